//! Options for the look of pictures, shared by `render` and `fill`.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::analysis::Plane;
use crate::cli::UsageError;
use crate::cli::parse::{plane, point};
use crate::mesh::DVec3;
use crate::options::{Choice, choices};
use crate::render::{MAX_SIDE, Material, ViewMode};

/// Options of pictures.
#[derive(Clone, Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArguments {
    /// The quantity shown by colours: shaded, colour, isophotes, zebra, H, K, k1 or k2 [default:
    /// colour if the mesh has colours or texture images, otherwise shaded].
    #[arg(long, value_name = "VIEW", value_parser = view)]
    pub view: Option<ViewMode>,
    /// Width and height in pixels, at most 8192 each [default: 1280x960].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// The camera: front, back, left, right, top, bottom, iso, or the text of a camera copied from
    /// the window.
    #[arg(long, value_name = "CAMERA", allow_hyphen_values = true)]
    pub camera: Option<String>,
    /// The axis that points up in the named views [default: y].
    #[arg(long, value_name = "AXIS", value_parser = choice::<Up>())]
    pub up: Option<Up>,
    /// Use parallel projection.
    #[arg(long)]
    pub orthographic: bool,
    /// Make the background transparent.
    #[arg(long)]
    pub transparent: bool,
    /// The number of pairs of light and dark bands (isophotes, zebra) [default: 12].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub stripes: Option<u32>,
    /// The direction to the light of the isophotes [default: 0.3,1,0.5].
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub light: Option<DVec3>,
    /// The values at the two ends of the colour map of H, K, k1 and k2 [default: the central range
    /// of the values that occur].
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<[f32; 2]>,
    /// The material of the view shaded: plain, clay, porcelain, steel or jade [default: plain].
    #[arg(long, value_name = "MATERIAL", value_parser = choice::<Material>())]
    pub material: Option<Material>,
    /// Draw the legend of H, K, k1 or k2 beside the surface: colours, end values and unit.
    #[arg(long)]
    pub legend: bool,
    /// Write this text below the surface.
    #[arg(long, value_name = "TEXT")]
    pub caption: Option<String>,
    /// Draw the edges of the control mesh.
    #[arg(long)]
    pub wireframe: bool,
    /// Draw the boundary loops.
    #[arg(long)]
    pub rims: bool,
    /// Draw a grid on the ground below the model; its cells have a round length.
    #[arg(long)]
    pub grid: bool,
    /// Hide the part of the surface between the eye and a plane, given by a point and a normal.
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", value_parser = plane, allow_hyphen_values = true)]
    pub cut: Option<Plane>,
    /// Draw the triangles of the control mesh instead of its limit surface.
    #[arg(long)]
    pub control_mesh: bool,
    /// Draw patches in the colour of the mesh.
    #[arg(long)]
    pub no_tint: bool,
    /// Use a dark background.
    #[arg(long)]
    pub dark: bool,
}

/// The values of `--up`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

choices!(Up: Y "y", Z "z");

impl PictureArguments {
    /// Whether any option was given.
    pub fn given(&self) -> bool {
        *self != Self::default()
    }

    /// Refuses a legend of a view without numbers.
    pub fn check(&self) -> anyhow::Result<()> {
        if self.legend && !self.view.is_some_and(ViewMode::is_map) {
            let message = "--legend needs a view with numbers: --view H, K, k1 or k2";
            return Err(UsageError(message.into()).into());
        }
        Ok(())
    }
}

fn view(text: &str) -> Result<ViewMode, String> {
    let shown = |mode: &ViewMode| !matches!(mode, ViewMode::Deviation | ViewMode::Distance);
    ViewMode::named(text)
        .filter(shown)
        .ok_or_else(|| "write shaded, colour, isophotes, zebra, H, K, k1 or k2".into())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let error = || {
        format!(
            "write a width and a height from 1 to {MAX_SIDE} pixels, as in \
                            1920x1080"
        )
    };
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(error)?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(n) if (1..=MAX_SIDE).contains(&n) => Ok(n),
        _ => Err(error()),
    };
    Ok([side(width)?, side(height)?])
}

fn range(text: &str) -> Result<[f32; 2], String> {
    let error = || "write two numbers, the lower first, as in -2,2".to_owned();
    let (low, high) = text.split_once(',').ok_or_else(error)?;
    let number = |text: &str| text.trim().parse::<f32>().map_err(|_| error());
    let [low, high] = [number(low)?, number(high)?];
    if low < high && low.is_finite() && high.is_finite() {
        Ok([low, high])
    } else {
        Err(error())
    }
}

/// Parses the name of a choice.
pub fn choice<T: Choice>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::names())
        .map(|name| T::named(&name).expect("one of the possible values"))
}
