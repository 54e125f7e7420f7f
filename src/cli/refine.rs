//! `meniscus refine`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::ValueEnum;
use serde::Serialize;

use crate::analysis::{Distances, distances};
use crate::cli::UsageError;
use crate::cli::fill::write_text;
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::refine_args::RefineArguments;
use crate::energy::Energy;
use crate::fill::TauChoice;
use crate::io::{self, Opened, open, save_mesh};
use crate::memory::peak_memory;
use crate::mesh::{LoadReport, Mesh, folded_edges, self_intersections};
use crate::refine::{self, LevelReport, RefineOptions, Refinement, natural_flow};
use crate::solver::{FlowOptions, Tau};

/// Intersecting pairs counted at most.
const MOST_INTERSECTIONS: usize = 1000;
/// An edge is folded where its faces' normals differ by more than this, in degrees.
const FOLDED: f64 = 150.0;

/// What a refinement did.
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
    /// Whether the vertices of the input are where they were, to the bit.
    input_kept: bool,
    /// Pairs of intersecting triangles of the result (at most 1000), and of the input.
    self_intersections: usize,
    self_intersections_of_input: usize,
    /// Edges of the result at which it turns by more than 150 degrees, and of the input.
    folded_edges: usize,
    folded_edges_of_input: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    distances: Option<Distances>,
    seconds: f64,
    peak_memory: u64,
    warnings: Vec<String>,
}

