//! The first patch over several rims: a sphere with as many holes as there are rims.
//!
//! [`blend`] triangulates between the rims without new vertices, then refines and relaxes as for a
//! single hole. The triangulation is the constrained Delaunay triangulation of the rims as seen
//! from a point (`layout`), if there is a point from which they do not overlap; else the rims are cut
//! open along bridges into one polygon, which is triangulated with least weight (`bridges`).

mod bending;
mod bridges;
mod curve;
mod hub;
mod layout;
mod loft;
mod lofted;
mod spine;
#[cfg(test)]
mod tests;

use curve::RimCurve;

use super::data::{Patch, PatchOptions, Rim, RimGeometry};
use super::error::{PatchError, validate};
use super::fill::{fineness, loose_angles, rim_sizes};
use super::remesh::{area, refit, rim_valences, split_chords};
use super::surface::Surface;
use crate::mesh::DVec3;

pub use bending::bending;
pub use lofted::lofted_candidates;

/// The first surface that joins the rims of a gap: triangulated between them, refined to their
/// densities (graded from one rim to the other), flipped and evened out.
///
/// The result is a sphere with a hole for every rim: Euler characteristic 2 − n, the rims as
/// its only boundary, rim points unchanged and first. With one rim this is [`super::fill()`].
///
/// # Errors
/// What makes a rim unusable; rims that touch ([`PatchError::RimsTouch`]); rims whose faces look to
/// different sides ([`PatchError::InsideOut`]).
pub fn blend(gap: &RimGeometry, options: &PatchOptions) -> Result<Patch, PatchError> {
    if let [rim] = &gap.rims[..] {
        return super::fill(rim, options);
    }
    for rim in &gap.rims {
        validate(rim, options.density)?;
    }
    check_apart(gap)?;
    let frame = Frame::around(gap.points());
    let rims: Vec<Rim> = gap.rims.iter().map(|r| frame.local(r)).collect();
    let chords = gap.chords();
    let mut surface = if let Some(triangles) = layout::triangulate(&rims) {
        let points: Vec<DVec3> = rims.iter().flat_map(|r| r.points.clone()).collect();
        let count = points.len();
        Surface::new(points, vec![0.0; count], count, &triangles)
    } else {
        if !look_alike(&rims) {
            check_orientation(&gap.pieces, &rims)?;
        }
        bridges::surface(&rims, &chords)
    };
    surface.size = sizes(&rims, *options);
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    split_chords(&mut surface, &chords);
    split_double_edges(&mut surface);
    // a film would pinch off between distant rims
    refit(&mut surface, &wanted);
    Ok(frame.world(surface.compact(), gap))
}

/// Brings a patch whose shape has changed (by a warm start) back to the rims' density: splits,
/// collapses and flips, vertices moving along the surface only. `patch` is a result of [`blend`] over
/// the same gap, its positions those of the new shape. A patch that has grown so much that this would
/// take 16 times its vertices stays as it is.
pub fn reblend(gap: &RimGeometry, patch: &Patch, options: &PatchOptions) -> Patch {
    let frame = Frame::around(gap.points());
    let rims: Vec<Rim> = gap.rims.iter().map(|r| frame.local(r)).collect();
    let points: Vec<DVec3> = patch.points.iter().map(|&p| frame.to_local(p)).collect();
    let mut size = sizes(&rims, *options);
    let middle = size.iter().sum::<f64>() / size.len() as f64;
    size.resize(points.len(), middle);
    let most = MOST_GROWTH * points.len() as f64;
    let mut surface = Surface::new(points, size, gap.vertex_count(), &patch.triangles);
    // equilateral triangles have √3/4 of their squared edge as area, and two come on a vertex
    let needed = area(&surface) / (0.75f64.sqrt() * middle * middle);
    if needed.is_nan() || needed >= most {
        return patch.clone();
    }
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    refit(&mut surface, &wanted);
    frame.world(surface.compact(), gap)
}

/// How many times its vertices a patch may get by [`reblend`].
const MOST_GROWTH: f64 = 16.0;

/// Wanted edge lengths at all rim vertices.
fn sizes(rims: &[Rim], options: PatchOptions) -> Vec<f64> {
    let count = rims.iter().map(|r| r.points.len()).sum();
    rims.iter()
        .flat_map(|r| rim_sizes(&r.points, options.density * fineness(count)))
        .collect()
}

/// Coordinates near the origin at unit scale: squared areas of tiny or huge meshes stay in range.
struct Frame {
    centre: DVec3,
    radius: f64,
}

impl Frame {
    fn around(points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let count = points.clone().count();
        let centre = points.clone().sum::<DVec3>() / count as f64;
        let radius = points.map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self { centre, radius }
    }

