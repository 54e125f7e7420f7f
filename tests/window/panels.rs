//! The window driven by its accessible labels, drawn in software where there is no graphics card.
//! Without any adapter these tests fail: `scripts/test.sh` installs one.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::wait::wait_for;
use eframe::egui::{self, Key, Modifiers, Pos2, Role, Theme};
use egui_kittest::kittest::{By, NodeT, Queryable};
use egui_kittest::{Harness, SnapshotOptions};
use meniscus::app::{App, Autosave, ControlsAction, Document, Model, Run, Settings, Source, act};
use meniscus::fill::{Continuity, Surface};
use meniscus::io;
use meniscus::mesh::{DVec3, LoopId, Soup};
use meniscus::render::{Bounds, Camera, Material};
use meniscus::shapes::{Hole, HoleShape, cut_holes, sphere};

fn hole(centre: DVec3, radius: f64, seed: u64) -> Hole {
    Hole {
        centre,
        shape: HoleShape::Disc { radius },
        turn: 0.0,
        seed,
    }
}

/// A sphere with a hole towards the first camera and one on the other side.
fn document() -> Document {
    let one = DVec3::ONE;
    let towards = -Camera::fit(&Bounds::new(-one, one)).forward();
    sphere_with(&[hole(towards, 0.45, 1), hole(-towards, 0.3, 2)])
}

/// A sphere with a dozen holes, so that the list of loops has filters.
fn riddled() -> Document {
    let centre = |i: u32| {
        let height = (f64::from(i) - 5.5) / 7.0;
        let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
        let radius = (1.0 - height * height).sqrt();
        DVec3::new(radius * cos, height, radius * sin)
    };
    let holes: Vec<Hole> = (0..12)
        .map(|i| hole(centre(i), 0.2, u64::from(i)))
        .collect();
    sphere_with(&holes)
}

fn sphere_with(holes: &[Hole]) -> Document {
    let (positions, triangles) = cut_holes(&sphere(900, 3), holes);
    let soup = Soup {
        positions,
        offsets: (0..=triangles.len() as u32).map(|i| 3 * i).collect(),
        corners: triangles.into_iter().flatten().collect(),
        ..Soup::default()
    };
    let opened = io::from_soup(&soup, Path::new("sphere")).expect("sound");
    Document::new(opened, Source::Sample("sphere".into()))
}

fn window() -> Harness<'static, App> {
    window_of([900.0, 600.0], true)
}

fn window_of(size: [f32; 2], dark: bool) -> Harness<'static, App> {
    window_on(document(), size, dark)
}

fn window_on(document: Document, size: [f32; 2], dark: bool) -> Harness<'static, App> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_theme(if dark { Theme::Dark } else { Theme::Light })
        .with_max_steps(40)
        .wgpu()
        .build_eframe(move |cc| {
            let ctx = cc.egui_ctx.clone();
            let wake = Arc::new(move || ctx.request_repaint());
            let settings = Settings {
                dark,
                ..Settings::default()
            };
            let model = Model::new(document, settings, Autosave::off(), wake);
            App::new(model, &cc.egui_ctx, cc.wgpu_render_state.as_ref())
        });
    until(&mut harness, |app| {
        app.model.picker.is_some() && app.model.displays[0].latest().is_some()
    });
    harness
}

/// Frames until `done`.
fn until(harness: &mut Harness<'_, App>, done: impl Fn(&App) -> bool) {
    wait_for("a frame", || {
        harness.step();
        done(harness.state()).then_some(())
    });
    harness.run_steps(3);
}

/// Closes the toasts, which would be at other moments of their fading.
fn dismiss_toasts(harness: &mut Harness<'_, App>) {
    let log = &mut harness.state_mut().model.log;
    for toast in log.toasts(Instant::now()) {
        log.dismiss(toast);
    }
    harness.run_steps(3);
}

fn ended(app: &App) -> bool {
    app.model.run.as_ref().is_some_and(Run::ended)
}

/// The front hole.
fn front(app: &App) -> LoopId {
    let loops = &app.model.document.loops;
    usize::from(loops[1].radius > loops[0].radius).into()
}

/// Where the front hole is in the window.
fn middle(harness: &Harness<'_, App>) -> Pos2 {
    harness.get_by_label("view").rect().center()
}

