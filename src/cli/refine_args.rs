//! Arguments of `meniscus refine` and `meniscus analyze`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::analysis::Plane;
use crate::cli::args::point;
use crate::cli::controls::{choice, parameter, tau};
use crate::cli::creases::CreaseArguments;
use crate::cli::edit::SelectionArguments;
use crate::fill::TauChoice;
use crate::refine::{BoundaryRule, Hold, Method};
use crate::solver::Mode;

/// `meniscus refine`.
#[derive(Debug, Args)]
pub struct RefineArguments {
    /// Mesh to read (.obj, .ply, .stl).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Mesh to write (.obj, .ply, .stl). The vertices of IN come first, untouched (but for `loop`).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Times every triangle is cut into four.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub levels: usize,
    /// How new vertices are placed: `pde` by a flow, `butterfly` and `loop` by the subdivision
    /// schemes of these names.
    #[arg(long, value_enum, default_value = "pde")]
    pub method: MethodArgument,
    /// Energy f(H,K): a preset or an expression. Without it, sqrt(k1^2+k2^2+c^2) with the c and the
    /// tension that suit the mesh's edge length; with it, just this energy.
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// Value of a parameter of the energy (repeatable).
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameter)]
    pub param: Vec<(String, f64)>,
    /// Weight of the area beside the energy, in units of 1/r^2, r the RMS distance of the vertices
    /// from their mean.
    #[arg(long, value_name = "W", value_parser = crate::cli::controls::finite, allow_negative_numbers = true)]
    pub tension: Option<f64>,
    /// What the surface keeps passing from the second level on: all vertices of the level before, or
    /// those of IN only.
    #[arg(long, value_enum, default_value = "previous")]
    pub hold: HoldArgument,
    /// Boundaries and creases between their vertices.
    #[arg(long, value_enum, default_value = "spline")]
    pub boundary: BoundaryArgument,
    /// A vertex of a boundary or crease is a corner where that turns by more than this, in degrees.
    #[arg(long, value_name = "DEG", default_value_t = 45.0)]
    pub corner_angle: f64,
    /// Which edges stay sharp.
    #[command(flatten)]
    pub creases: CreaseArguments,
    /// Refine only these faces; those beside them are cut to fit.
    #[command(flatten)]
    pub selection: SelectionArguments,
    /// `fast` goes for the stationary shape, `flow` follows the flow in true time.
    #[arg(long, default_value = "fast", value_parser = choice::<Mode>())]
    pub mode: Mode,
    /// Time step: auto, or a fixed one.
    #[arg(long, value_name = "T", default_value = "auto", value_parser = tau, allow_negative_numbers = true)]
    pub tau: TauChoice,
    /// Most steps at a level.
    #[arg(long, value_name = "N", default_value_t = 400)]
    pub steps: usize,
    /// Measure the result against this mesh.
    #[arg(long, value_name = "REF")]
    pub against: Option<PathBuf>,
    /// Write the control mesh of the limit surface as well, open along sharp edges.
    #[arg(long, value_name = "FILE")]
    pub control: Option<PathBuf>,
    /// Write a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Write every step as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// `meniscus analyze`.
#[derive(Debug, Args)]
pub struct AnalyzeArguments {
    /// Mesh to measure (.obj, .ply, .stl).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Energy f(H,K) to integrate beside the usual ones.
    #[arg(long, value_name = "F", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// Value of a parameter of the energy (repeatable).
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameter)]
    pub param: Vec<(String, f64)>,
    /// Distances to this mesh, both ways.
    #[arg(long, value_name = "REF")]
    pub against: Option<PathBuf>,
    /// How many of the first faces are the surroundings of patches, as in the output of `fill` (the
    /// faces of its input): the rims between them and the rest are measured.
    #[arg(long, value_name = "N")]
    pub first_faces: Option<usize>,
    /// Measure along the edges at which the surface bends by more than this, in degrees.
    #[arg(long, value_name = "DEG")]
    pub edge_angle: Option<f64>,
    /// Take the mesh as the surface: vertices are points of the limit surface, not control points.
    #[arg(long)]
    pub on_surface: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Write curvatures (and distances) of every vertex as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write all measures as CSV, a line each.
    #[arg(long, value_name = "FILE.csv")]
    pub measures: Option<PathBuf>,
    /// Cut the limit surface by the plane through a point, with a normal (repeatable); the curves and
    /// their curvatures are in the report.
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", value_parser = plane, allow_hyphen_values = true)]
    pub section: Vec<Plane>,
    /// Write the points of the sections as CSV.
    #[arg(long, value_name = "FILE.csv", requires = "section")]
    pub section_csv: Option<PathBuf>,
}

fn plane(text: &str) -> Result<Plane, String> {
    let mistaken = || "give a point and a normal that is not zero, as in 0,0,0.5,0,0,1".to_owned();
    let third = text.match_indices(',').nth(2).ok_or_else(mistaken)?.0;
    let [at, normal] = [&text[..third], &text[third + 1..]].map(point);
    match (at, normal) {
        (Ok(point), Ok(normal)) if normal.try_normalize().is_some() => Ok(Plane { point, normal }),
        _ => Err(mistaken()),
    }
}

/// `--method`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArgument {
    /// Geometric flow.
    Pde,
    /// Modified Butterfly.
    Butterfly,
    /// Loop's scheme.
    Loop,
}

/// `--hold`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HoldArgument {
    /// All vertices of the level before.
    Previous,
    /// Vertices of IN.
    Given,
}

/// `--boundary`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BoundaryArgument {
    /// Cubic B-splines through the vertices.
    Spline,
    /// Straight edges.
    Straight,
}

impl From<MethodArgument> for Method {
    fn from(argument: MethodArgument) -> Self {
        match argument {
            MethodArgument::Pde => Self::Pde,
            MethodArgument::Butterfly => Self::Butterfly,
            MethodArgument::Loop => Self::Loop,
        }
    }
}

impl From<HoldArgument> for Hold {
    fn from(argument: HoldArgument) -> Self {
        match argument {
            HoldArgument::Previous => Self::Previous,
            HoldArgument::Given => Self::Given,
        }
    }
}

impl From<BoundaryArgument> for BoundaryRule {
    fn from(argument: BoundaryArgument) -> Self {
        match argument {
            BoundaryArgument::Spline => Self::Spline,
            BoundaryArgument::Straight => Self::Straight,
        }
    }
}
