//! `meniscus refill`.

use anyhow::{Result, bail};
use serde::Serialize;

use crate::cli::UsageError;
use crate::cli::args::RefillArguments;
use crate::cli::fill::{save_filled, start, write_text};
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::report::step_lines;
use crate::fill::{self, Filled, LoopChoice, ScheduledOptions};
use crate::io::{Opened, save_mesh};
use crate::solver::{End, StepRecord};

/// Runs the command.
pub fn refill(args: &RefillArguments) -> Result<()> {
    let by_loop = !args.fill.loop_at.is_empty() || args.fill.loops != LoopChoice::Auto;
    if by_loop || !args.fill.part.is_empty() {
        let what = "refill fills what it erases: choose faces with --ball or --faces, not loops";
        return Err(UsageError(what.into()).into());
    }
    let start = start(&args.fill)?;
    let selected = args.selection.required(&start.opened.mesh)?;
    let progress = Progress::new(1, args.fill.quiet);
    let observe = |group, record: &StepRecord| {
        progress.step(group, record);
        true
    };
    let mesh = &start.opened.mesh;
    let options = ScheduledOptions::new(&start.controls, &start.schedule)?;
    if args.fair {
        let new = fill::fair(mesh, &selected, options, &observe)?;
        progress.finish();
        return save_faired(args, &start.opened, &selected, &new);
    }
    let new = fill::refill(mesh, &selected, options, &observe)?;
    progress.finish();
    if !args.fill.quiet {
        let erased = &new.region.erased;
        print(&format!(
            "{}: {} faces and {} vertices erased\n",
            args.fill.output.display(),
            mesh.face_count() - erased.old_face.len(),
            mesh.vertex_count() - erased.old_vertex.len(),
        ))?;
    }
    save_filled(
        &args.fill,
        &start.opened,
        &new.filled,
        Vec::new(),
        Vec::new(),
    )
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

fn save_faired(
    args: &RefillArguments,
    opened: &Opened,
    selected: &[bool],
    new: &Filled,
) -> Result<()> {
    save_mesh(&args.fill.output, &new.mesh, &opened.material_libraries)?;
    let Some(Ok(group)) = new.groups.first() else {
        let error = new.groups.iter().find_map(|g| g.as_ref().err());
        let why = error.map_or_else(String::new, ToString::to_string);
        bail!(
            "the selected region cannot be faired: {why}. {} was written with the warm start there",
            args.fill.output.display()
        );
    };
    let outcome = &group.outcome;
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
        seconds: group.timings.total() / 1e3,
        warnings: &outcome.warnings,
    };
    if let Some(path) = &args.fill.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if let Some(path) = &args.fill.trace {
        write_text(path, &step_lines([(None, &group.records[..])]))?;
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
