//! A bounding-volume hierarchy over triangles, and closest-point queries.

#[path = "ray.rs"]
mod ray;

use super::{DVec3, FaceId, Mesh};
pub use ray::RayHit;

/// Maximum number of triangles in a leaf. Smaller leaves need more memory, larger ones more tests.
const LEAF: usize = 4;

/// Factor by which the squared distance of a plane must exceed that of the nearest point so far to leave
/// out its triangle: larger than the rounding errors of both.
const MARGIN: f64 = 1.0 + 1e-9;

/// A box of the hierarchy. Nodes lie depth-first: the left child of node `i` is `i + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Leaf: start in `faces`. Inner node: index of the right child.
    first: u32,
    /// Leaf: number of triangles (at least one). Inner node: 0.
    count: u32,
}

/// A bounding-volume hierarchy over the triangles of a mesh, for exact queries in `f64`.
///
/// It is built by median splits in O(n log n) and has depth O(log n). It copies the corner
/// positions, so later changes of the mesh do not affect it.
#[derive(Clone, Debug)]
pub struct TriangleBvh {
    nodes: Vec<Node>,
    /// Triangle indices in leaf order.
    faces: Vec<u32>,
    /// Corner positions in leaf order.
    corners: Vec<[DVec3; 3]>,
}

/// Answer of [`TriangleBvh::closest_point`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The triangle that contains the point. The choice among equally near triangles is
    /// deterministic.
    pub face: u32,
    /// The point of the surface.
    pub point: DVec3,
    /// Distance from the query point in units of length.
    pub distance: f64,
}

