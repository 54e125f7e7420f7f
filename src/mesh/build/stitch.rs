//! Stitching of slits: the weld of loading, for a mesh, and the division of edges at T-junctions.

use super::t_junctions::split_edges;
use super::{BuildError, Weld, build_welded};
use crate::mesh::{Mesh, Soup};

/// Part of the mean length of the boundary edges within which [`stitch`] joins vertices by default.
const PART: f64 = 0.01;

/// The default tolerance of [`stitch`], in units of the mesh: 1 % of the mean length of its boundary
/// edges; 0 without any.
pub fn stitching_tolerance(mesh: &Mesh) -> f64 {
    let edges = mesh.topology.edges();
    let open = edges.filter(|&h| mesh.topology.is_boundary_edge(h));
    let lengths: Vec<f64> = open.map(|h| mesh.edge_length(h)).collect();
    // the sum of no lengths is -0
    PART * lengths.iter().sum::<f64>().abs() / lengths.len().max(1) as f64
}

/// Joins boundary edges whose ends are within `tolerance` of each other, in units of the mesh, as
/// loading does. The vertex that comes first stands for both, and no vertex moves. Where an edge runs along several
/// edges (a T-junction), it and its face are divided at the vertices on it. Components that are joined with opposite
/// orientation are flipped to agree.
///
/// # Errors
/// The mesh has no faces.
pub fn stitch(mesh: &Mesh, tolerance: f64) -> Result<Mesh, BuildError> {
    let written = mesh.written();
    let corners = written.triangles.into_flattened();
    let mut soup = Soup {
        positions: written.positions.into_owned(),
        offsets: (0..=corners.len() as u32).step_by(3).collect(),
        corners,
        attributes: written.attributes.into_owned(),
        ..Soup::default()
    };
    split_edges(mesh, &mut soup, tolerance);
    Ok(build_welded(&soup, Weld::Within(tolerance))?.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, VertexId, cut_open, edge_flags};
    use crate::random::SplitMix;
    use crate::shapes;

    /// A sphere cut open along edges whose copies of vertices are moved by up to `far`, and the sphere.
    fn cut(edges: &[[VertexId; 2]], far: f64) -> (Mesh, Mesh) {
        let (positions, triangles) = shapes::icosphere(4);
        let whole = Mesh::from_triangles(positions, &triangles).expect("closed");
        let open = cut_open(&whole.topology, &edge_flags(&whole.topology, edges));
        let open = open.expect("a manifold");
        let mut random = SplitMix::new(5);
        let place = |(i, &v): (usize, &u32)| {
            let moved = if i < whole.vertex_count() { 0.0 } else { far };
            whole.positions[v as usize] + moved * random.direction()
        };
        let positions: Vec<DVec3> = open.to_whole.iter().enumerate().map(place).collect();
        (Mesh::new(positions, open.topology), whole)
    }

    /// The edges around the faces at vertex 0, which separate a disc from the rest.
    fn ring() -> Vec<[VertexId; 2]> {
        let (positions, triangles) = shapes::icosphere(4);
        let whole = Mesh::from_triangles(positions, &triangles).expect("closed");
        let around: Vec<VertexId> = whole.topology.neighbours(VertexId(0)).collect();
        let n = around.len();
        (0..n).map(|i| [around[i], around[(i + 1) % n]]).collect()
    }

    #[test]
    fn slits_within_the_tolerance_are_joined() {
        for edges in [&ring()[..2], &ring()] {
            let (open, whole) = cut(edges, 0.9e-3);
            assert!(open.vertex_count() > whole.vertex_count());
            assert_eq!(stitch(&open, 1e-3), Ok(whole));
            assert_eq!(stitch(&open, 0.8e-3), Ok(open.clone()));
            assert!(stitching_tolerance(&open) > 1e-3);
        }
    }

    #[test]
    fn components_of_opposite_orientation_are_joined() {
        let (open, whole) = cut(&ring(), 0.0);
        let disc = crate::mesh::components(&open.topology).count as u32 - 1;
        let stitched = stitch(&open.with_flipped(&[disc]), 0.0);
        assert_eq!(stitched, Ok(whole));
    }

    #[test]
    fn closed_meshes_are_not_changed() {
        let (_, whole) = cut(&[], 0.0);
        assert_eq!(stitching_tolerance(&whole), 0.0);
        assert_eq!(stitch(&whole, 0.5), Ok(whole));
    }
}
