//! Holes that are filled without islands in them, because no sound patch joins these.

use rayon::prelude::*;

use crate::fill::assemble::appended_triangles;
use crate::fill::defects::{Room, defects, severity};
use crate::fill::hole::{DraftHole, HoleRims};
use crate::fill::options::FillOptions;
use crate::fill::repair::repaired;
use crate::fill::self_intersection::Obstacles;
use crate::mesh::{BoundaryLoop, LoopId, Mesh};
use crate::patch::{Patch, PatchError};
use crate::warning::{Warning, WhyLeft};

/// A hole without the islands for which no first patch can be made.
pub(super) fn without_misfits(
    mesh: &Mesh,
    mut draft: DraftHole,
    options: &FillOptions,
) -> DraftHole {
    while let Err(error) = &draft.patch
        && draft.rims.is_blend()
    {
        let (misfit, why) = match error {
            PatchError::InsideOut { rim } => (Some(*rim), WhyLeft::InsideOut),
            PatchError::OneSided { rim } => (Some(*rim), WhyLeft::OneSided),
            _ => (None, WhyLeft::NoPatch),
        };
        let is_left = |k: usize| match misfit {
            Some(misfit) if misfit > 0 => k == misfit,
            _ => k > 0,
        };
        draft = without(mesh, &draft, is_left, why, options);
    }
    draft
}

/// Triangles of a start surface for each pair of intersecting triangles and each folded edge, so that a flow may
/// remove them.
const FEW: usize = 16;

/// Leaves islands aside in holes whose start surfaces have [more than a few](FEW) defects or some that no local
/// repair removes: a flow from such a surface seldom ends at a sound one.
pub(super) fn without_unsound(mesh: &Mesh, drafts: &mut [DraftHole], options: &FillOptions) {
    let obstacles = Obstacles::new(drafts.len());
    let blends = drafts.par_iter_mut().filter(|draft| draft.rims.is_blend());
    blends.for_each(|draft| {
        let is_bad = |patch: &Patch| is_beyond_repair(mesh, &obstacles, &draft.rims, patch);
        if draft.patch.as_ref().is_ok_and(is_bad) {
            let alone = without(mesh, draft, |k| k > 0, WhyLeft::Unsound, options);
            if alone.patch.is_ok() {
                *draft = alone;
            }
        }
    });
}

fn is_beyond_repair(mesh: &Mesh, obstacles: &Obstacles, rims: &HoleRims, patch: &Patch) -> bool {
    let new = patch.new_points();
    let part = (&rims.vertices[..], &patch.triangles[..], new.len());
    let own = appended_triangles(mesh.vertex_count(), [part]);
    let room = Room::around(mesh, rims, &[]);
    let found = defects(mesh, obstacles, rims, room, &own, &[], new);
    let [pairs, _, folds] = severity(found);
    let is_repaired = || repaired(mesh, obstacles, rims, patch, &[], &[]).is_some();
    pairs + folds > 0 && (FEW * (pairs + folds) > own.len() || !is_repaired())
}

