//! One group of a live fill.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crate::fill::FillOptions;
use crate::fill::context::FillContext;
use crate::fill::group_flow::GroupFlow;
use crate::fill::live::{GroupState, GroupStatus, LiveEvent};
use crate::fill::schedule::Change;
use crate::fill::scheduled::refusal;
use crate::mesh::LoopId;
use crate::solver::{Flow, STOP, SolverError, StepRecord};

/// A group, its latest state and what was said of it.
pub(super) struct LiveGroup {
    pub run: GroupFlow,
    pub state: Arc<GroupState>,
    /// Whether its shape is another one than that of the latest state.
    pub fresh: bool,
    pub forecast: Forecast,
    last: Option<(StepRecord, usize)>,
    rejected: usize,
    end_reported: bool,
    crossing_reported: bool,
    /// Serial number of the latest state of each number of accepted steps.
    shown: BTreeMap<usize, usize>,
}

impl LiveGroup {
    pub fn start(ground: FillContext<'_>, group: usize, options: &FillOptions) -> Self {
        let run = guarded(|| GroupFlow::start(ground, group, options));
        let run =
            run.unwrap_or_else(|error| GroupFlow::failed_at_start(ground, group, options, error));
        let state = GroupState {
            step: 0,
            attempt: 0,
            positions: run.positions().into(),
            energy: run.flow().map_or(f64::NAN, |flow| flow.energy().value),
            residual: None,
            tau: 0.0,
            worst_angle: run.worst_angle(ground, &run.positions()),
            patches: Arc::clone(run.topology()),
        };
        Self {
            run,
            state: Arc::new(state),
            fresh: false,
            forecast: Forecast::default(),
            last: None,
            rejected: 0,
            end_reported: false,
            crossing_reported: false,
            shown: BTreeMap::new(),
        }
    }

    /// Attempts a step, the fill's `attempt`-th.
    pub fn attempt(&mut self, ground: FillContext<'_>, attempt: usize) -> Option<StepRecord> {
        let record = match guarded(|| self.run.attempt(ground)) {
            Ok(record) => record?,
            Err(error) => {
                self.fail(error);
                return None;
            }
        };
        if record.rejected {
            self.rejected += 1;
        } else {
            self.fresh = true;
            self.forecast.add(record.residual);
            self.last = Some((record.clone(), attempt));
        }
        Some(record)
    }

    /// Makes a change; `earlier` is where a rewind goes to.
    ///
    /// # Errors
    /// What is to be said if the group does not take part in it.
    pub fn change(
        &mut self,
        ground: FillContext<'_>,
        change: &Change,
        earlier: Option<&Arc<GroupState>>,
    ) -> Result<(), String> {
        let run = &mut self.run;
        let changed = guarded(|| match (change, earlier) {
            (Change::Options(options), _) => run.change(ground, options),
            (Change::Rewind { options, .. }, Some(to)) => {
                run.rewind(ground, &to.patches, &to.positions, to.step, options)
            }
            (Change::Rewind { .. }, None) => Ok(()),
            (Change::Stop, _) => {
                run.stop();
                Ok(())
            }
        });
        let result = match changed {
            Ok(result) => result.map_err(|error| refusal(&error)),
            Err(error) => {
                let text = error.to_string();
                self.fail(error);
                Err(text)
            }
        };
        if let Err(text) = &result {
            self.run.warn(text.clone());
        }
        let rewound = earlier.filter(|_| result.is_ok());
        if !Arc::ptr_eq(self.run.topology(), &self.state.patches) || rewound.is_some() {
            self.fresh = true;
        }
        if let Some(to) = rewound {
            self.state = Arc::clone(to);
            self.fresh = false;
            self.last = None;
        }
        self.forecast.forget();
        self.end_reported &= self.run.ended();
        result
    }

    /// The group stands still at its latest state.
    fn fail(&mut self, error: SolverError) {
        let state = &self.state;
        let patches = Arc::clone(&state.patches);
        self.run.fail(error, patches, state.positions.to_vec());
        self.fresh = false;
    }

