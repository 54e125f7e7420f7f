//! What actions do, without a window.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::action::{
    Action, ControlsAction, EditAction, FileAction, RunAction, SelectAction, SelectHow, Switch,
    TaskAction, ViewAction,
};
use super::autosave::{self, Autosave};
use super::document::{Document, Source};
use super::model::{Effect, Model};
use super::project;
use super::scene_builder;
use super::settings::Settings;
use super::ui::plots;
use super::update::{act, replace, tick};
use super::view_state::{
    AfterUnsaved, LoopColumn, LoopKind, LoopList, Modal, PathPrompt, PathUse, Task, Windows,
};
use crate::fill::{Features, LoopLimits, Surface};
use crate::io;
use crate::mesh::{DVec3, LoadReport, LoopId, Mesh, Soup, check_mesh, components};
use crate::ops::Operation;
use crate::render::{Vertex, ViewMode};
use crate::shapes::{Hole, HoleShape, TriangleMesh, cut_holes, icosphere, plane, sphere};
use crate::solver::{End, Mode};

mod pictures;
mod refine;
mod repair;

/// A sphere with two small holes.
pub(super) fn opened() -> io::Opened {
    let hole = |x: f64, seed| Hole {
        centre: DVec3::new(x, 0.2, 0.1),
        shape: HoleShape::Disc { radius: 0.4 },
        turn: 0.0,
        seed,
    };
    from_triangles(cut_holes(&sphere(600, 5), &[hole(1.0, 1), hole(-1.0, 2)]))
}

/// Triangles as if they were read from a file.
fn from_triangles((positions, triangles): TriangleMesh) -> io::Opened {
    let soup = Soup {
        positions,
        offsets: (0..=triangles.len() as u32).map(|i| 3 * i).collect(),
        corners: triangles.into_iter().flatten().collect(),
        ..Soup::default()
    };
    io::from_soup(&soup, Path::new("test")).expect("sound")
}

pub(super) fn model() -> Model {
    model_of(opened())
}

/// A model whose document is this mesh.
fn model_of(opened: io::Opened) -> Model {
    let document = Document::new(opened, Source::Sample("test".into()));
    let wake: crate::app::jobs::Wake = Arc::new(|| ());
    Model::new(document, Settings::default(), Autosave::off(), wake)
}

/// Lets the background work go on until `done`.
pub(super) fn until(model: &mut Model, mut done: impl FnMut(&Model) -> bool) {
    let begun = Instant::now();
    while !done(model) {
        tick(model, Instant::now());
        assert!(
            begun.elapsed() < Duration::from_mins(2),
            "nothing happens: {:?}",
            model.log.entries().last()
        );
        std::thread::sleep(Duration::from_millis(2));
    }
}

pub(super) fn filled(model: &mut Model) {
    act(model, RunAction::Pace(240.0));
    act(model, RunAction::Start);
    until(model, |m| {
        m.run.as_ref().is_some_and(super::run::Run::ended)
    });
}

fn loops<const N: usize>(indices: [usize; N]) -> BTreeSet<LoopId> {
    indices.map(LoopId::from).into()
}

pub(super) fn last_message(model: &Model) -> &str {
    model.log.entries().last().map_or("", |e| e.text.as_str())
}

#[test]
fn selection_by_click_keys_and_lists() {
    let mut m = model();
    assert_eq!(m.document.loops.len(), 2);
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    assert_eq!(m.document.selection, loops([1]));
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Add));
    assert_eq!(m.document.selection, loops([0, 1]));
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Toggle));
    assert_eq!(m.document.selection, loops([0]));
    act(&mut m, SelectAction::Loop(7.into(), SelectHow::Replace));
    assert_eq!(m.document.selection, loops([0]));
    act(&mut m, SelectAction::AllButLargest);
    assert_eq!(m.document.selection.len(), 1);
    act(&mut m, SelectAction::All);
    assert_eq!(m.document.selection.len(), 2);
    act(&mut m, Action::Escape);
    assert!(m.document.selection.is_empty());
    // each change was a separate entry
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.selection.len(), 2);
    act(&mut m, EditAction::Undo);
    assert_eq!(m.document.selection.len(), 1);
    act(&mut m, EditAction::Redo);
    assert_eq!(m.document.selection.len(), 2);
    assert!(!m.is_dirty() || m.document.accepted.is_empty());
}

/// Isophotes would show the noise of a scan; a generated sample is smooth. A chosen mode stays.
#[test]
fn files_open_shaded_samples_with_isophotes_and_a_chosen_mode_stays() {
    let mut m = model();
    assert_eq!(m.view.style.mode, ViewMode::Shaded);
    let open = |m: &mut Model, source: Source| replace(m, Document::new(opened(), source));
    let (sample, file) = (Source::Sample("a".into()), Source::File("a.obj".into()));
    open(&mut m, sample.clone());
    assert_eq!(m.view.style.mode, ViewMode::Isophotes);
    open(&mut m, file.clone());
    assert_eq!(m.view.style.mode, ViewMode::Shaded);
    act(&mut m, ViewAction::Mode(ViewMode::Mean));
    for source in [sample, file] {
        open(&mut m, source);
        assert_eq!(m.view.style.mode, ViewMode::Mean);
    }
    // a mode that needs data of one document is not kept for the next
    act(&mut m, ViewAction::Mode(ViewMode::Deviation));
    open(&mut m, Source::Sample("b".into()));
    assert_eq!(m.view.style.mode, ViewMode::Mean);
}

#[test]
fn escape_closes_the_report_before_it_clears_the_selection() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    act(&mut m, Action::Escape);
    assert!(!m.view.windows.analysis && m.document.selection.len() == 2);
    act(&mut m, Action::Escape);
    assert!(m.document.selection.is_empty());
}

#[test]
fn a_coloured_mesh_opens_in_its_colours_and_other_meshes_have_no_such_mode() {
    let mut m = model();
    let file = || Source::File("a.ply".into());
    act(&mut m, ViewAction::Mode(ViewMode::Color));
    assert_eq!(m.view.style.mode, ViewMode::Shaded, "there are no colours");
    let mut coloured = opened();
    let gray = vec![[0.5, 0.5, 0.5, 1.0]; coloured.mesh.vertex_count()];
    coloured.mesh.attributes.vertices = crate::mesh::color_columns(&gray);
    replace(&mut m, Document::new(coloured, file()));
    assert_eq!(m.view.style.mode, ViewMode::Color);
    until(&mut m, |m| m.displays[0].latest().is_some());
    let display = m.displays[0].latest().expect("drawn");
    let drawn = display.surfaces.iter().flat_map(|s| &s.vertices);
    assert!(drawn.clone().count() > 0 && drawn.clone().all(|v| v.color == [128, 128, 128, 255]));
    // the mode is not remembered for files without colours
    replace(&mut m, Document::new(opened(), file()));
    assert_eq!(m.view.style.mode, ViewMode::Shaded);
}

