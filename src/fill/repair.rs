//! Local repair of a patch: near its defects, new vertices are moved, edges flipped, and edges and
//! triangles split, until no triangle crosses another one and no edge is folded. Given vertices stay.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::cancel::is_cancelled;
use crate::fill::defects::FOLDED;
use crate::fill::hole::HoleRims;
use crate::fill::self_intersection::{Obstacles, place};
use crate::mesh::{
    DVec3, Mesh, bounds, boxes_overlap, canonical_vertices, pair_meets, self_intersections, sides,
};
use crate::patch::Patch;

/// Rounds over the defective triangles and those around them.
const ROUNDS: usize = 30;
/// A repair ends after so many rounds in a row that do not lower the number of defective triangles.
const PATIENCE: usize = 8;
/// Comparisons of a triangle with one near it before a repair ends: at most some tenths of a second.
const COMPARISONS: usize = 2_000_000;
/// Comparisons in one repair of each hole: some seconds for all, also if there are thousands of holes.
const COMPARISONS_OF_ALL: usize = 40_000_000;
/// Comparisons with which most of the repairs that succeed have ended.
const FEW_COMPARISONS: usize = 20_000;
/// Distances by which a vertex is moved on trial, relative to its longest edge.
const STEPS: [f64; 6] = [1.0, 0.5, 0.25, 0.12, 0.06, 0.03];
/// Defective triangles of a patch beyond which a local repair is not tried.
const MANY: usize = 64;

/// The patch with its defects repaired beside the mesh and the triangles `others`, which have vertices of
/// the mesh and [appended](super::assemble::appended_triangles) ones at `new`. `None` if defects are
/// left, or too many of its triangles are defective.
pub(super) fn repaired(
    mesh: &Mesh,
    obstacles: &Obstacles,
    rims: &HoleRims,
    patch: &Patch,
    others: &[[u32; 3]],
    new: &[DVec3],
) -> Option<Patch> {
    let (low, high) = bounds(patch.points.iter().copied());
    let room = rims.radius();
    let mut given = obstacles.overlapping(mesh, low - room, high + room);
    given.extend(others.iter().filter(|t| {
        let (other_low, other_high) = bounds(t.iter().map(|&v| place(mesh, new, v)));
        boxes_overlap(low - room, high + room, other_low, other_high)
    }));
    // numbers: rim vertices, other given vertices, new vertices
    let mut points: Vec<DVec3> = patch.points[..patch.rim].to_vec();
    let rim_numbers = rims.vertices.iter().map(|v| v.0).zip(0..);
    let mut numbers: FxHashMap<u32, u32> = rim_numbers.collect();
    for t in &mut given {
        *t = t.map(|v| {
            *numbers.entry(v).or_insert_with(|| {
                points.push(place(mesh, new, v));
                points.len() as u32 - 1
            })
        });
    }
    let (rim, fixed) = (patch.rim as u32, points.len() as u32);
    points.extend(patch.new_points());
    let number = |v: u32| if v < rim { v } else { v - rim + fixed };
    let own = patch.triangles.iter().map(|t| t.map(number));
    let share = COMPARISONS_OF_ALL / obstacles.holes.max(1);
    let comparisons = share.clamp(FEW_COMPARISONS, COMPARISONS);
    let mut sheet = Sheet::new(points, fixed, given, own, comparisons);
    if !sheet.repair() {
        return None;
    }
    let number = |v: u32| if v < rim { v } else { v - fixed + rim };
    let own = sheet.triangles[sheet.given..].iter();
    let mut points = patch.points[..patch.rim].to_vec();
    points.extend(&sheet.points[fixed as usize..]);
    Some(Patch {
        rim: patch.rim,
        points,
        triangles: own.map(|t| t.map(number)).collect(),
    })
}

/// The faults of some triangles, and how much they bend at their edges and how thin they are.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Cost {
    faults: usize,
    shape: f64,
}

