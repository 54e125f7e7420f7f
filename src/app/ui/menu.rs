//! The menu bar.

use eframe::egui::menu::MenuState;
use eframe::egui::{self, Button, FocusDirection, Key, Popup, Response, Ui, Vec2};

use super::icons::{Icon, icon_button};
use super::samples::samples_ui;
use super::widgets::ClickActions;
use crate::app::action::{
    Action, EditAction, FileAction, PictureAction, SelectAction, Switch, ViewAction,
};
use crate::app::document::{elided, file_name};
use crate::app::model::Model;
use crate::app::report::{Across, Pick, ReportAction};
use crate::app::shortcuts::{key_text, pressed_with_alt};
use crate::app::view_state::{Modal, Navigation};
use crate::options::Choice;
use crate::render::StandardView;

/// Maximum number of characters of a file name in a menu.
const NAME: usize = 44;

/// A menu entry with its key.
fn entry(ui: &mut Ui, text: &str, action: impl Into<Action>, actions: &mut Vec<Action>) {
    let action = action.into();
    if entry_with_key_of(ui, text, &action) {
        actions.push(action);
    }
}

/// A menu entry that shows the key of an action. Returns whether it was clicked.
fn entry_with_key_of(ui: &mut Ui, text: &str, action: &Action) -> bool {
    let mut button = Button::new(text);
    if let Some(key) = key_text(ui.ctx(), action) {
        button = button.shortcut_text(key);
    }
    let clicked = ui.add(button).clicked();
    if clicked {
        ui.close();
    }
    clicked
}

/// The menu bar.
pub(crate) fn menu_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    egui::MenuBar::new().ui(ui, |ui| {
        let menus = [
            bar_menu(ui, "File", |ui| file_ui(ui, model, actions)),
            bar_menu(ui, "Edit", |ui| edit_ui(ui, model, actions)),
            bar_menu(ui, "Select", |ui| select_ui(ui, actions)),
            bar_menu(ui, "View", |ui| view_ui(ui, model, actions)),
            bar_menu(ui, "Analyze", |ui| analyze_ui(ui, model, actions)),
            bar_menu(ui, "Picture", |ui| picture_ui(ui, actions)),
            bar_menu(ui, "Samples", |ui| samples_ui(ui, actions)),
            bar_menu(ui, "Help", |ui| help_ui(ui, actions)),
        ];
        let first = menu_key(ui.ctx());
        if model.view.modal == Modal::None {
            open_menu(ui.ctx(), &menus, first);
        }
        panels_ui(ui, model, actions);
    });
}

/// A menu of the bar.
struct BarMenu {
    title: &'static str,
    button: Response,
    /// How many menus an arrow key leads to the right; `None` if this one is closed.
    step: Option<isize>,
}

fn bar_menu(ui: &mut Ui, title: &'static str, content: impl FnOnce(&mut Ui)) -> BarMenu {
    let button = ui.button(title);
    let shown = Popup::menu(&button).show(|ui| {
        content(ui);
        let step = ui.input(|i| {
            isize::from(i.key_pressed(Key::ArrowRight)) - isize::from(i.key_pressed(Key::ArrowLeft))
        });
        // in a submenu the keys lead into it and out of it
        if step == 0 || MenuState::from_ui(ui, |state, _| state.open_item.is_some()) {
            return 0;
        }
        ui.memory_mut(|memory| memory.move_focus(FocusDirection::None));
        step
    });
    BarMenu {
        title,
        button,
        step: shown.map(|shown| shown.inner),
    }
}

