//! Joint tests of the basis, the stencils and the masks on whole meshes.

use super::basis::DERIVATIVES;
use super::folding::{Folder, Folding};
use super::test_meshes::{Noise, Shape, antiprism, grid, shapes};
use super::*;
use crate::mesh::{DVec3, FaceId, Topology, VertexId};

/// Position and derivatives of the limit surface at a point of a face, by the general path.
fn surface_at(topology: &Topology, positions: &[DVec3], f: FaceId, v: f64, w: f64) -> [DVec3; 6] {
    let (folding, vertices) = fold(topology, f);
    let rows = basis_at(folding.valences, v, w);
    let mut data = vec![0.0; DERIVATIVES * rows.len()];
    for (i, row) in rows.iter().enumerate() {
        for d in 0..DERIVATIVES {
            data[d * rows.len() + i] = row[d];
        }
    }
    let table = folding.apply(&BasisTable {
        n: rows.len(),
        points: 1,
        data,
    });
    [0, 1, 2, 3, 4, 5].map(|d| combine(table.row(0, d), &vertices, positions))
}

fn fold(topology: &Topology, f: FaceId) -> (Folding, Vec<u32>) {
    Folder::new(topology).fold(f)
}

fn combine(row: &[f64], vertices: &[u32], positions: &[DVec3]) -> DVec3 {
    assert_eq!(row.len(), vertices.len());
    let terms = row.iter().zip(vertices);
    terms.map(|(&n, &v)| n * positions[v as usize]).sum()
}

fn all_faces(topology: &Topology) -> Vec<FaceId> {
    topology.faces().collect()
}

fn all_elements(topology: &Topology, rule: Rule) -> Elements {
    elements(topology, &all_faces(topology), rule)
}

/// The fast gathering and the general path agree; vertices are distinct, corners come first.
#[test]
fn elements_are_the_surface() {
    for Shape {
        name,
        topology,
        positions,
    } in shapes()
    {
        let found = all_elements(&topology, Rule::Twelve);
        let mut seen: Vec<u32> = found.faces().to_vec();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..topology.face_count() as u32));
        assert!(found.table_of().is_sorted());
        assert_eq!(found.offsets().len(), found.len() + 1);
        for e in 0..found.len() {
            let f = FaceId(found.faces()[e]);
            let vertices = found.vertices_of(e);
            let corners = topology.face_vertices(f).map(|v| v.0);
            assert_eq!(vertices[..3], corners);
            for (i, v) in vertices.iter().enumerate() {
                assert!(!vertices[..i].contains(v), "{name}: {v} twice");
            }
            let table = found.table(e);
            assert_eq!(table.n, vertices.len(), "{name}");
            for (q, &[v, w]) in Rule::Twelve.points().iter().enumerate() {
                let expected = surface_at(&topology, &positions, f, v, w);
                for d in 0..DERIVATIVES {
                    let x = combine(table.row(q, d), vertices, &positions);
                    assert!((x - expected[d]).length() < 1e-12, "{name} {f:?}");
                    let sum: f64 = table.row(q, d).iter().sum();
                    let unity = if d == 0 { 1.0 } else { 0.0 };
                    assert!((sum - unity).abs() < 1e-12);
                }
            }
        }
    }
}

/// Two triangles glued back to back have no limit surface; they stay unchanged.
#[test]
fn a_pillow_is_flat() {
    let pillow = Topology::from_triangles(3, &[[0, 1, 2], [0, 2, 1]]).expect("closed");
    let positions = [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 1.0, 0.5)];
    let found = all_elements(&pillow, Rule::Three);
    assert_eq!(found.vertices(), [0, 1, 2, 0, 2, 1]);
    for (q, &[v, w]) in Rule::Three.points().iter().enumerate() {
        let at = |d| combine(found.table(0).row(q, d), found.vertices_of(0), &positions);
        assert!((at(0) - v * positions[1] - w * positions[2]).length() < 1e-15);
        assert_eq!((at(1), at(2)), (positions[1], positions[2]));
        assert_eq!((at(3), at(4), at(5)), Default::default());
    }
    assert_eq!(limit_positions(&pillow, &positions), positions);
}

