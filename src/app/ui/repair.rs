//! Selection of faces: the panel, and the tools in the view.

use eframe::egui::{self, Color32, Modifiers, PointerButton, Pos2, Rect, Response, Stroke, Ui};

use super::navigation::CLICK;
use super::widgets::{ClickActions, number, row, slider, wide_button, wide_primary};
use crate::app::action::{Action, ControlsAction, EditAction, RunAction, SelectAction, TaskAction};
use crate::app::faces::{BrushStamp, FaceEdit, Lasso};
use crate::app::model::Model;
use crate::app::report::Pick;
use crate::app::update::is_repairing;
use crate::app::view_state::{Selecting, Task, Tool};
use crate::mesh::{DVec3, Flaw};
use crate::render::{Picker, Projector};

/// The current stroke or lasso.
#[derive(Clone, Debug)]
pub(crate) enum Draft {
    /// A brush stroke, with its last point.
    Brush(Pos2),
    /// A lasso, in window points.
    Lasso(Vec<Pos2>),
}

/// Tools, and commands that change the whole selection.
pub(crate) fn repair_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let idle = model.run.is_none();
    ui.horizontal(|ui| {
        ui.heading("Faces");
        ui.weak(format!("{} selected", model.document.faces.len()));
    });
    let mut selecting = model.view.selecting;
    ui.horizontal(|ui| {
        for (tool, name, tip) in [
            (
                Tool::Brush,
                "Brush",
                "drag over the surface to select faces, with Ctrl to deselect",
            ),
            (
                Tool::Lasso,
                "Lasso",
                "draw around faces to select them, with Ctrl to deselect",
            ),
            (
                Tool::Grow,
                "Grow",
                "click a face to select it, and again to grow the selection there by one ring; \
                 Ctrl shrinks it",
            ),
        ] {
            let button = egui::Button::selectable(selecting.tool == tool, name);
            if ui.add_enabled(idle, button).on_hover_text(tip).clicked() {
                selecting.tool = tool;
            }
        }
    });
    match selecting.tool {
        Tool::Brush => {
            let tip = "in screen points: zoom in for finer strokes";
            row(ui, "Brush radius", tip, |ui, label| {
                let radius = slider(&mut selecting.brush, 3.0..=150.0);
                ui.add(radius.logarithmic(true).fixed_decimals(0))
                    .labelled_by(label)
                    .on_hover_text(tip);
            });
        }
        Tool::Lasso => {
            ui.checkbox(&mut selecting.through, "hidden faces too")
                .on_hover_text("select all faces inside the line, including hidden ones");
        }
        Tool::Grow => {
            ui.weak("each click adds one ring");
        }
    }
    quality_ui(ui, model, &mut selecting, actions);
    if selecting != model.view.selecting {
        actions.push(TaskAction::Selecting(selecting).into());
    }
    ui.horizontal_wrapped(|ui| {
        let spacing = ui.spacing_mut();
        spacing.item_spacing.x = 3.0;
        spacing.button_padding.x = 5.0;
        for (name, tip, edit) in [
            ("Grow", "add one ring of faces", FaceEdit::Grow),
            ("Shrink", "remove one ring of faces", FaceEdit::Shrink),
            (
                "Smooth",
                "remove ears and fill notches at the border",
                FaceEdit::Smooth,
            ),
            ("Invert", "select the other faces", FaceEdit::Invert),
            ("None", "clear the selection", FaceEdit::Clear),
        ] {
            let button = egui::Button::new(name).small();
            let some = idle && (edit == FaceEdit::Invert || !model.document.faces.is_empty());
            let named = ui.add_enabled(some, button).on_hover_text(tip);
            named.widget_info(|| {
                let label = format!("{name} the selection");
                egui::WidgetInfo::labeled(egui::Role::Button, some, label)
            });
            named.on_click(SelectAction::Faces(edit), actions);
        }
    });
    ui.weak(if idle {
        "Drag with the right button to rotate the view, or start a brush drag beside the surface."
    } else {
        "The selection can be changed again when the patch is accepted or rejected."
    });
    ui.separator();
}

