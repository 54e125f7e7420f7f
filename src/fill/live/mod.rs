//! A fill in the background, for an interactive caller.
//!
//! [`LiveFill::spawn`] starts a thread that makes the plan and then lets all groups of holes attempt
//! their steps together, round by round. Events come out of a lossless channel
//! ([`LiveFill::poll`]), shapes go to the [`Timeline`]; nothing that the caller calls waits for the
//! solver. Everything that changes the course of the flow is recorded: the
//! [schedule](LiveFill::schedule) and the controls at the start repeat the fill to the bit
//! ([`ScheduledOptions`](crate::fill::ScheduledOptions)).

mod command;
mod conductor;
mod events;
mod group;
mod state;
mod timeline;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::fill::schedule::{Course, Item};
use crate::fill::{Controls, ControlsError, Row, Schedule};
use crate::mesh::{BoundaryLoop, Mesh};
use crate::solver::StepRecord;

pub use crate::live::LiveSettings;
use crate::live::SharedTimeline;
pub use command::command_line;
use conductor::{Command, Kind, Lines, Message, Task};
pub use events::{GroupStatus, LiveError, LiveEvent};
pub use state::{GroupState, State};
pub use timeline::Timeline;

/// A fill running in the background. Dropping it cancels: the call returns at once, and the thread
/// ends within one step.
pub struct LiveFill {
    mesh: Arc<Mesh>,
    start: Controls,
    /// The controls asked for last.
    asked: Controls,
    commands: Sender<Command>,
    messages: Receiver<Message>,
    timeline: SharedTimeline<State>,
    cancelled: Arc<AtomicBool>,
    playing: AtomicBool,
    statuses: Vec<GroupStatus>,
    records: Vec<Vec<StepRecord>>,
    ended: bool,
}

