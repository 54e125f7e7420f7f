//! Derivatives against central differences, closed-form values, parameters.

use std::collections::BTreeMap;

use super::*;

mod umbilics;
mod wellposed;

fn parsed(text: &str) -> Energy {
    let params = BTreeMap::from([
        ("H0".to_owned(), 0.3),
        ("a".to_owned(), 1.7),
        ("c".to_owned(), 1.0),
    ]);
    Energy::parse(text, &params).unwrap_or_else(|error| panic!("{}", error.render()))
}

/// As typed, without the shortcut to presets.
fn unrecognised(text: &str) -> Energy {
    let mut energy = parsed(text);
    let (program, _) = expr::parse(text, energy.params()).expect("parsed before");
    let (program, _) = expr::split_gradient(text, &program).expect("linear");
    let even = program.is_smooth_in_principal();
    energy.density = if program.uses_principal() {
        Density::Principal(Arc::new(program), even)
    } else {
        Density::Plain(Arc::new(program))
    };
    energy
}

fn members(j: &Jet2) -> [f64; 6] {
    [j.f, j.h, j.k, j.hh, j.hk, j.kk]
}

/// The largest difference of two jets. Each member is relative to its magnitude at curvature scale
/// `c`: `f/c^i` for a derivative of weight i.
fn distance(x: &Jet2, y: &Jet2, c: f64) -> f64 {
    let weights = [1.0, c, c * c, c * c, c * c * c, c * c * c * c];
    let scaled = |j: &Jet2| std::array::from_fn::<f64, 6, _>(|i| members(j)[i] * weights[i]);
    let (x, y) = (scaled(x), scaled(y));
    let size = x
        .iter()
        .chain(&y)
        .fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    (0..6).map(|i| (x[i] - y[i]).abs()).fold(0.0, f64::max) / size
}

const POINTS: [[f64; 2]; 8] = [
    [-1.0, 1.0],
    [-0.7, 0.3],
    [0.4, -1.2],
    [1.3, 0.0],
    [0.0, -0.6],
    [-2.1, 4.41],
    [0.02, 1e-4],
    [-5.0, -40.0],
];

#[test]
fn presets_agree_with_their_text_and_are_recognised() {
    for preset in Preset::ALL {
        let energy = parsed(preset.text());
        assert_eq!(energy.as_preset(), Some(preset));
        let closed = if preset == Preset::HMinusH0Squared {
            Energy::preset(preset)
                .with_param("H0", 0.3)
                .expect("a parameter of it")
        } else {
            Energy::preset(preset)
        };
        let typed = unrecognised(preset.text());
        for [h, k] in POINTS {
            assert_eq!(energy.jet(h, k), closed.jet(h, k));
            // κ1⁴ + κ2⁴ is a difference of terms some 20 times itself.
            let d = distance(
                &closed.jet(h, k),
                &typed.jet(h, k),
                h.abs().max(k.abs().sqrt()),
            );
            assert!(d < 1e-14, "{preset} at {h} {k}: {d:e}");
        }
    }
}

#[test]
fn other_ways_to_write_a_preset_are_recognised() {
    for (text, preset) in [
        ("H*H", Preset::H2),
        ("(k1+k2)^2/4", Preset::H2),
        ("k1*k2", Preset::K),
        ("4*H^2 - 2*K", Preset::K1SqPlusK2Sq),
        ("(H - 0.3)^2", Preset::HMinusH0Squared),
        ("2*(k1^2+k2^2) - (k1+k2)^2", Preset::K1MinusK2Squared),
        ("k1^2*k2^2*((k1+k2)/2)^2", Preset::H2K2),
        (" ( k2^4+k1^4 ) ", Preset::K1P4PlusK2P4),
        ("3/3", Preset::One),
        ("sqrt(4*H^2 - 2*K + 7)", Preset::CurvatureNorm),
        ("(k1^2 + k2^2 + 7)^0.5", Preset::CurvatureNorm),
    ] {
        assert_eq!(parsed(text).as_preset(), Some(preset), "{text}");
    }
    for text in [
        "H^2 + 1e-30",
        "2*H^2",
        "H^4",
        "abs(H)^2",
        "H^2 + 1e-20*K",
        "sqrt(k1^2+k2^2)",
    ] {
        assert_eq!(parsed(text).as_preset(), None, "{text}");
    }
}

