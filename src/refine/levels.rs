//! A refinement in progress: levels of splits, each with its flow.

use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use crate::mesh::{DVec3, FaceId, Mesh, Split, Topology, VertexId, split_faces};
use crate::refine::boundary::BoundaryCurves;
use crate::refine::options::{Hold, Method, RefineError, RefineOptions};
use crate::refine::region::Region;
use crate::refine::schemes::{butterfly_step, loop_step};
use crate::refine::start::{fair_points, graded_points};
use crate::solver::energy::Energy;
use crate::solver::{
    Assembler, End, Flow, FlowOptions, FlowProblem, FoldState, Mode, Scheme, SolverError,
    StepRecord, Unknowns,
};
use crate::subdivision::{Rule, TableCache, elements, limit_positions};

/// What a finished level is like.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelReport {
    /// From 1.
    pub level: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Accepted steps of the flow.
    pub steps: usize,
    /// Rejected ones.
    pub rejected: usize,
    /// Whether the stopping rule was met (always for the schemes without a flow).
    pub converged: bool,
    /// `converged`, `steps` (as many as allowed), `stuck` (τ collapsed) or `cancelled`.
    pub end: &'static str,
    /// Energy of the limit surface at the start of the level, 12-point rule.
    pub energy_start: f64,
    /// At its end.
    pub energy_end: f64,
    /// Largest distance of the limit surface from a vertex it has to pass, over the radius of the
    /// mesh; null for Loop's scheme and Butterfly.
    pub held_error: Option<f64>,
    /// Wall clock.
    pub seconds: f64,
    /// Warnings in plain words.
    pub warnings: Vec<String>,
}

/// What [`Refinement::step`] did.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// A level was begun: topology and positions are those of the finer mesh.
    Level(usize),
    /// A step of the level's flow was attempted.
    Step(StepRecord),
    /// The level is finished.
    Finished(LevelReport),
}

/// Part of the steps that may go to the guarded descent before the normal flow takes over.
const GUARDED_SHARE: usize = 2;
/// The normal flow takes over when so many steps together gained less than this part.
const SETTLED: (usize, f64) = (10, 1e-4);

/// A mesh being refined.
///
/// The first `given` vertices keep their positions to the bit (but for Loop's scheme).
pub struct Refinement {
    options: RefineOptions,
    given: usize,
    radius: f64,
    level: usize,
    topology: Arc<Topology>,
    /// Control points of the limit surface.
    control: Vec<DVec3>,
    /// The refined mesh: points of the limit surface (of the scheme).
    points: Vec<DVec3>,
    colors: Vec<[f32; 4]>,
    face_tags: Vec<u32>,
    curves: BoundaryCurves,
    region: Option<Region>,
    current: Option<Running>,
    levels: Vec<LevelReport>,
    is_cancelled: bool,
    input: Arc<Mesh>,
}

/// The flow of the level under way.
struct Running {
    flow: Flow,
    start: Instant,
    held: Vec<(u32, DVec3)>,
    /// Energies after the last accepted steps of the guarded descent.
    recent: Vec<f64>,
    is_guarded: bool,
}

/// The result of a refinement.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The refined mesh, on the limit surface; the given vertices first.
    pub mesh: Mesh,
    /// The control mesh of the limit surface; for Butterfly, which has none, the mesh itself.
    pub control: Vec<DVec3>,
    /// Level by level.
    pub levels: Vec<LevelReport>,
}

impl Refinement {
    /// Sets a refinement up; nothing is split yet.
    ///
    /// # Errors
    /// An option out of range, or a mesh without triangles.
    pub fn new(mesh: Arc<Mesh>, options: RefineOptions) -> Result<Self, RefineError> {
        options.validate(&mesh)?;
        if mesh.face_count() == 0 {
            return Err(RefineError::NoFaces);
        }
        let curves = BoundaryCurves::new(
            &mesh.topology,
            &mesh.positions,
            options.boundary,
            options.corner_angle,
        );
        Ok(Self {
            given: mesh.vertex_count(),
            radius: radius(&mesh),
            level: 0,
            topology: Arc::new(mesh.topology.clone()),
            control: mesh.positions.clone(),
            points: mesh.positions.clone(),
            colors: mesh.colors.clone(),
            face_tags: mesh.face_tags.clone(),
            curves,
            region: options.region.clone().map(Region::new),
            current: None,
            levels: Vec::new(),
            is_cancelled: false,
            options,
            input: mesh,
        })
    }

    /// Connectivity of the current level.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// Current positions of the refined mesh: points of the limit surface, the given vertices as
    /// they were.
    pub fn points(&self) -> Vec<DVec3> {
        match &self.current {
            Some(running) => self.points_of(&self.control_of(running), &running.held),
            None => self.points.clone(),
        }
    }