/// Buttons that select faces by their quality.
fn quality_ui(ui: &mut Ui, model: &Model, selecting: &mut Selecting, actions: &mut Vec<Action>) {
    let idle = model.run.is_none() && !model.document.is_blank();
    let mut button = |ui: &mut Ui, name: &str, tip: &str, flaw: Flaw, on: bool| {
        ui.add_enabled(idle && on, egui::Button::new(name).small())
            .on_hover_text(tip)
            .on_click(SelectAction::Faces(FaceEdit::Flawed(flaw)), actions);
    };
    ui.collapsing("Select by quality", |ui| {
        ui.horizontal(|ui| {
            let (worse, tip) = (
                selecting.worse_than,
                "the smallest angle is below this limit",
            );
            button(ui, "Angle below", tip, Flaw::WorseThan(worse), true);
            let value = number(&mut selecting.worse_than);
            ui.add(value.range(0.0..=60.0).speed(0.1).suffix("°"));
        });
        ui.horizontal(|ui| {
            let (longer, tip) = (selecting.longer_than, "an edge is longer than this length");
            button(
                ui,
                "Edge above",
                tip,
                Flaw::LongerThan(longer),
                longer > 0.0,
            );
            let speed = 1e-3 * model.document.origin.bounds.radius();
            let value = number(&mut selecting.longer_than);
            ui.add(value.range(0.0..=f64::MAX).speed(speed));
        });
        ui.horizontal(|ui| {
            let tip = "the face intersects another one";
            button(ui, "Crossing", tip, Flaw::Crossing, true);
            let tip = "the face is folded onto a neighbour: their normals differ by 150° or more";
            button(ui, "Folded", tip, Flaw::Folded, true);
        });
    });
}

/// The buttons that start an operation on the selection.
pub(crate) fn start_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let some = !model.document.faces.is_empty();
    let refill = "erase the selected faces and fill the hole with a smooth patch";
    let main = wide_primary(ui, "Erase and refill");
    ui.add_enabled(some, main)
        .key_tip(refill, RunAction::Proceed)
        .on_click(RunAction::Start, actions);
    let fair = "keep the triangles and move the vertices inside the selection; those on its border \
                do not move";
    let button = wide_button(ui, "Fair in place");
    ui.add_enabled(some, button)
        .on_hover_text(fair)
        .on_click(RunAction::Fair, actions);
    let erase = "erase the selected faces and leave a hole";
    let button = wide_button(ui, "Erase only");
    ui.add_enabled(some, button)
        .on_click_with_key(erase, EditAction::Erase, actions);
    ui.separator();
    let button = wide_button(ui, REPAIR);
    repair_button(ui, model, button, actions);
}

/// The title of the button that repairs the whole mesh.
pub(crate) const REPAIR: &str = "Repair everything";

/// The button that repairs the whole mesh.
pub(crate) fn repair_button(
    ui: &mut Ui,
    model: &Model,
    button: egui::Button<'static>,
    actions: &mut Vec<Action>,
) {
    let tip = "remove loose parts, erase and refill faces that intersect others of their component, and fill \
               all holes (meniscus repair)";
    let idle = model.run.is_none() && !model.document.is_blank() && !is_repairing(model);
    ui.add_enabled(idle, button)
        .on_hover_text(tip)
        .on_click(EditAction::Repair, actions);
}

/// Whether the mouse selects faces.
pub(crate) fn is_active(model: &Model) -> bool {
    let picks = model.view.report.pick != Pick::Holes;
    model.view.task == Task::Repair && model.run.is_none() && !picks
}

/// Applies the tool. Returns whether it uses the primary button.
pub(crate) fn select(
    model: &Model,
    draft: &mut Option<Draft>,
    response: &Response,
    rect: Rect,
    actions: &mut Vec<Action>,
) -> bool {
    let Some((_, picker)) = model.picker.as_ref().filter(|_| is_active(model)) else {
        *draft = None;
        return false;
    };
    let input = |i: &egui::InputState| {
        (
            i.pointer.latest_pos(),
            i.modifiers,
            i.pointer.primary_pressed(),
        )
    };
    let (Some(at), keys, pressed) = response.ctx.input(input) else {
        return draft.is_some();
    };
    let canvas = Canvas {
        model,
        picker,
        rect,
    };
    let tool = model.view.selecting.tool;
    if pressed && response.contains_pointer() && !keys.alt {
        *draft = match tool {
            Tool::Brush => canvas.stamp(at).map(|_| Draft::Brush(at)),
            Tool::Lasso => Some(Draft::Lasso(vec![at])),
            Tool::Grow => None,
        };
        if matches!(draft, Some(Draft::Brush(_))) {
            canvas.paint(at, at, keys, actions);
        }
    }
    if response.dragged_by(PointerButton::Primary) {
        match draft {
            Some(Draft::Brush(last)) if *last != at => {
                canvas.paint(*last, at, keys, actions);
                *last = at;
            }
            Some(Draft::Lasso(line)) if line.last().is_none_or(|p| p.distance(at) >= 2.0) => {
                line.push(at);
            }
            Some(Draft::Brush(_) | Draft::Lasso(_)) | None => {}
        }
    }
    if response.drag_stopped_by(PointerButton::Primary) || response.clicked() {
        match draft.take() {
            Some(Draft::Lasso(line)) if line.len() > 2 => {
                actions.push(SelectAction::Faces(canvas.lasso(&line, keys)).into());
            }
            Some(Draft::Brush(_)) => actions.push(ControlsAction::EndDrag.into()),
            _ if tool == Tool::Grow && response.clicked() => {
                let size = canvas.size();
                if let Some(hit) = picker.surface(&model.view.camera, size, canvas.place(at)) {
                    let take = keys.command;
                    actions.push(
                        SelectAction::Faces(FaceEdit::Spread {
                            face: hit.face,
                            take,
                        })
                        .into(),
                    );
                }
            }
            Some(Draft::Lasso(_)) | None => {}
        }
        return true;
    }
    draft.is_some()
}

