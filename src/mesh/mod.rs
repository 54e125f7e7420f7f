//! Triangle meshes: connectivity without coordinates, and positions in `f64`.

mod ids;
mod topology;

pub use glam::DVec3;
pub use ids::{FaceId, HalfedgeId, VertexId};
pub use topology::{Topology, TopologyError};
