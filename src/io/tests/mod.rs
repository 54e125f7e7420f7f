//! Tests of the readers and writers together.

mod exports;
mod files;
mod gltf;
mod malformed;
mod oracles;
mod own_materials;
mod round_trip;
mod syntax;
mod threemf;

use std::path::Path;

use super::{Format, read};
use crate::mesh::{Attributes, Column, NO_VALUE, Soup, color_columns, row_count};

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
    let all = &soup.attributes;
    let has = |columns: &[Column], rows: usize| columns.iter().all(|c| c.numbers.len() == rows);
    assert!(has(&all.vertices, soup.positions.len()));
    assert!(has(&all.faces.columns, soup.face_count()));
    for columns in [&all.texture, &all.normals] {
        assert!(has(columns, row_count(columns)));
    }
    for (list, wanted, rows) in [
        (&all.faces.tags, soup.face_count(), all.tags.len()),
        (
            &all.faces.texture,
            soup.corners.len(),
            row_count(&all.texture),
        ),
        (
            &all.faces.normals,
            soup.corners.len(),
            row_count(&all.normals),
        ),
    ] {
        assert!(list.is_empty() || list.len() == wanted);
        assert!(
            list.iter()
                .all(|&row| row == NO_VALUE || (row as usize) < rows)
        );
    }
}

/// Attributes with these colours.
fn colored(colors: &[[f32; 4]]) -> Attributes {
    Attributes {
        vertices: color_columns(colors),
        ..Attributes::default()
    }
}
