//! The program from end to end, on small generated meshes.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Stdio;

use crate::common::desk::{Desk, Run};
use clap::{CommandFactory, Parser};
use meniscus::cli::Arguments;
use meniscus::io;
use meniscus::mesh::{self, DVec3, boundary_loops};
use meniscus::shapes::{self, Hole, HoleShape, TriangleMesh};
use serde_json::Value;

/// Boundary loops of a mesh file, by the library.
fn loop_count(desk: &Desk, name: &str) -> usize {
    let (mesh, report) = mesh::build(&io::load(&desk.path(name)).expect("loads")).expect("sound");
    assert_eq!(report.non_manifold_edges + report.split_vertices, 0);
    boundary_loops(&mesh).len()
}

fn disc(centre: [f64; 3], radius: f64) -> Hole {
    Hole {
        centre: DVec3::from_array(centre),
        shape: HoleShape::Disc { radius },
        turn: 0.0,
        seed: 1,
    }
}

/// A unit sphere with three round holes of different sizes, about +x, +y and +z.
fn sphere() -> TriangleMesh {
    let holes = [
        disc([1.0, 0.0, 0.0], 0.3),
        disc([0.0, 1.0, 0.0], 0.4),
        disc([0.0, 0.0, 1.0], 0.6),
    ];
    shapes::cut_holes(&shapes::sphere(1000, 1), &holes)
}

/// A flat square with a round hole in its middle.
fn plate() -> TriangleMesh {
    shapes::cut_holes(&shapes::plane(2.0, 16, 1), &[disc([0.0; 3], 0.45)])
}

fn obj(shape: &TriangleMesh) -> String {
    let mut text = String::new();
    for p in &shape.0 {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("text");
    }
    for t in &shape.1 {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").expect("text");
    }
    text
}

/// Numbers of the lines of an OBJ file that start with the word.
fn numbers(text: &str, word: &str) -> Vec<Vec<f64>> {
    text.lines()
        .filter_map(|line| line.strip_prefix(word)?.strip_prefix(' '))
        .map(|rest| {
            rest.split_whitespace()
                .map(|n| n.parse().expect("a number"))
                .collect()
        })
        .collect()
}

fn bits(points: &[Vec<f64>]) -> Vec<Vec<u64>> {
    let of = |p: &Vec<f64>| p.iter().map(|x| x.to_bits()).collect();
    points.iter().map(of).collect()
}

/// Splits a line of examples into words; quotes are the only shell syntax in them.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            _ => words.last_mut().expect("never empty").push(c),
        }
    }
    words.retain(|w| !w.is_empty());
    words
}

fn examples(text: &str) -> Vec<&str> {
    text.lines()
        .map(str::trim)
        // a usage line is not an example
        .filter(|line| line.starts_with("meniscus ") && !line.contains(['<', '[']))
        .map(|line| line.split(" #").next().unwrap_or(line).trim())
        .collect()
}

#[track_caller]
fn examples_hold(text: &str, at_least: usize) {
    let lines = examples(text);
    assert!(lines.len() >= at_least, "{} examples", lines.len());
    for line in lines {
        if let Err(error) = Arguments::try_parse_from(words(line)) {
            // --help and --version print and end, which clap calls an error too
            assert_eq!(error.exit_code(), 0, "{line}: {error}");
        }
    }
}

#[test]
fn help_has_examples_that_hold() {
    let desk = Desk::new();
    for (command, count) in [(&["--help"][..], 4), (&["fill", "--help"], 4)] {
        let help = desk.run(command).ends(0).stdout;
        assert!(help.contains("Examples:"), "{help}");
        examples_hold(&help, count);
    }
    let version = desk.run(&["--version"]).ends(0).stdout;
    assert_eq!(version, format!("meniscus {}\n", env!("CARGO_PKG_VERSION")));
    for command in ["info", "demo"] {
        desk.run(&[command, "--help"]).ends(0);
    }
}

/// Long options of a command that its help shows.
fn options_of(command: &clap::Command) -> BTreeSet<String> {
    let shown = command.get_arguments().filter(|a| !a.is_hide_set());
    shown
        .filter_map(|a| a.get_long())
        .map(str::to_owned)
        .collect()
}

/// Long options in the first column of the table of a command in the manual.
fn options_in_table(manual: &str, command: &str) -> BTreeSet<String> {
    let head = format!("| option of `{command}` |");
    let from = manual.find(&head).expect("a table of the command");
    let rows = manual[from..].lines().take_while(|l| l.starts_with('|'));
    let cells = rows.filter_map(|l| l.split('|').nth(1));
    cells
        .flat_map(|cell| cell.split("`--").skip(1))
        .map(|text| {
            let end = text.find(|c: char| !c.is_ascii_lowercase() && c != '-');
            text[..end.unwrap_or(text.len())].to_owned()
        })
        .collect()
}