/// Draws the circle of the brush or the line of the lasso.
pub(crate) fn draw(ui: &Ui, model: &Model, draft: Option<&Draft>, response: &Response) {
    if !is_active(model) {
        return;
    }
    let painter = ui.painter();
    let ink = |width| {
        let take = ui.input(|i| i.modifiers.command);
        let color = if take {
            Color32::from_rgb(255, 120, 100)
        } else {
            Color32::from_rgb(110, 170, 255)
        };
        Stroke::new(width, color)
    };
    let shade = Stroke::new(3.5, Color32::from_black_alpha(140));
    match (model.view.selecting.tool, draft) {
        (Tool::Brush, _) => {
            if let Some(at) = response.hover_pos() {
                painter.circle_stroke(at, model.view.selecting.brush, shade);
                painter.circle_stroke(at, model.view.selecting.brush, ink(1.5));
            }
        }
        (Tool::Lasso, Some(Draft::Lasso(line))) => {
            let closed: Vec<Pos2> = line.iter().chain(line.first()).copied().collect();
            painter.add(egui::Shape::line(closed.clone(), shade));
            painter.add(egui::Shape::line(closed, ink(1.5)));
        }
        (Tool::Lasso | Tool::Grow, _) => {}
    }
}

/// A view with an active tool.
struct Canvas<'a> {
    model: &'a Model,
    picker: &'a Picker,
    rect: Rect,
}

impl Canvas<'_> {
    fn size(&self) -> [f64; 2] {
        [f64::from(self.rect.width()), f64::from(self.rect.height())]
    }

    fn place(&self, p: Pos2) -> [f64; 2] {
        [
            f64::from(p.x - self.rect.left()),
            f64::from(p.y - self.rect.top()),
        ]
    }

    /// The stamp of the brush at a point of the window.
    fn stamp(&self, at: Pos2) -> Option<BrushStamp> {
        let camera = &self.model.view.camera;
        let hit = self.picker.surface(camera, self.size(), self.place(at))?;
        let [x, y] = self.place(at);
        let beside = [x + f64::from(self.model.view.selecting.brush), y];
        let (origin, direction) = Projector::new(camera, self.size()).line_through(beside);
        // at the same depth on the neighbouring line of sight
        let forward = camera.forward();
        let depth = |p: DVec3| (p - origin).dot(forward);
        let other = origin + direction * (depth(hit.point) / direction.dot(forward));
        Some(BrushStamp {
            face: hit.face,
            point: hit.point,
            radius: other.distance(hit.point),
        })
    }

    /// Stamps between two points, close enough to leave no gaps.
    fn paint(&self, from: Pos2, to: Pos2, keys: Modifiers, actions: &mut Vec<Action>) {
        let spacing = (0.5 * self.model.view.selecting.brush).max(2.0);
        let count = (from.distance(to) / spacing).ceil().clamp(1.0, 64.0) as usize;
        let places = (1..=count).map(|i| from.lerp(to, i as f32 / count as f32));
        let stamps: Vec<BrushStamp> = places.filter_map(|p| self.stamp(p)).collect();
        if !stamps.is_empty() {
            let take = keys.command;
            actions.push(SelectAction::Faces(FaceEdit::Paint { stamps, take }).into());
        }
    }

    fn lasso(&self, line: &[Pos2], keys: Modifiers) -> FaceEdit {
        let far = line.iter().map(|p| p.distance(line[0])).fold(0.0, f32::max);
        if far <= CLICK {
            return FaceEdit::Paint {
                stamps: Vec::new(),
                take: false,
            };
        }
        FaceEdit::Lasso {
            lasso: Lasso {
                corners: line.iter().map(|&p| self.place(p)).collect(),
                size: self.size(),
                camera: self.model.view.camera,
                through: self.model.view.selecting.through,
            },
            take: keys.command,
        }
    }
}
