//! The flow of one group of holes with its patches, which may change between steps.

use std::sync::Arc;
use std::time::Instant;

use crate::energy::Order;
use crate::fill::context::{ChangeError, FillContext};
use crate::fill::counterpart::{Faces, Following};
use crate::fill::hole::PlannedHole;
use crate::fill::noise::roughened;
use crate::fill::options::{Continuity, FillOptions};
use crate::fill::patch_topology::PatchTopology;
use crate::fill::plan::Domain;
use crate::fill::prediction::beside_needles;
use crate::fill::region;
use crate::fill::remesh::{RemeshPolicy, remesh, remesh_degraded};
use crate::fill::result::{Timings, milliseconds};
use crate::fill::self_intersection_monitor::{SelfIntersection, SelfIntersectionMonitor};
use crate::fill::soundness::make_sound;
use crate::fill::surface_choice::{Candidate, Counterpart, GroupSurface, OtherSurface, Prediction};
use crate::fill::warm_start::{warm_start, warm_start_of};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, VertexId};
use crate::solver::{End, Flow, FlowProblem, Outcome, SolverError, StepRecord, sharpest_cosine};
use crate::warning::{Warning, Warnings};

/// Maximum factor by which remeshing may raise the energy. A rise is normal: new vertices lie on
/// the control triangles and not on the smooth surface, which the next steps correct, and stretched
/// triangles underestimate the curvature.
const MAX_ENERGY_RISE: f64 = 1.6;

/// The flow of a group of holes.
pub(super) struct GroupFlow {
    group: usize,
    options: FillOptions,
    /// The prediction for `auto`, once it was needed; without candidates if none could be made.
    prediction: Option<Arc<Prediction>>,
    topology: Arc<PatchTopology>,
    /// The flow. Without one the vertices are at `fallback_positions`.
    flow: Option<Flow>,
    fallback_positions: Vec<DVec3>,
    failed: Option<SolverError>,
    /// Accepted and rejected steps if there is no flow.
    counts_before: (usize, usize),
    remeshing: RemeshPolicy,
    following: Following,
    intersection: SelfIntersectionMonitor,
    energy_start: Option<f64>,
    warnings: Warnings,
    /// What the last check for soundness found, by hole.
    patch_warnings: Vec<(LoopId, Warning)>,
    /// The holes whose patches it replaced by those of another model or on another triangulation.
    others: Vec<OtherSurface>,
    timings: Timings,
}

impl GroupFlow {
    /// Sets up the flow at the warm start. If that fails, the vertices keep their positions of the
    /// last successful stage.
    pub fn start(context: FillContext<'_>, group: usize, options: &FillOptions) -> Self {
        let mut run = Self::without_flow(context, group, options);
        let start = Instant::now();
        run.options = run.resolved(context, options);
        run.timings.prediction = milliseconds(start);
        if let Err(error) = run.set_up(context) {
            run.failed = Some(error);
            run.make_sound(context);
        }
        run
    }

    /// The group at its first patches, without a flow because of `error`.
    pub fn failed_at_start(
        context: FillContext<'_>,
        group: usize,
        options: &FillOptions,
        error: SolverError,
    ) -> Self {
        let failed = Some(error);
        Self {
            failed,
            ..Self::without_flow(context, group, options)
        }
    }

    fn without_flow(context: FillContext<'_>, group: usize, options: &FillOptions) -> Self {
        Self {
            group,
            options: options.clone(),
            prediction: None,
            topology: Arc::clone(&context.plan.groups[group].topology),
            flow: None,
            fallback_positions: context.plan.start_positions(context.mesh, group),
            failed: None,
            counts_before: (0, 0),
            remeshing: RemeshPolicy::default(),
            following: Following::default(),
            intersection: SelfIntersectionMonitor::default(),
            energy_start: None,
            warnings: Warnings::default(),
            patch_warnings: Vec::new(),
            others: Vec::new(),
            timings: Timings::default(),
        }
    }