#[test]
fn the_manual_has_every_option_and_no_other() {
    let manual = include_str!("../../docs/manual.md");
    let program = Arguments::command();
    let of = |name: &str| options_of(program.find_subcommand(name).expect("a command"));
    let pictures = options_in_table(manual, "render");
    assert_eq!(pictures, of("render"));
    for name in ["fill", "refine", "analyze"] {
        let table = options_in_table(manual, name);
        let taken = of(name);
        // the options of a picture are listed once, under `render`
        let shared = |o: &&String| table.contains(*o) || !pictures.contains(*o);
        let own: BTreeSet<String> = taken.iter().filter(shared).cloned().collect();
        assert_eq!(table, own, "{name}");
    }
    for command in program.get_subcommands() {
        for option in options_of(command) {
            let name = command.get_name();
            let named = manual.contains(&format!("--{option}"));
            assert!(named, "the manual does not name --{option} of {name}");
        }
    }
}

#[test]
fn readme_has_examples_that_hold() {
    examples_hold(include_str!("../../README.md"), 6);
}

#[test]
fn wrong_usage_ends_with_2() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let fill = |more: &[&str]| {
        let mut words = vec!["fill", "in.obj", "-o", "out.obj"];
        words.extend(more);
        desk.run(&words)
    };
    desk.run(&["fill", "in.obj"]).fails(2, &["--output"]);
    desk.run(&["mend"])
        .fails(2, &["mend", "neither a command nor a file"]);
    desk.run(&["mend", "in.obj"]).fails(2, &["in.obj"]);
    desk.run(&["sample", "cube", "-o", "out.obj"])
        .fails(2, &["cube", "creature"]);
    fill(&["--frobnicate"]).fails(2, &["--frobnicate"]);
    fill(&["--loops", "two"]).fails(2, &["two", "all-but-largest"]);
    fill(&["--loops", "0"]).fails(2, &["not a loop number"]);
    fill(&["--loop-at", "1,2"]).fails(2, &["three numbers"]);
    fill(&["--loop-at", "0,0,0", "--loops", "1"]).fails(2, &["cannot be used with"]);
    fill(&["--tau", "-1"]).fails(2, &["positive number"]);
    fill(&["--tau", "soon"]).fails(2, &["positive number"]);
    fill(&["--density", "-2"]).fails(2, &["positive number"]);
    fill(&["--steps", "many"]).fails(2, &["many"]);
    fill(&["--scheme", "magic"]).fails(2, &["normal", "mixed"]);
    fill(&["--param", "a"]).fails(2, &["NAME=VALUE"]);
    assert!(!desk.path("out.obj").exists());
}

#[test]
fn bad_energies_point_at_the_character() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let energy = |text: &str| desk.run(&["fill", "in.obj", "-o", "out.obj", "--energy", text]);
    for (text, at) in [
        ("H^2 + )", 6),
        ("H^2 + foo", 6),
        ("H^2 K", 4),
        ("2 * (H", 6),
    ] {
        let run = energy(text).fails(2, &["--energy"]);
        let lines: Vec<&str> = run.stderr.lines().collect();
        let caret = lines.iter().position(|l| l.trim_start().starts_with('^'));
        let caret = caret.unwrap_or_else(|| panic!("no caret: {}", run.stderr));
        let column = lines[caret].find('^').expect("found above");
        let start = lines[caret - 1]
            .find(text)
            .expect("the text above the caret");
        assert_eq!(column, start + at, "{}", run.stderr);
    }
    energy("k1").fails(2, &["not symmetric"]);
    energy("k1^2 + k1*k2").fails(2, &["not symmetric"]);
    energy("sqrt(-1)").fails(2, &["no finite value"]);
    // a valid energy whose parameter is missing
    energy("a*H^2").fails(2, &["unknown name 'a'", "--param a=VALUE"]);
    desk.run(&[
        "fill",
        "in.obj",
        "-o",
        "out.obj",
        "--energy",
        "a*H^2 + 0.1*K^2",
        "--param",
        "a=2",
    ])
    .ends(0);
}

#[test]
fn files_that_cannot_be_used_end_with_1() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    desk.run(&["fill", "none.obj", "-o", "out.obj"])
        .fails(1, &["none.obj", "the file does not exist"]);
    desk.run(&["info", "none.obj"])
        .fails(1, &["the file does not exist"]);
    desk.write("notes.txt", "v 0 0 0");
    desk.run(&["info", "notes.txt"])
        .fails(1, &[".obj, .ply, .stl"]);
    desk.run(&["fill", "in.obj", "-o", "out.xyz"])
        .fails(1, &["out.xyz", ".obj, .ply, .stl"]);
    desk.run(&["fill", "in.obj", "-o", "nowhere/out.obj"])
        .fails(1, &["the directory", "does not exist"]);
    // records are checked before the work too
    for option in ["--report", "--trace"] {
        desk.run(&["fill", "in.obj", "-o", "out.obj", option, "nowhere/x"])
            .fails(1, &["the directory", "does not exist"]);
        assert!(!desk.path("out.obj").exists());
    }
    desk.write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    desk.run(&["fill", "broken.obj", "-o", "out.obj"])
        .fails(1, &["broken.obj", "7"]);
    desk.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    desk.run(&["info", "points.obj"]).fails(1, &["points.obj"]);
    desk.run(&["fill", "in.obj", "-o", "out.obj", "--loops", "9"])
        .fails(1, &["loop 9 does not exist", "has 2"]);
    assert!(!desk.path("out.obj").exists());
}

