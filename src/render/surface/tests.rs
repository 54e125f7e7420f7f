use glam::DQuat;

use super::*;
use crate::render::Vertex;
use crate::shapes;

fn mesh(shape: &shapes::TriangleMesh) -> (Topology, &[DVec3]) {
    let topology = Topology::from_triangles(shape.0.len(), &shape.1).expect("a manifold");
    (topology, &shape.0)
}

fn all_faces(topology: &Topology) -> Vec<FaceId> {
    topology.faces().collect()
}

fn options(pieces: u32) -> SurfaceOptions {
    SurfaceOptions {
        samples_per_edge: Some(pieces),
        ..SurfaceOptions::default()
    }
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// Maximum errors of normals, `H r + 1` and `K r² − 1` on a sphere of frequency `n`.
fn sphere_errors(n: u32, pieces: u32) -> [f64; 3] {
    let shape = shapes::icosphere(n);
    let (topology, positions) = mesh(&shape);
    let surface = DynamicSurface::new(&topology, &all_faces(&topology), &options(pieces));
    let geometry = surface.evaluate(positions, DVec3::ZERO, true, None);
    let mut worst = [0.0f64; 3];
    for v in &geometry.vertices {
        assert_eq!(v.flags, Vertex::CURVATURE);
        let p = wide(v.position);
        let (r, h, k) = (p.length(), f64::from(v.mean), f64::from(v.gauss));
        let errors = [
            (wide(v.normal) - p / r).length(),
            (h * r + 1.0).abs(),
            (k * r * r - 1.0).abs(),
        ];
        for i in 0..3 {
            worst[i] = worst[i].max(errors[i]);
        }
    }
    worst
}

#[test]
fn a_sphere_has_its_normals_and_curvatures() {
    for pieces in [1, 3] {
        let coarse = sphere_errors(4, pieces);
        let fine = sphere_errors(16, pieces);
        // normals converge; curvatures keep the error of the twelve vertices of valence 5
        assert!(fine[0] < 0.5 * coarse[0] && fine[0] < 0.004, "{fine:?}");
        assert!(fine[1] < 0.05 && fine[2] < 0.1, "{fine:?}");
    }
}

#[test]
fn turning_and_moving_far_away_changes_nothing_else() {
    let shape = shapes::torus(2.0, 0.7, 400, 1);
    let (topology, positions) = mesh(&shape);
    let surface = DynamicSurface::new(&topology, &all_faces(&topology), &options(2));
    let before = surface.evaluate(positions, DVec3::ZERO, true, None);
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
    let shift = DVec3::new(1e6, -2e6, 5e5);
    let moved: Vec<DVec3> = positions.iter().map(|&p| turn * p + shift).collect();
    let after = surface.evaluate(&moved, shift, true, None);
    assert_eq!(before.triangles, after.triangles);
    for (a, b) in before.vertices.iter().zip(&after.vertices) {
        // rounding to f32, and the resolution 1e-10 of a coordinate of 1e6
        assert!((turn * wide(a.position) - wide(b.position)).length() < 1e-6);
        assert!((turn * wide(a.normal) - wide(b.normal)).length() < 1e-6);
        assert!((a.mean - b.mean).abs() < 1e-5 * (1.0 + a.mean.abs()));
        assert!((a.gauss - b.gauss).abs() < 1e-5 * (1.0 + a.gauss.abs()));
    }
}

#[test]
fn samples_form_the_same_surface_at_any_fineness() {
    for shape in [
        shapes::torus(2.0, 0.7, 300, 2),
        shapes::plane(1.0, 6, 3),
        shapes::icosphere(1),
    ] {
        let (topology, positions) = mesh(&shape);
        let euler = |t: &Topology| {
            let [v, e, f] = [t.vertex_count(), t.halfedge_count() / 2, t.face_count()]
                .map(|n| i64::try_from(n).expect("small"));
            v - e + f
        };
        let edges = topology.halfedge_count() / 2;
        for pieces in 1..=5 {
            let faces = all_faces(&topology);
            let surface = DynamicSurface::new(&topology, &faces, &options(pieces));
            let drawn = surface.evaluate(positions, DVec3::ZERO, true, None);
            let fine = Topology::from_triangles(drawn.vertices.len(), &drawn.triangles)
                .expect("neighbours share their samples");
            assert_eq!(euler(&fine), euler(&topology));
            assert_eq!(fine.boundary_loops().len(), topology.boundary_loops().len());
            let n = pieces as usize;
            assert_eq!(drawn.triangles.len(), n * n * faces.len());
            assert_eq!(drawn.edges.len(), n * edges);
            // normals are on the side of the triangles
            for t in &drawn.triangles {
                let [a, b, c] = t.map(|v| wide(drawn.vertices[v as usize].position));
                let sum: DVec3 = t
                    .iter()
                    .map(|&v| wide(drawn.vertices[v as usize].normal))
                    .sum();
                assert!((b - a).cross(c - a).dot(sum) > 0.0);
            }
        }
    }
}

/// Two halves of a square lattice, the right one folded up by 90° along `x = 0`.
fn folded() -> (Topology, Vec<DVec3>, Vec<[VertexId; 2]>) {
    let n = 4u32;
    let side = 2 * n + 1;
    let mut positions = Vec::new();
    for j in 0..side {
        for i in 0..side {
            let (x, y) = (f64::from(i) - f64::from(n), f64::from(j));
            positions.push(DVec3::new(x.min(0.0), y, x.max(0.0)));
        }
    }
    let at = |i: u32, j: u32| j * side + i;
    let mut triangles = Vec::new();
    for j in 0..2 * n {
        for i in 0..2 * n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    let creases = (0..2 * n)
        .map(|j| [VertexId(at(n, j)), VertexId(at(n, j + 1))])
        .collect();
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("a square");
    (topology, positions, creases)
}

#[test]
fn sides_of_a_crease_do_not_see_each_other() {
    let (topology, positions, creases) = folded();
    // only some faces, so that the result depends on the faces around them
    let faces: Vec<FaceId> = all_faces(&topology)
        .into_iter()
        .filter(|&f| {
            let [a, b, c] = topology.face_vertices(f).map(|v| positions[v.index()]);
            let centre = (a + b + c) / 3.0;
            centre.z - centre.x < 2.0 && (2.0..6.0).contains(&centre.y)
        })
        .collect();
    let normals = |creases: Vec<[VertexId; 2]>| -> Vec<(DVec3, DVec3, f32)> {
        let all = SurfaceOptions {
            creases,
            ..options(3)
        };
        let surface = DynamicSurface::new(&topology, &faces, &all);
        let drawn = surface.evaluate(&positions, DVec3::ZERO, true, None);
        let vertex = |v: &Vertex| (wide(v.position), wide(v.normal), v.mean);
        drawn.vertices.iter().map(vertex).collect()
    };
    let [floor, wall] = [DVec3::Z, DVec3::NEG_X];
    for (p, n, h) in normals(creases) {
        // two exact planes that meet in the fold
        assert!(p.x.abs() < 1e-6 || p.z.abs() < 1e-6, "{p}");
        assert!(
            (n - floor).length() < 1e-6 || (n - wall).length() < 1e-6,
            "{p}: {n}"
        );
        assert!(h.abs() < 1e-6);
        if p.x < -1e-6 {
            assert!((n - floor).length() < 1e-6);
        }
        if p.z > 1e-6 {
            assert!((n - wall).length() < 1e-6);
        }
    }
    let smooth = normals(Vec::new());
    assert!(
        smooth.iter().any(|(p, _, _)| p.x < -0.1 && p.z > 0.1),
        "rounded without"
    );
}

#[test]
fn a_fine_part_meets_the_coarse_rest() {
    let shape = shapes::sphere(400, 1);
    let (topology, positions) = mesh(&shape);
    let above = |f: &FaceId| {
        let corners = topology.face_vertices(*f);
        corners.iter().all(|v| positions[v.index()].z > 0.2)
    };
    let (part, rest): (Vec<_>, Vec<_>) = all_faces(&topology).into_iter().partition(above);
    let fine = DynamicSurface::new(&topology, &part, &options(4));
    let fine = fine.evaluate(positions, DVec3::ZERO, true, None);
    let coarse = DynamicSurface::new(&topology, &rest, &options(1));
    let coarse = coarse.evaluate(positions, DVec3::ZERO, true, None);
    let border = |g: &Geometry| -> Vec<[Vertex; 2]> {
        let t = Topology::from_triangles(g.vertices.len(), &g.triangles).expect("a manifold");
        let ends = |h: VertexId| g.vertices[h.index()];
        t.boundary_loops()
            .concat()
            .into_iter()
            .map(|h| [ends(t.origin(h)), ends(t.target(h))])
            .collect()
    };
    let segments = border(&coarse);
    let mut on_ends = 0;
    for [v, _] in border(&fine) {
        let p = wide(v.position);
        let distance = |s: &[Vertex; 2]| {
            let [a, b] = s.map(|v| wide(v.position));
            crate::mesh::closest_point_on_segment(p, a, b).distance(p)
        };
        let least = segments.iter().map(distance).fold(f64::INFINITY, f64::min);
        assert!(least < 1e-6, "{least:e}");
        // where the same vertex is on both sides, its curvature is too
        let same = |s: &&[Vertex; 2]| wide(s[0].position).distance(p) < 1e-6;
        if let Some([other, _]) = segments.iter().find(same) {
            on_ends += 1;
            let jump = (v.mean - other.mean).abs();
            assert!(jump < 1e-5, "{} {}", v.mean, other.mean);
        }
    }
    assert_eq!(on_ends, segments.len());
}

#[test]
fn flags_belong_to_faces() {
    let shape = shapes::icosphere(3);
    let (topology, positions) = mesh(&shape);
    let faces = all_faces(&topology);
    let flags: Vec<u32> = (0..faces.len()).map(|f| u32::from(f % 2 == 0)).collect();
    let all = SurfaceOptions {
        flags,
        ..options(2)
    };
    let surface = DynamicSurface::new(&topology, &faces, &all);
    let drawn = surface.evaluate(positions, DVec3::ZERO, true, None);
    for (i, t) in drawn.triangles.iter().enumerate() {
        for &v in t {
            let flags = drawn.vertices[v as usize].flags;
            assert_eq!(flags & Vertex::PATCH, u32::from(i / 4 % 2 == 0));
        }
    }
    let plain = DynamicSurface::new(&topology, &faces, &options(2));
    let plain = plain.evaluate(positions, DVec3::ZERO, true, None);
    assert!(plain.vertices.iter().all(|v| v.flags & Vertex::PATCH == 0));
    assert!(plain.vertices.len() < drawn.vertices.len());
    assert_ne!(plain.id, drawn.id);
}

#[test]
fn deviation_and_ill_posed_places_are_marked() {
    let shape = shapes::icosphere(4);
    let (topology, positions) = mesh(&shape);
    let surface = DynamicSurface::new(&topology, &all_faces(&topology), &options(2));
    let grown: Vec<DVec3> = positions.iter().map(|p| 1.25 * *p).collect();
    for limit in [true, false] {
        let out = surface.evaluate(&grown, DVec3::ZERO, limit, Some(positions));
        for v in &out.vertices {
            assert!(v.flags & Vertex::DEVIATION != 0);
            let r = wide(v.position).length();
            // a fifth of the new radius, less where flat triangles are not met at right angles
            assert!(
                (f64::from(v.deviation) - 0.2 * r).abs() < 2e-3,
                "{}",
                v.deviation
            );
        }
        let back = surface.evaluate(positions, DVec3::ZERO, limit, Some(&grown));
        assert!(back.vertices.iter().all(|v| v.deviation < 0.0));
    }
    let marked = |ill: &(dyn Fn(f64, f64) -> bool + Sync)| {
        let what = Evaluation {
            limit: true,
            ill_posed: Some(ill),
            ..Evaluation::default()
        };
        let out = surface.evaluate_with(positions, &what);
        let is = |v: &&Vertex| v.flags & Vertex::ILL_POSED != 0;
        (out.vertices.iter().filter(is).count(), out.vertices.len())
    };
    let (some, all) = marked(&|h, k| h < 0.0 && k > 0.0);
    assert_eq!(some, all);
    assert_eq!(marked(&|h, _| h > 0.0).0, 0);
}

#[test]
fn the_control_mesh_is_flat_with_the_limit_surface_s_normals() {
    let shape = shapes::icosphere(2);
    let (topology, positions) = mesh(&shape);
    let surface = DynamicSurface::new(&topology, &all_faces(&topology), &options(3));
    let flat = surface.evaluate(positions, DVec3::ZERO, false, None);
    let limit = surface.evaluate(positions, DVec3::ZERO, true, None);
    for (a, b) in flat.vertices.iter().zip(&limit.vertices) {
        assert_eq!(a.normal, b.normal);
        assert!(wide(a.position).length() > wide(b.position).length());
    }
    let on_triangle = |p: DVec3| {
        topology.triangles().any(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            crate::mesh::closest_point_on_triangle(p, a, b, c).distance(p) < 1e-6
        })
    };
    assert!(flat.vertices.iter().all(|v| on_triangle(wide(v.position))));
}

#[test]
fn odd_meshes_give_finite_vertices() {
    // back to back triangles, a single one, a fan with a pinch, and none at all
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    for triangles in [
        &[[0, 1, 2], [0, 2, 1]][..],
        &[[0, 1, 2]],
        &[[0, 1, 2], [0, 2, 3]],
        &[[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]],
        &[],
    ] {
        let topology = Topology::from_triangles(4, triangles).expect("a manifold");
        let faces = all_faces(&topology);
        for pieces in [1, 2, 4] {
            let surface = DynamicSurface::new(&topology, &faces, &options(pieces));
            for limit in [true, false] {
                let drawn = surface.evaluate(&corners, DVec3::ZERO, limit, Some(&corners));
                for v in &drawn.vertices {
                    let numbers = [v.mean, v.gauss, v.deviation];
                    let all = v.position.iter().chain(&v.normal).chain(&numbers);
                    assert!(all.copied().all(f32::is_finite), "{triangles:?} {v:?}");
                }
            }
        }
    }
}

/// The line around a patch runs along its border once, on the drawn surface, whatever lies beyond.
#[test]
fn a_patch_has_a_seam_along_its_border() {
    let shape = shapes::icosphere(8);
    let (topology, positions) = mesh(&shape);
    let centre = VertexId(100);
    let star: Vec<FaceId> = topology
        .outgoing(centre)
        .map(|h| topology.face(h))
        .collect();
    let others: Vec<FaceId> = topology.faces().filter(|f| !star.contains(f)).collect();
    let whole = [star.clone(), others].concat();
    for faces in [&whole, &star] {
        let flag = |f: &FaceId| u32::from(star.contains(f)) * Vertex::PATCH;
        let options = SurfaceOptions {
            flags: faces.iter().map(flag).collect(),
            ..options(3)
        };
        let surface = DynamicSurface::new(&topology, faces, &options);
        let geometry = surface.evaluate(positions, DVec3::ZERO, true, None);
        assert_eq!(geometry.seam.len(), 3 * star.len());
        for &v in geometry.seam.iter().flatten() {
            let place = wide(geometry.vertices[v as usize].position);
            let far = place.distance(positions[centre.index()]);
            assert!((0.1..0.2).contains(&far), "{far}");
        }
    }
    let plain = DynamicSurface::new(&topology, &whole, &options(3));
    let plain = plain.evaluate(positions, DVec3::ZERO, true, None);
    assert!(plain.seam.is_empty());
    // the newest patch inside an older one
    let newest = |f: &FaceId| u32::from(star.contains(f)) * Vertex::NEWEST;
    let flag = |f: &FaceId| Vertex::PATCH | newest(f);
    let options = SurfaceOptions {
        flags: whole.iter().map(flag).collect(),
        ..options(3)
    };
    let inside = DynamicSurface::new(&topology, &whole, &options);
    let inside = inside.evaluate(positions, DVec3::ZERO, true, None);
    assert_eq!(inside.seam.len(), 3 * star.len());
}

#[test]
fn colours_of_faces_hide_those_of_vertices_where_they_are_known() {
    let shape = shapes::icosphere(2);
    let (topology, positions) = mesh(&shape);
    let faces = all_faces(&topology);
    let known = 10;
    let shades = (0..known).map(|f| (f % 3 != 0).then_some([f as f32 / 255.0, 1.0, 0.5]));
    let options = SurfaceOptions {
        face_colors: Arc::new(shades.collect()),
        ..options(2)
    };
    // a part of the faces in another order
    let drawn: Vec<FaceId> = faces.iter().rev().copied().collect();
    let surface = DynamicSurface::new(&topology, &drawn, &options);
    let evaluation = Evaluation {
        colors: &vec![[1.0; 4]; positions.len()],
        ..Evaluation::default()
    };
    let geometry = surface.evaluate_with(positions, &evaluation);
    for (triangles, f) in geometry.triangles.chunks(4).zip(drawn) {
        let k = f.index();
        let wanted = if k < known && k % 3 != 0 {
            [k as u8, 255, 128, 255]
        } else {
            [255; 4]
        };
        for v in triangles.iter().flatten() {
            assert_eq!(geometry.vertices[*v as usize].color, wanted, "face {k}");
        }
    }
}

#[test]
fn colours_are_those_of_the_vertices_and_linear_between_them() {
    let shape = shapes::icosphere(3);
    let (topology, positions) = mesh(&shape);
    let faces = all_faces(&topology);
    let color = |p: &DVec3| [0.5 + 0.5 * p.x as f32, 0.25, 1.0, 1.0];
    let colors: Vec<[f32; 4]> = positions.iter().map(color).collect();
    let evaluate = |faces: &[FaceId], colors: &[[f32; 4]]| {
        let surface = DynamicSurface::new(&topology, faces, &options(4));
        let evaluation = Evaluation {
            colors,
            ..Evaluation::default()
        };
        surface.evaluate_with(positions, &evaluation)
    };
    // the drawn control mesh has the colours of its points
    let whole = evaluate(&faces, &colors);
    for v in &whole.vertices {
        let red = 255.0 * (0.5 + 0.5 * f64::from(v.position[0]));
        assert!((f64::from(v.color[0]) - red).abs() < 0.51, "{v:?}");
        assert_eq!(v.color[1..], [64, 255, 255]);
    }
    // a part far from the first vertices
    let last = evaluate(&faces[faces.len() - 5..], &colors);
    assert!(last.vertices.iter().all(|v| v.color[3] == 255));
    // vertices without a colour, as those of a patch that grows
    let known = positions.len() / 2;
    let half = evaluate(&faces, &colors[..known]);
    for (v, full) in half.vertices.iter().zip(&whole.vertices) {
        assert!(v.color == full.color || v.color == [0; 4]);
    }
    let unknown = half.vertices.iter().filter(|v| v.color == [0; 4]).count();
    // at least the corners
    assert!(unknown >= positions.len() - known && half.vertices.len() - unknown >= known);
}
