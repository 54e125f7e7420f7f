//! Intersections between the triangles of a mesh, decided by exact predicates.

use rayon::prelude::*;
use robust::{Coord, Coord3D};
use rustc_hash::FxHashMap;

use super::spatial::boxes_overlap;
use super::{DVec3, Topology, TriangleBvh};

/// Rounding that the distance of a box from a plane is safe from, relative to the lengths involved.
const ROUNDING: f64 = 1e-9;
/// Triangle queries between two checks of the limit.
const BLOCK: usize = 1 << 14;

/// Pairs of triangles that intersect or touch outside their common vertices and edges, each once,
/// as `[smaller, larger]` indices into `triangles`, at most `limit`.
///
/// With `subset` given, only pairs with at least one triangle of it are looked for (a patch
/// against the whole mesh, itself included). Vertices at bit-equal positions count as the same
/// vertex, so a mesh cut apart along an edge does not touch itself there. Two triangles that share
/// an edge meet only if they are coplanar and on the same side of it; nearly coplanar ones are
/// what [`folded_edges`] finds. Triangles of exactly zero area are left out. Runs in
/// O((n + candidates) log n), and the answer does not depend on the number of threads.
pub fn self_intersections(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    subset: Option<&[u32]>,
    limit: usize,
) -> Vec<[u32; 2]> {
    let all = TriangleIntersections::new(positions, triangles);
    let everything: Vec<u32>;
    let queries = if let Some(subset) = subset {
        subset
    } else {
        everything = (0..triangles.len() as u32).collect();
        &everything
    };
    let mut queried = vec![false; triangles.len()];
    for &f in queries {
        queried[f as usize] = true;
    }
    let mut found = Vec::new();
    for block in queries.chunks(BLOCK) {
        let mut pairs: Vec<[u32; 2]> = block
            .par_iter()
            .flat_map_iter(|&f| {
                let mut partners = Vec::new();
                // a pair of queried triangles is found once, by the smaller one
                let candidate = |g: u32| g != f && (g > f || !queried[g as usize]);
                all.for_each(triangles[f as usize], candidate, |g| {
                    partners.push([f.min(g), f.max(g)]);
                });
                partners
            })
            .collect();
        found.append(&mut pairs);
        if found.len() >= limit {
            break;
        }
    }
    found.sort_unstable();
    found.dedup(); // a subset that names a triangle twice
    found.truncate(limit);
    found
}

/// Triangles to be searched for those that meet another triangle.
pub struct TriangleIntersections<'a> {
    positions: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    bvh: TriangleBvh,
    /// The first vertex at the position of each vertex.
    same: Vec<u32>,
}

impl<'a> TriangleIntersections<'a> {
    /// Prepares the search. Runs in O(n log n).
    pub fn new(positions: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        Self {
            positions,
            triangles,
            bvh: TriangleBvh::new(positions, triangles),
            same: canonical_vertices(positions),
        }
    }

    /// Calls `visit` with the index of every `candidate` that meets `t`, as in [`self_intersections`].
    fn for_each(&self, t: [u32; 3], candidate: impl Fn(u32) -> bool, mut visit: impl FnMut(u32)) {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        self.bvh.for_each_overlapping(low, high, |g| {
            let meets = || pair_meets(self.positions, &self.same, t, self.triangles[g as usize]);
            if candidate(g) && meets() {
                visit(g);
            }
        });
    }

