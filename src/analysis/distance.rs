//! Distance between two surfaces.

use rayon::prelude::*;
use serde::Serialize;

use crate::mesh::{DVec3, Mesh, TriangleBvh};

/// Distances from the points of one mesh to another one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// Root of the area average of the squared distance.
    pub rms: f64,
    /// Area average of the distance.
    pub mean: f64,
    /// Largest distance over vertices and sample points.
    pub max: f64,
    /// The point of the maximum, on the mesh whose distances these are.
    pub max_at: [f64; 3],
    /// Distance of each vertex, for colouring.
    #[serde(skip)]
    pub vertices: Vec<f64>,
}

/// Distances between two meshes, in both directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distances {
    /// From the mesh to the reference.
    pub to_reference: Deviation,
    /// From the reference to the mesh.
    pub from_reference: Deviation,
    /// Root of the mean of both squared RMS distances.
    pub rms: f64,
    /// The larger of both maxima: a lower bound of the Hausdorff distance.
    pub max: f64,
}

/// Sample points of a triangle, all of the same weight: the centres of its division into sixteen.
/// Only the three corners, three edge midpoints and the centre would leave gaps.
const DIVISIONS: u32 = 4;

/// Distances between a mesh and a reference, or `None` if one of them has no triangles. Triangles
/// are sampled at sixteen points each, weighted by area; vertices count for the maxima.
pub fn distances(mesh: &Mesh, reference: &Mesh) -> Option<Distances> {
    let to_reference = one_sided(mesh, reference)?;
    let from_reference = one_sided(reference, mesh)?;
    let squares = to_reference.rms.powi(2) + from_reference.rms.powi(2);
    Some(Distances {
        rms: (0.5 * squares).sqrt(),
        max: to_reference.max.max(from_reference.max),
        to_reference,
        from_reference,
    })
}

fn one_sided(from: &Mesh, to: &Mesh) -> Option<Deviation> {
    let triangles: Vec<[u32; 3]> = to.all_triangles().collect();
    let bvh = TriangleBvh::new(&to.positions, &triangles);
    bvh.closest_point(DVec3::ZERO)?;
    let distance = |p: DVec3| bvh.closest_point(p).map_or(0.0, |c| c.distance);
    let own: Vec<[u32; 3]> = from.all_triangles().collect();
    let vertices: Vec<f64> = from.positions.par_iter().map(|&p| distance(p)).collect();
    // (area, mean, mean of squares, largest, where) of each triangle, added in order
    let parts: Vec<(f64, f64, f64, f64, DVec3)> = own
        .par_iter()
        .map(|t| {
            let corners = t.map(|v| from.positions[v as usize]);
            sample(corners, distance)
        })
        .collect();
    let (mut area, mut sum, mut squares) = (0.0, 0.0, 0.0);
    let (mut max, mut max_at) = (0.0, DVec3::ZERO);
    for &(a, mean, square, largest, at) in &parts {
        area += a;
        sum += a * mean;
        squares += a * square;
        if largest > max {
            (max, max_at) = (largest, at);
        }
    }
    let mut used = vec![false; vertices.len()];
    for &v in own.iter().flatten() {
        used[v as usize] = true;
    }
    for (v, &d) in vertices.iter().enumerate() {
        if used[v] && d > max {
            (max, max_at) = (d, from.positions[v]);
        }
    }
    (area > 0.0).then(|| Deviation {
        rms: (squares / area).sqrt(),
        mean: sum / area,
        max,
        max_at: max_at.to_array(),
        vertices,
    })
}

/// Area, mean distance, mean squared distance, largest distance of a triangle and where.
fn sample([a, b, c]: [DVec3; 3], distance: impl Fn(DVec3) -> f64) -> (f64, f64, f64, f64, DVec3) {
    let area = 0.5 * (b - a).cross(c - a).length();
    let n = f64::from(DIVISIONS);
    let (mut mean, mut square, mut largest, mut at) = (0.0, 0.0, 0.0, a);
    let mut take = |i: f64, j: f64| {
        let p = a + (b - a) * (i / n) + (c - a) * (j / n);
        let d = distance(p);
        mean += d;
        square += d * d;
        if d > largest {
            (largest, at) = (d, p);
        }
    };
    for i in 0..DIVISIONS {
        for j in 0..DIVISIONS - i {
            let (x, y) = (f64::from(i), f64::from(j));
            take(x + 1.0 / 3.0, y + 1.0 / 3.0);
            if i + j + 1 < DIVISIONS {
                take(x + 2.0 / 3.0, y + 2.0 / 3.0);
            }
        }
    }
    let count = n * n;
    (area, mean / count, square / count, largest, at)
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::shapes::icosphere;

    fn ball(radius: f64, frequency: u32) -> Mesh {
        let (positions, triangles) = icosphere(frequency);
        Mesh::from_triangles(positions.iter().map(|&p| radius * p).collect(), &triangles)
            .expect("closed")
    }

    #[test]
    fn a_mesh_is_no_distance_from_itself() {
        let d = distances(&ball(1.0, 3), &ball(1.0, 3)).expect("triangles");
        assert!(d.rms < 1e-15 && d.max < 1e-15);
    }

    #[test]
    fn homothetic_polyhedra() {
        // parallel faces: face points of the inner one project into the outer one's face
        let (inner, outer) = (ball(1.0, 1), ball(1.5, 1));
        let d = distances(&inner, &outer).expect("triangles");
        let inradius = inner.corners(0.into()).iter().sum::<DVec3>().length() / 3.0;
        assert!((d.to_reference.rms - 0.5 * inradius).abs() < 1e-14);
        assert!((d.to_reference.max - 0.5 * inradius).abs() < 1e-14);
        assert!((d.from_reference.max - 0.5).abs() < 1e-14, "at a corner");
        let back = distances(&outer, &inner).expect("triangles");
        assert_eq!(back.from_reference, d.to_reference);
        assert_eq!(back.rms, d.rms);
    }

    #[test]
    fn nothing_to_measure() {
        let none = Mesh::from_triangles(Vec::new(), &[]).expect("empty");
        assert!(distances(&none, &ball(1.0, 1)).is_none());
        assert!(distances(&ball(1.0, 1), &none).is_none());
    }
}
