//! A common interface to all kinds of runs.

use std::any::Any;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use crate::fill::{Controls, GroupSurface};
use crate::mesh::{DVec3, LoopId, Mesh, Topology};
use crate::runner::{Event, Process, Runner, Schedule, Snapshot, TimelineState};
use crate::solver::{End, StepRecord};
use crate::warning::Warning;

/// A run in the background.
pub trait RunHandle {
    /// Continues to the end.
    fn play(&self);

    /// Pauses after the current step.
    fn pause(&self);

    /// Takes one step, then pauses.
    fn step(&self);

    /// Continues to the end in fast mode.
    fn finish(&self);

    /// Ends at the current state.
    fn stop(&self);

    /// Sets the maximum number of states per second.
    fn set_pace(&self, pace: f64);

    /// Whether it is not paused; true after the end of a run that was not paused.
    fn playing(&self) -> bool;

    /// Whether it had ended at the last [`Self::poll`].
    fn ended(&self) -> bool;

    /// Changes the controls from the next step on.
    ///
    /// # Errors
    /// A message for the user; the run continues as before.
    fn set_controls(&mut self, controls: &Controls) -> Result<(), String>;

    /// The events since the last call.
    fn poll(&mut self) -> Vec<RunEvent>;

    /// The number of stored states.
    fn state_count(&self) -> usize;

    /// A stored state by index; the newest for an index out of range.
    fn state(&self, at: usize) -> Option<RunState>;

    /// All stored states, oldest first.
    fn states(&self) -> Vec<RunState>;

    /// The first stored state with the same vertices as another one.
    fn start_of(&self, state: &RunState) -> Option<RunState>;

    /// Size of the stored states in bytes.
    fn bytes(&self) -> usize;

    /// Continues from a stored state.
    fn rewind_to(&self, state: &RunState);

    /// The maximum radius of the groups of holes; 0 without groups.
    fn radius(&self) -> f64;

    /// The next time step and the natural time of the first group of holes.
    fn tau(&self) -> Option<(f64, f64)>;

    /// One row for each group, at the shown state.
    fn figures(&self, shown: Option<&RunState>) -> Vec<Figures>;
}

/// A stored state of a run.
pub type RunState = Arc<dyn StateView>;

/// The data of a stored state that the window needs.
pub trait StateView: Any + Debug + Send + Sync {
    /// Its serial number.
    fn serial(&self) -> usize;

    /// The schedule that repeats the run up to this state.
    fn schedule(&self) -> Schedule;

    /// Connectivity of the whole mesh; that of a refinement is cut open along creases.
    fn topology(&self) -> &Arc<Topology>;

    /// Positions of all vertices: control points of the limit surface, or those of the saved mesh
    /// if `flat`.
    fn positions(&self, flat: bool) -> Vec<DVec3>;

    /// The whole mesh.
    fn mesh(&self) -> Mesh;

    /// The whole mesh, and warnings about what its patches have besides their shape.
    fn mesh_with_warnings(&self) -> (Mesh, Vec<String>) {
        (self.mesh(), Vec::new())
    }

    /// Whether [`Self::mesh_with_warnings`] may make texture images, which takes time.
    fn makes_images(&self) -> bool {
        false
    }

    /// The faces added by the run; `None` if it replaces all faces.
    fn patch_faces(&self) -> Option<Range<usize>>;

    /// Whether it has a smooth limit surface.
    fn has_limit(&self) -> bool;

    /// Whether its mesh is cut open along creases.
    fn is_cut(&self) -> bool;

    /// Attempted steps before this state.
    fn attempt(&self) -> usize;
}

/// Equal where both are the same state, or none.
pub fn state_key(state: Option<&RunState>) -> Option<*const ()> {
    state.map(|state| Arc::as_ptr(state).cast())
}

/// An event of a run for the window.
pub enum RunEvent {
    /// A step was attempted by a group.
    Step(usize, StepRecord),
    /// The surface began to intersect itself or the mesh.
    SelfIntersection {
        /// The names of the holes.
        holes: String,
        /// A description, with the last state without an intersection.
        text: String,
        /// A point of the intersection.
        place: DVec3,
    },
    /// The run has paused automatically.
    Paused,
    /// A message.
    Note(String),
    /// A warning.
    Warning(String),
    /// An error.
    Error(String),
}

