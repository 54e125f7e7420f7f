//! Control vertices of faces away from the boundary, in one pass, with the faces sorted by
//! valences.

use std::collections::BTreeMap;

use super::masks::EXACT_VALENCE;
use crate::mesh::{FaceId, Topology, VertexId};

/// Number of control vertices of a triangle.
pub(super) fn stencil_size([a, b, c]: [usize; 3]) -> usize {
    (a + b + c - 6).max(4)
}

/// The stencils of a list of faces, and the faces that need folding.
pub(super) struct Gathered {
    /// Distinct valence triples, ascending, each with the number of its faces.
    pub(super) classes: Vec<([usize; 3], usize)>,
    /// The faces of the first class, then of the second, and so on, each in the given order.
    pub(super) faces: Vec<u32>,
    /// The control vertices of these faces in standard order.
    pub(super) vertices: Vec<u32>,
    /// Faces with a corner on an open boundary, of valence 2 or above [`EXACT_VALENCE`], or a vertex
    /// that occurs twice.
    pub(super) to_fold: Vec<FaceId>,
}

/// Finds rings and classes in a first pass and writes the stencils to their sorted places in a
/// second. Both passes run in the order of `faces`, which is close to the order of the vertices in
/// memory.
pub(super) fn gather(topology: &Topology, faces: &[FaceId]) -> Gathered {
    let mut rings = Rings::new(topology);
    let mut classes = Classes::new();
    let mut to_fold = Vec::new();
    let class_of: Vec<u32> = faces
        .iter()
        .map(|&f| {
            if let Some(valences) = rings.valences(topology.face_vertices(f)) {
                classes.count(valences)
            } else {
                to_fold.push(f);
                UNFIT
            }
        })
        .collect();

    let mut parts = Parts::new(&classes.found);
    for (&f, &class) in faces.iter().zip(&class_of) {
        if class != UNFIT && !parts.push(class as usize, f, topology, &mut rings) {
            to_fold.push(f);
        }
    }
    parts.close_gaps();
    Gathered {
        classes: parts.ranges.iter().map(|p| (p.valences, p.count)).collect(),
        faces: parts.faces,
        vertices: parts.vertices,
        to_fold,
    }
}

/// The place of a class in the sorted arrays.
struct Part {
    valences: [usize; 3],
    first_face: usize,
    first_vertex: usize,
    /// Number of faces written so far.
    count: usize,
}

/// Faces and stencils sorted by class.
struct Parts {
    /// In ascending order of valences.
    ranges: Vec<Part>,
    /// For each class its place in `ranges`.
    rank: Vec<usize>,
    faces: Vec<u32>,
    vertices: Vec<u32>,
}

impl Parts {
    /// Reserves the places of all faces of the given valences and numbers.
    fn new(classes: &[([usize; 3], usize)]) -> Self {
        let mut order: Vec<usize> = (0..classes.len()).collect();
        order.sort_unstable_by_key(|&c| classes[c].0);
        let mut rank = vec![0; classes.len()];
        let (mut first_face, mut first_vertex) = (0, 0);
        let mut ranges = Vec::with_capacity(classes.len());
        for &class in &order {
            let (valences, count) = classes[class];
            rank[class] = ranges.len();
            ranges.push(Part {
                valences,
                first_face,
                first_vertex,
                count: 0,
            });
            first_face += count;
            first_vertex += count * stencil_size(valences);
        }
        Self {
            ranges,
            rank,
            faces: vec![0; first_face],
            vertices: vec![0; first_vertex],
        }
    }

    /// Writes a face and its control vertices. If a vertex occurs twice, writes nothing and returns
    /// `false`.
    fn push(&mut self, class: usize, f: FaceId, topology: &Topology, rings: &mut Rings) -> bool {
        let part = &mut self.ranges[self.rank[class]];
        let n = stencil_size(part.valences);
        let start = part.first_vertex + part.count * n;
        let stencil = &mut self.vertices[start..start + n];
        if !rings.write_stencil(topology.face_vertices(f), part.valences, stencil) {
            return false;
        }
        self.faces[part.first_face + part.count] = f.0;
        part.count += 1;
        true
    }

    /// Closes the gaps where faces were refused.
    fn close_gaps(&mut self) {
        let (mut faces, mut vertices) = (0, 0);
        for part in &self.ranges {
            let n = part.count * stencil_size(part.valences);
            if faces < part.first_face {
                let from = part.first_face..part.first_face + part.count;
                self.faces.copy_within(from, faces);
                let from = part.first_vertex..part.first_vertex + n;
                self.vertices.copy_within(from, vertices);
            }
            faces += part.count;
            vertices += n;
        }
        self.faces.truncate(faces);
        self.vertices.truncate(vertices);
        self.ranges.retain(|part| part.count > 0);
    }
}

