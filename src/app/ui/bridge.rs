//! Bridges: the button, and the ends in the view.

use eframe::egui::{self, Color32, Rect, Ui};

use super::viewport::on_screen;
use crate::app::action::{Action, TaskAction};
use crate::app::model::Model;
use crate::app::ui::widgets::Asks;
use crate::app::view_state::Bridging;
use crate::mesh::DVec3;

/// A bridge splits a difficult hole, or joins two.
pub(crate) fn bridge_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let now = model.view.bridging;
        let some = model.run.is_none() && !model.document.loops.is_empty();
        let button = egui::Button::selectable(now.is_some(), "Bridge");
        let tip = "click two points on rims: a strip of triangles joins them, so that a difficult \
                   hole becomes two easy ones";
        ui.add_enabled(some, button).on_hover_text(tip).asks(
            TaskAction::Bridging(match now {
                Some(_) => None,
                None => Some(Bridging {
                    from: None,
                    width: 2,
                }),
            }),
            actions,
        );
        if let Some(mut next) = now {
            let drag = egui::DragValue::new(&mut next.width)
                .range(1..=64)
                .suffix(" edges wide");
            if ui.add(drag).changed() {
                actions.push(TaskAction::Bridging(Some(next)).into());
            }
        }
    });
}

/// The ends of the bridge under construction.
pub(crate) fn bridge_ends(ui: &Ui, model: &Model, over: Option<DVec3>, rect: Rect) {
    let Some(bridging) = model.view.bridging else {
        return;
    };
    let ends = [bridging.from, over].map(|p| p.and_then(|p| on_screen(model, rect, p)));
    let ink = egui::Stroke::new(2.5, Color32::from_rgb(255, 170, 40));
    let shade = egui::Stroke::new(5.0, Color32::from_black_alpha(160));
    if let [Some(a), Some(b)] = ends {
        for stroke in [shade, ink] {
            ui.painter().line_segment([a, b], stroke);
        }
    }
    for at in ends.into_iter().flatten() {
        ui.painter()
            .circle(at, 5.0, ink.color, egui::Stroke::new(1.5, Color32::BLACK));
    }
}
