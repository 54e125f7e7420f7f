//! The plan of a fairing: vertices of the mesh flow, and its triangles do not change.

use std::sync::{Arc, OnceLock};

use crate::fill::group::Group;
use crate::fill::plan::{Domain, Plan};
use crate::fill::result::RefillError;
use crate::fill::self_intersection::Obstacles;
use crate::mesh::{DVec3, FaceId, Mesh, Neighbourhood, VertexId, inner_vertices, rms_distance};
use crate::solver::SUPPORT_RINGS;

/// The plan of a fairing: the inner vertices of the selected faces, with the faces near them as the
/// support region.
pub(super) fn plan_fairing(mesh: &Mesh, selected: &[bool]) -> Result<Plan, RefillError> {
    let faces = selected.iter().filter(|&&flag| flag).count();
    if faces == 0 {
        return Err(RefillError::Nothing);
    }
    let moved = inner_vertices(&mesh.topology, selected);
    if moved.is_empty() {
        return Err(RefillError::NoInside { faces });
    }
    let (support, ring_1) = around(mesh, &moved);
    if ring_1.is_empty() {
        return Err(RefillError::Everything);
    }
    let centre = ring_1.iter().map(|&v| mesh.position(v)).sum::<DVec3>() / ring_1.len() as f64;
    let radius = rms_distance(ring_1.iter().map(|&v| mesh.position(v)), centre);
    Ok(Plan {
        domain: Domain::Vertices(moved),
        failed: Vec::new(),
        loose: Vec::new(),
        obstacles: Obstacles::new(0),
        symmetries: OnceLock::new(),
        normals: OnceLock::new(),
        groups: vec![Group {
            holes: Vec::new(),
            topology: Arc::default(),
            radius,
            support: vec![support],
        }],
    })
}

/// The faces within [`SUPPORT_RINGS`] rings of some vertices, sorted, and the vertices of the first
/// ring.
fn around(mesh: &Mesh, moved: &[VertexId]) -> (Vec<FaceId>, Vec<VertexId>) {
    let rings = usize::from(SUPPORT_RINGS);
    let around = Neighbourhood::new(&mesh.topology, moved.iter().copied(), rings);
    let ring_1 = around.rings().nth(1).unwrap_or_default().to_vec();
    (around.faces, ring_1)
}
