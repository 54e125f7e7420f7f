//! A look over a surface: curvature ranges, the natural time of the hole, well-posedness.

use crate::mesh::DVec3;
use crate::solver::SolverError;
use crate::solver::energy::{Energy, WellPosed, well_posedness};
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
    /// Share of the sampled area where the flow is ill-posed.
    pub ill_posed: f64,
    /// Share of the sampled area where it is degenerate.
    pub degenerate: f64,
    /// Where it is ill-posed (or, if nowhere, degenerate) worst: face, position, H, K.
    pub worst: Option<(u32, DVec3, f64, f64)>,
}

/// Elements looked at; a larger region is sampled evenly.
const SAMPLES: usize = 8192;

/// Surveys the limit surface over `elements`.
pub fn survey(elements: &Elements, positions: &[DVec3], energy: &Energy, radius: f64) -> Survey {
    let count = elements.faces.len();
    let stride = count.div_ceil(SAMPLES).max(1);
    let (mut area, mut weighted) = (0.0, 0.0);
    let (mut ill, mut degenerate) = (0.0, 0.0);
    let mut mean = [f64::INFINITY, f64::NEG_INFINITY];
    let mut gauss = mean;
    let mut worst: Option<(WellPosed, u32, DVec3, f64, f64)> = None;
    let r = radius;
    for e in (0..count).step_by(stride) {
        let table = &elements.tables[elements.table_of[e] as usize];
        let vertices =
            &elements.vertices[elements.offset[e] as usize..elements.offset[e + 1] as usize];
        for point in 0..table.points {
            let at = |d: usize| {
                let row = table.row(point, d);
                vertices
                    .iter()
                    .zip(row)
                    .fold(DVec3::ZERO, |sum, (&v, &b)| sum + positions[v as usize] * b)
            };
            let p = PointGeometry::new(at(1), at(2), at(3), at(4), at(5));
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
            let posed = well_posedness(&jet, p.mean, p.gauss, r);
            match posed {
                WellPosed::IllPosed => ill += p.sqrt_g,
                WellPosed::Degenerate => degenerate += p.sqrt_g,
                WellPosed::Strict | WellPosed::Stationary => continue,
            }
            if worst.is_none_or(|w| w.0 == WellPosed::Degenerate && posed == WellPosed::IllPosed) {
                worst = Some((posed, elements.faces[e], at(0), p.mean, p.gauss));
            }
        }
    }
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
        ill_posed: ill / area,
        degenerate: degenerate / area,
        worst: worst.map(|(_, face, x, h, k)| (face, x, h, k)),
    }
}

impl Survey {
    /// A warning where the flow is not well posed. Degenerate points alone are common (flat
    /// points under `k1^4 + k2^4`) and only named when they are more than isolated.
    pub fn warning(&self, centre: DVec3) -> Option<String> {
        let (share, what) = if self.ill_posed > 0.0 {
            (self.ill_posed, "ill-posed (backward parabolic)")
        } else if self.degenerate > 1e-3 {
            (self.degenerate, "degenerate (not strictly parabolic)")
        } else {
            return None;
        };
        let (_, x, h, k) = self.worst?;
        let x = x + centre;
        Some(format!(
            "the flow of this energy is {what} on {:.1} % of the starting surface, for example at \
             ({:.4}, {:.4}, {:.4}) where H = {h:.4}, K = {k:.4}; expect wiggles or an early end there",
            (100.0 * share).max(0.1),
            x.x,
            x.y,
            x.z
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
