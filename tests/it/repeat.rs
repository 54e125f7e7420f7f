//! The command line copied from the window reproduces the window's result bit-identically.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

use crate::common::wait::wait_for;
use meniscus::app::{
    Action, Autosave, BrushStamp, ControlsAction, Document, EditAction, Effect, FaceEdit,
    FileAction, Model, Part, Refining, Run, RunAction, SelectAction, SelectHow, Settings, Source,
    Task, TaskAction, act, tick,
};
use meniscus::fill::{Continuity, LoopLimits};
use meniscus::io;
use meniscus::mesh::{DVec3, FaceId, Mesh, build};
use meniscus::options::Options;
use meniscus::shapes::{Hole, HoleShape, Sample, cut_holes, sphere};

fn until(model: &mut Model, what: &str, done: impl Fn(&Model) -> bool) {
    wait_for(what, || {
        tick(model, Instant::now());
        done(model).then_some(())
    });
}

fn states(model: &Model) -> usize {
    model.run.as_ref().map_or(0, Run::state_count)
}

fn ended(model: &Model) -> bool {
    model.run.as_ref().is_some_and(Run::ended)
}

fn set_energy(model: &mut Model, energy: &str) {
    act(model, ControlsAction::EnergyText(energy.into()));
    act(model, ControlsAction::ApplyEnergy);
}

/// Runs the flow to its end and accepts it.
fn finish(model: &mut Model) {
    act(model, RunAction::Finish);
    until(model, "the end", ended);
    act(model, RunAction::Accept(0));
}

/// A sphere with three holes, as a file.
fn scan(path: &Path) {
    let hole = |centre: [f64; 3], radius, seed| Hole {
        centre: DVec3::from_array(centre),
        shape: HoleShape::Ragged { radius },
        turn: 0.0,
        seed,
    };
    let holes = [
        hole([1.0, 0.2, 0.1], 0.4, 1),
        hole([-1.0, 0.3, 0.2], 0.35, 2),
        hole([0.0, 1.0, 0.1], 0.3, 3),
    ];
    let (positions, triangles) = cut_holes(&sphere(900, 8), &holes);
    io::save_mesh(
        path,
        &Mesh::from_triangles(positions, &triangles).expect("a sphere"),
    )
    .expect("written");
}

fn opened(input: PathBuf) -> Model {
    let opened = io::open(&input).expect("a mesh");
    let document = Document::new(opened, Source::File(input));
    let mut m = Model::new(
        document,
        Settings::default(),
        Autosave::off(),
        Arc::new(|| ()),
    );
    act(&mut m, RunAction::Pace(240.0));
    m
}

#[test]
fn the_copied_command_gives_the_same_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("a scan.obj");
    let output = folder.path().join("done.obj");
    scan(&input);
    let mut m = opened(input);

    // first run: two holes, everything changed on the way
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, SelectAction::Loop(2.into(), SelectHow::Add));
    act(&mut m, RunAction::Start);
    until(&mut m, "states", |m| states(m) > 4);
    set_energy(&mut m, "H^2 + 0.1*K^2");
    until(&mut m, "more states", |m| states(m) > 8);
    let mut controls = m.document.controls.clone();
    controls.density = 1.4;
    controls.relaxation = 0.3;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    until(&mut m, "states at the new density", |m| states(m) > 12);
    act(&mut m, RunAction::Scrub(Some(6)));
    act(&mut m, RunAction::ContinueFromShown);
    until(&mut m, "states after the rewind", |m| states(m) > 16);
    set_energy(&mut m, "H^2 + 0.02*gradH2");
    until(&mut m, "states of sixth order", |m| states(m) > 18);
    finish(&mut m);
    // second run: a crease, stopped before its end
    act(&mut m, SelectAction::All);
    let mut controls = m.document.controls.clone();
    controls.continuity = Continuity::G0;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    act(&mut m, RunAction::Start);
    until(&mut m, "states", |m| states(m) > 5);
    act(&mut m, RunAction::Stop);
    until(&mut m, "the stop", ended);
    act(&mut m, RunAction::Accept(0));
    assert!(m.document.loops.is_empty());
    repeats(&mut m, &output);
}

/// A sample with a texture image, written and opened.
fn opened_egg(path: &Path) -> Model {
    let sample = Sample::named("egg").expect("a sample");
    let (egg, _) = build(&sample.soup()).expect("sound");
    io::save_mesh(path, &egg).expect("written");
    opened(path.to_owned())
}

/// The image of the patches is the same, too.
#[test]
fn texture_images_are_repeated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut m = opened_egg(&at("egg.obj"));
    act(&mut m, RunAction::Start);
    until(&mut m, "the end", ended);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, FileAction::SaveAs(at("done.obj")));
    until(&mut m, "the file", |m| {
        at("done.obj").exists() && !m.is_dirty()
    });
    let beside = ["done_meniscus.mtl", "done_patches.png"];
    let saved = beside.map(|name| std::fs::read(at(name)).expect("saved"));
    repeats(&mut m, &at("done.obj"));
    assert_eq!(
        beside.map(|name| std::fs::read(at(name)).expect("made")),
        saved
    );
}

