//! The panel of refinements.

use eframe::egui::{self, Ui};

use crate::app::action::{Action, RunAction, TaskAction};
use crate::app::model::Model;
use crate::app::run::method_name;
use crate::app::ui::format::grouped;
use crate::app::ui::widgets::{
    ClickActions, angle_limit, choice, pick_edges, row, slider, wide_primary,
};
use crate::app::view_state::Refining;
use crate::refine::{BoundaryRule, Hold, Method};

const METHODS: [(Method, &str); 3] = [
    (
        Method::Pde,
        "a flow places the new vertices: the limit surface interpolates the input vertices and \
         minimises the energy",
    ),
    (
        Method::Butterfly,
        "the modified Butterfly scheme: input vertices do not move; the surface is C1",
    ),
    (
        Method::Loop,
        "Loop's scheme: smooth, but input vertices move",
    ),
];

/// Levels, method, and methods to compare with.
pub(crate) fn refine_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let document = &model.document;
    let mut next = model.view.refining.clone();
    ui.horizontal(|ui| {
        ui.heading("Refine");
        ui.weak(format!("{} faces", grouped(document.mesh.face_count())));
    });
    ui.add_enabled_ui(model.run.is_none(), |ui| {
        levels_ui(ui, model, &mut next);
        let methods = METHODS.map(|(method, tip)| (method, method_name(method), tip));
        choice(ui, "Method", &mut next.controls.method, methods);
        row(ui, "Beside it", "methods to compare with", |ui, _| {
            for (method, tip) in METHODS
                .into_iter()
                .filter(|(m, _)| *m != next.controls.method)
            {
                let mut shown = next.beside.contains(&Some(method));
                if ui
                    .checkbox(&mut shown, method_name(method))
                    .on_hover_text(tip)
                    .changed()
                {
                    next.beside
                        .iter_mut()
                        .filter(|m| **m == Some(method))
                        .for_each(|m| *m = None);
                    if let (true, Some(free)) =
                        (shown, next.beside.iter_mut().find(|m| m.is_none()))
                    {
                        *free = Some(method);
                    }
                }
            }
        });
        // a method is not compared with itself
        let own = Some(next.controls.method);
        next.beside
            .iter_mut()
            .filter(|m| **m == own)
            .for_each(|m| *m = None);
        let mut own_energy = next.controls.energy.is_none();
        ui.checkbox(&mut own_energy, "Energy by edge length").on_hover_text(
            "curvature norm and area with weights adapted to the edge length of the mesh: keeps \
             edges, does not bulge between sparse vertices; off: the energy and the tension of the \
             controls at the right",
        );
        next.controls.energy = (!own_energy).then(|| document.controls.energy.clone());
        choice(
            ui,
            "Levels keep",
            &mut next.controls.hold,
            [
                (
                    Hold::Previous,
                    "all vertices",
                    "the surface interpolates all vertices of the previous level, as in the paper",
                ),
                (
                    Hold::Given,
                    "given ones",
                    "the surface interpolates only the vertices of the opened mesh, which is \
                     smoother",
                ),
            ],
        );
        choice(
            ui,
            "Boundaries",
            &mut next.controls.boundary,
            [
                (
                    BoundaryRule::Spline,
                    "spline",
                    "cubic B-splines through the vertices of boundaries and sharp edges",
                ),
                (BoundaryRule::Straight, "straight", "edges stay straight"),
            ],
        );
        sharp_ui(ui, model, &mut next, actions);
        let selected = document.faces.len();
        ui.add_enabled(
            selected > 0 || next.selected_only,
            egui::Checkbox::new(
                &mut next.selected_only,
                counted("Only selected faces", selected),
            ),
        )
        .on_hover_text("neighbouring faces are split to match; select faces in task Repair (F4)");
    });
    if next != model.view.refining {
        actions.push(TaskAction::Refining(Box::new(next)).into());
    }
    ui.separator();
}

fn levels_ui(ui: &mut Ui, model: &Model, next: &mut Refining) {
    let tip = "number of levels; each splits every triangle into four";
    row(ui, "Levels", tip, |ui, label| {
        let levels = slider(&mut next.controls.levels, 1..=6);
        ui.add(levels).labelled_by(label).on_hover_text(tip);
    });
    let document = &model.document;
    let after = next.faces_after(document.mesh.face_count(), document.faces.len());
    ui.weak(format!("{} faces afterwards", grouped(after as usize)));
}

/// The choice of sharp edges.
fn sharp_ui(ui: &mut Ui, model: &Model, next: &mut Refining, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        let tip = "edges with a larger dihedral angle stay sharp: they become curves with a smooth \
                   surface on each side";
        angle_limit(ui, "Sharp edges", tip, &mut next.controls.crease_angle);
    });
    ui.horizontal_wrapped(|ui| {
        let count: usize = (model.view.report.chains.iter())
            .map(|c| c.edges.len())
            .sum();
        ui.add_enabled(
            count > 0 || next.chosen_edges,
            egui::Checkbox::new(&mut next.chosen_edges, counted("Picked edges sharp", count)),
        )
        .on_hover_text("the edges picked here or for the report stay sharp");
        let tip = "a click adds an edge and its continuations, or removes them";
        next.chosen_edges |= pick_edges(ui, model.view.report.pick, tip, actions);
    });
    let selected = model.document.faces.len();
    ui.add_enabled(
        selected > 0 || next.selection_rim,
        egui::Checkbox::new(
            &mut next.selection_rim,
            counted("Border of selection sharp", selected),
        ),
    )
    .on_hover_text("stays sharp; select faces in task Repair (F4)");
}

/// A title with the number of what it is about, if there is any.
fn counted(title: &str, count: usize) -> String {
    match count {
        0 => title.to_owned(),
        _ => format!("{title} ({count})"),
    }
}

/// The button that starts the refinement.
pub(crate) fn start_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let button = wide_primary(ui, "Refine the mesh");
    let some = model.document.mesh.face_count() > 0;
    ui.add_enabled(some, button)
        .key_tip(
            "split every triangle into four, level by level",
            RunAction::Proceed,
        )
        .on_click(RunAction::Start, actions);
}