    /// Control points of the current limit surface.
    pub fn control(&self) -> Vec<DVec3> {
        match &self.current {
            Some(running) => self.control_of(running),
            None => self.control.clone(),
        }
    }

    /// Colours of the current mesh's vertices; empty if it has none.
    pub fn colors(&self) -> &[[f32; 4]] {
        &self.colors
    }

    /// Tags of the current mesh's faces; empty if it has none.
    pub fn face_tags(&self) -> &[u32] {
        &self.face_tags
    }

    /// The flow of the level under way.
    pub fn flow(&self) -> Option<&Flow> {
        self.current.as_ref().map(|running| &running.flow)
    }

    /// The level under way or finished last; 0 before the first.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Finished levels.
    pub fn levels(&self) -> &[LevelReport] {
        &self.levels
    }

    /// The options in force.
    pub fn options(&self) -> &RefineOptions {
        &self.options
    }

    /// Whether nothing is left to do.
    pub fn is_finished(&self) -> bool {
        self.current.is_none() && (self.is_cancelled || self.level >= self.options.levels)
    }

    /// Ends the refinement: the level under way is finished where it is, and no further one begun.
    pub fn cancel(&mut self) {
        self.is_cancelled = true;
        if let Some(running) = &mut self.current {
            running.flow.cancel();
        }
    }

    /// Changes energy, mode, τ or steps; the level under way goes on from its current shape.
    ///
    /// # Errors
    /// The new options are refused and the old ones stay in force.
    pub fn set_flow(&mut self, flow: FlowOptions) -> Result<(), RefineError> {
        flow.validate()?;
        if let Some(running) = &mut self.current {
            running.flow.set_options(level_options(&flow))?;
            running.is_guarded = running.flow.options().scheme == Scheme::Guarded;
            running.recent.clear();
        }
        self.options.flow = flow;
        Ok(())
    }

    /// Changes how many levels there are to be; those done are kept.
    pub fn set_levels(&mut self, levels: usize) {
        self.options.levels = levels;
    }

    /// Does one thing: begins a level, attempts a step of its flow, or finishes it. `None` if there
    /// is nothing left to do.
    ///
    /// # Errors
    /// Only what a smaller step cannot mend; the shape is that of the last step.
    pub fn step(&mut self) -> Result<Option<Progress>, RefineError> {
        let Some(running) = &mut self.current else {
            if self.is_finished() {
                return Ok(None);
            }
            return self.begin_level().map(Some);
        };
        if let Some(record) = running.flow.step()? {
            running.watch(&record, &self.options.flow)?;
            return Ok(Some(Progress::Step(record)));
        }
        if running.is_guarded && running.flow.end() == Some(End::Stuck) {
            // sliding along the surface no longer helps; the normal flow may still
            running.settle(&self.options.flow)?;
            return self.step();
        }
        Ok(Some(Progress::Finished(self.finish_level())))
    }

