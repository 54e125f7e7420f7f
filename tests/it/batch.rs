//! `meniscus fill` with several files.

use std::fs;

use crate::common::desk::{Desk, Run};

/// A folder with meshes of three formats, two of them in a folder `scans`.
fn desk() -> Desk {
    let desk = Desk::new();
    fs::create_dir(desk.path("scans")).expect("a folder");
    for (sample, file) in [
        ("sphere", "a.ply"),
        ("torus", "scans/b.obj"),
        ("sphere", "scans/c.stl"),
    ] {
        desk.runs(&["sample", sample, "-o", file]);
    }
    desk
}

const FILES: [&str; 3] = ["a.ply", "scans/b.obj", "scans/c.stl"];
const RESULTS: [&str; 3] = ["a.ply", "b.obj", "c.stl"];

#[test]
fn each_file_is_filled_to_the_bytes_of_a_single_fill() {
    let desk = desk();
    let words = [&["fill"], &FILES[..], &["--out-dir", "new/filled"]].concat();
    let run = desk.run(&words).ends(0);
    fs::create_dir(desk.path("single")).expect("a folder");
    for (k, (file, result)) in FILES.iter().zip(RESULTS).enumerate() {
        let single = format!("single/{result}");
        desk.runs(&["fill", file, "-o", &single]);
        let same = desk.bytes(&single) == desk.bytes(&format!("new/filled/{result}"));
        assert!(same, "{file}");
        let line = format!("{} of 3: {file}\n", k + 1);
        assert!(run.stderr.contains(&line), "{}", run.stderr);
    }
    let rows: Vec<&str> = run.stdout.lines().collect();
    assert_eq!(rows.len(), 4, "{}", run.stdout);
    let head = [
        "file", "holes", "filled", "warnings", "expected", "error", "seconds",
    ];
    assert!(rows[0].split_whitespace().eq(head), "{}", rows[0]);
    for (row, file) in rows[1..].iter().zip(FILES) {
        let cells: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(cells[0], file);
        assert!(cells[1] != "0" && cells[1] == cells[2], "{row}");
        assert!(cells[4].parse::<f64>().expect("a number") > 0.0, "{row}");
        assert_eq!(row.len(), rows[0].len(), "{}", run.stdout);
    }
}

#[test]
fn a_bad_file_does_not_end_the_batch() {
    let desk = desk();
    desk.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    desk.write("notes.txt", "no mesh");
    let words = [
        "fill",
        "a.ply",
        "bad.obj",
        "notes.txt",
        "scans/b.obj",
        "--out-dir",
        "filled",
        "--report",
        "report.json",
    ];
    let run = desk.run(&words);
    let run = run.fails(
        1,
        &["meniscus: bad.obj", "notes.txt", "2 of 4 files failed"],
    );
    let written = fs::read_dir(desk.path("filled")).expect("a folder").count();
    assert_eq!(written, 2);
    for name in ["filled/a.ply", "filled/b.obj"] {
        assert!(!desk.mesh(name).faces.is_empty());
    }
    let row = run.stdout.lines().find(|row| row.starts_with("bad.obj"));
    assert!(
        row.is_some_and(|row| row.contains("failed")),
        "{}",
        run.stdout
    );

    let report = desk.json("report.json");
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    let files = report["files"].as_array().expect("a list");
    let names: Vec<&str> = files.iter().filter_map(|f| f["file"].as_str()).collect();
    assert_eq!(names, words[1..5]);
    for (k, file) in files.iter().enumerate() {
        let failed = k == 1 || k == 2;
        assert_eq!(file["error"].is_string(), failed, "{file}");
        assert_eq!(file["report"].is_null(), failed, "{file}");
    }
    desk.runs(&["fill", "a.ply", "-o", "one.ply", "--report", "one.json"]);
    let (one, entry) = (desk.json("one.json"), &files[0]["report"]);
    let fields = |value: &serde_json::Value| -> Vec<String> {
        let object = value.as_object().expect("an object");
        object.keys().cloned().collect()
    };
    assert_eq!(fields(entry), fields(&one));
    assert_eq!(entry["input"], "a.ply");
    assert_eq!(
        entry["holes"][0]["energy_end"],
        one["holes"][0]["energy_end"]
    );
}