    /// The options with the surface model that prediction chooses, if it is to choose.
    fn resolved(&mut self, context: FillContext<'_>, options: &FillOptions) -> FillOptions {
        let mut resolved = options.clone();
        let mut holes = context.plan.holes_of(self.group);
        let is_smooth = |l: &BoundaryLoop| options.continuity_at(l.id) == Continuity::Auto;
        let is_predictable = |hole: &PlannedHole| {
            let rims = &hole.rims;
            let is_whole = rims.crease.is_empty() && !rims.is_part();
            is_whole && !rims.is_blend() && rims.loops.iter().all(is_smooth)
        };
        let is_patched = matches!(context.plan.domain, Domain::Holes(_));
        resolved.predicts_surface &= is_patched && holes.all(is_predictable);
        if options.symmetry != self.options.symmetry {
            self.prediction = None;
        }
        if resolved.predicts_surface {
            let group = self.group;
            let predict = || {
                Arc::new(Prediction::new(
                    context,
                    group,
                    &options.flow,
                    options.symmetry,
                ))
            };
            let prediction = self.prediction.get_or_insert_with(predict);
            let chosen = prediction.chosen().map(|(chosen, _)| chosen);
            let chosen = chosen.or_else(|| beside_needles(context, group));
            if let Some(chosen) = chosen {
                chosen.apply(&mut resolved.flow);
            }
        }
        resolved
    }

    /// The surface model of the flow, and the prediction that chose it.
    pub fn surface(&self) -> GroupSurface {
        let has_model = self.others.len() < self.topology.holes.len();
        let is_predicted = self.options.predicts_surface && has_model;
        GroupSurface {
            model: self.model(),
            prediction: self.prediction.clone().filter(|_| is_predicted),
            others: self.others.clone(),
        }
    }

    /// The surface model of the flow.
    fn model(&self) -> Candidate {
        let chosen = self.chosen(&self.options);
        chosen.unwrap_or(Candidate::of(&self.options.flow))
    }

    /// The candidate that prediction chose for resolved options.
    fn chosen(&self, options: &FillOptions) -> Option<Candidate> {
        let prediction = self.prediction.as_deref();
        let prediction = prediction.filter(|_| options.predicts_surface);
        Some(prediction?.chosen()?.0)
    }

    /// The counterparts that the holes follow with resolved options; none unless the symmetric model
    /// was chosen.
    fn counterparts(&self, options: &FillOptions) -> &[Option<Counterpart>] {
        let is_symmetric = self.chosen(options).is_some_and(|chosen| chosen.symmetric);
        let prediction = self.prediction.as_deref().filter(|_| is_symmetric);
        prediction.map_or(&[], |p| &p.counterparts)
    }

    /// Lets a flow that has converged follow the counterparts of the holes.
    fn follow_counterparts(&mut self, context: FillContext<'_>) {
        if self.end() != Some(End::Converged) {
            return;
        }
        let counterparts = self.counterparts(&self.options).to_vec();
        if let Some(flow) = &mut self.flow {
            self.following
                .update(context, flow, &self.topology, &counterparts);
        }
    }

    fn set_up(&mut self, context: FillContext<'_>) -> Result<(), SolverError> {
        let mut lap = Instant::now();
        let mut split = |slot: &mut f64| {
            *slot += milliseconds(lap);
            lap = Instant::now();
        };
        let options = &self.options;
        let start = &self.fallback_positions;
        let problem = region::problem(context, self.group, &self.topology, start, options)?;
        split(&mut self.timings.setup);
        let problem = roughened(self.warm_start(context, problem)?, options.noise);
        self.fallback_positions = problem.to_world(problem.positions());
        split(&mut self.timings.warm_start);
        self.flow = Self::flow_of(problem, options)?;
        if self.flow.is_some() && self.has_unfit_rim(context) {
            self.warn(Warning::SmoothRim);
        }
        self.check_self_intersection(context);
        split(&mut self.timings.setup);
        Ok(())
    }

