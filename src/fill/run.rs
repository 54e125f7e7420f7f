//! One group of holes on its way: a flow with its patches, which may be changed between steps.

use std::sync::Arc;
use std::time::Instant;

use crate::energy::Order;
use crate::fill::crossing::{Crossing, CrossingWatch};
use crate::fill::noise::roughened;
use crate::fill::renewal::{Moment, Renewals, remesh};
use crate::fill::shape::Shape;
use crate::fill::{
    FillOptions, Gap, Plan, Timings, milliseconds, region, warm_start, warm_start_of,
};
use crate::mesh::{DVec3, LoopId, Mesh};
use crate::patch::{PatchError, TransferError};
use crate::solver::{End, Flow, FlowProblem, Outcome, SolverError, StepRecord};

/// What all groups of a fill share.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub mesh: &'a Mesh,
    pub gaps: &'a [Gap<'a>],
    pub plan: &'a Plan,
}

/// Why a change cannot be made; the group is as before.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum ChangeError {
    #[error(transparent)]
    Flow(#[from] SolverError),
    #[error("hole {hole}: no patch of that density: {source}")]
    Patch { hole: LoopId, source: PatchError },
    #[error("hole {hole}: {source}")]
    Transfer { hole: LoopId, source: TransferError },
}

/// How much energy new triangles may add: their vertices lie on the control triangles and not on the smooth
/// surface, which the next steps mend, and stretched triangles see less of the curvature than there is.
const ROOM: f64 = 1.6;

/// What can be done about a surface that passes through itself.
const REMEDY: &str = "take another energy or a tension, or join fewer rims at a time";

/// A group of holes on its way.
pub(super) struct GroupRun {
    group: usize,
    options: FillOptions,
    shape: Arc<Shape>,
    /// The flow; without one the group stands still at `resting`.
    flow: Option<Flow>,
    resting: Vec<DVec3>,
    failed: Option<SolverError>,
    /// Accepted and rejected steps where there is no flow.
    past: (usize, usize),
    renewals: Renewals,
    crossing: CrossingWatch,
    energy_start: Option<f64>,
    warnings: Vec<String>,
    timings: Timings,
}

impl GroupRun {
    /// Sets the group's flow up at the warm start. If that fails the group stands still at the
    /// furthest it has come to.
    pub fn start(ground: Ground<'_>, group: usize, options: &FillOptions) -> Self {
        let mut run = Self::at_rest(ground, group, options);
        if let Err(error) = run.set_up(ground) {
            run.failed = Some(error);
        }
        run
    }

    /// The group at its first patches, without a flow because of `error`.
    pub fn still(
        ground: Ground<'_>,
        group: usize,
        options: &FillOptions,
        error: SolverError,
    ) -> Self {
        let failed = Some(error);
        Self {
            failed,
            ..Self::at_rest(ground, group, options)
        }
    }

    fn at_rest(ground: Ground<'_>, group: usize, options: &FillOptions) -> Self {
        let (shape, resting) = ground.plan.shape_of(&ground.plan.groups[group]);
        Self {
            group,
            options: options.clone(),
            shape: Arc::new(shape),
            flow: None,
            resting,
            failed: None,
            past: (0, 0),
            renewals: Renewals::default(),
            crossing: CrossingWatch::default(),
            energy_start: None,
            warnings: Vec::new(),
            timings: Timings::default(),
        }
    }

    fn set_up(&mut self, ground: Ground<'_>) -> Result<(), SolverError> {
        let mut lap = Instant::now();
        let mut split = |slot: &mut f64| {
            *slot += milliseconds(lap);
            lap = Instant::now();
        };
        let group = &ground.plan.groups[self.group];
        let options = &self.options;
        let problem = region::problem(
            ground.mesh,
            ground.plan,
            group,
            &self.shape,
            &self.resting,
            options,
        )?;
        split(&mut self.timings.setup);
        let problem = roughened(self.warm_start(ground, problem)?, options.noise);
        self.resting = problem.to_world(problem.positions());
        split(&mut self.timings.warm_start);
        self.flow = Self::flow_of(problem, options)?;
        self.watch(ground);
        split(&mut self.timings.setup);
        Ok(())
    }

    /// The warm start of the patches that do not have their shape yet.
    fn warm_start(
        &self,
        ground: Ground<'_>,
        problem: FlowProblem,
    ) -> Result<FlowProblem, SolverError> {
        if !ground.plan.moved.is_empty() {
            return warm_start(problem);
        }
        let mut first = 0;
        let mut moved = Vec::new();
        let holes = ground.plan.groups[self.group].holes.iter();
        for (&h, hole) in holes.zip(&self.shape.holes) {
            let own = &problem.interior()[first..first + hole.new_vertices];
            first += hole.new_vertices;
            if !ground.plan.holes[h].formed {
                moved.extend_from_slice(own);
            }
        }
        warm_start_of(problem, &moved)
    }

