//! What a mesh file holds besides positions and faces.
//!
//! Numbers are in named [`Column`]s in the type that the file declares. There are four tables: one
//! row for each vertex, one for each face, and the rows of texture coordinates and of normals, to
//! which corners refer by number. Given rows are never changed; new ones follow.

mod colors;
mod column;
mod faces;
mod materials;
mod mixing;
mod objects;
mod serial;
mod split;
mod summary;
mod texture;
mod written;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{FaceTag, Mesh, VertexId};
use colors::StlColors;

pub use colors::{Colors, color_columns, color_steps, colors, to_light, to_signal};
pub use column::{Column, NumberType, Numbers, columns_named, picked_rows, row_count};
pub use faces::{FaceData, NO_VALUE};
pub use materials::{GltfMaterials, ImageSource, Material, OwnMaterial};
pub use mixing::{append_between, append_interpolated};
pub use objects::ObjectSettings;
pub use texture::texture_columns;
pub use written::Written;

/// The name of the face property of a PLY file that chooses a texture image.
pub(crate) const TEXTURE_NUMBER: &str = "texnumber";

/// The name of the material of faces of a PLY file to which a negative number gives no texture image.
const NO_IMAGE: &str = "no image";

/// What a mesh file holds besides positions and faces. Lists are empty if it has no such data.
///
/// Serialized are those of a file ([`Written`]), without its folder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Attributes {
    /// Columns with a number for each vertex, such as colours.
    pub vertices: Vec<Column>,
    /// If the file has vertices at one place with different numbers, which the mesh joins: the vertex
    /// of each row of `vertices`. Corners then refer to rows by [`FaceData::rows`], and writing
    /// separates the vertices again.
    #[serde(skip)]
    pub vertex_of_row: Vec<u32>,
    /// Data of the faces.
    pub faces: FaceData,
    /// Data of [`Mesh::non_orientable`].
    #[serde(skip)]
    pub non_orientable: FaceData,
    /// Groups, objects and materials, in order of first use.
    pub tags: Vec<FaceTag>,
    /// Texture coordinates: the columns `u`, `v` and perhaps `w`.
    pub texture: Arc<Vec<Column>>,
    /// Whether `v` increases downwards in the image, as in glTF, and not upwards, as in other formats.
    pub texture_is_down: bool,
    /// Normals of corners: the columns `nx`, `ny` and `nz`.
    pub normals: Arc<Vec<Column>>,
    /// `mtllib` names of an OBJ file, as written there (relative to the file), in order.
    pub material_libraries: Vec<String>,
    /// The materials of a glTF or 3MF file.
    pub gltf_materials: Option<Arc<GltfMaterials>>,
    /// Materials whose images are written with the mesh.
    pub own_materials: Vec<OwnMaterial>,
    /// The lines `comment` and `obj_info` of a PLY header.
    pub comments: Vec<String>,
    /// The unit of the coordinates of a 3MF file, such as `millimeter`, if the file has one.
    pub unit: String,
    /// Names and values of the metadata of a 3MF file, such as `Title`.
    pub metadata: Vec<[String; 2]>,
    /// What a 3MF file says of its objects.
    pub objects: Vec<ObjectSettings>,
    /// The header of a binary STL file.
    #[serde(with = "serial::header")]
    pub stl_header: Option<[u8; 80]>,
    /// The folder of the file, to which names of other files are relative, if they are known to be.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
}

impl Attributes {
    /// Red, green, blue and opacity in 0..=1 for each vertex; empty if the vertices have no colour.
    pub fn vertex_colors(&self) -> Vec<[f32; 4]> {
        let of_rows = colors(&self.vertices);
        if self.vertex_of_row.is_empty() || of_rows.is_empty() {
            return of_rows;
        }
        let first = self.first_rows();
        first.iter().map(|&row| of_rows[row as usize]).collect()
    }

    /// The first row of each vertex, if rows are not vertices.
    fn first_rows(&self) -> Vec<u32> {
        let vertices = self
            .vertex_of_row
            .iter()
            .max()
            .map_or(0, |&v| v as usize + 1);
        let mut first = vec![NO_VALUE; vertices];
        for (row, &vertex) in self.vertex_of_row.iter().enumerate().rev() {
            first[vertex as usize] = row as u32;
        }
        first
    }

    /// The name of the material of a face: that of its tag, or the name of its texture file if the file is PLY
    /// and has several; empty without one. A negative number of a texture file is that of a material without image.
    pub fn material_of(&self, face: usize) -> &str {
        let tag = self.faces.tags.get(face);
        let name = tag.map_or("", |&tag| self.tags[tag as usize].material.as_str());
        let numbers = self.faces.columns.iter();
        let mut numbers = numbers.filter(|column| column.name == TEXTURE_NUMBER);
        match numbers.next() {
            Some(column) if name.is_empty() => match column.numbers.get(face) {
                number if number < 0.0 => NO_IMAGE,
                // the first one has no name, and so have faces of no number
                0.0 => name,
                number => self.texture_files().nth(number as usize).unwrap_or(""),
            },
            _ => name,
        }
    }

