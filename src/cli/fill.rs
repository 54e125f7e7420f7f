//! `meniscus fill`.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::cli::UsageError;
use crate::cli::args::{FillArguments, LinearArgument, ModeArgument, SchemeArgument, TauArgument};
use crate::cli::memory::peak_memory;
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::report::{FailedHole, FillReport, hole_reports, skipped, totals, trace};
use crate::fill::{
    FillOptions, Filled, Gap, LoopChoice, choose, fill_gaps, nearest_loop, with_islands,
};
use crate::io::{self, Opened, open};
use crate::mesh::{BoundaryLoop, Mesh, boundary_loops};
use crate::patch::PatchOptions;
use crate::solver::energy::{Energy, ExprError};
use crate::solver::{FlowOptions, LinearSolver, Mode, Scheme, Tau};

/// Runs the command.
pub fn fill(args: &FillArguments) -> Result<()> {
    let (options, opened) = start(args)?;
    fill_opened(args, &options, &opened, Task::Holes)
}

/// Everything before the work: options, targets, the mesh.
pub fn start(args: &FillArguments) -> Result<(FillOptions, Opened)> {
    let options = options(args)?;
    check_targets(args)?;
    // the pool's threads start while the file is read
    rayon::spawn(|| ());
    Ok((options, open(&args.input)?))
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
    fn gaps<'a>(
        self,
        args: &FillArguments,
        mesh: &Mesh,
        loops: &'a [BoundaryLoop],
        chosen: &[usize],
    ) -> Result<Vec<Gap<'a>>> {
        let rims: Gap<'a> = chosen.iter().map(|&i| &loops[i]).collect();
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

/// Finds out before the work whether its results can be written, and over nothing that is needed.
fn check_targets(args: &FillArguments) -> Result<()> {
    let input = ("IN", args.input.as_path());
    let mut taken = vec![input];
    let records = [("--report", &args.report), ("--trace", &args.trace)];
    let records = records
        .iter()
        .filter_map(|&(name, path)| Some((name, path.as_deref()?)));
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
pub fn fill_opened(
    args: &FillArguments,
    options: &FillOptions,
    opened: &Opened,
    task: Task,
) -> Result<()> {
    let mesh = &opened.mesh;
    let loops = boundary_loops(mesh);
    let chosen = chosen_loops(args, opened, &loops)?;
    let auto = args.loop_at.is_empty() && args.loops == LoopChoice::Auto;
    let gaps = task.gaps(args, mesh, &loops, &chosen)?;
    let joined: Vec<usize> = gaps.iter().flatten().map(|l| l.number - 1).collect();
    let skipped = skipped(&loops, &joined, auto);
    if !args.quiet {
        for note in &opened.report.notes {
            eprintln!("{}: {note}", args.input.display());
        }
        for s in &skipped {
            eprintln!(
                "loop {} ({} edges) left open: {}",
                s.number, s.edges, s.reason
            );
        }
        if chosen.is_empty() {
            eprintln!("{}", nothing_to_do(loops.len()));
        }
    }
    let progress = Progress::new(gaps.len(), args.quiet);
    let filled = fill_gaps(mesh, &gaps, options, &|group, record| {
        progress.step(group, record);
        true
    })?;
    progress.finish();

    io::save_mesh(&args.output, &filled.mesh, &opened.material_libraries)?;
    write_records(args, opened, &filled, skipped)
}

pub fn write_records(
    args: &FillArguments,
    opened: &Opened,
    filled: &Filled,
    skipped: Vec<crate::cli::report::SkippedLoop>,
) -> Result<()> {
    let holes = hole_reports(filled);
    let failed: Vec<FailedHole> = filled
        .plan
        .failed
        .iter()
        .map(|e| FailedHole {
            number: e.hole().unwrap_or(0),
            reason: e.to_string(),
        })
        .collect();
    let report = FillReport {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        output: args.output.display().to_string(),
        energy: args.energy.clone(),
        scheme: name(&args.scheme),
        mode: name(&args.mode),
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
    if let Some((group, error)) = filled
        .groups
        .iter()
        .enumerate()
        .find_map(|(g, r)| r.as_ref().err().map(|e| (g, e)))
    {
        let number = filled.plan.holes[filled.plan.groups[group].holes[0]].number;
        bail!(
            "hole {number}: {error}. {} was written with the first patch there",
            args.output.display()
        );
    }
    Ok(())
}

fn summary(report: &FillReport<'_>) -> Result<()> {
    for hole in &report.holes {
        for warning in &hole.warnings {
            eprintln!("hole {}: {warning}", hole.number);
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

/// A choice as it is written on the command line.
fn name(choice: &impl ValueEnum) -> String {
    choice
        .to_possible_value()
        .map_or_else(String::new, |v| v.get_name().to_owned())
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
) -> Result<Vec<usize>> {
    if args.loop_at.is_empty() {
        return Ok(choose(loops, &args.loops)?);
    }
    let mut chosen = Vec::new();
    for &point in &args.loop_at {
        let Some(i) = nearest_loop(&opened.mesh, loops, point) else {
            bail!("--loop-at: the mesh has no boundary loop");
        };
        chosen.push(i);
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

fn options(args: &FillArguments) -> Result<FillOptions> {
    let params: BTreeMap<String, f64> = args.param.iter().cloned().collect();
    let energy = Energy::parse(&args.energy, &params).map_err(|e| expression_error(&e))?;
    let mut flow = FlowOptions::new(energy);
    flow.scheme = match args.scheme {
        SchemeArgument::Normal => Scheme::Normal,
        SchemeArgument::Mixed => Scheme::Mixed,
        SchemeArgument::MixedCorrected => Scheme::MixedCorrected,
    };
    flow.mode = match args.mode {
        ModeArgument::Fast => Mode::Fast,
        ModeArgument::Flow => Mode::Flow,
    };
    flow.linear = match args.linear {
        LinearArgument::Gmres => LinearSolver::default(),
        LinearArgument::Lu => LinearSolver::Lu,
    };
    flow.tau = match args.tau {
        TauArgument::Auto => Tau::Auto,
        TauArgument::Fixed(t) => Tau::Fixed(t),
    };
    flow.max_steps = args.steps;
    Ok(FillOptions {
        patch: PatchOptions {
            density: args.density,
        },
        flow,
        ..FillOptions::default()
    })
}

fn expression_error(error: &ExprError) -> anyhow::Error {
    UsageError(format!("--energy\n{}", error.render())).into()
}

pub fn write_text(path: &Path, text: &str) -> Result<()> {
    Ok(io::save_text(path, text)?)
}
