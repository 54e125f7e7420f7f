//! A fill in progress: the live flow, what of it is shown, and what it was started with.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::document::{Document, Work, left_of};
use super::jobs::Wake;
use crate::fill::{
    Controls, LiveError, LiveEvent, LiveFill, LiveSettings, Opening, State, open_selection,
};
use crate::mesh::{BoundaryLoop, Mesh, face_flags};

/// Bytes of kept states for each side; beyond it every other state is dropped.
pub const TIMELINE_BYTES: usize = 512 << 20;

/// One flow on the selected holes.
pub struct Side {
    /// The flow.
    pub live: LiveFill,
    /// Controls at its start.
    pub start: Controls,
    /// Controls in force.
    pub controls: Controls,
    /// State that is shown; `None` for the newest.
    pub shown: Option<usize>,
    /// Energy of each accepted step and residual, one pair of curves a group.
    pub curves: Vec<Curve>,
    /// What it warned of, without repetition.
    pub warnings: Vec<String>,
}

/// Points of the plots of one group: `[attempt, value]`.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Energy.
    pub energy: Vec<[f64; 2]>,
    /// Residual, decadic logarithm.
    pub residual: Vec<[f64; 2]>,
    /// Attempts so far.
    attempts: usize,
}

/// One fill, or two that are compared.
pub struct Run {
    /// What it does.
    pub work: Work,
    /// The mesh it works on: the document's, or what is left of that after erasing.
    pub base: Arc<Mesh>,
    /// Faces of `base` from here on were patches before.
    pub first_patch_face: usize,
    /// The faces of the document that are left in `base`, if some were erased.
    pub kept: Option<Vec<u32>>,
    /// The loops of `base` it fills or joins.
    pub loops: Vec<BoundaryLoop>,
    /// One side, or A and B.
    pub sides: Vec<Side>,
    /// Whether it plays.
    pub playing: bool,
    /// When the replay of kept states moves on.
    next_frame: Option<Instant>,
}

impl Run {
    /// Starts flows of the same work, one for each set of controls.
    ///
    /// # Errors
    /// A message for the person.
    pub fn start(
        work: Work,
        document: &Document,
        controls: &[Controls],
        pace: f64,
        wake: &Wake,
    ) -> Result<Self, String> {
        let mut base = Arc::clone(&document.mesh);
        let mut first_patch_face = document.first_patch_face;
        let (mut kept, mut loops) = (None, Vec::new());
        match &work {
            Work::Fill(_) | Work::Blend(_) => {
                loops = document.selected().into_iter().cloned().collect();
            }
            Work::Refill(faces) => {
                let flags = face_flags(faces, base.face_count());
                let opening = open_selection(&base, &flags).map_err(|e| e.to_string())?;
                let Opening {
                    erased,
                    loops: all,
                    opened,
                } = opening;
                loops = opened.into_iter().map(|i| all[i].clone()).collect();
                first_patch_face = left_of(&erased.old_face, first_patch_face);
                base = Arc::new(erased.mesh);
                kept = Some(erased.old_face);
            }
            Work::Fair(_) => {}
            Work::Erase(_) | Work::Flip(_) => return Err("there is no flow in that".into()),
        }
        let spawn = |controls: &Controls, settings| -> Result<LiveFill, LiveError> {
            let (mesh, wake) = (Arc::clone(&base), Arc::clone(wake));
            let (loops, controls) = (loops.clone(), controls.clone());
            match &work {
                Work::Fair(faces) => {
                    let flags = face_flags(faces, mesh.face_count());
                    LiveFill::spawn_fair(mesh, flags, controls, settings, wake)
                }
                Work::Blend(_) => LiveFill::spawn_blend(mesh, loops, controls, settings, wake),
                _ => LiveFill::spawn(mesh, loops, controls, settings, wake),
            }
        };
        let sides = controls
            .iter()
            .map(|controls| {
                let settings = LiveSettings {
                    playing: true,
                    pace: Some(pace),
                    timeline_bytes: TIMELINE_BYTES,
                };
                let live = spawn(controls, settings).map_err(|error| error.to_string())?;
                Ok(Side {
                    live,
                    start: controls.clone(),
                    controls: controls.clone(),
                    shown: None,
                    curves: Vec::new(),
                    warnings: Vec::new(),
                })
            })
            .collect::<Result<_, String>>()?;
        Ok(Self {
            work,
            base,
            first_patch_face,
            kept,
            loops,
            sides,
            playing: true,
            next_frame: None,
        })
    }

