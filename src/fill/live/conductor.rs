//! The background thread of a live fill: makes the plan, then lets all groups attempt their steps
//! round by round.
//!
//! What a person asks for is taken up between two rounds. Controls wait for the next round, so that
//! what is changed to and fro meanwhile is one change, as in the [schedule](crate::fill::Schedule);
//! a rewind or a stop acts at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::fill::assemble::Assembly;
use crate::fill::context::FillContext;
use crate::fill::fair::plan_fairing;
use crate::fill::live::group::LiveGroup;
use crate::fill::live::{GroupState, GroupStatus, LiveEvent, State};
use crate::fill::prepare::prepare;
use crate::fill::schedule::{Change, Course, Item, Row};
use crate::fill::{FillError, RefillError, RimSet, with_islands};
use crate::live::{SharedTimeline, on_own_pool, until_next_round};
use crate::mesh::{BoundaryLoop, LoopId, Mesh, boundary_loops};
use crate::solver::SolverError;

/// What the handle tells the thread.
#[derive(Debug)]
pub(super) enum Command {
    Play,
    Pause,
    Step,
    Pace(Option<f64>),
    Item(Item),
    /// The rewind's state, which may be dropped from the timeline meanwhile.
    Rewind(Arc<State>),
}

/// What the thread tells the handle.
#[derive(Debug)]
pub(super) enum Message {
    Event(LiveEvent),
    /// How all groups stand, and whether all have ended.
    Statuses(Vec<GroupStatus>, bool),
}

/// What is made of the mesh.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    /// Each loop gets a patch of its own.
    Holes,
    /// One patch joins all loops.
    Blend,
    /// The inner vertices of the selected faces flow; there are no loops.
    Fair(Vec<bool>),
}

/// What a fill is made of.
pub(super) struct Task {
    pub mesh: Arc<Mesh>,
    pub loops: Vec<BoundaryLoop>,
    pub kind: Kind,
    pub course: Course,
    pub playing: bool,
    pub pace: Option<f64>,
}

/// Ways to the handle and back.
pub(super) struct Lines {
    pub inbox: Receiver<Command>,
    pub outbox: Sender<Message>,
    pub timeline: SharedTimeline<State>,
    pub cancelled: Arc<AtomicBool>,
    pub wake: Arc<dyn Fn() + Send + Sync>,
}

impl Lines {
    fn say(&self, event: LiveEvent) {
        // nobody listening means that the handle was dropped
        self.outbox.send(Message::Event(event)).ok();
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Runs a fill until its handle is dropped.
pub(super) fn run(task: Task, lines: Lines) {
    let (outbox, wake) = (lines.outbox.clone(), Arc::clone(&lines.wake));
    let work = move || conduct(task, &lines);
    let text = match on_own_pool(work) {
        Ok(Ok(())) => return,
        Ok(Err(error)) => error.to_string(),
        Err(panic) => SolverError::from_panic(&*panic).to_string(),
    };
    let event = LiveEvent::Failed {
        group: None,
        holes: Vec::new(),
        text,
    };
    outbox.send(Message::Event(event)).ok();
    wake();
}

fn conduct(task: Task, lines: &Lines) -> Result<(), RefillError> {
    let mesh = &*task.mesh;
    // all loops of the mesh, by their numbers: any may be the rim of an island
    let all = boundary_loops(mesh);
    let gaps: Vec<RimSet<'_>> = match task.kind {
        Kind::Blend => vec![task.loops.iter().collect()],
        Kind::Holes => {
            let chosen: Vec<LoopId> = task.loops.iter().map(|l| l.id).collect();
            with_islands(mesh, &all, &chosen)
        }
        Kind::Fair(_) => Vec::new(),
    };
    // checked before the thread was started
    let Ok(options) = task.course.options() else {
        return Ok(());
    };
    let mut plan = match &task.kind {
        Kind::Fair(selected) => plan_fairing(mesh, selected)?,
        Kind::Holes | Kind::Blend => prepare(mesh, &gaps, &options),
    };
    if lines.is_cancelled() {
        return Ok(());
    }
    for error in std::mem::take(&mut plan.failed) {
        lines.say(LiveEvent::Failed {
            group: None,
            holes: error.hole().into_iter().collect(),
            text: error.to_string(),
        });
    }
    let ground = FillContext { mesh, plan: &plan };
    let groups: Vec<LiveGroup> = (0..plan.groups.len())
        .into_par_iter()
        .map(|g| LiveGroup::start(ground, g, &options))
        .collect();
    if lines.is_cancelled() {
        return Ok(());
    }
    let patches = groups.iter().map(|g| Arc::clone(&g.state.patches));
    let assembly = Assembly::new(mesh, &plan, patches.collect()).map_err(FillError::from)?;
    let conductor = Conductor {
        lines,
        ground,
        groups,
        course: task.course,
        rows: Arc::default(),
        pending: None,
        clock: 0,
        next_index: 0,
        assembly: Arc::new(assembly),
        playing: task.playing,
        single: false,
        hurry: false,
        pace: task.pace,
        last_round: Instant::now(),
    };
    Ok(conductor.run()?)
}

struct Conductor<'a> {
    lines: &'a Lines,
    ground: FillContext<'a>,
    groups: Vec<LiveGroup>,
    course: Course,
    rows: Arc<Vec<Row>>,
    /// Controls asked for since the last round.
    pending: Option<Item>,
    /// Attempts so far.
    clock: usize,
    next_index: usize,
    assembly: Arc<Assembly>,
    playing: bool,
    /// Whether one round is asked for.
    single: bool,
    /// Whether rounds follow each other without a pace, towards the end.
    hurry: bool,
    pace: Option<f64>,
    last_round: Instant,
}

