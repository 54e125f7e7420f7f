//! A run: its flows, the shown states, and its operations.

mod divergence;
mod fill_handle;
mod handle;
mod refine_handle;
mod refinement;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::action::Action;
use super::document::{Document, left_of};
use super::jobs::Wake;
use super::log::Level;
use crate::energy::Preset;
use crate::fill::{Controls, Surface, open_selection, release};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, face_flags};
use crate::ops::Operation;
use crate::options::{Choice as _, Options as _};
use crate::render::grouped;
use crate::runner::RunSettings;
use crate::solver::{End, RejectReason, StepRecord};
use crate::warning::counted;
use divergence::{Limits, SENSIBLE_FALL, falls_without_bound, has_fallen};
pub use handle::{Figures, RunEvent, RunHandle, RunState, StateView, state_key};
pub use refinement::method_name;

/// Maximum size of each timeline, bytes.
pub const TIMELINE_BYTES: usize = 512 << 20;

/// One of the flows that a run compares.
pub struct RunVariant {
    /// The flow.
    pub handle: Box<dyn RunHandle>,
    /// The name: A, B or the method.
    pub name: &'static str,
    /// The operation at the start.
    pub operation: Operation,
    /// The current controls.
    pub controls: Controls,
    /// Index of the shown state; `None` for the newest.
    pub shown: Option<usize>,
    /// Energy and residual of each accepted step, one pair of curves per group.
    pub curves: Vec<Curve>,
    /// The first self-intersection, if there is one.
    pub crossing: Option<Since<Crossing>>,
    /// Warnings without duplicates.
    pub warnings: Vec<Since<String>>,
    /// Changes of the controls, in order; the attempt is the last before the change.
    pub changes: Vec<Since<String>>,
    /// Whether the surface grew without bound at the last step, so that the run was paused.
    pub diverged: bool,
    /// Number of attempts so far, which all groups share.
    attempts: usize,
    /// The group of the last step; `None` before the first one of an attempt.
    last_group: Option<usize>,
}

/// A fact about all states from one of them on.
#[derive(Clone, Debug)]
pub struct Since<T> {
    /// Attempts before the first of these states.
    pub attempt: usize,
    /// The fact.
    pub what: T,
}

/// A self-intersection.
#[derive(Clone, Debug)]
pub struct Crossing {
    /// The names of the holes.
    pub holes: String,
    /// One of its points.
    pub place: DVec3,
}

/// Points of the plots of one group: `[attempt, value]`.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Energy.
    pub energy: Vec<[f64; 2]>,
    /// Decadic logarithm of the residual.
    pub residual: Vec<[f64; 2]>,
    /// Reason of the last rejection.
    pub rejection: Option<RejectReason>,
}

/// A state of a run that is being accepted.
pub struct Accepting {
    /// The side.
    pub side: usize,
    /// The state.
    pub state: RunState,
    /// Actions on the mesh, which follow the acceptance.
    pub then: Vec<Action>,
}

/// A run of one flow, or of several flows that are compared.
pub struct Run {
    /// The operation.
    pub operation: Operation,
    /// The mesh of the run: that of the document, after erasing if faces were erased.
    pub base: Arc<Mesh>,
    /// The first face of `base` that belongs to an earlier patch.
    pub first_patch_face: usize,
    /// The faces of the document that remain in `base`, if some were erased.
    pub kept: Option<Vec<u32>>,
    /// The loops of `base` that are filled or joined.
    pub loops: Vec<BoundaryLoop>,
    /// The flows.
    pub sides: Vec<RunVariant>,
    /// Whether the flow, or the replay of stored states, is playing.
    pub playing: bool,
    /// Whether the user has stopped the run. A step that is being computed may still end.
    pub stopped: bool,
    /// The state that is being accepted, while the textures of its patches are made.
    pub accepting: Option<Accepting>,
    /// The time at which the replay shows the next state.
    next_frame: Option<Instant>,
    /// What a sensible surface does not exceed.
    limits: Option<Limits>,
    /// Whether the message about the end of the run was given.
    summarised: bool,
}

