//! `meniscus repair`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;

use crate::cli::flow::{MeshFiles, failed_holes, usage, write_text};
use crate::cli::hints::print_warnings;
use crate::cli::options::OptionArguments;
use crate::cli::print::{print, save, say};
use crate::cli::progress::{Progress, Work};
use crate::cli::report::{FailedHole, HoleReport, hole_reports};
use crate::cli::targets::check_targets;
use crate::fill::{Controls, Filled};
use crate::memory::peak_memory;
use crate::mesh::{
    DVec3, FOLD_DEGREES, LoadReport, Mesh, components, folded_edges, self_intersections,
};
use crate::ops::{CleanSpec, DamageSpec, FlowSpec, Operation, Outcome, Repair};
use crate::warning::{Place, counted};

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
    seconds: f64,
    peak_memory: u64,
}

/// What a mesh has.
#[derive(Serialize)]
struct Condition {
    vertices: usize,
    faces: usize,
    components: usize,
    loops: usize,
    /// Pairs of faces of one component that intersect.
    self_intersections: usize,
    /// Pairs of faces of two components that intersect.
    intersections_of_components: usize,
    folded_edges: usize,
    /// The place of one self-intersection.
    #[serde(skip)]
    place: Option<DVec3>,
}

impl Condition {
    fn of(mesh: &Mesh) -> Self {
        let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
        let parts = components(&mesh.topology);
        let all = self_intersections(&mesh.positions, &triangles, None, usize::MAX);
        let (of_one, of_two): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|&pair| parts.are_joined(pair));
        let middle = |&[f, _]: &[u32; 2]| {
            let corners = triangles[f as usize].map(|v| mesh.positions[v as usize]);
            corners.iter().sum::<DVec3>() / 3.0
        };
        Self {
            vertices: mesh.vertex_count(),
            faces: mesh.face_count(),
            components: parts.count,
            loops: mesh.topology.boundary_loops().len(),
            self_intersections: of_one.len(),
            intersections_of_components: of_two.len(),
            folded_edges: folded_edges(&mesh.positions, &mesh.topology, FOLD_DEGREES.to_radians())
                .len(),
            place: of_one.first().map(middle),
        }
    }

    fn words(&self) -> String {
        let of_two = match self.intersections_of_components {
            0 => String::new(),
            count => format!(" and {count} of two components"),
        };
        format!(
            "{}, {}, {}{of_two}, {}",
            counted(self.components, "component", "components"),
            counted(self.loops, "boundary loop", "boundary loops"),
            pairs(self.self_intersections),
            counted(self.folded_edges, "folded edge", "folded edges"),
        )
    }
}

/// A number of self-intersections in words.
fn pairs(count: usize) -> String {
    counted(
        count,
        "pair of intersecting triangles",
        "pairs of intersecting triangles",
    )
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

impl Step {
    fn words(&self) -> String {
        let erased = counted(self.faces_erased, "face", "faces");
        let holes = counted(self.holes.len(), "hole", "holes");
        let added = counted(self.faces_added, "face", "faces");
        match self.task {
            "clean" => format!("loose parts with {erased} removed"),
            "refill" => format!("{erased} erased at damaged places; {holes} filled with {added}"),
            _ => format!("{holes} filled with {added}"),
        }
    }
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
    while let Some(operation) = repair.next_for(&mesh) {
        let outcome = match run(&operation, &mesh, quiet) {
            Ok(outcome) => outcome,
            Err(error) if !matches!(operation, Operation::Refill(_)) => return Err(error),
            Err(error) => {
                tell(&format!("{}: {error}", operation.command_name()));
                repair.leave_damage();
                continue;
            }
        };
        let filled = match &outcome {
            Outcome::Filled(filled) => Some(&**filled),
            Outcome::Refilled(new) => Some(&new.filled),
            _ => None,
        };
        let faces_added = filled.map_or(0, Filled::faces_added);
        let holes = filled.map_or_else(Vec::new, |filled| hole_reports(filled, &options));
        let failed = filled.map_or_else(Vec::new, failed_holes);
        let next = outcome.into_mesh();
        let step = Step {
            task: operation.command_name(),
            faces_erased: mesh.face_count() + faces_added - next.face_count(),
            faces_added,
            holes,
            failed,
        };
        tell(&step.words());
        if let Operation::Fill(_) = operation {
            for hole in step.holes.iter().filter(|_| !quiet) {
                print_warnings(&format!("hole {}: ", hole.id), hole.warnings.iter());
            }
        }
        steps.push(step);
        mesh = next;
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
            pairs(after.self_intersections),
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
