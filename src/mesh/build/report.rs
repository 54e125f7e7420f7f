//! The load report: defects of a file and their repairs.

use crate::mesh::DVec3;
use serde::{Serialize, Serializer};

/// Counts and places of all defects found in a file, repaired or not.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LoadReport {
    /// Vertices in the file.
    pub file_vertices: usize,
    /// Polygons in the file.
    pub file_faces: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles of the mesh, including non-orientable components.
    pub faces: usize,
    /// Polygons with more than three corners, which were triangulated.
    pub polygons_triangulated: usize,
    /// Faces removed because an earlier one has the same vertices.
    pub duplicate_faces: usize,
    /// Faces removed because they have fewer than three different vertices.
    pub degenerate_faces: usize,
    /// Triangles of zero area. They are kept because they connect their neighbours.
    pub zero_area_faces: usize,
    /// Vertices merged with an earlier one at the same position.
    pub welded_vertices: usize,
    /// Those of them whose position differs, within the tolerance of welding.
    pub welded_apart: usize,
    /// Vertices used by no face, which are kept.
    pub isolated_vertices: usize,
    /// Faces flipped to agree with the majority of their component.
    pub flipped_faces: usize,
    /// Edges with more than two faces, which were cut.
    pub non_manifold_edges: usize,
    /// Vertices with several sheets, which were split.
    pub split_vertices: usize,
    /// Vertices at which a boundary touches itself, so that it counts as two or more loops.
    pub pinched_vertices: usize,
    /// Copies of vertices appended at the end of the list by these cuts.
    pub appended_vertices: usize,
    /// Triangles of non-orientable components, which are never changed.
    #[serde(rename = "one_sided_faces")]
    pub non_orientable_faces: usize,
    /// The connected components, in the order of their lowest face.
    pub components: Vec<ComponentReport>,
    /// The defects, at most [`Defect::LIMIT`] of each kind.
    pub defects: Vec<Defect>,
    /// What the file holds besides positions and faces, as [`Attributes::summary`] lists it.
    ///
    /// [`Attributes::summary`]: crate::mesh::Attributes::summary
    pub attributes: Vec<String>,
    /// Notes for the user. Those of the reader come first.
    pub notes: Vec<String>,
    /// The mesh index of each file vertex; empty if the indices are equal.
    pub file_to_mesh: Option<Vec<u32>>,
}

impl LoadReport {
    /// Number of defects, of which [`Self::defects`] lists some.
    pub fn defect_count(&self) -> usize {
        let one_sided = self.components.iter().filter(|part| !part.orientable);
        self.duplicate_faces
            + self.degenerate_faces
            + self.zero_area_faces
            + self.flipped_faces
            + self.non_manifold_edges
            + self.split_vertices
            + self.pinched_vertices
            + one_sided.count()
    }
}

/// One connected component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ComponentReport {
    /// Triangles.
    pub faces: usize,
    /// Vertices.
    pub vertices: usize,
    /// Number of boundary loops; 0 if the component is closed.
    pub loops: usize,
    /// Whether the component can be oriented. Other components are not changed.
    pub orientable: bool,
    /// Euler characteristic: vertices − edges + faces.
    pub euler: i64,
}

/// A defect, repaired or not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Defect {
    /// The kind of defect.
    pub kind: DefectKind,
    /// The position, to which the view can move.
    #[serde(serialize_with = "as_array")]
    pub position: DVec3,
    /// A face of the defect, 0-based in file order.
    pub file_face: Option<u32>,
    /// A vertex of the defect, 0-based in file order.
    pub file_vertex: Option<u32>,
}

impl Defect {
    /// Maximum number of listed defects of each kind. The counts include all defects.
    pub const LIMIT: usize = 100;
}

/// The kinds of [`Defect`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// A face removed because an earlier one has the same vertices.
    DuplicateFace,
    /// A face removed because it has fewer than three different vertices.
    DegenerateFace,
    /// A triangle of zero area, kept.
    ZeroAreaFace,
    /// A flipped face.
    FlippedFace,
    /// An edge with more than two faces, cut.
    NonManifoldEdge,
    /// A vertex with several sheets, split.
    NonManifoldVertex,
    /// A vertex at which a boundary touches itself.
    PinchedHole,
    /// A non-orientable component, not changed.
    OneSidedComponent,
}

impl DefectKind {
    /// A description for lists.
    pub fn words(self) -> &'static str {
        match self {
            Self::DuplicateFace => "duplicate face, removed",
            Self::DegenerateFace => "face with a repeated corner, removed",
            Self::ZeroAreaFace => "triangle of zero area, kept",
            Self::FlippedFace => "flipped face",
            Self::NonManifoldEdge => "edge with more than two faces, cut",
            Self::NonManifoldVertex => "vertex with several sheets, split",
            Self::PinchedHole => "boundary that touches itself",
            Self::OneSidedComponent => "non-orientable component, not changed",
        }
    }
}

fn as_array<S: Serializer>(p: &DVec3, serializer: S) -> Result<S::Ok, S::Error> {
    p.to_array().serialize(serializer)
}
