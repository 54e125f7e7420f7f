//! Is the flow of an energy parabolic? formulation.md section 8.
//!
//! The linearised flow has the symbol `q(b) = ¼ f_HH + f_HK b + f_KK b²` in the directions whose
//! normal curvature, rotated by 90°, is `b`, so `b` runs over the interval between κ2 and κ1:
//! the symbol of `½Δ` is `−½|ξ|²`, that of `□` is `−b|ξ|²`. Where `f` has no second derivatives
//! the flow is of second order with symbol `η + f_H b`, `η = f − f_H H − f_K K`. A term `c |∇H|²` makes
//! it of sixth order with symbol `½ c`, in all directions.

use super::{Energy, Jet2, Order, Preset};

/// The type of the flow at a point. The variants are ordered from harmless to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WellPosed {
    /// The energy is a multiple of `K`: nothing moves.
    Stationary,
    /// Strictly parabolic.
    Strict,
    /// The symbol touches zero in some direction: no smoothing there.
    Degenerate,
    /// The symbol is negative in some direction: short waves grow.
    IllPosed,
    /// The energy has no finite second derivatives here.
    Undefined,
}

/// The minimum of the symbol over all directions at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Symbol {
    min: f64,
    /// The normal curvature `b` of the minimum.
    b: f64,
    /// Sum of the magnitudes of its terms at the larger principal curvature.
    scale: f64,
}

impl Energy {
    /// Whether the flow is strictly parabolic on every surface, so that no scan is needed.
    pub fn is_uniformly_parabolic(&self) -> bool {
        matches!(
            self.as_preset(),
            Some(
                Preset::One
                    | Preset::H2
                    | Preset::H2PlusK2
                    | Preset::HMinusH0Squared
                    | Preset::K1SqPlusK2Sq
                    | Preset::K1MinusK2Squared
                    | Preset::CurvatureNorm
                    | Preset::MeanVariation
            )
        )
    }

    /// The class of the flow at `(h, k)`. `tol` is relative to the sum of the magnitudes of the
    /// symbol's terms; 1e-12 is above roundoff.
    #[cfg(test)]
    pub(super) fn well_posedness(&self, h: f64, k: f64, tol: f64) -> WellPosed {
        classify(self, h, k, tol, 0.0).0
    }

    /// The size of the symbol on spheres and saddles of radius `length`.
    fn symbol_scale(&self, length: f64) -> f64 {
        let c = length.recip();
        [[c, c * c], [-c, c * c], [0.0, -c * c]]
            .into_iter()
            .map(|[h, k]| symbol(self, &self.jet(h, k), h, k).scale)
            .filter(|scale| scale.is_finite())
            .fold(0.0, f64::max)
    }
}

/// The worst sample of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPoint {
    /// Index of the sample.
    pub index: usize,
    /// Its class.
    pub class: WellPosed,
    /// Mean curvature there.
    pub h: f64,
    /// Gauss curvature there.
    pub k: f64,
    /// The minimum of the symbol over all directions.
    pub symbol: f64,
    /// The normal curvature `b` of the minimum.
    pub b: f64,
}

/// The number of samples of each class.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WellPosedScan {
    /// Number of samples.
    pub samples: usize,
    /// [`WellPosed::Stationary`] samples.
    pub stationary: usize,
    /// [`WellPosed::Strict`] samples.
    pub strict: usize,
    /// [`WellPosed::Degenerate`] samples.
    pub degenerate: usize,
    /// [`WellPosed::IllPosed`] samples.
    pub ill_posed: usize,
    /// [`WellPosed::Undefined`] samples.
    pub undefined: usize,
    /// The worst sample: worst class, then smallest symbol, then lowest index.
    pub worst: Option<WorstPoint>,
}

/// Classifies the flow of `energy` at every `[H, K]` of `samples`.
///
/// `length` is the size of the region, such as the hole's radius. A symbol counts as zero below
/// `tol` times its size on a sphere of that radius. κ1⁴+κ2⁴ is therefore degenerate on surfaces
/// that are flat up to roundoff. Pass infinity to compare with the sample's own terms only.
pub fn scan_well_posedness(
    energy: &Energy,
    samples: &[[f64; 2]],
    length: f64,
    tol: f64,
) -> WellPosedScan {
    let floor = energy.symbol_scale(length);
    let mut scan = WellPosedScan {
        samples: samples.len(),
        ..WellPosedScan::default()
    };
    for (index, &[h, k]) in samples.iter().enumerate() {
        let (class, symbol) = classify(energy, h, k, tol, floor);
        *match class {
            WellPosed::Stationary => &mut scan.stationary,
            WellPosed::Strict => &mut scan.strict,
            WellPosed::Degenerate => &mut scan.degenerate,
            WellPosed::IllPosed => &mut scan.ill_posed,
            WellPosed::Undefined => &mut scan.undefined,
        } += 1;
        let worse = scan.worst.is_none_or(|worst| {
            class > worst.class || (class == worst.class && symbol.min < worst.symbol)
        });
        if worse {
            scan.worst = Some(WorstPoint {
                index,
                class,
                h,
                k,
                symbol: symbol.min,
                b: symbol.b,
            });
        }
    }
    scan
}

fn classify(energy: &Energy, h: f64, k: f64, tol: f64, floor: f64) -> (WellPosed, Symbol) {
    let jet = energy.jet(h, k);
    let symbol = symbol(energy, &jet, h, k);
    let bound = tol * symbol.scale.max(floor);
    let class = if !(jet.is_finite() && symbol.min.is_finite()) {
        WellPosed::Undefined
    } else if energy.order() == Order::Stationary {
        WellPosed::Stationary
    } else if symbol.min > bound {
        WellPosed::Strict
    } else if symbol.min >= -bound {
        WellPosed::Degenerate
    } else {
        WellPosed::IllPosed
    };
    (class, symbol)
}

fn symbol(energy: &Energy, jet: &Jet2, h: f64, k: f64) -> Symbol {
    if energy.order() == Order::Sixth {
        let min = 0.5 * energy.gradient();
        return Symbol {
            min,
            b: h,
            scale: min.abs(),
        };
    }
    let [low, high] = principal_curvatures(h, k);
    let largest = low.abs().max(high.abs());
    // c0 + c1 b + c2 b²
    let (c0, c1, c2, c0_scale) = if energy.order() == Order::Fourth {
        (0.25 * jet.hh, jet.hk, jet.kk, 0.25 * jet.hh.abs())
    } else {
        let eta = jet.f - jet.h * h - jet.k * k;
        (
            eta,
            jet.h,
            0.0,
            jet.f.abs() + (jet.h * h).abs() + (jet.k * k).abs(),
        )
    };
    let q = |b: f64| c0 + b * (c1 + b * c2);
    let (mut min, mut b) = (q(low), low);
    if q(high) < min {
        (min, b) = (q(high), high);
    }
    let vertex = -0.5 * c1 / c2;
    if c2 > 0.0 && low < vertex && vertex < high {
        (min, b) = (q(vertex), vertex);
    }
    Symbol {
        min,
        b,
        scale: c0_scale + largest * (c1.abs() + largest * c2.abs()),
    }
}

/// `[κ2, κ1]`, both `H` where `H² ≤ K`; the smaller in magnitude without cancellation.
fn principal_curvatures(h: f64, k: f64) -> [f64; 2] {
    let t = h * h - k;
    if t <= 0.0 {
        return [h, h];
    }
    let large = h + t.sqrt().copysign(h);
    let small = k / large;
    [large.min(small), large.max(small)]
}
