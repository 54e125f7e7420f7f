//! Brings a patch to its wanted edge length, with the rim untouched.
//!
//! ```text
//!   split a long edge        collapse a short edge        flip a diagonal
//!        c                     \   /        \ | /            c             c
//!      / | \                  --v-u--  ->  --u--           / \           /|\
//!     a--m--b                  /   \        / | \          a---b   ->    a | b
//!      \ | /                                               \ /           \|/
//!        d                                                  d             d
//! ```
//!
//! [`remesh`] starts from a triangulation without new vertices. It halves long edges until none is
//! left, flipping to the Delaunay property after each round (`refine`). Then it repeats: collapse
//! short edges, split long ones, flip towards six edges a vertex, move vertices towards the
//! centroids of their triangles (`relax`), flip to the Delaunay property. Lengths, angles and areas
//! are those of the patch in space; nothing is projected to a plane.
//!
//! Relaxation moves vertices towards a membrane of constant mean curvature, which stands in for the
//! final surface. [`refit`] does the same for a patch that has its shape already: its vertices move
//! along the surface only.

use super::grading::expected_vertices;
use super::surface::{NONE, STEEPEST, Surface, next, prev};
use crate::cancel::is_cancelled;
use crate::mesh::DVec3;

/// An edge longer than this multiple of the wanted length is split.
const LONG: f64 = 4.0 / 3.0;
/// An edge shorter than this multiple of the wanted length is collapsed.
const SHORT: f64 = 0.7;
/// Rounds of split, collapse, flip and relax after the first refinement.
const ROUNDS: usize = 5;
/// Vertex moves after each halving of the edges. The coarse levels, where a sweep reaches far and
/// costs little, form the curvature of the membrane.
const COARSE_WORK: usize = 3000;
/// Maximum number of relaxation sweeps on the coarsest levels.
const MAX_SWEEPS: usize = 40;
/// Relaxation sweeps in each round.
const SWEEPS: usize = 3;

/// The largest curvature of a membrane, relative to that of the hemisphere over a disc of the same
/// area. Beyond it a surface of constant mean curvature is unstable.
const MAX_CURVATURE: f64 = 0.85;
/// Maximum area of a curved membrane, relative to its first triangulation; a hemisphere over a disc
/// has 2. Beyond it the surface of constant mean curvature grows without bound, as it does over
/// rims that are wide in one place and narrow in others.
const MAX_AREA: f64 = 2.2;

/// Remeshes `s` to its `size` and relaxes it towards a surface of mean curvature `curvature`
/// (positive along the normals). `wanted` is the number of edges each rim vertex should have (rim
/// edges included), see [`rim_valences`].
pub(super) fn remesh(s: &mut Surface, wanted: &[i32], curvature: f64) {
    let first_area = s.area();
    let steepest = MAX_CURVATURE * (std::f64::consts::PI / first_area).sqrt();
    let mut membrane = Membrane {
        curvature: curvature.clamp(-steepest, steepest),
        max_area: MAX_AREA * first_area,
    };
    refine(s, &mut membrane);
    s.reorder();
    for round in 0..ROUNDS {
        if is_cancelled() {
            return;
        }
        if round > 0 {
            collapse_short(s);
            split_long(s);
        }
        flip_for_valence(s, wanted);
        membrane.relax(s, SWEEPS);
        flip_to_delaunay(s);
    }
    membrane.relax(s, 1);
}

/// Brings a patch to its `size` without changing its shape: vertices move along it only.
pub(super) fn refit(s: &mut Surface, wanted: &[i32]) {
    smooth_sizes(s, REFIT_SMOOTHING);
    refine(s, &mut Membrane::flat());
    for _ in 0..ROUNDS {
        if is_cancelled() {
            return;
        }
        collapse_short(s);
        split_long(s);
        flip_for_valence(s, wanted);
        relax_along(s, SWEEPS);
        flip_to_delaunay(s);
    }
}

