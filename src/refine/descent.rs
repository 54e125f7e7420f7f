//! The first phase of a level: descent along the full gradient.
//!
//! The normal flow moves vertices along the normals. On coarse irregular meshes this is not enough:
//! where the parametrization is bad, the discrete energy falls only if vertices slide along the
//! surface. This method follows the whole exact gradient, `d = −H G`. For each component, `H` is
//! the inverse of the matrix of scheme B in its isotropic form ([`MatrixForm::Isotropic`]),
//! corrected by L-BFGS. A line search ensures that every step lowers the energy (Armijo) and folds
//! nothing ([`FoldGuard`]). Vertices next to a fold are damped individually, `H → D H D`; the other
//! vertices continue to move.

use std::sync::Arc;

use crate::cancel::is_cancelled;
use crate::energy::Energy;
use crate::linear::{Cholesky, CholeskySymbolic, Lbfgs, LinearError, flat, vector};
use crate::mesh::{DVec3, Topology};
use crate::solver::{
    Attempt, EnergySum, Evaluator, FlowOptions, FlowProblem, FoldGuard, MatrixForm,
    PRECONDITIONER_RULE, RejectReason, SolverError, State, StepKind, StepRequest, Stepper,
};
use crate::subdivision::Rule;

/// Number of steps with one matrix.
const REFRESH: usize = 10;
/// Minimum fraction of a step, and maximum number of trial points, including those that fold.
const MIN_LENGTH: f64 = 1.0 / 65536.0;
const MAX_TRIALS: usize = 48;
/// Fraction of the slope by which a step must lower the energy.
const ARMIJO: f64 = 1e-4;
/// Factor on the steps of vertices next to a fold. Vertices whose damping is below `FROZEN` do not
/// move.
const DAMP: f64 = 0.3;
const FROZEN: f64 = 1e-3;
/// Growth of the damping factors after each step.
const RECOVER: f64 = 4.0;

/// State of the descent.
pub struct FullGradientDescent {
    pub(super) topology: Arc<Topology>,
    pub(super) evaluator: Evaluator,
    pub(super) folds: FoldGuard,
    pub(super) cholesky: Cholesky,
    memory: Lbfgs,
    /// Steps since the last factorization.
    age: Option<usize>,
    /// Factor on the step of each unknown; 0 for constrained ones.
    damping: Vec<f64>,
}

/// A step to an acceptable trial point.
struct Step {
    /// The move as a flat vector, x, y and z components one after the other.
    shift: Vec<f64>,
    /// Maximum displacement in the search direction, before any shortening.
    max_displacement: f64,
}

impl FullGradientDescent {
    /// Starts at the positions of a problem, with energies by `rule`.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`] if the energy is not finite at the start, or a failed
    /// symbolic factorization.
    pub fn new(problem: &FlowProblem, energy: &Energy, rule: Rule) -> Result<Self, SolverError> {
        let form = MatrixForm::Isotropic;
        let evaluator = Evaluator::new(problem, energy, rule, PRECONDITIONER_RULE, form)?;
        SolverError::unless_cancelled()?;
        let symbolic = Arc::new(CholeskySymbolic::new(evaluator.pattern())?);
        let mut damping = vec![1.0; evaluator.unknowns().len()];
        if let Some(constraints) = &evaluator.constraints {
            constraints.zero_constrained(&mut damping);
        }
        Ok(Self {
            topology: Arc::clone(problem.topology()),
            folds: FoldGuard::new(problem.discretization(), rule, problem.positions()),
            evaluator,
            cholesky: Cholesky::new(symbolic),
            memory: Lbfgs::new(),
            age: None,
            damping,
        })
    }

    /// [`Self::new`] as a [`MakeStepper`](crate::solver::MakeStepper).
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn make(
        problem: &FlowProblem,
        options: &FlowOptions,
        energy: &Energy,
    ) -> Result<Box<dyn Stepper>, SolverError> {
        Ok(Box::new(Self::new(problem, energy, options.quadrature)?))
    }