/// The image of each fill is the same, although the window saves once and the commands after each.
#[test]
fn texture_images_of_several_fills_are_repeated() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mut m = opened_egg(&at("egg.obj"));
    // the second loop is on the seam, before and after
    for on_seam in [1, 1] {
        act(
            &mut m,
            SelectAction::Loop(on_seam.into(), SelectHow::Replace),
        );
        act(&mut m, RunAction::Start);
        until(&mut m, "the end", ended);
        act(&mut m, RunAction::Accept(0));
        until(&mut m, "the textures", |m| m.run.is_none());
    }
    let (mesh, script) = saved(&mut m, &at("done.obj"));
    let images = ["done_patches.png", "done_patches_2.png"].map(|name| {
        let image = std::fs::read(at(name)).expect("saved");
        std::fs::remove_file(at(name)).expect("there");
        image
    });
    run(&script, folder.path(), "2");
    let made = ["egg_1_patches.png", "done_patches_2.png"];
    assert_eq!(
        made.map(|name| std::fs::read(at(name)).expect("made")),
        images
    );
    let rest = |bytes: &[u8]| -> Vec<String> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let lines = text.lines().filter(|line| !line.starts_with("mtllib"));
        lines.map(str::to_owned).collect()
    };
    let again = std::fs::read(at("done.obj")).expect("made");
    assert!(rest(&mesh) == rest(&again), "{script}");
}

/// Saves. Returns the file, and the copied commands.
fn saved(m: &mut Model, output: &Path) -> (Vec<u8>, String) {
    act(m, FileAction::SaveAs(output.to_owned()));
    until(m, "the file", |m| !m.is_dirty());
    let saved = std::fs::read(output).expect("saved");
    act(m, FileAction::CopyCommand);
    let Some(Effect::CopyText(script)) = m.effects.pop() else {
        panic!("nothing copied: {:?}", m.log.entries().last());
    };
    // files that the commands read are named
    if script.contains("--schedule") {
        let told = m.log.latest().map(|entry| entry.text.clone());
        assert!(told.is_some_and(|text| text.contains("schedule.csv, which was written")));
    }
    std::fs::remove_file(output).expect("there");
    (saved, script)
}

/// Runs commands in a folder.
fn run(script: &str, folder: &Path, threads: &str) {
    let program = Path::new(env!("CARGO_BIN_EXE_meniscus"));
    let bin = program.parent().expect("a folder").display().to_string();
    let path = std::env::var("PATH").unwrap_or_default();
    let status = Command::new("sh")
        .args(["-e", "-c", script])
        .env("PATH", format!("{bin}:{path}"))
        .env("RAYON_NUM_THREADS", threads)
        .current_dir(folder)
        .status()
        .expect("a shell");
    assert!(status.success(), "{script}");
}

/// Saves, runs the copied commands with one thread and with two, and compares the files.
fn repeats(m: &mut Model, output: &Path) {
    let (saved, script) = saved(m, output);
    for threads in ["1", "2"] {
        run(&script, output.parent().expect("a folder"), threads);
        assert!(
            std::fs::read(output).expect("made") == saved,
            "{threads} threads:\n{script}"
        );
    }
}

/// Paints the faces around the vertex farthest in a direction.
fn paint(m: &mut Model, towards: DVec3, radius: f64) {
    let mesh = Arc::clone(&m.document.mesh);
    let far = |f: &u32| mesh.corners(FaceId(*f))[0].dot(towards);
    let faces = 0..mesh.face_count() as u32;
    let face = faces.max_by(|a, b| far(a).total_cmp(&far(b))).map(FaceId);
    let face = face.expect("faces");
    let point = mesh.corners(face)[0];
    let stamps = vec![BrushStamp {
        face,
        point,
        radius,
    }];
    act(
        m,
        SelectAction::Faces(FaceEdit::Paint {
            stamps,
            take: false,
        }),
    );
}

