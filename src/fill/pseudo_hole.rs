//! Pseudo-holes: known discs of the mesh around a hole, from which predictions are made.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::fill::hole::HoleRims;
use crate::mesh::{DVec3, Mesh, VertexId, bounds, rms_distance, vertex_normal};
use crate::solver::{G2_RINGS, Laplacian};

/// Radius of a pseudo-hole, in hole radii. On scans with known truth 0.8 chose better than 0.5 and
/// 1.0 (measured on `real/`); the smaller ones are for holes without room for any of that radius.
const SIZES: [f64; 2] = [0.8, 0.4];
/// Distance from the centre of the hole, in hole radii, within which pseudo-holes lie. 2.5 chose
/// better than 4; the larger ones are for holes without enough surroundings.
const REACH: [f64; 3] = [2.5, 4.0, 8.0];
/// Number of pseudo-holes of a hole, and the least number before the reach is enlarged.
const DISCS: [usize; 2] = [20, 5];
/// Rings of known vertices between a pseudo-hole and the nearest boundary.
const MARGIN: usize = 3;
/// Maximum number of vertices of a pseudo-hole, and of all of a hole.
const MAX_VERTICES: [usize; 2] = [150, 3000];
/// Maximum number of vertices among which the pseudo-holes of a hole are found.
const MAX_NEAR: usize = 12_000;

/// Squared error of a failed prediction: one radius.
pub(super) const FAILED: f64 = 1.0;

/// A pseudo-hole.
pub(super) struct Disc {
    /// Its vertices and the rings around them, in numbers of the [`Surroundings`].
    pub vertices: Vec<u32>,
    /// The ends of its vertices and of each ring.
    pub ends: [usize; G2_RINGS + 1],
    /// Unit normals at its vertices.
    pub normals: Vec<DVec3>,
    /// RMS distance of its rim from the mean of the rim.
    pub radius: f64,
    /// The [turning] of its rim.
    pub turning: f64,
}

impl Disc {
    /// Mean square of distances at the vertices, relative to the radius.
    pub fn mean_square(&self, distances: impl Iterator<Item = f64>) -> f64 {
        let sum: f64 = distances.map(|d| d * d).sum();
        sum / (self.normals.len() as f64 * self.radius * self.radius)
    }
}

/// The vertices around a hole, in numbers of their own, and its pseudo-holes.
pub(super) struct Surroundings {
    /// The vertices of the mesh.
    pub vertices: Vec<VertexId>,
    /// Their positions.
    pub points: Vec<DVec3>,
    /// The vertices near the hole, from its rim outwards.
    pub near: Vec<u32>,
    /// The pseudo-holes.
    pub discs: Vec<Disc>,
    /// The [turning] of the rims of the hole.
    pub turning: f64,
    /// The Laplacian at the vertices of the discs and of all rings around them but the last.
    pub laplacian: Laplacian,
}

impl Surroundings {
    /// Those of the hole with some rims.
    pub fn new(mesh: &Mesh, rims: &HoleRims) -> Self {
        let centre = rims.loops[0].centroid;
        let radius = rims.radius();
        let mut search = Search::new(mesh);
        let rim: Vec<u32> = rims.vertices.iter().map(|&v| search.number(v)).collect();
        let mut best = (Vec::new(), Vec::new());
        for size in SIZES {
            for reach in REACH {
                let is_near = |p: DVec3| p.distance(centre) < reach * radius;
                let near = search.connected(&rim, MAX_NEAR, is_near);
                let found = search.discs(&near, centre, size * radius);
                if found.len() > best.1.len() {
                    best = (near, found);
                }
                if best.1.len() >= DISCS[1] {
                    break;
                }
            }
            if !best.1.is_empty() {
                break;
            }
        }
        let (near, discs) = best;
        let normal = |&v: &VertexId| vertex_normal(&mesh.topology, v, |v| mesh.position(v));
        let normals = rims.vertices.iter().filter_map(normal);
        let turning = turning(normals, rims.vertices.len());
        let laplacian = search.laplacian(&discs);
        Self {
            vertices: search.vertices,
            points: search.points,
            near,
            discs,
            turning,
            laplacian,
        }
    }

    /// How much the mean curvature varies: the standard deviation of its means over the pseudo-holes, over their
    /// RMS. Over a pseudo-hole the errors of the curvatures at single vertices nearly cancel.
    pub fn curvature_variation(&self) -> f64 {
        let mean = |disc: &Disc| {
            let vertices = disc.vertices.iter().zip(&disc.normals);
            let parts = vertices.map(|(&v, normal)| {
                let (vector, area) = self.laplacian.curvature(&self.points, v as usize);
                (0.5 * vector.dot(*normal), area)
            });
            let (sum, area) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
            sum / area
        };
        let means: Vec<f64> = self.discs.iter().map(mean).collect();
        let count = means.len() as f64;
        let average = means.iter().sum::<f64>() / count;
        let square = means.iter().map(|h| h * h).sum::<f64>() / count;
        let variation = ((square - average * average).max(0.0) / square).sqrt();
        if variation.is_finite() {
            variation
        } else {
            0.0
        }
    }

