//! `meniscus sample`: writes a built-in sample.

use std::path::Path;

use anyhow::Result;

use crate::cli::UsageError;
use crate::cli::args::SampleArguments;
use crate::cli::print::print;
use crate::io;
use crate::shapes::{SAMPLES, Sample};

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
