//! A flow on its own thread: commands in, events and the latest snapshot out.
//!
//! Events are a lossless channel; the snapshot is overwritten, so that a viewer that is slow never
//! holds the solver up. Dropping the handle cancels the flow and waits for its thread, which takes
//! at most one step.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

use arc_swap::ArcSwap;

use crate::mesh::DVec3;
use crate::solver::flow::{Flow, FlowOptions, Outcome, StepRecord};
use crate::solver::{FlowProblem, SolverError};

/// What a running flow can be told. Each takes effect before the next step.
#[derive(Clone, Debug)]
pub enum Command {
    /// Go on until the end.
    Play,
    /// Stop after the current step and wait.
    Pause,
    /// Attempt one step, then wait.
    Step,
    /// Go on with other options from the current shape.
    Options(Box<FlowOptions>),
    /// End; the current shape is the result.
    Cancel,
}

/// What a running flow says.
#[derive(Clone, Debug)]
pub enum Event {
    /// A step was attempted.
    Step(StepRecord),
    /// The options were changed after this many steps.
    OptionsChanged {
        /// Accepted steps before the change.
        step: usize,
    },
    /// New options were refused; the old ones are in force.
    OptionsRefused(SolverError),
    /// The flow has ended; nothing follows unless it is played on with other options.
    Finished(Outcome),
    /// The flow cannot go on; the last snapshot is the last good shape. Nothing follows.
    Failed(SolverError),
}

/// The latest shape.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Accepted steps.
    pub step: usize,
    /// Positions of the interior vertices in the mesh's own coordinates, in the problem's order.
    pub interior: Vec<DVec3>,
}

/// A flow running in the background.
pub struct FlowHandle {
    commands: Sender<Command>,
    events: Receiver<Event>,
    snapshot: Arc<ArcSwap<Snapshot>>,
    thread: Option<JoinHandle<()>>,
}

impl FlowHandle {
    /// Sends a command. Returns `false` if the flow is over.
    pub fn send(&self, command: Command) -> bool {
        self.commands.send(command).is_ok()
    }

    /// Events so far, without waiting.
    pub fn events(&self) -> impl Iterator<Item = Event> + '_ {
        self.events.try_iter()
    }

    /// Waits for the next event; `None` once the flow is over and all events were taken.
    pub fn wait(&self) -> Option<Event> {
        self.events.recv().ok()
    }

    /// The latest shape.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        self.snapshot.load_full()
    }
}

impl Drop for FlowHandle {
    fn drop(&mut self) {
        self.send(Command::Cancel);
        if let Some(thread) = self.thread.take() {
            // a panic in it has been reported as an event
            thread.join().ok();
        }
    }
}

/// Starts a flow on a thread of its own. `playing` decides whether it runs at once or waits for
/// [`Command::Play`]; `wake` is called after every event.
///
/// # Errors
/// If the system gives no thread.
pub fn spawn(
    problem: FlowProblem,
    options: FlowOptions,
    playing: bool,
    wake: impl Fn() + Send + 'static,
) -> std::io::Result<FlowHandle> {
    let (commands, inbox) = channel();
    let (outbox, events) = channel();
    let snapshot = Arc::new(ArcSwap::from_pointee(Snapshot {
        step: 0,
        interior: problem.to_world(problem.positions()),
    }));
    let worker = Worker {
        inbox,
        outbox,
        snapshot: Arc::clone(&snapshot),
        wake,
        playing,
        steps: 0,
    };
    let thread = std::thread::Builder::new()
        .name("meniscus-flow".into())
        .spawn(move || worker.run(problem, options))?;
    Ok(FlowHandle {
        commands,
        events,
        snapshot,
        thread: Some(thread),
    })
}

struct Worker<W> {
    inbox: Receiver<Command>,
    outbox: Sender<Event>,
    snapshot: Arc<ArcSwap<Snapshot>>,
    wake: W,
    playing: bool,
    steps: usize,
}

impl<W: Fn()> Worker<W> {
    fn run(mut self, problem: FlowProblem, options: FlowOptions) {
        let ended = catch_unwind(AssertUnwindSafe(|| self.work(problem, options)));
        match ended {
            Ok(Ok(())) => {}
            Ok(Err(error)) => self.say(Event::Failed(error)),
            Err(panic) => {
                let text = panic
                    .downcast_ref::<&str>()
                    .map(|s| (*s).to_owned())
                    .or_else(|| panic.downcast_ref::<String>().cloned())
                    .unwrap_or_else(|| "unknown panic".into());
                self.say(Event::Failed(SolverError::Panic(text)));
            }
        }
    }

    fn say(&self, event: Event) {
        // nobody listening means that the handle is being dropped
        self.outbox.send(event).ok();
        (self.wake)();
    }

    fn work(&mut self, problem: FlowProblem, options: FlowOptions) -> Result<(), SolverError> {
        let mut flow = Flow::new(problem, options)?;
        loop {
            let command = if self.playing && flow.end().is_none() {
                match self.inbox.try_recv() {
                    Ok(command) => Some(command),
                    Err(TryRecvError::Empty) => None,
                    Err(TryRecvError::Disconnected) => return Ok(()),
                }
            } else {
                match self.inbox.recv() {
                    Ok(command) => Some(command),
                    Err(_) => return Ok(()),
                }
            };
            match command {
                Some(Command::Cancel) => {
                    if flow.end().is_none() {
                        flow.cancel();
                        self.say(Event::Finished(flow.outcome()));
                    }
                    return Ok(());
                }
                Some(Command::Pause) => self.playing = false,
                Some(Command::Play) => self.playing = true,
                Some(Command::Step) => {
                    self.playing = false;
                    self.step(&mut flow)?;
                }
                Some(Command::Options(options)) => match flow.set_options(*options) {
                    Ok(()) => self.say(Event::OptionsChanged { step: self.steps }),
                    Err(error) => self.say(Event::OptionsRefused(error)),
                },
                None => self.step(&mut flow)?,
            }
        }
    }

    fn step(&mut self, flow: &mut Flow) -> Result<(), SolverError> {
        if let Some(record) = flow.step()? {
            if !record.rejected {
                self.steps = record.step;
                self.snapshot.store(Arc::new(Snapshot {
                    step: record.step,
                    interior: flow.problem().to_world(flow.positions()),
                }));
            }
            self.say(Event::Step(record));
            if flow.end().is_some() {
                self.say(Event::Finished(flow.outcome()));
            }
        } else if flow.end().is_some() && self.playing {
            // nothing to move at all
            self.playing = false;
            self.say(Event::Finished(flow.outcome()));
        }
        Ok(())
    }
}
