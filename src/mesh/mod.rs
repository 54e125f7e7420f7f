//! Triangle meshes: connectivity without coordinates, and positions in `f64`.

mod boundary;
mod build;
mod data;
mod ids;
mod soup;
mod topology;

pub use boundary::{BoundaryLoop, boundary_loops};
pub use build::{BuildError, ComponentReport, Defect, DefectKind, LoadReport, build};
pub use data::{Components, Mesh, components};
pub use glam::DVec3;
pub use ids::{FaceId, HalfedgeId, VertexId};
pub use soup::{FaceTag, Soup};
pub use topology::{Topology, TopologyError};