    pub(super) fn step(&mut self, tau: f64) -> Attempt {
        if is_cancelled() {
            return Attempt::rejected(RejectReason::Cancelled);
        }
        let fresh = self.age.is_none_or(|age| age >= REFRESH);
        if fresh && let Err(error) = self.factorize(tau) {
            return Attempt::rejected(error.into());
        }
        let Some(step) = self.search() else {
            self.age = None;
            return Attempt {
                needs_refactorization: !fresh,
                ..Attempt::rejected(RejectReason::NoDescent)
            };
        };
        let (new, old) = (
            &self.evaluator.trial.gradient,
            &self.evaluator.state.gradient,
        );
        let change = flat(new.iter().zip(old).map(|(new, old)| *new - *old));
        self.memory.push(&step.shift, &change);
        self.age = self.age.map(|age| age + 1);
        let damped = self.damping.iter().any(|&d| d > 0.0 && d < 1.0);
        for d in &mut self.damping {
            *d = (RECOVER * *d).min(1.0);
        }
        self.evaluator.accept_trial();
        self.folds.accept();
        // a step shortened by the fold guard does not measure the distance to the stationary shape
        let max_displacement = if damped {
            step.max_displacement.max(self.evaluator.radius() * 1e-3)
        } else {
            step.max_displacement
        };
        let kind = if fresh {
            StepKind::Factorized
        } else {
            StepKind::QuasiNewton
        };
        Attempt::accepted(max_displacement, kind)
    }

    pub(super) fn factorize(&mut self, tau: f64) -> Result<(), LinearError> {
        let mut values = Vec::new();
        let directions = vec![DVec3::X; self.evaluator.unknowns().len()];
        self.evaluator.matrix(&directions, tau, &mut values);
        self.cholesky.factorize(&values)?;
        self.memory.clear();
        self.age = Some(0);
        for d in &mut self.damping {
            // allow frozen vertices to move again
            *d = d.max(FROZEN);
        }
        if let Some(constraints) = &self.evaluator.constraints {
            constraints.zero_constrained(&mut self.damping);
        }
        Ok(())
    }

    /// Updates energy and gradient after a change of positions or constraints.
    pub(super) fn refresh(&mut self) {
        self.evaluator.evaluate_state();
        self.memory.clear();
    }

    /// Searches for an acceptable trial point along the direction of descent.
    fn search(&mut self) -> Option<Step> {
        let mut direction = self.direction();
        let mut length = 1.0;
        for _ in 0..MAX_TRIALS {
            if length < MIN_LENGTH || is_cancelled() {
                return None;
            }
            let along = |i: usize| vector(&direction, i);
            let (mut slope, mut max_displacement) = (0.0, 0.0f64);
            for (i, g) in self.evaluator.state.gradient.iter().enumerate() {
                slope += length * along(i).dot(*g);
                max_displacement = max_displacement.max(along(i).length());
            }
            if !(slope < 0.0 && max_displacement.is_finite()) {
                return None;
            }
            self.evaluator.displace(|i| length * along(i));
            if self.folds.would_fold(&self.evaluator.trial.positions) {
                self.damp();
                direction = self.direction();
                continue;
            }
            self.evaluator.evaluate_trial();
            let [old, new] = [&self.evaluator.state, &self.evaluator.trial].map(|s| s.energy);
            let limit = old.value + ARMIJO * slope + 1e-12 * old.scale;
            if new.value.is_finite() && new.value <= limit {
                for d in &mut direction {
                    *d *= length;
                }
                return Some(Step {
                    shift: direction,
                    max_displacement,
                });
            }
            length *= 0.5;
        }
        None
    }

    /// `−D H D G`, x, y and z components one after the other.
    fn direction(&mut self) -> Vec<f64> {
        let mut out = flat(self.evaluator.state.gradient.iter().copied());
        let (cholesky, damping) = (&mut self.cholesky, &self.damping);
        let damp = |q: &mut [f64]| {
            for part in q.chunks_exact_mut(damping.len()) {
                part.iter_mut().zip(damping).for_each(|(q, d)| *q *= d);
            }
        };
        self.memory.direction(&mut out, |q| {
            damp(q);
            cholesky.solve_in_place(q, 3);
            damp(q);
        });
        out
    }

    /// Damps the vertices next to the last fold.
    fn damp(&mut self) {
        let vertices = &self.evaluator.unknowns().vertex;
        for (&v, d) in vertices.iter().zip(&mut self.damping) {
            if self.folds.marked()[v as usize] {
                *d = if *d * DAMP < FROZEN { 0.0 } else { *d * DAMP };
            }
        }
        // pairs recorded under another damping would move the frozen vertices again
        self.memory.clear();
    }
}

impl Stepper for FullGradientDescent {
    fn state(&self) -> &State {
        &self.evaluator.state
    }

    /// Attempts one step. If a new matrix is due, it is made for the given time step.
    fn attempt(&mut self, request: &StepRequest) -> Attempt {
        self.step(request.tau)
    }

    fn normals(&self) -> Option<(&[u32], &[DVec3])> {
        None
    }

    fn slide(&mut self, _: &[DVec3], _: EnergySum) -> bool {
        false
    }

    fn first_tau(&self, tau_ref: f64) -> f64 {
        tau_ref
    }
}
