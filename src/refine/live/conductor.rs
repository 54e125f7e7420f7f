//! The background thread of a live refinement.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use crate::live::{LiveSettings, SharedTimeline, on_own_pool, until_next_round};
use crate::mesh::{DVec3, Mesh};
use crate::refine::live::{LevelFrame, RefineEvent, RefineState, RefineStatus};
use crate::refine::{Method, Progress, RefineError, RefineOptions, Refinement};
use crate::solver::{FlowOptions, Mode, StepRecord, Tau, panic_text};

/// What the handle tells the thread.
#[derive(Debug)]
pub(super) enum Command {
    Play,
    Pause,
    Step,
    Finish,
    Stop,
    Pace(Option<f64>),
    Flow(Box<FlowOptions>),
    Levels(usize),
}

/// What the thread tells the handle.
#[derive(Debug)]
pub(super) enum Message {
    Event(RefineEvent),
    Status(Box<RefineStatus>),
}

/// Ways to the handle and back.
pub(super) struct Lines {
    pub inbox: Receiver<Command>,
    pub outbox: Sender<Message>,
    pub timeline: SharedTimeline<RefineState>,
    pub cancelled: Arc<AtomicBool>,
    pub wake: Arc<dyn Fn() + Send + Sync>,
}

impl Lines {
    fn send(&self, message: Message) {
        // nobody listening means that the handle was dropped
        self.outbox.send(message).ok();
    }

    fn say(&self, event: RefineEvent) {
        self.send(Message::Event(event));
    }
}

/// Runs a refinement until its handle is dropped.
pub(super) fn run(mesh: Arc<Mesh>, options: RefineOptions, settings: LiveSettings, lines: Lines) {
    let (outbox, wake) = (lines.outbox.clone(), Arc::clone(&lines.wake));
    let work = move || {
        let refinement = Refinement::new(mesh, options)?;
        Conductor::new(refinement, settings, &lines).run()
    };
    let text = match on_own_pool(work) {
        Ok(Ok(())) => return,
        Ok(Err(error)) => error.to_string(),
        Err(panic) => panic_text(&*panic),
    };
    outbox
        .send(Message::Event(RefineEvent::Failed { text }))
        .ok();
    wake();
}

struct Conductor<'a> {
    lines: &'a Lines,
    refinement: Refinement,
    frame: Arc<LevelFrame>,
    /// Attempts so far.
    clock: usize,
    next_index: usize,
    status: RefineStatus,
    playing: bool,
    /// Whether one step is asked for.
    single: bool,
    /// Whether steps follow each other without a pace, towards the end.
    hurry: bool,
    pace: Option<f64>,
    last_round: Instant,
}

impl<'a> Conductor<'a> {
    fn new(refinement: Refinement, settings: LiveSettings, lines: &'a Lines) -> Self {
        Self {
            lines,
            frame: Arc::new(LevelFrame::of(&refinement)),
            clock: 0,
            next_index: 0,
            status: RefineStatus {
                ended: refinement.is_finished(),
                ..RefineStatus::default()
            },
            refinement,
            playing: settings.playing,
            single: false,
            hurry: false,
            pace: settings.pace,
            last_round: Instant::now(),
        }
    }

