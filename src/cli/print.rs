//! Output to standard output and to mesh files.

use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::Result;

use crate::io::save_mesh;
use crate::mesh::Mesh;

/// Writes text to standard output. A closed pipe (`meniscus info … | head`) is not an error; any
/// other failure, such as a full disk, is one.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("cannot write to standard output"))
        }
        _ => Ok(()),
    }
}

/// Writes a mesh. Unless `quiet`, prints to standard error what the format cannot store.
pub fn save(path: &Path, mesh: &Mesh, quiet: bool) -> Result<()> {
    let losses = save_mesh(path, mesh)?;
    for loss in losses.iter().filter(|_| !quiet) {
        eprintln!("{}: {loss}", path.display());
    }
    Ok(())
}
