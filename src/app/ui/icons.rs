//! Icons, drawn as shapes so that they are sharp at any scale.

use eframe::egui::{
    self, Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, StrokeKind, Ui, vec2,
};

use crate::app::view_state::Task;

/// An icon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Icon {
    /// To the first state.
    Rewind,
    /// Start the flow or the replay.
    Play,
    /// Pause.
    Pause,
    /// One step.
    Step,
    /// To the converged state.
    Finish,
    /// End the flow.
    Stop,
    /// Continue from the shown state.
    Continue,
    /// A task.
    Task(Task),
    /// The left panel.
    LeftPanel,
    /// The bottom panel.
    BottomPanel,
    /// The right panel.
    RightPanel,
}

/// Draws an icon into the middle of a rectangle.
pub(crate) fn draw(painter: &Painter, rect: Rect, icon: Icon, ink: Color32) {
    let side = rect.width().min(rect.height());
    let square = Rect::from_center_size(rect.center(), vec2(side, side));
    // coordinates from -1 to 1
    let at = |x: f32, y: f32| square.center() + 0.5 * side * vec2(x, y);
    let solid = |points: &[(f32, f32)]| {
        let points = points.iter().map(|&(x, y)| at(x, y)).collect();
        painter.add(Shape::convex_polygon(points, ink, Stroke::NONE));
    };
    let bar = |x: f32, width: f32| {
        solid(&[(x, -0.8), (x + width, -0.8), (x + width, 0.8), (x, 0.8)]);
    };
    let right = |x: f32, width: f32| solid(&[(x, -0.8), (x + width, 0.0), (x, 0.8)]);
    let stroke = Stroke::new((0.09 * side).max(1.2), ink);
    let line = |points: &[(f32, f32)]| {
        let points: Vec<Pos2> = points.iter().map(|&(x, y)| at(x, y)).collect();
        painter.add(Shape::line(points, stroke));
    };
    match icon {
        Icon::Play => right(-0.6, 1.4),
        Icon::Pause => {
            bar(-0.65, 0.45);
            bar(0.2, 0.45);
        }
        Icon::Step => {
            right(-0.75, 1.1);
            bar(0.45, 0.3);
        }
        Icon::Finish => {
            right(-0.95, 0.8);
            right(-0.15, 0.8);
            bar(0.7, 0.25);
        }
        Icon::Rewind => {
            bar(-0.85, 0.3);
            solid(&[(0.75, -0.8), (-0.45, 0.0), (0.75, 0.8)]);
        }
        Icon::Stop => solid(&[(-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)]),
        Icon::Continue => {
            bar(-0.9, 0.25);
            right(-0.35, 1.2);
        }
        Icon::Task(task) => task_icon(painter, task, side, stroke, at, line),
        Icon::LeftPanel | Icon::BottomPanel | Icon::RightPanel => {
            let frame = Rect::from_two_pos(at(-0.9, -0.75), at(0.9, 0.75));
            painter.rect_stroke(frame, 2.0, stroke, StrokeKind::Middle);
            let part = match icon {
                Icon::LeftPanel => [at(-0.9, -0.75), at(-0.25, 0.75)],
                Icon::BottomPanel => [at(-0.9, 0.15), at(0.9, 0.75)],
                _ => [at(0.25, -0.75), at(0.9, 0.75)],
            };
            painter.rect_filled(Rect::from_two_pos(part[0], part[1]), 1.0, ink);
        }
    }
}

fn task_icon(
    painter: &Painter,
    task: Task,
    side: f32,
    stroke: Stroke,
    at: impl Fn(f32, f32) -> Pos2,
    line: impl Fn(&[(f32, f32)]),
) {
    match task {
        // a closed hole
        Task::Fill => {
            painter.circle_stroke(at(0.0, 0.0), 0.42 * side, stroke);
            painter.circle_filled(at(0.0, 0.0), 0.24 * side, stroke.color);
        }
        // two rims and the surface between them
        Task::Blend => {
            line(&[(-0.9, -0.8), (-0.9, 0.8)]);
            line(&[(0.9, -0.8), (0.9, 0.8)]);
            for up in [-1.0, 1.0] {
                let curve: Vec<(f32, f32)> = (0..=12)
                    .map(|i| {
                        let x = -0.9 + 0.15 * i as f32;
                        (x, up * (0.3 + 0.5 * (x / 0.9).powi(2)))
                    })
                    .collect();
                line(&curve);
            }
        }
        // a selected part of a surface
        Task::Repair => {
            let dash = 0.16 * side;
            let corners = [
                (-0.8, -0.8),
                (0.8, -0.8),
                (0.8, 0.8),
                (-0.8, 0.8),
                (-0.8, -0.8),
            ];
            let path: Vec<Pos2> = corners.iter().map(|&(x, y)| at(x, y)).collect();
            painter.extend(Shape::dashed_line(&path, stroke, dash, 0.7 * dash));
            line(&[(-0.35, 0.05), (-0.05, 0.38), (0.42, -0.35)]);
        }
        // a triangle split into four
        Task::Refine => {
            line(&[(0.0, -0.85), (0.95, 0.75), (-0.95, 0.75), (0.0, -0.85)]);
            line(&[
                (-0.475, -0.05),
                (0.475, -0.05),
                (0.0, 0.75),
                (-0.475, -0.05),
            ]);
        }
    }
}

/// A button with an icon. Its name is for screen readers.
pub(crate) fn icon_button(ui: &mut Ui, icon: Icon, name: &str, on: bool) -> Response {
    let side = ui.spacing().interact_size.y + 4.0;
    let (rect, response) = ui.allocate_exact_size(vec2(side + 4.0, side), Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, enabled, on, name));
    let visuals = ui.style().interact_selectable(&response, on);
    if on || response.hovered() || response.has_focus() {
        let radius = visuals.corner_radius;
        ui.painter().rect_filled(rect, radius, visuals.weak_bg_fill);
        ui.painter()
            .rect_stroke(rect, radius, visuals.bg_stroke, StrokeKind::Inside);
    }
    let ink = visuals.text_color();
    draw(ui.painter(), rect.shrink(7.0), icon, ink);
    response
}