    /// The state of the present shape.
    pub fn show(&mut self, ground: FillContext<'_>) -> Arc<GroupState> {
        if std::mem::take(&mut self.fresh) {
            let positions = self.run.positions();
            let patches = self.run.topology();
            let last = self.last.as_ref();
            self.state = Arc::new(GroupState {
                step: self.run.steps(),
                attempt: last.map_or(self.state.attempt, |(_, attempt)| *attempt),
                energy: self.run.flow().map_or(f64::NAN, |flow| flow.energy().value),
                residual: last.map(|(r, _)| r.residual),
                tau: last.map_or(0.0, |(r, _)| r.tau),
                worst_angle: self.run.worst_angle(ground, &positions),
                positions: positions.into(),
                patches: Arc::clone(patches),
            });
        }
        Arc::clone(&self.state)
    }

    /// The present state has this serial number.
    pub fn number(&mut self, index: usize) {
        self.shown.insert(self.state.step, index);
    }

    /// That the surface has begun to pass through itself, once.
    pub fn crossing_event(&mut self, group: usize, paused: bool) -> Option<LiveEvent> {
        let crossing = self.run.self_intersection();
        let before = std::mem::replace(&mut self.crossing_reported, crossing.is_some());
        let crossing = crossing.filter(|_| !before)?;
        let last_good = crossing.last_clean.and_then(|step| self.shown.get(&step));
        Some(LiveEvent::Crossing {
            group,
            place: crossing.place,
            last_good: last_good.copied(),
            paused,
            text: crossing.words(),
        })
    }

    /// How the flow has ended, once.
    pub fn end_event(&mut self, group: usize, holes: Vec<LoopId>) -> Option<LiveEvent> {
        if self.end_reported || !self.run.ended() {
            return None;
        }
        self.end_reported = true;
        let outcome = match guarded(|| self.run.outcome()) {
            Ok(Ok((outcome, _))) => return Some(LiveEvent::Finished { group, outcome }),
            Ok(Err(error)) | Err(error) => error,
        };
        let (group, text) = (Some(group), outcome.to_string());
        Some(LiveEvent::Failed { group, holes, text })
    }

    pub fn status(&self, holes: Vec<LoopId>, radius: f64, attempts: usize) -> GroupStatus {
        let flow = self.run.flow();
        GroupStatus {
            holes,
            radius,
            vertices: self.state.positions.len(),
            step: self.run.steps(),
            attempts,
            rejected: self.rejected,
            tau: flow.map_or(0.0, Flow::tau),
            tau_ref: flow.map_or(0.0, Flow::tau_ref),
            energy: flow.map_or(f64::NAN, |flow| flow.energy().value),
            residual: self.last.as_ref().map(|(r, _)| r.residual),
            end: self.run.end(),
            failed: self.run.failed().map(ToString::to_string),
            warnings: self.run.warnings(),
            eta: self.forecast.eta().filter(|_| !self.run.ended()),
        }
    }
}

/// Runs what may panic; the state it leaves behind is only used to be replaced.
fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, SolverError> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| SolverError::from_panic(&*panic))
}

/// Tells the time to the end from the last residuals.
#[derive(Debug, Default)]
pub(super) struct Forecast {
    residuals: Vec<f64>,
    /// Seconds the last round took.
    pub seconds: f64,
}

/// Steps over which the rate is taken.
const WINDOW: usize = 4;

impl Forecast {
    fn add(&mut self, residual: f64) {
        if self.residuals.len() > WINDOW {
            self.residuals.remove(0);
        }
        self.residuals.push(residual);
    }

    fn forget(&mut self) {
        self.residuals.clear();
    }

    fn eta(&self) -> Option<f64> {
        if self.residuals.len() <= WINDOW {
            return None;
        }
        let last = self.residuals[WINDOW];
        let rate = (self.residuals[0] / last).ln() / WINDOW as f64;
        let steps = (last / STOP).ln() / rate;
        (rate > 0.0 && steps.is_finite()).then_some(steps.max(0.0) * self.seconds)
    }
}