/// Opens the menu that a key or the pointer chooses; `first` is whether a key chooses the first one.
fn open_menu(ctx: &egui::Context, menus: &[BarMenu], first: bool) {
    let count = menus.len();
    let open = menus.iter().position(|menu| menu.step.is_some());
    let step = open.and_then(|at| menus[at].step).filter(|step| *step != 0);
    let beside = open.zip(step);
    let beside = beside.map(|(at, step)| (at + count).saturating_add_signed(step) % count);
    let is_letter = |menu: &BarMenu| {
        let letter = Key::from_name(&menu.title[..1]);
        letter.is_some_and(|key| ctx.input(|i| pressed_with_alt(i, key)))
    };
    let is_typing = ctx.text_edit_focused();
    let named = menus.iter().position(|menu| !is_typing && is_letter(menu));
    let by_key = beside.or(named).or(first.then_some(0));
    // a pointer at rest does not take back what a key has opened
    let points = open.is_some() && ctx.input(|i| i.pointer.delta() != Vec2::ZERO);
    let pointed = menus
        .iter()
        .position(|menu| points && menu.button.hovered());
    let Some(at) = by_key.or(pointed).filter(|at| Some(*at) != open) else {
        return;
    };
    let button = &menus[at].button;
    if by_key.is_some() {
        button.request_focus();
    }
    Popup::open_id(ctx, Popup::default_response_id(button));
    // the next frame shows the menu
    ctx.request_repaint();
}

/// Buttons that open and close panels, at the right end.
fn panels_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let layout = &model.settings.layout;
    let details = layout.shows_details(model.view.window[1]);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for (icon, name, switch, on) in [
            (
                Icon::RightPanel,
                "Right panel",
                Switch::RightPanel,
                layout.right,
            ),
            (Icon::BottomPanel, "Bottom panel", Switch::Details, details),
            (
                Icon::LeftPanel,
                "Left panel",
                Switch::LeftPanel,
                layout.left,
            ),
        ] {
            icon_button(ui, icon, name, on).on_click_with_key(
                name,
                ViewAction::Toggle(switch),
                actions,
            );
        }
    });
}

/// Whether F10 was pressed, or Alt was pressed and released without another key.
fn menu_key(ctx: &egui::Context) -> bool {
    use egui::Event;
    // whether Alt was down, and alone
    let id = egui::Id::unique("alt");
    let (was_down, was_alone) = ctx.data(|data| data.get_temp(id).unwrap_or((false, false)));
    let (f10, down, others) = ctx.input(|i| {
        let is_other = |event: &Event| match event {
            Event::Key { key, .. } => !matches!(key, Key::AltLeft | Key::AltRight),
            Event::PointerButton { .. } | Event::MouseWheel { .. } => true,
            _ => false,
        };
        let others = i.events.iter().any(is_other) || i.pointer.any_down();
        (i.key_pressed(Key::F10), i.modifiers.alt, others)
    });
    let alone = !others && (was_alone || !was_down);
    ctx.data_mut(|data| data.insert_temp(id, (down, down && alone)));
    f10 || (was_down && !down && was_alone && !others)
}

fn file_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    entry(ui, "Open…", FileAction::AskOpen, actions);
    ui.menu_button("Open recent", |ui| {
        if model.settings.recent.is_empty() {
            ui.weak("no recent files");
        }
        for path in &model.settings.recent {
            if ui
                .button(elided(&file_name(path), NAME))
                .on_hover_text(path.display().to_string())
                .clicked()
            {
                actions.push(FileAction::Open(path.clone()).into());
                ui.close();
            }
        }
    });
    ui.separator();
    for (text, action) in [
        ("Save", FileAction::Save),
        ("Save as…", FileAction::AskSaveAs),
        ("Export only the patches…", FileAction::AskExportPatch),
        ("Copy as command line", FileAction::CopyCommand),
    ] {
        entry(ui, text, action, actions);
    }
    ui.separator();
    entry(
        ui,
        "Settings…",
        ViewAction::Toggle(Switch::Settings),
        actions,
    );
    entry(ui, "Quit", FileAction::Close, actions);
}

fn select_ui(ui: &mut Ui, actions: &mut Vec<Action>) {
    entry(ui, "All holes", SelectAction::All, actions);
    entry(
        ui,
        "All but the largest",
        SelectAction::AllButLargest,
        actions,
    );
    if entry_with_key_of(ui, "None", &Action::Escape) {
        actions.push(SelectAction::None.into());
    }
}

