//! Runs.

use std::sync::Arc;

use super::controls::params_for;
use super::{act, edits, refuse_while_running, select};
use crate::app::action::RunAction;
use crate::app::document::{AppliedOperation, window_controls};
use crate::app::model::{Done, Model, Rejected};
use crate::app::run::{Accepting, Run, RunState, state_key};
use crate::app::view_state::{Modal, Part, Task};
use crate::energy::Energy;
use crate::fill::{Controls, Surface};
use crate::mesh::{LoopId, Mesh};
use crate::ops::{BlendSpec, FacesSpec, FillPartSpec, FillSpec, FlowSpec, Operation};

/// The job that makes the mesh of an accepted state.
pub(super) const TEXTURES: &str = "textures of the patches";

/// A refinement to more faces than this is started only after a question.
const LARGE: u64 = 500_000;

pub(crate) fn update(model: &mut Model, action: RunAction) {
    if model.run.is_none() && refuse_while_running(model, "a fill") {
        return;
    }
    match action {
        RunAction::Proceed => match &model.run {
            Some(run) if run.ended() => accept(model, 0),
            Some(_) => {}
            None => start(model),
        },
        RunAction::Start => start(model),
        RunAction::StartLarge => {
            model.view.modal = Modal::None;
            refine(model);
        }
        RunAction::Fair => {
            if let Some(faces) = edits::selected_faces(model) {
                spawn(model, |flow| {
                    let faces = Arc::clone(&faces);
                    Operation::Fair(FacesSpec { faces, flow })
                });
            }
        }
        RunAction::PlayPause => play_pause(model),
        RunAction::Step => step(model),
        RunAction::StepBack => {
            if let Some(run) = &mut model.run {
                let last = run.state_count().saturating_sub(1);
                let shown = run.sides.iter().filter_map(|s| s.shown).min();
                run.scrub(Some(shown.unwrap_or(last).saturating_sub(1)));
            }
        }
        RunAction::Finish => {
            on_sides(model, |side| {
                side.shown = None;
                side.handle.finish();
            });
            if let Some(run) = &mut model.run {
                run.stopped = false;
            }
        }
        RunAction::Stop => {
            on_sides(model, |side| side.handle.stop());
            if let Some(run) = &mut model.run {
                run.playing = false;
                run.stopped = true;
            }
        }
        RunAction::Scrub(at) => {
            if let Some(run) = &mut model.run {
                run.scrub(at);
            }
        }
        RunAction::ContinueFromShown => continue_from_shown(model),
        RunAction::Pace(pace) => {
            model.view.pace = pace;
            on_sides(model, |side| side.handle.set_pace(pace));
        }
        RunAction::Accept(side) => accept(model, side),
        RunAction::Reject => reject(model),
    }
}

fn on_sides(model: &mut Model, f: impl Fn(&mut crate::app::run::RunVariant)) {
    if let Some(run) = &mut model.run {
        for side in &mut run.sides {
            f(side);
        }
    }
}

fn reject(model: &mut Model) {
    let Some(run) = model.run.take() else { return };
    if run.accepting.is_some() {
        model.jobs.retain(|job| job.what != TEXTURES);
    }
    // a flow that has not ended would go on in its thread
    let is_kept = run.ended() && run.accepting.is_none() && run.state_count() > 0;
    // the warnings were about what is gone
    model.log.settle();
    let undo = if is_kept {
        ", and Undo brings it back"
    } else {
        ""
    };
    let noun = run.noun();
    model.log.info(format!(
        "the {noun} was rejected{undo}; the mesh is unchanged"
    ));
    model.rejected = is_kept.then(|| Rejected::new(run, &model.document));
}

