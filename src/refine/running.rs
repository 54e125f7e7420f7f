//! The flow of one level.

use std::time::Instant;

use crate::memory::peak_memory;
use crate::mesh::DVec3;
use crate::refine::progress::LevelReport;
use crate::solver::{End, Flow, FlowOptions, Mode, Scheme, SolverError, StepRecord};
use crate::subdivision::Rule;

/// Part of the steps that may go to the guarded descent before the normal flow takes over.
const GUARDED_SHARE: usize = 2;
/// The normal flow takes over when so many steps together gained less than this part.
const SETTLED: (usize, f64) = (10, 1e-4);

/// The flow of the level under way.
pub struct Running {
    /// Levels after this one.
    pub splits: usize,
    /// Vertices that the surface came to pass only by folding.
    pub late: usize,
    /// The flow.
    pub flow: Flow,
    /// When the level was begun.
    pub start: Instant,
    /// Vertices the limit surface passes, and where.
    pub held: Vec<(u32, DVec3)>,
    /// Energies after the last accepted steps of the guarded descent.
    pub recent: Vec<f64>,
    /// Whether the guarded descent is at work.
    pub is_guarded: bool,
}

impl Running {
    /// Hands over to the normal flow when the guarded descent gains little.
    pub fn watch(&mut self, record: &StepRecord, flow: &FlowOptions) -> Result<(), SolverError> {
        if !self.is_guarded || record.rejected {
            return Ok(());
        }
        self.recent.push(record.energy);
        let (count, part) = SETTLED;
        let n = self.recent.len();
        let settled = n > count && {
            let before = self.recent[n - 1 - count];
            before - record.energy < part * before.abs()
        };
        if settled || GUARDED_SHARE * record.step >= flow.max_steps || self.flow.end().is_some() {
            self.settle(flow)?;
        }
        Ok(())
    }

    /// What the level has come to, on a mesh of so many vertices and faces.
    pub fn report(&mut self, level: usize, vertices: usize, faces: usize) -> LevelReport {
        let outcome = self.flow.outcome();
        let problem = self.flow.problem();
        let mut warnings = outcome.warnings;
        if self.late > 0 {
            warnings.push(format!(
                "{} vertices could not be reached without a fold in the surface (the mesh itself may be \
                 folded there)",
                self.late
            ));
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

    /// Goes on along the normals alone.
    pub fn settle(&mut self, flow: &FlowOptions) -> Result<(), SolverError> {
        self.is_guarded = false;
        if self.flow.end() == Some(End::Cancelled) {
            return Ok(());
        }
        let mut options = level_options(flow, self.splits);
        options.scheme = Scheme::Normal;
        self.flow.set_options(options)
    }
}

/// The options of a level's flow: the guarded descent first, or the flow in true time; by the 12 points of
/// each triangle there will be after the `splits` to come, for coarse meshes fold between fewer points.
pub fn level_options(flow: &FlowOptions, splits: usize) -> FlowOptions {
    FlowOptions {
        scheme: match flow.mode {
            Mode::Fast => Scheme::Guarded,
            Mode::Flow => Scheme::Normal,
        },
        quadrature: Rule::twelve_after(splits),
        relaxation: 0.0,
        ..flow.clone()
    }
}
