//! Triangle meshes: connectivity without coordinates, and positions in `f64`.

mod ids;
mod intersect;
pub mod shapes;
mod soup;
mod spatial;
mod topology;

pub use glam::DVec3;
pub use ids::{FaceId, HalfedgeId, VertexId};
pub use intersect::{folded_edges, self_intersections, triangles_meet};
pub use soup::{FaceTag, Soup};
pub use spatial::{ClosestPoint, TriangleBvh, closest_point_on_segment, closest_point_on_triangle};
pub use topology::{Topology, TopologyError};