#[test]
fn the_hole_under_the_cursor_is_the_one_that_is_picked() {
    let mut harness = window();
    let i = front(harness.state());
    let at = middle(&harness);
    harness.hover_at(at);
    harness.run_steps(3);
    assert_eq!(harness.state().model.view.hover, [i]);
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.selection, [i].into());

    // a drag turns the camera and picks nothing
    let before = harness.state().model.view.camera;
    harness.drag_at(at);
    harness.step();
    for n in 1..=6 {
        harness.hover_at(at + egui::vec2(5.0 * n as f32, 0.0));
        harness.step();
    }
    harness.drop_at(at + egui::vec2(30.0, 0.0));
    harness.run_steps(3);
    assert_ne!(harness.state().model.view.camera, before);
    assert_eq!(harness.state().model.document.selection, [i].into());

    // the list and the view are one selection
    let other = LoopId::from(1 - i.index());
    let l = &harness.state().model.document.loops[other.index()];
    let name = format!("loop {}, {} edges", l.id, l.edges());
    harness.get_by_label(&name).click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.selection, [other].into());
}

/// Two clicks on the rim of the front hole choose a part of it, which Enter fills.
#[test]
fn part_of_a_hole_is_chosen_by_two_clicks() {
    let mut harness = window();
    harness.get_by_label("Part of a hole").click();
    harness.run_steps(3);
    let view = harness.get_by_label("view").rect();
    let model = &harness.state().model;
    let hole = &model.document.loops[front(harness.state()).index()];
    let before = model.document.mesh.face_count();
    let ends = [0, hole.edges() / 3].map(|i| {
        let point = model.document.mesh.position(hole.vertices[i]);
        let aspect = f64::from(view.width() / view.height());
        let [x, y] = model.view.camera.project(point, aspect).expect("in front");
        let at = [0.5 * (1.0 + x as f32), 0.5 * (1.0 - y as f32)];
        (point, view.min + egui::Vec2::from(at) * view.size())
    });
    for (_, at) in ends {
        harness.hover_at(at);
        harness.run_steps(2);
        harness.drag_at(at);
        harness.step();
        harness.drop_at(at);
        harness.run_steps(3);
    }
    let part = harness.state().model.view.part.expect("chosen");
    assert_eq!([part.from, part.to], ends.map(|(point, _)| Some(point)));
    harness.get_by_label("Fill part of a hole");
    harness.remove_cursor();
    harness.run_steps(3);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(40);
    harness.snapshot_options("window_part", &options);
    harness.key_press(Key::Enter);
    until(&mut harness, ended);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let document = &harness.state().model.document;
    assert!(document.mesh.face_count() > before);
    assert_eq!(document.loops.len(), 2, "the rest of the hole is open");
}

/// Selects both loops and opens the choices of each rim.
fn open_rims(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(2);
    harness.get_by_label("Each rim").click();
    let is_open = |harness: &Harness<'_, App>| harness.query_all_by_label("G1").count() == 3;
    wait_for("the rims", || {
        harness.step();
        is_open(harness).then_some(())
    });
    // until the section has its full height
    harness.run_steps(20);
}

/// The well-posedness is that of an energy that is used.
#[test]
fn an_unused_energy_is_not_called_well_posed() {
    let mut harness = window_of([1280.0, 1000.0], true);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    let labels = |harness: &Harness<'_, App>| {
        ["well-posed", "not used by this surface model"]
            .map(|label| harness.query_by_label(label).is_some())
    };
    wait_for("the well-posedness", || {
        harness.step();
        (labels(&harness) == [true, false]).then_some(())
    });
    let mut controls = harness.state().model.document.controls.clone();
    controls.surface = Surface::G2;
    let model = &mut harness.state_mut().model;
    act(model, ControlsAction::Set(Box::new(controls)));
    harness.run_steps(3);
    assert_eq!(labels(&harness), [false, true]);
}

/// A row of any list highlights its loop in the view, and leaving the row ends that.
#[test]
fn hovered_rows_are_highlighted_in_the_view() {
    // the controls are visible without scrolling
    let mut harness = window_of([1280.0, 1000.0], true);
    open_rims(&mut harness);
    let hovered = |harness: &Harness<'_, App>| harness.state().model.view.hover.clone();
    for i in [0, 1] {
        let l = &harness.state().model.document.loops[i];
        let rows = [
            format!("loop {}, {} edges", l.id, l.edges()),
            format!("loop {}", l.id),
        ];
        let id = l.id;
        for row in rows {
            let at = harness.get_by_label(&row).rect().center();
            harness.hover_at(at);
            harness.run_steps(3);
            assert_eq!(hovered(&harness), [id], "{row}");
            let heading = harness.get_by_label("Flow").rect().center();
            harness.hover_at(heading);
            harness.run_steps(3);
            assert!(hovered(&harness).is_empty(), "{row}");
        }
    }
}

