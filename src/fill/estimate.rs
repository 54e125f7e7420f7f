//! Estimate of the memory that flows take, before they start.

use crate::energy::Order;
use crate::fill::options::FillOptions;
use crate::fill::plan::Plan;
use crate::mesh::Mesh;
use crate::solver::{LinearSolver, Scheme, SurfaceModel};

/// Bytes for each vertex that flows: elements, matrices and factors. Measured as peak memory of fills of
/// 400 to 1600 rim edges (5.9 to 6.4 kB); that of factors grows with the logarithm of the number of
/// vertices, which is little beside the rest.
const NORMAL: f64 = 6300.0;
/// The same for energies with `|∇H|²` (18.7 and 20.3 kB for 4,600 and 60,000 vertices).
const SIXTH_ORDER: f64 = 20_000.0;
/// The same for the mixed schemes with GMRES (14.5 and 14.7 kB for 5,000 and 21,000 vertices).
const MIXED: f64 = 14_600.0;
/// The same for the mixed schemes with LU (440 and 500 kB for 1,200 and 2,500 vertices).
const MIXED_LU: f64 = 500_000.0;
/// Bytes for each face of a support region.
const SUPPORT: f64 = 1500.0;
/// Bytes for each face of the filled mesh.
const FACE: f64 = 300.0;

/// The memory in bytes that the flows of a plan take at the same time, and the filled mesh.
pub(super) fn memory_of(mesh: &Mesh, plan: &Plan, options: &FillOptions) -> f64 {
    let groups = plan.groups.iter();
    let patches = groups.clone().map(|group| group.topology.new_vertices());
    let moving = plan.moved().len() + patches.sum::<usize>();
    let support: usize = groups.flat_map(|group| &group.support).map(Vec::len).sum();
    let patch_faces = plan.holes().iter().map(|hole| hole.patch.triangles.len());
    let faces = mesh.face_count() + patch_faces.sum::<usize>();
    let flow = &options.flow;
    // the other surface models take as much as the normal scheme (4 to 6 kB)
    let bytes = match (flow.surface, flow.scheme, &flow.linear) {
        (SurfaceModel::Energy, Scheme::Mixed | Scheme::MixedCorrected, LinearSolver::Lu) => {
            MIXED_LU
        }
        (SurfaceModel::Energy, Scheme::Mixed | Scheme::MixedCorrected, _) => MIXED,
        (SurfaceModel::Energy, ..) if flow.order() == Order::Sixth => SIXTH_ORDER,
        _ => NORMAL,
    };
    bytes * moving as f64 + SUPPORT * support as f64 + FACE * faces as f64
}