#[test]
fn texture_images_are_drawn_and_missing_ones_are_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect(name);
    write(
        "a.mtl",
        "newmtl skin\nmap_Kd skin.png\nnewmtl lost\nmap_Kd lost.jpg\n",
    );
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                usemtl skin\nf 1/1 2/2 3/3\nusemtl lost\nf 1/1 3/3 4/4\n";
    write("a.obj", text);
    let skin = image::RgbaImage::from_pixel(8, 8, image::Rgba([9, 99, 199, 255]));
    skin.save(folder.path().join("skin.png")).expect("saved");
    let mut m = model();
    let path = folder.path().join("a.obj");
    let opened = io::open_welded(&path, crate::mesh::Weld::default()).expect("sound");
    replace(&mut m, Document::new(opened, Source::File(path)));
    assert_eq!(m.view.style.mode, ViewMode::Shaded);
    until(&mut m, |m| m.view.style.mode == ViewMode::Color);
    let warnings = m
        .log
        .entries()
        .iter()
        .filter(|e| e.text.contains("lost.jpg"))
        .count();
    assert_eq!(warnings, 1);
    let images = |m: &Model| {
        let display = m.displays[0].latest()?;
        let runs = display.surfaces.iter().flat_map(|s| &s.textures);
        Some(
            runs.map(|(run, image)| (run.clone(), Arc::clone(image)))
                .collect::<Vec<_>>(),
        )
    };
    until(&mut m, |m| images(m).is_some_and(|all| !all.is_empty()));
    let all = images(&m).expect("drawn");
    assert_eq!(all.len(), 1);
    assert_eq!(all[0].1.pixels, skin);
    let surface = &m.displays[0].latest().expect("drawn").surfaces[0];
    assert_eq!(all[0].0.len(), surface.triangles.len() / 2);
    for t in &surface.triangles[all[0].0.start as usize..all[0].0.end as usize] {
        for v in t.map(|v| surface.vertices[v as usize]) {
            assert!(v.flags & Vertex::TEXTURED != 0);
            assert!((0.0..=1.0).contains(&v.uv[0]) && (0.0..=1.0).contains(&v.uv[1]));
        }
    }
}

/// The surfaces of a large mesh are made once, with its images.
#[test]
fn a_large_textured_mesh_is_first_drawn_with_its_images() {
    use std::fmt::Write as _;
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let skin = image::RgbaImage::from_pixel(8, 8, image::Rgba([9, 99, 199, 255]));
    skin.save(at("skin.png")).expect("saved");
    std::fs::write(at("a.mtl"), "newmtl skin\nmap_Kd skin.png\n").expect("written");
    let n = 160;
    let mut text = String::from("mtllib a.mtl\nusemtl skin\nvt 0 0\nvt 1 0\nvt 1 1\n");
    for k in 0..=n {
        for i in 0..=n {
            writeln!(text, "v {i} {k} 0").expect("text");
        }
    }
    for k in 0..n {
        for i in 1..=n {
            let v = k * (n + 1) + i;
            let (w, up, far) = (v + 1, v + n + 1, v + n + 2);
            let faces = writeln!(text, "f {v}/1 {w}/2 {far}/3\nf {v}/1 {far}/3 {up}/2");
            faces.expect("text");
        }
    }
    std::fs::write(at("a.obj"), text).expect("written");
    let mut m = model();
    let opened = io::open_welded(&at("a.obj"), crate::mesh::Weld::default()).expect("sound");
    replace(&mut m, Document::new(opened, Source::File(at("a.obj"))));
    until(&mut m, |m| m.displays[0].latest().is_some());
    let display = m.displays[0].latest().expect("drawn");
    let runs = display.surfaces.iter().flat_map(|s| &s.textures);
    assert_eq!(runs.map(|(run, _)| run.len()).sum::<usize>(), 2 * n * n);
}

/// The drawn vertices of patches.
fn drawn_patches(m: &Model) -> Vec<Vertex> {
    let display = m.displays[0].latest();
    let surfaces = display.iter().flat_map(|display| &display.surfaces);
    let vertices = surfaces.flat_map(|surface| surface.vertices.iter().copied());
    vertices.filter(|v| v.flags & Vertex::PATCH != 0).collect()
}

/// Starts a fill that is not yet near its end when its first state is drawn.
fn starts_slowly(m: &mut Model) {
    act(m, RunAction::Pace(0.5));
    act(m, RunAction::Start);
    until(m, |m| !drawn_patches(m).is_empty());
    assert!(!m.run.as_ref().expect("a run").ended());
}

#[test]
fn a_patch_has_colours_while_it_grows() {
    let mut m = model();
    act(&mut m, FileAction::Sample("ring".into()));
    until(&mut m, |m| m.view.style.mode == ViewMode::Color);
    starts_slowly(&mut m);
    let patches = drawn_patches(&m);
    assert!(patches.iter().all(|v| v.color[3] == u8::MAX));
    // in other views its colours are not computed
    act(&mut m, ViewAction::Mode(ViewMode::Shaded));
    until(&mut m, |m| {
        let patches = drawn_patches(m);
        patches.iter().any(|v| v.color[3] == 0)
    });
}

#[test]
fn faces_with_colours_are_drawn_in_them() {
    let mut m = model();
    let mut coloured = opened();
    let faces = coloured.mesh.face_count();
    let shades: Vec<[f32; 4]> = (0..faces)
        .map(|face| [face as f32 / faces as f32, 0.0, 1.0, 1.0])
        .collect();
    coloured.mesh.attributes.faces.columns = crate::mesh::color_columns(&shades);
    replace(
        &mut m,
        Document::new(coloured, Source::File("a.off".into())),
    );
    assert_eq!(m.view.style.mode, ViewMode::Color);
    until(&mut m, |m| m.displays[0].latest().is_some());
    let display = m.displays[0].latest().expect("drawn");
    let surface = &display.surfaces[0];
    assert!(surface.triangles.len() >= faces);
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|v| surface.vertices[v as usize].color);
        assert!(
            a == b && b == c && a[1..] == [0, 255, 255],
            "{a:?} {b:?} {c:?}"
        );
    }
    starts_slowly(&mut m);
    let patches = drawn_patches(&m);
    assert!(patches.iter().all(|v| v.color[1..] == [0, 255, 255]));
}

/// Patches across a seam are drawn with their image while they grow and when they are accepted, an undo takes
/// it back, and a project keeps it.
#[test]
fn images_of_patches_are_drawn_undone_and_kept_in_projects() {
    let mut m = model();
    act(&mut m, FileAction::Sample("egg".into()));
    until(&mut m, |m| m.view.style.mode == ViewMode::Color);
    let images = |m: &Model| {
        let display = m.displays[0].latest();
        let surfaces = display.iter().flat_map(|display| &display.surfaces);
        let ids: BTreeSet<u64> = surfaces
            .flat_map(|s| s.textures.iter().map(|(_, image)| image.id))
            .collect();
        ids.len()
    };
    until(&mut m, |m| images(m) == 1);
    starts_slowly(&mut m);
    // before, the patches are plain
    until(&mut m, |m| images(m) == 2);
    assert!(!m.run.as_ref().expect("a run").ended());
    let patches = drawn_patches(&m);
    assert!(patches.iter().all(|v| v.flags & Vertex::TEXTURED != 0));
    act(&mut m, RunAction::Reject);
    until(&mut m, |m| images(m) == 1);
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    until(&mut m, |m| m.run.is_none());
    assert_eq!(m.document.mesh.attributes.own_materials.len(), 2);
    until(&mut m, |m| images(m) == 2);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.meniscus");
    let text = project::write(&m.document, &m.view, folder.path());
    std::fs::write(&path, text).expect("written");
    let (document, _) = project::read(&path).expect("read");
    let (own, read) = (&m.document.mesh.attributes, &document.mesh.attributes);
    assert_eq!(own.own_materials, read.own_materials);
    assert_eq!(own.tags, read.tags);
    act(&mut m, EditAction::Undo);
    until(&mut m, |m| images(m) == 1);
    act(&mut m, EditAction::Redo);
    until(&mut m, |m| images(m) == 2);
}

