//! Scheme A: the paper's mixed finite element method, equations (18)-(23) corrected.
//!
//! The curvature normals `h = 2Hn` and `k = 2Kn` are separate unknowns, piecewise linear on rings 0
//! and 1. The other unknowns are the positions of ring 0. All matrices are those of the current
//! surface; one linear system gives all unknowns at the new time. At creases the surface ends in a
//! rim without a support region. There `h` and `k` are data computed from the current surface.
//! `assembly` contains the system, `splitting` the implicit terms, `precond` the preconditioner.
//!
//! The system is solved for increments. Let `h(x)`, `k(x)` be the solutions of the second and third
//! rows at the current positions. These rows then have right-hand side 0, and the first row has
//!
//! - in the plain scheme `−(l^p x + l^m h(x) + l^g k(x) + b)`: this is (23), written from the
//!   current state;
//! - in the residual-corrected variant `−δE`, the exact gradient (12), so that the fixed points are
//!   the stationary points of the discrete energy.
//!
//! A smooth energy is invariant under tangential motion of the surface, but the discrete energy
//! changes slightly. The plain scheme follows that change. Its shape converges within about ten
//! steps of large τ. Its vertices then slide for hundreds of steps, each by a percent of the
//! remaining distance. The corrected variant takes the normal part of the gradient and of the
//! increment at each vertex. It converges like scheme B, to the same shapes.
//!
//! The plain scheme treats terms without second derivatives of `f` explicitly. It is unstable where
//! `f` has only such terms, for example `f = K`. The corrected variant correctly stays stationary
//! under `f = K`.

mod assembly;
mod curvature_projection;
mod kernel;
mod precond;
mod splitting;

use crate::cancel::is_cancelled;
use crate::energy::Energy;
use crate::linear::{GmresOptions, GmresReport, LinearError, SparseLu, gmres};
use crate::mesh::DVec3;
use crate::solver::assembly::{Assembler, EnergySum};
use crate::solver::control::Attempt;
use crate::solver::evaluator::{Evaluator, State};
use crate::solver::normal::max_magnitude;
use crate::solver::normals::LimitNormals;
use crate::solver::record::{RejectReason, StepKind};
use crate::solver::stepper::{StepRequest, Stepper};
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::Rule;
use crate::surface::sample_surface;

use assembly::{System, Units};
use curvature_projection::CurvatureProjection;
use precond::BlockElimination;

/// How the linear system (23) is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinearSolver {
    /// Restarted GMRES with block elimination as preconditioner, to a relative residual.
    Gmres {
        /// Target relative residual.
        tolerance: f64,
    },
    /// Sparse LU.
    Lu,
}

impl Default for LinearSolver {
    fn default() -> Self {
        Self::Gmres { tolerance: 1e-10 }
    }
}

/// Restart length of GMRES; not reached with an effective preconditioner.
const RESTART: usize = 100;
/// Maximum number of GMRES iterations; a smaller τ helps if it is reached.
const MAX_ITERATIONS: usize = 300;
/// A step is rejected if the energy falls by more than this multiple of the decrease that its
/// gradient predicts. The quadrature is then no longer meaningful. (This happens for `f = K`, whose
/// integral is constant on smooth surfaces.)
const IMPLAUSIBLE: f64 = 10.0;

/// State of scheme A.
pub struct MixedFlow {
    system: System,
    precond: BlockElimination,
    evaluator: Evaluator,
    ring: LimitNormals,
    linear: LinearSolver,
    corrected: bool,
    /// Limit normals at the interior vertices.
    normals: Vec<DVec3>,
    /// The curvature normals `2Hn` and `2Kn` of all vertices of the region. On rings 0 and 1 they
    /// are those of the last accepted step (zero before the first). On ring 2 they are fixed;
    /// beyond it they are zero.
    h: Vec<DVec3>,
    k: Vec<DVec3>,
    /// Updates them at creases, where they are data of the current surface.
    creases: Option<CurvatureProjection>,
    /// The same, with `h(x)` and `k(x)` on rings 0 and 1.
    lifted_h: Vec<DVec3>,
    lifted_k: Vec<DVec3>,
    /// Whether the matrices and `force` are those of the current positions.
    assembled: bool,
    /// `δE` at the interior vertices, exact or by the mixed form.
    force: Vec<DVec3>,
    position_block: Vec<f64>,
    rhs: Vec<f64>,
    solution: Vec<f64>,
}

