//! The kept states of a fill, in bounded memory.

use std::sync::Arc;

use crate::fill::live::State;
use crate::live::Kept;
use crate::mesh::DVec3;

/// Kept states of a fill. Their positions and connectivities take 24 bytes a vertex, 12 a patch face of
/// each group, and some 24 a vertex and 72 a face of the filled mesh for each triangulation of a
/// patch.
pub type Timeline = crate::live::Timeline<State>;

impl Kept for State {
    fn index(&self) -> usize {
        self.index
    }

    fn bytes(&self, before: Option<&Self>) -> usize {
        let groups = self.groups.iter().enumerate().map(|(g, group)| {
            let earlier = before.map(|s| &s.groups[g]);
            if earlier.is_some_and(|e| Arc::ptr_eq(e, group)) {
                return 0;
            }
            let own_shape = earlier.is_none_or(|e| !Arc::ptr_eq(&e.patches, &group.patches));
            let shape = if own_shape { group.patches.bytes() } else { 0 };
            shape + group.positions.len() * size_of::<DVec3>()
        });
        let is_kept = before.is_some_and(|s| Arc::ptr_eq(&s.assembly, &self.assembly));
        let assembly = if is_kept { 0 } else { self.assembly.bytes() };
        groups.sum::<usize>() + assembly
    }
}
