//! The left panel: the task, the loops, and the operations on the selected ones.

use eframe::egui::{self, RichText, Ui};
use egui_extras::{Column, TableBuilder};

use super::format::format_number;
use super::widgets::Asks;
use crate::app::action::{
    Action, EditAction, RunAction, SelectAction, SelectHow, TaskAction, ViewAction,
};
use crate::app::model::Model;
use crate::app::view_state::Task;
use crate::mesh::BoundaryLoop;

/// The task, the loops and the start button.
pub(crate) fn side_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let document = &model.document;
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        for (task, title, tip) in [
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
        ] {
            let chosen = model.view.task == task;
            let button = egui::Button::selectable(chosen, RichText::new(title).strong());
            ui.add_enabled(model.run.is_none(), button).asks_with_key(
                tip,
                TaskAction::Choose(task),
                actions,
            );
        }
    });
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
                "all loops except the one with the largest perimeter",
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
                .asks(action, actions);
        }
    });
    if model.view.task == Task::Fill && !document.loops.is_empty() {
        limits_ui(ui, model, actions);
    }
    run_ui(ui, model, actions);
    super::bridge::bridge_ui(ui, model, actions);
    ui.separator();
    if document.is_blank() {
        return;
    }
    if document.loops.is_empty() {
        ui.weak("The mesh is closed: it has no holes.");
        return;
    }
    loops_ui(ui, model, actions);
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
            "Perimeter",
            &mut next.max_perimeter,
            largest(|l| l.perimeter),
        );
        limit_ui(
            ui,
            "Diameter",
            &mut next.max_diameter,
            largest(|l| l.diameter),
        );
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
            ui.add(
                egui::DragValue::new(value)
                    .speed(speed)
                    .range(T::from_f64(0.0)..=largest),
            );
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
            (Task::Fill, 0) => "Fill all holes".into(),
            (Task::Fill, 1) => "Fill the hole".into(),
            (Task::Blend, 0 | 1) => "Blend (click at least two rims)".into(),
            (Task::Blend, n) => format!("Blend {n} rims"),
            (_, n) => format!("Fill {n} holes"),
        };
        let button = egui::Button::new(RichText::new(text).strong())
            .min_size(egui::vec2(ui.available_width(), 28.0));
        ui.add_enabled(!model.document.loops.is_empty(), button)
            .key_tip(
                "fill the selected loops with smooth patches",
                RunAction::Proceed,
            )
            .asks(RunAction::Start, actions);
        return;
    };
    ui.horizontal_wrapped(|ui| {
        for (i, name) in run.names().into_iter().enumerate() {
            let name = format!("Accept {name}");
            ui.button(RichText::new(name.trim_end()).strong())
                .key_tip("accept the patch as shown", RunAction::Accept(0))
                .asks(RunAction::Accept(i), actions);
        }
        ui.button("Reject")
            .on_hover_text("discard the patch; the mesh is unchanged")
            .asks(RunAction::Reject, actions);
    });
}

fn loops_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let loops = &model.document.loops;
    let mut hovered = None;
    TableBuilder::new(ui)
        .striped(true)
        .sense(egui::Sense::click())
        .column(Column::auto().at_least(26.0))
        .column(Column::auto().at_least(40.0))
        .column(Column::auto().at_least(60.0))
        .column(Column::remainder())
        .header(18.0, |mut header| {
            for (title, tip) in [
                ("#", "number on the command line"),
                ("edges", "edges of the rim"),
                ("length", "perimeter, in units of the file"),
                ("width", "diameter, in units of the file"),
            ] {
                header.col(|ui| {
                    ui.strong(title).on_hover_text(tip);
                });
            }
        })
        .body(|body| {
            body.rows(18.0, loops.len(), |mut row| {
                let l = &loops[row.index()];
                let is_selected = model.document.selection.contains(&l.id);
                row.set_selected(is_selected);
                row.set_hovered(model.view.hover == Some(l.id));
                row.col(|ui| {
                    let mut text = RichText::new(l.id.to_string());
                    if l.is_outer_boundary {
                        text = text.weak();
                    }
                    ui.label(text);
                });
                row.col(|ui| {
                    ui.label(l.edges().to_string());
                });
                row.col(|ui| {
                    ui.label(format_number(l.perimeter));
                });
                row.col(|ui| {
                    let rim = if l.is_outer_boundary {
                        "  outer boundary"
                    } else {
                        ""
                    };
                    ui.label(format!("{}{rim}", format_number(l.diameter)));
                });
                let mut response = row.response();
                if l.is_outer_boundary {
                    response = response
                        .on_hover_text(format!("classified as an outer boundary: {}", l.reason));
                }
                response.widget_info(|| {
                    let name = format!("loop {}, {} edges", l.id, l.edges());
                    egui::WidgetInfo::selected(egui::Role::Button, true, is_selected, name)
                });
                if response.hovered() {
                    hovered = Some(l.id);
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
                    if ui.button("Zoom to it").clicked() {
                        actions.push(ViewAction::FlyToLoop(l.id).into());
                        ui.close();
                    }
                });
                if response.double_clicked() {
                    actions.push(ViewAction::FlyToLoop(l.id).into());
                } else if response.clicked() {
                    let modifiers = response.ctx.input(|input| input.modifiers);
                    actions.push(SelectAction::Loop(l.id, how(modifiers)).into());
                }
            });
        });
    if hovered.is_some() && hovered != model.view.hover {
        actions.push(ViewAction::Hover(hovered).into());
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