/// A typed energy with `gradH2` runs and is scrubbed; each rim has its own continuity under it.
#[test]
fn an_energy_of_sixth_order_runs_with_a_continuity_at_each_rim() {
    let mut harness = window_of([1280.0, 1000.0], true);
    let model = &mut harness.state_mut().model;
    act(model, ControlsAction::EnergyText("H^2 + 0.1*gradH2".into()));
    act(model, ControlsAction::ApplyEnergy);
    open_rims(&mut harness);
    // the choices of all rims stand above those of each
    let of_first = harness.get_all_by_label("G1").nth(1);
    of_first.expect("of the first").click();
    harness.run_steps(3);
    let of_last = harness.get_all_by_label("G2").last();
    of_last.expect("of the last").click();
    harness.run_steps(3);
    let controls = &harness.state().model.document.controls;
    let own: Vec<_> = controls.loop_continuity.values().copied().collect();
    assert_eq!(own, [Continuity::G1, Continuity::G2]);
    assert_eq!(controls.surface, Surface::Energy);
    harness.key_press(Key::Enter);
    until(&mut harness, ended);
    let run = harness.state().model.run.as_ref().expect("there");
    assert!(run.state_count() > 5);
    harness.get_by_label("Accept").click();
    harness.run_steps(3);
    assert!(harness.state().model.document.loops.is_empty());
}

#[test]
fn the_load_report_has_buttons_that_clean() {
    let mut harness = window();
    harness.state_mut().model.view.windows.report = true;
    harness.run_steps(3);
    for (button, words) in [
        ("Remove loose parts", "removal of loose parts: none found"),
        ("Stitch slits", "stitching of slits: none found"),
    ] {
        harness.get_by_label(button).click();
        harness.run_steps(3);
        let entries = harness.state().model.log.entries();
        let last = entries.last().expect("an entry");
        assert!(last.text.starts_with(words), "{}", last.text);
    }
    assert!(!harness.state().model.document.is_changed());
}

#[test]
fn enter_fills_space_pauses_the_timeline_scrubs_and_undo_takes_it_back() {
    let mut harness = window();
    let i = front(harness.state());
    harness.get_by_label("view").rect();
    let l = &harness.state().model.document.loops[i.index()];
    let name = format!("loop {}, {} edges", l.id, l.edges());
    harness.get_by_label(&name).click();
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    until(&mut harness, |app| {
        app.model.run.as_ref().is_some_and(|r| r.state_count() > 3)
    });
    harness.get_by_label("Pause").click();
    harness.run_steps(2);
    assert!(!harness.state().model.run.as_ref().expect("runs").playing);
    harness.key_press(Key::Space);
    until(&mut harness, ended);
    let count = harness
        .state()
        .model
        .run
        .as_ref()
        .expect("there")
        .state_count();

    harness
        .get_all_by_label("Timeline")
        .find(|n| n.accesskit_node().numeric_value().is_some())
        .expect("a slider")
        .set_value_accesskit(2.0);
    harness.run_steps(3);
    let run = harness.state().model.run.as_ref().expect("there");
    assert_eq!(run.sides[0].shown, Some(2), "of {count}");
    harness.get_by_label("Accept").click();
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.loops.len(), 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.loops.len(), 2);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.loops.len(), 1);
}

#[test]
fn a_stroke_selects_faces_that_are_refilled() {
    let mut harness = window();
    harness.get_by_label("Repair").click();
    harness.run_steps(2);
    // beside the hole in the middle of the view
    let view = harness.get_by_label("view").rect();
    let radius = 0.5 * view.height().min(view.width());
    let at = |n: u8| view.center() + egui::vec2(0.55 * radius, 4.0 * f32::from(n));
    let camera = harness.state().model.view.camera;
    harness.drag_at(at(0));
    harness.step();
    for n in 1..=5 {
        harness.hover_at(at(n));
        harness.step();
    }
    harness.drop_at(at(5));
    harness.run_steps(3);
    let model = &harness.state().model;
    assert_eq!(model.view.camera, camera, "a stroke does not turn the view");
    assert!(model.document.faces.len() > 4);
    assert!(model.document.selection.is_empty());
    let holes = model.document.loops.len();
    harness.get_by_label("Grow the selection").click();
    harness.run_steps(2);
    harness.get_by_label("Erase and refill").click();
    until(&mut harness, ended);
    harness.get_by_label("Accept").click();
    harness.run_steps(3);
    let document = &harness.state().model.document;
    assert!(document.is_changed() && document.faces.is_empty());
    assert!(document.loops.len() <= holes);
}

