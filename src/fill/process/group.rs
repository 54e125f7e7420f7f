//! One group of holes as a process.

use std::convert::Infallible;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use crate::fill::context::{ChangeError, FillContext};
use crate::fill::group_flow::GroupFlow;
use crate::fill::process::{FillEvent, GroupState, GroupStatus};
use crate::fill::{Controls, FillOptions};
use crate::mesh::LoopId;
use crate::runner::{Process, Refused, panic_text};
use crate::solver::{Flow, STOP, SolverError, StepRecord};
use crate::warning::Warning;

/// A group, its latest state and its reported events. If it fails, only this group ends.
pub(in crate::fill) struct GroupProgress {
    pub run: GroupFlow,
    state: Arc<GroupState>,
    /// Whether the flow has moved on from `state`.
    pub is_new: bool,
    forecast: Forecast,
    /// The last accepted step and its clock.
    last: Option<(StepRecord, usize)>,
    iterations: Option<usize>,
    rejected: usize,
    end_reported: bool,
    crossing_reported: bool,
}

impl GroupProgress {
    pub fn start(context: FillContext<'_>, group: usize, options: &FillOptions) -> Self {
        let start = || GroupFlow::start(context, group, options);
        let run = SolverError::unless_cancelled().and_then(|()| catching(start));
        let run =
            run.unwrap_or_else(|error| GroupFlow::failed_at_start(context, group, options, error));
        let positions = run.positions();
        let state = GroupState {
            step: 0,
            clock: 0,
            energy: run.flow().map_or(f64::NAN, |flow| flow.energy().value),
            residual: None,
            tau: None,
            worst_angle: run.worst_angle(context, &positions),
            positions: positions.into(),
            patches: Arc::clone(run.topology()),
        };
        Self {
            run,
            state: Arc::new(state),
            is_new: false,
            forecast: Forecast::default(),
            last: None,
            iterations: None,
            rejected: 0,
            end_reported: false,
            crossing_reported: false,
        }
    }

    /// Attempts a step, after which the clock is at `clock`.
    pub fn attempt(&mut self, context: FillContext<'_>, clock: usize) -> Option<StepRecord> {
        let record = match catching(|| self.run.attempt(context)) {
            Ok(record) => record,
            Err(error) => {
                self.fail(context, error);
                None
            }
        };
        self.is_new |= self.has_other_patches();
        let record = record?;
        self.iterations = record.iterations;
        if record.is_rejected() {
            self.rejected += 1;
        } else {
            self.is_new = true;
            self.forecast.add(record.residual);
            self.last = Some((record.clone(), clock));
        }
        Some(record)
    }

    /// Continues with other options.
    ///
    /// # Errors
    /// A message; the group continues as before.
    pub fn set_options(
        &mut self,
        context: FillContext<'_>,
        options: &FillOptions,
    ) -> Result<(), String> {
        self.change(context, |run| run.change(context, options))?;
        self.is_new |= self.has_other_patches();
        Ok(())
    }

    /// Whether patches were replaced since the latest state.
    fn has_other_patches(&self) -> bool {
        !Arc::ptr_eq(self.run.topology(), &self.state.patches)
    }

    /// Continues from an earlier state.
    ///
    /// # Errors
    /// A message; the group continues as before.
    pub fn rewind(
        &mut self,
        context: FillContext<'_>,
        to: &Arc<GroupState>,
        options: &FillOptions,
    ) -> Result<(), String> {
        self.change(context, |run| {
            run.rewind(context, &to.patches, &to.positions, to.step, options)
        })?;
        (self.state, self.is_new, self.last) = (Arc::clone(to), false, None);
        Ok(())
    }

    /// Ends the flow at the current state.
    pub fn stop(&mut self) {
        self.run.stop();
        self.forecast.residuals.clear();
    }

