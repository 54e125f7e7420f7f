//! Checks of the output files before the computation.

use std::path::Path;

use anyhow::{Result, bail};

use crate::io;

/// The name of an argument and its file, if given.
pub type Named<'a> = (&'a str, Option<&'a Path>);

/// Checks that all output files can be written, and that none of them is an input or another
/// output.
pub fn check_targets(read: &[Named<'_>], meshes: &[Named<'_>], others: &[Named<'_>]) -> Result<()> {
    let mut taken: Vec<(&str, &Path)> = read.iter().filter_map(given).collect();
    let meshes = meshes.iter().filter_map(given).map(|m| (m, true));
    let others = others.iter().filter_map(given).map(|o| (o, false));
    for ((name, path), is_mesh) in meshes.chain(others) {
        if let Some((other, _)) = taken.iter().find(|(_, at)| io::same_file(path, at)) {
            bail!(
                "{name} is the same file as {other} ({}); choose another name, nothing was \
                 overwritten",
                path.display()
            );
        }
        taken.push((name, path));
        if is_mesh {
            io::check_target(path)?;
        } else {
            io::check_text_target(path)?;
        }
    }
    Ok(())
}

fn given<'a>(&(name, path): &Named<'a>) -> Option<(&'a str, &'a Path)> {
    Some((name, path?))
}
