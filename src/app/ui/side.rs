//! The left panel: the task, the loops, and the operations on the selected ones.

use eframe::egui::{self, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use super::format::short_number;
use super::icons::{self, Icon};
use super::widgets::{ClickActions, number, primary, wide_primary};
use crate::app::action::{
    Action, EditAction, RunAction, SelectAction, SelectHow, TaskAction, ViewAction,
};
use crate::app::model::Model;
use crate::app::view_state::{LoopColumn, LoopKind, LoopList, Task};
use crate::mesh::{BoundaryLoop, LoopId};

/// Number of loops from which the list can be filtered.
const MANY: usize = 8;

/// Smallest height of the list of loops.
const LIST: f32 = 96.0;

/// The task, the loops and the start button. The whole panel scrolls where it is low.
pub(crate) fn side_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let height = ui.available_height();
    let area = egui::ScrollArea::vertical().auto_shrink(false);
    area.show(ui, |ui| task_ui(ui, model, height, actions));
}

/// The content of a panel of a height.
fn task_ui(ui: &mut Ui, model: &Model, height: f32, actions: &mut Vec<Action>) {
    let top = ui.cursor().top();
    let document = &model.document;
    ui.add_space(4.0);
    tasks_ui(ui, model, actions);
    if model.view.task == Task::Repair {
        super::repair::repair_ui(ui, model, actions);
        run_ui(ui, model, actions);
        return;
    }
    if model.view.task == Task::Refine {
        super::refine::refine_ui(ui, model, actions);
        run_ui(ui, model, actions);
        return;
    }
    ui.horizontal(|ui| {
        ui.heading("Loops");
        ui.weak(format!(
            "{}, {} selected",
            document.loop_count(),
            document.selection.len()
        ));
    });
    ui.horizontal_wrapped(|ui| {
        for (text, tip, action) in [
            (
                "All",
                "all loops that are not classified as outer boundaries",
                SelectAction::All,
            ),
            (
                "All but largest",
                "all loops except the longest one",
                SelectAction::AllButLargest,
            ),
            ("None", "clear the selection", SelectAction::None),
        ] {
            let key = match action {
                SelectAction::None => Action::Escape,
                _ => action.clone().into(),
            };
            ui.add_enabled(model.run.is_none(), egui::Button::new(text).small())
                .key_tip(tip, key)
                .on_click(action, actions);
        }
    });
    if model.view.task == Task::Fill && !document.loops.is_empty() {
        limits_ui(ui, model, actions);
    }
    run_ui(ui, model, actions);
    super::rim_tools::rim_tools_ui(ui, model, actions);
    ui.separator();
    if document.is_blank() {
        return;
    }
    if document.loops.is_empty() {
        ui.weak("The mesh is closed: it has no holes.");
        return;
    }
    filter_ui(ui, model, actions);
    let used = ui.cursor().top() - top;
    let size = egui::vec2(ui.available_width(), (height - used).max(LIST));
    ui.allocate_ui(size, |ui| loops_ui(ui, model, actions));
}

/// The tasks as a row of equal buttons.
fn tasks_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let tasks = [
        (
            Task::Fill,
            "Fill",
            "each selected hole gets a separate patch",
        ),
        (
            Task::Blend,
            "Blend",
            "one patch joins all selected rims, of one or more components",
        ),
        (
            Task::Repair,
            "Repair",
            "selected faces are erased and refilled, or faired in place",
        ),
        (
            Task::Refine,
            "Refine",
            "every triangle is split into four, on a smooth surface through all vertices",
        ),
    ];
    ui.add_enabled_ui(model.run.is_none(), |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let width = ((ui.available_width() - 12.0) / 4.0).floor();
            for (task, title, tip) in tasks {
                let chosen = model.view.task == task;
                task_button(ui, task, title, chosen, width).on_click_with_key(
                    tip,
                    TaskAction::Choose(task),
                    actions,
                );
            }
        });
    });
    ui.add_space(2.0);
}

/// A button with an icon above its title.
fn task_button(ui: &mut Ui, task: Task, title: &str, on: bool, width: f32) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(width, 46.0), egui::Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, enabled, on, title));
    let look = ui.style().interact_selectable(&response, on);
    let painter = ui.painter();
    painter.rect(
        rect,
        look.corner_radius,
        look.weak_bg_fill,
        look.bg_stroke,
        egui::StrokeKind::Inside,
    );
    let icon =
        egui::Rect::from_center_size(rect.center_top() + egui::vec2(0.0, 16.0), [18.0; 2].into());
    icons::draw(painter, icon, Icon::Task(task), look.text_color());
    painter.text(
        rect.center_bottom() - egui::vec2(0.0, 5.0),
        egui::Align2::CENTER_BOTTOM,
        title,
        egui::TextStyle::Small.resolve(ui.style()),
        look.text_color(),
    );
    response
}