    fn change(
        &mut self,
        context: FillContext<'_>,
        change: impl FnOnce(&mut GroupFlow) -> Result<(), ChangeError>,
    ) -> Result<(), String> {
        let result = match catching(|| change(&mut self.run)) {
            Ok(result) => result.map_err(|error| {
                let text =
                    format!("a change was refused and the flow continues as before: {error}");
                Warning::ChangeRefused { text }
            }),
            Err(error) => {
                let reason = error.to_string();
                self.fail(context, error);
                Err(Warning::FlowFailed { reason })
            }
        };
        let result = result.map_err(|warning| {
            let text = warning.to_string();
            self.run.warn(warning);
            text
        });
        self.forecast.residuals.clear();
        self.end_reported &= self.run.ended();
        result
    }

    /// Ends the flow at the latest stored state, whose patches are then checked for soundness.
    fn fail(&mut self, context: FillContext<'_>, error: SolverError) {
        self.fail_at_state(error);
        if let Err(error) = catching(|| self.run.make_sound(context)) {
            self.fail_at_state(error);
        }
        self.is_new = self.has_other_patches();
    }

    fn fail_at_state(&mut self, error: SolverError) {
        let state = &self.state;
        let patches = Arc::clone(&state.patches);
        self.run.fail(error, patches, state.positions.to_vec());
    }

    /// The current state.
    pub fn state(&mut self, context: FillContext<'_>) -> Arc<GroupState> {
        if std::mem::take(&mut self.is_new) {
            let positions = self.run.positions();
            let patches = self.run.topology();
            let last = self.last.as_ref();
            self.state = Arc::new(GroupState {
                step: self.run.steps(),
                clock: last.map_or(self.state.clock, |(_, clock)| *clock),
                energy: self.run.flow().map_or(f64::NAN, |flow| flow.energy().value),
                residual: last.map(|(r, _)| r.residual),
                tau: last.map(|(r, _)| r.tau),
                worst_angle: self.run.worst_angle(context, &positions),
                positions: positions.into(),
                patches: Arc::clone(patches),
            });
        }
        Arc::clone(&self.state)
    }

    /// The event that the surface has begun to intersect itself, once.
    pub fn crossing_event(&mut self, group: usize) -> Option<FillEvent> {
        let crossing = self.run.self_intersection();
        let before = std::mem::replace(&mut self.crossing_reported, crossing.is_some());
        let crossing = crossing.filter(|_| !before)?;
        Some(FillEvent::SelfIntersection {
            group,
            place: crossing.place,
            last_good: crossing.last_clean,
            text: crossing.words(),
        })
    }

    /// The events that the flow has ended, and what was found about the patches, once.
    pub fn end_events(&mut self, group: usize, holes: &[LoopId]) -> Vec<FillEvent> {
        if self.end_reported || !self.run.ended() {
            return Vec::new();
        }
        self.end_reported = true;
        let end = match catching(|| self.run.outcome()) {
            Ok(Ok((outcome, _))) => FillEvent::Finished { group, outcome },
            Ok(Err(error)) | Err(error) => FillEvent::Failed {
                group: Some(group),
                holes: holes.to_vec(),
                text: error.to_string(),
            },
        };
        let warnings = self.run.patch_warnings().iter().cloned();
        let warned = warnings.map(|(hole, warning)| FillEvent::Warned { hole, warning });
        std::iter::once(end).chain(warned).collect()
    }

    /// The holes with patches that are left with defects, each once.
    fn unsound(&self) -> Vec<LoopId> {
        let warnings = self.run.patch_warnings().iter();
        let unsound = warnings.filter(|(_, warning)| warning.is_unsound());
        let mut holes: Vec<LoopId> = unsound.map(|(hole, _)| *hole).collect();
        holes.dedup();
        holes
    }

    /// The status; `seconds` is the time a step takes.
    pub fn status(
        &self,
        holes: Vec<LoopId>,
        closed: Vec<Vec<LoopId>>,
        radius: f64,
        seconds: f64,
    ) -> GroupStatus {
        let flow = self.run.flow();
        GroupStatus {
            holes,
            closed,
            radius,
            surface: self.run.surface(),
            step: self.run.steps(),
            rejected: self.rejected,
            iterations: self.iterations,
            tau: flow.map_or(0.0, Flow::tau),
            tau_ref: flow.map_or(0.0, Flow::tau_ref),
            residual: self.last.as_ref().map(|(r, _)| r.residual),
            end: self.run.end(),
            failed: self.run.failed().map(ToString::to_string),
            unsound: self.unsound(),
            eta: self
                .forecast
                .eta(seconds, self.run.steps_left())
                .filter(|_| !self.run.ended()),
        }
    }
}

