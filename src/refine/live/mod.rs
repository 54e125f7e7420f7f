//! A refinement in the background, for an interactive caller.
//!
//! [`LiveRefine::spawn`] starts a thread that begins levels and attempts the steps of their flows.
//! Events come out of a lossless channel ([`LiveRefine::poll`]), shapes go to the
//! [timeline](LiveRefine::timeline); nothing that the caller calls waits for the solver. It is used
//! like [`fill::LiveFill`](../../fill/struct.LiveFill.html).

mod conductor;
mod state;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

pub use crate::live::LiveSettings;
use crate::live::{SharedTimeline, Timeline};
use crate::mesh::Mesh;
use crate::refine::{LevelReport, RefineError, RefineOptions};
use crate::solver::{FlowOptions, StepRecord};
use conductor::{Command, Lines, Message};
pub use state::{LevelFrame, RefineState};

/// Kept states of a refinement: 48 bytes a vertex each, and the connectivity of each level.
pub type RefineTimeline = Timeline<RefineState>;

/// Something that happened to a live refinement.
#[derive(Clone, Debug)]
pub enum RefineEvent {
    /// A level was begun; its first state is in the timeline.
    Level {
        /// From 1.
        level: usize,
        /// Vertices of its mesh.
        vertices: usize,
        /// Triangles.
        faces: usize,
    },
    /// A step of a level's flow was attempted.
    Step {
        /// The level.
        level: usize,
        /// How it went.
        record: StepRecord,
    },
    /// A level is finished; its report has the warnings.
    LevelDone(LevelReport),
    /// Another energy, mode or number of levels is in force.
    OptionsChanged,
    /// The old options stay in force.
    OptionsRefused {
        /// Why, in plain words.
        text: String,
    },
    /// All levels are finished, or it was stopped.
    Finished,
    /// It cannot go on; the last good shape stays.
    Failed {
        /// Why, in plain words.
        text: String,
    },
}

/// How a live refinement stands.
#[derive(Clone, Debug, Default)]
pub struct RefineStatus {
    /// The level under way or finished last; 0 before the first.
    pub level: usize,
    /// Levels there are to be.
    pub levels: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Accepted steps of the level.
    pub step: usize,
    /// Attempted steps of all levels.
    pub attempts: usize,
    /// The time step to come, over the natural time of the mesh; `None` between levels.
    pub relative_tau: Option<f64>,
    /// Energy of the present shape, by the rule of the steps.
    pub energy: Option<f64>,
    /// Residual of the last accepted step of the level.
    pub residual: Option<f64>,
    /// Whether it has ended.
    pub ended: bool,
    /// Why it cannot go on, if it cannot.
    pub failed: Option<String>,
}

/// A refinement running in the background. Dropping it cancels: the call returns at once, and the
/// thread ends within one step.
pub struct LiveRefine {
    mesh: Arc<Mesh>,
    commands: Sender<Command>,
    messages: Receiver<Message>,
    timeline: SharedTimeline<RefineState>,
    cancelled: Arc<AtomicBool>,
    playing: AtomicBool,
    status: RefineStatus,
    records: Vec<(usize, StepRecord)>,
    levels: Vec<LevelReport>,
}

impl LiveRefine {
    /// Starts the refinement of a mesh. `wake` is called whenever there is something to
    /// [poll](Self::poll), from the background thread.
    ///
    /// # Errors
    /// Options out of range, a mesh without triangles, or no thread to be had.
    pub fn spawn(
        mesh: Arc<Mesh>,
        options: RefineOptions,
        settings: LiveSettings,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Result<Self, RefineError> {
        options.validate(&mesh)?;
        let levels = options.levels;
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
        let given = Arc::clone(&mesh);
        std::thread::Builder::new()
            .name("meniscus-refine".into())
            .spawn(move || conductor::run(given, options, settings, lines))
            .map_err(|error| RefineError::Thread(error.to_string()))?;
        Ok(Self {
            mesh,
            commands,
            messages,
            timeline,
            cancelled,
            playing: AtomicBool::new(settings.playing),
            status: RefineStatus {
                levels,
                ..RefineStatus::default()
            },
            records: Vec::new(),
            levels: Vec::new(),
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

    /// Stops after the present step and waits.
    pub fn pause(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Pause);
    }

    /// Does one thing (begins a level, attempts a step, or finishes a level), then waits.
    pub fn step(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Step);
    }

    /// Goes on to the end of the last level in fast mode with an adaptive time step, unpaced.
    pub fn finish(&self) {
        self.playing.store(true, Ordering::Relaxed);
        self.send(Command::Finish);
    }

    /// Ends the refinement at the present shape.
    pub fn stop(&self) {
        self.send(Command::Stop);
    }

    /// Steps a second at most; `None` as fast as they come.
    pub fn set_pace(&self, pace: Option<f64>) {
        self.send(Command::Pace(pace));
    }

    /// Changes energy, mode, τ, tension or steps; the level under way goes on from its shape. What
    /// the surface at hand does not admit comes back as [`RefineEvent::OptionsRefused`].
    ///
    /// # Errors
    /// Mistaken options; the refinement goes on as before.
    pub fn set_flow(&self, flow: FlowOptions) -> Result<(), RefineError> {
        flow.validate()?;
        self.send(Command::Flow(Box::new(flow)));
        Ok(())
    }

    /// Changes how many levels there are to be; those done stay. One that had ended goes on if there
    /// are to be more, unless it was [stopped](Self::stop).
    pub fn set_levels(&self, levels: usize) {
        self.send(Command::Levels(levels));
    }

    /// What happened since the last call; never waits for the solver.
    pub fn poll(&mut self) -> Vec<RefineEvent> {
        let mut events = Vec::new();
        while let Ok(message) = self.messages.try_recv() {
            match message {
                Message::Status(status) => self.status = *status,
                Message::Event(event) => {
                    match &event {
                        RefineEvent::Step { level, record } => {
                            self.records.push((*level, record.clone()));
                        }
                        RefineEvent::Failed { text } => {
                            self.status.ended = true;
                            self.status.failed = Some(text.clone());
                        }
                        RefineEvent::LevelDone(report) => self.levels.push(report.clone()),
                        _ => {}
                    }
                    events.push(event);
                }
            }
        }
        events
    }

    /// How it stands as of the last [`Self::poll`].
    pub fn status(&self) -> &RefineStatus {
        &self.status
    }

    /// Every attempted step with its level, as of the last [`Self::poll`].
    pub fn records(&self) -> &[(usize, StepRecord)] {
        &self.records
    }

    /// Reports of the finished levels, as of the last [`Self::poll`].
    pub fn levels(&self) -> &[LevelReport] {
        &self.levels
    }

    /// The kept states, oldest first, beginning with the mesh as it was given; the first and the
    /// latest are always there. Empty until the thread has started.
    pub fn timeline(&self) -> Arc<RefineTimeline> {
        self.timeline.now()
    }

    /// Whether it runs (or would, had it not ended) or waits.
    pub fn playing(&self) -> bool {
        self.playing.load(Ordering::Relaxed)
    }

    /// Whether it had ended (or failed) at the last [`Self::poll`].
    pub fn ended(&self) -> bool {
        self.status.ended
    }

    /// The refined mesh at a state.
    pub fn mesh_at(&self, state: &RefineState) -> Mesh {
        state.mesh(&self.mesh)
    }
}

impl Drop for LiveRefine {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}
