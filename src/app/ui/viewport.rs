//! The view of the surface: drawing, picking, the camera, the legend.

use std::sync::Arc;

use eframe::egui::{self, Align2, Color32, FontId, PointerButton, Pos2, Rect, Sense, Ui};

use super::UiState;
use super::format::format_number;
use super::gizmo::{GIZMO, gizmo_ui, scale_bar};
use super::legend::{WIDTH, legend, legend_place, shared_range};
use super::navigation::{CLICK, navigate};
use super::repair;
use super::side::how;
use super::theme;
use super::widgets::{ClickActions, primary};
use crate::app::action::{
    Action, ControlsAction, EditAction, RunAction, SelectAction, SelectHow, TaskAction, ViewAction,
};
use crate::app::document::elided;
use crate::app::model::Model;
use crate::app::report::Pick;
use crate::app::run::Run;
use crate::app::scene_builder;
use crate::app::view_state::{Bridging, Task, Tool};
use crate::mesh::DVec3;
use crate::render::{
    Camera, MAX_SIDE, Projector, Scene, ViewportCallback, point_on_line, value_on_line,
};

/// The message about a surface that grows without bound.
const DIVERGED: &str = "The surface grows without bound under this energy. The run was paused at \
                            the last sensible shape.";

/// Minimum distance of the eye from the point towards which the camera zooms, as a fraction of the radius of the
/// mesh. There a pixel is not finer than the drawn positions.
const NEAREST: f64 = 2e-4;

/// Maximum distance of the cursor from a picked rim, in points.
const REACH: f32 = 9.0;

/// The views, side by side in a comparison.
pub(crate) fn viewports_ui(
    ui: &mut Ui,
    model: &Model,
    state: &mut UiState,
    format: Option<wgpu::TextureFormat>,
    actions: &mut Vec<Action>,
) {
    let whole = ui.available_rect_before_wrap();
    state.views = whole;
    let sides = model.sides();
    for side in 0..sides {
        let mut rect = whole;
        if sides > 1 {
            let width = whole.width() / sides as f32;
            rect.min.x = whole.left() + width * side as f32;
            rect.max.x = rect.min.x + width - if side + 1 < sides { 1.0 } else { 0.0 };
        }
        let range = map_range(model, state);
        let mut below = viewport_ui(ui, model, state, format, side, rect, range, actions);
        if let Some(run) = model.run.as_ref() {
            let rect = beside_legend(model, side, rect);
            if run.diverged() {
                if side == 0 {
                    below = Some(diverged_ui(ui, run, rect, actions));
                }
            } else if run.ended() {
                below = decide_ui(ui, run, side, rect, actions);
            } else if let Some(words) = run.progress().filter(|_| side == 0) {
                let at = rect.center_bottom() - egui::vec2(0.0, 16.0);
                below = Some(text(ui, rect, at, Align2::CENTER_BOTTOM, &words, 14.0));
            }
        }
        // one legend for all sides, which have the same range
        let place = range.filter(|_| side + 1 == sides);
        let place = place.and_then(|_| legend_place(rect, below));
        if let (Some(range), Some(place)) = (range, place) {
            legend(ui, place, model.view.style.mode, range);
        }
        if side == 0 {
            let mut corner = rect;
            // below the title
            if sides > 1 {
                corner.min.y += 24.0;
            }
            // beside the legend in a low view
            if let Some(place) = place.filter(|place| place.top() < corner.top() + GIZMO) {
                corner.max.x = place.left();
            }
            gizmo_ui(ui, model, corner, actions);
            scale_bar(ui, model, rect, below);
        }
        hatching_ui(ui, model, side, rect);
        if let Some(run) = model.run.as_ref().filter(|r| r.sides.len() > 1) {
            badge_ui(ui, &run.title(side), side, rect);
        }
    }
    ui.advance_cursor_after_rect(whole);
}

/// What the hatching in a view means, if there is some.
fn hatching_ui(ui: &Ui, model: &Model, side: usize, rect: Rect) {
    let scan = model.displays[side].latest().and_then(|d| d.posed);
    let is_hatched = scan.is_some_and(|scan| scan.ill_posed + scan.undefined > 0);
    if is_hatched && model.view.style.show_ill_posed {
        // below the title of a side
        let at = rect.left_top() + egui::vec2(10.0, 34.0);
        let words = "Hatched: the flow of this energy is ill-posed there.";
        text(ui, rect, at, Align2::LEFT_TOP, words, 14.0);
    }
}