/// The triangles of a patch beside given ones.
struct Sheet {
    points: Vec<DVec3>,
    /// Number of the vertices that do not move, the first ones.
    fixed: u32,
    /// The first vertex at the position of each vertex; that vertex itself for those that move.
    same: Vec<u32>,
    /// Given triangles first.
    triangles: Vec<[u32; 3]>,
    given: usize,
    boxes: Vec<(DVec3, DVec3)>,
    /// The triangle to the left of each directed edge.
    left: FxHashMap<[u32; 2], u32>,
    /// The triangles of the patch at each vertex.
    around: Vec<Vec<u32>>,
    /// Comparisons that are left.
    left_comparisons: usize,
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

impl Sheet {
    fn new(
        points: Vec<DVec3>,
        fixed: u32,
        given: Vec<[u32; 3]>,
        own: impl Iterator<Item = [u32; 3]>,
        left_comparisons: usize,
    ) -> Self {
        let mut same = canonical_vertices(&points[..fixed as usize]);
        same.extend(fixed..points.len() as u32);
        let mut sheet = Self {
            around: vec![Vec::new(); points.len()],
            points,
            fixed,
            same,
            given: given.len(),
            triangles: Vec::new(),
            boxes: Vec::new(),
            left: FxHashMap::default(),
            left_comparisons,
        };
        for t in given.into_iter().chain(own) {
            sheet.enter(sheet.triangles.len() as u32, t);
        }
        sheet
    }

    fn corners(&self, f: u32) -> [DVec3; 3] {
        let at = |v: u32| self.points[v as usize];
        let [a, b, c] = self.triangles[f as usize];
        [at(a), at(b), at(c)]
    }

    fn is_given(&self, f: u32) -> bool {
        (f as usize) < self.given
    }

    /// Enters a triangle at a number that is free.
    fn enter(&mut self, f: u32, t: [u32; 3]) {
        if f as usize == self.triangles.len() {
            self.triangles.push(t);
            self.boxes.push((DVec3::ZERO, DVec3::ZERO));
        }
        self.triangles[f as usize] = t;
        self.boxes[f as usize] = bounds(self.corners(f).into_iter());
        for k in 0..3 {
            self.left.insert([t[k], t[(k + 1) % 3]], f);
            if !self.is_given(f) {
                self.around[t[k] as usize].push(f);
            }
        }
    }

    fn remove(&mut self, f: u32) {
        let t = self.triangles[f as usize];
        for k in 0..3 {
            self.left.remove(&[t[k], t[(k + 1) % 3]]);
            self.around[t[k] as usize].retain(|&g| g != f);
        }
    }

    /// Replaces the first triangles by all of these; the others get numbers at the end.
    fn replace(&mut self, old: &[u32], new: &[[u32; 3]]) {
        for &f in old {
            self.remove(f);
        }
        let more = self.triangles.len() as u32..;
        let numbers: Vec<u32> = old.iter().copied().chain(more).take(new.len()).collect();
        for (f, &t) in numbers.into_iter().zip(new) {
            self.enter(f, t);
        }
    }

    fn move_to(&mut self, v: u32, point: DVec3) {
        self.points[v as usize] = point;
        for &f in &self.around[v as usize] {
            self.boxes[f as usize] = bounds(self.corners(f).into_iter());
        }
    }

    fn add_point(&mut self, point: DVec3) -> u32 {
        let v = self.points.len() as u32;
        self.points.push(point);
        self.same.push(v);
        self.around.push(Vec::new());
        v
    }

    /// The triangles whose boxes overlap a box.
    fn near(&self, (low, high): (DVec3, DVec3)) -> Vec<u32> {
        let boxes = (0..).zip(&self.boxes);
        let near = boxes.filter(|(_, b)| boxes_overlap(low, high, b.0, b.1));
        near.map(|(f, _)| f).collect()
    }

    fn meets(&self, f: u32, g: u32) -> bool {
        let ((low, high), other) = (self.boxes[f as usize], self.boxes[g as usize]);
        let [s, t] = [f, g].map(|f| self.triangles[f as usize]);
        f != g
            && boxes_overlap(low, high, other.0, other.1)
            && pair_meets(&self.points, &self.same, s, t)
    }

    /// The cosine of the angle at each edge of a triangle, and the triangle beyond.
    fn bends(&self, f: u32) -> impl Iterator<Item = (f64, u32)> {
        let t = self.triangles[f as usize];
        let own = normal(self.corners(f));
        (0..3).filter_map(move |k| {
            let g = *self.left.get(&[t[(k + 1) % 3], t[k]])?;
            Some((own.dot(normal(self.corners(g))), g))
        })
    }