    /// The row of a vertex, for each vertex of a list.
    pub(crate) fn rows_of(&self, vertices: impl Iterator<Item = VertexId>) -> Vec<u32> {
        if self.vertex_of_row.is_empty() {
            return vertices.map(|v| v.0).collect();
        }
        let first = self.first_rows();
        vertices.map(|v| first[v.index()]).collect()
    }

    /// Whether vertices have a colour.
    pub fn has_vertex_colors(&self) -> bool {
        Colors::channels(&self.vertices).is_some()
    }

    /// The same attributes with the second texture coordinate `v` replaced by `1 - v`, which increases
    /// in the other direction.
    #[must_use]
    pub fn with_turned_texture(&self) -> Self {
        let mut turned = self.clone();
        turned.texture_is_down = !self.texture_is_down;
        if let Some(column) = Arc::make_mut(&mut turned.texture).get_mut(1) {
            for row in 0..column.numbers.len() {
                let v = column.numbers.get(row);
                column.numbers.set(row, 1.0 - v);
            }
        }
        turned
    }

    /// The same attributes of these triangles without own materials: the faces with one of them have no material
    /// and no texture coordinates. Those of vertices become zero.
    #[must_use]
    pub fn without_own_materials(&self, triangles: &[[u32; 3]]) -> Self {
        let mut rest = self.clone();
        let own = std::mem::take(&mut rest.own_materials);
        let is_own = |tag: &FaceTag| own.iter().any(|material| material.name == tag.material);
        let lost: Vec<bool> = rest.tags.iter().map(is_own).collect();
        for data in [&mut rest.faces, &mut rest.non_orientable] {
            for (corners, &tag) in data.texture.chunks_exact_mut(3).zip(&data.tags) {
                if lost[tag as usize] {
                    corners.fill(NO_VALUE);
                }
            }
        }
        if rest.faces.texture.is_empty()
            && let Some(columns) = texture_columns(&rest.vertices)
        {
            let tagged = triangles.iter().zip(&rest.faces.tags);
            let lost = tagged.filter(|(_, tag)| lost[**tag as usize]);
            for &v in lost.flat_map(|(triangle, _)| triangle) {
                for k in columns {
                    rest.vertices[k].numbers.set(v as usize, 0.0);
                }
            }
        }
        for (tag, _) in rest.tags.iter_mut().zip(&lost).filter(|(_, lost)| **lost) {
            tag.material.clear();
        }
        rest
    }

    /// The same attributes with the numbers of texture images of a PLY file as materials of the faces, which have
    /// the names of the images; the first one has no name. `None` unless there are several images.
    #[must_use]
    pub fn with_numbered_materials(&self) -> Option<Self> {
        let is_number = |column: &Column| column.name == TEXTURE_NUMBER;
        let numbers = self.faces.columns.iter().position(is_number)?;
        self.texture_files().nth(1)?;
        let mut all = self.clone();
        let faces = all.faces.columns.remove(numbers).numbers.len();
        if all.tags.is_empty() {
            all.tags.push(FaceTag::default());
        }
        all.faces.tags.resize(faces, 0);
        let mut known: BTreeMap<(u32, &str), u32> = BTreeMap::new();
        for (face, tag) in all.faces.tags.iter_mut().enumerate() {
            let material = self.material_of(face);
            *tag = *known.entry((*tag, material)).or_insert_with(|| {
                let old = &all.tags[*tag as usize];
                if old.material == material {
                    return *tag;
                }
                all.tags.push(FaceTag {
                    material: material.to_owned(),
                    ..old.clone()
                });
                all.tags.len() as u32 - 1
            });
        }
        Some(all)
    }

    /// Whether vertices have numbers.
    pub fn has_vertex_columns(&self) -> bool {
        !self.vertices.is_empty()
    }

    /// Red, green and blue in 0..=1 for each face, where they are known; empty if the vertices have colours or
    /// the faces have none. They are columns of faces, or the attributes of an STL file.
    pub fn face_colors(&self) -> Vec<Option<[f32; 3]>> {
        if self.has_vertex_colors() {
            return Vec::new();
        }
        let of_columns = colors(&self.faces.columns);
        if !of_columns.is_empty() {
            let shades = of_columns.into_iter().map(|[r, g, b, _]| Some([r, g, b]));
            return shades.collect();
        }
        let of_stl = StlColors::of(&self.faces.columns, self.stl_header.as_ref());
        of_stl.map_or_else(Vec::new, |colors| colors.all())
    }

    /// Whether faces have a colour, perhaps beside vertices.
    pub fn has_face_colors(&self) -> bool {
        let columns = &self.faces.columns;
        let of_stl = || StlColors::of(columns, self.stl_header.as_ref());
        Colors::channels(columns).is_some() || of_stl().is_some()
    }

    /// Whether vertices or faces have a colour.
    pub fn has_colors(&self) -> bool {
        self.has_vertex_colors() || self.has_face_colors()
    }

