//! Lofted starting surfaces, for rims between which a membrane would close to a thread.

use super::bending::bending;
use super::curve::RimCurve;
use super::hub::hubs;
use super::loft::{loft_candidates, loft_surface};
use super::{check_apart, refitted, sizes};
use crate::mesh::self_intersections;
use crate::patch::data::{Patch, PatchOptions, Rim, RimGeometry};
use crate::patch::error::validate;
use crate::patch::frame::Frame;
use crate::patch::grading::set_grading;
use crate::patch::surface::Surface;

/// Surfaces that leave the rims smoothly: lofted from one rim to the other (two rims), or joined at
/// a hub (three or more). They are sorted by their bending, and none intersects itself.
///
/// They are patches like that of [`super::blend`], with a shape from which a flow can start.
pub fn lofted_candidates(geometry: &RimGeometry, options: PatchOptions) -> Vec<Patch> {
    let usable = |rim: &Rim| validate(rim, options.density).is_ok();
    if geometry.rims.len() < 2
        || !geometry.rims.iter().all(usable)
        || check_apart(geometry).is_err()
    {
        return Vec::new();
    }
    let frame = Frame::around(geometry.points());
    let rims: Vec<Rim> = geometry.rims.iter().map(|r| frame.local(r)).collect();
    let curves: Vec<RimCurve> = rims.iter().map(RimCurve::new).collect();
    let size = sizes(&rims, options);
    let mut first = 0;
    let mean: Vec<f64> = rims
        .iter()
        .map(|rim| {
            let own = &size[first..first + rim.points.len()];
            first += rim.points.len();
            own.iter().sum::<f64>() / own.len() as f64
        })
        .collect();
    let mut found: Vec<(f64, Patch)> = Vec::new();
    for side in sides(&curves) {
        for surface in surfaces(&curves, side, &mean) {
            let patch = fitted(surface, &rims, &size, options.density);
            let bending = bending(&patch.points, &patch.triangles);
            let is_clean = bending.is_finite()
                && self_intersections(&patch.points, &patch.triangles, None, 1).is_empty();
            if is_clean {
                found.push((bending, frame.world(patch, geometry.points())));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, patch)| patch).collect()
}

/// The sides to which rims that are no tubes may lead: that of the tubes among the rims, or both.
fn sides(curves: &[RimCurve]) -> Vec<f64> {
    let sum: f64 = curves.iter().map(RimCurve::side).sum();
    if sum == 0.0 {
        vec![1.0, -1.0]
    } else {
        vec![sum.signum()]
    }
}

fn surfaces(curves: &[RimCurve], side: f64, mean: &[f64]) -> Vec<Patch> {
    match curves {
        [a, b] => {
            let lofts = loft_candidates(a, b, side);
            let surfaces = lofts
                .iter()
                .map(|loft| loft_surface([a, b], loft, [mean[0], mean[1]]));
            surfaces.collect()
        }
        _ => hubs(curves, side, mean),
    }
}

/// Remeshes a surface to the sizes and valences of a patch of this density.
fn fitted(found: Patch, rims: &[Rim], size: &[f64], density: f64) -> Patch {
    let middle = size.iter().sum::<f64>() / size.len() as f64;
    let mut size = size.to_vec();
    size.resize(found.points.len(), middle);
    let mut surface = Surface::new(found.points, size, found.rim, &found.triangles);
    set_grading(&mut surface, density);
    refitted(surface, rims)
}
