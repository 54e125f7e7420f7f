//! The options of a fill.

use std::collections::BTreeMap;

use crate::energy::{Energy, Order, Preset};
use crate::mesh::LoopId;
use crate::options::choices;
use crate::patch::PatchOptions;
use crate::solver::{FlowOptions, SurfaceModel};

/// The continuity of a patch and the mesh along a rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Continuity {
    /// `G2` if the flow is of sixth order, otherwise `G1`.
    #[default]
    Auto,
    /// Continuous positions: the rim is a crease, and the mesh around it has no influence.
    G0,
    /// Continuous positions and normals.
    G1,
    /// Continuous positions, normals and curvatures. Only flows of sixth order have it.
    G2,
}

choices!(Continuity: Auto "auto", G0 "g0", G1 "g1", G2 "g2");

impl Continuity {
    /// What it is under a flow of that order.
    #[must_use]
    pub fn under(self, order: Order) -> Self {
        match self {
            Self::Auto if order == Order::Sixth => Self::G2,
            Self::Auto => Self::G1,
            other => other,
        }
    }

    /// Whether normals are continuous.
    pub fn is_smooth(self) -> bool {
        self != Self::G0
    }
}

/// The surface model of a fill.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surface {
    /// The model that predicts the surroundings of the holes best; see [`Prediction`]. `Energy` for
    /// blends, fairings and rims that are `G0` or `G1`, and where another energy than `H²` is chosen.
    ///
    /// [`Prediction`]: crate::fill::Prediction
    #[default]
    Auto,
    /// [`SurfaceModel::Energy`].
    Energy,
    /// [`SurfaceModel::Diffusion`].
    Diffusion,
    /// [`SurfaceModel::G2`].
    G2,
}

choices!(Surface: Auto "auto", Energy "energy", Diffusion "diffusion", G2 "g2");

impl Surface {
    /// The model, if it is not to be predicted.
    pub fn model(self) -> Option<SurfaceModel> {
        match self {
            Self::Auto => None,
            Self::Energy => Some(SurfaceModel::Energy),
            Self::Diffusion => Some(SurfaceModel::Diffusion),
            Self::G2 => Some(SurfaceModel::G2),
        }
    }

    /// Whether energies have an effect.
    pub fn has_energy(self) -> bool {
        !matches!(self, Self::Diffusion | Self::G2)
    }
}

/// Whether approximate symmetries of the mesh help to fill its holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Symmetry {
    /// Where prediction expects less error.
    #[default]
    Auto,
    /// Never.
    Off,
}

choices!(Symmetry: Auto "auto", Off "off");

/// Whether the sharp lines that end at a hole continue through it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Features {
    /// Where they lead to a common corner or in pairs to each other, and no other sharp edge ends at the
    /// hole.
    #[default]
    Auto,
    /// Never.
    Off,
}

choices!(Features: Auto "auto", Off "off");

/// How a patch continues the texture around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchTexture {
    /// As `Extend` where the patch has room in the image of its surroundings, otherwise as `Own`.
    #[default]
    Auto,
    /// The texture coordinates continue into the patch where its rim lies in one chart.
    Extend,
    /// The patch gets a chart in an image of its own, which continues the colours along the rim.
    Own,
    /// Not at all.
    None,
}

choices!(PatchTexture: Auto "auto", Extend "extend", Own "own", None "none");

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
    /// Whether prediction replaces surface model and tension of the flow.
    pub predicts_surface: bool,
    /// Whether prediction tries symmetries of the mesh.
    pub symmetry: Symmetry,
    /// Whether sharp edges continue through holes; the value at the start counts.
    pub features: Features,
    /// Continuity of the patches and the mesh.
    pub continuity: Continuity,
    /// Continuity at single loops.
    pub loop_continuity: BTreeMap<LoopId, Continuity>,
    /// Whether the faces of each patch get a group.
    pub label_patches: bool,
    /// How patches continue the texture around them; the value at the start counts.
    pub patch_texture: PatchTexture,
    /// Whether a hole is filled without islands in it where no sound first patch joins them. Otherwise such
    /// a hole fails or stays unsound.
    pub leaves_islands: bool,
}

impl Default for FillOptions {
    /// Density of the rim, `f = H²`, normal scheme, fast mode, G1.
    fn default() -> Self {
        Self {
            patch: PatchOptions::default(),
            noise: 0.0,
            flow: FlowOptions::new(Energy::preset(Preset::H2)),
            predicts_surface: true,
            symmetry: Symmetry::default(),
            features: Features::default(),
            continuity: Continuity::default(),
            loop_continuity: BTreeMap::new(),
            label_patches: false,
            patch_texture: PatchTexture::default(),
            leaves_islands: false,
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