fn enter_energy_field(harness: &mut Harness<'_, App>) {
    let at = harness
        .get_all_by_label("f(H, K) =")
        .find(|n| n.value().is_some())
        .expect("a field")
        .rect()
        .center();
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run_steps(2);
}

/// The field has its text from before, and nothing else has changed.
#[test]
fn esc_only_leaves_a_text_field() {
    let mut harness = window();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(2);
    let surface = harness.state().model.document.controls.surface;
    enter_energy_field(&mut harness);
    harness.event(egui::Event::Text("+x".into()));
    harness.run_steps(3);
    assert_ne!(harness.state().model.view.energy_text, "H^2");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    let model = &harness.state().model;
    assert_eq!(model.view.energy_text, "H^2");
    assert_eq!(model.document.controls.surface, surface);
    assert_eq!(model.document.selection.len(), 2);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().model.document.selection.is_empty());
}

#[test]
fn a_mistyped_energy_is_shown_at_its_character_and_keys_stay_text() {
    let mut harness = window();
    let wire = harness.state().model.view.style.wireframe;
    enter_energy_field(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("H^2 + w".into()));
    harness.key_press(Key::W);
    harness.run_steps(3);
    assert_eq!(harness.state().model.view.energy_text, "H^2 + w");
    assert_eq!(
        harness.state().model.view.style.wireframe,
        wire,
        "W was typed"
    );
    assert!(harness.query_by_label_contains("at character 7").is_some());
    assert_eq!(harness.state().model.document.controls.energy, "H^2");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("H^2+K^2".into()));
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().model.document.controls.energy, "H^2+K^2");
    assert!(
        harness.state().model.run.is_none(),
        "Enter belonged to the field"
    );
}

/// Fills all holes as fast as they can be shown.
fn fill_all(harness: &mut Harness<'_, App>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.state_mut().model.view.pace = 240.0;
    harness.key_press(Key::Enter);
    until(harness, ended);
    settle(harness);
}

/// Waits until what is drawn is what was last requested.
fn settle(harness: &mut Harness<'_, App>) {
    until(harness, |app| {
        let mut displays = app.model.displays.iter();
        displays.all(|display| display.requested().is_none() || display.is_settled())
    });
}

#[test]
fn pictures_of_the_window() {
    let mut harness = window();
    // other drivers round other edges of triangles and letters
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(40);
    harness.remove_cursor();
    harness.run_steps(3);
    harness.snapshot_options("window_open", &options);
    fill_all(&mut harness);
    harness.key_press(Key::H);
    settle(&mut harness);
    let run = harness.state().model.run.as_ref().expect("there");
    let figures = run.sides[0].handle.figures(None);
    assert!(figures.iter().all(|f| matches!(f.end, Some(Ok(_)))));
    dismiss_toasts(&mut harness);
    harness.snapshot_options("window_filled", &options);
}

/// Two energies side by side with their plots, and the dialog that writes their picture.
#[test]
fn pictures_of_a_comparison() {
    let mut harness = window_of([1280.0, 720.0], true);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness
        .get_by_label("Compare with another energy (A/B)")
        .click();
    harness.run_steps(3);
    let list = harness.get_all_by_label("Preset of B").last();
    list.expect("a list").click();
    harness.run_steps(3);
    harness.get_by_label_contains("Total curvature");
    harness.get_by_label_contains("Sum of squares").click();
    harness.run_steps(3);
    let view = &harness.state().model.view;
    let compared = view.compared.as_ref().map(|b| b.text.as_str());
    assert_eq!(compared, Some("H^2+K^2"));
    fill_all(&mut harness);
    harness.key_press(Key::H);
    settle(&mut harness);
    harness.remove_cursor();
    dismiss_toasts(&mut harness);
    harness.snapshot_options("window_comparison", &options);

    harness.key_press_modifiers(Modifiers::COMMAND, Key::P);
    harness.run_steps(5);
    harness.get_by_label("Browse…");
    harness.get_by_label("states of the flow").click();
    harness.run_steps(5);
    harness.snapshot_options("window_picture_dialog", &options);
}

/// The menu of the shaded view has the materials, and G draws the grid.
#[test]
fn materials_and_the_grid_are_switched() {
    let mut harness = window();
    harness.get_by_label("Options").click();
    harness.run_steps(5);
    harness.get_by_label("Porcelain").click();
    harness.run_steps(3);
    assert_eq!(
        harness.state().model.view.style.material,
        Material::Porcelain
    );
    assert_eq!(harness.state().model.settings.material, Material::Porcelain);
    harness.key_press(Key::Escape);
    harness.run_steps(5);
    harness.key_press(Key::G);
    harness.run_steps(5);
    harness.remove_cursor();
    harness.run_steps(3);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness.snapshot_options("window_material", &options);
}

