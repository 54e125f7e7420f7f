//! The options of a fill: one struct for command line, window, schedules and project files.

mod limits;
#[cfg(test)]
mod schedule_tests;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::energy::{Energy, ExprError, Order};
use crate::fill::options::{Continuity, Features, FillOptions, PatchTexture, Surface, Symmetry};
use crate::mesh::LoopId;
use crate::options::{Options, choices, options, text_keys};
use crate::patch::PatchOptions;
use crate::solver::{FlowOptions, LinearSolver, Mode, Scheme, SolverError, SurfaceModel, Tau};

pub use limits::LoopLimits;

/// How the linear systems of the mixed schemes are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Linear {
    /// Restarted GMRES with block elimination as preconditioner.
    #[default]
    Gmres,
    /// Sparse LU.
    Lu,
}

choices!(Linear: Gmres "gmres", Lu "lu");

options! {
    /// The options of a fill.
    ///
    /// The default is that of the command line: surface model `auto`, energy `H^2` (of the
    /// surface model `energy`), scheme B, fast mode, continuity `auto`.
    pub struct Controls {
        /// Energy f(H,K): a preset or an expression.
        energy("F"): String = "H^2".into(),
        /// Value of a parameter of the energy (repeatable).
        #[serde(alias = "params")]
        param("NAME=VALUE"): BTreeMap<String, f64> = BTreeMap::new(),
        /// Surface model: `energy` makes an energy f(H,K) stationary, `diffusion` is quasi surface
        /// diffusion, `g2` continues curvatures across the rim, `auto` chooses by prediction of the
        /// surroundings (`energy` if an option of the energy is given).
        surface: Surface = Surface::default(),
        /// Whether `auto` may fill holes after their counterparts under an approximate symmetry of the
        /// mesh: `auto` where prediction expects less error, `off` never.
        symmetry: Symmetry = Symmetry::default(),
        /// Whether the sharp lines that end at a hole continue through it: `auto` where they lead to a
        /// common corner or in pairs to each other, `off` never.
        features: Features = Features::default(),
        /// Method: `normal` is the fast linearly implicit normal flow, `mixed` the paper's mixed
        /// finite elements, `mixed-corrected` the same matrix with the exact gradient.
        scheme: Scheme = Scheme::default(),
        /// `fast` computes the stationary shape in few steps, `flow` follows the flow in true time.
        mode: Mode = Mode::default(),
        /// Linear solver of the mixed schemes.
        linear: Linear = Linear::default(),
        /// Time step: auto, or a fixed one (length^2 / unit of f).
        tau("T"): Tau = Tau::default(),
        /// Factor of an adaptive time step after an accepted step [default: 10 in fast mode, 1.3 in
        /// flow mode].
        growth("F"): Option<f64> = None,
        /// Tangential relaxation after each accepted step: vertices move towards the mean of their
        /// neighbours, by this weight from 0 to 1.
        relaxation("W"): f64 = 0.0,
        /// Maximum number of steps.
        #[serde(alias = "max_steps")]
        steps("N"): usize = 200,
        /// Weight of the area beside the energy, in units of 1/r^2, r the hole radius. A larger
        /// weight pulls the surface together.
        tension("W"): f64 = 0.0,
        /// Spontaneous curvature in units of 1/r, positive along the normals: 0.5 favours tubes of the
        /// hole's radius, 1 spheres of that radius. Caps are highest at 0.5.
        bulge("C"): f64 = 0.0,
        /// Noise on the surface from which the flow starts, in mean edge lengths along the normals.
        noise("A"): f64 = 0.0,
        /// Density of the patch relative to the rim: 2 halves the edge length.
        density("F"): f64 = 1.0,
        /// Continuity at the rims: `g0` for a crease, `g1` for continuous normals, `g2` for continuous
        /// curvatures (surface model `g2` or energy with gradH2), `auto` for the most of the surface model.
        continuity: Continuity = Continuity::default(),
        /// Continuity at one loop, by its number (repeatable).
        #[serde(alias = "loop_continuity", deserialize_with = "text_keys")]
        loop_continuity("LOOP=auto|g0|g1|g2"): BTreeMap<LoopId, Continuity> = BTreeMap::new(),
        /// Put the faces of each patch into a group, such as `patch_1`: groups of OBJ, or the
        /// property `patch` of the faces of PLY, which is 0 elsewhere.
        label_patches: bool = false,
        /// Texture of patches: `extend` continues the texture coordinates where the rim lies in one
        /// chart, `own` makes an image of the colours along the rim, `auto` extends where other faces
        /// leave room and makes an image elsewhere, `none` leaves patches without.
        patch_texture: PatchTexture = PatchTexture::default(),
    }
}

