//! Cutting holes into a mesh.

use std::collections::BTreeMap;

use glam::DVec2;

use super::TriangleMesh;
pub use super::outline::HoleShape;
use super::outline::Outline;
use super::relax::Adjacency;
use crate::mesh::union_find::{find, unite};
use crate::mesh::{DVec3, vertex_normals};

/// A hole to cut: an outline mapped onto the surface around a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// The position; the nearest vertex is used.
    pub centre: DVec3,
    /// The outline.
    pub shape: HoleShape,
    /// Turn of the outline about the normal, in radians.
    pub turn: f64,
    /// Seed of outlines with random parts.
    pub seed: u64,
}

/// Removes the faces whose middle lies inside the outline of a hole, the largest connected set of
/// them, so that each hole has one rim. Outlines are laid out in geodesic polar coordinates around
/// their centre (discrete exponential map: Schmidt, Grimm and Wyvill 2006). The rest is cleaned as
/// in [`cut_where`]; vertices keep their order.
pub fn cut_holes(shape: &TriangleMesh, holes: &[Hole]) -> TriangleMesh {
    let rings = Adjacency::new(shape);
    let normals = vertex_normals(&shape.0, shape.1.iter().copied());
    let mut removed = vec![false; shape.1.len()];
    for hole in holes {
        let outline = Outline::new(&hole.shape, hole.seed);
        let chart = chart_around(shape, &rings, &normals, hole.centre, outline.reach());
        let turn = DVec2::from_angle(-hole.turn);
        let mut inside = Vec::new();
        for (f, t) in shape.1.iter().enumerate() {
            let mut middle = DVec2::ZERO;
            let mut known = 0;
            for v in t {
                if let Some(&at) = chart.get(v) {
                    middle += at / 3.0;
                    known += 1;
                }
            }
            if known == 3 && outline.contains(turn.rotate(middle)) {
                inside.push(f as u32);
            }
        }
        for f in largest_piece(&shape.1, &inside) {
            removed[f as usize] = true;
        }
    }
    without(shape, removed)
}

/// Removes the faces whose centroid satisfies `inside`. Then ears (faces hanging by one edge) and
/// vertices where the rim would touch itself go too, and pieces left floating in a hole, so that
/// the rest is manifold; unused vertices are dropped, the others keep their order.
pub fn cut_where(shape: &TriangleMesh, inside: impl Fn(DVec3) -> bool) -> TriangleMesh {
    let removed = shape
        .1
        .iter()
        .map(|t| inside(t.iter().map(|&v| shape.0[v as usize]).sum::<DVec3>() / 3.0))
        .collect();
    without(shape, removed)
}

/// Coordinates, in units of length, of the vertices around the one nearest to `centre`, in order
/// of their distance until that exceeds `reach`.
fn chart_around(
    shape: &TriangleMesh,
    rings: &Adjacency,
    normals: &[DVec3],
    centre: DVec3,
    reach: f64,
) -> BTreeMap<u32, DVec2> {
    let positions = &shape.0;
    let mut chart = BTreeMap::new();
    let Some(start) = (0..positions.len() as u32).min_by(|&a, &b| {
        let distance = |v: u32| positions[v as usize].distance_squared(centre);
        distance(a).total_cmp(&distance(b))
    }) else {
        return chart;
    };
    // of finished vertices: the first axis of the tangent frame, carried along
    let mut axis_of = BTreeMap::new();
    let normal = normals[start as usize];
    // waiting: distance bits (order of non-negative floats) and vertex -> coordinates, parent
    let mut waiting = BTreeMap::from([((0u64, start), (DVec2::ZERO, start))]);
    axis_of.insert(start, normal.any_orthonormal_vector());
    while let Some(((_, v), (at, parent))) = waiting.pop_first() {
        if chart.contains_key(&v) {
            continue;
        }
        if at.length() > reach {
            break;
        }
        let n = normals[v as usize];
        let carried: DVec3 = axis_of[&parent];
        let axis = (carried - n * carried.dot(n)).normalize_or(n.any_orthonormal_vector());
        axis_of.insert(v, axis);
        chart.insert(v, at);
        for &w in rings.of(v) {
            if chart.contains_key(&w) {
                continue;
            }
            let edge = positions[w as usize] - positions[v as usize];
            let flat = DVec2::new(edge.dot(axis), edge.dot(n.cross(axis)));
            let there = at + flat.normalize_or_zero() * edge.length();
            waiting.insert((there.length().to_bits(), w), (there, v));
        }
    }
    chart
}

