//! Scheme B: the linearly implicit normal flow (formulation, section 6).
//!
//! Each step solves `(M/τ + S) w = −g` for one scalar per moving vertex and moves it by `w_j N_j`,
//! `N_j` the limit normal. The assembly at the trial point gives its energy, its gradient and the
//! next step's matrix at once.

use std::sync::Arc;

use crate::energy::Energy;
use crate::linear::{Cholesky, CholeskySymbolic, Lbfgs};
use crate::mesh::{DVec3, Topology, VertexId};
use crate::solver::assembly::{Assembler, EnergySum};
use crate::solver::constraints::Constraints;
use crate::solver::control::{Attempt, StepKind};
use crate::solver::fold_guard::FoldState;
use crate::solver::normals::LimitNormals;
use crate::solver::quadrature_levels::{
    FOLD_CHECK_RULE, PRECONDITIONER_RULE, coarsened, energy_and_preconditioner,
};
use crate::solver::relax::may_slide;
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::{Elements, Rule};
use crate::surface::sample_surface;

/// A quasi-Newton step that is not this much shorter than the one before calls for a new matrix.
const SHRINK: f64 = 0.4;

/// Factor on the diagonal of the matrix at vertices that rest.
const RIGID: f64 = 1e6;
/// Length, over the radius, below which steps that fold lay vertices to rest.
const SHORT: f64 = 1e-3;
/// How often a step under guard is halved before τ is made smaller.
const HALVINGS: usize = 8;

/// State of scheme B.
pub struct NormalFlow {
    assembler: Assembler,
    /// Of the matrix, where that of the energy has more points than it needs.
    metric: Option<Assembler>,
    ring: LimitNormals,
    cholesky: Cholesky,
    values: Vec<f64>,
    radius: f64,
    energy: Energy,
    positions: Vec<DVec3>,
    current: EnergySum,
    /// Normals at the current point, or those of the last factorization in a quasi-Newton phase.
    normals: Vec<DVec3>,
    gradient: Vec<DVec3>,
    /// The τ for which `values` hold the matrix at the current point.
    matrix_tau: Option<f64>,
    trial: Vec<DVec3>,
    trial_normals: Vec<DVec3>,
    trial_gradient: Vec<DVec3>,
    quasi_newton: Option<QuasiNewton>,
    w: Vec<f64>,
    constraints: Option<Constraints>,
    guard: Option<Guard>,
}

/// Why a step was not taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Refusal {
    /// The least part of it tried, a short one, folds the surface.
    Fold,
    /// It lowers no energy, goes too far or is no number.
    Other,
}

/// The watch over folds, on the coarse meshes of a refinement.
struct Guard {
    topology: Topology,
    elements: Elements,
    folds: FoldState,
    next: FoldState,
    /// Scratch: vertices next to a fold.
    marked: Vec<bool>,
    /// Unknowns that rest for good, since the least step of theirs would fold the surface.
    frozen: Vec<bool>,
}

/// Steps with the frozen factor.
struct QuasiNewton {
    memory: Lbfgs,
    last_move: f64,
}

