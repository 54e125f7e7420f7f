use super::*;
use crate::options::Options;

#[test]
fn defaults_need_no_arguments_and_are_the_librarys() {
    assert!(Controls::default().to_arguments().is_empty());
    let options = Controls::default().options().expect("defaults");
    assert_eq!(options.flow, FillOptions::default().flow);
    assert_eq!(options.patch, FillOptions::default().patch);
}

#[test]
fn invalid_options_are_refused_with_their_place() {
    let with = |change: &dyn Fn(&mut Controls)| {
        let mut controls = Controls::default();
        change(&mut controls);
        controls.options().expect_err("an error")
    };
    let error = with(&|c| c.energy = "H^2 + q".into());
    let place = error
        .expression()
        .and_then(ExprError::syntax)
        .expect("a place");
    assert_eq!(place.byte, 6);
    for (change, wanted) in [
        (
            &(|c: &mut Controls| c.density = 0.0) as &dyn Fn(&mut Controls),
            "density",
        ),
        (&|c| c.tau = Tau::Fixed(f64::NAN), "tau"),
        (&|c| c.growth = Some(0.5), "growth"),
        (&|c| c.relaxation = f64::NAN, "relaxation"),
    ] {
        assert!(with(change).to_string().starts_with(wanted));
    }
}

/// A project file may omit options that were added later.
#[test]
fn missing_fields_are_the_defaults() {
    let controls: Controls =
        serde_json::from_str(r#"{"energy":"K^2","tau":{"fixed":0.5}}"#).expect("controls");
    assert_eq!(controls.tau, Tau::Fixed(0.5));
    let wanted = Controls {
        energy: "K^2".into(),
        tau: Tau::Fixed(0.5),
        ..Controls::default()
    };
    assert_eq!(controls, wanted);
    let text = serde_json::to_string(&controls).expect("plain values");
    assert_eq!(
        serde_json::from_str::<Controls>(&text).expect("as written"),
        controls
    );
}

/// The controls of a project file written by version 0.1.
#[test]
fn controls_of_earlier_files_are_read() {
    let text = r#"
energy = "a*H^2"
scheme = "mixed-corrected"
mode = "flow"
linear = "lu"
relaxation = 0.5
density = 1.5
continuity = "G0"
max_steps = 17

[params]
a = 2.0

[tau]
fixed = 0.25

[loop_continuity]
3 = "G1"
"#;
    let controls: Controls = toml::from_str(text).expect("controls");
    let wanted = Controls {
        energy: "a*H^2".into(),
        param: [("a".into(), 2.0)].into(),
        scheme: Scheme::MixedCorrected,
        mode: Mode::Flow,
        linear: Linear::Lu,
        tau: Tau::Fixed(0.25),
        relaxation: 0.5,
        density: 1.5,
        continuity: Continuity::G0,
        loop_continuity: [(2.into(), Continuity::G1)].into(),
        steps: 17,
        ..Controls::default()
    };
    assert_eq!(controls, wanted);
    let written = toml::to_string(&wanted).expect("plain values");
    assert!(written.contains("loop-continuity") && written.contains("\"g0\""));
    assert_eq!(toml::from_str::<Controls>(&written), Ok(wanted));
}

/// A rim can be G2 only under a flow of sixth order, which `auto` then is.
#[test]
fn continuous_curvatures_need_a_flow_of_sixth_order() {
    let with = |surface, energy: &str| Controls {
        surface,
        energy: energy.into(),
        loop_continuity: [(3.into(), Continuity::G2)].into(),
        ..Controls::default()
    };
    for (surface, energy, model) in [
        (Surface::Auto, "H^2", Some(SurfaceModel::G2)),
        (Surface::G2, "H^2", Some(SurfaceModel::G2)),
        (Surface::Auto, "K^2", None),
        (Surface::Energy, "H^2", None),
        (Surface::Diffusion, "gradH2", None),
        (Surface::Energy, "H^2+gradH2", Some(SurfaceModel::Energy)),
        (Surface::Auto, "gradH2", Some(SurfaceModel::Energy)),
    ] {
        let controls = with(surface, energy);
        assert!(!controls.predicts_surface());
        let found = controls.options().map(|options| options.flow.surface);
        match model {
            Some(model) => assert_eq!(found.expect("valid"), model, "{surface:?} {energy}"),
            None => assert!(
                matches!(found, Err(ControlsError::Curvature)),
                "{surface:?}"
            ),
        }
    }
    for (continuity, order, found) in [
        (Continuity::Auto, Order::Sixth, Continuity::G2),
        (Continuity::Auto, Order::Fourth, Continuity::G1),
        (Continuity::G1, Order::Sixth, Continuity::G1),
        (Continuity::G0, Order::Sixth, Continuity::G0),
    ] {
        assert_eq!(continuity.under(order), found);
    }
}

#[test]
fn options_that_a_surface_model_does_not_use_are_named() {
    let mut controls = Controls {
        energy: "a*K".into(),
        param: [("a".into(), 1.0), ("b".into(), 1.0)].into(),
        tension: 3.0,
        bulge: 0.5,
        ..Controls::default()
    };
    assert!(controls.unused().is_empty());
    controls.surface = Surface::G2;
    assert_eq!(controls.unused(), ["energy", "param", "bulge"]);
    controls.surface = Surface::Energy;
    assert!(controls.unused().is_empty());
}
