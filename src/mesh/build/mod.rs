//! Builds an oriented manifold triangle mesh from the polygons of a file, and reports the repairs.

mod edges;
mod fans;
mod join;
mod repair;
mod report;
mod stitch;
mod summary;
mod t_junctions;
#[cfg(test)]
mod tests;
mod triangulate;
mod weld;

pub use report::{ComponentReport, Defect, DefectKind, LoadReport};
pub use stitch::{stitch, stitching_tolerance};
pub use weld::Weld;

use rustc_hash::FxHashMap;

use super::attributes::picked_rows;
use super::{Attributes, FaceData, Mesh, Soup, Topology, TopologyError};
use repair::{Faces, Repaired, repair};
use summary::summarize;
use triangulate::{Triangles, triangulate};

/// Why no mesh can be built from a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// There are no polygons.
    #[error("the file has {vertices} vertices but no faces; export the mesh with its faces")]
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
        /// The coordinates.
        position: super::DVec3,
    },
    /// A face uses a vertex that does not exist.
    #[error(
        "face {face} (counted from 1) uses vertex {vertex}, but the file has only {vertices} \
         vertices"
    )]
    IndexOutOfRange {
        /// The face, counted from 1 as in the file.
        face: usize,
        /// The vertex, counted from 1.
        vertex: usize,
        /// Number of vertices of the file.
        vertices: usize,
    },
    /// Too many elements for 32-bit indices.
    #[error("the mesh has {corners} face corners, which exceeds the limit of {limit}")]
    TooLarge {
        /// Corners of all polygons, or vertices.
        corners: usize,
        /// The limit.
        limit: usize,
    },
    /// Every face is degenerate.
    #[error(
        "all {faces} faces of the file are degenerate (their corners are at fewer than three \
             different places)"
    )]
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
    /// The repaired mesh is not a manifold, which is an internal error.
    #[error("the mesh could not be repaired: {0}; please report this file")]
    Unrepaired(#[from] TopologyError),
}

/// Builds an oriented manifold mesh from the polygons of a file and reports the repairs.
///
/// The steps are, in this order: polygons are triangulated; faces that use a vertex twice or repeat
/// an earlier face are removed, except the two faces at which solids touch; at an edge with more
/// than two faces, faces are joined in pairs, those of the same orientation first, and the others are
/// cut off; boundary edges with the same end positions within the tolerance of [`Weld::Auto`] are
/// welded (all vertices in a file that repeats them for every face); closed sheets of mixed
/// orientation are flipped to have outward normals, open ones to agree with the majority of their
/// faces; vertices with several sheets are split. Positions never change. A file that is an oriented
/// manifold is not changed.
///
/// Components that cannot be oriented are not changed (see [`Mesh::non_orientable`]).
///
/// # Errors
/// [`BuildError`] if no valid mesh can be built, [`BuildError::OneSided`] if no component can be
/// oriented.
pub fn build(soup: &Soup) -> Result<(Mesh, LoadReport), BuildError> {
    build_welded(soup, Weld::Auto)
}