impl TriangleBvh {
    /// Builds the hierarchy over `triangles`, whose corners are indices into `positions`.
    pub fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let at = |v: u32| positions[v as usize];
        let corner = |&[a, b, c]: &[u32; 3]| [at(a), at(b), at(c)];
        let centroids = triangles.iter().map(|t| centre(&corner(t)));
        let mut items: Vec<(DVec3, u32)> = centroids.zip(0..).collect();
        let mut nodes = Vec::with_capacity(triangles.len().div_ceil(LEAF) * 2);
        // (start, end, the inner node whose right child this range becomes)
        let mut stack = vec![(0, items.len(), usize::MAX)];
        while let Some((start, end, parent)) = stack.pop() {
            if start == end {
                continue;
            }
            let node = nodes.len();
            if parent != usize::MAX {
                let parent: &mut Node = &mut nodes[parent];
                parent.first = node as u32;
            }
            let is_leaf = end - start <= LEAF;
            nodes.push(Node {
                low: DVec3::INFINITY,
                high: DVec3::NEG_INFINITY,
                first: start as u32,
                count: if is_leaf { (end - start) as u32 } else { 0 },
            });
            if is_leaf {
                continue;
            }
            let range = &mut items[start..end];
            let (c_low, c_high) = bounds(range.iter().map(|item| item.0));
            let axis = longest_axis(c_high - c_low);
            let middle = (end - start) / 2;
            range.select_nth_unstable_by(middle, |(p, a), (q, b)| {
                p[axis].total_cmp(&q[axis]).then(a.cmp(b))
            });
            // the left half is taken next, so that it follows its parent
            stack.push((start + middle, end, node));
            stack.push((start, start + middle, usize::MAX));
        }
        let faces: Vec<u32> = items.iter().map(|item| item.1).collect();
        let corners = faces.iter().map(|&f| corner(&triangles[f as usize]));
        let corners: Vec<[DVec3; 3]> = corners.collect();
        // children follow their parents
        for i in (0..nodes.len()).rev() {
            let Node { first, count, .. } = nodes[i];
            let first = first as usize;
            let (low, high) = if count > 0 {
                let own = corners[first..first + count as usize].iter();
                bounds(own.flatten().copied())
            } else {
                let (left, right) = (nodes[i + 1], nodes[first]);
                (left.low.min(right.low), left.high.max(right.high))
            };
            (nodes[i].low, nodes[i].high) = (low, high);
        }
        Self {
            nodes,
            faces,
            corners,
        }
    }

    /// The point of the surface nearest to `query`; `None` without triangles.
    pub fn closest_point(&self, query: DVec3) -> Option<ClosestPoint> {
        let mut best: Option<ClosestPoint> = None;
        let mut best_squared = f64::INFINITY;
        let mut stack = DepthStack::default();
        if !self.nodes.is_empty() {
            stack.push((0, self.box_distance_squared(0, query)));
        }
        while let Some((index, bound)) = stack.pop() {
            if bound > best_squared {
                continue;
            }
            let node = self.nodes[index as usize];
            if node.count == 0 {
                let left = (index + 1, self.box_distance_squared(index + 1, query));
                let right = (node.first, self.box_distance_squared(node.first, query));
                let (near, far) = if right.1 < left.1 {
                    (right, left)
                } else {
                    (left, right)
                };
                stack.push(far);
                stack.push(near);
                continue;
            }
            for slot in node.first..node.first + node.count {
                let [a, b, c] = self.corners[slot as usize];
                let normal = (b - a).cross(c - a);
                let height = (query - a).dot(normal);
                if height * height > MARGIN * best_squared * normal.length_squared() {
                    continue;
                }
                let point = closest_point_on_triangle(query, a, b, c);
                let squared = point.distance_squared(query);
                let face = self.faces[slot as usize];
                let wins = squared < best_squared
                    || (squared == best_squared && best.is_some_and(|b| face < b.face));
                if wins {
                    best_squared = squared;
                    best = Some(ClosestPoint {
                        face,
                        point,
                        distance: squared.sqrt(),
                    });
                }
            }
        }
        best
    }

    /// Calls `visit` with every triangle whose bounding box meets the closed box `low..=high`,
    /// in a fixed order.
    pub fn for_each_overlapping(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        let overlaps = |a, b| boxes_overlap(low, high, a, b);
        self.search(overlaps, |f| {
            visit(f);
            true
        });
    }

    /// Calls `visit` with every triangle whose bounding box, and each box around it, is accepted by
    /// `overlaps`, in a fixed order, until it returns false.
    pub fn search(
        &self,
        overlaps: impl Fn(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(u32) -> bool,
    ) {
        let mut stack = DepthStack::default();
        if !self.nodes.is_empty() {
            stack.push((0, 0.0));
        }
        while let Some((index, _)) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !overlaps(node.low, node.high) {
                continue;
            }
            if node.count == 0 {
                stack.push((node.first, 0.0));
                stack.push((index + 1, 0.0));
                continue;
            }
            for slot in node.first as usize..(node.first + node.count) as usize {
                let [a, b, c] = self.corners[slot];
                let is_near = overlaps(a.min(b).min(c), a.max(b).max(c));
                if is_near && !visit(self.faces[slot]) {
                    return;
                }
            }
        }
    }

    fn box_distance_squared(&self, node: u32, p: DVec3) -> f64 {
        let node = &self.nodes[node as usize];
        (p - p.clamp(node.low, node.high)).length_squared()
    }
}

/// A stack of tree nodes without allocation: one more entry than the depth of the tree suffices,
/// and median splits of 2^32 triangles are 31 deep.
struct DepthStack {
    entries: [(u32, f64); 64],
    len: usize,
}

impl Default for DepthStack {
    fn default() -> Self {
        Self {
            entries: [(0, 0.0); 64],
            len: 0,
        }
    }
}

impl DepthStack {
    fn push(&mut self, entry: (u32, f64)) {
        self.entries[self.len] = entry;
        self.len += 1;
    }

    fn pop(&mut self) -> Option<(u32, f64)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }
}

fn centre([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// The corners of the bounding box of points: the smallest and the largest coordinates.
pub fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    })
}

fn longest_axis(extent: DVec3) -> usize {
    if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    }
}

/// Whether two boxes, given by their corners, have a point in common.
pub fn boxes_overlap(low: DVec3, high: DVec3, other_low: DVec3, other_high: DVec3) -> bool {
    low.cmple(other_high).all() && other_low.cmple(high).all()
}

/// Square of the sine of an angle below which the rounding errors of a normal are too large to decide
/// on which side of an edge a point lies.
const FLAT: f64 = 1e-20;

/// The point of triangle `abc` nearest to `p`; triangles of zero area (segments, points) are
/// allowed.
pub fn closest_point_on_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    closest_on_triangle(p, [a, b, c]).0
}

