//! Polygons as read from a file, before any repair.

use serde::{Deserialize, Serialize};

use super::{Attributes, DVec3};

/// Positions and polygons in file order, with everything else that the file holds.
///
/// Nothing is checked beyond index ranges and finite coordinates: faces may be degenerate,
/// duplicated, inconsistently oriented or unconnected (STL).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// Vertex positions, in the units and the order of the file.
    pub positions: Vec<DVec3>,
    /// Corner vertex indices of all polygons, one polygon after the other.
    pub corners: Vec<u32>,
    /// The start of each polygon in `corners`, and the end; empty without polygons.
    pub offsets: Vec<u32>,
    /// What the file holds besides; its faces are the polygons.
    pub attributes: Attributes,
    /// Whether positions are repeated for every face (STL), so that equal positions mean the same
    /// vertex.
    pub exploded: bool,
    /// Notes of the reader for the load report ("material library x.mtl not read").
    pub notes: Vec<String>,
}

/// Group, object, material and smoothing group of a run of faces in an OBJ file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct FaceTag {
    /// `o` name, empty if none.
    pub object: String,
    /// `g` name, empty if none.
    pub group: String,
    /// `usemtl` name, empty if none.
    pub material: String,
    /// `s` value, empty if none.
    pub smoothing: String,
}

impl FaceTag {
    /// The tag with the group of patch `number`, such as `patch_1`.
    #[must_use]
    pub fn in_patch(&self, number: u32) -> Self {
        Self {
            group: format!("{PATCH}{number}"),
            ..self.clone()
        }
    }

    /// The number of the patch whose group this is.
    pub fn patch(&self) -> Option<u32> {
        self.group.strip_prefix(PATCH)?.parse().ok()
    }
}

/// How the names of the groups of patches begin.
const PATCH: &str = "patch_";

impl Soup {
    /// Number of polygons.
    pub fn face_count(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// The corners of polygon `f`.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corners[self.offsets[f] as usize..self.offsets[f + 1] as usize]
    }
}
