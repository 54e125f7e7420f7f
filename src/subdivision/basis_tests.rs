use super::super::masks::EXACT_VALENCE;
use super::super::patch::ring_size;
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

/// Points spread over the triangle, some near corners and edges.
const POINTS: [[f64; 2]; 7] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [0.5, 0.1],
    [0.01, 0.02],
    [0.97, 0.02],
    [0.003, 0.99],
    [0.4, 0.6],
    [0.25, 0.0],
];

const TRIPLES: [[usize; 3]; 15] = [
    [6, 6, 6],
    [3, 3, 3],
    [3, 3, 5],
    [3, 4, 5],
    [4, 4, 4],
    [5, 6, 7],
    [7, 5, 5],
    [3, 30, 6],
    [12, 3, 9],
    [30, 30, 30],
    [6, 8, 3],
    [4, 17, 11],
    [100, 6, 7],
    [6, 65, 3],
    [1000, 70, 90],
];

/// Triples whose rings are control vertices throughout.
fn exact_triples() -> impl Iterator<Item = [usize; 3]> {
    TRIPLES
        .into_iter()
        .filter(|t| t.iter().all(|&n| n <= EXACT_VALENCE))
}

/// Order of each derivative.
const ORDER: [i32; DERIVATIVES] = [0, 1, 1, 2, 2, 2];

/// Growth of the rounding error of a derivative with each order: 2 for each subdivision step
/// towards a corner.
fn growth(v: f64, w: f64) -> f64 {
    (1.0 - v.max(w).max(1.0 - v - w)).recip()
}

/// The functions sum to 1, hence their derivatives to 0.
#[test]
fn partition_of_unity() {
    for triple in TRIPLES {
        for [v, w] in POINTS {
            let rows = basis_at(triple, v, w);
            let factor = growth(v, w);
            let means = triple.iter().filter(|&&n| n > EXACT_VALENCE).count();
            let [a, b, c] = triple.map(ring_size);
            assert_eq!(rows.len(), (a + b + c - 6).max(4) + means);
            for d in 0..DERIVATIVES {
                let sum: f64 = rows.iter().map(|r| r[d]).sum();
                let expected = if d == 0 { 1.0 } else { 0.0 };
                let tolerance = 1e-14 * factor.powi(ORDER[d]);
                assert!(
                    (sum - expected).abs() < tolerance,
                    "{triple:?} {d}: {sum:e}"
                );
            }
        }
    }
}

/// Rotating the triangle permutes corners and outer ring and changes parameters accordingly.
#[test]
fn turned_triangle() {
    for [a, b, c] in exact_triples() {
        for [v, w] in POINTS {
            let rows = basis_at([a, b, c], v, w);
            let factor = growth(v, w);
            let turned = basis_at([b, c, a], w, 1.0 - v - w);
            let outer = rows.len() - 3;
            for (i, row) in turned.iter().enumerate() {
                let same = if i < 3 {
                    (i + 1) % 3
                } else {
                    3 + (i - 3 + b - 3) % outer
                };
                let [n, p, q, pp, pq, qq] = *row;
                let expected = [n, -q, p - q, qq, qq - pq, pp - 2.0 * pq + qq];
                for d in 0..DERIVATIVES {
                    let error = (rows[same][d] - expected[d]).abs();
                    let tolerance = 1e-14 * factor.powi(ORDER[d]);
                    assert!(error < tolerance, "{:?} {v} {w} {d}: {error:e}", [a, b, c]);
                }
            }
        }
    }
}

/// Control vertices in a regular lattice, at the places of a linear parametrization.
#[test]
fn linear_precision_on_a_regular_patch() {
    let lattice = [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, -1.0],
        [2.0, -1.0],
        [2.0, 0.0],
        [1.0, 1.0],
        [0.0, 2.0],
        [-1.0, 2.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [0.0, -1.0],
    ];
    for [v, w] in POINTS {
        let rows = basis_at([6, 6, 6], v, w);
        let expected = [
            [v, w],
            [1.0, 0.0],
            [0.0, 1.0],
            [0.0, 0.0],
            [0.0, 0.0],
            [0.0, 0.0],
        ];
        for d in 0..DERIVATIVES {
            for k in 0..2 {
                let sum: f64 = rows.iter().zip(lattice).map(|(r, p)| r[d] * p[k]).sum();
                assert!((sum - expected[d][k]).abs() < 2e-14);
            }
        }
    }
}

#[test]
fn derivatives_match_central_differences() {
    let h = 1e-5;
    for triple in TRIPLES {
        for [v, w] in [[0.31, 0.22], [0.07, 0.11], [0.6, 0.33], [0.2, 0.7]] {
            let at = basis_at(triple, v, w);
            let (v0, v1) = (basis_at(triple, v - h, w), basis_at(triple, v + h, w));
            let (w0, w1) = (basis_at(triple, v, w - h), basis_at(triple, v, w + h));
            for i in 0..at.len() {
                // which quantity is whose derivative
                for (d, of, low, high) in [
                    (1, 0, &v0, &v1),
                    (2, 0, &w0, &w1),
                    (3, 1, &v0, &v1),
                    (4, 1, &w0, &w1),
                    (4, 2, &v0, &v1),
                    (5, 2, &w0, &w1),
                ] {
                    let slope = (high[i][of] - low[i][of]) / (2.0 * h);
                    let error = (slope - at[i][d]).abs();
                    // h^2 times a sixth of the third or fourth derivative, up to a few thousand
                    assert!(error < 2e-7, "{triple:?} {v} {w} {d}: {error:e}");
                }
            }
        }
    }
}

/// Towards a corner the values tend to the limit mask as the subdominant eigenvalue's powers.
#[test]
fn corner_values_are_the_limit_mask() {
    for triple in exact_triples() {
        let n = triple[0];
        let exact = basis_at(triple, 0.0, 0.0);
        let (centre, ring) = limit_mask(n);
        assert!((exact[0][0] - centre).abs() < 1e-15);
        assert!((exact[1][0] - ring).abs() < 1e-15);
        assert_eq!(exact[0][1].is_nan(), n != 6);
        let lambda = 0.375 + 0.25 * (std::f64::consts::TAU / n as f64).cos();
        let t = 0.5_f64.powi(40);
        for (near, exact) in basis_at(triple, t, 0.5 * t).iter().zip(&exact) {
            let error = (near[0] - exact[0]).abs();
            assert!(
                error < 4.0 * lambda.powi(40) + 1e-15,
                "{triple:?}: {error:e}"
            );
        }
    }
}

#[test]
fn tables_hold_the_basis_at_the_rule_points() {
    for rule in [Rule::Three, Rule::Twelve] {
        let table = BasisTable::new([5, 7, 6], rule);
        assert_eq!((table.n, table.points), (12, rule.points().len()));
        for (q, &[v, w]) in rule.points().iter().enumerate() {
            for (i, row) in basis_at([5, 7, 6], v, w).iter().enumerate() {
                for d in 0..DERIVATIVES {
                    assert_eq!(table.row(q, d)[i], row[d]);
                }
            }
        }
    }
}
