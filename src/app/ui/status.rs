//! The status line: document, background work, last message.

use eframe::egui::{self, Ui};

use crate::app::action::{Action, EditAction, FileAction, PictureAction, Switch, ViewAction};
use crate::app::document::elided;
use crate::app::log::Level;
use crate::app::model::Model;
use crate::app::ui::format::grouped;
use crate::app::ui::widgets::ClickActions;
use crate::app::update::{REPAIRING, WRITING};

/// Maximum number of characters of a file name.
const NAME: usize = 40;

/// Document, background work, last message.
pub(crate) fn status_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let document = &model.document;
        let star = if model.is_dirty() { " *" } else { "" };
        let words = format!(
            "{}{star}   {} vertices   {} faces   {}",
            elided(&model.name(), NAME),
            grouped(document.mesh.vertex_count()),
            grouped(document.mesh.face_count()),
            document.loop_count()
        );
        let half = egui::vec2(0.5 * ui.available_width(), ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(half, *ui.layout(), |ui| {
            let label = egui::Label::new(words).truncate();
            ui.add(label.sense(egui::Sense::click())).on_click_with_key(
                "load report",
                ViewAction::Toggle(Switch::Report),
                actions,
            );
        });
        for job in &model.jobs {
            // the picker is ready quickly, and a dialog is visible
            if matches!(job.what.as_str(), "picking" | "file dialog") {
                continue;
            }
            ui.separator();
            if job.progress().is_none() {
                ui.spinner();
            }
            ui.label(elided(&job.what, NAME)).on_hover_text(&job.what);
            if let Some((done, total)) = job.progress() {
                let part = done as f32 / total as f32;
                let words = format!("{done} of {total}");
                let bar = egui::ProgressBar::new(part).desired_width(120.0);
                ui.add(bar.text(words));
                if job.what.starts_with(WRITING) && ui.small_button("Cancel").clicked() {
                    actions.push(PictureAction::Cancel.into());
                }
            } else if job.what == REPAIRING {
                let cancel = ui.small_button("Cancel");
                cancel.on_click_with_key(
                    "the mesh stays as it is",
                    EditAction::CancelRepair,
                    actions,
                );
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.small_button("Copy command").on_click_with_key(
                "copy the command line that repeats the work",
                FileAction::CopyCommand,
                actions,
            );
            if let Some(entry) = model.log.latest() {
                let color = match entry.level {
                    Level::Info => ui.visuals().weak_text_color(),
                    Level::Warning => ui.visuals().warn_fg_color,
                    Level::Error => ui.visuals().error_fg_color,
                };
                let line = entry.text.lines().next().unwrap_or_default();
                let label = egui::Label::new(egui::RichText::new(line).color(color))
                    .truncate()
                    .sense(egui::Sense::click());
                ui.add(label)
                    .on_hover_text("open the log")
                    .on_click(ViewAction::Toggle(Switch::Log), actions);
            }
        });
    });
}
