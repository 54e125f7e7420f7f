//! Drawn geometry of meshes: the Loop limit surface and its curvatures.
//!
//! Positions and normals are those of the limit surface at every sample. Curvatures are the lumped
//! L2 projection to piecewise linear functions (formulation, section 3). The curvatures of the
//! limit surface itself are unbounded at irregular vertices and would only show the valences.

mod cut;
mod evaluate;
mod samples;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::mesh::{DVec3, FaceId, Topology, VertexId};
use crate::subdivision::{Elements, elements_at};

use super::Geometry;
use super::textures::{FaceTexture, FaceTextures};
use cut::Cut;
use samples::{Lattice, Samples};

/// The settings of a [`DynamicSurface`].
#[derive(Clone, Debug, Default)]
pub struct SurfaceOptions {
    /// Number of pieces of each drawn edge, 1 to 8; `None` derives it from the number of faces.
    pub samples_per_edge: Option<u32>,
    /// Edges along which the surface has a crease (rims joined G0). Both sides are drawn
    /// separately. Pairs that are not an edge are ignored.
    pub creases: Vec<[VertexId; 2]>,
    /// Whether the mesh was cut open along creases. Boundary edges are then drawn straight between
    /// the common points of the two sides, so that there is no gap between their curves.
    pub is_cut: bool,
    /// Flags of the faces ([`super::Vertex`]), one for each; empty for none.
    pub flags: Vec<u32>,
    /// Texture images of the faces of the whole mesh.
    pub textures: Option<Arc<FaceTextures>>,
    /// Red, green and blue (sRGB, 0 to 1) of the first faces of the whole mesh, if they are known. They hide
    /// colours of vertices.
    pub face_colors: Arc<Vec<Option<[f32; 3]>>>,
}

/// The settings of an evaluation.
#[derive(Clone, Copy, Default)]
pub struct Evaluation<'a> {
    /// The origin of the resulting positions.
    pub centre: DVec3,
    /// Whether the limit surface is drawn instead of the triangles of the control mesh. Normals and
    /// curvatures are those of the limit surface in both cases.
    pub limit: bool,
    /// Positions of the start surface, one per vertex of the mesh. The deviation is the signed
    /// distance along the normal from the same point of that surface.
    pub start: Option<&'a [DVec3]>,
    /// Signed distance of a point (in units of the file) to a reference surface, shown instead of
    /// the deviation.
    pub distance: Option<&'a (dyn Fn(DVec3) -> f64 + Sync)>,
    /// Red, green, blue and opacity (sRGB, 0 to 1) of the first vertices of the mesh; those of the others
    /// are unknown.
    pub colors: &'a [[f32; 4]],
    /// Whether the flow is ill-posed at mean curvature `H` and Gaussian curvature `K`.
    pub ill_posed: Option<&'a (dyn Fn(f64, f64) -> bool + Sync)>,
}

/// The moving part of a surface. Data that depends only on the topology is computed once.
#[derive(Clone, Debug)]
pub struct DynamicSurface {
    /// The mesh around the faces, cut along creases.
    cut: Cut,
    /// Stencils of the faces and of the neighbouring faces, which the curvatures depend on.
    elements: Elements,
    lattice: Lattice,
    samples: Samples,
}

impl DynamicSurface {
    /// Prepares `faces` of a mesh, such as the patch and its support region.
    ///
    /// # Panics
    /// If there are flags, but not exactly one for each face.
    pub fn new(topology: &Topology, faces: &[FaceId], options: &SurfaceOptions) -> Self {
        let pieces = options
            .samples_per_edge
            .unwrap_or_else(|| default_pieces(faces.len()))
            .clamp(1, 8);
        let cut = Cut::new(topology, faces, &options.creases);
        let lattice = Lattice::new(pieces);
        let around = cut.faces_around();
        let elements = elements_at(&cut.topology, &around, &lattice.points);
        let textures = options.textures.as_deref();
        let textures = faces.iter().map(|&f| textures.and_then(|all| all.of(f)));
        let textures: Vec<Option<&FaceTexture>> = textures.collect();
        let color = |f: &FaceId| {
            let known = options.face_colors.get(f.index()).copied().flatten();
            let byte = |x: f32| (255.0 * x).round() as u8;
            known.map_or([0; 4], |[r, g, b]| [byte(r), byte(g), byte(b), u8::MAX])
        };
        let colors: Vec<[u8; 4]> = if options.face_colors.is_empty() {
            Vec::new()
        } else {
            faces.iter().map(color).collect()
        };
        let samples = Samples::new(&cut, &elements, &lattice, options, &textures, &colors);
        Self {
            cut,
            elements,
            lattice,
            samples,
        }
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

/// Pieces per edge. Fewer faces get more pieces; a picture has about 10⁶ pixels.
fn default_pieces(faces: usize) -> u32 {
    match faces {
        0..=4_000 => 4,
        4_001..=20_000 => 2,
        _ => 1,
    }
}
