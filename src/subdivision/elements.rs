//! Control vertices and basis tables of a list of faces.

use std::collections::BTreeMap;

use super::basis::{BasisTable, TableCache};
use super::folding::fold;
use super::rule::Rule;
use crate::mesh::{FaceId, Topology};

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
    /// Appends an element whose vertices are at the end of `vertices`.
    fn push(&mut self, table: u32, f: FaceId) {
        self.table_of.push(table);
        self.offset.push(self.vertices.len() as u32);
        self.faces.push(f.0);
    }

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

/// Gathers the stencils of `faces`, with tables for the points of `rule`.
///
/// Where a corner of a face lies on an open boundary, the mesh is thought continued: beyond each
/// boundary edge `(p, q)` of a triangle `(p, q, r)` by a ghost vertex `p + q - r`, and at each
/// boundary vertex by one more triangle between the ghosts of its two boundary edges. Ghosts do not
/// appear in the result: their basis functions are added to those of the vertices they are made of.
/// Likewise a vertex that occurs several times around a triangle of a tiny closed mesh appears once,
/// with the sum of its functions.
pub fn elements(
    topology: &Topology,
    faces: &[FaceId],
    rule: Rule,
    cache: &mut TableCache,
) -> Elements {
    let classes = classify(topology, faces);
    let total = classes.triples.iter().map(|&(t, n)| n * stencil_size(t));
    let mut out = Elements {
        tables: Vec::with_capacity(classes.triples.len()),
        table_of: Vec::with_capacity(faces.len()),
        offset: Vec::with_capacity(faces.len() + 1),
        vertices: Vec::with_capacity(total.sum()),
        faces: Vec::with_capacity(faces.len()),
    };
    out.offset.push(0);

    let mut to_fold = classes.boundary;
    // for each vertex the last face found to use it, counted from 1, to find repetitions
    let mut mark = 0;
    let mut last_user = vec![0u32; topology.vertex_count()];
    let mut sorted = classes.sorted.iter();
    for (valences, count) in classes.triples {
        let table = out.tables.len() as u32;
        let first = out.faces.len();
        for &f in sorted.by_ref().take(count) {
            let start = out.vertices.len();
            gather(topology, f, valences, &mut out.vertices);
            mark += 1;
            let mut repeated = false;
            for &v in &out.vertices[start..] {
                repeated |= std::mem::replace(&mut last_user[v as usize], mark) == mark;
            }
            if repeated {
                out.vertices.truncate(start);
                to_fold.push(f);
            } else {
                out.push(table, f);
            }
        }
        if out.faces.len() > first {
            out.tables.push(cache.table(valences, rule).clone());
        }
    }
    push_folded(topology, &to_fold, rule, cache, &mut out);
    out
}

/// Appends the elements whose control vertices are not distinct real vertices.
fn push_folded(
    topology: &Topology,
    faces: &[FaceId],
    rule: Rule,
    cache: &mut TableCache,
    out: &mut Elements,
) {
    let mut folded: Vec<_> = faces.iter().map(|&f| (fold(topology, f), f)).collect();
    folded.sort_by(|((a, _), _), ((b, _), _)| a.cmp(b));
    for group in folded.chunk_by(|((a, _), _), ((b, _), _)| a == b) {
        let table = out.tables.len() as u32;
        let ((folding, _), _) = &group[0];
        out.tables.push(cache.folded_table(folding, rule).clone());
        for ((_, vertices), f) in group {
            out.vertices.extend_from_slice(vertices);
            out.push(table, *f);
        }
    }
}

/// Number of control vertices of a triangle.
fn stencil_size([a, b, c]: [usize; 3]) -> usize {
    (a + b + c - 6).max(4)
}

/// Faces by the valences of their corners.
struct Classes {
    /// Distinct valence triples of faces off the boundary, ascending, with the number of faces.
    triples: Vec<([usize; 3], usize)>,
    /// The faces of the first triple, then of the second, ...
    sorted: Vec<FaceId>,
    /// The faces with a corner on an open boundary.
    boundary: Vec<FaceId>,
}

/// In place of a valence or class: on the boundary.
const BOUNDARY: u32 = u32::MAX;

fn classify(topology: &Topology, faces: &[FaceId]) -> Classes {
    let mut valence = vec![0u32; topology.vertex_count()];
    let mut seen = Triples::default();
    let mut boundary = Vec::new();
    let mut class_of = Vec::with_capacity(faces.len());
    for &f in faces {
        let valences = topology.face_vertices(f).map(|v| {
            let n = &mut valence[v.index()];
            if *n == 0 {
                *n = if topology.is_boundary_vertex(v) {
                    BOUNDARY
                } else {
                    topology.valence(v) as u32
                };
            }
            *n
        });
        if valences.contains(&BOUNDARY) {
            boundary.push(f);
            class_of.push(BOUNDARY);
        } else {
            class_of.push(seen.count(valences.map(|n| n as usize)));
        }
    }

    let mut order: Vec<usize> = (0..seen.found.len()).collect();
    order.sort_unstable_by_key(|&c| seen.found[c].0);
    let mut slot = vec![0; order.len()];
    let mut filled = 0;
    for &c in &order {
        slot[c] = filled;
        filled += seen.found[c].1;
    }
    let mut sorted = vec![FaceId::NONE; filled];
    for (&f, &class) in faces.iter().zip(&class_of) {
        if class != BOUNDARY {
            let slot = &mut slot[class as usize];
            sorted[*slot] = f;
            *slot += 1;
        }
    }
    Classes {
        triples: order.iter().map(|&c| seen.found[c]).collect(),
        sorted,
        boundary,
    }
}

/// Valences below this are looked up directly, as nearly all are.
const DIRECT: usize = 16;

/// Valence triples in the order in which they were first seen, with their number.
struct Triples {
    found: Vec<([usize; 3], usize)>,
    direct: Vec<u32>,
    others: BTreeMap<[usize; 3], u32>,
}

impl Default for Triples {
    fn default() -> Self {
        Self {
            found: Vec::new(),
            direct: vec![u32::MAX; DIRECT.pow(3)],
            others: BTreeMap::new(),
        }
    }
}

impl Triples {
    /// Counts a triple and returns its index.
    fn count(&mut self, valences: [usize; 3]) -> u32 {
        let next = self.found.len() as u32;
        let class = if let [a @ ..DIRECT, b @ ..DIRECT, c @ ..DIRECT] = valences {
            &mut self.direct[(a * DIRECT + b) * DIRECT + c]
        } else {
            self.others.entry(valences).or_insert(u32::MAX)
        };
        if *class == u32::MAX {
            *class = next;
            self.found.push((valences, 0));
        }
        self.found[*class as usize].1 += 1;
        *class
    }
}

/// Appends the control vertices of a face whose corners are all inner vertices, in standard order.
fn gather(topology: &Topology, f: FaceId, valences: [usize; 3], vertices: &mut Vec<u32>) {
    let h0 = topology.halfedge_of_face(f);
    let h1 = topology.next(h0);
    let h2 = topology.next(h1);
    vertices.extend([h0, h1, h2].map(|h| topology.origin(h).0));
    if valences == [3, 3, 3] {
        vertices.push(topology.target(topology.next(h0.twin())).0);
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
