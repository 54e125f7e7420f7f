//! The right panel: energy, scheme, time step, patch.

use eframe::egui::{self, RichText, Ui};

use super::widgets::{ClickActions, Rail, choice, number, row, slider_row};
use crate::app::action::{Action, ControlsAction, TaskAction};
use crate::app::document::window_controls;
use crate::app::model::Model;
use crate::app::view_state::Task;
use crate::fill::{Continuity, Controls, Features, Linear, PatchTexture, Surface, Symmetry};
use crate::mesh::LoopId;
use crate::options::Choice;
use crate::solver::{FLOW_GROWTH, Mode, Scheme, Tau};

/// All controls of a run. Changes apply to the next step.
pub(crate) fn controls_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    egui::ScrollArea::vertical().show(ui, |ui| {
        ui.add_space(4.0);
        if model.view.task != Task::Refine {
            surface_ui(ui, model, actions);
            ui.separator();
        }
        ui.heading("Energy");
        let is_used = super::energy::is_used(model);
        if !is_used {
            ui.weak("not used by this surface model");
        }
        if model.view.task == Task::Refine && model.view.refining.controls.energy.is_none() {
            ui.weak("adapted to the edge length of the mesh, see the task on the left");
        } else {
            super::energy::energy_ui(ui, model, is_used, actions);
        }
        let mut next = model.document.controls.clone();
        let refining = model.view.task == Task::Refine;
        ui.separator();
        ui.heading("Flow");
        scheme_ui(ui, &mut next, refining);
        tau_ui(ui, model, &mut next);
        ui.separator();
        ui.heading(if refining { "Surface" } else { "Patch" });
        patch_ui(ui, model, &mut next, refining, actions);
        if next != model.document.controls {
            actions.push(ControlsAction::Set(Box::new(next)).into());
        }
        ui.separator();
        if ui
            .button("Defaults")
            .on_hover_text("automatic surface model, H^2, normal flow, automatic time step, density of the rim, automatic continuity")
            .clicked()
        {
            let defaults = window_controls();
            actions.push(ControlsAction::EnergyText(defaults.energy.clone()).into());
            actions.push(ControlsAction::Set(Box::new(defaults)).into());
        }
    });
}

/// Height of the list of surface models, which is reserved before it has rows, so that the controls below
/// do not move.
const MODELS: f32 = 64.0;

/// The surface model.
fn surface_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.heading("Surface model");
    let mut next = model.document.controls.clone();
    ui.horizontal_wrapped(|ui| {
        for (surface, tip) in [
            (
                Surface::Auto,
                "the model that restores known parts of the mesh around the hole best",
            ),
            (Surface::Energy, "makes the energy below stationary"),
            (
                Surface::Diffusion,
                "quasi surface diffusion: follows the mesh in place and direction",
            ),
            (
                Surface::G2,
                "continues the curvatures of the mesh across the rim",
            ),
        ] {
            ui.selectable_value(&mut next.surface, surface, surface.name())
                .on_hover_text(tip);
        }
    });
    let mut uses = next.symmetry == Symmetry::Auto;
    let tip =
        "auto: holes may follow their counterparts on the other side of a nearly symmetric mesh";
    let symmetry = egui::Checkbox::new(&mut uses, "Use symmetry");
    ui.add_enabled(next.predicts_surface(), symmetry)
        .on_hover_text(tip)
        .on_disabled_hover_text(tip);
    next.symmetry = if uses { Symmetry::Auto } else { Symmetry::Off };
    if next.surface == Surface::Auto && !next.predicts_surface() {
        ui.weak("An option of the energy is set: auto is energy.");
    }
    let sides = model
        .run
        .iter()
        .flat_map(|run| run.sides.iter().zip(run.names()));
    let rows = sides.flat_map(|(side, name)| {
        let rows = side.handle.figures(None).into_iter();
        rows.map(move |row| (name, row))
    });
    let rows: Vec<_> = rows.filter(|(_, row)| !row.holes.is_empty()).collect();
    ui.weak("Expected errors, % of the hole radius")
        .on_hover_text("and the surface model, from predictions of known parts of the mesh");
    // its bar is always visible
    ui.spacing_mut().scroll = egui::style::ScrollStyle::solid();
    let list = egui::ScrollArea::vertical()
        .id_salt("models")
        .auto_shrink(false);
    list.max_height(MODELS).show(ui, |ui| {
        if rows.is_empty() {
            ui.weak("known when a fill has started");
        }
        for (name, row) in rows {
            for (numbers, words) in row.surface_words() {
                let holes: Vec<LoopId> = numbers.iter().map(|&k| row.holes[k]).collect();
                let words = format!("{name} {}: {words}", row.hole_list_of(&numbers));
                let words = words.trim_start();
                let label = egui::Label::new(RichText::new(words).weak()).truncate();
                ui.add(label.show_tooltip_when_elided(false))
                    .on_hover_text(words)
                    .hovers(&holes, actions);
            }
        }
    });
    if next != model.document.controls {
        actions.push(ControlsAction::Set(Box::new(next)).into());
    }
}