/// The textures of accepted patches are made in the background. Until then the patch can be rejected, and what
/// follows the acceptance waits.
#[test]
fn textures_of_accepted_patches_are_made_in_the_background() {
    let mut m = model();
    act(&mut m, FileAction::Sample("egg".into()));
    until(&mut m, |m| !m.textures.is_empty());
    let before = Arc::clone(&m.document.mesh);
    let folder = tempfile::tempdir().expect("a folder");
    m.saved_to = Some(folder.path().join("out.ply"));

    filled(&mut m);
    act(&mut m, FileAction::Close);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, RunAction::Accept(0));
    let waits = |m: &Model| m.run.as_ref().is_some_and(|run| run.accepting.is_some());
    assert!(waits(&m) && Arc::ptr_eq(&m.document.mesh, &before));
    let making = |m: &Model| {
        m.jobs
            .iter()
            .filter(|j| j.what.contains("textures"))
            .count()
    };
    assert_eq!(making(&m), 1);
    act(&mut m, FileAction::SaveAndContinue);
    act(&mut m, RunAction::Reject);
    assert_eq!(making(&m), 0);
    until(&mut m, |m| m.jobs.is_empty());
    assert!(m.run.is_none() && Arc::ptr_eq(&m.document.mesh, &before));
    assert!(m.effects.is_empty() && !folder.path().join("out.ply").exists());
    m.view.modal = Modal::None;

    filled(&mut m);
    act(&mut m, FileAction::Close);
    act(&mut m, RunAction::Accept(0));
    let run = m.run.as_ref().expect("it waits");
    let state = run.sides[0].state().expect("a patch");
    act(&mut m, FileAction::SaveAndContinue);
    until(&mut m, |m| !m.effects.is_empty());
    assert!(matches!(m.effects.pop(), Some(Effect::Close)));
    assert!(m.run.is_none() && *m.document.mesh == state.mesh());
    let saved = io::open(&folder.path().join("out.ply")).expect("saved");
    assert_eq!(saved.mesh.positions, m.document.mesh.positions);
}

#[test]
fn projects_keep_everything_that_a_file_holds() {
    let m = model();
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let egg = project::sample_of("egg").expect("a sample").mesh;
    for name in ["a.glb", "a.3mf"] {
        io::save_mesh(&at(name), &egg).expect("written");
    }
    let columns = "comment TextureFile a.png\nelement vertex 4\nproperty double x\nproperty double y\n\
                   property double z\nproperty float confidence\nproperty short label\n\
                   element face 2\nproperty list uchar int vertex_indices\n\
                   property list uchar float texcoord\nproperty uchar side\nend_header\n";
    let rows = "0 0 0 .1 -1\n1 0 0 1e-40 2\n1 1 0 0 3\n0 1 0 9 4\n\
                3 0 1 2 6 0 0 1 0 1 1 7\n3 0 2 3 6 0 0 1 1 0 1 8\n";
    std::fs::write(
        at("a.ply"),
        format!("ply\nformat ascii 1.0\n{columns}{rows}"),
    )
    .expect("written");
    std::fs::write(
        at("a.off"),
        "COFF\n3 1 0\n0 0 0 9 8 7 1\n1 0 0 3 2 1 1\n0 1 0 5 5 5 1\n3 0 1 2\n",
    )
    .expect("written");
    io::save_mesh(&at("a.stl"), &egg).expect("written");
    for name in ["a.glb", "a.3mf", "a.ply", "a.off", "a.stl"] {
        let opened = io::open(&at(name)).expect("opened");
        // a mesh of no file is stored in the project
        let document = Document::new(opened, Source::Embedded);
        let path = at("a.meniscus");
        let text = project::write(&document, &m.view, folder.path());
        std::fs::write(&path, &text).expect("written");
        let (again, _) = project::read(&path).expect("read");
        let mut wanted = document.mesh.attributes.clone();
        wanted.folder = None;
        assert_eq!(again.mesh.attributes, wanted, "{name}");
        assert_eq!(again.mesh.positions, document.mesh.positions, "{name}");
        let images = |document: &Document| io::materials(&document.mesh.attributes);
        if name == "a.glb" || name == "a.3mf" {
            assert!(
                images(&again)
                    .iter()
                    .any(|material| material.image.is_some())
            );
            assert_eq!(images(&again), images(&document), "{name}");
        }
        // attributes of another mesh are refused
        if !document.mesh.attributes.faces.texture.is_empty() {
            let fewer = text.replacen("\nf ", "\n# f ", 1);
            std::fs::write(&path, fewer).expect("written");
            let Err(error) = project::read(&path) else {
                panic!("one face too few")
            };
            assert!(error.contains("do not fit its mesh"), "{name}: {error}");
        }
    }
}

/// A large mesh is looked at long before its surfaces are made.
#[test]
fn another_document_is_fitted_by_its_own_box() {
    let mut m = model();
    until(&mut m, |m| m.displays[0].latest().is_some());
    let mut large = opened();
    for p in &mut large.mesh.positions {
        *p = *p * 40.0 + DVec3::X;
    }
    replace(&mut m, Document::new(large, Source::Sample("large".into())));
    assert!(m.displays[0].latest().is_none());
    assert_eq!(m.bounds(), m.document.origin.bounds);
    assert!(m.bounds().radius() > 30.0);
    until(&mut m, |m| m.displays[0].latest().is_some());
    assert!(m.bounds().radius() > 30.0);
}

#[test]
fn fill_accept_undo_redo() {
    let mut m = model();
    let before = Arc::clone(&m.document.mesh);
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    assert!(Arc::ptr_eq(&before, &m.document.mesh), "not before accept");
    let run = m.run.as_ref().expect("it waits");
    assert!(
        run.state_count() >= 30,
        "{} states to watch",
        run.state_count()
    );
    act(&mut m, RunAction::Accept(0));
    assert!(m.run.is_none() && m.is_dirty());
    let after = Arc::clone(&m.document.mesh);
    assert_eq!(m.document.loops.len(), 1);
    check_mesh(&after).expect("sound");
    assert_eq!(after.positions[..before.vertex_count()], before.positions);
    let fill = &m.document.accepted[0];
    assert_eq!(fill.faces, before.face_count()..after.face_count());
    let patches = m.document.patches().expect("one");
    assert_eq!(patches.face_count(), fill.faces.len());
    act(&mut m, EditAction::Undo);
    assert!(Arc::ptr_eq(&before, &m.document.mesh));
    act(&mut m, EditAction::Redo);
    assert!(Arc::ptr_eq(&after, &m.document.mesh));
}

#[test]
fn holes_beyond_the_limits_are_selected_by_click_only() {
    let mut m = model();
    let [a, b] = [0, 1].map(|i| m.document.loops[i].perimeter);
    let small = usize::from(b < a);
    let limits = LoopLimits {
        max_perimeter: Some(0.5 * (a + b)),
        ..LoopLimits::default()
    };
    act(&mut m, TaskAction::Limits(limits));
    act(&mut m, SelectAction::All);
    assert_eq!(m.document.selection, loops([small]));
    act(
        &mut m,
        SelectAction::Loop((1 - small).into(), SelectHow::Add),
    );
    assert_eq!(m.document.selection.len(), 2);
    act(&mut m, SelectAction::None);
    let none = LoopLimits {
        max_diameter: Some(0.0),
        ..LoopLimits::default()
    };
    act(&mut m, TaskAction::Limits(none));
    act(&mut m, RunAction::Start);
    assert!(m.run.is_none() && last_message(&m).contains("exceed the limits"));
}

#[test]
fn undo_in_the_middle_of_a_run_and_redo_brings_it_back() {
    let mut m = model();
    let before = Arc::clone(&m.document.mesh);
    act(&mut m, SelectAction::All);
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > 2)
    });
    act(&mut m, EditAction::Undo);
    assert!(m.run.is_none() && Arc::ptr_eq(&before, &m.document.mesh));
    act(&mut m, EditAction::Redo);
    assert_eq!(m.document.loops.len(), 0);
    assert!(m.document.mesh.face_count() > before.face_count());
}