#[test]
fn files_that_are_needed_are_never_overwritten() {
    let desk = Desk::new();
    let text = obj(&plate());
    desk.write("in.obj", &text);
    fs::create_dir(desk.path("sub")).expect("a folder");
    for out in ["in.obj", "./in.obj", "sub/../in.obj"] {
        desk.run(&["fill", "in.obj", "-o", out])
            .fails(1, &["same file", "IN"]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(desk.path("in.obj"), desk.path("link.obj")).expect("a link");
        desk.run(&["fill", "in.obj", "-o", "link.obj"])
            .fails(1, &["same file"]);
    }
    let fill = ["fill", "in.obj", "-o", "out.obj"];
    for more in [
        &["--report", "in.obj"][..],
        &["--trace", "./in.obj"],
        &["--report", "out.obj"],
        &["--report", "r", "--trace", "r"],
    ] {
        desk.run(&[&fill, more].concat()).fails(1, &["same file"]);
    }
    assert_eq!(desk.text("in.obj"), text);
    assert!(!desk.path("out.obj").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn full_disk_is_said() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    std::os::unix::fs::symlink("/dev/full", desk.path("full.obj")).expect("a link");
    desk.run(&["fill", "in.obj", "-o", "full.obj"])
        .fails(1, &["disk is full"]);
}

#[test]
fn nobody_listening_is_no_failure() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&sphere()));
    let mut command = desk.command(&["info", "in.obj", "--json"]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// The fields `loop` of the filled and the skipped loops of the report.
fn filled_and_skipped(desk: &Desk, input: &str, choice: &[&str]) -> (Vec<u64>, Vec<u64>, usize) {
    let words = ["fill", input, "-o", "out.obj", "--report", "report.json"];
    desk.run(&[&words, choice].concat()).ends(0);
    let report = desk.json("report.json");
    let loops = |list: &str| -> Vec<u64> {
        let entries = report[list].as_array().expect("a list");
        let number = |e: &Value| e["loop"].as_u64().expect("a number");
        entries.iter().map(number).collect()
    };
    (
        loops("holes"),
        loops("skipped"),
        loop_count(desk, "out.obj"),
    )
}

#[test]
fn loops_are_chosen() {
    let desk = Desk::new();
    let shape = sphere();
    desk.write("in.obj", &obj(&shape));
    let info: Value = serde_json::from_str(&desk.run(&["info", "in.obj", "--json"]).ends(0).stdout)
        .expect("JSON");
    let loops = info["loops"].as_array().expect("loops");
    assert_eq!(loops.len(), 3);
    let towards = |axis: usize| -> u64 {
        let found = loops
            .iter()
            .find(|l| l["centroid"][axis].as_f64().expect("a number") > 0.7);
        found.expect("a hole on each axis")["number"]
            .as_u64()
            .expect("a number")
    };
    let (small, middle, large) = (towards(0), towards(1), towards(2));
    let sorted = |mut numbers: Vec<u64>| {
        numbers.sort_unstable();
        numbers
    };

    let chosen = |choice: &[&str]| filled_and_skipped(&desk, "in.obj", choice);
    assert_eq!(chosen(&[]), (vec![1, 2, 3], vec![], 0));
    assert_eq!(chosen(&["--loops", "all"]), (vec![1, 2, 3], vec![], 0));
    let others = sorted(vec![small, middle]);
    assert_eq!(
        chosen(&["--loops", "all-but-largest"]),
        (others.clone(), vec![large], 1)
    );
    let list = format!("{middle},{large},{middle}");
    assert_eq!(
        chosen(&["--loops", &list]),
        (sorted(vec![middle, large]), vec![small], 1)
    );
    let at = ["--loop-at", "0,0,2", "--loop-at", "0.1,-0.5,0.9"];
    assert_eq!(chosen(&at), (vec![large], others, 2));
    assert_eq!(chosen(&["--loop-at=-0.1,1,0"]).0, [middle]);
}

#[test]
fn outer_boundaries_are_left_open_and_reported() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let run = desk
        .run(&["fill", "in.obj", "-o", "out.obj", "--report", "report.json"])
        .ends(0);
    let report = desk.json("report.json");
    let skipped = &report["skipped"][0];
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(1));
    let reason = skipped["reason"].as_str().expect("text");
    assert!(reason.contains("outer boundary"), "{reason}");
    let number = skipped["loop"].as_u64().expect("a number");
    assert!(
        run.stderr.contains(&format!("loop {number} (")),
        "{}",
        run.stderr
    );
    // the new vertices lie in the plane
    let points = numbers(&desk.text("out.obj"), "v");
    assert!(points.iter().all(|p| p[2].abs() < 1e-12));
    assert_eq!(loop_count(&desk, "out.obj"), 1);
}

