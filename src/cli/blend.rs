//! `meniscus blend`.

use anyhow::Result;

use crate::cli::UsageError;
use crate::cli::args::BlendArguments;
use crate::cli::fill::{Task, fill_opened, start};
use crate::fill::NoSuchLoop;
use crate::mesh::boundary_loops;

/// Runs the command.
pub fn blend(args: &BlendArguments) -> Result<()> {
    if !args.fill.part.is_empty() {
        return Err(UsageError("a blend joins whole rims: leave --part out".into()).into());
    }
    let mut start = start(&args.fill)?;
    let opened = &mut start.opened;
    if !args.flip.is_empty() {
        // every loop's component once, by the numbers of the file as it is
        let loops = boundary_loops(&opened.mesh);
        let mut turned = Vec::new();
        for &number in &args.flip {
            let one = loops.get(number.wrapping_sub(1)).ok_or(NoSuchLoop {
                number,
                loops: loops.len(),
            })?;
            turned.push(one.component);
        }
        opened.mesh = opened.mesh.turned_over(&turned);
    }
    fill_opened(&args.fill, &start, Task::Blend)
}
