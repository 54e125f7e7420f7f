//! Output files under bad conditions: the old or the complete new file, and a clear message.

use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::common::desk::{Desk, Run};

/// A mesh of `side`² squares.
fn plane(side: usize) -> String {
    use std::fmt::Write as _;
    let mut text = String::new();
    for i in 0..=side {
        for j in 0..=side {
            writeln!(text, "v {i} {j} {}", (i * j) as f64 / 7.0).expect("text");
        }
    }
    let at = |i: usize, j: usize| i * (side + 1) + j + 1;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("text");
    }
    text
}

/// Kills the program while it writes a file over an old one. `MENISCUS_KILLS` is the number of kills,
/// 6 without it.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_save_leaves_the_old_or_the_new_file() {
    let kills = std::env::var("MENISCUS_KILLS").map_or(6, |text| text.parse().expect("a number"));
    let desk = Desk::new();
    desk.write("in.obj", &plane(300));
    let words = [
        "flip",
        "in.obj",
        "-o",
        "out.obj",
        "--component-of",
        "1",
        "--quiet",
    ];
    desk.runs(&words);
    let new = desk.bytes("out.obj");
    let (mut old_left, mut new_left) = (0, 0);
    for round in 0..kills {
        desk.write("out.obj", "old");
        let mut child = desk.command(&words).spawn().expect("the program starts");
        let unfinished = || {
            desk.names()
                .into_iter()
                .find(|name| name.starts_with(".meniscus-"))
        };
        let start = Instant::now();
        while unfinished().is_none() && start.elapsed() < Duration::from_mins(1) {
            assert!(
                child.try_wait().expect("a child").is_none(),
                "it was too fast"
            );
            std::thread::sleep(Duration::from_micros(200));
        }
        // at different times of the save
        std::thread::sleep(Duration::from_millis(20 * (round % 12)));
        child.kill().expect("killed");
        child.wait().expect("ended");
        match desk.bytes("out.obj") {
            bytes if bytes == b"old" => old_left += 1,
            bytes if bytes == new => new_left += 1,
            bytes => panic!("{} bytes, neither old nor new", bytes.len()),
        }
        // what SIGKILL leaves is a hidden file, which the next save does not mind
        if let Some(name) = unfinished() {
            fs::remove_file(desk.path(&name)).expect("removed");
        }
    }
    eprintln!("{kills} kills: {old_left} old files, {new_left} new ones");
    assert_eq!(old_left + new_left, kills);
}

/// The message of a fill into this file.
fn refused(desk: &Desk, target: &str, words: &[&str]) {
    desk.run(&["fill", "in.obj", "-o", target]).fails(1, words);
}

#[test]
fn files_that_cannot_be_written_are_said_before_the_computation() {
    let desk = Desk::with_sample("sphere");
    let text = desk.text("in.obj");
    refused(&desk, "in.obj", &["same file"]);
    refused(&desk, "none/out.obj", &["none"]);
    fs::create_dir(desk.path("folder.obj")).expect("a folder");
    refused(&desk, "folder.obj", &["folder"]);
    let long = format!("{}.obj", "long".repeat(100));
    refused(&desk, &long, &["long"]);
    #[cfg(target_os = "linux")]
    {
        // no user can create files there
        refused(&desk, "/proc/out.obj", &["/proc/out.obj"]);
        std::os::unix::fs::symlink("missing.obj", desk.path("link.obj")).expect("a link");
        desk.runs(&["fill", "in.obj", "-o", "link.obj"]);
        std::os::unix::fs::symlink("circle.obj", desk.path("circle.obj")).expect("a link");
        refused(&desk, "circle.obj", &["circle.obj"]);
    }
    assert_eq!(desk.text("in.obj"), text);
    let left: Vec<String> = desk
        .names()
        .into_iter()
        .filter(|n| n.contains("tmp"))
        .collect();
    assert_eq!(left, Vec::<String>::new());
}

/// A pipe with a name is written to, and its reader gets the whole mesh.
#[cfg(target_os = "linux")]
#[test]
fn a_pipe_gets_the_whole_mesh() {
    let desk = Desk::with_sample("sphere");
    desk.runs(&["fill", "in.obj", "-o", "out.obj"]);
    let made = std::process::Command::new("mkfifo")
        .arg(desk.path("pipe.obj"))
        .status();
    assert!(made.expect("mkfifo runs").success());
    let mut writer = desk.command(&["fill", "in.obj", "-o", "pipe.obj"]);
    let mut writer = writer
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    let read = fs::read(desk.path("pipe.obj")).expect("read");
    assert!(writer.wait().expect("ended").success());
    assert_eq!(read, desk.bytes("out.obj"));
}

/// Commands need neither a home folder nor a place for settings.
#[test]
fn commands_work_without_a_home() {
    let desk = Desk::with_sample("sphere");
    let mut command = desk.command(&["fill", "in.obj", "-o", "out.obj"]);
    for name in ["HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "TMPDIR"] {
        command.env_remove(name);
    }
    Run::of(command).ends(0);
}

/// A disk without room is said, and the old file stays.
#[cfg(target_os = "linux")]
#[test]
fn a_file_larger_than_allowed_leaves_the_old_one() {
    let desk = Desk::with_sample("sphere");
    desk.write("out.obj", "old");
    let program = env!("CARGO_BIN_EXE_meniscus");
    let mut shell = std::process::Command::new("sh");
    // 16 blocks of 512 bytes; without the signal that ends the program
    let line = format!("trap '' XFSZ; ulimit -f 16; exec '{program}' fill in.obj -o out.obj");
    shell.current_dir(desk.path("")).args(["-c", &line]);
    Run::of(shell).fails(1, &["out.obj"]);
    assert_eq!(desk.text("out.obj"), "old");
    assert_eq!(desk.names(), ["in.obj", "out.obj"]);
}