    /// The turning of the rims of the hole over the mean of its pseudo-holes, 1 on a plane. The squared error
    /// of a fill is about proportional to it (measured; docs/decisions.md).
    pub fn turning_ratio(&self) -> f64 {
        let mean =
            self.discs.iter().map(|disc| disc.turning).sum::<f64>() / self.discs.len() as f64;
        let ratio = (self.turning + FLAT * mean) / (1.0 + FLAT) / mean;
        if ratio.is_finite() { ratio } else { 1.0 }
    }
}

/// Share of the turning of pseudo-holes below which that of a hole means little: the surface inside a flat
/// rim need not be flat.
const FLAT: f64 = 0.1;

/// How much unit normals along a rim of `count` vertices turn: 1 less the length of their mean, 0 for a flat rim.
fn turning(normals: impl Iterator<Item = DVec3>, count: usize) -> f64 {
    1.0 - normals.sum::<DVec3>().length() / count as f64
}

/// A search in the vertices around a hole, which get numbers as they are reached.
struct Search<'a> {
    mesh: &'a Mesh,
    numbers: FxHashMap<VertexId, u32>,
    vertices: Vec<VertexId>,
    points: Vec<DVec3>,
    /// Unit normals, if they were needed so far; 0 for none.
    normals: Vec<Option<DVec3>>,
    on_boundary: Vec<bool>,
    /// Where the neighbours of each vertex are in `around`, if they were needed so far.
    neighbours: Vec<Option<Range<usize>>>,
    around: Vec<u32>,
    /// The last breadth-first search that reached each vertex.
    marks: Vec<u32>,
    searches: u32,
}

