//! Half-edge connectivity of an oriented manifold triangle mesh, possibly with boundary.

use super::{FaceId, HalfedgeId, VertexId};

/// Connectivity in half-edge arrays; no coordinates.
///
/// Twins are paired by the lowest bit. A boundary half-edge has no face; its `next` runs along the
/// boundary loop, so that the loop's direction is the one in which a patch filling the hole runs
/// through the rim. An isolated vertex has no half-edge. The outgoing half-edge stored for a
/// boundary vertex is its boundary half-edge.
///
/// Boundary loops are simple. Where a hole touches itself (a figure of eight), the vertex is
/// *pinched*: it keeps several fans of faces, each followed by the gap of one loop, and has a
/// boundary half-edge for each gap. Filling the loops makes it an ordinary vertex.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    next: Vec<HalfedgeId>,
    origin: Vec<VertexId>,
    face: Vec<FaceId>,
    vertex_halfedge: Vec<HalfedgeId>,
    face_halfedge: Vec<HalfedgeId>,
}

/// Why a list of triangles is not an oriented manifold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TopologyError {
    /// A triangle names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are only {vertices} vertices")]
    IndexOutOfRange {
        /// The triangle (0-based).
        face: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A triangle names a vertex twice.
    #[error("face {face} names a vertex twice")]
    DegenerateFace {
        /// The triangle (0-based).
        face: usize,
    },
    /// Two triangles run through the same edge in the same direction: a non-manifold edge, or
    /// neighbours of opposite orientation.
    #[error(
        "the edge from vertex {from} to vertex {to} is used twice in the same direction \
         (non-manifold edge or inconsistent orientation)"
    )]
    EdgeUsedTwice {
        /// Start of the directed edge.
        from: u32,
        /// End of the directed edge.
        to: u32,
    },
    /// The faces around a vertex form more than one fan.
    #[error("vertex {vertex} joins several sheets of the surface at a single point")]
    NonManifoldVertex {
        /// The vertex.
        vertex: u32,
    },
}

impl Topology {
    /// Builds the connectivity of `triangles` over `vertex_count` vertices, in linear time but for
    /// the sorting of edges at each vertex.
    ///
    /// # Errors
    /// The first defect found that keeps the triangles from being an oriented manifold.
    pub fn from_triangles(
        vertex_count: usize,
        triangles: &[[u32; 3]],
    ) -> Result<Self, TopologyError> {
        for (face, t) in triangles.iter().enumerate() {
            for &vertex in t {
                if vertex as usize >= vertex_count {
                    return Err(TopologyError::IndexOutOfRange {
                        face,
                        vertex,
                        vertices: vertex_count,
                    });
                }
            }
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                return Err(TopologyError::DegenerateFace { face });
            }
        }

