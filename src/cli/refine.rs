//! `meniscus refine`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use serde::Serialize;

use crate::analysis::{Distances, distances};
use crate::cli::UsageError;
use crate::cli::creases::CreaseArguments;
use crate::cli::flow::{MeshFiles, schedule, write_text};
use crate::cli::hints::{invalid_energy, print_warnings};
use crate::cli::options::OptionArguments;
use crate::cli::print::{print, save};
use crate::cli::progress::{Progress, Work};
use crate::cli::selection::SelectionArguments;
use crate::cli::targets::check_targets;
use crate::cli::trace::Trace;
use crate::io::{Opened, open};
use crate::memory::peak_memory;
use crate::mesh::{FOLD_DEGREES, LoadReport, Mesh, folded_edges, self_intersections};
use crate::ops::{OperationError, RefineSpec};
use crate::options::Choice;
use crate::refine::{self, LevelReport, RefineControls, RefineEvent, Refined};
use crate::runner::Schedule;
use crate::solver::FlowOptions;
use crate::warning::{Warning, Warnings};

/// Maximum number of intersecting pairs that are counted.
const MAX_INTERSECTIONS: usize = 1000;

/// The report of a refinement.
#[derive(Debug, Serialize)]
struct RefineReport<'a> {
    version: &'static str,
    input: String,
    output: String,
    method: String,
    energy: String,
    parameters: BTreeMap<String, f64>,
    /// Weight of the area beside the energy, in units of 1 / r².
    tension: f64,
    load: &'a LoadReport,
    levels: &'a [LevelReport],
    vertices: usize,
    faces: usize,
    /// Whether every level converged.
    converged: bool,
    /// Whether the input vertices are bit-identical.
    input_kept: bool,
    /// Pairs of intersecting triangles (at most 1000), of the result and of the input.
    self_intersections: usize,
    self_intersections_of_input: usize,
    /// Edges with a dihedral angle above 150 degrees, of the result and of the input.
    folded_edges: usize,
    folded_edges_of_input: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    distances: Option<Distances>,
    seconds: f64,
    peak_memory: u64,
    /// Warnings about the levels and the result.
    #[serde(flatten)]
    warnings: Warnings,
}

/// `meniscus refine`.
#[derive(Debug, Args)]
pub struct RefineArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// The options of the refinement.
    #[command(flatten)]
    pub controls: OptionArguments<RefineControls>,
    /// The edges that stay sharp.
    #[command(flatten)]
    pub creases: CreaseArguments,
    /// Refine only these faces. Neighbouring faces are split to match.
    #[command(flatten)]
    pub selection: SelectionArguments,
    /// Apply these changes during the flow: CSV with the columns attempt,control,value, as copied
    /// by the window.
    #[arg(long, value_name = "FILE.csv")]
    pub schedule: Option<PathBuf>,
    /// Measure the result against this mesh.
    #[arg(long, value_name = "REF")]
    pub against: Option<PathBuf>,
    /// Also write the control mesh of the limit surface, cut open along sharp edges.
    #[arg(long, value_name = "FILE")]
    pub control: Option<PathBuf>,
    /// Write a report as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Write every step as CSV.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
}

