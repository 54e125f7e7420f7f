//! Energy and controls.

use std::collections::BTreeMap;

use super::refuse_while_running;
use crate::app::action::ControlsAction;
use crate::app::model::Model;
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
                model.view.compare_energy = energy;
            }
        }
    }
}

/// Sets the controls of the next run and of the current one.
fn set(model: &mut Model, controls: Controls) {
    if controls == model.document.controls {
        return;
    }
    if let Some(run) = &mut model.run {
        let compares_methods = matches!(run.operation, Operation::Refine(_));
        for (i, side) in run.sides.iter_mut().enumerate() {
            let mut own = controls.clone();
            if i > 0 && !compares_methods {
                // side B keeps its energy with its parameters, which is all that it differs in
                own.surface = side.controls.surface;
                own.energy.clone_from(&side.controls.energy);
                for (name, value) in &side.controls.param {
                    own.param.entry(name.clone()).or_insert(*value);
                }
            }
            match side.handle.set_controls(&own) {
                Ok(()) => side.change_controls(own),
                Err(text) => {
                    model.log.error(text);
                    return;
                }
            }
        }
        if run.ended() {
            // a changed control restarts a flow that has ended; what was said about its end no
            // longer holds
            run.playing = true;
            run.stopped = false;
            for side in &mut run.sides {
                side.warnings.retain(|w| w.attempt == 0);
                side.handle.play();
            }
        }
    }
    model
        .history
        .record(&model.document, "change the controls", Some("controls"));
    model.document.controls = controls;
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
        }
        Err(error) => model.log.error(format!("energy: {error}")),
    }
}

/// The known parameters and the default of a preset's parameter.
pub(crate) fn params_for(text: &str, known: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut params = known.clone();
    let plain = text.replace(' ', "");
    let named = Preset::ALL.into_iter().find(|p| p.text() == plain);
    if let Some((name, value)) = named.and_then(Preset::parameter) {
        params.entry(name.into()).or_insert(value);
    }
    params
}
