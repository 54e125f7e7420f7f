//! Defects of patches: triangles that cross others or have no area, folded edges, and vertices far from
//! the rim.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use crate::fill::context::FillContext;
use crate::fill::hole::HoleRims;
use crate::fill::patch_topology::PatchTopology;
use crate::fill::result::FilledHole;
use crate::fill::self_intersection::{Obstacles, intersections, place};
use crate::mesh::{
    DVec3, FOLD_DEGREES, FaceId, LoopId, Mesh, Topology, bounds, boxes_overlap, dihedral_angle,
    self_intersections,
};
use crate::warning::{MAX_PAIRS, Warning};

/// Cosine of [`FOLD_DEGREES`], beyond which the edge of two neighbours counts as
/// folded.
pub(super) const FOLDED: f64 = -0.866_025_403_784_438_6;

/// Maximum number of pairs of intersecting triangles that are counted. More than warnings state, so that searches see which of
/// two bad patches is better.
const MAX_CROSSINGS: usize = 10 * MAX_PAIRS;

/// What is wrong with a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Defects {
    /// Pairs of triangles that cross, [`MAX_CROSSINGS`] at most, and one of the places.
    pub crossings: Option<(usize, DVec3)>,
    /// New vertices outside the [`Room`] of the hole, and one of the places.
    pub escaped: Option<(usize, DVec3)>,
    /// Folded edges and triangles without area, and one of the places.
    pub folds: Option<(usize, DVec3)>,
}

impl Defects {
    /// How bad they are: crossings first, then vertices that escaped, then folds.
    pub fn severity(&self) -> [usize; 3] {
        let all = [self.crossings, self.escaped, self.folds];
        all.map(|found| found.map_or(0, |found| found.0))
    }

    /// The warnings of a result that has these defects.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        let crossing = self.crossings.map(|(pairs, at)| Warning::SelfIntersection {
            pairs: pairs.min(MAX_PAIRS),
            at,
            kept_step: None,
        });
        let escape = |(vertices, at)| Warning::Escaped { vertices, at };
        let fold = |(edges, at)| Warning::Folded { edges, at };
        let others = [self.escaped.map(escape), self.folds.map(fold)];
        crossing.into_iter().chain(others.into_iter().flatten())
    }
}

/// The severity of no defects.
pub(super) const SOUND: [usize; 3] = [0; 3];

/// A cube about a hole that a patch should not leave. Its centre is that of the box of the rims and the
/// faces around them, and its edges are twice the diagonal of that box. The complement of a cap of a
/// sphere fits into it while the cap is a ninth of the sphere or more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    low: DVec3,
    high: DVec3,
}

impl Room {
    pub fn around(mesh: &Mesh, rims: &HoleRims, support: &[FaceId]) -> Self {
        let faces = support.iter().flat_map(|&f| mesh.topology.face_vertices(f));
        let points = faces.chain(rims.vertices.iter().copied());
        let (low, high) = bounds(points.map(|v| mesh.position(v)));
        let (centre, reach) = (low.midpoint(high), low.distance(high));
        Self {
            low: centre - reach,
            high: centre + reach,
        }
    }

    fn contains(&self, p: DVec3) -> bool {
        self.low.cmple(p).all() && p.cmple(self.high).all()
    }
}