const SMOOTH: [&str; 24] = [
    "1",
    "H^2",
    "K^2",
    "H^2+K^2",
    "H^2*K^2",
    "k1^4+k2^4",
    "K",
    "(H-H0)^2",
    "k1^2+k2^2",
    "(k1-k2)^2",
    "a*H^2 - H0*K + 0.1",
    "H^3*K - 2/(1+H^2)",
    "exp(-a*H^2)*K",
    "log(1+K^2)*sin(H)",
    "sqrt(2+H)^3",
    "tanh(H)*cos(K)",
    "(1+H^2)^(K/3)",
    "(1+K^2)^-1.5",
    "2^H",
    // With principal curvatures, smooth functions of each.
    "exp(k1)+exp(k2)",
    "tanh(k1)*tanh(k2)",
    "sin(k1)^2+sin(k2)^2+cos(k1*k2)",
    "log(3+k1^2)+log(3+k2^2)",
    "1/(1+k1^2)+1/(1+k2^2)",
];

#[test]
fn derivatives_are_those_of_central_differences() {
    for text in SMOOTH {
        let energy = unrecognised(text);
        // At least 0.4 away from the umbilics, so that no difference leaves the surfaces.
        for [h, k] in [[-0.7, 0.3], [0.4, -1.2], [0.9, 0.0], [0.1, -0.6]] {
            let jet = energy.jet(h, k);
            let d = 1e-3;
            // Fourth-order differences: truncation d⁴ f⁗'/30, roundoff ε f/d.
            let diff = |g: &dyn Fn(f64) -> f64| {
                (8.0 * (g(d) - g(-d)) - (g(2.0 * d) - g(-2.0 * d))) / (12.0 * d)
            };
            let found = Jet2 {
                f: jet.f,
                h: diff(&|d| energy.jet(h + d, k).f),
                k: diff(&|d| energy.jet(h, k + d).f),
                hh: diff(&|d| energy.jet(h + d, k).h),
                hk: diff(&|d| energy.jet(h, k + d).h),
                kk: diff(&|d| energy.jet(h, k + d).k),
            };
            let other = diff(&|d| energy.jet(h + d, k).k);
            assert!(
                distance(&jet, &found, 1.0) < 1e-9,
                "{text} {h} {k}: {jet:?} {found:?}"
            );
            assert!(
                (other - jet.hk).abs() < 1e-9 * (1.0 + jet.hk.abs()),
                "{text} {h} {k}"
            );
        }
    }
}

