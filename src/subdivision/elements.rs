//! Control vertices and basis tables of a list of faces.

use std::collections::BTreeMap;

use super::basis::{BasisTable, TableCache};
use super::rule::Rule;
use crate::mesh::{FaceId, HalfedgeId, Topology, VertexId};

/// The stencils of a list of faces: which vertices control each, and with which basis functions.
///
/// Faces are sorted by table, those of one table in the order in which they were given. The first
/// three control vertices of an element are the corners of its face in the face's own order; the
/// vertices of an element are distinct.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    /// Tables that occur.
    pub tables: Vec<BasisTable>,
    /// For each element its table.
    pub table_of: Vec<u32>,
    /// For each element the start of its control vertices in `vertices`; one more entry at the end.
    pub offset: Vec<u32>,
    /// Control vertices of all elements, in the order of the table's columns.
    pub vertices: Vec<u32>,
    /// For each element its face.
    pub faces: Vec<u32>,
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Control vertices of an element.
    #[inline]
    pub fn vertices_of(&self, element: usize) -> &[u32] {
        &self.vertices[self.offset[element] as usize..self.offset[element + 1] as usize]
    }

    /// Table of an element.
    #[inline]
    pub fn table(&self, element: usize) -> &BasisTable {
        &self.tables[self.table_of[element] as usize]
    }
}

/// Gathers the stencils of `faces`.
pub fn elements(
    topology: &Topology,
    faces: &[FaceId],
    rule: Rule,
    cache: &mut TableCache,
) -> Elements {
    let mut valence = vec![0u32; topology.vertex_count()];
    let mut classes: BTreeMap<[usize; 3], Vec<FaceId>> = BTreeMap::new();
    for &f in faces {
        let valences = topology.face_vertices(f).map(|v| {
            let n = &mut valence[v.index()];
            if *n == 0 {
                *n = topology.valence(v) as u32;
            }
            *n as usize
        });
        classes.entry(valences).or_default().push(f);
    }
    let mut out = Elements::default();
    out.offset.push(0);
    for (valences, members) in classes {
        let table = out.tables.len() as u32;
        out.tables.push(cache.table(valences, rule).clone());
        for f in members {
            gather(topology, f, valences, &mut out.vertices);
            out.offset.push(out.vertices.len() as u32);
            out.table_of.push(table);
            out.faces.push(f.0);
        }
    }
    out
}

/// Appends the control vertices of a face whose corners are all inner vertices.
fn gather(topology: &Topology, f: FaceId, valences: [usize; 3], vertices: &mut Vec<u32>) {
    let h0 = topology.halfedge_of_face(f);
    let h1 = topology.next(h0);
    let h2 = topology.next(h1);
    vertices.extend([h0, h1, h2].map(|h| topology.origin(h).0));
    if valences == [3, 3, 3] {
        vertices.push(opposite(topology, h0.twin()).0);
        return;
    }
    for (incoming, corner) in [(h0, 1), (h1, 2), (h2, 0)] {
        let mut out = incoming.twin();
        for _ in 3..valences[corner] {
            let previous = topology.prev_in_face(out);
            vertices.push(topology.origin(previous).0);
            out = previous.twin();
        }
    }
}

/// The vertex of a half-edge's face that is not on it.
fn opposite(topology: &Topology, h: HalfedgeId) -> VertexId {
    topology.target(topology.next(h))
}