    /// Takes in what the flows have said. Returns messages for the log: `(is an error, text)`.
    pub fn poll(&mut self) -> Vec<(bool, String)> {
        let mut messages = Vec::new();
        for side in &mut self.sides {
            for event in side.live.poll() {
                match event {
                    LiveEvent::Step { group, record } => side.book(group, &record),
                    LiveEvent::Finished { outcome, .. } => {
                        for warning in outcome.warnings {
                            if !side.warnings.contains(&warning) {
                                messages.push((false, warning.clone()));
                                side.warnings.push(warning);
                            }
                        }
                    }
                    LiveEvent::ControlsRefused { text, .. } | LiveEvent::Failed { text, .. } => {
                        messages.push((true, text));
                    }
                    LiveEvent::Planned
                    | LiveEvent::ControlsChanged { .. }
                    | LiveEvent::Rewound { .. } => {}
                }
            }
        }
        if self.playing && self.ended() {
            self.playing = false;
        }
        messages
    }

    /// The faces that flow as they are, ascending.
    pub fn faired(&self) -> Arc<Vec<u32>> {
        match &self.work {
            Work::Fair(faces) => Arc::clone(faces),
            _ => Arc::default(),
        }
    }

    /// Whether every flow has ended.
    pub fn ended(&self) -> bool {
        self.sides.iter().all(|s| s.live.ended())
    }

    /// Whether older states than the newest are shown.
    pub fn scrubbed(&self) -> bool {
        self.sides.iter().any(|s| s.shown.is_some())
    }

    /// Shows the state at a place of the timeline (of the longest side); `None` for the newest.
    pub fn scrub(&mut self, at: Option<usize>) {
        for side in &mut self.sides {
            let last = side.state_count().saturating_sub(1);
            side.shown = at.filter(|&i| i < last);
        }
    }

    /// Number of kept states, of the longest side.
    pub fn state_count(&self) -> usize {
        self.sides.iter().map(Side::state_count).max().unwrap_or(0)
    }

    /// Moves a replay of kept states on, `pace` states a second. Returns when it wants to be
    /// called again, `None` while nothing is replayed.
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
                // the replay has caught up with the flow
                self.playing = !self.ended();
                for side in &self.sides {
                    side.live.play();
                }
            }
        }
        self.next_frame
            .map(|due| due.saturating_duration_since(now))
    }
}

impl Side {
    /// The energy is another one: its curve begins anew.
    pub fn new_energy(&mut self) {
        for curve in &mut self.curves {
            curve.energy.clear();
        }
    }

    fn book(&mut self, group: usize, record: &crate::solver::StepRecord) {
        if self.curves.len() <= group {
            self.curves.resize(group + 1, Curve::default());
        }
        let curve = &mut self.curves[group];
        curve.attempts += 1;
        if record.rejected {
            return;
        }
        let x = curve.attempts as f64;
        curve.energy.push([x, record.energy]);
        if record.residual > 0.0 {
            curve.residual.push([x, record.residual.log10()]);
        }
    }

    /// The largest radius of its groups.
    pub fn radius(&self) -> f64 {
        let groups = self.live.groups().iter();
        groups.map(|g| g.radius).fold(0.0, f64::max)
    }

    /// Number of kept states.
    pub fn state_count(&self) -> usize {
        self.live.timeline().states.len()
    }

    /// The state that is shown; `None` before the first.
    pub fn state(&self) -> Option<Arc<State>> {
        let states = &self.live.timeline().states;
        match self.shown {
            Some(i) => states.get(i).or(states.last()).cloned(),
            None => states.last().cloned(),
        }
    }
}
