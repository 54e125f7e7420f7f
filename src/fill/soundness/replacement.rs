//! Surfaces that may replace an unsound or wrinkled one, and what gave them.

use crate::fill::defects::Defects;
use crate::fill::patch_topology::PatchTopology;
use crate::mesh::DVec3;

/// Patches of a group, and its new vertices.
pub(super) type Surface = (PatchTopology, Vec<DVec3>);

/// What gave a surface.
#[derive(Clone, Default)]
pub(super) struct Origin {
    /// Another model or triangulation, in words; `None` for the chosen model on the first triangles.
    pub other: Option<String>,
    /// Whether vertices near its defects were moved.
    pub is_repaired: bool,
    /// How many times as much the patch before bends, if that is why it was replaced.
    pub bending: Option<f64>,
    /// How far the patch before was from the rim, in radii of the hole, if that is why it was replaced.
    pub reach: Option<f64>,
}

/// A surface that may replace an unsound one.
pub(super) struct Replacement {
    pub surface: Surface,
    pub origin: Origin,
    /// Those of the hole's patch; `None` if it is sound.
    pub defects: Option<Defects>,
}

impl Replacement {
    pub fn is_sound(&self) -> bool {
        self.defects.is_none()
    }
}

/// The surface at a part of the way from one surface to another one of the same triangles.
pub(super) fn between(from: &Surface, to: &Surface, part: f64) -> Surface {
    let pairs = from.1.iter().zip(&to.1);
    let positions = pairs.map(|(a, b)| a.lerp(*b, part)).collect();
    (from.0.clone(), positions)
}
