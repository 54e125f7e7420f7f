//! `meniscus fill`.

use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::cli::UsageError;
use crate::cli::args::FillArguments;
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::report::{
    FailedHole, FillReport, SkippedLoop, hole_reports, skipped, totals, trace,
};
use crate::fill::{
    Choice, Continuity, Controls, ControlsError, Filled, LoopChoice, RimSet, Schedule,
    ScheduledOptions, choose, fill_part, fill_rim_sets, nearest_loop, with_islands,
};
use crate::io::{self, Opened, open};
use crate::memory::peak_memory;
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, VertexId, boundary_loops};

/// Runs the command.
pub fn fill(args: &FillArguments) -> Result<()> {
    let start = start(args)?;
    match args.part[..] {
        [from, to] => part(args, &start, from, to),
        _ => fill_opened(args, &start, Task::Holes),
    }
}

/// Fills part of a hole.
fn part(args: &FillArguments, start: &Start, from: DVec3, to: DVec3) -> Result<()> {
    let mesh = &start.opened.mesh;
    let loops = boundary_loops(mesh);
    let Some(hole) = nearest_loop(mesh, &loops, from).map(|id| &loops[id.index()]) else {
        bail!("--part: the mesh has no boundary loop");
    };
    let [from, to] = [from, to].map(|point| nearest_index(mesh, hole, point));
    let n = hole.edges();
    // the shorter way
    let [from, to] = if (to + n - from) % n <= n / 2 {
        [from, to]
    } else {
        [to, from]
    };
    let progress = Progress::new(1, args.quiet);
    let options = start.controls.options()?;
    let filled = fill_part(mesh, hole, from, to, &options, &|group, record| {
        progress.step(group, record);
        true
    })?;
    progress.finish();
    save_filled(args, &start.opened, &filled, Vec::new(), Vec::new())
}

/// Index along the loop of the vertex nearest to a point.
fn nearest_index(mesh: &Mesh, hole: &BoundaryLoop, point: DVec3) -> usize {
    let distance = |i: &usize| mesh.position(hole.vertices[*i]).distance_squared(point);
    (0..hole.edges())
        .min_by(|i, j| distance(i).total_cmp(&distance(j)))
        .unwrap_or(0)
}

/// What is known before the work.
pub struct Start {
    /// The controls to start with, found to be valid.
    pub controls: Controls,
    /// What is changed on the way.
    pub schedule: Schedule,
    /// The mesh.
    pub opened: Opened,
}

/// Everything before the work: controls, targets, the mesh.
pub fn start(args: &FillArguments) -> Result<Start> {
    let controls = args.controls.controls();
    controls.options().map_err(|e| mistaken(&e))?;
    args.picture.check()?;
    check_targets(args)?;
    let schedule = schedule(args, &controls)?;
    // the pool's threads start while the file is read
    rayon::spawn(|| ());
    Ok(Start {
        controls,
        schedule,
        opened: open(&args.input)?,
    })
}

/// What to do with the loops chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Fill each.
    Holes,
    /// Join them all by one surface.
    Blend,
}

impl Task {
    fn rim_sets<'a>(
        self,
        args: &FillArguments,
        mesh: &Mesh,
        loops: &'a [BoundaryLoop],
        chosen: &[LoopId],
    ) -> Result<Vec<RimSet<'a>>> {
        let rims: RimSet<'a> = chosen.iter().map(|id| &loops[id.index()]).collect();
        match self {
            Self::Holes if args.no_islands => Ok(rims.into_iter().map(|rim| vec![rim]).collect()),
            Self::Holes => Ok(with_islands(mesh, loops, chosen)),
            Self::Blend if rims.len() > 1 => Ok(vec![rims]),
            Self::Blend => bail!(
                "a blend joins at least two loops, and {} of {} {} chosen; name them with --loops or \
                 --loop-at (`meniscus info` lists them)",
                rims.len(),
                loops.len(),
                if rims.len() == 1 { "is" } else { "are" }
            ),
        }
    }
}