/// Starts the task. A fill with nothing selected fills all holes.
fn start(model: &mut Model) {
    if model.run.is_some() {
        return;
    }
    model.view.bridging = None;
    if let Some(part) = model.view.part {
        start_part(model, part);
        return;
    }
    if model.view.task == Task::Refine {
        let document = &model.document;
        let (all, selected) = (document.mesh.face_count(), document.faces.len());
        match model.view.refining.faces_after(all, selected) {
            faces if faces > LARGE => {
                let estimate = model.view.refining.estimate(all, selected);
                model.view.modal = Modal::Large(faces, estimate);
            }
            _ => refine(model),
        }
        return;
    }
    if model.view.task == Task::Repair {
        if let Some(faces) = edits::selected_faces(model) {
            spawn(model, |flow| {
                let faces = Arc::clone(&faces);
                Operation::Refill(FacesSpec { faces, flow })
            });
        }
        return;
    }
    if model.document.selection.is_empty() && model.view.task == Task::Fill {
        let holes = select::within_limits(model, model.document.holes());
        if holes.is_empty() {
            model.log.warning(if model.document.loops.is_empty() {
                "the mesh is closed: there is nothing to fill"
            } else if !model.document.holes().is_empty() {
                "all holes exceed the limits: click one to fill it nevertheless"
            } else {
                "all loops are classified as outer boundaries: click one to fill it nevertheless"
            });
            return;
        }
        select::set_loops(model, holes, "select all holes");
    }
    let task = model.view.task;
    if task == Task::Blend && model.document.selection.len() < 2 {
        model
            .log
            .warning("a blend joins at least two rims: click them, or select all with Ctrl+A");
        return;
    }
    let loops: Vec<LoopId> = model.document.selection.iter().copied().collect();
    let islands = model.view.islands;
    let bridges = Arc::new(model.document.bridge_faces());
    spawn(model, |flow| {
        let loops = loops.clone();
        match task {
            Task::Blend => Operation::Blend(BlendSpec { loops, flow }),
            _ => Operation::Fill(FillSpec {
                loops,
                islands,
                bridges: Arc::clone(&bridges),
                flow,
            }),
        }
    });
}

/// Starts the fill of part of a hole.
fn start_part(model: &mut Model, part: Part) {
    let (Some(from), Some(to)) = (part.from, part.to) else {
        model
            .log
            .warning("click the two rim vertices between which the hole is to be filled");
        return;
    };
    spawn(model, |flow| {
        let ends = [from, to];
        Operation::FillPart(FillPartSpec { ends, flow })
    });
    if model.run.is_some() {
        model.view.part = None;
    }
}

fn refine(model: &mut Model) {
    let refining = &model.view.refining;
    if refining.selected_only && model.document.faces.is_empty() {
        model
            .log
            .warning("no face is selected: select some in task Repair, or refine all of the mesh");
        return;
    }
    let (document, controls) = (&model.document, &model.document.controls);
    let (pace, wake) = (model.view.pace, &model.wake);
    let chains = &model.view.report.chains;
    match Run::start_refinement(refining, chains, document, controls, pace, wake) {
        Ok(run) => show(model, run),
        Err(text) => model.log.error(text),
    }
}

/// Shows a run that was started.
fn show(model: &mut Model, run: Run) {
    // side-by-side views are narrower than a single one
    model.view.fit |= run.sides.len() > 1;
    // such as the question for a selection
    model.log.settle();
    model.rejected = None;
    model.run = Some(run);
}

/// Starts an operation, and a second one if another energy is compared. A typed energy that is invalid is not
/// ignored.
fn spawn(model: &mut Model, operation: impl Fn(FlowSpec) -> Operation) {
    if !has_valid_energy(model) {
        return;
    }
    let a = model.document.controls.clone();
    let mut sides = vec![operation(a.clone().into())];
    if let Some(compared) = &model.view.compared {
        let b = Controls {
            energy: compared.text.clone(),
            param: compared.param.clone(),
            surface: Surface::Energy,
            ..a
        };
        sides.push(operation(b.into()));
    }
    match Run::start(&sides, &model.document, model.view.pace, &model.wake) {
        Ok(run) => show(model, run),
        Err(text) => model.log.error(text),
    }
}

/// Whether the typed energy is valid; logs the error otherwise.
pub(super) fn has_valid_energy(model: &mut Model) -> bool {
    let text = model.view.energy_text.trim();
    let params = params_for(text, &model.document.controls.param);
    let parsed = Energy::parse(text, &params);
    if let Err(error) = &parsed {
        model
            .log
            .error(format!("{error}; correct it or choose a preset"));
    }
    parsed.is_ok()
}

fn play_pause(model: &mut Model) {
    let Some(run) = &mut model.run else {
        return;
    };
    run.playing = !run.playing;
    if run.playing && run.ended() && !run.scrubbed() {
        // at the end: replay the stored states
        run.scrub(Some(0));
    }
    for side in &run.sides {
        if run.playing && !run.scrubbed() {
            side.handle.play();
        } else {
            side.handle.pause();
        }
    }
}

