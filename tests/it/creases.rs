//! Refinement with sharp edges: flat faces stay flat, rims become splines, both sides meet.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fs;
use std::process::Command;
use std::sync::Arc;

use meniscus::io;
use meniscus::mesh::{DVec3, HalfedgeId, Mesh, VertexId, check_mesh, dihedral_angle};
use meniscus::refine::{
    Method, RefineControls, RefineError, RefineOptions, Refined, crease_edges, radius, refine,
};
use meniscus::runner::Recording;
use meniscus::shapes::icosphere;
use meniscus::subdivision::limit_normal;

fn mesh(positions: &[DVec3], triangles: &[[u32; 3]]) -> Mesh {
    Mesh::from_triangles(positions.to_vec(), triangles).expect("a surface")
}

/// `[-1, 1]³` of twelve triangles.
fn cube() -> Mesh {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let positions: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(sign(i & 1), sign(i & 2), sign(i & 4)))
        .collect();
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles: Vec<[u32; 3]> = sides.into_iter().flat_map(halves).collect();
    mesh(&positions, &triangles)
}

/// A cylinder of radius 1 around the z axis between two caps, `n` vertices around.
fn capped_cylinder(n: u32) -> Mesh {
    let heights = [-0.6, -0.2, 0.2, 0.6];
    let mut positions = Vec::new();
    for (row, z) in heights.into_iter().enumerate() {
        for i in 0..n {
            let angle = TAU * (f64::from(i) + 0.5 * row as f64) / f64::from(n);
            positions.push(DVec3::new(angle.cos(), angle.sin(), z));
        }
    }
    let (low, high) = (positions.len() as u32, positions.len() as u32 + 1);
    positions.extend([DVec3::new(0.0, 0.0, -0.6), DVec3::new(0.0, 0.0, 0.6)]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        for row in 0..3 {
            let at = |row: u32, i: u32| n * row + i;
            triangles.push([at(row, i), at(row, j), at(row + 1, i)]);
            triangles.push([at(row, j), at(row + 1, j), at(row + 1, i)]);
        }
        triangles.push([low, j, i]);
        triangles.push([high, 3 * n + i, 3 * n + j]);
    }
    mesh(&positions, &triangles)
}

fn options(mesh: &Mesh, levels: usize, degrees: f64) -> RefineOptions {
    // bending and area balance over an edge
    let edge = mesh.position(0.into()).distance(mesh.position(1.into()));
    let controls = RefineControls {
        levels,
        energy: Some("H^2".into()),
        tension: Some(4.0 * (radius(mesh) / edge).powi(2)),
        crease_angle: Some(degrees),
        steps: 60,
        ..RefineControls::default()
    };
    controls.into()
}

fn refined(mesh: &Mesh, options: &RefineOptions) -> Refined {
    let (copy, options) = (Arc::new(mesh.clone()), options.clone());
    let refined = refine(copy, options, &Recording::default(), &mut |_| true);
    let (refined, _) = refined.expect("refined");
    is_sound(&refined, mesh);
    refined
}

