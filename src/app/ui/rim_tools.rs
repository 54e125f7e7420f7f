//! Tools that work between two rim vertices: bridges, and the choice of a part of a hole.

use eframe::egui::{self, Color32, Rect, Ui};

use super::viewport::on_screen;
use super::widgets::{ClickActions, number};
use crate::app::action::{Action, TaskAction};
use crate::app::model::Model;
use crate::app::view_state::{Bridging, Part, Task};
use crate::fill::{bridge_strip, part_chord, segment_at};
use crate::mesh::DVec3;
use crate::ops::FillPartSpec;

/// The buttons of both tools.
pub(crate) fn rim_tools_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let bridging = model.view.bridging;
        let some = model.run.is_none() && !model.document.loops.is_empty();
        let button = egui::Button::selectable(bridging.is_some(), "Bridge");
        let tip = "click two points on rims: a strip of triangles joins them, so that a difficult \
                   hole becomes two easy ones; the strip flows with the patches beside it";
        ui.add_enabled(some, button).on_hover_text(tip).on_click(
            TaskAction::Bridging(match bridging {
                Some(_) => None,
                None => Some(Bridging {
                    from: None,
                    width: 2,
                }),
            }),
            actions,
        );
        if model.view.task == Task::Fill {
            let part = model.view.part;
            let button = egui::Button::selectable(part.is_some(), "Part of a hole");
            let tip = "click two rim vertices of a hole: only the part between them is filled, along \
                       the shorter segment of the rim";
            let next = part.is_none().then(Part::default);
            ui.add_enabled(some, button)
                .on_hover_text(tip)
                .on_click(TaskAction::Part(next), actions);
        }
        if let Some(mut next) = bridging {
            let drag = number(&mut next.width)
                .range(1..=64)
                .suffix(" edges");
            let drag = ui.add(drag).on_hover_text("width of the bridge");
            if drag.changed() {
                actions.push(TaskAction::Bridging(Some(next)).into());
            }
        }
    });
}

/// The ends of the tool in use, and what it would make to the rim vertex under the cursor.
pub(crate) fn draw(ui: &Ui, model: &Model, over: Option<DVec3>, rect: Rect) {
    let (ends, lines) = if let Some(bridging) = model.view.bridging {
        let ends = [bridging.from, over];
        (ends, bridge_lines(model, ends, bridging.width))
    } else if let Some(part) = model.view.part {
        let ends = [part.from.or(over), part.to.or(over)];
        (ends, part_lines(model, ends))
    } else {
        return;
    };
    let ink = egui::Stroke::new(2.0, Color32::from_rgb(255, 170, 40));
    let shade = egui::Stroke::new(4.0, Color32::from_black_alpha(160));
    for stroke in [shade, ink] {
        for ends in lines.iter().flatten().flat_map(|line| line.windows(2)) {
            let ends = [ends[0], ends[1]].map(|p| on_screen(model, rect, p));
            if let [Some(a), Some(b)] = ends {
                ui.painter().line_segment([a, b], stroke);
            }
        }
    }
    let ends = ends.map(|p| p.and_then(|p| on_screen(model, rect, p)));
    for at in ends.into_iter().flatten() {
        ui.painter()
            .circle(at, 5.0, ink.color, egui::Stroke::new(1.5, Color32::BLACK));
    }
}

/// The strip that would join two rim vertices, as lines along and across it.
fn bridge_lines(model: &Model, ends: [Option<DVec3>; 2], width: usize) -> Option<Vec<Vec<DVec3>>> {
    let (mesh, loops) = (&model.document.mesh, &model.document.loops);
    let [from, to] = ends.map(|end| segment_at(mesh, loops, end?, width));
    let rows = bridge_strip(mesh, loops, from?, to?).ok()?;
    let rails = (0..=width).map(|k| rows.iter().map(|row| row[k]).collect());
    Some(rails.chain(rows.iter().cloned()).collect())
}

/// The border of the part between two rim vertices: the segment of the rim, and the curve through the hole.
fn part_lines(model: &Model, ends: [Option<DVec3>; 2]) -> Option<Vec<Vec<DVec3>>> {
    let (mesh, loops) = (&model.document.mesh, &model.document.loops);
    let spec = FillPartSpec {
        ends: [ends[0]?, ends[1]?],
        flow: model.document.controls.clone().into(),
    };
    let (hole, [from, to]) = spec.segment(mesh, loops)?;
    let n = hole.edges();
    let at = |k: usize| mesh.position(hole.vertices[k % n]);
    let edges = (to + n - from) % n;
    if edges < 2 {
        return None;
    }
    let segment = (0..=edges).map(|k| at(from + k)).collect();
    let chord = part_chord(mesh, hole, [from, to], spec.flow.controls.density);
    let curve = [at(to)].into_iter().chain(chord).chain([at(from)]);
    Some(vec![segment, curve.collect()])
}
