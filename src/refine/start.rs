//! The first position of new vertices.

use crate::mesh::{DVec3, Split, Topology, VertexId};

/// Old positions, and new vertices on their edges, nearer to the end with the shorter edges.
///
/// Old vertices are to lie on the limit surface, so their control points step aside from the
/// middle of their new neighbours. Midpoints of edges of unequal lengths have that middle far off
/// along the surface, and the control point, going the other way, folds it. With edges divided in
/// the ratio of the shortest edges at their ends the new neighbours of a vertex are at like
/// distances.
pub fn graded_points(topology: &Topology, positions: &[DVec3], split: &Split) -> Vec<DVec3> {
    let shortest: Vec<f64> = (0..positions.len())
        .map(|v| {
            topology
                .neighbours(VertexId::from(v))
                .map(|w| positions[w.index()].distance(positions[v]))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let mut points = positions.to_vec();
    for &h in &split.edges {
        let (a, b) = (topology.origin(h).index(), topology.target(h).index());
        let sum = shortest[a] + shortest[b];
        let part = if sum > 0.0 { shortest[a] / sum } else { 0.5 };
        points.push(positions[a].lerp(positions[b], part));
    }
    points
}