/// Splits a patch down to its `size` without changing its shape. Only longest edges of both their
/// triangles are split: otherwise there would be no end at long rim edges, which stay whole.
pub(super) fn subdivide(s: &mut Surface) {
    let is_longest = |s: &Surface, h: u32| {
        let sides = [h, s.twin(h)].into_iter().flat_map(|h| [next(h), prev(h)]);
        sides
            .into_iter()
            .all(|side| s.length2(side) <= s.length2(h))
    };
    while !is_cancelled() && split_where(s, is_longest) {
        if s.is_graded() {
            s.grade();
        }
        flip_where(s, |s, h| {
            let (m, n) = (s.normal(h), s.normal(s.twin(h)));
            m.dot(n) >= (1.0 - COPLANAR) * m.length() * n.length()
        });
    }
}

/// Triangles whose normals have a cosine up to this much below 1 are coplanar: rounding after halving
/// edges some ten times.
const COPLANAR: f64 = 1e-12;

/// Smoothing passes that carry the rims' sizes into a patch whose inner vertices have no sizes yet.
const REFIT_SMOOTHING: usize = 100;

/// The surface of constant mean curvature towards which a patch is relaxed.
struct Membrane {
    curvature: f64,
    max_area: f64,
}

impl Membrane {
    /// Curvature zero: a minimal surface.
    const fn flat() -> Self {
        Self {
            curvature: 0.0,
            max_area: f64::INFINITY,
        }
    }

    /// Relaxes `s`. While its area is too large the curvature is reduced.
    fn relax(&mut self, s: &mut Surface, sweeps: usize) {
        relax(s, sweeps, self.curvature);
        while self.curvature != 0.0 && s.area() > self.max_area {
            // well below any curvature that matters
            let negligible = self.curvature.abs() * self.max_area.sqrt() < 0.01;
            self.curvature = if negligible {
                0.0
            } else {
                0.7 * self.curvature
            };
            relax(s, sweeps, self.curvature);
        }
    }
}

/// The number of edges that divides the patch's angle at each rim vertex into angles near 60°.
///
/// `loose[i]` is the angle of the existing face at rim vertex `i` if it is the only one there, else
/// 0. Where a loose triangle stands up from the first triangulation, the angle in that
/// triangulation is far too small: the patch covers all the rest of the full angle.
pub(super) fn rim_valences(s: &Surface, loose: &[f64]) -> Vec<i32> {
    let mut angle = vec![0.0; s.rim];
    for h in 0..s.corner.len() as u32 {
        let v = s.from(h);
        if s.is_rim(v) {
            let a = s.point(s.to(h)) - s.point(v);
            let b = s.point(s.apex(h)) - s.point(v);
            angle[v as usize] += a.cross(b).length().atan2(a.dot(b));
        }
    }
    let sixty = std::f64::consts::FRAC_PI_3;
    angle
        .iter()
        .zip(loose)
        .map(|(&seen, &loose)| {
            let angle = if loose > 0.0 {
                seen.max(6.0 * sixty - loose)
            } else {
                seen
            };
            1 + (angle / sixty).round().max(1.0) as i32
        })
        .collect()
}

/// Splits those of the chords (pairs of rim vertices) that are edges of the patch. They do not come
/// back, because flips and collapses never join two rim vertices.
pub(super) fn split_chords(s: &mut Surface, chords: &[[u32; 2]]) {
    for &[i, j] in chords {
        if let Some(h) = s.edge_between(i, j) {
            let middle = s.point(i).midpoint(s.point(j));
            s.split(h, middle);
        }
    }
}

/// Maximum number of vertices after a refinement, relative to those before and the expected ones together. On a surface
/// that is folded onto itself flips make long edges again, and splits would not end.
const MOST: f64 = 16.0;