/// [`closest_point_on_triangle`], and the nearer end of the edge on which the point lies, unless it is
/// the projection of `p`.
#[inline]
fn closest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> (DVec3, Option<usize>) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    // barycentric coordinates of the projection, times `area`
    let v = ap.cross(ac).dot(normal);
    let w = ab.cross(ap).dot(normal);
    let u = area - v - w;
    let is_outside = [w < 0.0, u < 0.0, v < 0.0];
    let is_flat = area <= FLAT * ab.length_squared() * ac.length_squared();
    if !is_flat && !is_outside.contains(&true) {
        return (a + ab * (v / area) + ac * (w / area), None);
    }
    // the nearest point lies on an edge that has the projection on its outer side
    let corners = [a, b, c];
    let (mut nearest, mut least, mut edge) = (a, f64::INFINITY, [0, 1]);
    for (is_outside, [from, to]) in is_outside.into_iter().zip([[0, 1], [1, 2], [2, 0]]) {
        if is_outside || is_flat {
            let point = closest_point_on_segment(p, corners[from], corners[to]);
            let distance = point.distance_squared(p);
            if distance < least {
                (nearest, least, edge) = (point, distance, [from, to]);
            }
        }
    }
    let [from, to] = edge.map(|k| nearest.distance_squared(corners[k]));
    (nearest, Some(if to < from { edge[1] } else { edge[0] }))
}

/// The point of a mesh near to `query` to which a walk over its faces leads: from `start` to the nearest
/// one of the faces around the nearest corner, as long as they are nearer. If `start` has the point nearest to
/// a neighbour of `query`, this is the point of [`TriangleBvh::closest_point`], unless another part of the surface
/// is nearer, or one of several faces inside a bend that are nearly as near.
pub fn closest_point_from(mesh: &Mesh, start: FaceId, query: DVec3) -> ClosestPoint {
    let topology = &mesh.topology;
    let on = |face: FaceId| {
        let (point, corner) = closest_on_triangle(query, mesh.corners(face));
        (point.distance_squared(query), face, point, corner)
    };
    let mut best = on(start);
    while let (_, face, _, Some(corner)) = best {
        let corner = topology.face_vertices(face)[corner];
        let around = topology.outgoing(corner).map(|h| topology.face(h));
        for next in around.filter(|f| f.is_some()).map(on) {
            let is_nearer = next.0 < best.0 || (next.0 == best.0 && next.1 < best.1);
            if is_nearer {
                best = next;
            }
        }
        if best.1 == face {
            break;
        }
    }
    let (squared, face, point, _) = best;
    ClosestPoint {
        face: face.0,
        point,
        distance: squared.sqrt(),
    }
}

/// The point of a closed polygon nearest to `p`.
///
/// # Panics
/// If there are no corners.
pub fn closest_point_on_polygon(p: DVec3, corners: &[DVec3]) -> DVec3 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let points = edges.map(|(&a, &b)| closest_point_on_segment(p, a, b));
    let nearer = |a: &DVec3, b: &DVec3| a.distance_squared(p).total_cmp(&b.distance_squared(p));
    points.min_by(nearer).expect("a corner")
}

