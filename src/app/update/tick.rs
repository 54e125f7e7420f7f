//! Background updates: jobs, runs, and display requests.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{files, pictures, repair, report, runs, select};
use crate::app::action::SelectAction;
use crate::app::cached::SharedKey;
use crate::app::display::{Continued, Request};
use crate::app::jobs::Job;
use crate::app::model::{CreaseKey, Done, Effect, Model};
use crate::app::run::RunVariant;
use crate::app::view_state::Task;
use crate::fill::Continuity;
use crate::mesh::{BoundaryLoop, VertexId};
use crate::render::Picker;

/// Advances all background work. Returns the maximum time until the next call.
pub fn tick(model: &mut Model, now: Instant) -> Option<Duration> {
    let until_toast = model.log.next_change(now);
    finish_jobs(model);
    let own = &model.document.mesh.attributes.own_materials;
    if let Some(textures) = model.textures.with_own(own) {
        model.textures = Arc::new(textures);
    }
    model.view.camera.cut = model.view.report.hidden_half();
    let mut until_frame = None;
    if let Some(run) = &mut model.run {
        for (level, text) in run.poll() {
            model.log.note(level, text);
        }
        until_frame = run.replay(model.view.pace, now);
    }
    request_displays(model);
    request_picker(model);
    report::tick(model);
    let until_autosave = model.autosave.tick(
        now,
        model.revision,
        model.is_dirty(),
        &model.document,
        &model.view,
        &model.wake,
    );
    for text in model.autosave.take_errors() {
        model.log.warning(text);
    }
    [until_toast, until_frame, until_autosave]
        .into_iter()
        .flatten()
        .min()
}

fn finish_jobs(model: &mut Model) {
    let mut i = 0;
    while i < model.jobs.len() {
        let Some(result) = model.jobs[i].poll() else {
            i += 1;
            continue;
        };
        let job = model.jobs.remove(i);
        match result {
            Ok(done) => finish(model, done),
            Err(text) => {
                model.log.error(text);
                if let Some(run) = model.run.as_mut().filter(|_| job.what == runs::TEXTURES) {
                    run.accepting = None;
                }
            }
        }
    }
}

fn finish(model: &mut Model, done: Done) {
    match done {
        Done::Loaded(path, result) => files::loaded(model, &path, result),
        Done::Saved(path, what, result) => files::saved(model, path, what, result),
        Done::Picker(mesh, picker) => {
            if Arc::ptr_eq(&mesh, &model.document.mesh) {
                model.picker = Some((mesh, picker));
            }
        }
        Done::Textures(origin, mode, textures, notes) => {
            files::textures_read(model, &origin, mode, textures, notes);
        }
        Done::Accepted(state, mesh, warnings) => runs::accepted(model, &state, *mesh, warnings),
        Done::Repaired(base, result) => repair::repaired(model, &base, result),
        Done::Faces(edit) => select::update(model, SelectAction::Faces(edit)),
        Done::PathChosen(purpose, path, waited) => {
            files::path_chosen(model, purpose, path, waited);
        }
        Done::PicturePath(path, waited) => pictures::path_chosen(model, path, waited),
        Done::Picture(Ok(picture)) => {
            model.effects.push(Effect::CopyImage(picture));
            model.log.info("picture copied to the clipboard");
        }
        Done::Pictures(result, settings) => pictures::written(model, result, *settings),
        Done::Picture(Err(text)) => model.log.error(text),
    }
}

/// Number of faces from which the surfaces of an opened mesh are made only once, with its texture images.
const MANY: usize = 50_000;

/// Requests the current displays.
fn request_displays(model: &mut Model) {
    for display in &mut model.displays {
        display.poll();
    }
    let is_read = |job: &Job<Done>| job.what == files::TEXTURES;
    if model.displays[0].latest().is_none()
        && model.document.mesh.face_count() > MANY
        && model.jobs.iter().any(is_read)
    {
        return;
    }
    for i in 0..model.sides() {
        let request = request(model, i);
        model.displays[i].request(request);
    }
}

