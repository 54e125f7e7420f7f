//! Blends, parts of holes, bridges and refilling from end to end, on the built-in samples.

use crate::common::desk::Desk;
use crate::common::judge::{Keep, Verdict, judge};
use meniscus::io::save_mesh;
use meniscus::mesh::{DVec3, FaceId, Mesh, boundary_loops, erase};
use meniscus::shapes::sphere;

/// The verdict on `out.obj` as a change of `in.obj`.
#[track_caller]
fn verdict(desk: &Desk, keep: Keep) -> Verdict {
    let v = judge(&desk.mesh("in.obj"), &desk.mesh("out.obj"), keep, &[], None);
    assert!(v.failures.is_empty(), "{:?}", v.failures);
    v
}

#[test]
fn samples_are_blended() {
    for (sample, outer, rims) in [
        ("four-cylinders", 4, 4),
        ("three-y", 3, 3),
        ("tube-onto-plane", 2, 2),
    ] {
        let desk = Desk::with_sample(sample);
        desk.runs(&["blend", "in.obj", "-o", "out.obj", "--report", "r.json"]);
        let verdict = verdict(&desk, Keep::Everything);
        assert_eq!(
            (verdict.loops_left, verdict.components),
            (outer, 1),
            "{sample}"
        );
        let report = desk.json("r.json");
        let holes = report["holes"].as_array().expect("holes");
        assert_eq!(holes.len(), 1);
        assert_eq!(holes[0]["loops"].as_array().expect("loops").len(), rims);
        assert_eq!(holes[0]["converged"], true);
        assert!(holes[0]["steps"].as_u64().expect("steps") <= 40, "{sample}");
    }
}

/// Twice the edges, half the angle across the rim: the join is smooth.
#[test]
fn joins_get_smoother_with_density() {
    let angle = |around: usize| {
        let (positions, triangles) = meniscus::shapes::four_cylinders(around);
        let mesh = Mesh::from_triangles(positions, &triangles).expect("tubes");
        let desk = Desk::new();
        save_mesh(&desk.path("in.obj"), &mesh).expect("written");
        desk.runs(&["blend", "in.obj", "-o", "out.obj"]);
        verdict(&desk, Keep::Everything).rim_angle
    };
    assert!(angle(40) < 0.6 * angle(20));
}

#[test]
fn noise_is_smoothed_out_again() {
    let desk = Desk::with_sample("three-y");
    let energy = |words: &[&str]| {
        let all = [
            &["blend", "in.obj", "-o", "out.obj", "--report", "r.json"],
            words,
        ]
        .concat();
        desk.runs(&all);
        let report = desk.json("r.json");
        let value = |key: &str| report["holes"][0][key].as_f64().expect("an energy");
        (value("energy_start"), value("energy_end"))
    };
    let (smooth, rough) = (energy(&[]), energy(&["--noise", "0.3"]));
    assert!(rough.0 > 2.0 * smooth.0, "{smooth:?} {rough:?}");
    assert!(
        (rough.1 / smooth.1 - 1.0).abs() < 0.01,
        "{smooth:?} {rough:?}"
    );
}

#[test]
fn the_area_pinches_off_with_a_warning() {
    let desk = Desk::with_sample("four-cylinders");
    let words = [
        "blend", "in.obj", "-o", "out.obj", "--energy", "1", "--report", "r.json",
    ];
    desk.runs(&words);
    let report = desk.json("r.json");
    let hole = &report["holes"][0];
    assert_eq!(hole["converged"], false);
    let texts = hole["warnings"].to_string();
    assert!(texts.contains("pinches off near"), "{texts}");
    let codes = serde_json::json!(["smooth-rim", "pinched", "self-intersection"]);
    assert_eq!(hole["warning_codes"], codes);
    verdict(&desk, Keep::Everything);
}

#[test]
fn an_inside_out_component_is_named_and_turned_over() {
    let desk = Desk::with_sample("four-cylinders");
    let loops = ["--loops", "1,3"];
    let flipped = ["--flip", "3"];
    let start = ["blend", "in.obj", "-o", "out.obj"];
    let error = desk.fails(1, &[&start[..], &loops, &flipped].concat());
    assert!(error.contains("flip"), "{error}");
    // flipping twice restores the original
    desk.runs(&[&start[..], &loops].concat());
    let error = desk.fails(1, &[&start[..], &["--loops", "1"]].concat());
    assert!(error.contains("at least two"), "{error}");
}

#[test]
fn parts_and_bridges_leave_smaller_holes() {
    let desk = Desk::with_sample("catenoid");
    let holes = |name: &str| {
        let mesh = desk.mesh(name);
        crate::common::judge::loops_of(&mesh).expect("loops").len()
    };
    let before = holes("in.obj");
    let mesh = desk.mesh("in.obj");
    let loops = crate::common::judge::loops_of(&mesh).expect("loops");
    let window = loops
        .iter()
        .min_by(|a, b| a.radius.total_cmp(&b.radius))
        .expect("a hole");
    let at = |k: usize| {
        let p = mesh.positions[window.vertices[k % window.edges] as usize];
        format!("{},{},{}", p.x, p.y, p.z)
    };
    let half = at(window.edges / 2);
    let first = at(0);
    desk.runs(&["fill", "in.obj", "-o", "out.obj", "--part", &first, &half]);
    verdict(&desk, Keep::Everything);
    assert_eq!(holes("out.obj"), before);
    desk.runs(&[
        "bridge", "in.obj", "-o", "out.obj", "--from", &first, "--to", &half,
    ]);
    verdict(&desk, Keep::Everything);
    assert_eq!(holes("out.obj"), before + 1);
    // the strip flows with the fills beside it and is not in the result
    let to_bridge = ["bridge", "in.obj", "-o", "bridged.obj", "--from", &first];
    let said = desk
        .run(&[&to_bridge[..], &["--to", &half]].concat())
        .ends(0)
        .stdout;
    let list = said
        .split("--bridge-faces ")
        .nth(1)
        .expect("the faces of the bridge");
    let list = list.split_whitespace().next().expect("a list");
    let to_fill = [
        "fill",
        "bridged.obj",
        "-o",
        "out.obj",
        "--bridge-faces",
        list,
    ];
    desk.runs(&to_fill);
    verdict(&desk, Keep::Everything);
    let mesh = desk.mesh("out.obj");
    let strip = desk
        .mesh("bridged.obj")
        .positions
        .split_off(desk.mesh("in.obj").positions.len());
    assert!(!strip.iter().any(|p| mesh.positions.contains(p)));
    let error = desk.fails(
        2,
        &[
            "fill",
            "bridged.obj",
            "-o",
            "out.obj",
            "--bridge-faces",
            "9-999999",
        ],
    );
    assert!(error.contains("--bridge-faces"), "{error}");
}