/// Limits of the holes that are selected together.
fn limits_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let loops = &model.document.loops;
    let largest = |size: fn(&BoundaryLoop) -> f64| loops.iter().map(size).fold(0.0, f64::max);
    let edges = loops.iter().map(BoundaryLoop::edges).max().unwrap_or(0);
    let mut next = model.view.limits.clone();
    ui.collapsing("Limits", |ui| {
        limit_ui(ui, "Edges", &mut next.max_edges, edges);
        limit_ui(
            ui,
            "Length",
            &mut next.max_perimeter,
            largest(|l| l.perimeter),
        );
        limit_ui(ui, "Width", &mut next.max_diameter, largest(|l| l.diameter));
    });
    if next != model.view.limits {
        actions.push(TaskAction::Limits(next).into());
    }
}

/// A limit that can be switched on. Its initial value is that of the largest loop.
fn limit_ui<T: egui::emath::Numeric>(ui: &mut Ui, name: &str, limit: &mut Option<T>, largest: T) {
    ui.horizontal(|ui| {
        let mut is_on = limit.is_some();
        let tip = "All, All but largest and Fill all holes ignore larger holes";
        if ui.checkbox(&mut is_on, name).on_hover_text(tip).changed() {
            *limit = is_on.then_some(largest);
        }
        if let Some(value) = limit {
            let speed = 0.005 * largest.to_f64();
            let range = T::from_f64(0.0)..=largest;
            ui.add(number(value).speed(speed).range(range));
        }
    });
}

fn run_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let Some(run) = &model.run else {
        if model.view.task == Task::Repair {
            super::repair::start_ui(ui, model, actions);
            return;
        }
        if model.view.task == Task::Refine {
            super::refine::start_ui(ui, model, actions);
            return;
        }
        let n = model.document.selection.len();
        let text = match (model.view.task, n) {
            (Task::Fill, _) if model.view.part.is_some() => "Fill part of a hole".into(),
            (Task::Fill, 0) => "Fill all holes".into(),
            (Task::Fill, 1) => "Fill the hole".into(),
            (Task::Blend, 0 | 1) => "Blend (click at least two rims)".into(),
            (Task::Blend, n) => format!("Blend {n} rims"),
            (_, n) => format!("Fill {n} holes"),
        };
        let button = wide_primary(ui, &text);
        ui.add_enabled(!model.document.loops.is_empty(), button)
            .key_tip(
                "fill the selected loops with smooth patches",
                RunAction::Proceed,
            )
            .on_click(RunAction::Start, actions);
        return;
    };
    let accept = |ui: &mut Ui, i: usize, name: &str, width: f32| {
        let name = format!("Accept {name}");
        let button = primary(ui, name.trim_end()).truncate();
        let button = ui.add_enabled_ui(run.accepting.is_none(), |ui| {
            ui.add_sized([width, 30.0], button)
        });
        button
            .inner
            .key_tip("accept the patch as shown", RunAction::Accept(i))
            .clicked()
            .then_some(RunAction::Accept(i))
    };
    let names = run.names();
    // apart, so that one is not clicked instead of the other
    if names.len() == 1 {
        ui.horizontal(|ui| {
            let width = ui.available_width() - 96.0;
            actions.extend(accept(ui, 0, "", width).map(Action::from));
            reject_ui(ui, actions);
        });
        return;
    }
    for (i, name) in names.into_iter().enumerate() {
        let width = ui.available_width();
        actions.extend(accept(ui, i, name, width).map(Action::from));
    }
    ui.horizontal(|ui| reject_ui(ui, actions));
}

/// The button that discards the patches, at the right end of a row.
fn reject_ui(ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.add_sized([68.0, 30.0], egui::Button::new("Reject"))
            .on_hover_text("discard the patch; the mesh is unchanged")
            .on_click(RunAction::Reject, actions);
    });
}

/// The choice of the listed loops, if there are many.
fn filter_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    if model.document.loops.len() < MANY {
        return;
    }
    let mut next = model.view.list.clone();
    ui.horizontal_wrapped(|ui| {
        let spacing = ui.spacing_mut();
        spacing.item_spacing.x = 2.0;
        spacing.button_padding.x = 5.0;
        for (kind, title) in [
            (LoopKind::All, "all"),
            (LoopKind::Holes, "holes"),
            (LoopKind::Outer, "outer"),
        ] {
            ui.selectable_value(&mut next.kind, kind, title)
                .on_hover_text("the loops that are listed");
        }
        let least = number(&mut next.least_edges)
            .range(0..=1_000_000)
            .prefix("from ")
            .suffix(" edges");
        ui.add(least)
            .on_hover_text("list only loops with at least this many edges");
    });
    if next != model.view.list {
        actions.push(TaskAction::List(next).into());
    }
}

