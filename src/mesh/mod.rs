//! Triangle meshes: connectivity without coordinates, and positions in `f64`.

mod attributes;
mod boundary;
mod build;
mod check;
mod cut;
mod data;
mod erase;
mod flaws;
mod ids;
mod intersect;
mod joined;
mod loose;
mod measures;
mod neighbourhood;
mod outer_boundary;
mod selection;
mod soup;
mod spatial;
mod split;
mod submesh;
mod topology;
pub(crate) mod union_find;

pub(crate) use attributes::TEXTURE_NUMBER;
pub use attributes::{
    Attributes, Colors, Column, FaceData, GltfMaterials, ImageSource, Material, NO_VALUE,
    NumberType, Numbers, ObjectSettings, OwnMaterial, Written, color_columns, color_steps, colors,
    columns_named, row_count, texture_columns, to_light, to_signal,
};
pub use boundary::{BoundaryLoop, boundary_loops};
pub use build::{
    BuildError, ComponentReport, Defect, DefectKind, LoadReport, Weld, build, build_welded, stitch,
    stitching_tolerance,
};
pub use check::{check_filled, check_mesh, check_topology};
pub use cut::{CutOpen, cut_open, edge_between, edge_flags};
pub use data::{Components, Mesh, components};
pub use erase::{Erased, erase};
pub use flaws::{Flaw, flawed_faces};
pub use glam::DVec3;
pub use ids::{FaceId, HalfedgeId, LoopId, VertexId};
pub use intersect::{
    FOLD_DEGREES, TriangleIntersections, dihedral_angle, folded_edges, self_intersections,
    triangles_meet,
};
pub(crate) use intersect::{canonical_vertices, pair_meets};
pub use joined::joined;
pub use loose::{LOOSE_FACES, LooseParts, loose_parts};
pub use measures::{bending, perimeter, rms_distance, vector_area, vertex_normal, vertex_normals};
pub(crate) use measures::{bends, is_slit, sides};
pub use neighbourhood::{Neighbourhood, NeighbourhoodSearch, faces_around};
pub use selection::{
    connected_faces, face_flags, face_list, faces_in_ball, faces_near, grow, inner_vertices,
    invert, parse_ranges, ranges_text, shrink, smooth_border,
};
pub use soup::{FaceTag, Soup};
pub use spatial::{
    ClosestPoint, RayHit, TriangleBvh, bounds, boxes_overlap, closest_point_from,
    closest_point_on_polygon, closest_point_on_segment, closest_point_on_triangle,
};
pub use split::{Split, edge_diamond, split_all, split_faces};
pub use submesh::Submesh;
pub use topology::{Topology, TopologyError};
