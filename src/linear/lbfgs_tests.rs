use super::super::test_matrices::noise;
use super::*;

/// Gradient of ½ xᵀ A x for the tridiagonal A = tridiag(-1, 2 + i/n, -1).
fn gradient(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| {
            let left = if i > 0 { x[i - 1] } else { 0.0 };
            let right = if i + 1 < n { x[i + 1] } else { 0.0 };
            (2.0 + i as f64 / n as f64) * x[i] - left - right
        })
        .collect()
}

#[test]
fn empty_history_is_the_preconditioned_gradient() {
    let mut g = [1.0, -2.0];
    Lbfgs::new().direction(&mut g, |v| v.iter_mut().for_each(|x| *x *= 3.0));
    assert_eq!(g, [-3.0, 6.0]);
}

#[test]
fn secant_equation_holds_for_the_newest_pair() {
    let mut memory = Lbfgs::new();
    let mut newest = (Vec::new(), Vec::new());
    for seed in 0..8 {
        let s = noise(seed, 12);
        let y = gradient(&s);
        assert!(memory.push(&s, &y));
        newest = (s, y);
    }
    assert_eq!(memory.pairs.len(), 5);
    let mut direction = newest.1;
    memory.direction(&mut direction, |v| v.iter_mut().for_each(|x| *x *= 0.4));
    for (d, s) in direction.iter().zip(&newest.0) {
        assert!((d + s).abs() < 1e-13, "H y = s");
    }
}

#[test]
fn conjugate_pairs_that_span_the_space_give_newton_exactly() {
    // Exact line searches make successive steps conjugate; after n of them H = A⁻¹.
    let n = 5;
    let mut memory = Lbfgs::new();
    let mut x = noise(11, n);
    for _ in 0..n {
        let g = gradient(&x);
        let mut d = g.clone();
        memory.direction(&mut d, |_| {});
        let ad = gradient(&d);
        let length = -dot(&g, &d) / dot(&d, &ad);
        let s: Vec<f64> = d.iter().map(|v| length * v).collect();
        axpy(1.0, &s, &mut x);
        memory.push(&s, &gradient(&s));
    }
    assert!(x.iter().all(|v| v.abs() < 1e-12), "finite termination");
    let target = noise(12, n);
    let mut d = gradient(&target);
    memory.direction(&mut d, |_| {});
    for (d, t) in d.iter().zip(&target) {
        assert!((d + t).abs() < 1e-10);
    }
}

#[test]
fn exact_inverse_stays_exact_whatever_the_pairs() {
    let a = [2.0, 5.0, 0.5];
    let mut memory = Lbfgs::new();
    for seed in 0..3 {
        let s = noise(seed, 3);
        let y: Vec<f64> = s.iter().zip(a).map(|(s, a)| a * s).collect();
        memory.push(&s, &y);
    }
    let mut g = [4.0, -10.0, 1.0];
    memory.direction(&mut g, |v| v.iter_mut().zip(a).for_each(|(x, a)| *x /= a));
    for (d, exact) in g.iter().zip([-2.0, 2.0, -2.0]) {
        assert!((d - exact).abs() < 1e-14);
    }
}

#[test]
fn pairs_without_curvature_are_refused() {
    let mut memory = Lbfgs::new();
    assert!(!memory.push(&[1.0, 0.0], &[0.0, 1.0]));
    assert!(!memory.push(&[1.0, 0.0], &[-1.0, 0.0]));
    assert!(!memory.push(&[1.0, 0.0], &[f64::NAN, 0.0]));
    assert!(!memory.push(&[0.0, 0.0], &[0.0, 0.0]));
    assert!(memory.pairs.is_empty());
    assert!(memory.push(&[1.0, 0.0], &[2.0, 0.0]));
    memory.clear();
    assert!(memory.pairs.is_empty());
    assert!(memory.push(&[1.0], &[2.0]), "another length after clear");
}