fn request_picker(model: &mut Model) {
    let mesh = Arc::clone(&model.document.mesh);
    if model
        .picker_asked
        .as_ref()
        .is_some_and(|m| Arc::ptr_eq(m, &mesh))
    {
        return;
    }
    model.picker_asked = Some(Arc::clone(&mesh));
    let loops = Arc::clone(&model.document.loops);
    model.spawn("picking", move |_| {
        let picker = Picker::new(&mesh.positions, &mesh.topology, &loops);
        Done::Picker(mesh, Arc::new(picker))
    });
}

/// The display request of the document or of a side of the run.
fn request(model: &mut Model, side: usize) -> Request {
    let creases = creases(model);
    let document = &model.document;
    let run = model.run.as_ref();
    let shown = run.and_then(|r| r.sides.get(side));
    let controls = shown.map_or(&document.controls, |s| &s.controls);
    let rims = document.selected();
    let rims = rims.iter().map(|l| l.radius).fold(0.0, f64::max);
    let radius = shown.map_or(rims, |s| s.handle.radius());
    let energy = model.energies[side].of(controls);
    let (mut mesh, mut first_patch_face) = (&document.mesh, document.first_patch_face);
    let mut newest = document.newest_patch();
    let mut faired = Arc::default();
    if let Some(run) = run {
        (mesh, first_patch_face) = (&run.base, run.first_patch_face);
        newest = run.base.face_count()..usize::MAX;
        faired = run.faired();
    }
    // an accepted refinement is drawn as its limit surface until the next run
    let is_there = Arc::ptr_eq(mesh, &document.mesh);
    let accepted = document.surface.clone().filter(|_| is_there);
    let state = shown.and_then(RunVariant::state).or(accepted);
    let repairs = model.view.task == Task::Repair && run.is_none();
    // what is drawn at the end of a run is what will be accepted
    let is_last = run.is_none_or(|run| run.ended() && !run.scrubbed());
    let continued = if !(model.has_colors() && model.view.style.shows_colors()) {
        Continued::No
    } else if is_last {
        Continued::WithShape
    } else {
        Continued::WithTriangulation
    };
    Request {
        mesh: Arc::clone(mesh),
        faired,
        highlight: if repairs {
            Arc::clone(&document.faces)
        } else {
            Arc::default()
        },
        start: shown
            .zip(state.as_ref())
            .and_then(|(s, at)| s.handle.start_of(at)),
        state,
        first_patch_face,
        newest,
        creases,
        limit: model.view.limit_surface,
        original: model.view.show_original,
        centre: model.centre(),
        bounds: document.origin.bounds,
        energy: energy.filter(|_| radius > 0.0).map(|e| (e, radius)),
        reference: model.report.shown_reference(model.view.style.mode),
        textures: Arc::clone(&model.textures),
        continued,
    }
}

/// Edges of the rims that the run joins with a crease.
fn creases(model: &mut Model) -> Arc<Vec<[VertexId; 2]>> {
    let run = model.run.as_ref();
    let side = run.and_then(|run| Some((run, run.sides.first()?)));
    let sharp: Vec<&BoundaryLoop> = side.map_or_else(Vec::new, |(run, side)| {
        let is_sharp = |l: &&BoundaryLoop| side.controls.continuity_at(l.id) == Continuity::G0;
        run.loops.iter().filter(is_sharp).collect()
    });
    let key = CreaseKey {
        // without creases there is one list for all meshes
        base: run
            .filter(|_| !sharp.is_empty())
            .map(|run| SharedKey::of(&run.base)),
        loops: sharp.iter().map(|l| l.id).collect(),
    };
    let edges = || Arc::new(sharp.iter().flat_map(|l| l.edge_ends()).collect());
    model.creases.get(key, edges)
}
