//! The value of a colour map at a point of the picture.

use rayon::prelude::*;

use super::{Geometry, Scene, ViewMode};
use crate::mesh::DVec3;

/// The number shown where a line of sight first meets a surface; `None` beside all surfaces, and
/// where the number is unknown.
pub fn value_on_line(
    scene: &Scene,
    mode: ViewMode,
    origin: DVec3,
    direction: DVec3,
) -> Option<f64> {
    let start = origin - scene.centre;
    let nearest = |geometry: &Geometry| {
        let hit = |t: &[u32; 3]| {
            let corners = t.map(|v| {
                let p = geometry.vertices[v as usize].position;
                DVec3::from_array(p.map(f64::from))
            });
            meet(corners, start, direction).map(|(depth, weights)| (depth, *t, weights))
        };
        let hits = geometry.triangles.par_iter().filter_map(hit);
        let hit = hits.min_by(|a, b| a.0.total_cmp(&b.0));
        hit.map(|(depth, t, weights)| {
            let at = |k: usize| mode.value(&geometry.vertices[t[k] as usize]);
            let values = at(0).zip(at(1)).zip(at(2));
            let value = values.map(|((a, b), c)| {
                let [u, v, w] = weights;
                u * f64::from(a) + v * f64::from(b) + w * f64::from(c)
            });
            (depth, value)
        })
    };
    let hits = scene.surfaces.iter().filter_map(|s| nearest(s));
    hits.min_by(|a, b| a.0.total_cmp(&b.0))?.1
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
