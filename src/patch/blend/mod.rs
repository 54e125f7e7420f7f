//! The first patch over several rims: a sphere with as many holes as there are rims.
//!
//! [`blend`] triangulates between the rims without new vertices, then refines and relaxes as for a
//! single hole. If there is a point from which the rims do not overlap, the triangulation is the
//! constrained Delaunay triangulation of the rims as seen from that point (`layout`). Otherwise the
//! rims are cut open along bridges into one polygon, which gets the triangulation of minimum weight
//! (`bridges`).
//!
//! [`lofted_candidates`] makes other surfaces for rims that are far apart: lofted from rim to rim
//! (`loft`), or from all rims to a hub (`hub`).

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
use super::fill::{loose_angles, rim_sizes};
use super::frame::Frame;
use super::grading::{expected_vertices, require_memory, set_grading};
use super::remesh::{refit, rim_valences, split_chords};
use super::strip::strip;
use super::surface::Surface;
use crate::mesh::DVec3;

pub use bending::bending;
pub use lofted::lofted_candidates;

/// The first surface that joins the rims: triangulated between them, refined to their densities
/// (graded from one rim to the other), flipped and relaxed. Two rims that face each other less than an
/// edge apart are joined by triangles without new vertices.
///
/// The result is a sphere with a hole for every rim: Euler characteristic 2 − n, the rims as
/// its only boundary, rim points unchanged and first. With one rim this is [`super::fill()`].
///
/// # Errors
/// A rim that cannot be used; rims that touch ([`PatchError::RimsTouch`]); rims whose faces have
/// opposite orientations ([`PatchError::InsideOut`]).
pub fn blend(geometry: &RimGeometry, options: PatchOptions) -> Result<Patch, PatchError> {
    if let [rim] = &geometry.rims[..] {
        return super::fill(rim, options);
    }
    for rim in &geometry.rims {
        validate(rim, options.density)?;
    }
    check_apart(geometry)?;
    if let Some(strip) = strip(geometry) {
        return Ok(strip);
    }
    let frame = Frame::around(geometry.points());
    let rims: Vec<Rim> = geometry.rims.iter().map(|r| frame.local(r)).collect();
    let chords = geometry.chords();
    let mut surface = if let Some(triangles) = layout::triangulate(&rims) {
        let points: Vec<DVec3> = rims.iter().flat_map(|r| r.points.clone()).collect();
        let count = points.len();
        Surface::new(points, vec![0.0; count], count, &triangles)
    } else {
        if !have_equal_sides(&rims) {
            check_orientation(&geometry.pieces, &rims)?;
        }
        bridges::surface(&rims, &chords)
    };
    surface.size = sizes(&rims, options);
    set_grading(&mut surface, options.density);
    require_memory(&surface)?;
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    split_chords(&mut surface, &chords);
    split_double_edges(&mut surface);
    // relaxation to a membrane would pinch it off between distant rims
    refit(&mut surface, &wanted);
    Ok(frame.world(surface.compact(), geometry.points()))
}

/// Brings a patch whose shape has changed (by a warm start or a flow) back to the rims' density, by
/// splits, collapses and flips. Vertices move along the surface only. `patch` is a result of
/// [`blend`] over the same rims, with other positions. A patch that has grown so much that this
/// would take 16 times its vertices is returned unchanged.
pub fn reblend(geometry: &RimGeometry, patch: &Patch, options: PatchOptions) -> Patch {
    let frame = Frame::around(geometry.points());
    let rims: Vec<Rim> = geometry.rims.iter().map(|r| frame.local(r)).collect();
    let points: Vec<DVec3> = patch.points.iter().map(|&p| frame.to_local(p)).collect();
    let mut size = sizes(&rims, options);
    let middle = size.iter().sum::<f64>() / size.len() as f64;
    size.resize(points.len(), middle);
    let max_vertices = MAX_GROWTH * points.len() as f64;
    let mut surface = Surface::new(points, size, patch.rim, &patch.triangles);
    set_grading(&mut surface, options.density);
    let needed = expected_vertices(&surface);
    if needed.is_nan() || needed >= max_vertices {
        return patch.clone();
    }
    frame.world(refitted(surface, &rims), geometry.points())
}

