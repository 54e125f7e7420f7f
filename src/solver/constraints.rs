//! Constrained limit positions in the form that the schemes use.

use std::sync::Arc;

use crate::linear::SymmetricPattern;
use crate::mesh::DVec3;
use crate::solver::FlowProblem;
use crate::solver::penalty::Penalty;
use crate::solver::unknowns::Unknowns;
use crate::surface::Interpolation;

/// Interpolation constraints in the numbering of a scheme's unknowns.
///
/// The control points of the constrained vertices follow those of the free ones, so that the limit
/// surface interpolates the targets. Gradients are pulled back to the free vertices. In matrices, a
/// penalty enforces the limit positions.
pub struct Constraints {
    interpolation: Arc<Interpolation>,
    penalty: Penalty,
    unknowns: Vec<u32>,
    /// Penalty weight of each constrained vertex in the latest matrix.
    weights: Vec<f64>,
}

impl Constraints {
    /// The constraints of a problem, if it has any; `pattern` is that of the matrix over
    /// `unknowns`.
    pub fn of(
        problem: &FlowProblem,
        unknowns: &Unknowns,
        pattern: &SymmetricPattern,
    ) -> Option<Self> {
        let interpolation = problem.interpolation()?;
        let unknown = &unknowns.of_vertex;
        let held = interpolation.constrained().iter();
        Some(Self {
            penalty: Penalty::new(interpolation, unknown, pattern),
            unknowns: held.map(|&v| unknown[v as usize]).collect(),
            interpolation: Arc::clone(interpolation),
            weights: Vec::new(),
        })
    }

    /// Converts derivatives by all unknowns to derivatives by the free ones; 0 at the constrained
    /// ones.
    pub fn pull_back(&self, unknowns: &Unknowns, gradient: &mut [DVec3]) {
        self.interpolation.pull_back(&unknowns.of_vertex, gradient);
    }

    /// Adds the penalty to a matrix for displacements along `normals`.
    pub fn add_to_matrix(&mut self, normals: &[DVec3], values: &mut [f64]) {
        self.weights = self.penalty.add(normals, values);
    }

    /// The current limit positions of the constrained vertices.
    pub fn targets(&self) -> &[DVec3] {
        self.interpolation.targets()
    }

    /// Changes the targets.
    pub fn set_targets(&mut self, targets: Vec<DVec3>) {
        self.interpolation = Arc::new(self.interpolation.with_targets(targets));
    }

    /// Moves the constrained control points so that the limit surface interpolates the targets.
    pub fn enforce(&self, positions: &mut [DVec3]) {
        self.interpolation.enforce(positions);
    }

    /// The same for other targets.
    pub fn enforce_at(&self, targets: &[DVec3], positions: &mut [DVec3]) {
        self.interpolation.enforce_at(targets, positions);
    }

    /// Adds a load to the right-hand side (x, y and z components one after the other). Under this
    /// load, the solution with the latest matrix moves the limit surface by `shifts` at the
    /// constrained vertices.
    pub fn add_load(&self, shifts: &[DVec3], rhs: &mut [f64]) {
        let n = rhs.len() / 3;
        for (i, (&shift, &weight)) in shifts.iter().zip(&self.weights).enumerate() {
            for &(u, part) in self.penalty.row(i) {
                let force = weight * part * shift;
                let u = u as usize;
                rhs[u] += force.x;
                rhs[n + u] += force.y;
                rhs[2 * n + u] += force.z;
            }
        }
    }

    /// The unknowns of the constrained vertices.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }

    /// Sets the entries of the constrained unknowns to zero: they have no independent step.
    pub fn zero_constrained(&self, step: &mut [f64]) {
        for &u in &self.unknowns {
            step[u as usize] = 0.0;
        }
    }
}