/// The schedule asked for, found to be one that can be followed.
fn schedule(args: &FillArguments, controls: &Controls) -> Result<Schedule> {
    let Some(path) = &args.schedule else {
        return Ok(Schedule::default());
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the schedule {}", path.display()))?;
    let schedule = Schedule::parse(&text);
    let checked = schedule.and_then(|s| s.check(controls).map(|()| s));
    checked.map_err(|error| UsageError(format!("{}: {error}", path.display())).into())
}

/// Finds out before the work whether its results can be written, and over nothing that is needed.
fn check_targets(args: &FillArguments) -> Result<()> {
    let mut taken = vec![("IN", args.input.as_path())];
    taken.extend(args.schedule.as_deref().map(|path| ("--schedule", path)));
    let records = [
        ("--report", args.report.as_deref()),
        ("--trace", args.trace.as_deref()),
        ("--picture", args.picture.path()),
    ];
    let records = records
        .into_iter()
        .filter_map(|(name, path)| Some((name, path?)));
    for (name, path) in [("OUT", args.output.as_path())].into_iter().chain(records) {
        for &(other, at) in &taken {
            if io::same_file(path, at) {
                bail!(
                    "{name} is the same file as {other} ({}); give another name, nothing was \
                     overwritten",
                    path.display()
                );
            }
        }
        taken.push((name, path));
        if name == "OUT" {
            io::check_target(path)?;
        } else {
            io::check_text_target(path)?;
        }
    }
    Ok(())
}

/// Fills an opened mesh and writes everything asked for.
pub fn fill_opened(args: &FillArguments, start: &Start, task: Task) -> Result<()> {
    let Start {
        controls,
        schedule,
        opened,
    } = start;
    let mesh = &opened.mesh;
    let loops = boundary_loops(mesh);
    let mut chosen = chosen_loops(args, opened, &loops)?;
    let auto = args.loop_at.is_empty() && args.loops == LoopChoice::Auto;
    if auto && task == Task::Blend && chosen.len() < 2 && is_one_each(&loops) {
        // wherever they look, nothing else can be meant
        chosen = loops.iter().map(|l| l.id).collect();
    }
    let rim_sets = task.rim_sets(args, mesh, &loops, &chosen)?;
    let joined: Vec<LoopId> = rim_sets.iter().flatten().map(|l| l.id).collect();
    let skipped = skipped(&loops, &joined, auto);
    if !args.quiet {
        for note in &opened.report.notes {
            eprintln!("{}: {note}", args.input.display());
        }
        for s in &skipped {
            eprintln!("loop {} ({} edges) left open: {}", s.id, s.edges, s.reason);
        }
        if chosen.is_empty() {
            eprintln!("{}", nothing_to_do(loops.len()));
        }
    }
    let progress = Progress::new(rim_sets.len(), args.quiet);
    let options = ScheduledOptions::new(controls, schedule)?;
    let filled = fill_rim_sets(mesh, &rim_sets, options, &|group, record| {
        progress.step(group, record);
        true
    })?;
    progress.finish();
    // rims joined without continuous normals are drawn from either side by itself
    let sharp = rim_sets
        .iter()
        .flatten()
        .filter(|l| controls.continuity_at(l.id) == Continuity::G0);
    let creases = sharp.flat_map(|l| l.edge_ends()).collect();
    save_filled(args, opened, &filled, skipped, creases)
}

/// Writes the mesh and everything else asked for, and says what was done. `creases` are the edges
/// of rims that a picture shows from either side by itself.
pub fn save_filled(
    args: &FillArguments,
    opened: &Opened,
    filled: &Filled,
    skipped: Vec<SkippedLoop>,
    creases: Vec<[VertexId; 2]>,
) -> Result<()> {
    io::save_mesh(&args.output, &filled.mesh, &opened.material_libraries)?;
    let first = filled.mesh.face_count() - filled.faces_added();
    args.picture.save(&filled.mesh, first, creases)?;
    let holes = hole_reports(filled);
    let failed: Vec<FailedHole> = filled
        .failed
        .iter()
        .filter_map(|e| {
            let reason = e.to_string();
            e.hole().map(|id| FailedHole { id, reason })
        })
        .collect();
    let report = FillReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        output: args.output.display().to_string(),
        energy: args.controls.energy.clone(),
        scheme: args.controls.scheme.name(),
        mode: args.controls.mode.name(),
        load: &opened.report,
        totals: totals(filled, &holes),
        holes,
        failed,
        skipped,
        peak_memory: peak_memory(),
    };
    if let Some(path) = &args.report {
        let mut text = serde_json::to_string_pretty(&report)?;
        text.push('\n');
        write_text(path, &text)?;
    }
    if let Some(path) = &args.trace {
        write_text(path, &trace(filled))?;
    }
    if !args.quiet {
        summary(&report)?;
    }
    if let Some(first) = report.failed.first() {
        bail!(
            "{} of {} holes could not be filled; {} was written with the others. First: {}",
            report.failed.len(),
            report.failed.len() + report.holes.len(),
            args.output.display(),
            first.reason
        );
    }
    let mut groups = filled.groups.iter().enumerate();
    let failed = groups.find_map(|(g, r)| Some((filled.first_hole(g)?.id(), r.as_ref().err()?)));
    if let Some((id, error)) = failed {
        bail!(
            "hole {id}: {error}. {} was written with the first patch there",
            args.output.display()
        );
    }
    Ok(())
}

fn summary(report: &FillReport<'_>) -> Result<()> {
    for hole in &report.holes {
        for warning in &hole.warnings {
            eprintln!("hole {}: {warning}", hole.id);
        }
    }
    let t = &report.totals;
    print(&format!(
        "{}: {} {} filled, {} vertices and {} faces added in {:.2} s\n",
        report.output,
        t.holes,
        if t.holes == 1 { "hole" } else { "holes" },
        t.vertices_added,
        t.faces_added,
        t.seconds
    ))
}

/// Whether no component has two of the loops.
fn is_one_each(loops: &[BoundaryLoop]) -> bool {
    let mut components: Vec<u32> = loops.iter().map(|l| l.component).collect();
    components.sort_unstable();
    components.windows(2).all(|pair| pair[0] != pair[1])
}

fn nothing_to_do(loops: usize) -> String {
    if loops == 0 {
        "no boundary loops: the mesh is closed and is written as it is".into()
    } else {
        format!(
            "nothing to fill: all {loops} boundary loops look like outer rims (choose some with \
             --loops or --loop-at); the mesh is written as it is"
        )
    }
}

fn chosen_loops(
    args: &FillArguments,
    opened: &Opened,
    loops: &[BoundaryLoop],
) -> Result<Vec<LoopId>> {
    if args.loop_at.is_empty() {
        return Ok(choose(loops, &args.loops)?);
    }
    let mut chosen = Vec::new();
    for &point in &args.loop_at {
        let Some(id) = nearest_loop(&opened.mesh, loops, point) else {
            bail!("--loop-at: the mesh has no boundary loop");
        };
        chosen.push(id);
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// Controls that the grammar lets through but that are none.
fn mistaken(error: &ControlsError) -> anyhow::Error {
    let text = match error.expression() {
        Some(expression) => format!("--energy\n{}", expression.render()),
        None => error.to_string(),
    };
    UsageError(text).into()
}

pub fn write_text(path: &Path, text: &str) -> Result<()> {
    Ok(io::save_text(path, text)?)
}
