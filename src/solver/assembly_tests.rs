use super::*;
use crate::solver::FlowProblem;
use crate::solver::test_surfaces::{bumps, energy, lattice, raised};

const RULE: Rule = Rule::Twelve;

fn assembler(problem: &FlowProblem, form: MatrixForm) -> Assembler {
    let elements = problem.discretization().elements(RULE);
    let (unknowns, scatter) = Unknowns::dissected(elements, problem.positions(), problem.moving());
    Assembler::new(elements, RULE, unknowns).with_matrix(scatter, form)
}

/// The matrix at the flat start.
fn matrix(problem: &FlowProblem, f: &str, form: MatrixForm, tau: f64) -> (Assembler, Vec<f64>) {
    let mut assembler = assembler(problem, form);
    let normals = vec![DVec3::Z; assembler.unknowns().len()];
    let (mut gradient, mut values) = (Vec::new(), Vec::new());
    let (x, f) = (problem.positions(), energy(f));
    assembler.matrix(x, &normals, &f, 1.0, tau, &mut gradient, &mut values);
    (assembler, values)
}

/// `vᵀ A v` for heights `v` of all vertices.
fn quadratic_form(assembler: &Assembler, values: &[f64], heights: &[f64]) -> f64 {
    let vertices = &assembler.unknowns().vertex;
    let v: Vec<f64> = vertices.iter().map(|&v| heights[v as usize]).collect();
    let mut product = vec![0.0; v.len()];
    assembler.pattern().multiply(values, &v, &mut product);
    v.iter().zip(&product).map(|(a, b)| a * b).sum()
}

/// `∫ w²` over the flat lattice of the function `w` with these heights.
fn integral_of_square(problem: &FlowProblem, heights: &[f64]) -> f64 {
    let elements = problem.discretization().elements(RULE);
    let area = 0.5 * 0.75f64.sqrt();
    let at_point = |e: usize, point: usize| -> f64 {
        let row = elements.table(e).row(point, 0).iter();
        row.zip(elements.vertices_of(e))
            .map(|(b, &v)| b * heights[v as usize])
            .sum()
    };
    (0..elements.len())
        .flat_map(|e| (0..elements.table(e).points).map(move |point| (e, point)))
        .map(|(e, point)| RULE.weight() * area * at_point(e, point).powi(2))
        .sum()
}

fn assert_close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} instead of {b}");
}

/// `K` and its second derivatives vanish on a plane: only `M/τ` remains.
#[test]
fn the_mass_matrix_integrates_products() {
    let problem = lattice(5);
    let heights = bumps(&problem, 1.0);
    let (assembler, values) = matrix(&problem, "K", MatrixForm::Flow, 0.25);
    let found = 0.25 * quadratic_form(&assembler, &values, &heights);
    assert_close(found, integral_of_square(&problem, &heights), 1e-13);
}

/// On a plane `S` is the second variation: `∫|∇w|²` for the area, `½∫(Δw)²` for `H²`.
#[test]
fn the_stiffness_matrix_is_the_second_variation_on_a_plane() {
    let problem = lattice(5);
    let heights = bumps(&problem, 1.0);
    for f in ["1", "H^2", "1+H^2"] {
        let (mut assembler, values) = matrix(&problem, f, MatrixForm::Flow, f64::INFINITY);
        let found = quadratic_form(&assembler, &values, &heights);
        let step = 1e-3;
        let mut at = |size: f64| {
            let scaled: Vec<f64> = heights.iter().map(|h| size * h).collect();
            let sum = assembler.energy(&raised(&problem, &scaled), &energy(f));
            sum.value
        };
        let wanted = (at(step) - 2.0 * at(0.0) + at(-step)) / (step * step);
        assert!(found > 0.0);
        assert_close(found, wanted, 2e-5);
    }
}

/// Positive definite, whatever the time step.
#[test]
fn matrices_can_be_factorized() {
    use crate::linear::{Cholesky, CholeskySymbolic};
    let problem = lattice(8);
    for (f, form) in [
        ("1", MatrixForm::Stationary),
        ("H^2", MatrixForm::Flow),
        ("H^2", MatrixForm::Isotropic),
    ] {
        for tau in [1e-6, 1.0, f64::INFINITY] {
            let (assembler, values) = matrix(&problem, f, form, tau);
            let symbolic = CholeskySymbolic::new(assembler.pattern()).expect("small");
            let result = Cholesky::new(Arc::new(symbolic)).factorize(&values);
            assert!(result.is_ok(), "{f} {form:?} {tau}: {result:?}");
        }
    }
}

/// Where the normal is the same everywhere, all forms without a membrane to drop agree.
#[test]
fn the_isotropic_matrix_is_that_of_the_normals_on_a_plane() {
    let problem = lattice(5);
    for f in ["1", "H^2", "1+H^2"] {
        let (_, along_normals) = matrix(&problem, f, MatrixForm::Flow, 0.1);
        let (_, isotropic) = matrix(&problem, f, MatrixForm::Isotropic, 0.1);
        let scale = along_normals.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
        for (a, b) in along_normals.iter().zip(&isotropic) {
            assert!((a - b).abs() < 1e-14 * scale, "{f}: {a} {b}");
        }
    }
}

/// `1 + H²` is elliptic by its Hessian, so the stationary form drops the membrane term. The matrix
/// of `H²` remains.
#[test]
fn the_stationary_form_drops_the_membrane() {
    let problem = lattice(5);
    let (_, dropped) = matrix(&problem, "1+H^2", MatrixForm::Stationary, 0.1);
    let (_, bending) = matrix(&problem, "H^2", MatrixForm::Flow, 0.1);
    let (_, full) = matrix(&problem, "1+H^2", MatrixForm::Flow, 0.1);
    assert_eq!(dropped, bending);
    assert_ne!(dropped, full);
}

/// The kernels with and without a matrix give the same energy and gradient.
#[test]
fn energies_and_gradients_do_not_depend_on_the_matrix() {
    let problem = lattice(6);
    let x = raised(&problem, &bumps(&problem, 0.3));
    let mut assembler = assembler(&problem, MatrixForm::Flow);
    let normals = vec![DVec3::Z; assembler.unknowns().len()];
    let (mut one, mut two, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let f = energy("H^2+K^2");
    let alone = assembler.gradient(&x, &f, &mut one);
    let with = assembler.matrix(&x, &normals, &f, 1.0, 0.1, &mut two, &mut values);
    assert_eq!((alone, &one), (with, &two));
    assert_eq!(assembler.energy(&x, &f), alone);
    assert!(one.iter().any(|g| g.length() > 1e-3));
}

/// The area of a plane, and its gradient at inner vertices, which is zero.
#[test]
fn the_area_of_a_plane_is_exact_and_stationary() {
    let problem = lattice(4);
    let mut assembler = assembler(&problem, MatrixForm::Flow);
    let mut gradient = Vec::new();
    let sum = assembler.gradient(problem.positions(), &energy("1"), &mut gradient);
    let area = 0.5 * 0.75f64.sqrt() * problem.active_faces().len() as f64;
    assert_close(sum.value, area, 1e-14);
    assert!(gradient.iter().all(|g| g.length() < 1e-14));
}