#[test]
fn refilling_erases_and_fills_and_fairing_keeps_the_triangles() {
    let desk = Desk::with_sample("torus");
    let ball = ["--ball", "2.4142,0,0,0.5"];
    desk.runs(&[&["refill", "in.obj", "-o", "out.obj"], &ball[..]].concat());
    let (before, after) = (desk.mesh("in.obj"), desk.mesh("out.obj"));
    assert_ne!(before.faces.len(), after.faces.len());
    desk.runs(&[&["refill", "in.obj", "-o", "out.obj", "--fair"], &ball[..]].concat());
    let faired = desk.mesh("out.obj");
    assert_eq!(before.faces, faired.faces);
    let moved = |p: &DVec3, q: &DVec3| p.distance(*q) > 1e-9;
    let count = before.positions.iter().zip(&faired.positions);
    assert!(count.filter(|(p, q)| moved(p, q)).count() > 20);
    let error = desk.fails(
        1,
        &["refill", "in.obj", "-o", "out.obj", "--ball", "0,0,0,0.1"],
    );
    assert!(error.contains("no face is selected"), "{error}");
    desk.fails(2, &["refill", "in.obj", "-o", "out.obj", "--ball", "0,0,0"]);
    let wrong = ["refill", "in.obj", "-o", "out.obj", "--faces", "7,x"];
    assert!(desk.fails(2, &wrong).contains("`x`"));
}

/// Two bowls open to the same side: their rims look like borders of open surfaces.
#[test]
fn where_each_piece_has_one_rim_nothing_else_can_be_meant() {
    let desk = Desk::with_sample("torus");
    let (positions, triangles) = sphere(900, 3);
    let ball = Mesh::from_triangles(positions, &triangles).expect("a ball");
    let high = |f: usize| ball.corners(FaceId::from(f)).iter().any(|p| p.z > -0.5);
    let bowl = erase(&ball, &(0..ball.face_count()).map(high).collect::<Vec<_>>()).mesh;
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for x in [0.0, 3.0] {
        let first = points.len() as u32;
        points.extend(bowl.positions.iter().map(|&p| p + x * DVec3::X));
        faces.extend(bowl.topology.triangles().map(|t| t.map(|v| v + first)));
    }
    let mesh = Mesh::from_triangles(points, &faces).expect("two bowls");
    assert!(boundary_loops(&mesh).iter().all(|l| l.is_outer_boundary));
    save_mesh(&desk.path("in.obj"), &mesh).expect("written");
    desk.runs(&["blend", "in.obj", "-o", "out.obj"]);
    let verdict = verdict(&desk, Keep::Everything);
    assert_eq!((verdict.loops_left, verdict.components), (0, 1));
}

#[test]
fn faces_are_named_by_lists_and_erased_and_components_turned_over() {
    let desk = Desk::with_sample("torus");
    let before = desk.mesh("in.obj");
    desk.runs(&["erase", "in.obj", "-o", "out.obj", "--faces", "2-4,9"]);
    let after = desk.mesh("out.obj");
    let mut left = before.triangles();
    for gone in [8, 3, 2, 1] {
        left.remove(gone);
    }
    let corners = |points: &[DVec3], faces: &[[u32; 3]]| -> Vec<[DVec3; 3]> {
        let at = |v: u32| points[v as usize];
        faces.iter().map(|f| f.map(at)).collect()
    };
    assert_eq!(
        corners(&after.positions, &after.triangles()),
        corners(&before.positions, &left)
    );
    std::fs::write(desk.path("faces.txt"), "2-4\n9\n").expect("written");
    desk.runs(&[
        "erase",
        "in.obj",
        "-o",
        "again.obj",
        "--faces-from",
        "faces.txt",
    ]);
    assert_eq!(desk.mesh("again.obj").faces, after.faces);
    assert!(
        desk.fails(
            2,
            &["erase", "in.obj", "-o", "out.obj", "--faces", "9000000"]
        )
        .contains("9000000")
    );

    desk.runs(&["flip", "in.obj", "-o", "out.obj", "--component-of", "1"]);
    let turned = desk.mesh("out.obj");
    assert_eq!(turned.positions, before.positions);
    let sorted = |f: &[u32; 3]| {
        let least = (0..3).min_by_key(|&k| f[k]).unwrap_or(0);
        [f[least], f[(least + 1) % 3], f[(least + 2) % 3]]
    };
    for (f, g) in before.triangles().iter().zip(&turned.triangles()) {
        let [a, b, c] = sorted(f);
        assert_eq!([a, c, b], sorted(g));
    }
    desk.fails(
        1,
        &["flip", "in.obj", "-o", "out.obj", "--component-of", "77"],
    );
}
