//! Attributes of patches, which continue those around them.

use crate::fill::harmonic::Harmonic;
use crate::fill::result::FilledHole;
use crate::mesh::{Attributes, DVec3, FaceTag, Mesh, Topology};

/// The attributes of a mesh with patches over `holes`, whose filled form has these faces and positions.
///
/// Numbers of vertices continue harmonically from the rims, labels are those of the nearest rim
/// vertex. Faces have the data of the face across the first edge of their first rim, and the tags of
/// `holes` among `tags`.
pub(super) fn filled_attributes(
    mesh: &Mesh,
    holes: &[FilledHole],
    tags: &[FaceTag],
    topology: &Topology,
    positions: &[DVec3],
) -> Attributes {
    let mut attributes = mesh.attributes.clone();
    attributes.tags = tags.to_vec();
    if !tags.is_empty() {
        // tags of patches in a mesh without tags
        attributes.faces.tags.resize(mesh.face_count(), 0);
        let aside = mesh.non_orientable.len();
        attributes.non_orientable.tags.resize(aside, 0);
    }
    for hole in holes {
        let faces = hole.faces.clone();
        let of_hole = topology.triangles().skip(faces.start).take(faces.len());
        let triangles: Vec<[u32; 3]> = of_hole.collect();
        if attributes.has_vertex_columns() && !hole.vertices.is_empty() {
            let of_patch = triangles.iter().copied();
            let mut equation = Harmonic::new(of_patch, hole.vertices.clone(), positions);
            let (rim, nearest) = (equation.rim.clone(), equation.nearest.clone());
            let given = hole.vertices.start;
            attributes.append_interpolated(given, &rim, &nearest, |at_rim| equation.solve(at_rim));
        }
        let tag = (!tags.is_empty()).then_some(hole.tag);
        attributes.append_triangles(faces.start, hole.like.index(), tag, &triangles);
    }
    attributes
}
