//! The energy: presets, a typed expression with its error, parameters, and well-posedness.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::{self, Key, RichText, Ui};

use super::theme;
use crate::app::action::{Action, ControlsAction};
use crate::app::cached::ParsedEnergy;
use crate::app::model::Model;
use crate::app::run::Run;
use crate::app::ui::widgets::{Rail, named, row, slider_row};
use crate::app::update::params_for;
use crate::app::view_state::Task;
use crate::energy::{Energy, ExprError, Preset, WellPosedScan};

/// A sentence about a preset.
fn about(preset: Preset) -> &'static str {
    match preset {
        Preset::One => "soap films; a second-order flow",
        Preset::H2 => "round surfaces; the default",
        Preset::K2 => "smooths flat directions weakly",
        Preset::H2PlusK2 => "mixes units: the result depends on the size of the model",
        Preset::H2K2 => "ill-posed on parts of saddles: fine oscillations occur",
        Preset::K1P4PlusK2P4 => "penalises strong curvature",
        Preset::K => "every surface is stationary (Gauss-Bonnet)",
        Preset::HMinusH0Squared => "favours the mean curvature H0",
        Preset::K1SqPlusK2Sq => "of a thin plate",
        Preset::K1MinusK2Squared => "favours umbilics: spheres",
        Preset::CurvatureNorm => "keeps sharp edges and flat sides",
        Preset::MeanVariation => {
            "continues curvatures across the rim; spheres, cylinders and planes cost nothing"
        }
    }
}

/// Choice and expression of an energy that [`is_used`] or not.
pub(crate) fn energy_ui(ui: &mut Ui, model: &Model, is_used: bool, actions: &mut Vec<Action>) {
    let view = &model.view;
    let controls = &model.document.controls;
    if let Some(preset) = preset_ui(ui, "Preset", &view.energy_text, &controls.param) {
        actions.push(ControlsAction::EnergyText(preset.text().into()).into());
        actions.push(ControlsAction::ApplyEnergy.into());
    }
    let typed = expression_ui(ui, "f(H, K) =", &view.energy_text, &controls.param);
    if let Some(text) = typed.text.clone() {
        actions.push(ControlsAction::EnergyText(text).into());
    }
    if let Some(name) = typed.parameter {
        actions.push(ControlsAction::AddParameter(name).into());
    }
    if typed.is_valid {
        if typed.is_left {
            actions.push(ControlsAction::ApplyEnergy.into());
        } else if typed.text.is_none() && view.energy_text.trim() != controls.energy {
            ui.weak("press Enter to use this energy");
        }
        if let Some((name, value)) = parameters_ui(ui, "", &controls.energy, &controls.param) {
            let mut controls = controls.clone();
            controls.param.insert(name, value);
            actions.push(ControlsAction::Set(Box::new(controls)).into());
        }
    }
    // it is about the energy in use, not about the one that is being typed
    if typed.is_valid && view.energy_text.trim() == controls.energy && is_used {
        badge_ui(ui, model, 0);
    }
    if model.view.task != Task::Refine {
        compare_ui(ui, model, actions);
    }
}

/// Whether the run, or the next one, makes the energy of the controls stationary.
pub(crate) fn is_used(model: &Model) -> bool {
    let is_refined = model.view.task == Task::Refine;
    let may_be = is_refined || model.document.controls.surface.has_energy();
    may_be && model.run.as_ref().is_none_or(Run::uses_energy)
}

/// A list of presets by their names. Returns the one that was chosen.
fn preset_ui(
    ui: &mut Ui,
    name: &str,
    text: &str,
    params: &BTreeMap<String, f64>,
) -> Option<Preset> {
    row(ui, name, "", |ui, label| {
        let energy = parsed(ui, name, text, &params_for(text, params));
        let equal = || Result::as_ref(&energy).ok().and_then(Energy::as_preset);
        // with H0 = 0 the text (H-H0)^2 is another preset
        let current = Preset::of_text(text).or_else(equal);
        let mut chosen = None;
        egui::ComboBox::from_id_salt(name)
            .selected_text(current.map_or("typed", Preset::title))
            .width(ui.available_width())
            .height(420.0)
            .truncate()
            .show_ui(ui, |ui| {
                ui.set_min_width(330.0);
                for preset in Preset::ALL {
                    let text = RichText::new(preset.text()).weak();
                    let atoms = (preset.title(), egui::Atom::grow(), text);
                    let row = egui::Button::selectable(current == Some(preset), atoms);
                    let row = row.min_size(egui::vec2(ui.available_width(), 0.0));
                    if ui.add(row).on_hover_text(about(preset)).clicked() {
                        chosen = Some(preset);
                    }
                }
            })
            .response
            .labelled_by(label);
        chosen
    })
}

