//! The options of a fill.

use std::collections::BTreeMap;

use crate::energy::{Energy, Preset};
use crate::mesh::LoopId;
use crate::options::choices;
use crate::patch::PatchOptions;
use crate::solver::FlowOptions;

/// The continuity of a patch and the mesh along a rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuity {
    /// Continuous positions: the rim is a crease, and the mesh around it has no influence.
    G0,
    /// Continuous positions and normals: the surface is smooth across the rim.
    #[default]
    G1,
}

choices!(Continuity: G1 "g1", G0 "g0");

/// The options of a fill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FillOptions {
    /// The first patch.
    pub patch: PatchOptions,
    /// Noise on the start surface, in mean edge lengths along the normals.
    pub noise: f64,
    /// The flow.
    pub flow: FlowOptions,
    /// Continuity of the patches and the mesh.
    pub continuity: Continuity,
    /// Continuity at single loops.
    pub loop_continuity: BTreeMap<LoopId, Continuity>,
}

impl Default for FillOptions {
    /// Density of the rim, `f = H²`, normal scheme, fast mode, G1.
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
    /// The continuity at a loop.
    pub fn continuity_at(&self, id: LoopId) -> Continuity {
        let own = self.loop_continuity.get(&id);
        own.copied().unwrap_or(self.continuity)
    }
}
