//! What the report measures and shows: plain values, stored in the project file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::analysis::Plane;
use crate::app::chains::Chain;
use crate::mesh::DVec3;

/// What a click in the view chooses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pick {
    /// Holes.
    #[default]
    Holes,
    /// Chains of edges.
    Edges,
    /// A point of a section; its direction.
    Section(Across),
}

/// Direction of a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Perpendicular to an axis of the file: 0 to 2.
    Axis(usize),
    /// Upright in the view and along the line of sight.
    View,
}

/// How a curvature comb is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Comb {
    /// Length of a tooth at the curvature of the sphere around the model, in its radii; `None`
    /// adapts it to the section.
    pub length: Option<f64>,
    /// Teeth in the length of the model's radius.
    pub density: f64,
    /// The limit surface's own curvature, with its spikes at irregular vertices, instead of the
    /// averaged one.
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
    /// A point of it.
    pub point: [f64; 3],
    /// Its normal.
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
    /// Vertices are points of the limit surface, not control points.
    pub on_surface: bool,
    /// Sharp edges are measured from this angle on, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharp: Option<f64>,
    /// A mesh to measure distances to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<PathBuf>,
    /// How the comb is drawn.
    pub comb: Comb,
    /// The section.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// Chosen edges.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub chains: Vec<Chain>,
    /// What a click selects.
    #[serde(skip)]
    pub pick: Pick,
    /// Curvature whose histogram is shown: H, K, k1, k2.
    #[serde(skip)]
    pub curvature: usize,
    /// The place that was inspected last.
    #[serde(skip)]
    pub mark: Option<DVec3>,
}

impl ReportView {
    /// Drops what belongs to the mesh that was open before.
    pub fn forget(&mut self) {
        self.chains.clear();
        self.cut = None;
        self.mark = None;
        self.pick = Pick::Holes;
    }

    /// Replaces unusable values from a file by defaults.
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

/// Kinds of files a report is written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportFile {
    /// Everything, as JSON.
    Json,
    /// A line for each measure.
    Measures,
    /// A line for each vertex.
    Vertices,
    /// A line for each point of the section.
    Section,
}

impl ReportFile {
    /// All of them.
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

    /// Extension of its files.
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