/// Width of a letter of a title, at most on average.
const LETTER: f32 = 8.5;

/// The title of a side in the upper left corner of its view, with a bar in the colour of its curves.
fn badge_ui(ui: &Ui, title: &str, side: usize, rect: Rect) {
    let at = rect.left_top() + egui::vec2(20.0, 8.0);
    // in one line, like the titles of the other sides
    let most = ((rect.width() - 40.0) / LETTER).max(4.0) as usize;
    let title = elided(title, most);
    let words = text(ui, rect, at, Align2::LEFT_TOP, &title, 15.0);
    let bar = Rect::from_min_max(
        words.left_top() + egui::vec2(-10.0, -2.0),
        words.left_bottom() + egui::vec2(-5.0, 2.0),
    );
    ui.painter().rect_filled(bar, 2.0, theme::series(ui, side));
}

/// What to do about a surface that grows without bound. Returns its place.
fn diverged_ui(ui: &mut Ui, run: &Run, rect: Rect, actions: &mut Vec<Action>) -> Rect {
    let width = (rect.width() - 24.0).min(430.0);
    let place = Rect::from_center_size(
        rect.center_bottom() - egui::vec2(0.0, 62.0),
        egui::vec2(width, 90.0),
    );
    let builder = egui::UiBuilder::new().max_rect(place);
    ui.scope_builder(builder, |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(width - 16.0);
            ui.label(DIVERGED);
            ui.horizontal_wrapped(|ui| {
                // compared sides keep their energies
                if run.sides.len() == 1
                    && ui
                        .add(primary(ui, "Continue with H^2"))
                        .on_hover_text("go on from the shown shape with the Willmore energy")
                        .clicked()
                {
                    actions.push(ControlsAction::EnergyText("H^2".into()).into());
                    actions.push(ControlsAction::ApplyEnergy.into());
                    actions.push(RunAction::ContinueFromShown.into());
                }
                ui.button("Back to the start")
                    .on_hover_text("show the first shape; choose another energy on the right")
                    .on_click(RunAction::Scrub(Some(0)), actions);
                ui.button("Reject")
                    .on_hover_text("discard the patch; the mesh is unchanged")
                    .on_click(RunAction::Reject, actions);
            });
        });
    });
    place
}

/// The buttons that end a finished run, with their keys. A rejection rejects all sides. Returns their
/// place; `None` in a view that is too narrow for them, beside which the panel of the task has them.
fn decide_ui(
    ui: &mut Ui,
    run: &Run,
    side: usize,
    rect: Rect,
    actions: &mut Vec<Action>,
) -> Option<Rect> {
    let first = side == 0;
    let name = run.names()[side];
    let key = if first { "(Enter)" } else { "" };
    let words = format!("Accept {name} {key}");
    let words: Vec<&str> = words.split_whitespace().collect();
    let room = rect.width() - 16.0;
    let accept = egui::vec2(132.0, 30.0);
    let reject = egui::vec2(100.0, 30.0);
    if room < accept.x {
        return None;
    }
    // in one row, or above each other in a narrow view
    let row = accept.x + 16.0 + reject.x;
    let is_row = first && row <= room;
    let width = if is_row { row } else { accept.x };
    let rows = if first && !is_row { 2.0 } else { 1.0 };
    let height = rows * accept.y + (rows - 1.0) * 6.0;
    let left = rect.center_bottom() - egui::vec2(0.5 * width, 14.0 + height);
    let button = primary(ui, &words.join(" "));
    let place = Rect::from_min_size(left, accept);
    ui.add_enabled_ui(run.accepting.is_none(), |ui| ui.put(place, button))
        .inner
        .on_hover_text("accept the patch as shown")
        .on_click(RunAction::Accept(side), actions);
    if first {
        let left = left
            + if is_row {
                egui::vec2(row - reject.x, 0.0)
            } else {
                egui::vec2(0.5 * (accept.x - reject.x), accept.y + 6.0)
            };
        ui.put(
            Rect::from_min_size(left, reject),
            egui::Button::new("Reject (Esc)"),
        )
        .on_hover_text("discard the patch; the mesh is unchanged")
        .on_click(RunAction::Reject, actions);
    }
    Some(Rect::from_min_size(left, egui::vec2(width, height)))
}

/// The part of a view that the legend leaves. The last view has it.
fn beside_legend(model: &Model, side: usize, mut rect: Rect) -> Rect {
    let has_legend = side + 1 == model.sides() && model.view.style.mode.is_map();
    if has_legend && rect.width() > 2.0 * WIDTH {
        rect.max.x -= WIDTH;
    }
    rect
}