#[test]
fn integer_powers_are_exact_at_zero() {
    for (text, want) in [
        ("H^2", [0.0, 0.0, 0.0, 2.0, 0.0, 0.0]),
        ("H^3", [0.0; 6]),
        ("H^1*K", [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        ("H^0+K^2", [1.0, 0.0, 0.0, 0.0, 0.0, 2.0]),
        ("0^0*K", [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ("H^2.5", [0.0; 6]),
        ("abs(H)^3", [0.0; 6]),
        ("k1^4+k2^4", [0.0, 0.0, 0.0, 0.0, 0.0, 4.0]),
        ("k1^3+k2^3", [0.0, 0.0, 0.0, 0.0, -6.0, 0.0]),
    ] {
        assert_eq!(members(&unrecognised(text).jet(0.0, 0.0)), want, "{text}");
    }
    // A negative base keeps its sign under an integer power only.
    assert_eq!(parsed("H^-3").jet(-2.0, 0.0).f, -0.125);
    assert!(parsed("H^0.5").jet(-2.0, 0.0).f.is_nan());
    assert!(!parsed("H^1.5").jet(0.0, 0.0).is_finite());
    assert!(!parsed("sqrt(H^2)").jet(0.0, 0.0).is_finite());
}

#[test]
fn branches_take_the_active_side() {
    let abs = parsed("abs(k1)+abs(k2)");
    // Equal signs: 2|H|; opposite signs: κ1 − κ2 = 2s.
    assert_eq!(members(&abs.jet(-1.0, 0.5))[..3], [2.0, -2.0, 0.0]);
    let jet = abs.jet(0.5, -0.75);
    let s: f64 = 1.0;
    assert_eq!([jet.f, jet.h, jet.k], [2.0 * s, 1.0 / s, -1.0 / s]);
    let max = parsed("max(k1,k2)");
    assert_eq!([max.jet(0.5, -0.75).f, max.jet(0.5, -0.75).k], [1.5, -0.5]);
    assert_eq!(parsed("min(k2,k1)").jet(0.5, -0.75).f, -0.5);
    // Not differentiable at umbilics, as documented.
    assert!(!max.jet(1.0, 1.0).is_finite());
    assert!(!parsed("abs(k2-k1)").jet(1.0, 1.0).is_finite());
    // Symmetric in both: the tie does no harm.
    let product = parsed("max(k2,k1)*min(k1,k2)");
    assert_eq!(product.jet(-1.0, 1.0), Jet2::gauss(1.0));
    let cubes = parsed("abs(k1)^3+abs(k2)^3");
    assert!(
        distance(
            &cubes.jet(-1.0, 1.0),
            &-parsed("k1^3+k2^3").jet(-1.0, 1.0),
            1.0
        ) < 1e-15
    );
    assert_eq!(parsed("max(H,0)^2").jet(-1.0, 1.0), Jet2::default());
    assert_eq!(parsed("min(H,K)").jet(2.0, 2.0), Jet2::mean(2.0));
    assert!(parsed("max(log(H),1)").jet(-1.0, 1.0).f.is_nan());
}

/// R(0.05) from R(0) = 1 by R' = −(1/4πR²) d/dR [4πR² f(−1/R, 1/R²)], classical Runge-Kutta.
fn sphere_radius(energy: &Energy) -> f64 {
    let speed = |r: f64| {
        let j = energy.jet(-1.0 / r, 1.0 / (r * r));
        -(2.0 * j.f / r + j.h / (r * r) - 2.0 * j.k / (r * r * r))
    };
    let (mut r, dt) = (1.0, 0.05 / 200.0);
    for _ in 0..200 {
        let a = speed(r);
        let b = speed(r + 0.5 * dt * a);
        let c = speed(r + 0.5 * dt * b);
        let d = speed(r + dt * c);
        r += dt * (a + 2.0 * (b + c) + d) / 6.0;
    }
    r
}

#[test]
fn spheres_flow_as_in_section_9() {
    for (text, radius) in [
        ("1", 0.89443),
        ("H^2", 1.0),
        ("K", 1.0),
        ("K^2", 1.08148),
        ("H^4", 1.08148),
        ("(H-H0)^2", 0.95957),
        ("k1^4+k2^4", 1.14043),
        ("H^2*K^2", 1.12686),
    ] {
        for energy in [parsed(text), unrecognised(text)] {
            let r = sphere_radius(&energy);
            assert!((r - radius).abs() < 6e-6, "{text}: {r} {radius}");
        }
    }
    // f on a sphere of radius 2.
    for (preset, value) in [
        (Preset::One, 1.0),
        (Preset::H2, 0.25),
        (Preset::K2, 0.0625),
        (Preset::H2PlusK2, 0.3125),
        (Preset::H2K2, 0.015_625),
        (Preset::K1P4PlusK2P4, 0.125),
        (Preset::K, 0.25),
        (Preset::HMinusH0Squared, 0.25),
        (Preset::K1SqPlusK2Sq, 0.5),
        (Preset::K1MinusK2Squared, 0.0),
        (Preset::CurvatureNorm, 1.5f64.sqrt()),
        (Preset::MeanVariation, 0.0),
    ] {
        assert_eq!(Energy::preset(preset).jet(-0.5, 0.25).f, value, "{preset}");
    }
}

#[test]
fn homogeneous_presets_satisfy_eulers_identity() {
    for preset in Preset::ALL {
        let Some(degree) = preset.degree() else {
            continue;
        };
        let p = f64::from(degree);
        for [h, k] in POINTS {
            let jet = Energy::preset(preset).jet(h, k);
            let size = jet.f.abs() + (h * jet.h).abs() + (k * jet.k).abs();
            let first = h * jet.h + 2.0 * k * jet.k - p * jet.f;
            assert!(first.abs() <= 1e-14 * size, "{preset} {h} {k}");
            // The same for f_H, of degree p − 1, and f_K, of degree p − 2.
            let of_h = h * jet.hh + 2.0 * k * jet.hk - (p - 1.0) * jet.h;
            let of_k = h * jet.hk + 2.0 * k * jet.kk - (p - 2.0) * jet.k;
            let scale = (h * jet.hh).abs() + (k * jet.hk).abs() + jet.h.abs();
            assert!(of_h.abs() <= 1e-14 * scale, "{preset} {h} {k}");
            let scale = (h * jet.hk).abs() + (k * jet.kk).abs() + jet.k.abs();
            assert!(of_k.abs() <= 1e-14 * scale, "{preset} {h} {k}");
        }
    }
}

#[test]
fn parameters_are_kept_and_changed() {
    let params = BTreeMap::from([("a".to_owned(), 2.0), ("unused".to_owned(), 1.0)]);
    let energy = Energy::parse("a*H^2 ", &params).expect("valid");
    assert_eq!(
        (energy.text(), energy.to_string().as_str()),
        ("a*H^2", "a*H^2, a = 2")
    );
    assert_eq!(energy.params().keys().collect::<Vec<_>>(), ["a"]);
    let other = energy.with_param("a", 1.0).expect("a parameter of it");
    assert_eq!(other.as_preset(), Some(Preset::H2));
    assert_eq!(
        other.with_param("a", 2.0).expect("still one").jet(3.0, 0.0),
        energy.jet(3.0, 0.0)
    );
    let text = energy
        .with_param("b", 1.0)
        .expect_err("no such parameter")
        .to_string();
    assert!(text.contains("only a"), "{text}");
    assert!(Energy::preset(Preset::H2).with_param("H0", 1.0).is_err());
    for (name, value) in [
        ("H", 1.0),
        ("sin", 1.0),
        ("2a", 1.0),
        ("", 1.0),
        ("b", f64::NAN),
    ] {
        let params = BTreeMap::from([(name.to_owned(), value)]);
        assert!(
            matches!(
                Energy::parse("H", &params),
                Err(ExprError::Parameter { .. })
            ),
            "{name}"
        );
    }
}

#[test]
fn orders_are_recognised() {
    for (text, order) in [
        ("K", Order::Stationary),
        ("-3*k1*k2", Order::Stationary),
        ("0", Order::Stationary),
        ("1", Order::Second),
        ("H", Order::Second),
        ("k1+k2+K-a", Order::Second),
        ("abs(H)", Order::Second),
        ("H^2", Order::Fourth),
        ("H^2-k1*k2+exp(H)", Order::Fourth),
        ("H^7", Order::Fourth),
        ("gradH2", Order::Sixth),
        ("H^2+a*gradH2", Order::Sixth),
        ("1-gradH2", Order::Sixth),
        ("H^2+0*gradH2", Order::Fourth),
        ("gradH2+K-gradH2", Order::Stationary),
    ] {
        assert_eq!(parsed(text).order(), order, "{text}");
    }
}

/// `a` is 1.7.
#[test]
fn the_coefficient_of_the_gradient_is_split_off() {
    for (text, coefficient, rest) in [
        ("gradH2", 1.0, "0"),
        ("-gradH2", -1.0, "0"),
        ("a*gradH2", 1.7, "0"),
        ("H^2 + gradH2*a^2", 1.7 * 1.7, "H^2"),
        ("(2*(K^2 + gradH2/4) - 3)/2", 0.25, "K^2 - 1.5"),
        ("gradH2 + k1^4 + k2^4 + gradH2", 2.0, "k1^4+k2^4"),
        ("exp(H)-0.5*gradH2", -0.5, "exp(H)"),
        ("H^2", 0.0, "H^2"),
    ] {
        let (energy, rest) = (parsed(text), parsed(rest));
        assert!((energy.gradient() - coefficient).abs() < 1e-15, "{text}");
        assert_eq!(energy.jet(0.3, -0.7), rest.jet(0.3, -0.7), "{text}");
        let is_preset = text == "gradH2" || text == "H^2";
        assert_eq!(energy.as_preset().is_some(), is_preset, "{text}");
        let shifted = energy.shifted(0.3, 0.1);
        assert_eq!(shifted.gradient(), energy.gradient());
    }
    assert_eq!(parsed("gradH2").as_preset(), Some(Preset::MeanVariation));
}

#[test]
fn energies_go_between_threads() {
    fn send<T: Send + Sync + Clone>(_: &T) {}
    send(&Energy::preset(Preset::H2));
}