impl<'a> Search<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            numbers: FxHashMap::default(),
            vertices: Vec::new(),
            points: Vec::new(),
            normals: Vec::new(),
            on_boundary: Vec::new(),
            neighbours: Vec::new(),
            around: Vec::new(),
            marks: Vec::new(),
            searches: 0,
        }
    }

    /// The number of a vertex.
    fn number(&mut self, v: VertexId) -> u32 {
        let next = self.vertices.len() as u32;
        let number = *self.numbers.entry(v).or_insert(next);
        if number == next {
            self.vertices.push(v);
            self.points.push(self.mesh.position(v));
            self.normals.push(None);
            self.on_boundary
                .push(self.mesh.topology.is_boundary_vertex(v));
            self.neighbours.push(None);
            self.marks.push(0);
        }
        number
    }

    /// Where the neighbours of a vertex are in `around`, in cyclic order.
    fn neighbours(&mut self, v: u32) -> Range<usize> {
        if let Some(range) = &self.neighbours[v as usize] {
            return range.clone();
        }
        let mesh = self.mesh;
        let begin = self.around.len();
        for w in mesh.topology.neighbours(self.vertices[v as usize]) {
            let w = self.number(w);
            self.around.push(w);
        }
        let range = begin..self.around.len();
        self.neighbours[v as usize] = Some(range.clone());
        range
    }

    /// The unit normal at a vertex; 0 for none.
    fn normal(&mut self, v: u32) -> DVec3 {
        let (mesh, id) = (self.mesh, self.vertices[v as usize]);
        let normal = || vertex_normal(&mesh.topology, id, |v| mesh.position(v));
        *self.normals[v as usize].get_or_insert_with(|| normal().unwrap_or_default())
    }

    /// Begins a breadth-first search.
    fn begin(&mut self) {
        self.searches += 1;
    }

    /// Whether the present search reaches a vertex for the first time.
    fn reaches(&mut self, v: u32) -> bool {
        let mark = &mut self.marks[v as usize];
        std::mem::replace(mark, self.searches) != self.searches
    }

    /// Vertices connected to `seeds` through vertices that are `inside`, in the order of a search that
    /// ends once there are `most`.
    fn connected(
        &mut self,
        seeds: &[u32],
        most: usize,
        inside: impl Fn(DVec3) -> bool,
    ) -> Vec<u32> {
        self.begin();
        let mut found = seeds.to_vec();
        found.retain(|&v| self.reaches(v));
        let mut next = 0;
        while next < found.len() && found.len() < most {
            for at in self.neighbours(found[next]) {
                let w = self.around[at];
                if inside(self.points[w as usize]) && self.reaches(w) {
                    found.push(w);
                }
            }
            next += 1;
        }
        found
    }

    /// Appends the ring of vertices around all `found` ones, of which those before `from` have no other
    /// neighbours.
    fn add_ring(&mut self, found: &mut Vec<u32>, from: usize) {
        for i in from..found.len() {
            for at in self.neighbours(found[i]) {
                let w = self.around[at];
                if self.reaches(w) {
                    found.push(w);
                }
            }
        }
    }

    /// Pseudo-holes around some of the vertices `near`: the one nearest to `centre`, then each time the
    /// one farthest from those before.
    fn discs(&mut self, near: &[u32], centre: DVec3, size: f64) -> Vec<Disc> {
        let is_boundary = |v: &u32| self.on_boundary[*v as usize];
        let mut blocked: Vec<u32> = near.iter().copied().filter(is_boundary).collect();
        self.begin();
        blocked.retain(|&v| self.reaches(v));
        let mut from = 0;
        for _ in 1..MARGIN {
            let end = blocked.len();
            self.add_ring(&mut blocked, from);
            from = end;
        }
        let mut is_blocked = vec![false; self.vertices.len()];
        for v in blocked {
            is_blocked[v as usize] = true;
        }
        let is_free = |v: &u32| !is_blocked[*v as usize];
        let near: Vec<u32> = near.iter().copied().filter(is_free).collect();
        let mut out: Vec<Disc> = Vec::new();
        let mut total = 0;
        let places: Vec<DVec3> = near.iter().map(|&v| self.points[v as usize]).collect();
        // squared distances from the nearest pseudo-hole so far
        let mut apart: Vec<f64> = vec![f64::INFINITY; near.len()];
        let from_centre = places.iter().map(|p| p.distance_squared(centre));
        let distances: Vec<f64> = from_centre.collect();
        let mut next = (0..near.len()).min_by(|&i, &j| distances[i].total_cmp(&distances[j]));
        for _ in 0..3 * DISCS[0] {
            let Some(i) = next else { break };
            if let Some(disc) = self.disc(near[i], size, &is_blocked) {
                total += disc.normals.len();
                out.push(disc);
            }
            if out.len() >= DISCS[0] || total > MAX_VERTICES[1] {
                break;
            }
            let at = places[i];
            let mut farthest = 0.0;
            next = None;
            for (k, (d, p)) in apart.iter_mut().zip(&places).enumerate() {
                *d = d.min(p.distance_squared(at));
                if *d > 0.0 && *d >= farthest {
                    farthest = *d;
                    next = Some(k);
                }
            }
        }
        out
    }

    /// The pseudo-hole of the vertices within `size` of a vertex. `None` if it has fewer than three
    /// vertices or lies too near to a boundary; vertices that are `blocked` are known to.
    fn disc(&mut self, v: u32, size: f64, blocked: &[bool]) -> Option<Disc> {
        let at = self.points[v as usize];
        let is_inside = |p: DVec3| p.distance(at) < size;
        let mut vertices = self.connected(&[v], MAX_VERTICES[0], is_inside);
        vertices.truncate(MAX_VERTICES[0]);
        let is_blocked = |v: &u32| blocked.get(*v as usize).is_some_and(|&blocked| blocked);
        if vertices.len() < 3 || vertices.iter().any(is_blocked) {
            return None;
        }
        self.sort_along(&mut vertices);
        self.begin();
        for &v in &vertices {
            self.reaches(v);
        }
        let mut ends = [vertices.len(); G2_RINGS + 1];
        for k in 1..=G2_RINGS {
            let from = if k == 1 { 0 } else { ends[k - 2] };
            if vertices[from..]
                .iter()
                .any(|&v| self.on_boundary[v as usize])
            {
                return None;
            }
            self.add_ring(&mut vertices, from);
            ends[k] = vertices.len();
        }
        let rim = vertices[ends[0]..ends[1]].iter();
        let rim: Vec<DVec3> = rim.map(|&v| self.points[v as usize]).collect();
        let middle = rim.iter().sum::<DVec3>() / rim.len() as f64;
        let radius = rms_distance(rim.iter().copied(), middle);
        if !(radius.is_finite() && radius > 0.0) {
            return None;
        }
        let rim = &vertices[ends[0]..ends[1]];
        Some(Disc {
            turning: turning(rim.iter().map(|&v| self.normal(v)), rim.len()),
            normals: vertices[..ends[0]]
                .iter()
                .map(|&v| self.normal(v))
                .collect(),
            vertices,
            ends,
            radius,
        })
    }

    /// Sorts vertices along the longest side of their bounding box.
    fn sort_along(&self, vertices: &mut [u32]) {
        let point = |v: u32| self.points[v as usize];
        let (low, high) = bounds(vertices.iter().map(|&v| point(v)));
        let axis = (high - low).max_position();
        vertices.sort_by(|&v, &w| {
            let by_number = || self.vertices[v as usize].cmp(&self.vertices[w as usize]);
            point(v)[axis]
                .total_cmp(&point(w)[axis])
                .then_with(by_number)
        });
    }

    /// The Laplacian at the vertices of discs and of all rings around them but the last.
    fn laplacian(&self, discs: &[Disc]) -> Laplacian {
        let mut is_needed = vec![false; self.vertices.len()];
        let inner = discs
            .iter()
            .flat_map(|disc| &disc.vertices[..disc.ends[G2_RINGS - 1]]);
        for &v in inner {
            is_needed[v as usize] = true;
        }
        Laplacian::new(&self.points, |i| match &self.neighbours[i] {
            Some(range) if is_needed[i] => &self.around[range.clone()],
            _ => &[],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::boundary_loops;
    use crate::shapes;

    /// The surroundings of the first hole of a mesh.
    fn surroundings(mesh: &Mesh) -> Surroundings {
        let loops = boundary_loops(mesh);
        let hole = loops.iter().find(|l| !l.is_outer_boundary);
        Surroundings::new(mesh, &HoleRims::new(mesh, &[hole.expect("a hole")]))
    }

    #[test]
    fn turning_of_a_circle_on_a_sphere_is_one_less_the_cosine() {
        let (positions, triangles) = shapes::cut_where(&shapes::icosphere(24), |p| p.z > 0.7);
        let turned = positions.iter().map(|p| DVec3::new(5.0 + p.y, p.z, p.x));
        for positions in [positions.clone(), turned.collect()] {
            let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
            let around = surroundings(&mesh);
            // the rim is within an edge of z = 0.7, and its normals are those of the faces beyond
            assert!((around.turning - 0.3).abs() < 0.06, "{}", around.turning);
            for disc in &around.discs {
                let expected = 1.0 - (1.0 - disc.radius * disc.radius).sqrt();
                assert!((disc.turning - expected).abs() < 0.1 * expected);
            }
        }
    }

    #[test]
    fn pseudo_holes_are_smaller_where_there_is_no_room() {
        let radii = |size: f64| {
            let plane = shapes::plane(size, 40, 1);
            let (positions, triangles) = shapes::cut_where(&plane, |p| p.x.hypot(p.y) < 0.5);
            let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
            let discs = surroundings(&mesh).discs;
            discs.iter().map(|disc| disc.radius).collect::<Vec<f64>>()
        };
        // the rim of a disc is about half an edge beyond its radius
        for (size, part) in [(4.0, SIZES[0]), (2.0, SIZES[1])] {
            let radii = radii(size);
            let edge = size / 40.0;
            assert!(!radii.is_empty());
            for radius in radii {
                assert!((radius - 0.5 * part).abs() < edge, "{size}: {radius}");
            }
        }
    }

    #[test]
    fn the_mean_curvature_varies_unless_it_is_constant() {
        let variation = |(positions, triangles): (Vec<DVec3>, Vec<[u32; 3]>)| {
            let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
            surroundings(&mesh).curvature_variation()
        };
        let side = |p: DVec3| p.x > 0.9;
        let sphere = shapes::cut_where(&shapes::sphere(2000, 1), side);
        let of_sphere = variation(sphere.clone());
        assert!(of_sphere < 0.02, "{of_sphere}");
        // of the ellipsoid with half-axes 1, 1 and 2: H is 0.625 at the equator and 2 at the poles
        let (mut positions, triangles) = sphere;
        for p in &mut positions {
            p.z *= 2.0;
        }
        let of_ellipsoid = variation((positions, triangles));
        assert!(of_ellipsoid > 0.1, "{of_ellipsoid}");
    }

    #[test]
    fn larger_holes_of_a_sphere_turn_more_than_their_pseudo_holes() {
        let mesh = |top: f64| {
            let (positions, triangles) = shapes::cut_where(&shapes::icosphere(24), |p| p.z > top);
            Mesh::from_triangles(positions, &triangles).expect("a manifold")
        };
        // turnings of small holes are as the squares of the radii, and a rim has a ring more than its disc
        let ratio = surroundings(&mesh(0.95)).turning_ratio();
        assert!(
            (1.0..1.0 / (SIZES[0] * SIZES[0])).contains(&ratio),
            "{ratio}"
        );
        let plane = shapes::plane(1.0, 20, 1);
        let (positions, triangles) = shapes::cut_where(&plane, |p| p.x.abs() + p.y.abs() < 0.2);
        let plane = Mesh::from_triangles(positions, &triangles).expect("a manifold");
        assert_eq!(surroundings(&plane).turning_ratio(), 1.0);
    }
}
