//! Several files as one mesh.

use std::fmt::Write as _;

use crate::common::desk::Desk;
use crate::common::raw::RawMesh;

/// The faces of each object of a file, and its vertices.
fn objects(desk: &Desk, name: &str) -> (RawMesh, Vec<String>) {
    let text = desk.text(name);
    let names = text.lines().filter_map(|l| l.strip_prefix("o "));
    (desk.mesh(name), names.map(String::from).collect())
}

#[test]
fn rims_of_different_files_are_blended() {
    let desk = Desk::new();
    let tube = |z: f64| {
        let mut text = String::from("o tube\n");
        for (k, i) in (0..6).flat_map(|k| (0..24).map(move |i| (k, i))) {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 24.0).sin_cos();
            let height = z + 0.25 * f64::from(k);
            writeln!(text, "v {cos} {sin} {height}").expect("text");
        }
        for (k, i) in (0..5).flat_map(|k| (0..24).map(move |i| (k, i))) {
            let j = (i + 1) % 24;
            let [a, b, c, d] =
                [(k, i), (k, j), (k + 1, j), (k + 1, i)].map(|(k, i)| 24 * k + i + 1);
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("text");
        }
        text
    };
    desk.write("low.obj", &tube(0.0));
    desk.write("high.obj", &tube(2.5).replace("o tube\n", ""));
    let near = ["--loop-at", "1,0,1.25", "--loop-at", "1,0,2.5"];
    let words = ["blend", "low.obj", "high.obj", "-o", "out.obj"];
    desk.runs(&[&words[..], &near].concat());
    let (mesh, names) = objects(&desk, "out.obj");
    assert_eq!(names[..2], ["tube", "high"]);
    let (low, high) = (desk.mesh("low.obj"), desk.mesh("high.obj"));
    let both = [&low.positions[..], &high.positions].concat();
    assert_eq!(mesh.positions[..both.len()], both);
    assert!(mesh.positions.len() > both.len());
    // `fill` joins only with --join
    let fill = [
        "fill",
        "low.obj",
        "high.obj",
        "-o",
        "filled.obj",
        "--loops",
        "all",
    ];
    desk.run(&fill).fails(2, &["--join"]);
    desk.runs(&[&fill[..], &["--join"]].concat());
    let filled = desk.mesh("filled.obj");
    assert_eq!(filled.positions[..both.len()], both);
}
