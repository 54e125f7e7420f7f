//! Control vertices and basis tables of a list of faces.

use super::basis::{BasisTable, TableCache};
use super::folding::{Folding, fold};
use super::gather::gather;
use super::rule::Rule;
use crate::mesh::{FaceId, Topology};

/// The stencils of a list of faces: which vertices control each, and with which basis functions.
///
/// Faces are sorted by table, those of one table in the order in which they were given. The first
/// three control vertices of an element are the corners of its face in the face's own order; the
/// vertices of an element are distinct.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    /// Tables that occur.
    pub tables: Vec<BasisTable>,
    /// For each element its table.
    pub table_of: Vec<u32>,
    /// For each element the start of its control vertices in `vertices`; one more entry at the end.
    pub offset: Vec<u32>,
    /// Control vertices of all elements, in the order of the table's columns.
    pub vertices: Vec<u32>,
    /// For each element its face.
    pub faces: Vec<u32>,
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Control vertices of an element.
    #[inline]
    pub fn vertices_of(&self, element: usize) -> &[u32] {
        &self.vertices[self.offset[element] as usize..self.offset[element + 1] as usize]
    }

    /// Table of an element.
    #[inline]
    pub fn table(&self, element: usize) -> &BasisTable {
        &self.tables[self.table_of[element] as usize]
    }
}

/// Gathers the stencils of `faces`, with tables for the points of `rule`.
///
/// Where a corner of a face lies on an open boundary, the mesh is thought continued: beyond each
/// boundary edge `(p, q)` of a triangle `(p, q, r)` by a ghost vertex `p + q - r`, and at each
/// boundary vertex by one more triangle between the ghosts of its two boundary edges. Ghosts do not
/// appear in the result: their basis functions are added to those of the vertices they are made of.
/// Likewise a vertex that occurs several times around a triangle of a tiny closed mesh appears once,
/// with the sum of its functions. Two triangles glued along all their edges are flat elements of
/// their corners alone.
pub fn elements(
    topology: &Topology,
    faces: &[FaceId],
    rule: Rule,
    cache: &mut TableCache,
) -> Elements {
    collect(topology, faces, |class| match class {
        Class::Valences(valences) => cache.table(valences, rule).clone(),
        Class::Folded(folding) => cache.folded_table(folding, rule).clone(),
    })
}

/// [`elements()`] with tables for any `points` `(v, w)` of the closed parameter triangle, which need
/// not be those of a rule. Derivatives at corners of valence other than 6 are NaN.
pub fn elements_at(topology: &Topology, faces: &[FaceId], points: &[[f64; 2]]) -> Elements {
    collect(topology, faces, |class| match class {
        Class::Valences(valences) => BasisTable::at_points(valences, points),
        Class::Folded(folding) if folding.is_flat() => BasisTable::flat(points),
        Class::Folded(folding) => folding.apply(&BasisTable::at_points(folding.valences, points)),
    })
}

/// Faces with the same table.
enum Class<'a> {
    /// Their control vertices are distinct real vertices.
    Valences([usize; 3]),
    /// They are not.
    Folded(&'a Folding),
}

fn collect(
    topology: &Topology,
    faces: &[FaceId],
    mut table_of: impl FnMut(Class<'_>) -> BasisTable,
) -> Elements {
    let gathered = gather(topology, faces);
    let mut out = Elements {
        tables: Vec::with_capacity(gathered.classes.len()),
        table_of: Vec::with_capacity(faces.len()),
        offset: Vec::with_capacity(faces.len() + 1),
        vertices: gathered.vertices,
        faces: gathered.faces,
    };
    let mut end = 0;
    out.offset.push(end);
    for (valences, count) in gathered.classes {
        let table = out.tables.len() as u32;
        out.tables.push(table_of(Class::Valences(valences)));
        out.table_of.extend(std::iter::repeat_n(table, count));
        let n = stencil_size(valences) as u32;
        out.offset.extend((1..=count as u32).map(|i| end + i * n));
        end += count as u32 * n;
    }
    push_folded(topology, &gathered.to_fold, &mut table_of, &mut out);
    out
}

/// Appends the elements whose control vertices are not distinct real vertices.
fn push_folded(
    topology: &Topology,
    faces: &[FaceId],
    table_of: &mut impl FnMut(Class<'_>) -> BasisTable,
    out: &mut Elements,
) {
    let mut folded: Vec<_> = faces.iter().map(|&f| (fold(topology, f), f)).collect();
    folded.sort_by(|((a, _), _), ((b, _), _)| a.cmp(b));
    for group in folded.chunk_by(|((a, _), _), ((b, _), _)| a == b) {
        let table = out.tables.len() as u32;
        let ((folding, _), _) = &group[0];
        out.tables.push(table_of(Class::Folded(folding)));
        for ((_, vertices), f) in group {
            out.vertices.extend_from_slice(vertices);
            out.table_of.push(table);
            out.offset.push(out.vertices.len() as u32);
            out.faces.push(f.0);
        }
    }
}

/// Number of control vertices of a triangle.
pub(super) fn stencil_size([a, b, c]: [usize; 3]) -> usize {
    (a + b + c - 6).max(4)
}
