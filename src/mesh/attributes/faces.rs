//! What a file holds for its faces and their corners.

use serde::{Deserialize, Serialize};

use super::column::{Column, picked_rows};

/// The index of a corner without a value.
pub const NO_VALUE: u32 = u32::MAX;

/// Data of faces and their corners. A list is empty if the file has no such data. Lists of corners
/// have one entry for each corner, face by face.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaceData {
    /// For each face its index in [`Attributes::tags`](super::Attributes::tags).
    pub tags: Vec<u32>,
    /// Columns with a number for each face.
    pub columns: Vec<Column>,
    /// For each corner its row of the texture coordinates, or [`NO_VALUE`].
    pub texture: Vec<u32>,
    /// For each corner its row of the normals, or [`NO_VALUE`].
    pub normals: Vec<u32>,
    /// For each corner its row of the vertex columns; empty if rows are vertices.
    #[serde(skip)]
    pub rows: Vec<u32>,
}

impl FaceData {
    /// The lists of corners.
    pub(super) fn corner_lists(&self) -> [&Vec<u32>; 3] {
        [&self.texture, &self.normals, &self.rows]
    }

    pub(super) fn corner_lists_mut(&mut self) -> [&mut Vec<u32>; 3] {
        [&mut self.texture, &mut self.normals, &mut self.rows]
    }

    /// The data of these faces, whose corners are these.
    #[must_use]
    pub(crate) fn picked(
        &self,
        faces: &[u32],
        corners: &(impl Iterator<Item = u32> + Clone),
    ) -> Self {
        let of_corners = |list: &Vec<u32>| -> Vec<u32> {
            if list.is_empty() {
                return Vec::new();
            }
            corners.clone().map(|c| list[c as usize]).collect()
        };
        let tag = |&face: &u32| self.tags.get(face as usize).copied();
        Self {
            tags: faces.iter().filter_map(tag).collect(),
            columns: picked_rows(&self.columns, faces),
            texture: of_corners(&self.texture),
            normals: of_corners(&self.normals),
            rows: of_corners(&self.rows),
        }
    }

    /// The data of these triangles, of data of triangles.
    #[must_use]
    pub fn picked_triangles(&self, faces: &[u32]) -> Self {
        let corners = faces.iter().flat_map(|&f| 3 * f..3 * f + 3);
        self.picked(faces, &corners)
    }

    /// Exchanges the second and the third corner of a triangle.
    pub fn flip(&mut self, triangle: usize) {
        for list in self.corner_lists_mut() {
            if !list.is_empty() {
                list.swap(3 * triangle + 1, 3 * triangle + 2);
            }
        }
    }

    /// Appends a copy of the data of triangle `like` for each of `count` new triangles behind the
    /// `given` ones; their corners have no values. Columns that have rows for them stay.
    pub(super) fn append_like(&mut self, given: usize, like: usize, count: usize) {
        if !self.tags.is_empty() {
            self.tags.resize(given + count, self.tags[like]);
        }
        for column in &mut self.columns {
            for _ in column.numbers.len()..given + count {
                column.numbers.repeat(like);
            }
        }
        for list in self.corner_lists_mut() {
            if !list.is_empty() {
                list.resize(3 * (given + count), NO_VALUE);
            }
        }
    }

    /// Appends other data. The columns are the same.
    pub(super) fn append(&mut self, other: &Self) {
        self.tags.extend_from_slice(&other.tags);
        for (own, others) in self.columns.iter_mut().zip(&other.columns) {
            for row in 0..others.numbers.len() {
                own.numbers.push(others.numbers.get(row));
            }
        }
        for (own, others) in self
            .corner_lists_mut()
            .into_iter()
            .zip(other.corner_lists())
        {
            own.extend_from_slice(others);
        }
    }

    /// Size in bytes.
    pub(super) fn bytes(&self) -> usize {
        let columns = self.columns.iter().map(|column| column.numbers.bytes());
        let corners: usize = self.corner_lists().iter().map(|list| list.len()).sum();
        columns.sum::<usize>() + 4 * (self.tags.len() + corners)
    }
}
