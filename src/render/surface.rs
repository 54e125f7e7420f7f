//! Geometry to draw, made of meshes: the Loop limit surface and its curvatures.

use crate::mesh::{DVec3, FaceId, Topology, VertexId};

use super::Geometry;

/// How a [`DynamicSurface`] is made.
#[derive(Clone, Debug, Default)]
pub struct SurfaceOptions {
    /// Pieces each edge is drawn with, 1 to 8; `None` chooses by the number of faces.
    pub samples_per_edge: Option<u32>,
    /// Edges along which the surface has a crease (rims joined G0): either side is drawn as if the
    /// other were not there.
    pub creases: Vec<[VertexId; 2]>,
    /// Flags of the faces ([`super::Vertex`]), one for each; empty for none.
    pub flags: Vec<u32>,
}

/// The part of a surface that moves: what depends on the topology is computed once.
#[derive(Clone, Debug)]
pub struct DynamicSurface {
    faces: Vec<FaceId>,
}

/// What an evaluation shows.
#[derive(Clone, Copy, Default)]
pub struct Evaluation<'a> {
    /// What the result's positions are relative to.
    pub centre: DVec3,
    /// The limit surface; otherwise flat triangles of the control mesh. Normals and curvatures are
    /// those of the limit surface in both.
    pub limit: bool,
    /// Positions the deviation is measured from, one per vertex of the mesh.
    pub start: Option<&'a [DVec3]>,
    /// Whether the flow is ill-posed at mean curvature `H` and Gaussian curvature `K`.
    pub ill_posed: Option<&'a (dyn Fn(f64, f64) -> bool + Sync)>,
}

impl DynamicSurface {
    /// Prepares `faces` (the patch and its collar) of a mesh.
    pub fn new(topology: &Topology, faces: &[FaceId], options: &SurfaceOptions) -> Self {
        let _ = (topology, options);
        Self {
            faces: faces.to_vec(),
        }
    }

    /// Replaces the flags of the faces, in the order in which they were given.
    pub fn set_flags(&mut self, flags: &[u32]) {
        let _ = flags;
    }

    /// The surface at `positions` (one per vertex of the mesh); see [`Evaluation`].
    pub fn evaluate(
        &self,
        positions: &[DVec3],
        centre: DVec3,
        limit: bool,
        start: Option<&[DVec3]>,
    ) -> Geometry {
        self.evaluate_with(
            positions,
            &Evaluation {
                centre,
                limit,
                start,
                ill_posed: None,
            },
        )
    }

    /// The surface at `positions`, with all that an evaluation can show.
    pub fn evaluate_with(&self, positions: &[DVec3], what: &Evaluation<'_>) -> Geometry {
        let _ = (positions, what, &self.faces);
        Geometry::new(Vec::new(), Vec::new(), Vec::new())
    }
}

/// The part of a surface that does not move, one vertex per mesh vertex. `flags` are those of all
/// its faces.
pub fn static_surface(
    topology: &Topology,
    positions: &[DVec3],
    faces: &[FaceId],
    centre: DVec3,
    limit: bool,
    flags: u32,
) -> Geometry {
    let options = SurfaceOptions {
        samples_per_edge: Some(1),
        creases: Vec::new(),
        flags: vec![flags; faces.len()],
    };
    DynamicSurface::new(topology, faces, &options).evaluate(positions, centre, limit, None)
}
