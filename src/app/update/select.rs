//! The task, and the selection of loops and faces.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::refuse_while_running;
use crate::app::action::{SelectAction, SelectHow, TaskAction};
use crate::app::faces::{FaceEdit, Lasso, edited, faces_in_lasso};
use crate::app::model::{Done, Model};
use crate::app::view_state::Task;
use crate::fill::LoopChoice;
use crate::mesh::{BoundaryLoop, Flaw, LoopId, face_list, flawed_faces};

pub(crate) fn update_task(model: &mut Model, action: TaskAction) {
    match action {
        TaskAction::Choose(task) => {
            if !refuse_while_running(model, "changing the selection") {
                model.view.task = task;
                model.view.bridging = None;
                model.view.part = None;
                model.view.hover.clear();
            }
        }
        TaskAction::Bridging(bridging) => {
            if !refuse_while_running(model, "changing the selection") {
                model.view.bridging = bridging;
                model.view.part = None;
            }
        }
        TaskAction::Part(part) => {
            if !refuse_while_running(model, "changing the selection") {
                model.view.part = part;
                model.view.bridging = None;
            }
        }
        TaskAction::Selecting(selecting) => model.view.selecting = selecting,
        TaskAction::Refining(refining) => model.view.refining = *refining,
        TaskAction::Limits(limits) => model.view.limits = limits,
        TaskAction::Islands(islands) => model.view.islands = islands,
        TaskAction::List(list) => model.view.list = list,
    }
}

pub(crate) fn update(model: &mut Model, action: SelectAction) {
    if refuse_while_running(model, "changing the selection") {
        return;
    }
    let document = &model.document;
    let task = model.view.task;
    let is_about_faces = matches!(task, Task::Repair | Task::Refine);
    let mut selection = document.selection.clone();
    let label = match action {
        SelectAction::Faces(edit) => return faces(model, edit),
        SelectAction::None if is_about_faces => return faces(model, FaceEdit::Clear),
        SelectAction::Loop(..)
        | SelectAction::Several(_)
        | SelectAction::Similar(_)
        | SelectAction::All
        | SelectAction::AllButLargest
            if is_about_faces =>
        {
            return;
        }
        SelectAction::Several(ids) => {
            selection.extend(ids.iter().filter(|&&id| document.loop_of(id).is_some()));
            "select a range of loops"
        }
        SelectAction::Similar(id) => {
            let Some(like) = document.loop_of(id) else {
                return;
            };
            let alike = document.loops.iter().filter(|l| is_similar(l, like));
            selection.extend(alike.map(|l| l.id));
            "select similar loops"
        }
        SelectAction::Loop(id, _) if document.loop_of(id).is_none() => return,
        // rims of a blend are added one by one
        SelectAction::Loop(id, SelectHow::Replace) if task == Task::Blend => {
            toggle(&mut selection, id);
            "add a rim"
        }
        SelectAction::Loop(id, SelectHow::Replace) => {
            selection = [id].into();
            "select a loop"
        }
        SelectAction::Loop(id, SelectHow::Add) => {
            selection.insert(id);
            "add a loop"
        }
        SelectAction::Loop(id, SelectHow::Toggle) => {
            toggle(&mut selection, id);
            "toggle a loop"
        }
        SelectAction::All if task == Task::Blend && document.holes().len() < 2 => {
            selection = document.chosen(&LoopChoice::All);
            "select all rims"
        }
        SelectAction::All => {
            selection = within_limits(model, document.holes());
            "select all holes"
        }
        SelectAction::AllButLargest => {
            selection = within_limits(model, document.chosen(&LoopChoice::AllButLargest));
            "select all but the largest"
        }
        SelectAction::None => {
            selection.clear();
            "clear the selection"
        }
    };
    set_loops(model, selection, label);
}

/// Whether two loops are of the same kind and differ by at most a quarter in edges and diameter.
fn is_similar(a: &BoundaryLoop, b: &BoundaryLoop) -> bool {
    let near = |x: f64, y: f64| (x - y).abs() <= 0.25 * x.max(y);
    a.is_outer_boundary == b.is_outer_boundary
        && near(a.edges() as f64, b.edges() as f64)
        && near(a.diameter, b.diameter)
}

/// The loops that do not exceed the limits.
pub(super) fn within_limits(model: &Model, mut loops: BTreeSet<LoopId>) -> BTreeSet<LoopId> {
    if model.view.task == Task::Fill {
        let exceeded = |l: &BoundaryLoop| model.view.limits.exceeded(l).is_some();
        loops.retain(|&id| !model.document.loop_of(id).is_some_and(exceeded));
    }
    loops
}

fn toggle(selection: &mut BTreeSet<LoopId>, id: LoopId) {
    if !selection.remove(&id) {
        selection.insert(id);
    }
}

/// Changes the selection of loops and adds an undo entry.
pub(super) fn set_loops(model: &mut Model, selection: BTreeSet<LoopId>, label: &str) {
    if selection != model.document.selection {
        model.history.record(&model.document, label, None);
        model.document.selection = selection;
    }
}

fn faces(model: &mut Model, edit: FaceEdit) {
    match edit {
        FaceEdit::Lasso { lasso, take } => return start_lasso(model, lasso, take),
        FaceEdit::Flawed(flaw) => return find_flaws(model, flaw),
        FaceEdit::Paint { .. }
        | FaceEdit::Found { .. }
        | FaceEdit::Spread { .. }
        | FaceEdit::Grow
        | FaceEdit::Shrink
        | FaceEdit::Invert
        | FaceEdit::Smooth
        | FaceEdit::Clear => {}
    }
    // the mesh may have changed since the search began
    if matches!(&edit, FaceEdit::Found { mesh, .. } if !Arc::ptr_eq(mesh, &model.document.mesh)) {
        return;
    }
    if matches!(&edit, FaceEdit::Found { faces, .. } if faces.is_empty()) {
        model.log.info("no such faces were found");
    }
    let stroke = matches!(edit, FaceEdit::Paint { .. }).then(|| edit.label());
    if stroke.is_none() {
        model.history.seal();
    }
    let faces = edited(&model.document, &edit);
    if faces != *model.document.faces {
        model.history.record(&model.document, edit.label(), stroke);
        model.document.faces = Arc::new(faces);
    }
}

/// Finds the faces in a lasso in the background.
fn start_lasso(model: &mut Model, lasso: Lasso, take: bool) {
    if let Some((mesh, picker)) = model.picker.clone() {
        model.spawn("lasso", move |_| {
            let faces = faces_in_lasso(&mesh, &picker, &lasso);
            Done::Faces(FaceEdit::Found { mesh, faces, take })
        });
    }
}

/// Finds the faces with a flaw in the background.
fn find_flaws(model: &mut Model, flaw: Flaw) {
    let mesh = Arc::clone(&model.document.mesh);
    model.spawn("flawed faces", move |_| {
        let faces = face_list(&flawed_faces(&mesh, flaw));
        let take = false;
        Done::Faces(FaceEdit::Found { mesh, faces, take })
    });
}
