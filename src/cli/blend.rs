//! `meniscus blend`.

use anyhow::Result;

use crate::cli::UsageError;
use crate::cli::args::BlendArguments;
use crate::cli::edit::components_of;
use crate::cli::fill::{Task, fill_opened, start};

/// Runs the command.
pub fn blend(args: &BlendArguments) -> Result<()> {
    if !args.fill.part.is_empty() {
        return Err(UsageError("a blend joins whole rims: leave --part out".into()).into());
    }
    let mut start = start(&args.fill)?;
    let opened = &mut start.opened;
    if !args.flip.is_empty() {
        let turned = components_of(&opened.mesh, &args.flip)?;
        opened.mesh = opened.mesh.turned_over(&turned);
    }
    fill_opened(&args.fill, &start, Task::Blend)
}