/// The shape without the removed faces, tidied.
fn without((positions, triangles): &TriangleMesh, mut removed: Vec<bool>) -> TriangleMesh {
    let mut touched = vec![false; positions.len()];
    loop {
        for (f, t) in triangles.iter().enumerate() {
            if removed[f] {
                for &v in t {
                    touched[v as usize] = true;
                }
            }
        }
        let more = untidy_faces(triangles, &removed, &touched);
        if more.is_empty() {
            break;
        }
        for f in more {
            removed[f as usize] = true;
        }
    }
    let mut index = vec![u32::MAX; positions.len()];
    let left = || (0..triangles.len()).filter(|&f| !removed[f]);
    for f in left() {
        for &v in &triangles[f] {
            index[v as usize] = 0;
        }
    }
    let mut kept = Vec::new();
    for (v, slot) in index.iter_mut().enumerate() {
        if *slot == 0 {
            *slot = kept.len() as u32;
            kept.push(positions[v]);
        }
    }
    let faces = left()
        .map(|f| triangles[f].map(|v| index[v as usize]))
        .collect();
    (kept, faces)
}

/// Faces near the cut that must go next: ears, fans around vertices where the rim touches itself,
/// and islands.
fn untidy_faces(triangles: &[[u32; 3]], removed: &[bool], touched: &[bool]) -> Vec<u32> {
    let left: Vec<u32> = (0..triangles.len() as u32)
        .filter(|&f| !removed[f as usize])
        .collect();
    let mut open_edges = vec![0u8; triangles.len()];
    let mut rim_ends = vec![0u8; touched.len()];
    let mut component = pieces(triangles, &left, |p, q, f| {
        open_edges[f as usize] += 1;
        for v in [p, q] {
            rim_ends[v as usize] = rim_ends[v as usize].saturating_add(1);
        }
    });
    let mut size = vec![0usize; triangles.len()];
    for &f in &left {
        size[find(&mut component, f) as usize] += 1;
    }
    left.iter()
        .copied()
        .filter(|&f| {
            let t = &triangles[f as usize];
            let near_cut = t.iter().any(|&v| touched[v as usize]);
            let is_ear = open_edges[f as usize] >= 2;
            let pinches = t
                .iter()
                .any(|&v| touched[v as usize] && rim_ends[v as usize] > 2);
            let island = size[find(&mut component, f) as usize] < left.len() / 20;
            near_cut && (is_ear || pinches || island)
        })
        .collect()
}

/// The largest of the pieces, connected by edges, into which `faces` fall.
fn largest_piece(triangles: &[[u32; 3]], faces: &[u32]) -> Vec<u32> {
    let mut component = pieces(triangles, faces, |_, _, _| {});
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &f in faces {
        members.entry(find(&mut component, f)).or_default().push(f);
    }
    let mut largest = Vec::new();
    for piece in members.into_values() {
        if piece.len() > largest.len() {
            largest = piece;
        }
    }
    largest
}

/// Union-find parents of the edge-connected pieces of `faces`; `open` receives the ends and the
/// face of every edge that only one of them has.
fn pieces(triangles: &[[u32; 3]], faces: &[u32], mut open: impl FnMut(u32, u32, u32)) -> Vec<u32> {
    let mut edges = Vec::with_capacity(3 * faces.len());
    for &f in faces {
        let t = triangles[f as usize];
        for k in 0..3 {
            let (p, q) = (t[k], t[(k + 1) % 3]);
            edges.push((p.min(q), p.max(q), f));
        }
    }
    edges.sort_unstable();
    let mut component: Vec<u32> = (0..triangles.len() as u32).collect();
    for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(p, q, f)] = *group {
            open(p, q, f);
        }
        for pair in group.windows(2) {
            unite(&mut component, pair[0].2, pair[1].2);
        }
    }
    component
}
