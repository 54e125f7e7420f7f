//! Starting surfaces with a shape of their own, for rims between which a film would close to a thread.

use super::bending::bending;
use super::curve::RimCurve;
use super::hub::hubs;
use super::loft::{Sheet, best_way, sheet};
use super::{Frame, Gap, check_apart, compacted, sizes};
use crate::mesh::self_intersections;
use crate::patch::fill::{loose_angles, validate};
use crate::patch::remesh::{refit, rim_valences};
use crate::patch::surface::Surface;
use crate::patch::{PatchMesh, PatchOptions, Rim};

/// The surface between the rims of a gap that is swept from one of two to the other, or joined at a hub
/// by tubes that leave the rims smoothly: the one that bends least of those that do not pass through
/// themselves. `None` if there is none among those tried.
///
/// The patch is like that of [`super::blend`], and has already the shape a flow can start from.
pub fn formed(gap: &Gap, options: &PatchOptions) -> Option<PatchMesh> {
    let usable = |rim: &Rim| validate(rim, options.density).is_ok();
    if gap.rims.len() < 2 || !gap.rims.iter().all(usable) || check_apart(gap).is_err() {
        return None;
    }
    let frame = Frame::around(gap.rims.iter().flat_map(|r| &r.points));
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
    let mut best: Option<(f64, PatchMesh)> = None;
    for side in sides(&curves) {
        for found in sheets(&curves, side, &mean) {
            let patch = fitted(found, &rims, &size);
            let bends = bending(&patch.points, &patch.triangles);
            if best.as_ref().is_none_or(|b| bends < b.0)
                && bends.is_finite()
                && self_intersections(&patch.points, &patch.triangles, None, 1).is_empty()
            {
                best = Some((bends, patch));
            }
        }
    }
    best.map(|(_, patch)| frame.world(patch, gap))
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

fn sheets(curves: &[RimCurve], side: f64, mean: &[f64]) -> Vec<Sheet> {
    match curves {
        [a, b] => {
            let way = best_way(a, b, side);
            way.iter()
                .map(|way| sheet([a, b], way, [mean[0], mean[1]]))
                .collect()
        }
        _ => hubs(curves, side, mean),
    }
}

/// With the triangles' sizes and valences of a patch.
fn fitted(found: Sheet, rims: &[Rim], size: &[f64]) -> PatchMesh {
    let middle = size.iter().sum::<f64>() / size.len() as f64;
    let mut size = size.to_vec();
    let count = size.len();
    size.resize(found.points.len(), middle);
    let mut surface = Surface::new(found.points, size, count, &found.triangles);
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    refit(&mut surface, &wanted);
    compacted(surface)
}
