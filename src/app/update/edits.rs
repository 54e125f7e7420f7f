//! Undo, and changes of the mesh without a flow.

use std::sync::Arc;

use super::refuse_while_running;
use super::runs::accept;
use crate::app::action::EditAction;
use crate::app::document::{Accepted, Work};
use crate::app::model::Model;
use crate::fill::{bridge as build_bridge, segment_at};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, erase as erase_faces, face_flags};
use crate::runner::Schedule;

pub(crate) fn update(model: &mut Model, action: EditAction) {
    match action {
        EditAction::Undo => undo(model),
        EditAction::Redo => redo(model),
        EditAction::Erase => erase(model),
        EditAction::Flip(id) => flip(model, id),
        EditAction::Bridge(ends, width) => bridge(model, ends, width),
    }
}

/// In the middle of a run its shown state is accepted first, so that a redo brings it back.
fn undo(model: &mut Model) {
    if model.run.is_some() {
        accept(model, 0);
        model.run = None;
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
    model.view.hover = None;
    model.log.info(message);
}

/// The selected faces, if there are any.
pub(crate) fn selected_faces(model: &mut Model) -> Option<Arc<Vec<u32>>> {
    if refuse_while_running(model, "changing something else") {
        return None;
    }
    if model.document.faces.is_empty() {
        model
            .log
            .warning("no face is selected: paint over the place with the brush, or use the lasso");
        return None;
    }
    Some(Arc::clone(&model.document.faces))
}

/// Takes in what needs no flow.
fn accept_at_once(model: &mut Model, work: Work, mesh: Mesh, kept: Option<&[u32]>) {
    let label = work.label();
    model.history.record(&model.document, label.clone(), None);
    let end = mesh.face_count();
    // only what is there already may be erased
    let start = match kept {
        Some(_) => end,
        None => model.document.mesh.face_count(),
    };
    let done = Accepted {
        work,
        controls: model.document.controls.clone(),
        schedule: Schedule::default(),
        faces: start..end,
    };
    model.document.accept(mesh, kept, done);
    model.revision += 1;
    model.view.hover = None;
    model.log.info(label);
}

fn erase(model: &mut Model) {
    let Some(faces) = selected_faces(model) else {
        return;
    };
    let mesh = &model.document.mesh;
    if faces.len() == mesh.face_count() {
        model
            .log
            .warning("all faces are selected: nothing would be left; Ctrl takes faces away");
        return;
    }
    let erased = erase_faces(mesh, &face_flags(&faces, mesh.face_count()));
    accept_at_once(
        model,
        Work::Erase(faces),
        erased.mesh,
        Some(&erased.old_face),
    );
}

/// Builds a strip between two rim vertices.
fn bridge(model: &mut Model, ends: [DVec3; 2], width: usize) {
    if model.run.is_some() {
        return;
    }
    let (mesh, loops) = (&model.document.mesh, &model.document.loops);
    let [Some(from), Some(to)] = ends.map(|p| segment_at(mesh, loops, p, width)) else {
        return;
    };
    match build_bridge(mesh, loops, from, to) {
        Ok(bridged) => {
            accept_at_once(model, Work::Bridge(ends, width), bridged, None);
            model.view.bridging = None;
        }
        Err(error) => model.log.error(error.to_string()),
    }
}

/// Flips the component of a loop.
fn flip(model: &mut Model, id: LoopId) {
    if refuse_while_running(model, "changing something else") {
        return;
    }
    let Some(l) = model.document.loop_of(id) else {
        return;
    };
    let mesh = model.document.mesh.with_flipped(&[l.component]);
    let work = Work::Flip(id);
    let gathered = model.document.selected();
    let places: Vec<DVec3> = gathered.iter().map(|l| l.centroid).collect();
    accept_at_once(model, work, mesh, None);
    // the same rims stay selected; their numbers may have changed
    let loops = &model.document.loops;
    let nearest = |p: &DVec3| {
        let far = |l: &BoundaryLoop| l.centroid.distance_squared(*p);
        let found = loops.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        found.map(|l| l.id)
    };
    model.document.selection = places.iter().filter_map(nearest).collect();
}