        // Bucket the directed corner edges (face, corner) by their smaller vertex (counting sort),
        // then match the two directions within each bucket by their greater one.
        let corners = 3 * triangles.len();
        let ends = |corner: usize| -> (u32, u32) {
            let t = &triangles[corner / 3];
            let k = corner % 3;
            (t[k], t[(k + 1) % 3])
        };
        let mut start = vec![0u32; vertex_count + 1];
        for c in 0..corners {
            let (a, b) = ends(c);
            start[a.min(b) as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            start[v + 1] += start[v];
        }
        let mut bucket = vec![0u32; corners];
        let mut fill = start.clone();
        for c in 0..corners {
            let (a, b) = ends(c);
            let slot = &mut fill[a.min(b) as usize];
            bucket[*slot as usize] = c as u32;
            *slot += 1;
        }

        let mut corner_halfedge = vec![HalfedgeId::NONE; corners];
        let mut origin = Vec::with_capacity(corners + corners / 8);
        let mut face = Vec::with_capacity(corners + corners / 8);
        let mut by_end = Vec::new();
        for v in 0..vertex_count {
            let group = &bucket[start[v] as usize..start[v + 1] as usize];
            let far = |c: u32| {
                let (a, b) = ends(c as usize);
                a.max(b)
            };
            // corner edges between the same two vertices follow each other in their order
            by_end.clear();
            by_end.extend_from_slice(group);
            by_end.sort_by_key(|&c| far(c));
            for same in by_end.chunk_by(|&c, &d| far(c) == far(d)) {
                let (a, b) = ends(same[0] as usize);
                let (from, to) = match same[1..] {
                    [] => continue,
                    [d] if ends(d as usize) == (b, a) => continue,
                    [d] | [_, d, ..] => ends(d as usize),
                };
                return Err(TopologyError::EdgeUsedTwice { from, to });
            }
            for &c in group {
                if corner_halfedge[c as usize].is_some() {
                    continue;
                }
                let (a, b) = ends(c as usize);
                let end = far(c);
                let at = by_end.partition_point(|&d| far(d) < end);
                let h = HalfedgeId::from(origin.len());
                origin.push(VertexId(a));
                origin.push(VertexId(b));
                corner_halfedge[c as usize] = h;
                face.push(FaceId(c / 3));
                match by_end.get(at + 1) {
                    Some(&d) if far(d) == end => {
                        corner_halfedge[d as usize] = h.twin();
                        face.push(FaceId(d / 3));
                    }
                    _ => face.push(FaceId::NONE),
                }
            }
        }

        let mut next = vec![HalfedgeId::NONE; origin.len()];
        let mut face_halfedge = vec![HalfedgeId::NONE; triangles.len()];
        for f in 0..triangles.len() {
            for k in 0..3 {
                next[corner_halfedge[3 * f + k].index()] = corner_halfedge[3 * f + (k + 1) % 3];
            }
            face_halfedge[f] = corner_halfedge[3 * f];
        }

        // Boundary half-edges follow each other; a vertex may have two only where a loop would
        // otherwise touch itself.
        let mut pinched = false;
        let mut vertex_halfedge = vec![HalfedgeId::NONE; vertex_count];
        for (h, &v) in origin.iter().enumerate() {
            let slot = &mut vertex_halfedge[v.index()];
            if face[h].is_some() {
                if !slot.is_some() {
                    *slot = HalfedgeId::from(h);
                }
            } else if slot.is_some() && !face[slot.index()].is_some() {
                pinched = true;
            } else {
                *slot = HalfedgeId::from(h);
            }
        }
        for h in 0..origin.len() {
            if !face[h].is_some() {
                let end = origin[h ^ 1];
                next[h] = vertex_halfedge[end.index()];
            }
        }
        if pinched {
            link_fans(&mut next, &face);
            make_loops_simple(&mut next, &origin, &face, vertex_count);
        }
        let topology = Self {
            next,
            origin,
            face,
            vertex_halfedge,
            face_halfedge,
        };
        topology.check_fans()?;
        Ok(topology)
    }

    /// Every half-edge must be reached by circulating around its origin.
    fn check_fans(&self) -> Result<(), TopologyError> {
        let mut degree = vec![0u32; self.vertex_count()];
        for v in &self.origin {
            degree[v.index()] += 1;
        }
        for v in self.vertices() {
            let reached = self.outgoing(v).count();
            if reached != degree[v.index()] as usize {
                return Err(TopologyError::NonManifoldVertex { vertex: v.0 });
            }
        }
        Ok(())
    }

    /// Number of vertices, isolated ones included.
    pub fn vertex_count(&self) -> usize {
        self.vertex_halfedge.len()
    }

    /// Number of triangles.
    pub fn face_count(&self) -> usize {
        self.face_halfedge.len()
    }

    /// Memory used by the arrays, in bytes.
    pub fn bytes(&self) -> usize {
        // half-edges hold next, origin and face; vertices and faces one half-edge each
        self.halfedge_count() * 12 + (self.vertex_count() + self.face_count()) * 4
    }

    /// Number of half-edges, boundary ones included; twice the number of edges.
    pub fn halfedge_count(&self) -> usize {
        self.next.len()
    }

