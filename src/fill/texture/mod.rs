//! Textures of patches: the extended chart of their surroundings, or a chart in an image of their own.

mod atlas;
mod chart;
mod extension;
mod laplace;
mod own;
mod rim_colors;
#[cfg(all(test, feature = "textures"))]
mod tests;

use crate::fill::options::PatchTexture;

pub(super) use extension::{Extension, overlapping};
pub(super) use own::{Uncharted, append_own_charts};
pub(super) use rim_colors::RimColors;
use rim_colors::RimEdge;

/// Red, green, blue and opacity in 0..=1, in linear light.
type Light = [f32; 4];

impl PatchTexture {
    /// Whether texture coordinates may continue into patches.
    pub(super) fn extends(self) -> bool {
        matches!(self, Self::Auto | Self::Extend)
    }

    /// Whether patches may get an image of their own.
    pub(super) fn makes_images(self) -> bool {
        matches!(self, Self::Auto | Self::Own)
    }
}
