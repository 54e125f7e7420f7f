//! The panels: functions of the model that collect actions.

mod bridge;
mod controls;
mod dialogs;
mod energy;
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
mod windows;

use eframe::egui;

use super::action::{Action, Switch};
use super::model::{MOST_SIDES, Model};
use super::scene_builder::OverlayCache;
use super::shortcuts::{self, Command};
use super::view_state::{Modal, PictureSettings};
use crate::render::ViewMode;

/// What the interface keeps from frame to frame that is nobody else's business.
pub struct UiState {
    /// Overlays of all viewports.
    pub overlays: [OverlayCache; MOST_SIDES],
    /// The drag that is under way.
    pub drag: navigation::Drag,
    /// The rim vertex under the cursor, while a bridge is made.
    pub rim_vertex: Option<crate::mesh::DVec3>,
    /// The stroke or lasso that is under way.
    pub draft: Option<repair::Draft>,
    /// Range of the colour map that is shown.
    pub range: legend::KnownRange,
    /// Measured frames.
    pub frames: windows::FrameStats,
    /// Where all views are, in points.
    pub views: egui::Rect,
    /// Where the first view is, in points.
    pub viewport: egui::Rect,
    /// Whether a slider is being dragged.
    pub dragging: bool,
    /// Name and size of the graphics adapter, for the diagnostics.
    pub adapter: String,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            overlays: Default::default(),
            drag: navigation::Drag::default(),
            rim_vertex: None,
            draft: None,
            range: None,
            frames: windows::FrameStats::default(),
            views: egui::Rect::ZERO,
            viewport: egui::Rect::ZERO,
            dragging: false,
            adapter: String::new(),
        }
    }
}

/// The whole window. Returns what was asked for.
pub fn window_ui(
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
        let range = state.range.as_ref().map(|r| r.2);
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

    // a slider let go ends its undo entry
    let dragging = ui.ctx().dragged_id().is_some();
    if state.dragging && !dragging {
        actions.push(Action::Settle);
    }
    state.dragging = dragging;
    actions
}

/// What the right panel shows.
fn tabs(ui: &mut egui::Ui, model: &Model, actions: &mut Vec<Action>) {
    let switch = Switch::Analysis;
    let key = shortcuts::hint(ui.ctx(), Command::Toggle(switch));
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        for (report, title, tip) in [
            (false, "Controls", "energy, flow and patch"),
            (true, "Report", "measures of the surface that is shown"),
        ] {
            let open = model.view.windows.analysis == report;
            let title = egui::RichText::new(title).strong();
            if ui
                .selectable_label(open, title)
                .on_hover_text(format!("{tip}{key}"))
                .clicked()
                && !open
            {
                actions.push(Action::Toggle(switch));
            }
        }
    });
}

/// Colour of errors, readable on the theme's ground.
fn bad(ui: &egui::Ui) -> egui::Color32 {
    if ui.visuals().dark_mode {
        egui::Color32::from_rgb(255, 120, 110)
    } else {
        egui::Color32::from_rgb(185, 25, 25)
    }
}

/// Colour of what went well.
fn good(ui: &egui::Ui) -> egui::Color32 {
    if ui.visuals().dark_mode {
        egui::Color32::from_rgb(95, 190, 115)
    } else {
        egui::Color32::from_rgb(25, 120, 50)
    }
}

fn keys(ctx: &egui::Context, model: &Model, actions: &mut Vec<Action>) {
    let modal = model.view.modal != Modal::None;
    for command in shortcuts::pressed(ctx) {
        if modal && command != Command::Escape {
            continue;
        }
        if let Some(action) = action_of(command, model) {
            actions.push(action);
        }
    }
}

/// What a command means now.
fn action_of(command: Command, model: &Model) -> Option<Action> {
    let view = &model.view;
    Some(match command {
        Command::Fill => match &model.run {
            Some(run) if run.ended() => Action::Accept(0),
            Some(_) => return None,
            None => Action::Fill,
        },
        Command::StepBack => {
            let run = model.run.as_ref()?;
            let last = run.state_count().saturating_sub(1);
            let at = run
                .sides
                .iter()
                .filter_map(|s| s.shown)
                .min()
                .unwrap_or(last);
            Action::Scrub(Some(at.saturating_sub(1)))
        }
        Command::View(standard) => {
            let mut camera = view.camera;
            camera.standard_view(standard);
            Action::Camera(camera)
        }
        Command::NextMode(on) => {
            let all: Vec<ViewMode> = toolbar::modes(model).collect();
            let at = all.iter().position(|m| *m == view.style.mode).unwrap_or(0);
            let next = (at + if on { 1 } else { all.len() - 1 }) % all.len();
            Action::Style(toolbar::in_mode(view.style, all[next]))
        }
        Command::Stripes(more) => {
            let mut style = view.style;
            style.stripes = if more {
                (style.stripes + 2).min(60)
            } else {
                style.stripes.saturating_sub(2).max(2)
            };
            Action::Style(style)
        }
        Command::Picture => Action::Modal(Modal::Picture(picture_settings(model))),
        _ => return command.action(),
    })
}

/// Settings the picture dialog opens with.
fn picture_settings(model: &Model) -> PictureSettings {
    let [width, height] = model.view.viewport_px;
    let path = model
        .source_path()
        .unwrap_or_else(|| "meniscus.obj".into())
        .with_extension("png");
    PictureSettings {
        width: (width as u32).clamp(1, crate::render::MAX_SIDE),
        height: (height as u32).clamp(1, crate::render::MAX_SIDE),
        path: path.display().to_string(),
        ..PictureSettings::default()
    }
}

fn drops(ctx: &egui::Context, actions: &mut Vec<Action>) {
    let dropped = ctx.input(|i| i.raw.dropped_files.clone());
    if let Some(file) = dropped.first() {
        actions.push(Action::Open(file.path().to_owned()));
    }
}