/// Places of the new vertices of `triangles` outside a room.
fn escaped(mesh: &Mesh, room: Room, triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<DVec3> {
    let first = mesh.vertex_count() as u32;
    let new: BTreeSet<u32> = triangles
        .iter()
        .flatten()
        .copied()
        .filter(|&v| v >= first)
        .collect();
    let places = new.into_iter().map(|v| place(mesh, positions, v));
    places.filter(|&p| !room.contains(p)).collect()
}

/// The patches of a group, each with a box around it, and those without new vertices, which are in no
/// group.
pub(super) struct Patches {
    triangles: Vec<[u32; 3]>,
    /// End of each patch in `triangles`.
    ends: Vec<usize>,
    boxes: Vec<(DVec3, DVec3)>,
    loose: Vec<[u32; 3]>,
}

/// What the box of a patch exceeds it by, relative to the coordinates: more than their rounding.
const ROOM: f64 = 1e-9;

impl Patches {
    pub fn new(
        context: FillContext<'_>,
        group: usize,
        topology: &PatchTopology,
        positions: &[DVec3],
    ) -> Self {
        let counts = topology.holes.iter().map(|hole| hole.triangles.len());
        let mut end = 0;
        let ends = counts.map(|count| {
            end += count;
            end
        });
        let mut patches = Self {
            triangles: context.patch_triangles(group, topology),
            ends: ends.collect(),
            boxes: vec![(DVec3::ZERO, DVec3::ZERO); topology.holes.len()],
            loose: context.plan.loose_triangles().collect(),
        };
        for k in 0..patches.boxes.len() {
            patches.boxes[k] = patches.around(context.mesh, k, positions);
        }
        patches
    }

    /// The triangles of a patch.
    pub fn of(&self, k: usize) -> &[[u32; 3]] {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.triangles[begin..self.ends[k]]
    }

    /// The box around a patch with new vertices at `positions`.
    fn around(&self, mesh: &Mesh, k: usize, positions: &[DVec3]) -> (DVec3, DVec3) {
        let points = self.of(k).iter().flatten();
        let (low, high) = bounds(points.map(|&v| place(mesh, positions, v)));
        let room = ROOM * low.abs().max(high.abs());
        (low - room, high + room)
    }

    /// The triangles of the other patches whose boxes overlap that of a patch with new vertices at
    /// `positions`, and the triangles without new vertices that do.
    pub fn near(&self, mesh: &Mesh, k: usize, positions: &[DVec3]) -> Vec<[u32; 3]> {
        let (low, high) = self.around(mesh, k, positions);
        let is_near = |j: &usize| {
            let (other_low, other_high) = self.boxes[*j];
            *j != k && boxes_overlap(low, high, other_low, other_high)
        };
        let near = (0..self.boxes.len()).filter(is_near);
        let near = near.flat_map(|j| self.of(j));
        let loose = self.loose.iter().filter(|t| {
            let (other_low, other_high) = bounds(t.iter().map(|&v| place(mesh, positions, v)));
            boxes_overlap(low, high, other_low, other_high)
        });
        near.chain(loose).copied().collect()
    }
}

/// The severity of the defects of a patch.
pub(super) fn severity(defects: Option<Defects>) -> [usize; 3] {
    defects.map_or(SOUND, |defects| defects.severity())
}

/// The defects of a patch in `room` of the triangles `own` beside those of `others`, both
/// [appended](super::assemble::appended_triangles) to the mesh with new vertices at `positions`; `None` if it is
/// sound.
pub(super) fn defects(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    room: Room,
    own: &[[u32; 3]],
    others: &[[u32; 3]],
    positions: &[DVec3],
) -> Option<Defects> {
    let counted = |places: Vec<DVec3>| places.first().map(|&at| (places.len(), at));
    let crossings = intersections(mesh, obstacles, own, others, positions, MAX_CROSSINGS);
    let found = Defects {
        crossings: counted(crossings),
        escaped: counted(escaped(mesh, room, own, positions)),
        folds: counted(folds(mesh, rims, own, others, positions)),
    };
    (found.severity() != SOUND).then_some(found)
}

/// Places of folded edges of a patch and of its triangles without area. The edges of the rims and those where
/// the other parts of the hole begin are included.
fn folds(
    mesh: &Mesh,
    rims: &HoleRims,
    triangles: &[[u32; 3]],
    others: &[[u32; 3]],
    positions: &[DVec3],
) -> Vec<DVec3> {
    let corners = |t: [u32; 3]| t.map(|v| place(mesh, positions, v));
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    // unit normal of the face to the left of each directed edge
    let mut left: FxHashMap<[u32; 2], DVec3> = FxHashMap::default();
    let topology = &mesh.topology;
    for rim in &rims.loops {
        // not the half-edges of the loop: those at which a part of a hole has a crease are not among them
        for [start, end] in rim.edge_ends() {
            let beside = topology
                .outgoing(end)
                .find(|&h| topology.target(h) == start);
            if let Some(h) = beside.filter(|&h| !topology.is_boundary(h)) {
                let t = topology.face_vertices(topology.face(h));
                left.insert([end.0, start.0], normal(corners(t.map(|v| v.0))));
            }
        }
    }
    let mut found = Vec::new();
    for &t in triangles {
        let normal = normal(corners(t));
        if normal == DVec3::ZERO {
            found.push(corners(t).iter().sum::<DVec3>() / 3.0);
        }
        for k in 0..3 {
            left.insert([t[k], t[(k + 1) % 3]], normal);
        }
    }
    for &t in others {
        for k in 0..3 {
            let edge = [t[k], t[(k + 1) % 3]];
            left.entry(edge).or_insert_with(|| normal(corners(t)));
        }
    }
    let mut folded = BTreeSet::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let (Some(own), Some(other)) = (left.get(&[a, b]), left.get(&[b, a])) else {
                continue;
            };
            if own.dot(*other) < FOLDED {
                folded.insert([a.min(b), a.max(b)]);
            }
        }
    }
    let middle = |[a, b]: [u32; 2]| place(mesh, positions, a).midpoint(place(mesh, positions, b));
    found.extend(folded.into_iter().map(middle));
    found
}

