//! Sample points of the surface, and the triangles between them.

use std::ops::Range;
use std::sync::Arc;

use super::SurfaceOptions;
use super::cut::Cut;
use crate::mesh::{FaceId, HalfedgeId, Topology, VertexId};
use crate::render::textures::FaceTexture;
use crate::render::{Image, Vertex};
use crate::subdivision::{Elements, Rule};

/// Mark of a sample without a number.
const NONE: u32 = u32::MAX;

/// The points of the basis table of a face: a lattice with `pieces` per side and without corners,
/// then the quadrature points of the curvatures.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    pub(super) pieces: u32,
    pub(super) points: Vec<[f64; 2]>,
    /// Number of lattice points in `points`.
    pub(super) inner: usize,
    /// Triangles between lattice points `(i, j)`, at `v = i / pieces`, `w = j / pieces`.
    triangles: Vec<[[u32; 2]; 3]>,
}

impl Lattice {
    pub(super) fn new(pieces: u32) -> Self {
        let side = f64::from(pieces);
        let mut points: Vec<[f64; 2]> = places(pieces)
            .filter(|&at| corner(pieces, at).is_none())
            .map(|[i, j]| [f64::from(i) / side, f64::from(j) / side])
            .collect();
        let inner = points.len();
        points.extend(Rule::Three.points());
        Self {
            pieces,
            points,
            inner,
            triangles: triangles(pieces),
        }
    }
}

/// The triangles between the lattice points of a face.
fn triangles(pieces: u32) -> Vec<[[u32; 2]; 3]> {
    let mut all = Vec::new();
    for i in 0..pieces {
        for j in 0..pieces - i {
            all.push([[i, j], [i + 1, j], [i, j + 1]]);
            if i + j + 1 < pieces {
                all.push([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
            }
        }
    }
    all
}

/// Lattice points `(i, j)`, at `v = i / pieces`, `w = j / pieces`.
fn places(pieces: u32) -> impl Iterator<Item = [u32; 2]> {
    (0..=pieces).flat_map(move |i| (0..=pieces - i).map(move |j| [i, j]))
}

/// The corner at a lattice point, if there is one.
fn corner(pieces: u32, [i, j]: [u32; 2]) -> Option<usize> {
    match (i, j) {
        (0, 0) => Some(0),
        (i, 0) if i == pieces => Some(1),
        (0, j) if j == pieces => Some(2),
        _ => None,
    }
}

/// A sample that is not at a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inner {
    pub(super) element: u32,
    /// Index of the point in the table of the element.
    pub(super) point: u32,
    /// Whether it lies on the straight line between the ends of its edge. The faces beyond such an
    /// edge may be drawn with one piece per edge, or are the other side of a crease, and there must
    /// be no gap.
    pub(super) straight: bool,
}

/// Samples of the faces, shared between neighbours, and the triangles between them.
///
/// Samples at corners come first. A sample has several vertices if faces with different flags meet
/// there, because the flags of a triangle are those of its vertices.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    /// The corner samples: vertices of the cut mesh.
    pub(super) corners: Vec<u32>,
    /// The other samples.
    pub(super) inner: Vec<Inner>,
    /// Triangles between samples, those of a face together.
    sample_triangles: Vec<[u32; 3]>,
    /// Segments of the wireframe, between samples.
    sample_edges: Vec<[u32; 2]>,
    /// Segments of the seams of patches, between samples.
    sample_seam: Vec<[u32; 2]>,
    triangles_per_face: usize,
    /// The sample of each vertex.
    pub(super) sample_of: Vec<u32>,
    /// The flags of each vertex.
    pub(super) flags_of: Vec<u32>,
    /// The place of each vertex in the texture image.
    pub(super) places: Vec<[f32; 2]>,
    /// The colour of the faces at each vertex; opacity 0 if it is unknown.
    pub(super) colors_of: Vec<[u8; 4]>,
    /// Runs of triangles with one texture image.
    pub(super) textures: Vec<(Range<u32>, Arc<Image>)>,
    /// Triangles, wireframe and seams between vertices.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) edges: Vec<[u32; 2]>,
    pub(super) seam: Vec<[u32; 2]>,
}

impl Samples {
    pub(super) fn new(
        cut: &Cut,
        elements: &Elements,
        lattice: &Lattice,
        options: &SurfaceOptions,
        textures: &[Option<&FaceTexture>],
        colors: &[[u8; 4]],
    ) -> Self {
        let mut numbering = Numbering::new(cut, elements, lattice, options.is_cut);
        for &f in &cut.faces {
            numbering.add_corners(f);
        }
        let mut sample_triangles = Vec::new();
        for &f in &cut.faces {
            numbering.add_face(f);
            sample_triangles.extend_from_slice(&numbering.triangles);
        }
        let mut samples = Self {
            triangles_per_face: (lattice.pieces * lattice.pieces) as usize,
            sample_edges: numbering.wireframe(&cut.faces),
            sample_seam: numbering.seam(&cut.faces, &options.flags),
            corners: numbering.corners,
            inner: numbering.inner,
            sample_triangles,
            sample_of: Vec::new(),
            flags_of: Vec::new(),
            places: Vec::new(),
            colors_of: Vec::new(),
            textures: Vec::new(),
            triangles: Vec::new(),
            edges: Vec::new(),
            seam: Vec::new(),
        };
        samples.make_vertices(&options.flags, textures, colors, lattice);
        samples
    }

