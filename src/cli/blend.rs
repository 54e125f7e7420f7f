//! `meniscus blend`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;

use crate::cli::flow::{FileOptions, FlowArguments, FlowCommand, LoopArguments, MeshFiles};
use crate::cli::report::skipped;
use crate::mesh::{BoundaryLoop, LoopId, boundary_loops};
use crate::ops::{BlendSpec, FlipSpec};

/// `meniscus blend`.
#[derive(Debug, Args)]
pub struct BlendArguments {
    /// The mesh to read (.obj, .ply, .stl, .off, .glb, .gltf, .3mf). Several are joined into one mesh.
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// The mesh to write (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// How they are read and written.
    #[command(flatten)]
    pub options: FileOptions,
    /// The loops to join.
    #[command(flatten)]
    pub loops: LoopArguments,
    /// Flip the faces of this loop's component first (repeatable).
    #[arg(long, value_name = "LOOP")]
    pub flip: Vec<LoopId>,
    /// The flow and the output.
    #[command(flatten)]
    pub flow: FlowArguments,
}

/// Runs `meniscus blend`.
pub fn blend(args: &BlendArguments) -> Result<()> {
    let Some((input, more)) = args.inputs.split_first() else {
        unreachable!("an argument is required");
    };
    let files = MeshFiles {
        input: input.clone(),
        more: more.to_vec(),
        output: args.output.clone(),
        options: args.options.clone(),
    };
    let mut task = FlowCommand::new(&files, &args.flow)?;
    if !args.flip.is_empty() {
        let flip = FlipSpec {
            loops: args.flip.clone(),
        };
        task.opened.mesh = flip.run(&task.opened.mesh)?;
    }
    let mesh = &task.opened.mesh;
    let loops = boundary_loops(mesh);
    let mut chosen = args.loops.chosen(mesh, &loops)?;
    let is_auto = args.loops.are_auto();
    if is_auto && chosen.len() < 2 && is_one_each(&loops) {
        // no component has two loops, so `auto` can only mean all of them
        chosen = loops.iter().map(|l| l.id).collect();
    }
    if chosen.len() < 2 {
        bail!(
            "a blend joins at least two loops, and {} of {} {} chosen; name them with --loops or \
             --loop-at (`meniscus info` lists them)",
            chosen.len(),
            loops.len(),
            if chosen.len() == 1 { "is" } else { "are" }
        );
    }
    let rims = chosen.iter().map(|id| &loops[id.index()]).collect();
    let open = skipped(&loops, &chosen, |l| args.loops.reason_to_skip(l));
    let spec = BlendSpec {
        loops: chosen,
        flow: task.flow.clone(),
    };
    let written = task.fill(&[rims], open, |mesh| spec.prepare(mesh))?;
    written.conclude(args.options.quiet)
}

/// Whether the loops lie on different components.
fn is_one_each(loops: &[BoundaryLoop]) -> bool {
    let mut components: Vec<u32> = loops.iter().map(|l| l.component).collect();
    components.sort_unstable();
    components.windows(2).all(|pair| pair[0] != pair[1])
}
