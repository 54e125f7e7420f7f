//! `meniscus fill`.

use anyhow::Result;
use clap::Args;

use crate::cli::flow::{FlowArguments, LoopArguments, MeshFiles, Task};
use crate::cli::parse::point;
use crate::cli::progress::Progress;
use crate::cli::report::skipped;
use crate::mesh::{DVec3, LoopId, boundary_loops};
use crate::ops::{FillPartSpec, FillSpec, Operation, Outcome};

/// `meniscus fill`.
#[derive(Debug, Args)]
pub struct FillArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: MeshFiles,
    /// Which loops.
    #[command(flatten)]
    pub loops: LoopArguments,
    /// Fill only part of one hole: along its rim from the vertex nearest to the first point to the
    /// one nearest to the second, the shorter way. A later fill does the rest.
    #[arg(
        long,
        num_args = 2,
        value_names = ["X,Y,Z", "X,Y,Z"],
        value_parser = point,
        allow_hyphen_values = true,
        conflicts_with_all = ["loops", "loop_at", "schedule"]
    )]
    pub part: Vec<DVec3>,
    /// Fill holes as if no loose pieces lay in them; without it patches pass through the rims of
    /// islands.
    #[arg(long)]
    pub no_islands: bool,
    /// The flow and what is written.
    #[command(flatten)]
    pub flow: FlowArguments,
}

/// Runs the command.
pub fn fill(args: &FillArguments) -> Result<()> {
    let task = Task::new(&args.files, &args.flow)?;
    let mesh = &task.opened.mesh;
    if let [from, to] = args.part[..] {
        let progress = Progress::new(1, args.files.quiet);
        let operation = Operation::FillPart(FillPartSpec {
            ends: [from, to],
            controls: task.flow.controls.clone(),
        });
        let outcome = operation.run(mesh, &|group, record| {
            progress.step(group, record);
            true
        })?;
        progress.finish();
        let Outcome::Filled(filled) = outcome else {
            unreachable!("part of a hole is filled");
        };
        return task.save(&filled, Vec::new(), Vec::new());
    }
    let loops = boundary_loops(mesh);
    let chosen = args.loops.chosen(mesh, &loops)?;
    let spec = FillSpec {
        loops: chosen,
        islands: !args.no_islands,
        flow: task.flow.clone(),
    };
    let rim_sets = spec.rim_sets(mesh, &loops)?;
    let joined: Vec<LoopId> = rim_sets.iter().flatten().map(|l| l.id).collect();
    task.fill(&rim_sets, skipped(&loops, &joined, args.loops.are_auto()))
}