/// First refinement of a coarse triangulation: halves long edges, restoring the Delaunay property
/// after each round of splits.
fn refine(s: &mut Surface, membrane: &mut Membrane) {
    flip_to_delaunay(s);
    let most = MOST * (s.points.len() as f64 + expected_vertices(s));
    // every round halves the long edges, so this bounds extents of 2^40 edge lengths
    for _ in 0..40 {
        let before = s.points.len();
        if before as f64 > most {
            return;
        }
        if is_cancelled() || !split_long(s) {
            return;
        }
        flip_to_delaunay(s);
        if s.is_graded() {
            s.grade();
        }
        // stop if few splits remain, because every sweep visits all vertices
        if membrane.curvature != 0.0 && 5 * s.points.len() > 6 * before {
            let sweeps = COARSE_WORK / s.points.len();
            membrane.relax(s, sweeps.clamp(SWEEPS, MAX_SWEEPS));
        }
    }
}

/// Splits long edges at their midpoints, once over all of them. Returns whether there were any.
fn split_long(s: &mut Surface) -> bool {
    split_where(s, |_, _| true)
}

/// The same, but splits only edges that are `allowed`.
fn split_where(s: &mut Surface, allowed: impl Fn(&Surface, u32) -> bool) -> bool {
    let mut any = false;
    for h in 0..s.corner.len() as u32 {
        if s.is_dead(h) || s.twin(h) == NONE || s.twin(h) < h {
            continue;
        }
        let (a, b) = (s.from(h), s.to(h));
        let limit = LONG * wanted_length(s, h);
        if s.length2(h) > limit * limit && allowed(s, h) {
            let middle = s.point(a).midpoint(s.point(b));
            s.split(h, middle);
            any = true;
        }
    }
    any
}

/// The wanted length of an edge. A chord between rim vertices leads through a place with smaller
/// triangles.
fn wanted_length(s: &Surface, h: u32) -> f64 {
    let (a, b) = (s.from(h), s.to(h));
    let mean = f64::midpoint(s.size[a as usize], s.size[b as usize]);
    if s.refinement > 1.0 && s.is_rim(a) && s.is_rim(b) {
        let middle = mean - 0.5 * STEEPEST * s.length2(h).sqrt();
        return middle.max(mean / s.refinement);
    }
    mean
}

/// Merges the ends of short edges, once over all of them.
fn collapse_short(s: &mut Surface) {
    for h in 0..s.corner.len() as u32 {
        if s.is_dead(h) || s.twin(h) == NONE {
            continue;
        }
        let (v, u) = (s.from(h), s.to(h));
        if s.is_rim(v) {
            continue;
        }
        let limit = SHORT * f64::midpoint(s.size[v as usize], s.size[u as usize]);
        if s.length2(h) >= limit * limit || !s.may_collapse(h) {
            continue;
        }
        let point = if s.is_rim(u) {
            s.point(u)
        } else {
            s.point(u).midpoint(s.point(v))
        };
        s.collapse(h, point);
    }
}

/// Whether flipping `h` keeps the patch a manifold disc, joins no two rim vertices and folds
/// nothing over.
fn may_flip(s: &Surface, h: u32) -> bool {
    let g = s.twin(h);
    if g == NONE {
        return false;
    }
    let (a, b, c, d) = (s.from(h), s.to(h), s.apex(h), s.apex(g));
    if s.is_rim(c) && s.is_rim(d) {
        return false;
    }
    let spare = |v: u32| s.valence[v as usize] > if s.is_rim(v) { 2 } else { 3 };
    if !spare(a) || !spare(b) {
        return false;
    }
    let (pa, pb, pc, pd) = (s.point(a), s.point(b), s.point(c), s.point(d));
    let old = s.normal(h) + s.normal(g);
    let first = (pc - pd).cross(pa - pd);
    let second = (pb - pd).cross(pc - pd);
    first.dot(old) > 0.0 && second.dot(old) > 0.0 && !s.joined(c, d)
}