/// The choice of scheme and mode. Refinements choose their scheme themselves.
fn scheme_ui(ui: &mut Ui, next: &mut Controls, refining: bool) {
    if !refining {
        let corrected = "mixed with the exact gradient; vertices do not drift along the surface";
        let schemes = [
            (
                Scheme::Normal,
                "normal",
                "linearly implicit normal flow, the fastest",
            ),
            (Scheme::Mixed, "mixed", "mixed finite elements of the paper"),
            (Scheme::MixedCorrected, "corrected", corrected),
        ];
        choice(ui, "Scheme", &mut next.scheme, schemes);
    }
    if next.scheme != Scheme::Normal && !refining {
        let gmres = "restarted, with a Schur complement preconditioner";
        let solvers = [
            (Linear::Gmres, "GMRES", gmres),
            (Linear::Lu, "LU", "sparse direct solver"),
        ];
        choice(ui, "Linear solver", &mut next.linear, solvers);
    }
    let fast = "compute the stationary shape in few steps";
    let modes = [
        (Mode::Flow, "flow", "follow the flow in true time"),
        (Mode::Fast, "fast", fast),
    ];
    choice(ui, "Mode", &mut next.mode, modes);
}

fn tau_ui(ui: &mut Ui, model: &Model, next: &mut Controls) {
    let reference = model
        .run
        .as_ref()
        .and_then(|r| r.sides.first())
        .and_then(|s| s.handle.tau());
    let mut fixed = matches!(next.tau, Tau::Fixed(_));
    let auto = "grows after accepted steps, shrinks after rejected steps";
    let unit = "in multiples of the natural time of the hole (length² / unit of f)";
    let choices = [(false, "auto", auto), (true, "fixed", unit)];
    choice(ui, "Time step τ", &mut fixed, choices);
    let unit = reference.map_or(1.0, |(_, tau_ref)| tau_ref);
    match (fixed, next.tau) {
        (false, Tau::Fixed(_)) => next.tau = Tau::Auto,
        (true, Tau::Auto) => {
            let start = reference.map_or(1e-4, |(tau, tau_ref)| tau.min(1e-2 * tau_ref));
            next.tau = Tau::Fixed(start);
        }
        (false, Tau::Auto) | (true, Tau::Fixed(_)) => {}
    }
    if let Tau::Fixed(tau) = next.tau {
        let mut relative = tau / unit;
        let name = if reference.is_some() {
            "τ / τ_ref"
        } else {
            "τ"
        };
        let tip = format!("τ = {tau:.3e} length² / unit of f");
        let rail = Rail::logarithmic(1e-8..=1e4);
        if slider_row(ui, name, &tip, &mut relative, 1e-2, rail) {
            next.tau = Tau::Fixed(relative * unit);
        }
    } else if next.mode == Mode::Flow {
        let mut growth = next.growth.unwrap_or(FLOW_GROWTH);
        let tip = "factor of τ after an accepted step; closer to 1 gives more states";
        let rail = Rail::logarithmic(1.0..=10.0);
        if slider_row(ui, "Growth", tip, &mut growth, FLOW_GROWTH, rail) {
            next.growth = Some(growth);
        }
    }
    let tip = "maximum number of steps; the flow then ends, converged or not";
    row(ui, "Most steps", tip, |ui, label| {
        let steps = number(&mut next.steps).range(1..=100_000);
        ui.add(steps).labelled_by(label).on_hover_text(tip);
    });
    let tip = "tangential relaxation: evens out the triangles after each step";
    let none = window_controls().relaxation;
    let rail = Rail::linear(0.0..=1.0);
    slider_row(ui, "Relaxation", tip, &mut next.relaxation, none, rail);
}

/// Whether patches join islands, on a mesh that may have some.
fn islands_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let components = model.document.loops.iter().map(|l| l.component);
    let several = components.clone().min() != components.max();
    if model.view.task != Task::Fill || !several {
        return;
    }
    let mut joins = model.view.islands;
    let tip = "the patch of a hole joins the rims of loose components inside it; otherwise it passes them by";
    let islands = egui::Checkbox::new(&mut joins, "Join islands");
    let islands = ui.add_enabled(model.run.is_none(), islands);
    if islands.on_hover_text(tip).changed() {
        actions.push(TaskAction::Islands(joins).into());
    }
}