#[test]
fn repairs_are_repeated_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("scan.obj");
    let output = folder.path().join("done.obj");
    scan(&input);
    let mut m = opened(input);
    act(&mut m, EditAction::Flip(0.into()));
    let l = &m.document.loops[0];
    let at = |i: usize| m.document.mesh.position(l.vertices[i]);
    let ends = [at(0), at(l.edges() / 2)];
    act(&mut m, EditAction::Bridge(ends, 2));
    act(&mut m, TaskAction::Choose(Task::Repair));
    paint(&mut m, DVec3::Z, 0.45);
    act(&mut m, RunAction::Start);
    until(&mut m, "states", |m| states(m) > 4);
    set_energy(&mut m, "H^2 + 0.1*K^2");
    until(&mut m, "more states", |m| states(m) > 8);
    finish(&mut m);

    paint(&mut m, DVec3::NEG_Y, 0.5);
    act(&mut m, RunAction::Fair);
    until(&mut m, "states", |m| states(m) > 8);
    act(&mut m, RunAction::Scrub(Some(3)));
    act(&mut m, RunAction::ContinueFromShown);
    until(&mut m, "states after the rewind", |m| states(m) > 12);
    act(&mut m, RunAction::Stop);
    until(&mut m, "the stop", ended);
    act(&mut m, RunAction::Accept(0));

    // a list that fits on the line
    paint(&mut m, DVec3::NEG_Z, 0.1);
    act(&mut m, EditAction::Erase);
    repeats(&mut m, &output);
}

/// A part of a hole, and a bridge that flows with the patches on both sides.
#[test]
fn parts_and_bridges_are_repeated_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("scan.obj");
    let output = folder.path().join("done.obj");
    scan(&input);
    let mut m = opened(input);
    let across = |m: &Model, number: usize, part: usize| {
        let l = &m.document.loops[number];
        [0, l.edges() / part].map(|i| m.document.mesh.position(l.vertices[i]))
    };
    let [from, to] = across(&m, 0, 3).map(Some);
    act(&mut m, TaskAction::Part(Some(Part { from, to })));
    act(&mut m, RunAction::Start);
    until(&mut m, "states", |m| states(m) > 4);
    let mut controls = m.document.controls.clone();
    controls.density = 1.3;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    until(&mut m, "states at the new density", |m| states(m) > 8);
    finish(&mut m);
    assert_eq!(m.document.loops.len(), 3);

    let ends = across(&m, 1, 2);
    act(&mut m, EditAction::Bridge(ends, 2));
    assert_eq!(m.document.loops.len(), 4);
    act(&mut m, RunAction::Start);
    until(&mut m, "states", |m| states(m) > 4);
    set_energy(&mut m, "H^2 + 0.1*K^2");
    until(&mut m, "more states", |m| states(m) > 8);
    finish(&mut m);
    assert!(m.document.loops.is_empty());
    repeats(&mut m, &output);
}

/// A slit between two strips, and a loose triangle.
#[test]
fn cleaning_is_repeated_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("scan.obj");
    let output = folder.path().join("done.obj");
    let row = |x: f64| (0..4).map(move |y| DVec3::new(x, f64::from(y), 0.0));
    let mut positions: Vec<DVec3> = row(0.0).chain(row(1.0)).chain(row(1.001)).collect();
    positions.extend(row(2.0));
    let strips = [0, 8].into_iter().flat_map(|k| k..k + 3);
    let mut triangles: Vec<[u32; 3]> = strips
        .flat_map(|a| [[a, a + 4, a + 5], [a, a + 5, a + 1]])
        .collect();
    positions.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|p| 9.0 * p));
    triangles.insert(3, [16, 17, 18]);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("three parts");
    io::save_mesh(&input, &mesh).expect("written");
    let mut m = opened(input);
    let before = m.document.mesh.clone();
    assert_eq!(
        (&before.positions, &before.topology),
        (&mesh.positions, &mesh.topology)
    );
    act(&mut m, EditAction::Stitch);
    assert_eq!(m.document.mesh.vertex_count(), 15);
    act(&mut m, EditAction::Stitch);
    act(&mut m, EditAction::Clean);
    assert_eq!(m.document.mesh.face_count(), 12);
    assert_eq!(m.document.accepted.len(), 2);
    repeats(&mut m, &output);
    act(&mut m, EditAction::Undo);
    act(&mut m, EditAction::Undo);
    assert_eq!(*m.document.mesh, *before);
}

