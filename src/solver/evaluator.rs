//! The discrete energy at the current point of a flow and at a trial point.

use std::sync::Arc;

use crate::energy::Energy;
use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::solver::assembly::{Assembler, EnergySum, MatrixForm};
use crate::solver::constraints::Constraints;
use crate::solver::gradient_term::GradientTerm;
use crate::solver::relax::may_slide;
use crate::solver::unknowns::Unknowns;
use crate::solver::{FlowProblem, SolverError};
use crate::subdivision::Rule;
use crate::surface::sample_surface;

/// Quadrature rule for the matrix of a step with a line search. Such a matrix need not be exact.
pub const PRECONDITIONER_RULE: Rule = Rule::Twelve;

/// A surface with its energy.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// All vertices of the region, relative to the problem's centre.
    pub positions: Vec<DVec3>,
    /// Energy by the quadrature rule of the steps.
    pub energy: EnergySum,
    /// Its gradient by the unknowns; under constraints by the free ones, with 0 at the others.
    pub gradient: Vec<DVec3>,
}

/// Evaluates energy, gradient and the matrix of scheme B. Stores the two points that a step
/// compares.
pub struct Evaluator {
    assembler: Assembler,
    /// For matrices, if they use fewer quadrature points than the energy.
    coarse: Option<Assembler>,
    /// The term of `|∇H|²`, if the energy has one.
    gradient_term: Option<GradientTerm>,
    energy: Energy,
    radius: f64,
    /// The constrained limit positions.
    pub constraints: Option<Constraints>,
    /// The current point.
    pub state: State,
    /// The trial point of the current step; fixed vertices are those of `state`.
    pub trial: State,
}

impl Evaluator {
    /// Starts at the positions of a problem. Energies use `rule`, matrices the coarser of `rule`
    /// and `matrix_rule`. Nested dissection numbers the unknowns.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`].
    pub fn new(
        problem: &FlowProblem,
        energy: &Energy,
        rule: Rule,
        matrix_rule: Rule,
        form: MatrixForm,
    ) -> Result<Self, SolverError> {
        let elements = |rule| problem.discretization().elements(rule);
        let mut gradient_term = GradientTerm::of(problem, energy, rule);
        let (unknowns, scatter) = if let Some(term) = &mut gradient_term {
            term.dissected(problem, rule)
        } else {
            let (unknowns, scatter) =
                Unknowns::dissected(elements(rule), problem.positions(), problem.moving());
            (Arc::new(unknowns), Arc::new(scatter))
        };
        let constraints = Constraints::of(problem, &unknowns, &scatter.pattern);
        let assembler = Assembler::new(elements(rule), rule, Arc::clone(&unknowns));
        let (assembler, coarse) = if rule <= matrix_rule {
            (assembler.with_matrix(scatter, form), None)
        } else {
            let coarse = Assembler::new(elements(matrix_rule), matrix_rule, unknowns);
            (assembler, Some(coarse.with_matrix(scatter, form)))
        };
        let mut out = Self::with_term(problem, energy, assembler, gradient_term)?;
        if let Some(constraints) = &constraints {
            constraints.pull_back(out.assembler.unknowns(), &mut out.state.gradient);
        }
        (out.coarse, out.constraints) = (coarse, constraints);
        Ok(out)
    }

    /// The same with an assembler for energy and gradient only, of `f(H, K)` alone.
    ///
    /// # Errors
    /// [`SolverError::EnergyNotFinite`].
    pub fn without_matrix(
        problem: &FlowProblem,
        energy: &Energy,
        assembler: Assembler,
    ) -> Result<Self, SolverError> {
        Self::with_term(problem, energy, assembler, None)
    }

    fn with_term(
        problem: &FlowProblem,
        energy: &Energy,
        assembler: Assembler,
        gradient_term: Option<GradientTerm>,
    ) -> Result<Self, SolverError> {
        let start = State {
            positions: problem.positions().to_vec(),
            ..State::default()
        };
        let mut out = Self {
            assembler,
            coarse: None,
            gradient_term,
            energy: energy.clone(),
            radius: problem.radius(),
            constraints: None,
            trial: start.clone(),
            state: start,
        };
        out.evaluate_state();
        if !out.state.energy.value.is_finite() {
            let (elements, positions) = (out.assembler.elements(), &out.state.positions);
            let stats = sample_surface(elements, positions, energy, out.radius);
            return Err(SolverError::energy_not_finite(&stats));
        }
        Ok(out)
    }

    /// The unknowns.
    pub fn unknowns(&self) -> &Arc<Unknowns> {
        self.assembler.unknowns()
    }

    /// The energy that is evaluated.
    pub fn energy(&self) -> &Energy {
        &self.energy
    }

