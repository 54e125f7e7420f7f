//! A mesh from a file and back, repair included.

use std::path::{Path, PathBuf};

use super::{Format, LoadError, OutputMesh, SaveError, load, losses, save};
use crate::mesh::{self, BuildError, LoadReport, Mesh, Soup};

/// A mesh read from a file.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The repaired mesh.
    pub mesh: Mesh,
    /// What the file held and what was repaired.
    pub report: LoadReport,
    /// Material libraries the file names, to be named again in the output.
    pub material_libraries: Vec<String>,
}

/// Why a file gave no mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// It could not be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// It was read, but no mesh can be made of it.
    #[error("{} cannot be used: {source}", .path.display())]
    Build {
        /// The file.
        path: PathBuf,
        /// Why.
        source: BuildError,
    },
}

/// Reads and repairs a mesh.
///
/// # Errors
/// [`OpenError`].
pub fn open(path: &Path) -> Result<Opened, OpenError> {
    from_soup(load(path)?, path)
}

/// Repairs a polygon soup; `path` stands in the messages.
///
/// # Errors
/// [`OpenError::Build`].
pub fn from_soup(soup: Soup, path: &Path) -> Result<Opened, OpenError> {
    let (mesh, report) = mesh::build(&soup).map_err(|source| OpenError::Build {
        path: path.to_owned(),
        source,
    })?;
    Ok(Opened {
        mesh,
        report,
        material_libraries: soup.material_libraries,
    })
}

/// Writes a mesh atomically, in the format of the extension. Returns the [`losses`], one sentence
/// each.
///
/// # Errors
/// As [`save`].
pub fn save_mesh(
    path: &Path,
    mesh: &Mesh,
    material_libraries: &[String],
) -> Result<Vec<String>, SaveError> {
    with_output(mesh, material_libraries, |output| {
        save(path, output)?;
        Ok(Format::from_path(path).map_or_else(Vec::new, |format| losses(format, output)))
    })
}

/// Calls `write` with all that a file holds of a mesh.
pub fn with_output<T>(
    mesh: &Mesh,
    material_libraries: &[String],
    write: impl FnOnce(&OutputMesh<'_>) -> T,
) -> T {
    let triangles: Vec<[u32; 3]> = mesh.all_triangles().collect();
    let mut face_tags = mesh.face_tags.clone();
    face_tags.extend_from_slice(&mesh.non_orientable_tags);
    write(&OutputMesh {
        positions: &mesh.positions,
        triangles: &triangles,
        colors: &mesh.colors,
        face_tags: &face_tags,
        tags: &mesh.tags,
        material_libraries,
    })
}
