//! The flow of one level, in two phases.
//!
//! In fast mode a level starts with [`FullGradientDescent`], which lets vertices slide along the
//! surface. Once that gains little, the normal flow takes over. A flow in true time is normal from
//! the start.

use std::time::Instant;

use crate::memory::peak_memory;
use crate::mesh::DVec3;
use crate::refine::descent::FullGradientDescent;
use crate::refine::progress::LevelReport;
use crate::solver::{
    End, Flow, FlowOptions, FlowProblem, MakeStepper, Mode, Scheme, SolverError, StepRecord,
    scheme_stepper,
};
use crate::subdivision::Rule;
use crate::warning::Warning;

/// The descent may take one in so many of the steps.
const DESCENT_SHARE: usize = 2;
/// The normal flow takes over when so many steps together gained less than this part.
const SETTLED: (usize, f64) = (10, 1e-4);

/// The flow of the level under way.
pub struct LevelFlow {
    /// Levels after this one.
    splits: usize,
    /// Constraints that the surface came to pass only by folding.
    pub unreached: usize,
    /// The flow.
    pub flow: Flow,
    /// When the level was begun.
    start: Instant,
    /// Vertices the limit surface passes, and where.
    pub constraints: Vec<(u32, DVec3)>,
    /// In the descent, the energies after its accepted steps.
    descent: Option<Vec<f64>>,
}

/// What makes the steppers of a level's first phase, and whether that is the descent.
fn first_phase(mode: Mode) -> (MakeStepper, Option<Vec<f64>>) {
    match mode {
        Mode::Fast => (FullGradientDescent::make, Some(Vec::new())),
        Mode::Flow => (scheme_stepper, None),
    }
}

impl LevelFlow {
    /// The flow of a level begun at `start`, with `splits` levels to come. `constraints` are those
    /// of the problem; `unreached` of them are passed only by folding.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn new(
        problem: FlowProblem,
        options: &FlowOptions,
        splits: usize,
        constraints: Vec<(u32, DVec3)>,
        unreached: usize,
        start: Instant,
    ) -> Result<Self, SolverError> {
        let (make, descent) = first_phase(options.mode);
        let options = level_options(options, splits);
        Ok(Self {
            splits,
            unreached,
            flow: Flow::with_stepper(problem, options, make)?,
            start,
            constraints,
            descent,
        })
    }

    /// Counts the steps from a later state of the level.
    #[must_use]
    pub fn counting_from(mut self, steps: usize) -> Self {
        self.flow = self.flow.counting_from(steps, 0);
        self
    }

    /// Changes options; the flow goes on from the current shape in its first phase.
    ///
    /// # Errors
    /// The new options are refused and the old ones stay in force.
    pub fn set_options(&mut self, options: &FlowOptions) -> Result<(), SolverError> {
        let (make, descent) = first_phase(options.mode);
        self.flow
            .restart(level_options(options, self.splits), make)?;
        self.descent = descent;
        Ok(())
    }

    /// Attempts one step. `None` once the flow has ended.
    ///
    /// # Errors
    /// As [`Flow::step`].
    pub fn step(&mut self) -> Result<Option<StepRecord>, SolverError> {
        if let Some(record) = self.flow.step()? {
            if self.has_settled(&record) {
                self.switch_to_normal_flow()?;
            }
            return Ok(Some(record));
        }
        if self.descent.is_some() && self.flow.end() == Some(End::StepSizeCollapsed) {
            // sliding along the surface no longer helps; the normal flow may still
            self.switch_to_normal_flow()?;
            return self.step();
        }
        Ok(None)
    }

    /// Whether the descent ends with a step.
    fn has_settled(&mut self, record: &StepRecord) -> bool {
        let Some(energies) = self.descent.as_mut().filter(|_| !record.rejected) else {
            return false;
        };
        energies.push(record.energy);
        let (count, part) = SETTLED;
        let n = energies.len();
        let gains_little = n > count && {
            let before = energies[n - 1 - count];
            before - record.energy < part * before.abs()
        };
        gains_little
            || DESCENT_SHARE * record.step >= self.flow.options().max_steps
            || self.flow.end().is_some()
    }

    fn switch_to_normal_flow(&mut self) -> Result<(), SolverError> {
        self.descent = None;
        if self.flow.end() == Some(End::Cancelled) {
            return Ok(());
        }
        self.flow
            .restart(self.flow.options().clone(), scheme_stepper)
    }

    /// The report of the level, on a mesh of so many vertices and faces.
    pub fn report(&mut self, level: usize, vertices: usize, faces: usize) -> LevelReport {
        let outcome = self.flow.outcome();
        let problem = self.flow.problem();
        let mut warnings = outcome.warnings;
        if self.unreached > 0 {
            warnings.push(Warning::Unreached {
                vertices: self.unreached,
            });
        }
        LevelReport {
            level,
            vertices,
            faces,
            steps: outcome.steps,
            rejected: outcome.rejected,
            converged: outcome.end == End::Converged,
            end: match outcome.end {
                End::Converged => "converged",
                End::MaxSteps => "steps",
                End::StepSizeCollapsed | End::Pinched | End::SelfIntersected => "stuck",
                End::Cancelled => "cancelled",
            },
            energy_start: outcome.energy_start,
            energy_end: outcome.energy_end,
            held_error: problem
                .interpolation()
                .map(|i| i.error(self.flow.positions()) / problem.radius()),
            seconds: self.start.elapsed().as_secs_f64(),
            peak_memory: peak_memory(),
            warnings,
        }
    }
}

/// The options of a level's flow. Its quadrature has the 12 points of each triangle there will be
/// after the `splits` to come, because coarse meshes fold between fewer points.
fn level_options(flow: &FlowOptions, splits: usize) -> FlowOptions {
    FlowOptions {
        scheme: Scheme::Normal,
        quadrature: Rule::twelve_after(splits),
        relaxation: 0.0,
        ..flow.clone()
    }
}