#[test]
fn pause_step_scrub_and_replay() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > 4)
    });
    act(&mut m, RunAction::PlayPause);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| !r.sides[0].handle.playing())
    });
    let settle = |m: &mut Model| {
        let mut last = 0;
        loop {
            for _ in 0..250 {
                tick(m, Instant::now());
                std::thread::sleep(Duration::from_millis(2));
            }
            let now = m.run.as_ref().map_or(0, super::run::Run::state_count);
            if now == last {
                return now;
            }
            last = now;
        }
    };
    let paused = settle(&mut m);
    act(&mut m, RunAction::Step);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > paused)
    });
    assert_eq!(settle(&mut m), paused + 1, "one step, then it waits");
    act(&mut m, RunAction::Scrub(Some(1)));
    let run = m.run.as_ref().expect("still there");
    let figures = run.sides[0].figures();
    assert!(run.scrubbed() && figures[0].step == Some(1));
    // play: the kept states first, then the flow itself
    act(&mut m, RunAction::Pace(240.0));
    act(&mut m, RunAction::PlayPause);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(super::run::Run::ended)
    });
    let run = m.run.as_ref().expect("still there");
    assert!(!run.scrubbed());
    let last = run.sides[0].figures();
    assert!(matches!(last[0].end, Some(Ok(_))));
    // an earlier state has its own figures and no end
    act(&mut m, RunAction::Scrub(Some(2)));
    let side = |m: &Model| {
        m.run.as_ref().expect("still there").sides[0]
            .figures()
            .remove(0)
    };
    let earlier = side(&m);
    assert!(earlier.end.is_none() && earlier.step == Some(2));
    assert!(earlier.residual > last[0].residual && earlier.relative_tau != last[0].relative_tau);
    // play after the end: the stored states, from the shown one or from the first
    for from_end in [false, true] {
        if from_end {
            assert!(!m.run.as_ref().expect("still there").scrubbed());
        }
        act(&mut m, RunAction::PlayPause);
        let mut steps = Vec::new();
        until(&mut m, |m| {
            steps.extend(side(m).step);
            m.run.as_ref().is_some_and(|run| !run.playing)
        });
        steps.dedup();
        let first = if from_end { 0 } else { 2 };
        let all: Vec<usize> = (first..=last[0].step.expect("a step")).collect();
        assert!(
            steps.len() > 2 && all.ends_with(&steps[1..]),
            "{steps:?} of {all:?}"
        );
    }
    // a scrubbed state is what accept takes
    act(&mut m, RunAction::Scrub(Some(2)));
    let positions = m
        .run
        .as_ref()
        .and_then(|r| r.sides[0].state())
        .expect("a state")
        .positions(false);
    act(&mut m, RunAction::Accept(0));
    assert_eq!(m.document.mesh.positions, positions);
}

#[test]
fn controls_act_during_a_run_and_errors_are_reported() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > 3)
    });
    act(&mut m, ControlsAction::EnergyText("H^2 + )".into()));
    act(&mut m, ControlsAction::ApplyEnergy);
    assert!(
        last_message(&m).contains("character 7"),
        "{}",
        last_message(&m)
    );
    assert_eq!(m.document.controls.energy, "H^2");
    act(&mut m, ControlsAction::EnergyText("(H-H0)^2".into()));
    act(&mut m, ControlsAction::ApplyEnergy);
    assert_eq!(m.document.controls.param.get("H0"), Some(&0.0));
    let mut controls = m.document.controls.clone();
    controls.param.insert("H0".into(), -1.0);
    controls.mode = Mode::Fast;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(super::run::Run::ended)
    });
    let side = &m.run.as_ref().expect("there").sides[0];
    let rows = side.state().expect("a state").schedule().entries;
    let named = |name: &str| rows.iter().any(|r| r.control == name);
    assert!(
        named("energy") && named("param") && named("mode"),
        "{rows:?}"
    );
    // the sphere of radius 1 is where (H + 1)^2 vanishes
    act(&mut m, RunAction::Accept(0));
    let worst = m
        .document
        .mesh
        .positions
        .iter()
        .map(|p| (p.length() - 1.0).abs());
    assert!(worst.fold(0.0, f64::max) < 0.02);
}

#[test]
fn two_energies_are_compared_and_one_is_taken() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, ControlsAction::CompareEnergy(Some("1".into())));
    filled(&mut m);
    let run = m.run.as_ref().expect("there");
    assert_eq!(run.sides.len(), 2);
    let [a, b] = [0, 1].map(|i| run.sides[i].state().expect("a state").positions(false));
    let difference = a
        .iter()
        .zip(&b)
        .map(|(p, q)| p.distance(*q))
        .fold(0.0, f64::max);
    assert!(
        difference > 1e-3,
        "the area's surface is flatter: {difference}"
    );
    let told = last_message(&m);
    assert!(told.starts_with("A: 1 hole filled: ") && told.contains("; B: 1 hole filled: "));
    assert_eq!(run.title(0), "A: surface model auto");
    assert_eq!(run.title(1), "B: Area, 1");
    // the energies have other units: each curve begins at 1
    let curves = plots::curves(run, true);
    let names: Vec<(&str, usize)> = curves.iter().map(|c| (c.name.as_str(), c.color)).collect();
    assert_eq!(names, [("A", 0), ("B", 1)]);
    for curve in &curves {
        let first = curve.points[0];
        assert_eq!(first[1], 1.0);
        assert_eq!(curve.nearest(first[0] + 0.2), Some(first));
        assert_eq!(curve.nearest(1e9), curve.points.last().copied());
    }
    act(&mut m, RunAction::Accept(1));
    let mesh = &m.document.mesh;
    assert_eq!(mesh.positions[mesh.vertex_count() - b.len()..], b);
    assert_eq!(m.document.controls.energy, "1");
    assert_eq!(m.document.controls.surface, Surface::Energy);
    assert_eq!(m.view.energy_text, "1", "the text field shows it");
    act(&mut m, EditAction::Undo);
    assert_eq!(m.view.energy_text, "H^2");
}

/// The curves of one side have one colour, and so one entry of the legend; those of a single side one each.
#[test]
fn the_legend_of_a_comparison_names_both_sides() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    let shown = |m: &Model| {
        let run = m.run.as_ref().expect("a run");
        let curves = plots::curves(run, true);
        let entries = plots::entries(run, &curves).into_iter();
        let entries: Vec<(String, usize)> = entries.map(|e| (e.0, e.1)).collect();
        (curves.len(), entries)
    };
    filled(&mut m);
    assert_eq!(shown(&m), (2, vec![("1".into(), 0), ("2".into(), 1)]));
    act(&mut m, RunAction::Reject);
    act(&mut m, ControlsAction::CompareEnergy(Some("1".into())));
    filled(&mut m);
    assert_eq!(shown(&m), (4, vec![("A".into(), 0), ("B".into(), 1)]));
}

#[test]
fn compared_energies_keep_their_own_parameters_when_a_control_is_changed() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(
        &mut m,
        ControlsAction::CompareEnergy(Some("(H-H0)^2".into())),
    );
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        let sides = m.run.as_ref().map(|run| &run.sides);
        sides.is_some_and(|sides| sides.iter().all(|side| side.state_count() > 2))
    });
    let mut controls = m.document.controls.clone();
    controls.relaxation = 0.5;
    controls.energy = "K^2".into();
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    let run = m.run.as_ref().expect("it runs");
    for side in &run.sides {
        assert_eq!(side.controls.relaxation, 0.5, "{}", last_message(&m));
    }
    assert_eq!(run.sides[0].controls.energy, "K^2");
    assert_eq!(run.sides[1].controls.energy, "(H-H0)^2");
    assert_eq!(run.sides[1].controls.param.get("H0"), Some(&0.0));
    assert_eq!(run.sides[1].controls.surface, Surface::Energy);
    // the plots have a mark for each side
    let marks = plots::changes(run);
    let words: Vec<&str> = marks.iter().map(|(_, what)| what.as_str()).collect();
    assert_eq!(words, ["energy K^2, relaxation 0.5", "relaxation 0.5"]);
    assert!(
        marks.iter().all(|(attempt, _)| *attempt >= 1.0),
        "{marks:?}"
    );
    assert_eq!(m.document.controls.relaxation, 0.5);
    // a parameter of B changes B alone, also while it runs
    let before = m.run.as_ref().map(|run| run.sides[0].controls.clone());
    act(&mut m, ControlsAction::CompareParameter("H0".into(), -1.0));
    let run = m.run.as_ref().expect("it runs");
    assert_eq!(run.sides[1].controls.param.get("H0"), Some(&-1.0));
    assert_eq!(Some(&run.sides[0].controls), before.as_ref());
    assert!(!m.document.controls.param.contains_key("H0"));
}

