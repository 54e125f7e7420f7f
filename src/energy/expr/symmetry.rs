//! Tests `f(κ1, κ2) = f(κ2, κ1)` at sample points over nine decades of curvature.

use super::error::ExprError;
use super::program::Program;
use super::scalar::ScalarAlgebra;

/// Pairs of every sign combination, with ratios near and far from ±1, scaled by 1e-4 to 1e4.
const PAIRS: [[f64; 2]; 9] = [
    [1.0, 2.0],
    [0.7, -0.3],
    [-0.21, 0.86],
    [-2.3, -0.6],
    [1.31, 1.3],
    [-0.97, -1.01],
    [3.7, 0.0],
    [-1.9, 0.0],
    [0.113, 5.9],
];

/// Relative to the magnitude from which the roundoff comes, which is a few 1e-16 per operation.
const TOLERANCE: f64 = 1e-11;

/// Rejects an expression that is not symmetric, with a counterexample, or that is finite nowhere.
pub fn check_symmetry(text: &str, program: &Program) -> Result<(), ExprError> {
    let mut finite = false;
    // From unit curvature outwards, so that the counterexample shown is simple if possible.
    for scale in [1.0, 10.0, 0.1, 100.0, 0.01, 1e3, 1e-3, 1e4, 1e-4] {
        for [x, y] in PAIRS.map(|pair| pair.map(|k| k * scale)) {
            let there = program.eval(&ScalarAlgebra { k1: x, k2: y });
            let back = program.eval(&ScalarAlgebra { k1: y, k2: x });
            let (f, f_swapped) = (there.value, back.value);
            finite |= f.is_finite();
            let bound = TOLERANCE * there.magnitude.max(back.magnitude);
            let equal = if f.is_finite() && f_swapped.is_finite() {
                (f - f_swapped).abs() <= bound || !bound.is_finite()
            } else {
                f.is_finite() == f_swapped.is_finite()
            };
            if !equal {
                let text = text.to_owned();
                return Err(ExprError::NotSymmetric {
                    text,
                    k1: x,
                    k2: y,
                    f,
                    f_swapped,
                });
            }
        }
    }
    if finite {
        Ok(())
    } else {
        Err(ExprError::NowhereFinite {
            text: text.to_owned(),
        })
    }
}

/// The sample pairs as `(H, K)`.
pub fn sample_curvatures() -> impl Iterator<Item = [f64; 2]> {
    [1.0, 0.1, 10.0, 1e-3, 1e3]
        .into_iter()
        .flat_map(|scale| PAIRS.map(|[x, y]| [0.5 * (x + y) * scale, x * y * scale * scale]))
}
