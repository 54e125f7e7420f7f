use super::super::test_matrices::noise;
use super::*;

fn identity(v: &[f64], out: &mut [f64]) {
    out.copy_from_slice(v);
}

/// Upwind convection-diffusion on a line: tridiag(-1 - wind, 2 + wind, -1).
fn convection(wind: f64) -> impl FnMut(&[f64], &mut [f64]) {
    move |v, out| {
        for i in 0..v.len() {
            let left = if i > 0 { v[i - 1] } else { 0.0 };
            let right = if i + 1 < v.len() { v[i + 1] } else { 0.0 };
            out[i] = (2.0 + wind) * v[i] - (1.0 + wind) * left - right;
        }
    }
}

fn options(tolerance: f64, restart: usize) -> GmresOptions {
    GmresOptions {
        tolerance,
        restart,
        max_iterations: 5000,
    }
}

fn relative_residual(mut a: impl FnMut(&[f64], &mut [f64]), b: &[f64], x: &[f64]) -> f64 {
    let mut r = vec![0.0; b.len()];
    a(x, &mut r);
    for (r, b) in r.iter_mut().zip(b) {
        *r -= b;
    }
    norm(&r) / norm(b)
}

#[test]
fn identity_converges_in_one_step() {
    let b = noise(1, 30);
    let mut x = vec![0.0; 30];
    let report = gmres(
        &mut identity,
        &mut identity,
        &b,
        &mut x,
        &options(1e-14, 10),
    );
    assert!(report.converged);
    assert_eq!(report.iterations, 1);
    assert!(x.iter().zip(&b).all(|(x, b)| (x - b).abs() < 1e-14));
}

#[test]
fn full_space_is_exact() {
    let n = 40;
    let b = noise(2, n);
    let mut x = noise(3, n);
    let report = gmres(
        &mut convection(5.0),
        &mut identity,
        &b,
        &mut x,
        &options(1e-13, n),
    );
    assert!(report.converged && report.iterations <= n, "{report:?}");
    assert!(relative_residual(convection(5.0), &b, &x) <= 1e-13);
    // A cyclic shift makes no progress at all before the last of its n steps.
    let mut shift = |v: &[f64], out: &mut [f64]| {
        for i in 0..v.len() {
            out[i] = v[(i + 1) % v.len()];
        }
    };
    let mut unit = vec![0.0; n];
    unit[0] = 1.0;
    let mut x = vec![0.0; n];
    let report = gmres(&mut shift, &mut identity, &unit, &mut x, &options(1e-13, n));
    assert!(report.converged);
    assert_eq!(report.iterations, n);
}

#[test]
fn restarts_reach_the_same_solution_and_report_the_true_residual() {
    let n = 60;
    let b = noise(4, n);
    let (mut full, mut restarted) = (vec![0.0; n], vec![0.0; n]);
    gmres(
        &mut convection(2.0),
        &mut identity,
        &b,
        &mut full,
        &options(1e-12, n),
    );
    let report = gmres(
        &mut convection(2.0),
        &mut identity,
        &b,
        &mut restarted,
        &options(1e-12, 20),
    );
    assert!(report.converged && report.iterations > 20, "{report:?}");
    let truth = relative_residual(convection(2.0), &b, &restarted);
    assert!((truth - report.relative_residual).abs() < 1e-15);
    assert!(
        full.iter()
            .zip(&restarted)
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
}

#[test]
fn exact_preconditioner_needs_one_step() {
    let n = 50;
    // Forward and backward substitution of tridiag(-1, 2.5, -1) = (bidiagonal)(its transpose).
    let mut a = |v: &[f64], out: &mut [f64]| {
        for i in 0..v.len() {
            let left = if i > 0 { v[i - 1] } else { 0.0 };
            let right = if i + 1 < v.len() { v[i + 1] } else { 0.0 };
            out[i] = 2.5 * v[i] - left - right;
        }
    };
    let mut solve = |v: &[f64], out: &mut [f64]| {
        let mut pivots = vec![2.5; v.len()];
        out.copy_from_slice(v);
        for i in 1..v.len() {
            pivots[i] = 2.5 - 1.0 / pivots[i - 1];
            out[i] += out[i - 1] / pivots[i - 1];
        }
        for i in (0..v.len()).rev() {
            let right = if i + 1 < v.len() { out[i + 1] } else { 0.0 };
            out[i] = (out[i] + right) / pivots[i];
        }
    };
    let b = noise(6, n);
    let mut x = vec![0.0; n];
    let report = gmres(&mut a, &mut solve, &b, &mut x, &options(1e-13, 10));
    assert!(report.converged);
    assert_eq!(report.iterations, 1);
}

#[test]
fn hopeless_systems_end_without_convergence() {
    // Singular: b has a component outside the range.
    let mut projection = |v: &[f64], out: &mut [f64]| {
        out.copy_from_slice(v);
        out[0] = 0.0;
    };
    let mut x = vec![0.0; 4];
    let report = gmres(
        &mut projection,
        &mut identity,
        &[1.0; 4],
        &mut x,
        &options(1e-10, 3),
    );
    assert!(!report.converged);
    assert!(
        (report.relative_residual - 0.5).abs() < 1e-12,
        "the best possible"
    );
    let mut undefined = |_: &[f64], out: &mut [f64]| out.fill(f64::NAN);
    let report = gmres(
        &mut undefined,
        &mut identity,
        &[1.0; 4],
        &mut x,
        &options(1e-10, 3),
    );
    assert!(!report.converged);
    let limited = GmresOptions {
        max_iterations: 7,
        ..options(1e-12, 5)
    };
    let mut x = vec![0.0; 60];
    let report = gmres(
        &mut convection(0.0),
        &mut identity,
        &noise(8, 60),
        &mut x,
        &limited,
    );
    assert!(!report.converged);
    assert_eq!(report.iterations, 7);
}

#[test]
fn zero_right_hand_side_and_empty_system() {
    let mut x = vec![3.0; 5];
    let report = gmres(
        &mut identity,
        &mut identity,
        &[0.0; 5],
        &mut x,
        &options(1e-10, 3),
    );
    assert!(report.converged && x == [0.0; 5]);
    assert!(
        gmres(
            &mut identity,
            &mut identity,
            &[],
            &mut [],
            &options(1e-10, 3)
        )
        .converged
    );
}
