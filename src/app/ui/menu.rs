//! The menu bar.

use eframe::egui::{self, Button, Ui};

use crate::app::action::{Action, Switch};
use crate::app::model::Model;
use crate::app::report::{Across, Pick, ReportAction};
use crate::app::shortcuts::{Command, ROWS};
use crate::app::view_state::{Modal, Navigation};
use crate::render::StandardView;
use crate::shapes::SAMPLES;

/// An entry with its key.
fn entry(ui: &mut Ui, text: &str, command: Option<Command>) -> bool {
    let mut button = Button::new(text);
    if let Some((_, [key, ..], _)) = ROWS.iter().find(|(c, ..)| Some(*c) == command) {
        button = button.shortcut_text(ui.ctx().format_shortcut(key));
    }
    let clicked = ui.add(button).clicked();
    if clicked {
        ui.close();
    }
    clicked
}

/// Menus of the whole window.
pub fn menu_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file_ui(ui, model, actions));
        ui.menu_button("Edit", |ui| edit_ui(ui, model, actions));
        ui.menu_button("Select", |ui| {
            for (text, command, action) in [
                ("All holes", Command::SelectAll, Action::SelectAll),
                (
                    "All but the largest",
                    Command::SelectAllButLargest,
                    Action::SelectAllButLargest,
                ),
                ("None", Command::Escape, Action::SelectNone),
            ] {
                if entry(ui, text, Some(command)) {
                    actions.push(action);
                }
            }
        });
        ui.menu_button("View", |ui| view_ui(ui, model, actions));
        ui.menu_button("Analyze", |ui| analyze_ui(ui, model, actions));
        ui.menu_button("Picture", |ui| picture_ui(ui, model, actions));
        ui.menu_button("Samples", |ui| {
            for sample in &SAMPLES {
                if ui
                    .button(sample.title)
                    .on_hover_text(sample.about)
                    .clicked()
                {
                    actions.push(Action::Sample(sample.name.into()));
                    ui.close();
                }
            }
        });
        ui.menu_button("Help", |ui| {
            for (text, switch) in [
                ("Keys and mouse", Switch::Help),
                ("Load report", Switch::Report),
                ("Log", Switch::Log),
                ("Frame times and memory", Switch::Diagnostics),
            ] {
                if entry(ui, text, Some(Command::Toggle(switch))) {
                    actions.push(Action::Toggle(switch));
                }
            }
            ui.separator();
            ui.label(concat!("Meniscus ", env!("CARGO_PKG_VERSION")));
        });
    });
}

fn file_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    if entry(ui, "Open…", Some(Command::Open)) {
        actions.push(Action::AskOpen);
    }
    ui.menu_button("Open recent", |ui| {
        if model.settings.recent.is_empty() {
            ui.weak("nothing opened yet");
        }
        for path in &model.settings.recent {
            let name = path.file_name().map_or_else(
                || path.display().to_string(),
                |n| n.to_string_lossy().into_owned(),
            );
            if ui
                .button(name)
                .on_hover_text(path.display().to_string())
                .clicked()
            {
                actions.push(Action::Open(path.clone()));
                ui.close();
            }
        }
    });
    ui.separator();
    for (text, command, action) in [
        ("Save", Some(Command::Save), Action::Save),
        ("Save as…", Some(Command::SaveAs), Action::AskSaveAs),
        ("Export the patches alone…", None, Action::AskExportPatch),
        (
            "Copy as command line",
            Some(Command::CopyLine),
            Action::CopyCommand,
        ),
    ] {
        if entry(ui, text, command) {
            actions.push(action);
        }
    }
    ui.separator();
    if entry(ui, "Settings…", None) {
        actions.push(Action::Toggle(Switch::Settings));
    }
    if entry(ui, "Quit", Some(Command::Quit)) {
        actions.push(Action::Close);
    }
}

fn edit_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let undo = match model.history.next_undo() {
        Some(label) => format!("Undo {label}"),
        None => "Undo".into(),
    };
    let redo = match model.history.next_redo() {
        Some(label) => format!("Redo {label}"),
        None => "Redo".into(),
    };
    if entry(ui, &undo, Some(Command::Undo)) {
        actions.push(Action::Undo);
    }
    if entry(ui, &redo, Some(Command::Redo)) {
        actions.push(Action::Redo);
    }
}

fn view_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    if entry(ui, "Fit everything", Some(Command::Fit)) {
        actions.push(Action::FitAll);
    }
    for view in StandardView::ALL {
        let name = view.name();
        let title = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
        if entry(ui, &title, Some(Command::View(view))) {
            let mut camera = model.view.camera;
            camera.standard_view(view);
            actions.push(Action::Camera(camera));
        }
    }
    ui.separator();
    let view = &model.view;
    for (text, switch, mut on) in [
        (
            "Parallel projection",
            Switch::Projection,
            view.camera.orthographic,
        ),
        ("Z is up", Switch::ZUp, view.camera.z_up),
        ("Limit surface", Switch::LimitSurface, view.limit_surface),
        ("Opened mesh", Switch::Original, view.show_original),
        ("Rims", Switch::Rims, view.show_rims),
        ("Wireframe", Switch::Wireframe, view.style.wireframe),
        ("Tint the patch", Switch::Tint, view.style.tint_patch),
    ] {
        if ui.checkbox(&mut on, text).clicked() {
            actions.push(Action::Toggle(switch));
        }
    }
    ui.separator();
    ui.menu_button("Mouse", |ui| navigation_ui(ui, model, actions));
}

/// Choice of navigation presets.
pub fn navigation_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    for navigation in Navigation::ALL {
        let chosen = model.settings.navigation == navigation;
        if ui
            .radio(chosen, navigation.title())
            .on_hover_text(navigation.about())
            .clicked()
        {
            actions.push(Action::Navigation(navigation));
        }
    }
}

fn analyze_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let open = Switch::Analysis;
    let view = &model.view.report;
    let mut choose = |action: ReportAction| {
        if !model.view.windows.analysis {
            actions.push(Action::Toggle(open));
        }
        actions.push(Action::Report(action));
    };
    if entry(ui, "Measure across edges", None) {
        choose(ReportAction::Pick(Pick::Edges));
    }
    ui.menu_button("Section through a point", |ui| {
        for (across, title) in [
            (Across::Axis(0), "Across x"),
            (Across::Axis(1), "Across y"),
            (Across::Axis(2), "Across z"),
            (Across::View, "Along the view"),
        ] {
            if entry(ui, title, None) {
                choose(ReportAction::Pick(Pick::Section(across)));
            }
        }
    });
    if entry(ui, "Distance to a mesh…", None) {
        choose(ReportAction::AskReference);
    }
    if view.cut.is_some() && entry(ui, "Remove the section", None) {
        choose(ReportAction::DropCut);
    }
    ui.separator();
    if entry(ui, "Report", Some(Command::Toggle(open))) {
        actions.push(Action::Toggle(open));
    }
}

fn picture_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    if entry(ui, "Picture or sequence…", Some(Command::Picture)) {
        let settings = super::picture_settings(model);
        actions.push(Action::Modal(Modal::Picture(settings)));
    }
    if entry(ui, "Copy picture", Some(Command::CopyPicture)) {
        actions.push(Action::CopyPicture);
    }
    if entry(ui, "Picture of the whole window", None) {
        actions.push(Action::WindowPicture);
    }
}