    pub(super) fn len(&self) -> usize {
        self.corners.len() + self.inner.len()
    }

    /// Creates a vertex for each sample and each value of the flags, place in the texture image and colour of
    /// its faces. `colors` are those of the faces; empty for none.
    fn make_vertices(
        &mut self,
        flags: &[u32],
        textures: &[Option<&FaceTexture>],
        colors: &[[u8; 4]],
        lattice: &Lattice,
    ) {
        let faces = self.sample_triangles.len() / self.triangles_per_face;
        assert!(
            flags.is_empty() || flags.len() == faces,
            "{} flags for {faces} faces",
            flags.len()
        );
        let mut first = vec![NONE; self.len()];
        // the next vertex of the same sample
        let mut next: Vec<u32> = Vec::new();
        let (sample_of, flags_of) = (&mut self.sample_of, &mut self.flags_of);
        let (places, colors_of) = (&mut self.places, &mut self.colors_of);
        let mut vertex = |sample: u32, flags: u32, place: [f32; 2], color: [u8; 4]| {
            let mut at = first[sample as usize];
            let wanted = (flags, place, color);
            while at != NONE {
                let k = at as usize;
                if (flags_of[k], places[k], colors_of[k]) == wanted {
                    break;
                }
                at = next[k];
            }
            if at == NONE {
                at = next.len() as u32;
                next.push(std::mem::replace(&mut first[sample as usize], at));
                sample_of.push(sample);
                flags_of.push(flags);
                places.push(place);
                colors_of.push(color);
            }
            at
        };
        self.triangles = self
            .sample_triangles
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let (face, triangle) = (i / self.triangles_per_face, i % self.triangles_per_face);
                let flags = flags.get(face).copied().unwrap_or(0);
                let Some((_, corners)) = textures[face] else {
                    let color = colors.get(face).copied().unwrap_or_default();
                    return t.map(|s| vertex(s, flags, [0.0; 2], color));
                };
                let at = lattice.triangles[triangle];
                [0, 1, 2].map(|k| {
                    let [v, w] = at[k].map(|i| i as f32 / lattice.pieces as f32);
                    let place = [0, 1].map(|axis| {
                        let [a, b, c] = corners.map(|corner| corner[axis]);
                        a + v * (b - a) + w * (c - a)
                    });
                    vertex(t[k], flags | Vertex::TEXTURED, place, [0; 4])
                })
            })
            .collect();
        for (face, texture) in textures.iter().enumerate() {
            let Some((image, _)) = texture else { continue };
            let each = self.triangles_per_face as u32;
            let run = each * face as u32..each * (face as u32 + 1);
            match self.textures.last_mut() {
                Some((last, same)) if last.end == run.start && same == image => last.end = run.end,
                _ => self.textures.push((run, Arc::clone(image))),
            }
        }
        let any = |s: u32| first[s as usize];
        self.edges = self.sample_edges.iter().map(|e| e.map(any)).collect();
        self.seam = self.sample_seam.iter().map(|e| e.map(any)).collect();
    }
}

/// Numbers samples as faces are added.
struct Numbering<'a> {
    topology: &'a Topology,
    lattice: &'a Lattice,
    /// Whether boundary edges are drawn straight.
    is_cut: bool,
    element_of: Vec<u32>,
    corners: Vec<u32>,
    inner: Vec<Inner>,
    listed: Vec<bool>,
    corner_sample: Vec<u32>,
    /// The first sample of each edge. The others follow in order from the origin of the even
    /// half-edge.
    edge_sample: Vec<u32>,
    /// Samples of the last face, by rows of the lattice.
    face: Vec<u32>,
    /// Triangles of the last face.
    triangles: Vec<[u32; 3]>,
}

impl<'a> Numbering<'a> {
    fn new(cut: &'a Cut, elements: &Elements, lattice: &'a Lattice, is_cut: bool) -> Self {
        let topology = &cut.topology;
        let mut listed = vec![false; topology.face_count()];
        for f in &cut.faces {
            listed[f.index()] = true;
        }
        let mut element_of = vec![NONE; topology.face_count()];
        for (e, &f) in elements.faces().iter().enumerate() {
            element_of[f as usize] = e as u32;
        }
        Self {
            topology,
            lattice,
            is_cut,
            element_of,
            corners: Vec::new(),
            inner: Vec::new(),
            listed,
            corner_sample: vec![NONE; topology.vertex_count()],
            edge_sample: vec![NONE; topology.halfedge_count() / 2],
            face: Vec::new(),
            triangles: Vec::new(),
        }
    }

