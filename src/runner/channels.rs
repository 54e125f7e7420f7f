//! Messages between the handle of a run and its thread.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use crate::cancel::Cancel;
use crate::runner::timeline::SharedTimeline;
use crate::runner::{Process, Refused, Snapshot, Wake};

/// An event of a run; `E` are the events of its process.
#[derive(Clone, Debug)]
pub enum Event<E> {
    /// The process is set up; its first state is in the timeline.
    Started,
    /// An event of the process.
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
    /// The run has paused automatically because of the preceding event.
    Paused,
    /// No step is left, or the run was stopped.
    Ended,
    /// The run cannot continue; the last valid state is kept.
    Failed {
        /// The reason, as text.
        text: String,
    },
}

/// A command from the handle to the thread.
pub(super) enum Command<P: Process> {
    Play,
    Pause,
    Step,
    Finish,
    Stop,
    Pace(Option<f64>),
    Controls(Box<P::Controls>),
    /// The state, because the timeline may discard it meanwhile.
    Rewind(Arc<Snapshot<P::State>>),
}

/// A message from the thread to the handle.
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
    pub cancel: Arc<Cancel>,
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
}
