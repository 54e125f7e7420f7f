//! The start of the first level.

use crate::energy::{Energy, Preset};
use crate::mesh::DVec3;
use crate::refine::descent::FullGradientDescent;
use crate::solver::{FlowProblem, SolverError, Stepper};
use crate::subdivision::{Rule, limit_positions};
use crate::surface::sample_surface;

/// A problem whose limit surface is constrained to interpolate `held`, started from a surface near
/// these points. The constraints are moved to their targets without folds as far as possible.
/// Meanwhile the surface relaxes under `H²`, whatever the energy of the flow.
///
/// Also returns the number of points that could not be reached without a fold.
///
/// # Errors
/// As [`FlowProblem::with_constraints`] and [`FullGradientDescent::new`].
pub fn constrained_start(
    free: FlowProblem,
    held: &[(u32, DVec3)],
) -> Result<(FlowProblem, usize), SolverError> {
    let surface = limit_positions(free.topology(), free.positions());
    let passed: Vec<(u32, DVec3)> = held
        .iter()
        .map(|&(v, _)| (v, surface[v as usize] + free.centre()))
        .collect();
    let near = free.clone().with_constraints(&passed)?;
    let there = free.with_constraints(held)?;
    let Some(goals) = there.interpolation().map(|i| i.targets().to_vec()) else {
        return Ok((there, 0));
    };
    let (rule, energy) = (Rule::Twelve, Energy::preset(Preset::H2));
    let elements = near.discretization().elements(rule);
    let tau = sample_surface(elements, near.positions(), &energy, near.radius()).tau_ref;
    let mut descent = FullGradientDescent::new(&near, &energy, rule)?;
    let unreached = descent.move_constraints_to(&goals, tau);
    Ok((there.with_positions(&descent.state().positions), unreached))
}