/// Points of all groups are at the attempts they share, also of groups that have ended before others.
#[test]
fn curves_continue_at_the_change_of_a_control() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    filled(&mut m);
    let lengths = |m: &Model| -> Vec<usize> {
        let side = &m.run.as_ref().expect("there").sides[0];
        side.curves.iter().map(|curve| curve.energy.len()).collect()
    };
    let before = lengths(&m);
    assert!(
        before[0] != before[1],
        "one group ends before the other: {before:?}"
    );
    let mut controls = m.document.controls.clone();
    controls.tension = 0.5;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    until(&mut m, |m| {
        lengths(m).iter().zip(&before).all(|(now, then)| now > then)
    });
    let run = m.run.as_ref().expect("there");
    let marks = plots::changes(run);
    assert_eq!(marks.len(), 1, "{marks:?}");
    for (curve, then) in run.sides[0].curves.iter().zip(before) {
        let points = &curve.energy;
        assert!(points[then - 1][0] <= marks[0].0 && points[then][0] > marks[0].0);
    }
}

#[test]
fn an_undo_of_all_changes_leaves_nothing_to_save() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    assert!(m.is_dirty() && m.title().contains('*'));
    act(&mut m, EditAction::Undo);
    assert!(!m.is_dirty() && !m.title().contains('*'));
    act(&mut m, EditAction::Redo);
    assert!(m.is_dirty());
}

#[test]
fn saved_files_get_an_extension_and_enter_the_title_and_the_recent_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    for (typed, written) in [
        ("out", "out.obj"),
        ("scan.v2", "scan.v2.obj"),
        ("b.ply", "b.ply"),
        ("c.meniscus", "c.meniscus"),
    ] {
        let (typed, written) = (folder.path().join(typed), folder.path().join(written));
        act(&mut m, FileAction::UsePath(PathUse::SaveAs, typed));
        until(&mut m, |m| m.saved_to.as_ref() == Some(&written));
        assert!(written.exists());
        let name = written
            .file_name()
            .and_then(|n| n.to_str())
            .expect("a name");
        assert_eq!(m.title(), format!("{name} - Meniscus"));
        assert_eq!(m.settings.recent[0], written);
    }
}

/// A file is replaced only after a question, also one with the extension that the typed name lacks.
#[test]
fn a_typed_path_replaces_a_file_only_after_a_question() {
    let folder = tempfile::tempdir().expect("a folder");
    let (typed, path) = (folder.path().join("out"), folder.path().join("out.obj"));
    std::fs::write(&path, "mine").expect("written");
    let is_kept = || std::fs::read(&path).expect("there") == b"mine";
    let mut m = model();
    let prompt = Modal::Path(PathPrompt {
        purpose: PathUse::SaveAs,
        text: "out".into(),
    });
    act(&mut m, Action::Modal(prompt.clone()));
    act(&mut m, FileAction::UsePath(PathUse::SaveAs, typed.clone()));
    assert!(matches!(m.view.modal, Modal::Replace(_)));
    act(&mut m, Action::Escape);
    assert_eq!(m.view.modal, prompt, "another name can be typed");
    // after the dialog of the system there is no other place for a name: nothing follows a later save
    act(&mut m, Action::Modal(Modal::None));
    m.after_save = Some(AfterUnsaved::Close);
    act(&mut m, FileAction::UsePath(PathUse::SaveAs, typed.clone()));
    act(&mut m, Action::Escape);
    assert!(m.after_save.is_none() && m.view.modal == Modal::None);
    act(&mut m, FileAction::UsePath(PathUse::SaveAs, typed));
    let Modal::Replace(asked) = m.view.modal.clone() else {
        panic!("no question");
    };
    assert_eq!(asked.path, path);
    assert!(is_kept() && m.saved_to.is_none());
    act(&mut m, asked.writing);
    until(&mut m, |m| m.saved_to.as_ref() == Some(&path));
    assert!(!is_kept() && m.view.modal == Modal::None);
    // its own file is saved without a question
    std::fs::write(&path, "mine").expect("written");
    act(&mut m, FileAction::Save);
    assert_eq!(m.view.modal, Modal::None);
    until(&mut m, |_| !is_kept());
}

/// A typed path stays in its dialog until its file is read or written.
#[test]
fn a_path_that_fails_is_asked_for_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let missing = folder.path().join("none");
    let mut m = model();
    for (purpose, name) in [(PathUse::SaveAs, "out.ply"), (PathUse::Open, "in.ply")] {
        let path = missing.join(name);
        let text = path.display().to_string();
        act(&mut m, FileAction::UsePath(purpose, path));
        let prompt = Modal::Path(PathPrompt { purpose, text });
        until(&mut m, |m| m.view.modal == prompt);
        act(&mut m, Action::Modal(Modal::None));
    }
    let path = folder.path().join("out.ply");
    act(&mut m, FileAction::UsePath(PathUse::SaveAs, path.clone()));
    until(&mut m, |m| m.saved_to.as_ref() == Some(&path));
    assert_eq!((&m.view.modal, &m.typed_path), (&Modal::None, &None));
    // a reference is not what a later save asks for
    act(&mut m, FileAction::UsePath(PathUse::Reference, path));
    assert_eq!(m.typed_path, None);
}

#[test]
fn unsaved_work_is_asked_about_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("other.obj");
    io::save_mesh(&path, &opened().mesh).expect("written");
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, FileAction::AskOpen);
    assert_eq!(m.view.modal, Modal::Unsaved(AfterUnsaved::AskOpen));
    act(&mut m, FileAction::DiscardAndContinue);
    // the path that is chosen after the answer
    act(&mut m, FileAction::UsePath(PathUse::Open, path.clone()));
    assert!(!matches!(m.view.modal, Modal::Unsaved(_)));
    until(&mut m, |m| {
        m.document.origin.source == Source::File(path.clone())
    });
}

#[test]
fn escape_closes_the_windows_over_the_view_one_by_one() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    let windows = [
        Switch::Report,
        Switch::Log,
        Switch::Settings,
        Switch::Diagnostics,
        Switch::Help,
    ];
    for switch in windows {
        act(&mut m, ViewAction::Toggle(switch));
    }
    for _ in windows {
        assert_ne!(m.view.windows, Windows::default());
        act(&mut m, Action::Escape);
    }
    assert_eq!(m.view.windows, Windows::default());
    assert_eq!(m.document.selection.len(), 2, "not before the windows");
    act(&mut m, Action::Escape);
    assert!(m.document.selection.is_empty());
}

#[test]
fn panels_are_opened_and_closed_and_the_report_opens_its_panel() {
    let mut m = model();
    act(&mut m, ViewAction::Toggle(Switch::LeftPanel));
    act(&mut m, ViewAction::Toggle(Switch::RightPanel));
    assert!(!m.settings.layout.left && !m.settings.layout.right);
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    assert!(m.settings.layout.right && m.view.windows.analysis);
    act(&mut m, ViewAction::Toggle(Switch::Analysis));
    assert!(m.settings.layout.right && !m.view.windows.analysis);
    for (height, open) in [(600.0, false), (1000.0, true)] {
        m.view.window[1] = height;
        m.settings.layout.details = None;
        assert_eq!(m.settings.layout.shows_details(height), open);
        act(&mut m, ViewAction::Toggle(Switch::Details));
        assert_eq!(m.settings.layout.shows_details(height), !open);
    }
}

/// A run that is paused because its energy, the negative of the Willmore energy, has no minimum.
fn without_bound() -> Model {
    let mut m = model();
    act(&mut m, ControlsAction::EnergyText("0-H^2".into()));
    act(&mut m, ControlsAction::ApplyEnergy);
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, RunAction::Pace(240.0));
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        let run = m.run.as_ref().expect("it runs");
        assert!(!run.ended(), "it ended instead");
        run.diverged()
    });
    m
}

