//! Loop's and the modified Butterfly scheme: one step of stationary subdivision.
//!
//! Both schemes continue an open mesh by ghosts, as [`crate::subdivision`] does. Boundary curves
//! depend on boundary vertices only.

use std::f64::consts::TAU;

use crate::mesh::{DVec3, HalfedgeId, Split, Topology, VertexId, edge_diamond};
use crate::subdivision::{EDGE_END, EDGE_OPPOSITE, beta, ring_points};

/// Loop's scheme: new positions of all vertices, old and new, of a mesh whose edges were split.
/// Boundaries are cubic B-splines; the boundary vertices at `corners` (one flag per vertex, or
/// empty) stay. Where the mesh was split everywhere, the control points before and after have the
/// same limit surface.
pub fn loop_step(
    topology: &Topology,
    positions: &[DVec3],
    split: &Split,
    corners: &[bool],
) -> Vec<DVec3> {
    let at = |v: VertexId| positions[v.index()];
    let mut new = Vec::with_capacity(split.vertex_count(topology));
    for v in (0..positions.len()).map(VertexId::from) {
        new.push(if is_flagged(corners, v) {
            at(v)
        } else {
            at(v) + loop_shift(topology, positions, v)
        });
    }
    for &h in &split.edges {
        let ([a, b], opposite) = edge_diamond(topology, h);
        let ends = at(a) + at(b);
        new.push(match opposite {
            [Some(c), Some(d)] => EDGE_END * ends + EDGE_OPPOSITE * (at(c) + at(d)),
            _ => 0.5 * ends,
        });
    }
    new
}

fn is_flagged(flags: &[bool], v: VertexId) -> bool {
    flags.get(v.index()).copied().unwrap_or(false)
}

/// The displacement of an old vertex by Loop's scheme.
fn loop_shift(topology: &Topology, positions: &[DVec3], v: VertexId) -> DVec3 {
    let p = positions[v.index()];
    let spoke = |w: VertexId| positions[w.index()] - p;
    if !topology.has_faces(v) {
        return DVec3::ZERO;
    }
    if topology.is_boundary_vertex(v) {
        // a pinched vertex stays, because the curves of all its boundary loops would have to meet
        // there
        let [a, b] = boundary_neighbours(topology, v)[..] else {
            return DVec3::ZERO;
        };
        return 0.125 * (spoke(a) + spoke(b));
    }
    let n = topology.valence(v);
    if n < 3 {
        return DVec3::ZERO;
    }
    beta(n) * topology.neighbours(v).map(spoke).sum::<DVec3>()
}

/// Neighbours of a vertex along the boundary.
fn boundary_neighbours(topology: &Topology, v: VertexId) -> Vec<VertexId> {
    topology
        .outgoing(v)
        .filter(|&h| topology.is_boundary_edge(h))
        .map(|h| topology.target(h))
        .collect()
}

/// The modified Butterfly scheme (Zorin, Schröder and Sweldens, "Interpolating Subdivision for
/// Meshes with Arbitrary Topology", 1996). Returns the positions of all vertices; the old ones are
/// unchanged. On a boundary it is the four-point scheme, continued straight beyond `corners` (one
/// flag per vertex, or empty).
pub fn butterfly_step(
    topology: &Topology,
    positions: &[DVec3],
    split: &Split,
    corners: &[bool],
) -> Vec<DVec3> {
    let mut new = positions.to_vec();
    let mut rings = [Vec::new(), Vec::new()];
    for &h in &split.edges {
        new.push(if topology.is_boundary_edge(h) {
            four_point(topology, positions, h, corners)
        } else {
            butterfly_point(topology, positions, h, &mut rings)
        });
    }
    new
}

fn butterfly_point(
    topology: &Topology,
    positions: &[DVec3],
    h: HalfedgeId,
    rings: &mut [Vec<DVec3>; 2],
) -> DVec3 {
    let ends = [topology.origin(h), topology.target(h)];
    for k in 0..2 {
        ring_points(topology, positions, ends[k], ends[1 - k], &mut rings[k]);
    }
    let [p, q] = ends.map(|v| positions[v.index()]);
    let irregular: Vec<usize> = (0..2).filter(|&k| rings[k].len() != 6).collect();
    if irregular.is_empty() {
        let [a, b] = rings;
        let wings = a[2] + a[4] + b[2] + b[4];
        return 0.5 * (p + q) + 0.125 * (a[1] + a[5]) - 0.0625 * wings;
    }
    let from = |k: usize| irregular_point([p, q][k], &rings[k]);
    irregular.iter().map(|&k| from(k)).sum::<DVec3>() / irregular.len() as f64
}

/// The new point on the edge from a vertex of valence other than 6 to the first of its ring.
fn irregular_point(centre: DVec3, ring: &[DVec3]) -> DVec3 {
    let n = ring.len();
    let weight = |j: usize| match (n, j) {
        (3, 0) => 5.0 / 12.0,
        (3, _) => -1.0 / 12.0,
        (4, 0) => 3.0 / 8.0,
        (4, 2) => -1.0 / 8.0,
        (4, _) => 0.0,
        _ => {
            let angle = TAU * j as f64 / n as f64;
            (0.25 + angle.cos() + 0.5 * (2.0 * angle).cos()) / n as f64
        }
    };
    // the weights sum up to 1/4; differences avoid cancellation on a mesh far from the origin
    let pull = ring
        .iter()
        .enumerate()
        .map(|(j, &p)| weight(j) * (p - centre));
    centre + pull.sum::<DVec3>()
}

