//! Texture coordinates among the columns of vertices, as many PLY files have them.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::column::{Column, columns_named, row_count};
use super::{Attributes, NO_VALUE};
use crate::mesh::Mesh;

/// The texture coordinates among columns, by their names.
pub fn texture_columns(columns: &[Column]) -> Option<[usize; 2]> {
    const NAMES: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
    let named = |names| columns_named(columns, names);
    let found: [usize; 2] = NAMES.into_iter().find_map(named)?;
    let is_whole = |&k: &usize| columns[k].numbers.kind().is_integer();
    (!found.iter().any(is_whole)).then_some(found)
}

impl Attributes {
    /// Whether corners or vertices have texture coordinates.
    pub fn has_texture(&self) -> bool {
        !self.faces.texture.is_empty() || texture_columns(&self.vertices).is_some()
    }

    /// The same attributes of these triangles, and of the non-orientable ones `aside`, with the texture coordinates
    /// of vertices also as those of corners: rows of the vertex columns are rows of both. `None` if corners have
    /// texture coordinates of their own, or vertices have none.
    #[must_use]
    pub fn with_texture_of_corners(
        &self,
        triangles: impl Iterator<Item = [u32; 3]>,
        aside: &[[u32; 3]],
    ) -> Option<Self> {
        if !self.faces.texture.is_empty() {
            return None;
        }
        let columns = texture_columns(&self.vertices)?;
        let mut all = self.clone();
        all.texture = Arc::new(Vec::from(columns.map(|k| self.vertices[k].clone())));
        // as in PLY and OFF files
        all.texture_is_down = false;
        (all.faces.texture, all.non_orientable.texture) = if self.vertex_of_row.is_empty() {
            (triangles.flatten().collect(), aside.as_flattened().to_vec())
        } else {
            (self.faces.rows.clone(), self.non_orientable.rows.clone())
        };
        Some(all)
    }

    /// Undoes [`Self::with_texture_of_corners`] of the mesh `given`, to which vertices and triangles have been
    /// appended. `triangles` are all of them. The new corners refer to rows of the vertex columns with their texture
    /// coordinates; where a vertex has others, its row is repeated with them. Corners without texture coordinates
    /// keep their rows.
    pub(crate) fn return_texture(&mut self, given: &Mesh, triangles: &[[u32; 3]]) {
        let Some(columns) = texture_columns(&self.vertices) else {
            return;
        };
        let texture = std::mem::take(&mut self.texture);
        let places = std::mem::take(&mut self.faces.texture);
        self.non_orientable.texture.clear();
        self.texture_is_down = given.attributes.texture_is_down;
        let corners = triangles.as_flattened();
        let before = row_count(&self.vertices);
        let had_rows = !self.vertex_of_row.is_empty();
        if !had_rows {
            self.vertex_of_row = (0..before as u32).collect();
            self.faces.rows = corners.to_vec();
            self.non_orientable.rows = given.non_orientable.as_flattened().to_vec();
        }
        let given_rows = row_count(&given.attributes.vertices);
        let is_given = |v: u32| (v as usize) < given.vertex_count();
        let mut row_of: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let mut has_place: FxHashSet<u32> = FxHashSet::default();
        for corner in 3 * given.face_count()..corners.len() {
            let (v, place) = (corners[corner], places[corner]);
            if place == NO_VALUE {
                continue;
            }
            if (place as usize) < given_rows {
                self.faces.rows[corner] = place;
                continue;
            }
            let own = self.faces.rows[corner];
            let row = *row_of.entry([v, place]).or_insert_with(|| {
                let is_free = !is_given(v) && has_place.insert(v);
                let row = if is_free {
                    own
                } else {
                    for column in &mut self.vertices {
                        column.numbers.repeat(own as usize);
                    }
                    self.vertex_of_row.push(v);
                    self.vertex_of_row.len() as u32 - 1
                };
                for (k, column) in columns.into_iter().zip(texture.iter()) {
                    let number = column.numbers.get(place as usize);
                    self.vertices[k].numbers.set(row as usize, number);
                }
                row
            });
            self.faces.rows[corner] = row;
        }
        if !had_rows && row_count(&self.vertices) == before {
            // rows are vertices
            self.vertex_of_row.clear();
            self.faces.rows.clear();
            self.non_orientable.rows.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, Numbers};

    /// A triangle with texture coordinates of vertices, to which one of another place in the image is added.
    #[test]
    fn vertices_are_repeated_where_texture_coordinates_differ() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut given = Mesh::from_triangles(positions, &[[0, 1, 2]]).expect("a triangle");
        let column = |name: &str, numbers: &[f64]| Column::decimals(name, numbers.to_vec());
        given.attributes.vertices = vec![
            column("quality", &[1.0, 2.0, 3.0]),
            column("s", &[0.1, 0.2, 0.3]),
            column("t", &[0.4, 0.5, 0.6]),
        ];
        let triangles = given.topology.triangles();
        let viewed = given.attributes.with_texture_of_corners(triangles, &[]);
        let viewed = viewed.expect("texture coordinates");
        assert_eq!(viewed.faces.texture, [0, 1, 2]);
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let appended = |places: [u32; 3]| {
            let mut all = viewed.clone();
            for (k, number) in [4.0, 0.0, 0.0].into_iter().enumerate() {
                all.vertices[k].numbers.push(number);
            }
            for column in Arc::make_mut(&mut all.texture) {
                column.numbers.push(0.8);
                column.numbers.push(0.9);
            }
            all.faces.texture.extend(places);
            all.return_texture(&given, &triangles);
            assert!(all.texture.is_empty() && all.faces.texture.is_empty());
            all
        };
        let numbers = |all: &Attributes, k: usize| -> Vec<f64> {
            let numbers = &all.vertices[k].numbers;
            (0..numbers.len()).map(|row| numbers.get(row)).collect()
        };
        // a continued chart
        let all = appended([1, 0, 3]);
        assert!(all.faces.rows.is_empty() && all.vertex_of_row.is_empty());
        assert_eq!(numbers(&all, 1), [0.1, 0.2, 0.3, 0.8]);
        // another chart
        let all = appended([3, 4, 4]);
        assert_eq!(all.vertex_of_row, [0, 1, 2, 3, 1, 0]);
        assert_eq!(all.faces.rows, [0, 1, 2, 4, 5, 3]);
        assert_eq!(numbers(&all, 0), [1.0, 2.0, 3.0, 4.0, 2.0, 1.0]);
        assert_eq!(numbers(&all, 2), [0.4, 0.5, 0.6, 0.9, 0.8, 0.9]);
        // no chart
        let all = appended([NO_VALUE; 3]);
        assert!(all.faces.rows.is_empty());
        assert_eq!(numbers(&all, 1), [0.1, 0.2, 0.3, 0.0]);
    }

    #[test]
    fn whole_numbers_are_no_texture_coordinates() {
        let column = |name: &str, numbers: Numbers| Column {
            name: name.into(),
            numbers,
            is_typed: true,
        };
        let mut columns = vec![
            column("v", Numbers::F32(vec![0.5])),
            column("u", Numbers::F32(vec![0.5])),
        ];
        assert_eq!(texture_columns(&columns), Some([1, 0]));
        columns[0] = column("v", Numbers::I32(vec![5]));
        assert_eq!(texture_columns(&columns), None);
    }
}
