//! Measures of a surface: energies, curvatures, continuity along edges, quality of triangles,
//! distances to another one.
//!
//! The surface is the Loop limit surface of the mesh: its vertices are control points, as in what
//! `fill` writes, or points the surface passes ([`Vertices::OnSurface`]), as in what `refine` writes and
//! in meshes of any other origin. Plain data throughout, for a window and for JSON alike.

mod chains;
mod continuity;
mod curvature;
mod cut;
mod distance;
mod quality;
mod shape;

pub use chains::{EdgeChain, patch_rims, sharp_edges};
pub use continuity::{ChainReport, Statistic, measure_chain};
pub use curvature::{CurvatureReport, Histogram, Range, vertex_curvatures};
pub use distance::{Deviation, Distances, distances};
pub use quality::{QualityReport, quality};
pub use shape::{Energies, ShapeReport, Vertices, control_points, shape};

use serde::Serialize;

use crate::mesh::Mesh;
use crate::solver::energy::Energy;

/// Everything [`analyze`] finds out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// Counts, areas, volumes, energies.
    pub shape: ShapeReport,
    /// Ranges and histograms of the curvatures.
    pub curvature: CurvatureReport,
    /// The triangles.
    pub quality: QualityReport,
    /// Along the given chains of edges.
    pub chains: Vec<ChainReport>,
    /// Distances to the reference, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distances: Option<Distances>,
}

/// What is to be measured, and how.
#[derive(Clone, Debug, Default)]
pub struct AnalysisOptions<'a> {
    /// What the vertices are.
    pub vertices: Vertices,
    /// An energy beside the usual ones.
    pub energy: Option<Energy>,
    /// Chains of edges to measure continuity along.
    pub chains: Vec<EdgeChain>,
    /// A surface to compare with.
    pub reference: Option<&'a Mesh>,
}

/// Measures a mesh. Nothing is assumed of it: without triangles all measures are zero or absent.
pub fn analyze(mesh: &Mesh, options: &AnalysisOptions<'_>) -> Analysis {
    let control = control_points(mesh, options.vertices);
    let chains = options.chains.iter();
    Analysis {
        shape: shape(mesh, &control, options.energy.as_ref()),
        curvature: curvature::curvature(&mesh.topology, &control),
        quality: quality(mesh),
        chains: chains.map(|c| measure_chain(mesh, &control, c)).collect(),
        distances: options.reference.and_then(|r| distances(mesh, r)),
    }
}

#[cfg(test)]
mod tests;
