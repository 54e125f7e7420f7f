//! Options of a flow.

use crate::energy::{Energy, Order};
use crate::options::{Choice, choices};
use crate::solver::SolverError;
use crate::solver::control::{Mode, Tau};
use crate::solver::mixed::LinearSolver;
use crate::subdivision::Rule;

/// The method that computes the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scheme {
    /// Scheme B, the linearly implicit normal flow.
    #[default]
    Normal,
    /// Scheme A, the paper's mixed finite elements (21)-(23).
    Mixed,
    /// Scheme A with the exact gradient as right-hand side: the same matrix, but another fixed
    /// point.
    MixedCorrected,
}

/// What a flow makes stationary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SurfaceModel {
    /// `∫ f(H, K) dA` of the Loop limit surface.
    #[default]
    Energy,
    /// `½∫|Δx|²` of the control triangles: quasi surface diffusion.
    Diffusion,
    /// `½∫|∇Δx|²` of the control triangles: curvature continuous at the rim.
    G2,
}

choices!(SurfaceModel: Energy "energy", Diffusion "diffusion", G2 "g2");

impl SurfaceModel {
    /// The natural time of a flow over a hole of that radius: about that in which the slowest mode
    /// of a clamped disc falls by a factor e, `R⁴/100` (3.20⁴ = 104), or `R⁶/4000` for `G2`. That of
    /// `Energy` also depends on the surface.
    pub(crate) fn natural_time(self, radius: f64) -> f64 {
        match self {
            Self::Energy | Self::Diffusion => radius.powi(4) / 100.0,
            Self::G2 => radius.powi(6) / 4000.0,
        }
    }
}

choices!(Scheme: Normal "normal", Mixed "mixed", MixedCorrected "mixed-corrected");

/// Options of a flow.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FlowOptions {
    /// f(H, K) + c |∇H|².
    pub energy: Energy,
    /// Weight, in units of 1 / r² (r is the hole radius), of the energy of two orders less: the area
    /// beside an f of the dimension of `H²`, `½∫|∇x|²` for diffusion, `½∫|Δx|²` for g2. 0 gives the
    /// surface model only.
    pub tension: f64,
    /// Spontaneous curvature, in units of 1 / r, positive along the normals: 1 favours spheres of the
    /// hole radius.
    pub bulge: f64,
    /// What the flow makes stationary.
    pub surface: SurfaceModel,
    /// The method.
    pub scheme: Scheme,
    /// Stationary shape or true time.
    pub mode: Mode,
    /// Time step.
    pub tau: Tau,
    /// Factor of an adaptive τ after an accepted step; `None` is the mode's own.
    pub growth: Option<f64>,
    /// Weight of tangential relaxation after each accepted step, 0 (none) to 1.
    pub relaxation: f64,
    /// Maximum number of steps.
    pub max_steps: usize,
    /// Scheme A's linear solver.
    pub linear: LinearSolver,
    /// Quadrature of scheme B's steps. Three interior points give the same errors as twelve on
    /// scans (measured) at a third of the cost; scheme A and reported energies use twelve at least.
    pub quadrature: Rule,
}

impl FlowOptions {
    /// The defaults with the given energy: scheme B, fast mode, adaptive τ, at most 200 steps.
    pub fn new(energy: Energy) -> Self {
        Self {
            energy,
            tension: 0.0,
            bulge: 0.0,
            surface: SurfaceModel::default(),
            scheme: Scheme::default(),
            mode: Mode::default(),
            tau: Tau::default(),
            growth: None,
            relaxation: 0.0,
            max_steps: 200,
            linear: LinearSolver::default(),
            quadrature: Rule::Three,
        }
    }

    /// Order of the flow without tension.
    pub fn order(&self) -> Order {
        match self.surface {
            SurfaceModel::Energy => self.energy.order(),
            SurfaceModel::Diffusion => Order::Fourth,
            SurfaceModel::G2 => Order::Sixth,
        }
    }

    /// The energy with tension and spontaneous curvature for a hole of that radius. On a sphere
    /// with outward normals H is negative, so a positive option value is a negative spontaneous
    /// curvature.
    pub fn energy_at(&self, radius: f64) -> Energy {
        self.energy
            .shifted(self.tension / (radius * radius), -self.bulge / radius)
    }

    /// # Errors
    /// [`SolverError::BadOption`] naming the option that is out of range.
    pub fn validate(&self) -> Result<(), SolverError> {
        if let Tau::Fixed(t) = self.tau
            && !(t.is_finite() && t > 0.0)
        {
            return Err(SolverError::BadOption {
                option: "tau",
                value: t.to_string(),
                expected: "a time step is a positive number (or `auto`)",
            });
        }
        if let Some(growth) = self.growth
            && !(growth.is_finite() && growth >= 1.0)
        {
            return Err(SolverError::BadOption {
                option: "growth",
                value: growth.to_string(),
                expected: "the factor of the time step after an accepted step is at least 1",
            });
        }
        for (option, value) in [("tension", self.tension), ("bulge", self.bulge)] {
            if !value.is_finite() {
                return Err(SolverError::BadOption {
                    option,
                    value: value.to_string(),
                    expected: "a finite number, 0 for none",
                });
            }
        }
        let needs_normal =
            self.surface == SurfaceModel::Energy && self.energy.order() == Order::Sixth;
        if needs_normal && self.scheme != Scheme::Normal {
            return Err(SolverError::BadOption {
                option: "scheme",
                value: self.scheme.name().into(),
                expected: "an energy with gradH2 needs the scheme `normal`",
            });
        }
        if !(0.0..=1.0).contains(&self.relaxation) {
            return Err(SolverError::BadOption {
                option: "relaxation",
                value: self.relaxation.to_string(),
                expected: "a weight is a number from 0 to 1",
            });
        }
        Ok(())
    }
}
