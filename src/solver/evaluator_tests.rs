use super::*;
use crate::linear::{Cholesky, CholeskySymbolic};
use crate::mesh::VertexId;
use crate::solver::test_surfaces::{bumps, energy, lattice};
use crate::subdivision::limit_position;

/// A lattice whose limit surface is constrained above two neighbouring vertices and one separate
/// vertex.
fn constrained() -> FlowProblem {
    let free = lattice(6);
    let held: Vec<(u32, DVec3)> = [7, 8, 28]
        .into_iter()
        .zip([0.3, 0.1, -0.2])
        .map(|(k, h)| (free.interior()[k], h))
        .map(|(v, h)| {
            (
                v,
                free.positions()[v as usize] + free.centre() + h * DVec3::Z,
            )
        })
        .collect();
    free.with_constraints(&held).expect("three vertices")
}

fn evaluator(problem: &FlowProblem) -> Evaluator {
    let form = MatrixForm::Isotropic;
    Evaluator::new(problem, &energy("1+H^2"), Rule::Twelve, Rule::Three, form).expect("start")
}

/// Distance between the limit surface and the targets.
fn error(problem: &FlowProblem, positions: &[DVec3]) -> f64 {
    let interpolation = problem.interpolation().expect("constraints");
    let pairs = interpolation
        .constrained()
        .iter()
        .zip(interpolation.targets());
    pairs
        .map(|(&v, p)| limit_position(problem.topology(), positions, VertexId(v)).distance(*p))
        .fold(0.0, f64::max)
}

#[test]
fn trial_points_satisfy_the_constraints() {
    let problem = constrained();
    let mut evaluator = evaluator(&problem);
    let heights = bumps(&problem, 0.4);
    let vertices = evaluator.unknowns().vertex.clone();
    evaluator.displace(|i| heights[vertices[i] as usize] * DVec3::new(0.2, 0.1, 1.0));
    assert!(error(&problem, &evaluator.trial.positions) < 1e-13);
    // the current point and fixed vertices do not change
    assert_eq!(evaluator.state.positions, problem.positions());
    for (v, &height) in heights.iter().enumerate() {
        let moved = evaluator.trial.positions[v] != evaluator.state.positions[v];
        assert!(moved == (height != 0.0));
    }
}

/// The gradient is zero at constrained vertices, and gives the change of energy along free
/// displacements, which the constrained vertices follow.
#[test]
fn gradients_are_those_of_the_free_vertices() {
    let problem = constrained();
    let mut evaluator = evaluator(&problem);
    let constrained = evaluator
        .constraints
        .as_ref()
        .expect("three")
        .unknowns()
        .to_vec();
    for &u in &constrained {
        assert_eq!(evaluator.state.gradient[u as usize], DVec3::ZERO);
    }
    let is_free = |i: usize| !constrained.contains(&(i as u32));
    let shift = |i: usize| {
        let wave = (1.7 * i as f64).sin();
        if is_free(i) {
            DVec3::new(0.3 * wave, -0.1, wave)
        } else {
            DVec3::ZERO
        }
    };
    let gradient = evaluator.state.gradient.iter().enumerate();
    let wanted: f64 = gradient.map(|(i, g)| g.dot(shift(i))).sum();
    let mut at = |size: f64| {
        evaluator.displace(|i| size * shift(i));
        evaluator.evaluate_trial();
        evaluator.trial.energy.value
    };
    let step = 1e-5;
    let found = (at(step) - at(-step)) / (2.0 * step);
    assert!((found / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
}

/// Under the load of a shift the preconditioner moves the limit surface by that shift.
#[test]
fn loads_move_the_limit_surface() {
    let problem = constrained();
    let mut evaluator = evaluator(&problem);
    let (n, mut values) = (evaluator.unknowns().len(), Vec::new());
    evaluator.matrix(&vec![DVec3::X; n], 1.0, &mut values);
    let symbolic = CholeskySymbolic::new(evaluator.pattern()).expect("small");
    let mut cholesky = Cholesky::new(Arc::new(symbolic));
    cholesky.factorize(&values).expect("positive definite");
    let constraints = evaluator.constraints.as_ref().expect("three");
    let shifts = [DVec3::X, DVec3::new(0.0, 1.0, 2.0), -DVec3::Z];
    let mut step = vec![0.0; 3 * n];
    constraints.add_load(&shifts, &mut step);
    cholesky.solve_in_place(&mut step, 3);
    let mut moved = problem.positions().to_vec();
    for (i, &v) in evaluator.unknowns().vertex.iter().enumerate() {
        moved[v as usize] += DVec3::new(step[i], step[n + i], step[2 * n + i]);
    }
    let held = problem
        .interpolation()
        .expect("constraints")
        .constrained()
        .iter();
    for ((&v, target), shift) in held.zip(constraints.targets()).zip(shifts) {
        let at = limit_position(problem.topology(), &moved, VertexId(v));
        assert!((at - *target).distance(shift) < 1e-3 * shift.length());
    }
}

#[test]
fn slides_that_cost_too_much_are_refused() {
    let problem = lattice(4);
    let mut evaluator = Evaluator::new(
        &problem,
        &energy("1"),
        Rule::Three,
        Rule::Three,
        MatrixForm::Flow,
    )
    .expect("a plane");
    let before = evaluator.state.energy;
    let moved = |by: DVec3| {
        let mut x = problem.positions().to_vec();
        x[problem.interior()[5] as usize] += by;
        x
    };
    assert!(!evaluator.slide(&moved(0.1 * DVec3::Z), before));
    assert_eq!(evaluator.state.positions, problem.positions());
    assert!(evaluator.slide(&moved(0.1 * DVec3::X), before));
    assert_eq!(evaluator.state.positions, moved(0.1 * DVec3::X));
}
