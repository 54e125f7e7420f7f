//! Boundary loops as lines.

use crate::mesh::{BoundaryLoop, DVec3, Topology};
use crate::subdivision::limit_position;

/// The points of a boundary loop for a closed line, relative to `centre`: points of the limit
/// surface if that is drawn, else the vertices.
pub fn rim_points(
    topology: &Topology,
    positions: &[DVec3],
    one: &BoundaryLoop,
    centre: DVec3,
    limit: bool,
) -> Vec<[f32; 3]> {
    let point = |v| {
        if limit {
            limit_position(topology, positions, v)
        } else {
            positions[v.index()]
        }
    };
    one.vertices
        .iter()
        .map(|&v| (point(v) - centre).to_array().map(|x| x as f32))
        .collect()
}