    /// Whether a rim is smooth though the flow of the energy is of second order.
    fn has_unfit_rim(&self, context: FillContext<'_>) -> bool {
        let is_smooth = |l: &BoundaryLoop| self.options.continuity_at(l.id).is_smooth();
        let mut holes = context.plan.holes_of(self.group);
        self.options.flow.order() == Order::Second
            && holes.any(|hole| hole.rims.loops.iter().any(is_smooth))
    }

    /// The warm start of the patches that do not have their topology yet.
    fn warm_start(
        &self,
        context: FillContext<'_>,
        problem: FlowProblem,
    ) -> Result<FlowProblem, SolverError> {
        if let Domain::Vertices(_) = context.plan.domain {
            return warm_start(problem);
        }
        let mut moved = Vec::new();
        let parts = self.topology.split(problem.interior());
        for (hole, (_, own)) in context.plan.holes_of(self.group).zip(parts) {
            if !hole.has_initial_shape {
                moved.extend_from_slice(own);
            }
        }
        warm_start_of(problem, &moved)
    }

    /// `None` if no vertex can move.
    fn flow_of(problem: FlowProblem, options: &FillOptions) -> Result<Option<Flow>, SolverError> {
        if problem.interior().is_empty() {
            return Ok(None);
        }
        Flow::new(problem, options.flow.clone()).map(Some)
    }

    /// Attempts one step; `None` if the flow has ended.
    pub fn attempt(&mut self, context: FillContext<'_>) -> Option<StepRecord> {
        let start = Instant::now();
        let had_ended = self.ended();
        let record = self.flow.as_mut()?.step();
        self.timings.flow += milliseconds(start);
        match record {
            Ok(record) => {
                if record.as_ref().is_some_and(|record| !record.is_rejected()) {
                    self.patch_warnings.clear();
                    self.others.clear();
                    self.remesh_if_degraded(context);
                    self.follow_counterparts(context);
                    self.check_self_intersection(context);
                }
                // a flow may also end with a rejected step, or without one
                if !had_ended {
                    self.make_sound(context);
                }
                record
            }
            Err(error) => {
                let (topology, fallback_positions) = (Arc::clone(&self.topology), self.positions());
                self.fail(error, topology, fallback_positions);
                self.make_sound(context);
                None
            }
        }
    }

    /// Replaces triangles that a large deformation has degraded.
    fn remesh_if_degraded(&mut self, context: FillContext<'_>) {
        let end = self.end();
        let has_order_four = matches!(self.options.flow.order(), Order::Fourth | Order::Sixth);
        match end {
            None | Some(End::Converged) => {}
            // the cause is not a closing neck but zero-area triangles of a large deformation
            Some(End::Pinched) if has_order_four => {}
            _ => return,
        }
        let start = Instant::now();
        let (steps, rejected) = self.step_counts();
        if !self.remeshing.allows(steps, end.is_some()) {
            return;
        }
        let (topology, options) = (&self.topology, &self.options);
        let has_blend = context
            .plan
            .holes_of(self.group)
            .any(|hole| hole.rims.is_blend());
        let positions = self.positions();
        let evens = end == Some(End::Converged) && !has_blend && !self.is_far(context, &positions);
        let next = remesh_degraded(context, self.group, topology, &positions, options, evens);
        if let Some((topology, positions)) = next {
            self.remeshing.count(steps, evens);
            let energy = self.flow.as_mut().map_or(f64::NAN, Flow::fine_energy);
            let built = self.build(
                context,
                &topology,
                &positions,
                &self.options,
                steps,
                rejected,
            );
            if let Ok(Some(flow)) = built
                && (evens || flow.energy_start() <= MAX_ENERGY_RISE * energy)
            {
                // energies on the triangles of a converged flow and on new ones do not compare
                let start = evens.then(|| flow.energy_start());
                self.install(Arc::new(topology), positions, Some(flow));
                self.energy_start = start.or(self.energy_start);
            }
        }
        self.timings.setup += milliseconds(start);
    }

