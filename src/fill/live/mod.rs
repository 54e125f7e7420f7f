//! A fill in the background, for an interactive caller.

mod events;
mod state;

use std::path::Path;
use std::sync::Arc;

use crate::fill::{Controls, ControlsError, FillError, Schedule};
use crate::mesh::{BoundaryLoop, Mesh};
use crate::solver::StepRecord;

pub use events::{GroupStatus, LiveError, LiveEvent};
pub use state::{GroupState, HoleLayout, Layout, State, Timeline};

/// How a live fill starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveSettings {
    /// Whether it runs at once or waits for [`LiveFill::play`].
    pub playing: bool,
    /// States a second at most; `None` as fast as they come.
    pub pace: Option<f64>,
    /// Bytes the kept states may take.
    pub timeline_bytes: usize,
}

/// A fill running in the background. Dropping it cancels.
pub struct LiveFill {
    timeline: Arc<Timeline>,
    statuses: Vec<GroupStatus>,
}

#[expect(
    clippy::todo,
    clippy::missing_errors_doc,
    unused_variables,
    reason = "next commit"
)]
impl LiveFill {
    /// Starts the fill of the given loops.
    pub fn spawn(
        mesh: Arc<Mesh>,
        loops: Vec<BoundaryLoop>,
        controls: Controls,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, LiveError> {
        todo!()
    }

    /// Goes on until the end.
    pub fn play(&self) {
        todo!()
    }

    /// Stops after the current step.
    pub fn pause(&self) {
        todo!()
    }

    /// Attempts one step of every group, then waits.
    pub fn step(&self) {
        todo!()
    }

    /// Goes to the stationary shape in fast mode, unpaced; recorded.
    pub fn finish(&mut self) {
        todo!()
    }

    /// Ends the flow here; recorded.
    pub fn stop(&mut self) {
        todo!()
    }

    /// Changes controls before the next step; recorded. What the surface refuses comes back as
    /// [`LiveEvent::ControlsRefused`].
    pub fn set_controls(&mut self, controls: &Controls) -> Result<(), ControlsError> {
        todo!()
    }

    /// States a second at most; `None` as fast as they come.
    pub fn set_pace(&self, pace: Option<f64>) {
        todo!()
    }

    /// Goes on from a kept state, named by [`State::index`]; recorded. `false` if it is not kept.
    /// Nothing is thrown away: the timeline goes on with a copy of that state.
    pub fn rewind_to(&mut self, state: usize) -> bool {
        todo!()
    }

    /// What happened since the last call; never waits for the solver.
    pub fn poll(&mut self) -> Vec<LiveEvent> {
        todo!()
    }

    /// How each group of holes stands; empty until the plan is made.
    pub fn groups(&self) -> &[GroupStatus] {
        &self.statuses
    }

    /// Every attempted step of a group.
    pub fn records(&self, group: usize) -> &[StepRecord] {
        todo!()
    }

    /// The kept states, oldest first; the first and the latest are always there.
    pub fn timeline(&self) -> Arc<Timeline> {
        Arc::clone(&self.timeline)
    }

    /// Whether it runs or waits.
    pub fn playing(&self) -> bool {
        todo!()
    }

    /// Whether every group has ended.
    pub fn ended(&self) -> bool {
        todo!()
    }

    /// The controls the fill was started with.
    pub fn start_controls(&self) -> &Controls {
        todo!()
    }

    /// What repeats the fill up to where it is now.
    pub fn schedule(&self) -> Schedule {
        todo!()
    }

    /// What repeats the fill up to a state.
    pub fn schedule_to(&self, state: &State) -> Schedule {
        todo!()
    }

    /// The whole filled mesh at a state, the old part first.
    pub fn mesh_at(&self, state: &State) -> Result<Mesh, FillError> {
        todo!()
    }
}

/// The command that repeats a fill: quoted for a POSIX shell.
#[expect(clippy::todo, unused_variables, reason = "next commit")]
pub fn command_line(
    input: &Path,
    output: &Path,
    loops: &[usize],
    controls: &Controls,
    schedule: Option<&Path>,
) -> String {
    todo!()
}
