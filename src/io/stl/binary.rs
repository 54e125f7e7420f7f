//! Binary STL: 80 bytes of header, the number of faces, then 50 bytes per face: normal, three
//! points, two attribute bytes.

use std::io::{self, Write};

use super::super::OutputMesh;
use super::super::check::is_stl_attribute;
use super::super::error::{ParseError, ParseErrorKind, at_byte, in_file};
use super::{close_face, with_room};
use crate::mesh::{Column, DVec3, Numbers, Soup};

const HEADER: usize = 84;
const FACE: usize = 50;
const NORMAL: usize = 12;
const POINT: usize = 12;

/// The declared number of faces, if the file is long enough to contain it.
pub(super) fn declared_faces(bytes: &[u8]) -> Option<u32> {
    bytes
        .get(80..HEADER)?
        .first_chunk()
        .map(|raw| u32::from_le_bytes(*raw))
}

/// Size in bytes of a file with this many faces.
pub(super) fn size(faces: u32) -> u64 {
    HEADER as u64 + FACE as u64 * u64::from(faces)
}

/// Reads the declared faces, if the file contains them all.
pub(super) fn read(bytes: &[u8], declared: u32) -> Result<Soup, ParseError> {
    let needed = size(declared);
    if needed > bytes.len() as u64 {
        let found = bytes.len();
        let what =
            format!("a binary STL of {declared} faces has {needed} bytes, this file has {found}");
        return Err(at_byte(found, ParseErrorKind::truncated(what)));
    }
    if declared == 0 {
        return Err(in_file(ParseErrorKind::NoVertices));
    }
    let faces = declared as usize;
    let mut soup = with_room(faces);
    soup.attributes.stl_header = bytes.first_chunk().copied();
    let mut attributes = Vec::new();
    for (face, record) in bytes[HEADER..].chunks_exact(FACE).take(faces).enumerate() {
        let points = &record[NORMAL..NORMAL + 3 * POINT];
        for (corner, point) in points.chunks_exact(POINT).enumerate() {
            let mut position = [0.0; 3];
            for (axis, x) in position.iter_mut().enumerate() {
                let raw = [
                    point[4 * axis],
                    point[4 * axis + 1],
                    point[4 * axis + 2],
                    point[4 * axis + 3],
                ];
                *x = f64::from(f32::from_le_bytes(raw));
                if !x.is_finite() {
                    let at = HEADER + FACE * face + NORMAL + POINT * corner + 4 * axis;
                    let vertex = soup.positions.len() + 1;
                    let axis = ['x', 'y', 'z'][axis];
                    let found = x.to_string();
                    return Err(at_byte(
                        at,
                        ParseErrorKind::NotFinite {
                            vertex,
                            axis,
                            found,
                        },
                    ));
                }
            }
            soup.positions.push(DVec3::from_array(position));
        }
        close_face(&mut soup)?;
        let attribute = u16::from_le_bytes([record[FACE - 2], record[FACE - 1]]);
        if attribute != 0 {
            // files without attributes have no column
            attributes.resize(faces, 0);
            attributes[face] = attribute;
        }
    }
    if !attributes.is_empty() {
        soup.attributes.faces.columns.push(Column {
            name: "attribute".to_owned(),
            numbers: Numbers::U16(attributes),
            is_typed: true,
        });
    }
    let rest = bytes.len() as u64 - needed;
    if rest > 0 {
        soup.notes.push(format!(
            "{rest} bytes after the {declared} declared faces are ignored"
        ));
    }
    Ok(soup)
}

/// Writes binary STL. The mesh has been checked; coordinates are rounded to `f32`.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    // Some readers treat every file that starts with "solid" as ASCII.
    let title = b"binary STL written by meniscus";
    let mut header = [b' '; HEADER];
    header[..title.len()].copy_from_slice(title);
    if let Some(given) = &mesh.attributes.stl_header {
        header[..80].copy_from_slice(given);
    }
    let attributes = mesh
        .attributes
        .faces
        .columns
        .iter()
        .find(|c| is_stl_attribute(c));
    header[80..].copy_from_slice(&(mesh.triangles.len() as u32).to_le_bytes());
    out.write_all(&header)?;
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let mut record = [0_u8; FACE];
        for (slot, point) in record.chunks_exact_mut(POINT).zip([normal, a, b, c]) {
            for (raw, x) in slot.chunks_exact_mut(4).zip(point.to_array()) {
                raw.copy_from_slice(&(x as f32).to_le_bytes());
            }
        }
        if let Some(column) = attributes {
            let attribute = column.numbers.get(face) as u16;
            record[FACE - 2..].copy_from_slice(&attribute.to_le_bytes());
        }
        out.write_all(&record)?;
    }
    Ok(())
}
