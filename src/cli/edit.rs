//! `meniscus erase`, `flip`, `bridge`, `clean` and `stitch`: changes without a flow.

use anyhow::{Result, bail};
use clap::Args;

use crate::cli::flow::MeshFiles;
use crate::cli::options::OptionArguments;
use crate::cli::parse::point;
use crate::cli::print::{print, save, say};
use crate::cli::selection::SelectionArguments;
use crate::fill::{bridge_warning, nearest_loop};
use crate::io::Opened;
use crate::mesh::{DVec3, LoopId, Mesh, boundary_loops};
use crate::ops::{BridgeSpec, CleanSpec, EraseSpec, FlipSpec, Operation, StitchSpec};
use crate::warning::counted;

/// `meniscus erase`.
#[derive(Debug, Args)]
pub struct EraseArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// The faces to erase.
    #[command(flatten)]
    pub selection: SelectionArguments,
}

/// `meniscus flip`.
#[derive(Debug, Args)]
pub struct FlipArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// Flip the component of this loop. `meniscus info` lists the loops (repeatable).
    #[arg(long, value_name = "LOOP", required = true)]
    pub component_of: Vec<LoopId>,
}

/// `meniscus bridge`.
#[derive(Debug, Args)]
pub struct BridgeArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// Start at the rim vertex nearest to this point.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub from: DVec3,
    /// End at the rim vertex nearest to this point.
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub to: DVec3,
    /// The width in rim edges.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub width: usize,
}

/// `meniscus clean`.
#[derive(Debug, Args)]
pub struct CleanArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// What is loose.
    #[command(flatten)]
    pub spec: OptionArguments<CleanSpec>,
}

/// `meniscus stitch`.
#[derive(Debug, Args)]
pub struct StitchArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// What coincides.
    #[command(flatten)]
    pub spec: OptionArguments<StitchSpec>,
}

/// Runs `meniscus erase`.
pub fn erase(args: &EraseArguments) -> Result<()> {
    let opened = args.files.open()?;
    let erase = EraseSpec {
        faces: args.selection.required(&opened.mesh)?,
    };
    let mesh = done(&args.files, &opened, &Operation::Erase(erase))?;
    report(
        &args.files,
        &format!(
            "{} and {} erased; {} now",
            faces(opened.mesh.face_count() - mesh.face_count()),
            vertices(opened.mesh.vertex_count() - mesh.vertex_count()),
            loops_of(&mesh),
        ),
    )
}

/// Runs `meniscus flip`.
pub fn flip(args: &FlipArguments) -> Result<()> {
    let opened = args.files.open()?;
    let loops = args.component_of.clone();
    done(&args.files, &opened, &Operation::Flip(FlipSpec { loops }))?;
    report(&args.files, "flipped")
}

/// Runs `meniscus bridge`.
pub fn bridge(args: &BridgeArguments) -> Result<()> {
    let opened = args.files.open()?;
    let (before, loops) = (&opened.mesh, boundary_loops(&opened.mesh));
    let near = |point| nearest_loop(before, &loops, point);
    let ends = match [near(args.from), near(args.to)] {
        [Some(a), Some(b)] if a == b => format!("across loop {a}"),
        [Some(a), Some(b)] => format!("from loop {a} to loop {b}"),
        _ => bail!("the mesh has no boundary loop, so there is nothing to bridge"),
    };
    let spec = BridgeSpec {
        ends: [args.from, args.to],
        width: args.width,
    };
    let mesh = done(&args.files, &opened, &Operation::Bridge(spec))?;
    if let Some(warning) = bridge_warning(before, &mesh) {
        say(&format!("warning: {warning}"));
    }
    report(
        &args.files,
        &format!(
            "a bridge {ends}, {} and {} added; {} now\n  --bridge-faces {}-{} of `meniscus fill` lets \
             it flow with the patches beside it",
            vertices(mesh.vertex_count() - before.vertex_count()),
            faces(mesh.face_count() - before.face_count()),
            loops_of(&mesh),
            before.face_count() + 1,
            mesh.face_count(),
        ),
    )
}

/// Runs `meniscus clean`.
pub fn clean(args: &CleanArguments) -> Result<()> {
    let opened = args.files.open()?;
    let before = &opened.mesh;
    let spec = args.spec.0.clone();
    let parts = spec.parts(before);
    let mesh = done(&args.files, &opened, &Operation::Clean(spec))?;
    report(
        &args.files,
        &format!(
            "{} and {} removed, with {} and {}; {} now",
            counted(parts.components, "component", "components"),
            counted(parts.flaps, "flap", "flaps"),
            faces(before.face_count() - mesh.face_count()),
            vertices(before.vertex_count() - mesh.vertex_count()),
            loops_of(&mesh),
        ),
    )
}

/// Runs `meniscus stitch`.
pub fn stitch(args: &StitchArguments) -> Result<()> {
    let opened = args.files.open()?;
    let before = &opened.mesh;
    let spec = args.spec.0.clone();
    let tolerance = spec.tolerance(before);
    let mesh = done(&args.files, &opened, &Operation::Stitch(spec))?;
    let open = before.topology.boundary_edge_count();
    report(
        &args.files,
        &format!(
            "{} and {} joined within {tolerance:.3e}; {} now, {} before",
            counted(
                open.saturating_sub(mesh.topology.boundary_edge_count()),
                "boundary edge",
                "boundary edges"
            ),
            vertices(before.vertex_count() - mesh.vertex_count()),
            loops_of(&mesh),
            before.topology.boundary_loops().len(),
        ),
    )
}

/// Runs an operation without a flow and writes the new mesh.
fn done(files: &MeshFiles, opened: &Opened, operation: &Operation) -> Result<Mesh> {
    let mesh = operation.run(&opened.mesh, &|_, _| true)?.into_mesh();
    save(
        &files.output,
        &mesh,
        files.options.textures,
        files.options.quiet,
    )?;
    Ok(mesh)
}

fn vertices(n: usize) -> String {
    counted(n, "vertex", "vertices")
}

fn faces(n: usize) -> String {
    counted(n, "face", "faces")
}

/// The number of boundary loops in words.
fn loops_of(mesh: &Mesh) -> String {
    counted(mesh.topology.boundary_loops().len(), "loop", "loops")
}

fn report(files: &MeshFiles, text: &str) -> Result<()> {
    if files.options.quiet {
        return Ok(());
    }
    print(&format!("{}: {text}\n", files.output.display()))
}