    /// All vertices in ascending order, isolated ones included.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + Clone + use<> {
        (0..self.vertex_count()).map(VertexId::from)
    }

    /// All faces in ascending order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + Clone + use<> {
        (0..self.face_count()).map(FaceId::from)
    }

    /// All half-edges in ascending order.
    pub fn halfedges(&self) -> impl ExactSizeIterator<Item = HalfedgeId> + Clone + use<> {
        (0..self.halfedge_count()).map(HalfedgeId::from)
    }

    /// Of each edge the half-edge of lowest bit 0, in ascending order.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = HalfedgeId> + Clone + use<> {
        (0..self.halfedge_count() / 2).map(|e| HalfedgeId::from(2 * e))
    }

    /// The following half-edge of the same face or boundary loop.
    #[inline]
    pub fn next(&self, h: HalfedgeId) -> HalfedgeId {
        self.next[h.index()]
    }

    /// Where the half-edge starts.
    #[inline]
    pub fn origin(&self, h: HalfedgeId) -> VertexId {
        self.origin[h.index()]
    }

    /// Where the half-edge ends.
    #[inline]
    pub fn target(&self, h: HalfedgeId) -> VertexId {
        self.origin[h.twin().index()]
    }

    /// The face to the left, or [`FaceId::NONE`] on a boundary.
    #[inline]
    pub fn face(&self, h: HalfedgeId) -> FaceId {
        self.face[h.index()]
    }

    /// Whether the half-edge runs along a hole.
    #[inline]
    pub fn is_boundary(&self, h: HalfedgeId) -> bool {
        !self.face[h.index()].is_some()
    }

    /// An outgoing half-edge, the boundary one if there is one; `NONE` for an isolated vertex.
    #[inline]
    pub fn halfedge_of_vertex(&self, v: VertexId) -> HalfedgeId {
        self.vertex_halfedge[v.index()]
    }

    /// The half-edge from the first to the second corner of the face.
    #[inline]
    pub fn halfedge_of_face(&self, f: FaceId) -> HalfedgeId {
        self.face_halfedge[f.index()]
    }

    /// The half-edges of a face, from its first, second and third corner.
    #[inline]
    pub fn face_halfedges(&self, f: FaceId) -> [HalfedgeId; 3] {
        let h = self.halfedge_of_face(f);
        let n = self.next(h);
        [h, n, self.next(n)]
    }

    /// Whether the edge has a face on one side only.
    #[inline]
    pub fn is_boundary_edge(&self, h: HalfedgeId) -> bool {
        self.is_boundary(h) || self.is_boundary(h.twin())
    }

    /// Number of edges with a face on one side only.
    pub fn boundary_edge_count(&self) -> usize {
        self.edges().filter(|&h| self.is_boundary_edge(h)).count()
    }

    /// Whether the vertex has a face; isolated vertices have none.
    #[inline]
    pub fn has_faces(&self, v: VertexId) -> bool {
        self.halfedge_of_vertex(v).is_some()
    }

    /// Whether the vertex lies on a boundary (isolated vertices do not).
    #[inline]
    pub fn is_boundary_vertex(&self, v: VertexId) -> bool {
        let h = self.halfedge_of_vertex(v);
        h.is_some() && self.is_boundary(h)
    }

    /// The corners of a face, in the order in which it was given.
    #[inline]
    pub fn face_vertices(&self, f: FaceId) -> [VertexId; 3] {
        let h = self.halfedge_of_face(f);
        let n = self.next(h);
        [self.origin(h), self.origin(n), self.target(n)]
    }

    /// All triangles, in order.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.faces().map(|f| {
            let [a, b, c] = self.face_vertices(f);
            [a.0, b.0, c.0]
        })
    }

    /// Outgoing half-edges, turning clockwise from [`Self::halfedge_of_vertex`] (so that at a
    /// boundary vertex the walk starts with the boundary half-edge and covers the whole fan).
    pub fn outgoing(&self, v: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        let first = self.halfedge_of_vertex(v);
        let mut h = first;
        let mut left = self.next.len();
        std::iter::from_fn(move || {
            if !h.is_some() || left == 0 {
                return None;
            }
            left -= 1;
            let out = h;
            // clockwise: the half-edge after the twin
            h = self.next(h.twin());
            if h == first {
                h = HalfedgeId::NONE;
            }
            Some(out)
        })
    }

    /// Vertices joined to `v` by an edge.
    pub fn neighbours(&self, v: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        self.outgoing(v).map(|h| self.target(h))
    }

    /// Number of edges at the vertex.
    pub fn valence(&self, v: VertexId) -> usize {
        self.outgoing(v).count()
    }

    /// The boundary loops as half-edge sequences, each starting at its lowest vertex index, loops
    /// ordered by that vertex.
    pub fn boundary_loops(&self) -> Vec<Vec<HalfedgeId>> {
        let mut seen = vec![false; self.halfedge_count()];
        let mut loops = Vec::new();
        for v in self.vertices().filter(|&v| self.is_boundary_vertex(v)) {
            for first in self.outgoing(v).filter(|&h| self.is_boundary(h)) {
                if seen[first.index()] {
                    continue;
                }
                let mut one = Vec::new();
                let mut h = first;
                loop {
                    seen[h.index()] = true;
                    one.push(h);
                    h = self.next(h);
                    if h == first {
                        break;
                    }
                }
                loops.push(one);
            }
        }
        loops
    }
}

/// Makes each boundary half-edge be followed by the one at the other end of the fan of faces it
/// arrives at.
fn link_fans(next: &mut [HalfedgeId], face: &[FaceId]) {
    for h in 0..next.len() {
        if face[h].is_some() {
            continue;
        }
        let mut inner = h ^ 1;
        next[h] = loop {
            let prev = next[next[inner].index()];
            let turned = prev.twin();
            if !face[turned.index()].is_some() {
                break turned;
            }
            inner = turned.index();
        };
    }
}