    /// Hole radius of the problem.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The sparsity of the matrix.
    pub fn pattern(&self) -> &SymmetricPattern {
        self.coarse.as_ref().unwrap_or(&self.assembler).pattern()
    }

    /// Updates energy and gradient after a change of the current positions or constraints.
    pub fn evaluate_state(&mut self) {
        let constraints = self.constraints.as_ref();
        evaluate(
            &mut self.assembler,
            self.gradient_term.as_mut(),
            &self.energy,
            constraints,
            &mut self.state,
        );
    }

    /// Updates energy and gradient at the trial point.
    pub fn evaluate_trial(&mut self) {
        let constraints = self.constraints.as_ref();
        evaluate(
            &mut self.assembler,
            self.gradient_term.as_mut(),
            &self.energy,
            constraints,
            &mut self.trial,
        );
    }

    /// Moves each unknown of the trial point by `shift` from the current point. Constrained control
    /// points follow.
    pub fn displace(&mut self, shift: impl Fn(usize) -> DVec3) {
        for (i, &v) in self.assembler.unknowns().vertex.iter().enumerate() {
            self.trial.positions[v as usize] = self.state.positions[v as usize] + shift(i);
        }
        if let Some(constraints) = &self.constraints {
            constraints.enforce(&mut self.trial.positions);
        }
    }

    /// Computes energy and gradient at the trial point, and the matrix there for displacements
    /// along `normals`. Requires a single rule and no constraints.
    pub fn evaluate_trial_with_matrix(
        &mut self,
        normals: &[DVec3],
        tau: f64,
        values: &mut Vec<f64>,
    ) {
        let trial = &mut self.trial;
        trial.energy = self.assembler.matrix(
            &trial.positions,
            normals,
            &self.energy,
            self.radius,
            tau,
            &mut trial.gradient,
            values,
        );
        if let Some(term) = &mut self.gradient_term {
            let unknowns = self.assembler.unknowns();
            trial.energy += term.add_gradient(&trial.positions, unknowns, &mut trial.gradient);
            term.add_matrix(normals, values);
        }
    }

    /// Computes the matrix at the current point for displacements along `normals`, including
    /// constraints.
    pub fn matrix(&mut self, normals: &[DVec3], tau: f64, values: &mut Vec<f64>) {
        // the gradient is known already, and the coarser rule gives a different one
        self.coarse.as_mut().unwrap_or(&mut self.assembler).matrix(
            &self.state.positions,
            normals,
            &self.energy,
            self.radius,
            tau,
            &mut Vec::new(),
            values,
        );
        if let Some(term) = &mut self.gradient_term {
            let unknowns = self.assembler.unknowns();
            let mut gradient = vec![DVec3::ZERO; unknowns.len()];
            term.add_gradient(&self.state.positions, unknowns, &mut gradient);
            term.add_matrix(normals, values);
        }
        if let Some(constraints) = &mut self.constraints {
            constraints.add_to_matrix(normals, values);
        }
    }

    /// Adapts the matrix to the outcome of a step with it: stiffer if the step did not lower the energy.
    pub fn learn(&mut self, lowered: bool) {
        match &mut self.gradient_term {
            Some(term) if lowered => term.soften(),
            Some(term) => term.stiffen(),
            None => {}
        }
    }

    /// Whether the energy of the trial point is finite and not above the current one.
    pub fn admits_trial(&self) -> bool {
        self.state.energy.admits(&self.trial.energy)
    }

    /// Makes the trial point the current one.
    pub fn accept_trial(&mut self) {
        std::mem::swap(&mut self.state, &mut self.trial);
    }

    /// Moves to other positions, such as a slide along the surface after a step from energy
    /// `before`. The move is made only if it gives back at most a part of the step's gain. Returns
    /// whether it was made.
    pub fn slide(&mut self, positions: &[DVec3], before: EnergySum) -> bool {
        self.trial.positions.copy_from_slice(positions);
        self.evaluate_trial();
        let accepted = may_slide(before, self.state.energy, self.trial.energy);
        if accepted {
            self.accept_trial();
        }
        accepted
    }
}

fn evaluate(
    assembler: &mut Assembler,
    gradient_term: Option<&mut GradientTerm>,
    energy: &Energy,
    constraints: Option<&Constraints>,
    state: &mut State,
) {
    state.energy = assembler.gradient(&state.positions, energy, &mut state.gradient);
    if let Some(term) = gradient_term {
        let unknowns = assembler.unknowns();
        state.energy += term.add_gradient(&state.positions, unknowns, &mut state.gradient);
    }
    if let Some(constraints) = constraints {
        constraints.pull_back(assembler.unknowns(), &mut state.gradient);
    }
}

#[cfg(test)]
#[path = "evaluator_tests.rs"]
mod tests;
