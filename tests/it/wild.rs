//! Input as people bring it: degenerate triangles, pinched vertices, fans, poles, slits, noise.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::common::desk::Desk;
use meniscus::mesh::DVec3;

fn obj(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = String::new();
    for [x, y, z] in points {
        writeln!(text, "v {x} {y} {z}").expect("text");
    }
    for [a, b, c] in faces.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(text, "f {a} {b} {c}").expect("text");
    }
    text
}

/// A unit sphere of `n` by `m` quads, each of two triangles, with `m` vertices at each pole.
fn sphere_with_poles(n: usize, m: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut points = Vec::new();
    for i in 0..=n {
        let (r, z) = (TAU * i as f64 / (2 * n) as f64).sin_cos();
        let r = if i == 0 || i == n { 0.0 } else { r };
        points.extend((0..m).map(|j| {
            let (sin, cos) = (TAU * j as f64 / m as f64).sin_cos();
            [r * cos, r * sin, z]
        }));
    }
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (i * m + j, i * m + (j + 1) % m);
            faces.extend([[a, a + m, b], [b, a + m, b + m]]);
        }
    }
    (points, faces)
}

#[test]
fn triangles_with_two_corners_at_one_place_end_no_command() {
    let desk = Desk::new();
    let points = [
        [0., 0., 0.],
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
    ];
    let faces = [[0, 1, 2], [1, 3, 2], [1, 4, 3]];
    desk.write("in.obj", &obj(&points, &faces));
    desk.runs(&["analyze", "in.obj"]);
    desk.runs(&["refine", "in.obj", "-o", "out.obj", "--levels", "1"]);
    desk.runs(&["fill", "in.obj", "-o", "out.obj", "--loops", "all"]);
}

#[test]
fn poles_are_no_holes_and_do_not_disturb_one() {
    let desk = Desk::new();
    let (points, mut faces) = sphere_with_poles(8, 12);
    faces.retain(|t| !t.iter().all(|&v| points[v][0] > 0.4));
    desk.write("in.obj", &obj(&points, &faces));
    desk.runs(&["analyze", "in.obj"]);
    desk.runs(&["fill", "in.obj", "-o", "out.obj", "--report", "report.json"]);
    let report = desk.json("report.json");
    assert_eq!(report["holes"].as_array().map(Vec::len), Some(1));
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(2));
    // the poles stay in the file, and the patch lies near the sphere
    let text = desk.text("out.obj");
    let mut vertices = text.lines().filter_map(|l| l.strip_prefix("v "));
    let given: Vec<&str> = vertices.by_ref().take(points.len()).collect();
    assert_eq!(given.len(), points.len());
    for line in vertices {
        let p: Vec<f64> = line
            .split(' ')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let radius = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((radius - 1.0).abs() < 0.1, "{line}");
    }
}

/// The edge of one face runs along the edges of two others, none of whose ends it has.
#[test]
fn a_vertex_on_an_edge_leaves_a_slit_that_is_closed() {
    let desk = Desk::new();
    let mut points: Vec<[f64; 3]> = Vec::new();
    for z in [0.0, 2.0] {
        points.extend([[0., 0., z], [2., 0., z], [2., 2., z], [0., 2., z]]);
    }
    points.push([1., 0., 2.]);
    let mut faces = vec![[0, 2, 1], [0, 3, 2], [4, 8, 6], [8, 5, 6], [4, 6, 7]];
    for i in 0..4 {
        let j = (i + 1) % 4;
        faces.extend([[i, j, j + 4], [i, j + 4, i + 4]]);
    }
    desk.write("in.obj", &obj(&points, &faces));
    desk.runs(&["fill", "in.obj", "-o", "out.obj"]);
    let (before, after) = (desk.mesh("in.obj"), desk.mesh("out.obj"));
    assert_eq!(after.positions, before.positions);
    assert_eq!(after.triangles().len(), before.triangles().len() + 1);
    let info = desk.run(&["info", "in.obj"]).ends(0).stdout;
    assert!(info.contains("1 of 1 boundary loops are slits"), "{info}");
    // the face at the long edge is divided instead
    for words in [
        ["stitch", "in.obj", "-o", "out.obj"],
        ["repair", "in.obj", "-o", "out.obj"],
    ] {
        desk.runs(&words);
        let whole = desk.mesh("out.obj");
        assert_eq!(whole.positions, before.positions);
        assert_eq!(whole.triangles().len(), before.triangles().len() + 1);
        let opened = meniscus::io::open(&desk.path("out.obj")).expect("a mesh");
        assert!(opened.mesh.topology.boundary_loops().is_empty());
        assert_eq!(opened.report.zero_area_faces, 0);
    }
}

