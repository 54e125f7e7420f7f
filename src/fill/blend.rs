//! Patches over several rims take the shape of their warm start before they are refined to the end.

use std::time::Instant;

use crate::fill::{FillOptions, FirstPatch, Gap, Plan, gap_of, milliseconds, warm_start};
use crate::mesh::Mesh;
use crate::patch::{self, PatchMesh};

/// Remeshes the blends of a plan on the shape of their warm start: a film stretched between distant
/// rims is far smaller than the surface that leaves them smoothly, and its triangles would end up
/// long. A group whose warm start fails keeps its patches; the flow will say why.
pub(super) fn reshape(
    mesh: &Mesh,
    gaps: &[Gap<'_>],
    mut patches: Vec<FirstPatch>,
    plan: &mut Plan,
    options: &FillOptions,
) -> Plan {
    for g in 0..plan.groups.len() {
        let is_blend = |&h: &usize| plan.holes[h].loops.len() > 1;
        if !plan.groups[g].holes.iter().any(is_blend) {
            continue;
        }
        let start = plan.groups[g].problem(mesh, plan, options);
        let start = start.and_then(warm_start);
        if let Ok(problem) = start {
            plan.place(g, &problem.to_world(problem.positions()));
        }
    }
    let mut holes = plan.holes.iter();
    for (gap, (patch, ms)) in gaps.iter().zip(&mut patches) {
        let Ok(patch) = patch else { continue };
        let Some(hole) = holes.next() else { break };
        if gap.len() > 1 {
            let start = Instant::now();
            let rim = hole.edges;
            let mut points = patch.points[..rim].to_vec();
            points.extend_from_slice(&plan.new_positions[hole.new_vertices.clone()]);
            let shaped = PatchMesh {
                points,
                triangles: std::mem::take(&mut patch.triangles),
            };
            *patch = patch::reblend(&gap_of(mesh, gap), &shaped, &options.patch);
            *ms += milliseconds(start);
        }
    }
    Plan::new(mesh, gaps, &patches)
}
