//! The state of a refinement.

use std::sync::Arc;

use crate::mesh::{Attributes, DVec3, Mesh, Topology};
use crate::refine::levels::{Refinement, SavedLevel};
use crate::refine::refined::refined_mesh;
use crate::refine::{CreaseWeld, Method};
use crate::runner::TimelineState;
use crate::solver::StepRecord;

/// Data shared by the states of one level.
#[derive(Clone, Debug)]
pub struct LevelFrame {
    /// The level; 0 is the input mesh.
    pub level: usize,
    /// Connectivity, cut open along creases. The input vertices come first, then their copies made
    /// by the cut.
    pub topology: Arc<Topology>,
    /// The map to the welded mesh, if the mesh is cut.
    pub weld: Option<Arc<CreaseWeld>>,
    /// Attributes of the mesh that is cut open.
    pub attributes: Arc<Attributes>,
    /// Whether `control` of the states is the control mesh of a smooth limit surface. It is not for
    /// Butterfly, which has no such surface.
    pub has_limit: bool,
    given: Arc<Mesh>,
    pub(super) saved: SavedLevel,
}

/// A refined mesh after an accepted step, or at the start of a level.
#[derive(Clone, Debug)]
pub struct RefineState {
    /// Number of attempted steps before it, over all levels.
    pub attempts: usize,
    /// Accepted steps of its level.
    pub step: usize,
    /// Connectivity and attributes; the same `Arc` for all states of a level.
    pub frame: Arc<LevelFrame>,
    /// The vertices of the refined mesh: points of the limit surface (of the scheme), and the
    /// unchanged input vertices.
    pub points: Arc<[DVec3]>,
    /// Control points of the limit surface over the same connectivity.
    pub control: Arc<[DVec3]>,
    /// Energy by the rule of the steps; NaN before the first step of a level.
    pub energy: f64,
    /// Residual of the step; `None` at the start of a level.
    pub residual: Option<f64>,
}

impl LevelFrame {
    pub(super) fn of(refinement: &Refinement, given: &Arc<Mesh>) -> Self {
        Self {
            level: refinement.level(),
            topology: Arc::clone(refinement.topology()),
            weld: refinement.weld().cloned(),
            attributes: Arc::clone(refinement.attributes()),
            has_limit: refinement.method() != Method::Butterfly,
            given: Arc::clone(given),
            saved: refinement.save_level(),
        }
    }
}

impl RefineState {
    /// The current state; `last` is the last accepted step of the level.
    pub(super) fn of(
        refinement: &Refinement,
        frame: Arc<LevelFrame>,
        last: Option<&StepRecord>,
        attempts: usize,
    ) -> Self {
        let control: Arc<[DVec3]> = refinement.control().into();
        let points = if refinement.method() == Method::Pde {
            refinement.points().into()
        } else {
            Arc::clone(&control)
        };
        Self {
            attempts,
            step: last.map_or(0, |r| r.step),
            frame,
            points,
            control,
            energy: last.map_or(f64::NAN, |r| r.energy),
            residual: last.map(|r| r.residual),
        }
    }

    /// The refined mesh, welded, with the attributes of the input mesh.
    pub fn mesh(&self) -> Mesh {
        self.with(self.frame.weld.as_deref(), &self.points)
    }

    /// The control mesh of its limit surface, open along creases, with the same attributes.
    pub fn control_mesh(&self) -> Mesh {
        self.with(None, &self.control)
    }

    fn with(&self, weld: Option<&CreaseWeld>, positions: &[DVec3]) -> Mesh {
        let frame = &self.frame;
        refined_mesh(
            &frame.given,
            &frame.topology,
            weld,
            positions,
            &frame.attributes,
        )
    }
}

impl TimelineState for RefineState {
    fn bytes(&self, before: Option<&Self>) -> usize {
        let frame = if before.is_some_and(|s| Arc::ptr_eq(&s.frame, &self.frame)) {
            0
        } else {
            let frame = &self.frame;
            let weld = frame.weld.as_ref();
            let weld = weld.map_or(0, |w| w.topology.bytes() + 4 * w.to_whole.len());
            let attributes = frame.attributes.bytes();
            frame.topology.bytes() + weld + attributes + frame.saved.bytes()
        };
        let mut positions = self.points.len();
        if !Arc::ptr_eq(&self.points, &self.control) {
            positions += self.control.len();
        }
        frame + positions * size_of::<DVec3>()
    }
}
