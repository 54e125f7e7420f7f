//! `meniscus render`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use crate::cli::picture::Shot;
use crate::cli::picture_args::{PictureArguments, choice};
use crate::cli::print::say_notes;
use crate::cli::targets::check_targets;
use crate::io::open_welded;
use crate::mesh::Weld;
use crate::render::{Gpu, SequenceFormat, save_png, turntable, write_sequence};

/// `meniscus render`.
#[derive(Debug, Args)]
pub struct RenderArguments {
    /// The mesh to read (.obj, .ply, .stl, .off, .glb, .gltf, .3mf).
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// The distance within which vertices of IN count as one: auto (the rounding of its numbers) or a
    /// length.
    #[arg(long, value_name = "WELD", default_value = "auto", display_order = 999)]
    pub weld: Weld,
    /// The picture to write.
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// The look of the picture.
    #[command(flatten)]
    pub look: PictureArguments,
    /// Write N pictures of a full turn around the vertical axis instead of one picture.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600))]
    pub turntable: Option<u32>,
    /// The format of the turn: png (numbered files), gif or apng [default: by the extension].
    #[arg(long, requires = "turntable", value_parser = choice::<SequenceFormat>())]
    pub format: Option<SequenceFormat>,
    /// The number of pictures per second.
    #[arg(long, value_name = "FPS", default_value_t = 25.0, requires = "turntable", value_parser = fps)]
    pub fps: f64,
    /// Print only errors.
    #[arg(short, long)]
    pub quiet: bool,
}

fn fps(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(f) if (0.1..=100.0).contains(&f) => Ok(f),
        _ => Err("write a number from 0.1 to 100".into()),
    }
}

/// Runs `meniscus render`.
pub fn render(args: &RenderArguments) -> Result<()> {
    let format = format(args)?;
    args.look.check()?;
    check_targets(
        &[("IN", Some(&args.input))],
        &[],
        &[("OUT", Some(&args.output))],
    )?;
    // fail without an adapter before the mesh is read
    let gpu = Gpu::new()?;
    let opened = open_welded(&args.input, args.weld)?;
    if !args.quiet {
        say_notes(&args.input.display().to_string(), &opened.report);
    }
    let shot = Shot::new(
        &opened.mesh,
        opened.mesh.face_count(),
        Vec::new(),
        &args.look,
    )?;
    let Some(count) = args.turntable else {
        return Ok(save_png(&args.output, &shot.take(&gpu, &shot.camera)?)?);
    };
    let count = count as usize;
    let frame = |i| shot.take(&gpu, &turntable(&shot.camera, i, count));
    let progress = |_, _| true;
    write_sequence(&args.output, format, frame, count, args.fps, &progress)?;
    Ok(())
}

/// The requested format, or that of the extension.
fn format(args: &RenderArguments) -> Result<SequenceFormat> {
    let extension = args.output.extension().unwrap_or_default();
    let is = |name: &str| extension.eq_ignore_ascii_case(name);
    let turns = args.turntable.is_some();
    let by_extension = if turns && is("gif") {
        SequenceFormat::Gif
    } else if turns && is("apng") {
        SequenceFormat::Apng
    } else {
        SequenceFormat::Png
    };
    let format = args.format.unwrap_or(by_extension);
    let fits = match format {
        SequenceFormat::Png => is("png"),
        SequenceFormat::Gif => is("gif"),
        SequenceFormat::Apng => is("png") || is("apng"),
    };
    if fits {
        return Ok(format);
    }
    let wanted = match format {
        SequenceFormat::Png => ".png (or .gif and .apng with --turntable)",
        SequenceFormat::Gif => ".gif",
        SequenceFormat::Apng => ".png or .apng",
    };
    let message = format!(
        "{}: a picture needs the extension {wanted}",
        args.output.display()
    );
    Err(crate::cli::UsageError(message).into())
}
