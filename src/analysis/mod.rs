//! Measures of a surface: energies, curvatures, continuity along edges, quality of triangles,
//! distances to another one.
//!
//! The surface is the Loop limit surface of the mesh: its vertices are control points, as in what
//! `fill` writes, or points the surface passes ([`Vertices::OnSurface`]), as in what `refine`
//! writes and in meshes of any other origin. Plain data throughout, for a window and for JSON
//! alike.

mod bending;
mod chains;
mod continuity;
mod curvature;
mod distance;
mod export;
mod local;
mod quality;
mod section;
mod shape;

pub use chains::{EdgeChain, chain_through, patch_rims, sharp_edges};
pub use continuity::{ChainReport, Statistic, WorstJumps, measure_chain, worst_jumps};
pub use curvature::{CurvatureReport, Histogram, Range, vertex_curvatures};
pub use distance::{Deviation, Distances, distances};
pub use export::{measures_csv, report_json, sections_csv, vertices_csv};
pub use quality::{QualityReport, quality};
pub use section::{Plane, Section, SectionCurve, SectionPoint, section};
pub use shape::{Energies, ShapeReport, Vertices, control_points, shape};

use serde::Serialize;

use crate::energy::Energy;
use crate::mesh::Mesh;

/// All results of [`analyze`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
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
    /// Sections by the given planes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<Section>,
}

/// Options of a measurement.
#[derive(Clone, Debug, Default)]
pub struct AnalysisOptions<'a> {
    /// The meaning of the vertices.
    pub vertices: Vertices,
    /// An energy in addition to the standard ones.
    pub energy: Option<Energy>,
    /// Chains of edges to measure continuity along.
    pub chains: Vec<EdgeChain>,
    /// A surface to compare with.
    pub reference: Option<&'a Mesh>,
    /// Planes to cut by.
    pub planes: Vec<Plane>,
}

/// Measures any mesh. Without triangles all measures are zero or absent.
pub fn analyze(mesh: &Mesh, options: &AnalysisOptions<'_>) -> Analysis {
    let Some(all) = analyze_while(mesh, options, &|_, _| true) else {
        unreachable!("it is wanted to the end");
    };
    all
}

/// [`analyze`] that can be cancelled. Between two measures it calls `wanted` with the number of
/// finished measures and the total; it returns `None` as soon as `wanted` returns false.
pub fn analyze_while(
    mesh: &Mesh,
    options: &AnalysisOptions<'_>,
    wanted: &dyn Fn(usize, usize) -> bool,
) -> Option<Analysis> {
    let total = 5 + options.chains.len() + options.planes.len();
    let go_on = |done: usize| wanted(done, total).then_some(());
    go_on(0)?;
    let control = control_points(mesh, options.vertices);
    go_on(1)?;
    let shape = shape(mesh, &control, options.energy.as_ref());
    go_on(2)?;
    let curvature = curvature::curvature(&mesh.topology, &control);
    go_on(3)?;
    let quality = quality(mesh);
    let mut chains = Vec::new();
    for chain in &options.chains {
        go_on(4 + chains.len())?;
        chains.push(measure_chain(mesh, &control, chain));
    }
    let mut sections = Vec::new();
    for plane in &options.planes {
        go_on(4 + chains.len() + sections.len())?;
        sections.push(section(&mesh.topology, &control, plane));
    }
    go_on(total - 1)?;
    let distances = options.reference.and_then(|r| distances(mesh, r));
    Some(Analysis {
        shape,
        curvature,
        quality,
        chains,
        distances,
        sections,
    })
}

#[cfg(test)]
mod order_tests;
#[cfg(test)]
mod tests;
