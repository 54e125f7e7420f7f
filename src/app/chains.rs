//! Edges chosen in the view. They persist when the mesh changes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::mesh::{HalfedgeId, Mesh, VertexId};

/// Edges chosen together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chain {
    /// Whether both sides are evaluated separately.
    pub is_crease: bool,
    /// The edges as positions of their end points.
    pub edges: Vec<[[f64; 3]; 2]>,
}

/// The vertices at the ends of chosen edges, found by position, because erasing faces renumbers
/// vertices but does not move them.
pub struct Places(BTreeMap<[u64; 3], Vec<VertexId>>);

impl Places {
    /// The ends of all edges of the chains.
    pub fn new(mesh: &Mesh, chains: &[Chain]) -> Self {
        let ends = chains.iter().flat_map(|c| &c.edges).flatten();
        let mut ends: Vec<[u64; 3]> = ends.map(|p| p.map(f64::to_bits)).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut found: Vec<Vec<VertexId>> = vec![Vec::new(); ends.len()];
        if !ends.is_empty() {
            for (v, p) in mesh.positions.iter().enumerate() {
                if let Ok(i) = ends.binary_search(&p.to_array().map(f64::to_bits)) {
                    found[i].push(VertexId::from(v));
                }
            }
        }
        Self(ends.into_iter().zip(found).collect())
    }

    /// The half-edge from one position to the other, if there is one.
    pub fn edge(&self, mesh: &Mesh, ends: &[[f64; 3]; 2]) -> Option<HalfedgeId> {
        let topology = &mesh.topology;
        let [from, to] = ends.map(|p| self.0.get(&p.map(f64::to_bits)));
        let to = to?;
        from?
            .iter()
            .flat_map(|&v| topology.outgoing(v))
            .find(|&h| to.contains(&topology.target(h)))
    }
}
