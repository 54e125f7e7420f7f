//! Classification of the flow.

use super::*;

#[test]
fn well_posedness_is_that_of_section_8() {
    use WellPosed::{Degenerate, IllPosed, Stationary, Strict, Undefined};
    let (sphere, saddle, flat) = ([-1.0, 1.0], [0.2, -1.0], [0.0, 0.0]);
    for (text, at, class) in [
        ("H^2", flat, Strict),
        ("H^2+K^2", saddle, Strict),
        ("k1^4+k2^4", flat, Degenerate),
        ("k1^4+k2^4", sphere, Strict),
        ("K^2", sphere, Strict),
        // 2b² vanishes where b does, between the principal curvatures of a saddle.
        ("K^2", saddle, Degenerate),
        ("K^2", [0.5, 0.0], Degenerate),
        ("H^2*K^2", [1.0, -0.1], IllPosed),
        ("-H^2", flat, IllPosed),
        ("1", saddle, Strict),
        ("-1", saddle, IllPosed),
        ("K", saddle, Stationary),
        ("0", saddle, Stationary),
        // Symbol f_H b = b: the sign of the curvature, hence of the orientation.
        ("H", [1.0, 0.5], Strict),
        ("H", sphere, IllPosed),
        ("H", saddle, IllPosed),
        ("H^4+K", flat, Degenerate),
        ("sqrt(H)", sphere, Undefined),
        // of sixth order, whatever the rest
        ("gradH2", saddle, Strict),
        ("-H^2+1e-3*gradH2", flat, Strict),
        ("H^2-1e-3*gradH2", flat, IllPosed),
        ("H^2-0*gradH2", flat, Strict),
        ("sqrt(H)+gradH2", sphere, Undefined),
    ] {
        let found = parsed(text).well_posedness(at[0], at[1], 1e-12);
        assert_eq!(found, class, "{text} {at:?}");
    }
}

/// The smallest symbol by brute force over directions: the shape operator diag(κ1, κ2) has
/// ½Δ → ½|ξ|², □ → κ2 ξ1² + κ1 ξ2².
#[test]
fn the_symbol_is_minimal_over_directions() {
    let energy = parsed("H^2*K^2 + a*H^3*K + 0.5*K^3");
    for [h, k] in [[1.0_f64, -0.1], [0.4, -1.2], [-0.7, 0.3], [0.1, -3.0]] {
        let s = (h * h - k).sqrt();
        let jet = energy.jet(h, k);
        let brute = (0..=20_000)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * 1e-4_f64).sin_cos();
                let b = (h - s) * cos * cos + (h + s) * sin * sin;
                0.25 * jet.hh + jet.hk * b + jet.kk * b * b
            })
            .fold(f64::INFINITY, f64::min);
        let scan = scan_well_posedness(&energy, &[[h, k]], f64::INFINITY, 1e-12);
        let found = scan.worst.expect("one sample").symbol;
        assert!(
            (found - brute).abs() < 1e-6 * (1.0 + brute.abs()),
            "{h} {k}: {found} {brute}"
        );
    }
}

#[test]
fn scans_count_and_point_at_the_worst() {
    let samples = [[-1.0, 1.0], [1e-17, 0.0], [0.5, 0.2]];
    let quartic = Energy::preset(Preset::K1P4PlusK2P4);
    let scan = scan_well_posedness(&quartic, &samples, 1.0, 1e-9);
    assert_eq!((scan.samples, scan.strict, scan.degenerate), (3, 2, 1));
    assert_eq!(scan.worst.map(|worst| worst.index), Some(1));
    let class = |scan: &WellPosedScan| scan.worst.map(|worst| worst.class);
    assert_eq!(class(&scan), Some(WellPosed::Degenerate));
    let far = scan_well_posedness(&quartic, &samples, f64::INFINITY, 1e-9);
    assert_eq!(far.strict + far.degenerate, 3);
    let willmore = scan_well_posedness(&Energy::preset(Preset::H2), &samples, 1.0, 1e-9);
    assert_eq!(
        (willmore.strict, class(&willmore)),
        (3, Some(WellPosed::Strict))
    );
    let bad = scan_well_posedness(&parsed("log(H)"), &samples, 1.0, 1e-9);
    assert_eq!((bad.undefined, bad.ill_posed), (1, 2));
    assert_eq!(
        scan_well_posedness(&quartic, &[], 1.0, 1e-9),
        WellPosedScan::default()
    );
}
