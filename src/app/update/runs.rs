//! Controls and runs.

use super::edits;
use crate::app::action::Action;
use crate::app::document::{Accepted, Work, window_controls};
use crate::app::model::{Effect, Model};
use crate::app::repeat;
use crate::app::run::Run;
use crate::app::view_state::Task;
use crate::energy::{Energy, Preset};
use crate::fill::Controls;

/// Carries out the actions of this kind.
pub fn update(model: &mut Model, action: Action) {
    match action {
        Action::Controls(controls) => set_controls(model, *controls),
        Action::Settle => model.history.seal(),
        Action::EnergyText(text) => model.view.energy_text = text,
        Action::ApplyEnergy => apply_energy(model),
        Action::AddParameter(name) => {
            let mut controls = model.document.controls.clone();
            controls.param.insert(name, 1.0);
            set_controls(model, controls);
            let text = &model.view.energy_text;
            if Energy::parse(text, &model.document.controls.param).is_ok() {
                apply_energy(model);
            }
        }
        Action::CompareEnergy(energy) => {
            if model.is_busy("comparing other energies") {
                return;
            }
            model.view.compare_energy = energy;
        }
        Action::Fill => fill(model),
        Action::Fair => {
            if let Some(faces) = edits::selected_faces(model) {
                start(model, Work::Fair(faces));
            }
        }
        Action::PlayPause => play_pause(model),
        Action::Step => step(model),
        Action::Finish => on_sides(model, |side| {
            side.shown = None;
            side.live.finish();
        }),
        Action::Stop => {
            on_sides(model, |side| side.live.stop());
            if let Some(run) = &mut model.run {
                run.playing = false;
            }
        }
        Action::Scrub(at) => {
            if let Some(run) = &mut model.run {
                run.scrub(at);
            }
        }
        Action::GoOnFromHere => go_on_from_here(model),
        Action::Pace(pace) => {
            model.view.pace = pace;
            on_sides(model, |side| side.live.set_pace(pace));
        }
        Action::Accept(side) => {
            accept(model, side);
        }
        Action::Reject => reject(model),
        Action::CopyCommand => match repeat::command(model) {
            Ok(text) => {
                model.effects.push(Effect::CopyText(text));
                model.log.info("command copied to the clipboard");
            }
            Err(text) => model.log.warning(text),
        },
        _ => {}
    }
}

fn on_sides(model: &mut Model, f: impl Fn(&mut crate::app::run::Side)) {
    if let Some(run) = &mut model.run {
        for side in &mut run.sides {
            f(side);
        }
    }
}

fn reject(model: &mut Model) {
    if model.run.take().is_some() {
        model
            .log
            .info("the patch was dropped; the mesh is as before");
    }
}

/// New controls: for the next run, and for the one under way.
fn set_controls(model: &mut Model, controls: Controls) {
    if controls == model.document.controls {
        return;
    }
    if let Some(run) = &mut model.run {
        let compared = run.sides.len() > 1;
        for side in &mut run.sides {
            let mut own = controls.clone();
            if compared {
                // the energies are what differs, each with parameters of its own
                own.energy.clone_from(&side.controls.energy);
                for (name, value) in &side.controls.param {
                    own.param.entry(name.clone()).or_insert(*value);
                }
            }
            match side.live.set_controls(&own, &run.base, run.own_energy) {
                Ok(()) => {
                    if (&own.energy, &own.param) != (&side.controls.energy, &side.controls.param) {
                        side.new_energy();
                    }
                    side.controls = own;
                    if let Work::Refine(work) = &mut run.work {
                        work.changed = true;
                    }
                }
                Err(text) => {
                    model.log.error(text);
                    return;
                }
            }
        }
        if run.ended() {
            // a changed control wakes a flow that has come to its end
            run.playing = true;
            for side in &run.sides {
                side.live.play();
            }
        }
    }
    model
        .history
        .record(&model.document, "change the controls", Some("controls"));
    model.document.controls = controls;
}

/// Takes the typed energy, if it is one, with a value for each of its parameters.
fn apply_energy(model: &mut Model) {
    let mut controls = model.document.controls.clone();
    let text = model.view.energy_text.trim().to_owned();
    controls.param = params_for(&text, &controls.param);
    match Energy::parse(&text, &controls.param) {
        Ok(energy) => {
            controls.param = energy.params().clone();
            controls.energy = text;
            model.history.seal();
            set_controls(model, controls);
            model.history.seal();
        }
        Err(error) => model.log.error(format!("energy: {error}")),
    }
}

/// The known parameters, with 0 for those that the text names besides.
pub fn params_for(
    text: &str,
    known: &std::collections::BTreeMap<String, f64>,
) -> std::collections::BTreeMap<String, f64> {
    let mut params = known.clone();
    let plain = text.replace(' ', "");
    let named = Preset::ALL.into_iter().find(|p| p.text() == plain);
    if let Some((name, value)) = named.and_then(Preset::parameter) {
        params.entry(name.into()).or_insert(value);
    }
    params
}

