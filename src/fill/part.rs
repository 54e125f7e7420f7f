//! A part of a hole: a polygon of vertices of its rim and of new vertices on curves through it.

use crate::fill::hole::HoleRims;
use crate::fill::rim::rim_of;
use crate::mesh::{BoundaryLoop, DVec3, Mesh, Topology, TopologyError, VertexId, rms_distance};
use crate::patch::{Rim, RimGeometry};

/// A corner of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Corner {
    /// A vertex of the rim of the hole, by its index along the loop.
    Rim(usize),
    /// A new vertex, by its index in [`NewVertices`].
    New(usize),
}

/// New vertices on curves through a hole. They have no faces yet.
#[derive(Clone, Debug, Default)]
pub(super) struct NewVertices {
    pub points: Vec<DVec3>,
    /// Where the attributes of each come from: two vertices of the mesh, and the place between them,
    /// from 0 at the first to 1 at the second.
    between: Vec<([VertexId; 2], f64)>,
}

impl NewVertices {
    /// Adds the points of a curve that leaves the first of two vertices of the mesh and covers a `share`,
    /// at most 1, of the way to the second. Returns their corners, in order.
    pub fn add_curve(
        &mut self,
        points: &[DVec3],
        ends: [VertexId; 2],
        share: f64,
    ) -> impl DoubleEndedIterator<Item = Corner> + Clone + use<> {
        let first = self.points.len();
        self.points.extend_from_slice(points);
        let ratio = |i: usize| share * (i + 1) as f64 / (points.len() + 1) as f64;
        let between = (0..points.len()).map(|i| (ends, ratio(i)));
        self.between.extend(between);
        (first..self.points.len()).map(Corner::New)
    }
}

/// For each corner of a part the edge of the hole's rim that begins there, by its index, if the part has
/// that edge and it is not one of those `without` faces.
pub(super) fn rim_edges(
    hole: &BoundaryLoop,
    corners: &[Corner],
    without: &[usize],
) -> Vec<Option<usize>> {
    let rim_edge = |k: usize| match [corners[k], corners[(k + 1) % corners.len()]] {
        [Corner::Rim(i), Corner::Rim(j)] if j == (i + 1) % hole.edges() => {
            (!without.contains(&i)).then_some(i)
        }
        _ => None,
    };
    (0..corners.len()).map(rim_edge).collect()
}

/// The rim of a part with these corners and [edges](rim_edges), in the loop's direction. The edges along
/// the rim of the hole keep their faces; the others have none. `first` is the number in the mesh of the
/// first new vertex.
pub(super) fn rims_of_part(
    mesh: &Mesh,
    hole: &BoundaryLoop,
    corners: &[Corner],
    edges: &[Option<usize>],
    new: &[DVec3],
    first: usize,
) -> HoleRims {
    let whole = rim_of(mesh, hole);
    let point = |&corner: &Corner| match corner {
        Corner::Rim(i) => whole.points[i],
        Corner::New(i) => new[i],
    };
    let vertex = |&corner: &Corner| match corner {
        Corner::Rim(i) => hole.vertices[i],
        Corner::New(i) => VertexId::from(first + i),
    };
    let points: Vec<DVec3> = corners.iter().map(point).collect();
    let opposite = edges.iter().zip(&points);
    let mut place = vec![u32::MAX; hole.edges()];
    for (k, corner) in (0..).zip(corners) {
        if let &Corner::Rim(i) = corner {
            place[i] = k;
        }
    }
    let forbidden = (whole.forbidden.iter())
        .map(|pair| pair.map(|i| place[i as usize]))
        .filter(|pair| !pair.contains(&u32::MAX))
        .map(|[i, j]| [i.min(j), i.max(j)]);
    let rim = Rim {
        // on the edge where there is no face: a degenerate face has no influence
        opposite: opposite
            .map(|(edge, &start)| edge.map_or(start, |i| whole.opposite[i]))
            .collect(),
        forbidden: forbidden.collect(),
        points,
    };
    let centroid = rim.points.iter().sum::<DVec3>() / rim.points.len() as f64;
    let part = BoundaryLoop {
        halfedges: edges.iter().flatten().map(|&i| hole.halfedges[i]).collect(),
        vertices: corners.iter().map(vertex).collect(),
        centroid,
        radius: rms_distance(rim.points.iter().copied(), centroid),
        ..hole.clone()
    };
    HoleRims::with_geometry(vec![part], RimGeometry::single(rim))
}

/// The mesh with additional vertices, which have no faces yet.
pub(super) fn with_vertices(mesh: &Mesh, new: &[&NewVertices]) -> Result<Mesh, TopologyError> {
    let mut longer = mesh.clone();
    let points = new.iter().flat_map(|new| &new.points);
    longer.positions.extend(points);
    let between: Vec<_> = new.iter().flat_map(|new| new.between.clone()).collect();
    longer
        .attributes
        .append_vertices(mesh.vertex_count(), &between);
    let faces: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    longer.topology = Topology::from_triangles(longer.positions.len(), &faces)?;
    Ok(longer)
}