/// The message about it goes, and the next such state pauses the flow again.
#[test]
fn a_flow_without_bound_that_is_continued_is_paused_again() {
    let mut m = without_bound();
    let diverged = |m: &Model| m.run.as_ref().is_some_and(super::run::Run::diverged);
    act(&mut m, RunAction::PlayPause);
    assert!(!diverged(&m));
    until(&mut m, diverged);
    let run = m.run.as_ref().expect("it waits");
    assert!(!run.playing && run.scrubbed());
    let shown = run.sides[0].state().expect("a state").positions(false);
    assert!(shown.iter().all(|p| p.length() < 1.5));
}

#[test]
fn a_flow_without_bound_is_paused_at_a_sensible_shape() {
    let mut m = without_bound();
    let run = m.run.as_ref().expect("it waits");
    assert!(!run.playing && run.scrubbed());
    let state = run.sides[0].state().expect("a state");
    for p in state.positions(false) {
        assert!(p.length() < 1.5, "{p} is far from the sphere");
    }
    // another energy goes on from there, and the plots mark it
    let attempt = state.attempt() as f64;
    act(&mut m, ControlsAction::EnergyText("H^2".into()));
    act(&mut m, ControlsAction::ApplyEnergy);
    act(&mut m, RunAction::ContinueFromShown);
    let marks = plots::changes(m.run.as_ref().expect("it runs"));
    assert!(marks.iter().any(|mark| mark.0 == attempt), "{marks:?}");
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(super::run::Run::ended)
    });
    let run = m.run.as_ref().expect("it waits");
    assert!(!run.diverged());
    let rows = run.sides[0].figures();
    assert!(matches!(rows[0].end, Some(Ok(End::Converged))), "{rows:?}");
    let warnings: Vec<&str> = run.sides[0].shown_warnings().collect();
    assert!(warnings.is_empty(), "of the former energy: {warnings:?}");
}

/// Esc does not wait for the step that is being computed.
#[test]
fn a_stopped_run_has_ended_at_once() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    act(&mut m, RunAction::Start);
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(|r| r.state_count() > 2)
    });
    act(&mut m, RunAction::Scrub(Some(1)));
    act(&mut m, Action::Escape);
    let run = m.run.as_ref().expect("it waits");
    assert!(run.ended() && !run.playing);
    assert_eq!(run.sides[0].shown, Some(1), "the shown state stays");
    act(&mut m, Action::Escape);
    assert!(m.run.is_none());
}

/// What is known about a state does not hold for earlier ones, nor after the flow went on from one.
#[test]
fn escape_before_the_first_state_leaves_nothing_to_decide() {
    let hole = Hole {
        centre: DVec3::X,
        shape: HoleShape::Disc { radius: 0.9 },
        turn: 0.0,
        seed: 1,
    };
    let (positions, triangles) = cut_holes(&sphere(20_000, 5), &[hole]);
    let opened = io::Opened {
        mesh: Mesh::from_triangles(positions, &triangles).expect("manifold"),
        report: LoadReport::default(),
    };
    let document = Document::new(opened, Source::Sample("test".into()));
    let settings = Settings::default();
    let mut m = Model::new(document, settings, Autosave::off(), Arc::new(|| ()));
    act(&mut m, RunAction::Start);
    assert!(m.run.is_some());
    act(&mut m, Action::Escape);
    assert!(m.run.is_none(), "the first patch takes long");
}

#[test]
fn warnings_are_those_of_the_shown_state() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    let mut controls = m.document.controls.clone();
    controls.steps = 5;
    act(&mut m, ControlsAction::Set(Box::new(controls.clone())));
    filled(&mut m);
    let warnings = |m: &Model| {
        let side = &m.run.as_ref().expect("it waits").sides[0];
        side.shown_warnings().map(str::to_owned).collect::<Vec<_>>()
    };
    let is_limit = |text: &String| text.contains("maximum number of steps");
    assert!(warnings(&m).iter().any(is_limit), "{:?}", warnings(&m));
    act(&mut m, RunAction::Scrub(Some(1)));
    assert!(!warnings(&m).iter().any(is_limit), "{:?}", warnings(&m));
    act(&mut m, RunAction::Scrub(None));
    assert!(warnings(&m).iter().any(is_limit));
    // the cause goes
    controls.steps = 200;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    assert!(!warnings(&m).iter().any(is_limit));
    until(&mut m, |m| {
        m.run.as_ref().is_some_and(super::run::Run::ended)
    });
    assert!(!warnings(&m).iter().any(is_limit), "{:?}", warnings(&m));
}

/// A roof with a hole across its ridge.
fn roof(island: bool) -> io::Opened {
    const N: u32 = 24;
    let place = |i: u32| 2.0 * f64::from(i) / f64::from(N) - 1.0;
    let at = |i: u32, j: u32| DVec3::new(place(i), place(j), -1.2 * place(i).abs());
    let number = |i: u32, j: u32| i * (N + 1) + j;
    let grid = |n: u32| (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
    let positions: Vec<DVec3> = grid(N + 1).map(|(i, j)| at(i, j)).collect();
    let corners = grid(N).flat_map(|(i, j)| {
        let [a, b, c, d] =
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| number(i, j));
        [[a, b, c], [a, c, d]]
    });
    let far = |&v: &u32| positions[v as usize].length() > 0.4;
    let near = |&v: &u32| positions[v as usize].length() < 0.2;
    let is_kept = |t: &[u32; 3]| t.iter().any(far) || island && t.iter().all(near);
    let triangles = corners.filter(is_kept).collect();
    from_triangles((positions.clone(), triangles))
}

#[test]
fn a_crease_through_a_hole_is_shown_and_the_hole_counts_once() {
    let mut m = model_of(roof(false));
    let hole = *m.document.holes().first().expect("a hole");
    // lines along the ridge through the hole
    let creases = |m: &Model| {
        let scene = scene_builder::scene(m, 0);
        let lines = scene
            .overlays
            .iter()
            .flat_map(|overlay| overlay.lines.clone());
        let ridge = |p: &[f32; 3]| p[0].abs() < 1e-5;
        let lines = lines.filter(|line| !line.closed && line.points.iter().all(ridge));
        lines.filter(|line| line.points.len() > 2).count()
    };
    assert_eq!(creases(&m), 0);
    act(&mut m, ViewAction::Hover(vec![hole]));
    assert_eq!(creases(&m), 1);
    act(&mut m, ViewAction::Hover(Vec::new()));
    act(&mut m, SelectAction::Loop(hole, SelectHow::Replace));
    assert_eq!(creases(&m), 1);
    let mut controls = m.document.controls.clone();
    controls.features = Features::Off;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    assert_eq!(creases(&m), 0);
    let mut controls = m.document.controls.clone();
    controls.features = Features::Auto;
    act(&mut m, ControlsAction::Set(Box::new(controls)));
    filled(&mut m);
    assert_eq!(creases(&m), 1);
    let told = m.log.entries().iter();
    assert!(
        told.clone().any(|e| e.text == "1 hole filled: 1 converged"),
        "{}",
        last_message(&m)
    );
}

