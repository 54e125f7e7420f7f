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

/// An action of the report.
#[derive(Clone, Debug, PartialEq)]
pub enum ReportAction {
    /// Whether vertices are points of the limit surface.
    OnSurface(bool),
    /// Minimum angle of sharp edges in degrees; `None` for no sharp edges.
    Sharp(Option<f64>),
    /// What a click in the view selects.
    Pick(Pick),
    /// The curvature of the histogram.
    Curvature(usize),
    /// Add or remove the chain through this edge of the document's mesh.
    Edge(HalfedgeId),
    /// Remove a chosen chain.
    DropChain(usize),
    /// Add a section through a point.
    Cut(Cut),
    /// Remove the section.
    DropCut,
    /// Whether the half in front of the section is hidden.
    HideFront(bool),
    /// Change the look of the comb.
    Comb(Comb),
    /// Choose the reference mesh.
    AskReference,
    /// Remove the reference.
    DropReference,
    /// Mark a point and move the camera to it.
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

/// A request for measures.
#[derive(Clone)]
pub struct MeasureRequest {
    /// The measured surface.
    pub subject: Subject,
    /// Whether vertices are points of the limit surface.
    pub on_surface: bool,
    /// The typed energy.
    pub energy: Option<Energy>,
    /// Minimum angle of sharp edges in degrees.
    pub sharp: Option<f64>,
    /// Chosen edges.
    pub chains: Vec<Chain>,
    /// Reference mesh.
    pub reference: Option<Arc<Reference>>,
}

impl MeasureRequest {
    /// Whether both request the same measures of one mesh, regardless of the state of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        self.subject.same_but_state(&other.subject)
            && self.on_surface == other.on_surface
            && self.energy == other.energy
            && self.sharp == other.sharp
            && self.chains == other.chains
            && self.reference.as_ref().map(Arc::as_ptr) == other.reference.as_ref().map(Arc::as_ptr)
    }

    /// Whether both requests are equal.
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
    /// The measures. Chains are, in this order, the chosen ones, the rims and the sharp edges.
    pub analysis: Analysis,
    /// Number of chosen chains.
    pub chosen: usize,
    /// Number of rims.
    pub rims: usize,
    /// Number of omitted chains of sharp edges.
    pub left_out: usize,
}

/// A request for a section.
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
    /// Whether both request the same section, regardless of the state of a run.
    pub fn same_but_state(&self, other: &Self) -> bool {
        self.subject.same_but_state(&other.subject)
            && self.on_surface == other.on_surface
            && self.plane == other.plane
    }

    /// Whether both requests are equal.
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

/// A job with its request.
pub type Under<T, R> = Option<(T, Job<R>)>;

/// Results and running jobs of the report.
#[derive(Default)]
pub struct Report {
    /// The newest measures.
    pub measured: Option<Arc<Measured>>,
    /// The running measurement.
    pub measuring: Under<MeasureRequest, Option<Measured>>,
    /// The failed request, which is not repeated.
    pub failed: Option<MeasureRequest>,
    /// The newest section.
    pub cut: Option<SectionResult>,
    /// The running computation of a section.
    pub cutting: Under<SectionRequest, SectionResult>,
    /// The reference mesh.
    pub reference: Option<Arc<Reference>>,
    /// The reference that is being read.
    pub loading: Under<PathBuf, Result<Reference, String>>,
    /// The energy of the document's controls.
    pub(crate) energy: ParsedEnergy,
    /// The job that writes a text for the clipboard.
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
