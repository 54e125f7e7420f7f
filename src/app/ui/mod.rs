//! The panels: functions of the model that collect actions.

mod controls;
mod dialogs;
mod energy;
mod format;
mod gizmo;
mod icons;
mod legend;
mod menu;
mod navigation;
pub(crate) mod plots;
mod refine;
mod repair;
mod report;
mod rim_tools;
mod samples;
mod side;
mod status;
pub(crate) mod theme;
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
use super::settings::Layout;
use super::shortcuts;
use super::view_state::Modal;
use widgets::ClickActions;

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
    /// Sizes of the panels.
    pub(crate) sizes: Layout,
    /// Whether a slider is being dragged.
    pub(crate) dragging: bool,
    /// Whether a text field has the focus.
    pub(crate) typing: bool,
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
            sizes: Layout::default(),
            dragging: false,
            typing: false,
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
    keys(ui.ctx(), model, state.typing, &mut actions);
    drops(ui.ctx(), &mut actions);
    egui::Panel::top("menu").show(ui, |ui| menu::menu_ui(ui, model, &mut actions));
    egui::Panel::top("toolbar").show(ui, |ui| {
        let range = state.range.latest().copied();
        toolbar::toolbar_ui(ui, model, range, &mut actions);
    });
    egui::Panel::bottom("status").show(ui, |ui| status::status_ui(ui, model, &mut actions));
    panels_ui(ui, model, state, &mut actions);
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE)
        .show(ui, |ui| {
            viewport::viewports_ui(ui, model, state, format, &mut actions);
        });
    windows::windows_ui(ui.ctx(), model, state, &mut actions);
    dialogs::dialogs_ui(ui.ctx(), model, &mut actions);
    toasts::toasts_ui(ui.ctx(), model, state.views, &mut actions);

    settle_hover(model, &mut actions);
    // releasing a slider ends its undo entry
    let dragging = ui.ctx().dragged_id().is_some();
    if state.dragging && !dragging {
        actions.push(ControlsAction::EndDrag.into());
    }
    state.dragging = dragging;
    state.typing = ui.ctx().text_edit_focused();
    actions
}

/// Width of the window below which side panels are narrow by default.
const NARROW: f32 = 1100.0;

/// A panel at a side, which can be resized and closed. Its width is `chosen`, or the default, as far as it
/// is between the least and the greatest one: only a drag of its edge changes the choice, not what it
/// contains or a small window. `widths` are the least, the default and the greatest one.
fn side_panel(
    ui: &mut egui::Ui,
    panel: fn(&'static str) -> egui::Panel,
    name: &'static str,
    widths: [f32; 3],
    chosen: &mut Option<f32>,
    is_open: &mut bool,
    content: impl FnOnce(&mut egui::Ui),
) {
    let [least, default, greatest] = widths;
    let fitting = chosen.unwrap_or(default).clamp(least, greatest);
    let fitting = fitting.min(ui.available_width());
    // egui keeps the width that the panel last had, which a small window or wide content may have changed
    let id = ui.scope_id().with_salt(egui::IdSalt::new(name));
    let outer_rect = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(fitting, 0.0));
    let state = egui::PanelState { outer_rect };
    ui.data_mut(|data| data.insert_persisted(id, state));
    let shown = panel(name)
        .resizable(true)
        .size_range(least..=greatest)
        .show_collapsible(ui, is_open, |ui| {
            let area = ui.available_rect_before_wrap();
            // does not report its size, so that the panel does not grow with it
            content(&mut ui.new_child(egui::UiBuilder::new().max_rect(area)));
            ui.advance_cursor_after_rect(area);
        });
    let width = shown.map_or(fitting, |shown| shown.response.rect.width());
    // a drag may still close the panel, which then keeps its width
    if *is_open && ui.ctx().dragged_id().is_none() && (width - fitting).abs() > 0.1 {
        *chosen = Some(width);
    }
}

/// The panels around the views. Each can be resized and closed.
fn panels_ui(ui: &mut egui::Ui, model: &Model, state: &mut UiState, actions: &mut Vec<Action>) {
    let window = ui.ctx().content_rect();
    let layout = &model.settings.layout;
    if let Some(run) = &model.run {
        let details = layout.shows_details(window.height());
        let panel = if details {
            egui::Panel::bottom("details")
                .resizable(true)
                .default_size(layout.bottom_height.unwrap_or(210.0))
                .min_size(130.0)
                .max_size(0.5 * window.height())
        } else {
            egui::Panel::bottom("transport")
        };
        let shown = panel.show(ui, |ui| {
            transport::transport_ui(ui, model, run, details, actions);
        });
        if details {
            state.sizes.bottom_height = Some(shown.response.rect.height());
        }
    }
    let [left, right] = if window.width() < NARROW {
        [244.0, 260.0]
    } else {
        [270.0, 290.0]
    };
    let sizes = &mut state.sizes;
    sizes.left_width = sizes.left_width.or(layout.left_width);
    sizes.right_width = sizes.right_width.or(layout.right_width);
    let mut open = layout.left;
    side_panel(
        ui,
        egui::Panel::left,
        "left",
        [220.0, left, (0.28 * window.width()).max(244.0)],
        &mut sizes.left_width,
        &mut open,
        |ui| side::side_ui(ui, model, actions),
    );
    if open != layout.left {
        actions.push(ViewAction::Toggle(Switch::LeftPanel).into());
    }
    let mut open = layout.right;
    side_panel(
        ui,
        egui::Panel::right,
        "right",
        [250.0, right, (0.4 * window.width()).max(260.0)],
        &mut sizes.right_width,
        &mut open,
        |ui| {
            tabs(ui, model, actions);
            if model.view.windows.analysis {
                report::report_ui(ui, model, actions);
            } else {
                controls::controls_ui(ui, model, actions);
            }
        },
    );
    if open != layout.right {
        actions.push(ViewAction::Toggle(Switch::RightPanel).into());
    }
}

/// The view and the lists request the loops under the cursor in every frame. Keeps that request only
/// if it is new, and clears the loops if there is none.
fn settle_hover(model: &Model, actions: &mut Vec<Action>) {
    let mut hovered = Vec::new();
    actions.retain(|action| match action {
        Action::View(ViewAction::Hover(loops)) => {
            hovered.clone_from(loops);
            false
        }
        _ => true,
    });
    if hovered != model.view.hover {
        actions.push(ViewAction::Hover(hovered).into());
    }
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
                label.on_click(ViewAction::Toggle(switch), actions);
            }
        }
    });
}

fn keys(ctx: &egui::Context, model: &Model, was_typing: bool, actions: &mut Vec<Action>) {
    let dialog = model.view.modal != Modal::None;
    let pressed = shortcuts::pressed(ctx, was_typing).into_iter();
    actions.extend(pressed.filter(|action| !dialog || *action == Action::Escape));
}

fn drops(ctx: &egui::Context, actions: &mut Vec<Action>) {
    let dropped = ctx.input(|i| i.raw.dropped_files.clone());
    if let Some(file) = dropped.first() {
        actions.push(FileAction::Open(file.path().to_owned()).into());
    }
}
