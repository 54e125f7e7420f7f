//! The thread of a run in the background.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::cancel::is_cancelled;
use crate::runner::channels::{Channels, Command, Message};
use crate::runner::schedule::{ActiveControls, UserCommand};
use crate::runner::{
    Change, Event, Process, RunSettings, ScheduleEntry, Snapshot, TimelineState, panic_text,
};

/// Constructs a process and runs it until its handle is dropped.
///
/// The work runs on its own thread pool, so that no other work waits for a long step.
pub(super) fn run<P: Process, E: Display>(
    set_up: impl FnOnce() -> Result<P, E> + Send,
    controls: P::Controls,
    settings: RunSettings,
    channels: Channels<P>,
) where
    P::State: TimelineState + Send + Sync,
    P::Event: Send,
    P::Status: Send,
{
    let (messages, wake) = (channels.messages.clone(), Arc::clone(&channels.wake));
    let cancel = Arc::clone(&channels.cancel);
    let work = move || {
        let process = set_up().map_err(|error| error.to_string())?;
        if is_cancelled() {
            return Ok(());
        }
        let worker = Worker::new(process, controls, settings, channels);
        worker.run().map_err(|error| error.to_string())
    };
    let result = catch_unwind(AssertUnwindSafe(|| cancel.install(work)));
    let text = match result {
        Ok(Ok(())) => return,
        Ok(Err(text)) => text,
        Err(panic) => panic_text(&*panic),
    };
    messages.send(Message::Event(Event::Failed { text })).ok();
    wake();
}

struct Worker<P: Process> {
    process: P,
    channels: Channels<P>,
    controls: ActiveControls<P::Controls>,
    /// Changes so far.
    entries: Arc<Vec<ScheduleEntry>>,
    /// Controls set since the last step.
    pending: Option<Box<P::Controls>>,
    /// Actions so far.
    clock: usize,
    next_serial: usize,
    latest: Option<Arc<Snapshot<P::State>>>,
    playing: bool,
    /// Whether to take a single step.
    step_once: bool,
    /// Whether to run to the end without a pace limit.
    fast_forward: bool,
    pace: Option<f64>,
    last_step: Instant,
    /// Time per step at the current pace.
    seconds: f64,
    end_reported: bool,
}

