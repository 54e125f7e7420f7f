//! The row of view modes and switches.

use eframe::egui::{self, Ui};

use super::format::{format_number, mode_words};
use super::widgets::{ClickActions, number, row, slider, title_width};
use crate::app::action::{Action, Switch, ViewAction};
use crate::app::model::Model;
use crate::app::view_state::ViewState;
use crate::mesh::DVec3;
use crate::options::Choice as _;
use crate::render::{Material, ViewMode, ViewStyle};

/// View modes and switches. `range` is that of the last colour map.
pub(crate) fn toolbar_ui(
    ui: &mut Ui,
    model: &Model,
    range: Option<[f32; 2]>,
    actions: &mut Vec<Action>,
) {
    let view = &model.view;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        for mode in model.view_modes() {
            let (title, about) = mode_words(mode);
            ui.selectable_label(view.style.mode == mode, title)
                .key_tip(about, ViewAction::Mode(mode))
                .on_click(ViewAction::Mode(mode), actions);
        }
        // in a menu of its own, so that the row stays the same in every mode
        let has_options = view.style.mode != ViewMode::Color;
        ui.add_enabled_ui(has_options, |ui| {
            let menu = egui::containers::menu::MenuConfig::new()
                .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
            let button = egui::containers::menu::MenuButton::new("Options").config(menu);
            let (button, _) = button.ui(ui, |ui| {
                ui.set_min_width(250.0);
                if view.style.mode == ViewMode::Shaded {
                    material_ui(ui, model, actions);
                } else if view.style.mode.is_map() {
                    range_ui(ui, model, range.unwrap_or([-1.0, 1.0]), actions);
                } else {
                    stripes_ui(ui, model, actions);
                }
            });
            button.on_hover_text("material, stripes and light, or the range of the colour map");
        });
        ui.separator();
        let switches = switches(view);
        // in a menu where the row is too short, so that there is one row at any width
        if switches_width(ui, &switches) <= ui.available_size_before_wrap().x {
            switches_ui(ui, &switches, actions);
        } else {
            let menu = egui::containers::menu::MenuConfig::new()
                .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
            let button = egui::containers::menu::MenuButton::new("Show").config(menu);
            let (button, _) = button.ui(ui, |ui| switches_ui(ui, &switches, actions));
            button.on_hover_text("wireframe, tint, limit surface, whole mesh, rims");
        }
    });
}

/// A switch of the view: title, tooltip, action and state.
type ViewSwitch = (&'static str, &'static str, Switch, bool);

fn switches(view: &ViewState) -> [ViewSwitch; 5] {
    [
        (
            "Wireframe",
            "show the edges of the control mesh",
            Switch::Wireframe,
            view.style.wireframe,
        ),
        (
            "Tint",
            "draw patches in a different colour",
            Switch::Tint,
            view.style.tint_patch,
        ),
        (
            "Limit surface",
            "on: limit surface; off: triangles of the control mesh",
            Switch::LimitSurface,
            view.limit_surface,
        ),
        (
            "Original",
            "on: whole mesh; off: only the patches",
            Switch::Original,
            view.show_original,
        ),
        (
            "Rims",
            "draw all boundary loops",
            Switch::Rims,
            view.show_rims,
        ),
    ]
}

fn switches_ui(ui: &mut Ui, switches: &[ViewSwitch], actions: &mut Vec<Action>) {
    for &(title, about, switch, on) in switches {
        let label = ui.selectable_label(on, title);
        label.on_click_with_key(about, ViewAction::Toggle(switch), actions);
    }
}

/// Width of the switches in one row.
fn switches_width(ui: &Ui, switches: &[ViewSwitch]) -> f32 {
    let spacing = ui.spacing();
    let beside = 2.0 * spacing.button_padding.x + spacing.item_spacing.x;
    let widths = switches
        .iter()
        .map(|switch| title_width(ui, switch.0) + beside);
    widths.sum()
}

