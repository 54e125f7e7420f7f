//! `meniscus sample`: writes a built-in sample.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::cli::print::{Textures, print, save};
use crate::io;
use crate::shapes::{SAMPLES, Sample};

/// `meniscus sample`.
#[derive(Debug, Args)]
pub struct SampleArguments {
    /// The name of the sample.
    #[arg(value_name = "NAME", value_parser = samples())]
    pub sample: &'static Sample,
    /// The mesh to write (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
}

/// The samples by their names.
fn samples() -> impl TypedValueParser<Value = &'static Sample> {
    let names = SAMPLES.map(|s| PossibleValue::new(s.name).help(s.title));
    PossibleValuesParser::new(names).try_map(|name| Sample::named(&name).ok_or("no such sample"))
}

/// Runs `meniscus sample`.
pub fn sample(args: &SampleArguments) -> Result<()> {
    let sample = args.sample;
    io::check_target(&args.output)?;
    let opened = io::from_soup(&sample.soup(), Path::new(sample.name))?;
    save(&args.output, &opened.mesh, Textures::Keep, false)?;
    print(&format!("{}: {}\n", args.output.display(), sample.title))
}