    /// Whether a patch is far from its rim: other triangles let it go still farther.
    fn is_far(&self, context: FillContext<'_>, positions: &[DVec3]) -> bool {
        let holes = context.plan.holes_of(self.group);
        let mut parts = holes.zip(self.topology.split(positions));
        parts.any(|(hole, (_, own))| hole.rims.far_reach(own).is_some())
    }

    /// Checks whether the surface intersects itself or the mesh. If it does at the end of the flow,
    /// the group returns to its last surface without intersections.
    fn check_self_intersection(&mut self, context: FillContext<'_>) {
        let (steps, rejected) = self.step_counts();
        let (positions, ended) = (self.positions(), self.ended());
        self.intersection.check(
            context,
            self.group,
            &self.topology,
            &positions,
            steps,
            ended,
        );
        let Some(found) = self.intersection.found().copied().filter(|_| ended) else {
            return;
        };
        let warning = |kept_step| Warning::SelfIntersection {
            pairs: found.pairs,
            at: found.place,
            kept_step,
        };
        let Some(clean) = self.intersection.clean().cloned() else {
            if !self.is_checked(context) {
                self.warn(warning(None));
            }
            return;
        };
        let built = self.build(
            context,
            &clean.topology,
            &clean.positions,
            &self.options,
            steps,
            rejected,
        );
        if let Ok(Some(mut flow)) = built {
            flow.finish(End::SelfIntersected);
            self.install(clean.topology, clean.positions, Some(flow));
            self.warn(warning(Some(clean.steps)));
        }
    }

    /// Whether the flow has ended or failed and its patches are checked for soundness.
    fn is_checked(&self, context: FillContext<'_>) -> bool {
        let is_patched = matches!(context.plan.domain, Domain::Holes(_));
        let has_ended = !matches!(self.end(), None | Some(End::Cancelled));
        is_patched && (has_ended || self.failed.is_some())
    }

    /// Checks the patches at the end of the flow or after its failure, and replaces unsound ones of single rims.
    pub fn make_sound(&mut self, context: FillContext<'_>) {
        if !self.is_checked(context) {
            return;
        }
        let start = Instant::now();
        let positions = self.positions();
        let checked = make_sound(
            context,
            self.group,
            &self.topology,
            positions,
            self.model(),
            self.counterparts(&self.options),
            &self.options,
        );
        self.patch_warnings = checked.warnings;
        self.others = checked.others;
        if let Some((topology, positions)) = checked.replaced {
            let topology = Arc::new(topology);
            let failed = self.failed.take();
            let flow = failed.is_none().then(|| {
                let (steps, rejected) = self.step_counts();
                let options = &self.options;
                let flow = self.build(context, &topology, &positions, options, steps, rejected);
                let mut flow = flow.ok().flatten()?;
                flow.finish(self.end().unwrap_or(End::Converged));
                Some(flow)
            });
            self.install(topology, positions, flow.flatten());
            self.failed = failed;
        }
        self.timings.soundness += milliseconds(start);
    }

    /// The intersection found by the last check, if there was one.
    pub fn self_intersection(&self) -> Option<&SelfIntersection> {
        self.intersection.found()
    }

    /// Ends the flow because of `error`. The vertices stay at `fallback_positions`, those of
    /// `topology`.
    pub fn fail(
        &mut self,
        error: SolverError,
        topology: Arc<PatchTopology>,
        fallback_positions: Vec<DVec3>,
    ) {
        self.keep_history();
        self.flow = None;
        (self.topology, self.fallback_positions) = (topology, fallback_positions);
        self.failed = Some(error);
    }

    /// Ends the flow at the current surface.
    pub fn stop(&mut self) {
        if let Some(flow) = &mut self.flow {
            flow.cancel();
        }
    }

