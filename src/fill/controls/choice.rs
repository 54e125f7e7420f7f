//! Choices with names, as they are written on the command line and in schedules.

use crate::solver::{Mode, Scheme};
use serde::{Deserialize, Serialize};

/// A choice among few named values.
pub trait Choice: Copy + PartialEq + 'static {
    /// All values.
    const ALL: &'static [Self];

    /// The name of a value.
    fn name(self) -> &'static str;

    /// The value of that name.
    fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|c| c.name() == name)
    }
}

/// How a patch meets the mesh along a rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Continuity {
    /// In position only: the rim is a crease, and the mesh around it has no influence.
    G0,
    /// In position and normal: one smooth surface runs through the rim.
    #[default]
    G1,
}

/// How the linear systems of the mixed schemes are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Linear {
    /// Restarted GMRES with block elimination as preconditioner.
    #[default]
    Gmres,
    /// Sparse LU.
    Lu,
}

impl Choice for Continuity {
    const ALL: &'static [Self] = &[Self::G1, Self::G0];

    fn name(self) -> &'static str {
        match self {
            Self::G0 => "g0",
            Self::G1 => "g1",
        }
    }
}

impl Choice for Linear {
    const ALL: &'static [Self] = &[Self::Gmres, Self::Lu];

    fn name(self) -> &'static str {
        match self {
            Self::Gmres => "gmres",
            Self::Lu => "lu",
        }
    }
}

impl Choice for Scheme {
    // the guarded descent is for refinements, which choose it themselves
    const ALL: &'static [Self] = &[Self::Normal, Self::Mixed, Self::MixedCorrected];

    fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Mixed => "mixed",
            Self::MixedCorrected => "mixed-corrected",
        }
    }
}

impl Choice for Mode {
    const ALL: &'static [Self] = &[Self::Fast, Self::Flow];

    fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Flow => "flow",
        }
    }
}
