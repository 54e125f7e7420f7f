//! Bridges: the button, and the ends in the view.

use eframe::egui::{self, Color32, Rect, Ui};

use super::viewport::on_screen;
use crate::app::action::{Action, TaskAction};
use crate::app::model::Model;
use crate::app::ui::widgets::Asks;
use crate::app::view_state::Bridging;
use crate::fill::{bridge_strip, segment_at};
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

/// The strip that would join two rim vertices; `None` if there is none.
fn strip(model: &Model, ends: [DVec3; 2], width: usize) -> Option<Vec<Vec<DVec3>>> {
    let (mesh, loops) = (&model.document.mesh, &model.document.loops);
    let [from, to] = ends.map(|end| segment_at(mesh, loops, end, width));
    bridge_strip(mesh, loops, from?, to?).ok()
}

/// The ends of the bridge under construction, and its strip to the rim vertex under the cursor.
pub(crate) fn bridge_ends(ui: &Ui, model: &Model, over: Option<DVec3>, rect: Rect) {
    let Some(bridging) = model.view.bridging else {
        return;
    };
    let ends = [bridging.from, over];
    let ink = egui::Stroke::new(1.5, Color32::from_rgb(255, 170, 40));
    let shade = egui::Stroke::new(3.5, Color32::from_black_alpha(160));
    let rows = match ends {
        [Some(from), Some(to)] => strip(model, [from, to], bridging.width),
        _ => None,
    };
    if let Some(rows) = rows {
        let rails = (0..=bridging.width).map(|k| rows.iter().map(|row| row[k]).collect());
        let lines: Vec<Vec<DVec3>> = rails.chain(rows.iter().cloned()).collect();
        for stroke in [shade, ink] {
            for ends in lines.iter().flat_map(|line| line.windows(2)) {
                let ends = [ends[0], ends[1]].map(|p| on_screen(model, rect, p));
                if let [Some(a), Some(b)] = ends {
                    ui.painter().line_segment([a, b], stroke);
                }
            }
        }
    }
    let ends = ends.map(|p| p.and_then(|p| on_screen(model, rect, p)));
    for at in ends.into_iter().flatten() {
        ui.painter()
            .circle(at, 5.0, ink.color, egui::Stroke::new(1.5, Color32::BLACK));
    }
}