/// Warnings about the holes whose patches cross, or are folded onto, one of another group or one
/// without new vertices. Each group itself is checked at the end of its flow. `topology` and
/// `positions` are those of the filled mesh.
pub(super) fn defects_between_groups(
    topology: &Topology,
    positions: &[DVec3],
    holes: &[FilledHole],
) -> Vec<(LoopId, Warning)> {
    let Some((group, first)) = holes.first().map(|hole| (hole.group, hole.faces.start)) else {
        return Vec::new();
    };
    if group.is_some() && holes.iter().all(|hole| hole.group == group) {
        return Vec::new();
    }
    let faces: Vec<[u32; 3]> = topology.triangles().skip(first).collect();
    let hole_of = |face: usize| holes.partition_point(|hole| hole.faces.end <= face);
    let are_solved_together = |[h, k]: [usize; 2]| {
        h == k || (holes[h].group.is_some() && holes[h].group == holes[k].group)
    };
    let mut crossings = BTreeMap::new();
    for pair in self_intersections(positions, &faces, None, usize::MAX) {
        let between = pair.map(|f| hole_of(first + f as usize));
        if !are_solved_together(between) {
            let corners = pair.map(|f| faces[f as usize].map(|v| positions[v as usize]));
            let at = corners.iter().flatten().sum::<DVec3>() / 6.0;
            count(&mut crossings, between, at);
        }
    }
    // parts of a hole may be in different groups
    let mut folds = BTreeMap::new();
    for face in first..topology.face_count() {
        for h in topology.face_halfedges(FaceId::from(face)) {
            if topology.is_boundary_edge(h) {
                continue;
            }
            // each edge between patches once
            let other = topology.face(h.twin()).index();
            let between = [face, other].map(hole_of);
            if other < face || are_solved_together(between) {
                continue;
            }
            if dihedral_angle(positions, topology, h) >= FOLD_DEGREES.to_radians() {
                let [start, end] = [topology.origin(h), topology.target(h)];
                let middle = positions[start.index()].midpoint(positions[end.index()]);
                count(&mut folds, between, middle);
            }
        }
    }
    let crossing = |(h, (pairs, at)): (usize, (usize, DVec3))| {
        let pairs = pairs.min(MAX_PAIRS);
        let kept_step = None;
        let warning = Warning::SelfIntersection {
            pairs,
            at,
            kept_step,
        };
        (holes[h].id(), warning)
    };
    let fold =
        |(h, (edges, at)): (usize, (usize, DVec3))| (holes[h].id(), Warning::Folded { edges, at });
    let crossings = crossings.into_iter().map(crossing);
    crossings.chain(folds.into_iter().map(fold)).collect()
}

