//! Which vertices move, in the order of the factorization.

use crate::linear::{SymmetricPattern, nested_dissection};
use crate::mesh::DVec3;
use crate::subdivision::Elements;

/// Vertices of a mesh that move, numbered for the factorization.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// The vertex of each unknown.
    pub vertex: Vec<u32>,
    /// The unknown of each vertex; [`Self::len`] where the vertex is fixed.
    pub of_vertex: Vec<u32>,
    /// Who meets whom where, until the assembly has taken it.
    pub(super) structure: Option<Structure>,
}

/// What numbering the unknowns found out about the matrix.
#[derive(Clone, Debug)]
pub(super) struct Structure {
    pub(super) pattern: SymmetricPattern,
    /// In the order of `moving`.
    pub(super) incidence: Incidence,
    /// Place in `moving` of each unknown.
    pub(super) order: Vec<u32>,
}

impl Unknowns {
    /// How many vertices move.
    pub fn len(&self) -> usize {
        self.vertex.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.vertex.is_empty()
    }

    /// Numbers the `moving` vertices by nested dissection of the graph of vertices that share an
    /// element.
    pub fn new(elements: &Elements, positions: &[DVec3], moving: &[u32]) -> Self {
        let unknowns = Self::numbered(positions.len(), moving.to_vec());
        let incidence = Incidence::new(elements, &unknowns);
        let n = moving.len();
        let mut offsets = Vec::with_capacity(n + 1);
        let mut adjacency = Vec::with_capacity(36 * n);
        let mut stamp = vec![u32::MAX; n + 1];
        stamp[n] = n as u32;
        offsets.push(0);
        for j in 0..n {
            stamp[j] = j as u32;
            for &[e, _] in incidence.of(j) {
                for &v in elements.vertices_of(e as usize) {
                    let i = unknowns.of_vertex[v as usize] as usize;
                    if i < n && stamp[i] != j as u32 {
                        stamp[i] = j as u32;
                        adjacency.push(i as u32);
                    }
                }
            }
            offsets.push(adjacency.len() as u32);
        }
        let points: Vec<DVec3> = moving.iter().map(|&v| positions[v as usize]).collect();
        let order = nested_dissection(&points, &offsets, &adjacency);
        let mut unknowns = Self::numbered(
            positions.len(),
            order.iter().map(|&i| moving[i as usize]).collect(),
        );
        unknowns.structure = Some(Structure {
            pattern: SymmetricPattern::of_permuted_graph(&offsets, &adjacency, &order),
            incidence,
            order,
        });
        unknowns
    }

    /// All vertices fixed: only energies can be computed.
    pub fn none(vertex_count: usize) -> Self {
        Self::numbered(vertex_count, Vec::new())
    }

    /// Numbers vertices in the order given.
    pub(super) fn numbered(vertex_count: usize, vertex: Vec<u32>) -> Self {
        let mut of_vertex = vec![vertex.len() as u32; vertex_count];
        for (i, &v) in vertex.iter().enumerate() {
            of_vertex[v as usize] = i as u32;
        }
        Self {
            vertex,
            of_vertex,
            structure: None,
        }
    }
}

/// For each unknown the elements that contain it, with its place in the element.
#[derive(Clone, Debug)]
pub(super) struct Incidence {
    start: Vec<u32>,
    entries: Vec<[u32; 2]>,
}

impl Incidence {
    fn new(elements: &Elements, unknowns: &Unknowns) -> Self {
        let n = unknowns.len();
        let mut start = vec![0u32; n + 2];
        for &v in elements.vertices() {
            start[unknowns.of_vertex[v as usize] as usize + 1] += 1;
        }
        for i in 0..=n {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut entries = vec![[0; 2]; start[n] as usize];
        for e in 0..elements.faces().len() {
            for (k, &v) in elements.vertices_of(e).iter().enumerate() {
                let i = unknowns.of_vertex[v as usize] as usize;
                if i < n {
                    entries[fill[i] as usize] = [e as u32, k as u32];
                    fill[i] += 1;
                }
            }
        }
        Self { start, entries }
    }

    pub(super) fn of(&self, unknown: usize) -> &[[u32; 2]] {
        &self.entries[self.start[unknown] as usize..self.start[unknown + 1] as usize]
    }
}
