//! The selection of loops and of faces.

use std::sync::Arc;

use crate::app::action::{Action, SelectHow};
use crate::app::faces::{FaceEdit, catch, edited};
use crate::app::jobs::Job;
use crate::app::model::{Done, Model};
use crate::app::view_state::Task;
use crate::fill::LoopChoice;

/// Carries out the actions of this kind.
pub fn update(model: &mut Model, action: Action) {
    let action = match action {
        Action::Hover(hover) => {
            model.view.hover = hover;
            return;
        }
        Action::Selecting(selecting) => {
            model.view.selecting = selecting;
            return;
        }
        Action::Refining(refining) => {
            model.view.refining = *refining;
            return;
        }
        action => action,
    };
    if model.is_busy("selecting something else") {
        return;
    }
    match action {
        Action::Task(task) => {
            model.view.task = task;
            model.view.bridging = None;
            model.view.hover = None;
        }
        Action::Faces(edit) => faces(model, edit),
        Action::Bridging(bridging) => model.view.bridging = bridging,
        _ => loops(model, &action),
    }
}

fn faces(model: &mut Model, edit: FaceEdit) {
    match edit {
        FaceEdit::Lasso { lasso, take } => {
            let Some((mesh, picker)) = model.picker.clone() else {
                return;
            };
            model.jobs.push(Job::spawn("lasso", &model.wake, move |_| {
                let faces = catch(&mesh, &picker, &lasso);
                Done::Caught(FaceEdit::Caught { mesh, faces, take })
            }));
            return;
        }
        // the mesh has changed since the lasso was drawn
        FaceEdit::Caught { ref mesh, .. } if !Arc::ptr_eq(mesh, &model.document.mesh) => return,
        _ => {}
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

fn loops(model: &mut Model, action: &Action) {
    if matches!(model.view.task, Task::Repair | Task::Refine) {
        if matches!(action, Action::SelectNone) {
            faces(model, FaceEdit::Clear);
        }
        return;
    }
    let mut selection = model.document.selection.clone();
    let label = match action {
        Action::Select(id, _) if model.document.loop_of(*id).is_none() => return,
        // the rims of a blend are gathered one by one
        Action::Select(id, SelectHow::Replace) if model.view.task == Task::Blend => {
            if !selection.remove(id) {
                selection.insert(*id);
            }
            "gather a rim"
        }
        Action::Select(id, SelectHow::Replace) => {
            selection = [*id].into();
            "select a loop"
        }
        Action::Select(id, SelectHow::Add) => {
            selection.insert(*id);
            "add a loop"
        }
        Action::Select(id, SelectHow::Toggle) => {
            if !selection.remove(id) {
                selection.insert(*id);
            }
            "toggle a loop"
        }
        Action::SelectAll if model.view.task == Task::Blend && model.document.holes().len() < 2 => {
            selection = model.document.chosen(&LoopChoice::All);
            "select all rims"
        }
        Action::SelectAll => {
            selection = model.document.holes();
            "select all holes"
        }
        Action::SelectAllButLargest => {
            selection = model.document.chosen(&LoopChoice::AllButLargest);
            "select all but the largest"
        }
        _ => {
            selection.clear();
            "clear the selection"
        }
    };
    model.select(selection, label);
}
