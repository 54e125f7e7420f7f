//! Smoothing: vertices move towards the mean of their neighbours and back onto the surface.

use super::TriangleMesh;
use super::flip::delaunay_flips;
use crate::mesh::DVec3;
use crate::random::SplitMix;

/// Fraction of the distance to the neighbours' mean that a vertex moves in one sweep.
const STEP: f64 = 0.7;

/// Moves every vertex not on a boundary by up to `amount` of its mean edge length in a random
/// direction, then puts it back onto the surface.
pub fn jitter(shape: &mut TriangleMesh, amount: f64, seed: u64, project: impl Fn(DVec3) -> DVec3) {
    let mut rng = SplitMix::new(seed);
    let ring = Adjacency::new(shape);
    let old = shape.0.clone();
    for v in 0..old.len() {
        let push = rng.direction() * rng.unit().sqrt();
        if ring.is_inside[v] {
            let (_, length) = ring.mean(&old, v);
            shape.0[v] = project(old[v] + push * amount * length);
        }
    }
}

/// `sweeps` times: Delaunay flips, then Jacobi smoothing of vertices not on a boundary, each put
/// back by `project`.
pub fn relax(shape: &mut TriangleMesh, sweeps: usize, project: impl Fn(DVec3) -> DVec3) {
    for _ in 0..sweeps {
        delaunay_flips(&shape.0, &mut shape.1);
        let ring = Adjacency::new(shape);
        let old = shape.0.clone();
        for v in 0..old.len() {
            if ring.is_inside[v] {
                let (mean, _) = ring.mean(&old, v);
                shape.0[v] = project(old[v].lerp(mean, STEP));
            }
        }
    }
    delaunay_flips(&shape.0, &mut shape.1);
}

/// Neighbours of all vertices, in one array.
pub struct Adjacency {
    start: Vec<u32>,
    neighbours: Vec<u32>,
    is_inside: Vec<bool>,
}

impl Adjacency {
    /// Every directed edge of a face gives its start a neighbour: inside, each exactly once.
    pub fn new((positions, triangles): &TriangleMesh) -> Self {
        let mut start = vec![0u32; positions.len() + 1];
        for v in triangles.iter().flatten() {
            start[*v as usize + 1] += 1;
        }
        for v in 0..positions.len() {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut neighbours = vec![0; 3 * triangles.len()];
        // outgoing and incoming neighbours are the same set, unless the vertex is on a boundary
        let mut balance = vec![0u64; positions.len()];
        for t in triangles {
            for k in 0..3 {
                let (v, out, back) = (t[k] as usize, t[(k + 1) % 3], t[(k + 2) % 3]);
                neighbours[fill[v] as usize] = out;
                fill[v] += 1;
                balance[v] = balance[v].wrapping_add(hash(out)).wrapping_sub(hash(back));
            }
        }
        let is_inside = (0..positions.len())
            .map(|v| balance[v] == 0 && start[v + 1] > start[v])
            .collect();
        Self {
            start,
            neighbours,
            is_inside,
        }
    }

    /// The neighbours of `v`; on a boundary one may be missing.
    pub fn of(&self, v: u32) -> &[u32] {
        &self.neighbours[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }

    /// Mean position of the neighbours, and mean distance to them.
    fn mean(&self, positions: &[DVec3], v: usize) -> (DVec3, f64) {
        let ring = self.of(v as u32);
        let (mut sum, mut length) = (DVec3::ZERO, 0.0);
        for &w in ring {
            sum += positions[w as usize];
            length += positions[w as usize].distance(positions[v]);
        }
        (sum / ring.len() as f64, length / ring.len() as f64)
    }
}

fn hash(v: u32) -> u64 {
    SplitMix::new(u64::from(v)).next_u64()
}
