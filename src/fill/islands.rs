//! Components of the mesh inside a hole (islands): the hole's patch joins their rims too.

use crate::fill::rim::{RimSet, rim_of};
use crate::mesh::{
    BoundaryLoop, DVec3, LoopId, Mesh, TriangleBvh, closest_point_on_polygon, vector_area,
};
use crate::patch::{self, PatchOptions};

/// Maximum distance of an island from the first patch of its hole, in hole radii.
const NEAR: f64 = 0.5;
/// If the nearest point of the patch is closer to the rim than this, in hole radii, it counts as a
/// rim point, and the component is beside the hole.
const BESIDE: f64 = 1e-6;
/// Approximate number of vertices of a rim that are checked.
const SAMPLES: usize = 64;

/// The chosen loops as rim sets, with the islands in them if patches join these.
pub fn rim_sets<'a>(
    mesh: &Mesh,
    loops: &'a [BoundaryLoop],
    chosen: &[LoopId],
    islands: bool,
) -> Vec<RimSet<'a>> {
    if islands {
        with_islands(mesh, loops, chosen)
    } else {
        chosen.iter().map(|id| vec![&loops[id.index()]]).collect()
    }
}

/// The chosen loops as rim sets, each with the islands in it.
///
/// A loop of another component that lies within a hole, near its first patch, belongs to an island.
/// A loop that runs in the opposite direction of the hole is the island's outer boundary and one of
/// the rims of the hole's patch. A loop that runs in the same direction is a hole in the island; it
/// is filled too, with its own islands. A rim within several holes belongs to the smallest. Islands
/// that touch each other or the hole's rim are left aside.
pub fn with_islands<'a>(
    mesh: &Mesh,
    loops: &'a [BoundaryLoop],
    chosen: &[LoopId],
) -> Vec<RimSet<'a>> {
    let first = loops.first().map_or(0, |l| l.component);
    if loops.iter().all(|l| l.component == first) {
        return rim_sets(mesh, loops, chosen, false);
    }
    let mut holes: Vec<CandidateHole> = chosen
        .iter()
        .map(|id| CandidateHole::new(mesh, loops, id.index()))
        .collect();
    let mut kind: Vec<Option<LoopRole>> = vec![None; loops.len()];
    // holes of islands are processed in turn, each once
    let mut next = 0;
    while next < holes.len() {
        for (i, one) in loops.iter().enumerate() {
            let hole = &holes[next];
            if one.component == loops[hole.index].component || !hole.holds(mesh, one) {
                continue;
            }
            if hole.normal.dot(area(mesh, one)) < 0.0 {
                let smaller = |other: &LoopRole| match *other {
                    LoopRole::Island(h) => {
                        loops[holes[h].index].perimeter > loops[hole.index].perimeter
                    }
                    LoopRole::Hole => true,
                };
                if kind[i].as_ref().is_none_or(smaller) {
                    kind[i] = Some(LoopRole::Island(next));
                }
            } else if kind[i].is_none() && !holes.iter().any(|h| h.index == i) {
                kind[i] = Some(LoopRole::Hole);
            }
        }
        next += 1;
        if next == holes.len() {
            let opened = |i: usize| holes.iter().any(|h| h.index == i);
            let is_island = |component: u32| {
                let outer = |k: &Option<LoopRole>| matches!(k, Some(LoopRole::Island(_)));
                loops
                    .iter()
                    .zip(&kind)
                    .any(|(l, k)| l.component == component && outer(k))
            };
            let more: Vec<usize> = (0..loops.len())
                .filter(|&i| matches!(kind[i], Some(LoopRole::Hole)) && !opened(i))
                .filter(|&i| is_island(loops[i].component))
                .collect();
            holes.extend(more.into_iter().map(|i| CandidateHole::new(mesh, loops, i)));
        }
    }
    let is_island = |i: usize| matches!(kind[i], Some(LoopRole::Island(_)));
    let mut sets = Vec::new();
    for (h, hole) in holes.iter().enumerate() {
        if is_island(hole.index) {
            continue;
        }
        let mut rim_set = vec![&loops[hole.index]];
        let mine = |i: &usize| matches!(kind[*i], Some(LoopRole::Island(owner)) if owner == h);
        rim_set.extend((0..loops.len()).filter(mine).map(|i| &loops[i]));
        sets.push(without_touching(mesh, rim_set));
    }
    sets
}

/// The rims of a hole, the first, without the islands that have a point in common with another of
/// the rims: no patch joins these.
fn without_touching<'a>(mesh: &Mesh, rims: RimSet<'a>) -> RimSet<'a> {
    let mut all: Vec<([u64; 3], usize)> = Vec::new();
    for (r, rim) in rims.iter().enumerate() {
        // adding 0.0 turns -0.0 into 0.0
        let key = |&v| {
            (mesh.position(v) + DVec3::ZERO)
                .to_array()
                .map(f64::to_bits)
        };
        all.extend(rim.vertices.iter().map(|v| (key(v), r)));
    }
    all.sort_unstable();
    all.dedup();
    let mut touches = vec![false; rims.len()];
    for same in all
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() > 1)
    {
        for &(_, r) in same {
            touches[r] = true;
        }
    }
    let kept = rims.into_iter().zip(touches).enumerate();
    kept.filter(|&(r, (_, touches))| r == 0 || !touches)
        .map(|(_, (rim, _))| rim)
        .collect()
}