    /// The cost of some triangles of the patch among those near them if it is below `limit`.
    fn cost_below(&mut self, limit: Cost, some: &[u32], near: &[u32]) -> Option<Cost> {
        let mut cost = Cost {
            faults: 0,
            shape: 0.0,
        };
        for &f in some {
            let [a, b, c] = self.corners(f);
            let area = (b - a).cross(c - a).length();
            let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
            cost.shape += THIN * (sides / area).min(THINNEST);
            cost.faults += usize::from(area == 0.0);
            for (cosine, g) in self.bends(f) {
                if g > f || !some.contains(&g) {
                    cost.faults += usize::from(cosine < FOLDED);
                    cost.shape += (1.0 - cosine).powi(4);
                }
            }
        }
        // intersections, which take most of the time, can only add faults
        for &f in some {
            if cost >= limit {
                return None;
            }
            let meets = |g: &&u32| (**g > f || !some.contains(g)) && self.meets(f, **g);
            cost.faults += near.iter().filter(meets).count();
            self.left_comparisons = self.left_comparisons.saturating_sub(near.len());
        }
        (cost < limit).then_some(cost)
    }

    fn cost(&mut self, some: &[u32], near: &[u32]) -> Cost {
        let none = Cost {
            faults: usize::MAX,
            shape: 0.0,
        };
        self.cost_below(none, some, near).unwrap_or(none)
    }

    /// Whether a triangle has no area or a folded edge.
    fn is_bent(&self, f: u32) -> bool {
        normal(self.corners(f)) == DVec3::ZERO || self.bends(f).any(|bend| bend.0 < FOLDED)
    }

    /// Those of some triangles of the patch that are bent or meet others.
    fn defective(&self, some: impl Iterator<Item = u32>) -> BTreeSet<u32> {
        let meets = |f: u32| (0..self.triangles.len() as u32).any(|g| self.meets(f, g));
        some.filter(|&f| self.is_bent(f) || meets(f)).collect()
    }

    /// The triangles on both sides of an edge, if both are of the patch, and its corners.
    fn diamond(&self, a: u32, b: u32) -> Option<([u32; 2], [u32; 2])> {
        let sides = [*self.left.get(&[a, b])?, *self.left.get(&[b, a])?];
        if sides.into_iter().any(|f| self.is_given(f)) {
            return None;
        }
        let [s, t] = sides.map(|f| self.triangles[f as usize]);
        let apex = |t: [u32; 3]| t.into_iter().find(|&v| v != a && v != b);
        Some((sides, [apex(s)?, apex(t)?]))
    }

    /// Flips an edge if that lowers the cost.
    fn flip(&mut self, a: u32, b: u32) {
        let Some((sides, [c, d])) = self.diamond(a, b) else {
            return;
        };
        let is_spare = |v: u32| {
            let least = if v < self.fixed { 1 } else { 3 };
            self.around[v as usize].len() > least
        };
        let is_edge = self.left.contains_key(&[c, d]) || self.left.contains_key(&[d, c]);
        if c == d || is_edge || !is_spare(a) || !is_spare(b) {
            return;
        }
        let corners = [a, b, c, d].map(|v| self.points[v as usize]);
        let near = self.near(bounds(corners.into_iter()));
        let before = self.cost(&sides, &near);
        let old = sides.map(|f| self.triangles[f as usize]);
        self.replace(&sides, &[[c, d, b], [d, c, a]]);
        if self.cost_below(before, &sides, &near).is_none() {
            self.replace(&sides, &old);
        }
    }

    fn split_triangle(&mut self, f: u32) {
        let [a, b, c] = self.triangles[f as usize];
        let middle = self.corners(f).iter().sum::<DVec3>() / 3.0;
        let m = self.add_point(middle);
        self.replace(&[f], &[[a, b, m], [b, c, m], [c, a, m]]);
    }

    /// Splits an edge between two triangles of the patch.
    fn split_edge(&mut self, a: u32, b: u32) {
        if let Some((sides, [c, d])) = self.diamond(a, b) {
            let middle = self.points[a as usize].midpoint(self.points[b as usize]);
            let m = self.add_point(middle);
            self.replace(&sides, &[[a, m, c], [m, b, c], [b, m, d], [m, a, d]]);
        }
    }

