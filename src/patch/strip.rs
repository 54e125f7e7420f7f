//! A strip of triangles between two rims that face each other less than an edge apart.

use super::data::{Patch, Rim, RimGeometry};
use crate::mesh::{DVec3, closest_point_on_polygon, perimeter, sides};

/// Largest distance of a rim vertex from the other rim, in mean edges of the two rims.
const REACH: f64 = 1.0;
/// Smallest mean over the edges of the cosine of the angle between the way to the other rim and the way on
/// across the edge. Two rims above each other, as those of a hole through a thin plate, have right angles;
/// those of the ragged cracks of the stress program have means of 0.5 and more.
const FACING: f64 = 0.3;

/// The triangles between two rims that run side by side and face each other, without new vertices: the
/// ring between them, whose edges across the gap are kept short. `None` for other rims, if the mesh has one
/// of its edges already, and if the ring has an edge twice.
pub(crate) fn strip(geometry: &RimGeometry) -> Option<Patch> {
    let [a, b] = &geometry.rims[..] else {
        return None;
    };
    let mean = (perimeter(&a.points) + perimeter(&b.points)) / geometry.vertex_count() as f64;
    let cosines = facing(a, b, REACH * mean)? + facing(b, a, REACH * mean)?;
    if cosines < FACING * geometry.vertex_count() as f64 {
        return None;
    }
    let triangles = zipped(&a.points, &b.points);
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&t| sides(t)).collect();
    let is_taken = |&[i, j]: &[u32; 2]| geometry.forbidden.contains(&[i.min(j), i.max(j)]);
    if edges.iter().any(is_taken) {
        return None;
    }
    // all edges of a short rim may be nearest to one vertex of the other
    edges.sort_unstable();
    if edges.windows(2).any(|pair| pair[0] == pair[1]) {
        return None;
    }
    Some(Patch {
        rim: geometry.vertex_count(),
        points: geometry.points().collect(),
        triangles,
    })
}

/// The sum over the edges of a rim of the cosine of the angle between the ways to the other rim and across
/// the edge. `None` if an edge is farther than `reach` from the other rim, or on it.
fn facing(rim: &Rim, other: &Rim, reach: f64) -> Option<f64> {
    let n = rim.points.len();
    let cosines = (0..n).map(|i| {
        let (start, end) = (rim.points[i], rim.points[(i + 1) % n]);
        let middle = start.midpoint(end);
        let across = closest_point_on_polygon(middle, &other.points) - middle;
        let inward = (start - rim.opposite[i]).reject_from(end - start);
        let is_near = across.length() <= reach && across != DVec3::ZERO;
        is_near.then(|| inward.normalize_or_zero().dot(across.normalize()))
    });
    cosines.sum()
}

