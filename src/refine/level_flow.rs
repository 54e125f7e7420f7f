//! The flow of one level, in two phases.
//!
//! In fast mode a level starts with [`FullGradientDescent`], which lets vertices slide along the
//! surface. When its gain becomes small, the normal flow takes over. A flow in true time uses the
//! normal flow from the start.

use std::time::{Duration, Instant};

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

/// The descent may take at most the number of steps divided by this.
const DESCENT_SHARE: usize = 2;
/// The normal flow takes over when this many steps together gained less than this fraction.
const SETTLED: (usize, f64) = (10, 1e-4);

/// The flow of the current level.
pub struct LevelFlow {
    /// Levels after this one.
    splits: usize,
    /// Number of constraints that the surface satisfies only by folding.
    pub unreached: usize,
    /// The flow.
    pub flow: Flow,
    /// Time of the computation so far, without pauses.
    pub time: Duration,
    /// The vertices that the limit surface interpolates, and their target points.
    pub constraints: Vec<(u32, DVec3)>,
    /// In the descent, the energies after its accepted steps.
    descent: Option<Vec<f64>>,
}

/// The constructor of the steppers for a level's first phase, and whether that phase is the
/// descent.
fn first_phase(mode: Mode) -> (MakeStepper, Option<Vec<f64>>) {
    match mode {
        Mode::Fast => (FullGradientDescent::make, Some(Vec::new())),
        Mode::Flow => (scheme_stepper, None),
    }
}

impl LevelFlow {
    /// Starts the flow of a level that began at `start`, with `splits` levels to come. `constraints` are those
    /// of the problem. The surface satisfies `unreached` of them only by folding.
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
        let flow = Flow::with_stepper(problem, options, make)?;
        Ok(Self {
            splits,
            unreached,
            flow,
            time: start.elapsed(),
            constraints,
            descent,
        })
    }

    /// Continues the step counts from a later state of the level.
    #[must_use]
    pub fn counting_from(mut self, steps: usize) -> Self {
        self.flow = self.flow.counting_from(steps, 0);
        self
    }

    /// Changes options. The flow continues from the current shape in its first phase.
    ///
    /// # Errors
    /// Invalid options; the old options stay in force.
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
        let start = Instant::now();
        let record = self.attempt();
        self.time += start.elapsed();
        record
    }

    fn attempt(&mut self) -> Result<Option<StepRecord>, SolverError> {
        if let Some(record) = self.flow.step()? {
            if self.has_settled(&record) {
                self.switch_to_normal_flow()?;
            }
            return Ok(Some(record));
        }
        if self.descent.is_some() && self.flow.end() == Some(End::StepSizeCollapsed) {
            // sliding along the surface no longer helps; the normal flow may still
            self.switch_to_normal_flow()?;
            return self.attempt();
        }
        Ok(None)
    }

    /// Whether the descent ends with a step.
    fn has_settled(&mut self, record: &StepRecord) -> bool {
        let Some(energies) = self.descent.as_mut().filter(|_| !record.is_rejected()) else {
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

    /// The report of the level, for a mesh with these numbers of vertices and faces.
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
            end: outcome.end,
            energy_start: outcome.energy_start,
            energy_end: outcome.energy_end,
            held_error: problem
                .interpolation()
                .map(|i| i.error(self.flow.positions()) / problem.radius()),
            seconds: self.time.as_secs_f64(),
            peak_memory: peak_memory(),
            warnings,
        }
    }
}

/// The options of a level's flow. The quadrature uses the 12 points of each triangle that will
/// exist after the `splits` to come, because coarse meshes fold between fewer points.
fn level_options(flow: &FlowOptions, splits: usize) -> FlowOptions {
    FlowOptions {
        scheme: Scheme::Normal,
        quadrature: Rule::twelve_after(splits),
        relaxation: 0.0,
        ..flow.clone()
    }
}
