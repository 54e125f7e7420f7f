//! The panels: functions of the model that collect actions.

mod bridge;
mod controls;
mod dialogs;
mod energy;
mod format;
mod legend;
mod menu;
mod navigation;
mod refine;
mod repair;
mod report;
mod side;
mod status;
mod toasts;
mod toolbar;
mod transport;
mod viewport;
mod widgets;
mod windows;

use eframe::egui;

use super::action::{Action, ControlsAction, FileAction, Switch, ViewAction};
use super::model::{MAX_SIDES, Model};
use super::scene_builder::OverlayCache;
use super::shortcuts;
use super::view_state::Modal;
use widgets::Asks;

/// State of the interface that persists from frame to frame.
pub(crate) struct UiState {
    /// Overlays of all viewports.
    pub(crate) overlays: [OverlayCache; MAX_SIDES],
    /// The current drag.
    pub(crate) drag: navigation::Drag,
    /// The rim vertex under the cursor, while a bridge is under construction.
    pub(crate) rim_vertex: Option<crate::mesh::DVec3>,
    /// The current stroke or lasso.
    pub(crate) draft: Option<repair::Draft>,
    /// Range of the shown colour map.
    pub(crate) range: legend::MapRange,
    /// Measured frames.
    pub(crate) frames: windows::FrameStats,
    /// The area of all views in points.
    pub(crate) views: egui::Rect,
    /// The area of the first view in points.
    pub(crate) viewport: egui::Rect,
    /// Whether a slider is being dragged.
    pub(crate) dragging: bool,
    /// Name and size of the graphics adapter, for the diagnostics.
    pub(crate) adapter: String,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            overlays: Default::default(),
            drag: navigation::Drag::default(),
            rim_vertex: None,
            draft: None,
            range: legend::MapRange::default(),
            frames: windows::FrameStats::default(),
            views: egui::Rect::ZERO,
            viewport: egui::Rect::ZERO,
            dragging: false,
            adapter: String::new(),
        }
    }
}

/// The whole window. Returns the requested actions.
pub(crate) fn window_ui(
    ui: &mut egui::Ui,
    model: &Model,
    state: &mut UiState,
    format: Option<wgpu::TextureFormat>,
) -> Vec<Action> {
    let mut actions = Vec::new();
    keys(ui.ctx(), model, &mut actions);
    drops(ui.ctx(), &mut actions);
    egui::Panel::top("menu").show(ui, |ui| menu::menu_ui(ui, model, &mut actions));
    egui::Panel::top("toolbar").show(ui, |ui| {
        let range = state.range.latest().copied();
        toolbar::toolbar_ui(ui, model, range, &mut actions);
    });
    egui::Panel::bottom("status").show(ui, |ui| status::status_ui(ui, model, &mut actions));
    if model.run.is_some() {
        egui::Panel::bottom("transport")
            .resizable(true)
            .default_size(230.0)
            .min_size(140.0)
            .show(ui, |ui| transport::transport_ui(ui, model, &mut actions));
    }
    egui::Panel::left("loops")
        .resizable(true)
        .default_size(270.0)
        .min_size(200.0)
        .show(ui, |ui| side::side_ui(ui, model, &mut actions));
    if model.view.windows.analysis {
        egui::Panel::right("report")
            .resizable(true)
            .default_size(330.0)
            .min_size(300.0)
            .show(ui, |ui| {
                tabs(ui, model, &mut actions);
                report::report_ui(ui, model, &mut actions);
            });
    } else {
        egui::Panel::right("controls")
            .resizable(true)
            .default_size(290.0)
            .min_size(240.0)
            .show(ui, |ui| {
                tabs(ui, model, &mut actions);
                controls::controls_ui(ui, model, &mut actions);
            });
    }
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE)
        .show(ui, |ui| {
            viewport::viewports_ui(ui, model, state, format, &mut actions);
        });
    windows::windows_ui(ui.ctx(), model, state, &mut actions);
    dialogs::dialogs_ui(ui.ctx(), model, &mut actions);
    toasts::toasts_ui(ui.ctx(), model, state.views, &mut actions);

    // releasing a slider ends its undo entry
    let dragging = ui.ctx().dragged_id().is_some();
    if state.dragging && !dragging {
        actions.push(ControlsAction::EndDrag.into());
    }
    state.dragging = dragging;
    actions
}

/// The choice of the right panel.
fn tabs(ui: &mut egui::Ui, model: &Model, actions: &mut Vec<Action>) {
    let switch = Switch::Analysis;
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        for (report, title, tip) in [
            (false, "Controls", "energy, flow and patch"),
            (true, "Report", "measures of the shown surface"),
        ] {
            let open = model.view.windows.analysis == report;
            let title = egui::RichText::new(title).strong();
            let label = ui.selectable_label(open, title);
            let label = label.key_tip(tip, ViewAction::Toggle(switch));
            if !open {
                label.asks(ViewAction::Toggle(switch), actions);
            }
        }
    });
}

/// Colour of errors, readable on the theme's background.
fn error_color(ui: &egui::Ui) -> egui::Color32 {
    if ui.visuals().dark_mode {
        egui::Color32::from_rgb(255, 120, 110)
    } else {
        egui::Color32::from_rgb(185, 25, 25)
    }
}

/// Colour of success.
fn success_color(ui: &egui::Ui) -> egui::Color32 {
    if ui.visuals().dark_mode {
        egui::Color32::from_rgb(95, 190, 115)
    } else {
        egui::Color32::from_rgb(25, 120, 50)
    }
}

fn keys(ctx: &egui::Context, model: &Model, actions: &mut Vec<Action>) {
    let dialog = model.view.modal != Modal::None;
    let pressed = shortcuts::pressed(ctx).into_iter();
    actions.extend(pressed.filter(|action| !dialog || *action == Action::Escape));
}

fn drops(ctx: &egui::Context, actions: &mut Vec<Action>) {
    let dropped = ctx.input(|i| i.raw.dropped_files.clone());
    if let Some(file) = dropped.first() {
        actions.push(FileAction::Open(file.path().to_owned()).into());
    }
}