/// A larger window in the light theme, with numbers and plots.
#[test]
fn pictures_of_a_larger_window_in_the_light_theme() {
    let mut harness = window_of([1280.0, 720.0], false);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness.key_press(Key::B);
    harness.remove_cursor();
    harness.run_steps(3);
    harness.snapshot_options("window_light", &options);
    fill_all(&mut harness);
    harness.key_press(Key::S);
    harness.run_steps(5);
    harness.get_by_label("Accept (Enter)");
    dismiss_toasts(&mut harness);
    harness.snapshot_options("window_light_filled", &options);
}

/// Menus open with F10, close with Esc, and neither key reaches the view.
#[test]
fn menus_open_and_close_with_keys() {
    let mut harness = window();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("Save as…").is_none());
    harness.key_press(Key::F10);
    // as in a window, which draws another frame only if one is requested
    harness.step();
    while harness.ctx.has_requested_repaint()
        && harness.query_by_label_contains("Save as…").is_none()
    {
        harness.step();
    }
    harness.get_by_label_contains("Save as…");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Save as…").is_none());
    assert_eq!(harness.state().model.document.selection.len(), 2);
}

/// The arrow keys lead from menu to menu and into submenus, and Alt with a letter opens a menu.
#[test]
fn keys_change_the_open_menu() {
    let mut harness = window();
    harness.state_mut().model.view.camera.distance *= 2.0;
    let camera = harness.state().model.view.camera;
    let press = |harness: &mut Harness<'_, App>, modifiers: Modifiers, key: Key| {
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(5);
    };
    // an entry of each menu
    let open = |harness: &Harness<'_, App>| -> Vec<&'static str> {
        let entries = [
            "Save as…",
            "Frame times and memory",
            "Distance to a mesh…",
            "Across x",
            "Picture of the whole window",
        ];
        let shown = |entry: &&str| harness.query_all_by_label_contains(entry).count() > 0;
        entries.into_iter().filter(shown).collect()
    };
    press(&mut harness, Modifiers::NONE, Key::F10);
    assert_eq!(open(&harness), ["Save as…"]);
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(open(&harness), ["Frame times and memory"]);
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(open(&harness), ["Save as…"]);
    press(&mut harness, Modifiers::ALT, Key::P);
    assert_eq!(open(&harness), ["Picture of the whole window"]);
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(open(&harness), ["Distance to a mesh…"]);
    for key in [Key::ArrowDown, Key::ArrowDown, Key::ArrowRight] {
        press(&mut harness, Modifiers::NONE, key);
    }
    assert_eq!(open(&harness), ["Distance to a mesh…", "Across x"]);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    assert!(open(&harness).is_empty());
    press(&mut harness, Modifiers::ALT, Key::F);
    assert_eq!(open(&harness), ["Save as…"]);
    press(&mut harness, Modifiers::NONE, Key::Escape);
    // Alt is up again before the frame is drawn
    harness.event(egui::Event::Key {
        key: Key::F,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::ALT,
    });
    harness.run_steps(5);
    assert_eq!(open(&harness), ["Save as…"]);
    assert_eq!(harness.state().model.view.camera, camera, "F alone fits it");
}

/// The wheel leads to the surface under the pointer, and ends in front of it.
#[test]
fn the_wheel_does_not_lead_through_the_surface() {
    let mut harness = window();
    // beside the hole in the middle of the view
    let view = harness.get_by_label("view").rect();
    let radius = 0.5 * view.height().min(view.width());
    harness.hover_at(view.center() + egui::vec2(0.55 * radius, 0.0));
    for _ in 0..40 {
        harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: egui::vec2(0.0, 100.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(5);
    }
    let camera = &harness.state().model.view.camera;
    let (eye, pivot) = (camera.eye().length(), camera.pivot.length());
    assert!(camera.distance < 1e-3, "{}", camera.distance);
    assert!((pivot - 1.0).abs() < 0.05 && eye > pivot, "{eye} {pivot}");
}

/// The controls stay where they are when the view mode changes, and the panels leave their place
/// to the view when they are closed.
#[test]
fn controls_do_not_jump_and_panels_can_be_closed() {
    let mut harness = window();
    let places = |harness: &Harness<'_, App>| {
        ["Wireframe", "Rims", "view"].map(|name| harness.get_by_label(name).rect())
    };
    let before = places(&harness);
    for mode in ["Isophotes", "H", "Zebra", "Shaded"] {
        harness.get_by_label(mode).click();
        harness.run_steps(3);
        assert_eq!(places(&harness), before, "{mode}");
    }
    // what is measured in the background has its row from the beginning
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(2);
    let flow = |harness: &Harness<'_, App>| harness.get_by_label("Flow").rect();
    let before = flow(&harness);
    until(&mut harness, |app| {
        let scan = app.model.displays[0].latest().and_then(|d| d.posed);
        scan.is_some_and(|scan| scan.samples > 0)
    });
    assert_eq!(flow(&harness), before);
    for key in [Key::F6, Key::F8] {
        let width = harness.get_by_label("view").rect().width();
        harness.key_press(key);
        harness.run_steps(30);
        assert!(harness.get_by_label("view").rect().width() > width + 200.0);
    }
}

