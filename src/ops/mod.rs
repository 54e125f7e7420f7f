//! Operations on meshes, as data.
//!
//! An [`Operation`] contains everything that is needed to repeat it with a bit-identical result.
//! The commands of the command line build operations and run them. The document of the window
//! contains the operations that were applied, and the project file stores them (`serde`).
//! [`Operation::command`] returns the command line that repeats one.
//!
//! Loop numbers and face indices refer to the mesh to which the operation is applied.

mod cleaning;
mod command;
mod file;
mod repair;
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

pub use cleaning::{CleanSpec, StitchSpec};
pub use command::{CommandLine, chain_text, parse_chain};
pub use repair::{Condition, DamageSpec, Repair, RepairStep};
pub use run::{OperationError, Outcome};

/// Face indices in ascending order, shared because the list may be long.
pub type Faces = Arc<Vec<u32>>;

/// An operation on a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "task", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Operation {
    /// Fills every loop with a separate patch.
    Fill(FillSpec),
    /// Joins all loops by one patch.
    Blend(BlendSpec),
    /// Erases the faces and fills the hole.
    Refill(FacesSpec),
    /// Moves the inner vertices of the faces; keeps the triangles.
    Fair(FacesSpec),
    /// Fills part of a hole.
    FillPart(FillPartSpec),
    /// Refines the mesh.
    Refine(RefineSpec),
    /// Erases the faces.
    Erase(EraseSpec),
    /// Flips the components of some loops: reverses the orientation of their faces.
    Flip(FlipSpec),
    /// Joins two places on rims by a strip of triangles.
    Bridge(BridgeSpec),
    /// Removes loose parts.
    Clean(CleanSpec),
    /// Joins boundary edges that coincide.
    Stitch(StitchSpec),
}

/// A flow: its options at the start and their changes during the flow.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FlowSpec {
    /// Changes during the flow.
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
    /// Whether patches join the rims of islands, the loose components inside holes.
    #[serde(default = "yes")]
    pub islands: bool,
    /// The faces of bridges that flow with the patches of the holes beside them.
    #[serde(default, skip_serializing_if = "no_faces", with = "file::faces")]
    pub bridges: Faces,
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

/// A fill of part of a hole, along the shorter segment of the rim between two ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FillPartSpec {
    /// The ends are the rim vertices nearest to these points, on the loop nearest to the first.
    #[serde(with = "file::points")]
    pub ends: [DVec3; 2],
    /// The flow.
    #[serde(flatten)]
    pub flow: FlowSpec,
}

/// A refinement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "file::RefineEntry", into = "file::RefineEntry")]
pub struct RefineSpec {
    /// Options.
    pub controls: RefineControls,
    /// Sharp edges in addition to those chosen by their angle: chains of vertex indices.
    pub creases: Vec<Vec<u32>>,
    /// The faces to refine; empty for all.
    pub faces: Faces,
    /// Changes during the flow.
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
    /// The loops whose components are flipped.
    pub loops: Vec<LoopId>,
}

/// A bridge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BridgeSpec {
    /// The bridge joins the rim vertices nearest to these points.
    #[serde(with = "file::points")]
    pub ends: [DVec3; 2],
    /// The width in rim edges.
    pub width: usize,
}

fn yes() -> bool {
    true
}

fn no_faces(faces: &Faces) -> bool {
    faces.is_empty()
}

impl Operation {
    /// The loops of the operation.
    pub fn loops(&self) -> &[LoopId] {
        match self {
            Self::Fill(spec) => &spec.loops,
            Self::Blend(spec) => &spec.loops,
            Self::Flip(spec) => &spec.loops,
            _ => &[],
        }
    }

    /// The faces of the operation.
    pub fn faces(&self) -> Faces {
        match self {
            Self::Refill(spec) | Self::Fair(spec) => Arc::clone(&spec.faces),
            Self::Erase(spec) => Arc::clone(&spec.faces),
            Self::Refine(spec) => Arc::clone(&spec.faces),
            _ => Faces::default(),
        }
    }

    /// The flow, if it has the options of a fill.
    pub fn flow(&self) -> Option<&FlowSpec> {
        match self {
            Self::Fill(spec) => Some(&spec.flow),
            Self::Blend(spec) => Some(&spec.flow),
            Self::Refill(spec) | Self::Fair(spec) => Some(&spec.flow),
            Self::FillPart(spec) => Some(&spec.flow),
            _ => None,
        }
    }

    /// As [`Self::flow`].
    pub fn flow_mut(&mut self) -> Option<&mut FlowSpec> {
        match self {
            Self::Fill(spec) => Some(&mut spec.flow),
            Self::Blend(spec) => Some(&mut spec.flow),
            Self::Refill(spec) | Self::Fair(spec) => Some(&mut spec.flow),
            Self::FillPart(spec) => Some(&mut spec.flow),
            _ => None,
        }
    }

    /// The changes during the flow.
    pub fn schedule(&self) -> Option<&Schedule> {
        match self {
            Self::Refine(spec) => Some(&spec.schedule),
            _ => self.flow().map(|flow| &flow.schedule),
        }
    }

    /// Sets the changes during the flow. Does nothing for operations without a flow.
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

    /// The controls of a fill at its end, with all changes; the defaults for other operations.
    pub fn last_controls(&self) -> Controls {
        let Some(flow) = self.flow() else {
            return Controls::default();
        };
        let mut controls = flow.controls.clone();
        for entry in &flow.schedule.entries {
            // entries such as `stop` do not set a control
            controls.set(&entry.control, &entry.value).ok();
        }
        controls
    }

    /// A short description for messages and the undo list.
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
            Self::Clean(_) => "removal of loose parts".into(),
            Self::Stitch(_) => "stitching of slits".into(),
        }
    }
}
