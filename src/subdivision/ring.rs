//! The closed ring of neighbours of a vertex, completed by ghosts at an open boundary.
//!
//! Beyond each boundary edge `(p, q)` whose triangle has the third corner `r` lies the ghost
//! `p + q - r`. At each boundary vertex, one more triangle joins the two ghosts of its boundary
//! edges. A boundary vertex with `k` triangles thus has valence `k + 3`. On a straight boundary of
//! a regular mesh the valence is 6, so the continuation is regular. At a corner (`k < 3`) or a
//! notch (`k > 3`) the continued mesh is irregular. At a pinched vertex each gap is continued
//! separately.

use crate::mesh::{DVec3, HalfedgeId, Topology, VertexId};

/// A neighbour of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Neighbour {
    /// A vertex of the mesh.
    Real(VertexId),
    /// The ghost `p + q - r`, given as `[p, q, r]`, with `p` the vertex whose neighbour it is.
    Ghost([VertexId; 3]),
}

impl Neighbour {
    /// Its position.
    pub(super) fn position(self, positions: &[DVec3]) -> DVec3 {
        match self {
            Self::Real(v) => positions[v.index()],
            Self::Ghost(g) => {
                let [p, q, r] = g.map(|v| positions[v.index()]);
                p + (q - r)
            }
        }
    }

    /// Distributes a weight to the vertices that define it.
    pub(super) fn scatter(self, weight: f64, mut add: impl FnMut(VertexId, f64)) {
        match self {
            Self::Real(v) => add(v, weight),
            Self::Ghost([p, q, r]) => {
                add(p, weight);
                add(q, weight);
                add(r, -weight);
            }
        }
    }
}

/// Fills `ring` with the neighbours of `v`, ghosts included, in counter-clockwise order; empty for a
/// vertex without triangles.
pub(super) fn extended_ring(topology: &Topology, v: VertexId, ring: &mut Vec<Neighbour>) {
    ring.clear();
    // Clockwise, a boundary half-edge starts a fan of triangles. The half-edge before it ends a
    // fan, either the previous one or the same one. The walk starts at such a half-edge.
    let mut before = HalfedgeId::NONE;
    let mut open = false;
    for out in topology.outgoing(v) {
        if topology.is_boundary(out) {
            if before.is_some() {
                ring.push(ghost(topology, before, before));
            }
            ring.push(ghost(topology, out, out.twin()));
            open = true;
        }
        ring.push(Neighbour::Real(topology.target(out)));
        before = out;
    }
    if open {
        ring.push(ghost(topology, before, before));
    }
    ring.reverse();
}

/// The ghost beyond the boundary edge of `out`, as a neighbour of its origin; `inner` is the half of
/// the edge that has a face.
fn ghost(topology: &Topology, out: HalfedgeId, inner: HalfedgeId) -> Neighbour {
    let opposite = topology.target(topology.next(inner));
    Neighbour::Ghost([topology.origin(out), topology.target(out), opposite])
}

#[cfg(test)]
mod tests {
    use super::super::test_meshes::PINCHED;
    use super::*;

    #[test]
    fn rings_are_counter_clockwise_and_closed() {
        // a square of two triangles: 0 and 2 have two faces, 1 and 3 have one
        let t = Topology::from_triangles(4, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
        let mut ring = Vec::new();
        extended_ring(&t, VertexId(0), &mut ring);
        let real = |v| Neighbour::Real(VertexId(v));
        let ghost = |p, q, r| Neighbour::Ghost([VertexId(p), VertexId(q), VertexId(r)]);
        assert_eq!(
            ring,
            [ghost(0, 1, 2), real(1), real(2), real(3), ghost(0, 3, 2)]
        );
        extended_ring(&t, VertexId(1), &mut ring);
        assert_eq!(ring, [ghost(1, 2, 0), real(2), real(0), ghost(1, 0, 2)]);
    }

    #[test]
    fn each_gap_of_a_pinched_vertex_is_closed() {
        let t = Topology::from_triangles(11, &PINCHED).expect("pinched at 0");
        let mut ring = Vec::new();
        extended_ring(&t, VertexId(0), &mut ring);
        let real = |v| Neighbour::Real(VertexId(v));
        let ghost = |q, r| Neighbour::Ghost([VertexId(0), VertexId(q), VertexId(r)]);
        let expected = [
            ghost(2, 5),
            real(2),
            real(5),
            real(10),
            real(3),
            ghost(3, 10),
            ghost(4, 8),
            real(4),
            real(8),
            real(7),
            real(1),
            ghost(1, 7),
        ];
        let turn = ring
            .iter()
            .position(|&n| n == expected[0])
            .expect("a ghost");
        ring.rotate_left(turn);
        assert_eq!(ring, expected);
    }

    #[test]
    fn a_vertex_without_triangles_has_no_ring() {
        let t = Topology::from_triangles(4, &[[0, 1, 2]]).expect("a triangle");
        let mut ring = vec![Neighbour::Real(VertexId(0))];
        extended_ring(&t, VertexId(3), &mut ring);
        assert!(ring.is_empty());
    }
}