/// Text that is legible on any background, within a part of a view.
fn text(ui: &Ui, room: Rect, at: Pos2, align: Align2, text: &str, size: f32) -> Rect {
    let painter = ui.painter();
    let font = FontId::proportional(size);
    let ink = ui.visuals().strong_text_color();
    let room = room.shrink(10.0);
    let galley = painter.layout(text.to_owned(), font, ink, room.width().max(80.0));
    let rect = align.anchor_size(at, galley.size());
    let shift = (room.max - rect.max).min(egui::Vec2::ZERO);
    let rect = rect.translate(shift);
    let rect = rect.translate((room.min - rect.min).max(egui::Vec2::ZERO));
    painter.rect_filled(rect.expand2(egui::vec2(5.0, 2.0)), 4.0, theme::ground(ui));
    painter.galley(rect.min, galley, Color32::PLACEHOLDER);
    rect
}

/// The range of the shown colour map.
fn map_range(model: &Model, state: &mut UiState) -> Option<[f32; 2]> {
    let style = &model.view.style;
    style.mode.is_map().then(|| {
        style
            .range
            .unwrap_or_else(|| shared_range(model, style.mode, &mut state.range))
    })
}

/// One view. Returns the place of the hint for the next action.
fn viewport_ui(
    ui: &mut Ui,
    model: &Model,
    state: &mut UiState,
    format: Option<wgpu::TextureFormat>,
    side: usize,
    rect: Rect,
    range: Option<[f32; 2]>,
    actions: &mut Vec<Action>,
) -> Option<Rect> {
    let response = ui.interact(
        rect,
        ui.scope_id().with(("viewport", side)),
        Sense::click_and_drag(),
    );
    response.widget_info(|| {
        egui::WidgetInfo::labeled(
            egui::Role::Canvas,
            true,
            if side == 0 { "view" } else { "view B" },
        )
    });
    let points = ui.ctx().pixels_per_point();
    if side == 0 {
        state.viewport = rect;
    }
    let tool = repair::is_active(model)
        .then(|| repair::select(model, &mut state.draft, &response, rect, actions));
    let scene = Arc::new(scene_builder::scene_with(
        model,
        side,
        &mut state.overlays[side],
    ));
    let mut camera = model.view.camera;
    if navigate(
        &mut camera,
        model.settings.navigation,
        &response,
        rect,
        tool,
        |camera, at| {
            let (origin, direction) = line_of_sight(camera, rect, at)?;
            point_on_line(&scene, origin, direction)
        },
        NEAREST * model.document.origin.bounds.radius(),
    ) {
        actions.push(ViewAction::Camera(camera).into());
    }
    pick(model, state, &response, rect, actions);

    let mut style = model.view.style;
    style.line_scale = points;
    // edges are visible while the user picks edges
    style.wireframe |= model.view.report.pick == Pick::Edges;
    style.range = range;
    let value = range.and_then(|_| value_under(model, &scene, &response, rect));
    let size = rect.size() * points;
    // egui assumes an infinite screen before the window size is known
    let drawable = size.max_elem() <= MAX_SIDE as f32 && size.min_elem() >= 1.0;
    if let Some(target_format) = format.filter(|_| drawable) {
        let callback = ViewportCallback {
            scene,
            camera,
            style,
            slot: side as u32,
            size_px: [
                (size.x.round() as u32).max(1),
                (size.y.round() as u32).max(1),
            ],
            target_format,
        };
        ui.painter().add(callback.shape(rect));
    }
    if let (Some(value), Some(at)) = (value, response.hover_pos()) {
        let (name, _) = super::format::mode_words(style.mode);
        let words = format!("{name} = {}", format_number(value));
        let at = at + egui::vec2(14.0, 18.0);
        let room = beside_legend(model, side, rect);
        text(ui, room, at, Align2::LEFT_TOP, &words, 13.0);
    }
    repair::draw(ui, model, state.draft.as_ref(), &response);
    if side != 0 {
        return None;
    }
    rim_numbers(ui, model, rect);
    super::rim_tools::draw(ui, model, state.rim_vertex, rect);
    hover_figures(ui, model, rect);
    corner_words(ui, model, rect)
}