impl Run {
    /// Starts fills of the same kind that are compared, one or two.
    ///
    /// # Errors
    /// A message for the user.
    pub fn start(
        operations: &[Operation],
        document: &Document,
        pace: f64,
        wake: &Wake,
    ) -> Result<Self, String> {
        let operation = operations.first().ok_or("nothing to start")?;
        let mut base = Arc::clone(&document.mesh);
        let mut first_patch_face = document.first_patch_face;
        let (mut without, mut loops, mut opened) = (None, Vec::new(), Vec::new());
        match operation {
            Operation::Fill(spec) if !spec.bridges.is_empty() => {
                let rim_sets = spec.rim_sets(&base, &document.loops);
                let rim_sets = rim_sets.map_err(|e| e.to_string())?;
                if let Some(released) = release(&base, &rim_sets, &spec.bridges) {
                    loops = released.rims.concat();
                    without = Some(released.erased);
                } else {
                    loops = document.selected().into_iter().cloned().collect();
                }
            }
            Operation::Fill(_) | Operation::Blend(_) => {
                loops = document.selected().into_iter().cloned().collect();
            }
            Operation::FillPart(spec) => {
                let part = spec.segment(&base, &document.loops);
                let (hole, _) = part.ok_or("the mesh has no boundary loop")?;
                loops = vec![hole.clone()];
            }
            Operation::Refill(spec) => {
                let flags = face_flags(&spec.faces, base.face_count());
                let opening = open_selection(&base, &flags).map_err(|e| e.to_string())?;
                opened = opening.opened;
                let of_opened = opened.iter().map(|id| opening.loops[id.index()].clone());
                loops = of_opened.collect();
                without = Some(opening.erased);
            }
            Operation::Fair(_) => {}
            _ => return Err("unsupported operation".into()),
        }
        let mut kept = None;
        if let Some(erased) = without {
            first_patch_face = left_of(&erased.old_face, first_patch_face);
            base = Arc::new(erased.mesh);
            kept = Some(erased.old_face);
        }
        let start = |operation: &Operation| {
            let (mesh, started) = match operation {
                Operation::Refill(spec) => (&base, Operation::Fill(spec.fill_of(&opened))),
                // a fill releases the strips of bridges by itself
                _ => (&document.mesh, operation.clone()),
            };
            started.start(Arc::clone(mesh), settings(pace), Arc::clone(wake))
        };
        let sides = operations.iter().zip(["A", "B"]);
        let sides = sides
            .map(|(operation, name)| {
                let controls = operation.flow().map(|flow| flow.controls.clone());
                let controls = controls.unwrap_or_default();
                let live = start(operation).map_err(|error| error.to_string())?;
                let operation = operation.clone();
                Ok(RunVariant::new(Box::new(live), name, operation, controls))
            })
            .collect::<Result<_, String>>()?;
        Ok(Self {
            operation: operation.clone(),
            limits: Limits::new(&base, &loops),
            base,
            first_patch_face,
            kept,
            loops,
            sides,
            playing: true,
            stopped: false,
            accepting: None,
            next_frame: None,
            summarised: false,
        })
    }

