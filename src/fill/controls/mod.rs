//! Everything a person may choose about a fill: one struct for command line, window and project
//! file.

mod arguments;
mod choice;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::energy::{Energy, ExprError};
use crate::fill::FillOptions;
use crate::mesh::LoopId;
use crate::patch::PatchOptions;
use crate::solver::{FlowOptions, LinearSolver, Mode, Scheme, SolverError, Tau};

pub(in crate::fill) use arguments::difference;
pub use choice::{Choice, Continuity, Linear};

/// How the time step is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TauChoice {
    /// Grown after accepted, shrunk after rejected steps.
    #[default]
    Auto,
    /// Always this one (length² / unit of f).
    Fixed(f64),
}

/// Everything a person may choose about a fill, as plain values.
///
/// The default is that of the command line: `H^2`, scheme B, fast mode, G1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Controls {
    /// Energy f(H, K), as typed.
    pub energy: String,
    /// Values of its parameters.
    pub params: BTreeMap<String, f64>,
    /// The method.
    pub scheme: Scheme,
    /// Stationary shape or true time.
    pub mode: Mode,
    /// Linear solver of the mixed schemes.
    pub linear: Linear,
    /// Time step.
    pub tau: TauChoice,
    /// Factor of τ after an accepted step; `None` is the mode's own.
    pub growth: Option<f64>,
    /// Weight of tangential relaxation after each accepted step, 0 to 1.
    pub relaxation: f64,
    /// Weight of the area beside the energy, in units of 1 / r², r the hole radius: more draws the
    /// surface together.
    pub tension: f64,
    /// Spontaneous curvature, in units of 1 / r, positive along the normals: 1 favours spheres of the
    /// hole's radius.
    pub bulge: f64,
    /// Density of the patch relative to the rim: 2 halves the edge length.
    pub density: f64,
    /// Noise on the surface the flow starts from, in mean edge lengths along the normals. It only
    /// acts at the start.
    pub noise: f64,
    /// How patches meet the mesh.
    pub continuity: Continuity,
    /// The same for single loops.
    pub loop_continuity: BTreeMap<LoopId, Continuity>,
    /// Most steps to take.
    pub max_steps: usize,
}

impl Default for Controls {
    fn default() -> Self {
        Self {
            energy: "H^2".into(),
            params: BTreeMap::new(),
            scheme: Scheme::default(),
            mode: Mode::default(),
            linear: Linear::default(),
            tau: TauChoice::default(),
            growth: None,
            relaxation: 0.0,
            tension: 0.0,
            bulge: 0.0,
            density: 1.0,
            noise: 0.0,
            continuity: Continuity::default(),
            loop_continuity: BTreeMap::new(),
            max_steps: 200,
        }
    }
}

/// A control that cannot be used.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ControlsError {
    /// The energy, with the place in its text.
    #[error(transparent)]
    Energy(#[from] ExprError),
    /// An option of the flow is out of range.
    #[error(transparent)]
    Flow(#[from] SolverError),
    /// The density is not a positive number.
    #[error("density must be a positive number, not {0}")]
    Density(f64),
    /// The noise is not a non-negative number.
    #[error("noise must be a number of edge lengths, 0 for none, not {0}")]
    Noise(f64),
}

impl ControlsError {
    /// The error of the energy's text, if it is one.
    pub fn expression(&self) -> Option<&ExprError> {
        match self {
            Self::Energy(error) => Some(error),
            _ => None,
        }
    }
}

impl Controls {
    /// The options of a fill.
    ///
    /// # Errors
    /// A mistaken energy, or a number out of range.
    pub fn options(&self) -> Result<FillOptions, ControlsError> {
        if !(self.density.is_finite() && self.density > 0.0) {
            return Err(ControlsError::Density(self.density));
        }
        if !(self.noise.is_finite() && self.noise >= 0.0) {
            return Err(ControlsError::Noise(self.noise));
        }
        let mut flow = FlowOptions::new(Energy::parse(&self.energy, &self.params)?);
        flow.scheme = self.scheme;
        flow.mode = self.mode;
        flow.linear = match self.linear {
            Linear::Gmres => LinearSolver::default(),
            Linear::Lu => LinearSolver::Lu,
        };
        flow.tau = match self.tau {
            TauChoice::Auto => Tau::Auto,
            TauChoice::Fixed(tau) => Tau::Fixed(tau),
        };
        flow.tension = self.tension;
        flow.bulge = self.bulge;
        flow.growth = self.growth;
        flow.relaxation = self.relaxation;
        flow.max_steps = self.max_steps;
        flow.validate()?;
        Ok(FillOptions {
            patch: PatchOptions {
                density: self.density,
            },
            noise: self.noise,
            flow,
            continuity: self.continuity,
            loop_continuity: self.loop_continuity.clone(),
        })
    }

    /// How the patch of a loop joins its rim.
    pub fn continuity_at(&self, id: LoopId) -> Continuity {
        let own = self.loop_continuity.get(&id);
        own.copied().unwrap_or(self.continuity)
    }
}
