//! What can be done to a mesh, as data.
//!
//! An [`Operation`] holds everything that is needed to do it, and to do it again with a
//! bit-identical result. The commands of the command line make operations and run them, the window's
//! document is a list of them, the project file holds them (`serde`), and [`Operation::command`]
//! is the command line that repeats one.
//!
//! Loops and faces are those of the mesh to which the operation is applied.

mod command;
mod file;
mod run;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::fill::Controls;
use crate::mesh::{DVec3, LoopId};
use crate::options::Options;
use crate::refine::RefineControls;
use crate::runner::Schedule;

pub use command::{CommandLine, chain_text, parse_chain};
pub use run::{OperationError, Outcome};

/// Faces of a mesh, ascending; shared, for they may be many.
pub type Faces = Arc<Vec<u32>>;

/// A change of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "task", rename_all = "kebab-case")]
pub enum Operation {
    /// Every loop gets a patch of its own.
    Fill(FillSpec),
    /// One patch joins all loops.
    Blend(BlendSpec),
    /// The faces are erased and what this opens is filled.
    Refill(FacesSpec),
    /// The inner vertices of the faces flow; the triangles stay.
    Fair(FacesSpec),
    /// Part of a hole is filled.
    FillPart(FillPartSpec),
    /// The mesh is refined.
    Refine(RefineSpec),
    /// The faces are erased.
    Erase(EraseSpec),
    /// The components of some loops are flipped: their other side becomes the outer one.
    Flip(FlipSpec),
    /// A strip of triangles joins two places of rims.
    Bridge(BridgeSpec),
}

/// A flow: its options at the start and their changes on the way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlowSpec {
    /// Changes on the way.
    #[serde(default)]
    pub schedule: Schedule,
    /// Options at the start.
    #[serde(default)]
    pub controls: Controls,
}

impl From<Controls> for FlowSpec {
    fn from(controls: Controls) -> Self {
        Self {
            schedule: Schedule::default(),
            controls,
        }
    }
}

/// A fill.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FillSpec {
    /// The loops.
    pub loops: Vec<LoopId>,
    /// Whether patches pass through the rims of loose pieces inside the holes.
    #[serde(default = "yes")]
    pub islands: bool,
    /// The flow.
    #[serde(flatten)]
    pub flow: FlowSpec,
}

/// A blend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlendSpec {
    /// The loops, at least two.
    pub loops: Vec<LoopId>,
    /// The flow.
    #[serde(flatten)]
    pub flow: FlowSpec,
}

/// A refill or a fairing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FacesSpec {
    /// The faces.
    #[serde(rename = "selected", with = "file::faces")]
    pub faces: Faces,
    /// The flow.
    #[serde(flatten)]
    pub flow: FlowSpec,
}

/// A fill of part of a hole: along the rim from one end to the other, the shorter way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FillPartSpec {
    /// The rim vertices nearest to these points, of the loop nearest to the first, are the ends.
    #[serde(with = "file::points")]
    pub ends: [DVec3; 2],
    /// Options of the flow.
    pub controls: Controls,
}

/// A refinement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "file::RefineEntry", into = "file::RefineEntry")]
pub struct RefineSpec {
    /// Options.
    pub controls: RefineControls,
    /// Edges that stay sharp, beside those chosen by their angle: chains of vertex indices.
    pub creases: Vec<Vec<u32>>,
    /// The faces to refine; empty for all.
    pub faces: Faces,
    /// Changes on the way.
    pub schedule: Schedule,
}

/// An erasure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EraseSpec {
    /// The faces.
    #[serde(rename = "selected", with = "file::faces")]
    pub faces: Faces,
}

/// A flip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlipSpec {
    /// Loops; their components are flipped.
    pub loops: Vec<LoopId>,
}

/// A bridge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BridgeSpec {
    /// It ends at the rim vertices nearest to these points.
    #[serde(with = "file::points")]
    pub ends: [DVec3; 2],
    /// Its width in rim edges.
    pub width: usize,
}

fn yes() -> bool {
    true
}

impl Operation {
    /// The loops it is about.
    pub fn loops(&self) -> &[LoopId] {
        match self {
            Self::Fill(spec) => &spec.loops,
            Self::Blend(spec) => &spec.loops,
            Self::Flip(spec) => &spec.loops,
            _ => &[],
        }
    }

    /// The faces it is about.
    pub fn faces(&self) -> Faces {
        match self {
            Self::Refill(spec) | Self::Fair(spec) => Arc::clone(&spec.faces),
            Self::Erase(spec) => Arc::clone(&spec.faces),
            Self::Refine(spec) => Arc::clone(&spec.faces),
            _ => Faces::default(),
        }
    }

    /// Its flow, if it is one with the options of a fill.
    pub fn flow(&self) -> Option<&FlowSpec> {
        match self {
            Self::Fill(spec) => Some(&spec.flow),
            Self::Blend(spec) => Some(&spec.flow),
            Self::Refill(spec) | Self::Fair(spec) => Some(&spec.flow),
            _ => None,
        }
    }

    /// As [`Self::flow`].
    pub fn flow_mut(&mut self) -> Option<&mut FlowSpec> {
        match self {
            Self::Fill(spec) => Some(&mut spec.flow),
            Self::Blend(spec) => Some(&mut spec.flow),
            Self::Refill(spec) | Self::Fair(spec) => Some(&mut spec.flow),
            _ => None,
        }
    }

    /// Its changes on the way.
    pub fn schedule(&self) -> Option<&Schedule> {
        match self {
            Self::Refine(spec) => Some(&spec.schedule),
            _ => self.flow().map(|flow| &flow.schedule),
        }
    }

    /// Sets the changes on the way; operations without a flow have none.
    pub fn set_schedule(&mut self, schedule: Schedule) {
        match self {
            Self::Refine(spec) => spec.schedule = schedule,
            _ => {
                if let Some(flow) = self.flow_mut() {
                    flow.schedule = schedule;
                }
            }
        }
    }

    /// The controls of its fill at the end, with all changes on the way; the defaults if it is none.
    pub fn last_controls(&self) -> Controls {
        let Some(flow) = self.flow() else {
            return Controls::default();
        };
        let mut controls = flow.controls.clone();
        for entry in &flow.schedule.entries {
            // entries such as `stop` set no control
            controls.set(&entry.control, &entry.value).ok();
        }
        controls
    }

    /// For messages and the undo list.
    pub fn label(&self) -> String {
        match self {
            Self::Fill(FillSpec { loops, .. }) if loops.len() == 1 => {
                format!("fill of loop {}", loops[0])
            }
            Self::Fill(spec) => format!("fill of {} loops", spec.loops.len()),
            Self::Blend(spec) => format!("blend of {} rims", spec.loops.len()),
            Self::Refill(spec) => format!("refill of {} faces", spec.faces.len()),
            Self::Fair(spec) => format!("fairing of {} faces", spec.faces.len()),
            Self::FillPart(_) => "fill of part of a hole".into(),
            Self::Refine(_) => "refinement".into(),
            Self::Erase(spec) => format!("erase {} faces", spec.faces.len()),
            Self::Flip(FlipSpec { loops }) if loops.len() == 1 => {
                format!("flip at loop {}", loops[0])
            }
            Self::Flip(spec) => format!("flip at {} loops", spec.loops.len()),
            Self::Bridge(_) => "bridge".into(),
        }
    }
}