fn loops_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let list = &model.view.list;
    let loops = list.listed(&model.document.loops);
    // where a range begins
    let anchor = ui.scope_id().with("anchor");
    ui.spacing_mut().item_spacing.x = 3.0;
    TableBuilder::new(ui)
        .striped(true)
        .sense(egui::Sense::click())
        .auto_shrink([false, false])
        // the panel may be low
        .min_scrolled_height(60.0)
        .max_scroll_height(f32::INFINITY)
        .column(Column::exact(22.0))
        // room for the arrow before the title
        .column(Column::exact(52.0))
        .columns(Column::exact(57.0), 2)
        .column(Column::remainder().clip(true))
        .header(18.0, |mut header| {
            for (column, title, tip) in [
                (LoopColumn::Number, "#", "number on the command line"),
                (LoopColumn::Edges, "edges", "edges of the rim"),
                (
                    LoopColumn::Length,
                    "length",
                    "perimeter, in units of the file",
                ),
                (LoopColumn::Width, "width", "diameter, in units of the file"),
                (
                    LoopColumn::Kind,
                    "kind",
                    "outer: classified as an outer boundary, which is not filled unless it is \
                     selected",
                ),
            ] {
                header.col(|ui| {
                    let sorted = list.sort == column;
                    let arrow = match (sorted, list.descending) {
                        (false, _) => "",
                        (true, false) => "↑",
                        (true, true) => "↓",
                    };
                    let text = RichText::new(format!("{arrow}{title}")).strong();
                    let label = egui::Label::new(text).truncate().selectable(false);
                    let label = ui.add(label.sense(egui::Sense::click()));
                    label.widget_info(|| {
                        let name = format!("Sort by {title}");
                        egui::WidgetInfo::labeled(egui::Role::Button, true, name)
                    });
                    if label
                        .on_hover_text(format!("{tip}; click to sort"))
                        .clicked()
                    {
                        let next = LoopList {
                            sort: column,
                            descending: sorted && !list.descending,
                            ..list.clone()
                        };
                        actions.push(TaskAction::List(next).into());
                    }
                });
            }
        })
        .body(|body| {
            body.rows(20.0, loops.len(), |mut row| {
                let at = row.index();
                let l = loops[at];
                let is_selected = model.document.selection.contains(&l.id);
                row.set_selected(is_selected);
                row.set_hovered(model.view.hover.contains(&l.id));
                for text in [
                    l.id.to_string(),
                    l.edges().to_string(),
                    short_number(l.perimeter),
                    short_number(l.diameter),
                    if l.is_outer_boundary { "outer" } else { "hole" }.into(),
                ] {
                    row.col(|ui| {
                        let mut text = RichText::new(text);
                        if l.is_outer_boundary {
                            text = text.weak();
                        }
                        ui.add(egui::Label::new(text).truncate().selectable(false));
                    });
                }
                let mut response = row.response();
                if l.is_outer_boundary {
                    response = response.on_hover_text(l.why_outer());
                }
                response.widget_info(|| {
                    let name = format!("loop {}, {} edges", l.id, l.edges());
                    egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, name)
                });
                show_focus(&response);
                if response.hovered() {
                    actions.push(ViewAction::Hover(vec![l.id]).into());
                }
                response.context_menu(|ui| {
                    let idle = model.run.is_none();
                    let button = egui::Button::new("Flip its component");
                    let tip = "reverse the orientation of its faces; use it if two components have \
                         opposite orientation";
                    if ui.add_enabled(idle, button).on_hover_text(tip).clicked() {
                        actions.push(EditAction::Flip(l.id).into());
                        ui.close();
                    }
                    let button = egui::Button::new("Select similar");
                    let tip = "add all loops of this kind and about this size";
                    if ui.add_enabled(idle, button).on_hover_text(tip).clicked() {
                        actions.push(SelectAction::Similar(l.id).into());
                        ui.close();
                    }
                    if ui.button("Zoom to it").clicked() {
                        actions.push(ViewAction::FlyToLoop(l.id).into());
                        ui.close();
                    }
                });
                if response.double_clicked() || model.run.is_some() && response.clicked() {
                    actions.push(ViewAction::FlyToLoop(l.id).into());
                } else if response.clicked() {
                    let modifiers = response.ctx.input(|input| input.modifiers);
                    let start = response.ctx.data(|data| data.get_temp::<LoopId>(anchor));
                    let start = start.and_then(|id| loops.iter().position(|l| l.id == id));
                    match (how(modifiers), start) {
                        (SelectHow::Add, Some(start)) => {
                            let range = &loops[start.min(at)..=start.max(at)];
                            let range = range.iter().map(|l| l.id).collect();
                            actions.push(SelectAction::Several(range).into());
                        }
                        (how, _) => {
                            response.ctx.data_mut(|data| data.insert_temp(anchor, l.id));
                            actions.push(SelectAction::Loop(l.id, how).into());
                        }
                    }
                }
            });
        });
}

/// Draws a frame around a row that has the keyboard focus.
fn show_focus(row: &egui::Response) {
    if row.has_focus() {
        let stroke = row.ctx.global_style().visuals.selection.stroke;
        let painter = row.ctx.layer_painter(row.layer_id);
        let painter = painter.with_clip_rect(row.interact_rect);
        painter.rect_stroke(row.rect, 3.0, stroke, egui::StrokeKind::Inside);
    }
}

/// The effect of a click with these modifier keys.
pub(crate) fn how(modifiers: egui::Modifiers) -> SelectHow {
    if modifiers.command {
        SelectHow::Toggle
    } else if modifiers.shift {
        SelectHow::Add
    } else {
        SelectHow::Replace
    }
}