    /// Appends the numbers of new vertices, which follow the `given` ones: each is at `t` of the way
    /// from one vertex to another, as in `append_between`.
    pub fn append_vertices(&mut self, given: usize, pairs: &[([VertexId; 2], f64)]) {
        if self.vertices.is_empty() {
            return;
        }
        let ends = self.rows_of(pairs.iter().flat_map(|(ends, _)| *ends));
        let ends = ends.chunks_exact(2).map(|e| [e[0], e[1]]);
        let ratios = pairs.iter().map(|(_, t)| *t);
        append_between(&mut self.vertices, &ends.zip(ratios));
        self.number_new_rows(given, pairs.len());
    }

    /// Appends the numbers of new vertices, which follow the `given` ones, as
    /// `append_interpolated` does from those of the vertices `known`.
    pub fn append_interpolated(
        &mut self,
        given: usize,
        known: &[VertexId],
        nearest: &[VertexId],
        interpolate: impl FnMut(&[f64]) -> Vec<f64>,
    ) {
        if self.vertices.is_empty() {
            return;
        }
        let known = self.rows_of(known.iter().copied());
        let rows = self.rows_of(nearest.iter().copied());
        append_interpolated(&mut self.vertices, &known, &rows, interpolate);
        self.number_new_rows(given, nearest.len());
    }

    fn number_new_rows(&mut self, given: usize, count: usize) {
        if !self.vertex_of_row.is_empty() {
            let new = given..given + count;
            self.vertex_of_row.extend(new.map(|v| v as u32));
        }
    }

    /// Appends the numbers of `count` new faces as `append_interpolated` does from those of the faces
    /// `known`. Labels are those of face `like`.
    pub fn append_face_numbers(
        &mut self,
        known: &[u32],
        like: u32,
        count: usize,
        interpolate: impl FnMut(&[f64]) -> Vec<f64>,
    ) {
        let nearest = vec![like; count];
        append_interpolated(&mut self.faces.columns, known, &nearest, interpolate);
    }

    /// Appends the data of new triangles, which follow the `given` ones: that of face `like`, except numbers
    /// that they have already, with another tag if `tag` is given. Their corners have the first rows of their vertices, and no
    /// texture coordinates and normals.
    ///
    /// All new vertices must have been appended.
    pub fn append_triangles(
        &mut self,
        given: usize,
        like: usize,
        tag: Option<u32>,
        triangles: &[[u32; 3]],
    ) {
        self.faces.append_like(given, like, triangles.len());
        if let Some(tag) = tag {
            self.faces.tags[given..].fill(tag);
        }
        if !self.faces.rows.is_empty() {
            let corners = triangles.as_flattened().iter().map(|&v| VertexId(v));
            let rows = self.rows_of(corners);
            self.faces.rows[3 * given..].copy_from_slice(&rows);
        }
    }

    /// The attributes of a part of a mesh: of these vertices and faces, in ascending order.
    #[must_use]
    pub fn picked(&self, vertices: &[u32], faces: &[u32]) -> Self {
        let mut part = Self {
            vertices: Vec::new(),
            vertex_of_row: Vec::new(),
            faces: self.faces.picked_triangles(faces),
            ..self.clone()
        };
        if self.vertex_of_row.is_empty() {
            part.vertices = picked_rows(&self.vertices, vertices);
            return part;
        }
        let mut rows = Vec::new();
        let mut new_row = vec![NO_VALUE; self.vertex_of_row.len()];
        for (row, vertex) in self.vertex_of_row.iter().enumerate() {
            if let Ok(vertex) = vertices.binary_search(vertex) {
                new_row[row] = rows.len() as u32;
                rows.push(row as u32);
                part.vertex_of_row.push(vertex as u32);
            }
        }
        part.vertices = picked_rows(&self.vertices, &rows);
        let lists = [&mut part.faces.rows, &mut part.non_orientable.rows];
        for row in lists.into_iter().flatten() {
            *row = new_row[*row as usize];
        }
        part
    }

    /// The attributes of a mesh with the same faces whose vertices have the numbers of these vertices.
    #[must_use]
    pub fn with_vertices(&self, vertices: &[u32]) -> Self {
        if !self.vertex_of_row.is_empty() {
            // corners refer to rows, which stay
            return self.clone();
        }
        Self {
            vertices: picked_rows(&self.vertices, vertices),
            ..self.clone()
        }
    }

    /// Size in bytes of what changes with a refinement.
    pub fn bytes(&self) -> usize {
        let tables = [&self.vertices, &*self.texture, &*self.normals];
        let columns = tables.into_iter().flatten();
        let columns: usize = columns.map(|column| column.numbers.bytes()).sum();
        columns + 4 * self.vertex_of_row.len() + self.faces.bytes() + self.non_orientable.bytes()
    }
}

impl Mesh {
    /// Red, green, blue and opacity in 0..=1 for each vertex; empty if the mesh has no colours.
    pub fn colors(&self) -> Vec<[f32; 4]> {
        self.attributes.vertex_colors()
    }
}
