//! The moving vertices, in the order of the factorization.

use crate::mesh::DVec3;
use crate::solver::sparsity::{IndexLists, ListGraph, SymmetricScatter};
use crate::subdivision::Elements;

/// Vertices of a mesh that move, numbered for the factorization.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// The vertex of each unknown.
    pub vertex: Vec<u32>,
    /// The unknown of each vertex; [`Self::len`] where the vertex is fixed.
    pub of_vertex: Vec<u32>,
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

    /// Numbers the `moving` vertices of `vertex_count` in the order given.
    pub fn new(vertex_count: usize, moving: Vec<u32>) -> Self {
        let mut of_vertex = vec![moving.len() as u32; vertex_count];
        for (i, &v) in moving.iter().enumerate() {
            of_vertex[v as usize] = i as u32;
        }
        Self {
            vertex: moving,
            of_vertex,
        }
    }

    /// All vertices fixed: only energies can be computed.
    pub fn none(vertex_count: usize) -> Self {
        Self::new(vertex_count, Vec::new())
    }

    /// Numbers the `moving` vertices by nested dissection of the graph of vertices that share an
    /// element, and finds the sparsity of a matrix over them.
    pub fn dissected(
        elements: &Elements,
        positions: &[DVec3],
        moving: Vec<u32>,
    ) -> (Self, SymmetricScatter) {
        Self::dissected_by(|unknowns| unknowns.lists(elements), positions, moving)
    }

    /// The same for the graph of vertices that share a list; `lists` makes them for the vertices in the
    /// order given.
    pub(super) fn dissected_by(
        lists: impl FnOnce(&Self) -> IndexLists,
        positions: &[DVec3],
        moving: Vec<u32>,
    ) -> (Self, SymmetricScatter) {
        let unordered = Self::new(positions.len(), moving);
        let lists = lists(&unordered);
        let graph = ListGraph::new(&lists, unordered.len());
        let order = graph.dissect(&unordered.points(positions));
        (unordered.reordered(&order), graph.scatter(&order))
    }

    /// The same vertices in another order: `order[new] = old`.
    pub(super) fn reordered(&self, order: &[u32]) -> Self {
        let vertex = order.iter().map(|&i| self.vertex[i as usize]).collect();
        Self::new(self.of_vertex.len(), vertex)
    }

    /// The positions of the vertices that move.
    pub(super) fn points(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let at = |&v: &u32| positions[v as usize];
        self.vertex.iter().map(at).collect()
    }

    /// The unknowns of the control vertices of each element.
    pub(super) fn lists(&self, elements: &Elements) -> IndexLists {
        let vertices = elements.vertices().iter();
        IndexLists {
            start: elements.offsets().to_vec(),
            items: vertices.map(|&v| self.of_vertex[v as usize]).collect(),
        }
    }
}
