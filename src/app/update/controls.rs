//! Energy and controls.

use std::collections::BTreeMap;

use super::refuse_while_running;
use crate::app::action::ControlsAction;
use crate::app::log::Level;
use crate::app::model::Model;
use crate::app::view_state::ComparedEnergy;
use crate::energy::{Energy, Preset};
use crate::fill::{Controls, Surface};
use crate::ops::Operation;

pub(crate) fn update(model: &mut Model, action: ControlsAction) {
    match action {
        ControlsAction::Set(controls) => set(model, *controls),
        ControlsAction::EndDrag => model.history.seal(),
        ControlsAction::EnergyText(text) => model.view.energy_text = text,
        ControlsAction::ApplyEnergy => apply_energy(model),
        ControlsAction::AddParameter(name) => {
            let mut controls = model.document.controls.clone();
            controls.param.insert(name, 1.0);
            set(model, controls);
            let text = &model.view.energy_text;
            if Energy::parse(text, &model.document.controls.param).is_ok() {
                apply_energy(model);
            }
        }
        ControlsAction::CompareEnergy(energy) => {
            if !refuse_while_running(model, "comparing other energies") {
                let known = known_params(model);
                model.view.compared = energy.map(|text| compared(text, &known));
            }
        }
        ControlsAction::CompareParameter(name, value) => {
            if let Some(compared) = &mut model.view.compared {
                compared.param.insert(name, value);
                let param = compared.param.clone();
                set_compared(model, &param);
            }
        }
    }
}

/// The energy of side B. A parameter begins at its known value.
fn compared(text: String, known: &BTreeMap<String, f64>) -> ComparedEnergy {
    let param = params_for(&text, known);
    // those of an invalid text may be used again
    let param = Energy::parse(&text, &param).map_or(param, |energy| energy.params().clone());
    ComparedEnergy { text, param }
}

/// The parameters of side B, and those of side A that it does not have.
fn known_params(model: &Model) -> BTreeMap<String, f64> {
    let mut known = model.document.controls.param.clone();
    known.extend(model.view.compared.iter().flat_map(|b| b.param.clone()));
    known
}

/// Sets the controls of the next run and of the current one.
fn set(model: &mut Model, controls: Controls) {
    if controls == model.document.controls {
        return;
    }
    let is_set = change_sides(model, |is_compared, present| {
        let mut own = controls.clone();
        if is_compared {
            // side B keeps its energy with its parameters, which is all that it differs in
            own.surface = present.surface;
            own.energy.clone_from(&present.energy);
            own.param.clone_from(&present.param);
        }
        own
    });
    if !is_set {
        return;
    }
    model
        .history
        .record(&model.document, "change the controls", Some("controls"));
    model.document.controls = controls;
}

/// Sets the parameters of side B of the current run.
fn set_compared(model: &mut Model, param: &BTreeMap<String, f64>) {
    change_sides(model, |is_compared, present| {
        let mut own = present.clone();
        if is_compared {
            own.param.clone_from(param);
        }
        own
    });
}

/// Changes the controls of the sides of the current run to those that `own` makes of the present ones;
/// its first argument is whether the side runs the compared energy. Returns whether all were accepted.
fn change_sides(model: &mut Model, own: impl Fn(bool, &Controls) -> Controls) -> bool {
    let Some(run) = &mut model.run else {
        return true;
    };
    let compares_methods = matches!(run.operation, Operation::Refine(_));
    for (i, side) in run.sides.iter_mut().enumerate() {
        let own = own(i > 0 && !compares_methods, &side.controls);
        if own == side.controls {
            continue;
        }
        // before the flow continues with them
        let attempt = side.latest_attempt();
        match side.handle.set_controls(&own) {
            Ok(()) => side.change_controls(own, attempt),
            Err(text) => {
                model.log.error(text);
                return false;
            }
        }
    }
    if run.ended() {
        // a changed control restarts a flow that has ended; what was said about its end no longer
        // holds
        run.playing = true;
        run.stopped = false;
        for side in &mut run.sides {
            side.warnings.retain(|w| w.attempt == 0);
            side.handle.play();
        }
    }
    true
}

/// Uses the typed energy if it is valid, with a value for each parameter.
fn apply_energy(model: &mut Model) {
    let mut controls = model.document.controls.clone();
    let text = model.view.energy_text.trim().to_owned();
    controls.param = params_for(&text, &controls.param);
    match Energy::parse(&text, &controls.param) {
        Ok(energy) => {
            controls.param = energy.params().clone();
            controls.energy = text;
            controls.surface = Surface::Energy;
            model.history.seal();
            set(model, controls);
            model.history.seal();
            // what was wrong with the text before is over
            let latest = model.log.latest();
            if latest.is_some_and(|entry| entry.level == Level::Error) {
                model.log.settle();
            }
        }
        Err(error) => model.log.error(error.to_string()),
    }
}

/// The known parameters and the default of a preset's parameter.
pub(crate) fn params_for(text: &str, known: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut params = known.clone();
    if let Some((name, value)) = Preset::of_text(text).and_then(Preset::parameter) {
        params.entry(name.into()).or_insert(value);
    }
    params
}
