//! `meniscus repair`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;

use crate::cli::flow::{MeshFiles, failed_holes, say_skipped, usage, write_text};
use crate::cli::hints::print_warnings;
use crate::cli::options::OptionArguments;
use crate::cli::print::{print, save, say};
use crate::cli::progress::{Progress, Work};
use crate::cli::report::{FailedHole, HoleReport, SkippedLoop, hole_reports, skipped};
use crate::cli::targets::check_targets;
use crate::fill::Controls;
use crate::memory::peak_memory;
use crate::mesh::{LoadReport, Mesh, boundary_loops};
use crate::ops::{CleanSpec, Condition, DamageSpec, FlowSpec, Operation, Outcome, Repair};
use crate::warning::Place;

/// `meniscus repair`.
#[derive(Debug, Args)]
pub struct RepairArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// What is loose.
    #[command(flatten)]
    pub clean: OptionArguments<CleanSpec>,
    /// What is damaged.
    #[command(flatten)]
    pub damage: OptionArguments<DamageSpec>,
    /// The options of the flows.
    #[command(flatten)]
    pub controls: OptionArguments<Controls>,
    /// Write a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
}

/// The report of a repair.
#[derive(Serialize)]
struct RepairReport {
    version: &'static str,
    input: String,
    output: String,
    load: LoadReport,
    before: Condition,
    steps: Vec<Step>,
    after: Condition,
    left_open: Vec<SkippedLoop>,
    seconds: f64,
    peak_memory: u64,
}

/// One operation of a repair.
#[derive(Serialize)]
struct Step {
    task: &'static str,
    faces_erased: usize,
    faces_added: usize,
    holes: Vec<HoleReport>,
    failed: Vec<FailedHole>,
}

/// Runs `meniscus repair`.
pub fn repair(args: &RepairArguments) -> Result<()> {
    let controls = args.controls.0.clone();
    let options = controls.options().map_err(|e| usage(&e))?;
    let [input, output] = args.files.named();
    check_targets(&[input], &[output], &[("--report", args.report.as_deref())])?;
    let opened = args.files.read()?;
    let quiet = args.files.options.quiet;
    let tell = |line: &str| {
        if !quiet {
            say(line);
        }
    };
    let start = Instant::now();
    let mut mesh = opened.mesh;
    let before = Condition::of(&mesh);
    tell(&format!("before: {}", before.words()));
    let (clean, damage) = (args.clean.0.clone(), args.damage.0.clone());
    let mut repair = Repair::new(clean, damage, FlowSpec::from(controls));
    let mut steps: Vec<Step> = Vec::new();
    while let Some(done) = repair.step(
        &mesh,
        |operation| run(operation, &mesh, quiet),
        |error| tell(&format!("refill: {error}")),
    )? {
        tell(&done.words());
        let filled = done.outcome.filled();
        let step = Step {
            task: done.operation.command_name(),
            faces_erased: done.faces_erased,
            faces_added: done.faces_added,
            holes: filled.map_or_else(Vec::new, |filled| hole_reports(filled, &options)),
            failed: filled.map_or_else(Vec::new, failed_holes),
        };
        if let Operation::Fill(_) = done.operation {
            for hole in step.holes.iter().filter(|_| !quiet) {
                print_warnings(&format!("hole {}: ", hole.id), hole.warnings.iter());
            }
        }
        steps.push(step);
        mesh = done.outcome.into_mesh();
    }
    save(
        &args.files.output,
        &mesh,
        args.files.options.textures,
        quiet,
    )?;
    let report = RepairReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.files.input.display().to_string(),
        output: args.files.output.display().to_string(),
        load: opened.report,
        before,
        steps,
        after: Condition::of(&mesh),
        left_open: skipped(&boundary_loops(&mesh), &[], |l| {
            if l.is_outer_boundary {
                l.why_outer()
            } else {
                "it could not be filled".into()
            }
        }),
        seconds: start.elapsed().as_secs_f64(),
        peak_memory: peak_memory(),
    };
    if let Some(path) = &args.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if !quiet {
        conclude(&report)?;
    }
    let mut failed = report.steps.iter().flat_map(|step| &step.failed);
    if let Some(FailedHole { reason, .. }) = failed.next() {
        bail!("not all holes could be filled. First error: {reason}");
    }
    Ok(())
}

fn run(operation: &Operation, mesh: &Mesh, quiet: bool) -> Result<Outcome> {
    let holes = match operation {
        Operation::Fill(spec) => spec.loops.len(),
        _ => 1,
    };
    let progress = Progress::new(Work::Holes(holes), quiet);
    let outcome = operation.run(mesh, &|group, record| {
        progress.step(group, record);
        true
    });
    progress.finish();
    Ok(outcome?)
}

/// Says what is left.
fn conclude(report: &RepairReport) -> Result<()> {
    say_skipped(&report.left_open);
    let after = &report.after;
    if let Some(at) = after.place {
        let is_tried = report.steps.iter().any(|step| step.task == "refill");
        let why = if is_tried {
            "erase more around them with --grow, or with `meniscus refill`"
        } else {
            "they were not erased, because they have more than a tenth of all faces"
        };
        say(&format!(
            "{} left, one near {}\n  hint: {why}; `meniscus analyze --json` lists the places",
            after.pairs(),
            Place(at)
        ));
    }
    print(&format!(
        "{}: {} in {:.2} s\n",
        report.output,
        after.words(),
        report.seconds
    ))
}