#[test]
fn large_loops_are_left_open_and_named() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&sphere()));
    let info = desk.run(&["info", "in.obj", "--json"]).ends(0).stdout;
    let info: Value = serde_json::from_str(&info).expect("JSON");
    let loops = info["loops"].as_array().expect("loops");
    let edges = |l: &Value| l["edges"].as_u64().expect("a number");
    let large = loops.iter().max_by_key(|l| edges(l)).expect("loops");
    let number = large["number"].as_u64().expect("a number");
    let limit = (edges(large) - 1).to_string();
    let (filled, skipped, left) = filled_and_skipped(&desk, "in.obj", &["--max-edges", &limit]);
    assert_eq!((filled.len(), skipped, left), (2, vec![number], 1));
    let reason = desk.json("report.json")["skipped"][0]["reason"].to_string();
    assert!(reason.contains("more than"), "{reason}");
    // a loop chosen by number is filled at any size
    let named = ["--loops", &number.to_string(), "--max-edges", "3"];
    assert_eq!(filled_and_skipped(&desk, "in.obj", &named).0, [number]);
    let run = desk.run(&["fill", "in.obj", "-o", "out.obj", "--max-diameter", "1e-9"]);
    let run = run.ends(0);
    assert!(run.stderr.contains("diameter"), "{}", run.stderr);
    assert!(run.stderr.contains("nothing to fill"), "{}", run.stderr);
}

#[test]
fn report_and_trace_are_complete() {
    let desk = Desk::new();
    let shape = sphere();
    desk.write("in.obj", &obj(&shape));
    desk.run(&[
        "fill",
        "in.obj",
        "-o",
        "out.obj",
        "--report",
        "report.json",
        "--trace",
        "trace.csv",
    ])
    .ends(0);
    let report = desk.json("report.json");
    for field in [
        "input",
        "output",
        "holes",
        "totals",
        "peak_memory",
        "version",
        "load",
        "skipped",
    ] {
        assert!(!report[field].is_null(), "{field}");
    }
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(
        (&report["input"], &report["output"]),
        (&"in.obj".into(), &"out.obj".into())
    );
    let choices = [&report["energy"], &report["scheme"], &report["mode"]];
    assert_eq!(choices, ["H^2", "normal", "fast"]);
    if cfg!(target_os = "linux") {
        assert!(report["peak_memory"].as_u64().expect("bytes") > 1 << 20);
    }
    let holes = report["holes"].as_array().expect("holes");
    assert_eq!(holes.len(), 3);
    let mut added = [0, 0];
    for hole in holes {
        let count = |field: &str| hole[field].as_u64().unwrap_or_else(|| panic!("{field}"));
        let number = |field: &str| hole[field].as_f64().unwrap_or_else(|| panic!("{field}"));
        assert!(count("loop") > 0 && count("edges") > 10 && count("steps") > 0);
        assert!(count("rejected") <= 2);
        added[0] += count("vertices_added");
        added[1] += count("faces_added");
        // V − E + F = 1 for a disc: F = 2 V + edges − 2
        assert_eq!(
            count("faces_added"),
            2 * count("vertices_added") + count("edges") - 2
        );
        assert_eq!(hole["converged"], true);
        assert_eq!(hole["warnings"].as_array().map(Vec::len), Some(0), "{hole}");
        assert!(number("energy_end") <= number("energy_start"));
        assert!(number("seconds") > 0.0);
    }
    let totals = &report["totals"];
    let points = numbers(&desk.text("out.obj"), "v");
    let faces = numbers(&desk.text("out.obj"), "f");
    assert_eq!(totals["vertices"], points.len());
    assert_eq!(totals["faces"], faces.len());
    assert_eq!(points.len() as u64, shape.0.len() as u64 + added[0]);
    assert_eq!(faces.len() as u64, shape.1.len() as u64 + added[1]);
    assert_eq!(totals["vertices_added"], added[0]);
    assert_eq!(totals["holes"], 3);

    trace_is_sound(&desk.text("trace.csv"), holes);
}

