//! A strip of triangles across a hole, or from one hole to another.

use crate::fill::hermite::{RimFrame, hermite_between, length, pieces};
use crate::fill::select::nearest_loop;
use crate::mesh::{
    BoundaryLoop, DVec3, FaceId, LoopId, Mesh, Topology, TopologyError, self_intersections,
};
use crate::warning::{MAX_PAIRS, Warning};

/// Consecutive edges of a rim, in the direction of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RimSegment {
    /// The loop.
    pub hole: LoopId,
    /// Index of the first vertex along the loop.
    pub start: usize,
    /// Number of edges.
    pub edges: usize,
}

/// Why a bridge cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BridgeError {
    /// The segments have different numbers of edges, or none.
    #[error(
        "the two ends of a bridge need the same number of rim edges, at least one; they have {0} \
         and {1}"
    )]
    Widths(usize, usize),
    /// The segments meet, or no rim remains beside the bridge.
    #[error(
        "the two ends of the bridge meet; choose points farther apart on the rim, or a narrower \
         bridge"
    )]
    Meet,
    /// The loop does not exist.
    #[error("loop {hole} does not exist: the mesh has {loops} boundary loops")]
    NoSuchLoop {
        /// The number given.
        hole: LoopId,
        /// Number of loops of the mesh.
        loops: usize,
    },
    /// The mesh with the bridge is not a manifold.
    #[error("the bridged mesh would not be manifold ({0}); choose other points on the rims")]
    NotManifold(#[from] TopologyError),
}

/// The segment of `edges` edges centred at the rim vertex nearest to `point`; `None` if the mesh
/// has no loops.
pub fn segment_at(
    mesh: &Mesh,
    loops: &[BoundaryLoop],
    point: DVec3,
    edges: usize,
) -> Option<RimSegment> {
    let hole = nearest_loop(mesh, loops, point)?;
    let rim = &loops[hole.index()].vertices;
    let distance = |i: &usize| mesh.position(rim[*i]).distance_squared(point);
    let middle = (0..rim.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)))?;
    Some(RimSegment {
        hole,
        start: (middle + rim.len() - (edges / 2) % rim.len()) % rim.len(),
        edges,
    })
}

