//! Checks of a mesh for a format, and losses of a format.

use super::{Format, MeshFault, OutputMesh};
use crate::mesh::{DVec3, FaceTag};

/// Checks that `mesh` can be written in `format`: finite coordinates, indices in range, attribute
/// arrays of the right length.
///
/// # Errors
/// The first [`MeshFault`].
pub fn check(format: Format, mesh: &OutputMesh<'_>) -> Result<(), MeshFault> {
    let vertices = mesh.positions.len();
    let triangles = mesh.triangles.len();
    for (what, count) in [("vertices", vertices), ("triangles", triangles)] {
        if u32::try_from(count).is_err() {
            return Err(MeshFault::TooMany { what, count });
        }
    }
    for (vertex, p) in mesh.positions.iter().enumerate() {
        for value in p.to_array() {
            if !value.is_finite() {
                return Err(MeshFault::NotFinite { vertex, value });
            }
            if format == Format::Stl && !(value as f32).is_finite() {
                return Err(MeshFault::BeyondSingle { vertex, value });
            }
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for &index in corners {
            if index as usize >= vertices {
                return Err(MeshFault::IndexRange {
                    triangle,
                    index,
                    vertices,
                });
            }
        }
    }
    let lengths = [
        ("vertex colours", mesh.colors.len(), vertices),
        ("face tags", mesh.face_tags.len(), triangles),
    ];
    for (what, found, wanted) in lengths {
        if found != 0 && found != wanted {
            return Err(MeshFault::Attribute {
                what,
                found,
                wanted,
            });
        }
    }
    let wanted = mesh.tags.len();
    if let Some(&tag) = mesh.face_tags.iter().find(|&&tag| tag as usize >= wanted) {
        return Err(MeshFault::Attribute {
            what: "face tag index",
            found: tag as usize,
            wanted,
        });
    }
    Ok(())
}

/// The attributes of `mesh` that a file in `format` cannot store, as messages for the user.
pub fn losses(format: Format, mesh: &OutputMesh<'_>) -> Vec<String> {
    let mut lost = Vec::new();
    let colored = !mesh.colors.is_empty();
    match format {
        Format::Obj if mesh.colors.iter().any(|c| c[3] != 1.0) => {
            lost.push("OBJ cannot store transparency".to_owned());
        }
        Format::Stl if colored => lost.push("STL cannot store colours".to_owned()),
        _ => {}
    }
    // PLY stores the groups of patches
    let is_stored = |tag: &FaceTag| {
        let group = tag.group.is_empty() || tag.patch().is_some();
        format == Format::Ply && group && tag.object.is_empty() && tag.material.is_empty()
    };
    let mut tags = mesh.face_tags.iter().map(|&tag| &mesh.tags[tag as usize]);
    if format != Format::Obj && !tags.all(is_stored) {
        lost.push("only OBJ can store groups and materials".to_owned());
    }
    if format == Format::Stl {
        let rounded = |p: &DVec3| p.as_vec3().as_dvec3() != *p;
        if mesh.positions.iter().any(rounded) {
            lost.push("STL coordinates are rounded to single precision".to_owned());
        }
        let single = |v: u32| mesh.positions[v as usize].as_vec3();
        let same = |a: u32, b: u32| {
            single(a) == single(b) && mesh.positions[a as usize] != mesh.positions[b as usize]
        };
        let collapsed = |t: &&[u32; 3]| same(t[0], t[1]) || same(t[1], t[2]) || same(t[2], t[0]);
        let count = mesh.triangles.iter().filter(collapsed).count();
        if count > 0 {
            lost.push(format!(
                "triangles that collapse in single precision: {count}; move the mesh to the \
                 origin, or write OBJ or PLY"
            ));
        }
    }
    lost
}