/// The choices at a rim.
const CONTINUITIES: [(Continuity, &str, &str); 4] = [
    (
        Continuity::Auto,
        "auto",
        "G2 with the surface model g2 or an energy with gradH2, otherwise G1",
    ),
    (Continuity::G0, "G0", "the rim is a crease"),
    (Continuity::G1, "G1", "normals continue across the rim"),
    (
        Continuity::G2,
        "G2",
        "curvatures continue across the rim: needs the surface model g2 or an energy with gradH2",
    ),
];

fn patch_ui(
    ui: &mut Ui,
    model: &Model,
    next: &mut Controls,
    refining: bool,
    actions: &mut Vec<Action>,
) {
    let defaults = window_controls();
    if !refining {
        let tip = "density relative to the rim, from 0.25 to 4: 2 halves the edge length";
        let value = &mut next.density;
        let rail = Rail::logarithmic(0.25..=4.0);
        slider_row(ui, "Density", tip, value, defaults.density, rail);
    }
    let own_energy = refining && model.view.refining.controls.energy.is_none();
    ui.add_enabled_ui(!own_energy, |ui| {
        let tip = "weight of the area beside the energy, in units of 1/r²; a larger weight pulls the \
                   surface together";
        let tip = if own_energy {
            "clear “Energy by edge length” in the panel on the left to set it"
        } else {
            tip
        };
        let value = &mut next.tension;
        let rail = Rail::logarithmic(0.0..=100.0);
        slider_row(ui, "Tension", tip, value, defaults.tension, rail);
    });
    let tip = "spontaneous curvature in units of 1/r, positive along the normals: 0.5 favours tubes \
               of the hole's radius, 1 spheres of that radius; caps are highest at 0.5";
    let rail = Rail::linear(-2.0..=2.0);
    slider_row(ui, "Bulge", tip, &mut next.bulge, defaults.bulge, rail);
    if !refining {
        let tip = "noise on the start surface of the next run, in mean edge lengths";
        let rail = Rail::linear(0.0..=1.0);
        slider_row(ui, "Noise", tip, &mut next.noise, defaults.noise, rail);
    }
    if refining {
        return;
    }
    choice(ui, "At the rim", &mut next.continuity, CONTINUITIES);
    let mut continues = next.features == Features::Auto;
    let sharp = egui::Checkbox::new(&mut continues, "Continue sharp edges");
    let tip = "where the sharp edges that end at a hole lead to each other or to a corner, the patch gets \
               creases between them";
    ui.add_enabled(model.run.is_none(), sharp)
        .on_hover_text(tip);
    next.features = if continues {
        Features::Auto
    } else {
        Features::Off
    };
    islands_ui(ui, model, actions);
    let label = egui::Checkbox::new(&mut next.label_patches, "Label patches");
    ui.add_enabled(model.run.is_none(), label)
        .on_hover_text("put the faces of each patch into a group: patch_1, patch_2, …");
    if model.document.mesh.attributes.has_texture() {
        let choices = [
            (
                PatchTexture::Auto,
                "auto",
                "extended where other faces leave room in the image, an image of its own elsewhere",
            ),
            (
                PatchTexture::Extend,
                "extend",
                "the texture coordinates continue where the rim lies in one chart",
            ),
            (
                PatchTexture::Own,
                "own",
                "the colours along the rim continue in a new image, which is saved with the mesh",
            ),
            (PatchTexture::None, "none", "patches have no texture"),
        ];
        ui.add_enabled_ui(model.run.is_none(), |ui| {
            choice(ui, "Texture", &mut next.patch_texture, choices);
        });
    }
    let selected = model.document.selected();
    if selected.len() > 1 {
        ui.collapsing("Each rim", |ui| {
            for l in selected {
                let row = ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(format!("loop {}", l.id)));
                    let mut own = next.continuity_at(l.id);
                    let before = own;
                    for (value, name, tip) in CONTINUITIES {
                        ui.selectable_value(&mut own, value, name)
                            .on_hover_text(tip);
                    }
                    if own != before {
                        if own == next.continuity {
                            next.loop_continuity.remove(&l.id);
                        } else {
                            next.loop_continuity.insert(l.id, own);
                        }
                    }
                });
                row.response.hovers(&[l.id], actions);
            }
        });
    }
}