/// The patch of a hole joins the islands in it, or passes them by, and has a crease only in that case.
#[test]
fn islands_are_joined_unless_switched_off() {
    let mut m = model_of(roof(true));
    let loops = &m.document.loops;
    let holes = loops.iter().filter(|l| !l.is_outer_boundary);
    let hole = holes.max_by_key(|l| l.edges()).expect("a hole").id;
    let has_crease = |m: &Model| {
        let scene = scene_builder::scene(m, 0);
        let lines = scene.overlays.iter().flat_map(|overlay| &overlay.lines);
        lines.filter(|line| !line.closed).count() > 0
    };
    for joins in [true, false] {
        act(&mut m, TaskAction::Islands(joins));
        act(&mut m, SelectAction::Loop(hole, SelectHow::Replace));
        assert_eq!(has_crease(&m), !joins);
        let before = m.document.loops.len();
        filled(&mut m);
        assert_eq!(has_crease(&m), !joins);
        act(&mut m, RunAction::Accept(0));
        let gone = before - m.document.loops.len();
        assert_eq!(gone, if joins { 2 } else { 1 });
        let operation = &m.document.accepted.last().expect("done").operation;
        assert!(matches!(operation, Operation::Fill(spec) if spec.islands == joins));
        act(&mut m, EditAction::Undo);
    }
}

#[test]
fn a_fill_is_summarised_in_one_line() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    filled(&mut m);
    let told = |m: &Model| {
        let entries = m.log.entries().iter();
        let lines = entries.filter(|e| e.text == "2 holes filled: 2 converged");
        lines.count()
    };
    assert_eq!(told(&m), 1, "{}", last_message(&m));
    act(&mut m, RunAction::PlayPause);
    for _ in 0..5 {
        tick(&mut m, Instant::now());
    }
    assert_eq!(told(&m), 1, "a replay is no fill");
}

/// A hole whose flow has ended before those of others keeps its end in states in which only these go on.
#[test]
fn a_hole_at_its_last_state_says_how_it_ended() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    filled(&mut m);
    let last = m.run.as_ref().expect("a run").state_count() - 1;
    act(&mut m, RunAction::Scrub(Some(last - 1)));
    let rows = m.run.as_ref().expect("a run").sides[0].figures();
    let (ended, others): (Vec<_>, Vec<_>) = rows.iter().partition(|row| row.end.is_some());
    assert_eq!((ended.len(), others.len()), (1, 1), "{rows:?}");
    assert!(matches!(ended[0].end, Some(Ok(End::Converged))));
    assert_eq!(others[0].doing, "earlier state");
}

#[test]
fn a_pause_has_no_estimate_of_the_time_left() {
    let mut m = model();
    act(&mut m, SelectAction::All);
    act(&mut m, RunAction::Pace(30.0));
    act(&mut m, RunAction::Start);
    let progress = |m: &Model| m.run.as_ref().and_then(super::run::Run::progress);
    until(&mut m, |m| {
        progress(m).is_some_and(|words| words.contains("about"))
    });
    act(&mut m, RunAction::PlayPause);
    let words = progress(&m).expect("not done");
    assert!(!words.contains("about"), "{words}");
    let rows = m.run.as_ref().expect("a run").sides[0].figures();
    assert!(rows.iter().any(|row| row.doing == "paused"), "{rows:?}");
}

/// A needle through the hole meets every patch.
#[test]
fn a_patch_with_defects_does_not_count_as_success() {
    let (mut positions, mut triangles) = cut_holes(
        &plane(4.0, 24, 1),
        &[Hole {
            centre: DVec3::ZERO,
            shape: HoleShape::Disc { radius: 0.6 },
            turn: 0.0,
            seed: 1,
        }],
    );
    let first = positions.len() as u32;
    let (needle, faces) = icosphere(3);
    positions.extend(
        needle
            .iter()
            .map(|p| DVec3::new(0.1 * p.x, 0.1 * p.y, 20.0 * p.z)),
    );
    triangles.extend(faces.iter().map(|t| t.map(|v| v + first)));
    let mut m = model_of(from_triangles((positions, triangles)));
    let hole = *m.document.holes().first().expect("a hole");
    act(&mut m, SelectAction::Loop(hole, SelectHow::Replace));
    filled(&mut m);
    let run = m.run.as_ref().expect("a run");
    let figures = run.sides[0].handle.figures(None);
    assert_eq!(figures[0].unsound, [hole]);
    assert!(figures[0].needs_attention());
    let mut entries = m.log.entries().iter();
    assert!(entries.any(|e| e.text.ends_with("; 1 patch has defects, see its warning")));
}

/// Esc rejects a run that has ended; Undo brings it back, unless something else was done since.
#[test]
fn a_rejection_is_undone() {
    let mut m = model();
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    let states = m.run.as_ref().map(crate::app::Run::state_count);
    act(&mut m, Action::Escape);
    assert!(m.run.is_none());
    assert_eq!(m.next_undo(), Some("reject the patch"));
    act(&mut m, EditAction::Undo);
    assert_eq!(m.run.as_ref().map(crate::app::Run::state_count), states);
    act(&mut m, RunAction::Reject);
    act(&mut m, SelectAction::None);
    assert_ne!(m.next_undo(), Some("reject the patch"));
    act(&mut m, EditAction::Undo);
    assert!(m.run.is_none());
    // the selection is that of the run again
    act(&mut m, EditAction::Undo);
    act(&mut m, RunAction::Accept(0));
    assert_eq!(m.document.loops.len(), 1);
}

#[test]
fn an_invalid_typed_energy_is_not_ignored() {
    let mut m = model();
    act(&mut m, ControlsAction::EnergyText("H^2+sqt(K)".into()));
    act(&mut m, RunAction::Start);
    assert!(m.run.is_none());
    let told = last_message(&m);
    assert!(told.starts_with("energy: at character") && told.contains("choose a preset"));
    assert_eq!(told.matches("energy").count(), 1, "{told}");
    act(&mut m, ControlsAction::EnergyText("H^2+K^2".into()));
    act(&mut m, ControlsAction::ApplyEnergy);
    filled(&mut m);
}

#[test]
fn loops_are_listed_in_order_and_selected_by_range_and_likeness() {
    let mut m = model();
    let widths = |list: &LoopList, m: &Model| {
        let listed = list.listed(&m.document.loops);
        listed.iter().map(|l| l.diameter).collect::<Vec<_>>()
    };
    let mut list = LoopList {
        sort: LoopColumn::Width,
        descending: true,
        ..LoopList::default()
    };
    assert!(widths(&list, &m).is_sorted_by(|a, b| a >= b));
    list.descending = false;
    assert!(widths(&list, &m).is_sorted());
    list.least_edges = usize::MAX;
    assert!(widths(&list, &m).is_empty());
    list.least_edges = 0;
    list.kind = LoopKind::Outer;
    assert!(
        list.listed(&m.document.loops)
            .iter()
            .all(|l| l.is_outer_boundary)
    );
    let both = vec![0.into(), 1.into(), 9.into()];
    act(&mut m, SelectAction::Several(both));
    assert_eq!(m.document.selection, loops([0, 1]));
    act(&mut m, SelectAction::None);
    // both holes have the same size
    act(&mut m, SelectAction::Similar(1.into()));
    assert_eq!(m.document.selection, loops([0, 1]));
}

#[test]
fn what_a_format_cannot_keep_is_logged() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    act(&mut m, FileAction::SaveAs(folder.path().join("out.stl")));
    until(&mut m, |m| last_message(m).contains("rounded"));
}

#[test]
fn files_are_saved_reopened_and_never_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    let source = folder.path().join("in.obj");
    io::save_mesh(&source, &opened().mesh).expect("written");
    let bytes = std::fs::read(&source).expect("there");
    let mut m = model();
    act(&mut m, FileAction::Open(source.clone()));
    until(&mut m, |m| {
        m.document.origin.source == Source::File(source.clone())
    });
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, FileAction::SaveAs(source.clone()));
    assert!(
        last_message(&m).contains("never overwritten"),
        "{}",
        last_message(&m)
    );
    assert_eq!(std::fs::read(&source).expect("there"), bytes);

    // a project brings everything back
    let project_path = folder.path().join("work.meniscus");
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, FileAction::SaveAs(project_path.clone()));
    until(&mut m, |m| !m.is_dirty());
    let (document, _) = project::read(&project_path).expect("a project");
    assert_eq!(document.mesh.positions, m.document.mesh.positions);
    assert_eq!(document.first_patch_face, m.document.first_patch_face);
    assert_eq!(document.selection, m.document.selection);
    assert_eq!(document.controls, m.document.controls);
    assert_eq!(document.accepted, m.document.accepted);

    // damaged or missing files leave everything as it is
    let nonsense = folder.path().join("nonsense.obj");
    std::fs::write(&nonsense, "v 1 2 x\n").expect("written");
    let mesh = Arc::clone(&m.document.mesh);
    for path in [
        nonsense,
        folder.path().join("nothing.ply"),
        folder.path().join("no.meniscus"),
    ] {
        let before = m.log.entries().len();
        act(&mut m, FileAction::Open(path));
        until(&mut m, |m| m.log.entries().len() > before);
        assert!(
            last_message(&m).contains("document is unchanged"),
            "{}",
            last_message(&m)
        );
        assert!(Arc::ptr_eq(&mesh, &m.document.mesh));
    }
}