/// What happened to a text field of an expression.
struct Typed {
    /// The new text, if it has changed.
    text: Option<String>,
    /// Whether the text is valid.
    is_valid: bool,
    /// Whether the field lost the focus, by Enter or with another text than before.
    is_left: bool,
    /// An unknown name that is to become a parameter.
    parameter: Option<String>,
}

/// A text field for an expression, with errors marked under their characters.
fn expression_ui(ui: &mut Ui, name: &str, current: &str, params: &BTreeMap<String, f64>) -> Typed {
    let mut text = current.to_owned();
    let field = egui::TextEdit::singleline(&mut text)
        .font(egui::TextStyle::Monospace)
        .desired_width(f32::INFINITY)
        .hint_text("an expression in H, K, k1, k2, gradH2");
    let response = named(ui, name, field).on_hover_text(
        "H, K, k1, k2, numbers and parameters with + - * / ^, abs, sqrt, exp, log, sin, cos, \
         tanh, min, max; and gradH2, the square of the gradient of H, times a number; Enter takes it",
    );
    // Esc brings back the text from before
    let before = response.id.with("before");
    if response.gained_focus() {
        ui.data_mut(|data| data.insert_temp(before, current.to_owned()));
    }
    let before = ui.data(|data| data.get_temp::<String>(before));
    let [entered, escaped] = [Key::Enter, Key::Escape].map(|key| ui.input(|i| i.key_pressed(key)));
    let is_left = response.lost_focus();
    if is_left
        && escaped
        && let Some(before) = &before
    {
        text.clone_from(before);
    }
    let parsed = parsed(ui, name, &text, &params_for(text.trim(), params));
    let error = parsed.as_ref().as_ref().err();
    if let Some(error) = error {
        error_ui(ui, error);
    }
    let unknown = error.and_then(|error| error.syntax()?.unknown.clone());
    let parameter =
        unknown.filter(|name| ui.button(format!("Make \"{name}\" a parameter")).clicked());
    Typed {
        is_valid: error.is_none(),
        is_left: is_left && (entered || before.as_ref() != Some(&text)),
        text: (text != current).then_some(text),
        parameter,
    }
}

/// The energy of a text, parsed again only when the text or a parameter changes. `name`
/// distinguishes fields.
fn parsed(
    ui: &Ui,
    name: &str,
    text: &str,
    params: &BTreeMap<String, f64>,
) -> Arc<Result<Energy, ExprError>> {
    let id = egui::Id::unique(("energy", name));
    ui.ctx().data_mut(|data| {
        let known = data.get_temp_mut_or_default::<ParsedEnergy>(id);
        known.parse(text, params)
    })
}

/// The carets under the characters, and the message.
fn error_ui(ui: &mut Ui, error: &ExprError) {
    let color = ui.visuals().error_fg_color;
    let Some(syntax) = error.syntax() else {
        ui.label(RichText::new(error.to_string()).color(color));
        return;
    };
    let carets = format!(
        "{}{}",
        " ".repeat(syntax.character),
        "^".repeat(syntax.length.min(24))
    );
    ui.horizontal(|ui| {
        // the distance of the text from the edge of the field
        ui.add_space(ui.spacing().button_padding.x);
        let carets = RichText::new(carets).monospace().strong().color(color);
        ui.add(egui::Label::new(carets).truncate());
    });
    ui.label(RichText::new(syntax.to_string()).color(color));
}

/// A slider for each parameter of an energy; `side` precedes their names. Returns the one that was
/// changed, with its new value.
fn parameters_ui(
    ui: &mut Ui,
    side: &str,
    energy: &str,
    params: &BTreeMap<String, f64>,
) -> Option<(String, f64)> {
    let mut changed = None;
    for (name, &value) in params {
        let mut next = value;
        let title = format!("{side}{name}");
        let reach = drag_reach(ui, &title, value);
        let tip = "drag or type; applies to the next step";
        let rail = Rail::linear(-reach..=reach).open();
        let is_changed = slider_row(ui, &title, tip, &mut next, default_of(energy, name), rail);
        if is_changed {
            changed = Some((name.clone(), next));
        }
    }
    changed
}

