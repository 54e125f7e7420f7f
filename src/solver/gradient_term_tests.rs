use super::*;
use crate::linear::{Cholesky, CholeskySymbolic};
use crate::solver::assembly::{Assembler, MatrixForm};
use crate::solver::evaluator::Evaluator;
use crate::solver::test_surfaces::{bumps, distance_from_paraboloid, energy, lattice, raised};
use crate::solver::{End, Flow, FlowOptions};

const RULE: Rule = Rule::Three;

fn term(problem: &FlowProblem, f: &str) -> GradientTerm {
    GradientTerm::of(problem, &energy(f), RULE).expect("the energy has the term")
}

/// A saddle-like surface over the lattice with irregular bumps.
fn curved(problem: &FlowProblem, size: f64) -> Vec<DVec3> {
    let shape = |p: DVec3| DVec3::new(p.x, p.y, 0.05 * p.x * p.y - 0.03 * p.x * p.x);
    let rough = raised(problem, &bumps(problem, size));
    rough
        .into_iter()
        .map(|p| shape(p) + p.z * DVec3::new(0.3, -0.2, 1.0))
        .collect()
}

/// The derivative in the direction of irregular displacements, against central differences.
#[test]
fn the_gradient_is_exact() {
    let problem = lattice(6);
    let unknowns = Unknowns::new(problem.positions().len(), problem.moving());
    let x = curved(&problem, 0.3);
    let mut term = term(&problem, "0.7*gradH2");
    let mut gradient = vec![DVec3::ZERO; unknowns.len()];
    let sum = term.add_gradient(&x, &unknowns, &mut gradient);
    assert!(sum.value > 0.0);
    let direction: Vec<DVec3> = (0..unknowns.len())
        .map(|i| {
            let t = i as f64;
            DVec3::new(
                (3.1 * t).sin(),
                (1.7 * t + 1.0).cos(),
                (0.9 * t + 2.0).sin(),
            )
        })
        .collect();
    let mut at = |step: f64| {
        let mut moved = x.clone();
        for (&v, d) in unknowns.vertex.iter().zip(&direction) {
            moved[v as usize] += step * *d;
        }
        term.evaluate(&moved).value
    };
    let h = 1e-4;
    let wanted = (8.0 * (at(h) - at(-h)) - at(2.0 * h) + at(-2.0 * h)) / (12.0 * h);
    let found: f64 = gradient
        .iter()
        .zip(&direction)
        .map(|(g, d)| g.dot(*d))
        .sum();
    assert!(
        (found - wanted).abs() < 1e-7 * wanted.abs(),
        "{found} {wanted}"
    );
}

fn matrix(problem: &FlowProblem, f: &str, tau: f64) -> (Evaluator, Vec<f64>) {
    let form = MatrixForm::Stationary;
    let mut evaluator = Evaluator::new(problem, &energy(f), RULE, RULE, form).expect("a start");
    let normals = vec![DVec3::Z; evaluator.unknowns().len()];
    let mut values = Vec::new();
    evaluator.matrix(&normals, tau, &mut values);
    (evaluator, values)
}

/// On a plane the matrix is the second variation, with and without another term.
#[test]
fn the_matrix_is_the_second_variation_on_a_plane() {
    let problem = lattice(6);
    let heights = bumps(&problem, 1.0);
    for f in ["gradH2", "H^2+0.4*gradH2"] {
        let (evaluator, values) = matrix(&problem, f, f64::INFINITY);
        let vertices = &evaluator.unknowns().vertex;
        let v: Vec<f64> = vertices.iter().map(|&v| heights[v as usize]).collect();
        let mut product = vec![0.0; v.len()];
        evaluator.pattern().multiply(&values, &v, &mut product);
        let found: f64 = v.iter().zip(&product).map(|(a, b)| a * b).sum();
        let step = 1e-3;
        let elements = problem.discretization().elements(RULE);
        let nothing = Unknowns::none(heights.len());
        let mut assembler = Assembler::new(elements, RULE, nothing);
        let mut term = term(&problem, f);
        let mut at = |size: f64| {
            let scaled: Vec<f64> = heights.iter().map(|h| size * h).collect();
            let x = raised(&problem, &scaled);
            assembler.energy(&x, &energy(f)).value + term.evaluate(&x).value
        };
        let wanted = (at(step) - 2.0 * at(0.0) + at(-step)) / (step * step);
        assert!(
            (found - wanted).abs() < 1e-4 * wanted,
            "{f}: {found} {wanted}"
        );
    }
}

