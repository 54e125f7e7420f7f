//! The splitting of `f_H`, `f_K` and `f` that makes the scheme linear in `x`, `h`, `k`.

use crate::energy::Jet2;

/// Coefficients at a point with `f_H = 2αH + 2βK + μ`, `f_K = 2γH + 2δK + ν` and
/// `f = 2ωH + 2ϖK + η`.
///
/// The splitting is not unique. This one is the first-order Taylor polynomial of `f_H`, `f_K` and
/// `f` about the current curvatures (`2ω = f_H`, `2ϖ = f_K`). It is valid for any smooth `f`. The
/// factors of `h = 2Hn` and `k = 2Kn` are implicit (new time); all other terms are explicit (old
/// time).
///
/// The residual-corrected variant doubles `δ`. The system has `k = □x` with the coefficients of `□`
/// at the old time, but these contain second derivatives of `x` themselves, so that `□δx` is half
/// of the change of `k`: with `2δ = f_KK` half of the stiffest term of `f = K²` is explicit, the
/// borderline of stability. (The plain scheme has it as the paper does: there the other half is in
/// the right-hand side, and a larger `δ` overshoots from rough starts.)
#[derive(Clone, Copy, Debug)]
pub struct Splitting {
    /// `½ f_HH`.
    pub alpha: f64,
    /// `½ f_HK`; equal to γ.
    pub beta: f64,
    /// `½ f_HK`; equal to β.
    pub gamma: f64,
    /// `½ f_KK`, or `f_KK` if doubled.
    pub delta: f64,
    /// `f_H − 2αH − 2βK`.
    pub mu: f64,
    /// `f_K − 2γH − 2δK`.
    pub nu: f64,
    /// `½ f_H`.
    pub omega: f64,
    /// `½ f_K`.
    pub varpi: f64,
    /// `f − f_H H − f_K K`.
    pub eta: f64,
}

impl Splitting {
    /// From the jet of `f` at mean curvature `mean` and Gaussian curvature `gauss`, with `δ` doubled
    /// or not.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "part of the element kernels, which are compiled once per instruction set"
    )]
    pub fn new(jet: &Jet2, mean: f64, gauss: f64, doubled: bool) -> Self {
        let half_hk = 0.5 * jet.hk;
        let delta = if doubled { jet.kk } else { 0.5 * jet.kk };
        Self {
            alpha: 0.5 * jet.hh,
            beta: half_hk,
            gamma: half_hk,
            delta,
            mu: jet.h - jet.hh * mean - jet.hk * gauss,
            nu: jet.k - jet.hk * mean - 2.0 * delta * gauss,
            omega: 0.5 * jet.h,
            varpi: 0.5 * jet.k,
            eta: jet.f - jet.h * mean - jet.k * gauss,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Energy;

    #[test]
    fn splitting_restores_f_and_its_derivatives() {
        for text in [
            "1",
            "H^2",
            "K",
            "H^2*K^2",
            "k1^4+k2^4",
            "(H-0.3)^2",
            "exp(H)*K",
        ] {
            let energy = Energy::parse(text, &std::collections::BTreeMap::new()).expect("energy");
            for (h, k, doubled) in [(0.7, 0.2, false), (-1.3, -0.4, true), (-1.0, 1.0, true)] {
                let jet = energy.jet(h, k);
                let s = Splitting::new(&jet, h, k, doubled);
                let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()));
                close(2.0 * s.alpha * h + 2.0 * s.beta * k + s.mu, jet.h);
                close(2.0 * s.gamma * h + 2.0 * s.delta * k + s.nu, jet.k);
                close(2.0 * s.omega * h + 2.0 * s.varpi * k + s.eta, jet.f);
            }
        }
    }
}