/// Runs the command.
pub fn refine(args: &RefineArguments) -> Result<()> {
    check_targets(args)?;
    let typed = typed(args)?;
    let creases = args.creases.edges()?;
    let opened = open(&args.input)?;
    let reference = args.against.as_deref().map(open).transpose()?;
    let flow = flow(args, typed, &opened.mesh);
    let options = options(args, flow.clone(), creases, &opened.mesh)?;
    let start = Instant::now();
    let progress = Progress::new(1, args.quiet);
    let mut trace = String::from("level,step,tau,energy,residual,rejected\n");
    let mesh = Arc::new(opened.mesh.clone());
    let refined = Refinement::new(mesh, options)?.run(|state, event| {
        if let refine::Progress::Step(record) = event {
            progress.step(state.level(), record);
            // a String takes everything
            let _ = writeln!(
                trace,
                "{},{},{:e},{:e},{:e},{}",
                state.level(),
                record.step,
                record.tau,
                record.energy,
                record.residual,
                u8::from(record.rejected)
            );
        }
        true
    })?;
    progress.finish();
    let seconds = start.elapsed().as_secs_f64();
    save_mesh(&args.output, &refined.mesh, &opened.material_libraries)?;
    if let Some(path) = &args.control {
        save_mesh(path, &refined.control, &opened.material_libraries)?;
    }
    let mut report = report(args, &opened, &refined, seconds, &flow);
    report.distances = reference.and_then(|r| distances(&refined.mesh, &r.mesh));
    if let Some(path) = &args.report {
        write_text(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if let Some(path) = &args.trace {
        write_text(path, &trace)?;
    }
    if args.quiet { Ok(()) } else { summary(&report) }
}

fn report<'a>(
    args: &RefineArguments,
    opened: &'a Opened,
    refined: &'a refine::Refined,
    seconds: f64,
    flow: &FlowOptions,
) -> RefineReport<'a> {
    let (mesh, given) = (&refined.mesh, &opened.mesh);
    let bits = |m: &Mesh| -> Vec<[u64; 3]> {
        let first = m.positions.iter().take(given.vertex_count());
        first.map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    let (own, of_input) = (faults(mesh), faults(given));
    let mut warnings: Vec<String> = refined
        .levels
        .iter()
        .flat_map(|l| l.warnings.iter().map(|w| format!("level {}: {w}", l.level)))
        .collect();
    if own.0 > of_input.0 {
        warnings.push(format!(
            "the result has {} pairs of intersecting triangles, the input {}: two sheets of the \
             coarse mesh are too near to each other for a smooth surface through its vertices \
             (try more --tension)",
            own.0, of_input.0
        ));
    }
    RefineReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        output: args.output.display().to_string(),
        method: name(&args.method),
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
    let pairs = self_intersections(&mesh.positions, &triangles, None, MOST_INTERSECTIONS);
    let folds = folded_edges(&mesh.positions, &mesh.topology, FOLDED.to_radians());
    (pairs.len(), folds.len())
}

fn summary(report: &RefineReport<'_>) -> Result<()> {
    for warning in &report.warnings {
        eprintln!("{warning}");
    }
    let mut text = String::new();
    for l in report.levels {
        writeln!(
            text,
            "level {}: {} vertices, energy {:.6e}, {} steps, {}, {:.2} s, peak memory {} MiB",
            l.level,
            l.vertices,
            l.energy_end,
            l.steps,
            l.end,
            l.seconds,
            l.peak_memory >> 20
        )?;
    }
    if let Some(d) = &report.distances {
        writeln!(
            text,
            "distance to the reference: RMS {:.4e}, largest {:.4e}",
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

fn check_targets(args: &RefineArguments) -> Result<()> {
    let mut taken: Vec<(&str, &Path)> = vec![("IN", &args.input)];
    if let Some(path) = &args.against {
        taken.push(("--against", path));
    }
    let meshes = [
        ("OUT", Some(&args.output)),
        ("--control", args.control.as_ref()),
    ];
    let texts = [
        ("--report", args.report.as_ref()),
        ("--trace", args.trace.as_ref()),
    ];
    for (is_mesh, (name, path)) in
        (meshes.map(|m| (true, m)).into_iter()).chain(texts.map(|t| (false, t)))
    {
        let Some(path) = path else { continue };
        if let Some((other, _)) = taken.iter().find(|(_, p)| io::same_file(path, p)) {
            bail!(
                "{name} is the same file as {other} ({}); give another name, nothing was overwritten",
                path.display()
            );
        }
        taken.push((name, path));
        if is_mesh {
            io::check_target(path)?;
        } else {
            io::check_text_target(path)?;
        }
    }
    Ok(())
}

/// The energy asked for, if one was.
fn typed(args: &RefineArguments) -> Result<Option<Energy>> {
    let params: BTreeMap<String, f64> = args.param.iter().cloned().collect();
    let parse = |text: &str| {
        Energy::parse(text, &params)
            .map_err(|e| UsageError(format!("--energy\n{}", e.render())).into())
    };
    args.energy.as_deref().map(parse).transpose()
}

fn flow(args: &RefineArguments, typed: Option<Energy>, mesh: &Mesh) -> FlowOptions {
    let (energy, tension) = match typed {
        Some(energy) => (energy, 0.0),
        None => natural_flow(mesh),
    };
    let mut flow = FlowOptions::new(energy);
    flow.tension = args.tension.unwrap_or(tension);
    flow.mode = args.mode;
    flow.tau = match args.tau {
        TauChoice::Auto => Tau::Auto,
        TauChoice::Fixed(tau) => Tau::Fixed(tau),
    };
    flow.max_steps = args.steps;
    flow
}

fn options(
    args: &RefineArguments,
    flow: FlowOptions,
    creases: Vec<[u32; 2]>,
    mesh: &Mesh,
) -> Result<RefineOptions> {
    let selection = &args.selection;
    let region = (!selection.is_empty())
        .then(|| selection.flags(mesh))
        .transpose()?;
    Ok(RefineOptions {
        levels: args.levels,
        method: args.method.into(),
        hold: args.hold.into(),
        boundary: args.boundary.into(),
        corner_angle: args.corner_angle.to_radians(),
        crease_angle: args.creases.crease_angle.map(f64::to_radians),
        creases,
        region,
        flow,
    })
}

/// A choice as it is written on the command line.
fn name(choice: &impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map_or_else(String::new, |v| v.get_name().to_owned())
}