/// The options that only the surface model `energy` uses.
const OF_ENERGY: [&str; 6] = ["energy", "param", "scheme", "linear", "relaxation", "bulge"];

/// Invalid options.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
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
    #[error("noise must be a non-negative number of edge lengths, not {0}")]
    Noise(f64),
    /// A rim is `G2`, but the flow is not of sixth order.
    #[error("continuity g2 needs the surface model g2 or an energy with gradH2")]
    Curvature,
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
    /// An invalid energy, or a number out of range.
    pub fn options(&self) -> Result<FillOptions, ControlsError> {
        if !(self.density.is_finite() && self.density > 0.0) {
            return Err(ControlsError::Density(self.density));
        }
        if !(self.noise.is_finite() && self.noise >= 0.0) {
            return Err(ControlsError::Noise(self.noise));
        }
        let mut flow = FlowOptions::new(Energy::parse(&self.energy, &self.param)?);
        flow.surface = match self.surface.model() {
            Some(model) => model,
            None if self.is_plain() && self.has_g2_rim() => SurfaceModel::G2,
            None => SurfaceModel::default(),
        };
        flow.scheme = self.scheme;
        flow.mode = self.mode;
        flow.linear = match self.linear {
            Linear::Gmres => LinearSolver::default(),
            Linear::Lu => LinearSolver::Lu,
        };
        flow.tau = self.tau;
        flow.tension = self.tension;
        flow.bulge = self.bulge;
        flow.growth = self.growth;
        flow.relaxation = self.relaxation;
        flow.max_steps = self.steps;
        flow.validate()?;
        if self.has_g2_rim() && flow.order() != Order::Sixth {
            return Err(ControlsError::Curvature);
        }
        Ok(FillOptions {
            patch: PatchOptions {
                density: self.density,
            },
            noise: self.noise,
            flow,
            predicts_surface: self.predicts_surface(),
            symmetry: self.symmetry,
            features: self.features,
            continuity: self.continuity,
            loop_continuity: self.loop_continuity.clone(),
            label_patches: self.label_patches,
            patch_texture: self.patch_texture,
            leaves_islands: false,
        })
    }

    /// Whether the surface model is to be predicted: `auto`, no option of the model `energy` is set, and
    /// no rim has to be `G2`.
    pub fn predicts_surface(&self) -> bool {
        self.surface == Surface::Auto && self.is_plain() && !self.has_g2_rim()
    }

    fn has_g2_rim(&self) -> bool {
        let own = self.loop_continuity.values();
        std::iter::once(&self.continuity)
            .chain(own)
            .any(|c| *c == Continuity::G2)
    }

    /// Names of the options that are set but have no effect with the surface model.
    pub fn unused(&self) -> Vec<String> {
        if self.surface.has_energy() {
            return Vec::new();
        }
        let set = Self::default()
            .difference(self)
            .into_iter()
            .map(|(name, _)| name);
        let mut names: Vec<String> = set
            .filter(|name| OF_ENERGY.contains(&name.as_str()))
            .collect();
        names.dedup();
        names
    }

    /// Whether no option is set that only the model `energy` has, and no tension.
    fn is_plain(&self) -> bool {
        let default = Self::default();
        let parts = |c: &Self| {
            (
                c.energy.clone(),
                c.param.clone(),
                c.scheme,
                c.tension,
                c.bulge,
            )
        };
        parts(self) == parts(&default)
    }

    /// How the patch of a loop joins its rim.
    pub fn continuity_at(&self, id: LoopId) -> Continuity {
        let own = self.loop_continuity.get(&id);
        own.copied().unwrap_or(self.continuity)
    }
}
