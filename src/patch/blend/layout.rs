//! Rims as seen from a point: their images on the sphere around it, and the Delaunay triangulation
//! of the region between them.

use spade::Point2;

use crate::mesh::{DVec3, vector_area};
use crate::patch::data::Rim;
use crate::patch::planar::delaunay_between;

/// A triangulation between the rims without new vertices. Of all points of view from which no rim
/// overlaps another, the one whose triangulation has the least area is taken. `None` if no point
/// that is tried is such a point, or if the orientations of the rims do not fit.
///
/// The spherical Delaunay triangulation is the planar one after stereographic projection, which
/// takes circles to circles; the pole is put on the far side of a rim.
pub(super) fn triangulate(rims: &[Rim]) -> Option<Vec<[u32; 3]>> {
    let points: Vec<DVec3> = rims.iter().flat_map(|r| r.points.iter().copied()).collect();
    let lengths: Vec<usize> = rims.iter().map(|r| r.points.len()).collect();
    let mut best: Option<(f64, Vec<[u32; 3]>)> = None;
    for centre in points_of_view(rims) {
        for inwards in [false, true] {
            let Some(flat) = view(rims, centre, inwards) else {
                continue;
            };
            let Some(triangles) = delaunay_between(flat, &lengths) else {
                continue;
            };
            let area = area(&points, &triangles);
            // a later view must be better by more than rounding
            if best.as_ref().is_none_or(|b| area < (1.0 - 1e-6) * b.0) {
                best = Some((area, triangles));
            }
        }
    }
    best.map(|(_, triangles)| triangles)
}

fn area(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum()
}

/// Distances of points of view from the middle along the common normal, in radii of the whole: rims
/// in one plane (a hole with islands) must be viewed from outside the plane.
const OFF: [f64; 3] = [0.4, 1.0, 3.0];

/// Points of view: the mean of the rims, the point nearest to all axes, and points on either
/// side of both along the mean normal.
fn points_of_view(rims: &[Rim]) -> Vec<DVec3> {
    let middle = |r: &Rim| r.points.iter().sum::<DVec3>() / r.points.len() as f64;
    let centre = rims.iter().map(middle).sum::<DVec3>() / rims.len() as f64;
    let axes: Vec<(DVec3, DVec3)> = rims
        .iter()
        .map(|r| (middle(r), vector_area(&r.points).normalize_or_zero()))
        .collect();
    let crossing = nearest_to_lines(&axes, centre);
    let normal = rims.iter().map(|r| vector_area(&r.points)).sum::<DVec3>();
    let mut views = vec![centre, crossing, centre.midpoint(crossing)];
    // the normal of a closed configuration (tubes that face each other) is rounding
    let along = match normal.try_normalize() {
        Some(n) if normal.length() > 1e-6 => vec![n],
        _ => axes.iter().map(|a| a.1).collect(),
    };
    for direction in along {
        for off in OFF {
            views.extend([centre + off * direction, centre - off * direction]);
        }
    }
    views
}

/// The point with the least sum of squared distances from the lines (point, direction), drawn a
/// little towards `centre`, so that it exists for parallel lines too.
fn nearest_to_lines(lines: &[(DVec3, DVec3)], centre: DVec3) -> DVec3 {
    const PULL: f64 = 1e-3;
    let mut matrix = glam::DMat3::from_diagonal(DVec3::splat(PULL));
    let mut right = DVec3::ZERO;
    for &(p, d) in lines {
        let across = glam::DMat3::IDENTITY - glam::DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        matrix += across;
        right += across * (p - centre);
    }
    centre + matrix.inverse() * right
}

/// Minimum distance of a point of view from all vertices, in radii of the whole.
const NEAR: f64 = 1e-3;

/// The rims on the sphere around `centre`, projected from a pole beyond the rim that takes up most
/// of it. The patch lies to the left of the rims in the plane: seen from outside if its
/// normals point away from the centre, mirrored if they point `inwards`.
fn view(rims: &[Rim], centre: DVec3, inwards: bool) -> Option<Vec<Point2<f64>>> {
    let sphere: Vec<Vec<DVec3>> = rims
        .iter()
        .map(|r| r.points.iter().map(|&p| p - centre).collect())
        .collect();
    if sphere.iter().flatten().any(|p| p.length() < NEAR) {
        return None;
    }
    let sphere: Vec<Vec<DVec3>> = sphere
        .iter()
        .map(|rim| rim.iter().map(|p| p.normalize()).collect())
        .collect();
    let pole = sphere
        .iter()
        .map(|rim| {
            let middle = rim.iter().sum::<DVec3>().normalize_or_zero();
            // positive: counter-clockwise around its middle as seen from outside
            let turn = vector_area(rim).dot(middle);
            let excluded = if (turn > 0.0) == inwards {
                middle
            } else {
                -middle
            };
            (turn.abs(), excluded)
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))?
        .1
        .try_normalize()?;
    let (u, v) = frame(pole, &sphere);
    let v = if inwards { -v } else { v };
    Some(
        sphere
            .iter()
            .flatten()
            .map(|&d| {
                let down = (1.0 - d.dot(pole)).max(1e-9);
                let snap = |x: f64| if x.abs() < 1e-40 { 0.0 } else { x };
                Point2::new(snap(d.dot(u) / down), snap(d.dot(v) / down))
            })
            .collect(),
    )
}

/// Axes of the plane across the pole, counter-clockwise seen against it; they turn with the rims.
fn frame(pole: DVec3, sphere: &[Vec<DVec3>]) -> (DVec3, DVec3) {
    let far = sphere
        .iter()
        .flatten()
        .map(|&d| d.reject_from_normalized(pole))
        .fold(DVec3::ZERO, |far, d| {
            if d.length_squared() > far.length_squared() {
                d
            } else {
                far
            }
        });
    let u = far
        .try_normalize()
        .unwrap_or_else(|| pole.any_orthonormal_vector());
    (u, u.cross(pole))
}
