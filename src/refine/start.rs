//! The first position of new vertices.

use crate::energy::{Energy, Preset};
use crate::mesh::DVec3;
use crate::solver::{FlowProblem, GuardedFlow, SolverError};
use crate::subdivision::{Rule, elements, limit_positions};
use crate::surface::sample_surface;

/// The flow of a surface held at points, from a surface near to them: it is led to them without
/// folding on the way, as far as that can be, while it relaxes under `H²` whatever the energy of the flow.
///
/// Returns beside it how many points could not be reached without a fold.
///
/// # Errors
/// As [`FlowProblem::holding`] and [`GuardedFlow::new`].
pub fn drawn_start(
    free: FlowProblem,
    held: &[(u32, DVec3)],
) -> Result<(FlowProblem, usize), SolverError> {
    let surface = limit_positions(free.topology(), free.positions());
    let at_rest: Vec<(u32, DVec3)> = held
        .iter()
        .map(|&(v, _)| (v, surface[v as usize] + free.centre()))
        .collect();
    let near = free.clone().holding(&at_rest)?;
    let there = free.holding(held)?;
    let Some(goals) = there.interpolation().map(|i| i.targets().to_vec()) else {
        return Ok((there, 0));
    };
    let (rule, energy) = (Rule::Twelve, Energy::preset(Preset::H2));
    let elements = elements(near.topology(), near.active_faces(), rule);
    let tau = sample_surface(&elements, near.positions(), &energy, near.radius()).tau_ref;
    let mut flow = GuardedFlow::new(&near, &elements, rule, &energy)?;
    let late = flow.approach(&goals, tau);
    Ok((there.with_positions(flow.positions()), late))
}