/// A hole without some of its islands, and a warning that names them.
fn without(
    mesh: &Mesh,
    draft: &DraftHole,
    is_left: impl Fn(usize) -> bool,
    why: WhyLeft,
    options: &FillOptions,
) -> DraftHole {
    let numbered = || draft.rims.loops.iter().enumerate();
    let kept: Vec<&BoundaryLoop> = numbered().filter(|r| !is_left(r.0)).map(|r| r.1).collect();
    let islands: Vec<LoopId> = numbered()
        .filter(|r| is_left(r.0))
        .map(|r| r.1.id)
        .collect();
    let mut next = DraftHole::new(HoleRims::new(mesh, &kept), options);
    next.patch_ms += draft.patch_ms;
    next.warnings = draft.warnings.clone();
    next.warnings.push(Warning::IslandsLeft { islands, why });
    next
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{Filled, FilledHole, fill_rim_sets};
    use crate::mesh::{DVec3, VertexId, boundary_loops, erase, self_intersections};
    use crate::shapes;

    /// A unit sphere without the part above z = 0.7, but with an island at its top.
    fn with_island() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (positions, triangles) = shapes::sphere(1500, 7);
        let ball = Mesh::from_triangles(positions, &triangles).expect("closed");
        let height = |f: usize| ball.corners(f.into()).iter().map(|p| p.z).sum::<f64>() / 3.0;
        let selected = (0..ball.face_count()).map(|f| (0.7..0.95).contains(&height(f)));
        let rest = erase(&ball, &selected.collect::<Vec<bool>>()).mesh;
        let triangles = rest.topology.triangles().collect();
        (rest.positions, triangles)
    }

    /// The rims of the hole and of the island, whose vertices lie on the unit sphere.
    fn rims(loops: &[BoundaryLoop], mesh: &Mesh) -> [LoopId; 2] {
        let is_on_sphere = |v: &VertexId| (mesh.position(*v).length() - 1.0).abs() < 1e-9;
        let of_sphere = loops.iter().filter(|l| l.vertices.iter().all(is_on_sphere));
        let mut of_sphere: Vec<&BoundaryLoop> = of_sphere.collect();
        of_sphere.sort_by(|a, b| b.radius.total_cmp(&a.radius));
        let [hole, island] = of_sphere[..] else {
            panic!("{} rims", of_sphere.len())
        };
        [hole.id, island.id]
    }

    /// The fill of the hole with the island.
    fn filled(mesh: &Mesh, leaves_islands: bool) -> Filled {
        let loops = boundary_loops(mesh);
        let set = rims(&loops, mesh).map(|id| &loops[id.index()]).to_vec();
        let options = FillOptions {
            leaves_islands,
            ..FillOptions::default()
        };
        fill_rim_sets(mesh, &[set], &options, &|_, _| true).expect("a manifold")
    }

    /// Whether a fill of the hole alone has a warning that names the island.
    fn has_left(mesh: &Mesh, filled: &Filled, why: WhyLeft) -> bool {
        let [hole, island] = rims(&boundary_loops(mesh), mesh);
        let islands = vec![island];
        let warning = Warning::IslandsLeft { islands, why };
        let of_hole = |one: &FilledHole| one.loops == [hole] && one.warnings.contains(&warning);
        filled.holes.iter().any(of_hole)
    }

    #[test]
    fn an_island_of_opposite_orientation_is_left_aside() {
        let (positions, mut triangles) = with_island();
        for t in &mut triangles {
            if positions[t[0] as usize].z > 0.9 {
                t.swap(1, 2);
            }
        }
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        let without = filled(&mesh, true);
        assert!(has_left(&mesh, &without, WhyLeft::InsideOut));
        assert_eq!(boundary_loops(&without.mesh).len(), 1);
        assert!(!has_left(&mesh, &filled(&mesh, false), WhyLeft::InsideOut));
    }

    #[test]
    fn an_island_behind_a_wall_is_left_aside() {
        let (mut positions, mut triangles) = with_island();
        // a wall around the island, above the rim of the hole
        let (first, n) = (positions.len() as u32, 40);
        for k in 0..n {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
            let at = |z: f64| DVec3::new(0.5 * cosine, 0.5 * sine, z);
            positions.extend([at(0.77), at(1.4)]);
            let [a, b] = [k, (k + 1) % n].map(|k| first + 2 * k);
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        let crossings = |filled: &Filled| {
            let faces: Vec<[u32; 3]> = filled.mesh.topology.triangles().collect();
            self_intersections(&filled.mesh.positions, &faces, None, usize::MAX).len()
        };
        let without = filled(&mesh, true);
        assert!(has_left(&mesh, &without, WhyLeft::Unsound));
        assert_eq!(crossings(&without), 0);
        assert!(crossings(&filled(&mesh, false)) > 0);
    }
}
