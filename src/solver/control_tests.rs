use super::*;

/// Mode, way of choosing τ, growth; first τ, and τ after each of: accept, accept, reject, accept.
#[test]
fn time_steps_follow_their_law() {
    let (fast, flow) = (Mode::Fast, Mode::Flow);
    // tau_ref is 2, the first τ of a flow in true time 5e-5
    for (mode, tau, growth, wanted) in [
        (fast, Tau::Auto, None, [4.0, 40.0, 400.0, 50.0, 500.0]),
        (fast, Tau::Auto, Some(2.0), [4.0, 8.0, 16.0, 2.0, 4.0]),
        (
            flow,
            Tau::Auto,
            None,
            [5e-5, 6.5e-5, 8.45e-5, 1.056_25e-5, 1.373_125e-5],
        ),
        // a fixed step is restored by doubling
        (fast, Tau::Fixed(0.5), None, [0.5, 0.5, 0.5, 0.0625, 0.125]),
        (
            flow,
            Tau::Fixed(0.5),
            Some(9.0),
            [0.5, 0.5, 0.5, 0.0625, 0.125],
        ),
    ] {
        let mut control = StepSizeControl::new(mode, tau, 2.0, 5e-5, growth);
        let mut found = vec![control.tau];
        for accepted in [true, true, false, true] {
            if accepted {
                assert_eq!(control.next(), {
                    control.accept();
                    control.tau
                });
            } else {
                assert!(!control.reject());
            }
            found.push(control.tau);
        }
        for (f, w) in found.iter().zip(wanted) {
            assert!((f / w - 1.0).abs() < 1e-14, "{mode:?} {tau:?}: {found:?}");
        }
    }
}

#[test]
fn time_steps_stay_in_their_range() {
    for (first, wanted) in [(1.0, 2e-4), (1e-20, 2e-9), (1e-6, 1e-6)] {
        let control = StepSizeControl::new(Mode::Flow, Tau::Auto, 2.0, first, None);
        assert_eq!(control.tau, wanted);
    }
    let mut control = StepSizeControl::new(Mode::Fast, Tau::Auto, 2.0, 1.0, None);
    for _ in 0..20 {
        control.accept();
    }
    assert_eq!(control.tau, 2e12);
}

/// From `2 τ_ref` by eighths to `1e-14 τ_ref`, or equally far below a fixed τ that is even shorter.
#[test]
fn rejected_steps_collapse_in_the_end() {
    for (tau, wanted) in [(Tau::Auto, 16), (Tau::Fixed(1e-6), 16)] {
        let mut control = StepSizeControl::new(Mode::Fast, tau, 2.0, 1.0, None);
        let rejections = (1..100).find(|_| control.reject());
        assert_eq!(rejections, Some(wanted), "{tau:?}");
    }
}

/// A step shorter than `τ_ref` is extrapolated to it; a longer one counts unchanged.
#[test]
fn residuals_are_displacements_in_the_natural_time() {
    let control = StepSizeControl::new(Mode::Fast, Tau::Auto, 2.0, 1.0, None);
    assert_eq!(control.residual(0.5, 0.5, 0.25), 8.0);
    assert_eq!(control.residual(0.5, 8.0, 0.25), 2.0);
}

#[test]
fn energies_that_stop_falling_are_noticed() {
    let sum = |value| EnergySum { value, scale: 1.0 };
    let first_stop = |fall: f64| {
        let mut test = StagnationTest::default();
        (1..100).find(|&k| test.has_stagnated(sum(5.0 - fall * f64::from(k)), 1e-3))
    };
    assert_eq!(first_stop(0.0), Some(11));
    assert_eq!(first_stop(-1.0), Some(11));
    assert_eq!(first_stop(2e-3), None);
    // ten steps together count
    assert_eq!(first_stop(2e-4), None);
    assert_eq!(first_stop(0.9e-4), Some(11));
}

#[test]
fn steps_may_rise_by_rounding_only() {
    let sum = |value| EnergySum { value, scale: 2.0 };
    assert!(sum(1.0).admits(&sum(0.5)) && sum(1.0).admits(&sum(1.0 + 1e-12)));
    assert!(!sum(1.0).admits(&sum(1.0 + 3e-12)) && !sum(1.0).admits(&sum(f64::NAN)));
}