fn picture_ui(ui: &mut Ui, actions: &mut Vec<Action>) {
    entry(ui, "Picture or sequence…", PictureAction::Ask, actions);
    entry(ui, "Copy picture", PictureAction::Copy, actions);
    entry(
        ui,
        "Picture of the whole window",
        PictureAction::Window,
        actions,
    );
}

fn help_ui(ui: &mut Ui, actions: &mut Vec<Action>) {
    for (text, switch) in [
        ("Keys and mouse", Switch::Help),
        ("Load report", Switch::Report),
        ("Log", Switch::Log),
        ("Frame times and memory", Switch::Diagnostics),
    ] {
        entry(ui, text, ViewAction::Toggle(switch), actions);
    }
    ui.separator();
    ui.label(concat!("Meniscus ", env!("CARGO_PKG_VERSION")));
}

fn edit_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let undo = match model.next_undo() {
        Some(label) => format!("Undo: {label}"),
        None => "Undo".into(),
    };
    let redo = match model.history.next_redo() {
        Some(label) => format!("Redo: {label}"),
        None => "Redo".into(),
    };
    entry(ui, &undo, EditAction::Undo, actions);
    entry(ui, &redo, EditAction::Redo, actions);
}

fn view_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    entry(ui, "Fit everything", ViewAction::FitAll, actions);
    for &view in StandardView::ALL {
        let name = view.name();
        let title = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
        entry(ui, &title, ViewAction::Standard(view), actions);
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
        ("Left panel", Switch::LeftPanel, model.settings.layout.left),
        (
            "Right panel",
            Switch::RightPanel,
            model.settings.layout.right,
        ),
        ("Limit surface", Switch::LimitSurface, view.limit_surface),
        ("Original mesh", Switch::Original, view.show_original),
        ("Rims", Switch::Rims, view.show_rims),
        ("Grid on the ground", Switch::Grid, model.settings.grid),
        ("Wireframe", Switch::Wireframe, view.style.wireframe),
        ("Tint the patch", Switch::Tint, view.style.tint_patch),
    ] {
        ui.checkbox(&mut on, text)
            .on_click(ViewAction::Toggle(switch), actions);
    }
    ui.separator();
    ui.menu_button("Mouse", |ui| navigation_ui(ui, model, actions));
}

/// Choice of navigation presets.
pub(crate) fn navigation_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    for navigation in Navigation::ALL {
        let chosen = model.settings.navigation == navigation;
        ui.radio(chosen, navigation.title())
            .on_hover_text(navigation.about())
            .on_click(ViewAction::Navigation(navigation), actions);
    }
}

fn analyze_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let mut chosen = Vec::new();
    let pick = |pick| ReportAction::Pick(pick);
    entry(ui, "Measure across edges", pick(Pick::Edges), &mut chosen);
    ui.menu_button("Section through a point", |ui| {
        for (across, title) in [
            (Across::Axis(0), "Across x"),
            (Across::Axis(1), "Across y"),
            (Across::Axis(2), "Across z"),
            (Across::View, "Along the view"),
        ] {
            entry(ui, title, pick(Pick::Section(across)), &mut chosen);
        }
    });
    entry(
        ui,
        "Distance to a mesh…",
        ReportAction::AskReference,
        &mut chosen,
    );
    if model.view.report.cut.is_some() {
        let mut hidden = model.view.report.hide_front;
        ui.checkbox(&mut hidden, "Hide the half in front")
            .on_click(ReportAction::HideFront(hidden), actions);
        entry(ui, "Remove the section", ReportAction::DropCut, &mut chosen);
    }
    let show_report = ViewAction::Toggle(Switch::Analysis);
    if !chosen.is_empty() && !model.view.windows.analysis {
        actions.push(show_report.clone().into());
    }
    actions.append(&mut chosen);
    ui.separator();
    entry(ui, "Report", show_report, actions);
}