/// Only a drag changes the width of a side panel: no long number, no other content and no small window does.
#[test]
fn side_panels_keep_their_widths() {
    let mut harness = window_of([1280.0, 1000.0], true);
    let view = |harness: &Harness<'_, App>| harness.get_by_label("view").rect();
    let first = view(&harness);
    let mut controls = harness.state().model.document.controls.clone();
    (controls.tension, controls.bulge) = (0.012_345_6, -0.012_345_6);
    let set = ControlsAction::Set(Box::new(controls));
    act(&mut harness.state_mut().model, set);
    harness.run_steps(10);
    assert_eq!(view(&harness), first, "numbers");
    for tab in ["Report", "Controls"] {
        harness.get_by_label(tab).click();
        harness.run_steps(5);
        assert_eq!(view(&harness), first, "{tab}");
    }

    let edge = first.left_center() - egui::vec2(2.0, 0.0);
    let dragged = edge + egui::vec2(40.0, 0.0);
    harness.hover_at(edge);
    harness.step();
    harness.drag_at(edge);
    harness.step();
    harness.hover_at(dragged);
    harness.step();
    harness.drop_at(dragged);
    harness.run_steps(5);
    let chosen = view(&harness);
    assert!((chosen.left() - dragged.x).abs() < 1.0, "{chosen:?}");
    harness.set_size(egui::vec2(900.0, 600.0));
    harness.run_steps(5);
    assert!(view(&harness).left() < chosen.left());
    harness.set_size(egui::vec2(1280.0, 1000.0));
    harness.run_steps(5);
    assert_eq!(view(&harness), chosen, "after a small window");
}

/// A typed number counts once Enter ends it, and that Enter starts no fill.
#[test]
fn a_typed_number_counts_at_its_end() {
    let mut harness = window_of([1280.0, 1000.0], true);
    let tension = |harness: &Harness<'_, App>| {
        let model = &harness.state().model;
        (model.document.controls.tension, model.run.is_none())
    };
    let click = |harness: &mut Harness<'_, App>| {
        let field = harness
            .get_all_by_label("Tension")
            .find(|n| n.accesskit_node().role() == Role::SpinButton);
        let at = field.expect("a field").rect().center();
        harness.drag_at(at);
        harness.drop_at(at);
        harness.run_steps(2);
    };
    click(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    for typed in ["0", ".", "0", "1", "2", "3", "4", "5"] {
        harness.event(egui::Event::Text(typed.into()));
        harness.step();
    }
    assert_eq!(tension(&harness), (0.0, true));
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(tension(&harness), (0.012_345, true));

    // the field shows fewer digits, which do not become the value
    click(&mut harness);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(tension(&harness), (0.012_345, true));
}

/// A released slider of a parameter keeps the value that it showed.
#[test]
fn a_parameter_keeps_its_value_when_its_slider_is_released() {
    let mut harness = window_of([1280.0, 1000.0], true);
    let model = &mut harness.state_mut().model;
    act(model, ControlsAction::EnergyText("(H-a)^2".into()));
    act(model, ControlsAction::AddParameter("a".into()));
    harness.run_steps(3);
    let slider = harness
        .get_all_by_label("a")
        .find(|n| n.accesskit_node().role() == Role::Slider);
    let rail = slider.expect("a slider").rect();
    let value = |harness: &Harness<'_, App>| harness.state().model.document.controls.param["a"];
    harness.hover_at(rail.center());
    harness.step();
    harness.drag_at(rail.center());
    harness.step();
    harness.hover_at(rail.right_center());
    harness.run_steps(2);
    let held = value(&harness);
    harness.drop_at(rail.right_center());
    harness.run_steps(3);
    assert_eq!((held, value(&harness)), (4.0, 4.0));
}