/// [`build`] with another tolerance for welding.
///
/// # Errors
/// As [`build`].
pub fn build_welded(soup: &Soup, weld: Weld) -> Result<(Mesh, LoadReport), BuildError> {
    validate(soup)?;
    let triangles = triangulate(soup);
    if triangles.corners.is_empty() {
        return Err(BuildError::OnlyDegenerate {
            faces: soup.face_count(),
        });
    }
    let (topology, repaired) = repair(
        &soup.positions,
        soup.exploded,
        &triangles.corners,
        weld.tolerance(&soup.positions, soup.exploded),
    )?;
    if repaired.triangles.is_empty() {
        return Err(match repaired.non_orientable.len() {
            0 => BuildError::OnlyDegenerate {
                faces: soup.face_count(),
            },
            faces => BuildError::OneSided { faces },
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

/// Transfers positions and attributes to the repaired connectivity.
fn assemble(soup: &Soup, triangles: &Triangles, topology: Topology, repaired: &Repaired) -> Mesh {
    let given = &soup.attributes;
    let mut attributes = Attributes {
        faces: face_data(&given.faces, triangles, repaired, &repaired.triangles),
        non_orientable: face_data(&given.faces, triangles, repaired, &repaired.non_orientable),
        tags: given.tags.clone(),
        texture: given.texture.clone(),
        texture_is_down: given.texture_is_down,
        normals: given.normals.clone(),
        material_libraries: given.material_libraries.clone(),
        gltf_materials: given.gltf_materials.clone(),
        own_materials: given.own_materials.clone(),
        comments: given.comments.clone(),
        unit: given.unit.clone(),
        metadata: given.metadata.clone(),
        objects: given.objects.clone(),
        stl_header: given.stl_header,
        folder: given.folder.clone(),
        ..Attributes::default()
    };
    vertex_data(soup, triangles, repaired, &mut attributes);
    Mesh {
        positions: match &repaired.source {
            None => soup.positions.clone(),
            Some(of) => of.iter().map(|&v| soup.positions[v as usize]).collect(),
        },
        topology,
        attributes,
        non_orientable: repaired.non_orientable.corners.clone(),
    }
}

/// The places of the corners of a repaired face in the file's list of corners.
fn file_corners(triangles: &Triangles, repaired: &Repaired, origin: usize) -> [u32; 3] {
    let [a, b, c] = triangles.file_corners(origin);
    if repaired.flipped.binary_search(&(origin as u32)).is_ok() {
        [a, c, b]
    } else {
        [a, b, c]
    }
}

/// The data of repaired faces, from that of the polygons.
fn face_data(
    given: &FaceData,
    triangles: &Triangles,
    repaired: &Repaired,
    faces: &Faces,
) -> FaceData {
    if *given == FaceData::default() {
        return FaceData::default();
    }
    // the usual case: the triangles of the file as they are
    if faces.are_those_of_file() && triangles.are_polygons() && repaired.flipped.is_empty() {
        return given.clone();
    }
    let origins = || (0..faces.len()).map(|i| faces.origin(i));
    let of_file: Vec<u32> = origins().map(|t| triangles.file_face(t)).collect();
    let corners = (0..faces.len()).flat_map(|i| file_corners(triangles, repaired, faces.origin(i)));
    given.picked(&of_file, &corners)
}

/// Transfers the columns of the vertices. If welded vertices differ in them, every vertex of the file
/// keeps its row.
fn vertex_data(
    soup: &Soup,
    triangles: &Triangles,
    repaired: &Repaired,
    attributes: &mut Attributes,
) {
    let columns = &soup.attributes.vertices;
    if columns.is_empty() {
        return;
    }
    let Some(source) = &repaired.source else {
        attributes.vertices.clone_from(columns);
        return;
    };
    let all_faces = [&repaired.triangles, &repaired.non_orientable];
    // the vertex of the file and that of the mesh at each corner
    let corners = |faces: &Faces| -> Vec<[u32; 2]> {
        let corners = faces.corners.iter().enumerate().flat_map(|(i, t)| {
            let of_file = file_corners(triangles, repaired, faces.origin(i));
            of_file.into_iter().zip(t)
        });
        corners
            .map(|(corner, &vertex)| [soup.corners[corner as usize], vertex])
            .collect()
    };
    let kept = |v: usize| repaired.file_to_mesh.as_ref().map_or(v as u32, |of| of[v]);
    let differs = |[of_file, vertex]: [u32; 2]| {
        let (own, first) = (of_file as usize, source[vertex as usize] as usize);
        own != first && columns.iter().any(|c| !c.numbers.are_same(own, first))
    };
    let mut vertices = (0..soup.positions.len()).map(|v| [v as u32, kept(v)]);
    let corners = all_faces.map(corners);
    if !vertices.any(differs) && !corners.iter().flatten().any(|&pair| differs(pair)) {
        attributes.vertices = picked_rows(columns, source);
        return;
    }
    // the rows of the file, then those of vertices that the repair separated
    let mut vertex_of_row: Vec<u32> = (0..soup.positions.len()).map(kept).collect();
    let mut rows: Vec<u32> = (0..soup.positions.len() as u32).collect();
    let mut other_rows = FxHashMap::default();
    let mut row = |[of_file, vertex]: [u32; 2]| {
        if vertex_of_row[of_file as usize] == vertex {
            return of_file;
        }
        *other_rows.entry([of_file, vertex]).or_insert_with(|| {
            vertex_of_row.push(vertex);
            rows.push(of_file);
            rows.len() as u32 - 1
        })
    };
    let [faces, aside] = corners.map(|pairs| pairs.into_iter().map(&mut row).collect());
    attributes.faces.rows = faces;
    attributes.non_orientable.rows = aside;
    attributes.vertices = picked_rows(columns, &rows);
    attributes.vertex_of_row = vertex_of_row;
}