/// The material of shaded surfaces.
fn material_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    ui.label("Material");
    for &material in Material::ALL {
        let chosen = model.view.style.material == material;
        let style = ViewStyle {
            material,
            ..model.view.style
        };
        let name = material.name();
        let title = format!("{}{}", name[..1].to_uppercase(), &name[1..]);
        ui.radio(chosen, title)
            .on_hover_text(material.about())
            .on_click(ViewAction::Style(style), actions);
    }
}

/// The ends of the colour map.
fn range_ui(ui: &mut Ui, model: &Model, shown: [f32; 2], actions: &mut Vec<Action>) {
    let mut style = model.view.style;
    let mut fixed = style.range.is_some();
    let [mut low, mut high] = style.range.unwrap_or(shown);
    let speed = 0.01 * f64::from(high - low).max(1e-9);
    let tip = "off: from -m to m, where m is the 98 % quantile of the magnitudes";
    let mut changed = row(ui, "Range", tip, |ui, label| {
        let fixed = ui.checkbox(&mut fixed, "fixed").labelled_by(label);
        fixed.on_hover_text(tip).changed()
    });
    for (name, value) in [("Low end", &mut low), ("High end", &mut high)] {
        let tip = "value at an end of the colour map";
        changed |= row(ui, name, tip, |ui, label| {
            let drag = number(value)
                .speed(speed)
                .custom_formatter(|x, _| format_number(x));
            let drag = ui.add_enabled(fixed, drag).labelled_by(label);
            drag.on_hover_text(tip).changed()
        });
    }
    if changed && (!fixed || low < high) {
        style.range = fixed.then_some([low, high]);
        actions.push(ViewAction::Style(style).into());
    }
}

fn degrees(value: &mut f64) -> egui::DragValue<'_> {
    number(value).speed(1.0).max_decimals(0).suffix("°")
}

fn stripes_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let mut style = model.view.style;
    let mut changed = row(ui, "Stripes", "number of pairs of bands", |ui, label| {
        let slider = slider(&mut style.stripes, 2..=60).logarithmic(true);
        let slider = ui.add(slider).labelled_by(label);
        slider
            .key_tip("number of pairs of bands", ViewAction::MoreStripes)
            .changed()
    });
    if style.mode == ViewMode::Isophotes {
        let d = style.light.normalize_or(DVec3::Y);
        let mut around = d.z.atan2(d.x).to_degrees();
        let mut above = d.y.clamp(-1.0, 1.0).asin().to_degrees();
        let mut turned = false;
        for (name, tip, angle) in [
            (
                "Azimuth",
                "azimuth of the light around the vertical axis",
                degrees(&mut around),
            ),
            (
                "Elevation",
                "elevation of the light above the horizon",
                degrees(&mut above).range(-90.0..=90.0),
            ),
        ] {
            turned |= row(ui, name, tip, |ui, label| {
                ui.add(angle)
                    .labelled_by(label)
                    .on_hover_text(tip)
                    .changed()
            });
        }
        if turned {
            let (s, c) = around.to_radians().sin_cos();
            let (up, flat) = above.to_radians().sin_cos();
            style.light = DVec3::new(flat * c, up, flat * s);
            changed = true;
        }
        changed |= row(ui, "Light", "", |ui, _| {
            ui.checkbox(&mut style.light_follows_view, "moves with the view")
                .on_hover_text("the light moves with the camera")
                .changed()
        });
    }
    if model.has_colors() {
        changed |= row(ui, "Surface", "", |ui, _| {
            ui.checkbox(&mut style.stripes_on_colors, "colours of the file")
                .on_hover_text("draw the stripes on the colours of the file")
                .changed()
        });
    }
    if style.mode == ViewMode::Zebra {
        let tip = "rotation of the reflected lines around the line of sight";
        let turn = degrees(&mut style.zebra_turn).range(-180.0..=180.0);
        changed |= row(ui, "Turned", tip, |ui, label| {
            ui.add(turn).labelled_by(label).on_hover_text(tip).changed()
        });
    }
    if changed {
        actions.push(ViewAction::Style(style).into());
    }
}
