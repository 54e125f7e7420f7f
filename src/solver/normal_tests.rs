use super::*;
use crate::solver::test_surfaces::{bumps, energy, lattice, raised};

fn bumpy(size: f64) -> FlowProblem {
    let flat = lattice(6);
    let positions = raised(&flat, &bumps(&flat, size));
    flat.with_positions(&positions)
}

fn request(tau: f64) -> StepRequest {
    StepRequest {
        tau,
        next_tau: tau,
        may_freeze: false,
    }
}

/// Steps go along the normals, and the area falls to that of the plane.
#[test]
fn bumps_are_flattened_along_the_normals() {
    let problem = bumpy(0.3);
    let mut flow =
        NormalFlow::new(&problem, &energy("1"), Rule::Twelve, MatrixForm::Flow).expect("start");
    let before = flow.state().clone();
    let (vertices, normals) = flow.normals().expect("normals");
    let (vertices, normals) = (vertices.to_vec(), normals.to_vec());
    let attempt = flow.attempt(&request(1e-2));
    assert!(attempt.is_accepted() && attempt.kind == StepKind::Factorized);
    assert!(flow.state().energy.value < before.energy.value);
    let mut longest = 0.0f64;
    for (&v, n) in vertices.iter().zip(&normals) {
        let step = flow.state().positions[v as usize] - before.positions[v as usize];
        assert!(step.reject_from_normalized(*n).length() < 1e-14);
        longest = longest.max(step.length());
    }
    assert!((longest / attempt.max_displacement - 1.0).abs() < 1e-12);
    let mut tau = 1e-2;
    for _ in 0..40 {
        tau *= if flow.attempt(&request(tau)).is_accepted() {
            2.0
        } else {
            0.25
        };
    }
    let area = 0.5 * 0.75f64.sqrt() * problem.active_faces().len() as f64;
    assert!((flow.state().energy.value / area - 1.0).abs() < 1e-9);
}

/// After a factorized step that allows it, quasi-Newton steps follow with the same factor.
#[test]
fn frozen_factors_give_quasi_newton_steps() {
    let problem = bumpy(0.05);
    let form = MatrixForm::Stationary;
    let mut flow = NormalFlow::new(&problem, &energy("1"), Rule::Twelve, form).expect("start");
    let may_freeze = StepRequest {
        may_freeze: true,
        ..request(1e3)
    };
    let kinds = [0, 1].map(|_| {
        let before = flow.state().energy.value;
        let attempt = flow.attempt(&may_freeze);
        assert!(attempt.is_accepted() && flow.state().energy.value < before);
        attempt.kind
    });
    assert_eq!(kinds, [StepKind::Factorized, StepKind::QuasiNewton]);
}

/// The shortest edge over the fastest explicit speed: with twice the bumps it is shorter.
#[test]
fn the_first_time_step_is_limited_by_the_edges() {
    let first = |size: f64| {
        let problem = bumpy(size);
        let flow = NormalFlow::new(&problem, &energy("1"), Rule::Twelve, MatrixForm::Flow);
        flow.expect("start").first_tau(1.0)
    };
    let (low, high) = (first(1e-3), first(2e-3));
    assert!((low / high - 2.0).abs() < 1e-3, "{low} {high}");
}

#[test]
fn constrained_steps_pass_the_targets_and_freeze_nothing() {
    let free = lattice(6);
    let held: Vec<(u32, DVec3)> = [7, 21]
        .map(|k| free.interior()[k])
        .map(|v| {
            (
                v,
                free.positions()[v as usize] + free.centre() + 0.1 * DVec3::Z,
            )
        })
        .to_vec();
    let problem = free.with_constraints(&held).expect("two vertices");
    let interpolation = problem.interpolation().expect("constraints");
    let form = MatrixForm::Stationary;
    let mut flow =
        NormalFlow::new(&problem, &energy("1+H^2"), Rule::FortyEight, form).expect("start");
    let before = flow.state().energy.value;
    for _ in 0..5 {
        assert!(flow.attempt(&request(1.0)).is_accepted());
        assert!(interpolation.error(&flow.state().positions) < 1e-13);
    }
    assert!(flow.state().energy.value < before);
    assert_eq!(flow.frozen(), 0);
}

#[test]
fn a_largest_magnitude_keeps_what_is_not_a_number() {
    assert_eq!(max_magnitude([1.0, -3.0, 2.0].into_iter()), 3.0);
    assert_eq!(max_magnitude([].into_iter()), 0.0);
    assert!(max_magnitude([1.0, f64::NAN, 2.0].into_iter()).is_nan());
}
