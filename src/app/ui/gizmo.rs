//! The axes in the corner of a view, which can be clicked, and the scale bar.

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, vec2};

use super::format::trimmed;
use super::theme;
use crate::app::action::{Action, ViewAction};
use crate::app::model::Model;
use crate::mesh::DVec3;
use crate::options::Choice;
use crate::render::{Camera, StandardView};

/// Distance of the balls from the centre of the axes in points.
const ARM: f32 = 30.0;
/// Distance of the centre from the corner of the view.
const INSET: f32 = 46.0;

/// Height of the axes, which messages in the same corner leave free.
pub(crate) const GIZMO: f32 = 2.0 * INSET;

/// The standard view from the positive or negative end of an axis.
fn view_from(camera: &Camera, towards_eye: DVec3) -> Option<StandardView> {
    let looks = |view: &StandardView| {
        let mut camera = *camera;
        camera.standard_view(*view);
        -camera.forward()
    };
    let all = StandardView::ALL.iter().copied();
    all.into_iter()
        .find(|view| looks(view).dot(towards_eye) > 0.99)
}

/// The six ends of the axes, the rearmost first.
pub(crate) fn gizmo_ui(ui: &mut Ui, model: &Model, rect: Rect, actions: &mut Vec<Action>) {
    if rect.width() < 4.0 * INSET || rect.height() < 4.0 * INSET {
        return;
    }
    let camera = &model.view.camera;
    let centre = rect.right_top() + vec2(-INSET, INSET);
    let colors = [
        Color32::from_rgb(225, 75, 80),
        Color32::from_rgb(110, 175, 60),
        Color32::from_rgb(70, 130, 225),
    ];
    let mut ends: Vec<(DVec3, usize, bool)> = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .enumerate()
        .flat_map(|(i, axis)| [(axis, i, true), (-axis, i, false)])
        .collect();
    ends.sort_by(|a, b| {
        let depth = |end: &(DVec3, usize, bool)| end.0.dot(camera.forward());
        depth(b).total_cmp(&depth(a))
    });
    for (end, axis, positive) in ends {
        let flat = vec2(end.dot(camera.right()) as f32, -end.dot(camera.up()) as f32);
        let at = centre + ARM * flat;
        let radius = if positive { 9.0 } else { 6.5 };
        let Some(view) = view_from(camera, end) else {
            continue;
        };
        let hit = Rect::from_center_size(at, vec2(18.0, 18.0));
        let id = ui.scope_id().with(("axis", axis, positive));
        let response = ui.interact(hit, id, Sense::click());
        let name = format!("View from the {}", view.name());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
        let color = colors[axis];
        let painter = ui.painter();
        let fill = if positive || response.hovered() {
            color
        } else {
            color.gamma_multiply(0.35)
        };
        if positive {
            painter.line_segment([centre, at], Stroke::new(2.0, color));
        }
        painter.circle(at, radius, fill, Stroke::new(1.0, color));
        if positive {
            let font = FontId::proportional(11.0);
            let letter = ["x", "y", "z"][axis];
            painter.text(at, Align2::CENTER_CENTER, letter, font, Color32::WHITE);
        }
        if response.on_hover_text(name).clicked() {
            actions.push(ViewAction::Standard(view).into());
        }
    }
}

/// A bar whose length is a round number of units at the depth of the pivot.
pub(crate) fn scale_bar(ui: &Ui, model: &Model, rect: Rect, below: Option<Rect>) {
    let Some(length) = model.view.bar_length().filter(|_| rect.width() >= 240.0) else {
        return;
    };
    let width = (length / model.view.units_per_point()) as f32;
    let left = rect.left() + 14.0;
    let reaches = |below: &Rect| below.left() < left + width + 10.0;
    let floor = below
        .filter(reaches)
        .map_or(rect.bottom(), |below| below.top());
    let left = Pos2::new(left, floor - 14.0);
    let ink = ui.visuals().strong_text_color();
    let painter = ui.painter();
    let stroke = Stroke::new(1.5, ink);
    let right = left + vec2(width, 0.0);
    let tick = vec2(0.0, 5.0);
    let number = trimmed(length);
    let s = if number == "1" { "" } else { "s" };
    let words = format!("{number} unit{s}");
    let galley = painter.layout_no_wrap(words, FontId::proportional(11.0), ink);
    let at = Pos2::new(0.5 * (left.x + right.x), left.y - 6.0);
    let words = Align2::CENTER_BOTTOM.anchor_size(at, galley.size());
    let whole = words.union(Rect::from_two_pos(left, right));
    painter.rect_filled(whole.expand2(vec2(6.0, 4.0)), 4.0, theme::ground(ui));
    for line in [[left, right], [left, left - tick], [right, right - tick]] {
        painter.line_segment(line, stroke);
    }
    painter.galley(words.min, galley, ink);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Bounds;

    /// A click on the end of an axis shows the model from there, whatever axis is vertical.
    #[test]
    fn each_end_of_an_axis_has_its_view() {
        for z_up in [false, true] {
            let mut camera = Camera::fit(&Bounds::new(-DVec3::ONE, DVec3::ONE));
            camera.z_up = z_up;
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                for end in [axis, -axis] {
                    let view = view_from(&camera, end).expect("a view");
                    let mut turned = camera;
                    turned.standard_view(view);
                    assert!((-turned.forward()).dot(end) > 0.999);
                }
            }
        }
    }
}
