//! The result of a refinement.

use crate::mesh::{Attributes, DVec3, Mesh, Topology};
use crate::refine::{CreaseWeld, LevelReport};

/// The result of a refinement.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Refined {
    /// The refined mesh, on the limit surface; the input vertices come first.
    pub mesh: Mesh,
    /// The control mesh of the limit surface. It is open along creases, where each side has its own
    /// control points. The faces are in the order of `mesh`. The input vertices come first, then
    /// the copies that the cut made. Butterfly has no limit surface; there the points are those of
    /// the mesh.
    pub control: Mesh,
    /// One report per level.
    pub levels: Vec<LevelReport>,
}

/// Builds the refined mesh of the mesh `given`, and welds it if it was cut. `attributes` are those of
/// the mesh that is cut open.
pub fn refined_mesh(
    given: &Mesh,
    topology: &Topology,
    weld: Option<&CreaseWeld>,
    points: &[DVec3],
    attributes: &Attributes,
) -> Mesh {
    let mut mesh = match weld {
        Some(weld) => Mesh::new(weld.welded(points), weld.topology.clone()),
        None => Mesh::new(points.to_vec(), topology.clone()),
    };
    mesh.attributes = match weld {
        Some(weld) => weld.welded_attributes(attributes),
        None => attributes.clone(),
    };
    mesh.attributes.number_rows(mesh.topology.triangles());
    mesh.non_orientable.clone_from(&given.non_orientable);
    mesh
}
