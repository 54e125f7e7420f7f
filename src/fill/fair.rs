//! Part of a surface faired in place: its vertices flow, its triangles stay.

use std::sync::Arc;

use crate::fill::group::Group;
use crate::fill::plan::{Domain, Plan};
use crate::fill::refill::RefillError;
use crate::fill::result::Filled;
use crate::fill::run::{Observer, ScheduledOptions, run_plan};
use crate::mesh::{DVec3, FaceId, Mesh, VertexId, inner_vertices};
use crate::solver::SUPPORT_RINGS;

/// Lets the inner vertices of the selected faces flow, with G1 continuity to the rest. The
/// triangles stay as they are. As in a new patch the vertices start from the warm start, so that
/// their given positions do not matter. [`Filled::moved`] lists them.
///
/// # Errors
/// An empty selection, one without inner vertices, or one that leaves nothing to continue from. An
/// error of the flow is in the result.
pub fn fair(
    mesh: &Mesh,
    selected: &[bool],
    options: impl Into<ScheduledOptions>,
    observe: Observer<'_>,
) -> Result<Filled, RefillError> {
    let plan = plan_fairing(mesh, selected)?;
    Ok(run_plan(mesh, plan, &options.into(), observe)?)
}

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
    let square = |&v: &VertexId| mesh.position(v).distance_squared(centre);
    let radius = (ring_1.iter().map(square).sum::<f64>() / ring_1.len() as f64).sqrt();
    Ok(Plan {
        domain: Domain::Vertices(moved),
        failed: Vec::new(),
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
    let topology = &mesh.topology;
    let mut reached = vec![false; mesh.vertex_count()];
    for v in moved {
        reached[v.index()] = true;
    }
    let mut has_face = vec![false; mesh.face_count()];
    let (mut faces, mut ring_1) = (Vec::new(), Vec::new());
    let mut front = moved.to_vec();
    for ring in 0..SUPPORT_RINGS {
        let mut next = Vec::new();
        for &v in &front {
            for h in topology.outgoing(v) {
                let (f, w) = (topology.face(h), topology.target(h));
                if f.is_some() && !std::mem::replace(&mut has_face[f.index()], true) {
                    faces.push(f);
                }
                if !std::mem::replace(&mut reached[w.index()], true) {
                    next.push(w);
                }
            }
        }
        if ring == 0 {
            ring_1.clone_from(&next);
        }
        front = next;
    }
    faces.sort_unstable();
    (faces, ring_1)
}
