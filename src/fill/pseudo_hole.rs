//! Pseudo-holes: known discs of the mesh around a hole, from which predictions are made.

use rustc_hash::FxHashSet;

use crate::fill::hole::HoleRims;
use crate::mesh::{DVec3, Mesh, Neighbourhood, VertexId, bounds, rms_distance, vertex_normal};
use crate::solver::G2_RINGS;

/// Radius of a pseudo-hole, in hole radii. On scans with known truth 0.8 chose better than 0.5 and
/// 1.0 (measured on `real/`).
const SIZE: f64 = 0.8;
/// Distance from the centre of the hole, in hole radii, within which pseudo-holes lie. 2.5 chose
/// better than 4; the larger ones are for holes without enough surroundings.
const REACH: [f64; 3] = [2.5, 4.0, 8.0];
/// Number of pseudo-holes of a hole, and the least number before the reach is enlarged.
const DISCS: [usize; 2] = [20, 5];
/// Rings of known vertices between a pseudo-hole and the nearest boundary.
const MARGIN: usize = 3;
/// Most vertices of a pseudo-hole, and of all of a hole.
const MOST_VERTICES: [usize; 2] = [150, 3000];
/// Most vertices among which the pseudo-holes of a hole are found.
const MOST_NEAR: usize = 12_000;
/// A pseudo-hole.
pub(super) struct Disc {
    /// Its vertices, which are ring 0, and the rings around them.
    pub region: Neighbourhood,
    /// Unit normals at its vertices.
    pub normals: Vec<DVec3>,
    /// RMS distance of its rim from the mean of the rim.
    pub radius: f64,
}

impl Disc {
    /// The positions of the vertices of the region.
    pub fn positions(&self, mesh: &Mesh) -> Vec<Option<DVec3>> {
        let vertices = self.region.vertices().iter();
        vertices.map(|&v| Some(mesh.position(v))).collect()
    }
}

/// The vertices around a hole, and its pseudo-holes among them.
pub(super) fn discs(mesh: &Mesh, rims: &HoleRims) -> (Vec<VertexId>, Vec<Disc>) {
    let rim = &rims.vertices;
    let centre = rims.loops[0].centroid;
    let radius = rims.radius();
    let mut best = (Vec::new(), Vec::new());
    for reach in REACH {
        let near = connected(mesh, rim.iter().copied(), MOST_NEAR, |p| {
            p.distance(centre) < reach * radius
        });
        let found = discs_at(mesh, &near, centre, SIZE * radius);
        if found.len() > best.1.len() {
            best = (near, found);
        }
        if best.1.len() >= DISCS[1] {
            break;
        }
    }
    best
}

/// Pseudo-holes around some of the vertices `near`: the one nearest to `centre`, then each time the
/// one farthest from those before.
fn discs_at(mesh: &Mesh, near: &[VertexId], centre: DVec3, size: f64) -> Vec<Disc> {
    let topology = &mesh.topology;
    let boundary = near
        .iter()
        .copied()
        .filter(|&v| topology.is_boundary_vertex(v));
    let blocked = Neighbourhood::without_faces(topology, boundary, MARGIN - 1);
    let blocked: FxHashSet<VertexId> = blocked.vertices().iter().copied().collect();
    let near: Vec<VertexId> = near
        .iter()
        .copied()
        .filter(|v| !blocked.contains(v))
        .collect();
    let mut out: Vec<Disc> = Vec::new();
    let mut total = 0;
    let mut apart: Vec<f64> = vec![f64::INFINITY; near.len()];
    let nearest = |&i: &usize, &j: &usize| {
        let d = |k: usize| mesh.position(near[k]).distance_squared(centre);
        d(i).total_cmp(&d(j))
    };
    let mut next = (0..near.len()).min_by(nearest);
    for _ in 0..3 * DISCS[0] {
        let Some(i) = next else { break };
        let at = mesh.position(near[i]);
        if let Some(disc) = disc_at(mesh, near[i], size, &blocked) {
            total += disc.normals.len();
            out.push(disc);
        }
        if out.len() >= DISCS[0] || total > MOST_VERTICES[1] {
            break;
        }
        for (d, &v) in apart.iter_mut().zip(&near) {
            *d = d.min(mesh.position(v).distance_squared(at));
        }
        let farthest = |&i: &usize, &j: &usize| apart[i].total_cmp(&apart[j]);
        next = (0..near.len()).max_by(farthest).filter(|&k| apart[k] > 0.0);
    }
    out
}

/// Vertices connected to `seeds` through vertices that are `inside`, in the order of a search that
/// ends once there are `most`.
fn connected(
    mesh: &Mesh,
    seeds: impl Iterator<Item = VertexId>,
    most: usize,
    inside: impl Fn(DVec3) -> bool,
) -> Vec<VertexId> {
    let mut found: Vec<VertexId> = seeds.collect();
    let mut seen: FxHashSet<VertexId> = found.iter().copied().collect();
    let mut next = 0;
    while next < found.len() && found.len() < most {
        for w in mesh.topology.neighbours(found[next]) {
            if inside(mesh.position(w)) && seen.insert(w) {
                found.push(w);
            }
        }
        next += 1;
    }
    found
}

/// The pseudo-hole of the vertices within `size` of a vertex. `None` if it has fewer than three
/// vertices or lies too near to a boundary; `blocked` are vertices known to.
fn disc_at(mesh: &Mesh, v: VertexId, size: f64, blocked: &FxHashSet<VertexId>) -> Option<Disc> {
    let at = mesh.position(v);
    let is_inside = |p: DVec3| p.distance(at) < size;
    let mut inside = connected(mesh, std::iter::once(v), MOST_VERTICES[0], is_inside);
    inside.truncate(MOST_VERTICES[0]);
    if inside.len() < 3 || inside.iter().any(|v| blocked.contains(v)) {
        return None;
    }
    sort_along(mesh, &mut inside);
    let region = Neighbourhood::without_faces(&mesh.topology, inside.iter().copied(), G2_RINGS);
    let is_boundary = |&v: &VertexId| mesh.topology.is_boundary_vertex(v);
    if region.rings().take(MARGIN).flatten().any(is_boundary) {
        return None;
    }
    let rim: Vec<DVec3> = region
        .rings()
        .nth(1)?
        .iter()
        .map(|&v| mesh.position(v))
        .collect();
    let middle = rim.iter().sum::<DVec3>() / rim.len() as f64;
    let radius = rms_distance(rim.iter().copied(), middle);
    if !(radius.is_finite() && radius > 0.0) {
        return None;
    }
    let normal = |&v: &VertexId| vertex_normal(&mesh.topology, v, |v| mesh.position(v));
    let normal = |v| normal(v).unwrap_or_default();
    Some(Disc {
        normals: inside.iter().map(normal).collect(),
        region,
        radius,
    })
}

/// Sorts vertices along the longest side of their bounding box.
fn sort_along(mesh: &Mesh, vertices: &mut [VertexId]) {
    let (low, high) = bounds(vertices.iter().map(|&v| mesh.position(v)));
    let axis = (high - low).max_position();
    vertices.sort_by(|&v, &w| {
        let [p, q] = [v, w].map(|v| mesh.position(v)[axis]);
        p.total_cmp(&q).then(v.cmp(&w))
    });
}
