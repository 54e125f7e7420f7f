//! The OBJ writer: vertices with the shortest decimals that parse exactly, faces in runs of one
//! tag.

use std::io::{self, Write};

use super::super::OutputMesh;
use super::super::number::{push_f32, push_f64, push_index};
use crate::mesh::FaceTag;

/// Buffer size in bytes.
const CHUNK: usize = 1 << 16;

/// Writes OBJ text. The mesh has been checked.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut text = Vec::with_capacity(CHUNK + 1024);
    for library in mesh.material_libraries {
        push_line(&mut text, "mtllib ", library);
    }
    for (vertex, p) in mesh.positions.iter().enumerate() {
        text.extend_from_slice(b"v");
        for x in p.to_array() {
            text.push(b' ');
            push_f64(&mut text, x);
        }
        if let Some(color) = mesh.colors.get(vertex) {
            for &c in &color[..3] {
                text.push(b' ');
                push_f32(&mut text, c);
            }
        }
        text.push(b'\n');
        flush(&mut text, out, CHUNK)?;
    }
    let mut in_force = FaceTag::default();
    let mut last = None;
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let tag = mesh.face_tags.get(face).copied();
        if tag != last
            && let Some(index) = tag
        {
            let tag = &mesh.tags[index as usize];
            push_tag(&mut text, &in_force, tag);
            in_force.clone_from(tag);
            last = Some(index);
        }
        text.push(b'f');
        for &corner in triangle {
            text.push(b' ');
            push_index(&mut text, u64::from(corner) + 1);
        }
        text.push(b'\n');
        flush(&mut text, out, CHUNK)?;
    }
    flush(&mut text, out, 0)
}

fn flush(text: &mut Vec<u8>, out: &mut dyn Write, limit: usize) -> io::Result<()> {
    if text.len() >= limit {
        out.write_all(text)?;
        text.clear();
    }
    Ok(())
}

/// Writes the difference between two tags.
///
/// OBJ cannot end an object, group or material. An empty name after another one is therefore
/// written as the conventional name for "none".
fn push_tag(text: &mut Vec<u8>, from: &FaceTag, to: &FaceTag) {
    let changes = [
        ("o ", &from.object, &to.object, "default"),
        ("g ", &from.group, &to.group, "default"),
        ("usemtl ", &from.material, &to.material, "None"),
    ];
    for (keyword, old, new, none) in changes {
        if old != new {
            push_line(text, keyword, if new.is_empty() { none } else { new });
        }
    }
}

/// A name without line ends, which would start a new statement. Names from other formats may
/// contain them.
fn push_line(text: &mut Vec<u8>, keyword: &str, name: &str) {
    text.extend_from_slice(keyword.as_bytes());
    text.extend(
        name.bytes()
            .map(|b| if b == b'\n' || b == b'\r' { b' ' } else { b }),
    );
    if name.ends_with('\\') {
        // a backslash at the end would join the next line
        text.push(b' ');
    }
    text.push(b'\n');
}