    /// Runs to the end; `observe` is called after every step and returns whether to go on.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run(
        mut self,
        mut observe: impl FnMut(&Self, &Progress) -> bool,
    ) -> Result<Refined, RefineError> {
        while let Some(progress) = self.step()? {
            if !observe(&self, &progress) {
                self.cancel();
            }
        }
        Ok(self.result())
    }

    /// The mesh as it is now.
    pub fn result(&self) -> Refined {
        let mut mesh = Mesh::new(self.points(), Topology::clone(&self.topology));
        mesh.colors.clone_from(&self.colors);
        mesh.face_tags.clone_from(&self.face_tags);
        mesh.tags.clone_from(&self.input.tags);
        mesh.one_sided.clone_from(&self.input.one_sided);
        mesh.one_sided_tags.clone_from(&self.input.one_sided_tags);
        Refined {
            mesh,
            control: self.control(),
            levels: self.levels.clone(),
        }
    }

    fn begin_level(&mut self) -> Result<Progress, RefineError> {
        let start = Instant::now();
        let old = Arc::clone(&self.topology);
        let everything = || vec![true; old.face_count()];
        let chosen = match &self.region {
            Some(region) => region.faces().to_vec(),
            None => everything(),
        };
        let split = split_faces(&old, &chosen);
        let count = split.vertex_count(&old);
        let new = Topology::from_triangles(count, &split.triangles).map_err(SolverError::from)?;
        self.curves = self.curves.split(&old, &split);
        self.inherit(&old, &split);
        match self.options.method {
            Method::Butterfly => {
                self.points = butterfly_step(&old, &self.points, &split);
                self.control.clone_from(&self.points);
            }
            Method::Loop => {
                self.points = self.nested(&old, &split, &self.points);
                self.control.clone_from(&self.points);
            }
            Method::Pde if self.level == 0 => {
                self.control = graded_points(&old, &self.points, &split);
            }
            Method::Pde => self.control = self.nested(&old, &split, &self.control),
        }
        self.level += 1;
        self.topology = Arc::new(new);
        if let Some(region) = &mut self.region {
            region.descend(&self.topology, &split);
        }
        let level = Progress::Level(self.level);
        if self.options.method != Method::Pde {
            self.levels.push(self.scheme_report(start));
            return Ok(level);
        }
        let (free, held) = self.roles(&old, &split);
        let triangles: Vec<[u32; 3]> = self.topology.triangles().collect();
        let problem =
            FlowProblem::new(&self.control, &triangles, &free, self.radius)?.holding(&held)?;
        let problem = if self.level == 1 && self.region.is_none() {
            best_start(problem, &self.options.flow.energy_at(self.radius))
        } else {
            problem
        };
        let options = level_options(&self.options.flow);
        self.current = Some(Running {
            is_guarded: options.scheme == Scheme::Guarded,
            flow: Flow::new(problem, options)?,
            start,
            held,
            recent: Vec::new(),
        });
        Ok(level)
    }

    /// Loop's scheme where the mesh is split all around; elsewhere old vertices stay.
    fn nested(&self, old: &Topology, split: &Split, positions: &[DVec3]) -> Vec<DVec3> {
        let mut new = loop_step(old, positions, split);
        if let Some(region) = &self.region {
            for v in 0..positions.len() {
                let inside = old
                    .outgoing(VertexId::from(v))
                    .map(|h| old.face(h))
                    .all(|f| !f.is_some() || region.faces()[f.index()]);
                if !inside {
                    new[v] = positions[v];
                }
            }
        }
        new
    }

    /// The vertices that move and those held, with the points to pass.
    fn roles(&self, old: &Topology, split: &Split) -> (Vec<u32>, Vec<(u32, DVec3)>) {
        let topology = &self.topology;
        let (mut free, mut held) = (Vec::new(), Vec::new());
        let near = Region::near(topology, old.vertex_count()..split.vertex_count(old));
        for v in (0..topology.vertex_count()).map(VertexId::from) {
            if !topology.halfedge_of_vertex(v).is_some() || !near[v.index()] {
                continue;
            }
            let is_old = v.index() < old.vertex_count();
            let stays = self.options.hold == Hold::Previous || v.index() < self.given;
            if is_old && (stays || topology.is_boundary_vertex(v) || self.region.is_some()) {
                held.push((v.0, self.points[v.index()]));
            } else if let Some(p) = self.curves.point(topology, v) {
                held.push((v.0, p));
            } else {
                free.push(v.0);
            }
        }
        (free, held)
    }

    fn inherit(&mut self, old: &Topology, split: &Split) {
        if !self.colors.is_empty() {
            for &h in &split.edges {
                let [a, b] = [old.origin(h), old.target(h)].map(|v| self.colors[v.index()]);
                self.colors
                    .push(std::array::from_fn(|i| 0.5 * (a[i] + b[i])));
            }
        }
        if !self.face_tags.is_empty() {
            let tags = split.parent.iter().map(|&f| self.face_tags[f as usize]);
            self.face_tags = tags.collect();
        }
    }

    fn control_of(&self, running: &Running) -> Vec<DVec3> {
        let centre = running.flow.problem().centre();
        let mut control = self.control.clone();
        for v in running.flow.problem().moving() {
            control[v as usize] = running.flow.positions()[v as usize] + centre;
        }
        control
    }

    fn points_of(&self, control: &[DVec3], held: &[(u32, DVec3)]) -> Vec<DVec3> {
        let mut points = limit_positions(&self.topology, control);
        // vertices far from a region are where they were; those held are exact
        let known = self.points.len();
        if self.region.is_some() {
            points[..known].copy_from_slice(&self.points);
        }
        points[..self.given].copy_from_slice(&self.points[..self.given]);
        for &(v, p) in held {
            points[v as usize] = p;
        }
        points
    }

    fn finish_level(&mut self) -> LevelReport {
        let Some(mut running) = self.current.take() else {
            return self.scheme_report(Instant::now());
        };
        let outcome = running.flow.outcome();
        let problem = running.flow.problem();
        let error = problem
            .interpolation()
            .map(|i| i.error(running.flow.positions()) / self.radius);
        self.control = self.control_of(&running);
        self.points = self.points_of(&self.control, &running.held);
        let report = LevelReport {
            level: self.level,
            vertices: self.points.len(),
            faces: self.topology.face_count(),
            steps: outcome.steps,
            rejected: outcome.rejected,
            converged: outcome.end == End::Converged,
            end: match outcome.end {
                End::Converged => "converged",
                End::Steps => "steps",
                End::Stuck | End::Pinched | End::Crossed => "stuck",
                End::Cancelled => "cancelled",
            },
            energy_start: outcome.energy_start,
            energy_end: outcome.energy_end,
            held_error: error,
            seconds: running.start.elapsed().as_secs_f64(),
            warnings: outcome.warnings,
        };
        self.levels.push(report.clone());
        report
    }

    fn scheme_report(&self, start: Instant) -> LevelReport {
        let energy = surface_energy(
            &self.topology,
            &self.control,
            &self.options.flow.energy_at(self.radius),
        );
        LevelReport {
            level: self.level,
            vertices: self.points.len(),
            faces: self.topology.face_count(),
            steps: 0,
            rejected: 0,
            converged: true,
            end: "converged",
            energy_start: energy,
            energy_end: energy,
            held_error: None,
            seconds: start.elapsed().as_secs_f64(),
            warnings: Vec::new(),
        }
    }
}