    fn add_corners(&mut self, f: FaceId) {
        for VertexId(v) in self.topology.face_vertices(f) {
            let sample = &mut self.corner_sample[v as usize];
            if *sample == NONE {
                *sample = self.corners.len() as u32;
                self.corners.push(v);
            }
        }
    }

    /// Numbers the samples of a face, after the corners of all faces, and triangulates it.
    fn add_face(&mut self, f: FaceId) {
        let n = self.lattice.pieces;
        let around = self.topology.face_halfedges(f);
        let corners = self.topology.face_vertices(f);
        let element = self.element_of[f.index()];
        let first = (self.corners.len() + self.inner.len()) as u32;
        let mut point = 0;
        // new samples of an edge are numbered from the origin of its even half-edge
        for h in around {
            let edge = &mut self.edge_sample[h.edge()];
            if *edge == NONE && n > 1 {
                *edge = (self.corners.len() + self.inner.len()) as u32;
                let beyond = self.topology.face(h.twin());
                let new = Inner {
                    element,
                    point: NONE,
                    straight: if beyond.is_some() {
                        !self.listed[beyond.index()]
                    } else {
                        self.is_cut
                    },
                };
                self.inner.extend((1..n).map(|_| new));
            }
        }
        self.face.clear();
        for [i, j] in places(n) {
            if let Some(c) = corner(n, [i, j]) {
                self.face.push(self.corner_sample[corners[c].index()]);
                continue;
            }
            let along = match (i, j) {
                (i, 0) => Some((around[0], i)),
                (0, j) => Some((around[2], n - j)),
                (i, j) if i + j == n => Some((around[1], j)),
                _ => None,
            };
            let sample = if let Some((h, t)) = along {
                let t = if h.0 % 2 == 0 { t } else { n - t };
                self.edge_sample[h.edge()] + t - 1
            } else {
                self.inner.push(Inner {
                    element,
                    point,
                    straight: false,
                });
                (self.corners.len() + self.inner.len()) as u32 - 1
            };
            if sample >= first {
                self.inner[sample as usize - self.corners.len()].point = point;
            }
            point += 1;
            self.face.push(sample);
        }
        self.triangulate();
    }

    fn triangulate(&mut self) {
        let n = self.lattice.pieces as usize;
        // row i of the lattice starts after the longer rows before it
        let start = |i: usize| i * (n + 1) - i * i.saturating_sub(1) / 2;
        let at = |[i, j]: [u32; 2]| self.face[start(i as usize) + j as usize];
        self.triangles.clear();
        let triangles = self.lattice.triangles.iter();
        self.triangles.extend(triangles.map(|t| t.map(at)));
    }

    /// The edges of the faces, each once, as chains of samples.
    fn wireframe(&self, faces: &[FaceId]) -> Vec<[u32; 2]> {
        let mut done = vec![false; self.edge_sample.len()];
        let mut segments = Vec::new();
        for &f in faces {
            for h in self.topology.face_halfedges(f) {
                if !std::mem::replace(&mut done[h.edge()], true) {
                    self.add_edge(h, &mut segments);
                }
            }
        }
        segments
    }

    /// The edges of patches whose other side is not drawn or belongs to no patch, and the edges between the newest
    /// patch and other patches.
    fn seam(&self, faces: &[FaceId], flags: &[u32]) -> Vec<[u32; 2]> {
        // largest in the newest patch, 0 outside patches
        let mut patch = vec![0; self.listed.len()];
        for (f, flags) in faces.iter().zip(flags) {
            patch[f.index()] = flags & (Vertex::PATCH | Vertex::NEWEST);
        }
        let mut segments = Vec::new();
        for &f in faces.iter().filter(|f| patch[f.index()] != 0) {
            for h in self.topology.face_halfedges(f) {
                let beyond = self.topology.face(h.twin());
                if !beyond.is_some() || patch[beyond.index()] < patch[f.index()] {
                    self.add_edge(h, &mut segments);
                }
            }
        }
        segments
    }

    /// Adds the chain of samples of an edge.
    fn add_edge(&self, h: HalfedgeId, segments: &mut Vec<[u32; 2]>) {
        let even = if h.0.is_multiple_of(2) { h } else { h.twin() };
        let end = |v: VertexId| self.corner_sample[v.index()];
        let mut last = end(self.topology.origin(even));
        for t in 1..self.lattice.pieces {
            let here = self.edge_sample[h.edge()] + t - 1;
            segments.push([last, here]);
            last = here;
        }
        segments.push([last, end(self.topology.target(even))]);
    }
}