    /// Moves a vertex to the best place that a pattern search finds.
    fn relocate(&mut self, v: u32) {
        let star = self.around[v as usize].clone();
        let start = self.points[v as usize];
        let corners = star.iter().flat_map(|&f| self.corners(f));
        let size = corners.map(|p| p.distance(start)).fold(0.0, f64::max);
        let reach = STEPS.iter().sum::<f64>() * size;
        let corners = star.iter().flat_map(|&f| self.corners(f));
        let (low, high) = bounds(corners.chain([start - reach, start + reach]));
        let near = self.near((low, high));
        let mut best = self.cost(&star, &near);
        let mut at = start;
        for step in STEPS {
            let centre = at;
            for direction in directions() {
                let point = centre + step * size * direction;
                self.move_to(v, point);
                if let Some(cost) = self.cost_below(best, &star, &near) {
                    (best, at) = (cost, point);
                }
            }
        }
        self.move_to(v, at);
    }

    /// Gives defective triangles vertices that can move: in triangles between given vertices, on
    /// edges between such, and if `finer` on the longest edge of each.
    fn split(&mut self, defective: &BTreeSet<u32>, finer: bool) {
        let fixed = self.fixed;
        for &f in defective {
            let t = self.triangles[f as usize];
            if t.iter().all(|&v| v < fixed) {
                self.split_triangle(f);
            } else if finer {
                let inner = sides(t)
                    .into_iter()
                    .filter(|e| self.diamond(e[0], e[1]).is_some());
                let length = |e: &[u32; 2]| {
                    let [p, q] = e.map(|v| self.points[v as usize]);
                    p.distance_squared(q)
                };
                let longest = inner.max_by(|d, e| length(d).total_cmp(&length(e)));
                if let Some([a, b]) = longest {
                    self.split_edge(a, b);
                }
            }
        }
        for &f in defective {
            for k in 0..3 {
                let t = self.triangles[f as usize];
                let [a, b] = [t[k], t[(k + 1) % 3]];
                if a < fixed && b < fixed {
                    self.split_edge(a, b);
                }
            }
        }
    }

    /// Repairs the patch. Returns whether it is sound.
    fn repair(&mut self) -> bool {
        let own = self.given as u32..self.triangles.len() as u32;
        let subset: Vec<u32> = own.clone().collect();
        let pairs = self_intersections(&self.points, &self.triangles, Some(&subset), 4 * MANY);
        let crossing = pairs.into_iter().flatten();
        let bent = own.filter(|&f| self.is_bent(f));
        let mut defective: BTreeSet<u32> = bent.chain(crossing).collect();
        defective.retain(|&f| !self.is_given(f));
        let (mut least, mut stalled) = (usize::MAX, 0);
        for round in 0..ROUNDS {
            if defective.is_empty() {
                return true;
            }
            if defective.len() < least {
                (least, stalled) = (defective.len(), 0);
            } else {
                stalled += 1;
            }
            let is_hopeless = defective.len() > MANY || stalled > PATIENCE;
            if is_hopeless || self.is_spent() {
                return false;
            }
            if round == 0 || stalled % 3 == 2 {
                self.split(&defective, stalled > 0);
            }
            let mut vertices = self.vertices_of(&defective);
            for _ in 0..(stalled / 2).min(2) {
                vertices = self.vertices_of(&self.faces_at(&vertices));
            }
            let faces = self.faces_at(&vertices);
            for &f in &faces {
                if self.is_spent() {
                    return false;
                }
                for k in 0..3 {
                    let t = self.triangles[f as usize];
                    self.flip(t[k], t[(k + 1) % 3]);
                }
            }
            let fixed = self.fixed;
            for v in vertices.into_iter().filter(|&v| v >= fixed) {
                if self.is_spent() {
                    return false;
                }
                self.relocate(v);
            }
            let changed = self.faces_at(&self.vertices_of(&faces));
            defective = self.defective(changed.union(&defective).copied());
        }
        defective.is_empty()
    }

    /// Whether the repair has taken as long as it may, or was cancelled.
    fn is_spent(&self) -> bool {
        self.left_comparisons == 0 || is_cancelled()
    }

    fn vertices_of(&self, faces: &BTreeSet<u32>) -> BTreeSet<u32> {
        let corners = faces.iter().flat_map(|&f| self.triangles[f as usize]);
        corners.collect()
    }

