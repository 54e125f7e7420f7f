//! From the polygons of a file to an oriented manifold triangle mesh, and what had to be repaired.

mod edges;
mod fans;
mod join;
mod repair;
mod report;
mod summary;
#[cfg(test)]
mod tests;
mod triangulate;
mod weld;

pub use report::{ComponentReport, Defect, DefectKind, LoadReport};

use super::{Mesh, Soup, Topology, TopologyError};
use repair::{Faces, Repaired, repair};
use summary::summarize;
use triangulate::{Triangles, triangulate};

/// Why no mesh can be made of what the file holds.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    /// No component of the surface can be oriented.
    #[error(
        "the surface is one-sided (all {faces} triangles belong to Moebius strips): it has no \
         inside and outside, which a flow needs; cut it open along a line across the strip"
    )]
    OneSided {
        /// Triangles.
        faces: usize,
    },
    /// Repair left something that is not a manifold: a defect of this program.
    #[error("the mesh could not be repaired: {0}; please report this file")]
    Unrepaired(#[from] TopologyError),
}

/// Makes an oriented manifold mesh of a file's polygons and reports the repairs.
///
/// In this order: polygons are cut into triangles; faces that name a vertex twice or repeat an
/// earlier face are dropped; where more than two faces share an edge, two of them stay joined and
/// the others are cut off; boundary edges with exactly the same end positions are welded (all
/// vertices in a file that repeats them for every face); sheets are turned to agree with the
/// majority of their faces; vertices joining several sheets are split. Positions are never moved. A
/// file that is an oriented manifold already comes through unchanged.
///
/// Components that cannot be oriented are left alone (see [`Mesh::non_orientable`]).
///
/// # Errors
/// [`BuildError`] where no sound mesh can be made, [`BuildError::OneSided`] if no component can be
/// oriented.
pub fn build(soup: &Soup) -> Result<(Mesh, LoadReport), BuildError> {
    validate(soup)?;
    let triangles = triangulate(soup);
    if triangles.corners.is_empty() {
        return Err(BuildError::OnlyDegenerate {
            faces: soup.face_count(),
        });
    }
    let (topology, repaired) = repair(&soup.positions, soup.exploded, &triangles.corners)?;
    if repaired.triangles.is_empty() {
        return Err(BuildError::OneSided {
            faces: repaired.non_orientable.len(),
        });
    }
    let mesh = assemble(soup, &triangles, topology, &repaired);
    let report = summarize(soup, &triangles, &repaired, &mesh);
    Ok((mesh, report))
}

fn validate(soup: &Soup) -> Result<(), BuildError> {
    const LIMIT: usize = 1 << 30;
    let vertices = soup.positions.len();
    if soup.corners.len() >= LIMIT || vertices >= LIMIT {
        return Err(BuildError::TooLarge {
            corners: soup.corners.len().max(vertices),
            limit: LIMIT,
        });
    }
    if soup.face_count() == 0 {
        return Err(BuildError::NoFaces { vertices });
    }
    if let Some(v) = soup.positions.iter().position(|p| !p.is_finite()) {
        return Err(BuildError::NotFinite {
            vertex: v + 1,
            position: soup.positions[v],
        });
    }
    if let Some(c) = soup.corners.iter().position(|&v| v as usize >= vertices) {
        return Err(BuildError::IndexOutOfRange {
            face: soup.offsets.partition_point(|&o| o as usize <= c),
            vertex: soup.corners[c] as usize + 1,
            vertices,
        });
    }
    Ok(())
}

/// Carries positions and attributes over to the repaired connectivity.
fn assemble(soup: &Soup, triangles: &Triangles, topology: Topology, repaired: &Repaired) -> Mesh {
    let pick = |faces: &Faces| -> Vec<u32> {
        if soup.face_tags.is_empty() {
            return Vec::new();
        }
        (0..faces.len())
            .map(|i| soup.face_tags[triangles.file_face(faces.origin(i)) as usize])
            .collect()
    };
    Mesh {
        positions: match &repaired.source {
            None => soup.positions.clone(),
            Some(of) => of.iter().map(|&v| soup.positions[v as usize]).collect(),
        },
        topology,
        colors: match &repaired.source {
            Some(of) if !soup.colors.is_empty() => {
                of.iter().map(|&v| soup.colors[v as usize]).collect()
            }
            _ => soup.colors.clone(),
        },
        face_tags: pick(&repaired.triangles),
        tags: soup.tags.clone(),
        non_orientable: repaired.non_orientable.corners.clone(),
        non_orientable_tags: pick(&repaired.non_orientable),
    }
}