/// Counts a defect between two patches for both, by hole with the place of the first.
fn count(found: &mut BTreeMap<usize, (usize, DVec3)>, holes: [usize; 2], at: DVec3) {
    for hole in holes {
        found.entry(hole).or_insert((0, at)).0 += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::prepare::prepare;
    use crate::fill::{FillOptions, RimSet, fill_rim_sets};
    use crate::mesh::boundary_loops;
    use crate::shapes;

    fn cap() -> Mesh {
        let (positions, triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.8);
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    #[test]
    fn crossings_escapes_folds_and_triangles_without_area_are_found() {
        let mesh = cap();
        let loops = boundary_loops(&mesh);
        let plan = prepare(&mesh, &[vec![&loops[0]]], &[], &FillOptions::default()).plan;
        let context = FillContext {
            mesh: &mesh,
            plan: &plan,
        };
        let topology = &plan.groups[0].topology;
        let start = plan.start_positions(&mesh, 0);
        let rims = &plan.holes()[0].rims;
        let room = Room::around(&mesh, rims, &plan.groups[0].support[0]);
        let own = context.patch_triangles(0, topology);
        let defects =
            |positions: &[DVec3]| defects(&mesh, &plan.obstacles, rims, room, &own, &[], positions);
        assert_eq!(defects(&start), None);
        // a vertex pulled through the opposite side of the sphere
        let mut crossing = start.clone();
        crossing[0] = DVec3::new(0.1, 0.2, -2.0);
        let found = defects(&crossing).expect("defects");
        assert!(found.crossings.is_some());
        // a vertex pulled far out
        let mut far = start.clone();
        far[0] = DVec3::new(0.0, 0.0, 2.5);
        assert_eq!(defects(&far).and_then(|found| found.escaped), None);
        far[0] = DVec3::new(0.1, 0.0, 4.0);
        let found = defects(&far).expect("defects").escaped;
        assert_eq!(found, Some((1, far[0])));
        // a vertex on another one: the triangles between have no area
        let t = topology.holes[0].triangles.iter();
        let rim = plan.holes()[0].rims.vertices.len() as u32;
        let inner = t
            .copied()
            .find(|t| t.iter().all(|&v| v >= rim))
            .expect("an inner triangle");
        let mut flat = start.clone();
        flat[(inner[0] - rim) as usize] = flat[(inner[1] - rim) as usize];
        assert!(defects(&flat).expect("defects").folds.is_some());
        // a vertex reflected across its neighbours: folded edges
        let mut folded = start.clone();
        let across = folded[(inner[1] - rim) as usize].midpoint(folded[(inner[2] - rim) as usize]);
        let v = &mut folded[(inner[0] - rim) as usize];
        *v = across + 1.5 * (across - *v);
        assert!(defects(&folded).expect("defects").folds.is_some());
    }

    /// Two sheets with hills towards each other, whose tops are missing.
    #[test]
    fn patches_of_two_groups_that_cross_get_a_warning() {
        for (distance, is_crossing) in [(1.2, true), (2.5, false)] {
            let hill = |height: f64| {
                let z = move |x: f64, y: f64| height * (-3.0 * (x * x + y * y)).exp();
                shapes::cut_where(&shapes::graph(2.0, 24, z, 1), |p| {
                    p.truncate().length() < 0.5
                })
            };
            let (mut positions, mut triangles) = hill(0.9);
            let count = positions.len() as u32;
            let (above, more) = hill(-0.9);
            positions.extend(above.into_iter().map(|p| p + distance * DVec3::Z));
            triangles.extend(more.into_iter().map(|t| t.map(|v| v + count)));
            let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
            let loops = boundary_loops(&mesh);
            let holes = loops.iter().filter(|one| !one.is_outer_boundary);
            let holes: Vec<RimSet<'_>> = holes.map(|one| vec![one]).collect();
            assert_eq!(holes.len(), 2);
            let filled = fill_rim_sets(&mesh, &holes, &FillOptions::default(), &|_, _| true);
            let filled = filled.expect("filled");
            assert_eq!(filled.groups.len(), 2);
            for hole in &filled.holes {
                let codes: Vec<&str> = hole.warnings.iter().map(Warning::code).collect();
                assert_eq!(codes.contains(&"self-intersection"), is_crossing);
            }
        }
    }
}
