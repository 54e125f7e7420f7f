//! The PLY writer: binary little endian, coordinates as doubles.

use std::io::{self, Write};

use super::super::OutputMesh;
use crate::mesh::{
    Colors, Column, FaceTag, NO_VALUE, NumberType, Numbers, color_steps, colors, row_count,
};

/// The comment that names this program.
const MARK: &str = "comment written by meniscus";

/// Writes binary PLY. The mesh has been checked.
///
/// Columns are written in their declared type, and decimals as `double`, except colours: those that
/// are exact in 8 or in 16 bits are written as such integers, which most programs expect, and others as
/// `float`. If there are groups of patches, each face has the number of its patch, 0 without one.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    let all = mesh.attributes;
    let converted = decimal_colors(&all.vertices);
    let vertices = converted.as_deref().unwrap_or(&all.vertices);
    let index = if i32::try_from(mesh.positions.len()).is_ok() {
        "int"
    } else {
        "uint"
    };
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    if all.comments.iter().all(|line| line != MARK) {
        writeln!(out, "{MARK}")?;
    }
    for line in &all.comments {
        writeln!(out, "{line}")?;
    }
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property double {axis}")?;
    }
    declare(vertices, out)?;
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar {index} vertex_indices")?;
    let has_texture = all.faces.texture.iter().any(|&row| row != NO_VALUE);
    let texture = has_texture.then(|| coordinates(&all.texture));
    if let Some([u, _]) = &texture {
        writeln!(out, "property list uchar {} texcoord", u.kind().ply_name())?;
    }
    let patches: Vec<Option<u32>> = all.tags.iter().map(FaceTag::patch).collect();
    let tags = &all.faces.tags;
    let has_patches = tags.iter().any(|&tag| patches[tag as usize].is_some());
    if has_patches {
        writeln!(out, "property int patch")?;
    }
    declare(&all.faces.columns, out)?;
    writeln!(out, "end_header")?;
    let mut row = Vec::new();
    for (vertex, p) in mesh.positions.iter().enumerate() {
        row.clear();
        for x in p.to_array() {
            row.extend_from_slice(&x.to_le_bytes());
        }
        for column in vertices {
            column.numbers.push_bytes(vertex, &mut row);
        }
        out.write_all(&row)?;
    }
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        row.clear();
        row.push(3);
        for corner in triangle {
            row.extend_from_slice(&corner.to_le_bytes());
        }
        if let Some(numbers) = &texture {
            let values = &all.faces.texture[3 * face..3 * face + 3];
            row.push(6);
            if values.contains(&NO_VALUE) {
                // most programs expect as many numbers for each face
                row.resize(row.len() + 6 * numbers[0].kind().size(), 0);
            } else {
                for &value in values {
                    for list in numbers {
                        list.push_bytes(value as usize, &mut row);
                    }
                }
            }
        }
        if has_patches {
            let patch = patches[tags[face] as usize].unwrap_or(0);
            row.extend_from_slice(&patch.to_le_bytes());
        }
        for column in &all.faces.columns {
            column.numbers.push_bytes(face, &mut row);
        }
        out.write_all(&row)?;
    }
    Ok(())
}

fn declare(columns: &[Column], out: &mut dyn Write) -> io::Result<()> {
    for Column { name, numbers, .. } in columns {
        writeln!(out, "property {} {name}", numbers.kind().ply_name())?;
    }
    Ok(())
}

/// The columns with colours in a type that other programs expect, if the colours are decimals.
fn decimal_colors(columns: &[Column]) -> Option<Vec<Column>> {
    let found = Colors::of(columns).filter(|c| !columns[c.channels[0]].is_typed)?;
    let values = colors(columns);
    if values.is_empty() {
        return None;
    }
    let steps = color_steps(&values);
    let numbers = |k: usize| {
        let channel = values.iter().map(|color| color[k]);
        #[allow(clippy::cast_sign_loss)] // from 0 to `steps`
        let whole = |c: f32, steps: u16| (c * f32::from(steps)).round() as u16;
        match steps {
            Some(255) => Numbers::U8(channel.map(|c| whole(c, 255) as u8).collect()),
            Some(steps) => Numbers::U16(channel.map(|c| whole(c, steps)).collect()),
            None => Numbers::F32(channel.collect()),
        }
    };
    let mut converted = columns.to_vec();
    let named = found.channels.into_iter().chain(found.alpha);
    for (k, column) in named.enumerate() {
        converted[column].numbers = numbers(k);
    }
    Some(converted)
}

/// The numbers of the first two columns of texture coordinates; zeros if there is one only. Decimals become
/// `float`, the only type that some programs read.
fn coordinates(columns: &[Column]) -> [Numbers; 2] {
    let count = row_count(columns);
    [0, 1].map(|k| {
        if let Some(column) = columns.get(k) {
            return match &column.numbers {
                Numbers::F64(list) if !column.is_typed => {
                    Numbers::F32({
                        // in the range of the type
                        let (least, most) = (f64::from(f32::MIN), f64::from(f32::MAX));
                        list.iter().map(|x| x.clamp(least, most) as f32).collect()
                    })
                }
                numbers => numbers.clone(),
            };
        }
        let kind = columns[0].numbers.kind();
        let kind = if columns[0].is_typed {
            kind
        } else {
            NumberType::F32
        };
        let mut zeros = Numbers::with_capacity(kind, count);
        zeros.pad(count);
        zeros
    })
}
