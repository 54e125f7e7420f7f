//! Tests of the readers and writers together.

mod files;
mod malformed;
mod oracles;
mod round_trip;
mod syntax;

use std::path::Path;

use super::{Format, read};
use crate::mesh::Soup;

/// Reads text or bytes that must be sound.
fn good(format: Format, bytes: impl AsRef<[u8]>) -> Soup {
    match read(format, bytes.as_ref(), Path::new("mesh")) {
        Ok(soup) => {
            assert_sound(&soup);
            soup
        }
        Err(error) => panic!("{error}"),
    }
}

/// Reads text or bytes that must be refused, and gives the message.
fn bad(format: Format, bytes: impl AsRef<[u8]>) -> String {
    match read(format, bytes.as_ref(), Path::new("mesh")) {
        Ok(soup) => panic!("accepted: {} faces, {:?}", soup.face_count(), soup.notes),
        Err(error) => error.to_string(),
    }
}

/// What every reader promises.
fn assert_sound(soup: &Soup) {
    assert!(soup.face_count() > 0);
    assert_eq!(soup.offsets[0], 0);
    assert_eq!(
        soup.offsets.last().map(|&end| end as usize),
        Some(soup.corners.len())
    );
    for f in 0..soup.face_count() {
        assert!(soup.face(f).len() >= 3);
    }
    assert!(
        soup.corners
            .iter()
            .all(|&v| (v as usize) < soup.positions.len())
    );
    assert!(soup.positions.iter().all(|p| p.is_finite()));
    assert!(soup.colors.is_empty() || soup.colors.len() == soup.positions.len());
    assert!(soup.face_tags.is_empty() || soup.face_tags.len() == soup.face_count());
    assert!(
        soup.face_tags
            .iter()
            .all(|&t| (t as usize) < soup.tags.len())
    );
}
