//! Settings of the report. They are stored in the project file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::analysis::Plane;
use crate::app::chains::Chain;
use crate::mesh::DVec3;
use crate::render::CutPlane;

/// The target of a click in the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pick {
    /// Holes.
    #[default]
    Holes,
    /// Chains of edges.
    Edges,
    /// A point of a section with this direction.
    Section(Across),
}

/// Direction of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Perpendicular to a coordinate axis, 0 to 2.
    Axis(usize),
    /// Vertical in the view, along the line of sight.
    View,
}

/// The look of a curvature comb.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Comb {
    /// Length of a tooth at the curvature of the bounding sphere of the model, in its radii. `None`
    /// adapts it to the section.
    pub length: Option<f64>,
    /// Teeth per radius of the model.
    pub density: f64,
    /// Whether the comb shows the curvature of the limit surface itself, with its spikes at
    /// irregular vertices, instead of the averaged curvature.
    pub own: bool,
}

impl Default for Comb {
    fn default() -> Self {
        Self {
            length: None,
            density: 60.0,
            own: false,
        }
    }
}

/// A plane as stored in the project file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cut {
    /// A point of the plane.
    pub point: [f64; 3],
    /// The normal.
    pub normal: [f64; 3],
}

impl Cut {
    /// The plane.
    pub fn plane(&self) -> Plane {
        Plane {
            point: DVec3::from_array(self.point),
            normal: DVec3::from_array(self.normal),
        }
    }
}

/// The view of the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ReportView {
    /// Whether vertices are points of the limit surface, not control points.
    pub on_surface: bool,
    /// Minimum angle of sharp edges in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharp: Option<f64>,
    /// The file of the reference mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<PathBuf>,
    /// How the comb is drawn.
    pub comb: Comb,
    /// The section.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// Whether the half in front of the section is hidden.
    pub hide_front: bool,
    /// Chosen edges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub chains: Vec<Chain>,
    /// What a click selects.
    #[serde(skip)]
    pub pick: Pick,
    /// The curvature of the histogram: H, K, k1 or k2.
    #[serde(skip)]
    pub curvature: usize,
    /// The last inspected point.
    #[serde(skip)]
    pub mark: Option<DVec3>,
}

impl ReportView {
    /// Clears the settings that belong to the previous mesh.
    pub fn forget(&mut self) {
        self.chains.clear();
        self.reference = None;
        self.cut = None;
        self.mark = None;
        self.pick = Pick::Holes;
    }

    /// The plane whose side towards the eye is hidden.
    pub fn hidden_half(&self) -> Option<CutPlane> {
        let plane = self.cut.filter(|_| self.hide_front)?.plane();
        Some(CutPlane {
            point: plane.point,
            normal: plane.normal,
        })
    }

    /// Replaces invalid values from a file by defaults.
    #[must_use]
    pub fn checked(mut self) -> Self {
        let in_range = |x: f64, low: f64, high: f64| (low..=high).contains(&x);
        self.comb.length = self.comb.length.filter(|&l| in_range(l, 1e-6, 1e6));
        if !in_range(self.comb.density, 1.0, 2000.0) {
            self.comb.density = Comb::default().density;
        }
        self.sharp = self.sharp.filter(|&a| in_range(a, 1.0, 180.0));
        self.cut = self.cut.filter(|c| {
            let plane = c.plane();
            plane.point.is_finite() && plane.normal.try_normalize().is_some()
        });
        self
    }
}

/// Kinds of report files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportFile {
    /// Everything, as JSON.
    Json,
    /// One line per measure, as CSV.
    Measures,
    /// One line per vertex, as CSV.
    Vertices,
    /// One line per point of the section, as CSV.
    Section,
}

impl ReportFile {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Json, Self::Measures, Self::Vertices, Self::Section];

    /// Name in menus.
    pub fn title(self) -> &'static str {
        match self {
            Self::Json => "Report as JSON",
            Self::Measures => "Measures as CSV",
            Self::Vertices => "Every vertex as CSV",
            Self::Section => "The section as CSV",
        }
    }

    /// File extension.
    pub fn extension(self) -> &'static str {
        if self == Self::Json { "json" } else { "csv" }
    }

    /// End of a file name.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Json => "report.json",
            Self::Measures => "measures.csv",
            Self::Vertices => "vertices.csv",
            Self::Section => "section.csv",
        }
    }
}
