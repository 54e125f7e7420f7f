//! Guarded descent: all three components of every vertex, in the metric of scheme B.
//!
//! Scheme B moves vertices along the normals. On coarse irregular meshes that is not enough: where
//! the parametrization is bad the discrete energy can be lowered only by sliding vertices along the
//! surface, and steps along normals alone creep. Here the whole exact gradient is followed,
//! `d = −H G` with `H` for each component the inverse of scheme B's matrix as if all displacements lay along
//! the normals ([`Assembler::make_isotropic`]), corrected by L-BFGS. Every
//! step is searched for a decrease of the energy (Armijo) and must fold nothing ([`FoldState`]); where
//! it would, the vertices concerned are damped one by one, `H → D H D`, and the others go on.

mod approach;

use std::sync::Arc;

use crate::energy::Energy;
use crate::linear::{Cholesky, CholeskySymbolic, Lbfgs};
use crate::mesh::{DVec3, Topology};
use crate::solver::assembly::{Assembler, EnergySum};
use crate::solver::constraints::Constraints;
use crate::solver::control::{Attempt, StepKind};
use crate::solver::fold_guard::FoldState;
use crate::solver::quadrature_levels::{
    FOLD_CHECK_RULE, PRECONDITIONER_RULE, coarsened, energy_and_preconditioner,
};
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::{Elements, Rule};
use crate::surface::sample_surface;

/// Steps with one matrix.
const REFRESH: usize = 10;
/// Shortest part of a step tried, and trial points in all, those that fold included.
const SHORTEST: f64 = 1.0 / 65536.0;
const TRIALS: usize = 48;
/// Part of the slope a step must gain.
const ARMIJO: f64 = 1e-4;
/// Factor on the steps of vertices next to a fold; below `FROZEN` they rest.
const DAMP: f64 = 0.3;
const FROZEN: f64 = 1e-3;
/// How fast damped vertices come back.
const RECOVER: f64 = 4.0;

/// State of the guarded descent.
pub struct GuardedFlow {
    topology: Topology,
    /// Where normals are watched.
    watched: Elements,
    assembler: Assembler,
    /// Of the metric, where the energy has more points than that needs.
    metric: Option<Assembler>,
    cholesky: Cholesky,
    radius: f64,
    energy: Energy,
    positions: Vec<DVec3>,
    current: EnergySum,
    gradient: Vec<DVec3>,
    folds: FoldState,
    constraints: Option<Constraints>,
    memory: Lbfgs,
    /// Steps since the last factorization.
    age: Option<usize>,
    /// Factor on the step of each unknown; 0 for those held.
    damping: Vec<f64>,
}

/// A point that was found acceptable.
struct Found {
    positions: Vec<DVec3>,
    sum: EnergySum,
    gradient: Vec<DVec3>,
    folds: FoldState,
    /// The move as a flat vector, x, y and z components one after the other.
    shift: Vec<f64>,
    /// Longest move the direction asked for, before any shortening.
    longest: f64,
}

