//! The report: what was measured of the surface that is shown, and what is being measured.

mod overlay;
mod reference;
mod subject;
#[cfg(test)]
mod tests;
mod view;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

pub use overlay::{ReportOverlays, natural_length};
pub use reference::Reference;
pub use subject::{Patches, Places, Subject};
pub use view::{Across, Chain, Comb, Cut, Pick, ReportFile, ReportView};

use super::jobs::Job;
use super::view_state::PathUse;
use crate::analysis::{Analysis, Plane, Section};
use crate::energy::Energy;
use crate::mesh::{DVec3, HalfedgeId, Mesh};
use crate::render::ViewMode;

/// A request of the report.
#[derive(Clone, Debug)]
pub enum ReportAction {
    /// Whether vertices are points of the limit surface.
    OnSurface(bool),
    /// Angle from which edges are sharp, degrees; `None` for no sharp edges.
    Sharp(Option<f64>),
    /// What a click in the view chooses.
    Pick(Pick),
    /// Curvature whose histogram is shown.
    Curvature(usize),
    /// The chain through this edge of the document's mesh in or out.
    Edge(HalfedgeId),
    /// A chosen chain out.
    DropChain(usize),
    /// A section through a point.
    Cut(Cut),
    /// No section.
    DropCut,
    /// How the comb is drawn.
    Comb(Comb),
    /// Choose a mesh to measure distances to.
    AskReference,
    /// No distances.
    DropReference,
    /// Show a place: mark it, look at it from outside.
    Inspect(DVec3),
    /// To the clipboard.
    Copy(ReportFile),
    /// Choose where to write a report.
    AskSave(ReportFile),
    /// A path was given.
    Path(PathUse, PathBuf),
}

/// What is to be measured.
#[derive(Clone)]
pub struct Wanted {
    /// Of what.
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

impl Wanted {
    /// Whether both ask for the same of one mesh, at the same moment of a run or at another.
    pub fn same_but_state(&self, other: &Self) -> bool {
        type Key<'a> = (bool, Option<(&'a str, &'a BTreeMap<String, f64>)>);
        fn key(w: &Wanted) -> Key<'_> {
            let energy = w.energy.as_ref().map(|e| (e.text(), e.params()));
            (w.on_surface, energy)
        }
        self.subject.same_but_state(&other.subject)
            && key(self) == key(other)
            && self.sharp == other.sharp
            && self.chains == other.chains
            && self.reference.as_ref().map(Arc::as_ptr) == other.reference.as_ref().map(Arc::as_ptr)
    }

    /// Whether both ask for the same.
    pub fn same(&self, other: &Self) -> bool {
        self.subject.same(&other.subject) && self.same_but_state(other)
    }
}

/// What was found.
pub struct Measured {
    /// What was asked for.
    pub wanted: Wanted,
    /// The mesh it was found of.
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

/// A section and what it was asked for.
pub struct CutMade {
    /// Of what.
    pub subject: Subject,
    /// Whether vertices are points of the limit surface.
    pub on_surface: bool,
    /// By what.
    pub plane: Plane,
    /// The curves.
    pub section: Arc<Section>,
}

/// What a job was asked for, and the job.
pub type Under<T, R> = Option<(T, Job<R>)>;

/// All of it.
#[derive(Default)]
pub struct Report {
    /// The newest measures.
    pub measured: Option<Arc<Measured>>,
    /// Measures on the way.
    pub measuring: Under<Wanted, Option<Measured>>,
    /// What could not be measured, not to be tried again.
    pub failed: Option<Wanted>,
    /// The newest section.
    pub cut: Option<CutMade>,
    /// A section on the way.
    pub cutting: Under<(Subject, bool, Plane), CutMade>,
    /// The mesh distances are measured to.
    pub reference: Option<Arc<Reference>>,
    /// One that is being read.
    pub loading: Under<PathBuf, Result<Reference, String>>,
    /// Text for the clipboard on the way.
    pub copying: Option<Job<Result<String, String>>>,
}

impl Report {
    /// The reference, where its distance is what is shown.
    pub fn shown_reference(&self, mode: ViewMode) -> Option<Arc<Reference>> {
        self.reference
            .clone()
            .filter(|_| mode == ViewMode::Distance)
    }
}
