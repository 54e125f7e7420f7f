//! The manifest of the test models.

use std::path::Path;

use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
pub struct Manifest {
    pub cases: Vec<Case>,
}

/// One file and its known properties. Indices are 0-based, in file order.
#[derive(Clone, Debug, Deserialize)]
pub struct Case {
    pub name: String,
    /// Relative to the manifest.
    pub file: String,
    pub group: String,
    #[serde(default)]
    pub truth: Option<TruthEntry>,
    #[serde(default)]
    pub loops: Vec<Loop>,
    #[serde(default)]
    pub holes_to_fill: Option<usize>,
    #[serde(default)]
    pub loops_to_leave: Option<usize>,
    /// What must happen with a bad file, in words.
    #[serde(default)]
    pub expect: String,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Loop {
    pub fill: bool,
    /// Whether the patch can be compared with the true surface.
    pub has_truth: bool,
    pub edges: usize,
    /// RMS distance of the loop's vertices from their mean.
    pub radius: f64,
    #[serde(default)]
    pub vertices: Vec<u32>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum TruthEntry {
    Sphere {
        centre: [f64; 3],
        radius: f64,
    },
    Torus {
        #[serde(rename = "R")]
        major: f64,
        #[serde(rename = "r")]
        minor: f64,
    },
    Catenoid {
        c: f64,
    },
    Ellipsoid {
        axes: [f64; 3],
    },
    Graph {
        f: String,
    },
    Cylinder {
        radius: f64,
    },
    Plane {
        point: [f64; 3],
        normal: [f64; 3],
    },
    Mesh {
        file: String,
    },
    /// Truths of other groups (blends, refinements).
    #[serde(other)]
    Other,
}

pub fn read(folder: &Path) -> Result<Manifest, String> {
    let path = folder.join("manifest.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
}