    fn to_local(&self, p: DVec3) -> DVec3 {
        (p - self.centre) / self.radius
    }

    fn local(&self, rim: &Rim) -> Rim {
        Rim {
            points: rim.points.iter().map(|&p| self.to_local(p)).collect(),
            opposite: rim.opposite.iter().map(|&p| self.to_local(p)).collect(),
            forbidden: rim.forbidden.clone(),
        }
    }

    /// The patch in the mesh's coordinates, rim points bit-identical.
    fn world(&self, mut patch: Patch, gap: &RimGeometry) -> Patch {
        for p in &mut patch.points {
            *p = *p * self.radius + self.centre;
        }
        for (p, rim) in patch.points.iter_mut().zip(gap.points()) {
            *p = rim;
        }
        patch
    }
}

/// No two rims may have a vertex at the same place.
fn check_apart(gap: &RimGeometry) -> Result<(), PatchError> {
    let mut all: Vec<([u64; 3], usize, usize)> = Vec::with_capacity(gap.vertex_count());
    for (r, rim) in gap.rims.iter().enumerate() {
        let keys = rim.points.iter().enumerate();
        // adding 0.0 turns -0.0 into 0.0
        all.extend(keys.map(|(i, &p)| ((p + DVec3::ZERO).to_array().map(f64::to_bits), r, i)));
    }
    all.sort_unstable();
    match all
        .windows(2)
        .find(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1)
    {
        Some(pair) => Err(PatchError::RimsTouch {
            rims: [pair[0].1, pair[1].1],
            index: pair[0].2,
        }),
        None => Ok(()),
    }
}

/// Whether all rims are mouths of tubes whose faces look outwards, or all of tubes whose faces look inwards.
fn look_alike(rims: &[Rim]) -> bool {
    let side = |rim: &Rim| RimCurve::new(rim).side();
    let first = side(&rims[0]);
    first != 0.0 && rims.iter().all(|rim| side(rim) == first)
}

/// Things of which every combination is turned over; of more, one at a time.
const COMBINED: u32 = 6;

/// Whether rims that are seen from nowhere would be if some of them were turned over: then they run
/// around the gap in directions that fit no orientable surface without passing through itself.
fn check_orientation(pieces: &[u32], rims: &[Rim]) -> Result<(), PatchError> {
    let mut names = pieces.to_vec();
    names.sort_unstable();
    names.dedup();
    let piece_of = |k: usize| names.binary_search(&pieces[k]).unwrap_or(0);
    if let Some(rim) = mistaken(rims, names.len() as u32, piece_of) {
        return Err(PatchError::InsideOut { rim });
    }
    match mistaken(rims, rims.len() as u32, |k| k) {
        Some(rim) => Err(PatchError::OneSided { rim }),
        None => Ok(()),
    }
}

/// The first rim that has to be turned over so that all are seen from somewhere, if that helps; rims of
/// one class (of `count`) are turned over together, those of the first class not at all.
fn mistaken(rims: &[Rim], count: u32, class: impl Fn(usize) -> usize) -> Option<usize> {
    let free = count - 1;
    let choices: Vec<u32> = if free < COMBINED {
        (1..1 << free).collect()
    } else {
        (0..free.min(31)).map(|k| 1 << k).collect()
    };
    choices.into_iter().find_map(|choice| {
        let is_turned = |k: usize| class(k) > 0 && choice >> (class(k) - 1) & 1 == 1;
        let mut candidate: Vec<Rim> = rims.to_vec();
        for (k, rim) in candidate.iter_mut().enumerate() {
            if is_turned(k) {
                rim.points.reverse();
            }
        }
        layout::triangulate(&candidate)?;
        (0..rims.len()).find(|&k| is_turned(k))
    })
}

/// Splits edges that join the same two vertices as another one, until there are none: around a gap
/// an edge may run on either side of a bridge.
fn split_double_edges(s: &mut Surface) {
    loop {
        let mut edges: Vec<([u32; 2], u32)> = (0..s.corner.len() as u32)
            .filter(|&h| s.twin(h) == super::surface::NONE || h < s.twin(h))
            .map(|h| {
                let (a, b) = (s.from(h), s.to(h));
                ([a.min(b), a.max(b)], h)
            })
            .collect();
        edges.sort_unstable();
        let mut any = false;
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            if same.len() == 1 && same[0].0[0] != same[0].0[1] {
                continue;
            }
            for &(_, h) in same {
                if s.twin(h) != super::surface::NONE {
                    let middle = s.point(s.from(h)).midpoint(s.point(s.to(h)));
                    s.split(h, middle);
                    any = true;
                }
            }
        }
        if !any {
            return;
        }
    }
}