impl<P: Process> Worker<P>
where
    P::State: TimelineState,
{
    fn new(
        process: P,
        controls: P::Controls,
        settings: RunSettings,
        channels: Channels<P>,
    ) -> Self {
        Self {
            process,
            channels,
            controls: ActiveControls::new(controls),
            entries: Arc::default(),
            pending: None,
            clock: 0,
            next_serial: 0,
            latest: None,
            playing: settings.playing,
            step_once: false,
            fast_forward: false,
            pace: settings.pace,
            last_step: Instant::now(),
            seconds: 0.0,
            end_reported: false,
        }
    }

    fn run(mut self) -> Result<(), P::Error> {
        self.push_state()?;
        self.channels.emit(Event::Started);
        self.publish_status();
        loop {
            if is_cancelled() {
                return Ok(());
            }
            let idle = self.pending.is_none() && self.process.ended();
            self.step_once &= !idle;
            let due = if idle || !(self.playing || self.step_once) {
                None
            } else if self.step_once || self.fast_forward {
                Some(Duration::ZERO)
            } else {
                Some(self.period().saturating_sub(self.last_step.elapsed()))
            };
            let commands = &self.channels.commands;
            let command = match due {
                Some(due) => commands.recv_timeout(due),
                None => commands.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match command {
                Ok(command) => self.handle(command)?,
                Err(RecvTimeoutError::Timeout) => self.step()?,
                // the handle was dropped
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }

    /// Minimum time between the starts of two steps.
    fn period(&self) -> Duration {
        Duration::from_secs_f64(self.pace.map_or(0.0, |pace| 1.0 / pace.max(1e-3)))
    }

    fn handle(&mut self, command: Command<P>) -> Result<(), P::Error> {
        match command {
            Command::Play => self.playing = true,
            Command::Pause => (self.playing, self.fast_forward) = (false, false),
            Command::Step => (self.playing, self.step_once) = (false, true),
            Command::Pace(pace) => self.pace = pace,
            // replaces earlier ones that have not acted yet
            Command::Controls(controls) => self.pending = Some(controls),
            Command::Finish => {
                self.apply_pending();
                (self.playing, self.fast_forward) = (true, true);
                self.apply(&UserCommand::Finish, None);
                self.publish_status();
            }
            Command::Stop => {
                self.apply_pending();
                self.fast_forward = false;
                self.apply(&UserCommand::Stop, None);
                self.publish_status();
            }
            Command::Rewind(to) => {
                self.apply_pending();
                self.fast_forward = false;
                self.apply(&UserCommand::Rewind(to.clock), Some(&to.state));
                self.push_state()?;
                self.channels.emit(Event::Rewound { clock: self.clock });
                self.publish_status();
            }
        }
        Ok(())
    }

    fn apply_pending(&mut self) {
        if let Some(controls) = self.pending.take() {
            self.apply(&UserCommand::Controls(controls), None);
        }
    }

    /// Records a command and changes the process; `state` is the target of a rewind.
    fn apply(&mut self, command: &UserCommand<P::Controls>, state: Option<&Arc<P::State>>) {
        let (entries, change) = self.controls.take(self.clock, command);
        Arc::make_mut(&mut self.entries).extend(entries);
        let Some(change) = change else { return };
        let clock = self.clock;
        let refused = match (&change, state) {
            (Change::Controls(controls), _) => self.process.set_controls(controls),
            (Change::Rewind { controls, .. }, Some(state)) => {
                self.clock += 1;
                self.process.rewind(state, controls)
            }
            (Change::Rewind { .. }, None) => Vec::new(),
            (Change::Stop, _) => {
                let channels = &self.channels;
                self.process
                    .stop(&mut |event| channels.emit(Event::Process(event)));
                Vec::new()
            }
        };
        if matches!(change, Change::Controls(_)) && refused.is_empty() {
            self.channels.emit(Event::ControlsChanged { clock });
        }
        for refused in refused {
            self.channels.emit(Event::Refused(refused));
        }
    }

    fn step(&mut self) -> Result<(), P::Error> {
        self.last_step = Instant::now();
        self.step_once = false;
        self.apply_pending();
        self.clock += 1;
        let mut events = Vec::new();
        self.process
            .advance(self.clock, &mut |event| events.push(event))?;
        if self.process.has_new_state() {
            self.push_state()?;
        }
        // a fast-forwarded run continues to the end without pausing
        let pauses = !self.fast_forward && events.iter().any(P::pauses);
        for event in events {
            self.channels.emit(Event::Process(event));
        }
        if pauses {
            self.playing = false;
            self.channels.emit(Event::Paused);
        }
        let period = if self.fast_forward {
            Duration::ZERO
        } else {
            self.period()
        };
        self.seconds = self.last_step.elapsed().max(period).as_secs_f64();
        self.fast_forward &= !self.process.ended();
        self.publish_status();
        Ok(())
    }

    /// Adds the current state to the timeline.
    fn push_state(&mut self) -> Result<(), P::Error> {
        let state = Arc::new(Snapshot {
            serial: self.next_serial,
            clock: self.clock,
            state: self.process.state()?,
            entries: Arc::clone(&self.entries),
            end: OnceLock::new(),
        });
        self.next_serial += 1;
        self.latest = Some(Arc::clone(&state));
        self.channels.timeline.push(state);
        Ok(())
    }

    /// Sends the status and, once, the end of the run.
    fn publish_status(&mut self) {
        let channels = &self.channels;
        let emit = &mut |event| channels.emit(Event::Process(event));
        let status = Box::new(self.process.status(self.seconds, emit));
        let ended = self.process.ended();
        if ended && !self.end_reported {
            channels.emit(Event::Ended);
        }
        if let Some(latest) = self.latest.as_ref().filter(|_| ended)
            && !self.process.has_new_state()
        {
            latest.end.get_or_init(|| Arc::clone(&self.entries));
        }
        self.end_reported = ended;
        channels.send(Message::Status {
            status,
            clock: self.clock,
            ended,
        });
        (channels.wake)();
    }
}