/// A hole beside a vertex with 2,000 triangles takes next to nothing, as it should.
#[test]
fn a_hole_in_a_large_fan_is_filled() {
    let desk = Desk::new();
    let n = 2000;
    let mut points = vec![[0.0, 0.0, 0.1]];
    for radius in [1.0, 2.0] {
        points.extend((0..n).map(|i| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            [radius * cos, radius * sin, 0.0]
        }));
    }
    let mut faces = Vec::new();
    for i in 0..n {
        let (a, b) = (1 + i, 1 + (i + 1) % n);
        if i >= 40 {
            faces.push([0, a, b]);
        }
        faces.extend([[a, a + n, b + n], [a, b + n, b]]);
    }
    desk.write("in.obj", &obj(&points, &faces));
    let words = [
        "fill",
        "in.obj",
        "-o",
        "out.obj",
        "--loops",
        "1",
        "--report",
        "report.json",
    ];
    desk.runs(&words);
    let memory = desk.json("report.json")["peak_memory"].as_u64();
    assert!(memory.is_none_or(|bytes| bytes < 100 << 20), "{memory:?}");
}

/// A loose triangle far away, and one at an edge of the hole.
#[test]
fn clean_removes_what_is_loose_and_no_other() {
    let desk = Desk::new();
    let (mut points, mut faces) = sphere_with_poles(8, 12);
    faces.retain(|t| !t.iter().all(|&v| points[v][0] > 0.4));
    desk.write("clean.obj", &obj(&points, &faces));
    let n = points.len();
    points.extend([[9., 0., 0.], [9., 1., 0.], [9., 0., 1.], [2., 0.2, 0.]]);
    faces.insert(7, [n, n + 1, n + 2]);
    let [a, b] = rim_edge(&faces);
    faces.push([b, a, n + 3]);
    desk.write("in.obj", &obj(&points, &faces));
    let run = desk.run(&["clean", "in.obj", "-o", "out.obj"]).ends(0);
    let wanted = "1 component and 1 flap removed, with 2 faces and 4 vertices; 3 loops now";
    assert!(run.stdout.contains(wanted), "{}", run.stdout);
    are_equal(&desk, "out.obj", "clean.obj");
    let none = ["--min-faces", "0", "--flap-faces", "0"];
    desk.runs(&[&["clean", "in.obj", "-o", "same.obj"], &none[..]].concat());
    are_equal(&desk, "same.obj", "in.obj");
}

#[track_caller]
fn are_equal(desk: &Desk, one: &str, other: &str) {
    let [one, other] = [one, other].map(|name| desk.mesh(name));
    assert_eq!(one.positions, other.positions);
    assert_eq!(one.triangles(), other.triangles());
}

