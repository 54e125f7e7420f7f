//! The command line's grammar.

#[cfg(feature = "window")]
use std::path::PathBuf;

use clap::{Parser, Subcommand};

use crate::cli::analyze::AnalyzeArguments;
use crate::cli::blend::BlendArguments;
use crate::cli::demo::DemoArguments;
use crate::cli::edit::{
    BridgeArguments, CleanArguments, EraseArguments, FlipArguments, StitchArguments,
};
use crate::cli::fill::FillArguments;
use crate::cli::info::InfoArguments;
use crate::cli::refill::RefillArguments;
use crate::cli::refine::RefineArguments;
#[cfg(feature = "render")]
use crate::cli::render::RenderArguments;
use crate::cli::repair::RepairArguments;
use crate::cli::sample::SampleArguments;

/// Fills holes in triangle meshes with smooth surfaces.
///
/// Each hole gets a patch that joins the mesh with continuous normals (G1) or curvatures (G2). By
/// default its surface model is chosen by prediction of the mesh around the hole. The model `energy`
/// makes the integral of an energy f(H,K) stationary. H is the mean curvature, K the Gaussian curvature.
#[derive(Debug, Parser)]
#[command(
    name = "meniscus",
    version,
    about,
    after_help = EXAMPLES,
    args_conflicts_with_subcommands = true
)]
pub struct Arguments {
    /// A command that runs without a window. Without a command the window opens.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The mesh or project to open in the window. The default is a built-in sample.
    #[cfg(feature = "window")]
    #[arg(value_name = "FILE", value_parser = file)]
    pub file: Option<PathBuf>,
    /// Write frame times and memory as JSON when the window closes.
    #[cfg(feature = "window")]
    #[arg(long, value_name = "FILE.json")]
    pub diagnostics: Option<PathBuf>,
}

const EXAMPLES: &str = "Examples:
  meniscus
  meniscus scan.obj
  meniscus info scan.obj
  meniscus fill scan.obj -o filled.obj
  meniscus fill scan.stl -o filled.ply --loops 1,4 --energy 'H^2+K^2'
  meniscus fill scan.obj -o filled.obj --loop-at 0.1,0.2,0.3 --energy '(H-H0)^2' --param H0=-1
  meniscus blend pipes.obj -o joined.obj --loops 1,3
  meniscus demo --out demo

Exit codes: 0 success, 1 failure with a message, 2 invalid command line, 130 or 143 interrupted.";

const FILL_USAGE: &str = "meniscus fill [OPTIONS] --output <OUT> <IN>
       meniscus fill [OPTIONS] --output <OUT> --join <IN>...
       meniscus fill [OPTIONS] --out-dir <FOLDER> <IN>...";