impl NormalFlow {
    /// Sets the flow up on the elements `local` with tables for `rule`; `membrane` keeps the
    /// membrane term of `S` everywhere. Order of the unknowns, symbolic factorization, first gradient.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`] if the energy is not finite at the start, or a failed
    /// symbolic factorization.
    pub fn new(
        problem: &FlowProblem,
        local: &Elements,
        rule: Rule,
        energy: &Energy,
        membrane: bool,
    ) -> Result<Self, SolverError> {
        let is_held = problem.interpolation().is_some();
        let most = if is_held { PRECONDITIONER_RULE } else { rule };
        let (mut assembler, mut metric) = energy_and_preconditioner(problem, local, rule, most);
        let ring = LimitNormals::new(problem.topology(), &assembler.unknowns().vertex);
        let maker = metric.as_mut().unwrap_or(&mut assembler);
        if !membrane {
            maker.drop_membrane();
        }
        let symbolic = Arc::new(CholeskySymbolic::new(maker.pattern())?);
        let held = Constraints::of(problem, maker);
        let count = maker.unknowns().len();
        let mut flow = Self {
            assembler,
            metric,
            ring,
            cholesky: Cholesky::new(symbolic),
            values: Vec::new(),
            radius: problem.radius(),
            energy: energy.clone(),
            positions: problem.positions().to_vec(),
            current: EnergySum::default(),
            normals: Vec::new(),
            gradient: Vec::new(),
            matrix_tau: None,
            trial: problem.positions().to_vec(),
            trial_normals: Vec::new(),
            trial_gradient: Vec::new(),
            quasi_newton: None,
            w: vec![0.0; count],
            guard: is_held.then(|| {
                let elements = coarsened(problem, local, rule, FOLD_CHECK_RULE).into_owned();
                Guard {
                    folds: FoldState::new(problem.topology(), &elements, problem.positions()),
                    topology: problem.topology().clone(),
                    elements,
                    next: FoldState::default(),
                    marked: vec![false; problem.positions().len()],
                    frozen: vec![false; count],
                }
            }),
            constraints: held,
        };
        flow.ring.evaluate(&flow.positions, &mut flow.normals);
        flow.current = flow
            .assembler
            .gradient(&flow.positions, energy, &mut flow.gradient);
        if let Some(held) = &flow.constraints {
            held.pull_back(flow.assembler.unknowns(), &mut flow.gradient);
        }
        if !flow.current.value.is_finite() {
            return Err(SolverError::energy_not_finite(&sample_surface(
                local,
                &flow.positions,
                energy,
                flow.radius,
            )));
        }
        Ok(flow)
    }

    /// Positions of all vertices of the region, relative to the problem's centre.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Energy at the current positions, by the rule of the steps.
    pub fn energy(&self) -> EnergySum {
        self.current
    }

    /// The vertices that move.
    pub fn moving(&self) -> &[u32] {
        &self.assembler.unknowns().vertex
    }

    /// Limit normals at the moving vertices (those of the factor in a quasi-Newton phase).
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Takes other positions, such as a slide along the surface after a step from energy `before`,
    /// if they do not give back too much of it. Returns whether it did.
    pub fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool {
        self.trial.copy_from_slice(positions);
        let sum = self
            .assembler
            .gradient(&self.trial, &self.energy, &mut self.trial_gradient);
        if !may_slide(before, self.current, sum) {
            return false;
        }
        self.accept(sum);
        self.leave_quasi_newton();
        true
    }

    /// Exact gradient of the energy at the moving vertices, with the vertex of each.
    pub fn gradient(&self) -> (&[u32], &[DVec3]) {
        (&self.assembler.unknowns().vertex, &self.gradient)
    }

    /// A time step such that an explicit step would move no vertex by more than its shortest edge.
    pub fn edge_limited_tau(&self, topology: &Topology) -> f64 {
        let mut tau = f64::INFINITY;
        for (i, &v) in self.assembler.unknowns().vertex.iter().enumerate() {
            let p = self.positions[v as usize];
            let (mut shortest, mut area) = (f64::INFINITY, 0.0);
            for h in topology.outgoing(VertexId(v)) {
                let a = self.positions[topology.target(h).index()] - p;
                let next = topology.next(h);
                let b = self.positions[topology.target(next).index()] - p;
                shortest = shortest.min(a.length());
                area += a.cross(b).length() / 6.0;
            }
            let speed = self.normals[i].dot(self.gradient[i]).abs() / area;
            tau = tau.min(shortest / speed);
        }
        tau
    }

    /// One step. `tau` is the time step, `next_tau` the one to prepare for if it is accepted;
    /// `freeze` asks for quasi-Newton steps from now on (fast mode), ended by this scheme itself
    /// when they no longer shrink.
    pub fn attempt(&mut self, tau: f64, next_tau: f64, freeze: bool) -> Attempt {
        if self.quasi_newton.is_some() {
            return self.quasi_newton_step();
        }
        self.factorized_step(tau, next_tau, freeze)
    }

