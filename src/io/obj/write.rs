//! The OBJ writer: vertices with the shortest decimals that parse exactly, faces in runs of one
//! tag.

use std::io::{self, Write};

use super::super::OutputMesh;
use super::super::number::{push_f32, push_f64, push_index, push_number};
use crate::mesh::{Colors, Column, FaceTag, NO_VALUE, Numbers, row_count};

/// Buffer size in bytes.
const CHUNK: usize = 1 << 16;

/// Writes OBJ text. The mesh has been checked.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut text = Vec::with_capacity(CHUNK + 1024);
    let all = mesh.attributes;
    for library in &all.material_libraries {
        push_line(&mut text, "mtllib ", library);
    }
    let extras = extras(&all.vertices);
    for (vertex, p) in mesh.positions.iter().enumerate() {
        text.extend_from_slice(b"v");
        for x in p.to_array() {
            text.push(b' ');
            push_f64(&mut text, x);
        }
        for extra in &extras {
            text.push(b' ');
            extra.push(&mut text, vertex);
        }
        text.push(b'\n');
        flush(&mut text, out, CHUNK)?;
    }
    for (keyword, columns) in [("vt", &all.texture), ("vn", &all.normals)] {
        for row in 0..row_count(columns) {
            text.extend_from_slice(keyword.as_bytes());
            for column in columns.iter() {
                text.push(b' ');
                push_number(&mut text, &column.numbers, row);
            }
            text.push(b'\n');
            flush(&mut text, out, CHUNK)?;
        }
    }
    let mut in_force = FaceTag::default();
    let mut last = None;
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let tag = all.faces.tags.get(face).copied();
        if tag != last
            && let Some(index) = tag
        {
            let tag = &all.tags[index as usize];
            push_tag(&mut text, &in_force, tag);
            in_force.clone_from(tag);
            last = Some(index);
        }
        text.push(b'f');
        let [texture, normals] = [&all.faces.texture, &all.faces.normals].map(|list| {
            let values = list.get(3 * face..3 * face + 3);
            values.filter(|values| !values.contains(&NO_VALUE))
        });
        for (k, &corner) in triangle.iter().enumerate() {
            text.push(b' ');
            push_index(&mut text, u64::from(corner) + 1);
            if texture.is_some() || normals.is_some() {
                text.push(b'/');
            }
            if let Some(values) = texture {
                push_index(&mut text, u64::from(values[k]) + 1);
            }
            if let Some(values) = normals {
                text.push(b'/');
                push_index(&mut text, u64::from(values[k]) + 1);
            }
        }
        text.push(b'\n');
        flush(&mut text, out, CHUNK)?;
    }
    flush(&mut text, out, 0)
}

/// A number that follows the coordinates of each vertex.
struct Extra<'a> {
    numbers: &'a Numbers,
    /// The number of full intensity of a colour that is not in 0..=1.
    scale: Option<f32>,
}

impl<'a> Extra<'a> {
    fn plain(column: &'a Column) -> Self {
        Self {
            numbers: &column.numbers,
            scale: None,
        }
    }

    fn push(&self, text: &mut Vec<u8>, vertex: usize) {
        match self.scale {
            Some(full) => push_f32(text, self.numbers.get(vertex) as f32 / full),
            None => push_number(text, self.numbers, vertex),
        }
    }
}

/// The weight and the colour among the columns of vertices. Those of an OBJ file are written as they
/// were there, others as red, green and blue in 0..=1.
fn extras(columns: &[Column]) -> Vec<Extra<'_>> {
    let colors = Colors::of(columns);
    // before a colour, a weight other than 1 would be read as a part of the colour
    let is_one = |c: &Column| (0..c.numbers.len()).all(|row| c.numbers.get(row) == 1.0);
    let fits = |c: &Column| colors.is_none_or(|colors| colors.alpha.is_none() && is_one(c));
    let is_weight = |c: &&Column| c.name == "w" && !c.is_typed && fits(c);
    let weight = columns.iter().find(is_weight);
    let mut extras: Vec<Extra<'_>> = weight.map(Extra::plain).into_iter().collect();
    let Some(colors) = colors else {
        return extras;
    };
    let [red, ..] = colors.channels;
    if columns[red].is_typed {
        let scaled = |k: usize| Extra {
            numbers: &columns[k].numbers,
            scale: (colors.full != 1.0).then_some(colors.full as f32),
        };
        // a weight cannot stand before such a colour
        return colors.channels.map(scaled).into();
    }
    let named = colors.channels.into_iter().chain(colors.alpha);
    extras.extend(named.map(|k| Extra::plain(&columns[k])));
    extras
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
/// OBJ cannot end an object, group, material or smoothing group. An empty name after another one is therefore
/// written as the conventional name for "none".
fn push_tag(text: &mut Vec<u8>, from: &FaceTag, to: &FaceTag) {
    let changes = [
        ("o ", &from.object, &to.object, "default"),
        ("g ", &from.group, &to.group, "default"),
        ("usemtl ", &from.material, &to.material, "None"),
        ("s ", &from.smoothing, &to.smoothing, "off"),
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