/// The heading of the column that sorts the list has room for its arrow.
#[test]
fn the_sorted_column_has_its_arrow() {
    let mut harness = window_on(riddled(), [1280.0, 720.0], true);
    harness.get_by_label("Sort by edges").click();
    harness.run_steps(3);
    let font = egui::FontId::proportional(13.0);
    let heading = harness.ctx.fonts_mut(|fonts| {
        let galley = fonts.layout_no_wrap("↑edges".into(), font, egui::Color32::WHITE);
        galley.size().x
    });
    let shown = harness.get_by_label("Sort by edges").rect().width();
    assert!(shown > heading - 0.5, "{shown} of {heading}");
}

/// No button, field or label of a panel reaches beyond it, and the toolbar has one row, also where the
/// window is small or its scale is large.
#[test]
fn nothing_leaves_its_panel_in_a_small_window() {
    for size in [[900.0, 600.0], [800.0, 500.0]] {
        let mut harness = window_on(riddled(), size, true);
        for task in [Key::F2, Key::F3, Key::F4, Key::F5] {
            harness.key_press(task);
            harness.run_steps(6);
            dismiss_toasts(&mut harness);
            let view = harness.get_by_label("view").rect();
            let named = harness.query_all(
                By::new().predicate(|node| node.label().is_some() && node.role() != Role::Canvas),
            );
            let mut count = 0;
            for node in named {
                let rect = node.rect();
                let name = node.accesskit_node().label();
                let is_left = rect.left() < view.left() - 20.0 && rect.top() >= view.top();
                if is_left && rect.bottom() < size[1] - 30.0 && rect.right() < view.right() {
                    assert!(
                        rect.right() <= view.left(),
                        "{name:?} at {rect:?}, {size:?}"
                    );
                    count += 1;
                }
                assert!(
                    rect.right() <= size[0] + 0.5,
                    "{name:?} at {rect:?}, {size:?}"
                );
            }
            assert!(count > 10, "{count} names");
            assert!(view.top() < 70.0, "the toolbar ends at {}", view.top());
        }
    }
}

/// Side panels end where the bottom panel begins, titles of a choice are in one row, and the legend is apart
/// from buttons in a low window.
#[test]
fn a_low_window_has_room_for_all() {
    let mut harness = window_on(riddled(), [800.0, 500.0], true);
    let top = |harness: &Harness<'_, App>, name: &str| harness.get_by_label(name).rect().top();
    let scheme = ["normal", "mixed", "corrected"].map(|name| top(&harness, name));
    assert!(
        scheme.iter().all(|y| (y - scheme[0]).abs() < 0.5),
        "{scheme:?}"
    );
    fill_all(&mut harness);
    harness.key_press(Key::H);
    harness.key_press(Key::F7);
    harness.run_steps(20);
    let bar = top(&harness, "Numbers and plots");
    let edges = harness
        .get_all_by_role(Role::Splitter)
        .map(|edge| edge.rect());
    let upright: Vec<_> = edges.filter(|edge| edge.height() > edge.width()).collect();
    assert_eq!(upright.len(), 2);
    assert!(
        upright.iter().all(|edge| edge.bottom() <= bar),
        "{upright:?}, {bar}"
    );
    harness.remove_cursor();
    dismiss_toasts(&mut harness);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness.snapshot_options("window_low", &options);
}

/// The legend is above the buttons of a narrow comparison, and the axes are below its titles.
#[test]
fn a_narrow_comparison_has_room_for_all() {
    let mut harness = window();
    let compare = ControlsAction::CompareEnergy(Some("H^2+K^2".into()));
    act(&mut harness.state_mut().model, compare);
    fill_all(&mut harness);
    harness.key_press(Key::H);
    settle(&mut harness);
    harness.remove_cursor();
    dismiss_toasts(&mut harness);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness.snapshot_options("window_narrow_comparison", &options);
}