fn trace_is_sound(trace: &str, holes: &[Value]) {
    let mut lines = trace.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    assert_eq!(
        header,
        [
            "loop", "step", "tau", "energy", "residual", "rejected", "reason"
        ]
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    for hole in holes {
        // holes solved together have the rows of the first of them
        let first = holes.iter().find(|h| h["group"] == hole["group"]);
        let number = first.expect("itself at least")["loop"].to_string();
        let of_hole = rows.iter().filter(|row| row[0] == number);
        let (mut steps, mut rejected, mut energy) = (0, 0, f64::INFINITY);
        let mut rises = 0;
        for row in of_hole {
            assert_eq!(row.len(), 7);
            assert_eq!(row[5] == "1", !row[6].is_empty(), "{row:?}");
            assert!(row[2].parse::<f64>().expect("tau") > 0.0);
            let now: f64 = row[3].parse().expect("an energy");
            if row[5] == "1" {
                rejected += 1;
                assert_eq!(row[4], "");
            } else {
                steps += 1;
                assert_eq!(row[1], steps.to_string());
                assert!(row[4].parse::<f64>().expect("a residual") >= 0.0);
                // the one update of a vector flow's metric changes the energy's definition
                rises += usize::from(now > energy + 1e-9 * energy.abs());
                energy = now;
            }
        }
        assert!(rises <= 1, "{rises}");
        assert_eq!(hole["steps"], steps);
        assert_eq!(hole["rejected"], rejected);
    }
}

#[test]
fn originals_come_first_bit_by_bit() {
    let desk = Desk::new();
    // coordinates with all their digits, far from the origin, and an isolated vertex
    let (mut points, faces) = sphere();
    for p in &mut points {
        *p = *p / 3.0 + DVec3::new(1e6, -7e-3, 1.0 / 7.0);
    }
    points.insert(0, DVec3::new(1e6, 0.1, 0.7));
    let faces: Vec<[u32; 3]> = faces.iter().map(|t| t.map(|v| v + 1)).collect();
    let shape = (points, faces);
    desk.write("in.obj", &obj(&shape));
    desk.run(&["fill", "in.obj", "-o", "out.obj"]).ends(0);
    let (before, after) = (desk.text("in.obj"), desk.text("out.obj"));
    let (old, new) = (numbers(&before, "v"), numbers(&after, "v"));
    assert!(new.len() > old.len());
    assert_eq!(bits(&new[..old.len()]), bits(&old));
    let (old, new) = (numbers(&before, "f"), numbers(&after, "f"));
    assert_eq!(new[..old.len()], old);
    assert_eq!(loop_count(&desk, "out.obj"), 0);
}

#[test]
fn thread_counts_give_the_same_bytes() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&sphere()));
    let mut results = Vec::new();
    for threads in ["1", "2"] {
        let out = format!("out{threads}.obj");
        let mut command = desk.command(&["fill", "in.obj", "-o", &out]);
        command.env("RAYON_NUM_THREADS", threads);
        Run::of(command).ends(0);
        results.push(desk.bytes(&out));
    }
    assert!(results[0] == results[1]);
}

#[test]
fn quiet_says_nothing() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let loud = desk.run(&["fill", "in.obj", "-o", "a.obj"]).ends(0);
    assert!(loud.stdout.contains("1 hole filled"), "{}", loud.stdout);
    let quiet = desk
        .run(&["fill", "in.obj", "-o", "b.obj", "--quiet"])
        .ends(0);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    assert!(desk.bytes("a.obj") == desk.bytes("b.obj"));
}

/// Every command that writes a mesh prints what loading left out.
#[test]
fn the_notes_of_loading_are_printed() {
    let desk = Desk::new();
    let (positions, triangles) = plate();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nproperty list uchar int obs\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        positions.len(),
        triangles.len()
    );
    for p in &positions {
        writeln!(text, "{} {} {} 1 7", p.x, p.y, p.z).expect("text");
    }
    for [a, b, c] in &triangles {
        writeln!(text, "3 {a} {b} {c}").expect("text");
    }
    desk.write("in.ply", &text);
    let note = "in.ply: vertex lists not kept: obs\n";
    for command in [
        "clean",
        "stitch",
        "flip --component-of 1",
        "erase --faces 1",
        "bridge --from -0.45,0,0 --to 0.45,0,0",
        "refine --levels 1 --method butterfly",
        "refill --fair --ball 0.7,0.7,0,0.29",
        "repair",
        "fill",
    ] {
        let command = format!("{command} in.ply -o out.ply");
        let run = desk.run(&command.split(' ').collect::<Vec<_>>()).ends(0);
        let said = run.stderr;
        assert_eq!(said.matches(note).count(), 1, "{command}: {said}");
        let quiet = format!("{command} --quiet");
        let run = desk.run(&quiet.split(' ').collect::<Vec<_>>()).ends(0);
        assert!(!run.stderr.contains("obs"), "{command}: {}", run.stderr);
    }
    let measured = desk.run(&["analyze", "in.ply"]).ends(0).stdout;
    assert!(measured.contains("  vertex lists not kept: obs\n"));
}

#[test]
fn what_a_format_cannot_keep_is_reported() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let stl = desk.run(&["fill", "in.obj", "-o", "a.stl"]).ends(0);
    assert!(
        stl.stderr.contains("a.stl: STL coordinates are rounded"),
        "{}",
        stl.stderr
    );
    let obj = desk.run(&["fill", "in.obj", "-o", "a.obj"]).ends(0);
    assert!(!obj.stderr.contains("a.obj: "), "{}", obj.stderr);
}

#[test]
fn the_limit_of_steps_has_a_code_and_a_hint_that_names_the_option() {
    let desk = Desk::new();
    desk.write("in.obj", &obj(&plate()));
    let words = [
        "fill", "in.obj", "-o", "a.obj", "--steps", "0", "--report", "r.json",
    ];
    let run = desk.run(&words).ends(0);
    assert!(
        run.stderr.contains("hint: allow more steps with --steps"),
        "{}",
        run.stderr
    );
    let hole = &desk.json("r.json")["holes"][0];
    assert_eq!(hole["warning_codes"], serde_json::json!(["step-limit"]));
    let text = hole["warnings"][0].as_str().expect("a text");
    assert!(
        text.contains("maximum number of steps, 0") && !text.contains("--"),
        "{text}"
    );
}

