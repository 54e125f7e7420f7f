//! Dialogs over the window.

use eframe::egui::{self, Context, Key, Modal as Over, Ui};

use crate::app::action::{Action, FileAction, PictureAction, RunAction};
use crate::app::model::Model;
use crate::app::project;
use crate::app::ui::format::format_number;
use crate::app::ui::widgets::{Asks, named, primary};
use crate::app::view_state::{Modal, PathPrompt, PathUse, PictureKind, PictureSettings};
use crate::render::{MAX_SIDE, SequenceFormat};

/// The open dialog.
pub(crate) fn dialogs_ui(ctx: &Context, model: &Model, actions: &mut Vec<Action>) {
    let closed = match &model.view.modal {
        Modal::None => return,
        Modal::Path(prompt) => over(ctx, |ui| path_ui(ui, prompt, actions)),
        Modal::Unsaved(_) => over(ctx, |ui| unsaved_ui(ui, model, actions)),
        Modal::Recover(paths) => over(ctx, |ui| recover_ui(ui, paths, actions)),
        Modal::Large(faces) => over(ctx, |ui| large_ui(ui, *faces, actions)),
        Modal::Picture(settings) => over(ctx, |ui| picture_ui(ui, model, settings, actions)),
    };
    // a click outside the dialog must not discard a recovery file
    if closed && !matches!(model.view.modal, Modal::Recover(_)) {
        actions.push(Action::Escape);
    }
}

fn over(ctx: &Context, body: impl FnOnce(&mut Ui)) -> bool {
    Over::new(egui::Id::unique("dialog"))
        .show(ctx, |ui| {
            ui.set_width(440.0);
            body(ui);
        })
        .should_close()
}

fn path_ui(ui: &mut Ui, prompt: &PathPrompt, actions: &mut Vec<Action>) {
    let title = match prompt.purpose {
        PathUse::Open => "Open a mesh or project",
        PathUse::SaveAs => {
            "Save the mesh (.obj, .ply, .stl, .off, .glb, .gltf) or the project (.meniscus)"
        }
        PathUse::ExportPatch => "Export only the patches (.obj, .ply, .stl, .off, .glb, .gltf)",
        PathUse::Reference => {
            "Open the reference mesh of distances (.obj, .ply, .stl, .off, .glb, .gltf)"
        }
        PathUse::Report(file) => file.title(),
    };
    ui.heading(title);
    ui.weak("The system has no file dialog: type a path.");
    let mut text = prompt.text.clone();
    let field = egui::TextEdit::singleline(&mut text).desired_width(f32::INFINITY);
    let field = named(ui, "Path", field);
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
    if ui.memory(|m| m.focused().is_none()) {
        field.request_focus();
    }
    if field.changed() {
        actions.push(Action::Modal(Modal::Path(PathPrompt {
            text: text.clone(),
            ..prompt.clone()
        })));
    }
    ui.horizontal(|ui| {
        let done = ui.add(primary(ui, "OK")).clicked() || entered;
        if done && !text.trim().is_empty() {
            let path = expand(text.trim());
            actions.push(Action::Modal(Modal::None));
            actions.push(FileAction::UsePath(prompt.purpose, path).into());
        }
        ui.button("Cancel").asks(Action::Escape, actions);
    });
}

/// Expands `~/` like a shell.
fn expand(text: &str) -> std::path::PathBuf {
    match (text.strip_prefix("~/"), std::env::var_os("HOME")) {
        (Some(rest), Some(home)) => std::path::Path::new(&home).join(rest),
        _ => text.into(),
    }
}

fn unsaved_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.heading("There are unsaved changes");
    if model.run.is_some() {
        ui.label("A patch is not accepted.");
    }
    ui.horizontal(|ui| {
        if ui.add(primary(ui, "Save")).clicked() {
            if model.run.is_some() {
                actions.push(RunAction::Accept(0).into());
            }
            actions.push(FileAction::SaveAndContinue.into());
        }
        ui.button("Discard changes")
            .asks(FileAction::DiscardAndContinue, actions);
        ui.button("Cancel")
            .asks(Action::Modal(Modal::None), actions);
    });
}

fn recover_ui(ui: &mut Ui, paths: &[std::path::PathBuf], actions: &mut Vec<Action>) {
    ui.heading("Unsaved work of an earlier session");
    ui.label("The program did not exit normally. Its work can be recovered:");
    for path in paths {
        let when = std::fs::metadata(path)
            .and_then(|m| m.modified())
            .ok()
            .and_then(|t| t.elapsed().ok())
            .map_or_else(String::new, |d| age(d.as_secs() / 60));
        let name = project::title(path);
        ui.button(format!("Recover {name}, {when}"))
            .asks(FileAction::Recover(path.clone()), actions);
    }
    ui.horizontal(|ui| {
        ui.button("Keep for later")
            .asks(Action::Modal(Modal::None), actions);
        ui.button("Delete").asks(FileAction::DropRecovery, actions);
    });
}