/// The number of the colour map under the cursor.
fn value_under(model: &Model, scene: &Scene, response: &egui::Response, rect: Rect) -> Option<f64> {
    let down = response.ctx.input(|i| i.pointer.any_down());
    let at = response.hover_pos().filter(|_| !down)?;
    let (origin, direction) = line_of_sight(&model.view.camera, rect, at)?;
    value_on_line(scene, model.view.style.mode, origin, direction)
}

/// The line of sight through a place in a view, from where it is not hidden.
fn line_of_sight(camera: &Camera, rect: Rect, at: Pos2) -> Option<(DVec3, DVec3)> {
    let size = [f64::from(rect.width()), f64::from(rect.height())];
    let pixel = [f64::from(at.x - rect.left()), f64::from(at.y - rect.top())];
    let (origin, direction) = Projector::new(camera, size).line_through(pixel);
    let start = camera.first_visible(origin, direction);
    (start < f64::INFINITY).then(|| (origin + start.max(0.0) * direction, direction))
}

/// Whether clicks select loops.
fn picks_loops(model: &Model) -> bool {
    model.run.is_none() && matches!(model.view.task, Task::Fill | Task::Blend)
}

/// Hover, click, double click.
fn pick(
    model: &Model,
    state: &mut UiState,
    response: &egui::Response,
    rect: Rect,
    actions: &mut Vec<Action>,
) {
    let ctx = &response.ctx;
    let (pressed, down, at) = ctx.input(|i| {
        let p = &i.pointer;
        (
            p.button_pressed(PointerButton::Primary),
            p.primary_down(),
            p.latest_pos(),
        )
    });
    if pressed && response.contains_pointer() {
        state.drag.press = at.map(|p| (p, 0.0));
    }
    if let (true, Some((from, far)), Some(at)) = (down, &mut state.drag.press, at) {
        *far = far.max(from.distance(at));
    }
    let Some((mesh, picker)) = &model.picker else {
        return;
    };
    if !Arc::ptr_eq(mesh, &model.document.mesh) {
        return;
    }
    let size = [f64::from(rect.width()), f64::from(rect.height())];
    let place = |p: Pos2| [f64::from(p.x - rect.left()), f64::from(p.y - rect.top())];
    let camera = &model.view.camera;
    if let Some(at) = response.hover_pos()
        && !down
    {
        let picks_vertices = model.view.bridging.is_some() || model.view.part.is_some();
        let vertex = || picker.pick_rim_vertex(camera, size, place(at), f64::from(REACH));
        state.rim_vertex = picks_vertices.then(vertex).flatten();
        let picks = picks_loops(model) && !picks_vertices && model.view.report.pick == Pick::Holes;
        if picks && let Some(over) = picker.pick_loop(camera, size, place(at), f64::from(REACH)) {
            actions.push(ViewAction::Hover(vec![over]).into());
        }
    }
    let Some(at) = response.interact_pointer_pos() else {
        return;
    };
    if response.double_clicked() && !repair::is_active(model) {
        if let Some(hit) = picker.surface(camera, size, place(at)) {
            let mut turned = *camera;
            turned.set_pivot(hit.point);
            actions.push(ViewAction::Camera(turned).into());
        }
    } else if response.clicked() {
        let far = state.drag.press.map_or(0.0, |(_, far)| far);
        if far > CLICK || super::report::click(model, picker, size, place(at), actions) {
            return;
        }
        if !picks_loops(model) {
            return;
        }
        let modifiers = ctx.input(|i| i.modifiers);
        if let Some(bridging) = model.view.bridging {
            let to = picker.pick_rim_vertex(camera, size, place(at), f64::from(REACH));
            match (bridging.from, to) {
                (Some(from), Some(to)) => {
                    actions.push(EditAction::Bridge([from, to], bridging.width).into());
                }
                (None, Some(from)) => actions.push(
                    TaskAction::Bridging(Some(Bridging {
                        from: Some(from),
                        ..bridging
                    }))
                    .into(),
                ),
                (_, None) => {}
            }
            return;
        }
        if let Some(part) = model.view.part {
            let at = picker.pick_rim_vertex(camera, size, place(at), f64::from(REACH));
            if let Some(at) = at {
                actions.push(TaskAction::Part(Some(part.with(at))).into());
            }
            return;
        }
        match picker.pick_loop(camera, size, place(at), f64::from(REACH)) {
            Some(id) => actions.push(SelectAction::Loop(id, how(modifiers)).into()),
            None if how(modifiers) == SelectHow::Replace => actions.push(SelectAction::None.into()),
            None => {}
        }
    }
}

