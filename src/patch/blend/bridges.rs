//! Rims cut open along bridges into one polygon, for rims that overlap from every point of view.

use crate::mesh::DVec3;
use crate::patch::data::Rim;
use crate::patch::surface::Surface;
use crate::patch::triangulate::triangulate;

/// A surface between the rims. Bridges join the rims, nearest first, at their nearest vertices. The
/// walk around all rims and, twice, along the bridges is one polygon. It is triangulated like the
/// rim of a hole and sewn together along the bridges. Bridges and minimum weight thus decide how
/// two rims are twisted against each other.
///
/// `chords` are pairs of vertices already joined by an edge of the mesh. They and edges that join
/// the same vertices twice may remain: the caller splits them. O(N²) for N rim vertices, plus the
/// triangulation.
pub(super) fn surface(rims: &[Rim], chords: &[[u32; 2]]) -> Surface {
    let points: Vec<DVec3> = rims.iter().flat_map(|r| r.points.iter().copied()).collect();
    let polygon = Polygon::around(rims, &points);
    let copies = Rim {
        points: polygon.name.iter().map(|&v| points[v as usize]).collect(),
        opposite: polygon.opposite(rims, &points),
        forbidden: polygon.forbidden(chords),
    };
    let triangles = triangulate(&copies);
    let count = polygon.name.len();
    let mut surface = Surface::new(copies.points, vec![0.0; count], count, &triangles);
    surface.sew(&polygon.name, points, &polygon.bridges);
    surface
}

/// Factor on the squared length of a bridge from a vertex that has one already.
const SECOND: f64 = 4.0;

/// The polygon of vertex copies.
struct Polygon {
    /// The rim vertex each corner is a copy of.
    name: Vec<u32>,
    /// Pairs of polygon edges (numbered by where they start) that are the two sides of a bridge.
    bridges: Vec<[u32; 2]>,
}

impl Polygon {
    fn around(rims: &[Rim], points: &[DVec3]) -> Self {
        let start: Vec<u32> = rims
            .iter()
            .scan(0, |next, r| {
                let first = *next;
                *next += r.points.len() as u32;
                Some(first)
            })
            .collect();
        let vertices = |k: usize| start[k]..start[k] + rims[k].points.len() as u32;
        let mut name: Vec<u32> = vertices(0).collect();
        let mut ends: Vec<[u32; 2]> = Vec::new();
        let mut waiting: Vec<usize> = (1..rims.len()).collect();
        while !waiting.is_empty() {
            let taken = |v: u32| ends.iter().flatten().any(|&e| e == v);
            let (mut best, mut least) = ((0, 0, 0), f64::INFINITY);
            for (w, &k) in waiting.iter().enumerate() {
                for (i, &a) in name.iter().enumerate() {
                    for b in vertices(k) {
                        let mut d = points[a as usize].distance_squared(points[b as usize]);
                        if taken(a) {
                            d *= SECOND;
                        }
                        if d < least {
                            (best, least) = ((w, i, b), d);
                        }
                    }
                }
            }
            let (w, i, b) = best;
            let k = waiting.remove(w);
            ends.push([name[i], b]);
            let n = rims[k].points.len() as u32;
            let around = (0..=n).map(|s| start[k] + (b - start[k] + s) % n);
            let detour: Vec<u32> = around.chain([name[i]]).collect();
            let after = i + 1;
            name.splice(after..after, detour);
        }
        let bridges = bridge_edges(&name, &ends);
        Self { name, bridges }
    }

    /// Third vertices of the faces across the polygon's edges. Bridges have no face: theirs is
    /// degenerate and has no influence.
    fn opposite(&self, rims: &[Rim], points: &[DVec3]) -> Vec<DVec3> {
        let across: Vec<DVec3> = rims
            .iter()
            .flat_map(|r| r.opposite.iter().copied())
            .collect();
        let is_bridge = self.is_bridge();
        (0..self.name.len())
            .map(|i| {
                let v = self.name[i] as usize;
                if is_bridge[i] { points[v] } else { across[v] }
            })
            .collect()
    }

    fn is_bridge(&self) -> Vec<bool> {
        let mut is_bridge = vec![false; self.name.len()];
        for &e in self.bridges.iter().flatten() {
            is_bridge[e as usize] = true;
        }
        is_bridge
    }

    /// Pairs of corners that must not be joined: copies of the same vertex, and copies of vertices
    /// that the mesh, a rim or a bridge joins already.
    fn forbidden(&self, chords: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let n = self.name.len();
        let mut copies: Vec<(u32, u32)> =
            (0..n as u32).map(|i| (self.name[i as usize], i)).collect();
        copies.sort_unstable();
        let of = |v: u32| {
            let from = copies.partition_point(|c| c.0 < v);
            let to = copies.partition_point(|c| c.0 <= v);
            &copies[from..to]
        };
        let edges = (0..n).map(|i| [self.name[i], self.name[(i + 1) % n]]);
        let mut forbidden = Vec::new();
        let same = copies.iter().map(|c| [c.0, c.0]);
        for [a, b] in edges.chain(chords.iter().copied()).chain(same) {
            for &(_, i) in of(a) {
                for &(_, j) in of(b) {
                    let [i, j] = [i.min(j), i.max(j)];
                    let is_side = j == i + 1 || (i == 0 && j as usize == n - 1);
                    if i != j && !is_side {
                        forbidden.push([i, j]);
                    }
                }
            }
        }
        forbidden.sort_unstable();
        forbidden.dedup();
        forbidden
    }
}

/// Where each bridge and its other side start in the polygon.
fn bridge_edges(name: &[u32], ends: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let n = name.len();
    let find = |a: u32, b: u32| {
        (0..n)
            .find(|&i| name[i] == a && name[(i + 1) % n] == b)
            .unwrap_or(0) as u32
    };
    ends.iter()
        .map(|&[a, b]| [find(a, b), find(b, a)])
        .collect()
}
