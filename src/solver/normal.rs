//! Scheme B: the linearly implicit normal flow (formulation, section 6).
//!
//! Each step solves `(M/τ + S) w = −g` for one scalar per moving vertex and moves it by `w_j N_j`,
//! `N_j` the limit normal. Without constraints, one assembly at the trial point gives its energy,
//! its gradient and the matrix of the next step. Under constraints the matrix is a preconditioner.
//! The step is halved until it lowers the energy and folds nothing. Vertices next to remaining
//! folds are frozen.

use std::sync::Arc;

use crate::cancel::is_cancelled;
use crate::energy::Energy;
use crate::linear::{Cholesky, CholeskySymbolic, Lbfgs};
use crate::mesh::{DVec3, Topology, VertexId};
use crate::solver::assembly::{EnergySum, MatrixForm};
use crate::solver::control::Attempt;
use crate::solver::evaluator::{Evaluator, PRECONDITIONER_RULE, State};
use crate::solver::fold_guard::FoldGuard;
use crate::solver::normals::LimitNormals;
use crate::solver::record::{RejectReason, StepKind};
use crate::solver::stepper::{StepRequest, Stepper};
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::Rule;

/// A quasi-Newton step that is longer than this fraction of the previous step requires a new
/// matrix.
const SHRINK: f64 = 0.4;

/// Factor on the diagonal of the matrix at frozen vertices.
const RIGID: f64 = 1e6;
/// Length, over the radius, below which steps that fold the surface freeze vertices.
const SHORT: f64 = 1e-3;
/// Maximum number of halvings of a guarded step before τ is reduced.
const HALVINGS: usize = 8;

/// State of scheme B.
pub struct NormalFlow {
    topology: Arc<Topology>,
    evaluator: Evaluator,
    ring: LimitNormals,
    cholesky: Cholesky,
    values: Vec<f64>,
    /// The τ for which `values` contains the matrix at the current point.
    matrix_tau: Option<f64>,
    /// Normals at the current point, or those of the last factorization in a quasi-Newton phase.
    normals: Vec<DVec3>,
    trial_normals: Vec<DVec3>,
    /// The step along the normals.
    w: Vec<f64>,
    quasi_newton: Option<QuasiNewton>,
    guard: Option<Guard>,
}

/// The guard against folds under constraints.
struct Guard {
    folds: FoldGuard,
    /// Frozen unknowns: their shortest step would fold the surface.
    frozen: Vec<bool>,
}

/// Number of steps with the same factor.
struct QuasiNewton {
    memory: Lbfgs,
    last_move: f64,
}

impl NormalFlow {
    /// Starts at the positions of a problem, with energies by `rule`; `form` is that of the matrix.
    /// Orders the unknowns and makes the symbolic factorization.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`] if the energy is not finite at the start, or a failed
    /// symbolic factorization.
    pub fn new(
        problem: &FlowProblem,
        energy: &Energy,
        rule: Rule,
        form: MatrixForm,
    ) -> Result<Self, SolverError> {
        let is_constrained = problem.interpolation().is_some();
        let matrix_rule = if is_constrained {
            PRECONDITIONER_RULE
        } else {
            rule
        };
        let evaluator = Evaluator::new(problem, energy, rule, matrix_rule, form)?;
        let count = evaluator.unknowns().len();
        SolverError::unless_cancelled()?;
        let symbolic = Arc::new(CholeskySymbolic::new(evaluator.pattern())?);
        let ring = LimitNormals::new(problem.topology(), &evaluator.unknowns().vertex);
        let mut normals = Vec::new();
        ring.evaluate(problem.positions(), &mut normals);
        Ok(Self {
            topology: Arc::clone(problem.topology()),
            evaluator,
            ring,
            cholesky: Cholesky::new(symbolic),
            values: Vec::new(),
            matrix_tau: None,
            normals,
            trial_normals: Vec::new(),
            w: vec![0.0; count],
            quasi_newton: None,
            guard: is_constrained.then(|| Guard {
                folds: FoldGuard::new(problem.discretization(), rule, problem.positions()),
                frozen: vec![false; count],
            }),
        })
    }