/// The triangles between two closed polygons that run against each other, in numbers of both, one after
/// the other. From the shortest edge between them on, the next edge is the shorter of the two that are
/// possible.
fn zipped(a: &[DVec3], b: &[DVec3]) -> Vec<[u32; 3]> {
    let (n, m) = (a.len(), b.len());
    let pairs = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let apart = |&(i, j): &(usize, usize)| a[i].distance_squared(b[j]);
    let shortest = pairs.min_by(|p, q| apart(p).total_cmp(&apart(q)));
    let (first, second) = shortest.unwrap_or_default();
    let on_a = |steps: usize| (first + steps) % n;
    let on_b = |steps: usize| (second + m - steps % m) % m;
    let corners = |i: usize, j: usize| [on_a(i) as u32, (n + on_b(j)) as u32];
    let (mut i, mut j) = (0, 0);
    let mut triangles = Vec::with_capacity(n + m);
    while i < n || j < m {
        let [here, there] = corners(i, j);
        let along_a = apart(&(on_a(i + 1), on_b(j)));
        let along_b = apart(&(on_a(i), on_b(j + 1)));
        if j == m || (i < n && along_a <= along_b) {
            i += 1;
            triangles.push([here, corners(i, j)[0], there]);
        } else {
            j += 1;
            triangles.push([corners(i, j)[1], there, here]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A circle at a height, run through in a direction, with faces away from the plane z = 0.
    fn circle(n: u32, height: f64, direction: f64) -> Rim {
        let at = |t: f64, z: f64| DVec3::new(t.cos(), direction * t.sin(), z);
        let angle = |i: u32| TAU * f64::from(i) / f64::from(n);
        Rim {
            points: (0..n).map(|i| at(angle(i), height)).collect(),
            opposite: (0..n).map(|i| at(angle(i) + 0.05, 4.0 * height)).collect(),
            forbidden: Vec::new(),
        }
    }

    fn geometry(a: Rim, b: Rim) -> RimGeometry {
        RimGeometry {
            rims: vec![a, b],
            ..RimGeometry::default()
        }
    }

    #[test]
    fn a_strip_is_a_ring_with_an_edge_of_each_rim_in_each_triangle() {
        let both = geometry(circle(40, -0.03, 1.0), circle(47, 0.03, -1.0));
        let strip = strip(&both).expect("side by side");
        assert_eq!(strip.triangles.len(), 40 + 47);
        assert_eq!(strip.points.len(), strip.rim);
        let edges = strip.triangles.iter().flat_map(|&t| sides(t));
        let edges: std::collections::BTreeSet<[u32; 2]> = edges.collect();
        // each directed edge once
        assert_eq!(edges.len(), 3 * strip.triangles.len());
        for i in 0..40 {
            assert!(edges.contains(&[i, (i + 1) % 40]));
        }
        for j in 0..47 {
            assert!(edges.contains(&[40 + j, 40 + (j + 1) % 47]));
        }
        // area of a ring of radius 1 and width 0.06, less what the chords of 40 edges cut off
        let area: f64 = strip
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| strip.points[v as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        assert!((area / (0.06 * TAU) - 1.0).abs() < 5e-3, "{area}");
    }

    #[test]
    fn moved_and_scaled_rims_have_the_same_strip() {
        let rims = [circle(40, -0.03, 1.0), circle(47, 0.03, -1.0)];
        let moved = rims.clone().map(|rim| {
            let place = |p: &DVec3| 8.0 * DVec3::new(p.y, p.z, p.x) + DVec3::new(16.0, -4.0, 2.0);
            Rim {
                points: rim.points.iter().map(place).collect(),
                opposite: rim.opposite.iter().map(place).collect(),
                ..rim
            }
        });
        let [first, second] =
            [rims, moved].map(|[a, b]| strip(&geometry(a, b)).expect("side by side"));
        assert_eq!(first.triangles, second.triangles);
    }

    #[test]
    fn rims_apart_or_above_each_other_or_joined_already_have_none() {
        let (a, b) = (circle(40, -0.03, 1.0), circle(40, 0.03, -1.0));
        // one and a half edges apart
        let far = circle(40, 0.2, -1.0);
        assert_eq!(strip(&geometry(a.clone(), far)), None);
        // a hole through a plate: faces outwards in the planes of the rims
        let flat = |rim: &Rim| Rim {
            opposite: rim.points.iter().map(|p| 1.1 * *p).collect(),
            ..rim.clone()
        };
        assert_eq!(strip(&geometry(flat(&a), flat(&b))), None);
        // two discs on each other
        let inner = |rim: &Rim| Rim {
            opposite: rim.points.iter().map(|p| 0.9 * *p).collect(),
            ..rim.clone()
        };
        assert_eq!(strip(&geometry(inner(&a), inner(&b))), None);
        let mut joined = geometry(a, b);
        let free = strip(&joined).expect("side by side");
        let [i, j, _] = free.triangles[0];
        assert!(joined.forbidden.is_empty());
        joined.forbidden.push([i.min(j), i.max(j)]);
        assert_eq!(strip(&joined), None);
    }

    #[test]
    fn a_ring_whose_edges_all_end_at_one_vertex_is_refused() {
        // two small holes of a riddled sheet, one above the other
        let rim = |points: &[[f64; 3]], opposite: &[[f64; 3]]| {
            let [points, opposite] =
                [points, opposite].map(|all| all.iter().map(|&p| DVec3::from_array(p)).collect());
            let forbidden = Vec::new();
            Rim {
                points,
                opposite,
                forbidden,
            }
        };
        let four = rim(
            &[
                [-0.24, -0.69, -0.83],
                [-5.07, -3.23, -0.79],
                [-2.75, 1.56, -0.74],
                [1.41, 4.07, -0.77],
            ],
            &[
                [-3.38, -6.49, -0.86],
                [-6.69, -0.58, -0.7],
                [-0.47, 5.37, -0.69],
                [3.93, 2.3, -0.82],
            ],
        );
        let three = rim(
            &[
                [-1.67, -0.28, -0.01],
                [0.74, -3.18, 0.06],
                [2.88, 1.62, 0.02],
            ],
            &[
                [-3.73, -5.31, 0.03],
                [4.86, -1.85, 0.1],
                [1.55, 4.61, -0.06],
            ],
        );
        let triangles = zipped(&four.points, &three.points);
        let edges = triangles.iter().flat_map(|&t| sides(t));
        let edges: std::collections::BTreeSet<[u32; 2]> = edges.collect();
        assert!(edges.len() < 3 * triangles.len());
        assert_eq!(strip(&geometry(four, three)), None);
    }
}
