//! The row of view modes and switches.

use eframe::egui::{self, Ui};

use crate::app::action::{Action, Switch};
use crate::app::model::Model;
use crate::app::shortcuts::{Command, hint};
use crate::mesh::DVec3;
use crate::render::ViewMode;

/// Title and tooltip of a mode.
pub fn mode_words(mode: ViewMode) -> (&'static str, &'static str) {
    match mode {
        ViewMode::Shaded => ("Shaded", "plain material"),
        ViewMode::Isophotes => (
            "Isophotes",
            "bands of equal angle to the light: they join without a kink where normals are \
             continuous",
        ),
        ViewMode::Zebra => ("Zebra", "reflected stripes, moving with the view"),
        ViewMode::Mean => (
            "H",
            "mean curvature, negative on a sphere seen from outside",
        ),
        ViewMode::Gauss => ("K", "Gaussian curvature"),
        ViewMode::K1 => ("k1", "greater principal curvature"),
        ViewMode::K2 => ("k2", "smaller principal curvature"),
        ViewMode::Deviation => ("Deviation", "distance from the start of the flow"),
    }
}

/// View modes and switches.
pub fn toolbar_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let view = &model.view;
    let ctx = ui.ctx().clone();
    ui.horizontal_wrapped(|ui| {
        for mode in ViewMode::ALL {
            let (title, about) = mode_words(mode);
            let hint = hint(&ctx, Command::NextMode(true));
            if ui
                .selectable_label(view.style.mode == mode, title)
                .on_hover_text(format!("{about}{hint}"))
                .clicked()
            {
                let mut style = view.style;
                style.mode = mode;
                actions.push(Action::Style(style));
            }
        }
        if matches!(view.style.mode, ViewMode::Isophotes | ViewMode::Zebra) {
            ui.separator();
            stripes_ui(ui, model, actions);
        }
        ui.separator();
        for (title, about, switch, on) in [
            (
                "Wireframe",
                "edges of the control mesh",
                Switch::Wireframe,
                view.style.wireframe,
            ),
            (
                "Tint",
                "patches in a colour of their own",
                Switch::Tint,
                view.style.tint_patch,
            ),
            (
                "Limit surface",
                "off: the flat triangles of the control mesh",
                Switch::LimitSurface,
                view.limit_surface,
            ),
            (
                "Original",
                "off: the patches alone",
                Switch::Original,
                view.show_original,
            ),
            (
                "Rims",
                "outlines of all open loops",
                Switch::Rims,
                view.show_rims,
            ),
        ] {
            let tip = format!("{about}{}", hint(&ctx, Command::Toggle(switch)));
            if ui.selectable_label(on, title).on_hover_text(tip).clicked() {
                actions.push(Action::Toggle(switch));
            }
        }
    });
}

fn stripes_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let mut style = model.view.style;
    let label = ui.label("Stripes");
    let slider = ui
        .add(egui::Slider::new(&mut style.stripes, 2..=60).logarithmic(true))
        .labelled_by(label.id)
        .on_hover_text(format!(
            "number of pairs of bands{}",
            hint(ui.ctx(), Command::Stripes(true))
        ));
    let mut changed = slider.changed();
    if style.mode == ViewMode::Isophotes {
        let d = style.light.normalize_or(DVec3::Y);
        let mut around = d.z.atan2(d.x).to_degrees();
        let mut above = d.y.clamp(-1.0, 1.0).asin().to_degrees();
        let label = ui.label("Light");
        let a = ui
            .add(egui::DragValue::new(&mut around).speed(1.0).suffix("°"))
            .labelled_by(label.id)
            .on_hover_text("direction to the light, around the vertical");
        let b = ui
            .add(
                egui::DragValue::new(&mut above)
                    .speed(1.0)
                    .range(-90.0..=90.0)
                    .suffix("°"),
            )
            .labelled_by(label.id)
            .on_hover_text("direction to the light, above the horizon");
        if a.changed() || b.changed() {
            let (s, c) = around.to_radians().sin_cos();
            let (up, flat) = above.to_radians().sin_cos();
            style.light = DVec3::new(flat * c, up, flat * s);
            changed = true;
        }
        changed |= ui
            .checkbox(&mut style.light_follows_view, "with the view")
            .on_hover_text("the light moves with the camera")
            .changed();
    }
    if changed {
        actions.push(Action::Style(style));
    }
}
