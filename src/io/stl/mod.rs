//! STL: ASCII and binary are read, binary is written.
//!
//! STL has no vertex list: each face has its own three points. They are returned unchanged and
//! marked `exploded`; `mesh::build` welds them. Coordinates of ASCII files are read as `f64`; those
//! of binary files are `f32` by definition.

mod ascii;
mod binary;

pub(super) use binary::write;

use super::error::{ParseError, ParseErrorKind, in_file};
use crate::mesh::Soup;

/// Reads STL. The size of a binary file, not the first word, distinguishes ASCII from binary,
/// because binary files may start with "solid" too.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    if bytes.is_empty() {
        return Err(in_file(ParseErrorKind::Empty));
    }
    let declared = binary::declared_faces(bytes);
    let fits = declared.is_some_and(|faces| bytes.len() as u64 == binary::size(faces));
    if !fits && ascii::looks_like(bytes) {
        return ascii::read(bytes);
    }
    let Some(declared) = declared else {
        let found = format!(
            "{} bytes, too few for a binary STL, and not an ASCII STL",
            bytes.len()
        );
        return Err(in_file(ParseErrorKind::NotThisFormat {
            format: "STL",
            found,
        }));
    };
    binary::read(bytes, declared)
}

/// An empty soup with capacity for this many faces.
fn with_room(faces: usize) -> Soup {
    let mut soup = Soup {
        positions: Vec::with_capacity(3 * faces),
        corners: Vec::with_capacity(3 * faces),
        offsets: Vec::with_capacity(faces + 1),
        exploded: true,
        ..Soup::default()
    };
    soup.offsets.push(0);
    soup
}

/// Adds a face of the last three positions.
fn close_face(soup: &mut Soup) -> Result<(), ParseError> {
    let Ok(end) = u32::try_from(soup.positions.len()) else {
        return Err(in_file(ParseErrorKind::too_large("face corners")));
    };
    soup.corners.extend([end - 3, end - 2, end - 1]);
    soup.offsets.push(end);
    Ok(())
}
