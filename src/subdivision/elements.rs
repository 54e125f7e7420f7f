//! Control vertices and basis tables of a list of faces.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::basis::BasisTable;
use super::cache;
use super::folding::{Folder, Folding};
use super::gather::{gather, stencil_size};
use super::rule::Rule;
use crate::mesh::{FaceId, Topology};

/// The control vertices and basis functions of a list of faces.
///
/// Faces are sorted by table; faces of one table keep the given order. The first three control
/// vertices of an element are the corners of its face in the face's own order. The vertices of an
/// element are distinct.
#[derive(Clone, Debug)]
pub struct Elements {
    /// One table for each class of the stencils.
    tables: Vec<Arc<BasisTable>>,
    stencils: Arc<Stencils>,
}

/// The control vertices of a list of faces: the data that do not depend on the points at which
/// basis functions are tabulated.
#[derive(Debug)]
pub struct Stencils {
    classes: Vec<Class>,
    /// For each element its class.
    class_of: Vec<u32>,
    /// For each element the start of its control vertices in `vertices`; one more entry at the end.
    offset: Vec<u32>,
    vertices: Vec<u32>,
    /// For each element its face.
    faces: Vec<u32>,
}

/// Faces with the same basis functions.
#[derive(Debug)]
enum Class {
    /// Faces whose control vertices are distinct real vertices.
    Valences([usize; 3]),
    /// All other faces.
    Folded(Folding),
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.stencils.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.stencils.faces.is_empty()
    }

    /// Control vertices of an element, in the order of its table's columns.
    #[inline]
    pub fn vertices_of(&self, element: usize) -> &[u32] {
        let s = &*self.stencils;
        &s.vertices[s.offset[element] as usize..s.offset[element + 1] as usize]
    }

    /// Table of an element.
    #[inline]
    pub fn table(&self, element: usize) -> &BasisTable {
        &self.tables[self.table_of()[element] as usize]
    }

    /// The tables in use.
    pub fn tables(&self) -> &[Arc<BasisTable>] {
        &self.tables
    }

    /// For each element the index of its table.
    pub fn table_of(&self) -> &[u32] {
        &self.stencils.class_of
    }

    /// For each element the start of its control vertices in [`Self::vertices`]; one more entry at
    /// the end.
    pub fn offsets(&self) -> &[u32] {
        &self.stencils.offset
    }

    /// Control vertices of all elements.
    pub fn vertices(&self) -> &[u32] {
        &self.stencils.vertices
    }

    /// For each element its face.
    pub fn faces(&self) -> &[u32] {
        &self.stencils.faces
    }

    /// Tables for the points of `rule`.
    pub fn new(stencils: Arc<Stencils>, rule: Rule) -> Self {
        Self::tabulated(stencils, |class| match class {
            Class::Valences(valences) => cache::table(*valences, rule),
            Class::Folded(folding) => cache::folded_table(folding, rule),
        })
    }

    fn tabulated(stencils: Arc<Stencils>, table: impl FnMut(&Class) -> Arc<BasisTable>) -> Self {
        Self {
            tables: stencils.classes.iter().map(table).collect(),
            stencils,
        }
    }
}

/// The elements of `faces` with tables for the points of `rule`; see [`Stencils::new`].
pub fn elements(topology: &Topology, faces: &[FaceId], rule: Rule) -> Elements {
    Elements::new(Arc::new(Stencils::new(topology, faces)), rule)
}

/// [`elements()`] with tables for any `points` `(v, w)` of the closed parameter triangle, which need
/// not be those of a rule. Derivatives at corners of valence other than 6 are NaN.
pub fn elements_at(topology: &Topology, faces: &[FaceId], points: &[[f64; 2]]) -> Elements {
    let stencils = Arc::new(Stencils::new(topology, faces));
    Elements::tabulated(stencils, |class| {
        Arc::new(match class {
            Class::Valences(valences) => BasisTable::at_points(*valences, points),
            Class::Folded(folding) if folding.is_flat() => BasisTable::flat(points),
            Class::Folded(folding) => {
                folding.apply(&BasisTable::at_points(folding.valences, points))
            }
        })
    })
}

impl Stencils {
    /// Gathers the stencils of `faces`.
    ///
    /// Where a corner of a face lies on an open boundary, the mesh is extended. Beyond each
    /// boundary edge `(p, q)` of a triangle `(p, q, r)` lies a ghost vertex `p + q - r`. At each
    /// boundary vertex, one more triangle lies between the ghosts of its two boundary edges. Ghosts
    /// do not appear in the result: their basis functions are added to those of the vertices that
    /// define them. Likewise, a vertex that occurs several times around a triangle of a tiny closed
    /// mesh appears once, with the sum of its functions. Two triangles glued along all their edges
    /// are flat elements with their corners as the only control vertices.
    pub fn new(topology: &Topology, faces: &[FaceId]) -> Self {
        let gathered = gather(topology, faces);
        let mut out = Self {
            classes: Vec::with_capacity(gathered.classes.len()),
            class_of: Vec::with_capacity(faces.len()),
            offset: Vec::with_capacity(faces.len() + 1),
            vertices: gathered.vertices,
            faces: gathered.faces,
        };
        let mut end = 0;
        out.offset.push(end);
        for (valences, count) in gathered.classes {
            let class = out.classes.len() as u32;
            out.classes.push(Class::Valences(valences));
            out.class_of.extend(std::iter::repeat_n(class, count));
            let n = stencil_size(valences) as u32;
            out.offset.extend((1..=count as u32).map(|i| end + i * n));
            end += count as u32 * n;
        }
        out.push_folded(topology, &gathered.to_fold);
        out
    }

    /// Appends the elements whose control vertices are not distinct real vertices.
    fn push_folded(&mut self, topology: &Topology, faces: &[FaceId]) {
        let mut folder = Folder::new(topology);
        let mut folded = BTreeMap::new();
        for &f in faces {
            let (folding, vertices) = folder.fold(f);
            folded
                .entry(folding)
                .or_insert_with(Vec::new)
                .push((f, vertices));
        }
        for (folding, group) in folded {
            let class = self.classes.len() as u32;
            self.classes.push(Class::Folded(folding));
            for (f, vertices) in group {
                self.vertices.extend(vertices);
                self.class_of.push(class);
                self.offset.push(self.vertices.len() as u32);
                self.faces.push(f.0);
            }
        }
    }
}
