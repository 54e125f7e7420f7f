//! Events of a fill, and the status of its groups.

use crate::fill::GroupSurface;
use crate::mesh::{DVec3, LoopId};
use crate::solver::{End, Outcome, StepRecord};
use crate::warning::Warning;

/// An event of a fill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum FillEvent {
    /// A step of a group was attempted.
    Step {
        /// The group.
        group: usize,
        /// Its result.
        record: StepRecord,
    },
    /// A group's surface has begun to intersect itself or the mesh. The run pauses.
    SelfIntersection {
        /// The group.
        group: usize,
        /// One of the places.
        place: DVec3,
        /// Accepted steps of the group at the last state that was checked and is free of
        /// intersections. States between that and the current one were not checked.
        last_good: Option<usize>,
        /// The number of intersections and one of the places, in words.
        text: String,
    },
    /// A group's flow has ended.
    Finished {
        /// The group.
        group: usize,
        /// Its result.
        outcome: Outcome,
    },
    /// A patch has a defect or was replaced.
    Warned {
        /// The first loop of its hole.
        hole: LoopId,
        /// What is wrong.
        warning: Warning,
    },
    /// A hole has no patch, or a group cannot continue; its last valid state is kept.
    Failed {
        /// The group; `None` for a hole without a patch.
        group: Option<usize>,
        /// The loops of the group or hole.
        holes: Vec<LoopId>,
        /// The reason, in words.
        text: String,
    },
}

/// The status of a group of holes that are solved together.
#[derive(Clone, Debug)]
pub struct GroupStatus {
    /// Its loops.
    pub holes: Vec<LoopId>,
    /// All loops that the patch of each hole closes.
    pub closed: Vec<Vec<LoopId>>,
    /// Hole radius: the maximum of the group.
    pub radius: f64,
    /// Its surface model.
    pub surface: GroupSurface,
    /// Accepted steps.
    pub step: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Iterations of the linear solver in the last attempted step, if it is iterative.
    pub iterations: Option<usize>,
    /// The next time step.
    pub tau: f64,
    /// Natural time of the hole; show τ relative to it.
    pub tau_ref: f64,
    /// Residual of the last accepted step; `None` before the first.
    pub residual: Option<f64>,
    /// Why it ended, if it has.
    pub end: Option<End>,
    /// Why it cannot continue, if so.
    pub failed: Option<String>,
    /// The holes whose patches are left with defects at its end: they intersect themselves, the mesh or
    /// patches of the group, are folded or far from their rims.
    pub unsound: Vec<LoopId>,
    /// Estimated seconds to the end at the rate of the last steps.
    pub eta: Option<f64>,
}
