//! Cracks around a part: two loops that face each other are joined by one patch.

use crate::fill::assemble::appended_triangles;
use crate::fill::defects::{Room, defects};
use crate::fill::hole::HoleRims;
use crate::fill::rim::RimSet;
use crate::fill::self_intersection::Obstacles;
use crate::mesh::{BoundaryLoop, DVec3, Mesh, bounds, boxes_overlap};
use crate::patch;

/// The rim sets, with one for the two sides of each crack instead of one for each side. The strip between
/// the sides must be sound; patches over each side alone would cross each other.
pub(super) fn with_joined_cracks<'a>(mesh: &Mesh, rim_sets: &[RimSet<'a>]) -> Vec<RimSet<'a>> {
    let mut sets = rim_sets.to_vec();
    let single = |set: &RimSet<'a>| match set[..] {
        [rim] => Some(rim),
        _ => None,
    };
    let mut sides: Vec<(usize, Side<'a>)> = (sets.iter().enumerate())
        .filter_map(|(k, set)| Some((k, Side::new(mesh, single(set)?))))
        .collect();
    // in order of their low ends, so that few pairs are compared
    sides.sort_by(|(k, a), (l, b)| a.low.x.total_cmp(&b.low.x).then(k.cmp(l)));
    for (i, &(k, ref a)) in sides.iter().enumerate() {
        let near = sides[i + 1..].iter();
        for &(l, ref b) in near.take_while(|(_, b)| b.low.x <= a.high.x) {
            let are_single = sets[k].len() == 1 && sets[l].len() == 1;
            if are_single && a.may_face(b) && is_crack(mesh, [a.rim, b.rim]) {
                let (first, second) = (k.min(l), k.max(l));
                let other = std::mem::take(&mut sets[second]);
                sets[first].extend(other);
            }
        }
    }
    sets.retain(|set| !set.is_empty());
    sets
}

/// A loop that may be a side of a crack, in a box with an edge around it.
struct Side<'a> {
    rim: &'a BoundaryLoop,
    low: DVec3,
    high: DVec3,
}

/// Largest ratio of the lengths of the sides of a crack.
const RATIO: f64 = 1.5;

impl<'a> Side<'a> {
    fn new(mesh: &Mesh, rim: &'a BoundaryLoop) -> Self {
        let edge = rim.perimeter / rim.edges() as f64;
        let (low, high) = bounds(rim.vertices.iter().map(|&v| mesh.position(v)));
        Self {
            rim,
            low: low - edge,
            high: high + edge,
        }
    }

    fn may_face(&self, other: &Self) -> bool {
        let [a, b] = [self.rim.perimeter, other.rim.perimeter];
        a.max(b) <= RATIO * a.min(b) && boxes_overlap(self.low, self.high, other.low, other.high)
    }
}

/// Whether a sound strip joins two loops.
fn is_crack(mesh: &Mesh, loops: [&BoundaryLoop; 2]) -> bool {
    let rims = HoleRims::new(mesh, &loops);
    let Some(strip) = patch::strip(&rims.geometry) else {
        return false;
    };
    let part = (&rims.vertices[..], &strip.triangles[..], 0);
    let own = appended_triangles(mesh.vertex_count(), [part]);
    let room = Room::around(mesh, &rims, &[]);
    defects(mesh, &Obstacles::new(1), &rims, room, &own, &[], &[]).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::{FillOptions, fill_rim_sets};
    use crate::mesh::{boundary_loops, check_filled, folded_edges, self_intersections};
    use crate::shapes;

    /// A sphere that is cut apart below a height, its lower part moved down by `gap`.
    fn cut_apart(gap: f64) -> Mesh {
        let (mut positions, triangles) = shapes::icosphere(12);
        let is_low = |t: &[u32; 3]| t.iter().any(|&v| positions[v as usize].z < 0.25);
        let (low, high): (Vec<[u32; 3]>, Vec<[u32; 3]>) = triangles.iter().partition(|t| is_low(t));
        let count = positions.len() as u32;
        let moved: Vec<DVec3> = positions.iter().map(|p| *p - gap * DVec3::Z).collect();
        positions.extend(moved);
        let low = low.into_iter().map(|t| t.map(|v| v + count));
        let triangles: Vec<[u32; 3]> = high.into_iter().chain(low).collect();
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    #[test]
    fn a_crack_around_a_part_is_closed_by_a_strip() {
        // edges are 0.1 long
        let mesh = cut_apart(0.03);
        let loops = boundary_loops(&mesh);
        assert_eq!(loops.len(), 2);
        let sets: Vec<RimSet<'_>> = loops.iter().map(|l| vec![l]).collect();
        let filled = fill_rim_sets(&mesh, &sets, &FillOptions::default(), &|_, _| true);
        let filled = filled.expect("filled");
        assert_eq!(filled.holes.len(), 1);
        assert!(filled.holes[0].warnings.is_empty());
        assert_eq!(filled.mesh.vertex_count(), mesh.vertex_count());
        assert!(check_filled(&mesh, &filled.mesh, &[]).is_ok());
        assert!(boundary_loops(&filled.mesh).is_empty());
        let topology = &filled.mesh.topology;
        let triangles: Vec<[u32; 3]> = topology.triangles().collect();
        let positions = &filled.mesh.positions;
        let crossing = self_intersections(positions, &triangles, None, usize::MAX);
        assert!(crossing.is_empty());
        assert!(folded_edges(positions, topology, 2.6).is_empty());
    }

    #[test]
    fn loops_apart_and_holes_of_a_plate_stay_holes_of_their_own() {
        let counts = |mesh: &Mesh| {
            let loops = boundary_loops(mesh);
            let sets: Vec<RimSet<'_>> = loops.iter().map(|l| vec![l]).collect();
            (sets.len(), with_joined_cracks(mesh, &sets).len())
        };
        assert_eq!(counts(&cut_apart(0.3)), (2, 2));
        // a hole through both sheets of a thin plate
        let (upper, triangles) =
            shapes::cut_where(&shapes::plane(2.0, 20, 1), |p| p.length() < 0.3);
        let count = upper.len() as u32;
        let lower = upper.iter().map(|p| *p - 0.05 * DVec3::Z);
        let positions: Vec<DVec3> = upper.iter().copied().chain(lower).collect();
        let below = triangles
            .iter()
            .map(|&[a, b, c]| [a, c, b].map(|v| v + count));
        let triangles: Vec<[u32; 3]> = triangles.iter().copied().chain(below).collect();
        let plate = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        assert_eq!(counts(&plate), (4, 4));
    }
}