    /// Whether any triangle meets `t`, which is not one of them.
    pub fn any(&self, t: [u32; 3]) -> bool {
        let [a, b, c] = t.map(|v| self.positions[v as usize]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let normal = (b - a).cross(c - a);
        let slack = ROUNDING * (b - a).length() * (c - a).length();
        // a box that the plane of `t` does not cut cannot meet it
        let overlaps = |below: DVec3, above: DVec3| {
            let (middle, half) = (below.midpoint(above) - a, 0.5 * (above - below));
            boxes_overlap(low, high, below, above)
                && normal.dot(middle).abs()
                    <= normal.abs().dot(half) + slack * (middle.length() + half.length())
        };
        let mut any = false;
        self.bvh.search(overlaps, |g| {
            any = pair_meets(self.positions, &self.same, t, self.triangles[g as usize]);
            !any
        });
        any
    }
}

/// Angle between the normals of the triangles at an edge in radians; 0 on a boundary or if one has
/// zero area.
pub fn dihedral_angle(positions: &[DVec3], topology: &Topology, h: super::HalfedgeId) -> f64 {
    if topology.is_boundary_edge(h) {
        return 0.0;
    }
    let [m, n] = [h, h.twin()].map(|h| {
        let corners = topology.face_vertices(topology.face(h));
        let [a, b, c] = corners.map(|v| positions[v.index()]);
        (b - a).cross(c - a)
    });
    if m.length_squared() == 0.0 || n.length_squared() == 0.0 {
        return 0.0;
    }
    m.cross(n).length().atan2(m.dot(n))
}

/// Angle in degrees between the normals of two faces from which their edge counts as folded.
pub const FOLD_DEGREES: f64 = 150.0;

/// Pairs of edge-adjacent faces whose normals differ by at least `min_angle` radians (positive; pi:
/// folded flat onto each other), as `[smaller, larger]` face indices in edge order. Faces of zero
/// area have no normal and are left out.
pub fn folded_edges(positions: &[DVec3], topology: &Topology, min_angle: f64) -> Vec<[u32; 2]> {
    topology
        .edges()
        .filter(|&h| {
            let angle = dihedral_angle(positions, topology, h);
            angle > 0.0 && angle >= min_angle
        })
        .map(|h| {
            let (f, g) = (topology.face(h), topology.face(h.twin()));
            [f.0.min(g.0), f.0.max(g.0)]
        })
        .collect()
}

/// The first vertex at the position of each vertex.
pub(crate) fn canonical_vertices(positions: &[DVec3]) -> Vec<u32> {
    // adding 0.0 turns -0.0 into 0.0
    let key = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut first = FxHashMap::default();
    first.reserve(positions.len());
    let numbered = positions.iter().zip(0..);
    numbered
        .map(|(p, v)| *first.entry(key(p)).or_insert(v))
        .collect()
}

/// Whether two triangles of the mesh meet outside their common vertices and edges. `same` are the
/// [`canonical_vertices`].
pub(crate) fn pair_meets(positions: &[DVec3], same: &[u32], s: [u32; 3], t: [u32; 3]) -> bool {
    let key = |v: u32| same[v as usize];
    let is_point_or_segment = |t: [u32; 3]| {
        let [a, b, c] = t.map(key);
        a == b || b == c || c == a
    };
    if is_point_or_segment(s) || is_point_or_segment(t) {
        return false;
    }
    let at = |v: u32| positions[v as usize];
    // shared corners as (corner of s, corner of t)
    let mut shared = [(0, 0); 3];
    let mut count = 0;
    for i in 0..3 {
        for j in 0..3 {
            if key(s[i]) == key(t[j]) && count < 3 {
                shared[count] = (i, j);
                count += 1;
            }
        }
    }
    let (p, q) = (s.map(at), t.map(at));
    match count {
        0 => triangles_meet(p, q),
        1 => {
            let (i, j) = shared[0];
            let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
            let (c, d) = (q[(j + 1) % 3], q[(j + 2) % 3]);
            let (Some(plane_p), Some(plane_q)) = (Plane::of(p), Plane::of(q)) else {
                return false;
            };
            // a triangle on one side of the other's plane meets that plane at the shared corner only
            let sides_p = [a, b].map(|x| plane_q.side(x));
            if sides_p[0] * sides_p[1] > 0 {
                return false;
            }
            let sides_q = [c, d].map(|x| plane_p.side(x));
            if sides_q[0] * sides_q[1] > 0 {
                return false;
            }
            // Both cuts with the common line start at the shared corner; if they go the same
            // way, the shorter one ends on its opposite edge inside the other triangle.
            plane_q.meets_segment_with_sides(a, b, sides_p[0], sides_p[1])
                || plane_p.meets_segment_with_sides(c, d, sides_q[0], sides_q[1])
        }
        2 => {
            let (i, j) = (3 - shared[0].0 - shared[1].0, 3 - shared[0].1 - shared[1].1);
            overlaps_across_edge(p, i, q[j])
        }
        _ => !is_degenerate(p),
    }
}

/// Whether triangles `p` and `q` without common vertices meet (closed sets). Triangles of zero
/// area meet nothing.
pub fn triangles_meet(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let (Some(plane_p), Some(plane_q)) = (Plane::of(p), Plane::of(q)) else {
        return false;
    };
    let apart = |s: [i8; 3]| s.iter().all(|&x| x > 0) || s.iter().all(|&x| x < 0);
    let sides_q = q.map(|x| plane_p.side(x));
    if apart(sides_q) {
        return false;
    }
    let sides_p = p.map(|x| plane_q.side(x));
    if apart(sides_p) {
        return false;
    }
    (0..3).any(|k| {
        let l = (k + 1) % 3;
        plane_p.meets_segment_with_sides(q[k], q[l], sides_q[k], sides_q[l])
            || plane_q.meets_segment_with_sides(p[k], p[l], sides_p[k], sides_p[l])
    })
}

/// Whether a triangle and a point across its edge opposite to corner `i` form a flat fold: the
/// point coplanar with the triangle and on the same side of the edge.
fn overlaps_across_edge(p: [DVec3; 3], i: usize, x: DVec3) -> bool {
    let Some(plane) = Plane::of(p) else {
        return false;
    };
    if plane.side(x) != 0 {
        return false;
    }
    let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
    plane.turn(a, b, x) == plane.turn(a, b, p[i])
}

fn is_degenerate(t: [DVec3; 3]) -> bool {
    Plane::of(t).is_none()
}

/// A triangle of non-zero area with the coordinate plane into which it may be projected.
struct Plane {
    corners: [DVec3; 3],
    /// The two coordinates that are kept.
    axes: [usize; 2],
}

impl Plane {
    /// `None` if the area is exactly zero.
    fn of(corners: [DVec3; 3]) -> Option<Self> {
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .abs();
        let [x, y, z] = normal.to_array();
        let order = if z >= x && z >= y {
            [[0, 1], [1, 2], [2, 0]]
        } else if x >= y {
            [[1, 2], [0, 1], [2, 0]]
        } else {
            [[2, 0], [0, 1], [1, 2]]
        };
        order.into_iter().find_map(|axes| {
            let plane = Self { corners, axes };
            (plane.turn(corners[0], corners[1], corners[2]) != 0).then_some(plane)
        })
    }