/// `(-1, 9, 9, -1) / 16` along the boundary.
fn four_point(topology: &Topology, positions: &[DVec3], h: HalfedgeId, corners: &[bool]) -> DVec3 {
    let along = if topology.is_boundary(h) { h } else { h.twin() };
    let (p, q) = (topology.origin(along), topology.target(along));
    let beyond = |v: VertexId, other: VertexId| {
        let others: Vec<VertexId> = boundary_neighbours(topology, v)
            .into_iter()
            .filter(|&w| w != other)
            .collect();
        // at a corner or pinched vertex the curve has no unique continuation: use a straight one
        match others[..] {
            [w] if !is_flagged(corners, v) => positions[w.index()],
            _ => 2.0 * positions[v.index()] - positions[other.index()],
        }
    };
    let ends = positions[p.index()] + positions[q.index()];
    (9.0 * ends - beyond(p, q) - beyond(q, p)) / 16.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::split_all;
    use crate::shapes::{graph, icosphere, sphere};
    use crate::subdivision::limit_positions;

    fn topology((positions, triangles): &crate::shapes::TriangleMesh) -> Topology {
        Topology::from_triangles(positions.len(), triangles).expect("manifold")
    }

    #[test]
    fn loop_keeps_the_limit_surface() {
        let ball = sphere(200, 3);
        let old = topology(&ball);
        let split = split_all(&old);
        let new = loop_step(&old, &ball.0, &split, &[]);
        let fine = Topology::from_triangles(new.len(), &split.triangles).expect("closed");
        let (before, after) = (limit_positions(&old, &ball.0), limit_positions(&fine, &new));
        for (p, q) in before.iter().zip(&after) {
            assert!(p.distance(*q) < 1e-14);
        }
    }

    /// Both schemes commute with affine maps, and Butterfly keeps its old vertices bit-identical.
    #[test]
    fn affine_maps_commute() {
        for shape in [icosphere(2), graph(2.0, 5, |x, y| x * y, 1)] {
            let old = topology(&shape);
            let split = split_all(&old);
            let map = |p: DVec3| DVec3::new(2.0 * p.x + p.y, p.y - p.z, 0.5 * p.z) + 3.0;
            let mapped: Vec<DVec3> = shape.0.iter().map(|&p| map(p)).collect();
            for step in [loop_step, butterfly_step] {
                let (plain, moved) = (
                    step(&old, &shape.0, &split, &[]),
                    step(&old, &mapped, &split, &[]),
                );
                for (p, q) in plain.iter().zip(&moved) {
                    assert!(map(*p).distance(*q) < 1e-14);
                }
            }
            let kept = butterfly_step(&old, &shape.0, &split, &[]);
            assert_eq!(kept[..shape.0.len()], shape.0[..]);
        }
    }

    /// On the regular lattice Butterfly reproduces cubics.
    #[test]
    fn butterfly_reproduces_cubics() {
        let side = 8u32;
        let at = |i: u32, j: u32| i * side + j;
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        let height = |x: f64, y: f64| x * x * x - 2.0 * x * y * y + x * y + 0.3 * y * y - x;
        for i in 0..side {
            for j in 0..side {
                let (x, y) = (f64::from(j) - 3.0, f64::from(i) - 4.0);
                points.push(DVec3::new(x, y, height(x, y)));
                if i + 1 < side && j + 1 < side {
                    triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                    triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
                }
            }
        }
        let old = topology(&(points.clone(), triangles));
        let split = split_all(&old);
        let new = butterfly_step(&old, &points, &split, &[]);
        let mut inside = 0;
        for (k, &h) in split.edges.iter().enumerate() {
            let ends = [old.origin(h), old.target(h)];
            let deep = ends.iter().all(|&v| {
                !old.is_boundary_vertex(v) && old.neighbours(v).all(|w| !old.is_boundary_vertex(w))
            });
            if deep {
                let p = new[points.len() + k];
                assert!((p.z - height(p.x, p.y)).abs() < 1e-12);
                inside += 1;
            }
        }
        assert!(inside > 20);
    }

    #[test]
    fn boundary_curves_are_the_boundary_s_own() {
        let sheet = graph(2.0, 5, |x, y| x * x + y, 4);
        let old = topology(&sheet);
        let split = split_all(&old);
        let mut raised = sheet.0.clone();
        for v in (0..raised.len()).map(VertexId::from) {
            if !old.is_boundary_vertex(v) {
                raised[v.index()].z += 5.0;
            }
        }
        for step in [loop_step, butterfly_step] {
            let (low, high) = (
                step(&old, &sheet.0, &split, &[]),
                step(&old, &raised, &split, &[]),
            );
            for (k, &h) in split.edges.iter().enumerate() {
                let k = k + sheet.0.len();
                if old.is_boundary_edge(h) {
                    assert_eq!(low[k], high[k]);
                }
            }
        }
    }
}
