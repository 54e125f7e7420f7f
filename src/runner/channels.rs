//! What the handle of a run and its thread send each other.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender};

use crate::runner::timeline::SharedTimeline;
use crate::runner::{Process, Refused, Snapshot, Wake};

/// What happened in a run; `E` are the events of its process.
#[derive(Clone, Debug)]
pub enum Event<E> {
    /// The process is set up; its first state is in the timeline.
    Started,
    /// The process reports something.
    Process(E),
    /// New controls are in force.
    ControlsChanged {
        /// Actions before the change.
        clock: usize,
    },
    /// A part keeps its previous controls.
    Refused(Refused),
    /// The run continues from an earlier state.
    Rewound {
        /// Actions so far, the rewind included.
        clock: usize,
    },
    /// The run has paused by itself because of the event before.
    Paused,
    /// No step is left, or the run was stopped.
    Ended,
    /// The run cannot continue; the last valid state is kept.
    Failed {
        /// The reason, in plain words.
        text: String,
    },
}

/// What the handle sends to the thread.
pub(super) enum Command<P: Process> {
    Play,
    Pause,
    Step,
    Finish,
    Stop,
    Pace(Option<f64>),
    Controls(Box<P::Controls>),
    /// The state itself: it may be discarded from the timeline meanwhile.
    Rewind(Arc<Snapshot<P::State>>),
}

/// What the thread sends to the handle.
pub(super) enum Message<P: Process> {
    Event(Event<P::Event>),
    Status {
        status: Box<P::Status>,
        clock: usize,
        ended: bool,
    },
}

/// The thread's ends of the channels.
pub(super) struct Channels<P: Process> {
    pub commands: Receiver<Command<P>>,
    pub messages: Sender<Message<P>>,
    pub timeline: SharedTimeline<P::State>,
    pub cancelled: Arc<AtomicBool>,
    pub wake: Wake,
}

impl<P: Process> Channels<P> {
    /// Sends a message, unless the handle was dropped.
    pub fn send(&self, message: Message<P>) {
        self.messages.send(message).ok();
    }

    pub fn emit(&self, event: Event<P::Event>) {
        self.send(Message::Event(event));
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}