#[test]
fn a_file_that_cannot_be_opened_at_the_start_gives_the_sample() {
    let mut m = model();
    replace(&mut m, Document::blank());
    until(&mut m, |m| {
        m.displays[0].latest().is_some() && m.picker.is_some()
    });
    act(&mut m, FileAction::Open("nowhere.obj".into()));
    until(&mut m, |m| !m.document.is_blank());
    assert_eq!(m.document.origin.source, Source::Sample("creature".into()));
    assert_eq!(m.document.holes().len(), 16);
    let told = |e: &super::log::Entry| e.text.contains("nowhere.obj");
    assert!(m.log.entries().iter().any(told));
    assert!(m.settings.recent.is_empty());
}

#[test]
fn unsaved_work_is_asked_about() {
    let mut m = model();
    act(&mut m, FileAction::Close);
    assert!(matches!(m.effects.pop(), Some(Effect::Close)));
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, FileAction::Close);
    assert_eq!(m.view.modal, Modal::Unsaved(AfterUnsaved::Close));
    act(&mut m, Action::Escape);
    assert!(m.effects.is_empty() && m.view.modal == Modal::None);
    let folder = tempfile::tempdir().expect("a folder");
    m.saved_to = Some(folder.path().join("out.ply"));
    act(&mut m, FileAction::Close);
    act(&mut m, FileAction::SaveAndContinue);
    until(&mut m, |m| !m.effects.is_empty());
    assert!(matches!(m.effects.pop(), Some(Effect::Close)));
    let saved = io::open(&folder.path().join("out.ply")).expect("saved");
    assert_eq!(saved.mesh.positions, m.document.mesh.positions);
}

#[test]
fn a_recovery_file_survives_its_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut m = model();
    m.autosave = Autosave::in_folder(folder.path());
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    let written = || {
        std::fs::read_dir(folder.path())
            .expect("a folder")
            .filter_map(Result::ok)
            .map(|e| e.path())
            .find(|p| p.extension().is_some_and(|e| e == "meniscus"))
    };
    until(&mut m, |_| written().is_some());
    let path = written().expect("there");
    // the window is open: nothing was left behind
    assert_eq!(
        autosave::left_behind(folder.path()),
        Vec::<std::path::PathBuf>::new()
    );
    let copy = folder.path().join("copy");
    std::fs::create_dir(&copy).expect("made");
    // as after kill -9: the file is there and nobody holds its lock
    std::fs::copy(&path, copy.join("window-1.meniscus")).expect("copied");
    std::fs::write(copy.join("window-1.lock"), "").expect("written");
    let left = autosave::left_behind(&copy);
    assert_eq!(left.len(), 1);
    assert_eq!(project::title(&left[0]), "sample test");
    let (document, _) = project::read(&left[0]).expect("a project");
    assert_eq!(document.mesh.positions, m.document.mesh.positions);
    autosave::remove(&left[0]);
    assert!(autosave::left_behind(&copy).is_empty());
    // nothing is left to recover when everything is undone, whatever is selected
    act(&mut m, EditAction::Undo);
    assert!(!m.is_dirty() && !m.document.selection.is_empty());
    until(&mut m, |_| written().is_none());
    // a regular end leaves nothing
    drop(m);
    assert_eq!(written(), None);
}

#[test]
fn the_command_repeats_the_work() {
    let mut m = model();
    act(&mut m, FileAction::CopyCommand);
    assert!(
        last_message(&m).contains("nothing to repeat"),
        "{}",
        last_message(&m)
    );
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    filled(&mut m);
    act(&mut m, RunAction::Accept(0));
    act(&mut m, FileAction::CopyCommand);
    let Some(Effect::CopyText(text)) = m.effects.pop() else {
        panic!("no text");
    };
    assert!(
        text.starts_with("meniscus sample test -o test.obj\n"),
        "{text}"
    );
    assert!(
        text.contains("meniscus fill test.obj") && text.contains("--loops 2"),
        "{text}"
    );
    assert!(text.contains("--mode flow"), "{text}");
}

#[test]
fn switches_flip_and_views_fit() {
    let mut m = model();
    let before = m.view.style.wireframe;
    act(&mut m, ViewAction::Toggle(Switch::Wireframe));
    assert_ne!(m.view.style.wireframe, before);
    act(&mut m, ViewAction::Toggle(Switch::ZUp));
    assert!(m.view.camera.up().z > 0.5 && m.settings.z_up);
    act(&mut m, ViewAction::Toggle(Switch::ZUp));
    assert!(m.view.camera.up().y > 0.5);
    act(&mut m, ViewAction::FlyToLoop(0.into()));
    let l = &m.document.loops[0];
    let [x, y] = m.view.camera.project(l.centroid, 1.6).expect("in front");
    assert!(x.abs() < 1e-9 && y.abs() < 1e-9, "in the middle");
    // seen from outside: the hole is nearer than the centre of the sphere
    let eye = m.view.camera.eye();
    assert!(eye.distance(l.centroid) < eye.length());
    act(&mut m, ViewAction::FitAll);
    for p in &m.document.mesh.positions {
        let [x, y] = m.view.camera.project(*p, 1280.0 / 800.0).expect("in front");
        assert!(x.abs() <= 1.0 && y.abs() <= 1.0);
    }
}

#[test]
fn rims_of_a_blend_are_gathered_and_joined() {
    let opened = project::sample_of("four-cylinders").expect("a sample");
    let document = Document::new(opened, Source::Sample("four-cylinders".into()));
    let mut m = Model::new(
        document,
        Settings::default(),
        Autosave::off(),
        Arc::new(|| ()),
    );
    act(&mut m, TaskAction::Choose(Task::Blend));
    act(&mut m, RunAction::Start);
    assert!(
        last_message(&m).contains("two rims"),
        "{}",
        last_message(&m)
    );
    act(&mut m, SelectAction::Loop(0.into(), SelectHow::Replace));
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    act(&mut m, SelectAction::Loop(1.into(), SelectHow::Replace));
    assert_eq!(m.document.selection, loops([0]));
    act(&mut m, SelectAction::All);
    assert_eq!(
        m.document.selection.len(),
        4,
        "the rims that face each other"
    );
    filled(&mut m);
    // one name in the table, the legend and the list of expected errors
    let rims: Vec<String> = m.document.selection.iter().map(LoopId::to_string).collect();
    let rows = m.run.as_ref().expect("a run").sides[0].figures();
    assert_eq!(rows[0].names, [rims.join("+")]);
    assert_eq!(last_message(&m), "blend of 4 rims: converged");
    act(&mut m, RunAction::Accept(0));
    check_mesh(&m.document.mesh).expect("sound");
    assert_eq!(components(&m.document.mesh.topology).count, 1);
    assert_eq!(m.document.loops.len(), 4);
    act(&mut m, FileAction::CopyCommand);
    let Some(Effect::CopyText(text)) = m.effects.pop() else {
        panic!("no text");
    };
    assert!(text.contains("meniscus blend four-cylinders.obj"), "{text}");
}
