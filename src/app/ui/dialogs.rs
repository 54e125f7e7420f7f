//! Dialogs over the window.

use eframe::egui::{self, Context, Key, Modal as Over, Ui};

use crate::app::action::{Action, FileAction, PictureAction, RunAction};
use crate::app::document::{elided, file_name};
use crate::app::model::Model;
use crate::app::project;
use crate::app::run::Run;
use crate::app::ui::format::{format_number, trimmed};
use crate::app::ui::widgets::{ClickActions, named, number, primary, row};
use crate::app::update::extension;
use crate::app::view_state::{Modal, PathPrompt, PathUse, PictureKind, PictureSettings, Replacing};
use crate::memory::{free_memory, in_gib};
use crate::refine::RefineEstimate;
use crate::render::{MAX_SIDE, SequenceFormat};

/// Maximum number of characters of a file name.
const NAME: usize = 40;

/// The open dialog.
pub(crate) fn dialogs_ui(ctx: &Context, model: &Model, actions: &mut Vec<Action>) {
    let closed = match &model.view.modal {
        Modal::None => return,
        Modal::Path(prompt) => over(ctx, |ui| path_ui(ui, prompt, actions)),
        Modal::Replace(asked) => over(ctx, |ui| replace_ui(ui, asked, actions)),
        Modal::Unsaved(_) => over(ctx, |ui| unsaved_ui(ui, model, actions)),
        Modal::Recover(paths) => over(ctx, |ui| recover_ui(ui, paths, actions)),
        Modal::Large(faces, estimate) => over(ctx, |ui| large_ui(ui, *faces, estimate, actions)),
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
            ui.set_width((ctx.content_rect().width() - 40.0).min(520.0));
            body(ui);
        })
        .should_close()
}

fn path_ui(ui: &mut Ui, prompt: &PathPrompt, actions: &mut Vec<Action>) {
    let title = match prompt.purpose {
        PathUse::Open => "Open a mesh or project",
        PathUse::SaveAs => {
            "Save the mesh (.obj, .ply, .stl, .off, .glb, .gltf, .3mf) or the project (.meniscus)"
        }
        PathUse::ExportPatch => {
            "Export only the patches (.obj, .ply, .stl, .off, .glb, .gltf, .3mf)"
        }
        PathUse::Reference => {
            "Open the reference mesh of distances (.obj, .ply, .stl, .off, .glb, .gltf, .3mf)"
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
            actions.push(FileAction::UsePath(prompt.purpose, path).into());
        }
        ui.button("Cancel").on_click(Action::Escape, actions);
    });
}

