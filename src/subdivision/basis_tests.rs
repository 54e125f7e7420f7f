use super::*;

#[derive(serde::Deserialize)]
struct Reference {
    cases: Vec<Case>,
}

#[derive(serde::Deserialize)]
#[allow(non_snake_case)] // the file's own names
struct Case {
    valences: [usize; 3],
    v: f64,
    w: f64,
    n: usize,
    N: Vec<f64>,
    N_v: Vec<f64>,
    N_w: Vec<f64>,
    N_vv: Vec<f64>,
    N_vw: Vec<f64>,
    N_ww: Vec<f64>,
}

/// The file's second derivatives next to an irregular corner carry rounding of their own, up to
/// 5.1e-12 against 40-digit arithmetic; see [`forty_digits`]. Everything else agrees to 1e-12.
#[test]
fn reference_values() {
    let file: Reference =
        serde_json::from_str(include_str!("../../tests/data/loop_basis.json")).expect("readable");
    assert_eq!(file.cases.len(), 28);
    for case in file.cases {
        let rows = basis_at(case.valences, case.v, case.w);
        assert_eq!(rows.len(), case.n);
        let expected = [
            &case.N, &case.N_v, &case.N_w, &case.N_vv, &case.N_vw, &case.N_ww,
        ];
        let deep = case.v == 0.02 && case.valences != [6, 6, 6];
        for (d, values) in expected.iter().enumerate() {
            let tolerance = if deep && d >= 3 { 5.2e-12 } else { 1e-12 };
            for (row, value) in rows.iter().zip(values.iter()) {
                let error = (row[d] - value).abs();
                assert!(error < tolerance, "{:?} {d}: {error:e}", case.valences);
            }
        }
    }
}

/// `N_ww` of (12, 5, 6) at (0.02, 0.03), four subdivision steps down, in 40-digit arithmetic.
#[test]
fn forty_digits() {
    let exact = [
        -3.146_169_772_729_947,
        -0.908_777_518_939_171,
        0.063_222_481_060_828_98,
        -0.547_277_518_939_171,
        0.0,
        0.048_5,
        0.001_499_999_999_999_999_8,
        0.028_499_999_999_999_998,
        -1.097_277_518_939_171,
        -1.379_277_518_939_171,
        -0.079_277_518_939_171_13,
        0.813_222_481_060_828_8,
        1.029_222_481_060_828_8,
        1.072_722_481_060_829,
        1.257_722_481_060_829,
        1.625_222_481_060_829,
        1.218_222_481_060_829,
    ];
    for (row, exact) in basis_at([12, 5, 6], 0.02, 0.03).iter().zip(exact) {
        let error: f64 = row[5] - exact;
        assert!(error.abs() < 3e-13, "{error:e}");
    }
}