/// The point of segment `ab` nearest to `p`.
pub fn closest_point_on_segment(p: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let d = b - a;
    let length = d.length_squared();
    if length > 0.0 {
        a + d * ((p - a).dot(d) / length).clamp(0.0, 1.0)
    } else {
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix;
    use crate::shapes;

    fn random_point(rng: &mut SplitMix) -> DVec3 {
        DVec3::new(rng.unit(), rng.unit(), rng.unit()) * 2.0 - 1.0
    }

    #[test]
    fn points_of_polygons_are_those_of_their_nearest_sides() {
        let square =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        for ([x, y, z], nearest) in [
            ([1.0, -3.0, 1.0], [1.0, 0.0]),
            ([3.0, 3.0, 0.0], [2.0, 2.0]),
            // the last side
            ([0.25, 1.0, 0.0], [0.0, 1.0]),
        ] {
            let found = closest_point_on_polygon(DVec3::new(x, y, z), &square);
            assert_eq!(found, DVec3::new(nearest[0], nearest[1], 0.0));
        }
    }

    #[test]
    fn closest_point_agrees_with_brute_force() {
        let mut rng = SplitMix::new(1);
        let positions: Vec<DVec3> = (0..300).map(|_| random_point(&mut rng)).collect();
        let triangles: Vec<[u32; 3]> = (0..400)
            .map(|_| [0; 3].map(|_| rng.below(300) as u32)) // some degenerate on purpose
            .collect();
        let bvh = TriangleBvh::new(&positions, &triangles);
        for _ in 0..300 {
            let q = random_point(&mut rng) * 1.5;
            let brute = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|v| positions[v as usize]);
                    closest_point_on_triangle(q, a, b, c).distance(q)
                })
                .fold(f64::INFINITY, f64::min);
            let hit = bvh.closest_point(q).expect("not empty");
            assert_eq!(hit.distance, brute);
            assert_eq!(hit.point.distance(q), brute);
        }
    }

    #[test]
    fn walks_lead_to_the_closest_point() {
        let (positions, triangles) = shapes::sphere(800, 1);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("a sphere");
        let bvh = TriangleBvh::new(&mesh.positions, &triangles);
        let mut rng = SplitMix::new(5);
        for _ in 0..300 {
            // outside, where no other face is the nearest one around it
            let query = (1.0 + 0.6 * rng.unit()) * random_point(&mut rng).normalize();
            let nearest = bvh.closest_point(query).expect("not empty");
            let start = bvh.closest_point(query + 0.5 * random_point(&mut rng));
            let start = FaceId(start.expect("not empty").face);
            let found = closest_point_from(&mesh, start, query);
            assert!((found.distance - nearest.distance).abs() < 1e-14);
            assert!(found.point.distance(nearest.point) < 1e-7);
        }
    }

    #[test]
    fn closest_point_on_triangle_in_every_region() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        for (p, expected) in [
            (DVec3::new(0.25, 0.25, 3.0), DVec3::new(0.25, 0.25, 0.0)),
            (DVec3::new(-1.0, -1.0, 1.0), a),
            (DVec3::new(3.0, 0.5, -1.0), b),
            (DVec3::new(0.5, 3.0, -1.0), c),
            (DVec3::new(0.5, -2.0, 1.0), DVec3::new(0.5, 0.0, 0.0)),
            (DVec3::new(-2.0, 0.5, 1.0), DVec3::new(0.0, 0.5, 0.0)),
            (DVec3::new(1.0, 1.0, 7.0), DVec3::new(0.5, 0.5, 0.0)),
        ] {
            assert!((closest_point_on_triangle(p, a, b, c) - expected).length() < 1e-15);
        }
        let p = DVec3::new(2.0, 2.0, 0.0);
        // a needle whose normal is rounding
        let (near, middle) = (DVec3::new(0.9, 0.3, 0.0), DVec3::new(0.5, 1e-17, 1e-18));
        assert!(closest_point_on_triangle(near, a, middle, b).distance(0.9 * b) < 1e-15);
        assert_eq!(closest_point_on_triangle(p, a, a, b), b);
        assert_eq!(closest_point_on_triangle(p, b, b, b), b);
    }

    #[test]
    fn overlapping_boxes_agree_with_brute_force() {
        let mut rng = SplitMix::new(2);
        let positions: Vec<DVec3> = (0..600).map(|_| random_point(&mut rng)).collect();
        let triangles: Vec<[u32; 3]> = (0..200).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let bvh = TriangleBvh::new(&positions, &triangles);
        for _ in 0..100 {
            let p = random_point(&mut rng);
            let (low, high) = (p - 0.1, p + 0.1);
            let mut found = Vec::new();
            bvh.for_each_overlapping(low, high, |f| found.push(f));
            found.sort_unstable();
            let expected: Vec<u32> = (0..200u32)
                .filter(|&f| {
                    let t = triangles[f as usize].map(|v| positions[v as usize]);
                    let (l, h) = bounds(t.into_iter());
                    boxes_overlap(low, high, l, h)
                })
                .collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn empty_and_many_equal_triangles() {
        let none = TriangleBvh::new(&[], &[]);
        assert_eq!(none.closest_point(DVec3::ZERO), None);
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let bvh = TriangleBvh::new(&positions, &[[0, 1, 2]; 1000]);
        let hit = bvh.closest_point(DVec3::Z).expect("not empty");
        assert_eq!((hit.face, hit.distance), (0, 1.0));
    }
}
