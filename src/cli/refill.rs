//! `meniscus refill`.

use anyhow::Result;
use serde::Serialize;

use crate::cli::UsageError;
use crate::cli::args::RefillArguments;
use crate::cli::fill::{Start, save_filled, start, write_text};
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::report::step_lines;
use crate::fill::{self, FillOptions, LoopChoice, Schedule};
use crate::io::{Opened, save_mesh};
use crate::mesh::{faces_in_ball, grow};
use crate::solver::End;

/// Runs the command.
pub fn refill(args: &RefillArguments) -> Result<()> {
    let by_loop = !args.fill.loop_at.is_empty() || args.fill.loops != LoopChoice::Auto;
    if by_loop || !args.fill.part.is_empty() {
        let what = "refill fills what it erases: choose a place with --ball, not loops";
        return Err(UsageError(what.into()).into());
    }
    let Start {
        controls,
        schedule,
        opened,
    } = start(&args.fill)?;
    if schedule != Schedule::default() {
        return Err(UsageError("refill follows no --schedule".into()).into());
    }
    let options = controls.options()?;
    let mut selected = vec![false; opened.mesh.face_count()];
    for &(centre, radius) in &args.ball {
        for (flag, inside) in selected
            .iter_mut()
            .zip(faces_in_ball(&opened.mesh, centre, radius))
        {
            *flag |= inside;
        }
    }
    for _ in 0..args.grow {
        grow(&opened.mesh.topology, &mut selected);
    }
    if args.fair {
        fair(args, &options, &opened, &selected)
    } else {
        replace(args, &options, &opened, &selected)
    }
}

fn replace(
    args: &RefillArguments,
    options: &FillOptions,
    opened: &Opened,
    selected: &[bool],
) -> Result<()> {
    let progress = Progress::new(1, args.fill.quiet);
    let new = fill::refill(&opened.mesh, selected, options, &|group, record| {
        progress.step(group, record);
        true
    })?;
    progress.finish();
    let output = &args.fill.output;
    if !args.fill.quiet {
        print(&format!(
            "{}: {} faces and {} vertices erased\n",
            output.display(),
            opened.mesh.face_count() - new.erased.old_face.len(),
            opened.mesh.vertex_count() - new.erased.old_vertex.len(),
        ))?;
    }
    save_filled(&args.fill, opened, &new.filled, Vec::new(), Vec::new())
}

/// What `--fair` did.
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
    warnings: &'a [String],
}

fn fair(
    args: &RefillArguments,
    options: &FillOptions,
    opened: &Opened,
    selected: &[bool],
) -> Result<()> {
    let progress = Progress::new(1, args.fill.quiet);
    let new = fill::fair(&opened.mesh, selected, options, &|record| {
        progress.step(0, record);
        true
    })?;
    progress.finish();
    save_mesh(&args.fill.output, &new.mesh, &opened.material_libraries)?;
    let outcome = &new.flow.outcome;
    let report = FairReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.fill.input.display().to_string(),
        output: args.fill.output.display().to_string(),
        energy: &args.fill.controls.energy,
        faces: selected.iter().filter(|&&flag| flag).count(),
        vertices_moved: new.moved.len(),
        steps: outcome.steps,
        rejected: outcome.rejected,
        converged: outcome.end == End::Converged,
        energy_start: outcome.energy_start,
        energy_end: outcome.energy_end,
        seconds: new.flow.timings.total() / 1e3,
        warnings: &outcome.warnings,
    };
    if let Some(path) = &args.fill.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if let Some(path) = &args.fill.trace {
        write_text(path, &step_lines([(0, &new.flow.records[..])]))?;
    }
    if args.fill.quiet {
        return Ok(());
    }
    for warning in &outcome.warnings {
        eprintln!("{warning}");
    }
    print(&format!(
        "{}: {} vertices faired in {:.2} s\n",
        report.output, report.vertices_moved, report.seconds
    ))
}