const FILL_EXAMPLES: &str = "Examples:
  meniscus fill bunny.obj -o filled.obj
  meniscus fill scan.obj -o out.obj --loops all-but-largest --report report.json
  meniscus fill a.ply b.obj scans/*.obj --out-dir filled --report report.json
  meniscus fill scan.obj -o out.obj --energy 'k1^4+k2^4' --scheme mixed --linear lu
  meniscus fill scan.obj -o out.obj --energy 'H^2 + a*K^2' --param a=0.3 --trace steps.csv
  meniscus fill scan.obj -o out.obj --mode flow --tau 1e-5 --steps 1000
  meniscus fill pipe.obj -o out.obj --energy 1 --loop-continuity 2=g0
  meniscus fill scan.obj -o out.obj --part 0,0,1 0,1,0

Energies: 1, H^2, K^2, H^2+K^2, H^2*K^2, k1^4+k2^4, K, (H-H0)^2, k1^2+k2^2, (k1-k2)^2,
sqrt(k1^2+k2^2+c^2), or any expression in H, K, k1, k2 and parameters with + - * / ^, abs, sqrt,
exp, log, sin, cos, tanh, min and max. It must be symmetric in k1 and k2. H is negative on a sphere with outward normals.
An energy is evaluated in the units of the file.";

const BLEND_EXAMPLES: &str = "Examples:
  meniscus blend pipes.obj -o joined.obj
  meniscus blend a.ply b.ply -o joined.ply
  meniscus blend pipes.obj -o joined.obj --loops 1,3,5 --energy 'H^2+K^2'
  meniscus blend pipes.obj -o joined.obj --loop-at 1,0,0 --loop-at 0,1,0
  meniscus blend tubes.obj -o joined.obj --energy '(H-H0)^2' --param H0=-1
  meniscus blend pipes.obj -o joined.obj --loops 1,3 --flip 3";

const REFILL_EXAMPLES: &str = "Examples:
  meniscus refill scan.obj -o out.obj --ball 0.1,0.2,0.3,0.05
  meniscus refill scan.obj -o out.obj --ball 0,0,1,0.2 --ball 0,0.1,1,0.2 --grow 2
  meniscus refill scan.obj -o out.obj --faces-crossing --faces-folded --grow 1
  meniscus refill scan.obj -o out.obj --ball 0,0,1,0.2 --fair --energy 'H^2+K^2'";

const REPAIR_EXAMPLES: &str = "Examples:
  meniscus repair scan.ply -o repaired.ply
  meniscus repair scan.ply -o repaired.ply --folds --min-faces 100 --report report.json";

const ERASE_EXAMPLES: &str = "Examples:
  meniscus erase scan.obj -o out.obj --ball 0.1,0.2,0.3,0.05
  meniscus erase scan.obj -o out.obj --faces 1-12,40 --grow 1";

const REFINE_EXAMPLES: &str = "Examples:
  meniscus refine coarse.obj -o fine.obj
  meniscus refine coarse.obj -o fine.obj --levels 2 --energy 'H^2' --report report.json
  meniscus refine coarse.obj -o fine.obj --method butterfly --against original.obj
  meniscus refine coarse.obj -o fine.obj --ball 0,0,1,0.3 --boundary straight";

const ANALYZE_EXAMPLES: &str = "Examples:
  meniscus analyze part.obj
  meniscus analyze fine.obj --on-surface --against original.obj --json
  meniscus analyze filled.obj --first-faces 5000 --csv curvatures.csv
  meniscus analyze part.obj --edge-angle 40 --energy 'H^2+K^2'";

#[cfg(feature = "render")]
const RENDER_EXAMPLES: &str = "Examples:
  meniscus render scan.obj -o scan.png
  meniscus render filled.obj -o map.png --view H --camera top --size 1920x1080
  meniscus render filled.obj -o turn.gif --turntable 60 --size 480x360";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fill the holes of a mesh and write the result.
    ///
    /// The vertices of IN come first in OUT, unchanged.
    #[command(after_help = FILL_EXAMPLES, override_usage = FILL_USAGE)]
    Fill(Box<FillArguments>),
    /// Join several rims, of one or more components, by one smooth patch.
    ///
    /// The vertices of IN come first in OUT, unchanged.
    #[command(after_help = BLEND_EXAMPLES)]
    Blend(Box<BlendArguments>),
    /// Erase faces and fill the hole, or fair them in place.
    #[command(after_help = REFILL_EXAMPLES)]
    Refill(Box<RefillArguments>),
    /// Repair a scan: remove loose parts, erase faces that intersect others and fill their holes, then
    /// fill all other holes.
    ///
    /// The remaining vertices of IN come first in OUT, unchanged.
    #[command(after_help = REPAIR_EXAMPLES)]
    Repair(Box<RepairArguments>),
    /// Refine a mesh: split every triangle into four, level by level, on a smooth surface through
    /// the input vertices.
    ///
    /// The vertices of IN come first in OUT, unchanged (except with `--method loop`).
    #[command(after_help = REFINE_EXAMPLES)]
    Refine(Box<RefineArguments>),
    /// Erase faces and leave the hole open.
    ///
    /// OUT contains the remaining vertices and faces in the order of IN.
    #[command(after_help = ERASE_EXAMPLES)]
    Erase(EraseArguments),
    /// Flip components: reverse the orientation of their faces.
    ///
    /// OUT contains the same vertices and faces in the same order.
    Flip(FlipArguments),
    /// Add a strip of triangles across a hole, or from one hole to another.
    ///
    /// The vertices of IN come first in OUT, unchanged.
    Bridge(BridgeArguments),
    /// Remove loose parts: small components, and flaps that stick into holes.
    ///
    /// OUT contains the remaining vertices and faces in the order of IN.
    Clean(CleanArguments),
    /// Join boundary edges that coincide, such as the two sides of a slit.
    ///
    /// OUT contains the vertices of IN in their order, without those that are joined with an earlier
    /// one, and the faces in their order.
    Stitch(StitchArguments),
    /// Show counts, components, boundary loops and defects of a mesh.
    Info(InfoArguments),
    /// Measure a surface: energies, curvatures, continuity, triangles, distances.
    #[command(after_help = ANALYZE_EXAMPLES)]
    Analyze(AnalyzeArguments),
    /// Write a picture of a mesh.
    #[cfg(feature = "render")]
    #[command(after_help = RENDER_EXAMPLES)]
    Render(RenderArguments),
    /// Write a built-in sample as a mesh file.
    Sample(SampleArguments),
    /// Fill a built-in sample with many holes and write both meshes and the report.
    Demo(DemoArguments),
}

/// Parses FILE. A word without an extension that is not a file is probably a mistyped command.
#[cfg(feature = "window")]
fn file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path.exists() || path.extension().is_some() || path.components().count() > 1 {
        Ok(path)
    } else {
        Err("this is neither a command nor a file; `meniscus --help` lists the commands".into())
    }
}
