//! The OFF writer.

use std::io::{self, Write};

use super::super::OutputMesh;
use super::super::number::{push_f64, push_index, push_number};
use super::{COLOR, NORMAL, TEXTURE};
use crate::mesh::{Colors, Column, columns_named};

/// Writes OFF text with the shortest decimals that parse exactly. The mesh has been checked.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    let vertices = &mesh.attributes.vertices;
    let normal = columns_named(vertices, NORMAL);
    let texture = columns_named(vertices, TEXTURE);
    let color = Colors::of(vertices);
    // the format has four numbers for a colour; three are kept where a file has three
    let opaque = color.filter(|c| c.alpha.is_none() && vertices[c.channels[0]].is_typed);
    let letters = [
        (texture.is_some(), "ST"),
        (color.is_some(), "C"),
        (normal.is_some(), "N"),
    ];
    let letters: String = letters.iter().filter(|l| l.0).map(|l| l.1).collect();
    writeln!(out, "{letters}OFF")?;
    writeln!(out, "{} {} 0", mesh.positions.len(), mesh.triangles.len())?;
    let mut columns: Vec<&Column> = Vec::new();
    columns.extend(normal.iter().flatten().map(|&k| &vertices[k]));
    if let Some(Colors {
        channels, alpha, ..
    }) = color
    {
        columns.extend(channels.into_iter().chain(alpha).map(|k| &vertices[k]));
    }
    let before_texture = columns.len();
    columns.extend(texture.iter().flatten().map(|&k| &vertices[k]));
    let mut text = Vec::new();
    for (vertex, p) in mesh.positions.iter().enumerate() {
        text.clear();
        for x in p.to_array() {
            push_f64(&mut text, x);
            text.push(b' ');
        }
        for (k, column) in columns.iter().enumerate() {
            if k == before_texture {
                push_opacity(&mut text, opaque);
            }
            push_number(&mut text, &column.numbers, vertex);
            text.push(b' ');
        }
        if columns.len() == before_texture {
            push_opacity(&mut text, opaque);
        }
        text.pop();
        text.push(b'\n');
        out.write_all(&text)?;
    }
    let of_faces = face_columns(&mesh.attributes.faces.columns);
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        text.clear();
        text.push(b'3');
        for &corner in triangle {
            text.push(b' ');
            push_index(&mut text, u64::from(corner));
        }
        for column in &of_faces {
            text.push(b' ');
            push_number(&mut text, &column.numbers, face);
        }
        text.push(b'\n');
        out.write_all(&text)?;
    }
    Ok(())
}

fn push_opacity(text: &mut Vec<u8>, of: Option<Colors>) {
    if let Some(Colors { full, .. }) = of {
        push_f64(text, full);
        text.push(b' ');
    }
}

/// The columns that the colour of a face is written from: red, green, blue and perhaps alpha, or an index.
pub(in super::super) fn face_columns(columns: &[Column]) -> Vec<&Column> {
    if let Some(rgb) = columns_named(columns, ["red", "green", "blue"]) {
        let alpha = columns.iter().find(|c| c.name == COLOR[3]);
        return rgb.iter().map(|&k| &columns[k]).chain(alpha).collect();
    }
    columns.iter().filter(|c| c.name == "color").collect()
}