/// Cotangent of the angle at `apex` times twice the triangle's area, and that area.
fn corner_cotangent(apex: DVec3, a: DVec3, b: DVec3) -> (f64, f64) {
    let (u, v) = (a - apex, b - apex);
    (u.dot(v), u.cross(v).length())
}

/// Whether the angles opposite the edge sum up to more than 180°, rounding aside.
fn is_not_delaunay(s: &Surface, h: u32) -> bool {
    let (a, b) = (s.point(s.from(h)), s.point(s.to(h)));
    let (dot_c, area_c) = corner_cotangent(s.point(s.apex(h)), a, b);
    let (dot_d, area_d) = corner_cotangent(s.point(s.apex(s.twin(h))), a, b);
    dot_c * area_d + dot_d * area_c < -1e-10 * (area_c * area_d).max(f64::MIN_POSITIVE)
}

/// Flips edges until the triangulation is Delaunay in its own metric (opposite angles of every
/// interior edge sum up to at most 180°).
fn flip_to_delaunay(s: &mut Surface) {
    flip_where(s, |_, _| true);
}

/// The same, but flips only edges that are `allowed`.
fn flip_where(s: &mut Surface, allowed: impl Fn(&Surface, u32) -> bool) {
    let mut stack: Vec<u32> = (0..s.corner.len() as u32)
        .rev()
        .filter(|&h| s.twin(h) != NONE && s.twin(h) > h)
        .collect();
    // Lawson's flips end in the plane; in space a bound guards against cycles.
    let mut left = 8 * s.corner.len() + 64;
    while let Some(h) = stack.pop() {
        let may_flip = |s: &Surface| is_not_delaunay(s, h) && may_flip(s, h) && allowed(s, h);
        if s.is_dead(h) || s.twin(h) == NONE || !may_flip(s) {
            continue;
        }
        s.flip(h);
        if left == 0 {
            return;
        }
        left -= 1;
        let g = s.twin(h);
        stack.extend([next(h), prev(h), next(g), prev(g)]);
    }
}

/// Flips edges where that brings the valences of their four vertices nearer to the wanted ones
/// (6 in the interior) without making a thin triangle.
fn flip_for_valence(s: &mut Surface, wanted: &[i32]) {
    let excess = |s: &Surface, v: u32| -> i32 {
        let want = wanted.get(v as usize).copied().unwrap_or(6);
        s.valence[v as usize].cast_signed() - want
    };
    for h in 0..s.corner.len() as u32 {
        let g = s.twin(h);
        if s.is_dead(h) || g == NONE || g < h {
            continue;
        }
        let (a, b, c, d) = (s.from(h), s.to(h), s.apex(h), s.apex(g));
        let gain = excess(s, a) + excess(s, b) - excess(s, c) - excess(s, d);
        // (x−1)² summed over the losing and (x+1)² over the gaining ends, minus before
        if gain <= 2 || !may_flip(s, h) {
            continue;
        }
        let (pa, pb, pc, pd) = (s.point(a), s.point(b), s.point(c), s.point(d));
        if is_thin(pd, pc, pa) || is_thin(pc, pd, pb) {
            continue;
        }
        s.flip(h);
    }
}

/// Whether a triangle's shape is worse than (1, 1, 1.8): height over longest side below about 1/4.
fn is_thin(a: DVec3, b: DVec3, c: DVec3) -> bool {
    let longest2 = a
        .distance_squared(b)
        .max(b.distance_squared(c))
        .max(c.distance_squared(a));
    (b - a).cross(c - a).length() < 0.25 * longest2
}

