//! Reading and writing meshes on behalf of a command.

use std::path::Path;

use anyhow::{Context, Result};

use crate::io::{self, OutputMesh};
use crate::mesh::{self, LoadReport, Mesh};

/// A mesh read from a file.
pub struct Opened {
    /// The repaired mesh.
    pub mesh: Mesh,
    /// What the file held and what was repaired.
    pub report: LoadReport,
    /// Material libraries the file names, to be named again in the output.
    pub material_libraries: Vec<String>,
}

/// Reads and repairs a mesh.
pub fn open(path: &Path) -> Result<Opened> {
    let soup = io::load(path)?;
    let (mesh, report) =
        mesh::build(&soup).with_context(|| format!("{} cannot be used", path.display()))?;
    Ok(Opened {
        mesh,
        report,
        material_libraries: soup.material_libraries,
    })
}

/// Writes a mesh atomically, in the format of the extension.
pub fn save(path: &Path, mesh: &Mesh, material_libraries: &[String]) -> Result<()> {
    let triangles: Vec<[u32; 3]> = mesh.all_triangles().collect();
    let mut face_tags = mesh.face_tags.clone();
    face_tags.extend_from_slice(&mesh.one_sided_tags);
    io::save(
        path,
        &OutputMesh {
            positions: &mesh.positions,
            triangles: &triangles,
            colors: &mesh.colors,
            face_tags: &face_tags,
            tags: &mesh.tags,
            material_libraries,
        },
    )?;
    Ok(())
}