/// The patch between the rims after [`refit`].
fn refitted(mut surface: Surface, rims: &[Rim]) -> Patch {
    let loose: Vec<f64> = rims.iter().flat_map(loose_angles).collect();
    let wanted = rim_valences(&surface, &loose);
    refit(&mut surface, &wanted);
    surface.compact()
}

/// Maximum factor by which [`reblend`] may raise the number of vertices.
const MAX_GROWTH: f64 = 16.0;

/// Wanted edge lengths at all rim vertices.
fn sizes(rims: &[Rim], options: PatchOptions) -> Vec<f64> {
    let count = rims.iter().map(|r| r.points.len()).sum();
    rims.iter()
        .flat_map(|r| rim_sizes(&r.points, options.density, count))
        .collect()
}

/// No two rims may have a vertex at the same place.
fn check_apart(geometry: &RimGeometry) -> Result<(), PatchError> {
    let mut all: Vec<([u64; 3], usize, usize)> = Vec::with_capacity(geometry.vertex_count());
    for (r, rim) in geometry.rims.iter().enumerate() {
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

/// Whether all rims are mouths of tubes with outward normals, or all of tubes with inward normals.
fn have_equal_sides(rims: &[Rim]) -> bool {
    let side = |rim: &Rim| RimCurve::new(rim).side();
    let first = side(&rims[0]);
    first != 0.0 && rims.iter().all(|rim| side(rim) == first)
}

/// Up to this number of classes every combination of flips is tried; of more classes, one flip at a
/// time.
const MAX_COMBINED: u32 = 6;

/// Maximum number of flips that are tried one at a time.
const MAX_SINGLE: u32 = 31;

/// For rims that overlap from every point of view: an error if flipping some of them would change
/// that. Then no orientable surface joins them without intersecting itself.
fn check_orientation(pieces: &[u32], rims: &[Rim]) -> Result<(), PatchError> {
    let mut names = pieces.to_vec();
    names.sort_unstable();
    names.dedup();
    let piece_of = |k: usize| names.binary_search(&pieces[k]).unwrap_or(0);
    if let Some(rim) = first_misoriented(rims, names.len() as u32, piece_of) {
        return Err(PatchError::InsideOut { rim });
    }
    match first_misoriented(rims, rims.len() as u32, |k| k) {
        Some(rim) => Err(PatchError::OneSided { rim }),
        None => Ok(()),
    }
}

/// The first rim that has to be flipped so that there is a point from which the rims do not
/// overlap, if flipping helps. Rims of one class (of `count`) are flipped together, those of the
/// first class not at all.
fn first_misoriented(rims: &[Rim], count: u32, class: impl Fn(usize) -> usize) -> Option<usize> {
    let free = count - 1;
    let is_combined = free < MAX_COMBINED;
    // a set of classes, or one class
    let mut choices = if is_combined {
        1..1 << free
    } else {
        1..free.min(MAX_SINGLE) + 1
    };
    choices.find_map(|choice| {
        let is_flipped = |k: usize| match class(k) as u32 {
            0 => false,
            class if is_combined => choice >> (class - 1) & 1 == 1,
            class => choice == class,
        };
        let mut candidate: Vec<Rim> = rims.to_vec();
        for (k, rim) in candidate.iter_mut().enumerate() {
            if is_flipped(k) {
                rim.points.reverse();
            }
        }
        layout::triangulate(&candidate)?;
        (0..rims.len()).find(|&k| is_flipped(k))
    })
}

/// Splits edges that join the same two vertices as another edge, until there are none. Between
/// several rims an edge may run on either side of a bridge.
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