/// Without a time step it is positive definite: the mean curvatures around the moving vertices
/// determine them.
#[test]
fn the_matrix_is_positive_definite() {
    let problem = lattice(8);
    for tau in [1e-6, 1.0, f64::INFINITY] {
        let (evaluator, values) = matrix(&problem, "gradH2", tau);
        let symbolic = CholeskySymbolic::new(evaluator.pattern()).expect("small");
        let result = Cholesky::new(Arc::new(symbolic)).factorize(&values);
        assert!(result.is_ok(), "{tau}: {result:?}");
    }
}

/// A plane is stationary, and low bumps flow back to it: the order is six, with positive coefficient.
#[test]
fn bumps_on_a_plane_vanish() {
    let problem = lattice(8);
    let start = problem
        .clone()
        .with_positions(&raised(&problem, &bumps(&problem, 0.05)));
    let mut flow = Flow::new(start, FlowOptions::new(energy("gradH2"))).expect("a flow");
    let outcome = flow.run(|_, _| true).expect("steps");
    assert_eq!(outcome.end, End::Converged);
    assert!(outcome.energy_end < 1e-9 * outcome.energy_start);
    let height = flow
        .positions()
        .iter()
        .map(|p| p.z.abs())
        .fold(0.0, f64::max);
    assert!(height < 1e-5, "{height:e}");
}

/// Cubic height functions have a linear `Δz`, so they are stationary to second order of the height. The
/// flow restores one from a plane, although heights, slopes and curvatures of the surroundings alone
/// determine it.
#[test]
fn cubic_polynomials_of_small_height_are_restored() {
    let flat = lattice(8);
    let middle = flat.positions().iter().sum::<DVec3>() / flat.positions().len() as f64;
    let size = 1e-4;
    let height = |p: DVec3| {
        let DVec3 { x, y, .. } = 0.1 * (p - middle);
        size * (x * x * x - 2.0 * x * y + y * y + x)
    };
    let exact: Vec<DVec3> = flat
        .positions()
        .iter()
        .map(|&p| p + height(p) * DVec3::Z)
        .collect();
    let triangles: Vec<[u32; 3]> = flat.topology().triangles().collect();
    let mut start = exact.clone();
    for &v in flat.interior() {
        start[v as usize].z = 0.0;
    }
    let problem = FlowProblem::new(&start, &triangles, flat.interior(), 1.0).expect("a problem");
    let centre = problem.centre();
    let mut options = FlowOptions::new(energy("gradH2"));
    options.tau = crate::solver::Tau::Fixed(1e9);
    options.max_steps = 20;
    let mut flow = Flow::new(problem, options).expect("a flow");
    flow.run(|_, _| true).expect("steps");
    let found = flow.positions().iter().map(|&p| p + centre);
    let error = found
        .zip(&exact)
        .map(|(p, q)| p.distance(*q))
        .fold(0.0, f64::max);
    assert!(error < 1e-3 * size, "{error:e}");
}

/// With a free curvature at the rim, that of the surroundings has no influence.
#[test]
fn a_rim_with_free_curvature_continues_normals_only() {
    let mut options = FlowOptions::new(energy("gradH2"));
    options.tau = crate::solver::Tau::Fixed(1e9);
    options.max_steps = 20;
    let [free, given] = [true, false].map(|is| distance_from_paraboloid(options.clone(), is));
    assert!(free < 1e-3, "{free:e}");
    assert!(given > 0.01, "{given:e}");
}