impl MixedFlow {
    /// Sets the scheme up: elements of the 12-point rule, patterns, and the fixed curvature normals
    /// of ring 2 from the starting surface. `corrected` selects the residual-corrected variant.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`] if the energy is not finite at the start, or a failed
    /// symbolic factorization.
    pub fn new(
        problem: &FlowProblem,
        energy: &Energy,
        linear: LinearSolver,
        corrected: bool,
    ) -> Result<Self, SolverError> {
        let elements = problem.discretization().elements(Rule::Twelve);
        let start = sample_surface(elements, problem.positions(), energy, problem.radius());
        let count = problem.positions().len();
        let (mut h, mut k) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
        let is_crease = problem.crease_marks();
        let data = |v: usize| is_crease[v] || problem.ring()[v] == 2;
        CurvatureProjection::new(problem, data).evaluate(problem.positions(), &mut h, &mut k);
        let creases = (!problem.creases().is_empty())
            .then(|| CurvatureProjection::new(problem, |v| is_crease[v]));
        let length = problem.radius();
        let units = Units {
            length,
            force: length * length * length / start.tau_ref,
        };
        let system = System::new(problem, elements.clone(), units);
        let assembler = Assembler::new(elements, Rule::Twelve, system.numbering.x.clone());
        let ring = LimitNormals::new(problem.topology(), &system.numbering.x.vertex);
        let mut normals = Vec::new();
        ring.evaluate(problem.positions(), &mut normals);
        Ok(Self {
            evaluator: Evaluator::without_matrix(problem, energy, assembler)?,
            precond: BlockElimination::new(&system)?,
            rhs: vec![0.0; system.dimension()],
            solution: vec![0.0; system.dimension()],
            system,
            linear,
            corrected,
            ring,
            normals,
            lifted_h: h.clone(),
            lifted_k: k.clone(),
            h,
            k,
            creases,
            assembled: false,
            force: Vec::new(),
            position_block: Vec::new(),
        })
    }

    /// Positions of all vertices of the region, relative to the problem's centre.
    pub fn positions(&self) -> &[DVec3] {
        &self.evaluator.state.positions
    }

    /// Attempts one step of time `tau`. A rejected step does not change the state. The reported
    /// displacement is the normal one, which changes the shape. A `tau` that is not a positive
    /// number is rejected.
    pub fn attempt(&mut self, tau: f64) -> Attempt {
        if !(tau > 0.0 && tau.is_finite()) {
            return Attempt::rejected(RejectReason::TimeStep(tau));
        }
        if !self.assembled {
            if let Err(reason) = self.assemble() {
                return Attempt::rejected(reason);
            }
            self.assembled = true;
        }
        if is_cancelled() {
            return Attempt::rejected(RejectReason::Cancelled);
        }
        self.system.position_block(tau, &mut self.position_block);
        let linear = match self.solve(tau) {
            Ok(report) => report,
            Err(error) => return Attempt::rejected(error.into()),
        };
        let mut attempt = Attempt {
            linear,
            kind: linear.map_or(StepKind::Factorized, |_| StepKind::Krylov),
            ..Attempt::rejected(RejectReason::NoDescent)
        };
        if let Some(report) = linear
            && !report.converged
        {
            attempt.rejection = Some(RejectReason::NotSolved {
                relative_residual: report.relative_residual,
                iterations: report.iterations,
            });
            return attempt;
        }
        let (longest, promised) = self.displace();
        if !longest.is_finite() {
            return attempt;
        }
        self.evaluator.evaluate_trial();
        let [before, after] = [&self.evaluator.state, &self.evaluator.trial].map(|s| s.energy);
        if !self.evaluator.admits_trial() {
            return attempt;
        }
        let fall = before.value - after.value;
        if fall > IMPLAUSIBLE * promised.abs() + 1e-9 * before.scale {
            let promised = -promised;
            attempt.rejection = Some(RejectReason::Unresolved { fall, promised });
            return attempt;
        }
        self.take_curvatures();
        self.evaluator.accept_trial();
        self.after_move();
        Attempt {
            max_displacement: longest,
            rejection: None,
            ..attempt
        }
    }

    /// Computes matrices, `h(x)`, `k(x)` and the force at the current positions.
    fn assemble(&mut self) -> Result<(), RejectReason> {
        let system = &mut self.system;
        let State {
            positions,
            gradient,
            ..
        } = &self.evaluator.state;
        let energy = self.evaluator.energy();
        if let Some(creases) = &self.creases {
            creases.evaluate(positions, &mut self.lifted_h, &mut self.lifted_k);
        }
        let (h, k) = (&self.lifted_h, &self.lifted_k);
        system.assemble(positions, h, k, energy, self.corrected);
        if !system.is_finite() {
            return Err(RejectReason::UndefinedDerivatives);
        }
        self.precond.factorize_mass(system)?;
        // m has the unit r²
        let scale = system.units.length.powi(-2);
        let m = system.numbering.h.len();
        for (rhs, field) in [
            (&mut system.rhs_h, &mut self.lifted_h),
            (&mut system.rhs_k, &mut self.lifted_k),
        ] {
            self.precond.solve_mass(rhs);
            for (j, &v) in system.numbering.h.vertex.iter().enumerate() {
                field[v as usize] = DVec3::new(rhs[j], rhs[m + j], rhs[2 * m + j]) * scale;
            }
        }
        if self.corrected {
            self.force.clear();
            let pairs = gradient.iter().zip(&self.normals);
            self.force.extend(pairs.map(|(g, n)| *n * n.dot(*g)));
        } else {
            let (h, k) = (&self.lifted_h, &self.lifted_k);
            system.residual(positions, h, k, energy, &mut self.force);
        }
        Ok(())
    }

