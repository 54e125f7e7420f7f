//! A mesh as the lists of a file.

use std::borrow::Cow;

use super::{Attributes, FaceData};
use crate::mesh::{DVec3, Mesh};

/// The vertices, triangles and attributes of a written file: vertices that the mesh joins are
/// separate again, and non-orientable triangles follow the others.
#[derive(Clone, Debug)]
pub struct Written<'a> {
    /// Positions, one for each row of the vertex columns.
    pub positions: Cow<'a, [DVec3]>,
    /// Triangles over the positions.
    pub triangles: Vec<[u32; 3]>,
    /// Attributes; rows are vertices, and all triangles are in [`Attributes::faces`].
    pub attributes: Cow<'a, Attributes>,
}

impl Mesh {
    /// The lists of a file of this mesh.
    pub fn written(&self) -> Written<'_> {
        let own = &self.attributes;
        let mut attributes = Cow::Borrowed(own);
        let mut triangles: Vec<[u32; 3]> = self.all_triangles().collect();
        if !self.non_orientable.is_empty() {
            let all = attributes.to_mut();
            let aside = std::mem::take(&mut all.non_orientable);
            all.faces.append(&aside);
        }
        if own.vertex_of_row.is_empty() {
            return Written {
                positions: Cow::Borrowed(&self.positions),
                triangles,
                attributes,
            };
        }
        let all = attributes.to_mut();
        let of_row = std::mem::take(&mut all.vertex_of_row);
        let FaceData { rows, .. } = &mut all.faces;
        for (triangle, rows) in triangles.iter_mut().zip(rows.chunks_exact(3)) {
            *triangle = [rows[0], rows[1], rows[2]];
        }
        rows.clear();
        let at = |&v: &u32| self.positions[v as usize];
        Written {
            positions: of_row.iter().map(at).collect(),
            triangles,
            attributes,
        }
    }
}