/// A boundary edge at positive x, along its face.
fn rim_edge(faces: &[[usize; 3]]) -> [usize; 2] {
    let sides = |t: &[usize; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let all: std::collections::BTreeSet<_> = faces.iter().flat_map(sides).collect();
    let is_open = |[a, b]: &&[usize; 2]| !all.contains(&[*b, *a]) && *a >= 24 && *b < 84;
    *all.iter().find(is_open).expect("a rim")
}

#[test]
fn stitch_joins_the_sides_of_a_slit() {
    let desk = Desk::new();
    let row = |x: f64| (0..4).map(move |y| [x, f64::from(y), 0.0]);
    let mut points: Vec<[f64; 3]> = row(0.0).chain(row(1.0)).chain(row(1.0)).collect();
    points.extend(row(2.0));
    points[9][0] += 1e-3;
    let strips = [0, 8].into_iter().flat_map(|k| k..k + 3);
    let faces: Vec<[usize; 3]> = strips
        .flat_map(|a| [[a, a + 4, a + 5], [a, a + 5, a + 1]])
        .collect();
    // both sides keep their vertices if no other place is equal
    for p in &mut points[8..12] {
        p[2] += 1e-3;
    }
    desk.write("in.obj", &obj(&points, &faces));
    let run = desk.run(&["stitch", "in.obj", "-o", "out.obj"]).ends(0);
    let wanted = "6 boundary edges and 4 vertices joined";
    assert!(run.stdout.contains(wanted), "{}", run.stdout);
    assert!(
        run.stdout.contains("1 loop now, 2 before"),
        "{}",
        run.stdout
    );
    let after = desk.mesh("out.obj");
    let kept = [&points[..8], &points[12..]].concat();
    let left: Vec<[f64; 3]> = after.positions.iter().map(DVec3::to_array).collect();
    assert_eq!(left, kept);
    desk.runs(&["stitch", "in.obj", "-o", "same.obj", "--tolerance", "1e-4"]);
    are_equal(&desk, "same.obj", "in.obj");
    let message = desk.fails(1, &["stitch", "in.obj", "-o", "x.obj", "--tolerance", "-1"]);
    assert!(message.contains("a length of 0 or more"), "{message}");
}

/// A cap on a tube is highest where tubes have no energy; at 0 and at 1 it is the same half sphere.
#[test]
fn the_height_of_a_cap_follows_the_spontaneous_curvature() {
    let desk = Desk::new();
    let (n, rows) = (16, 8);
    let place = |i: usize| {
        let (sin, cos) = (TAU * (i % n) as f64 / n as f64).sin_cos();
        [cos, sin, 0.4 * (i / n) as f64]
    };
    let points: Vec<[f64; 3]> = (0..n * rows).map(place).collect();
    let cells = (0..n * (rows - 1)).map(|i| (i, i / n * n + (i + 1) % n));
    let faces: Vec<[usize; 3]> = cells
        .flat_map(|(a, b)| [[a, b, b + n], [a, b + n, a + n]])
        .collect();
    desk.write("in.obj", &obj(&points, &faces));
    let height = |bulge: &str| {
        let words = ["fill", "in.obj", "-o", "out.obj", "--loops", "2", "--bulge"];
        desk.runs(&[&words[..], &[bulge]].concat());
        let mesh = desk.mesh("out.obj");
        let all = mesh.positions.iter().map(|p| p.z);
        all.fold(0.0, f64::max) - points[n * rows - 1][2]
    };
    let heights = ["-1", "0", "0.25", "0.5", "0.75", "1", "2"].map(height);
    let [.., three_quarters, one, two] = heights;
    assert!(
        heights[..4].is_sorted_by(|a, b| a + 0.1 < *b),
        "{heights:?}"
    );
    assert!(three_quarters < heights[3] && one < three_quarters && two < one);
    assert!((one - heights[1]).abs() < 0.02, "{heights:?}");
}

/// Every patch gets a group of its own, and later patches the next numbers, in OBJ and in PLY.
#[test]
fn patches_are_labelled() {
    let desk = Desk::with_sample("sphere");
    let given = desk.mesh("in.obj").triangles().len();
    for (first, second) in [("a.obj", "b.obj"), ("a.ply", "b.ply"), ("a.ply", "b.obj")] {
        let one = [
            "fill",
            "in.obj",
            "-o",
            first,
            "--loops",
            "1,2",
            "--label-patches",
        ];
        desk.runs(&one);
        desk.runs(&["fill", first, "-o", second, "--label-patches"]);
        let labels = labels(&desk, second);
        assert!(labels[..given].iter().all(|&label| label == 0));
        let mut of_patches = labels[given..].to_vec();
        assert!(of_patches.is_sorted());
        of_patches.dedup();
        assert_eq!(of_patches, [1, 2, 3, 4, 5]);
    }
    // without the option the files are as before
    desk.runs(&["fill", "in.obj", "-o", "plain.obj"]);
    assert!(!desk.text("plain.obj").contains("\ng "));
    let blend = ["blend", "in.obj", "-o", "c.obj", "--loops", "1,2"];
    desk.runs(&[&blend[..], &["--label-patches"]].concat());
    assert!(labels(&desk, "c.obj").contains(&1));
    let refill = [
        "refill", "in.obj", "-o", "d.obj", "--faces", "1", "--grow", "2",
    ];
    desk.runs(&[&refill[..], &["--label-patches"]].concat());
    assert!(labels(&desk, "d.obj").contains(&1));
}

/// The number of the patch of each face, 0 for none.
fn labels(desk: &Desk, name: &str) -> Vec<u32> {
    let opened = meniscus::io::open(&desk.path(name)).expect("a mesh");
    let tags = &opened.mesh.attributes.tags;
    let number = |&tag: &u32| tags[tag as usize].patch().unwrap_or(0);
    opened
        .mesh
        .attributes
        .faces
        .tags
        .iter()
        .map(number)
        .collect()
}

/// A sphere with one vertex pulled through the opposite side is erased there and filled.
#[test]
fn refill_selects_faces_by_quality() {
    let desk = Desk::new();
    let (positions, triangles) = meniscus::shapes::icosphere(8);
    let mut points: Vec<[f64; 3]> = positions.iter().map(DVec3::to_array).collect();
    let faces: Vec<[usize; 3]> = triangles.iter().map(|t| t.map(|v| v as usize)).collect();
    let pulled = points.iter_mut().max_by(|p, q| p[0].total_cmp(&q[0]));
    *pulled.expect("a vertex") = [-1.5, 0.02, 0.01];
    desk.write("in.obj", &obj(&points, &faces));
    for quality in [
        &["--faces-crossing"][..],
        &["--faces-longer-than", "0.9"],
        &["--faces-worse-than", "5", "--grow", "1"],
    ] {
        let words = ["refill", "in.obj", "-o", "out.obj"];
        desk.runs(&[&words, quality].concat());
        let after = desk.mesh("out.obj");
        assert!(after.positions.iter().all(|p| p[0] > -1.1), "{quality:?}");
    }
    // the same vertex pushed over its neighbours, along the surface
    let pushed = points.iter_mut().min_by(|p, q| p[0].total_cmp(&q[0]));
    *pushed.expect("a vertex") = [0.95, 0.3, 0.0];
    desk.write("folded.obj", &obj(&points, &faces));
    desk.runs(&["refill", "folded.obj", "-o", "out.obj", "--faces-folded"]);
    let message = desk.fails(1, &["erase", "out.obj", "-o", "x.obj", "--faces-folded"]);
    assert!(message.contains("no face is selected"), "{message}");
    let none = ["erase", "in.obj", "-o", "x.obj", "--faces-longer-than", "9"];
    let message = desk.fails(1, &none);
    assert!(message.contains("no face is selected"), "{message}");
    let wrong = ["erase", "in.obj", "-o", "x.obj", "--faces-worse-than", "-1"];
    let message = desk.fails(2, &wrong);
    assert!(message.contains("a positive number"), "{message}");
}

/// The same sphere with the pulled vertex, a hole, a loose triangle and a second sphere through it.
#[test]
fn repair_leaves_nothing_but_components_that_cross() {
    let desk = Desk::new();
    let (positions, triangles) = meniscus::shapes::icosphere(8);
    let ball: Vec<[f64; 3]> = positions.iter().map(DVec3::to_array).collect();
    let faces: Vec<[usize; 3]> = triangles.iter().map(|t| t.map(|v| v as usize)).collect();
    let mut points = ball.clone();
    let pulled = points.iter_mut().max_by(|p, q| p[0].total_cmp(&q[0]));
    *pulled.expect("a vertex") = [-1.5, 0.02, 0.01];
    let is_hole = |t: &[usize; 3]| t.iter().all(|&v| points[v][2] > 0.9);
    let mut all: Vec<[usize; 3]> = faces.iter().copied().filter(|t| !is_hole(t)).collect();
    let mut add = |more: &[[f64; 3]], of_more: &[[usize; 3]]| {
        let first = points.len();
        points.extend(more);
        all.extend(of_more.iter().map(|t| t.map(|v| v + first)));
    };
    let through: Vec<[f64; 3]> = ball
        .iter()
        .map(|[x, y, z]| [x + 0.5, y + 1.5, *z])
        .collect();
    add(&through, &faces);
    add(
        &[[3.0, 0.0, 0.0], [3.1, 0.0, 0.0], [3.0, 0.1, 0.0]],
        &[[0, 1, 2]],
    );
    desk.write("in.obj", &obj(&points, &all));
    let words = ["repair", "in.obj", "-o", "out.obj", "--report", "out.json"];
    let run = desk.run(&words).ends(0);
    for words in [
        "loose parts with 1 face removed",
        "erased at damaged places; 2 holes",
        " between components, ",
    ] {
        assert!(
            run.stderr.contains(words),
            "no {words:?} in: {}",
            run.stderr
        );
    }
    let report = desk.json("out.json");
    let tasks = report["steps"].as_array().expect("steps").iter();
    let tasks: Vec<&str> = tasks.filter_map(|step| step["task"].as_str()).collect();
    assert_eq!(tasks, ["clean", "refill", "fill"]);
    assert_eq!(report["before"]["loops"], 2);
    assert_eq!(report["after"]["loops"], 0);
    assert_eq!(report["after"]["components"], 2);
    assert_eq!(report["after"]["self_intersections"], 0);
    assert!(report["after"]["intersections_of_components"].as_u64() > Some(0));
    assert!(!run.stderr.contains("left"), "{}", run.stderr);
    let after = desk.mesh("out.obj");
    assert!(after.positions.iter().all(|p| p[0] > -1.1));
    // a sound mesh is written as it is
    desk.write("sound.obj", &obj(&ball, &faces));
    desk.runs(&["repair", "sound.obj", "-o", "same.obj"]);
    let same = desk.mesh("same.obj");
    assert!(
        same.positions
            .iter()
            .zip(&ball)
            .all(|(p, q)| p.to_array() == *q)
    );
    assert_eq!(same.faces.len(), faces.len());
    desk.fails(2, &["repair", "in.obj", "-o", "x.obj", "--energy", "H^"]);
    desk.fails(1, &["repair", "in.obj", "-o", "in.obj"]);
}

#[test]
fn welding_follows_the_option() {
    let desk = Desk::new();
    let (points, mut faces) = sphere_with_poles(6, 8);
    faces.retain(|t| t.iter().all(|&v| points[v][2] < 0.9));
    let mut text = String::from("solid noisy\n");
    for (f, t) in faces.iter().enumerate() {
        text += " facet normal 0 0 0\n  outer loop\n";
        for &v in t {
            let [x, y, z] = points[v];
            let noise = 1e-17 * (f % 3) as f64;
            writeln!(text, "   vertex {} {} {}", x + noise, y - noise, z).expect("text");
        }
        text += "  endloop\n endfacet\n";
    }
    text += "endsolid noisy\n";
    desk.write("in.stl", &text);
    let loops = |more: &[&str]| {
        let run = desk
            .run(&[&["info", "in.stl", "--json"], more].concat())
            .ends(0);
        let info: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        let welded = info["welded_apart"].as_u64().expect("a count");
        (info["loops"].as_array().map(Vec::len), welded > 0)
    };
    assert_eq!(loops(&[]), (Some(1), true));
    assert_eq!(loops(&["--weld", "auto"]), (Some(1), true));
    assert_eq!(loops(&["--weld", "1e-6"]), (Some(1), true));
    let (exact, apart) = loops(&["--weld", "0"]);
    assert!(exact > Some(1) && !apart);
    let message = desk.fails(2, &["info", "in.stl", "--weld", "near"]);
    assert!(message.contains("auto"), "{message}");
}

#[test]
fn ply_colours_keep_their_type() {
    let desk = Desk::new();
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 255 0 0\n2 0 0 0 255 0\n2 2 0 0 0 255\n0 2 0 255 255 0\n1 1 1.5 255 255 255\n\
        3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
    desk.write("in.ply", text);
    desk.runs(&["fill", "in.ply", "-o", "out.ply", "--loops", "all"]);
    let bytes = desk.bytes("out.ply");
    let header = String::from_utf8_lossy(&bytes);
    assert!(header.contains("property uchar red"));
}

/// A fill that would go on for hours leaves nothing behind when it is interrupted.
#[cfg(unix)]
#[test]
fn interrupted_commands_leave_nothing_behind() {
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let desk = Desk::with_sample("sphere");
        let words = [
            "fill", "in.obj", "-o", "out.obj", "--mode", "flow", "--tau", "1e-12",
        ];
        let mut command = desk.command(&words);
        command.args(["--steps", "100000000", "--density", "3"]);
        let mut child = command.spawn().expect("the program starts");
        // long enough for the program to set up its handler
        std::thread::sleep(std::time::Duration::from_secs(2));
        let kill = std::process::Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        assert_eq!(child.wait().expect("ended").code(), Some(code));
        assert_eq!(desk.names(), ["in.obj"]);
    }
}