    fn factorized_step(&mut self, request: &StepRequest) -> Attempt {
        let &StepRequest {
            tau, may_freeze, ..
        } = request;
        if self.matrix_tau != Some(tau) {
            self.evaluator.matrix(&self.normals, tau, &mut self.values);
            self.matrix_tau = Some(tau);
        }
        self.stiffen_frozen();
        if is_cancelled() {
            return Attempt::rejected(RejectReason::Cancelled);
        }
        if let Err(error) = self.cholesky.factorize(&self.values) {
            // M/τ dominates for small τ: reject the step and let the step-size control reduce τ
            return Attempt::rejected(error.into());
        }
        project(
            &self.evaluator.state.gradient,
            &self.normals,
            -1.0,
            &mut self.w,
        );
        self.zero_frozen();
        self.cholesky.solve_in_place(&mut self.w, 1);
        self.zero_dependent();
        let longest = match self.try_step(request.next_tau, may_freeze) {
            Ok(longest) => longest,
            Err(reason) => {
                self.evaluator.learn(false);
                return Attempt {
                    // retry the same τ if the other vertices can move without those at a fold
                    needs_refactorization: reason == RejectReason::Fold && self.freeze_marked(),
                    ..Attempt::rejected(reason)
                };
            }
        };
        self.evaluator.learn(true);
        if may_freeze {
            let mut memory = Lbfgs::new();
            self.remember(&mut memory);
            self.quasi_newton = Some(QuasiNewton {
                memory,
                last_move: longest,
            });
            self.matrix_tau = None;
        } else {
            std::mem::swap(&mut self.normals, &mut self.trial_normals);
        }
        self.accept();
        Attempt::accepted(longest, StepKind::Factorized)
    }

    /// Moves the trial point by the step `w`. Under a guard, `w` is first shortened until it lowers
    /// the energy and folds nothing. Returns the length of the whole step. With `freeze`, only the
    /// gradient is computed at the new point. Otherwise the normals are computed too and, without a
    /// guard, the matrix for `next_tau`.
    fn try_step(&mut self, next_tau: f64, freeze: bool) -> Result<f64, RejectReason> {
        self.matrix_tau = None;
        if self.guard.is_some() {
            let longest = self.search()?;
            if !freeze {
                self.ring
                    .evaluate(&self.evaluator.trial.positions, &mut self.trial_normals);
            }
            return Ok(longest);
        }
        let longest = self.displace();
        if !longest.is_finite() {
            return Err(RejectReason::NoDescent);
        }
        if freeze {
            // quasi-Newton steps keep the normals of this factor
            self.evaluator.evaluate_trial();
        } else {
            self.ring
                .evaluate(&self.evaluator.trial.positions, &mut self.trial_normals);
            let (normals, values) = (&self.trial_normals, &mut self.values);
            self.evaluator
                .evaluate_trial_with_matrix(normals, next_tau, values);
        }
        if !self.evaluator.admits_trial() {
            return Err(RejectReason::NoDescent);
        }
        self.matrix_tau = (!freeze).then_some(next_tau);
        Ok(longest)
    }

    /// Halves the step until it lowers the energy and folds nothing.
    fn search(&mut self) -> Result<f64, RejectReason> {
        let mut whole = None;
        let mut reason = RejectReason::NoDescent;
        for _ in 0..=HALVINGS {
            if is_cancelled() {
                return Err(RejectReason::Cancelled);
            }
            let longest = self.displace();
            let whole = *whole.get_or_insert(longest);
            reason = RejectReason::NoDescent;
            if !longest.is_finite() {
                return Err(reason);
            }
            if self.would_fold() {
                if longest < SHORT * self.evaluator.radius() {
                    reason = RejectReason::Fold;
                }
            } else {
                self.evaluator.evaluate_trial();
                if self.evaluator.admits_trial() {
                    return Ok(whole);
                }
            }
            self.w.iter_mut().for_each(|w| *w *= 0.5);
        }
        Err(reason)
    }

    fn quasi_newton_step(&mut self, mut phase: QuasiNewton) -> Attempt {
        project(
            &self.evaluator.state.gradient,
            &self.normals,
            1.0,
            &mut self.w,
        );
        self.zero_frozen();
        let cholesky = &mut self.cholesky;
        phase
            .memory
            .direction(&mut self.w, |q| cholesky.solve_in_place(q, 1));
        self.zero_dependent();
        let longest = match self.try_step(0.0, true) {
            Ok(longest) => longest,
            Err(reason) => {
                // return to a new matrix at the current point
                self.leave_quasi_newton();
                return Attempt {
                    needs_refactorization: true,
                    ..Attempt::rejected(reason)
                };
            }
        };
        self.remember(&mut phase.memory);
        let stale = longest > SHRINK * phase.last_move;
        phase.last_move = longest;
        self.accept();
        if stale {
            self.leave_quasi_newton();
        } else {
            self.quasi_newton = Some(phase);
        }
        Attempt {
            needs_refactorization: stale,
            ..Attempt::accepted(longest, StepKind::QuasiNewton)
        }
    }

    fn leave_quasi_newton(&mut self) {
        self.quasi_newton = None;
        self.matrix_tau = None;
        self.ring
            .evaluate(&self.evaluator.state.positions, &mut self.normals);
    }

    /// Adds the pair (step, change of gradient) to the quasi-Newton memory.
    fn remember(&self, memory: &mut Lbfgs) {
        let (new, old) = (
            &self.evaluator.trial.gradient,
            &self.evaluator.state.gradient,
        );
        let change: Vec<f64> = new
            .iter()
            .zip(old)
            .zip(&self.normals)
            .map(|((new, old), n)| n.dot(*new) - n.dot(*old))
            .collect();
        memory.push(&self.w, &change);
    }