    /// The triangles of the patch at vertices.
    fn faces_at(&self, vertices: &BTreeSet<u32>) -> BTreeSet<u32> {
        let around = vertices.iter().flat_map(|&v| &self.around[v as usize]);
        around.copied().collect()
    }
}

/// Weight of thin triangles, whose measure is their sum of squared sides over their area, beside bent
/// edges.
const THIN: f64 = 0.01;
/// The largest measure of a thin triangle.
const THINNEST: f64 = 1e6;

/// The directions to the faces, edges and corners of a cube.
fn directions() -> impl Iterator<Item = DVec3> {
    let coordinate = |k: i32| f64::from(k % 3 - 1);
    (0..27)
        .filter(|&k| k != 13)
        .map(move |k| DVec3::new(coordinate(k), coordinate(k / 3), coordinate(k / 9)).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::defects::{Room, defects};
    use crate::mesh::{VertexId, boundary_loops};
    use crate::patch::{PatchOptions, fill};
    use crate::shapes;

    /// Whether a patch over the first loop of a mesh is unsound and its repair sound.
    fn is_repaired(mesh: &Mesh, change: impl Fn(&mut Patch)) -> bool {
        let loops = boundary_loops(mesh);
        let hole = &loops[0];
        let rims = HoleRims::new(mesh, &[hole]);
        let mut patch = fill(&rims.geometry.rims[0], PatchOptions::default()).expect("a patch");
        change(&mut patch);
        let obstacles = Obstacles::new(1);
        let is_sound = |patch: &Patch| {
            let part = (
                &rims.vertices[..],
                &patch.triangles[..],
                patch.new_points().len(),
            );
            let own = crate::fill::assemble::appended_triangles(mesh.vertex_count(), [part]);
            let room = Room::around(mesh, &rims, &[]);
            defects(mesh, &obstacles, &rims, room, &own, &[], patch.new_points()).is_none()
        };
        let after = repaired(mesh, &obstacles, &rims, &patch, &[], &[]);
        let is_kept = |after: &Patch| after.points[..after.rim] == patch.points[..patch.rim];
        !is_sound(&patch) && after.is_some_and(|after| is_sound(&after) && is_kept(&after))
    }

    fn cap() -> Mesh {
        let (positions, triangles) = shapes::cut_where(&shapes::sphere(600, 1), |p| p.z > 0.7);
        Mesh::from_triangles(positions, &triangles).expect("a manifold")
    }

    #[test]
    fn a_vertex_beyond_its_neighbours_or_the_mesh_returns() {
        let mesh = cap();
        assert!(is_repaired(&mesh, |patch| patch.points[patch.rim] =
            DVec3::new(0.9, 0.1, 0.9)));
        assert!(is_repaired(&mesh, |patch| patch.points[patch.rim].z -= 2.5));
    }

    #[test]
    fn a_triangle_through_an_obstacle_gets_a_vertex_and_goes_around() {
        // the tip of a tetrahedron, whose bottom is missing, through the face that is missing
        let mut positions = vec![DVec3::X, DVec3::Y, DVec3::ZERO, DVec3::new(0.3, 0.3, -1.0)];
        let at = |x: f64, y: f64, z: f64| DVec3::new(0.3 + x, 0.3 + y, z);
        positions.extend([
            at(0.0, 0.0, 0.1),
            at(0.05, 0.0, -0.2),
            at(-0.03, 0.04, -0.2),
            at(-0.03, -0.04, -0.2),
        ]);
        let triangles = [
            [1, 0, 3],
            [2, 1, 3],
            [0, 2, 3],
            [4, 5, 6],
            [4, 6, 7],
            [4, 7, 5],
        ];
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        assert_eq!(mesh.position(VertexId(4)).z, 0.1);
        let hole = boundary_loops(&mesh)
            .into_iter()
            .find(|one| one.vertices.contains(&VertexId(0)));
        let hole = hole.expect("a hole");
        let rims = HoleRims::new(&mesh, &[&hole]);
        let points = rims.geometry.rims[0].points.clone();
        let patch = Patch {
            rim: 3,
            points,
            triangles: vec![[0, 1, 2]],
        };
        let obstacles = Obstacles::new(1);
        let after = repaired(&mesh, &obstacles, &rims, &patch, &[], &[]).expect("repaired");
        assert!(after.new_points().iter().any(|p| p.z > 0.1));
    }
}
