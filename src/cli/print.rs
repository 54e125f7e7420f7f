//! Results on standard output and in mesh files.

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Result;

use crate::io::{Opened, save_mesh};
use crate::mesh::Mesh;

/// Writes text to standard output. A reader that has gone away (`meniscus info … | head`) is no
/// error; any other failure, such as a full disk, is.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("cannot write to standard output"))
        }
        _ => Ok(()),
    }
}

/// Writes a mesh with the material libraries of the input, and prints on standard error what the
/// format cannot keep, unless `quiet`.
pub fn save(path: &Path, mesh: &Mesh, input: &Opened, quiet: bool) -> Result<()> {
    let losses = save_mesh(path, mesh, &input.material_libraries)?;
    for loss in losses.iter().filter(|_| !quiet) {
        eprintln!("{}: {loss}", path.display());
    }
    Ok(())
}
