//! The surface models of groups of holes, and the predictions that choose them.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::energy::{Energy, Preset};
use crate::mesh::LoopId;
use crate::options::Choice;
use crate::solver::{FlowOptions, SurfaceModel};
use crate::symmetry::Isometry;

/// A surface model with its tension.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Candidate {
    /// The model.
    pub surface: SurfaceModel,
    /// Its tension.
    pub tension: f64,
    /// Whether it follows the counterparts of the holes under a symmetry of the mesh.
    pub symmetric: bool,
    /// The energy of the model `Energy`, if it is not that of the options.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Preset>,
}

impl Candidate {
    pub(super) const fn new(surface: SurfaceModel, tension: f64) -> Self {
        Self {
            surface,
            tension,
            symmetric: false,
            energy: None,
        }
    }

    /// The model of a flow.
    pub(super) fn of(flow: &FlowOptions) -> Self {
        Self::new(flow.surface, flow.tension)
    }

    /// Makes it the model of a flow.
    pub(super) fn apply(self, flow: &mut FlowOptions) {
        (flow.surface, flow.tension) = (self.surface, self.tension);
        if let Some(preset) = self.energy {
            flow.energy = Energy::preset(preset);
        }
    }

    /// Whether it makes the energy of the options stationary.
    pub fn uses_energy(&self) -> bool {
        self.surface == SurfaceModel::Energy && self.energy.is_none()
    }

    /// The model by name, with its own energy and its tension if there are any.
    pub fn words(&self) -> String {
        let mut words = self.surface.name().to_owned();
        if let Some(preset) = self.energy {
            words += " ";
            words += preset.text();
        }
        if self.tension != 0.0 {
            words += " with tension ";
            words += &self.tension.to_string();
        }
        if self.symmetric {
            words += " and symmetry";
        }
        words
    }
}

/// The surface model of a group of holes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GroupSurface {
    /// The model.
    pub model: Candidate,
    /// What chose it; `None` if the options did.
    pub prediction: Option<Arc<Prediction>>,
    /// The holes whose patches were not sound and are by another model or on another triangulation.
    pub others: Vec<OtherSurface>,
}

/// What gave the patch of a hole that is not by the model of its group.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct OtherSurface {
    /// The hole.
    pub hole: LoopId,
    /// The model or triangulation in words.
    pub by: String,
}

impl GroupSurface {
    /// The error to expect of the holes that have this model, relative to the hole radius.
    pub fn expected_error(&self) -> Option<f64> {
        let prediction = self.prediction.as_ref()?;
        Some(prediction.scale * prediction.chosen()?.1)
    }

    /// The error to expect of one hole; `None` if its patch is by another model. It is that of the group if there
    /// is no room for pseudo-holes around the hole itself.
    pub fn expected_error_of(&self, hole: LoopId) -> Option<f64> {
        if self.other_of(hole).is_some() {
            return None;
        }
        let own = self.prediction.as_ref()?.expected_error_of(hole);
        own.or_else(|| self.expected_error())
    }

    /// What gave the patch of a hole, in words; `None` if it is by the model of the group.
    pub fn other_of(&self, hole: LoopId) -> Option<&str> {
        let other = self.others.iter().find(|other| other.hole == hole);
        other.map(|other| &other.by[..])
    }

    /// What gives the patch of a hole: the model, or another one.
    pub fn words_of(&self, hole: LoopId) -> String {
        let other = self.other_of(hole).map(str::to_owned);
        other.unwrap_or_else(|| self.model.words())
    }
}

/// What was predicted for the holes of a group.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Prediction {
    /// The candidates tried, each with the RMS error of its pseudo-holes, relative to their radius.
    pub errors: Vec<(Candidate, f64)>,
    /// Number of pseudo-holes that were computed.
    pub discs: usize,
    /// Ratio of the error to expect of the holes to that of their pseudo-holes: the square root of how
    /// much more the rims of the holes turn.
    pub scale: f64,
    /// The predictions of holes with pseudo-holes of their own.
    pub(super) of_holes: BTreeMap<LoopId, OwnErrors>,
    /// Whether the mean curvature varies around each hole.
    pub(super) varies: bool,
    /// What fills each hole by symmetry, if the symmetric candidate is chosen.
    pub(super) counterparts: Vec<Option<Counterpart>>,
}