impl GuardedFlow {
    /// Sets the descent up on `elements` with tables for `rule`.
    ///
    /// # Errors
    /// As for [`crate::solver::NormalFlow::new`].
    pub fn new(
        problem: &FlowProblem,
        elements: &Elements,
        rule: Rule,
        energy: &Energy,
    ) -> Result<Self, SolverError> {
        let (mut assembler, mut metric) =
            energy_and_preconditioner(problem, elements, rule, PRECONDITIONER_RULE);
        let maker = metric.as_mut().unwrap_or(&mut assembler);
        maker.make_isotropic();
        let symbolic = Arc::new(CholeskySymbolic::new(maker.pattern())?);
        let held = Constraints::of(problem, maker);
        let watched = coarsened(problem, elements, rule, FOLD_CHECK_RULE).into_owned();
        let positions = problem.positions().to_vec();
        let mut gradient = Vec::new();
        let current = assembler.gradient(&positions, energy, &mut gradient);
        if !current.value.is_finite() {
            return Err(SolverError::energy_not_finite(&sample_surface(
                elements,
                &positions,
                energy,
                problem.radius(),
            )));
        }
        let mut flow = Self {
            folds: FoldState::new(problem.topology(), &watched, &positions),
            topology: problem.topology().clone(),
            watched,
            damping: vec![1.0; assembler.unknowns().len()],
            assembler,
            metric,
            cholesky: Cholesky::new(symbolic),
            radius: problem.radius(),
            energy: energy.clone(),
            positions,
            current,
            gradient,
            constraints: held,
            memory: Lbfgs::new(),
            age: None,
        };
        if let Some(held) = &flow.constraints {
            held.pull_back(flow.assembler.unknowns(), &mut flow.gradient);
            held.clear(&mut flow.damping);
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

    /// One step; `tau` is the time step of the matrix, if a new one is due.
    pub fn attempt(&mut self, tau: f64) -> Attempt {
        let fresh = self.age.is_none_or(|age| age >= REFRESH);
        if fresh && let Err(note) = self.factorize(tau) {
            return Attempt::rejected(Some(note));
        }
        let found = self.search();
        let Some(found) = found else {
            self.age = None;
            return Attempt {
                needs_refactorization: !fresh,
                ..Attempt::rejected(None)
            };
        };
        let change = flat(
            found
                .gradient
                .iter()
                .zip(&self.gradient)
                .map(|(new, old)| *new - *old),
        );
        self.memory.push(&found.shift, &change);
        self.age = self.age.map(|age| age + 1);
        let damped = self.damping.iter().any(|&d| d > 0.0 && d < 1.0);
        for d in &mut self.damping {
            *d = (RECOVER * *d).min(1.0);
        }
        self.positions = found.positions;
        self.current = found.sum;
        self.gradient = found.gradient;
        self.folds = found.folds;
        // a step that the guard shortened says nothing about how far the stationary shape is
        let longest = if damped {
            found.longest.max(self.radius * 1e-3)
        } else {
            found.longest
        };
        Attempt::accepted(
            longest,
            if fresh {
                StepKind::Factorized
            } else {
                StepKind::QuasiNewton
            },
        )
    }

    fn factorize(&mut self, tau: f64) -> Result<(), String> {
        let mut values = Vec::new();
        let normals = vec![DVec3::X; self.assembler.unknowns().len()];
        self.metric.as_mut().unwrap_or(&mut self.assembler).matrix(
            &self.positions,
            &normals,
            &self.energy,
            self.radius,
            tau,
            &mut Vec::new(),
            &mut values,
        );
        if let Some(held) = &mut self.constraints {
            held.hold(&normals, &mut values);
        }
        self.cholesky
            .factorize(&values)
            .map_err(|e| e.to_string())?;
        self.memory.clear();
        self.age = Some(0);
        for d in &mut self.damping {
            // frozen vertices get another chance
            *d = d.max(FROZEN);
        }
        if let Some(held) = &self.constraints {
            held.clear(&mut self.damping);
        }
        Ok(())
    }

    /// Looks for an acceptable point along the direction of descent.
    fn search(&mut self) -> Option<Found> {
        let n = self.gradient.len();
        let mut direction = self.direction();
        let mut length = 1.0;
        let mut marked = vec![false; self.positions.len()];
        let mut positions = self.positions.clone();
        let mut gradient = Vec::new();
        for _ in 0..TRIALS {
            if length < SHORTEST {
                return None;
            }
            let mut slope = 0.0;
            let mut longest = 0.0f64;
            for (i, &v) in self.assembler.unknowns().vertex.iter().enumerate() {
                let d = DVec3::new(direction[i], direction[n + i], direction[2 * n + i]);
                slope += length * d.dot(self.gradient[i]);
                longest = longest.max(d.length());
                positions[v as usize] = self.positions[v as usize] + length * d;
            }
            if !(slope < 0.0 && longest.is_finite()) {
                return None;
            }
            if let Some(held) = &self.constraints {
                held.settle(&mut positions);
            }
            let folds = FoldState::new(&self.topology, &self.watched, &positions);
            marked.fill(false);
            if self
                .folds
                .mark_folds(&folds, &self.topology, &self.watched, &mut marked)
            {
                self.damp(&marked);
                direction = self.direction();
                continue;
            }
            let sum = self
                .assembler
                .gradient(&positions, &self.energy, &mut gradient);
            let limit = self.current.value + ARMIJO * slope + 1e-12 * self.current.scale;
            if sum.value.is_finite() && sum.value <= limit {
                if let Some(held) = &self.constraints {
                    held.pull_back(self.assembler.unknowns(), &mut gradient);
                }
                for d in &mut direction {
                    *d *= length;
                }
                return Some(Found {
                    positions,
                    sum,
                    gradient,
                    folds,
                    shift: direction,
                    longest,
                });
            }
            length *= 0.5;
        }
        None
    }

    /// `−D H D G`, x, y and z components one after the other.
    fn direction(&mut self) -> Vec<f64> {
        let mut out = flat(self.gradient.iter().copied());
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

    fn damp(&mut self, marked: &[bool]) {
        for (&v, d) in self
            .assembler
            .unknowns()
            .vertex
            .iter()
            .zip(&mut self.damping)
        {
            if marked[v as usize] {
                *d = if *d * DAMP < FROZEN { 0.0 } else { *d * DAMP };
            }
        }
        // pairs of other dampings would move the frozen vertices again
        self.memory.clear();
    }
}

/// Components one after the other.
fn flat(vectors: impl ExactSizeIterator<Item = DVec3>) -> Vec<f64> {
    let n = vectors.len();
    let mut out = vec![0.0; 3 * n];
    for (i, v) in vectors.enumerate() {
        (out[i], out[n + i], out[2 * n + i]) = (v.x, v.y, v.z);
    }
    out
}