#[test]
fn the_help_of_samples_names_them_all() {
    let help = Desk::new().run(&["sample", "--help"]).ends(0).stdout;
    for sample in &shapes::SAMPLES {
        assert!(help.contains(sample.name), "{}: {help}", sample.name);
    }
}

#[test]
fn info_shows_loops_and_defects() {
    let desk = Desk::new();
    let mut text = obj(&plate());
    text.push_str("f 1 1 2\n");
    desk.write("in.obj", &text);
    let shown = desk.run(&["info", "in.obj"]).ends(0).stdout;
    for words in [
        "in.obj",
        "vertices",
        "component 0",
        "loop",
        "outer boundary: ",
        "face with a repeated corner, removed: at (",
    ] {
        assert!(shown.contains(words), "no {words:?} in: {shown}");
    }
    let json = desk.run(&["info", "in.obj", "--json"]).ends(0).stdout;
    let info: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(info["degenerate_faces"], 1);
    let loops = info["loops"].as_array().expect("loops");
    assert_eq!(loops.len(), 2);
    let rims: Vec<&Value> = loops.iter().filter(|l| l["outer_rim"] == true).collect();
    assert_eq!(rims.len(), 1);
    assert!((rims[0]["perimeter"].as_f64().expect("a number") - 8.0).abs() < 0.1);
    for field in [
        "number",
        "edges",
        "diameter",
        "radius",
        "centroid",
        "component",
        "reason",
    ] {
        assert!(!loops[0][field].is_null(), "{field}");
    }
    desk.write("closed.obj", &obj(&shapes::icosphere(2)));
    let closed = desk.run(&["info", "closed.obj"]).ends(0).stdout;
    assert!(closed.contains("closed"), "{closed}");
}

/// Raw scans have hundreds of loose triangles.
#[test]
fn long_lists_of_small_parts_are_counted() {
    let desk = Desk::new();
    let (mut positions, mut triangles) = plate();
    for k in 0..200 {
        let first = positions.len() as u32;
        let corner = DVec3::new(3.0, 0.1 * f64::from(k), 0.0);
        positions.extend([corner, corner + 0.05 * DVec3::X, corner + 0.05 * DVec3::Y]);
        triangles.push([first, first + 1, first + 2]);
    }
    desk.write("in.obj", &obj(&(positions, triangles)));
    let shown = desk.run(&["info", "in.obj"]).ends(0).stdout;
    assert!(shown.lines().count() < 100, "{shown}");
    for words in [
        "component 0: ",
        "161 more components of at most 1 face ",
        "162 more loops of at most 3 edges, 162 of them outer boundaries",
    ] {
        assert!(shown.contains(words), "no {words:?} in: {shown}");
    }
    let filled = desk.run(&["fill", "in.obj", "-o", "out.obj", "--report", "out.json"]);
    let said = filled.ends(0).stderr;
    assert!(said.lines().count() < 15, "{said}");
    assert!(
        said.contains("191 more loops of at most 3 edges left open"),
        "{said}"
    );
    let report: Value = serde_json::from_str(&desk.text("out.json")).expect("JSON");
    assert_eq!(report["skipped"].as_array().map(Vec::len), Some(201));
}

#[test]
fn closed_meshes_are_written_as_they_are() {
    let desk = Desk::new();
    let text = obj(&shapes::icosphere(2));
    desk.write("in.obj", &text);
    let run = desk.run(&["fill", "in.obj", "-o", "out.obj"]).ends(0);
    assert!(run.stderr.contains("no boundary loops"), "{}", run.stderr);
    let out = desk.text("out.obj");
    assert_eq!(bits(&numbers(&out, "v")), bits(&numbers(&text, "v")));
    assert_eq!(numbers(&out, "f"), numbers(&text, "f"));
}

#[test]
fn stl_in_ply_out() {
    let desk = Desk::new();
    let (points, faces) = sphere();
    let mut stl = String::from("solid ball\n");
    for t in &faces {
        stl.push_str("facet normal 0 0 0\nouter loop\n");
        for p in t.map(|v| points[v as usize]) {
            writeln!(stl, "vertex {} {} {}", p.x, p.y, p.z).expect("text");
        }
        stl.push_str("endloop\nendfacet\n");
    }
    stl.push_str("endsolid ball\n");
    desk.write("in.stl", &stl);
    desk.run(&["fill", "in.stl", "-o", "out.ply", "--report", "report.json"])
        .ends(0);
    assert_eq!(loop_count(&desk, "out.ply"), 0);
    let report = desk.json("report.json");
    assert_eq!(report["load"]["file_vertices"], 3 * faces.len());
    let used: BTreeSet<u32> = faces.iter().flatten().copied().collect();
    assert_eq!(report["load"]["vertices"], used.len());
    assert_eq!(
        report["load"]["welded_vertices"],
        3 * faces.len() - used.len()
    );
    let map = report["load"]["file_to_mesh"]
        .as_array()
        .expect("an index map");
    let out = io::load(&desk.path("out.ply")).expect("loads");
    for (corner, at) in faces.iter().flatten().zip(map) {
        let at = at.as_u64().expect("an index") as usize;
        assert_eq!(out.positions[at], points[*corner as usize]);
    }
}

