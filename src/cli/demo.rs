//! `meniscus demo`: the main job on a built-in sample.

use anyhow::{Context, Result};
use clap::Parser;

use crate::cli::args::{Arguments, Command, DemoArguments};
use crate::cli::fill;
use crate::cli::print::print;
use crate::io::save_mesh;
use crate::mesh::{Mesh, Topology};
use crate::shapes;

/// Writes the sample, fills it from its file, writes the result and the report.
pub fn demo(args: &DemoArguments) -> Result<()> {
    std::fs::create_dir_all(&args.out)
        .with_context(|| format!("cannot make the folder {}", args.out.display()))?;
    let (positions, triangles) = shapes::demo();
    let topology = Topology::from_triangles(positions.len(), &triangles)?;
    let holed = args.out.join("holed.obj");
    save_mesh(&holed, &Mesh::new(positions, topology), &[])?;
    let mut words: Vec<std::ffi::OsString> = vec!["meniscus".into(), "fill".into()];
    words.push(holed.clone().into());
    words.extend(["-o".into(), args.out.join("filled.obj").into()]);
    words.extend(["--report".into(), args.out.join("report.json").into()]);
    if args.quiet {
        words.push("--quiet".into());
    } else {
        print(&format!("{}: the sample with its holes\n", holed.display()))?;
    }
    let Some(Command::Fill(command)) = Arguments::try_parse_from(words)?.command else {
        unreachable!("the words above are a fill command");
    };
    fill::fill(&command)
}
