//! `meniscus analyze` from end to end.

use std::fs;
use std::process::Command;

use meniscus::shapes::{TriangleMesh, icosphere};
use serde_json::Value;

fn obj((positions, triangles): &TriangleMesh) -> String {
    let vertices = positions
        .iter()
        .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = triangles
        .iter()
        .map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    vertices.chain(faces).collect()
}

#[test]
fn a_sphere_is_measured_in_all_ways() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, frequency) in [("ball.obj", 4), ("fine.obj", 10)] {
        fs::write(folder.path().join(name), obj(&icosphere(frequency))).expect("written");
    }
    let run = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus"));
        command.current_dir(folder.path()).args(words.split(' '));
        command.output().expect("it starts")
    };
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).expect("written");
    let out = run(
        "analyze ball.obj --on-surface --json --against fine.obj --energy 1 \
         --section 0,0,0.6,0,0,1 --section-csv section.csv --csv vertices.csv --measures all.csv",
    );
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let found: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let number = |v: &Value| v.as_f64().expect("a number");
    let area = number(&found["shape"]["area"]);
    assert_eq!(number(&found["shape"]["energies"]["given"]), area);
    let curve = &found["sections"][0]["curves"][0];
    // a circle of radius 0.8
    assert!((number(&curve["length"]) / 5.0265 - 1.0).abs() < 0.01);
    let points = curve["points"].as_array().expect("points").len();
    assert_eq!(text("section.csv").lines().count(), points + 1);
    assert_eq!(text("vertices.csv").lines().count(), 162 + 1);
    let line = format!("limit surface,area,{area:?},,,,");
    assert!(text("all.csv").lines().any(|l| l == line), "{line}");
    assert!(number(&found["distances"]["to_reference"]["rms"]) < 0.03);

    let words = String::from_utf8(run("analyze ball.obj --section 0,0,0.6,0,0,1").stdout);
    assert!(words.expect("text").contains("section 1: closed curve"));
    for wrong in ["0,0,0,0,0,0", "1,2,3", "0,0,0,1,x,0"] {
        let out = run(&format!("analyze ball.obj --section {wrong}"));
        assert_eq!(out.status.code(), Some(2));
        let words = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(words.contains("write a point and"), "{words}");
    }
    let before = text("ball.obj");
    let out = run("analyze ball.obj --measures ball.obj");
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(text("ball.obj"), before);
}