#[test]
fn colours_and_groups_survive() {
    let desk = Desk::new();
    let shape = sphere();
    let mut text = String::from("mtllib paint.mtl\n");
    for (i, p) in shape.0.iter().enumerate() {
        let red = (i % 256) as f64 / 255.0;
        writeln!(text, "v {} {} {} {red} 0.25 0.5", p.x, p.y, p.z).expect("text");
    }
    for (i, t) in shape.1.iter().enumerate() {
        if i == 0 {
            text.push_str("g front\nusemtl blue\n");
        } else if i == 100 {
            text.push_str("g back\nusemtl green\n");
        }
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").expect("text");
    }
    desk.write("in.obj", &text);
    for name in ["out.obj", "out.ply"] {
        desk.run(&["fill", "in.obj", "-o", name]).ends(0);
        let out = io::load(&desk.path(name)).expect("loads");
        let colors = out.attributes.vertex_colors();
        assert_eq!(colors.len(), out.positions.len());
        for (i, c) in colors.iter().enumerate() {
            if i < shape.0.len() {
                assert!(
                    (f64::from(c[0]) - (i % 256) as f64 / 255.0).abs() < 1e-6,
                    "{i}"
                );
            }
            assert!(
                (c[1] - 0.25).abs() < 3e-3 && (c[2] - 0.5).abs() < 3e-3,
                "{c:?}"
            );
        }
    }
    let out = desk.text("out.obj");
    for line in [
        "mtllib paint.mtl",
        "g front",
        "g back",
        "usemtl blue",
        "usemtl green",
    ] {
        assert!(out.lines().any(|l| l == line), "{line}");
    }
    let soup = io::load(&desk.path("out.obj")).expect("loads");
    for (f, &tag) in soup
        .attributes
        .faces
        .tags
        .iter()
        .enumerate()
        .take(shape.1.len())
    {
        let group = &soup.attributes.tags[tag as usize].group;
        assert_eq!(group, if f < 100 { "front" } else { "back" });
    }
}

