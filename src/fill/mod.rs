//! Hole filling, from the rims to the filled mesh.
//!
//! A fill has four stages. First patches over the rims are made, and holes whose support regions
//! meet are grouped (`prepare`, `plan`, `group`). One flow for each group moves the new vertices
//! (`group_flow`, `region`, `remesh`). The patches are inserted into the mesh (`assemble`).
//! [`fill_rim_sets`] does all of it, with the groups in parallel.

mod assemble;
mod attributes;
mod blend;
mod bridge;
mod bridged;
#[cfg(test)]
mod cancel_tests;
mod context;
mod controls;
mod counterpart;
mod crack;
mod defects;
mod estimate;
mod fairing;
mod features;
mod group;
mod group_flow;
mod harmonic;
mod hermite;
mod hole;
mod islands;
mod left_islands;
mod noise;
mod options;
mod part;
mod partial;
mod passing;
mod patch_topology;
mod plan;
mod prediction;
mod prepare;
mod prepared;
mod process;
mod pseudo_hole;
mod refill;
mod region;
mod remesh;
mod repair;
mod restored;
mod result;
mod rim;
mod run;
mod scheduled;
mod select;
mod self_intersection;
mod self_intersection_monitor;
mod sharp;
mod sheets;
mod soundness;
mod surface_choice;
mod symmetric_errors;
mod texture;
mod warm_start;

pub use bridge::{BridgeError, RimSegment, bridge, bridge_strip, bridge_warning, segment_at};
pub use bridged::{Released, release};
pub use controls::{Controls, ControlsError, Linear, LoopLimits};
pub use features::creases_through;
pub use islands::{rim_sets, with_islands};
pub use options::{Continuity, Features, FillOptions, PatchTexture, Surface, Symmetry};
pub use partial::part_chord;
pub use prepare::flow_problem;
pub use prepared::{PreparedFill, ScheduledOptions};
pub use process::{
    FillEvent, FillProcess, FillSnapshot, FillState, GroupState, GroupStatus, LiveFill,
};
pub use refill::{ErasedRegion, Refilled, fair, open_selection, refill};
pub use result::{FillError, Filled, FilledHole, GroupResult, PartialError, RefillError, Timings};
pub use rim::RimSet;
pub use run::{Observer, fill_rim_sets};
pub use select::{LoopChoice, NoSuchLoop, choose, nearest_loop};
pub use surface_choice::{Candidate, GroupSurface, OtherSurface, Prediction};
