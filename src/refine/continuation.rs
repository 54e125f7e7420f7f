//! Continuation in the constraints: from a surface near the targets to one that interpolates them.

use crate::cancel::is_cancelled;
use crate::linear::vector;
use crate::mesh::{DVec3, VertexId};
use crate::refine::descent::FullGradientDescent;

/// Maximum fraction of its path that a constraint moves in one round.
const MAX_STEP_FRACTION: f64 = 0.34;
/// Minimum fraction. A constraint whose move by this fraction still folds the surface waits.
const MIN_STEP_FRACTION: f64 = 1e-3;
/// Factors on the fraction after a fold and after a move without a fold.
const SHRINK: f64 = 0.4;
const GROW: f64 = 1.6;
/// Maximum number of rounds, and steps of descent after each.
const ROUNDS: usize = 60;
const DESCENTS: usize = 2;
/// Trial points of one round.
const TRIALS: usize = 40;

/// The straight paths of the constraints and the progress along each.
struct ConstraintPath<'a> {
    start: Vec<DVec3>,
    goals: &'a [DVec3],
    /// Fraction of its path that each constraint has covered.
    reached: Vec<f64>,
    /// Maximum fraction that each constraint may move in the next round.
    stride: Vec<f64>,
}

impl ConstraintPath<'_> {
    /// Constraints that have not arrived.
    fn unreached(&self) -> usize {
        self.reached.iter().filter(|&&r| r < 1.0).count()
    }

    /// The fraction that each constraint moves next.
    fn next(&self) -> Vec<f64> {
        let parts = self.reached.iter().zip(&self.stride);
        parts.map(|(&r, &s)| s.min(1.0 - r)).collect()
    }

    /// The targets after moves by these parts.
    fn after(&self, parts: &[f64]) -> Vec<DVec3> {
        (0..parts.len())
            .map(|i| match self.reached[i] + parts[i] {
                part if part >= 1.0 => self.goals[i],
                part => self.start[i].lerp(self.goals[i], part),
            })
            .collect()
    }

    /// Records moves by `parts` out of the requested fractions `wanted`.
    fn advance(&mut self, parts: &[f64], wanted: &[f64]) {
        for i in 0..parts.len() {
            self.reached[i] += parts[i];
            self.stride[i] = if parts[i] < wanted[i] {
                (SHRINK * self.stride[i]).max(MIN_STEP_FRACTION)
            } else {
                (GROW * self.stride[i]).min(MAX_STEP_FRACTION)
            };
        }
    }
}

impl FullGradientDescent {
    /// Moves the constraints from the current points of the surface to `goals`, in parts that cause
    /// no fold. The preconditioner spreads each move over the surface, and descent steps follow.
    /// Constraints that cannot reach their goals without a fold are moved there at the end. Returns
    /// the number of these constraints.
    pub fn move_constraints_to(&mut self, goals: &[DVec3], tau: f64) -> usize {
        let Some(constraints) = &self.evaluator.constraints else {
            return 0;
        };
        let mut path = ConstraintPath {
            start: constraints.targets().to_vec(),
            goals,
            reached: vec![0.0; goals.len()],
            stride: vec![MAX_STEP_FRACTION; goals.len()],
        };
        for _ in 0..ROUNDS {
            if path.unreached() == 0 || is_cancelled() || self.factorize(tau).is_err() {
                break;
            }
            self.advance(&mut path);
            for _ in 0..DESCENTS {
                if !self.step(tau).is_accepted() {
                    break;
                }
            }
        }
        let unreached = path.unreached();
        if unreached > 0 {
            self.jump_to(goals.to_vec());
        }
        unreached
    }

    /// One move of the constraints. Constraints next to a fold move less, or wait.
    fn advance(&mut self, path: &mut ConstraintPath<'_>) {
        let mut parts = path.next();
        let wanted = parts.clone();
        for _ in 0..TRIALS {
            let Some(positions) = self.predict(&path.after(&parts)) else {
                return;
            };
            if !self.folds.would_fold(&positions) {
                if let Some(constraints) = &mut self.evaluator.constraints {
                    constraints.set_targets(path.after(&parts));
                }
                self.evaluator.state.positions = positions;
                self.folds.accept();
                self.refresh();
                path.advance(&parts, &wanted);
                return;
            }
            if !self.slow_down(&mut parts) {
                return;
            }
        }
    }

    /// The surface after a move of the constraints to `targets`, spread by the preconditioner.
    fn predict(&mut self, targets: &[DVec3]) -> Option<Vec<DVec3>> {
        let constraints = self.evaluator.constraints.as_ref()?;
        let shifts: Vec<DVec3> = targets
            .iter()
            .zip(constraints.targets())
            .map(|(to, from)| *to - *from)
            .collect();
        let vertices = &self.evaluator.unknowns().vertex;
        let mut step = vec![0.0; 3 * vertices.len()];
        constraints.add_load(&shifts, &mut step);
        self.cholesky.solve_in_place(&mut step, 3);
        let mut positions = self.evaluator.state.positions.clone();
        for (i, &v) in vertices.iter().enumerate() {
            positions[v as usize] += vector(&step, i);
        }
        constraints.enforce_at(targets, &mut positions);
        Some(positions)
    }

    /// Shortens the moves of the constraints next to the last fold. Returns whether any of these
    /// constraints was moving.
    fn slow_down(&self, parts: &mut [f64]) -> bool {
        let Some(constraints) = &self.evaluator.constraints else {
            return false;
        };
        let marked = self.folds.marked();
        let vertices = &self.evaluator.unknowns().vertex;
        let mut any = false;
        for (&u, part) in constraints.unknowns().iter().zip(parts) {
            let v = vertices[u as usize];
            let mut around = self.topology.neighbours(VertexId(v));
            if *part > 0.0 && (marked[v as usize] || around.any(|w| marked[w.index()])) {
                any = true;
                *part *= SHRINK;
                if *part < MIN_STEP_FRACTION {
                    *part = 0.0;
                }
            }
        }
        any
    }

    /// Moves the constraints at once.
    fn jump_to(&mut self, targets: Vec<DVec3>) {
        if let Some(constraints) = &mut self.evaluator.constraints {
            constraints.set_targets(targets);
            constraints.enforce(&mut self.evaluator.state.positions);
        }
        self.folds.reset(&self.evaluator.state.positions);
        self.refresh();
    }
}