/// The role of a loop within a hole.
#[derive(Clone, Copy, Debug)]
enum LoopRole {
    /// The outer boundary of an island in the hole of that number.
    Island(usize),
    /// A hole in an island.
    Hole,
}

/// A hole that may contain islands, with a coarse first patch.
struct CandidateHole {
    index: usize,
    normal: DVec3,
    radius: f64,
    rim: Vec<DVec3>,
    patch: Option<TriangleBvh>,
}

impl CandidateHole {
    fn new(mesh: &Mesh, loops: &[BoundaryLoop], index: usize) -> Self {
        let one = &loops[index];
        let patch = patch::fill(&rim_of(mesh, one), PatchOptions { density: 0.5 });
        Self {
            index,
            normal: area(mesh, one),
            radius: one.radius,
            rim: one.vertices.iter().map(|&v| mesh.position(v)).collect(),
            patch: patch
                .ok()
                .map(|p| TriangleBvh::new(&p.points, &p.triangles)),
        }
    }

    /// Whether the loop lies over the interior of the hole.
    fn holds(&self, mesh: &Mesh, one: &BoundaryLoop) -> bool {
        let Some(patch) = &self.patch else {
            return false;
        };
        let step = one.vertices.len().div_ceil(SAMPLES);
        one.vertices.iter().step_by(step).all(|&v| {
            let nearest = patch.closest_point(mesh.position(v));
            nearest.is_some_and(|c| {
                c.distance < NEAR * self.radius
                    && closest_point_on_polygon(c.point, &self.rim).distance(c.point)
                        > BESIDE * self.radius
            })
        })
    }
}

/// Vector area of a loop, along the normal of a patch over it.
fn area(mesh: &Mesh, one: &BoundaryLoop) -> DVec3 {
    let points: Vec<DVec3> = one.vertices.iter().map(|&v| mesh.position(v)).collect();
    vector_area(&points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{FillOptions, fill_rim_sets};
    use crate::mesh::{boundary_loops, check_filled, components, erase};
    use crate::shapes;

    /// A unit sphere with a wide hole at its top. The faces selected by `stays` form islands in the
    /// hole.
    fn islands(stays: impl Fn(DVec3) -> bool) -> Mesh {
        let (positions, triangles) = shapes::sphere(3000, 7);
        let ball = Mesh::from_triangles(positions, &triangles).expect("closed");
        let selected: Vec<bool> = (0..ball.face_count())
            .map(|f| ball.corners(f.into()).iter().sum::<DVec3>() / 3.0)
            .map(|middle| middle.z > 0.5 && !stays(middle))
            .collect();
        erase(&ball, &selected).mesh
    }

    fn filled(mesh: &Mesh) -> (Vec<usize>, f64) {
        let loops = boundary_loops(mesh);
        let hole = loops
            .iter()
            .max_by(|a, b| a.perimeter.total_cmp(&b.perimeter))
            .expect("a hole");
        let rim_sets = with_islands(mesh, &loops, &[hole.id]);
        let result = fill_rim_sets(mesh, &rim_sets, &FillOptions::default(), &|_, _| true);
        let result = result.expect("filled");
        assert!(result.complete());
        check_filled(mesh, &result.mesh, &[]).expect("closed");
        assert_eq!(components(&result.mesh.topology).count, 1);
        let new = &result.mesh.positions[mesh.vertex_count()..];
        let off = new.iter().map(|p| (p.length() - 1.0).abs());
        (
            rim_sets.iter().map(Vec::len).collect(),
            off.fold(0.0, f64::max),
        )
    }

    #[test]
    fn patches_pass_through_islands() {
        let at = |x: f64, y: f64| DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
        let mesh = islands(|p| p.distance(at(0.2, 0.1)) < 0.2 || p.distance(at(-0.4, -0.2)) < 0.12);
        let (rim_sets, off) = filled(&mesh);
        assert_eq!(rim_sets, [3]);
        assert!(off < 5e-3, "{off}");
    }

    #[test]
    fn rings_are_filled_inside_and_out() {
        let mesh = islands(|p| (0.25..0.4).contains(&p.x.hypot(p.y)));
        let (mut rim_sets, off) = filled(&mesh);
        rim_sets.sort_unstable();
        assert_eq!(rim_sets, [1, 2]);
        assert!(off < 5e-3, "{off}");
    }

    #[test]
    fn what_lies_beside_or_far_away_is_no_island() {
        let mut shape = shapes::cut_where(&shapes::sphere(2000, 7), |p| p.z > 0.7);
        let first = shape.0.len() as u32;
        for lift in [DVec3::new(1.6, 0.0, 1.0), 2.5 * DVec3::Z] {
            let (positions, triangles) = shapes::plane(0.2, 4, 1);
            let start = shape.0.len() as u32;
            shape.0.extend(positions.iter().map(|&p| p + lift));
            shape
                .1
                .extend(triangles.iter().map(|t| t.map(|v| v + start)));
        }
        assert!(shape.0.len() as u32 > first);
        let mesh = Mesh::from_triangles(shape.0, &shape.1).expect("manifold");
        let loops = boundary_loops(&mesh);
        assert_eq!(loops.len(), 3);
        let rim_sets = with_islands(&mesh, &loops, &[LoopId::FIRST]);
        assert_eq!(rim_sets.iter().map(Vec::len).collect::<Vec<_>>(), [1]);
    }
}