/// The mesh with a strip of triangles between two segments of its rims. A bridge across a hole
/// splits it into two; a bridge between two holes merges them.
///
/// The strip is tangent to the surface at both rims: a cubic Hermite curve starts at each rim
/// vertex. The triangles along the strip are as long as the rim edges. Old vertices and faces come
/// first, unchanged.
///
/// # Errors
/// [`BridgeError`].
pub fn bridge(
    mesh: &Mesh,
    loops: &[BoundaryLoop],
    from: RimSegment,
    to: RimSegment,
) -> Result<Mesh, BridgeError> {
    let strip = bridge_strip(mesh, loops, from, to)?;
    let rows = strip.len() - 1;
    let (near, far) = (&loops[from.hole.index()], &loops[to.hole.index()]);
    let width = from.edges;
    let (at, across) = (near_index(near, from), far_index(far, to));
    let first = mesh.vertex_count();
    let mut positions = mesh.positions.clone();
    let mut ends = Vec::new();
    for (row, points) in strip.iter().enumerate().take(rows).skip(1) {
        let t = row as f64 / rows as f64;
        for (k, &point) in points.iter().enumerate() {
            positions.push(point);
            ends.push(([near.vertices[at(k)], far.vertices[across(k)]], t));
        }
    }
    let vertex = |row: usize, k: usize| -> u32 {
        match row {
            0 => near.vertices[at(k)].0,
            _ if row == rows => far.vertices[across(k)].0,
            _ => (first + (row - 1) * (width + 1) + k) as u32,
        }
    };
    let mut faces: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    for row in 0..rows {
        for k in 0..width {
            let quad = [(row, k), (row, k + 1), (row + 1, k + 1), (row + 1, k)];
            let [a, b, c, d] = quad.map(|(row, k)| vertex(row, k));
            let span = |u: u32, v: u32| positions[u as usize].distance(positions[v as usize]);
            if span(a, c) <= span(b, d) {
                faces.extend([[a, b, c], [a, c, d]]);
            } else {
                faces.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    let given = mesh.face_count();
    let beside = mesh.topology.face(near.halfedges[from.start].twin());
    let mut attributes = mesh.attributes.clone();
    attributes.append_vertices(first, &ends);
    attributes.append_triangles(given, beside.index(), None, &faces[given..]);
    Ok(Mesh {
        topology: Topology::from_triangles(positions.len(), &faces)?,
        positions,
        attributes,
        ..mesh.clone()
    })
}

/// The points of a [`bridge`] in rows from rim to rim. Each row has one point more than the bridge is wide.
///
/// # Errors
/// [`BridgeError`], but whether the bridged mesh is a manifold is not known yet.
pub fn bridge_strip(
    mesh: &Mesh,
    loops: &[BoundaryLoop],
    from: RimSegment,
    to: RimSegment,
) -> Result<Vec<Vec<DVec3>>, BridgeError> {
    check(loops, from, to)?;
    let (near, far) = (&loops[from.hole.index()], &loops[to.hole.index()]);
    let width = from.edges;
    let (at, across) = (near_index(near, from), far_index(far, to));
    let rails: Vec<[RimFrame; 2]> = (0..=width)
        .map(|k| {
            [
                RimFrame::of(mesh, near, at(k)),
                RimFrame::of(mesh, far, across(k)),
            ]
        })
        .collect();
    let curve = |k: usize, t: f64| {
        let [a, b] = rails[k];
        hermite_between(a.point, a.ahead, b.point, -b.ahead)(t)
    };
    let size = near.perimeter / near.edges() as f64 + far.perimeter / far.edges() as f64;
    // at least two rows, so that no edge occurs twice
    let rows = pieces(length(|t| curve(width / 2, t)), 0.5 * size, 2);

    let row = |row: usize| {
        let t = row as f64 / rows as f64;
        (0..=width).map(|k| curve(k, t)).collect()
    };
    Ok((0..=rows).map(row).collect())
}

/// Indices along the near rim of a bridge, by the rail.
fn near_index(near: &BoundaryLoop, from: RimSegment) -> impl Fn(usize) -> usize {
    let n = near.edges();
    move |k| (from.start + k) % n
}

/// The same along the far rim, which has the opposite direction: its last vertex is opposite the first.
fn far_index(far: &BoundaryLoop, to: RimSegment) -> impl Fn(usize) -> usize {
    let n = far.edges();
    move |k| (to.start + to.edges - k) % n
}

/// The warning that a [`bridge`] intersects itself or the mesh `before` it; `None` if it does not.
pub fn bridge_warning(before: &Mesh, bridged: &Mesh) -> Option<Warning> {
    let faces: Vec<[u32; 3]> = bridged.topology.triangles().collect();
    let new: Vec<u32> = (before.face_count() as u32..faces.len() as u32).collect();
    let pairs = self_intersections(&bridged.positions, &faces, Some(&new), MAX_PAIRS);
    let corners = |&[f, g]: &[u32; 2]| [f, g].map(|f| bridged.corners(FaceId(f)));
    let all = pairs.first().map(corners)?;
    Some(Warning::SelfIntersection {
        pairs: pairs.len(),
        at: all.iter().flatten().sum::<DVec3>() / 6.0,
        kept_step: None,
    })
}

fn check(loops: &[BoundaryLoop], from: RimSegment, to: RimSegment) -> Result<(), BridgeError> {
    for segment in [from, to] {
        if segment.hole.index() >= loops.len() {
            return Err(BridgeError::NoSuchLoop {
                hole: segment.hole,
                loops: loops.len(),
            });
        }
    }
    if from.edges == 0 || from.edges != to.edges {
        return Err(BridgeError::Widths(from.edges, to.edges));
    }
    let vertices = |s: RimSegment| {
        let rim = &loops[s.hole.index()].vertices;
        (0..=s.edges).map(move |k| rim[(s.start + k) % rim.len()])
    };
    let fits = |s: RimSegment| s.edges < loops[s.hole.index()].edges();
    let apart = vertices(from).all(|v| vertices(to).all(|w| v != w));
    if apart && fits(from) && fits(to) {
        Ok(())
    } else {
        Err(BridgeError::Meet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{boundary_loops, check_mesh};
    use crate::shapes;

    fn holed() -> Mesh {
        let ball = shapes::sphere(2000, 7);
        let (positions, triangles) = shapes::cut_where(&ball, |p| p.z > 0.7 || p.z < -0.8);
        Mesh::from_triangles(positions, &triangles).expect("manifold")
    }

    #[test]
    fn a_bridge_cuts_a_hole_in_two_and_joins_two_to_one() {
        let mesh = holed();
        let loops = boundary_loops(&mesh);
        assert_eq!(loops.len(), 2);
        let at = |x: f64, z: f64, edges: usize| {
            segment_at(&mesh, &loops, DVec3::new(x, 0.0, z), edges).expect("loops")
        };
        for width in 1..5 {
            let across = bridge(&mesh, &loops, at(-1.0, 0.7, width), at(1.0, 0.7, width));
            let across = across.expect("a bridge");
            let strip = bridge_strip(&mesh, &loops, at(-1.0, 0.7, width), at(1.0, 0.7, width));
            let strip = strip.expect("a strip");
            let [inner @ .., last] = &strip[1..] else {
                panic!("one row")
            };
            assert_eq!(inner.concat(), across.positions[mesh.vertex_count()..]);
            let is_on_rim = |p: &DVec3| mesh.positions.iter().any(|q| q.distance(*p) < 1e-12);
            assert!(strip[0].iter().chain(last).all(is_on_rim));
            check_mesh(&across).expect("sound");
            assert_eq!(across.topology.boundary_loops().len(), 3);
            let triangles: Vec<_> = across.topology.triangles().collect();
            assert!(self_intersections(&across.positions, &triangles, None, 1).is_empty());
            // the strip is tangent to the sphere and stays near it across the hole
            let new = &across.positions[mesh.vertex_count()..];
            let off = new.iter().map(|p| (p.length() - 1.0).abs());
            let off = off.fold(0.0, f64::max);
            // measured: 0.029; the rim deviates from a circle by one edge, 0.08
            assert!(off < 0.03, "{off}");
            let joined = bridge(&mesh, &loops, at(1.0, 0.7, width), at(1.0, -0.8, width));
            assert_eq!(joined.expect("a bridge").topology.boundary_loops().len(), 1);
        }
    }

    #[test]
    fn a_bridge_through_a_plate_is_said() {
        for (height, is_crossing) in [(0.0, true), (2.0, false)] {
            // a triangle in the plane of x = 0 above the hole
            let (mut positions, mut triangles) =
                shapes::cut_where(&shapes::sphere(2000, 7), |p| p.z > 0.7);
            let first = positions.len() as u32;
            let plate = [(-0.5, 0.9), (0.5, 0.9), (0.0, 1.5)];
            positions.extend(plate.map(|(y, z)| DVec3::new(0.0, y, z + height)));
            triangles.push([first, first + 1, first + 2]);
            let mesh = Mesh::from_triangles(positions, &triangles).expect("manifold");
            let loops = boundary_loops(&mesh);
            let [from, to] = [-1.0, 1.0]
                .map(|x| segment_at(&mesh, &loops, DVec3::new(x, 0.0, 0.7), 2).expect("loops"));
            let bridged = bridge(&mesh, &loops, from, to).expect("a bridge");
            let warning = bridge_warning(&mesh, &bridged);
            assert_eq!(warning.is_some(), is_crossing);
            let at = warning.map(|warning| match warning {
                Warning::SelfIntersection { at, .. } => at,
                other => panic!("{other}"),
            });
            assert!(at.is_none_or(|at| at.distance(DVec3::Z) < 0.3), "{at:?}");
        }
    }

    #[test]
    fn ends_that_meet_are_refused() {
        let mesh = holed();
        let loops = boundary_loops(&mesh);
        let segment = |start, edges| RimSegment {
            hole: LoopId::FIRST,
            start,
            edges,
        };
        let error = |a, b| bridge(&mesh, &loops, a, b).err();
        assert_eq!(error(segment(0, 2), segment(2, 2)), Some(BridgeError::Meet));
        assert_eq!(
            error(segment(0, 2), segment(9, 1)),
            Some(BridgeError::Widths(2, 1))
        );
        let missing = RimSegment {
            hole: 2.into(),
            ..segment(0, 1)
        };
        let no = BridgeError::NoSuchLoop {
            hole: 2.into(),
            loops: 2,
        };
        assert_eq!(error(segment(0, 1), missing), Some(no));
    }
}
