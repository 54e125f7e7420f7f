//! The program itself, in a real window on a virtual display, worked with mouse and keys.
//! `scripts/test.sh` installs Xvfb and xdotool.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::wait::{wait_at_most, wait_for};
use meniscus::io;
use meniscus::mesh::{DVec3, Mesh, boundary_loops, check_mesh};
use meniscus::render::{Bounds, Camera};
use meniscus::shapes::{Hole, HoleShape, cut_holes, sphere};

/// A process that ends with the test, whether it passes or fails.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// A separate virtual display with a free number.
struct Display {
    _server: Process,
    name: String,
}

impl Display {
    fn new() -> Self {
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1400x900x24",
                "-nolisten",
                "tcp",
                // without it the server starts anew after its last client, such as xdotool, and drops others
                // that connect meanwhile
                "-noreset",
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is not installed: run scripts/test.sh, which installs it");
        let out = server.stdout.take().expect("a pipe");
        let server = Process(server);
        let mut number = String::new();
        BufReader::new(out)
            .read_line(&mut number)
            .expect("Xvfb says its number");
        let number = number.trim();
        assert!(!number.is_empty(), "Xvfb did not start");
        Self {
            _server: server,
            name: format!(":{number}"),
        }
    }

    /// Runs xdotool and returns its output.
    fn hand(&self, args: &[&str]) -> String {
        let out = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.name)
            .output()
            .expect("xdotool is not installed: run scripts/test.sh, which installs it");
        String::from_utf8_lossy(&out.stdout).trim().to_owned()
    }
}

/// Waits until the program is idle: it has used no processor time for a while. That interval is
/// shorter than a text cursor stays on or off.
fn wait_until_idle(program: &Process) {
    let spent = || -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", program.0.id()));
        let stat = stat.unwrap_or_default();
        // after the name, which may hold anything: user and system time are fields 14 and 15
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split(' ').collect();
        let field = |i: usize| fields.get(i - 2).and_then(|x| x.parse::<u64>().ok());
        field(14).unwrap_or(0) + field(15).unwrap_or(0)
    };
    let mut last = (spent(), Instant::now());
    wait_for("an idle program", || {
        let now = spent();
        if now != last.0 {
            last = (now, Instant::now());
        }
        (last.1.elapsed() > Duration::from_millis(350)).then_some(())
    });
}

/// The recovery file of the program, once it keeps one.
fn recovery(folder: &Path) -> Option<String> {
    let entries = std::fs::read_dir(folder.join("state/meniscus/recovery")).ok()?;
    let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let path = paths.find(|path| path.extension().is_some_and(|e| e == "meniscus"))?;
    std::fs::read_to_string(path).ok()
}

/// A sphere with a hole towards the first camera and one on the far side, as a file.
fn model(folder: &Path) -> (PathBuf, Mesh) {
    let one = DVec3::ONE;
    let towards = -Camera::fit(&Bounds::new(-one, one)).forward();
    let hole = |centre, seed| Hole {
        centre,
        shape: HoleShape::Disc { radius: 0.4 },
        turn: 0.0,
        seed,
    };
    let (positions, triangles) = cut_holes(&sphere(900, 3), &[hole(towards, 1), hole(-towards, 2)]);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("a sphere");
    let path = folder.join("holes.obj");
    io::save_mesh(&path, &mesh).expect("written");
    (path, mesh)
}

#[test]
fn a_hole_is_clicked_filled_and_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, before) = model(folder.path());
    // another scale of the interface than the one of the first frame
    let config = folder.path().join("config/meniscus");
    std::fs::create_dir_all(&config).expect("made");
    std::fs::write(config.join("settings.toml"), "ui_scale = 1.25\n").expect("written");
    let display = Display::new();
    let program = Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .arg(&path)
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        .env("HOME", folder.path())
        .env("XDG_CONFIG_HOME", folder.path().join("config"))
        .env("XDG_STATE_HOME", folder.path().join("state"))
        .env("XDG_RUNTIME_DIR", folder.path())
        // no file dialog: the path is typed
        .env("DBUS_SESSION_BUS_ADDRESS", "unix:path=/nonexistent")
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut program = Process(program);
    let window = wait_for("the window", || {
        let found = display.hand(&["search", "--name", "holes.obj - Meniscus"]);
        found.lines().next().map(str::to_owned)
    });
    display.hand(&["windowfocus", "--sync", &window]);
    let title = || display.hand(&["getwindowname", &window]);

    // the middle of the view: between the left panel of 244 and the right one of 260 points, each of
    // 1.25 pixels
    let geometry = display.hand(&["getwindowgeometry", "--shell", &window]);
    let size = |name: &str| -> i32 {
        let line = geometry.lines().find_map(|l| l.strip_prefix(name));
        line.and_then(|l| l.parse().ok()).expect("a size")
    };
    let (x, y) = ((size("WIDTH=") - 20) / 2, size("HEIGHT=") / 2);
    let (x, y) = (x.to_string(), y.to_string());
    display.hand(&["mousemove", "--window", &window, &x, &y]);
    // a click before the mesh can be picked selects nothing; a recovery file holds the selection
    wait_for("the hole, selected", || {
        display.hand(&["click", "1"]);
        wait_at_most(Duration::from_secs(5), || {
            let text = recovery(folder.path())?;
            let mut lines = text.lines();
            let line = lines.find(|line| line.starts_with("selection = "))?;
            (line != "selection = []").then_some(())
        })
    });
    // the first Enter starts the flow; an Enter after the end of the flow accepts the patch
    wait_for("the patch, accepted", || {
        display.hand(&["key", "Return"]);
        wait_at_most(Duration::from_secs(5), || {
            title().contains("holes.obj*").then_some(())
        })
    });

    let target = folder.path().join("closed.obj");
    display.hand(&["key", "ctrl+s"]);
    wait_until_idle(&program);
    display.hand(&["key", "ctrl+a"]);
    display.hand(&["type", "--delay", "15", &target.display().to_string()]);
    display.hand(&["key", "Return"]);
    wait_for("the file", || target.exists().then_some(()));
    wait_for("the title without star", || {
        (!title().contains('*')).then_some(())
    });
    let saved = io::open(&target).expect("a mesh").mesh;
    check_mesh(&saved).expect("sound");
    assert_eq!(saved.positions[..before.vertex_count()], before.positions);
    let loops = boundary_loops(&saved);
    assert_eq!(loops.len(), 1, "the hole behind the surface was not picked");
    let eye = -Camera::fit(&Bounds::new(-DVec3::ONE, DVec3::ONE)).forward();
    assert!(
        loops[0].centroid.dot(eye) < 0.0,
        "it is the one behind that is open"
    );

    display.hand(&["key", "ctrl+q"]);
    let status = wait_for("the end", || program.0.try_wait().ok().flatten());
    assert!(status.success());
}
