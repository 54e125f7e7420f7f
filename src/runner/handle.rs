//! The handle of a run in the background.

use std::fmt::Display;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::cancel::Cancel;
use crate::runner::channels::{Channels, Command, Message};
use crate::runner::timeline::SharedTimeline;
use crate::runner::worker;
use crate::runner::{
    Event, Process, RunControls, RunSettings, Schedule, Timeline, TimelineState, Wake,
};

/// Why a run cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError<E: std::error::Error> {
    /// The options are invalid.
    #[error(transparent)]
    Options(E),
    /// No thread could be started.
    #[error("could not start a thread for the run: {0}")]
    Thread(std::io::Error),
}

/// A process running in the background. Dropping the handle cancels the run. The call returns at
/// once, and the thread ends within one step.
pub struct Runner<P: Process> {
    controls: P::Controls,
    commands: Sender<Command<P>>,
    messages: Receiver<Message<P>>,
    /// Received events whose status has not been received yet.
    early: Vec<Event<P::Event>>,
    timeline: SharedTimeline<P::State>,
    cancel: Arc<Cancel>,
    playing: AtomicBool,
    status: P::Status,
    clock: usize,
    ended: bool,
    failed: Option<String>,
}

impl<P> Runner<P>
where
    P: Process + 'static,
    P::State: TimelineState + Send + Sync + 'static,
    P::Event: Send + 'static,
    P::Status: Send + 'static,
{
    /// Starts a thread that constructs the process by `set_up` and runs it. `controls` are the initial controls; they must
    /// be valid.
    ///
    /// # Errors
    /// No thread could be started.
    pub(crate) fn start<E: Display>(
        name: &str,
        controls: P::Controls,
        settings: RunSettings,
        wake: Wake,
        set_up: impl FnOnce() -> Result<P, E> + Send + 'static,
    ) -> Result<Self, std::io::Error> {
        let (commands, inbox) = channel();
        let (outbox, messages) = channel();
        let timeline = SharedTimeline::new(settings.timeline_bytes);
        let cancel = Arc::new(Cancel::default());
        let channels = Channels {
            commands: inbox,
            messages: outbox,
            timeline: timeline.clone(),
            cancel: Arc::clone(&cancel),
            wake,
        };
        let first = controls.clone();
        std::thread::Builder::new()
            .name(format!("meniscus-{name}"))
            .spawn(move || worker::run(set_up, first, settings, channels))?;
        Ok(Self {
            controls,
            commands,
            messages,
            early: Vec::new(),
            timeline,
            cancel,
            playing: AtomicBool::new(settings.playing),
            status: P::Status::default(),
            clock: 0,
            ended: false,
            failed: None,
        })
    }
}

impl<P: Process> Runner<P>
where
    P::State: TimelineState,
{
    fn send(&self, command: Command<P>) {
        // a thread that has ended has already sent the reason
        self.commands.send(command).ok();
    }

    /// Continues until the end.
    pub fn play(&self) {
        self.playing.store(true, Ordering::Relaxed);
        self.send(Command::Play);
    }

    /// Pauses after the current step.
    pub fn pause(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Pause);
    }

    /// Takes one step, then pauses.
    pub fn step(&self) {
        self.playing.store(false, Ordering::Relaxed);
        self.send(Command::Step);
    }

    /// Continues to the end in the fewest steps, without a pace limit; recorded.
    pub fn finish(&self) {
        self.playing.store(true, Ordering::Relaxed);
        self.send(Command::Finish);
    }

    /// Ends the run at the current state; recorded.
    pub fn stop(&self) {
        self.send(Command::Stop);
    }

    /// Sets the maximum number of steps per second; `None` for no limit.
    pub fn set_pace(&self, pace: Option<f64>) {
        self.send(Command::Pace(pace));
    }

    /// Changes the controls before the next step; recorded. Controls that the current surface does
    /// not permit are reported by [`Event::Refused`].
    ///
    /// # Errors
    /// Invalid controls; the run continues as before.
    pub fn set_controls(
        &mut self,
        controls: &P::Controls,
    ) -> Result<(), <P::Controls as RunControls>::Error> {
        if *controls != self.controls {
            controls.validate()?;
            self.controls = controls.clone();
            self.send(Command::Controls(Box::new(controls.clone())));
        }
        Ok(())
    }

    /// Continues from a stored state, by its serial number; recorded. Returns `false` if no such
    /// state is stored.
    ///
    /// Nothing is discarded: the state is added to the timeline as the latest one. A paused run
    /// stays paused.
    pub fn rewind_to(&self, serial: usize) -> bool {
        let state = self.timeline().find(serial).cloned();
        state
            .map(|state| self.send(Command::Rewind(state)))
            .is_some()
    }

    /// The events since the last call, in order; never blocks. An event is returned together with
    /// the status after it, so that [`Self::clock`] and [`Self::status`] include its effect.
    pub fn poll(&mut self) -> Vec<Event<P::Event>> {
        let mut events = Vec::new();
        while let Ok(message) = self.messages.try_recv() {
            match message {
                Message::Status {
                    status,
                    clock,
                    ended,
                } => (self.status, self.clock, self.ended) = (*status, clock, ended),
                Message::Event(event) => {
                    let failed = match &event {
                        Event::Failed { text } => Some(text.clone()),
                        _ => None,
                    };
                    self.early.push(event);
                    if failed.is_none() {
                        continue;
                    }
                    // no status follows
                    (self.ended, self.failed) = (true, failed);
                }
            }
            events.append(&mut self.early);
        }
        if events.iter().any(|e| matches!(e, Event::Paused)) {
            self.playing.store(false, Ordering::Relaxed);
        }
        events
    }

    /// The status at the last [`Self::poll`]; the default until the process is set up.
    pub fn status(&self) -> &P::Status {
        &self.status
    }

    /// Number of actions, at the last [`Self::poll`].
    pub fn clock(&self) -> usize {
        self.clock
    }

    /// Whether the run is playing rather than paused. The end of the run does not change this.
    pub fn playing(&self) -> bool {
        self.playing.load(Ordering::Relaxed)
    }

    /// Whether the run had ended or failed at the last [`Self::poll`].
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Why the run cannot continue, if it had failed at the last [`Self::poll`].
    pub fn failed(&self) -> Option<&str> {
        self.failed.as_deref()
    }

    /// The latest controls.
    pub fn controls(&self) -> &P::Controls {
        &self.controls
    }

    /// The stored states, oldest first; the first and the latest are always among them. Empty until
    /// the process is set up.
    pub fn timeline(&self) -> Arc<Timeline<P::State>> {
        self.timeline.now()
    }

    /// The recording that repeats the run up to its latest state, with its initial controls.
    pub fn schedule(&self) -> Schedule {
        let timeline = self.timeline();
        timeline
            .latest()
            .map_or_else(Schedule::default, |s| s.schedule())
    }
}

impl<P: Process> Drop for Runner<P> {
    fn drop(&mut self) {
        self.cancel.request();
    }
}
