//! The surface at a point of the picture, and the value of a colour map there.

use rayon::prelude::*;

use super::{Scene, Vertex, ViewMode};
use crate::mesh::DVec3;

/// The number shown where a line of sight first meets a surface; `None` beside all surfaces, and
/// where the number is unknown.
pub fn value_on_line(
    scene: &Scene,
    mode: ViewMode,
    origin: DVec3,
    direction: DVec3,
) -> Option<f64> {
    let (_, weights, corners) = first_on_line(scene, origin, direction)?;
    let [a, b, c] = corners.map(|corner| mode.value(corner));
    let [u, v, w] = weights;
    Some(u * f64::from(a?) + v * f64::from(b?) + w * f64::from(c?))
}

/// The point where a line of sight first meets a surface.
pub fn point_on_line(scene: &Scene, origin: DVec3, direction: DVec3) -> Option<DVec3> {
    let (depth, ..) = first_on_line(scene, origin, direction)?;
    Some(origin + depth * direction)
}

/// The depth at which a line of sight first meets a surface, and the triangle there with the barycentric
/// coordinates of the point.
fn first_on_line(
    scene: &Scene,
    origin: DVec3,
    direction: DVec3,
) -> Option<(f64, [f64; 3], [&Vertex; 3])> {
    let start = origin - scene.centre;
    let hits = scene.surfaces.iter().filter_map(|geometry| {
        let hit = move |t: &[u32; 3]| {
            let corners = t.map(|v| &geometry.vertices[v as usize]);
            let places = corners.map(|v| DVec3::from_array(v.position.map(f64::from)));
            meet(places, start, direction).map(|(depth, weights)| (depth, weights, corners))
        };
        let hits = geometry.triangles.par_iter().filter_map(hit);
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Depth and barycentric coordinates of the point where a line in front of its start meets a
/// triangle.
fn meet([a, b, c]: [DVec3; 3], start: DVec3, direction: DVec3) -> Option<(f64, [f64; 3])> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = start - a;
    let v = from.dot(p) / determinant;
    let q = from.cross(ab);
    let w = direction.dot(q) / determinant;
    let depth = ac.dot(q) / determinant;
    let inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0 && depth > 0.0;
    inside.then_some((depth, [1.0 - v - w, v, w]))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::render::{Bounds, DynamicSurface, SurfaceOptions};
    use crate::shapes::icosphere;

    #[test]
    fn the_front_of_a_sphere_has_its_curvature_and_beside_it_there_is_none() {
        let (positions, triangles) = icosphere(10);
        let centre = DVec3::new(5.0, 0.0, 0.0);
        let positions: Vec<DVec3> = positions.iter().map(|p| 2.0 * *p + centre).collect();
        let topology = crate::mesh::Topology::from_triangles(positions.len(), &triangles);
        let topology = topology.expect("a sphere");
        let faces: Vec<_> = topology.faces().collect();
        let surface = DynamicSurface::new(&topology, &faces, &SurfaceOptions::default());
        let scene = Scene {
            centre,
            bounds: Bounds::of(positions.iter().copied()).expect("a box"),
            surfaces: vec![Arc::new(surface.evaluate(&positions, centre, true, None))],
            overlays: Vec::new(),
        };
        let eye = centre + DVec3::new(0.3, 0.2, 10.0);
        let value = |mode, from, to| value_on_line(&scene, mode, from, to);
        let mean = value(ViewMode::Mean, eye, DVec3::NEG_Z).expect("a hit");
        assert!((mean + 0.5).abs() < 0.05, "{mean}");
        let point = point_on_line(&scene, eye, DVec3::NEG_Z).expect("a hit");
        let radius = point.distance(centre);
        assert!((radius - 2.0).abs() < 0.05 && point.z > 0.0, "{point}");
        assert_eq!(point_on_line(&scene, eye, DVec3::Z), None);
        let gauss = value(ViewMode::Gauss, eye, DVec3::NEG_Z).expect("a hit");
        assert!((gauss - 0.25).abs() < 0.05, "{gauss}");
        assert_eq!(value(ViewMode::Mean, eye, DVec3::Z), None, "behind the eye");
        let beside = eye + 3.0 * DVec3::X;
        assert_eq!(value(ViewMode::Mean, beside, DVec3::NEG_Z), None);
        assert_eq!(
            value(ViewMode::Deviation, eye, DVec3::NEG_Z),
            None,
            "unknown"
        );
    }
}
