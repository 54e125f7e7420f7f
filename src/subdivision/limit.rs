//! Limit positions and limit normals of the vertices of a mesh.

use std::sync::LazyLock;

use super::masks::{EXACT_VALENCE, limit_mask, sample, tangent_mask};
use super::ring::{Neighbour, extended_ring};
use crate::mesh::{DVec3, Topology, VertexId};

/// Masks are tabulated for valences up to this.
const TABULATED: usize = 32;

/// Limit position weight of a neighbour and tangent weights, by valence.
static MASKS: LazyLock<Vec<Mask>> = LazyLock::new(|| (0..=TABULATED).map(Mask::new).collect());

#[derive(Clone)]
struct Mask {
    omega: f64,
    tangents: Vec<(f64, f64)>,
}

impl Mask {
    fn new(n: usize) -> Self {
        Self {
            omega: position_weight(n),
            tangents: tangent_mask(n).collect(),
        }
    }
}

/// Weight of each of the neighbours in the [`sample`] of `n` in the limit position.
fn position_weight(n: usize) -> f64 {
    match n {
        ..3 => 0.0,
        3..=EXACT_VALENCE => limit_mask(n).1,
        _ => n as f64 * limit_mask(n).1 / sample(n).len() as f64,
    }
}

/// Calls `f` with the number of neighbours of the vertex, its mask and the differences of its
/// neighbours to it, counter-clockwise. Differences avoid cancellation far from the origin.
fn with_star<T>(
    topology: &Topology,
    positions: &[DVec3],
    v: VertexId,
    ring: &mut Vec<Neighbour>,
    f: impl FnOnce(usize, &Mask, &dyn Fn(usize) -> DVec3) -> T,
) -> T {
    extended_ring(topology, v, ring);
    let centre = positions[v.index()];
    let spoke = |i: usize| ring[i].position(positions) - centre;
    if let Some(mask) = MASKS.get(ring.len()) {
        f(ring.len(), mask, &spoke)
    } else {
        f(ring.len(), &Mask::new(ring.len()), &spoke)
    }
}

fn position_with(
    topology: &Topology,
    positions: &[DVec3],
    v: VertexId,
    ring: &mut Vec<Neighbour>,
) -> DVec3 {
    let shift = with_star(topology, positions, v, ring, |n, mask, spoke| {
        mask.omega * sample(n).map(spoke).sum::<DVec3>()
    });
    positions[v.index()] + shift
}

fn normal_with(
    topology: &Topology,
    positions: &[DVec3],
    v: VertexId,
    ring: &mut Vec<Neighbour>,
) -> DVec3 {
    with_star(topology, positions, v, ring, |n, mask, spoke| {
        let (mut t1, mut t2) = (DVec3::ZERO, DVec3::ZERO);
        for (spoke, &(cos, sin)) in (0..n).map(spoke).zip(&mask.tangents) {
            t1 += cos * spoke;
            t2 += sin * spoke;
        }
        t1.cross(t2).normalize_or_zero()
    })
}

/// The limit position of a control vertex; the vertex itself if it has no triangles. At an open
/// boundary the mesh is continued by ghosts, as in [`super::elements()`].
pub fn limit_position(topology: &Topology, positions: &[DVec3], v: VertexId) -> DVec3 {
    position_with(topology, positions, v, &mut Vec::new())
}

/// Fills `points` with the neighbours of `v` counter-clockwise, starting at its neighbour `first`;
/// at an open boundary including ghosts. Empty for a vertex without triangles.
pub fn ring_points(
    topology: &Topology,
    positions: &[DVec3],
    v: VertexId,
    first: VertexId,
    points: &mut Vec<DVec3>,
) {
    let mut ring = Vec::new();
    extended_ring(topology, v, &mut ring);
    let turn = ring.iter().position(|&n| n == Neighbour::Real(first));
    ring.rotate_left(turn.unwrap_or(0));
    points.clear();
    points.extend(ring.iter().map(|n| n.position(positions)));
}

/// Appends the weights of the limit position of a vertex as `(vertex, weight)`: first its own, then
/// those of its neighbours, above [`EXACT_VALENCE`] of their sample. The weights of ghosts are distributed to the vertices that define them.
/// A vertex may occur several times.
pub fn limit_stencil(topology: &Topology, v: VertexId, stencil: &mut Vec<(u32, f64)>) {
    let mut ring = Vec::new();
    extended_ring(topology, v, &mut ring);
    let omega = position_weight(ring.len());
    let neighbours = sample(ring.len());
    stencil.push((v.0, 1.0 - neighbours.len() as f64 * omega));
    for i in neighbours {
        ring[i].scatter(omega, |w, weight| stencil.push((w.0, weight)));
    }
}

/// Appends the weights of the two tangents of [`tangent_mask`] at a vertex as `(vertex, [t1, t2])`.
/// The tangents span the plane orthogonal to [`limit_normal`]. Otherwise as [`limit_stencil`].
pub fn tangent_stencil(topology: &Topology, v: VertexId, stencil: &mut Vec<(u32, [f64; 2])>) {
    let mut ring = Vec::new();
    extended_ring(topology, v, &mut ring);
    let fresh;
    let mask = if let Some(mask) = MASKS.get(ring.len()) {
        mask
    } else {
        fresh = Mask::new(ring.len());
        &fresh
    };
    for (neighbour, &(cos, sin)) in ring.iter().zip(&mask.tangents) {
        neighbour.scatter(1.0, |w, sign| stencil.push((w.0, [sign * cos, sign * sin])));
    }
}

/// [`limit_position`] of every vertex.
pub fn limit_positions(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    let mut ring = Vec::new();
    (0..topology.vertex_count())
        .map(|v| position_with(topology, positions, VertexId::from(v), &mut ring))
        .collect()
}

/// Unit normal of the limit surface at the limit position of a control vertex, on the side from
/// which the triangles run counter-clockwise. It is zero if the tangents are parallel or vanish,
/// and for a vertex without triangles. At an open boundary the mesh is continued by ghosts.
pub fn limit_normal(topology: &Topology, positions: &[DVec3], v: VertexId) -> DVec3 {
    normal_with(topology, positions, v, &mut Vec::new())
}

/// [`limit_normal`] of every vertex.
pub fn limit_normals(topology: &Topology, positions: &[DVec3]) -> Vec<DVec3> {
    let mut ring = Vec::new();
    (0..topology.vertex_count())
        .map(|v| normal_with(topology, positions, VertexId::from(v), &mut ring))
        .collect()
}