/// What fills a hole by symmetry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Counterpart {
    /// Takes the surroundings of the hole to the counterpart.
    pub isometry: Isometry,
    /// Its share in the shape of the patch, above 0 and at most 1.
    pub share: f64,
}

/// What the pseudo-holes of one hole predict.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OwnErrors {
    /// Errors to expect of the hole, by candidate without symmetry, relative to its radius.
    pub plain: [f64; CANDIDATES],
    /// The error to expect of the symmetric candidate.
    pub symmetric: f64,
}

/// Error of `energy` up to which the surface counts as smooth and `energy` is chosen: the predictions
/// use the exact metric, which a vector flow must approximate. On scans the errors are larger, and an
/// advantage of `energy` on the pseudo-holes did not carry over to the fill.
pub(super) const SMOOTH: f64 = 1e-2;
/// Tensions of the candidates `G2`.
pub(super) const TENSIONS: [f64; 4] = [100.0, 30.0, 10.0, 0.0];
/// The candidates `Energy`: the energy of the options, and the variation of the mean curvature, which
/// continues curvatures and takes several times as long.
pub(super) const ENERGIES: [Candidate; 2] = {
    let energy = Candidate::new(SurfaceModel::Energy, 0.0);
    let variation = Candidate {
        energy: Some(Preset::MeanVariation),
        ..energy
    };
    [energy, variation]
};
/// Error of the second energy, over that of the first, up to which it is chosen where the mean curvature is
/// constant and where it varies. On small pseudo-holes both errors are those of the triangles; farther from a
/// rim the second is better where the mean curvature varies.
const PREFERRED: [f64; 2] = [0.9, 1.5];
/// Number of candidates without symmetry.
pub(super) const CANDIDATES: usize = TENSIONS.len() + ENERGIES.len();

/// The candidates: `G2` by [`TENSIONS`], then [`ENERGIES`].
pub(super) fn candidates() -> impl Iterator<Item = Candidate> {
    let g2 = TENSIONS.map(|tension| Candidate::new(SurfaceModel::G2, tension));
    g2.into_iter().chain(ENERGIES)
}

impl Prediction {
    /// The error to expect of a hole by its own pseudo-holes, relative to its radius. `None` if it has none.
    fn expected_error_of(&self, hole: LoopId) -> Option<f64> {
        let (chosen, _) = self.chosen()?;
        let own = self.of_holes.get(&hole)?;
        if chosen.symmetric {
            return Some(own.symmetric);
        }
        let number = candidates().position(|candidate| candidate == chosen)?;
        Some(own.plain[number]).filter(|error| error.is_finite())
    }

    /// The chosen candidate and its error; `None` without a prediction.
    pub fn chosen(&self) -> Option<(Candidate, f64)> {
        let better = |a: &&(Candidate, f64), b: &&(Candidate, f64)| a.1.total_cmp(&b.1);
        let is_energy = |e: &&(Candidate, f64)| e.0.surface == SurfaceModel::Energy;
        let is_plain = |e: &&(Candidate, f64)| !is_energy(e) && !e.0.symmetric;
        let others = self.errors.iter().filter(is_plain).min_by(better);
        let of = |candidate: Candidate| {
            let mut errors = self.errors.iter();
            errors.find(|e| e.0 == candidate && e.1 <= SMOOTH)
        };
        let [energy, variation] = ENERGIES.map(of);
        let preferred = PREFERRED[usize::from(self.varies)];
        let is_better = |e: &&(Candidate, f64)| energy.is_none_or(|f| e.1 <= preferred * f.1);
        let energy = variation.filter(is_better).or(energy);
        let plain = energy.or(others)?;
        // the same flow as without symmetry, or one that must be better by far, because `energy` is exact on
        // many smooth surfaces
        let limit = if is_energy(&plain) { 0.5 } else { 1.0 };
        let symmetric = self.errors.iter().find(|e| e.0.symmetric);
        let symmetric = symmetric.filter(|e| e.1 <= limit * plain.1);
        symmetric.or(Some(plain)).copied()
    }
}
