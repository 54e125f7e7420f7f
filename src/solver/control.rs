//! Step size, acceptance and the stopping rule (formulation, section 6).

use serde::{Deserialize, Serialize};

use crate::linear::GmresReport;
use crate::options::{OptionError, OptionValue, choices};
use crate::solver::assembly::EnergySum;
use crate::solver::record::{RejectReason, StepKind};

/// The purpose of the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Mode {
    /// The stationary shape in as few steps as possible.
    #[default]
    Fast,
    /// The flow in true time, to show its intermediate shapes.
    Flow,
}

choices!(Mode: Fast "fast", Flow "flow");

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tau {
    /// Adaptive: grows after accepted steps and shrinks after rejected ones.
    #[default]
    Auto,
    /// Always this value (length² / unit of f), reduced only where a step is rejected.
    Fixed(f64),
}

impl OptionValue for Tau {
    fn text(&self) -> Option<String> {
        match self {
            Self::Auto => Some("auto".into()),
            Self::Fixed(tau) => tau.text(),
        }
    }

    fn set(&mut self, text: &str, form: &str) -> Result<(), OptionError> {
        let mut tau = None;
        tau.set(text, form).map_err(|error| OptionError {
            remedy: "write `auto` or a positive number".into(),
            ..error
        })?;
        *self = tau.map_or(Self::Auto, Self::Fixed);
        Ok(())
    }
}

/// The options of a run that reaches the stationary shape in the fewest steps, by name and text.
pub const FASTEST: &[(&str, &str)] = &[("mode", "fast"), ("tau", "auto"), ("growth", "auto")];

/// The outcome of one attempted step.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Largest displacement of a vertex; 0 if rejected.
    pub max_displacement: f64,
    /// The method of its computation.
    pub kind: StepKind,
    /// Whether the next step needs a new matrix: a quasi-Newton phase ended, or vertices were frozen.
    pub needs_refactorization: bool,
    /// Scheme A: the result of the linear solve.
    pub linear: Option<GmresReport>,
    /// Why the step was rejected; `None` if it was accepted.
    pub rejection: Option<RejectReason>,
}

impl Attempt {
    pub(crate) fn accepted(max_displacement: f64, kind: StepKind) -> Self {
        Self {
            max_displacement,
            kind,
            needs_refactorization: false,
            linear: None,
            rejection: None,
        }
    }

    pub(crate) fn rejected(reason: RejectReason) -> Self {
        Self {
            max_displacement: 0.0,
            kind: StepKind::Factorized,
            needs_refactorization: false,
            linear: None,
            rejection: Some(reason),
        }
    }

    /// Whether the step was accepted.
    pub fn is_accepted(&self) -> bool {
        self.rejection.is_none()
    }
}

impl EnergySum {
    /// Whether a step to energy `new` is acceptable: finite, and not higher by more than rounding.
    pub fn admits(&self, new: &Self) -> bool {
        new.value.is_finite() && new.value <= self.value + 1e-12 * self.scale
    }
}

/// Relative displacement (of the hole radius) below which a step counts as zero.
pub const STOP: f64 = 1e-6;
/// Minimum of τ over `τ_ref`. Below it, no step is expected to lower the energy.
const MIN_TAU_RATIO: f64 = 1e-14;
const SHRINK: f64 = 8.0;
const FAST_GROWTH: f64 = 10.0;
/// Range of the first τ in flow mode, as multiples of `τ_ref`. From a warm start near the
/// stationary shape, the edge-limited τ alone would converge within a few steps.
const FIRST: [f64; 2] = [1e-9, 1e-4];
/// Growth of τ in flow mode. From the upper end of `FIRST` to `τ_ref` it takes more than thirty
/// steps, so that the flow can be watched.
pub const FLOW_GROWTH: f64 = 1.3;
/// Accepted steps after which an energy that has not fallen beyond rounding counts as constant.
const PATIENCE: usize = 10;
/// Decrease of the energy that counts as zero, relative to the sum of its absolute terms.
pub const STAGNATION: f64 = 1e-11;
/// The same under constraints, where vertices move along the surface long after its shape has
/// converged.
pub const STAGNATION_CONSTRAINED: f64 = 1e-8;
/// Maximum of τ over `τ_ref`; at this τ a step is practically a Newton step.
const MAX_TAU_RATIO: f64 = 1e12;

/// Tests whether an energy still decreases.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StagnationTest {
    start: EnergySum,
    steps: usize,
}

impl StagnationTest {
    /// Records the energy after an accepted step. Returns whether ten steps have not lowered it by
    /// more than `part` of the sum of its absolute terms.
    pub fn has_stagnated(&mut self, energy: EnergySum, part: f64) -> bool {
        self.steps += 1;
        if self.start.value - energy.value > part * energy.scale || self.steps == 1 {
            *self = Self {
                start: energy,
                steps: 1,
            };
        }
        self.steps > PATIENCE
    }
}

/// Control of the time step.
#[derive(Clone, Copy, Debug)]
pub struct StepSizeControl {
    /// The next step's τ.
    pub tau: f64,
    /// The natural time of the hole, `r² / f̂`.
    pub tau_ref: f64,
    growth: f64,
    wanted: Option<f64>,
}

impl StepSizeControl {
    /// The control for a mode. `gentle` is the proposed first τ of a flow in true time. `growth` is
    /// the factor after an accepted step; `None` selects the default of the mode.
    pub fn new(mode: Mode, tau: Tau, tau_ref: f64, gentle: f64, growth: Option<f64>) -> Self {
        let (start, wanted) = match (tau, mode) {
            (Tau::Fixed(t), _) => (t, Some(t)),
            (Tau::Auto, Mode::Fast) => (2.0 * tau_ref, None),
            (Tau::Auto, Mode::Flow) => {
                let [least, most] = FIRST.map(|part| part * tau_ref);
                (gentle.clamp(least, most), None)
            }
        };
        Self {
            tau: start,
            tau_ref,
            growth: growth.unwrap_or(match mode {
                Mode::Fast => FAST_GROWTH,
                Mode::Flow => FLOW_GROWTH,
            }),
            wanted,
        }
    }

    /// Sets the τ that follows an accepted step.
    pub fn next(&self) -> f64 {
        match self.wanted {
            Some(t) => t.min(2.0 * self.tau),
            None => (self.tau * self.growth).min(MAX_TAU_RATIO * self.tau_ref),
        }
    }

    /// Records that a factorized step was accepted.
    pub fn accept(&mut self) {
        self.tau = self.next();
    }

    /// Records a rejected step. Returns whether τ has collapsed.
    pub fn reject(&mut self) -> bool {
        self.tau /= SHRINK;
        self.tau < MIN_TAU_RATIO * self.tau_ref.min(self.wanted.unwrap_or(f64::INFINITY))
    }

    /// Displacement of a step of time `tau`, scaled to `τ_ref`, over the hole radius.
    pub fn residual(&self, displacement: f64, tau: f64, radius: f64) -> f64 {
        displacement / radius * (self.tau_ref / tau).max(1.0)
    }
}

#[cfg(test)]
#[path = "control_tests.rs"]
mod tests;