impl Running {
    /// Hands over to the normal flow when the guarded descent gains little.
    fn watch(&mut self, record: &StepRecord, flow: &FlowOptions) -> Result<(), SolverError> {
        if !self.is_guarded || record.rejected {
            return Ok(());
        }
        self.recent.push(record.energy);
        let (count, part) = SETTLED;
        let n = self.recent.len();
        let settled = n > count && {
            let before = self.recent[n - 1 - count];
            before - record.energy < part * before.abs()
        };
        if settled || GUARDED_SHARE * record.step >= flow.max_steps || self.flow.end().is_some() {
            self.settle(flow)?;
        }
        Ok(())
    }

    /// Goes on along the normals alone.
    fn settle(&mut self, flow: &FlowOptions) -> Result<(), SolverError> {
        self.is_guarded = false;
        if self.flow.end() == Some(End::Cancelled) {
            return Ok(());
        }
        let mut options = level_options(flow);
        options.scheme = Scheme::Normal;
        self.flow.set_options(options)
    }
}

/// The problem from its own starting positions or from the fair ones, whichever is less folded, then
/// of less energy. On even meshes the graph bi-Laplacian comes near to the stationary shape; on
/// uneven ones it folds.
fn best_start(problem: FlowProblem, energy: &Energy) -> FlowProblem {
    let topology = problem.topology();
    let elements = elements(
        topology,
        problem.active_faces(),
        Rule::Twelve,
        &mut TableCache::default(),
    );
    let judge = |positions: &[DVec3]| {
        let folded = FoldState::new(topology, &elements, positions).folded();
        (folded, surface_energy(topology, positions, energy))
    };
    let Some(interpolation) = problem.interpolation() else {
        return problem;
    };
    let Ok(mut fair) = fair_points(topology, problem.positions(), interpolation) else {
        return problem; // the other start does without a factorization
    };
    interpolation.settle(&mut fair);
    let (own, other) = (judge(problem.positions()), judge(&fair));
    if other.0 < own.0 || (other.0 == own.0 && other.1 < own.1) {
        problem.with_positions(&fair)
    } else {
        problem
    }
}

/// The options of a level's flow: the guarded descent first, or the flow in true time; always the
/// 12-point rule, for coarse meshes fold between fewer points.
fn level_options(flow: &FlowOptions) -> FlowOptions {
    FlowOptions {
        scheme: match flow.mode {
            Mode::Fast => Scheme::Guarded,
            Mode::Flow => Scheme::Normal,
        },
        quadrature: Rule::Twelve,
        relaxation: 0.0,
        ..flow.clone()
    }
}

/// `∫ f dA` over the whole Loop limit surface, 12-point rule.
pub fn surface_energy(topology: &Topology, control: &[DVec3], energy: &Energy) -> f64 {
    let faces: Vec<FaceId> = (0..topology.face_count()).map(FaceId::from).collect();
    let elements = elements(topology, &faces, Rule::Twelve, &mut TableCache::default());
    Assembler::new(&elements, Rule::Twelve, Unknowns::none(control.len()))
        .gradient(control, energy, &mut Vec::new())
        .value
}

/// RMS distance of the vertices of triangles from their mean, the unit of length of a refinement; 1
/// if they coincide.
pub fn radius(mesh: &Mesh) -> f64 {
    let used: Vec<DVec3> = (0..mesh.vertex_count())
        .filter(|&v| {
            mesh.topology
                .halfedge_of_vertex(VertexId::from(v))
                .is_some()
        })
        .map(|v| mesh.positions[v])
        .collect();
    let n = used.len().max(1) as f64;
    let origin = used.first().copied().unwrap_or_default();
    let mean = origin + used.iter().map(|&p| p - origin).sum::<DVec3>() / n;
    let square = used.iter().map(|p| p.distance_squared(mean)).sum::<f64>() / n;
    if square > 0.0 { square.sqrt() } else { 1.0 }
}