/// A single group: without an interactive caller, groups run independently of each other.
pub(in crate::fill) struct GroupProcess<'a> {
    pub context: FillContext<'a>,
    pub group: GroupProgress,
}

impl GroupProcess<'_> {
    fn changed(
        &mut self,
        controls: &Controls,
        change: impl FnOnce(&mut GroupProgress, &FillOptions) -> Result<(), String>,
    ) -> Vec<Refused> {
        let options = controls.options().map_err(|error| error.to_string());
        let result = options.and_then(|options| change(&mut self.group, &options));
        let refused = |text| Refused { part: None, text };
        result.err().map(refused).into_iter().collect()
    }
}

impl Process for GroupProcess<'_> {
    type Controls = Controls;
    type State = GroupState;
    type Event = StepRecord;
    type Status = ();
    type Error = Infallible;

    fn advance(
        &mut self,
        clock: usize,
        emit: &mut dyn FnMut(StepRecord),
    ) -> Result<(), Infallible> {
        if let Some(record) = self.group.attempt(self.context, clock) {
            emit(record);
        }
        Ok(())
    }

    fn set_controls(&mut self, controls: &Controls) -> Vec<Refused> {
        let context = self.context;
        self.changed(controls, |group, options| {
            group.set_options(context, options)
        })
    }

    fn rewind(&mut self, to: &Arc<GroupState>, controls: &Controls) -> Vec<Refused> {
        let context = self.context;
        self.changed(controls, |group, options| {
            group.rewind(context, to, options)
        })
    }

    fn stop(&mut self, _: &mut dyn FnMut(StepRecord)) {
        self.group.stop();
    }

    fn ended(&self) -> bool {
        self.group.run.ended()
    }

    fn has_new_state(&self) -> bool {
        self.group.is_new
    }

    fn state(&mut self) -> Result<Arc<GroupState>, Infallible> {
        Ok(self.group.state(self.context))
    }

    fn status(&mut self, _: f64, _: &mut dyn FnMut(StepRecord)) {}
}

/// Runs a function that may panic. After a panic the state of the group is only replaced, never
/// used.
fn catching<T>(work: impl FnOnce() -> T) -> Result<T, SolverError> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| SolverError::Panic(panic_text(&*panic)))
}

/// Estimates the time to the end from the last residuals.
#[derive(Debug, Default)]
struct Forecast {
    residuals: Vec<f64>,
}

/// Number of steps over which the rate is estimated.
const WINDOW: usize = 4;

impl Forecast {
    fn add(&mut self, residual: f64) {
        if self.residuals.len() > WINDOW {
            self.residuals.remove(0);
        }
        self.residuals.push(residual);
    }

    /// Seconds to the end where a step takes `seconds` and at most `most` steps are left.
    fn eta(&self, seconds: f64, most: usize) -> Option<f64> {
        if self.residuals.len() <= WINDOW {
            return None;
        }
        let last = self.residuals[WINDOW];
        let rate = (self.residuals[0] / last).ln() / WINDOW as f64;
        let steps = (last / STOP).ln() / rate;
        let steps = steps.clamp(0.0, most as f64);
        (rate > 0.0).then_some(steps * seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_to_the_end_is_at_most_that_of_the_steps_left() {
        let eta = |rate: f64, most: usize| {
            let mut forecast = Forecast::default();
            for k in 0..10 {
                forecast.add(rate.powi(k));
            }
            forecast.eta(2.0, most)
        };
        // from 1e-9 to the end, one step for each power of ten
        assert_eq!(eta(0.1, 100), Some(0.0));
        let steps = (STOP / 0.5f64.powi(9)).ln() / 0.5f64.ln();
        let expected = eta(0.5, 100).expect("a rate");
        assert!((expected - 2.0 * steps).abs() < 1e-9);
        // residuals that hardly fall
        assert_eq!(eta(0.9999, 100), Some(200.0));
        assert_eq!(eta(1.0, 100), None);
        assert_eq!(eta(1.1, 100), None);
    }
}