fn large_ui(ui: &mut Ui, faces: u64, actions: &mut Vec<Action>) {
    ui.heading("This is a large refinement");
    ui.label(format!(
        "The result has about {} million faces. Computing it can take minutes and several gigabytes \
         of memory. Fewer levels give a smaller result.",
        format_number(faces as f64 / 1e6)
    ));
    ui.horizontal(|ui| {
        ui.add(primary(ui, "Refine"))
            .asks(RunAction::StartLarge, actions);
        ui.button("Cancel")
            .asks(Action::Modal(Modal::None), actions);
    });
}

/// The age of a file in words.
fn age(minutes: u64) -> String {
    match minutes {
        0 => "less than a minute old".into(),
        1 => "1 minute old".into(),
        2..120 => format!("{minutes} minutes old"),
        120..2880 => format!("{} hours old", minutes / 60),
        _ => format!("{} days old", minutes / 1440),
    }
}

fn picture_ui(ui: &mut Ui, model: &Model, settings: &PictureSettings, actions: &mut Vec<Action>) {
    let mut next = settings.clone();
    ui.heading("Picture");
    ui.horizontal(|ui| {
        for (kind, title, enabled) in [
            (PictureKind::Still, "one picture", true),
            (PictureKind::Turntable, "turntable", true),
            (PictureKind::Flow, "states of the flow", model.run.is_some()),
        ] {
            if ui
                .add_enabled(enabled, egui::Button::selectable(next.kind == kind, title))
                .clicked()
            {
                next.kind = kind;
            }
        }
    });
    if next.kind == PictureKind::Still {
        next.format = SequenceFormat::Png;
    } else {
        ui.horizontal(|ui| {
            for (format, title) in [
                (SequenceFormat::Png, "numbered PNG"),
                (SequenceFormat::Gif, "GIF"),
                (SequenceFormat::Apng, "APNG"),
            ] {
                ui.selectable_value(&mut next.format, format, title);
            }
            let fps = egui::DragValue::new(&mut next.fps).range(1.0..=60.0);
            named(ui, "pictures per second", fps);
            if next.kind == PictureKind::Turntable {
                let frames = egui::DragValue::new(&mut next.frames).range(2..=2000);
                named(ui, "pictures", frames);
            }
        });
    }
    size_ui(ui, model, &mut next);
    ui.checkbox(&mut next.transparent, "transparent background");
    ui.checkbox(&mut next.overlays, "with rims and selection");
    if next.format != settings.format || next.kind != settings.kind {
        let extension = if next.format == SequenceFormat::Gif {
            "gif"
        } else {
            "png"
        };
        let path = std::path::Path::new(&next.path).with_extension(extension);
        next.path = path.display().to_string();
    }
    let path = egui::TextEdit::singleline(&mut next.path).desired_width(f32::INFINITY);
    named(ui, "File", path);
    if next != *settings {
        actions.push(Action::Modal(Modal::Picture(next.clone())));
    }
    ui.horizontal(|ui| {
        ui.add(primary(ui, "Write"))
            .asks(PictureAction::Make(Box::new(next)), actions);
        if ui.button("Copy to the clipboard").clicked() {
            actions.push(PictureAction::Copy.into());
            actions.push(Action::Modal(Modal::None));
        }
        ui.button("Cancel")
            .asks(Action::Modal(Modal::None), actions);
    });
}

fn size_ui(ui: &mut Ui, model: &Model, next: &mut PictureSettings) {
    ui.horizontal(|ui| {
        for (name, value) in [("Width", &mut next.width), ("Height", &mut next.height)] {
            let pixels = egui::DragValue::new(value).range(1..=MAX_SIDE);
            named(ui, name, pixels.suffix(" px"));
        }
        for factor in [1.0, 2.0, 4.0] {
            let [w, h] = model.view.viewport_px.map(|x| (x * factor) as u32);
            let fits = w.max(h) <= MAX_SIDE && w.min(h) > 0;
            if ui
                .add_enabled(fits, egui::Button::new(format!("{factor}×")).small())
                .on_hover_text("multiple of the view")
                .clicked()
            {
                (next.width, next.height) = (w, h);
            }
        }
    });
}
