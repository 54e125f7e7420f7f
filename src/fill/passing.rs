//! Parts of the mesh that pass through a hole, such as the shaft through the opening of a bearing.

use crate::fill::assemble::appended_triangles;
use crate::fill::hole::HoleRims;
use crate::fill::self_intersection::{Obstacles, intersecting_pairs};
use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, Mesh, sides, vector_area};
use crate::patch::Patch;

/// How far a part that passes through a hole reaches beyond the plane of the rim, on either side, in radii of the
/// hole. A surface that avoids it would be no surface over the hole any more.
const BEYOND: f64 = 0.3;
/// Maximum number of intersecting pairs of triangles that are looked at.
const MAX_PAIRS: usize = 1000;

/// A place where a part of the mesh that is not connected with the rim near the hole passes through a patch over
/// it. Every patch near this one intersects that part. `None` if there is none, and for several rims.
pub(super) fn passing_part(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    patch: &Patch,
) -> Option<DVec3> {
    let [rim] = &rims.geometry.rims[..] else {
        return None;
    };
    let new = patch.new_points();
    let own = (&rims.vertices[..], &patch.triangles[..], new.len());
    let own = appended_triangles(mesh.vertex_count(), [own]);
    let radius = rims.radius();
    let (all, pairs) = intersecting_pairs(mesh, obstacles, &own, &[], new, radius, MAX_PAIRS);
    let own = own.len();
    if pairs.is_empty() {
        return None;
    }
    // the connected parts of the mesh near the hole
    let mut part: Vec<u32> = (0..all.points.len() as u32).collect();
    for [a, b] in all.triangles[own..].iter().flat_map(|&t| sides(t)) {
        unite(&mut part, a, b);
    }
    let part: Vec<u32> = (0..part.len() as u32).map(|v| find(&mut part, v)).collect();
    let normal = vector_area(&rim.points).normalize_or_zero();
    let middle = rim.points.iter().sum::<DVec3>() / rim.points.len() as f64;
    let mut reach = vec![[0.0_f64; 2]; all.points.len()];
    for (point, &part) in all.points.iter().zip(&part) {
        let height = (*point - middle).dot(normal) / radius;
        let [below, above] = &mut reach[part as usize];
        (*below, *above) = (below.max(-height), above.max(height));
    }
    let rim_vertices = rims.vertices.iter().filter_map(|v| all.number(v.0));
    let of_rim: Vec<u32> = rim_vertices.map(|v| part[v as usize]).collect();
    let passes = |f: &u32| {
        let part = part[all.triangles[*f as usize][0] as usize];
        let [below, above] = reach[part as usize];
        below.min(above) >= BEYOND && !of_rim.contains(&part)
    };
    let mut others = pairs.into_iter().flatten().filter(|&f| f as usize >= own);
    Some(all.centroid(others.find(passes)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::hole::HoleRims;
    use crate::mesh::boundary_loops;
    use crate::patch::{PatchOptions, fill};
    use crate::shapes;
    use crate::warning::Warning;

    /// A sphere without a cap of radius 0.6 at height 0.8, and a thin ellipsoid from one height to another on its axis.
    fn with_rod(from: f64, to: f64) -> Mesh {
        let (mut positions, mut triangles) =
            shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.8);
        let (first, half) = (positions.len() as u32, 0.5 * (to - from));
        let (rod, faces) = shapes::ellipsoid([0.1, 0.1, half], 200, 1);
        positions.extend(rod.iter().map(|p| *p + DVec3::Z * (from + half)));
        triangles.extend(faces.iter().map(|t| t.map(|v| first + v)));
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    fn place_of(mesh: &Mesh) -> Option<DVec3> {
        let loops = boundary_loops(mesh);
        let rims = HoleRims::new(mesh, &[&loops[0]]);
        let patch = fill(&rims.geometry.rims[0], PatchOptions::default()).expect("a patch");
        passing_part(mesh, &Obstacles::new(1), &rims, &patch)
    }

    #[test]
    fn a_part_passes_if_it_is_long_on_both_sides() {
        let at = place_of(&with_rod(0.2, 1.6)).expect("a rod passes");
        assert!(at.truncate().length() < 0.11 && at.z > 0.7, "{at}");
        // beside the hole, on one side of the rim, or short on one side
        for (from, to) in [(-0.5, 0.5), (1.5, 2.5), (0.2, 0.9), (0.9, 1.6)] {
            assert_eq!(place_of(&with_rod(from, to)), None, "{from} to {to}");
        }
    }

    /// Moving, turning and scaling all points changes nothing.
    #[test]
    fn it_is_invariant() {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
        for (from, to) in [(0.2, 1.6), (0.2, 0.9)] {
            let mut mesh = with_rod(from, to);
            let before = place_of(&mesh);
            let moved = |p: DVec3| 7.0 * (turn * p) + DVec3::new(5.0, -3.0, 2.0);
            for p in &mut mesh.positions {
                *p = moved(*p);
            }
            let after = place_of(&mesh);
            let distance = before.zip(after).map(|(p, q)| moved(p).distance(q));
            assert_eq!(before.is_some(), after.is_some());
            assert!(distance.is_none_or(|d| d < 3.0), "{distance:?}");
        }
    }

    /// A rod through the hole of a sphere: no surface over the hole avoids it, and searching one takes long.
    #[test]
    fn a_part_that_passes_through_a_hole_is_reported() {
        let mesh = with_rod(0.0, 2.0);
        let filled = crate::Fill::new(&mesh).run().expect("filled");
        let codes: Vec<&str> = filled.holes[0].warnings.iter().map(Warning::code).collect();
        assert_eq!(codes, ["self-intersection", "passed-through"]);
    }
}