    /// Solves the linear system for the current position block.
    fn solve(&mut self, tau: f64) -> Result<Option<GmresReport>, LinearError> {
        let system = &self.system;
        let position = &self.position_block;
        let n = system.numbering.x.len();
        self.rhs.fill(0.0);
        for (i, force) in self.force.iter().enumerate() {
            for axis in 0..3 {
                self.rhs[axis * n + i] = -force[axis] / system.units.force;
            }
        }
        match self.linear {
            LinearSolver::Gmres { tolerance } => {
                let precond = &mut self.precond;
                precond.factorize(system, position, tau)?;
                self.solution.fill(0.0);
                Ok(Some(gmres(
                    &mut |v, out| system.multiply(position, v, out),
                    &mut |v, out| precond.apply(system, v, out),
                    &self.rhs,
                    &mut self.solution,
                    &GmresOptions {
                        tolerance,
                        restart: RESTART,
                        max_iterations: MAX_ITERATIONS,
                    },
                )))
            }
            LinearSolver::Lu => {
                let mut lu = SparseLu::new(&system.to_csc(position))?;
                self.solution.copy_from_slice(&self.rhs);
                lu.solve_in_place(&mut self.solution, 1);
                // one step of iterative refinement, because rows and columns differ greatly in
                // magnitude
                let mut residual = vec![0.0; self.rhs.len()];
                system.multiply(position, &self.solution, &mut residual);
                for (r, b) in residual.iter_mut().zip(&self.rhs) {
                    *r = b - *r;
                }
                lu.solve_in_place(&mut residual, 1);
                for (x, r) in self.solution.iter_mut().zip(&residual) {
                    *x += r;
                }
                Ok(None)
            }
        }
    }

    /// Sets `trial = positions + δx`. Returns the largest normal displacement, and the change of
    /// energy to first order.
    fn displace(&mut self) -> (f64, f64) {
        let n = self.system.numbering.x.len();
        let r = self.system.units.length;
        let s = &self.solution;
        let step = |i: usize| DVec3::new(s[i], s[n + i], s[2 * n + i]) * r;
        let along = |i: usize| step(i).dot(self.normals[i]);
        let step = |i: usize| {
            if self.corrected {
                self.normals[i] * along(i)
            } else {
                step(i)
            }
        };
        self.evaluator.displace(step);
        let gradient = self.evaluator.state.gradient.iter().enumerate();
        let promised = gradient.fold(0.0, |sum, (i, g)| sum + step(i).dot(*g));
        (max_magnitude((0..n).map(along)), promised)
    }

    /// Updates `h` and `k` after an accepted step.
    fn take_curvatures(&mut self) {
        let r = self.system.units.length;
        let (n, m) = (self.system.numbering.x.len(), self.system.numbering.h.len());
        for (j, &v) in self.system.numbering.h.vertex.iter().enumerate() {
            let v = v as usize;
            let get = |begin: usize| {
                let s = &self.solution[begin + j..];
                DVec3::new(s[0], s[m], s[2 * m])
            };
            self.h[v] = self.lifted_h[v] + get(3 * n) / r;
            self.k[v] = self.lifted_k[v] + get(3 * n + 3 * m) / (r * r);
        }
    }

    fn after_move(&mut self) {
        self.ring
            .evaluate(&self.evaluator.state.positions, &mut self.normals);
        self.assembled = false;
    }
}

impl Stepper for MixedFlow {
    fn state(&self) -> &State {
        &self.evaluator.state
    }

    fn attempt(&mut self, request: &StepRequest) -> Attempt {
        self.attempt(request.tau)
    }

    fn normals(&self) -> Option<(&[u32], &[DVec3])> {
        Some((&self.system.numbering.x.vertex, &self.normals))
    }

    fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool {
        let moved = self.evaluator.slide(positions, before);
        if moved {
            self.after_move();
        }
        moved
    }

    fn first_tau(&self, tau_ref: f64) -> f64 {
        1e-3 * tau_ref
    }
}

#[cfg(test)]
mod tests;