/// The parameters of both energies have sliders, which do not change each other.
#[test]
fn parameters_of_both_energies_are_set() {
    let mut harness = window_of([1280.0, 1000.0], true);
    let set = |harness: &mut Harness<'_, App>, action: ControlsAction| {
        act(&mut harness.state_mut().model, action);
        harness.run_steps(3);
    };
    set(&mut harness, ControlsAction::EnergyText("(H-a)^2".into()));
    set(&mut harness, ControlsAction::AddParameter("a".into()));
    set(
        &mut harness,
        ControlsAction::CompareEnergy(Some("(H-a)^2+b*K".into())),
    );
    harness.get_by_label("Make \"b\" a parameter").click();
    harness.run_steps(3);
    let sliders = |harness: &Harness<'_, App>, name: &str| {
        harness
            .get_all_by_label(name)
            .filter(|n| n.accesskit_node().role() == Role::Slider)
            .count()
    };
    assert_eq!(
        ["a", "B: a", "B: b"].map(|name| sliders(&harness, name)),
        [1, 1, 1]
    );
    set(
        &mut harness,
        ControlsAction::CompareParameter("a".into(), -2.0),
    );
    let model = &harness.state().model;
    let compared = model.view.compared.as_ref().expect("an energy");
    assert_eq!(
        (model.document.controls.param["a"], compared.param["a"]),
        (1.0, -2.0)
    );
    harness.get_by_label("Reset B: a").click();
    harness.run_steps(3);
    let compared = harness
        .state()
        .model
        .view
        .compared
        .as_ref()
        .expect("an energy");
    assert_eq!((compared.param["a"], compared.param["b"]), (1.0, 1.0));
}

/// Rows of the shortcut sheet are found by what they do and by their keys.
#[test]
fn the_shortcut_sheet_is_searched() {
    let mut harness = window();
    harness.key_press(Key::F1);
    for _ in 0..5 {
        if harness.query_by_label("Camera").is_none() {
            harness.step();
        }
    }
    // each row is below the one before it in the first frame already
    let rows = |harness: &Harness<'_, App>| {
        let rows = [
            "Select a hole",
            "Add a hole to the selection",
            "Add or remove a hole",
        ];
        let rows = rows.map(|row| harness.get_by_label(row).rect());
        let heading = harness.get_by_label("Camera").rect();
        [rows[0], rows[1], rows[2], heading].map(|rect| [rect.top(), rect.bottom()])
    };
    let first = rows(&harness);
    assert!(
        first.windows(2).all(|rows| rows[0][1] <= rows[1][0]),
        "{first:?}"
    );
    harness.run_steps(20);
    let later = rows(&harness);
    let from_first = |rows: &[[f32; 2]; 4], i: usize| rows[i][1] - rows[0][0];
    assert!(
        (0..4).all(|i| (from_first(&later, i) - from_first(&first, i)).abs() < 0.5),
        "{first:?}, {later:?}"
    );
    let search = |harness: &mut Harness<'_, App>, text: &str| {
        let field = harness
            .get_all_by_label("Search")
            .find(|n| n.value().is_some())
            .expect("a field")
            .rect()
            .center();
        harness.drag_at(field);
        harness.drop_at(field);
        harness.run_steps(2);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        harness.event(egui::Event::Text(text.into()));
        harness.run_steps(3);
    };
    search(&mut harness, "undo");
    harness.get_by_label("Undo (also during a run)");
    assert!(harness.query_by_label("Camera").is_none());
    search(&mut harness, "ctrl+p");
    harness.get_by_label("Write a picture or a sequence");
    assert!(harness.query_by_label("Undo (also during a run)").is_none());
}

/// The report beside a filled sphere, with a section.
#[test]
fn picture_of_the_report() {
    let mut harness = window_of([1280.0, 720.0], true);
    fill_all(&mut harness);
    harness.get_by_label("Accept").click();
    harness.run_steps(2);
    harness.get_by_label("Report").click();
    until(&mut harness, |app| app.model.report.measured.is_some());
    for part in ["Shape and energies", "Section and curvature comb"] {
        harness.get_by_label(part).click();
        harness.run_steps(20);
    }
    // a section across y, through the point clicked in the view
    harness.get_by_label("y").click();
    harness.run_steps(2);
    let at = middle(&harness);
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    until(&mut harness, |app| {
        app.model.report.cut.is_some() && app.model.report.measuring.is_none()
    });
    let report = &harness.state().model.report;
    let measured = report.measured.as_ref().expect("measured");
    assert_eq!(measured.analysis.chains.len(), 2);
    let section = &report.cut.as_ref().expect("cut").section;
    assert_eq!(section.curves.len(), 1);
    assert!(section.curves[0].closed);
    harness.get_by_label("rim 1").rect();
    harness.get_by_label("Hide the half in front").click();
    harness.run_steps(3);
    assert!(harness.state().model.view.camera.cut.is_some());
    harness.remove_cursor();
    dismiss_toasts(&mut harness);
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(60);
    harness.snapshot_options("window_report", &options);
}
