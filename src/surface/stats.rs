//! Curvature ranges of a limit surface, and well-posedness of an energy's flow on it.

use crate::energy::{Energy, WellPosed, WellPosedScan, scan_well_posedness};
use crate::mesh::DVec3;
use crate::subdivision::Elements;
use crate::surface::each_point;
use crate::warning::Warning;

/// The results of [`sample_surface`].
#[derive(Clone, Debug)]
pub struct SurfaceStats {
    /// `r² / f̂`, `f̂` the mean of `max(|η|, |f_HH|/r², |f_HK|/r³, |f_KK|/r⁴, 40 · 2|c|/r⁴)`.
    pub tau_ref: f64,
    /// Minimum and maximum mean curvature.
    pub mean: [f64; 2],
    /// Minimum and maximum Gaussian curvature.
    pub gauss: [f64; 2],
    /// Well-posedness of the flow at the samples.
    pub posed: WellPosedScan,
    /// The sample at which the flow is worst posed.
    pub worst_place: DVec3,
}

/// Maximum number of sampled elements where the energy may be ill-posed. Larger regions are sampled
/// evenly.
const SAMPLES: usize = 8192;
/// The same where only the natural time step is needed.
const FEW_SAMPLES: usize = 256;
/// Symbols smaller than this, relative to their scale, count as zero.
const TOLERANCE: f64 = 1e-9;

/// By how much faster than under `H²` the slowest mode of a clamped disc of radius 1 decays under
/// `|∇H|²`, rounded.
const SIXTH_ORDER: f64 = 40.0;

/// Samples the limit surface over `elements`. `radius` is the unit of length, the hole radius.
pub fn sample_surface(
    elements: &Elements,
    positions: &[DVec3],
    energy: &Energy,
    radius: f64,
) -> SurfaceStats {
    let count = elements.faces().len();
    let samples = if energy.is_uniformly_parabolic() {
        FEW_SAMPLES
    } else {
        SAMPLES
    };
    let stride = count.div_ceil(samples).max(1);
    let (mut area, mut weighted) = (0.0, 0.0);
    let mut mean = [f64::INFINITY, f64::NEG_INFINITY];
    let mut gauss = mean;
    let (mut samples, mut places) = (Vec::new(), Vec::new());
    let r = radius;
    for e in (0..count).step_by(stride) {
        each_point(elements, e, positions, |place, p| {
            let jet = energy.jet(p.mean, p.gauss);
            let eta = jet.f - jet.h * p.mean - jet.k * p.gauss;
            let size = eta
                .abs()
                .max(jet.hh.abs() / (r * r))
                .max(jet.hk.abs() / (r * r * r))
                .max(jet.kk.abs() / (r * r * r * r))
                .max(2.0 * SIXTH_ORDER * energy.gradient().abs() / (r * r * r * r));
            area += p.sqrt_g;
            weighted += p.sqrt_g * size;
            mean = [mean[0].min(p.mean), mean[1].max(p.mean)];
            gauss = [gauss[0].min(p.gauss), gauss[1].max(p.gauss)];
            samples.push([p.mean, p.gauss]);
            places.push(place);
        });
    }
    let posed = scan_well_posedness(energy, &samples, r, TOLERANCE);
    // an energy without scale (f = K) gives no natural time step: any τ is equally good
    let f_hat = weighted / area;
    let tau_ref = if f_hat.is_finite() && f_hat > 0.0 {
        r * r / f_hat
    } else {
        r * r * r * r
    };
    SurfaceStats {
        tau_ref,
        mean,
        gauss,
        worst_place: posed.worst.map_or(DVec3::ZERO, |w| places[w.index]),
        posed,
    }
}

impl SurfaceStats {
    /// A warning if the flow is not well posed, with a place (`centre` is added to it).
    ///
    /// Isolated degenerate points are common and harmless (flat points under `k1^4 + k2^4`). They
    /// are reported only if they exceed one sample in a thousand.
    pub fn warning(&self, centre: DVec3) -> Option<Warning> {
        let posed = &self.posed;
        let bad = posed.ill_posed + posed.undefined;
        if bad == 0 && 1000 * posed.degenerate <= posed.samples {
            return None;
        }
        let worst = posed.worst.filter(|w| w.class > WellPosed::Strict)?;
        Some(Warning::NotParabolic {
            class: worst.class,
            count: match worst.class {
                WellPosed::Undefined => posed.undefined,
                WellPosed::IllPosed => posed.ill_posed,
                _ => posed.degenerate,
            },
            samples: posed.samples,
            at: self.worst_place + centre,
            h: worst.h,
            k: worst.k,
            symbol: worst.symbol,
            direction: worst.b,
        })
    }
}
