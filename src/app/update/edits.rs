//! Undo, and changes of the mesh without a flow.

use std::sync::Arc;

use super::refuse_while_running;
use super::repair;
use super::runs::accept;
use crate::app::action::EditAction;
use crate::app::model::Model;
use crate::fill::bridge_warning;
use crate::mesh::{BoundaryLoop, DVec3, LoopId};
use crate::ops::{BridgeSpec, CleanSpec, EraseSpec, FlipSpec, Operation, StitchSpec};

pub(crate) fn update(model: &mut Model, action: EditAction) {
    match action {
        EditAction::Undo => undo(model),
        EditAction::Redo => redo(model),
        EditAction::Erase => erase(model),
        EditAction::Flip(id) => flip(model, id),
        EditAction::Bridge(ends, width) => bridge(model, ends, width),
        EditAction::Clean => clean(model, Operation::Clean(CleanSpec::default())),
        EditAction::Stitch => clean(model, Operation::Stitch(StitchSpec::default())),
        EditAction::Repair => repair::start(model),
        EditAction::CancelRepair => {
            repair::cancel(model);
        }
    }
}

/// During a run the shown state is accepted first, so that a redo restores it.
fn undo(model: &mut Model) {
    if model.run.is_some() {
        accept(model, 0);
        if let Some(accepting) = model.accepting() {
            accepting.then.push(EditAction::Undo.into());
            return;
        }
        model.run = None;
    }
    if let Some(run) = model.take_rejected() {
        model.run = Some(run);
        model
            .log
            .info("the rejected patch is back: accept or reject it");
        return;
    }
    match model.history.undo(&mut model.document) {
        Some(label) => after_travel(model, &format!("undone: {label}")),
        None => model.log.info("nothing to undo"),
    }
}

fn redo(model: &mut Model) {
    if refuse_while_running(model, "redoing") {
        return;
    }
    match model.history.redo(&mut model.document) {
        Some(label) => after_travel(model, &format!("redone: {label}")),
        None => model.log.info("nothing to redo"),
    }
}

fn after_travel(model: &mut Model, message: &str) {
    model.revision += 1;
    model
        .view
        .energy_text
        .clone_from(&model.document.controls.energy);
    model.view.hover.clear();
    model.log.info(message);
}

/// The selected faces, if there are any.
pub(crate) fn selected_faces(model: &mut Model) -> Option<Arc<Vec<u32>>> {
    if refuse_while_running(model, "other changes") {
        return None;
    }
    if model.document.faces.is_empty() {
        model
            .log
            .warning("no face is selected: use the brush or the lasso");
        return None;
    }
    Some(Arc::clone(&model.document.faces))
}

/// Applies an operation without a flow. Returns whether it succeeded.
fn apply(model: &mut Model, operation: Operation) -> bool {
    let outcome = match operation.run(&model.document.mesh, &|_, _| true) {
        Ok(outcome) => outcome,
        Err(error) => {
            model.log.error(error.to_string());
            return false;
        }
    };
    let label = operation.label();
    let (before, after) = (&model.document.mesh, outcome.mesh());
    if *after == **before {
        model
            .log
            .info(format!("{label}: none found; the mesh is unchanged"));
        return false;
    }
    let removed = before.face_count().saturating_sub(after.face_count());
    let joined = before.vertex_count().saturating_sub(after.vertex_count());
    model.history.record(&model.document, label.clone(), None);
    model.document.accept_outcome(operation, outcome);
    model.revision += 1;
    model.view.hover.clear();
    model.log.info(match (removed, joined) {
        (0, 0) => label,
        (0, vertices) => format!("{label}: {vertices} vertices joined"),
        (faces, vertices) => format!("{label}: {faces} faces and {vertices} vertices removed"),
    });
    true
}

/// Applies an operation that cleans the mesh.
fn clean(model: &mut Model, operation: Operation) {
    if !refuse_while_running(model, "other changes") {
        apply(model, operation);
    }
}

fn erase(model: &mut Model) {
    let Some(faces) = selected_faces(model) else {
        return;
    };
    let mesh = &model.document.mesh;
    if faces.len() == mesh.face_count() {
        model
            .log
            .warning("all faces are selected and none would remain: deselect some with Ctrl");
        return;
    }
    apply(model, Operation::Erase(EraseSpec { faces }));
}

/// Builds a bridge between two rim vertices.
fn bridge(model: &mut Model, ends: [DVec3; 2], width: usize) {
    if model.run.is_some() {
        return;
    }
    let before = Arc::clone(&model.document.mesh);
    if apply(model, Operation::Bridge(BridgeSpec { ends, width })) {
        model.view.bridging = None;
        if let Some(warning) = bridge_warning(&before, &model.document.mesh) {
            model.log.warning(warning.to_string());
        }
    }
}

/// Flips the component of a loop.
fn flip(model: &mut Model, id: LoopId) {
    if refuse_while_running(model, "other changes") {
        return;
    }
    let selected = model.document.selected();
    let places: Vec<DVec3> = selected.iter().map(|l| l.centroid).collect();
    if !apply(model, Operation::Flip(FlipSpec { loops: vec![id] })) {
        return;
    }
    // keep the same rims selected; their numbers may have changed
    let loops = &model.document.loops;
    let nearest = |p: &DVec3| {
        let far = |l: &BoundaryLoop| l.centroid.distance_squared(*p);
        let found = loops.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        found.map(|l| l.id)
    };
    model.document.selection = places.iter().filter_map(nearest).collect();
}
