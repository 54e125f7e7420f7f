//! Held limit positions as the schemes use them.

use std::sync::Arc;

use crate::mesh::DVec3;
use crate::solver::FlowProblem;
use crate::solver::assembly::Assembler;
use crate::solver::interpolation::Interpolation;
use crate::solver::penalty::Penalty;
use crate::solver::unknowns::Unknowns;

/// Vertices whose limit positions are given, in the numbering of a scheme's unknowns.
pub struct Held {
    interpolation: Arc<Interpolation>,
    penalty: Penalty,
    unknowns: Vec<u32>,
}

impl Held {
    /// Those of a problem, if it holds any.
    pub fn of(problem: &FlowProblem, assembler: &mut Assembler) -> Option<Self> {
        let interpolation = problem.interpolation()?;
        let unknown = assembler.unknowns().of_vertex.clone();
        let held = interpolation.held().iter();
        Some(Self {
            penalty: Penalty::new(interpolation, &unknown, assembler.pattern()),
            unknowns: held.map(|&v| unknown[v as usize]).collect(),
            interpolation: Arc::clone(interpolation),
        })
    }

    /// Derivatives by the free vertices, the held ones following.
    pub fn pull_back(&self, unknowns: &Unknowns, gradient: &mut [DVec3]) {
        self.interpolation.pull_back(&unknowns.of_vertex, gradient);
    }

    /// Holds them in a matrix for displacements along `normals`.
    pub fn hold(&self, normals: &[DVec3], values: &mut [f64]) {
        self.penalty.add(normals, values);
    }

    /// Lets the held vertices follow the others.
    pub fn settle(&self, positions: &mut [DVec3]) {
        self.interpolation.settle(positions);
    }

    /// Held vertices have no step of their own.
    pub fn clear(&self, step: &mut [f64]) {
        for &u in &self.unknowns {
            step[u as usize] = 0.0;
        }
    }
}
