//! Triangle meshes: connectivity without coordinates, and positions in `f64`.

mod ids;
mod soup;
mod topology;

pub use glam::DVec3;
pub use ids::{FaceId, HalfedgeId, VertexId};
pub use soup::{FaceTag, Soup};
pub use topology::{Topology, TopologyError};