/// Both triangles at an edge give the same points and, away from its ends, the same first
/// derivatives in a common chart.
#[test]
fn triangles_join_smoothly() {
    for Shape {
        name,
        topology,
        positions,
    } in shapes()
    {
        for h in (0..topology.halfedge_count()).map(|h| crate::mesh::HalfedgeId(h as u32)) {
            if topology.is_boundary_edge(h) || h.0 % 2 == 1 {
                continue;
            }
            for t in [0.0, 0.03, 0.5, 0.7, 1.0] {
                let side = |h, t| {
                    let f = topology.face(h);
                    let from = corner_of(&topology, f, topology.origin(h));
                    let mut bary = [0.0; 3];
                    bary[from] = 1.0 - t;
                    bary[(from + 1) % 3] = t;
                    let at = surface_at(&topology, &positions, f, bary[1], bary[2]);
                    // derivatives along the edge and towards the opposite corner
                    let corner = [-at[1] - at[2], at[1], at[2]];
                    let grad = |k: usize| if k == 0 { DVec3::ZERO } else { corner[k] };
                    let [o, p, q] = [from, (from + 1) % 3, (from + 2) % 3].map(grad);
                    (at[0], p - o, q - o)
                };
                let (x, along, inward) = side(h, t);
                let (y, back, outward) = side(h.twin(), 1.0 - t);
                assert!((x - y).length() < 1e-13, "{name} {t}");
                if t > 0.0 && t < 1.0 {
                    // in the common chart the two opposite corners and the ends form a parallelogram
                    assert!((along + back).length() < 1e-12, "{name} {t}");
                    let jump = inward + outward;
                    assert!(jump.length() < 1e-12, "{name} {t}: {jump}");
                }
            }
        }
    }
}

/// A sample of a circle has the mean of the circle, so that the surface over it is Loop's.
#[test]
fn around_a_large_symmetric_ring_nothing_changes() {
    let n = 72;
    let (positions, triangles) = antiprism(n as u32);
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
    let (centre, ring) = limit_mask(n);
    let expected = centre * positions[0] + n as f64 * ring * 0.45 * DVec3::Z;
    assert!((limit_position(&topology, &positions, VertexId(0)) - expected).length() < 1e-14);
    for f in topology.faces().step_by(4) {
        assert!((surface_at(&topology, &positions, f, 0.0, 0.0)[0] - expected).length() < 1e-14);
    }
}

/// The control vertices of a face do not depend on the valence, nor do the tables.
#[test]
fn stencils_grow_linearly_with_the_valence() {
    let size = |n: u32| {
        let (positions, triangles) = antiprism(n);
        let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
        let found = all_elements(&topology, Rule::Twelve);
        let table = found.tables().iter().map(|t| t.data.len()).sum::<usize>();
        (found.vertices().len(), table)
    };
    let ((v, t), (v2, t2)) = (size(1200), size(2400));
    assert!(v <= 21 * 4800 && v2 <= 21 * 9600, "{v} {v2}");
    assert!(t2 <= t, "{t} {t2}");
}

fn corner_of(topology: &Topology, f: FaceId, v: VertexId) -> usize {
    let corners = topology.face_vertices(f);
    corners.iter().position(|&c| c == v).expect("a corner")
}

/// The mask at a vertex agrees with the basis of every adjacent triangle, in the position and in
/// the limit direction of the normal.
#[test]
fn limit_masks_are_the_surface_at_corners() {
    for Shape {
        name,
        topology,
        positions,
    } in shapes()
    {
        let limits = limit_positions(&topology, &positions);
        let normals = limit_normals(&topology, &positions);
        for f in all_faces(&topology) {
            let corners = topology.face_vertices(f);
            for (c, [v, w]) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let at = surface_at(&topology, &positions, f, v, w)[0];
                let limit = limits[corners[c].index()];
                assert!((at - limit).length() < 1e-14, "{name}");
                assert_eq!(limit, limit_position(&topology, &positions, corners[c]));
                let normal = normals[corners[c].index()];
                assert_eq!(normal, limit_normal(&topology, &positions, corners[c]));
                let (steps, rate) = (12, normal_rate(basis_valence(&topology, f, c)));
                let step = 0.5_f64.powi(steps);
                let [v, w] = [v, w].map(|x| x + (1.0 / 3.0 - x) * step);
                let near = surface_at(&topology, &positions, f, v, w);
                let direction = near[1].cross(near[2]).normalize();
                assert!((normal.length() - 1.0).abs() < 1e-14);
                let error = (direction - normal).length();
                let tolerance = 20.0 * rate.powi(steps);
                assert!(
                    error < tolerance,
                    "{name} {corners:?} {c}: {error:e} {tolerance:e}"
                );
            }
        }
    }
}

fn basis_valence(topology: &Topology, f: FaceId, corner: usize) -> usize {
    fold(topology, f).0.valences[corner]
}

/// Improvement of the normal with each halving of the distance to a vertex: the ratio of the third
/// to the second eigenvalue of the subdivision matrix.
fn normal_rate(n: usize) -> f64 {
    let eigenvalue = |j: f64| 0.375 + 0.25 * (std::f64::consts::TAU * j / n as f64).cos();
    let second = eigenvalue(1.0);
    let third = if n > 3 { eigenvalue(2.0) } else { 0.125 };
    third.max(second * second).max(0.125) / second
}