    /// Sets `trial = positions + w N`. Returns `max |w|`, or NaN if `w` contains a NaN.
    fn displace(&mut self) -> f64 {
        self.evaluator.displace(|i| self.normals[i] * self.w[i]);
        max_magnitude(self.w.iter().copied())
    }

    /// Constrained vertices follow the others and frozen ones stay: neither has a step.
    fn zero_dependent(&mut self) {
        if let Some(constraints) = &self.evaluator.constraints {
            constraints.zero_constrained(&mut self.w);
        }
        self.zero_frozen();
    }

    /// Makes the frozen vertices immovable in the matrix.
    fn stiffen_frozen(&mut self) {
        let Some(guard) = &self.guard else { return };
        let columns = &self.evaluator.pattern().col_ptr;
        for (&diagonal, _) in columns.iter().zip(&guard.frozen).filter(|c| *c.1) {
            self.values[diagonal] *= RIGID;
        }
    }

    /// Sets the entries of frozen vertices to zero.
    fn zero_frozen(&mut self) {
        if let Some(guard) = &self.guard {
            for (w, _) in self.w.iter_mut().zip(&guard.frozen).filter(|f| *f.1) {
                *w = 0.0;
            }
        }
    }

    /// Whether the trial point has a fold that the current point does not have.
    fn would_fold(&mut self) -> bool {
        let trial = &self.evaluator.trial.positions;
        self.guard
            .as_mut()
            .is_some_and(|guard| guard.folds.would_fold(trial))
    }

    /// Freezes the vertices next to the last fold. Returns whether any of them was moving.
    fn freeze_marked(&mut self) -> bool {
        let Some(guard) = &mut self.guard else {
            return false;
        };
        let mut any = false;
        let vertices = &self.evaluator.unknowns().vertex;
        for (&v, frozen) in vertices.iter().zip(&mut guard.frozen) {
            if guard.folds.marked()[v as usize] {
                any |= !std::mem::replace(frozen, true);
            }
        }
        any
    }

    fn accept(&mut self) {
        self.evaluator.accept_trial();
        if let Some(guard) = &mut self.guard {
            guard.folds.accept();
        }
    }
}

impl Stepper for NormalFlow {
    fn state(&self) -> &State {
        &self.evaluator.state
    }

    fn attempt(&mut self, request: &StepRequest) -> Attempt {
        match self.quasi_newton.take() {
            Some(phase) => self.quasi_newton_step(phase),
            None => self.factorized_step(request),
        }
    }

    fn normals(&self) -> Option<(&[u32], &[DVec3])> {
        Some((&self.evaluator.unknowns().vertex, &self.normals))
    }

    fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool {
        let moved = self.evaluator.slide(positions, before);
        if moved {
            self.leave_quasi_newton();
        }
        moved
    }

    /// The τ with which an explicit step would move no vertex by more than its shortest edge.
    fn first_tau(&self, _: f64) -> f64 {
        let State {
            positions,
            gradient,
            ..
        } = &self.evaluator.state;
        let mut tau = f64::INFINITY;
        for (i, &v) in self.evaluator.unknowns().vertex.iter().enumerate() {
            let p = positions[v as usize];
            let (mut shortest, mut area) = (f64::INFINITY, 0.0);
            for h in self.topology.outgoing(VertexId(v)) {
                let a = positions[self.topology.target(h).index()] - p;
                let next = self.topology.next(h);
                let b = positions[self.topology.target(next).index()] - p;
                shortest = shortest.min(a.length());
                area += a.cross(b).length() / 6.0;
            }
            let speed = self.normals[i].dot(gradient[i]).abs() / area;
            tau = tau.min(shortest / speed);
        }
        tau
    }

    fn frozen(&self) -> usize {
        let frozen = self.guard.iter().flat_map(|guard| &guard.frozen);
        frozen.filter(|&&f| f).count()
    }
}

/// The largest magnitude, or NaN if there is a NaN ([`f64::max`] would hide it).
pub(super) fn max_magnitude(numbers: impl Iterator<Item = f64>) -> f64 {
    let larger = |max: f64, x: f64| {
        if x.abs() <= max || max.is_nan() {
            max
        } else {
            x.abs()
        }
    };
    numbers.fold(0.0, larger)
}

/// `out_j = factor N_j · G_j`.
fn project(gradient: &[DVec3], normals: &[DVec3], factor: f64, out: &mut [f64]) {
    for ((out, g), n) in out.iter_mut().zip(gradient).zip(normals) {
        *out = factor * n.dot(*g);
    }
}

#[cfg(test)]
#[path = "normal_tests.rs"]
mod tests;