#[test]
fn without_a_display_the_window_says_what_to_do() {
    let desk = Desk::new();
    let mut command = desk.command(&[]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    Run::of(command).fails(1, &["DISPLAY", "xvfb-run", "meniscus fill"]);
}

#[test]
fn the_demo_fills_its_sample() {
    let desk = Desk::new();
    desk.run(&["demo"]).ends(0);
    let folder = Path::new("meniscus-demo");
    let name = |file: &str| folder.join(file).to_string_lossy().into_owned();
    assert_eq!(loop_count(&desk, &name("holed.obj")), 16);
    assert_eq!(loop_count(&desk, &name("filled.obj")), 0);
    let report = desk.json(&name("report.json"));
    assert_eq!(report["totals"]["converged"], true);
    assert_eq!(report["holes"].as_array().map(Vec::len), Some(16));

    let run = desk
        .run(&["demo", "--out", "there/again", "--quiet"])
        .ends(0);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert!(desk.bytes("there/again/filled.obj") == desk.bytes(&name("filled.obj")));
}

#[test]
fn a_message_contains_each_fact_once() {
    let desk = Desk::new();
    let faces = (0..5).map(|i| format!("f {} {} {}\n", i + 1, (i + 1) % 5 + 1, (i + 2) % 5 + 1));
    let strip = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nv 0 0 1\n".to_owned();
    desk.write("strip.obj", &(strip + &faces.collect::<String>()));
    let run = desk.run(&["fill", "strip.obj", "-o", "out.obj"]);
    let run = run.fails(1, &["one-sided", "strip.obj"]);
    assert_eq!(run.stderr.matches("one-sided").count(), 1, "{}", run.stderr);
}

#[test]
fn a_given_energy_selects_the_surface_model_energy() {
    let desk = Desk::new();
    desk.runs(&["sample", "sphere", "-o", "in.obj"]);
    let surface = |arguments: &[&str]| {
        let fill = ["fill", "in.obj", "-o", "out.obj", "--report", "report.json"];
        desk.runs(&[&fill, arguments].concat());
        desk.json("report.json")["holes"][0]["surface"].clone()
    };
    let auto = surface(&[]);
    assert!(auto["expected_error"].as_f64().is_some_and(|e| e > 0.0));
    let candidates = auto["candidates"].as_array().expect("candidates").iter();
    let plain = candidates.filter(|candidate| candidate["symmetric"] == false);
    assert_eq!(plain.count(), 6);
    assert_eq!(auto, surface(&["--surface", "auto"]));
    for arguments in [
        &["--energy", "H^2"][..],
        &["--surface", "energy"],
        &["--bulge", "0.1"],
    ] {
        let energy = surface(arguments);
        assert_eq!(energy["surface"], "energy", "{arguments:?}");
        assert!(energy["expected_error"].is_null(), "{arguments:?}");
    }
    for model in ["diffusion", "g2"] {
        let chosen = surface(&["--surface", model, "--tension", "2.5"]);
        assert_eq!(
            (chosen["surface"].as_str(), chosen["tension"].as_f64()),
            (Some(model), Some(2.5))
        );
    }
}

#[test]
fn each_rim_has_its_continuity() {
    let desk = Desk::with_sample("three-y");
    let blend = |arguments: &[&str]| {
        let blend = [
            "blend",
            "in.obj",
            "-o",
            "out.obj",
            "--report",
            "report.json",
        ];
        desk.runs(&[&blend, arguments].concat());
        let hole = desk.json("report.json")["holes"][0].clone();
        (
            hole["loops"].clone(),
            hole["continuity"].clone(),
            desk.bytes("out.obj"),
        )
    };
    let (loops, continuity, all) = blend(&["--surface", "g2"]);
    assert_eq!(continuity, serde_json::json!(["g2", "g2", "g2"]));
    let [first, second] = [0, 1].map(|i| format!("{}=g{}", loops[i], 1 - i));
    let each = ["--loop-continuity", &first, "--loop-continuity", &second];
    let (_, mixed, other) = blend(&[&["--surface", "g2"], &each[..]].concat());
    assert_eq!(mixed, serde_json::json!(["g1", "g0", "g2"]));
    assert_ne!(all, other);
    let (_, of_energy, _) = blend(&["--energy", "gradH2", "--loop-continuity", &first]);
    assert_eq!(of_energy, serde_json::json!(["g1", "g2", "g2"]));
    let (_, plain, _) = blend(&[]);
    assert_eq!(plain, serde_json::json!(["g1", "g1", "g1"]));
    for model in [&["--surface", "diffusion"][..], &["--energy", "H^2"]] {
        let words = [
            &["blend", "in.obj", "-o", "out.obj", "--continuity", "g2"],
            model,
        ]
        .concat();
        let text = desk.fails(2, &words);
        assert!(text.contains("continuity g2 needs"), "{text}");
    }
}

#[test]
fn the_gradient_of_the_mean_curvature_is_an_energy() {
    let desk = Desk::with_sample("saddle");
    let fill = ["fill", "in.obj", "-o", "out.obj"];
    let words = [
        "--energy",
        "H^2 + c*gradH2",
        "--param",
        "c=0.02",
        "--report",
        "report.json",
    ];
    desk.runs(&[&fill[..], &words].concat());
    let hole = desk.json("report.json")["holes"][0].clone();
    assert_eq!(hole["surface"]["surface"], "energy");
    assert_eq!(
        (&hole["converged"], &hole["continuity"][0]),
        (&true.into(), &"g2".into())
    );
    let ill_posed = ["--energy", "0-gradH2", "--steps", "3"];
    let ill_posed = desk.run(&[&fill[..], &ill_posed].concat());
    assert!(
        ill_posed.stderr.contains("ill-posed"),
        "{}",
        ill_posed.stderr
    );
    let nonlinear = desk.fails(2, &[&fill[..], &["--energy", "H*gradH2"]].concat());
    assert!(nonlinear.contains("    ^^^^^^\n"), "{nonlinear}");
    let mixed = ["--energy", "gradH2", "--scheme", "mixed"];
    let mixed = desk.fails(2, &[&fill[..], &mixed].concat());
    assert!(mixed.contains("scheme `normal`"), "{mixed}");
    let refine = desk.fails(
        2,
        &["refine", "in.obj", "-o", "out.obj", "--energy", "gradH2"],
    );
    assert!(refine.contains("without gradH2"), "{refine}");
    let text = desk
        .run(&["analyze", "out.obj", "--energy", "gradH2", "--json"])
        .ends(0)
        .stdout;
    let report: Value = serde_json::from_str(&text).expect("JSON");
    assert!(
        report["shape"]["energies"]["given"]
            .as_f64()
            .is_some_and(|e| e > 0.0),
        "{text}"
    );
}

#[test]
fn options_that_the_surface_model_does_not_use_are_named() {
    let desk = Desk::with_sample("sphere");
    let fill = ["fill", "in.obj", "-o", "out.obj", "--surface", "g2"];
    let given = desk
        .run(&[&fill[..], &["--energy", "K", "--tension", "1"]].concat())
        .ends(0);
    assert!(
        given
            .stderr
            .contains("no effect: --energy with --surface g2\n"),
        "{}",
        given.stderr
    );
    let plain = desk.run(&fill).ends(0);
    assert!(!plain.stderr.contains("no effect"), "{}", plain.stderr);
    let fill = ["fill", "in.obj", "-o", "out.obj", "--energy", "H^2+a*K^2"];
    let others = [
        "--param",
        "a=1",
        "--param",
        "b=2",
        "--loop-continuity",
        "9=g0",
    ];
    let said = desk.run(&[&fill[..], &others].concat()).ends(0).stderr;
    let wanted = "no effect: --loop-continuity 9, because loop 9 is not filled\n\
                  no effect: --param b, because `H^2+a*K^2` does not contain it\n";
    assert!(said.contains(wanted), "{said}");
}
