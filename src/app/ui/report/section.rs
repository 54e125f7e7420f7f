//! The section and its comb.

use eframe::egui::{Button, Ui};

use super::{grid, row};
use crate::app::action::Action;
use crate::app::model::Model;
use crate::app::report::{Across, Comb, Pick, ReportAction};
use crate::app::scene_builder::natural_length;
use crate::app::ui::format::format_number;
use crate::app::ui::widgets::{ClickActions, Rail, slider_row};

/// The choice of the plane, the measures, and the look of the comb.
pub(crate) fn section_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let view = &model.view.report;
    ui.horizontal_wrapped(|ui| {
        ui.label("Click a point, cut across");
        for (across, title, tip) in [
            (Across::Axis(0), "x", "perpendicular to the x axis"),
            (Across::Axis(1), "y", "perpendicular to the y axis"),
            (Across::Axis(2), "z", "perpendicular to the z axis"),
            (
                Across::View,
                "the view",
                "vertical in the view, along the line of sight",
            ),
        ] {
            let chosen = view.pick == Pick::Section(across);
            let tip = format!("then click the surface: the plane contains that point, {tip}");
            let pick = if chosen {
                Pick::Holes
            } else {
                Pick::Section(across)
            };
            ui.add(Button::selectable(chosen, title))
                .on_hover_text(tip)
                .on_click(ReportAction::Pick(pick), actions);
        }
        if view.cut.is_some() {
            ui.button("Remove").on_click(ReportAction::DropCut, actions);
        }
    });
    let Some(cut) = &model.report.cut else {
        return;
    };
    let mut hidden = view.hide_front;
    ui.checkbox(&mut hidden, "Hide the half in front")
        .on_hover_text(
            "the side of the plane that is towards the eye; look from the other side to see it",
        )
        .on_click(ReportAction::HideFront(hidden), actions);
    let section = &cut.section;
    let mut comb = view.comb;
    let points = section.curves.iter().flat_map(|c| &c.points);
    let known = points.map(|p| if comb.own { p.curvature } else { p.averaged });
    let known: Vec<f64> = known.filter(|k| k.is_finite()).collect();
    grid(ui, "section", |ui| {
        let length: f64 = section.curves.iter().map(|c| c.length).sum();
        let both = format!("{}, {}", section.curves.len(), format_number(length));
        let tip = "number of connected curves; sum of their lengths";
        row(ui, "Curves, length", tip, both);
        if let (Some(low), Some(high)) = (
            known.iter().copied().reduce(f64::min),
            known.iter().copied().reduce(f64::max),
        ) {
            let range = format!("{} to {}", format_number(low), format_number(high));
            let tip = "of the plane curve; negative as on a sphere with outward normals";
            row(ui, "Curvature", tip, range);
        }
    });
    let radius = model.document.origin.bounds.radius();
    let natural = natural_length(section, &comb, radius);
    let mut length = comb.length.unwrap_or(natural);
    let lengths = Rail::logarithmic(natural * 0.02..=natural * 50.0);
    let tip = "length at the curvature of the model's bounding sphere, in radii of that sphere";
    if slider_row(ui, "Tooth length", tip, &mut length, natural, lengths) {
        comb.length = Some(length);
    }
    let densities = Rail::logarithmic(5.0..=400.0);
    let tip = "teeth per radius of the model, limited by the number of points";
    let default = Comb::default().density;
    slider_row(
        ui,
        "Tooth density",
        tip,
        &mut comb.density,
        default,
        densities,
    );
    ui.checkbox(&mut comb.own, "not averaged").on_hover_text(
        "the curvature of the limit surface itself, which jumps at discontinuities of G2 and has \
         spikes at irregular vertices, where it is not defined",
    );
    if comb != view.comb {
        actions.push(ReportAction::Comb(comb).into());
    }
}