/// A box that becomes a ball is said; a coarse ball, which has sharp edges too, is not.
#[test]
fn rounded_edges_between_flat_parts_are_said() {
    let warnings = |mesh: &Mesh, options: RefineOptions| {
        let levels = refined(mesh, &options).levels;
        let codes = levels.iter().map(|level| {
            let of_level = level.warnings.iter().map(|w| (w.code(), w.to_string()));
            of_level
                .filter(|(code, _)| *code == "rounded-edges")
                .collect()
        });
        let codes: Vec<Vec<_>> = codes.collect();
        assert!(codes[1..].iter().all(Vec::is_empty));
        codes[0]
            .iter()
            .map(|(_, text)| text.clone())
            .collect::<Vec<_>>()
    };
    let smooth = |mesh: &Mesh| RefineOptions {
        controls: RefineControls {
            crease_angle: None,
            ..options(mesh, 2, 0.0).controls
        },
        ..RefineOptions::default()
    };
    for angle in [0.0, 1.0] {
        let mut turned = cube();
        let turn = glam::DQuat::from_rotation_x(angle) * glam::DQuat::from_rotation_y(angle);
        turned
            .positions
            .iter_mut()
            .for_each(|p| *p = 1e3 * (turn * *p));
        let said = warnings(&turned, smooth(&turned));
        assert!(
            said.len() == 1 && said[0].contains("become round: 12,"),
            "{said:?}"
        );
        assert_eq!(warnings(&turned, options(&turned, 2, 30.0)), [""; 0]);
    }
    let (positions, triangles) = icosphere(0);
    let ball = mesh(&positions, &triangles);
    assert_eq!(warnings(&ball, smooth(&ball)), [""; 0]);
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// Checks a refined mesh: same boundary and Euler number as the input, no two vertices at one
/// position, unchanged input vertices (except for Loop's scheme), and a control mesh with the same
/// faces.
fn is_sound(refined: &Refined, given: &Mesh) {
    let mesh = &refined.mesh;
    check_mesh(mesh).expect("sound");
    let euler = |m: &Mesh| {
        let t = &m.topology;
        t.vertex_count() + t.face_count() - t.halfedge_count() / 2
    };
    assert_eq!(euler(mesh), euler(given));
    assert_eq!(
        mesh.topology.boundary_loops().len(),
        given.topology.boundary_loops().len()
    );
    let places: BTreeSet<[u64; 3]> = mesh.positions.iter().map(|&p| bits(p)).collect();
    assert_eq!(places.len(), mesh.vertex_count());
    assert_eq!(refined.control.face_count(), mesh.face_count());
    let last = refined.levels.last().expect("a level");
    assert_eq!(last.vertices, mesh.vertex_count());
}

fn keeps(refined: &Refined, given: &Mesh) {
    let first = &refined.mesh.positions[..given.vertex_count()];
    assert!(
        first
            .iter()
            .zip(&given.positions)
            .all(|(&p, &q)| bits(p) == bits(q))
    );
}

#[test]
fn a_cube_stays_a_cube() {
    let cube = cube();
    for method in [Method::Pde, Method::Butterfly, Method::Loop] {
        let mut options = options(&cube, 3, 40.0);
        options.controls.method = method;
        let refined = refined(&cube, &options);
        keeps(&refined, &cube);
        for p in &refined.mesh.positions {
            let off = p.abs().max_element() - 1.0;
            assert!(off.abs() < 1e-12, "{method:?}: {p}");
        }
    }
}

#[test]
fn every_edge_may_be_sharp() {
    let (positions, triangles) = icosphere(1);
    let ball = mesh(&positions, &triangles);
    let refined = refined(&ball, &options(&ball, 2, 1.0));
    keeps(&refined, &ball);
    // sixteen parts of each face, all in its plane
    for (f, t) in refined.mesh.topology.triangles().enumerate() {
        let [a, b, c] = ball.corners((f / 16).into());
        let normal = (b - a).cross(c - a).normalize();
        for v in t {
            assert!((refined.mesh.positions[v as usize] - a).dot(normal).abs() < 1e-12);
        }
    }
}

#[test]
fn caps_stay_flat_and_rims_become_round() {
    let given = capped_cylinder(16);
    let refined = refined(&given, &options(&given, 2, 60.0));
    keeps(&refined, &given);
    let topology = &refined.mesh.topology;
    let on_cap = |p: DVec3| (p.z.abs() - 0.6).abs() < 1e-12;
    let mut rims = 0;
    for h in topology.edges() {
        let ends = [topology.origin(h), topology.target(h)].map(|v| refined.mesh.position(v));
        let angle = dihedral_angle(&refined.mesh.positions, topology, h);
        let sides = [h, h.twin()].map(|h| {
            let face = topology.face_vertices(topology.face(h));
            face.iter().all(|&v| on_cap(refined.mesh.position(v)))
        });
        if sides[0] == sides[1] {
            assert!(angle < 12_f64.to_radians(), "{}", angle.to_degrees());
            continue;
        }
        rims += 1;
        assert!(
            (angle - FRAC_PI_2).abs() < 6_f64.to_radians(),
            "{}",
            angle.to_degrees()
        );
        for p in ends {
            // twelve points to a circle are off by less than 1e-3, and O(h⁴)
            assert!(
                (p.x.hypot(p.y) - 1.0).abs() < 1e-3 * (12.0f64 / 16.0).powi(4),
                "{p}"
            );
        }
    }
    assert_eq!(rims, 2 * 16 * 4);
    // the faces of the caps come last, 2 · 16 of each 8 · 16
    let parts = 16;
    for (f, t) in topology.triangles().enumerate() {
        let is_cap = (f / parts) % 8 >= 6;
        let flat = t
            .iter()
            .all(|&v| on_cap(refined.mesh.positions[v as usize]));
        assert_eq!(is_cap, flat);
    }
}

/// The normals of the two sides of a rim differ by about its dihedral angle.
#[test]
fn one_sided_normals_keep_the_angle() {
    let given = capped_cylinder(24);
    let refined = refined(&given, &options(&given, 1, 60.0));
    let (open, whole) = (&refined.control.topology, &refined.mesh.topology);
    let mut compared = 0;
    for (f, g) in (0..open.face_count()).map(|f| (f.into(), f.into())) {
        for (here, there) in open
            .face_halfedges(f)
            .into_iter()
            .zip(whole.face_halfedges(g))
        {
            if !open.is_boundary(here.twin()) {
                continue;
            }
            // the same edge from the other side
            let beyond = whole.face(there.twin());
            let sides = whole.face_halfedges(beyond);
            let k = sides
                .iter()
                .position(|&s| s == there.twin())
                .expect("its side");
            let other = open.target(open.face_halfedges(beyond)[k]);
            let normal = |v: VertexId| limit_normal(open, &refined.control.positions, v);
            let angle = normal(open.origin(here)).angle_between(normal(other));
            // the wall may tilt where that lowers the energy between the constrained vertices
            assert!((angle - FRAC_PI_2).abs() < 0.2, "{}", angle.to_degrees());
            compared += 1;
        }
    }
    assert_eq!(compared, 2 * 2 * 24 * 2);
}

/// A crease that ends inside a smooth surface, in a single vertex.
#[test]
fn a_crease_may_end_inside() {
    let (positions, triangles) = icosphere(2);
    let ball = mesh(&positions, &triangles);
    let topology = &ball.topology;
    // straight on over three edges
    let mut h = topology.outgoing(VertexId(12)).next().expect("a spoke");
    let mut creases = Vec::new();
    for _ in 0..3 {
        let ends = [topology.origin(h), topology.target(h)];
        creases.push(ends.map(|v| v.0));
        let along = ball.position(ends[1]) - ball.position(ends[0]);
        let turn = |o: &HalfedgeId| {
            along.angle_between(ball.position(topology.target(*o)) - ball.position(ends[1]))
        };
        let on = topology.outgoing(ends[1]);
        h = on
            .min_by(|a, b| turn(a).total_cmp(&turn(b)))
            .expect("spokes");
    }
    for method in [Method::Pde, Method::Butterfly, Method::Loop] {
        let mut options = options(&ball, 2, 180.0);
        (options.controls.method, options.creases) = (method, creases.clone());
        let refined = refined(&ball, &options);
        let cut = refined.control.vertex_count() - refined.mesh.vertex_count();
        assert_eq!(cut, 3 * 4 - 1, "{method:?}");
        if method != Method::Loop {
            keeps(&refined, &ball);
        }
    }
}

#[test]
fn creases_of_a_region() {
    let given = capped_cylinder(16);
    // a cap and the wall beside it
    let inside = |f: usize| f % 8 == 7 || f % 8 == 4 || f % 8 == 5;
    let mut options = options(&given, 2, 60.0);
    options.region = Some((0..given.face_count()).map(inside).collect());
    for method in [Method::Pde, Method::Butterfly] {
        options.controls.method = method;
        let refined = refined(&given, &options);
        keeps(&refined, &given);
        let upper = |p: &&DVec3| (p.z - 0.6).abs() < 1e-12;
        let on_rim = |p: &&DVec3| (p.x.hypot(p.y) - 1.0).abs() < 1e-3;
        let rim = refined.mesh.positions.iter().filter(upper).filter(on_rim);
        assert!(rim.count() >= 32);
    }
}

#[test]
fn a_rotated_mesh_gives_the_rotated_result() {
    let given = capped_cylinder(10);
    let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
    let turn = |p: DVec3| {
        let (sin, cos) = 0.8f64.sin_cos();
        cos * p + sin * axis.cross(p) + (1.0 - cos) * axis.dot(p) * axis
    };
    let mut turned = given.clone();
    turned.positions.iter_mut().for_each(|p| *p = turn(*p));
    // a few steps: within a flat cap vertices may slide as they like without a change of energy
    let first_steps = |m: &Mesh| {
        let mut options = options(m, 1, 60.0);
        options.controls.steps = 5;
        refined(m, &options)
    };
    let [plain, other] = [&given, &turned].map(first_steps);
    for (p, q) in plain.mesh.positions.iter().zip(&other.mesh.positions) {
        assert!(turn(*p).distance(*q) < 1e-7, "{}", turn(*p).distance(*q));
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let given = capped_cylinder(10);
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().expect("threads");
        pool.install(|| refined(&given, &options(&given, 2, 60.0)))
    };
    let (one, two) = (of(1), of(2));
    assert_eq!(one.mesh, two.mesh);
    assert_eq!(one.control, two.control);
}

#[test]
fn without_a_sharp_edge_nothing_changes() {
    let given = capped_cylinder(10);
    let mut smooth = options(&given, 1, 40.0);
    smooth.controls.crease_angle = None;
    let angle = options(&given, 1, 170.0);
    assert_eq!(refined(&given, &smooth).mesh, refined(&given, &angle).mesh);
    assert_eq!(
        refined(&given, &smooth).control,
        refined(&given, &angle).control
    );
}

#[test]
fn mistaken_creases_are_named() {
    let (positions, triangles) = icosphere(1);
    let ball = mesh(&positions, &triangles);
    let mut options = options(&ball, 1, 180.0);
    let far = (0..12).find(|&v| v != 0 && ball.topology.neighbours(VertexId(0)).all(|w| w.0 != v));
    let far = far.expect("not all are neighbours");
    for ends in [[0, far], [0, 99], [99, 0], [3, 3]] {
        options.creases = vec![ends];
        let error = crease_edges(&ball, &options).expect_err("no edge");
        assert!(matches!(error, RefineError::NoCrease { .. }));
        assert!(
            error
                .to_string()
                .contains(&format!("vertex {}", ends[0] + 1))
        );
    }
    let near = ball
        .topology
        .neighbours(VertexId(0))
        .next()
        .expect("a neighbour");
    options.creases = vec![[0, near.0]];
    let error = crease_edges(&ball, &options).expect_err("too short");
    assert!(matches!(error, RefineError::LoneCrease { .. }));
    options.creases.clear();
    for angle in [0.0, -1.0, f64::NAN] {
        options.controls.crease_angle = Some(angle);
        let error = options.validate(&ball).expect_err("no angle");
        assert!(error.to_string().starts_with("the crease angle"));
    }
    options.controls.crease_angle = Some(180.0);
    options.validate(&ball).expect("no crease");
    options.controls.crease_angle = Some(45.0);
    assert!(
        crease_edges(&ball, &options)
            .expect("angle")
            .iter()
            .all(|&c| !c)
    );
}

#[test]
fn the_command_keeps_sharp_edges() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus"));
        command.current_dir(folder.path()).args(words.split(' '));
        command.output().expect("it starts")
    };
    let cube = cube();
    io::save_mesh(&folder.path().join("cube.obj"), &cube).expect("written");
    let out = run("refine cube.obj -o angle.obj --levels 2 --crease-angle 40 --control open.obj");
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let read = |name: &str| io::open(&folder.path().join(name)).expect("a mesh").mesh;
    let by_angle = read("angle.obj");
    assert_eq!(by_angle.vertex_count(), 8 + 18 + 72);
    assert_eq!(read("open.obj").topology.boundary_loops().len(), 6);
    // the same edges named, all twelve
    let chains = "1,2,4,3,1\n5,6,8,7,5\n1,5\n2,6\n3,7\n";
    fs::write(folder.path().join("chains.txt"), chains).expect("written");
    let from_file =
        "refine cube.obj -o named.obj --levels 2 --creases-from chains.txt --crease 8,4";
    assert!(run(from_file).status.success());
    assert_eq!(read("named.obj"), by_angle);
    for (wrong, code, word) in [
        ("--crease 1,8", 1, "not an edge"),
        ("--crease 1", 2, "4,7,9"),
        ("--crease-angle 0", 1, "positive"),
        ("--creases-from nowhere", 2, "nowhere"),
    ] {
        let out = run(&format!("refine cube.obj -o wrong.obj {wrong}"));
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(code), "{wrong}: {said}");
        assert!(said.contains(word), "{wrong}: {said}");
    }
    assert!(!folder.path().join("wrong.obj").exists());
}