/// Moves interior vertices, in place, towards the mean of the centroids of their triangles weighted
/// with area in the metric of the wanted size (centroidal patch triangulation: L. Chen, "Mesh
/// smoothing schemes based on optimal Delaunay triangulations", 2004), and wanted sizes to the mean
/// of their neighbours'. The target lies off the centroid by as much as a surface of mean curvature
/// `curvature` leaves its tangent plane: H/2 times the squared distance at every corner.
fn relax(s: &mut Surface, sweeps: usize, curvature: f64) {
    let metric: Vec<f64> = s.size.iter().map(|size| 1.0 / (size * size)).collect();
    for _ in 0..sweeps {
        for v in s.rim..s.points.len() {
            if s.out[v] == NONE {
                continue;
            }
            let step = if curvature == 0.0 {
                star_step::<false>(s, v, &metric, 0.0)
            } else {
                star_step::<true>(s, v, &metric, curvature)
            };
            s.points[v] += step;
        }
    }
    smooth_sizes(s, 1);
}

/// Moves interior vertices along the patch only: the part of the step of [`relax`] across the
/// vertex normal is left out.
fn relax_along(s: &mut Surface, sweeps: usize) {
    let metric: Vec<f64> = s.size.iter().map(|size| 1.0 / (size * size)).collect();
    for _ in 0..sweeps {
        for v in s.rim..s.points.len() {
            if s.out[v] != NONE {
                let step = star_step::<false>(s, v, &metric, 0.0);
                let normal = s.vertex_normal(v as u32).normalize_or_zero();
                s.points[v] += step - normal * step.dot(normal);
            }
        }
    }
    smooth_sizes(s, 1);
}

/// Sets wanted sizes of interior vertices to the mean of their neighbours', in place, or to those
/// that grow from the rim.
fn smooth_sizes(s: &mut Surface, passes: usize) {
    if s.is_graded() {
        s.grade();
        return;
    }
    for _ in 0..passes {
        for v in s.rim..s.points.len() {
            if s.out[v] != NONE {
                let mut sum = 0.0;
                s.for_neighbours(v as u32, |w| sum += s.size[w as usize]);
                s.size[v] = sum / f64::from(s.valence[v]);
            }
        }
    }
}

/// The step of an interior vertex to its target (see [`relax`]); `metric` is 1/size² per vertex.
#[inline]
fn star_step<const CURVED: bool>(s: &Surface, v: usize, metric: &[f64], curvature: f64) -> DVec3 {
    let centre = s.points[v];
    let first = s.out[v];
    let start = s.to(first) as usize;
    let mut a = s.points[start] - centre;
    let mut metric_a = metric[start];
    let (mut moment, mut weights) = (DVec3::ZERO, 0.0);
    let (mut normal, mut drop) = (DVec3::ZERO, 0.0);
    let mut h = first;
    loop {
        let back = prev(h);
        let w = s.from(back) as usize;
        let b = s.points[w] - centre;
        let cross = a.cross(b);
        let weight = cross.length() * (metric[v] + metric_a + metric[w]);
        moment += weight * (a + b);
        weights += weight;
        if CURVED {
            normal += cross;
            drop += weight * (a.length_squared() + b.length_squared());
        }
        a = b;
        metric_a = metric[w];
        h = s.twin(back);
        if h == first {
            break;
        }
    }
    if weights <= 0.0 {
        return DVec3::ZERO;
    }
    let step = moment / (3.0 * weights);
    if !CURVED {
        return step;
    }
    let normal = normal.normalize_or_zero();
    let rise = step.dot(normal) + curvature * drop / (6.0 * weights);
    let over = step + (RISE * rise - step.dot(normal)) * normal;
    // over tangled rims over-relaxation may diverge; the step to the centroid stays in the hull
    if (centre + over).length_squared() < MAX_DISTANCE * MAX_DISTANCE {
        over
    } else {
        step
    }
}

/// Over-relaxation along the normal of a curved membrane. A step towards the centroid is two thirds
/// of one towards the mean of the neighbours, so this is a factor of 1.47 for Gauss-Seidel, below
/// the limit of 2.
const RISE: f64 = 2.2;

/// Maximum distance of a curved membrane from the mean of the rim, in distances of the farthest rim
/// vertex; a hemisphere over a disc reaches 1.
const MAX_DISTANCE: f64 = 1.5;
