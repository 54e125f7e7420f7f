//! Flows of both kinds behind one face: fills and refinements.

mod figures;

use std::sync::Arc;

use crate::fill::{Controls, LiveEvent, LiveFill, Schedule, State};
use crate::mesh::{DVec3, Mesh, Topology};
use crate::refine::{LiveRefine, RefineEvent, RefineState, natural_flow};
use crate::solver::{FlowOptions, StepRecord};

/// A flow in the background.
pub enum Live {
    /// A fill, blend, refill or fairing.
    Fill(Box<LiveFill>),
    /// A refinement.
    Refine(Box<LiveRefine>),
}

/// A kept state of a flow.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Of a fill.
    Fill(Arc<State>),
    /// Of a refinement.
    Refine(Arc<RefineState>),
}

/// Something a flow says, as far as the window cares.
pub enum Said {
    /// A step was attempted by a group.
    Step(usize, StepRecord),
    /// It began to pass through itself or the mesh.
    Crossing {
        /// What happened, and which state is the last without.
        text: String,
        /// Where.
        place: DVec3,
        /// Whether it waits now.
        pauses: bool,
    },
    /// A message.
    Note(String),
    /// A warning.
    Warning(String),
    /// An error.
    Error(String),
}

impl Live {
    /// Goes on until the end.
    pub fn play(&self) {
        match self {
            Self::Fill(live) => live.play(),
            Self::Refine(live) => live.play(),
        }
    }

    /// Waits after the present step.
    pub fn pause(&self) {
        match self {
            Self::Fill(live) => live.pause(),
            Self::Refine(live) => live.pause(),
        }
    }

    /// One step, then waits.
    pub fn step(&self) {
        match self {
            Self::Fill(live) => live.step(),
            Self::Refine(live) => live.step(),
        }
    }

    /// Goes on to the end in fast mode.
    pub fn finish(&mut self) {
        match self {
            Self::Fill(live) => live.finish(),
            Self::Refine(live) => live.finish(),
        }
    }

    /// Ends at the present shape.
    pub fn stop(&mut self) {
        match self {
            Self::Fill(live) => live.stop(),
            Self::Refine(live) => live.stop(),
        }
    }

    /// States a second, at most.
    pub fn set_pace(&self, pace: f64) {
        match self {
            Self::Fill(live) => live.set_pace(Some(pace)),
            Self::Refine(live) => live.set_pace(Some(pace)),
        }
    }

    /// Whether it runs (or would, had it not ended) or waits.
    pub fn playing(&self) -> bool {
        match self {
            Self::Fill(live) => live.playing(),
            Self::Refine(live) => live.playing(),
        }
    }

    /// Whether it had ended at the last [`Self::poll`].
    pub fn ended(&self) -> bool {
        match self {
            Self::Fill(live) => live.ended(),
            Self::Refine(live) => live.ended(),
        }
    }

    /// Changes controls from the next step on; `base` is the mesh it was started on, and
    /// `own_energy` whether a refinement has the energy of its edge length.
    ///
    /// # Errors
    /// A message for the person; the flow goes on as before.
    pub fn set_controls(
        &mut self,
        controls: &Controls,
        base: &Mesh,
        own_energy: bool,
    ) -> Result<(), String> {
        match self {
            Self::Fill(live) => live.set_controls(controls).map_err(|e| e.to_string()),
            Self::Refine(live) => {
                let flow = refining_flow(controls, base, own_energy)?;
                live.set_flow(flow).map_err(|e| e.to_string())
            }
        }
    }

    /// What was said since the last call.
    pub fn poll(&mut self) -> Vec<Said> {
        let mut said = Vec::new();
        match self {
            Self::Fill(live) => {
                for event in live.poll() {
                    match event {
                        LiveEvent::Step { group, record } => said.push(Said::Step(group, record)),
                        LiveEvent::Crossing {
                            text,
                            place,
                            last_good,
                            paused,
                            ..
                        } => said.push(Said::Crossing {
                            text: crossing_words(live, &text, last_good),
                            place,
                            pauses: paused,
                        }),
                        LiveEvent::Finished { outcome, .. } => {
                            said.extend(outcome.warnings.into_iter().map(Said::Warning));
                        }
                        LiveEvent::ControlsRefused { text, .. }
                        | LiveEvent::Failed { text, .. } => said.push(Said::Error(text)),
                        LiveEvent::Planned
                        | LiveEvent::ControlsChanged { .. }
                        | LiveEvent::Rewound { .. } => {}
                    }
                }
            }
            Self::Refine(live) => {
                for event in live.poll() {
                    match event {
                        RefineEvent::Step { record, .. } => said.push(Said::Step(0, record)),
                        RefineEvent::LevelDone(report) => {
                            // the schemes without a flow take no step
                            if report.steps > 0 {
                                said.push(Said::Note(format!(
                                    "level {}: {} vertices, energy {:.6e}, {} steps, {}",
                                    report.level,
                                    report.vertices,
                                    report.energy_end,
                                    report.steps,
                                    report.end
                                )));
                            }
                            let level = report.level;
                            let warning = |text| Said::Warning(format!("level {level}: {text}"));
                            said.extend(report.warnings.into_iter().map(warning));
                        }
                        RefineEvent::OptionsRefused { text } | RefineEvent::Failed { text } => {
                            said.push(Said::Error(text));
                        }
                        RefineEvent::Level { .. }
                        | RefineEvent::OptionsChanged
                        | RefineEvent::Finished => {}
                    }
                }
            }
        }
        said
    }

    /// Number of kept states.
    pub fn state_count(&self) -> usize {
        match self {
            Self::Fill(live) => live.timeline().states.len(),
            Self::Refine(live) => live.timeline().states.len(),
        }
    }