    /// `None` where nothing can move.
    fn flow_of(problem: FlowProblem, options: &FillOptions) -> Result<Option<Flow>, SolverError> {
        if problem.interior().is_empty() {
            return Ok(None);
        }
        Flow::new(problem, options.flow.clone()).map(Some)
    }

    /// Attempts one step; `None` if the group stands still.
    pub fn attempt(&mut self, ground: Ground<'_>) -> Option<StepRecord> {
        let start = Instant::now();
        let record = self.flow.as_mut()?.step();
        self.timings.flow += milliseconds(start);
        match record {
            Ok(record) => {
                if record.as_ref().is_some_and(|record| !record.rejected) {
                    self.renew(ground);
                    self.watch(ground);
                }
                record
            }
            Err(error) => {
                let (shape, resting) = (Arc::clone(&self.shape), self.positions());
                self.fail(error, shape, resting);
                None
            }
        }
    }

    /// Goes on with better triangles where a large deformation has spoilt them.
    fn renew(&mut self, ground: Ground<'_>) {
        let end = self.end();
        let is_fourth = self.options.flow.energy.order() == Order::Fourth;
        match end {
            None | Some(End::Converged) => {}
            // no neck that closes: triangles that a large deformation leaves without area
            Some(End::Pinched) if is_fourth => {}
            _ => return,
        }
        let start = Instant::now();
        let (steps, rejected) = self.counts();
        let (positions, options) = (self.positions(), &self.options);
        let moment = Moment {
            steps,
            converged: end.is_some(),
        };
        let next = self
            .renewals
            .next(ground, self.group, &self.shape, &positions, options, moment);
        if let Some((shape, positions)) = next {
            let energy = self.flow.as_mut().map_or(f64::NAN, Flow::fine_energy);
            let built = self.build(ground, &shape, &positions, &self.options, steps, rejected);
            if let Ok(Some(flow)) = built
                && flow.energy_start() <= ROOM * energy
            {
                self.take(Arc::new(shape), positions, Some(flow));
            }
        }
        self.timings.setup += milliseconds(start);
    }

    /// Looks whether the surface passes through itself. If it does where the flow has ended, the group
    /// goes back to its last shape without.
    fn watch(&mut self, ground: Ground<'_>) {
        let (steps, rejected) = self.counts();
        let (positions, ended) = (self.positions(), self.ended());
        self.crossing
            .look(ground, self.group, &self.shape, &positions, steps, ended);
        let Some(crossing) = self.crossing.found().copied().filter(|_| ended) else {
            return;
        };
        let Some(clean) = self.crossing.clean().cloned() else {
            self.warn(format!(
                "the surface passes through itself or the mesh from the start ({}); {REMEDY}",
                crossing.words()
            ));
            return;
        };
        let built = self.build(
            ground,
            &clean.shape,
            &clean.positions,
            &self.options,
            steps,
            rejected,
        );
        if let Ok(Some(mut flow)) = built {
            flow.finish(End::SelfIntersected);
            self.take(clean.shape, clean.positions, Some(flow));
            self.warn(format!(
                "not converged: on its way the surface passes through itself or the mesh ({}); its last shape                  without that, after step {}, is kept ({REMEDY})",
                crossing.words(),
                clean.steps
            ));
        }
    }

    /// Where the surface passes through itself or the mesh, as far as it was looked at.
    pub fn crossing(&self) -> Option<&Crossing> {
        self.crossing.found()
    }

    /// The flow cannot go on; the group stands still at `resting`, positions of `shape`.
    pub fn fail(&mut self, error: SolverError, shape: Arc<Shape>, resting: Vec<DVec3>) {
        self.keep_history();
        self.flow = None;
        (self.shape, self.resting) = (shape, resting);
        self.failed = Some(error);
    }

    /// Ends the flow at the present shape.
    pub fn stop(&mut self) {
        if let Some(flow) = &mut self.flow {
            flow.cancel();
        }
    }

    /// Goes on with other options from the present shape.
    ///
    /// # Errors
    /// The options are refused and the group is as before.
    pub fn change(&mut self, ground: Ground<'_>, options: &FillOptions) -> Result<(), ChangeError> {
        let group = &ground.plan.groups[self.group];
        let holes = group.holes.iter().map(|&h| &ground.plan.holes[h]);
        // a fairing keeps its triangles
        let remeshed = options.patch != self.options.patch && ground.plan.moved.is_empty();
        let recut = holes.clone().any(|hole| {
            let differs =
                |&id: &LoopId| options.continuity_at(id) != self.options.continuity_at(id);
            hole.loops.iter().any(differs)
        });
        if remeshed || recut || self.flow.is_none() {
            let mut positions = self.positions();
            let mut shape = Arc::clone(&self.shape);
            if remeshed {
                let remeshed = remesh(ground, self.group, &shape, &positions, options)?;
                (shape, positions) = (Arc::new(remeshed.0), remeshed.1);
            }
            let (steps, rejected) = self.counts();
            let flow = self.build(ground, &shape, &positions, options, steps, rejected)?;
            self.take(shape, positions, flow);
        } else if options.flow != self.options.flow
            && let Some(flow) = &mut self.flow
        {
            flow.set_options(options.flow.clone())?;
        }
        self.options = options.clone();
        Ok(())
    }