    fn factorized_step(&mut self, tau: f64, next_tau: f64, freeze: bool) -> Attempt {
        if self.matrix_tau != Some(tau) {
            // the gradient is known; of a coarser rule it would be another
            self.metric.as_mut().unwrap_or(&mut self.assembler).matrix(
                &self.positions,
                &self.normals,
                &self.energy,
                self.radius,
                tau,
                &mut Vec::new(),
                &mut self.values,
            );
            if let Some(held) = &mut self.constraints {
                held.hold(&self.normals, &mut self.values);
            }
            self.matrix_tau = Some(tau);
        }
        self.stiffen_frozen();
        if let Err(error) = self.cholesky.factorize(&self.values) {
            // M/τ dominates for small τ: reject and let the control shrink it
            return Attempt::rejected(Some(error.to_string()));
        }
        project(&self.gradient, &self.normals, -1.0, &mut self.w);
        self.rest_frozen();
        self.cholesky.solve_in_place(&mut self.w, 1);
        self.free_only();
        let (longest, sum) = match self.try_step(next_tau, freeze) {
            Ok(step) => step,
            Err(refusal) => {
                return Attempt {
                    // the same τ again, if the rest can go on without the vertices at a fold
                    needs_refactorization: refusal == Refusal::Fold && self.lay_to_rest(),
                    ..Attempt::rejected(None)
                };
            }
        };
        if freeze {
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
        self.accept(sum);
        Attempt::accepted(longest, StepKind::Factorized)
    }

    /// Moves `trial` by the step `w`, or under guard by as much of it as lowers the energy and folds
    /// nothing (`w` is shortened to that). Returns the length of the whole step and the energy. With
    /// `freeze` only the gradient is made at the new point, else the normals too and, where no
    /// shorter step can come, the matrix for `next_tau`.
    fn try_step(&mut self, next_tau: f64, freeze: bool) -> Result<(f64, EnergySum), Refusal> {
        self.matrix_tau = None;
        if self.guard.is_some() {
            let found = self.search()?;
            if !freeze {
                self.ring.evaluate(&self.trial, &mut self.trial_normals);
            }
            return Ok(found);
        }
        let longest = self.displace();
        if !longest.is_finite() {
            return Err(Refusal::Other);
        }
        let sum = if freeze {
            // quasi-Newton steps keep the normals of this factor
            self.assembler
                .gradient(&self.trial, &self.energy, &mut self.trial_gradient)
        } else {
            self.ring.evaluate(&self.trial, &mut self.trial_normals);
            self.matrix_tau = Some(next_tau);
            self.assembler.matrix(
                &self.trial,
                &self.trial_normals,
                &self.energy,
                self.radius,
                next_tau,
                &mut self.trial_gradient,
                &mut self.values,
            )
        };
        if !self.current.admits(&sum) {
            self.matrix_tau = None;
            return Err(Refusal::Other);
        }
        Ok((longest, sum))
    }

    /// Halves the step until it lowers the energy and folds nothing.
    fn search(&mut self) -> Result<(f64, EnergySum), Refusal> {
        let mut whole = None;
        let mut refusal = Refusal::Other;
        for _ in 0..=HALVINGS {
            let longest = self.displace();
            let whole = *whole.get_or_insert(longest);
            refusal = Refusal::Other;
            if !longest.is_finite() {
                return Err(refusal);
            }
            if self.would_fold() {
                if longest < SHORT * self.radius {
                    refusal = Refusal::Fold;
                }
            } else {
                let sum =
                    self.assembler
                        .gradient(&self.trial, &self.energy, &mut self.trial_gradient);
                if self.current.admits(&sum) {
                    self.pull_back_trial();
                    return Ok((whole, sum));
                }
            }
            self.w.iter_mut().for_each(|w| *w *= 0.5);
        }
        Err(refusal)
    }

    fn quasi_newton_step(&mut self) -> Attempt {
        let Some(mut state) = self.quasi_newton.take() else {
            return Attempt::rejected(None);
        };
        project(&self.gradient, &self.normals, 1.0, &mut self.w);
        self.rest_frozen();
        let cholesky = &mut self.cholesky;
        state
            .memory
            .direction(&mut self.w, |q| cholesky.solve_in_place(q, 1));
        self.free_only();
        let Ok((longest, sum)) = self.try_step(0.0, true) else {
            // back to a fresh matrix at the current point
            self.leave_quasi_newton();
            return Attempt {
                needs_refactorization: true,
                ..Attempt::rejected(None)
            };
        };
        self.remember(&mut state.memory);
        let stale = longest > SHRINK * state.last_move;
        state.last_move = longest;
        self.accept(sum);
        if stale {
            self.leave_quasi_newton();
        } else {
            self.quasi_newton = Some(state);
        }
        Attempt {
            needs_refactorization: stale,
            ..Attempt::accepted(longest, StepKind::QuasiNewton)
        }
    }

    fn leave_quasi_newton(&mut self) {
        self.quasi_newton = None;
        self.matrix_tau = None;
        self.ring.evaluate(&self.positions, &mut self.normals);
    }

    /// Gives the pair (step, change of gradient) to the quasi-Newton memory.
    fn remember(&self, memory: &mut Lbfgs) {
        let change: Vec<f64> = self
            .trial_gradient
            .iter()
            .zip(&self.gradient)
            .zip(&self.normals)
            .map(|((new, old), n)| n.dot(*new) - n.dot(*old))
            .collect();
        memory.push(&self.w, &change);
    }

    /// `trial = positions + w N`; returns `max |w|`.
    fn displace(&mut self) -> f64 {
        let mut longest = 0.0f64;
        for ((&v, &w), &n) in self
            .assembler
            .unknowns()
            .vertex
            .iter()
            .zip(&self.w)
            .zip(&self.normals)
        {
            self.trial[v as usize] = self.positions[v as usize] + n * w;
            // f64::max would hide a NaN
            longest = if w.abs() <= longest { longest } else { w.abs() };
        }
        if let Some(held) = &self.constraints {
            held.settle(&mut self.trial);
        }
        longest
    }

    /// Constrained vertices follow and have no step of their own, and frozen ones have none.
    fn free_only(&mut self) {
        if let Some(held) = &self.constraints {
            held.clear(&mut self.w);
        }
        self.rest_frozen();
    }

    /// Makes the frozen vertices immovable in the matrix.
    fn stiffen_frozen(&mut self) {
        let Some(guard) = &self.guard else { return };
        let maker = self.metric.as_mut().unwrap_or(&mut self.assembler);
        let columns = &maker.pattern().col_ptr;
        for (&diagonal, _) in columns.iter().zip(&guard.frozen).filter(|c| *c.1) {
            self.values[diagonal] *= RIGID;
        }
    }

    /// No step, and no say in the others', for frozen vertices.
    fn rest_frozen(&mut self) {
        if let Some(guard) = &self.guard {
            for (w, &frozen) in self.w.iter_mut().zip(&guard.frozen) {
                if frozen {
                    *w = 0.0;
                }
            }
        }
    }

    /// Whether the trial point is folded where the current one is not.
    fn would_fold(&mut self) -> bool {
        self.guard.as_mut().is_some_and(|g| {
            g.next = FoldState::new(&g.topology, &g.elements, &self.trial);
            g.marked.fill(false);
            g.folds
                .mark_folds(&g.next, &g.topology, &g.elements, &mut g.marked)
        })
    }

    /// Lays the vertices next to the last fold to rest; whether there were any that moved.
    fn lay_to_rest(&mut self) -> bool {
        let Some(g) = &mut self.guard else {
            return false;
        };
        let mut any = false;
        for (&v, frozen) in self.assembler.unknowns().vertex.iter().zip(&mut g.frozen) {
            if g.marked[v as usize] {
                any |= !std::mem::replace(frozen, true);
            }
        }
        any
    }

    /// Vertices that rest because a step of theirs would fold the surface.
    pub fn frozen(&self) -> usize {
        self.guard
            .as_ref()
            .map_or(0, |g| g.frozen.iter().filter(|&&f| f).count())
    }

    fn pull_back_trial(&mut self) {
        if let Some(held) = &self.constraints {
            held.pull_back(self.assembler.unknowns(), &mut self.trial_gradient);
        }
    }

    fn accept(&mut self, sum: EnergySum) {
        self.current = sum;
        if let Some(guard) = &mut self.guard {
            std::mem::swap(&mut guard.folds, &mut guard.next);
        }
        std::mem::swap(&mut self.positions, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
    }
}

/// `out_j = factor N_j · G_j`.
fn project(gradient: &[DVec3], normals: &[DVec3], factor: f64, out: &mut [f64]) {
    for ((out, g), n) in out.iter_mut().zip(gradient).zip(normals) {
        *out = factor * n.dot(*g);
    }
}
