//! Attributes of a mesh whose triangles are split at the midpoints of their edges.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::{Attributes, Column, NO_VALUE, append_between, picked_rows};
use crate::mesh::{FaceId, Split, Topology};

impl Attributes {
    /// Advances to the triangles of a split of `old`: new vertices and corners have the mean of the two
    /// ends of their edge, new triangles the data of the face that they are a part of.
    ///
    /// If rows are not vertices, [`Self::vertex_of_row`] has no entries for the new rows; see
    /// [`Self::number_rows`].
    pub fn split(&mut self, old: &Topology, split: &Split) {
        if self.vertex_of_row.is_empty() {
            let ends = split.edges.iter();
            let ends = ends.map(|&h| ([old.origin(h).0, old.target(h).0], 0.5));
            append_between(&mut self.vertices, &ends);
        } else {
            self.faces.rows = halved(&mut self.vertices, &self.faces.rows, old, split);
        }
        for (columns, list) in [
            (&mut self.texture, &mut self.faces.texture),
            (&mut self.normals, &mut self.faces.normals),
        ] {
            if !list.is_empty() {
                let columns: &mut Vec<Column> = Arc::make_mut(columns);
                *list = halved(columns, list, old, split);
            }
        }
        if !self.faces.tags.is_empty() {
            let tags = split.parent.iter().map(|&f| self.faces.tags[f as usize]);
            self.faces.tags = tags.collect();
        }
        self.faces.columns = picked_rows(&self.faces.columns, &split.parent);
    }

    /// Completes [`Self::vertex_of_row`] after splits, for the triangles of the split mesh.
    pub fn number_rows(&mut self, triangles: impl Iterator<Item = [u32; 3]>) {
        if self.vertex_of_row.is_empty() {
            return;
        }
        let rows = super::row_count(&self.vertices);
        self.vertex_of_row.resize(rows, NO_VALUE);
        for (&row, vertex) in self.faces.rows.iter().zip(triangles.flatten()) {
            self.vertex_of_row[row as usize] = vertex;
        }
    }
}

/// The rows of the corners of split triangles. Two faces beside an edge that refer to the same rows
/// at its ends share the new row in the middle.
fn halved(columns: &mut [Column], rows: &[u32], old: &Topology, split: &Split) -> Vec<u32> {
    let mut next = super::row_count(columns) as u32;
    let mut middles = Vec::new();
    let mut middle_of: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut new = Vec::with_capacity(3 * split.triangles.len());
    for (triangle, &f) in split.triangles.iter().zip(&split.parent) {
        let corners = old.face_vertices(FaceId(f));
        let row_at = |v: u32| {
            let k = corners.iter().position(|c| c.0 == v);
            rows[3 * f as usize + k.expect("an edge of the face ends at its corners")]
        };
        for &v in triangle {
            let Some(edge) = (v as usize).checked_sub(old.vertex_count()) else {
                new.push(row_at(v));
                continue;
            };
            let h = split.edges[edge];
            let [a, b] = [old.origin(h), old.target(h)].map(|v| row_at(v.0));
            if a == NO_VALUE || b == NO_VALUE {
                new.push(NO_VALUE);
                continue;
            }
            let ends = [a.min(b), a.max(b)];
            new.push(*middle_of.entry(ends).or_insert_with(|| {
                middles.push((ends, 0.5));
                next += 1;
                next - 1
            }));
        }
    }
    append_between(columns, &middles.iter().copied());
    new
}
