//! The report. It replaces the controls while it is open.

mod continuity;
mod measures;
mod section;
mod view;

use eframe::egui::{CollapsingHeader, Grid, RichText, ScrollArea, Spinner, Ui};

use super::format::format_number;
use crate::app::action::Action;
use crate::app::model::Model;
use crate::app::report::{Pick, ReportAction, ReportFile};
use crate::app::ui::widgets::ClickActions;
use crate::mesh::DVec3;

pub(crate) use view::{click, hint_words};

/// All measures of the shown surface.
pub(crate) fn report_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    header_ui(ui, model, actions);
    ui.separator();
    ScrollArea::both()
        // a row may be wider than the panel
        .auto_shrink([false; 2])
        .show(ui, |ui| {
            let Some(measured) = model.report.measured.clone() else {
                let words = if model.report.measuring.is_some() {
                    "measuring…"
                } else {
                    "nothing to measure"
                };
                ui.weak(words);
                return;
            };
            part(ui, "Shape and energies", true, false, |ui| {
                measures::shape_ui(ui, &measured);
            });
            part(ui, "Curvature", true, false, |ui| {
                measures::curvature_ui(ui, model, &measured, actions);
            });
            part(ui, "Triangles", false, false, |ui| {
                measures::quality_ui(ui, &measured, actions);
            });
            let wanted = model.report.loading.is_some();
            part(ui, "Distance to a reference", false, wanted, |ui| {
                measures::distance_ui(ui, model, &measured, actions);
            });
            let wanted = matches!(model.view.report.pick, Pick::Section(_));
            part(ui, "Section and curvature comb", false, wanted, |ui| {
                section::section_ui(ui, model, actions);
            });
            let wanted = model.view.report.pick == Pick::Edges;
            part(ui, "Continuity", true, wanted, |ui| {
                continuity::chains_ui(ui, model, &measured, actions);
            });
        });
}

/// A collapsible part of the report. It is expanded initially if `open`, and always while `wanted`.
fn part(ui: &mut Ui, title: &str, open: bool, wanted: bool, body: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong())
        .default_open(open)
        .open(wanted.then_some(true))
        .show_unindented(ui, body);
}

fn header_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        for file in [ReportFile::Json, ReportFile::Measures] {
            let name = file.extension().to_uppercase();
            ui.button(format!("Copy {name}"))
                .on_hover_text(format!("{}, to the clipboard", file.title()))
                .on_click(ReportAction::Copy(file), actions);
        }
        ui.menu_button("Save", |ui| {
            for file in ReportFile::ALL {
                if ui.button(format!("{}…", file.title())).clicked() {
                    actions.push(ReportAction::AskSave(file).into());
                    ui.close();
                }
            }
        });
    });
    ui.horizontal(|ui| {
        if let Some(measured) = &model.report.measured {
            ui.weak(format!("of {}", measured.request.subject.words()));
        }
        if let Some((_, job)) = &model.report.measuring {
            ui.add(Spinner::new().size(12.0));
            if let Some((done, total)) = job.progress() {
                let percent = 100.0 * f64::from(done) / f64::from(total);
                ui.weak(format!("{percent:.0} %"));
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("Vertices are");
        for (on, title, tip) in [
            (
                false,
                "control points",
                "of the limit surface, as in the result of a fill (analyze)",
            ),
            (
                true,
                "on the surface",
                "points on the limit surface, as in a scan or a refined mesh (analyze \
                 --on-surface)",
            ),
        ] {
            let chosen = model.view.report.on_surface == on;
            ui.selectable_label(chosen, title)
                .on_hover_text(tip)
                .on_click(ReportAction::OnSurface(on), actions);
        }
    });
}

/// A table of names and values.
fn grid(ui: &mut Ui, name: &str, body: impl FnOnce(&mut Ui)) {
    Grid::new(name)
        .striped(true)
        .num_columns(2)
        .spacing([12.0, 3.0])
        .show(ui, body);
}

fn row(ui: &mut Ui, name: &str, tip: &str, value: impl Into<String>) {
    let label = ui.label(name);
    if !tip.is_empty() {
        label.on_hover_text(tip);
    }
    ui.label(value.into());
    ui.end_row();
}

/// A number with a link to its location.
fn place(ui: &mut Ui, value: f64, at: [f64; 3], actions: &mut Vec<Action>) {
    let [x, y, z] = at;
    if ui
        .link(format_number(value))
        .on_hover_text(format!(
            "show the point {}, {}, {}",
            format_number(x),
            format_number(y),
            format_number(z)
        ))
        .clicked()
    {
        let action = ReportAction::Inspect(DVec3::from_array(at));
        actions.push(action.into());
    }
}