    /// Continues with other options from the current surface.
    ///
    /// # Errors
    /// The options are refused; the group continues as before.
    pub fn change(
        &mut self,
        context: FillContext<'_>,
        options: &FillOptions,
    ) -> Result<(), ChangeError> {
        let followed = self.counterparts(&self.options).to_vec();
        let options = &self.resolved(context, options);
        let refollowed = followed != self.counterparts(options);
        if refollowed {
            self.following = Following::default();
        }
        let is_patched = matches!(context.plan.domain, Domain::Holes(_));
        let remeshed = is_patched && options.patch != self.options.patch;
        let mut loops = context
            .plan
            .holes_of(self.group)
            .flat_map(|hole| &hole.rims.loops);
        let recut = loops.any(|l| options.continuity_at(l.id) != self.options.continuity_at(l.id));
        if remeshed || recut || refollowed || self.flow.is_none() {
            let mut positions = self.positions();
            let mut topology = Arc::clone(&self.topology);
            if remeshed {
                let remeshed = remesh(context, self.group, &topology, &positions, options)?;
                (topology, positions) = (Arc::new(remeshed.0), remeshed.1);
            }
            let (steps, rejected) = self.step_counts();
            let flow = self.build(context, &topology, &positions, options, steps, rejected)?;
            self.install(topology, positions, flow);
        } else if options.flow != self.options.flow
            && let Some(flow) = &mut self.flow
        {
            flow.set_options(options.flow.clone())?;
        }
        self.options = options.clone();
        Ok(())
    }

    /// Continues from another surface of the group, `steps` accepted steps from its start.
    ///
    /// # Errors
    /// No flow can start from that surface with these options. The group continues as before.
    pub fn rewind(
        &mut self,
        context: FillContext<'_>,
        topology: &Arc<PatchTopology>,
        positions: &[DVec3],
        steps: usize,
        options: &FillOptions,
    ) -> Result<(), ChangeError> {
        let options = &self.resolved(context, options);
        let (_, rejected) = self.step_counts();
        self.following = Following::default();
        let flow = self.build(context, topology, positions, options, steps, rejected)?;
        self.install(Arc::clone(topology), positions.to_vec(), flow);
        self.intersection.restart();
        self.options = options.clone();
        Ok(())
    }

    fn build(
        &self,
        context: FillContext<'_>,
        topology: &PatchTopology,
        positions: &[DVec3],
        options: &FillOptions,
        steps: usize,
        rejected: usize,
    ) -> Result<Option<Flow>, SolverError> {
        let mut problem = region::problem(context, self.group, topology, positions, options)?;
        if self.following.has_begun() {
            let (positions, counterparts) = (problem.positions(), self.counterparts(options));
            let faces = &mut Faces::default();
            let references = context.references(&problem, topology, positions, counterparts, faces);
            problem = problem.with_references(references);
        }
        if self.remeshing.has_evened() {
            problem = problem.keeping_metric();
        }
        let flow = Self::flow_of(problem, options)?;
        Ok(flow.map(|flow| flow.counting_from(steps, rejected)))
    }

    fn install(&mut self, topology: Arc<PatchTopology>, positions: Vec<DVec3>, flow: Option<Flow>) {
        self.keep_history();
        self.topology = topology;
        self.fallback_positions = positions;
        self.failed = None;
        self.flow = flow;
    }

    /// Stores the steps, warnings and times of a flow before it is replaced.
    fn keep_history(&mut self) {
        if let Some(flow) = &self.flow {
            self.energy_start.get_or_insert(flow.energy_start());
            self.warnings = self.warnings();
            self.counts_before = flow.counts();
        }
    }

    fn step_counts(&self) -> (usize, usize) {
        self.flow.as_ref().map_or(self.counts_before, Flow::counts)
    }

    /// Accepted steps from the start to the current surface.
    pub fn steps(&self) -> usize {
        self.step_counts().0
    }

