//! From the polygons of a file to an oriented manifold triangle mesh, and what had to be repaired.

mod report;

pub use report::{ComponentReport, Defect, DefectKind, LoadReport};

use super::{Mesh, Soup, Topology, TopologyError};

/// Why no mesh can be made of what the file holds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// No polygon at all.
    #[error("the file has {vertices} vertices but no faces: there is nothing to fill")]
    NoFaces {
        /// Vertices in the file.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "vertex {vertex} (counted from 1) has the coordinates {position}, which are not finite \
         numbers; correct or remove it in the file"
    )]
    NotFinite {
        /// The vertex, counted from 1 as in the file.
        vertex: usize,
        /// What it has.
        position: super::DVec3,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face} (counted from 1) names vertex {vertex}, but the file has only {vertices} vertices"
    )]
    IndexOutOfRange {
        /// The face, counted from 1 as in the file.
        face: usize,
        /// The vertex, counted from 1.
        vertex: usize,
        /// How many there are.
        vertices: usize,
    },
    /// Too many elements for 32-bit indices.
    #[error("the mesh has {corners} face corners, more than the {limit} this program can index")]
    TooLarge {
        /// Corners of all polygons, or vertices.
        corners: usize,
        /// The limit.
        limit: usize,
    },
    /// Every face is degenerate.
    #[error("all {faces} faces of the file are degenerate (they name fewer than three vertices)")]
    OnlyDegenerate {
        /// Faces in the file.
        faces: usize,
    },
    /// Repair left something that is not a manifold: a defect of this program.
    #[error("the mesh could not be repaired: {0}; please report this file")]
    Unrepaired(#[from] TopologyError),
}

/// Makes an oriented manifold mesh of a file's polygons and says what was done to them.
///
/// # Errors
/// [`BuildError`] where no sound mesh can be made.
pub fn build(soup: &Soup) -> Result<(Mesh, LoadReport), BuildError> {
    let triangles: Vec<[u32; 3]> = (0..soup.face_count())
        .flat_map(|f| {
            let p = soup.face(f);
            (1..p.len().saturating_sub(1)).map(move |i| [p[0], p[i], p[i + 1]])
        })
        .collect();
    if triangles.is_empty() {
        return Err(BuildError::NoFaces {
            vertices: soup.positions.len(),
        });
    }
    let topology = Topology::from_triangles(soup.positions.len(), &triangles)?;
    let mut mesh = Mesh::new(soup.positions.clone(), topology);
    mesh.colors.clone_from(&soup.colors);
    let report = LoadReport {
        file_vertices: soup.positions.len(),
        file_faces: soup.face_count(),
        vertices: mesh.vertex_count(),
        faces: mesh.face_count(),
        notes: soup.notes.clone(),
        ..LoadReport::default()
    };
    Ok((mesh, report))
}