/// A row of numbers of a group of holes or of a refinement.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Loops solved together; none for a refinement.
    pub holes: Vec<LoopId>,
    /// The names of the holes: the numbers of their loops, such as `1+2` for a patch between two, and those of the
    /// parts of a hole that sharp lines split, such as `3.1`.
    pub names: Vec<String>,
    /// The level of a refinement.
    pub level: Option<usize>,
    /// Accepted steps at the shown state.
    pub step: Option<usize>,
    /// Time step that led to the shown state, divided by the natural time.
    pub relative_tau: Option<f64>,
    /// Energy of the shown state.
    pub energy: Option<f64>,
    /// Residual of the shown state.
    pub residual: Option<f64>,
    /// Rejected steps.
    pub rejected: usize,
    /// Smallest triangle angle in degrees.
    pub angle: Option<f64>,
    /// Whether the shown state is the last one of the flow so far.
    pub is_last: bool,
    /// How the flow ended, if the shown state is its last.
    pub end: Option<Result<End, String>>,
    /// The holes whose patches are left with defects.
    pub unsound: Vec<LoopId>,
    /// Estimated time to the end in seconds.
    pub eta: Option<f64>,
    /// The current activity.
    pub doing: String,
    /// The surface model of the holes; `None` for a refinement.
    pub surface: Option<GroupSurface>,
    /// Whether the surface model makes the energy of the controls stationary.
    pub uses_energy: bool,
}

impl Figures {
    /// Whether the user should look at the patches: the flow has failed or ended before it converged, or
    /// patches have defects.
    pub fn needs_attention(&self) -> bool {
        let is_converged = matches!(self.end, None | Some(Ok(End::Converged)));
        !is_converged || !self.unsound.is_empty()
    }

    /// The names of the holes in one list.
    pub fn hole_list(&self) -> String {
        hole_list(&self.names)
    }

    /// The names of some of the holes, by their numbers in [`Self::holes`], in one list.
    pub fn hole_list_of(&self, numbers: &[usize]) -> String {
        let names: Vec<String> = numbers.iter().map(|&k| self.names[k].clone()).collect();
        hole_list(&names)
    }

    /// The names of those of the holes whose patches are left with defects, in one list.
    pub fn unsound_list(&self) -> String {
        let names = self.holes.iter().zip(&self.names);
        let names = names.filter(|(hole, _)| self.unsound.contains(hole));
        let names: Vec<String> = names.map(|(_, name)| name.clone()).collect();
        hole_list(&names)
    }

    /// What gives the patches and the errors to expect, each once in words, with the numbers in
    /// [`Self::holes`] of the holes that it is about.
    pub fn surface_words(&self) -> Vec<(Vec<usize>, String)> {
        let Some(surface) = &self.surface else {
            return Vec::new();
        };
        let of = |&hole: &LoopId| (surface.expected_error_of(hole), surface.words_of(hole));
        alike(self.holes.iter().map(of))
    }
}

/// Errors to expect and models of successive holes, each once in words, with the numbers of their holes.
fn alike(surfaces: impl Iterator<Item = (Option<f64>, String)>) -> Vec<(Vec<usize>, String)> {
    let mut all: Vec<(Vec<usize>, String)> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for (k, (error, model)) in surfaces.enumerate() {
        let error = error.map_or_else(String::new, |error| format!("{:.2} %, ", 100.0 * error));
        let words = error + &model;
        let at = *known.entry(words.clone()).or_insert(all.len());
        if at == all.len() {
            all.push((Vec::new(), words));
        }
        all[at].0.push(k);
    }
    all
}

/// Names of holes in one list, in which three or more holes with successive numbers are a range, as in
/// `1–4, 7`. A part of a hole, such as `3.1`, is in no range.
pub(super) fn hole_list(names: &[String]) -> String {
    let number = |k: usize| names[k].parse::<usize>().ok();
    let follows = |k: usize| match (number(k - 1), number(k)) {
        (Some(last), Some(this)) => last + 1 == this,
        _ => false,
    };
    let mut parts = Vec::new();
    let mut first = 0;
    for k in 1..=names.len() {
        if k < names.len() && follows(k) {
            continue;
        }
        if k - first > 2 {
            parts.push(format!("{}–{}", names[first], names[k - 1]));
        } else {
            parts.extend_from_slice(&names[first..k]);
        }
        first = k;
    }
    parts.join(", ")
}

/// The functions of a process that the window needs in addition to its [`Runner`].
pub trait WindowProcess: Process {
    /// The controls of the process after the user has changed those of the window.
    fn controls(previous: &Self::Controls, window: &Controls) -> Self::Controls;

    /// The window's form of an event.
    fn events(event: Self::Event, runner: &Runner<Self>) -> Vec<RunEvent>;

    /// As [`RunHandle::radius`].
    fn radius(status: &Self::Status) -> f64;

    /// As [`RunHandle::tau`].
    fn tau(status: &Self::Status) -> Option<(f64, f64)>;