/// The numbers of the selected rims of a blend.
fn rim_numbers(ui: &Ui, model: &Model, rect: Rect) {
    if model.view.task != Task::Blend || model.run.is_some() {
        return;
    }
    for l in model.document.selected() {
        if let Some(at) = on_screen(model, rect, l.centroid) {
            text(ui, rect, at, Align2::CENTER_CENTER, &l.id.to_string(), 17.0);
        }
    }
}

/// The position of a point in the window.
pub(crate) fn on_screen(model: &Model, rect: Rect, point: DVec3) -> Option<Pos2> {
    let aspect = f64::from(rect.width() / rect.height().max(1.0));
    let [x, y] = model.view.camera.project(point, aspect)?;
    let at = Pos2::new(
        rect.left() + (x as f32 + 1.0) * 0.5 * rect.width(),
        rect.top() + (1.0 - y as f32) * 0.5 * rect.height(),
    );
    rect.contains(at).then_some(at)
}

/// The measures of the loop under the cursor, above it or, where there is no room, below it.
fn hover_figures(ui: &Ui, model: &Model, rect: Rect) {
    let [id] = model.view.hover[..] else {
        return;
    };
    let Some(l) = model.shown_loop(id) else {
        return;
    };
    let shown = l.vertices.iter();
    let shown = shown.filter_map(|&v| on_screen(model, rect, model.looped_mesh().position(v)));
    let shown = Rect::from_points(&shown.collect::<Vec<_>>());
    if !shown.is_positive() {
        return;
    }
    let rim = if l.is_outer_boundary {
        ", outer boundary"
    } else {
        ""
    };
    let words = format!(
        "loop {}: {} edges, length {}, width {}{rim}",
        l.id,
        l.edges(),
        format_number(l.perimeter),
        format_number(l.diameter)
    );
    let apart = egui::vec2(0.0, 10.0);
    let above = shown.center_top() - apart;
    if above.y > rect.top() + 30.0 {
        text(ui, rect, above, Align2::CENTER_BOTTOM, &words, 14.0);
    } else {
        let below = shown.center_bottom() + apart;
        text(ui, rect, below, Align2::CENTER_TOP, &words, 14.0);
    }
}

/// A hint for the next action. Returns its place.
fn corner_words(ui: &Ui, model: &Model, rect: Rect) -> Option<Rect> {
    let document = &model.document;
    let words = if let Some(words) = super::report::hint_words(model.view.report.pick) {
        words
    } else if model.run.is_some() {
        return None;
    } else if let Some(bridging) = model.view.bridging {
        match bridging.from {
            None => "Click the rim where the bridge starts.",
            Some(_) => "Click the rim where the bridge ends. Esc cancels.",
        }
    } else if let Some(part) = model.view.part {
        match (part.from, part.to) {
            (None, _) => "Click the rim vertex where the part of the hole begins.",
            (_, None) => "Click the rim vertex where it ends. Esc cancels.",
            _ => "Press Enter to fill the part. Esc cancels.",
        }
    } else if model.view.task == Task::Repair {
        if document.faces.is_empty() {
            match model.view.selecting.tool {
                Tool::Brush => "Paint over the faces to replace. Ctrl deselects.",
                Tool::Lasso => "Draw around the faces to replace. Ctrl deselects.",
                Tool::Grow => "Click a face to replace. Click again to grow the selection.",
            }
        } else {
            "Press Enter to erase and refill, Delete to erase."
        }
    } else if model.view.task == Task::Refine {
        "Press Enter to refine the mesh."
    } else if model.view.task == Task::Fill
        && document.selection.is_empty()
        && document.ends_with_bridge()
    {
        "Press Enter to fill all holes, or click those beside the bridge."
    } else if document.is_changed() && document.selection.is_empty() || document.loops.is_empty() {
        return None;
    } else if model.view.task == Task::Blend {
        if document.selection.len() < 2 {
            "Click the rims to join, one after the other."
        } else {
            "Press Enter to join them."
        }
    } else if document.selection.is_empty() {
        "Click a hole (Shift adds), or press Enter to fill all of them. F1 shows the keys."
    } else {
        "Press Enter to fill the selected loops."
    };
    let rect = beside_legend(model, 0, rect);
    Some(text(
        ui,
        rect,
        rect.center_bottom() - egui::vec2(0.0, 16.0),
        Align2::CENTER_BOTTOM,
        words,
        14.0,
    ))
}