    /// A kept state by its place; the newest if there is none.
    pub fn state(&self, at: usize) -> Option<Shape> {
        match self {
            Self::Fill(live) => {
                let states = &live.timeline().states;
                states.get(at).or(states.last()).cloned().map(Shape::Fill)
            }
            Self::Refine(live) => {
                let states = &live.timeline().states;
                states.get(at).or(states.last()).cloned().map(Shape::Refine)
            }
        }
    }

    /// All kept states, oldest first.
    pub fn states(&self) -> Vec<Shape> {
        match self {
            Self::Fill(live) => {
                let states = live.timeline().states.clone();
                states.into_iter().map(Shape::Fill).collect()
            }
            Self::Refine(live) => {
                let states = live.timeline().states.clone();
                states.into_iter().map(Shape::Refine).collect()
            }
        }
    }

    /// The first state with the vertices of another.
    pub fn start_of(&self, shape: &Shape) -> Option<Shape> {
        match (self, shape) {
            (Self::Fill(_), _) => self.state(0),
            (Self::Refine(live), Shape::Refine(state)) => {
                let timeline = live.timeline();
                let mut states = timeline.states.iter();
                let first = states.find(|s| Arc::ptr_eq(&s.frame, &state.frame));
                first.cloned().map(Shape::Refine)
            }
            (Self::Refine(_), Shape::Fill(_)) => None,
        }
    }

    /// Bytes the kept states take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Fill(live) => live.timeline().bytes,
            Self::Refine(live) => live.timeline().bytes,
        }
    }

    /// Whether it can go on from earlier states.
    pub fn rewinds(&self) -> bool {
        matches!(self, Self::Fill(_))
    }

    /// Goes on from a kept state, where it can.
    pub fn rewind_to(&mut self, shape: &Shape) {
        if let (Self::Fill(live), Shape::Fill(state)) = (self, shape) {
            live.rewind_to(state.index);
        }
    }

    /// What repeats the changes on the way up to a state; nothing of a refinement.
    pub fn schedule_to(&self, shape: Option<&Shape>) -> Schedule {
        match (self, shape) {
            (Self::Fill(live), Some(Shape::Fill(state))) => live.schedule_to(state),
            (Self::Fill(live), _) => live.schedule(),
            (Self::Refine(_), _) => Schedule::default(),
        }
    }

    /// The whole mesh at a state.
    pub fn mesh_at(&self, shape: &Shape) -> Option<Mesh> {
        match (self, shape) {
            (Self::Fill(live), Shape::Fill(state)) => Some(live.mesh_at(state)),
            (Self::Refine(live), Shape::Refine(state)) => Some(live.mesh_at(state)),
            _ => None,
        }
    }

    /// The largest radius of its groups, 0 for a refinement.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Fill(live) => live.groups().iter().map(|g| g.radius).fold(0.0, f64::max),
            Self::Refine(_) => 0.0,
        }
    }

    /// The next time step and the natural time, of the first group of holes.
    pub fn tau(&self) -> Option<(f64, f64)> {
        match self {
            Self::Fill(live) => live.groups().first().map(|g| (g.tau, g.tau_ref)),
            Self::Refine(_) => None,
        }
    }
}

fn crossing_words(live: &LiveFill, text: &str, last_good: Option<usize>) -> String {
    let timeline = live.timeline();
    let at = |index| timeline.states.iter().position(|s| s.index == index);
    let back = last_good.and_then(at).map_or_else(String::new, |at| {
        let number = at + 1;
        format!("; state {number} is the last that was looked at and does not")
    });
    format!("the surface passes through itself or the mesh: {text}{back}")
}

impl Shape {
    /// Whether both are the same state.
    pub fn same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Fill(a), Self::Fill(b)) => Arc::ptr_eq(a, b),
            (Self::Refine(a), Self::Refine(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }

    /// Connectivity of the whole mesh; of a refinement cut open along creases.
    pub fn topology(&self) -> &Arc<Topology> {
        match self {
            Self::Fill(state) => state.topology(),
            Self::Refine(state) => &state.frame.topology,
        }
    }

    /// Positions of all vertices: control points of the limit surface, or with `flat` those of the
    /// mesh that is saved. `base` is the mesh the flow was started on.
    pub fn positions(&self, base: &Mesh, flat: bool) -> Vec<DVec3> {
        match self {
            Self::Fill(state) => state.positions(base),
            Self::Refine(state) if flat || !state.frame.has_limit => state.points.to_vec(),
            Self::Refine(state) => state.control.to_vec(),
        }
    }

    /// Whether it has a smooth limit surface.
    pub fn has_limit(&self) -> bool {
        match self {
            Self::Fill(_) => true,
            Self::Refine(state) => state.frame.has_limit,
        }
    }

    /// Whether its mesh is cut open along creases.
    pub fn is_cut(&self) -> bool {
        match self {
            Self::Fill(_) => false,
            Self::Refine(state) => state.frame.weld.is_some(),
        }
    }

    /// Whether all of the surface moves.
    pub fn is_whole(&self) -> bool {
        matches!(self, Self::Refine(_))
    }

    /// Attempts before it.
    pub fn attempt(&self) -> usize {
        match self {
            Self::Fill(state) => state.attempt,
            Self::Refine(state) => state.attempt,
        }
    }
}

/// What a refinement takes of the controls.
///
/// # Errors
/// Mistaken controls, for the person.
pub fn refining_flow(
    controls: &Controls,
    base: &Mesh,
    own_energy: bool,
) -> Result<FlowOptions, String> {
    let mut flow = controls.options().map_err(|e| e.to_string())?.flow;
    if own_energy {
        (flow.energy, flow.tension) = natural_flow(base);
    }
    Ok(flow)
}
