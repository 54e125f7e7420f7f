//! STL, ASCII and binary, in; binary out.
//!
//! STL has no vertex list: each face brings its own three points. They are given as they are,
//! `exploded`, for welding is the business of `mesh::build`. Coordinates of ASCII files are read as
//! `f64`, those of binary files are `f32` by definition.

use std::io::{self, Write};

use super::OutputMesh;
use super::error::{Fault, Problem, at_byte, at_line, excerpt, in_file};
use super::scan::Scanner;
use crate::mesh::{DVec3, FaceTag, Soup};

const HEADER: usize = 84;
const FACE: usize = 50;

/// Reads STL, telling ASCII from binary by the size the file must have, not by its first word:
/// binary files may start with "solid" too.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    if bytes.is_empty() {
        return Err(in_file(Problem::Empty));
    }
    let declared = bytes
        .get(80..HEADER)
        .and_then(|b| b.try_into().ok())
        .map(u32::from_le_bytes);
    let fits = declared.is_some_and(|n| bytes.len() as u64 == binary_size(n));
    if !fits && looks_ascii(bytes) {
        return read_ascii(bytes);
    }
    let Some(declared) = declared else {
        let format = "STL";
        let found = format!(
            "{} bytes that are not ASCII STL, too few for binary STL",
            bytes.len()
        );
        return Err(in_file(Problem::NotThisFormat { format, found }));
    };
    if binary_size(declared) > bytes.len() as u64 {
        let what = format!(
            "a binary STL of {declared} faces has {} bytes, this file has {}",
            binary_size(declared),
            bytes.len()
        );
        return Err(at_byte(bytes.len(), Problem::Truncated { what }));
    }
    read_binary(bytes, declared as usize)
}

fn binary_size(faces: u32) -> u64 {
    HEADER as u64 + FACE as u64 * u64::from(faces)
}

/// Whether the file starts like ASCII STL and goes on as text.
fn looks_ascii(bytes: &[u8]) -> bool {
    let start = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let head = &start[..start.len().min(1024)];
    let is_solid = start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid");
    is_solid && !head.contains(&0)
}

fn read_binary(bytes: &[u8], faces: usize) -> Result<Soup, Fault> {
    if faces == 0 {
        return Err(in_file(Problem::NoVertices));
    }
    let mut soup = exploded(faces)?;
    for face in 0..faces {
        let start = HEADER + FACE * face + 12;
        for corner in 0..3 {
            let at = start + 12 * corner;
            let mut point = [0.0; 3];
            for (axis, x) in point.iter_mut().enumerate() {
                let raw = &bytes[at + 4 * axis..at + 4 * axis + 4];
                *x = f64::from(f32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]]));
                if !x.is_finite() {
                    let vertex = soup.positions.len() + 1;
                    let axis = ['x', 'y', 'z'][axis];
                    let problem = Problem::NotFinite {
                        vertex,
                        axis,
                        found: x.to_string(),
                    };
                    return Err(at_byte(at, problem));
                }
            }
            soup.positions.push(DVec3::from_array(point));
        }
        close_face(&mut soup);
    }
    let rest = bytes.len() - HEADER - FACE * faces;
    if rest > 0 {
        soup.notes.push(format!(
            "{rest} bytes after the {faces} faces the file declares: ignored"
        ));
    }
    Ok(soup)
}

fn exploded(faces: usize) -> Result<Soup, Fault> {
    if faces > u32::MAX as usize / 3 {
        let limit = u64::from(u32::MAX) / 3;
        return Err(in_file(Problem::TooLarge {
            what: "STL faces",
            limit,
        }));
    }
    let mut soup = Soup {
        positions: Vec::with_capacity(3 * faces),
        corners: Vec::with_capacity(3 * faces),
        offsets: Vec::with_capacity(faces + 1),
        exploded: true,
        ..Soup::default()
    };
    soup.offsets.push(0);
    Ok(soup)
}

fn close_face(soup: &mut Soup) {
    let first = soup.corners.len() as u32;
    soup.corners.extend([first, first + 1, first + 2]);
    soup.offsets.push(first + 3);
}

