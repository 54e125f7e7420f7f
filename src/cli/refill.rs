//! `meniscus refill`.

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;

use crate::cli::flow::{FlowArguments, FlowCommand, MeshFiles, write_text};
use crate::cli::hints::print_warnings;
use crate::cli::print::{print, save};
use crate::cli::progress::{Progress, Work};
use crate::cli::selection::SelectionArguments;
use crate::cli::trace::Trace;
use crate::fill::Filled;
use crate::ops::{FacesSpec, Operation, Outcome};
use crate::solver::End;
use crate::warning::Warnings;

/// `meniscus refill`.
#[derive(Debug, Args)]
pub struct RefillArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// The faces to erase or fair.
    #[command(flatten)]
    pub selection: SelectionArguments,
    /// Keep the triangles and move only their vertices, instead of erasing and filling.
    #[arg(long)]
    pub fair: bool,
    /// The flow and the output.
    #[command(flatten)]
    pub flow: FlowArguments,
}

/// Runs `meniscus refill`.
pub fn refill(args: &RefillArguments) -> Result<()> {
    let task = FlowCommand::new(&args.files, &args.flow)?;
    let mesh = &task.opened.mesh;
    let spec = FacesSpec {
        faces: args.selection.required(mesh)?,
        flow: task.flow.clone(),
    };
    let faces = spec.faces.len();
    let operation = if args.fair {
        Operation::Fair(spec)
    } else {
        Operation::Refill(spec)
    };
    let work = if args.fair {
        Work::Fairing
    } else {
        Work::Holes(1)
    };
    let progress = Progress::new(work, args.files.options.quiet);
    let outcome = operation.run(mesh, &|group, record| {
        progress.step(group, record);
        true
    })?;
    progress.finish();
    match outcome {
        Outcome::Refilled(new) => {
            if !args.files.options.quiet {
                let erased = &new.region.erased;
                print(&format!(
                    "{}: {} faces and {} vertices erased\n",
                    args.files.output.display(),
                    mesh.face_count() - erased.old_face.len(),
                    mesh.vertex_count() - erased.old_vertex.len(),
                ))?;
            }
            let written = task.save(&new.filled, Vec::new(), Vec::new())?;
            written.conclude(args.files.options.quiet)
        }
        Outcome::Filled(new) => save_faired(args, &task, faces, &new),
        _ => unreachable!("a refill or a fairing"),
    }
}

/// The report of `--fair`.
#[derive(Debug, Serialize)]
struct FairReport<'a> {
    version: &'static str,
    input: String,
    output: String,
    energy: &'a str,
    /// Selected faces.
    faces: usize,
    /// Vertices that moved.
    vertices_moved: usize,
    steps: usize,
    rejected: usize,
    converged: bool,
    energy_start: f64,
    energy_end: f64,
    seconds: f64,
    #[serde(flatten)]
    warnings: &'a Warnings,
}

fn save_faired(
    args: &RefillArguments,
    task: &FlowCommand<'_>,
    faces: usize,
    new: &Filled,
) -> Result<()> {
    let files = &args.files;
    save(
        &files.output,
        &new.mesh,
        files.options.textures,
        files.options.quiet,
    )?;
    let Some(Ok(group)) = new.groups.first() else {
        let error = new.groups.iter().find_map(|g| g.as_ref().err());
        let why = error.map_or_else(String::new, ToString::to_string);
        bail!(
            "the selected region cannot be faired: {why}. {} contains the warm start there",
            args.files.output.display()
        );
    };
    let outcome = &group.outcome;
    let report = FairReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.files.input.display().to_string(),
        output: args.files.output.display().to_string(),
        energy: &task.flow.controls.energy,
        faces,
        vertices_moved: new.moved.len(),
        steps: outcome.steps,
        rejected: outcome.rejected,
        converged: outcome.end == End::Converged,
        energy_start: outcome.energy_start,
        energy_end: outcome.energy_end,
        seconds: group.timings.total() / 1e3,
        warnings: &outcome.warnings,
    };
    if let Some(path) = &args.flow.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if let Some(path) = &args.flow.trace {
        write_text(path, Trace::of_fill(new).text())?;
    }
    if args.files.options.quiet {
        return Ok(());
    }
    print_warnings("", outcome.warnings.iter());
    print(&format!(
        "{}: {} vertices faired in {:.2} s\n",
        report.output, report.vertices_moved, report.seconds
    ))
}