/// Shows the next stored state, or takes a step of the flow.
fn step(model: &mut Model) {
    let Some(run) = &mut model.run else {
        return;
    };
    run.playing = false;
    if run.scrubbed() {
        let at = run.sides.iter().filter_map(|s| s.shown).min();
        run.scrub(at.map(|i| i + 1));
    } else {
        for side in &run.sides {
            side.handle.step();
        }
    }
}

fn continue_from_shown(model: &mut Model) {
    let Some(run) = &mut model.run else {
        return;
    };
    for side in &mut run.sides {
        if let (Some(state), Some(_)) = (side.state(), side.shown.take()) {
            side.handle.rewind_to(&state);
            side.forget_after(state.attempt());
        }
        side.handle.play();
    }
    run.playing = true;
    run.stopped = false;
}

/// Accepts the shown state of a variant.
pub(super) fn accept(model: &mut Model, index: usize) {
    let Some(run) = &mut model.run else {
        return;
    };
    if run.accepting.is_some() {
        return;
    }
    let Some(side) = run.sides.get_mut(index) else {
        return;
    };
    if !side.handle.ended() {
        side.handle.stop();
    }
    let Some(state) = side.state() else {
        model
            .log
            .info("there is no patch yet: wait for the first patch or press Esc");
        return;
    };
    if !state.makes_images() {
        let (filled, warnings) = state.mesh_with_warnings();
        take_over(model, index, &state, filled, warnings);
        return;
    }
    run.accepting = Some(Accepting {
        side: index,
        state: state.clone(),
        then: Vec::new(),
    });
    model.spawn(TEXTURES, move |_| {
        let (filled, warnings) = state.mesh_with_warnings();
        Done::Accepted(state, Box::new(filled), warnings)
    });
}

/// Takes over the mesh of a state that is being accepted.
pub(super) fn accepted(model: &mut Model, state: &RunState, filled: Mesh, warnings: Vec<String>) {
    // another run, or none, if the document was replaced
    let is_same = |a: &mut Accepting| state_key(Some(&a.state)) == state_key(Some(state));
    let accepting = model
        .run
        .as_mut()
        .and_then(|run| run.accepting.take_if(is_same));
    let Some(Accepting { side, then, .. }) = accepting else {
        return;
    };
    take_over(model, side, state, filled, warnings);
    for action in then {
        act(model, action);
    }
}

/// Makes the mesh of a state of a run that of the document.
fn take_over(
    model: &mut Model,
    index: usize,
    state: &RunState,
    filled: Mesh,
    warnings: Vec<String>,
) {
    let Some(run) = &mut model.run else {
        return;
    };
    let side = &run.sides[index];
    let surface = (state.patch_faces().is_none() && state.has_limit()).then(|| state.clone());
    let mut operation = side.operation.clone();
    operation.set_schedule(state.schedule());
    let mut faces = run.base.face_count()..filled.face_count();
    if matches!(operation, Operation::Refine(_)) {
        faces = 0..0;
        // the vertices are on the limit surface, if there is one
        model.view.report.on_surface |= state.has_limit();
    } else if faces.is_empty() && !matches!(operation, Operation::Fair(_)) {
        model
            .log
            .error("no hole could be filled; the mesh is unchanged");
        model.run = None;
        return;
    }
    let label = operation.label();
    let at = side.shown.map_or_else(String::new, |at| {
        format!(" at state {} of {}", at + 1, side.state_count())
    });
    let done = AppliedOperation { operation, faces };
    let kept = run.kept.take();
    let controls = side.controls.clone();
    model.history.record(&model.document, label.clone(), None);
    model.document.accept(filled, kept.as_deref(), done);
    model.document.surface = surface;
    model.document.controls = Controls {
        // the loops of the mesh have changed
        loop_continuity: window_controls().loop_continuity,
        ..controls
    };
    // side B has another energy
    let energy = &model.document.controls.energy;
    model.view.energy_text.clone_from(energy);
    model.run = None;
    model.revision += 1;
    model.view.hover.clear();
    model.log.info(format!("{label} accepted{at}"));
    for warning in warnings {
        model.log.warning(warning);
    }
}
