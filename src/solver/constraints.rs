//! Constrained limit positions as the schemes use them.

use std::sync::Arc;

use crate::mesh::DVec3;
use crate::solver::FlowProblem;
use crate::solver::assembly::Assembler;
use crate::solver::penalty::Penalty;
use crate::solver::unknowns::Unknowns;
use crate::surface::Interpolation;

/// Vertices whose limit positions are given, in the numbering of a scheme's unknowns.
pub struct Constraints {
    interpolation: Arc<Interpolation>,
    penalty: Penalty,
    unknowns: Vec<u32>,
    /// Weight of each held vertex in the matrix last made.
    weights: Vec<f64>,
}

impl Constraints {
    /// Those of a problem, if it holds any.
    pub fn of(problem: &FlowProblem, assembler: &mut Assembler) -> Option<Self> {
        let interpolation = problem.interpolation()?;
        let unknown = assembler.unknowns().of_vertex.clone();
        let held = interpolation.held().iter();
        Some(Self {
            penalty: Penalty::new(interpolation, &unknown, assembler.pattern()),
            unknowns: held.map(|&v| unknown[v as usize]).collect(),
            interpolation: Arc::clone(interpolation),
            weights: Vec::new(),
        })
    }

    /// Derivatives by the free vertices, the held ones following.
    pub fn pull_back(&self, unknowns: &Unknowns, gradient: &mut [DVec3]) {
        self.interpolation.pull_back(&unknowns.of_vertex, gradient);
    }

    /// Holds them in a matrix for displacements along `normals`.
    pub fn hold(&mut self, normals: &[DVec3], values: &mut [f64]) {
        self.weights = self.penalty.add(normals, values);
    }

    /// Where the limit surface passes them.
    pub fn targets(&self) -> &[DVec3] {
        self.interpolation.targets()
    }

    /// Holds them elsewhere.
    pub fn retarget(&mut self, targets: Vec<DVec3>) {
        self.interpolation = Arc::new(self.interpolation.with_targets(targets));
    }

    /// Lets the held vertices follow the others as if they were held at `targets`.
    pub fn settle_at(&self, targets: &[DVec3], positions: &mut [DVec3]) {
        self.interpolation.settle_at(targets, positions);
    }

    /// Adds to the right-hand side (x, y and z components one after the other) what makes the solution
    /// with the matrix last made move the limit surface by `shifts` at the held vertices.
    pub fn pull(&self, shifts: &[DVec3], rhs: &mut [f64]) {
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

    /// The unknowns of the held vertices.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }

    /// Lets the held vertices follow the others.
    pub fn settle(&self, positions: &mut [DVec3]) {
        self.interpolation.settle(positions);
    }

    /// Constrained vertices have no step of their own.
    pub fn clear(&self, step: &mut [f64]) {
        for &u in &self.unknowns {
            step[u as usize] = 0.0;
        }
    }
}
