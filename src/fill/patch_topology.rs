//! Connectivity of a group's patches, apart from the positions of their vertices.

use crate::patch::Patch;

/// The triangulation of one hole, in the vertex numbers of its [`Patch`]: rim vertices first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct HoleTopology {
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// Number of vertices that are not on a rim.
    pub new_vertices: usize,
}

impl HoleTopology {
    pub fn of(patch: &Patch) -> Self {
        Self {
            triangles: patch.triangles.clone(),
            new_vertices: patch.new_points().len(),
        }
    }
}

/// The triangulations of a group's holes, in the order of [`Group::holes`](crate::fill::group::Group).
///
/// Values of a group's new vertices (such as positions) come in one list: those of the first hole,
/// then those of the second, and so on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct PatchTopology {
    pub holes: Vec<HoleTopology>,
}

impl PatchTopology {
    /// Number of new vertices of all holes.
    pub fn new_vertices(&self) -> usize {
        self.holes.iter().map(|hole| hole.new_vertices).sum()
    }

    /// Size of the triangles in bytes.
    pub fn bytes(&self) -> usize {
        let triangles: usize = self.holes.iter().map(|h| h.triangles.len()).sum();
        triangles * size_of::<[u32; 3]>()
    }

    /// Every hole with its part of the values of the group's new vertices.
    pub fn split<'a, T>(
        &'a self,
        values: &'a [T],
    ) -> impl Iterator<Item = (&'a HoleTopology, &'a [T])> {
        let mut rest = values;
        self.holes.iter().map(move |hole| {
            let (own, after) = rest.split_at(hole.new_vertices);
            rest = after;
            (hole, own)
        })
    }
}