/// Replaces a ring or a class of faces that are not handled here.
const UNFIT: u32 = u32::MAX;

/// Neighbours of vertices; each ring is computed once.
struct Rings<'a> {
    topology: &'a Topology,
    /// For each vertex the place of its ring in `data`; 0 if it has not been visited.
    span: Vec<u32>,
    /// For each vertex its valence, then its neighbours counter-clockwise.
    data: Vec<u32>,
    /// For each vertex the last stencil that has it, by number, to find repetitions.
    last_stencil: Vec<u32>,
    stencils: u32,
}

impl<'a> Rings<'a> {
    fn new(topology: &'a Topology) -> Self {
        Self {
            topology,
            span: vec![0; topology.vertex_count()],
            // so that no ring starts at 0
            data: vec![0],
            last_stencil: vec![0; topology.vertex_count()],
            stencils: 0,
        }
    }

    /// Corner valences of a face; `None` if a corner is on a boundary, has only two neighbours or has
    /// more than [`EXACT_VALENCE`].
    fn valences(&mut self, corners: [VertexId; 3]) -> Option<[usize; 3]> {
        let spans = corners.map(|v| match self.span[v.index()] {
            0 => self.find(v),
            span => span,
        });
        if spans.contains(&UNFIT) {
            return None;
        }
        Some(spans.map(|s| self.data[s as usize] as usize))
    }

    fn find(&mut self, v: VertexId) -> u32 {
        let start = self.data.len();
        self.data.push(0);
        for w in self.topology.neighbours(v) {
            self.data.push(w.0);
        }
        let valence = self.data.len() - start - 1;
        self.data[start] = valence as u32;
        self.data[start + 1..].reverse();
        let span = if !(3..=EXACT_VALENCE).contains(&valence) || self.topology.is_boundary_vertex(v)
        {
            UNFIT
        } else {
            start as u32
        };
        self.span[v.index()] = span;
        span
    }

    /// Writes the control vertices of a face, whose corners have been visited, in standard order.
    /// Returns whether they are distinct.
    fn write_stencil(
        &mut self,
        corners: [VertexId; 3],
        valences: [usize; 3],
        stencil: &mut [u32],
    ) -> bool {
        self.stencils += 1;
        let mark = self.stencils;
        let mut distinct = true;
        let mut length = 0;
        let last_stencil = &mut self.last_stencil;
        let mut write = |v: u32| {
            distinct &= std::mem::replace(&mut last_stencil[v as usize], mark) != mark;
            stencil[length] = v;
            length += 1;
        };
        for v in corners {
            write(v.0);
        }
        for c in [1, 2, 0] {
            // counter-clockwise after the preceding corner, up to but not with the first vertex of
            // the next corner's part
            let preceding = corners[(c + 2) % 3].0;
            let start = self.span[corners[c].index()] as usize + 1;
            let ring = &self.data[start..start + valences[c]];
            let mut at = ring.iter().position(|&v| v == preceding).unwrap_or(0);
            // the tetrahedron has one vertex for all three parts
            let count = if valences == [3, 3, 3] && c == 1 {
                1
            } else {
                valences[c] - 3
            };
            for _ in 0..count {
                at = if at + 1 == ring.len() { 0 } else { at + 1 };
                write(ring[at]);
            }
        }
        distinct
    }
}

/// Valences below this, nearly all of them, are looked up directly.
const DIRECT: usize = 16;

/// Valence triples in the order in which they were first seen, each with its number.
struct Classes {
    found: Vec<([usize; 3], usize)>,
    direct: Vec<u32>,
    others: BTreeMap<[usize; 3], u32>,
}

impl Classes {
    fn new() -> Self {
        Self {
            found: Vec::new(),
            direct: vec![u32::MAX; DIRECT.pow(3)],
            others: BTreeMap::new(),
        }
    }

    /// Counts a triple and returns its index.
    fn count(&mut self, valences: [usize; 3]) -> u32 {
        let next = self.found.len() as u32;
        let class = if let [a @ ..DIRECT, b @ ..DIRECT, c @ ..DIRECT] = valences {
            &mut self.direct[(a * DIRECT + b) * DIRECT + c]
        } else {
            self.others.entry(valences).or_insert(u32::MAX)
        };
        if *class == u32::MAX {
            *class = next;
            self.found.push((valences, 0));
        }
        self.found[*class as usize].1 += 1;
        *class
    }
}