    fn run(mut self) -> Result<(), RefineError> {
        self.show(None);
        self.tell();
        loop {
            if self.lines.cancelled.load(Ordering::Relaxed) {
                return Ok(());
            }
            let idle = self.status.ended;
            // a step asked for where none is left is none
            self.single &= !idle;
            let due = if idle || !(self.playing || self.single) {
                None
            } else if self.single || self.hurry {
                Some(Duration::ZERO)
            } else {
                Some(until_next_round(self.pace, self.last_round))
            };
            let command = match due {
                Some(due) => self.lines.inbox.recv_timeout(due),
                None => (self.lines.inbox.recv()).map_err(|_| RecvTimeoutError::Disconnected),
            };
            match command {
                Ok(command) => self.obey(command),
                Err(RecvTimeoutError::Timeout) => self.round()?,
                // the handle is gone
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::Play => self.playing = true,
            Command::Pause => (self.playing, self.hurry) = (false, false),
            Command::Step => (self.playing, self.single) = (false, true),
            Command::Pace(pace) => self.pace = pace,
            Command::Flow(flow) => self.change(*flow),
            Command::Levels(levels) => {
                self.refinement.set_levels(levels);
                self.lines.say(RefineEvent::OptionsChanged);
                self.tell();
            }
            Command::Finish => {
                (self.playing, self.hurry) = (true, true);
                let mut flow = self.refinement.options().flow.clone();
                if (flow.mode, flow.tau) != (Mode::Fast, Tau::Auto) {
                    (flow.mode, flow.tau) = (Mode::Fast, Tau::Auto);
                    self.change(flow);
                }
            }
            Command::Stop => {
                // what is under way is still to be finished
                self.refinement.cancel();
                (self.playing, self.hurry) = (true, true);
                self.tell();
            }
        }
    }

    fn change(&mut self, flow: FlowOptions) {
        self.lines.say(match self.refinement.set_flow(flow) {
            Ok(()) => RefineEvent::OptionsChanged,
            Err(error) => RefineEvent::OptionsRefused {
                text: error.to_string(),
            },
        });
        self.tell();
    }

    /// Does one thing.
    fn round(&mut self) -> Result<(), RefineError> {
        self.last_round = Instant::now();
        self.single = false;
        let level = self.refinement.level() + 1;
        match self.refinement.step()? {
            Some(Progress::Level(level)) => {
                self.frame = Arc::new(LevelFrame::of(&self.refinement));
                self.status.step = 0;
                self.status.residual = None;
                self.show(None);
                self.lines.say(RefineEvent::Level {
                    level,
                    vertices: self.refinement.vertex_count(),
                    faces: self.frame.topology.face_count(),
                });
                if self.refinement.flow().is_none() {
                    self.level_done();
                }
            }
            Some(Progress::Step(record)) => {
                self.clock += 1;
                if !record.rejected {
                    self.status.step = record.step;
                    self.status.residual = Some(record.residual);
                    self.show(Some(&record));
                }
                let level = level - 1;
                self.lines.say(RefineEvent::Step { level, record });
            }
            Some(Progress::Finished(_)) => self.level_done(),
            None => {}
        }
        self.tell();
        Ok(())
    }

    fn level_done(&mut self) {
        if let Some(report) = self.refinement.levels().last() {
            self.lines.say(RefineEvent::LevelDone(report.clone()));
        }
    }

    /// Puts the present shape into the timeline.
    fn show(&mut self, record: Option<&StepRecord>) {
        let control: Arc<[DVec3]> = self.refinement.control().into();
        let points = if self.refinement.options().method == Method::Pde {
            self.refinement.points().into()
        } else {
            Arc::clone(&control)
        };
        let state = Arc::new(RefineState {
            index: self.next_index,
            attempt: self.clock,
            step: record.map_or(0, |r| r.step),
            frame: Arc::clone(&self.frame),
            points,
            control,
            energy: record.map_or(f64::NAN, |r| r.energy),
            residual: record.map(|r| r.residual),
            tau: record.map_or(0.0, |r| r.tau),
        });
        self.next_index += 1;
        self.lines.timeline.push(state);
    }

    /// Tells the handle how things stand and, once, that they have ended, and wakes whoever waits.
    fn tell(&mut self) {
        let refinement = &self.refinement;
        let ended = refinement.is_finished();
        if ended && !self.status.ended {
            self.hurry = false;
            self.lines.say(RefineEvent::Finished);
        }
        let flow = refinement.flow();
        self.status.ended = ended;
        self.status.level = refinement.level();
        self.status.levels = refinement.options().levels;
        self.status.vertices = refinement.vertex_count();
        self.status.attempts = self.clock;
        self.status.relative_tau = flow.map(|f| f.tau() / f.tau_ref());
        self.status.energy = flow.map(|f| f.energy().value);
        self.lines
            .send(Message::Status(Box::new(self.status.clone())));
        (self.lines.wake)();
    }
}