    /// The names of the sides, if there are several.
    pub fn names(&self) -> Vec<&'static str> {
        let several = self.sides.len() > 1;
        let named = |s: &RunVariant| if several { s.name } else { "" };
        self.sides.iter().map(named).collect()
    }

    /// The prefix of texts about a side, if there are several.
    pub fn prefix(&self, side: usize) -> String {
        match self.names().get(side) {
            Some(name) if !name.is_empty() => format!("{name} "),
            _ => String::new(),
        }
    }

    /// The holes of a row of figures, or what else its flow is about.
    pub fn holes_words(&self, figures: &Figures) -> String {
        match &self.operation {
            Operation::Fair(spec) => format!("{} faces", grouped(spec.faces.len())),
            Operation::Refine(_) => figures
                .level
                .map_or_else(String::new, |n| format!("level {n}")),
            _ => figures.hole_list(),
        }
    }

    /// What it makes, in words.
    pub fn noun(&self) -> &'static str {
        match self.operation {
            Operation::Refine(_) => "refinement",
            Operation::Fair(_) => "fairing",
            _ => "patch",
        }
    }

    /// The title of a side in words; empty if there is only one.
    pub fn title(&self, side: usize) -> String {
        match self.sides.get(side) {
            Some(shown) if self.sides.len() > 1 => shown.title(),
            _ => String::new(),
        }
    }

    /// Polls the flows. Returns messages for the log.
    pub fn poll(&mut self) -> Vec<(Level, String)> {
        let mut messages = Vec::new();
        let mut paused = false;
        let mut good = None;
        for side in &mut self.sides {
            let mut stepped = false;
            for event in side.handle.poll() {
                let attempt = side.latest_attempt();
                match event {
                    RunEvent::Step(group, record) => {
                        side.record(group, &record);
                        stepped = true;
                    }
                    RunEvent::SelfIntersection { holes, text, place } => {
                        let what = Crossing { holes, place };
                        side.crossing = Some(Since { attempt, what });
                        messages.push((Level::Warning, text));
                    }
                    RunEvent::Paused => paused = true,
                    RunEvent::Note(text) => messages.push((Level::Info, text)),
                    RunEvent::Error(text) => messages.push((Level::Error, text)),
                    RunEvent::Warning(text) if side.warnings.iter().any(|w| w.what == text) => {}
                    RunEvent::Warning(text) => {
                        messages.push((Level::Warning, text.clone()));
                        let what = text;
                        side.warnings.push(Since { attempt, what });
                    }
                }
            }
            if stepped {
                side.diverged = side.exceeds(self.limits.as_ref());
            }
            if stepped && side.diverged {
                paused = true;
                good = Some(side.last_within(self.limits.as_ref()));
            }
        }
        if paused {
            // pause all compared flows together
            for side in &mut self.sides {
                side.handle.pause();
            }
        }
        if good.is_some() {
            self.scrub(good);
        }
        let ended = self.sides.iter().all(|s| s.handle.ended());
        if ended && !self.summarised {
            let texts = self.names().into_iter().enumerate();
            let texts = texts.filter_map(|(s, name)| {
                let text = self.summary(s)?;
                let prefix = if name.is_empty() { "" } else { ": " };
                Some(format!("{name}{prefix}{text}"))
            });
            let texts: Vec<String> = texts.collect();
            if !texts.is_empty() {
                messages.push((Level::Info, texts.join("; ")));
            }
        }
        self.summarised = ended;
        // stored states may still be replayed after the end
        if paused || (self.playing && self.ended() && !self.scrubbed()) {
            self.playing = false;
        }
        messages
    }

    /// The faces that flow without remeshing, in ascending order.
    pub fn faired(&self) -> Arc<Vec<u32>> {
        match &self.operation {
            Operation::Fair(spec) => Arc::clone(&spec.faces),
            _ => Arc::default(),
        }
    }

    /// Whether every flow has ended or was stopped by the user.
    pub fn ended(&self) -> bool {
        self.stopped || self.sides.iter().all(|s| s.handle.ended())
    }

    /// Why the run has paused by itself, or else the progress of a running fill of several holes, in words.
    pub fn progress(&self) -> Option<String> {
        let crossing = self.sides.iter().find_map(RunVariant::shown_crossing);
        if let Some(Crossing { holes, .. }) = crossing.filter(|_| !self.playing && !self.ended()) {
            return Some(format!(
                "Paused: the patch of hole {holes} intersects itself or the mesh at the red mark. Play continues, Esc \
                 stops."
            ));
        }
        let rows = self.sides.first()?.handle.figures(None);
        let left = rows.iter().filter(|row| row.end.is_none());
        let left: BTreeSet<LoopId> = left.flat_map(|row| row.holes.iter().copied()).collect();
        let all: BTreeSet<LoopId> = rows
            .iter()
            .flat_map(|row| row.holes.iter().copied())
            .collect();
        let (all, done) = (all.len(), all.len() - left.len());
        if all < 2 || self.ended() || !matches!(self.operation, Operation::Fill(_)) {
            return None;
        }
        let eta = rows.iter().filter_map(|row| row.eta).fold(0.0, f64::max);
        let eta = match eta.ceil() {
            0.0 => String::new(),
            seconds => format!(", about {seconds} s"),
        };
        Some(format!("{done} of {all} holes done{eta}"))
    }

    /// Whether the first side makes the energy of its controls stationary, as far as is known.
    pub fn uses_energy(&self) -> bool {
        let rows = self.sides.first().map(|side| side.handle.figures(None));
        let rows = rows.unwrap_or_default();
        rows.is_empty() || rows.iter().any(|row| row.uses_energy)
    }

    /// The results of a side that has ended in one line.
    fn summary(&self, side: usize) -> Option<String> {
        let side = self.sides.get(side)?;
        // a hole in parts, with creases between them, ends as the worst of them; a fairing and a refinement have no
        // holes
        let mut ends: BTreeMap<Option<LoopId>, usize> = BTreeMap::new();
        let mut unsound: BTreeSet<LoopId> = BTreeSet::new();
        for row in side.handle.figures(None) {
            let kind = match row.end? {
                Ok(End::Converged) => 0,
                Ok(_) => 1,
                Err(_) => 2,
            };
            let has_none = row.holes.is_empty().then_some(None);
            for hole in row.holes.into_iter().map(Some).chain(has_none) {
                let end = ends.entry(hole).or_default();
                *end = kind.max(*end);
            }
            unsound.extend(row.unsound);
        }
        let done = match side.operation {
            Operation::Refine(_) => "done",
            _ => "converged",
        };
        let kinds = [done, "ended early", "failed"];
        let counts = [0, 1, 2].map(|kind| ends.values().filter(|&&end| end == kind).count());
        let parts = counts.iter().zip(kinds).filter(|(n, _)| **n > 0);
        let all = ends.len();
        let is_fill = matches!(side.operation, Operation::Fill(_));
        let part = |(n, kind): (&usize, &str)| {
            if all == 1 && !is_fill {
                kind.to_owned()
            } else {
                format!("{n} {kind}")
            }
        };
        let parts: Vec<String> = parts.map(part).collect();
        let what = if is_fill {
            format!("{} filled", counted(all, "hole", "holes"))
        } else {
            side.operation.label()
        };
        let defective = match unsound.len() {
            0 => String::new(),
            n => {
                let [one, many] = [
                    "patch has defects, see its warning",
                    "patches have defects, see their warnings",
                ];
                format!("; {}", counted(n, one, many))
            }
        };
        (all > 0).then(|| format!("{what}: {}{defective}", parts.join(", ")))
    }

    /// Whether the run is paused because a surface grew without bound.
    pub fn diverged(&self) -> bool {
        !self.playing && self.sides.iter().any(|s| s.diverged)
    }

    /// Whether the newest state is not the shown one.
    pub fn scrubbed(&self) -> bool {
        self.sides.iter().any(|s| s.shown.is_some())
    }

    /// Shows the state at an index of the longest timeline; `None` for the newest.
    pub fn scrub(&mut self, at: Option<usize>) {
        for side in &mut self.sides {
            let last = side.state_count().saturating_sub(1);
            side.shown = at.filter(|&i| i < last);
        }
    }

    /// Number of stored states of the longest side.
    pub fn state_count(&self) -> usize {
        self.sides
            .iter()
            .map(RunVariant::state_count)
            .max()
            .unwrap_or(0)
    }

    /// Advances a replay of stored states at `pace` states per second. Returns the time of the next
    /// call, or `None` if nothing is replayed.
    pub fn replay(&mut self, pace: f64, now: Instant) -> Option<Duration> {
        if !(self.playing && self.scrubbed()) {
            self.next_frame = None;
            return None;
        }
        let interval = Duration::from_secs_f64(1.0 / pace.clamp(0.5, 240.0));
        let due = *self.next_frame.get_or_insert(now + interval);
        if now >= due {
            let at = self.sides.iter().filter_map(|s| s.shown).min();
            self.scrub(at.map(|i| i + 1));
            self.next_frame = Some(now + interval);
            if !self.scrubbed() {
                // the replay has reached the newest state
                self.playing = !self.ended();
                for side in &self.sides {
                    side.handle.play();
                }
            }
        }
        self.next_frame
            .map(|due| due.saturating_duration_since(now))
    }
}