/// The initial value of a parameter.
fn default_of(energy: &str, name: &str) -> f64 {
    let known = params_for(energy, &BTreeMap::new());
    known.get(name).copied().unwrap_or(1.0)
}

/// The end of the slider of a parameter: four times the value at the start of a drag, so that the
/// value can change its sign but not grow without bound.
fn drag_reach(ui: &Ui, name: &str, value: f64) -> f64 {
    let id = egui::Id::unique(("reach", name));
    let reach = if value == 0.0 { 1.0 } else { 4.0 * value.abs() };
    // a slider also moves in the frame in which it is released
    let dragging = ui.ctx().dragged_id().is_some() || ui.input(|i| i.pointer.any_released());
    ui.ctx().data_mut(|data| {
        let kept = data.get_temp_mut_or(id, reach);
        if !dragging {
            *kept = reach;
        }
        *kept
    })
}

/// The well-posedness of the flow on the shown surface of a side. The row is there before the surface is
/// scanned, so that the rows below it stay in place.
fn badge_ui(ui: &mut Ui, model: &Model, side: usize) {
    let scan = model.displays[side].latest().and_then(|d| d.posed);
    let scan = scan.filter(|scan| scan.samples > 0);
    let is_idle = model.run.is_none() && model.document.selected().is_empty();
    let name = ["This flow is", "Flow B is"][side.min(1)];
    row(ui, name, "", |ui, _| {
        if let Some(scan) = scan {
            return posed_ui(ui, &scan);
        }
        let words = if is_idle {
            "known for a selection"
        } else {
            "\u{2026}"
        };
        ui.weak(words)
            .on_hover_text("shown once the curvatures around the selected holes are known");
    });
}

/// The result of a scan for well-posedness.
fn posed_ui(ui: &mut Ui, scan: &WellPosedScan) {
    let (text, color, tip) = if scan.undefined > 0 {
        (
            "undefined in places",
            ui.visuals().error_fg_color,
            "the energy has no finite second derivatives at some curvatures of the surface",
        )
    } else if scan.ill_posed > 0 {
        (
            "ill-posed in places",
            ui.visuals().error_fg_color,
            "short wavelengths grow instead of decaying where the patch is hatched",
        )
    } else if 1000 * scan.degenerate > scan.samples {
        (
            "degenerate in places",
            ui.visuals().warn_fg_color,
            "the flow does not smooth in some directions",
        )
    } else if scan.stationary == scan.samples {
        (
            "nothing moves",
            ui.visuals().warn_fg_color,
            "a multiple of K, whose integral depends only on the rim",
        )
    } else {
        (
            "well-posed",
            theme::success(ui),
            "the flow is strictly parabolic on the whole surface",
        )
    };
    ui.label(RichText::new(text).color(color).strong())
        .on_hover_text(tip);
}

fn compare_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let mut on = model.view.compared.is_some();
    if ui
        .checkbox(&mut on, "Compare with another energy (A/B)")
        .on_hover_text("fills the same holes twice, side by side, with linked cameras")
        .changed()
    {
        let energy = on.then(|| "k1^4+k2^4".to_owned());
        actions.push(ControlsAction::CompareEnergy(energy).into());
    }
    let Some(compared) = &model.view.compared else {
        return;
    };
    let (text, params) = (&compared.text, &compared.param);
    if let Some(preset) = preset_ui(ui, "Preset of B", text, params) {
        let text = Some(preset.text().into());
        actions.push(ControlsAction::CompareEnergy(text).into());
    }
    let typed = expression_ui(ui, "B: f(H, K) =", text, params);
    if typed.text.is_some() {
        actions.push(ControlsAction::CompareEnergy(typed.text).into());
    }
    let parameter = typed.parameter.map(|name| (name, 1.0));
    if let Some((name, value)) = parameter.or_else(|| {
        let shown = typed.is_valid;
        shown
            .then(|| parameters_ui(ui, "B: ", text, params))
            .flatten()
    }) {
        actions.push(ControlsAction::CompareParameter(name, value).into());
    }
    if model.run.as_ref().is_some_and(|run| run.sides.len() > 1) {
        badge_ui(ui, model, 1);
    }
}