    /// Sign of the side of the triangle's plane on which `x` lies.
    fn side(&self, x: DVec3) -> i8 {
        orient(self.corners[0], self.corners[1], self.corners[2], x)
    }

    /// Sign of the turn a → b → c in the projection.
    fn turn(&self, a: DVec3, b: DVec3, c: DVec3) -> i8 {
        let [i, j] = self.axes;
        let at = |p: DVec3| Coord { x: p[i], y: p[j] };
        sign(robust::orient2d(at(a), at(b), at(c)))
    }

    /// Whether the closed segment meets the closed triangle; `side_p` and `side_q` are the sides
    /// of its ends.
    fn meets_segment_with_sides(&self, p: DVec3, q: DVec3, side_p: i8, side_q: i8) -> bool {
        if side_p * side_q > 0 {
            return false;
        }
        if side_p == 0 && side_q == 0 {
            return self.meets_coplanar_segment(p, q);
        }
        let [a, b, c] = self.corners;
        let turns = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)];
        turns.iter().all(|&s| s >= 0) || turns.iter().all(|&s| s <= 0)
    }

    fn meets_coplanar_segment(&self, p: DVec3, q: DVec3) -> bool {
        let [a, b, c] = self.corners;
        let inside = [self.turn(a, b, p), self.turn(b, c, p), self.turn(c, a, p)];
        if inside.iter().all(|&s| s >= 0) || inside.iter().all(|&s| s <= 0) {
            return true;
        }
        self.segments_meet(p, q, a, b)
            || self.segments_meet(p, q, b, c)
            || self.segments_meet(p, q, c, a)
    }

    /// Whether two closed segments of the plane meet.
    fn segments_meet(&self, p: DVec3, q: DVec3, a: DVec3, b: DVec3) -> bool {
        let (a_side, b_side) = (self.turn(p, q, a), self.turn(p, q, b));
        let (p_side, q_side) = (self.turn(a, b, p), self.turn(a, b, q));
        if a_side * b_side < 0 && p_side * q_side < 0 {
            return true;
        }
        let between = |x: DVec3, s: DVec3, t: DVec3| {
            self.axes
                .iter()
                .all(|&k| s[k].min(t[k]) <= x[k] && x[k] <= s[k].max(t[k]))
        };
        (a_side == 0 && between(a, p, q))
            || (b_side == 0 && between(b, p, q))
            || (p_side == 0 && between(p, a, b))
            || (q_side == 0 && between(q, a, b))
    }
}

