//! The PLY writer: binary little endian, coordinates as doubles.

use std::io::{self, Write};

use super::super::OutputMesh;
use crate::mesh::{FaceTag, color_steps};

/// Writes binary PLY. The mesh has been checked.
///
/// Colours that are exact in 8 or in 16 bits are written as such integers, which most programs expect,
/// and others as `float`. If there are groups of patches, each face has the number of its patch, 0
/// without one.
pub(in super::super) fn write(mesh: &OutputMesh<'_>, out: &mut dyn Write) -> io::Result<()> {
    let steps = color_steps(mesh.colors);
    let channels = if mesh.colors.iter().all(|c| c[3] == 1.0) {
        3
    } else {
        4
    };
    let index = if i32::try_from(mesh.positions.len()).is_ok() {
        "int"
    } else {
        "uint"
    };
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment written by meniscus")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property double {axis}")?;
    }
    if !mesh.colors.is_empty() {
        let kind = match steps {
            Some(255) => "uchar",
            Some(_) => "ushort",
            None => "float",
        };
        for channel in &["red", "green", "blue", "alpha"][..channels] {
            writeln!(out, "property {kind} {channel}")?;
        }
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar {index} vertex_indices")?;
    let patches: Vec<Option<u32>> = mesh.tags.iter().map(FaceTag::patch).collect();
    let has_patches = mesh
        .face_tags
        .iter()
        .any(|&tag| patches[tag as usize].is_some());
    if has_patches {
        writeln!(out, "property int patch")?;
    }
    writeln!(out, "end_header")?;
    for (vertex, p) in mesh.positions.iter().enumerate() {
        for x in p.to_array() {
            out.write_all(&x.to_le_bytes())?;
        }
        if let Some(color) = mesh.colors.get(vertex) {
            for &c in &color[..channels] {
                #[allow(clippy::cast_sign_loss)] // from 0 to `steps`
                let whole = |steps: u16| (c * f32::from(steps)).round() as u16;
                match steps {
                    Some(255) => out.write_all(&[whole(255) as u8])?,
                    Some(steps) => out.write_all(&whole(steps).to_le_bytes())?,
                    None => out.write_all(&c.to_le_bytes())?,
                }
            }
        }
    }
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let mut row = [3_u8; 13];
        for (k, corner) in triangle.iter().enumerate() {
            row[1 + 4 * k..5 + 4 * k].copy_from_slice(&corner.to_le_bytes());
        }
        out.write_all(&row)?;
        if has_patches {
            let patch = patches[mesh.face_tags[face] as usize].unwrap_or(0);
            out.write_all(&patch.to_le_bytes())?;
        }
    }
    Ok(())
}