/// Cuts boundary loops that visit a vertex more than once into loops that do not.
fn make_loops_simple(
    next: &mut [HalfedgeId],
    origin: &[VertexId],
    face: &[FaceId],
    vertex_count: usize,
) {
    const NONE: u32 = u32::MAX;
    let mut done = vec![false; next.len()];
    let mut place = vec![NONE; vertex_count];
    let mut walk: Vec<HalfedgeId> = Vec::new();
    for start in 0..next.len() {
        if face[start].is_some() || done[start] {
            continue;
        }
        let mut h = HalfedgeId::from(start);
        while !done[h.index()] {
            done[h.index()] = true;
            let following = next[h.index()];
            let v = origin[h.index()].index();
            let before = place[v];
            if before != NONE {
                close_lobe(next, origin, &mut place, &mut walk, before as usize);
                if let Some(last) = walk.last() {
                    next[last.index()] = h;
                }
            }
            place[v] = walk.len() as u32;
            walk.push(h);
            h = following;
        }
        close_lobe(next, origin, &mut place, &mut walk, 0);
    }
}

/// Links the walk from `from` on into a loop and takes it off the walk.
fn close_lobe(
    next: &mut [HalfedgeId],
    origin: &[VertexId],
    place: &mut [u32],
    walk: &mut Vec<HalfedgeId>,
    from: usize,
) {
    if let Some(last) = walk.last() {
        next[last.index()] = walk[from];
    }
    for h in walk.drain(from..) {
        place[origin[h.index()].index()] = u32::MAX;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRA: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]];

    #[test]
    fn closed_and_open_tetrahedron() {
        let t = Topology::from_triangles(5, &TETRA).expect("closed");
        assert_eq!(t.halfedge_count(), 12);
        assert!(t.boundary_loops().is_empty());
        assert_eq!(t.triangles().collect::<Vec<_>>(), TETRA);
        assert!(!t.halfedge_of_vertex(VertexId(4)).is_some());
        for v in 0..4 {
            assert_eq!(t.valence(VertexId(v)), 3);
        }
        let open = Topology::from_triangles(4, &TETRA[1..]).expect("open");
        let loops = open.boundary_loops();
        assert_eq!(loops.len(), 1);
        let ring: Vec<_> = loops[0].iter().map(|&h| open.origin(h).0).collect();
        // the loop runs as the missing face (0, 1, 2) would
        assert_eq!(ring, [0, 1, 2]);
    }

    /// Two quads that touch at vertex 0 from both sides of the gap between them, closed on the
    /// outside to an annulus: its hole touches itself at vertex 0.
    #[test]
    fn a_hole_touching_itself_has_two_lobes() {
        // a ring of eight sectors around a figure of eight: lobe (0, 1, 2), lobe (0, 3, 4)
        let triangles = [
            [0, 2, 5],
            [2, 6, 5],
            [2, 1, 6],
            [1, 7, 6],
            [1, 0, 7],
            [0, 8, 7],
            [0, 4, 8],
            [4, 9, 8],
            [4, 3, 9],
            [3, 10, 9],
            [3, 0, 10],
            [0, 5, 10],
        ];
        let t = Topology::from_triangles(11, &triangles).expect("pinched");
        let mut loops: Vec<Vec<u32>> = t
            .boundary_loops()
            .iter()
            .map(|l| l.iter().map(|&h| t.origin(h).0).collect())
            .collect();
        assert_eq!(loops.remove(0), [0, 1, 2]);
        assert_eq!(loops.remove(0), [0, 3, 4]);
        assert_eq!(loops.len(), 1);
        assert_eq!(t.valence(VertexId(0)), 8);
        let mut filled = triangles.to_vec();
        filled.push([0, 1, 2]);
        let one = Topology::from_triangles(11, &filled).expect("one lobe filled");
        assert_eq!(one.boundary_loops().len(), 2);
        filled.push([0, 3, 4]);
        let both = Topology::from_triangles(11, &filled).expect("both filled");
        assert_eq!(both.boundary_loops().len(), 1);
        assert!(!both.is_boundary_vertex(VertexId(0)));
    }

    #[test]
    fn defects_are_named() {
        assert_eq!(
            Topology::from_triangles(3, &[[0, 1, 3]]),
            Err(TopologyError::IndexOutOfRange {
                face: 0,
                vertex: 3,
                vertices: 3
            })
        );
        assert_eq!(
            Topology::from_triangles(3, &[[0, 1, 1]]),
            Err(TopologyError::DegenerateFace { face: 0 })
        );
        assert!(matches!(
            Topology::from_triangles(5, &[[0, 1, 2], [1, 0, 3], [1, 0, 4]]),
            Err(TopologyError::EdgeUsedTwice { .. })
        ));
        assert!(matches!(
            Topology::from_triangles(4, &[[0, 1, 2], [0, 1, 3]]),
            Err(TopologyError::EdgeUsedTwice { .. })
        ));
        assert_eq!(
            Topology::from_triangles(5, &[[0, 1, 2], [0, 3, 4]]),
            Err(TopologyError::NonManifoldVertex { vertex: 0 })
        );
    }
}
