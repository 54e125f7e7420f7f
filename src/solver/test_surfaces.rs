//! Small surfaces for unit tests.

use crate::energy::Energy;
use crate::mesh::DVec3;
use crate::solver::FlowProblem;

/// A part of the regular triangular lattice in the plane `z = 0`, with edges of length 1. All
/// vertices have valence 6, so the parametrization of each triangle is affine. The inner vertices
/// move.
pub fn lattice(inner: u32) -> FlowProblem {
    let side = inner + 8;
    let at = |i: u32, j: u32| i * side + j;
    let (mut positions, mut triangles, mut interior) = (Vec::new(), Vec::new(), Vec::new());
    let moves = |i: u32| (4..4 + inner).contains(&i);
    for i in 0..side {
        for j in 0..side {
            let (x, y) = (f64::from(j), f64::from(i));
            positions.push(DVec3::new(x + 0.5 * y, 0.75f64.sqrt() * y, 0.0));
            if moves(i) && moves(j) {
                interior.push(at(i, j));
            }
            if i + 1 < side && j + 1 < side {
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }
    FlowProblem::new(&positions, &triangles, &interior, 1.0).expect("a lattice")
}

/// Irregular heights of the moving vertices, at most `size`; 0 at the others.
pub fn bumps(problem: &FlowProblem, size: f64) -> Vec<f64> {
    let mut heights = vec![0.0; problem.positions().len()];
    for (k, &v) in problem.interior().iter().enumerate() {
        heights[v as usize] = size * (2.3 * k as f64 + 1.0).sin();
    }
    heights
}

/// The positions of a problem with these heights added.
pub fn raised(problem: &FlowProblem, heights: &[f64]) -> Vec<DVec3> {
    let lift = |(p, h): (&DVec3, &f64)| *p + *h * DVec3::Z;
    problem.positions().iter().zip(heights).map(lift).collect()
}

/// The energy of an expression without parameters.
pub fn energy(text: &str) -> Energy {
    Energy::parse(text, &std::collections::BTreeMap::new()).expect("a known energy")
}
