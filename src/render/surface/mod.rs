//! Geometry to draw, made of meshes: the Loop limit surface and its curvatures.
//!
//! Positions and normals are those of the limit surface at every sample. Curvatures are the lumped
//! L2 projection to piecewise linears (formulation, section 3): those of the limit surface are not
//! bounded at irregular vertices, and shown as they are would only map the valences.

mod cut;
mod evaluate;
mod samples;
#[cfg(test)]
mod tests;

use crate::mesh::{DVec3, FaceId, Topology, VertexId};
use crate::subdivision::{Elements, elements_at};

use super::Geometry;
use cut::Cut;
use samples::{Lattice, Samples};

/// How a [`DynamicSurface`] is made.
#[derive(Clone, Debug, Default)]
pub struct SurfaceOptions {
    /// Pieces each edge is drawn with, 1 to 8; `None` chooses by the number of faces.
    pub samples_per_edge: Option<u32>,
    /// Edges along which the surface has a crease (rims joined G0): either side is drawn as if the
    /// other were not there. Pairs that are no edge are ignored.
    pub creases: Vec<[VertexId; 2]>,
    /// The mesh was cut open along creases: its boundary edges are drawn straight between the
    /// points that the sides have in common, so that no gap opens between the curves either would
    /// take.
    pub is_cut: bool,
    /// Flags of the faces ([`super::Vertex`]), one for each; empty for none.
    pub flags: Vec<u32>,
}

/// What an evaluation shows.
#[derive(Clone, Copy, Default)]
pub struct Evaluation<'a> {
    /// What the result's positions are relative to.
    pub centre: DVec3,
    /// The limit surface; otherwise flat triangles of the control mesh. Normals and curvatures are
    /// those of the limit surface in both.
    pub limit: bool,
    /// Positions the deviation is measured from, one per vertex of the mesh: the signed distance
    /// along the normal from the same point of that surface.
    pub start: Option<&'a [DVec3]>,
    /// Signed distance of a point (in units of the file) to a reference surface, to be shown in
    /// place of the deviation.
    pub distance: Option<&'a (dyn Fn(DVec3) -> f64 + Sync)>,
    /// Whether the flow is ill-posed at mean curvature `H` and Gaussian curvature `K`.
    pub ill_posed: Option<&'a (dyn Fn(f64, f64) -> bool + Sync)>,
}

/// The part of a surface that moves: what depends on the topology is computed once.
#[derive(Clone, Debug)]
pub struct DynamicSurface {
    /// The mesh around the faces, cut along creases.
    cut: Cut,
    /// Stencils of the faces and of those around them, which the curvatures need.
    elements: Elements,
    lattice: Lattice,
    samples: Samples,
}

impl DynamicSurface {
    /// Prepares `faces` (the patch and its collar, or any others) of a mesh.
    ///
    /// # Panics
    /// If there are flags, but not one for each face.
    pub fn new(topology: &Topology, faces: &[FaceId], options: &SurfaceOptions) -> Self {
        let pieces = options
            .samples_per_edge
            .unwrap_or_else(|| default_pieces(faces.len()))
            .clamp(1, 8);
        let cut = Cut::new(topology, faces, &options.creases);
        let lattice = Lattice::new(pieces);
        let around = cut.faces_around();
        let elements = elements_at(&cut.topology, &around, &lattice.points);
        let samples = Samples::new(&cut, &elements, &lattice, options);
        Self {
            cut,
            elements,
            lattice,
            samples,
        }
    }

    /// Replaces the flags of the faces, in the order in which they were given.
    ///
    /// # Panics
    /// If there are flags, but not one for each face.
    pub fn set_flags(&mut self, flags: &[u32]) {
        self.samples.set_flags(flags);
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
                ..Evaluation::default()
            },
        )
    }
}

/// Finer where there are few faces: a picture has some 10⁶ pixels.
fn default_pieces(faces: usize) -> u32 {
    match faces {
        0..=4_000 => 4,
        4_001..=20_000 => 2,
        _ => 1,
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
        flags: vec![flags; faces.len()],
        ..SurfaceOptions::default()
    };
    DynamicSurface::new(topology, faces, &options).evaluate(positions, centre, limit, None)
}