fn replace_ui(ui: &mut Ui, asked: &Replacing, actions: &mut Vec<Action>) {
    let name = elided(&file_name(&asked.path), NAME);
    ui.heading(format!("Replace {name}?"));
    ui.label("There is a file with this name. Its content will be lost.");
    ui.horizontal(|ui| {
        ui.add(primary(ui, "Replace"))
            .on_click(asked.writing.clone(), actions);
        ui.button("Cancel").on_click(Action::Escape, actions);
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
            .on_click(FileAction::DiscardAndContinue, actions);
        ui.button("Cancel")
            .on_click(Action::Modal(Modal::None), actions);
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
        let name = elided(&project::title(path), NAME);
        ui.button(format!("Recover {name}, {when}"))
            .on_click(FileAction::Recover(path.clone()), actions);
    }
    ui.horizontal(|ui| {
        ui.button("Keep for later")
            .on_click(Action::Modal(Modal::None), actions);
        ui.button("Delete")
            .on_click(FileAction::DropRecovery, actions);
    });
}

fn large_ui(ui: &mut Ui, faces: u64, estimate: &RefineEstimate, actions: &mut Vec<Action>) {
    ui.heading("This is a large refinement");
    let free = free_memory();
    let left = free.map_or_else(String::new, |free| format!(" {} are free.", in_gib(free)));
    ui.label(format!(
        "The result has about {} million faces. Computing it takes about {}{} and {} of memory.{left} Fewer \
         levels give a smaller result.",
        format_number(faces as f64 / 1e6),
        duration(estimate.seconds),
        if estimate.is_measured {
            ", at the rate of the refinements so far,"
        } else {
            " of processor time"
        },
        in_gib(estimate.bytes as u64),
    ));
    if free.is_some_and(|free| estimate.bytes > free as f64) {
        let color = ui.visuals().warn_fg_color;
        ui.colored_label(color, "The memory will not be enough.");
    }
    ui.horizontal(|ui| {
        ui.add(primary(ui, "Refine"))
            .on_click(RunAction::StartLarge, actions);
        ui.button("Cancel")
            .on_click(Action::Modal(Modal::None), actions);
    });
}

/// A time in words, in two digits.
fn duration(seconds: f64) -> String {
    let (number, unit) = match seconds {
        ..60.0 => (seconds, "second"),
        60.0..3600.0 => (seconds / 60.0, "minute"),
        _ => (seconds / 3600.0, "hour"),
    };
    let digits = if number < 10.0 { 10.0 } else { 1.0 };
    let number = trimmed((digits * number).round() / digits);
    let s = if number == "1" { "" } else { "s" };
    format!("{number} {unit}{s}")
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
    ui.add_space(4.0);
    row(ui, "Content", "", |ui, _| {
        for (kind, title, enabled) in [
            (PictureKind::Still, "one picture", true),
            (PictureKind::Turntable, "turntable", true),
            (PictureKind::Flow, "states of the flow", model.run.is_some()),
        ] {
            let button = egui::Button::selectable(next.kind == kind, title);
            if ui.add_enabled(enabled, button).clicked() {
                next.kind = kind;
            }
        }
    });
    if next.kind == PictureKind::Still {
        next.format = SequenceFormat::Png;
    } else {
        sequence_ui(ui, model, &mut next);
    }
    size_ui(ui, model, &mut next);
    row(ui, "Show", "", |ui, _| {
        ui.vertical(|ui| {
            let is_map = model.view.style.mode.is_map();
            let legend = egui::Checkbox::new(&mut next.legend, "legend");
            ui.add_enabled(is_map, legend)
                .on_hover_text("colours, end values and unit of the colour map")
                .on_disabled_hover_text("the view shows no numbers: choose H, K, k1 or k2");
            if model.sides() > 1 {
                ui.checkbox(&mut next.all_sides, "all sides of the comparison");
            }
            ui.checkbox(&mut next.overlays, "rims, selection and grid");
            ui.checkbox(&mut next.transparent, "transparent background");
        });
    });
    row(
        ui,
        "Caption",
        "a line of text below the surface",
        |ui, label| {
            let field = egui::TextEdit::singleline(&mut next.caption);
            let field = field.hint_text("none").desired_width(f32::INFINITY);
            ui.add(field).labelled_by(label);
        },
    );
    let known = extension(settings);
    if extension(&next) != known && next.path.ends_with(known) {
        let path = std::path::Path::new(&next.path).with_extension(extension(&next));
        next.path = path.display().to_string();
    }
    row(ui, "File", "", |ui, label| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.button("Browse…")
                .on_click(PictureAction::Browse, actions);
            let path = egui::TextEdit::singleline(&mut next.path);
            ui.add(path.desired_width(f32::INFINITY)).labelled_by(label);
        });
    });
    if next.all_sides != settings.all_sides {
        // the sides keep their size
        let (before, after) = (shown_sides(model, settings), shown_sides(model, &next));
        next.width = (next.width * after / before).clamp(1, MAX_SIDE);
    }
    if next != *settings {
        actions.push(Action::Modal(Modal::Picture(next.clone())));
    }
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.add(primary(ui, "Write"))
            .on_click(PictureAction::Make(Box::new(next.clone())), actions);
        ui.add_enabled(
            next.kind == PictureKind::Still,
            egui::Button::new("Copy to the clipboard"),
        )
        .on_click(PictureAction::CopyAs(Box::new(next)), actions);
        ui.button("Cancel")
            .on_click(Action::Modal(Modal::None), actions);
    });
}

/// Number of sides in a picture.
fn shown_sides(model: &Model, settings: &PictureSettings) -> u32 {
    if settings.all_sides {
        model.sides() as u32
    } else {
        1
    }
}

/// Format, number and speed of the pictures of a sequence.
fn sequence_ui(ui: &mut Ui, model: &Model, next: &mut PictureSettings) {
    row(ui, "Format", "", |ui, _| {
        for (format, title) in [
            (SequenceFormat::Png, "numbered PNG"),
            (SequenceFormat::Gif, "GIF"),
            (SequenceFormat::Apng, "APNG"),
        ] {
            ui.selectable_value(&mut next.format, format, title);
        }
    });
    let states = model.run.as_ref().map_or(0, Run::state_count).max(1);
    row(ui, "Pictures", "", |ui, label| {
        let mut count = match (next.kind, next.states) {
            (PictureKind::Flow, 0) => states,
            (PictureKind::Flow, some) => some.min(states),
            _ => next.frames,
        };
        let range = if next.kind == PictureKind::Flow {
            1..=states
        } else {
            2..=2000
        };
        let value = number(&mut count).range(range);
        ui.add(value).labelled_by(label);
        let fps = number(&mut next.fps).range(1.0..=60.0);
        ui.add(fps.suffix(" per second"));
        if next.kind == PictureKind::Flow {
            // all states, also of a run that continues
            next.states = if count == states { 0 } else { count };
            ui.weak(format!("of {states} states"));
        } else {
            next.frames = count;
        }
        ui.weak(format!("{:.1} s", count as f64 / next.fps));
    });
}

fn size_ui(ui: &mut Ui, model: &Model, next: &mut PictureSettings) {
    row(ui, "Size", "", |ui, _| {
        for (name, value) in [("Width", &mut next.width), ("Height", &mut next.height)] {
            let pixels = number(value).range(1..=MAX_SIDE);
            named(ui, name, pixels.suffix(" px"));
        }
        let sides = f64::from(shown_sides(model, next));
        for factor in [1.0, 2.0, 4.0] {
            let [w, h] = model.view.viewport_px.map(|x| x * factor);
            let [w, h] = [(w * sides) as u32, h as u32];
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

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn times_in_words() {
        for (seconds, words) in [
            (1.04, "1 second"),
            (42.4, "42 seconds"),
            (90.0, "1.5 minutes"),
            (3540.0, "59 minutes"),
            (7200.0, "2 hours"),
        ] {
            assert_eq!(duration(seconds), words);
        }
    }
}