    /// Positions of the vertices that flow, those of [`Self::topology`].
    pub fn positions(&self) -> Vec<DVec3> {
        match &self.flow {
            Some(flow) => flow.problem().to_world(flow.positions()),
            None => self.fallback_positions.clone(),
        }
    }

    /// The triangulations of the patches.
    pub fn topology(&self) -> &Arc<PatchTopology> {
        &self.topology
    }

    /// Smallest triangle angle of the patches, or of the faired triangles, in degrees. `positions`
    /// are [`Self::positions`].
    pub fn worst_angle(&self, context: FillContext<'_>, positions: &[DVec3]) -> f64 {
        let mesh = context.mesh;
        let mut sharpest = -1.0f64;
        if let Domain::Vertices(moved) = &context.plan.domain {
            let place = |v: VertexId| match moved.binary_search(&v) {
                Ok(i) => positions[i],
                Err(_) => mesh.position(v),
            };
            let faces = moved.iter().flat_map(|&v| mesh.topology.outgoing(v));
            for f in faces.map(|h| mesh.topology.face(h)) {
                let corners = mesh.topology.face_vertices(f).map(place);
                sharpest = sharpest.max(sharpest_cosine(corners));
            }
        }
        let parts = self.topology.split(positions);
        for (hole, (own, here)) in context.plan.holes_of(self.group).zip(parts) {
            let rim = &hole.rims.vertices;
            let place = |v: u32| match rim.get(v as usize) {
                Some(&given) => mesh.position(given),
                None => here[v as usize - rim.len()],
            };
            for t in &own.triangles {
                sharpest = sharpest.max(sharpest_cosine(t.map(place)));
            }
        }
        sharpest.clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// The flow, unless it failed or no vertex can move.
    pub fn flow(&self) -> Option<&Flow> {
        self.flow.as_ref()
    }

    /// Whether the flow has ended.
    pub fn ended(&self) -> bool {
        self.flow.as_ref().is_none_or(|flow| flow.end().is_some())
    }

    /// Why the flow has ended, if it has and did not fail.
    pub fn end(&self) -> Option<End> {
        match &self.flow {
            Some(flow) => flow.end(),
            None => self.failed.is_none().then_some(End::Converged),
        }
    }

    /// Why the flow failed, if it did.
    pub fn failed(&self) -> Option<&SolverError> {
        self.failed.as_ref()
    }

    /// Adds a warning for the user.
    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Warnings so far, each once.
    pub fn warnings(&self) -> Warnings {
        let mut all = self.warnings.clone();
        let of_flow = self.flow.iter().flat_map(|flow| flow.warnings().iter());
        all.extend(of_flow.cloned());
        all
    }

    /// What the check of the patches at the end of the flow found, by hole.
    pub fn patch_warnings(&self) -> &[(LoopId, Warning)] {
        &self.patch_warnings
    }

    /// The most steps that the flow can still accept.
    pub fn steps_left(&self) -> usize {
        self.options.flow.max_steps.saturating_sub(self.steps())
    }

    /// The outcome of the flow, and the stage times.
    ///
    /// # Errors
    /// Why the flow failed.
    pub fn outcome(&mut self) -> Result<(Outcome, Timings), SolverError> {
        match (&mut self.flow, &self.failed) {
            (Some(flow), _) => {
                let mut outcome = flow.outcome();
                if let Some(start) = self.energy_start {
                    outcome.energy_start = start;
                }
                let mut all = self.warnings.clone();
                all.extend(outcome.warnings);
                outcome.warnings = all;
                Ok((outcome, self.timings))
            }
            (None, Some(error)) => Err(error.clone()),
            (None, None) => {
                let warnings = self.warnings.clone();
                Ok((nothing_to_do(warnings), self.timings))
            }
        }
    }
}

/// The outcome of a group without vertices to move.
fn nothing_to_do(warnings: Warnings) -> Outcome {
    Outcome {
        end: End::Converged,
        steps: 0,
        rejected: 0,
        energy_start: 0.0,
        energy_end: 0.0,
        warnings,
    }
}
