//! Self-intersections of patches over several rims, and intersections with the mesh.

use std::sync::{Arc, OnceLock};

use rustc_hash::FxHashMap;

use crate::mesh::{DVec3, FaceId, Mesh, TriangleBvh, bounds, boxes_overlap, self_intersections};

/// Position of a vertex of the filled mesh, whose new vertices are at `new`.
pub(super) fn place(mesh: &Mesh, new: &[DVec3], v: u32) -> DVec3 {
    let at = v as usize;
    let given = mesh.positions.get(at).copied();
    given.unwrap_or_else(|| new[at - mesh.vertex_count()])
}

/// Number of holes from which a search tree is built, unless there is one, instead of reading all triangles for
/// each hole.
const MANY_HOLES: usize = 64;

/// The triangles of the mesh, to be searched for those that overlap a box.
#[derive(Clone, Debug, Default)]
pub(crate) struct Obstacles {
    /// The number of holes whose patches are checked.
    pub holes: usize,
    bvh: OnceLock<Arc<TriangleBvh>>,
}

impl Obstacles {
    /// For the checks of so many holes.
    pub fn new(holes: usize) -> Self {
        let bvh = OnceLock::new();
        Self { holes, bvh }
    }

    /// The search tree of the triangles, built when it is first needed.
    pub fn bvh(&self, mesh: &Mesh) -> &TriangleBvh {
        self.bvh.get_or_init(|| {
            let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
            Arc::new(TriangleBvh::new(&mesh.positions, &triangles))
        })
    }

    /// The triangles that overlap a box, in the order of the mesh.
    pub fn overlapping(&self, mesh: &Mesh, low: DVec3, high: DVec3) -> Vec<[u32; 3]> {
        if self.holes < MANY_HOLES && self.bvh.get().is_none() {
            // the sides of the box beyond which each vertex lies
            let beyond = |p: &DVec3| p.cmplt(low).bitmask() | p.cmpgt(high).bitmask() << 3;
            let beyond: Vec<u8> = mesh.positions.iter().map(|p| beyond(p) as u8).collect();
            let overlaps =
                |t: &[u32; 3]| t.iter().fold(!0, |all, &v| all & beyond[v as usize]) == 0;
            return mesh.topology.triangles().filter(overlaps).collect();
        }
        let mut faces = Vec::new();
        self.bvh(mesh)
            .for_each_overlapping(low, high, |f| faces.push(FaceId(f)));
        faces.sort_unstable();
        let corners = |f: FaceId| mesh.topology.face_vertices(f).map(|v| v.0);
        faces.into_iter().map(corners).collect()
    }
}

/// Intersections of the triangles `own` with each other, with the triangles `others` and with the
/// mesh: one place for every pair, at most `limit`. `own` and `others` are
/// [appended](super::assemble::appended_triangles) to the triangles of the mesh, with new vertices at `new`.
pub(super) fn intersections(
    mesh: &Mesh,
    obstacles: &Obstacles,
    own: &[[u32; 3]],
    others: &[[u32; 3]],
    new: &[DVec3],
    limit: usize,
) -> Vec<DVec3> {
    let (all, pairs) = intersecting_pairs(mesh, obstacles, own, others, new, 0.0, limit);
    let middle = |[f, g]: &[u32; 2]| all.centroid(*f).midpoint(all.centroid(*g));
    pairs.iter().map(middle).collect()
}

/// The pairs of triangles at which [`intersections`] finds them, and all triangles: `own` first, and those of the
/// mesh as far as `room` from the box of these.
pub(super) fn intersecting_pairs(
    mesh: &Mesh,
    obstacles: &Obstacles,
    own: &[[u32; 3]],
    others: &[[u32; 3]],
    new: &[DVec3],
    room: f64,
    limit: usize,
) -> (CompactTriangles, Vec<[u32; 2]>) {
    let place = |v: u32| place(mesh, new, v);
    let (low, high) = bounds(own.iter().flatten().map(|&v| place(v)));
    let mut all = own.to_vec();
    all.extend(others.iter().filter(|t| {
        let (other_low, other_high) = bounds(t.iter().map(|&v| place(v)));
        boxes_overlap(low, high, other_low, other_high)
    }));
    all.extend(obstacles.overlapping(mesh, low - room, high + room));
    let all = CompactTriangles::new(all, place);
    let subset: Vec<u32> = (0..own.len() as u32).collect();
    let pairs = self_intersections(&all.points, &all.triangles, Some(&subset), limit);
    (all, pairs)
}

/// Triangles with their own vertex numbers.
pub(super) struct CompactTriangles {
    /// The new number of each vertex, by its old one.
    numbers: FxHashMap<u32, u32>,
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl CompactTriangles {
    /// `place` gives the position of a vertex by its old number.
    pub fn new(mut triangles: Vec<[u32; 3]>, place: impl Fn(u32) -> DVec3) -> Self {
        let mut points = Vec::new();
        let mut numbers = FxHashMap::default();
        let mut number = |v: u32| {
            *numbers.entry(v).or_insert_with(|| {
                points.push(place(v));
                points.len() as u32 - 1
            })
        };
        for t in &mut triangles {
            *t = t.map(&mut number);
        }
        Self {
            numbers,
            points,
            triangles,
        }
    }

    /// The centroid of a triangle.
    pub fn centroid(&self, f: u32) -> DVec3 {
        let corners = self.triangles[f as usize].map(|v| self.points[v as usize]);
        corners.iter().sum::<DVec3>() / 3.0
    }

    /// The new number of a vertex, if a triangle has it.
    pub fn number(&self, v: u32) -> Option<u32> {
        self.numbers.get(&v).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::shapes;

    #[test]
    fn self_intersections_and_those_with_the_mesh_are_found() {
        let (positions, faces) = shapes::sphere(500, 1);
        let mesh = Mesh::from_triangles(positions, &faces).expect("a sphere");
        let old = mesh.vertex_count() as u32;
        let triangle = |at: DVec3, size: f64| [at, at + size * DVec3::Y, at + size * DVec3::Z];
        let look = |new: &[DVec3]| {
            let own: Vec<[u32; 3]> = (0..new.len() as u32 / 3)
                .map(|k| [0, 1, 2].map(|c| old + 3 * k + c))
                .collect();
            // both kinds of search
            let [few, many] = [1, MANY_HOLES]
                .map(|holes| intersections(&mesh, &Obstacles::new(holes), &own, &[], new, 100));
            assert_eq!(few, many);
            few
        };
        // inside, through the sphere, through one another
        assert!(look(&triangle(DVec3::ZERO, 0.5)).is_empty());
        let through = look(&triangle(DVec3::ZERO, 1.5));
        assert!(!through.is_empty());
        for place in through {
            assert!((0.6..1.2).contains(&place.length()), "{place}");
        }
        let mut two = triangle(DVec3::ZERO, 0.5).to_vec();
        two.extend([
            DVec3::new(-0.1, 0.1, 0.1),
            DVec3::new(0.1, 0.1, 0.1),
            DVec3::new(0.1, 0.12, 0.1),
        ]);
        let found = look(&two);
        assert_eq!(found.len(), 1);
        assert!(found[0].length() < 0.3);
    }
}
