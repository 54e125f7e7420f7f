//! Temporary messages in the corner of the views.

use std::time::Instant;

use eframe::egui::{self, Align2, Area, Color32, Context, Frame, Id, Order, Stroke};

use super::gizmo::GIZMO;
use crate::app::action::{Action, Switch, ViewAction};
use crate::app::log::Level;
use crate::app::model::Model;

/// The visible toasts, in the upper right corner of the views.
pub(crate) fn toasts_ui(
    ctx: &Context,
    model: &Model,
    views: egui::Rect,
    actions: &mut Vec<Action>,
) {
    let shown = model.log.toasts(Instant::now());
    if shown.is_empty() {
        return;
    }
    let corner = egui::vec2(
        views.right() - ctx.content_rect().right() - 12.0,
        views.top() + GIZMO,
    );
    Area::new(Id::unique("toasts"))
        // a window that is clicked comes in front of them
        .order(Order::Middle)
        // below the axes
        .anchor(Align2::RIGHT_TOP, corner)
        .interactable(true)
        .show(ctx, |ui| {
            let width = (views.width() - 24.0).clamp(120.0, 420.0);
            ui.set_max_width(width);
            for i in shown {
                let entry = &model.log.entries()[i];
                let color = match entry.level {
                    Level::Info => Color32::from_rgb(70, 130, 180),
                    Level::Warning => ui.visuals().warn_fg_color,
                    Level::Error => ui.visuals().error_fg_color,
                };
                let frame = Frame::popup(ui.style()).stroke(Stroke::new(1.5, color));
                let inner = frame.show(ui, |ui| {
                    ui.set_max_width(width - 20.0);
                    ui.label(&entry.text);
                });
                let response = inner.response.interact(egui::Sense::click());
                if response.on_hover_text("click to open the log").clicked() {
                    if !model.view.windows.log {
                        actions.push(ViewAction::Toggle(Switch::Log).into());
                    }
                    actions.push(Action::DismissToast(i));
                }
                ui.add_space(6.0);
            }
        });
}
