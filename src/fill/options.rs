//! What can be chosen about a fill.

use std::collections::BTreeMap;

use crate::energy::{Energy, Preset};
use crate::mesh::LoopId;
use crate::options::choices;
use crate::patch::PatchOptions;
use crate::solver::FlowOptions;

/// How a patch meets the mesh along a rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuity {
    /// In position only: the rim is a crease, and the mesh around it has no influence.
    G0,
    /// In position and normal: one smooth surface runs through the rim.
    #[default]
    G1,
}

choices!(Continuity: G1 "g1", G0 "g0");

/// What can be chosen about a fill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FillOptions {
    /// The first patch.
    pub patch: PatchOptions,
    /// Noise on the surface the flow starts from, in mean edge lengths along the normals.
    pub noise: f64,
    /// The flow.
    pub flow: FlowOptions,
    /// How patches meet the mesh.
    pub continuity: Continuity,
    /// The same for single loops.
    pub loop_continuity: BTreeMap<LoopId, Continuity>,
}

impl Default for FillOptions {
    /// Rim density, `f = H²`, scheme B, fast mode, G1.
    fn default() -> Self {
        Self {
            patch: PatchOptions::default(),
            noise: 0.0,
            flow: FlowOptions::new(Energy::preset(Preset::H2)),
            continuity: Continuity::default(),
            loop_continuity: BTreeMap::new(),
        }
    }
}

impl FillOptions {
    /// How the patch meets the mesh at a loop.
    pub fn continuity_at(&self, id: LoopId) -> Continuity {
        let own = self.loop_continuity.get(&id);
        own.copied().unwrap_or(self.continuity)
    }
}