    /// Goes on from another shape of the group, `steps` accepted steps from its start.
    ///
    /// # Errors
    /// No flow can start there with these options; the group is as before.
    pub fn rewind(
        &mut self,
        ground: Ground<'_>,
        shape: &Arc<Shape>,
        positions: &[DVec3],
        steps: usize,
        options: &FillOptions,
    ) -> Result<(), ChangeError> {
        let (_, rejected) = self.counts();
        let flow = self.build(ground, shape, positions, options, steps, rejected)?;
        self.take(Arc::clone(shape), positions.to_vec(), flow);
        self.crossing.restart();
        self.options = options.clone();
        Ok(())
    }

    fn build(
        &self,
        ground: Ground<'_>,
        shape: &Shape,
        positions: &[DVec3],
        options: &FillOptions,
        steps: usize,
        rejected: usize,
    ) -> Result<Option<Flow>, SolverError> {
        let group = &ground.plan.groups[self.group];
        let problem = region::problem(ground.mesh, ground.plan, group, shape, positions, options)?;
        let flow = Self::flow_of(problem, options)?;
        Ok(flow.map(|flow| flow.counting_from(steps, rejected)))
    }

    fn take(&mut self, shape: Arc<Shape>, positions: Vec<DVec3>, flow: Option<Flow>) {
        self.keep_history();
        self.shape = shape;
        self.resting = positions;
        self.failed = None;
        self.flow = flow;
    }

    /// What is to be remembered of a flow that is about to be replaced.
    fn keep_history(&mut self) {
        if let Some(flow) = &self.flow {
            self.energy_start.get_or_insert(flow.energy_start());
            self.warnings = self.warnings();
            self.past = flow.counts();
        }
    }

    fn counts(&self) -> (usize, usize) {
        self.flow.as_ref().map_or(self.past, Flow::counts)
    }

    /// Accepted steps from the start to the present shape.
    pub fn steps(&self) -> usize {
        self.counts().0
    }

    /// Positions of the new vertices, those of `shape`.
    pub fn positions(&self) -> Vec<DVec3> {
        match &self.flow {
            Some(flow) => flow.problem().to_world(flow.positions()),
            None => self.resting.clone(),
        }
    }

    /// The patches.
    pub fn shape(&self) -> &Arc<Shape> {
        &self.shape
    }

    /// The flow, unless the group cannot go on.
    pub fn flow(&self) -> Option<&Flow> {
        self.flow.as_ref()
    }

    /// Whether it stands still.
    pub fn ended(&self) -> bool {
        self.flow.as_ref().is_none_or(|flow| flow.end().is_some())
    }

    /// Why it has ended, if it has and did not fail.
    pub fn end(&self) -> Option<End> {
        match &self.flow {
            Some(flow) => flow.end(),
            None => self.failed.is_none().then_some(End::Converged),
        }
    }

    /// Why it cannot go on.
    pub fn failed(&self) -> Option<&SolverError> {
        self.failed.as_ref()
    }

    /// Something a person has to know about this group.
    pub fn warn(&mut self, text: String) {
        self.warnings.push(text);
    }

    /// Warnings so far, each once.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = self.warnings.clone();
        for text in self.flow.iter().flat_map(Flow::warnings) {
            if !all.contains(text) {
                all.push(text.clone());
            }
        }
        all
    }

    /// How the flow went, and the stage times.
    ///
    /// # Errors
    /// Why it could not go on.
    pub fn outcome(&mut self) -> Result<(Outcome, Timings), SolverError> {
        let before = std::mem::take(&mut self.warnings);
        let result = match (&mut self.flow, &self.failed) {
            (Some(flow), _) => {
                let mut outcome = flow.outcome();
                if let Some(start) = self.energy_start {
                    outcome.energy_start = start;
                }
                let own = std::mem::take(&mut outcome.warnings);
                outcome.warnings.clone_from(&before);
                outcome
                    .warnings
                    .extend(own.into_iter().filter(|text| !before.contains(text)));
                Ok((outcome, self.timings))
            }
            (None, Some(error)) => Err(error.clone()),
            (None, None) => Ok((nothing_to_do(), self.timings)),
        };
        self.warnings = before;
        result
    }
}

/// The outcome of a group without vertices to move.
fn nothing_to_do() -> Outcome {
    Outcome {
        end: End::Converged,
        steps: 0,
        rejected: 0,
        energy_start: 0.0,
        energy_end: 0.0,
        warnings: Vec::new(),
    }
}