impl RunVariant {
    fn new(
        handle: Box<dyn RunHandle>,
        name: &'static str,
        operation: Operation,
        controls: Controls,
    ) -> Self {
        Self {
            handle,
            name,
            operation,
            controls,
            shown: None,
            curves: Vec::new(),
            crossing: None,
            warnings: Vec::new(),
            changes: Vec::new(),
            diverged: false,
            attempts: 0,
            last_group: None,
        }
    }

    /// The side with its surface model or energy, or its method.
    fn title(&self) -> String {
        let controls = &self.controls;
        let (name, text) = (self.name, &controls.energy);
        let preset = Preset::of_text(text);
        match (&self.operation, controls.surface, preset) {
            (Operation::Refine(_), ..) => name.to_owned(),
            (_, Surface::Diffusion | Surface::G2, _) => {
                format!("{name}: surface model {}", controls.surface.name())
            }
            (_, Surface::Auto, _) if controls.predicts_surface() => {
                format!("{name}: surface model auto")
            }
            (_, _, Some(preset)) => format!("{name}: {}, {text}", preset.title()),
            _ => format!("{name}: f = {text}"),
        }
    }

    /// Whether the newest state or its energy is beyond the limits.
    fn exceeds(&self, limits: Option<&Limits>) -> bool {
        let newest = self.handle.state(usize::MAX);
        let outside = limits
            .zip(newest.as_ref())
            .is_some_and(|(limits, state)| !limits.hold(state));
        // the other surface models minimise no energy
        let minimises = self.controls.surface == Surface::Energy;
        outside || (minimises && self.curves.iter().any(falls_without_bound))
    }

