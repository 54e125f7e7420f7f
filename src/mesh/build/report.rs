//! What was found in a file and done to it.

use crate::mesh::DVec3;
use serde::{Serialize, Serializer};

/// Counts and places of everything that was repaired, or found and left, when a file was loaded.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LoadReport {
    /// Vertices in the file.
    pub file_vertices: usize,
    /// Polygons in the file.
    pub file_faces: usize,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles of the mesh, one-sided components included.
    pub faces: usize,
    /// Polygons of more than three corners that were cut into triangles.
    pub polygons_triangulated: usize,
    /// Faces dropped because an earlier one has the same vertices.
    pub duplicate_faces: usize,
    /// Faces dropped because they have fewer than three different vertices.
    pub degenerate_faces: usize,
    /// Triangles of zero area, which are kept: without them their neighbours would come apart.
    pub zero_area_faces: usize,
    /// Vertices merged with an earlier one at the same position.
    pub welded_vertices: usize,
    /// Vertices used by no face, which are kept.
    pub isolated_vertices: usize,
    /// Faces flipped to agree with the majority of their component.
    pub flipped_faces: usize,
    /// Edges shared by more than two faces, which were cut apart.
    pub non_manifold_edges: usize,
    /// Vertices that joined several sheets at a point, which were split.
    pub split_vertices: usize,
    /// Vertices at which a hole touches itself, so that it counts as two or more.
    pub pinched_vertices: usize,
    /// Copies of vertices appended at the end of the list by these cuts.
    pub appended_vertices: usize,
    /// Triangles of non-orientable components, which are never changed.
    #[serde(rename = "one_sided_faces")]
    pub non_orientable_faces: usize,
    /// The connected components, in the order of their lowest face.
    pub components: Vec<ComponentReport>,
    /// Where the defects are; at most [`Defect::LIMIT`] of each kind.
    pub defects: Vec<Defect>,
    /// Notes in plain words, the reader's first.
    pub notes: Vec<String>,
    /// For each vertex of the file its index in the mesh; none if that is the same throughout.
    pub file_to_mesh: Option<Vec<u32>>,
}

/// One connected component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ComponentReport {
    /// Triangles.
    pub faces: usize,
    /// Vertices.
    pub vertices: usize,
    /// Boundary loops; none if the component is closed.
    pub loops: usize,
    /// Whether the component can be oriented. One-sided ones are left alone.
    pub orientable: bool,
    /// Euler characteristic: vertices − edges + faces.
    pub euler: i64,
}

/// Something wrong at a place, whether repaired or not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Defect {
    /// What it is.
    pub kind: DefectKind,
    /// Where it is, for the view to fly to.
    #[serde(serialize_with = "as_array")]
    pub position: DVec3,
    /// A face concerned, 0-based in file order.
    pub file_face: Option<u32>,
    /// A vertex concerned, 0-based in file order.
    pub file_vertex: Option<u32>,
}

impl Defect {
    /// How many places of each kind are listed; the counts go on.
    pub const LIMIT: usize = 100;
}

/// The kinds of [`Defect`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DefectKind {
    /// A face dropped because an earlier one has the same vertices.
    DuplicateFace,
    /// A face dropped for having fewer than three different vertices.
    DegenerateFace,
    /// A triangle of zero area, kept.
    ZeroAreaFace,
    /// A flipped face.
    FlippedFace,
    /// An edge of more than two faces, cut apart.
    NonManifoldEdge,
    /// A vertex joining several sheets, split.
    NonManifoldVertex,
    /// A vertex at which a hole touches itself.
    PinchedHole,
    /// A component without orientation, left alone.
    OneSidedComponent,
}

impl DefectKind {
    /// What it is, for a list.
    pub fn words(self) -> &'static str {
        match self {
            Self::DuplicateFace => "duplicate face, dropped",
            Self::DegenerateFace => "face with a repeated corner, dropped",
            Self::ZeroAreaFace => "triangle of zero area, kept",
            Self::FlippedFace => "face turned over",
            Self::NonManifoldEdge => "edge of more than two faces, cut apart",
            Self::NonManifoldVertex => "vertex joining several sheets, split",
            Self::PinchedHole => "hole touching itself",
            Self::OneSidedComponent => "component without orientation, left alone",
        }
    }
}

fn as_array<S: Serializer>(p: &DVec3, serializer: S) -> Result<S::Ok, S::Error> {
    p.to_array().serialize(serializer)
}
