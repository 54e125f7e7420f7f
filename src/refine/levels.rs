//! A refinement in progress: levels of splits, each with its flow.

mod restore;

use std::sync::Arc;
use std::time::Instant;

use crate::memory::{peak_memory, require};
use crate::mesh::{Attributes, DVec3, Mesh, Split, Topology, VertexId};
use crate::refine::creases::{CreaseWeld, Features, crease_edges, rounded_edges};
use crate::refine::estimate::count_level;
use crate::refine::level_flow::LevelFlow;
use crate::refine::measures::{radius, surface_energy};
use crate::refine::options::{Hold, Method, RefineControls, RefineError, RefineOptions};
use crate::refine::progress::{LevelReport, RefineEvent};
use crate::refine::refined::{Refined, refined_mesh};
use crate::refine::region::{Region, nested_step};
use crate::refine::schemes::butterfly_step;
use crate::refine::start::constrained_start;
use crate::solver::{End, Flow, FlowOptions, FlowProblem, SolverError};
use crate::subdivision::limit_positions;
use crate::surface::Interpolation;
use crate::warning::{Warning, Warnings};
pub(super) use restore::{SavedLevel, SavedState};

/// A mesh being refined, cut open along its creases.
///
/// The first `given` vertices are the input vertices and the copies of them that the cut made.
/// Their positions stay bit-identical, except with Loop's scheme.
pub struct Refinement {
    controls: RefineControls,
    flow: FlowOptions,
    given: usize,
    radius: f64,
    level: usize,
    topology: Arc<Topology>,
    /// Control points of the limit surface.
    control: Vec<DVec3>,
    /// The refined mesh: points of the limit surface (of the scheme).
    points: Vec<DVec3>,
    /// Attributes of the mesh that is cut open.
    attributes: Arc<Attributes>,
    features: Features,
    region: Option<Region>,
    current: Option<LevelFlow>,
    levels: Vec<LevelReport>,
    is_cancelled: bool,
    rounded_edges: Option<Warning>,
    input: Arc<Mesh>,
}

impl Refinement {
    /// Sets up a refinement at level 0.
    ///
    /// # Errors
    /// An option out of range, a named crease that is not a crease, or a mesh without triangles.
    pub fn new(mesh: Arc<Mesh>, options: RefineOptions) -> Result<Self, RefineError> {
        options.validate(&mesh)?;
        if mesh.face_count() == 0 {
            return Err(RefineError::NoFaces);
        }
        require(options.memory(&mesh))?;
        let flow = options.controls.flow(&mesh)?;
        let creases = crease_edges(&mesh, &options)?;
        let rounded_edges = rounded_edges(&mesh, &options, &creases);
        let (topology, features) = Features::new(&mesh, &options, &creases)?;
        let points = features.opened(&mesh.positions);
        let mut control = points.clone();
        // a region of all faces is equivalent to no region
        let region = options.region.filter(|faces| faces.contains(&false));
        if region.is_some() && options.controls.method == Method::Pde {
            // the surface outside the region does not change; like the one inside, it interpolates
            // its vertices
            let used = |&v: &VertexId| topology.has_faces(v);
            let all = (0..points.len()).map(VertexId::from).filter(used);
            let held: Vec<(u32, DVec3)> = all.map(|v| (v.0, points[v.index()])).collect();
            Interpolation::new(&topology, &held).enforce(&mut control);
        }
        Ok(Self {
            given: points.len(),
            radius: radius(&mesh),
            level: 0,
            topology: Arc::new(topology),
            control,
            points,
            attributes: Arc::new(features.opened_attributes(&mesh.attributes)),
            features,
            region: region.map(Region::new),
            current: None,
            levels: Vec::new(),
            is_cancelled: false,
            rounded_edges,
            controls: options.controls,
            flow,
            input: mesh,
        })
    }

    /// Connectivity of the current level, cut open along creases.
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// How the mesh of the current level is welded; `None` without creases.
    pub fn weld(&self) -> Option<&Arc<CreaseWeld>> {
        self.features.weld()
    }

    /// Vertices of the current level, copies along creases counted once.
    pub fn vertex_count(&self) -> usize {
        self.features.whole(&self.topology).vertex_count()
    }

