//! `meniscus fill`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::cli::UsageError;
use crate::cli::flow::{
    FileOptions, FlowArguments, FlowCommand, LoopArguments, MeshFiles, Written,
};
use crate::cli::options::OptionArguments;
use crate::cli::parse::point;
use crate::cli::report::skipped;
use crate::cli::selection::listed_faces;
use crate::cli::side_by_side::Place;
use crate::fill::LoopLimits;
use crate::mesh::{BoundaryLoop, DVec3, LoopId, boundary_loops};
use crate::ops::{FillPartSpec, FillSpec, OperationError};

/// The files of `meniscus fill`.
#[derive(Debug, Args)]
pub struct FillFiles {
    /// The mesh to read (.obj, .ply, .stl, .off, .glb, .gltf, .3mf). Several need --out-dir or --join.
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// The mesh to write (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(
        short,
        long,
        value_name = "OUT",
        required_unless_present = "out_dir",
        conflicts_with = "out_dir"
    )]
    pub output: Option<PathBuf>,
    /// Fill each IN and write it under its name to this folder. It is created if it does not exist.
    #[arg(long, value_name = "FOLDER")]
    pub out_dir: Option<PathBuf>,
    /// Join all IN into one mesh and fill it.
    #[arg(long, conflicts_with = "out_dir")]
    pub join: bool,
    /// How they are read and written.
    #[command(flatten)]
    pub options: FileOptions,
}

/// `meniscus fill`.
#[derive(Debug, Args)]
pub struct FillArguments {
    /// Input and output.
    #[command(flatten)]
    pub files: FillFiles,
    /// The loops to fill.
    #[command(flatten)]
    pub loops: LoopArguments,
    /// Limits above which loops are left open.
    #[command(flatten)]
    pub limits: OptionArguments<LoopLimits>,
    /// Fill only part of one hole: the shorter segment of its rim between the vertices nearest to
    /// these points. A later fill closes the rest.
    #[arg(
        long,
        num_args = 2,
        value_names = ["X,Y,Z", "X,Y,Z"],
        value_parser = point,
        allow_hyphen_values = true,
        conflicts_with_all = [
            "loops", "loop_at", "max-edges", "max-perimeter", "max-diameter"
        ]
    )]
    pub part: Vec<DVec3>,
    /// These triangles of IN are the strips of bridges, as in 801-840: they flow with the patches of the
    /// holes beside them, and only divide the holes. `meniscus bridge` prints their numbers.
    #[arg(long, value_name = "LIST", conflicts_with = "part")]
    pub bridge_faces: Option<String>,
    /// Ignore loose components (islands) inside a hole. Without it the patch joins their rims.
    #[arg(long)]
    pub no_islands: bool,
    /// The flow and the output.
    #[command(flatten)]
    pub flow: FlowArguments,
}

impl FillArguments {
    /// # Errors
    /// A limit out of range.
    pub fn check(&self) -> Result<(), UsageError> {
        let limits = self.limits.0.check();
        limits.map_err(|e| UsageError(format!("--{e}")))
    }
}

/// Runs `meniscus fill` on one mesh.
pub fn fill(args: &FillArguments) -> Result<()> {
    let FillFiles {
        inputs,
        output,
        join,
        options,
        ..
    } = &args.files;
    args.check()?;
    let (Some((input, more)), Some(output)) = (inputs.split_first(), output) else {
        unreachable!("the arguments are required");
    };
    if !more.is_empty() && !join {
        let message = "several meshes need --out-dir FOLDER instead of -o OUT, or --join";
        return Err(UsageError(message.into()).into());
    }
    let files = MeshFiles {
        input: input.clone(),
        more: more.to_vec(),
        output: output.clone(),
        options: options.clone(),
    };
    fill_file(args, &files, &args.flow, None)?.conclude(options.quiet)
}

/// Fills one file. `files` and `flow` replace those of the arguments.
pub fn fill_file(
    args: &FillArguments,
    files: &MeshFiles,
    flow: &FlowArguments,
    place: Option<Place<'_>>,
) -> Result<Written> {
    let share = place.map(|place| place.all.memory(files.memory_to_read()));
    let task = FlowCommand::new(files, flow)?.at(place);
    drop(share);
    let mesh = &task.opened.mesh;
    let loops = boundary_loops(mesh);
    if let [from, to] = args.part[..] {
        let spec = FillPartSpec {
            ends: [from, to],
            flow: task.flow.clone(),
        };
        let (hole, _) = (spec.segment(mesh, &loops)).ok_or(OperationError::NoLoops)?;
        return task.fill(&[vec![hole]], Vec::new(), |mesh| spec.prepare(mesh));
    }
    let mut chosen = args.loops.chosen(mesh, &loops)?;
    let limits = if args.loops.are_named() {
        LoopLimits::default()
    } else {
        args.limits.0.clone()
    };
    chosen.retain(|id| limits.exceeded(&loops[id.index()]).is_none());
    let bridges = match &args.bridge_faces {
        Some(list) => listed_faces("--bridge-faces", list, mesh.face_count())?,
        None => Vec::new(),
    };
    let spec = FillSpec {
        loops: chosen,
        bridges: bridges.into(),
        islands: !args.no_islands,
        flow: task.flow.clone(),
    };
    let rim_sets = spec.rim_sets(mesh, &loops)?;
    let joined: Vec<LoopId> = rim_sets.iter().flatten().map(|l| l.id).collect();
    let is_outer = |l: &BoundaryLoop| args.loops.are_auto() && l.is_outer_boundary;
    let reason = |l: &BoundaryLoop| match limits.exceeded(l) {
        Some(reason) if !is_outer(l) => reason,
        _ => args.loops.reason_to_skip(l),
    };
    let skipped = skipped(&loops, &joined, reason);
    task.fill(&rim_sets, skipped, |mesh| {
        spec.prepare_rims(mesh, &rim_sets)
    })
}