fn orient(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> i8 {
    let at = |p: DVec3| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    };
    sign(robust::orient3d(at(a), at(b), at(c), at(d)))
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;

    fn v(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    const UNIT: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn any_finds_what_a_search_of_all_finds() {
        let mut random = SplitMix::new(5);
        for far in [0.0, 1e4] {
            let mut points: Vec<DVec3> = Vec::new();
            for _ in 0..100 {
                let at = far * DVec3::ONE + random.direction();
                points.extend([0; 3].map(|_| at + 0.2 * random.direction()));
            }
            let all: Vec<[u32; 3]> = (0..100).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
            let search = TriangleIntersections::new(&points, &all[..50]);
            let found = all[50..].iter().map(|&t| search.any(t));
            let meets = |t| (0..50).any(|f| pair_meets(&points, &search.same, t, all[f]));
            let expected: Vec<bool> = all[50..].iter().map(|&t| meets(t)).collect();
            assert!(expected.contains(&true) && expected.contains(&false));
            assert!(found.eq(expected));
        }
    }

    #[test]
    fn known_pairs_without_common_vertices() {
        let cases = [
            // pierces the inside
            (
                [v(0.2, 0.2, -1.0), v(0.2, 0.2, 1.0), v(3.0, 3.0, 0.5)],
                true,
            ),
            // crosses the plane beside the triangle
            (
                [v(2.0, 2.0, -1.0), v(2.0, 2.0, 1.0), v(3.0, 3.0, 0.5)],
                false,
            ),
            // touches with a corner, from above
            (
                [v(0.25, 0.25, 0.0), v(0.0, 1.0, 1.0), v(1.0, 0.0, 1.0)],
                true,
            ),
            // an epsilon above
            (
                [v(0.25, 0.25, 1e-300), v(0.0, 1.0, 1.0), v(1.0, 0.0, 1.0)],
                false,
            ),
            // edge through edge
            (
                [v(0.5, 0.0, -1.0), v(0.5, 0.0, 1.0), v(0.5, -1.0, 0.0)],
                true,
            ),
            // coplanar: inside, around, across, beside
            ([v(0.1, 0.1, 0.0), v(0.2, 0.1, 0.0), v(0.1, 0.2, 0.0)], true),
            (
                [v(-9.0, -9.0, 0.0), v(9.0, -9.0, 0.0), v(0.0, 9.0, 0.0)],
                true,
            ),
            (
                [v(0.2, -1.0, 0.0), v(0.3, -1.0, 0.0), v(0.25, 2.0, 0.0)],
                true,
            ),
            (
                [v(1.0, 1.0, 0.0), v(2.0, 1.0, 0.0), v(1.0, 2.0, 0.0)],
                false,
            ),
            // parallel planes
            (
                [v(0.0, 0.0, 1e-9), v(1.0, 0.0, 1e-9), v(0.0, 1.0, 1e-9)],
                false,
            ),
        ];
        for (q, expected) in cases {
            for turn in 0..3 {
                let r = [q[turn], q[(turn + 1) % 3], q[(turn + 2) % 3]];
                assert_eq!(triangles_meet(UNIT, r), expected, "{q:?}");
                assert_eq!(triangles_meet(r, UNIT), expected, "{q:?}");
                assert_eq!(triangles_meet([r[1], r[0], r[2]], UNIT), expected, "{q:?}");
            }
        }
    }

    #[test]
    fn shared_vertices_and_edges_are_not_intersections() {
        let mesh = |x: DVec3, y: DVec3| {
            let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, x, y];
            (positions, [[0, 1, 2], [0, 3, 4]])
        };
        let meets = |x, y| {
            let (p, t) = mesh(x, y);
            let fresh = [p[0], p[1], p[2], p[0], p[3], p[4]];
            let pairs = self_intersections(&p, &t, None, 9);
            // the same with the shared corner stored twice
            assert_eq!(
                self_intersections(&fresh, &[[0, 1, 2], [3, 4, 5]], None, 9),
                pairs
            );
            !pairs.is_empty()
        };
        assert!(!meets(v(-1.0, 0.0, 0.0), v(0.0, -1.0, 0.0)));
        assert!(!meets(v(0.0, 0.0, 1.0), v(-1.0, 0.0, 1.0)));
        // through the inside, either far edge being the nearer one
        assert!(meets(v(0.2, 0.2, -1.0), v(0.2, 0.2, 1.0)));
        assert!(meets(v(2.0, 2.0, -1.0), v(2.0, 2.0, 1.0)));
        // coplanar sectors: overlapping, touching along an edge, apart
        assert!(meets(v(0.5, 0.1, 0.0), v(0.1, 0.5, 0.0)));
        assert!(meets(v(0.5, 0.0, 0.0), v(0.0, -1.0, 0.0)));
        assert!(!meets(v(-0.5, 1.0, 0.0), v(-1.0, -1.0, 0.0)));

        let edge = |x: DVec3| {
            let p = [DVec3::ZERO, DVec3::X, DVec3::Y, x];
            !self_intersections(&p, &[[0, 1, 2], [1, 0, 3]], None, 9).is_empty()
        };
        assert!(!edge(v(0.0, -1.0, 0.0)));
        assert!(!edge(v(0.3, 0.4, 1e-200)));
        assert!(edge(v(0.3, 0.4, 0.0)));
        // the same face twice
        assert_eq!(
            self_intersections(&UNIT, &[[0, 1, 2], [2, 1, 0]], None, 9),
            [[0, 1]]
        );
    }

    /// Triangles over the points of a small lattice: many have corners at one place or on one line.
    #[test]
    fn triangles_without_area_meet_nothing() {
        let mut rng = SplitMix::new(5);
        let mut positions = Vec::new();
        for _ in 0..2 {
            let lattice = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(f64::from));
            positions.extend(lattice.map(DVec3::from_array));
        }
        let mut triangles = Vec::new();
        while triangles.len() < 400 {
            let t = [(); 3].map(|()| rng.below(54) as u32);
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                triangles.push(t);
            }
        }
        let area = |f: u32| {
            let [a, b, c] = triangles[f as usize].map(|v| positions[v as usize]);
            (b - a).cross(c - a).length()
        };
        let flat = (0..400).filter(|&f| area(f) == 0.0).count();
        let found = self_intersections(&positions, &triangles, None, usize::MAX);
        assert!(flat > 20 && found.len() > 1000);
        assert!(found.iter().flatten().all(|&f| area(f) > 0.0));
    }

    #[test]
    fn agrees_with_brute_force_on_a_random_soup() {
        let mut rng = SplitMix::new(7);
        let mut point = || v(rng.unit(), rng.unit(), rng.unit());
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for f in 0..300u32 {
            let p = point();
            positions.extend([p, p + 0.2 * point(), p + 0.2 * point()]);
            triangles.push([3 * f, 3 * f + 1, 3 * f + 2]);
        }
        let corner = |f: u32| triangles[f as usize].map(|v| positions[v as usize]);
        let mut all = Vec::new();
        for f in 0..300 {
            for g in f + 1..300 {
                if triangles_meet(corner(f), corner(g)) {
                    all.push([f, g]);
                }
            }
        }
        assert!(all.len() > 20);
        assert_eq!(
            self_intersections(&positions, &triangles, None, usize::MAX),
            all
        );
        let subset: Vec<u32> = (0..300).filter(|f| f % 3 == 0).collect();
        all.retain(|p| p.iter().any(|f| f % 3 == 0));
        assert_eq!(
            self_intersections(&positions, &triangles, Some(&subset), usize::MAX),
            all
        );
        assert_eq!(self_intersections(&positions, &triangles, None, 5).len(), 5);
    }

    #[test]
    fn folds_are_measured_by_the_angle_between_normals() {
        let fold = |x: DVec3, angle: f64| {
            let p = [DVec3::ZERO, DVec3::X, DVec3::Y, x];
            let t = Topology::from_triangles(4, &[[0, 1, 2], [1, 0, 3]]).expect("manifold");
            folded_edges(&p, &t, angle.to_radians())
        };
        assert_eq!(fold(v(0.0, 1.0, 1e-9), 179.0), [[0, 1]]);
        assert_eq!(fold(v(0.0, 0.0, 1.0), 89.9), [[0, 1]]);
        assert!(fold(v(0.0, 0.0, 1.0), 90.1).is_empty());
        assert!(fold(v(0.5, -1.0, 0.0), 1.0).is_empty());
    }
}