    /// Index of the newest state within the limits, before the newest one.
    fn last_within(&self, limits: Option<&Limits>) -> usize {
        let within = |i: &usize| {
            let state = self.handle.state(*i);
            let inside = limits
                .zip(state.as_ref())
                .is_none_or(|(limits, state)| limits.hold(state));
            let rows = self.handle.figures(state.as_ref());
            let fallen = rows.iter().zip(&self.curves).any(|(row, curve)| {
                let energy = row.energy;
                energy.is_some_and(|energy| has_fallen(curve, energy, SENSIBLE_FALL))
            });
            inside && !fallen
        };
        let newest = self.state_count().saturating_sub(1);
        (0..newest).rev().find(within).unwrap_or(0)
    }

    /// Forgets the facts about states after an attempt, because the flow continues there.
    pub fn forget_after(&mut self, attempt: usize) {
        self.warnings.retain(|w| w.attempt <= attempt);
        // the flow continues with the changed controls
        for change in &mut self.changes {
            change.attempt = change.attempt.min(attempt);
        }
        self.attempts = attempt;
        self.last_group = None;
        for curve in &mut self.curves {
            let last = attempt as f64;
            curve.energy.retain(|point| point[0] <= last);
            curve.residual.retain(|point| point[0] <= last);
        }
        self.crossing = self.crossing.take().filter(|c| c.attempt <= attempt);
        self.diverged = false;
    }

    /// The warnings about the shown state.
    pub fn shown_warnings(&self) -> impl Iterator<Item = &str> {
        let at = self.shown_attempt();
        let warnings = self.warnings.iter().filter(move |w| w.attempt <= at);
        warnings.map(|w| w.what.as_str())
    }

    /// The self-intersection of the shown state.
    pub fn shown_crossing(&self) -> Option<&Crossing> {
        let at = self.shown_attempt();
        let crossing = self.crossing.as_ref().filter(|c| c.attempt <= at);
        crossing.map(|c| &c.what)
    }

    fn shown_attempt(&self) -> usize {
        self.state().map_or(0, |state| state.attempt())
    }

    /// The attempt of the latest state.
    pub fn latest_attempt(&self) -> usize {
        self.handle
            .state(usize::MAX)
            .map_or(0, |state| state.attempt())
    }

    /// Takes over controls that were changed after an attempt.
    pub fn change_controls(&mut self, controls: Controls, attempt: usize) {
        let difference = self.controls.difference(&controls).into_iter();
        let words: Vec<String> = difference
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        // a drag gives many changes before the next attempt
        self.changes.retain(|change| change.attempt != attempt);
        let what = words.join(", ");
        self.changes.push(Since { attempt, what });
        if (&controls.energy, &controls.param) != (&self.controls.energy, &self.controls.param) {
            self.new_energy();
            self.diverged = false;
        }
        self.controls = controls;
    }

    /// Restarts the energy curve after a change of the energy.
    fn new_energy(&mut self) {
        for curve in &mut self.curves {
            curve.energy.clear();
        }
    }

    fn record(&mut self, group: usize, record: &StepRecord) {
        if self.curves.len() <= group {
            self.curves.resize(group + 1, Curve::default());
        }
        // the steps of an attempt are in the order of the groups; groups that have ended take none
        if self.last_group.is_none_or(|last| group <= last) {
            self.attempts += 1;
        }
        self.last_group = Some(group);
        let curve = &mut self.curves[group];
        if record.is_rejected() {
            curve.rejection.clone_from(&record.rejection);
            return;
        }
        let x = self.attempts as f64;
        curve.energy.push([x, record.energy]);
        if record.residual > 0.0 {
            curve.residual.push([x, record.residual.log10()]);
        }
    }

    /// Number of stored states.
    pub fn state_count(&self) -> usize {
        self.handle.state_count()
    }

    /// The shown state; `None` before the first.
    pub fn state(&self) -> Option<RunState> {
        self.handle.state(self.shown.unwrap_or(usize::MAX))
    }

    /// The figures of the shown state. Only the last state of a group has an end and an activity.
    pub fn figures(&self) -> Vec<Figures> {
        let mut rows = self.handle.figures(self.state().as_ref());
        if self.shown.is_some() {
            for row in rows.iter_mut().filter(|row| !row.is_last) {
                row.end = None;
                // states of refinements do not store it
                row.relative_tau = row.relative_tau.filter(|_| row.level.is_none());
                "earlier state".clone_into(&mut row.doing);
            }
        }
        rows
    }
}

fn settings(pace: f64) -> RunSettings {
    RunSettings {
        playing: true,
        pace: Some(pace),
        timeline_bytes: TIMELINE_BYTES,
    }
}
