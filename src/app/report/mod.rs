//! The report: measures of the shown surface, and the jobs that compute them.

mod reference;
mod subject;
#[cfg(test)]
mod tests;
mod view;

use std::path::PathBuf;
use std::sync::Arc;

pub use reference::Reference;
pub use subject::{Patches, Subject};
pub use view::{Across, Comb, Cut, Pick, ReportFile, ReportView};

use super::cached::ParsedEnergy;
use super::chains::Chain;
use super::jobs::Job;
use crate::analysis::{Analysis, Plane, Section};
use crate::energy::Energy;
use crate::mesh::{DVec3, HalfedgeId, Mesh};
use crate::render::ViewMode;

/// A request of the report.
#[derive(Clone, Debug, PartialEq)]
pub enum ReportAction {
    /// Whether vertices are points of the limit surface.
    OnSurface(bool),
    /// Angle from which edges are sharp, degrees; `None` for no sharp edges.
    Sharp(Option<f64>),
    /// What a click in the view selects.
    Pick(Pick),
    /// Curvature whose histogram is shown.
    Curvature(usize),
    /// Add or remove the chain through this edge of the document's mesh.
    Edge(HalfedgeId),
    /// Remove a chosen chain.
    DropChain(usize),
    /// A section through a point.
    Cut(Cut),
    /// Remove the section.
    DropCut,
    /// How the comb is drawn.
    Comb(Comb),
    /// Choose a mesh to measure distances to.
    AskReference,
    /// Remove the reference.
    DropReference,
    /// Show a place: mark it and look at it from outside.
    Inspect(DVec3),
    /// Copy a report to the clipboard.
    Copy(ReportFile),
    /// Choose where to write a report.
    AskSave(ReportFile),
    /// Measure distances to this mesh file.
    Reference(PathBuf),
    /// Write a report to this path.
    Save(ReportFile, PathBuf),
}

/// What to measure.
#[derive(Clone)]
pub struct MeasureRequest {
    /// The measured surface.
    pub subject: Subject,
    /// Whether vertices are points of the limit surface.
    pub on_surface: bool,
    /// The typed energy.
    pub energy: Option<Energy>,
    /// Angle from which edges are sharp, degrees.
    pub sharp: Option<f64>,
    /// Chosen edges.
    pub chains: Vec<Chain>,
    /// Mesh to measure distances to.
    pub reference: Option<Arc<Reference>>,
}

impl MeasureRequest {
    /// Whether both measure the same of one mesh, at the same or another state of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        self.subject.same_but_state(&other.subject)
            && self.on_surface == other.on_surface
            && self.energy == other.energy
            && self.sharp == other.sharp
            && self.chains == other.chains
            && self.reference.as_ref().map(Arc::as_ptr) == other.reference.as_ref().map(Arc::as_ptr)
    }

    /// Whether both measure the same.
    pub fn same(&self, other: &Self) -> bool {
        self.subject.same(&other.subject) && self.same_but_state(other)
    }
}

/// Measures.
pub struct Measured {
    /// The request.
    pub request: MeasureRequest,
    /// The measured mesh.
    pub mesh: Arc<Mesh>,
    /// The measures; chains are the chosen ones, the rims, the sharp edges.
    pub analysis: Analysis,
    /// How many of the chains were chosen.
    pub chosen: usize,
    /// How many are rims.
    pub rims: usize,
    /// Chains of sharp edges that were left out.
    pub left_out: usize,
}

/// A section to compute.
#[derive(Clone)]
pub struct SectionRequest {
    /// The surface.
    pub subject: Subject,
    /// Whether vertices are points of the limit surface.
    pub on_surface: bool,
    /// The plane.
    pub plane: Plane,
}

impl SectionRequest {
    /// Whether both are the same section, at the same or another state of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        self.subject.same_but_state(&other.subject)
            && self.on_surface == other.on_surface
            && self.plane == other.plane
    }

    /// Whether both are the same section.
    pub fn same(&self, other: &Self) -> bool {
        self.subject.same(&other.subject) && self.same_but_state(other)
    }
}

/// A section with its request.
pub struct SectionResult {
    /// The request.
    pub request: SectionRequest,
    /// The curves.
    pub section: Arc<Section>,
}

/// The request of a job, and the job.
pub type Under<T, R> = Option<(T, Job<R>)>;

/// Results and running jobs of the report.
#[derive(Default)]
pub struct Report {
    /// The newest measures.
    pub measured: Option<Arc<Measured>>,
    /// Measures being computed.
    pub measuring: Under<MeasureRequest, Option<Measured>>,
    /// The request that failed; it is not tried again.
    pub failed: Option<MeasureRequest>,
    /// The newest section.
    pub cut: Option<SectionResult>,
    /// A section being computed.
    pub cutting: Under<SectionRequest, SectionResult>,
    /// The mesh distances are measured to.
    pub reference: Option<Arc<Reference>>,
    /// A reference being read.
    pub loading: Under<PathBuf, Result<Reference, String>>,
    /// The energy of the document's controls.
    pub(crate) energy: ParsedEnergy,
    /// Text for the clipboard being written.
    pub copying: Option<Job<Result<String, String>>>,
}

impl Report {
    /// The reference, if the view shows the distance to it.
    pub fn shown_reference(&self, mode: ViewMode) -> Option<Arc<Reference>> {
        self.reference
            .clone()
            .filter(|_| mode == ViewMode::Distance)
    }
}
