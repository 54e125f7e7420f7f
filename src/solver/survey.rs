//! A look over a surface: curvature ranges, the natural time of the hole, well-posedness.

use crate::energy::{Energy, WellPosedScan, scan_well_posedness};
use crate::mesh::DVec3;
use crate::solver::SolverError;
use crate::solver::forms::PointGeometry;
use crate::subdivision::Elements;

/// What a survey found.
#[derive(Clone, Debug)]
pub struct Survey {
    /// `r² / f̂`, `f̂` the mean of `max(|η|, |f_HH|/r², |f_HK|/r³, |f_KK|/r⁴)`.
    pub tau_ref: f64,
    /// Least and greatest mean curvature.
    pub mean: [f64; 2],
    /// Least and greatest Gaussian curvature.
    pub gauss: [f64; 2],
    /// How the flow is posed at the sampled points.
    pub posed: WellPosedScan,
    /// Where it is posed worst.
    pub worst_place: DVec3,
}

/// Symbols smaller than this, relative to their scale, count as zero.
const TOLERANCE: f64 = 1e-9;
/// Elements looked at where the energy may be ill-posed somewhere; a larger region is sampled
/// evenly.
const SAMPLES: usize = 8192;
/// Elements looked at where only the natural time is in question.
const FEW_SAMPLES: usize = 256;

/// Surveys the limit surface over `elements`.
pub fn survey(elements: &Elements, positions: &[DVec3], energy: &Energy, radius: f64) -> Survey {
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
                .max(jet.kk.abs() / (r * r * r * r));
            area += p.sqrt_g;
            weighted += p.sqrt_g * size;
            mean = [mean[0].min(p.mean), mean[1].max(p.mean)];
            gauss = [gauss[0].min(p.gauss), gauss[1].max(p.gauss)];
            samples.push([p.mean, p.gauss]);
            places.push(place);
        });
    }
    let posed = scan_well_posedness(energy, &samples, r, TOLERANCE);
    // an energy without scale (f = K) leaves any τ as good as another
    let f_hat = weighted / area;
    let tau_ref = if f_hat.is_finite() && f_hat > 0.0 {
        r * r / f_hat
    } else {
        r * r * r * r
    };
    Survey {
        tau_ref,
        mean,
        gauss,
        worst_place: posed.worst.map_or(DVec3::ZERO, |w| places[w.index]),
        posed,
    }
}

/// Mean curvature of the limit surface on a face: the average over the points of its table.
pub fn mean_curvature(elements: &Elements, element: usize, positions: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    each_point(elements, element, positions, |_, p| sum += p.mean);
    sum / elements.table(element).points as f64
}

/// Calls `look` with the place and the geometry at every quadrature point of an element.
pub fn each_point(
    elements: &Elements,
    element: usize,
    positions: &[DVec3],
    mut look: impl FnMut(DVec3, &PointGeometry),
) {
    for point in 0..elements.table(element).points {
        let (at, geometry) = surface_point(elements, element, point, positions);
        look(at, &geometry);
    }
}

/// One point of an element's table on the limit surface, and the geometry there.
#[inline]
pub fn surface_point(
    elements: &Elements,
    element: usize,
    point: usize,
    positions: &[DVec3],
) -> (DVec3, PointGeometry) {
    let table = elements.table(element);
    let vertices = elements.vertices_of(element);
    let at = |d: usize| {
        let row = table.row(point, d);
        vertices
            .iter()
            .zip(row)
            .fold(DVec3::ZERO, |sum, (&v, &b)| sum + positions[v as usize] * b)
    };
    let geometry = PointGeometry::new(at(1), at(2), at(3), at(4), at(5));
    (at(0), geometry)
}

impl Survey {
    /// A warning where the flow is not well posed, with a place (`centre` is added to it).
    ///
    /// Isolated degenerate points are common and harmless (flat points under `k1^4 + k2^4`); they
    /// are named only above one sample in a thousand.
    pub fn warning(&self, centre: DVec3) -> Option<String> {
        let bad = self.posed.ill_posed + self.posed.undefined;
        if bad == 0 && 1000 * self.posed.degenerate <= self.posed.samples {
            return None;
        }
        let at = self.worst_place + centre;
        let text = self.posed.warning()?;
        Some(format!(
            "{text}, near ({:.6}, {:.6}, {:.6})",
            at.x, at.y, at.z
        ))
    }

    /// The error for an energy that is not finite here.
    pub fn not_finite(&self) -> SolverError {
        SolverError::EnergyNotFinite {
            h_min: self.mean[0],
            h_max: self.mean[1],
            k_min: self.gauss[0],
            k_max: self.gauss[1],
        }
    }
}
