//! Refinement of a part of a mesh.

use std::ops::Range;

use crate::mesh::{DVec3, FaceId, Neighbourhood, Split, Topology, VertexId};
use crate::refine::schemes::loop_step;

/// The faces to be refined at a level.
#[derive(Clone, Debug)]
pub struct Region {
    faces: Vec<bool>,
}

/// Number of rings around new vertices whose control points may change with them. Their limit
/// positions involve a new vertex's ring.
const NEAR: usize = 2;

impl Region {
    /// One flag per face.
    pub fn new(faces: Vec<bool>) -> Self {
        Self { faces }
    }

    /// One flag per face of the current level.
    pub fn faces(&self) -> &[bool] {
        &self.faces
    }

    /// Advances to the mesh after a split. The new region has the parts of the old region's faces,
    /// except those at its rim. Each level is thus framed by one of the previous level.
    pub fn descend(&mut self, new: &Topology, split: &Split) {
        let inside: Vec<bool> = split
            .parent
            .iter()
            .map(|&f| self.faces[f as usize])
            .collect();
        let mut at_rim = vec![false; new.vertex_count()];
        for (f, _) in inside.iter().enumerate().filter(|&(_, &is)| !is) {
            for v in new.face_vertices(FaceId::from(f)) {
                at_rim[v.index()] = true;
            }
        }
        self.faces = inside
            .iter()
            .enumerate()
            .map(|(f, &is)| {
                let corners = new.face_vertices(FaceId::from(f));
                is && !corners.iter().any(|v| at_rim[v.index()])
            })
            .collect();
    }

    /// The vertices within two rings of the given ones.
    pub fn near(topology: &Topology, vertices: Range<usize>) -> Vec<bool> {
        let mut near = vec![false; topology.vertex_count()];
        let seeds = vertices.map(VertexId::from);
        for v in Neighbourhood::new(topology, seeds, NEAR).vertices() {
            near[v.index()] = true;
        }
        near
    }
}

/// Loop's scheme (see [`loop_step`]) where the mesh is split all around. Next to the split region
/// and outside it, old vertices stay.
pub fn nested_step(
    old: &Topology,
    positions: &[DVec3],
    split: &Split,
    corners: &[bool],
    region: Option<&Region>,
) -> Vec<DVec3> {
    let mut new = loop_step(old, positions, split, corners);
    if let Some(region) = region {
        for v in 0..positions.len() {
            let inside = old
                .outgoing(VertexId::from(v))
                .map(|h| old.face(h))
                .all(|f| !f.is_some() || region.faces()[f.index()]);
            if !inside {
                new[v] = positions[v];
            }
        }
    }
    new
}
