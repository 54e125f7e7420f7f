//! Measures of points and polygons.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle() {
        let points = [[0., 0.], [2., 0.], [2., 3.], [0., 3.]].map(|[x, y]| DVec3::new(x, y, 5.0));
        assert_eq!(perimeter(&points), 10.0);
        assert_eq!(vector_area(&points), 6.0 * DVec3::Z);
        let rms = rms_distance(points.iter().copied(), DVec3::new(1.0, 1.5, 5.0));
        assert!((rms - 3.25f64.sqrt()).abs() < 1e-15);
    }
}