/// Everything at once: as `meniscus repair`, as one change, and as commands.
#[test]
fn a_repair_of_everything_is_repeated_and_undone() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("raw.ply");
    let output = folder.path().join("done.ply");
    let hole = Hole {
        centre: DVec3::Z,
        shape: HoleShape::Ragged { radius: 0.4 },
        turn: 0.0,
        seed: 1,
    };
    let (mut positions, mut triangles) = cut_holes(&sphere(2000, 1), &[hole]);
    // a vertex on the far side, and a loose triangle
    let spike = positions.iter().position(|p| p.x > 0.99).expect("a vertex");
    positions[spike] = DVec3::new(-1.2, 0.0, 0.0);
    let first = positions.len() as u32;
    positions.extend([2.0, 2.1, 2.2].map(|x| DVec3::new(x, 0.1 * x * x, 0.0)));
    triangles.push([first, first + 1, first + 2]);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("two parts");
    io::save_mesh(&input, &mesh).expect("written");
    let mut m = opened(input);
    act(&mut m, ControlsAction::Set(Box::default()));
    let before = m.document.mesh.clone();
    act(&mut m, EditAction::Repair);
    // nothing else starts meanwhile
    act(&mut m, RunAction::Start);
    act(&mut m, EditAction::Clean);
    assert!(m.run.is_none());
    act(&mut m, Action::Escape);
    until(&mut m, "the end of all jobs", |m| m.jobs.is_empty());
    assert!(Arc::ptr_eq(&m.document.mesh, &before));

    act(&mut m, EditAction::Repair);
    until(&mut m, "the repair", |m| m.jobs.is_empty());
    assert!(m.document.loops.is_empty());
    assert_eq!(m.document.accepted.len(), 3);
    let patches = &m.document.accepted[1..];
    let added = patches.iter().map(|one| one.faces.len()).sum::<usize>();
    let new = m.document.mesh.face_count() - m.document.first_patch_face;
    assert_eq!(added, new);
    repeats(&mut m, &output);
    let status = Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .args(["repair", "raw.ply", "-o", "by_command.ply"])
        .current_dir(folder.path())
        .status();
    assert!(status.expect("the program").success());
    let read = |path: &Path| std::fs::read(path).expect("made");
    assert!(read(&folder.path().join("by_command.ply")) == read(&output));
    act(&mut m, EditAction::Undo);
    assert_eq!(*m.document.mesh, *before);
}

/// The holes within the limits, filled in the window and by the option of the command.
#[test]
fn limits_choose_the_same_holes_without_a_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("scan.obj");
    let output = folder.path().join("done.obj");
    scan(&input);
    let mut m = opened(input);
    let mut lengths: Vec<f64> = m.document.loops.iter().map(|l| l.perimeter).collect();
    lengths.sort_by(f64::total_cmp);
    let limits = LoopLimits {
        max_perimeter: Some(0.5 * (lengths[1] + lengths[2])),
        ..LoopLimits::default()
    };
    let arguments = limits.to_arguments();
    act(&mut m, TaskAction::Limits(limits));
    // the defaults of the command
    act(&mut m, ControlsAction::Set(Box::default()));
    act(&mut m, RunAction::Start);
    until(&mut m, "the end", ended);
    act(&mut m, RunAction::Accept(0));
    assert_eq!(m.document.loops.len(), 1);
    repeats(&mut m, &output);
    let by_limit = folder.path().join("limited.obj");
    let status = Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .args(["fill", "scan.obj", "-o", "limited.obj"])
        .args(arguments)
        .current_dir(folder.path())
        .status();
    assert!(status.expect("the program").success());
    let read = |path| std::fs::read(path).expect("made");
    assert!(read(&by_limit) == read(&output));
}

#[test]
fn refinements_are_repeated_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let input = folder.path().join("coarse.obj");
    let output = folder.path().join("done.obj");
    let (positions, triangles) = meniscus::shapes::icosphere(1);
    io::save_mesh(
        &input,
        &Mesh::from_triangles(positions, &triangles).expect("a sphere"),
    )
    .expect("written");
    let mut m = opened(input);
    act(&mut m, TaskAction::Choose(Task::Refine));
    let mut refining = Refining::default();
    refining.controls.levels = 2;
    act(&mut m, TaskAction::Refining(Box::new(refining)));
    set_energy(&mut m, "H^2 + 0.1*K^2");
    act(&mut m, RunAction::Start);
    until(&mut m, "the end", ended);
    act(&mut m, RunAction::Accept(0));
    repeats(&mut m, &output);
}

/// Sharp edges by angle, by choice and around a selection, on the line and in a file.
#[test]
fn sharp_edges_are_repeated_too() {
    for (frequency, is_long) in [(2, false), (9, true)] {
        let folder = tempfile::tempdir().expect("a folder");
        let input = folder.path().join("coarse.obj");
        let output = folder.path().join("done.obj");
        let (positions, triangles) = meniscus::shapes::icosphere(frequency);
        io::save_mesh(
            &input,
            &Mesh::from_triangles(positions, &triangles).expect("a sphere"),
        )
        .expect("written");
        let mut m = opened(input);
        act(&mut m, TaskAction::Choose(Task::Repair));
        paint(&mut m, DVec3::Z, 0.6);
        act(&mut m, TaskAction::Choose(Task::Refine));
        let mut refining = Refining::default();
        (refining.controls.levels, refining.selection_rim) = (1, true);
        refining.controls.crease_angle = Some(41.8);
        act(&mut m, TaskAction::Refining(Box::new(refining)));
        act(&mut m, RunAction::Start);
        until(&mut m, "the end", ended);
        act(&mut m, RunAction::Accept(0));
        repeats(&mut m, &output);
        let list = output.with_extension("creases.txt");
        assert_eq!(list.exists(), is_long);
    }
}
