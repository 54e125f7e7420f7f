//! Flows of some holes of a group by a surface model, the others fixed.

use super::replacement::Surface;
use crate::fill::context::FillContext;
use crate::fill::counterpart::Following;
use crate::fill::options::FillOptions;
use crate::fill::region;
use crate::fill::surface_choice::{Candidate, Counterpart};
use crate::fill::warm_start::warm_start_of;
use crate::solver::{End, Flow, FlowProblem, Mode, SurfaceModel, Tau};

/// Surface models for patches that are unsound by another one, in the order in which they are
/// tried: each next one is nearer to a membrane.
pub(super) const SAFER: [Candidate; 5] = [
    Candidate::new(SurfaceModel::Diffusion, 0.0),
    Candidate::new(SurfaceModel::Diffusion, 3.0),
    Candidate::new(SurfaceModel::Diffusion, 30.0),
    Candidate::new(SurfaceModel::Diffusion, 300.0),
    Candidate::new(SurfaceModel::Diffusion, 1e5),
];

/// Steps of a flow that is tried. Flows to sound surfaces rarely take more.
const MAX_STEPS: usize = 60;

/// The flow of a surface model from a problem to its end. `None` if that fails.
pub(super) fn flow_by(
    problem: FlowProblem,
    model: Candidate,
    options: &FillOptions,
) -> Option<Flow> {
    let mut flow = options.flow.clone();
    model.apply(&mut flow);
    flow.mode = Mode::Fast;
    flow.tau = Tau::Auto;
    let mut flow = Flow::new(problem, flow).ok()?;
    flow.run(|_, record| record.step < MAX_STEPS).ok()?;
    Some(flow)
}

/// A group with the holes of these numbers filled by the chosen model from their warm start, the
/// others fixed. Holes with counterparts follow these. `None` if that fails.
pub(super) fn solved(
    context: FillContext<'_>,
    group: usize,
    numbers: &[usize],
    (topology, positions): &Surface,
    counterparts: &[Option<Counterpart>],
    options: &FillOptions,
) -> Option<Surface> {
    let problem = region::problem(context, group, topology, positions, options).ok()?;
    let parts: Vec<&[u32]> = topology
        .split(problem.interior())
        .map(|part| part.1)
        .collect();
    let own: Vec<u32> = numbers.iter().flat_map(|&k| parts[k]).copied().collect();
    let start = warm_start_of(problem.clone(), &own).ok()?;
    let chosen = Candidate::of(&options.flow);
    let mut flow = flow_by(start.moving_only(&own).ok()?, chosen, options)?;
    let mut following = Following::default();
    while flow.end() == Some(End::Converged)
        && following.update(context, &mut flow, topology, counterparts)
    {
        flow.run(|_, _| true).ok()?;
    }
    Some((topology.clone(), problem.to_world(flow.positions())))
}