    /// As [`RunHandle::figures`].
    fn figures(runner: &Runner<Self>, shown: Option<&Snapshot<Self::State>>) -> Vec<Figures>;
}

impl<P: WindowProcess> RunHandle for Runner<P>
where
    P::State: TimelineState + 'static,
    Snapshot<P::State>: StateView,
{
    fn play(&self) {
        self.play();
    }

    fn pause(&self) {
        self.pause();
    }

    fn step(&self) {
        self.step();
    }

    fn finish(&self) {
        self.finish();
    }

    fn stop(&self) {
        self.stop();
    }

    fn set_pace(&self, pace: f64) {
        self.set_pace(Some(pace));
    }

    fn playing(&self) -> bool {
        self.playing()
    }

    fn ended(&self) -> bool {
        self.ended()
    }

    fn set_controls(&mut self, controls: &Controls) -> Result<(), String> {
        let controls = P::controls(self.controls(), controls);
        self.set_controls(&controls)
            .map_err(|error| error.to_string())
    }

    fn poll(&mut self) -> Vec<RunEvent> {
        let mut events = Vec::new();
        for event in self.poll() {
            match event {
                Event::Process(event) => events.extend(P::events(event, self)),
                Event::Refused(refused) => events.push(RunEvent::Error(refused.text)),
                Event::Failed { text } => events.push(RunEvent::Error(text)),
                Event::Paused => events.push(RunEvent::Paused),
                Event::Started
                | Event::ControlsChanged { .. }
                | Event::Rewound { .. }
                | Event::Ended => {}
            }
        }
        events
    }

    fn state_count(&self) -> usize {
        self.timeline().states.len()
    }

    fn state(&self, at: usize) -> Option<RunState> {
        let states = &self.timeline().states;
        let state = states.get(at).or(states.last())?;
        Some(Arc::clone(state) as RunState)
    }

    fn states(&self) -> Vec<RunState> {
        let states = self.timeline().states.clone();
        states.into_iter().map(|state| state as RunState).collect()
    }

    fn start_of(&self, state: &RunState) -> Option<RunState> {
        let timeline = self.timeline();
        let shares = |s: &&Arc<Snapshot<P::State>>| Arc::ptr_eq(s.topology(), state.topology());
        let first = timeline.states.iter().find(shares)?;
        Some(Arc::clone(first) as RunState)
    }

    fn bytes(&self) -> usize {
        self.timeline().bytes
    }

    fn rewind_to(&self, state: &RunState) {
        self.rewind_to(state.serial());
    }

    fn radius(&self) -> f64 {
        P::radius(self.status())
    }

    fn tau(&self) -> Option<(f64, f64)> {
        P::tau(self.status())
    }

    fn figures(&self, shown: Option<&RunState>) -> Vec<Figures> {
        let shown = shown.and_then(|state| (&**state as &dyn Any).downcast_ref());
        P::figures(self, shown)
    }
}

/// A warning with its remedy in the window.
pub(super) fn with_hint(warning: &Warning) -> String {
    let hint = match warning {
        Warning::StepLimit { mixed: false, .. } => Some("raise “Most steps” to continue"),
        Warning::StepLimit { mixed: true, .. } => Some(
            "raise “Most steps” to continue, or choose the scheme “corrected”, whose vertices do \
             not drift along the surface",
        ),
        Warning::RoundedEdges { .. } => Some("keep them by the angle “Sharp edges”"),
        _ => warning.hint(),
    };
    hint.map_or_else(|| warning.to_string(), |hint| format!("{warning} ({hint})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn successive_holes_are_listed_as_a_range() {
        let list = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            hole_list(&names)
        };
        assert_eq!(list(&[]), "");
        assert_eq!(list(&["4"]), "4");
        assert_eq!(list(&["1", "2", "4"]), "1, 2, 4");
        assert_eq!(list(&["1", "2", "3", "4", "6", "7"]), "1–4, 6, 7");
        assert_eq!(list(&["2", "5", "6", "7"]), "2, 5–7");
        assert_eq!(list(&["1", "2.1", "2.2", "3", "4"]), "1, 2.1, 2.2, 3, 4");
    }

    #[test]
    fn holes_with_the_same_words_are_listed_together() {
        let surfaces = [
            (Some(0.012), "g2"),
            (None, "diffusion"),
            (Some(0.012_000_1), "g2"),
        ];
        let surfaces = surfaces.map(|(error, model)| (error, model.to_owned()));
        let expected = [(vec![0, 2], "1.20 %, g2"), (vec![1], "diffusion")];
        let expected = expected.map(|(holes, words)| (holes, words.to_owned()));
        assert_eq!(alike(surfaces.into_iter()), expected);
    }
}