/// Runs `meniscus refine`.
pub fn refine(args: &RefineArguments) -> Result<()> {
    check_targets(
        &[
            ("IN", Some(&args.files.input)),
            ("--schedule", args.schedule.as_deref()),
            ("--against", args.against.as_deref()),
        ],
        &[
            ("OUT", Some(&args.files.output)),
            ("--control", args.control.as_deref()),
        ],
        &[
            ("--report", args.report.as_deref()),
            ("--trace", args.trace.as_deref()),
        ],
    )?;
    let energy = args.controls.0.given_energy();
    energy.map_err(|e| invalid_energy(&e))?;
    let checked = args.controls.0.check();
    checked.map_err(|e| UsageError(e.to_string()))?;
    let creases = args.creases.chains()?;
    let schedule = match &args.schedule {
        Some(path) => schedule(path, &args.controls.0)?,
        None => Schedule::default(),
    };
    let opened = args.files.read()?;
    let reference = args.against.as_deref().map(open).transpose()?;
    let faces = args.selection.faces(&opened.mesh)?;
    if faces.is_empty() && !args.selection.is_empty() {
        return Err(OperationError::NoFaces.into());
    }
    let spec = RefineSpec {
        controls: args.controls.0.clone(),
        creases,
        faces,
        schedule,
    };
    let options = spec.options(&opened.mesh)?;
    let recording = spec.schedule.recording(&spec.controls)?;
    let flow = spec.controls.flow(&opened.mesh)?;
    let start = Instant::now();
    let progress = Progress::new(Work::Refinement, args.files.options.quiet);
    let mut trace = Trace::new("level");
    let mesh = Arc::new(opened.mesh.clone());
    let observe = &mut |event| {
        if let RefineEvent::Step { level, record } = event {
            progress.step(level, &record);
            trace.add(&level, &record);
        }
        true
    };
    let (refined, refused) = refine::refine(mesh, options, &recording, observe)?;
    progress.finish();
    let seconds = start.elapsed().as_secs_f64();
    let files = &args.files;
    save(
        &files.output,
        &refined.mesh,
        files.options.textures,
        files.options.quiet,
    )?;
    if let Some(path) = &args.control {
        save(
            path,
            &refined.control,
            files.options.textures,
            files.options.quiet,
        )?;
    }
    let mut report = report(args, &opened, &refined, seconds, &flow);
    let refused = refused.into_iter().map(|change| change.text);
    let warning = |text| Warning::ChangeRefused { text };
    report.warnings.extend(refused.map(warning));
    report.distances = reference.and_then(|r| distances(&refined.mesh, &r.mesh));
    if let Some(path) = &args.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if let Some(path) = &args.trace {
        write_text(path, trace.text())?;
    }
    if args.files.options.quiet {
        Ok(())
    } else {
        summary(&report)
    }
}

fn report<'a>(
    args: &RefineArguments,
    opened: &'a Opened,
    refined: &'a Refined,
    seconds: f64,
    flow: &FlowOptions,
) -> RefineReport<'a> {
    let (mesh, given) = (&refined.mesh, &opened.mesh);
    let bits = |m: &Mesh| -> Vec<[u64; 3]> {
        let first = m.positions.iter().take(given.vertex_count());
        first.map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    let (own, of_input) = (faults(mesh), faults(given));
    let levels = refined.levels.iter();
    let mut warnings: Warnings = levels.flat_map(|l| l.warnings.iter().cloned()).collect();
    if own.0 > of_input.0 {
        let (pairs, of_input) = (own.0, of_input.0);
        warnings.push(Warning::IntersectingResult { pairs, of_input });
    }
    RefineReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.files.input.display().to_string(),
        output: args.files.output.display().to_string(),
        method: args.controls.0.method.name().into(),
        energy: flow.energy.text().to_owned(),
        parameters: flow.energy.params().clone(),
        tension: flow.tension,
        load: &opened.report,
        levels: &refined.levels,
        vertices: mesh.vertex_count(),
        faces: mesh.face_count(),
        converged: refined.levels.iter().all(|l| l.converged),
        input_kept: bits(mesh) == bits(given),
        self_intersections: own.0,
        self_intersections_of_input: of_input.0,
        folded_edges: own.1,
        folded_edges_of_input: of_input.1,
        distances: None,
        seconds,
        peak_memory: peak_memory(),
        warnings,
    }
}

/// Pairs of intersecting triangles and folded edges.
fn faults(mesh: &Mesh) -> (usize, usize) {
    let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    let pairs = self_intersections(&mesh.positions, &triangles, None, MAX_INTERSECTIONS);
    let folds = folded_edges(&mesh.positions, &mesh.topology, FOLD_DEGREES.to_radians());
    (pairs.len(), folds.len())
}

fn summary(report: &RefineReport<'_>) -> Result<()> {
    for l in report.levels {
        print_warnings(&format!("level {}: ", l.level), l.warnings.iter());
    }
    let is_new = |w: &&Warning| !report.levels.iter().any(|l| l.warnings.contains(w));
    print_warnings("", report.warnings.iter().filter(is_new));
    let mut text = String::new();
    for l in report.levels {
        writeln!(
            text,
            "level {}: {} vertices, energy {:.6e}, {} steps, {}, {:.2} s, peak memory {} MiB",
            l.level,
            l.vertices,
            l.energy_end,
            l.steps,
            l.end_name(),
            l.seconds,
            l.peak_memory >> 20
        )?;
    }
    if let Some(d) = &report.distances {
        writeln!(
            text,
            "distance to the reference: RMS {:.4e}, maximum {:.4e}",
            d.rms, d.max
        )?;
    }
    writeln!(
        text,
        "{}: {} vertices and {} faces in {:.2} s",
        report.output, report.vertices, report.faces, report.seconds
    )?;
    print(&text)
}
