//! The kept states of a fill, in bounded memory.

use std::sync::Arc;

use crate::fill::live::State;
use crate::mesh::DVec3;

/// Kept states of a fill, oldest first. The first and the latest are always among them; where they
/// would take more than the bytes they may, every second of the others is dropped.
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    /// The states.
    pub states: Vec<Arc<State>>,
    /// Bytes their positions and connectivities take (24 a vertex, 12 a patch face of each group,
    /// and some 24 a vertex and 72 a face of the filled mesh for each triangulation of a patch);
    /// what states share counts once.
    pub bytes: usize,
    limit: usize,
}

impl Timeline {
    /// An empty one that may take `limit` bytes.
    pub(super) fn new(limit: usize) -> Self {
        Self {
            states: Vec::new(),
            bytes: 0,
            limit,
        }
    }

    /// The kept state of that serial number.
    pub fn find(&self, index: usize) -> Option<&Arc<State>> {
        let found = self.states.binary_search_by_key(&index, |s| s.index);
        found.ok().map(|at| &self.states[at])
    }

    /// The latest state.
    pub fn latest(&self) -> Option<&Arc<State>> {
        self.states.last()
    }

    pub(super) fn push(&mut self, state: Arc<State>) {
        self.bytes += bytes(&state, self.latest().map(AsRef::as_ref));
        self.states.push(state);
        while self.bytes > self.limit && self.states.len() > 2 {
            let last = self.states.len() - 1;
            let mut at = 0;
            self.states.retain(|_| {
                at += 1;
                (at - 1) % 2 == 0 || at - 1 == last
            });
            self.bytes = (0..self.states.len())
                .map(|i| bytes(&self.states[i], i.checked_sub(1).map(|j| &*self.states[j])))
                .sum();
        }
    }
}

/// Bytes of what a state does not share with the one before.
fn bytes(state: &State, before: Option<&State>) -> usize {
    let groups = state.groups.iter().enumerate().map(|(g, group)| {
        let earlier = before.map(|s| &s.groups[g]);
        if earlier.is_some_and(|e| Arc::ptr_eq(e, group)) {
            return 0;
        }
        let own_shape = earlier.is_none_or(|e| !Arc::ptr_eq(&e.shape, &group.shape));
        let shape = if own_shape { group.shape.bytes() } else { 0 };
        shape + group.positions.len() * size_of::<DVec3>()
    });
    let topology = if before.is_some_and(|s| Arc::ptr_eq(&s.topology, &state.topology)) {
        0
    } else {
        let plan = &state.layout.plan;
        let new = plan.new_positions.len() * size_of::<DVec3>() + plan.triangles.len() * 12;
        let topology = &state.topology;
        // half-edges hold next, target and face; vertices and faces one half-edge each
        new + topology.halfedge_count() * 12 + (topology.vertex_count() + topology.face_count()) * 4
    };
    groups.sum::<usize>() + topology
}
