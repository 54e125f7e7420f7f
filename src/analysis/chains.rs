//! Chains of edges along which continuity is measured.

use std::collections::BTreeSet;

use crate::analysis::quality::dihedral;
use crate::mesh::{FaceId, HalfedgeId, Mesh, Topology, VertexId};

/// Edges to be measured together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdgeChain {
    /// Its name for the user: "rim 1", "sharp edges".
    pub name: String,
    /// One half-edge of each edge. Boundary edges are left out of the measures.
    pub edges: Vec<HalfedgeId>,
    /// Whether the surface is made up of its two sides separately there (a rim of G0): positions
    /// and normals are then one-sided limits. Otherwise one limit surface runs through.
    pub is_crease: bool,
}

/// The rims between faces of `is_patch` and others, one chain for each connected rim.
pub fn patch_rims(mesh: &Mesh, is_patch: &[bool], is_crease: bool) -> Vec<EdgeChain> {
    let topology = &mesh.topology;
    let inside = |f: FaceId| f.is_some() && is_patch.get(f.index()).copied().unwrap_or(false);
    let on_rim = |h: HalfedgeId| {
        let (f, g) = (topology.face(h), topology.face(h.twin()));
        f.is_some() && g.is_some() && inside(f) && !inside(g)
    };
    connected(mesh, on_rim)
        .into_iter()
        .enumerate()
        .map(|(i, edges)| EdgeChain {
            name: format!("rim {}", i + 1),
            edges,
            is_crease,
        })
        .collect()
}

/// The edges at which neighbouring triangles differ by more than `angle` (radians), in connected
/// chains, as creases.
pub fn sharp_edges(mesh: &Mesh, angle: f64) -> Vec<EdgeChain> {
    let topology = &mesh.topology;
    let sharp = |h: HalfedgeId| {
        h.0.is_multiple_of(2) && !topology.is_boundary_edge(h) && dihedral(mesh, h) > angle
    };
    connected(mesh, sharp)
        .into_iter()
        .enumerate()
        .map(|(i, edges)| EdgeChain {
            name: format!("sharp edges {}", i + 1),
            edges,
            is_crease: true,
        })
        .collect()
}

/// Maximum turning angle of a straight chain at a vertex.
const STRAIGHT: f64 = std::f64::consts::FRAC_PI_6;

/// The chain through an edge: where neighbouring triangles differ by more than `angle` (radians)
/// the sharp edge it is part of, up to vertices where more or fewer than two sharp edges meet; else
/// the edges that go straight on from it, turning by 30° at most. `None` for a boundary edge, which
/// has no other side.
pub fn chain_through(mesh: &Mesh, edge: HalfedgeId, angle: f64) -> Option<EdgeChain> {
    let topology = &mesh.topology;
    let is_inner = |h: HalfedgeId| !topology.is_boundary_edge(h);
    if !is_inner(edge) {
        return None;
    }
    let is_sharp = |h: HalfedgeId| is_inner(h) && dihedral(mesh, h) > angle;
    let along =
        |h: HalfedgeId| mesh.position(topology.target(h)) - mesh.position(topology.origin(h));
    let sharp = is_sharp(edge);
    let next = |h: HalfedgeId| {
        let at = topology.target(h);
        let on = topology.outgoing(at).filter(|&o| o != h.twin());
        if sharp {
            let mut on = on.filter(|&o| is_sharp(o));
            let only = on.next();
            return only.filter(|_| on.next().is_none());
        }
        if topology.is_boundary_vertex(at) {
            return None;
        }
        // the smallest turn; among equal turns, the first half-edge
        on.map(|o| (along(h).angle_between(along(o)), o))
            .filter(|(turn, _)| *turn <= STRAIGHT)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, o)| o)
    };
    Some(EdgeChain {
        name: if sharp { "sharp edge" } else { "edges" }.into(),
        edges: follow(topology, edge, next),
        is_crease: sharp,
    })
}

/// An edge and its continuation on either side, in order and direction. Each side ends where no
/// edge follows or a vertex repeats.
fn follow(
    topology: &Topology,
    edge: HalfedgeId,
    next: impl Fn(HalfedgeId) -> Option<HalfedgeId>,
) -> Vec<HalfedgeId> {
    let mut seen = BTreeSet::from([topology.origin(edge), topology.target(edge)]);
    let mut ways = [edge, edge.twin()].map(|first| {
        let mut way = Vec::new();
        let mut at = first;
        while let Some(h) = next(at) {
            let closes = topology.target(h) == topology.target(first.twin());
            if !seen.insert(topology.target(h)) {
                if closes {
                    way.push(h);
                }
                break;
            }
            way.push(h);
            at = h;
        }
        way
    });
    let [onwards, back] = &mut ways;
    if onwards.last().map(|h| topology.target(*h)) == Some(topology.origin(edge)) {
        back.clear();
    }
    let before = back.iter().rev().map(|h| h.twin());
    before
        .chain([edge])
        .chain(onwards.iter().copied())
        .collect()
}

/// The chosen half-edges in groups connected by vertices, each in index order.
fn connected(mesh: &Mesh, chosen: impl Fn(HalfedgeId) -> bool) -> Vec<Vec<HalfedgeId>> {
    let topology = &mesh.topology;
    let is_chosen: Vec<bool> = topology.halfedges().map(chosen).collect();
    let mut seen = vec![false; topology.vertex_count()];
    let mut groups = Vec::new();
    for first in topology.halfedges().filter(|h| is_chosen[h.index()]) {
        let start = topology.origin(first);
        if std::mem::replace(&mut seen[start.index()], true) {
            continue;
        }
        let mut group = Vec::new();
        let mut stack: Vec<VertexId> = vec![start];
        while let Some(v) = stack.pop() {
            for out in topology.outgoing(v) {
                for h in [out, out.twin()] {
                    if is_chosen[h.index()] {
                        group.push(h);
                        let w = topology.target(out);
                        if !std::mem::replace(&mut seen[w.index()], true) {
                            stack.push(w);
                        }
                    }
                }
            }
        }
        group.sort_unstable();
        group.dedup();
        groups.push(group);
    }
    groups
}
