//! What a live fill says, and how its groups stand.

use crate::mesh::{DVec3, LoopId};
use crate::solver::{End, Outcome, StepRecord};

/// Something that happened to a live fill.
#[derive(Clone, Debug)]
pub enum LiveEvent {
    /// First patches, groups and the first state are there.
    Planned,
    /// A step of a group was attempted.
    Step {
        /// The group.
        group: usize,
        /// How it went.
        record: StepRecord,
    },
    /// New controls are in force.
    ControlsChanged {
        /// Attempts before the change.
        attempt: usize,
    },
    /// A group keeps its old controls.
    ControlsRefused {
        /// The group; `None` for all of them.
        group: Option<usize>,
        /// Why, in plain words.
        text: String,
    },
    /// The fill goes on from an earlier state.
    Rewound {
        /// Attempts, the rewind included.
        attempt: usize,
    },
    /// A group's surface has begun to pass through itself or the mesh.
    Crossing {
        /// The group.
        group: usize,
        /// Where, at one of the places.
        place: DVec3,
        /// [Serial number](crate::fill::State::index) of the last state that was looked at and does not;
        /// states between the two were not looked at.
        last_good: Option<usize>,
        /// Whether the fill pauses: not on its way to the end.
        paused: bool,
        /// How much and where, in plain words.
        text: String,
    },
    /// A group's flow has ended.
    Finished {
        /// The group.
        group: usize,
        /// How it went.
        outcome: Outcome,
    },
    /// A hole has no patch, or a group cannot go on; its last good shape stays.
    Failed {
        /// The group; `None` for a hole without a patch.
        group: Option<usize>,
        /// The loops concerned.
        holes: Vec<LoopId>,
        /// Why, in plain words.
        text: String,
    },
}

/// Why a live fill cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The controls are mistaken.
    #[error(transparent)]
    Controls(#[from] crate::fill::ControlsError),
    /// The system gives no thread.
    #[error("the system gives no thread for the flow: {0}")]
    Thread(String),
}

/// How a group of holes that are solved together stands.
#[derive(Clone, Debug)]
pub struct GroupStatus {
    /// Its loops.
    pub holes: Vec<LoopId>,
    /// Hole radius: the largest of the group.
    pub radius: f64,
    /// Vertices that move.
    pub vertices: usize,
    /// Accepted steps.
    pub step: usize,
    /// Attempted steps.
    pub attempts: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// The time step to come.
    pub tau: f64,
    /// Natural time of the hole; show τ relative to it.
    pub tau_ref: f64,
    /// Energy of the present shape, by the rule of the steps.
    pub energy: f64,
    /// Residual of the last accepted step; `None` before the first.
    pub residual: Option<f64>,
    /// Why it ended, if it has.
    pub end: Option<End>,
    /// Why it cannot go on, if it cannot.
    pub failed: Option<String>,
    /// Warnings in plain words.
    pub warnings: Vec<String>,
    /// Seconds to the end at the rate of the last steps, if that can be told.
    pub eta: Option<f64>,
}