impl LiveFill {
    /// Starts the fill of the given loops of a mesh, each with the islands in it. `wake` is called
    /// whenever there is something to [poll](Self::poll), from the background thread.
    ///
    /// # Errors
    /// Mistaken controls, or no thread to be had.
    pub fn spawn(
        mesh: Arc<Mesh>,
        loops: Vec<BoundaryLoop>,
        controls: Controls,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, LiveError> {
        Self::start(mesh, loops, Kind::Holes, controls, settings, wake)
    }

    /// Starts the blend of the given loops of a mesh: one patch joins them all.
    ///
    /// # Errors
    /// As [`Self::spawn`].
    pub fn spawn_blend(
        mesh: Arc<Mesh>,
        loops: Vec<BoundaryLoop>,
        controls: Controls,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, LiveError> {
        Self::start(mesh, loops, Kind::Blend, controls, settings, wake)
    }

    /// Starts the fairing of the selected faces (one flag each): their inner vertices flow, the
    /// triangles stay. A selection without inner vertices comes back as [`LiveEvent::Failed`].
    ///
    /// # Errors
    /// As [`Self::spawn`].
    pub fn spawn_fair(
        mesh: Arc<Mesh>,
        selected: Vec<bool>,
        controls: Controls,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, LiveError> {
        let kind = Kind::Fair(selected);
        Self::start(mesh, Vec::new(), kind, controls, settings, wake)
    }

    fn start(
        mesh: Arc<Mesh>,
        mut loops: Vec<BoundaryLoop>,
        kind: Kind,
        controls: Controls,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, LiveError> {
        controls.options()?;
        // as the command line takes them
        loops.sort_by_key(|l| l.id);
        loops.dedup_by_key(|l| l.id);
        let (commands, inbox) = channel();
        let (outbox, messages) = channel();
        let timeline = SharedTimeline::new(settings.timeline_bytes);
        let cancelled = Arc::new(AtomicBool::new(false));
        let lines = Lines {
            inbox,
            outbox,
            timeline: timeline.clone(),
            cancelled: Arc::clone(&cancelled),
            wake,
        };
        let task = Task {
            mesh: Arc::clone(&mesh),
            loops,
            kind,
            course: Course::new(controls.clone()),
            playing: settings.playing,
            pace: settings.pace,
        };
        std::thread::Builder::new()
            .name("meniscus-fill".into())
            .spawn(move || conductor::run(task, lines))
            .map_err(|error| LiveError::Thread(error.to_string()))?;
        Ok(Self {
            mesh,
            asked: controls.clone(),
            start: controls,
            commands,
            messages,
            timeline,
            cancelled,
            playing: AtomicBool::new(settings.playing),
            statuses: Vec::new(),
            records: Vec::new(),
            ended: false,
        })
    }

    fn send(&self, command: Command) {
        // a thread that is gone has said why
        self.commands.send(command).ok();
    }

    /// Goes on until the end.
    pub fn play(&self) {
        self.playing.store(true, Ordering::Relaxed);
        self.send(Command::Play);
    }

    /// Stops after the present round and waits.
    pub fn pause(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Pause);
    }

    /// Attempts one step of every group, then waits.
    pub fn step(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Step);
    }

    /// Goes on to the stationary shape in fast mode with an adaptive time step, unpaced; recorded.
    pub fn finish(&mut self) {
        self.playing.store(true, Ordering::Relaxed);
        self.send(Command::Item(Item::Finish));
    }

    /// Ends the flow at the present shape; recorded.
    pub fn stop(&mut self) {
        self.send(Command::Item(Item::Stop));
    }

    /// Changes controls before the next step; recorded. What the surface at hand does not admit
    /// comes back as [`LiveEvent::ControlsRefused`].
    ///
    /// # Errors
    /// Mistaken controls; the fill goes on as before.
    pub fn set_controls(&mut self, controls: &Controls) -> Result<(), ControlsError> {
        if *controls == self.asked {
            return Ok(());
        }
        controls.options()?;
        self.asked = controls.clone();
        self.send(Command::Item(Item::Controls(Box::new(controls.clone()))));
        Ok(())
    }

    /// Rounds a second at most; `None` as fast as they come.
    pub fn set_pace(&self, pace: Option<f64>) {
        self.send(Command::Pace(pace));
    }

    /// Goes on from a kept state, named by [`State::index`]; recorded. `false` if it is not kept.
    ///
    /// Nothing is thrown away: the timeline goes on with that state's shape as its latest. If the
    /// fill is paused it stays so.
    pub fn rewind_to(&mut self, state: usize) -> bool {
        let Some(state) = self.timeline().find(state).cloned() else {
            return false;
        };
        self.send(Command::Rewind(state));
        true
    }

    /// What happened since the last call; never waits for the solver.
    pub fn poll(&mut self) -> Vec<LiveEvent> {
        let mut events = Vec::new();
        while let Ok(message) = self.messages.try_recv() {
            match message {
                Message::Statuses(statuses, ended) => {
                    self.statuses = statuses;
                    self.ended = ended;
                }
                Message::Event(event) => {
                    if let LiveEvent::Step { group, record } = &event {
                        if self.records.len() <= *group {
                            self.records.resize_with(group + 1, Vec::new);
                        }
                        self.records[*group].push(record.clone());
                    }
                    events.push(event);
                }
            }
        }
        events
    }

    /// How each group of holes stands as of the last [`Self::poll`]; empty until the plan is made.
    pub fn groups(&self) -> &[GroupStatus] {
        &self.statuses
    }

    /// Every attempted step of a group as of the last [`Self::poll`].
    pub fn records(&self, group: usize) -> &[StepRecord] {
        self.records.get(group).map_or(&[], Vec::as_slice)
    }

    /// The kept states, oldest first; the first and the latest are always there. Empty until the
    /// plan is made.
    pub fn timeline(&self) -> Arc<Timeline> {
        self.timeline.now()
    }

    /// Whether it runs (or would, had it not ended) or waits.
    pub fn playing(&self) -> bool {
        self.playing.load(Ordering::Relaxed)
    }

    /// Whether every group had ended at the last [`Self::poll`].
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// The controls the fill was started with.
    pub fn start_controls(&self) -> &Controls {
        &self.start
    }

    /// The controls asked for last.
    pub fn controls(&self) -> &Controls {
        &self.asked
    }

    /// What repeats the fill up to its latest state.
    pub fn schedule(&self) -> Schedule {
        match self.timeline().latest() {
            Some(state) => self.schedule_to(state),
            None => Schedule::default(),
        }
    }

    /// What repeats the fill up to one of its states.
    pub fn schedule_to(&self, state: &State) -> Schedule {
        let mut rows = state.rows.to_vec();
        if !state.ended {
            rows.push(Row {
                attempt: state.attempt,
                control: "stop".into(),
                value: String::new(),
            });
        }
        Schedule { rows }
    }

    /// The whole filled mesh at a state, the old part first.
    pub fn mesh_at(&self, state: &State) -> Mesh {
        state.mesh(&self.mesh)
    }
}

impl Drop for LiveFill {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}
