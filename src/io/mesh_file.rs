//! Reading meshes from files, with repair, and writing them.

use std::path::{Path, PathBuf};

use super::companions::kept;
use super::{LoadError, OutputMesh, SaveError, load, save_with_messages};
use crate::mesh::{self, BuildError, LoadReport, Mesh, Soup, Weld};

/// A mesh read from a file.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The repaired mesh.
    pub mesh: Mesh,
    /// The load report.
    pub report: LoadReport,
}

/// Why a mesh file cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The file cannot be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// No mesh can be built from the contents.
    #[error("{} cannot be used: {source}", .path.display())]
    Build {
        /// The file.
        path: PathBuf,
        /// Reason why no mesh can be built.
        source: BuildError,
    },
}

/// Reads and repairs a mesh.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path) -> Result<Opened, OpenError> {
    open_welded(path, Weld::Auto)
}

/// [`open`] with another tolerance for welding.
///
/// # Errors
/// [`OpenError`].
pub fn open_welded(path: &Path, weld: Weld) -> Result<Opened, OpenError> {
    repaired(&load(path)?, path, weld)
}

/// Reads several files as one mesh, the vertices and faces of each following those of the one before (see
/// [`mesh::joined`]), and repairs it.
///
/// # Errors
/// [`OpenError`].
pub fn open_joined(paths: &[PathBuf], weld: Weld) -> Result<Opened, OpenError> {
    let part = |path: &PathBuf| -> Result<_, OpenError> {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        Ok((name.to_string_lossy().into_owned(), load(path)?))
    };
    let parts: Vec<_> = paths.iter().map(part).collect::<Result<_, _>>()?;
    let path = paths.first().map_or(Path::new(""), PathBuf::as_path);
    repaired(&mesh::joined(&parts), path, weld)
}

/// Repairs a polygon soup. Messages contain `path`.
///
/// # Errors
/// [`OpenError::Build`].
pub fn from_soup(soup: &Soup, path: &Path) -> Result<Opened, OpenError> {
    repaired(soup, path, Weld::Auto)
}

fn repaired(soup: &Soup, path: &Path, weld: Weld) -> Result<Opened, OpenError> {
    let (mesh, report) = mesh::build_welded(soup, weld).map_err(|source| OpenError::Build {
        path: path.to_owned(),
        source,
    })?;
    Ok(Opened { mesh, report })
}

/// Writes a mesh atomically in the format of the extension. Returns messages for the user: the
/// [losses](super::losses), and what was written beside it.
///
/// # Errors
/// As [`save`](super::save).
pub fn save_mesh(path: &Path, mesh: &Mesh) -> Result<Vec<String>, SaveError> {
    with_output(mesh, |output| save_with_messages(path, output))
}

/// [`save_mesh`] of a mesh whose material libraries and images stay where they are. A file in another folder refers
/// to them there; a message says where that is impossible.
///
/// # Errors
/// As [`save`](super::save).
pub fn save_mesh_keeping_files(path: &Path, mesh: &Mesh) -> Result<Vec<String>, SaveError> {
    with_output(mesh, |output| {
        let (attributes, message) = kept(path, output.attributes);
        let output = OutputMesh {
            attributes: &attributes,
            ..*output
        };
        let mut messages = save_with_messages(path, &output)?;
        messages.extend(message);
        Ok(messages)
    })
}

/// Calls `write` with the lists of a file of a mesh.
pub fn with_output<T>(mesh: &Mesh, write: impl FnOnce(&OutputMesh<'_>) -> T) -> T {
    let written = mesh.written();
    write(&OutputMesh {
        positions: &written.positions,
        triangles: &written.triangles,
        attributes: &written.attributes,
    })
}