/// On a regular lattice with a boundary the parametrization is linear, except at the four corners
/// of the lattice, where fewer than three triangles meet.
#[test]
fn straight_boundary_of_a_regular_mesh_is_reproduced() {
    let (m, n) = (6, 5);
    let (positions, triangles) = grid(m, n, || false);
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("a grid");
    let found = all_elements(&topology, Rule::Three);
    let mut exact = 0;
    for e in 0..found.len() {
        let corners = topology.face_vertices(FaceId(found.faces()[e]));
        let [a, b, c] = corners.map(|v| positions[v.index()]);
        let lattice_corner =
            |v: VertexId| topology.is_boundary_vertex(v) && topology.valence(v) != 4;
        if corners.into_iter().any(lattice_corner) {
            continue;
        }
        exact += 1;
        for (q, &[v, w]) in Rule::Three.points().iter().enumerate() {
            let at = |d| combine(found.table(e).row(q, d), found.vertices_of(e), &positions);
            assert!((at(0) - (a + v * (b - a) + w * (c - a))).length() < 1e-14);
            assert!((at(1) - (b - a)).length() < 2e-14);
            assert!((at(2) - (c - a)).length() < 2e-14);
            for d in 3..DERIVATIVES {
                assert!(at(d).length() < 1e-13);
            }
        }
    }
    // one or two triangles at each corner of the lattice are not
    assert_eq!(exact, 2 * m * n - 6);
}

/// Functions linear in space are reproduced by any mesh, ghosts included: a planar mesh has a
/// planar limit surface with the plane's normal.
#[test]
fn planes_stay_planes() {
    let mut noise = Noise::new(11);
    let (mut positions, triangles) = grid(6, 6, || noise.next() > 0.0);
    let mut noise = Noise::new(12);
    for p in &mut positions {
        p.x += 0.2 * noise.next();
        p.y += 0.2 * noise.next();
        p.z = 3.0 + 0.5 * p.x - 0.25 * p.y;
    }
    let normal = DVec3::new(-0.5, 0.25, 1.0).normalize();
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("a grid");
    let found = all_elements(&topology, Rule::Twelve);
    for e in 0..found.len() {
        for q in 0..12 {
            for d in 0..DERIVATIVES {
                let x = combine(found.table(e).row(q, d), found.vertices_of(e), &positions);
                let constant = if d == 0 { 3.0 * normal.z } else { 0.0 };
                let error = (x.dot(normal) - constant).abs();
                // coordinates up to 8; each order of derivative loses up to a factor 6
                let tolerance = 1e-13 * [1.0, 6.0, 6.0, 36.0, 36.0, 36.0][d];
                assert!(error < tolerance, "{d} {error:e}");
            }
        }
    }
    for (n, x) in limit_normals(&topology, &positions)
        .into_iter()
        .zip(limit_positions(&topology, &positions))
    {
        assert!((n - normal).length() < 1e-13);
        assert!((x.dot(normal) - 3.0 * normal.z).abs() < 1e-13);
    }
}

/// Limit positions and normals move with the mesh, also far from the origin.
#[test]
fn rigid_motion() {
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
    let shift = DVec3::new(1e6, -2e6, 0.5e6);
    for Shape {
        name,
        topology,
        positions,
    } in shapes()
    {
        let moved: Vec<DVec3> = positions.iter().map(|&p| turn * p + shift).collect();
        let before = limit_positions(&topology, &positions);
        let normals = limit_normals(&topology, &positions);
        let after = limit_positions(&topology, &moved);
        let turned = limit_normals(&topology, &moved);
        for v in 0..positions.len() {
            // a few units in the last place of the shift
            let error = (turn * before[v] + shift - after[v]).length();
            assert!(error < 4e-9, "{name}: {error:e}");
            let error = (turn * normals[v] - turned[v]).length();
            assert!(error < 1e-7, "{name}: {error:e}");
        }
    }
}

/// The result does not depend on the content of the cache.
#[test]
fn caches_do_not_show() {
    for shape in shapes() {
        let faces = all_faces(&shape.topology);
        let first = all_elements(&shape.topology, Rule::Three);
        let again = all_elements(&shape.topology, Rule::Three);
        let fresh = elements_at(&shape.topology, &faces, Rule::Three.points());
        for shared in [&first, &again] {
            assert_eq!(fresh.tables(), shared.tables());
            assert_eq!(fresh.table_of(), shared.table_of());
            assert_eq!(fresh.vertices(), shared.vertices());
        }
    }
    assert!(elements(&shapes()[0].topology, &[], Rule::Three).is_empty());
}