    /// Current positions of the refined mesh: points of the limit surface, and the unchanged input
    /// vertices.
    pub fn points(&self) -> Vec<DVec3> {
        match &self.current {
            Some(running) => self.points_of(&self.control_of(running), &running.constraints),
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

    /// Attributes of the current mesh, cut open along creases.
    pub fn attributes(&self) -> &Arc<Attributes> {
        &self.attributes
    }

    /// The flow of the current level.
    pub fn flow(&self) -> Option<&Flow> {
        self.current.as_ref().map(|running| &running.flow)
    }

    /// The current level, or the last finished one; 0 before the first.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Finished levels.
    pub fn levels(&self) -> &[LevelReport] {
        &self.levels
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.controls.method
    }

    /// Planned number of levels.
    pub fn planned_levels(&self) -> usize {
        self.controls.levels
    }

    /// Whether nothing is left to do.
    pub fn is_finished(&self) -> bool {
        self.current.is_none() && (self.is_cancelled || self.level >= self.controls.levels)
    }

    /// Changes energy, mode, τ, steps or the number of levels. The current level continues from its
    /// current shape, and finished levels stay.
    ///
    /// # Errors
    /// Invalid controls; the old ones stay in force.
    pub fn set_controls(&mut self, controls: &RefineControls) -> Result<(), RefineError> {
        let flow = controls.flow(&self.input)?;
        if flow != self.flow {
            if let Some(running) = &mut self.current {
                running.set_options(&flow)?;
            }
            self.flow = flow;
        }
        self.controls.levels = controls.levels;
        Ok(())
    }

    /// Performs one action: starts a level, attempts a step of its flow, or finishes it. Returns
    /// `None` if nothing is left to do.
    ///
    /// # Errors
    /// Errors that a smaller step cannot avoid; the shape is that of the last step.
    pub fn step(&mut self) -> Result<Option<RefineEvent>, RefineError> {
        let level = self.level;
        let Some(running) = &mut self.current else {
            if self.is_finished() {
                return Ok(None);
            }
            self.begin_level()?;
            return Ok(Some(RefineEvent::Level {
                level: self.level,
                vertices: self.vertex_count(),
                faces: self.topology.face_count(),
            }));
        };
        Ok(Some(match running.step()? {
            Some(record) => RefineEvent::Step { level, record },
            None => RefineEvent::LevelDone(self.finish_level()),
        }))
    }

    /// The current mesh.
    pub fn result(&self) -> Refined {
        let part = |weld, positions: &[DVec3]| {
            refined_mesh(
                &self.input,
                &self.topology,
                weld,
                positions,
                &self.attributes,
            )
        };
        Refined {
            mesh: part(self.weld().map(Arc::as_ref), &self.points()),
            control: part(None, &self.control()),
            levels: self.levels.clone(),
        }
    }

    fn begin_level(&mut self) -> Result<(), RefineError> {
        let start = Instant::now();
        let old = Arc::clone(&self.topology);
        let everything = || vec![true; old.face_count()];
        let chosen = match &self.region {
            Some(region) => region.faces().to_vec(),
            None => everything(),
        };
        let split = (self.features.split(&old, &chosen)).map_err(SolverError::from)?;
        let count = split.vertex_count(&old);
        let new = Topology::from_triangles(count, &split.triangles).map_err(SolverError::from)?;
        Arc::make_mut(&mut self.attributes).split(&old, &split);
        if self.controls.method == Method::Pde {
            self.control = nested_step(&old, &self.control, &split, &[], self.region.as_ref());
        } else {
            self.by_scheme(&old, &split);
        }
        self.level += 1;
        self.topology = Arc::new(new);
        if let Some(region) = &mut self.region {
            region.descend(self.features.whole(&self.topology), &split);
        }
        if self.controls.method != Method::Pde {
            count_level(
                self.controls.method,
                self.topology.face_count(),
                start.elapsed(),
            );
            let report = self.scheme_report(start);
            self.add_report(report);
            return Ok(());
        }
        let (free, held) = self.partition_vertices(&old, &split);
        if free.is_empty() {
            // all vertices lie on creases and boundaries
            self.hold(&held);
            let report = self.scheme_report(start);
            self.add_report(report);
            return Ok(());
        }
        SolverError::unless_cancelled()?;
        let triangles: Vec<[u32; 3]> = self.topology.triangles().collect();
        let problem = FlowProblem::new(&self.control, &triangles, &free, self.radius)?;
        let (problem, unreached) = if self.level == 1 {
            constrained_start(problem, &held)?
        } else {
            (problem.with_constraints(&held)?, 0)
        };
        SolverError::unless_cancelled()?;
        let splits = self.controls.levels.saturating_sub(self.level);
        let flow = LevelFlow::new(problem, &self.flow, splits, held, unreached, start)?;
        self.current = Some(flow);
        Ok(())
    }

    /// One step of Butterfly or of Loop's scheme.
    fn by_scheme(&mut self, old: &Topology, split: &Split) {
        // the new mesh has corners only where the old one has
        let corners = self.features.corners();
        let mut points = if self.controls.method == Method::Butterfly {
            butterfly_step(old, &self.points, split, &corners)
        } else {
            nested_step(old, &self.points, split, &corners, self.region.as_ref())
        };
        self.features.join(&mut points, &self.points);
        self.control.clone_from(&points);
        self.points = points;
    }

    /// Makes the limit surface interpolate points where no vertex is free.
    fn hold(&mut self, held: &[(u32, DVec3)]) {
        Interpolation::new(&self.topology, held).enforce(&mut self.control);
        self.points = self.points_of(&self.control, held);
    }

    /// The free vertices, and the constrained vertices with their target points.
    fn partition_vertices(&self, old: &Topology, split: &Split) -> (Vec<u32>, Vec<(u32, DVec3)>) {
        let topology = &self.topology;
        let (mut free, mut held) = (Vec::new(), Vec::new());
        let near = Region::near(topology, old.vertex_count()..split.vertex_count(old));
        for v in topology.vertices() {
            if !topology.has_faces(v) || !near[v.index()] {
                continue;
            }
            let is_old = v.index() < old.vertex_count();
            let stays = self.controls.hold == Hold::Previous || v.index() < self.given;
            if is_old && (stays || topology.is_boundary_vertex(v) || self.region.is_some()) {
                held.push((v.0, self.points[v.index()]));
            } else if let Some(p) = self.features.point(v) {
                held.push((v.0, p));
            } else {
                free.push(v.0);
            }
        }
        (free, held)
    }

    fn control_of(&self, running: &LevelFlow) -> Vec<DVec3> {
        let centre = running.flow.problem().centre();
        let mut control = self.control.clone();
        for v in running.flow.problem().moving() {
            control[v as usize] = running.flow.positions()[v as usize] + centre;
        }
        control
    }

    fn points_of(&self, control: &[DVec3], held: &[(u32, DVec3)]) -> Vec<DVec3> {
        let mut points = limit_positions(&self.topology, control);
        // vertices far from a region do not move; constrained points are exact
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
        self.control = self.control_of(&running);
        self.points = self.points_of(&self.control, &running.constraints);
        let faces = self.topology.face_count();
        if running.flow.end() != Some(End::Cancelled) {
            count_level(self.controls.method, faces, running.time);
        }
        let report = running.report(self.level, self.vertex_count(), faces);
        self.add_report(report)
    }

    /// Adds the report of a finished level; that of the first has the warning about rounded edges.
    fn add_report(&mut self, mut report: LevelReport) -> LevelReport {
        if self.levels.is_empty() {
            report.warnings.extend(self.rounded_edges.clone());
        }
        self.levels.push(report.clone());
        report
    }

    fn scheme_report(&self, start: Instant) -> LevelReport {
        let energy = surface_energy(
            &self.topology,
            &self.control,
            &self.flow.energy_at(self.radius),
        );
        LevelReport {
            level: self.level,
            vertices: self.vertex_count(),
            faces: self.topology.face_count(),
            steps: 0,
            rejected: 0,
            converged: true,
            end: End::Converged,
            energy_start: energy,
            energy_end: energy,
            held_error: None,
            seconds: start.elapsed().as_secs_f64(),
            peak_memory: peak_memory(),
            warnings: Warnings::default(),
        }
    }
}
