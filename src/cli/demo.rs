//! `meniscus demo`: the main job on a built-in sample.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;

use crate::cli::fill::{FillArguments, FillFiles, fill};
use crate::cli::flow::{FileOptions, FlowArguments, LoopArguments};
use crate::cli::options::OptionArguments;
use crate::cli::print::{Textures, print};
use crate::io::save_mesh;
use crate::mesh::{Mesh, Weld};
use crate::shapes;

/// `meniscus demo`.
#[derive(Debug, Args)]
pub struct DemoArguments {
    /// The folder to write to. It is created if it does not exist.
    #[arg(long, value_name = "DIR", default_value = "meniscus-demo")]
    pub out: PathBuf,
    /// Print only errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Writes the sample, fills it from its file, writes the result and the report.
pub fn demo(args: &DemoArguments) -> Result<()> {
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot create the folder {}", args.out.display()))?;
    let (positions, triangles) = shapes::demo();
    let holed = args.out.join("holed.obj");
    // OBJ keeps all data of the sample
    save_mesh(&holed, &Mesh::from_triangles(positions, &triangles)?)?;
    if !args.quiet {
        print(&format!("{}: the sample with its holes\n", holed.display()))?;
    }
    fill(&FillArguments {
        bridge_faces: None,
        files: FillFiles {
            inputs: vec![holed],
            output: Some(args.out.join("filled.obj")),
            out_dir: None,
            join: false,
            options: FileOptions {
                weld: Weld::Auto,
                textures: Textures::Keep,
                quiet: args.quiet,
            },
        },
        loops: LoopArguments::default(),
        limits: OptionArguments::default(),
        part: Vec::new(),
        no_islands: false,
        flow: FlowArguments {
            report: Some(args.out.join("report.json")),
            ..FlowArguments::default()
        },
    })
}