/// Does the task; for fills with nothing selected, all holes that are no outer rims.
fn fill(model: &mut Model) {
    if model.run.is_some() {
        return;
    }
    model.view.bridging = None;
    if model.view.task == Task::Refine {
        refine(model);
        return;
    }
    if model.view.task == Task::Repair {
        if let Some(faces) = edits::selected_faces(model) {
            start(model, Work::Refill(faces));
        }
        return;
    }
    if model.document.selection.is_empty() && model.view.task == Task::Fill {
        let holes = model.document.holes();
        if holes.is_empty() {
            model.log.warning(if model.document.loops.is_empty() {
                "the mesh is closed: there is nothing to fill"
            } else {
                "all open loops look like outer rims: click one to fill it all the same"
            });
            return;
        }
        model.select(holes, "select all holes");
    }
    let task = model.view.task;
    if task == Task::Blend && model.document.selection.len() < 2 {
        model
            .log
            .warning("a blend joins two rims or more: click them, or take all with Ctrl+A");
        return;
    }
    let loops = model.document.selection.iter().copied().collect();
    start(
        model,
        match task {
            Task::Blend => Work::Blend(loops),
            _ => Work::Fill(loops),
        },
    );
}

fn refine(model: &mut Model) {
    let refining = model.view.refining;
    if refining.selected_only && model.document.faces.is_empty() {
        model
            .log
            .warning("no face is selected: select some in task Repair, or refine all of the mesh");
        return;
    }
    let (document, controls) = (&model.document, &model.document.controls);
    let (pace, wake) = (model.view.pace, &model.wake);
    let chains = &model.view.report.chains;
    match Run::start_refinement(&refining, chains, document, controls, pace, wake) {
        Ok(run) => {
            // several views are narrower than the one before
            model.view.fit |= run.sides.len() > 1;
            model.run = Some(run);
        }
        Err(text) => model.log.error(text),
    }
}

fn start(model: &mut Model, work: Work) {
    let a = model.document.controls.clone();
    let mut sides = vec![a.clone()];
    if let Some(energy) = &model.view.compare_energy {
        let mut b = a;
        b.param = params_for(energy, &b.param);
        b.energy.clone_from(energy);
        sides.push(b);
    }
    match Run::start(work, &model.document, &sides, model.view.pace, &model.wake) {
        Ok(run) => model.run = Some(run),
        Err(text) => model.log.error(text),
    }
}

fn play_pause(model: &mut Model) {
    let Some(run) = &mut model.run else {
        return;
    };
    run.playing = !run.playing;
    if run.playing && run.ended() && !run.scrubbed() {
        // at the end: play the kept states again
        run.scrub(Some(0));
    }
    for side in &run.sides {
        if run.playing && !run.scrubbed() {
            side.live.play();
        } else {
            side.live.pause();
        }
    }
}

/// One state on: of the kept ones, or of the flow.
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
            side.live.step();
        }
    }
}

fn go_on_from_here(model: &mut Model) {
    let Some(run) = &mut model.run else {
        return;
    };
    for side in &mut run.sides {
        if let (Some(state), Some(_)) = (side.state(), side.shown.take()) {
            side.live.rewind_to(&state);
            side.crossing = None;
        }
        side.live.play();
    }
    run.playing = true;
}

/// Takes in the shown state of a side.
pub fn accept(model: &mut Model, index: usize) {
    let Some(run) = &mut model.run else {
        return;
    };
    let Some(side) = run.sides.get_mut(index) else {
        return;
    };
    if !side.live.ended() {
        side.live.stop();
    }
    let Some(state) = side.state() else {
        model
            .log
            .info("there is no patch yet: wait for the first one, or press Esc");
        return;
    };
    let Some(filled) = side.live.mesh_at(&state) else {
        return;
    };
    let surface = (state.is_whole() && state.has_limit()).then(|| state.clone());
    let mut work = run.work.clone();
    let mut faces = run.base.face_count()..filled.face_count();
    if let Work::Refine(work) = &mut work {
        work.words.clone_from(&side.words);
        faces = 0..0;
        // its vertices are points of the limit surface, if it has one
        model.view.report.on_surface |= state.has_limit();
    } else if faces.is_empty() && !matches!(work, Work::Fair(_)) {
        model
            .log
            .error("no hole could be filled; the mesh is as before");
        model.run = None;
        return;
    }
    let done = Accepted {
        work,
        controls: side.start.clone(),
        schedule: side.live.schedule_to(Some(&state)),
        faces,
    };
    let label = done.work.label();
    let kept = run.kept.take();
    let controls = side.controls.clone();
    model.history.record(&model.document, label.clone(), None);
    model.document.accept(filled, kept.as_deref(), done);
    model.document.surface = surface;
    model.document.controls = Controls {
        // numbers of loops mean other loops from now on
        loop_continuity: window_controls().loop_continuity,
        ..controls
    };
    model.run = None;
    model.revision += 1;
    model.view.hover = None;
    model.log.info(format!("{label} accepted"));
}