/// The number of threads changes neither what is printed nor what is written, also where two files have
/// libraries of one name.
#[test]
fn the_order_is_that_of_the_files_for_any_number_of_threads() {
    let desk = desk();
    for folder in ["x", "y"] {
        fs::create_dir(desk.path(folder)).expect("a folder");
        let file = format!("{folder}/{folder}.obj");
        desk.runs(&["sample", "sphere", "-o", &file]);
        let text = format!("mtllib all.mtl\n{}", desk.text(&file));
        desk.write(&file, &text);
        desk.write(&format!("{folder}/all.mtl"), &format!("newmtl {folder}\n"));
    }
    desk.write("bad.ply", "ply\n");
    // a large file before small ones
    let files = [
        "scans/b.obj",
        "bad.ply",
        "x/x.obj",
        "a.ply",
        "y/y.obj",
        "scans/c.stl",
    ];
    let results = [1, 4].map(|threads: usize| {
        let folder = format!("filled-{threads}");
        let words = [&["fill"], &files[..], &["--out-dir", &folder]].concat();
        let mut command = desk.command(&words);
        command.env("RAYON_NUM_THREADS", threads.to_string());
        let run = Run::of(command).ends(1);
        let without_time = |row: &str| {
            let cells: Vec<&str> = row.split_whitespace().collect();
            cells[..cells.len() - 1].join(" ")
        };
        let table: Vec<String> = run.stdout.lines().map(without_time).collect();
        let said = run.stderr.replace(&folder, "filled");
        let numbers = said.lines().filter(|line| line.contains(" of 6: "));
        let wanted = (1..)
            .zip(files)
            .map(|(k, file)| format!("{k} of 6: {file}"));
        assert!(numbers.eq(wanted), "{said}");
        let mut names: Vec<_> = fs::read_dir(desk.path(&folder))
            .expect("a folder")
            .map(|entry| entry.expect("an entry").file_name())
            .collect();
        names.sort();
        let bytes =
            |name: &std::ffi::OsString| desk.bytes(&format!("{folder}/{}", name.to_string_lossy()));
        let contents: Vec<Vec<u8>> = names.iter().map(bytes).collect();
        (table, said, names, contents)
    });
    assert!(
        results[0] == results[1],
        "{}\n{}",
        results[0].1,
        results[1].1
    );
    assert_eq!(results[0].2.len(), 6);
    assert!(
        results[0].1.contains("another file of this name"),
        "{}",
        results[0].1
    );
    // its library is another file
    let error = "y/y.obj: filled/y.obj is written, but another file than that of the input is beside it: 'all.mtl'";
    assert!(results[0].1.contains(error), "{}", results[0].1);
    assert!(results[0].1.contains("2 of 6 files failed"));
    assert_eq!(desk.text("filled-4/all.mtl"), "newmtl x\n");
}

#[test]
fn quiet_prints_only_errors() {
    let desk = desk();
    let words = [
        "fill",
        "a.ply",
        "--out-dir",
        "filled",
        "--quiet",
        "--max-edges",
        "3",
    ];
    let run = desk.run(&words).ends(0);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert!(desk.path("filled/a.ply").exists());
}

#[test]
fn nothing_is_filled_where_an_output_would_replace_a_file() {
    let desk = desk();
    desk.runs(&["sample", "sphere", "-o", "b.obj"]);
    let before = desk.bytes("a.ply");
    let batch = |words: &[&str]| desk.run(&[&["fill"], words].concat());
    batch(&["a.ply", "b.obj", "scans/b.obj", "--out-dir", "filled"])
        .fails(1, &["b.obj and scans/b.obj", "nothing was filled"]);
    batch(&["b.obj", "a.ply", "--out-dir", "."]).fails(1, &["would replace the input b.obj"]);
    assert!(!desk.path("filled").exists());
    batch(&["a.ply", "--out-dir", "filled", "--report", "filled/a.ply"])
        .fails(1, &["--report is the same file as OUT"]);
    batch(&["a.ply", "--out-dir", "filled", "--report", "a.ply"])
        .fails(1, &["--report is the same file as IN"]);
    batch(&["a.ply", "--out-dir", "b.obj"]).fails(1, &["cannot create the folder b.obj"]);
    #[cfg(unix)]
    {
        fs::create_dir(desk.path("links")).expect("a folder");
        let link = desk.path("links/b.obj");
        std::os::unix::fs::symlink(desk.path("a.ply"), link).expect("a link");
        batch(&["a.ply", "b.obj", "--out-dir", "links"])
            .fails(1, &["links/b.obj would replace the input a.ply"]);
    }
    assert!(!desk.path("filled/a.ply").exists());
    assert!(desk.bytes("a.ply") == before);
}

#[test]
fn options_for_one_mesh_are_refused() {
    let desk = desk();
    let batch = |more: &[&str]| {
        let words = ["fill", "a.ply", "scans/b.obj", "--out-dir", "filled"];
        desk.run(&[&words, more].concat())
    };
    for more in [
        &["--loops", "1,2"][..],
        &["--loop-at", "0,0,1"],
        &["--part", "0,0,1", "0,1,0"],
        &["--loop-continuity", "1=g0"],
        &["--schedule", "s.csv"],
        &["--trace", "t.csv"],
        #[cfg(feature = "render")]
        &["--picture", "p.png"],
    ] {
        batch(more).fails(2, &[more[0], "is for one mesh"]);
    }
    batch(&["--energy", "H^2 +"]).fails(2, &["--energy"]);
    batch(&["-o", "out.ply"]).fails(2, &["cannot be used with"]);
    desk.run(&["fill", "a.ply", "scans/b.obj", "-o", "out.ply"])
        .fails(2, &["several meshes need --out-dir"]);
    desk.run(&["fill", "--out-dir", "filled"])
        .fails(2, &["<IN>"]);
    assert!(!desk.path("filled").exists());
}