/// Two walls side by side, whose rims are both in one hole: its first patch has no new vertices and is replaced.
#[test]
fn a_hole_between_two_walls_is_filled() {
    let desk = Desk::new();
    desk.write("in.obj", include_str!("../data/double_wall.obj"));
    desk.runs(&["fill", "in.obj", "-o", "out.obj"]);
}

/// A sharp line runs along a part of the rim, where the patch has a crease, or through the hole, where two
/// parts of the patch meet. A fold there counts.
#[test]
fn a_fold_at_a_crease_is_removed_or_said() {
    let cases = [
        include_str!("../data/crease_at_cliff.obj"),
        include_str!("../data/creases_through_ring.obj"),
    ];
    for case in cases {
        let desk = Desk::new();
        desk.write("in.obj", case);
        desk.runs(&["fill", "in.obj", "-o", "out.obj", "--report", "report.json"]);
        let folds = |name: &str| {
            let mesh = meniscus::io::open(&desk.path(name)).expect("a mesh").mesh;
            let angle = meniscus::mesh::FOLD_DEGREES.to_radians();
            meniscus::mesh::folded_edges(&mesh.positions, &mesh.topology, angle).len()
        };
        assert_eq!(folds("in.obj"), 0);
        let report = desk.text("report.json");
        assert!(folds("out.obj") == 0 || report.contains("\"folded\""));
    }
}
