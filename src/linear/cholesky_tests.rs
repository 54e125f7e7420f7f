use glam::DVec3;

use super::super::nested_dissection;
use super::super::test_matrices::{Graph, identity_order, noise};
use super::*;

fn factorized(pattern: &SymmetricPattern, values: &[f64]) -> Cholesky {
    let symbolic = Arc::new(CholeskySymbolic::new(pattern).expect("small"));
    let mut cholesky = Cholesky::new(symbolic);
    cholesky.factorize(values).expect("positive definite");
    cholesky
}

fn max_abs_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f64::max)
}

#[test]
fn one_dimensional_laplacian_gives_the_parabola() {
    // -u'' = 2 on (0, 1), u = 0 at both ends: u = x (1 - x), exact for the three-point formula.
    let n = 199;
    let h = 1.0 / (n + 1) as f64;
    let points = vec![DVec3::ZERO; n];
    let edges: Vec<_> = (1..n).map(|i| (i - 1, i)).collect();
    let (pattern, values) = Graph::new(points, &edges).laplacian(2.0, &identity_order(n));
    let mut x = vec![2.0 * h * h; n];
    factorized(&pattern, &values).solve_in_place(&mut x, 1);
    let exact: Vec<f64> = (1..=n)
        .map(|i| i as f64 * h * (1.0 - i as f64 * h))
        .collect();
    // Condition number 4 / (π h)² = 1.6e4, so 1e-11 is ten times the expected error.
    assert!(max_abs_difference(&x, &exact) < 1e-11);
}

#[test]
fn two_dimensional_laplacian_has_sines_as_eigenvectors() {
    let (nx, ny) = (31, 23);
    let graph = Graph::grid(nx, ny, 1);
    let perm = nested_dissection(&graph.points, &graph.offsets, &graph.adjacency);
    let (pattern, values) = graph.laplacian(4.0, &perm);
    let mut cholesky = factorized(&pattern, &values);
    let angle = |k: usize, m: usize| std::f64::consts::PI * k as f64 / (m + 1) as f64;
    for (kx, ky) in [(1, 1), (3, 2), (31, 23)] {
        let eigenvalue = 4.0 - 2.0 * angle(kx, nx).cos() - 2.0 * angle(ky, ny).cos();
        let mode: Vec<f64> = perm
            .iter()
            .map(|&v| {
                let (i, j) = (v as usize % nx + 1, v as usize / nx + 1);
                (angle(kx, nx) * i as f64).sin() * (angle(ky, ny) * j as f64).sin()
            })
            .collect();
        let mut x = mode.clone();
        cholesky.solve_in_place(&mut x, 1);
        let scaled: Vec<f64> = mode.iter().map(|m| m / eigenvalue).collect();
        assert!(max_abs_difference(&x, &scaled) < 1e-12 / eigenvalue);
    }
}

#[test]
fn residual_is_at_rounding_level_and_columns_are_independent() {
    let graph = Graph::grid(40, 33, 3);
    let perm = nested_dissection(&graph.points, &graph.offsets, &graph.adjacency);
    let (pattern, values) = graph.laplacian(25.0, &perm);
    let n = pattern.n;
    let mut cholesky = factorized(&pattern, &values);
    let b = noise(1, 5 * n);
    let mut together = b.clone();
    cholesky.solve_in_place(&mut together, 5);
    for column in 0..5 {
        let rhs = &b[column * n..][..n];
        let x = &together[column * n..][..n];
        let mut ax = vec![0.0; n];
        pattern.multiply(&values, x, &mut ax);
        assert!(max_abs_difference(&ax, rhs) < 1e-13 * 50.0);
        let mut alone = rhs.to_vec();
        cholesky.solve_in_place(&mut alone, 1);
        assert!(max_abs_difference(&alone, x) < 1e-13);
    }
}

#[test]
fn order_does_not_change_the_solution() {
    let graph = Graph::grid(25, 25, 2);
    let n = graph.n();
    let b = noise(2, n);
    let solve = |perm: &[u32]| {
        let (pattern, values) = graph.laplacian(13.0, perm);
        let mut x: Vec<f64> = perm.iter().map(|&v| b[v as usize]).collect();
        factorized(&pattern, &values).solve_in_place(&mut x, 1);
        let mut in_old_order = vec![0.0; n];
        for (&v, &xi) in perm.iter().zip(&x) {
            in_old_order[v as usize] = xi;
        }
        in_old_order
    };
    let natural = solve(&identity_order(n));
    let dissected = solve(&nested_dissection(
        &graph.points,
        &graph.offsets,
        &graph.adjacency,
    ));
    let reversed = solve(&(0..n as u32).rev().collect::<Vec<_>>());
    assert!(max_abs_difference(&natural, &dissected) < 1e-13);
    assert!(max_abs_difference(&natural, &reversed) < 1e-13);
}

#[test]
fn refactorizing_forgets_the_previous_matrix() {
    let graph = Graph::grid(20, 20, 2);
    let (pattern, values) = graph.laplacian(13.0, &identity_order(graph.n()));
    let doubled: Vec<f64> = values.iter().map(|v| 2.0 * v).collect();
    let b = noise(3, pattern.n);
    let mut reused = factorized(&pattern, &doubled);
    reused.factorize(&values).expect("positive definite");
    let (mut x, mut y) = (b.clone(), b);
    reused.solve_in_place(&mut x, 1);
    factorized(&pattern, &values).solve_in_place(&mut y, 1);
    assert_eq!(x, y, "same values, same bits");
}

#[test]
fn first_non_positive_pivot_is_named() {
    let graph = Graph::grid(12, 9, 1);
    let (pattern, mut values) = graph.laplacian(4.5, &identity_order(graph.n()));
    let symbolic = Arc::new(CholeskySymbolic::new(&pattern).expect("small"));
    let mut cholesky = Cholesky::new(symbolic);
    for (row, bad) in [(57, -3.0), (3, f64::NAN), (107, 0.0)] {
        let kept = std::mem::replace(&mut values[pattern.col_ptr[row]], bad);
        assert_eq!(
            cholesky.factorize(&values),
            Err(LinearError::NotPositiveDefinite { index: row })
        );
        values[pattern.col_ptr[row]] = kept;
    }
    assert_eq!(cholesky.factorize(&values), Ok(()));
}

#[test]
fn empty_and_single_systems() {
    let empty = SymmetricPattern::new(0, vec![0], vec![]);
    factorized(&empty, &[]).solve_in_place(&mut [], 1);
    let single = SymmetricPattern::new(1, vec![0, 1], vec![0]);
    let mut x = [3.0];
    factorized(&single, &[4.0]).solve_in_place(&mut x, 1);
    assert_eq!(x, [0.75]);
}