impl Conductor<'_> {
    fn run(mut self) -> Result<(), FillError> {
        self.show()?;
        self.lines.say(LiveEvent::Planned);
        self.tell();
        loop {
            if self.lines.is_cancelled() {
                return Ok(());
            }
            let idle = self.pending.is_none() && self.ended();
            // a step asked for where none is left is none
            self.single &= !idle;
            let work = (self.playing || self.single) && !idle;
            let due = if !work {
                None
            } else if self.single || self.hurry {
                Some(Duration::ZERO)
            } else {
                Some(until_next_round(self.pace, self.last_round))
            };
            match self.wait(due) {
                Ok(command) => self.obey(command)?,
                Err(RecvTimeoutError::Timeout) => self.round()?,
                // the handle is gone
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    }

    /// The next command; a timeout when a round is due, which without a time is never.
    fn wait(&self, due: Option<Duration>) -> Result<Command, RecvTimeoutError> {
        match due {
            Some(due) => self.lines.inbox.recv_timeout(due),
            None => Ok(self.lines.inbox.recv()?),
        }
    }

    fn ended(&self) -> bool {
        self.groups.iter().all(|g| g.run.ended())
    }

    fn obey(&mut self, command: Command) -> Result<(), FillError> {
        match command {
            Command::Play => self.playing = true,
            Command::Pause => (self.playing, self.hurry) = (false, false),
            Command::Step => (self.playing, self.single) = (false, true),
            Command::Pace(pace) => self.pace = pace,
            Command::Item(item @ Item::Controls(_)) => {
                // an earlier one that has not acted yet is overtaken
                self.pending = Some(item);
            }
            Command::Item(item) => {
                self.take_pending();
                match item {
                    Item::Finish => (self.playing, self.hurry) = (true, true),
                    _ => self.hurry = false,
                }
                self.take(&item, None);
                self.tell();
            }
            Command::Rewind(state) => {
                self.take_pending();
                self.hurry = false;
                self.take(&Item::Rewind(state.attempt), Some(&state));
                self.assembly = Arc::clone(&state.assembly);
                self.show()?;
                let attempt = self.clock;
                self.lines.say(LiveEvent::Rewound { attempt });
                self.tell();
            }
        }
        Ok(())
    }

    fn take_pending(&mut self) {
        if let Some(item) = self.pending.take() {
            self.take(&item, None);
        }
    }

    /// Records an item and lets every group make the change.
    fn take(&mut self, item: &Item, state: Option<&State>) {
        let (rows, change) = match self.course.take(self.clock, item) {
            Ok(taken) => taken,
            Err(error) => {
                // controls are checked by the handle before they get here
                let text = error.to_string();
                self.lines
                    .say(LiveEvent::ControlsRefused { group: None, text });
                return;
            }
        };
        Arc::make_mut(&mut self.rows).extend(rows);
        let Some(change) = change else { return };
        let ground = self.ground;
        let results: Vec<Result<(), String>> = self
            .groups
            .par_iter_mut()
            .enumerate()
            .map(|(g, group)| group.change(ground, &change, state.map(|s| &s.groups[g])))
            .collect();
        for (g, result) in results.into_iter().enumerate() {
            if let Err(text) = result {
                let group = Some(g);
                self.lines.say(LiveEvent::ControlsRefused { group, text });
            }
        }
        let attempt = self.clock;
        match change {
            Change::Rewind { .. } => self.clock += 1,
            Change::Options(_) => self.lines.say(LiveEvent::ControlsChanged { attempt }),
            Change::Stop => {}
        }
    }

    /// One attempt of every group that has not ended.
    fn round(&mut self) -> Result<(), FillError> {
        self.last_round = Instant::now();
        self.single = false;
        self.take_pending();
        self.clock += 1;
        let (ground, clock, cancelled) = (self.ground, self.clock, &self.lines.cancelled);
        let attempt = |group: &mut LiveGroup| {
            let is_wanted = !cancelled.load(Ordering::Relaxed);
            is_wanted.then(|| group.attempt(ground, clock)).flatten()
        };
        let records: Vec<_> = self.groups.par_iter_mut().map(attempt).collect();
        if self.groups.iter().any(|g| g.fresh) {
            self.show()?;
        }
        for (group, record) in records.into_iter().enumerate() {
            if let Some(record) = record {
                self.lines.say(LiveEvent::Step { group, record });
            }
        }
        for g in 0..self.groups.len() {
            // who asks for the end gets there
            let pauses = !self.hurry;
            if let Some(event) = self.groups[g].crossing_event(g, pauses) {
                self.lines.say(event);
                self.playing &= !pauses;
            }
        }
        let seconds = self.last_round.elapsed().as_secs_f64();
        let period = self.pace.filter(|_| !self.hurry).map_or(0.0, |p| 1.0 / p);
        for group in &mut self.groups {
            group.forecast.seconds = seconds.max(period);
        }
        self.hurry &= !self.ended();
        self.tell();
        Ok(())
    }

    fn holes(&self, g: usize) -> Vec<LoopId> {
        self.ground.plan.hole_ids(g)
    }

    /// Puts the present shapes into the timeline.
    fn show(&mut self) -> Result<(), FillError> {
        let (ground, mesh) = (self.ground, self.ground.mesh);
        let groups: Vec<Arc<GroupState>> = self.groups.iter_mut().map(|g| g.show(ground)).collect();
        if !self.assembly.fits(groups.iter().map(|g| &g.patches)) {
            let patches = groups.iter().map(|g| Arc::clone(&g.patches));
            self.assembly = Arc::new(Assembly::new(mesh, ground.plan, patches.collect())?);
        }
        let state = Arc::new(State {
            index: self.next_index,
            attempt: self.clock,
            groups,
            assembly: Arc::clone(&self.assembly),
            ended: self.ended(),
            rows: Arc::clone(&self.rows),
        });
        for group in &mut self.groups {
            group.number(self.next_index);
        }
        self.next_index += 1;
        self.lines.timeline.push(state);
        Ok(())
    }

    /// Tells the handle how the groups stand and, once, how they have ended, and wakes whoever
    /// waits for that.
    fn tell(&mut self) {
        for g in 0..self.groups.len() {
            let holes = self.holes(g);
            if let Some(event) = self.groups[g].end_event(g, holes) {
                self.lines.say(event);
            }
        }
        let groups = self.groups.iter().enumerate();
        let statuses = groups.map(|(g, group)| {
            let radius = self.ground.plan.groups[g].radius;
            group.status(self.holes(g), radius, self.clock)
        });
        let message = Message::Statuses(statuses.collect(), self.ended());
        self.lines.outbox.send(message).ok();
        (self.lines.wake)();
    }
}