fn read_ascii(bytes: &[u8]) -> Result<Soup, Fault> {
    let start = if bytes.starts_with(b"\xef\xbb\xbf") {
        3
    } else {
        0
    };
    // A face takes over 100 bytes in practice, 60 at the very least.
    exploded(bytes.len() / 60)?;
    let mut soup = exploded((bytes.len() / 200).min(u32::MAX as usize / 3))?;
    let mut text = Scanner::new(bytes, start, 1);
    let mut in_solid = false;
    while !text.at_end() {
        text.skip_blanks();
        if !text.line_over() {
            let line = text.line();
            let word = text.token().to_ascii_lowercase();
            match word.as_slice() {
                b"solid" => {
                    in_solid = true;
                    start_solid(&mut soup, &mut text);
                }
                b"vertex" => ascii_vertex(&mut soup, &mut text)?,
                b"facet" | b"endfacet" | b"endloop" => whole_triangles(&soup, &word, line)?,
                b"endsolid" => {
                    whole_triangles(&soup, &word, line)?;
                    in_solid = false;
                }
                b"outer" | b"color" => {}
                _ => {
                    let what = "this is no ASCII STL statement".to_owned();
                    return Err(at_line(
                        line,
                        Problem::Syntax {
                            what,
                            found: excerpt(&word),
                        },
                    ));
                }
            }
            if word == b"endfacet" && soup.positions.len() > soup.corners.len() {
                close_face(&mut soup);
                if !soup.tags.is_empty() {
                    soup.face_tags.push(soup.tags.len() as u32 - 1);
                }
            }
        }
        text.next_line();
    }
    if soup.positions.len() > soup.corners.len() {
        let what = format!(
            "the last face ends after {} corners",
            soup.positions.len() - soup.corners.len()
        );
        return Err(at_line(text.line(), Problem::Truncated { what }));
    }
    if soup.positions.is_empty() {
        return Err(in_file(Problem::NoVertices));
    }
    if in_solid {
        soup.notes
            .push("the file has no 'endsolid': it may be cut off".into());
    }
    Ok(soup)
}

/// A named solid becomes an object.
fn start_solid(soup: &mut Soup, text: &mut Scanner) {
    text.skip_blanks();
    let object = String::from_utf8_lossy(text.rest_of_line()).into_owned();
    if soup.tags.last().is_some_and(|tag| tag.object == object) {
        return;
    }
    if soup.tags.is_empty() {
        if object.is_empty() {
            return;
        }
        if soup.face_count() > 0 {
            soup.tags.push(FaceTag::default());
            soup.face_tags.resize(soup.face_count(), 0);
        }
    }
    soup.tags.push(FaceTag {
        object,
        ..FaceTag::default()
    });
}

fn whole_triangles(soup: &Soup, word: &[u8], line: usize) -> Result<(), Fault> {
    let corners = soup.positions.len() - soup.corners.len();
    let open = word == b"facet" || word == b"endsolid";
    if (open && corners == 0) || (!open && corners == 3) {
        return Ok(());
    }
    let what = format!(
        "face {} has {corners} corners where {} belong before",
        soup.face_count() + 1,
        if open { 0 } else { 3 }
    );
    Err(at_line(
        line,
        Problem::Syntax {
            what,
            found: excerpt(word),
        },
    ))
}

fn ascii_vertex(soup: &mut Soup, text: &mut Scanner) -> Result<(), Fault> {
    let vertex = soup.positions.len() + 1;
    if soup.positions.len() - soup.corners.len() == 3 {
        let what = format!("face {} has a fourth corner", soup.face_count() + 1);
        return Err(at_line(
            text.line(),
            Problem::Syntax {
                what,
                found: "vertex".to_owned(),
            },
        ));
    }
    let mut point = [0.0; 3];
    for (x, axis) in point.iter_mut().zip(['x', 'y', 'z']) {
        text.skip_blanks();
        if text.line_over() {
            let found = usize::from(axis >= 'y') + usize::from(axis == 'z');
            let problem = Problem::VertexNumbers {
                vertex,
                found,
                wanted: "3 (x y z)",
            };
            return Err(at_line(text.line(), problem));
        }
        let found = text.peek_token();
        let Some(value) = text.float() else {
            let what = format!("{axis} of vertex {vertex}");
            return Err(at_line(
                text.line(),
                Problem::NotANumber {
                    what,
                    found: excerpt(found),
                },
            ));
        };
        if !value.is_finite() {
            let found = excerpt(found);
            return Err(at_line(
                text.line(),
                Problem::NotFinite {
                    vertex,
                    axis,
                    found,
                },
            ));
        }
        *x = value;
    }
    text.skip_blanks();
    if !text.line_over() {
        let problem = Problem::VertexNumbers {
            vertex,
            found: 4,
            wanted: "3 (x y z)",
        };
        return Err(at_line(text.line(), problem));
    }
    soup.positions.push(DVec3::from_array(point));
    Ok(())
}

/// Writes binary STL. The mesh has been checked; coordinates are rounded to `f32`.
pub(super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    // The header must not start with "solid".
    let mut header = [b' '; 80];
    let title = b"binary STL written by meniscus";
    header[..title.len()].copy_from_slice(title);
    out.write_all(&header)?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for triangle in mesh.triangles {
        let corners = triangle.map(|v| mesh.positions[v as usize]);
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or_zero();
        let mut record = [0_u8; FACE];
        for (k, point) in [normal, corners[0], corners[1], corners[2]]
            .iter()
            .enumerate()
        {
            for (axis, x) in point.to_array().iter().enumerate() {
                let at = 12 * k + 4 * axis;
                record[at..at + 4].copy_from_slice(&(*x as f32).to_le_bytes());
            }
        }
        out.write_all(&record)?;
    }
    Ok(())
}
