//! Going back to an earlier state of a refinement, and ending it early.

use std::sync::Arc;
use std::time::Instant;

use super::Refinement;
use crate::mesh::{Attributes, DVec3, Topology};
use crate::refine::creases::Features;
use crate::refine::level_flow::LevelFlow;
use crate::refine::progress::LevelReport;
use crate::refine::region::Region;
use crate::refine::{RefineControls, RefineError};
use crate::solver::FlowProblem;

/// What a refinement needs to return to a level, besides the positions.
#[derive(Clone, Debug)]
pub(in crate::refine) struct SavedLevel {
    level: usize,
    topology: Arc<Topology>,
    /// Points of the previous level, while the level's flow runs.
    previous: Vec<DVec3>,
    attributes: Arc<Attributes>,
    features: Features,
    region: Option<Region>,
    flow: Option<SavedFlow>,
    /// Reports of the finished levels.
    reports: Vec<LevelReport>,
}

/// The flow of a level: the vertices that move, and the constraints.
#[derive(Clone, Debug)]
struct SavedFlow {
    free: Vec<u32>,
    constraints: Vec<(u32, DVec3)>,
    unreached: usize,
}

/// A state of a refinement.
pub(in crate::refine) struct SavedState<'a> {
    pub level: &'a SavedLevel,
    pub points: &'a [DVec3],
    pub control: &'a [DVec3],
    /// Accepted steps from the start of the level.
    pub steps: usize,
}

impl SavedLevel {
    /// Memory that the state does not share with the mesh of its level, in bytes.
    pub fn bytes(&self) -> usize {
        let flow = self.flow.as_ref();
        let flow = flow.map_or(0, |f| 4 * f.free.len() + 32 * f.constraints.len());
        flow + self.previous.len() * size_of::<DVec3>()
    }
}

impl Refinement {
    /// The data needed to return to the current level.
    pub(in crate::refine) fn save_level(&self) -> SavedLevel {
        SavedLevel {
            level: self.level,
            topology: Arc::clone(&self.topology),
            previous: self.points.clone(),
            attributes: Arc::clone(&self.attributes),
            features: self.features.clone(),
            region: self.region.clone(),
            reports: self.levels.clone(),
            flow: self.current.as_ref().map(|level| SavedFlow {
                free: level.flow.problem().interior().to_vec(),
                constraints: level.constraints.clone(),
                unreached: level.unreached,
            }),
        }
    }

    /// Continues from an earlier state with other controls.
    ///
    /// # Errors
    /// No flow can start there with these options; the refinement stays unchanged.
    pub(in crate::refine) fn restore(
        &mut self,
        to: &SavedState<'_>,
        controls: &RefineControls,
    ) -> Result<(), RefineError> {
        let (flow, levels) = (controls.flow(&self.input)?, controls.levels);
        let saved = to.level;
        self.current = match &saved.flow {
            None => None,
            Some(saved_flow) => {
                let splits = levels.saturating_sub(saved.level);
                let triangles: Vec<[u32; 3]> = saved.topology.triangles().collect();
                let (free, constraints) = (&saved_flow.free, &saved_flow.constraints);
                let problem = FlowProblem::new(to.control, &triangles, free, self.radius)?;
                let problem = problem.with_constraints(constraints)?;
                let (unreached, start) = (saved_flow.unreached, Instant::now());
                let constraints = constraints.clone();
                let level = LevelFlow::new(problem, &flow, splits, constraints, unreached, start)?;
                Some(level.counting_from(to.steps))
            }
        };
        (self.flow, self.controls.levels) = (flow, levels);
        self.level = saved.level;
        self.topology = Arc::clone(&saved.topology);
        self.control = to.control.to_vec();
        self.points = match self.current {
            Some(_) => saved.previous.clone(),
            None => to.points.to_vec(),
        };
        self.attributes = Arc::clone(&saved.attributes);
        self.features = saved.features.clone();
        self.region.clone_from(&saved.region);
        self.levels.clone_from(&saved.reports);
        self.is_cancelled = false;
        Ok(())
    }

    /// Ends the refinement at the current shape. Returns the report of the level that this ends.
    pub fn stop(&mut self) -> Option<LevelReport> {
        self.is_cancelled = true;
        let running = self.current.as_mut()?;
        running.flow.cancel();
        Some(self.finish_level())
    }
}
