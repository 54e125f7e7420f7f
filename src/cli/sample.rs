//! `meniscus sample`: writes a built-in sample.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;

use crate::cli::UsageError;
use crate::cli::print::print;
use crate::io;
use crate::shapes::{SAMPLES, Sample};

/// `meniscus sample`.
#[derive(Debug, Args)]
pub struct SampleArguments {
    /// Which: creature, sphere, torus, catenoid or saddle.
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Mesh to write (.obj, .ply, .stl).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
}

/// Runs the command.
pub fn sample(args: &SampleArguments) -> Result<()> {
    let Some(sample) = Sample::named(&args.name) else {
        let names: Vec<&str> = SAMPLES.iter().map(|s| s.name).collect();
        return Err(UsageError(format!(
            "there is no sample `{}`; there are {}",
            args.name,
            names.join(", ")
        ))
        .into());
    };
    io::check_target(&args.output)?;
    let opened = io::from_soup(sample.soup(), Path::new(sample.name))?;
    io::save_mesh(&args.output, &opened.mesh, &[])?;
    print(&format!("{}: {}\n", args.output.display(), sample.title))
}
