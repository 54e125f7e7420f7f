//! Triangles whose unrolled control vertices are not distinct vertices of the mesh.

use super::basis::{BasisTable, DERIVATIVES};
use super::ring::{Neighbour, extended_ring};
use crate::mesh::{FaceId, Topology, VertexId};

/// How real control vertices determine the unrolled ones of a triangle.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Folding {
    /// Corner valences, including ghosts.
    pub(super) valences: [usize; 3],
    /// Number of distinct real control vertices.
    columns: usize,
    /// The unrolled control vertices in standard order, by columns of real ones.
    sources: Vec<Source>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Real(usize),
    /// `p + q - r`.
    Ghost([usize; 3]),
}

impl Folding {
    /// Whether a corner has only two neighbours. The triangle is then one of two glued along all
    /// their edges, for which Loop's scheme has no limit surface.
    pub(super) fn is_flat(&self) -> bool {
        self.valences.iter().any(|&n| n < 3)
    }

    /// The table over the real vertices: `N' = N T`, with `T` from real to unrolled vertices.
    pub(super) fn apply(&self, unrolled: &BasisTable) -> BasisTable {
        debug_assert_eq!(unrolled.n, self.sources.len());
        let mut data = vec![0.0; unrolled.points * DERIVATIVES * self.columns];
        let rows = unrolled.data.chunks_exact(unrolled.n);
        for (from, to) in rows.zip(data.chunks_exact_mut(self.columns)) {
            for (&value, source) in from.iter().zip(&self.sources) {
                match *source {
                    Source::Real(c) => to[c] += value,
                    Source::Ghost([p, q, r]) => {
                        to[p] += value;
                        to[q] += value;
                        to[r] -= value;
                    }
                }
            }
        }
        BasisTable {
            n: self.columns,
            points: unrolled.points,
            data,
        }
    }
}

/// The folding of a face and its real control vertices: the corners in the face's order, then the
/// others in the order of their first occurrence in the outer ring.
pub(super) fn fold(topology: &Topology, f: FaceId) -> (Folding, Vec<u32>) {
    let corners = topology.face_vertices(f);
    let mut valences = [0; 3];
    let mut rings = [const { Vec::new() }; 3];
    for c in 0..3 {
        let ring = &mut rings[c];
        extended_ring(topology, corners[c], ring);
        valences[c] = ring.len();
        let following = Neighbour::Real(corners[(c + 1) % 3]);
        let turn = ring.iter().position(|&r| r == following).unwrap_or(0);
        ring.rotate_left(turn);
    }
    if valences.iter().any(|&n| n < 3) {
        let folding = Folding {
            valences,
            columns: 3,
            sources: [0, 1, 2].map(Source::Real).to_vec(),
        };
        return (folding, corners.map(|v| v.0).to_vec());
    }

    // Each ring starts with the two other corners, and its last vertex is the first of the next one.
    let mut unrolled: Vec<Neighbour> = corners.map(Neighbour::Real).to_vec();
    for c in [1, 2, 0] {
        unrolled.extend(&rings[c][2..valences[c] - 1]);
    }
    if valences == [3, 3, 3] {
        unrolled.push(rings[0][2]);
    }

    let mut vertices: Vec<u32> = Vec::with_capacity(unrolled.len());
    let mut column = |v: VertexId| {
        vertices.iter().position(|&u| u == v.0).unwrap_or_else(|| {
            vertices.push(v.0);
            vertices.len() - 1
        })
    };
    // real ones first: a ghost may precede its defining vertices
    for u in &unrolled {
        if let Neighbour::Real(v) = *u {
            column(v);
        }
    }
    let sources = unrolled
        .iter()
        .map(|u| match *u {
            Neighbour::Real(v) => Source::Real(column(v)),
            Neighbour::Ghost(g) => Source::Ghost(g.map(&mut column)),
        })
        .collect();
    let columns = vertices.len();
    let folding = Folding {
        valences,
        columns,
        sources,
    };
    (folding, vertices)
}
