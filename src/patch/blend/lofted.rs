//! Starting surfaces with a shape of their own, for rims between which a film would close to a thread.

use super::bending::bending;
use super::curve::RimCurve;
use super::hub::hubs;
use super::loft::{loft_candidates, loft_surface};
use super::{Frame, check_apart, sizes};
use crate::mesh::self_intersections;
use crate::patch::data::{Patch, PatchOptions, Rim, RimGeometry};
use crate::patch::error::validate;
use crate::patch::fill::loose_angles;
use crate::patch::remesh::{refit, rim_valences};
use crate::patch::surface::Surface;

/// Surfaces between the rims of a gap that are swept from one of two to the other, or joined at a hub by
/// tubes that leave the rims smoothly; those that bend least first, none that passes through itself.
///
/// They are patches like that of [`super::blend`], and have already a shape that a flow can start from.
pub fn lofted_candidates(gap: &RimGeometry, options: &PatchOptions) -> Vec<Patch> {
    let usable = |rim: &Rim| validate(rim, options.density).is_ok();
    if gap.rims.len() < 2 || !gap.rims.iter().all(usable) || check_apart(gap).is_err() {
        return Vec::new();
    }
    let frame = Frame::around(gap.points());
    let rims: Vec<Rim> = gap.rims.iter().map(|r| frame.local(r)).collect();
    let curves: Vec<RimCurve> = rims.iter().map(RimCurve::new).collect();
    let size = sizes(&rims, *options);
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
        for sheet in sheets(&curves, side, &mean) {
            let patch = fitted(sheet, &rims, &size);
            let bends = bending(&patch.points, &patch.triangles);
            let is_clean = bends.is_finite()
                && self_intersections(&patch.points, &patch.triangles, None, 1).is_empty();
            if is_clean {
                found.push((bends, frame.world(patch, gap)));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, patch)| patch).collect()
}

/// The sides to which rims without a direction of their own may lead: that of the tubes among them, or
/// both.
fn sides(curves: &[RimCurve]) -> Vec<f64> {
    let sum: f64 = curves.iter().map(RimCurve::side).sum();
    if sum == 0.0 {
        vec![1.0, -1.0]
    } else {
        vec![sum.signum()]
    }
}

fn sheets(curves: &[RimCurve], side: f64, mean: &[f64]) -> Vec<Patch> {
    match curves {
        [a, b] => {
            let loft_candidates = loft_candidates(a, b, side);
            let sheets = loft_candidates
                .iter()
                .map(|loft| loft_surface([a, b], loft, [mean[0], mean[1]]));
            sheets.collect()
        }
        _ => hubs(curves, side, mean),
    }
}

/// With the triangles' sizes and valences of a patch.
fn fitted(found: Patch, rims: &[Rim], size: &[f64]) -> Patch {
    let middle = size.iter().sum::<f64>() / size.len() as f64;
    let mut size = size.to_vec();
    let count = size.len();
    size.resize(found.points.len(), middle);
    let mut surface = Surface::new(found.points, size, count, &found.triangles);
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    refit(&mut surface, &wanted);
    surface.compact()
}
