//! Measures of points and polygons.

use std::f64::consts::PI;

use rustc_hash::FxHashMap;

use super::{DVec3, Topology, VertexId};

/// Root of the mean squared distance of points from `centre`; not a number without points.
pub fn rms_distance(points: impl ExactSizeIterator<Item = DVec3>, centre: DVec3) -> f64 {
    let count = points.len() as f64;
    (points.map(|p| p.distance_squared(centre)).sum::<f64>() / count).sqrt()
}

/// Unit normal at a vertex: the mean of those of its faces, weighted by area. `place` gives positions.
/// `None` if the faces have no area.
pub fn vertex_normal(
    topology: &Topology,
    v: VertexId,
    place: impl Fn(VertexId) -> DVec3,
) -> Option<DVec3> {
    let faces = topology.outgoing(v).map(|h| topology.face(h));
    let areas = faces.filter(|f| f.is_some()).map(|f| {
        let [a, b, c] = topology.face_vertices(f);
        let [a, b, c] = [place(a), place(b), place(c)];
        (b - a).cross(c - a)
    });
    areas.sum::<DVec3>().try_normalize()
}

/// The [`vertex_normal`] at each of the positions, the corners of these triangles; 0 where there is none.
pub fn vertex_normals(
    positions: &[DVec3],
    triangles: impl IntoIterator<Item = [u32; 3]>,
) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let area = (b - a).cross(c - a);
        for v in t {
            sums[v as usize] += area;
        }
    }
    let normals = sums.into_iter().map(DVec3::normalize_or_zero);
    normals.collect()
}

/// Length of a closed polygon.
pub fn perimeter(points: &[DVec3]) -> f64 {
    let n = points.len();
    (0..n)
        .map(|i| points[i].distance(points[(i + 1) % n]))
        .sum()
}

/// Vector area of a closed polygon, half the integral of `x × dx`. Every surface bounded by the
/// polygon has this vector area.
///
/// # Panics
/// If there are no points.
pub fn vector_area(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    let mut area = DVec3::ZERO;
    for i in 0..points.len() {
        let (a, b) = (points[i] - origin, points[(i + 1) % points.len()] - origin);
        area += 0.5 * a.cross(b);
    }
    area
}

/// A closed polygon with less area than this part of that of a circle of its perimeter is a slit: its width is below
/// 1/300 of its length.
const SLIT: f64 = 0.01;

/// Whether the two sides of a closed polygon almost coincide.
pub(crate) fn is_slit(points: &[DVec3]) -> bool {
    4.0 * PI * vector_area(points).length() < SLIT * perimeter(points).powi(2)
}

/// The directed edges of a triangle.
pub(crate) fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// How much a surface of triangles bends inside, whatever its size: the sum over its inner edges of `θ² l² / A`, with
/// the angle θ between the normals of both faces, the length l of the edge and A, four thirds of their area (Grinspun,
/// Hirani, Desbrun, Schröder 2003, scaled). On equilateral triangles it tends to `∫ ¾ (k1² + k2²) − ½ k1 k2` (Seung,
/// Nelson 1988), which is 4π on a sphere.
pub fn bending(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let bends = bends(positions, triangles).into_iter();
    let with_area = bends.filter(|bend| bend.area > 0.0);
    with_area.map(|bend| 0.75 * bend.cost()).sum()
}

/// An inner edge of a surface of triangles.
pub(crate) struct Bend {
    /// Between the normals of both faces, in radians.
    pub angle: f64,
    squared_length: f64,
    /// Of both faces.
    pub area: f64,
}

impl Bend {
    /// `θ² l² / A`, without a unit.
    pub fn cost(&self) -> f64 {
        self.angle * self.angle * self.squared_length / self.area
    }
}

/// The inner edges of a surface of triangles.
pub(crate) fn bends(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Bend> {
    let mut first: FxHashMap<[u32; 2], DVec3> = FxHashMap::default();
    let mut bends = Vec::new();
    for &t in triangles {
        let own = vector_area(&t.map(|v| positions[v as usize]));
        for [v, w] in sides(t) {
            let Some(other) = first.insert([v.min(w), v.max(w)], own) else {
                continue;
            };
            let [a, b] = [v, w].map(|v| positions[v as usize]);
            bends.push(Bend {
                angle: own.cross(other).length().atan2(own.dot(other)),
                squared_length: a.distance_squared(b),
                area: own.length() + other.length(),
            });
        }
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use std::f64::consts::PI;

    #[test]
    fn bending_of_a_sphere_a_tube_and_a_plane() {
        let of = |(points, triangles): &shapes::TriangleMesh| bending(points, triangles);
        let (points, triangles) = shapes::icosphere(16);
        let sphere = (points.clone(), triangles.clone());
        assert!(
            (of(&sphere) / (4.0 * PI) - 1.0).abs() < 0.02,
            "{}",
            of(&sphere)
        );
        let turned = |p: &DVec3| DVec3::new(7.0 * p.z + 3.0, 7.0 * p.x, 7.0 * p.y);
        let turned = (points.iter().map(turned).collect(), triangles);
        assert!((of(&turned) / of(&sphere) - 1.0).abs() < 1e-12);
        // equilateral triangles in a plane, then on a tube with k1 = 1 and k2 = 0
        let (n, edge) = (30, 0.06);
        let height = 0.75f64.sqrt() * edge;
        let at = |i: u32, j: u32| {
            let x = f64::from(i) + 0.5 * f64::from(j % 2);
            DVec3::new(edge * x, height * f64::from(j), 0.0)
        };
        let plane: Vec<DVec3> = (0..n * n).map(|k| at(k % n, k / n)).collect();
        let squares = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (i + n * j, j % 2 == 0)));
        let halves = squares.flat_map(|(a, is_even)| {
            let [b, c, d] = [a + 1, a + n, a + n + 1];
            if is_even {
                [[a, b, c], [b, d, c]]
            } else {
                [[a, b, d], [a, d, c]]
            }
        });
        let triangles: Vec<[u32; 3]> = halves.collect();
        assert!(bending(&plane, &triangles) < 1e-20);
        let tube = plane.iter().map(|p| DVec3::new(p.x.sin(), p.x.cos(), p.y));
        let tube: Vec<DVec3> = tube.collect();
        let area = triangles.len() as f64 * 0.5 * edge * height;
        let mean = bending(&tube, &triangles) / area;
        // the edges of the border do not count
        assert!((0.72..0.75).contains(&mean), "{mean}");
    }

    #[test]
    fn a_rectangle() {
        let points = [[0., 0.], [2., 0.], [2., 3.], [0., 3.]].map(|[x, y]| DVec3::new(x, y, 5.0));
        assert_eq!(perimeter(&points), 10.0);
        assert_eq!(vector_area(&points), 6.0 * DVec3::Z);
        let rms = rms_distance(points.iter().copied(), DVec3::new(1.0, 1.5, 5.0));
        assert!((rms - 3.25f64.sqrt()).abs() < 1e-15);
    }
}
