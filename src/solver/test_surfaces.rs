//! Small surfaces for unit tests.

use crate::energy::Energy;
use crate::mesh::DVec3;
use crate::solver::{Flow, FlowOptions, FlowProblem};

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

/// The distance from a low paraboloid over the lattice to which a flow returns from a plane, relative to
/// its height. Only its heights up to ring 2 are given; the curvature of the surroundings is another one.
/// The curvature at ring 1 is free or not.
pub fn distance_from_paraboloid(options: FlowOptions, is_free: bool) -> f64 {
    let flat = lattice(8);
    let size = 1e-4;
    let height = |p: DVec3| size * (0.02 * p.x * p.x - 0.01 * p.x * p.y + 0.03 * p.y);
    let mut start = flat.positions().to_vec();
    for (p, &ring) in start.iter_mut().zip(flat.ring()) {
        p.z = match ring {
            0 => 0.0,
            1 | 2 => height(*p),
            _ => height(*p) + size,
        };
    }
    let triangles: Vec<[u32; 3]> = flat.topology().triangles().collect();
    let problem = FlowProblem::new(&start, &triangles, flat.interior(), 4.0).expect("a problem");
    let rim = (0..).zip(problem.ring()).filter(|(_, ring)| **ring == 1);
    let rim: Vec<u32> = rim.map(|(v, _)| v).collect();
    let problem = problem.with_free_curvatures(if is_free { rim } else { Vec::new() });
    let centre = problem.centre();
    let mut flow = Flow::new(problem, options).expect("a flow");
    flow.run(|_, _| true).expect("steps");
    let inner = flat.interior().iter();
    let errors = inner.map(|&v| {
        let p = flow.positions()[v as usize] + centre;
        (p.z - height(p)).abs() / size
    });
    errors.fold(0.0, f64::max)
}

/// The energy of an expression without parameters.
pub fn energy(text: &str) -> Energy {
    Energy::parse(text, &std::collections::BTreeMap::new()).expect("a known energy")
}
