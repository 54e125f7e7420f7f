//! Shape, energies, curvatures, triangles, distances.

use eframe::egui::{self, Grid, Ui};
use egui_plot::{Bar, BarChart, Plot};

use super::{grid, place, row};
use crate::app::action::{Action, ViewAction};
use crate::app::document::file_name;
use crate::app::model::Model;
use crate::app::report::{Measured, ReportAction};
use crate::app::ui::format::{format_number, grouped, long_number};
use crate::app::ui::plots;
use crate::app::ui::widgets::ClickActions;
use crate::render::ViewMode;

/// Maximum number of listed intersections.
const LISTED: usize = 12;

/// Energies with a row of their own.
const LISTED_ENERGIES: [&str; 5] = ["1", "H^2", "K", "K^2", "k1^2+k2^2"];

/// Counts and integrals.
pub(crate) fn shape_ui(ui: &mut Ui, measured: &Measured) {
    let s = &measured.analysis.shape;
    let e = &s.energies;
    let or_open = |v: Option<f64>| v.map_or_else(|| "open".into(), format_number);
    grid(ui, "shape", |ui| {
        let counts = list([s.vertices, s.faces, s.edges].map(grouped));
        row(ui, "Vertices, faces, edges", "", counts);
        let counts = list([s.components, s.boundary_loops]);
        let tip = "connected components; boundary loops";
        row(ui, "Components, loops", tip, counts);
        let tip = "vertices - edges + faces; number of handles, as if all holes were filled";
        let value = format!("{}, {}", s.euler, s.genus);
        row(ui, "Euler number, genus", tip, value);
        let tip = "of the limit surface and of the triangles";
        for (name, limit, mesh) in [
            ("Area", Some(s.area), Some(s.mesh_area)),
            ("Volume", s.volume, s.mesh_volume),
        ] {
            let both = format!("{}  (mesh {})", or_open(limit), or_open(mesh));
            row(ui, name, tip, both);
        }
        let tip = "integral over the limit surface, without the contribution of creases";
        row(ui, "Energy 1", tip, long_number(s.area));
        row(ui, "Energy H^2", tip, long_number(e.willmore));
        row(ui, "Energy K", tip, long_number(e.total_curvature));
        row(ui, "Energy K^2", tip, long_number(e.gauss_squared));
        row(ui, "Energy k1^2+k2^2", tip, long_number(e.bending));
        if let (Some(given), Some(energy)) = (e.given, &measured.request.energy)
            && !LISTED_ENERGIES.contains(&energy.text())
        {
            row(
                ui,
                &format!("Energy {}", energy.text()),
                tip,
                long_number(given),
            );
        }
    });
}

/// Values with commas between them.
fn list<T: ToString, const N: usize>(values: [T; N]) -> String {
    values.map(|value| value.to_string()).join(", ")
}

/// Range and histogram of one curvature.
pub(crate) fn curvature_ui(
    ui: &mut Ui,
    model: &Model,
    measured: &Measured,
    actions: &mut Vec<Action>,
) {
    let all = measured.analysis.curvature.named();
    let chosen = model.view.report.curvature.min(all.len() - 1);
    ui.horizontal(|ui| {
        for (i, (name, _)) in all.iter().enumerate() {
            let name = format!("{name} ");
            ui.selectable_label(i == chosen, name)
                .on_click(ReportAction::Curvature(i), actions);
        }
    });
    let (name, range) = all[chosen];
    let h = &range.histogram;
    let width = (h.to - h.from) / h.share.len().max(1) as f64;
    if width > 0.0 {
        let bars = h.share.iter().enumerate().map(|(i, &share)| {
            let middle = h.from + (i as f64 + 0.5) * width;
            Bar::new(middle, 100.0 * share).width(width)
        });
        Plot::new("histogram")
            .height(96.0)
            .allow_scroll(false)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_boxed_zoom(false)
            .show_axes([true, true])
            .show_grid([false, true])
            .x_grid_spacer(|input| plots::marks(&input, plots::WIDE, false))
            .custom_x_axes(vec![plots::axis()])
            .show(ui, |plot| {
                plot.bar_chart(BarChart::new(name, bars.collect()).allow_hover(false));
            })
            .response
            .on_hover_text(
                "percentage of the area by value; the end bars include values outside the range",
            );
    }
    Grid::new("range")
        .num_columns(4)
        .spacing([12.0, 3.0])
        .show(ui, |ui| {
            ui.label("least");
            place(ui, range.min, range.min_at, actions);
            ui.label("greatest");
            place(ui, range.max, range.max_at, actions);
            ui.end_row();
            ui.label("average");
            ui.label(format_number(range.average));
            ui.label("deviation");
            ui.label(format_number(range.deviation));
            ui.end_row();
        });
}

/// Shape of the triangles, and their intersections.
pub(crate) fn quality_ui(ui: &mut Ui, measured: &Measured, actions: &mut Vec<Action>) {
    let q = &measured.analysis.quality;
    grid(ui, "quality", |ui| {
        ui.label("Smallest angle");
        place(ui, q.min_angle, q.min_angle_at, actions);
        ui.end_row();
        let angles = [q.mean_min_angle, q.max_angle].map(format_number);
        row(ui, "Mean of smallest, largest", "degrees", list(angles));
        let value = list([q.slivers, q.degenerate]);
        row(ui, "Below 10°, zero area", "triangles", value);
        let tip = "twice the inscribed radius over the circumscribed radius, 1 for an equilateral \
                   triangle: minimum, mean";
        let [least, mean, _] = q.radius_ratio.map(format_number);
        row(ui, "Radius ratio", tip, list([least, mean]));
        let [shortest, mean, longest] = q.edge_length.map(format_number);
        row(ui, "Shortest, mean edge", "lengths", list([shortest, mean]));
        row(ui, "Longest edge", "length", longest);
        let tip = "degrees between the normals of neighbouring triangles";
        let value = format_number(q.max_dihedral);
        row(ui, "Maximum dihedral angle", tip, value);
        let folded = q.folded_edges.to_string();
        row(ui, "Folded edges", "dihedral angle above 150°", folded);
        let tip = "pairs of triangles that intersect outside their common edges and vertices";
        let value = q.self_intersections.to_string();
        row(ui, "Self-intersections", tip, value);
    });
    let listed = q.self_intersections_at.iter().take(LISTED).enumerate();
    ui.horizontal_wrapped(|ui| {
        for (i, at) in listed {
            if i == 0 {
                ui.label("show");
            }
            let at = crate::mesh::DVec3::from_array(*at);
            let link = ui.link((i + 1).to_string());
            link.on_click(ReportAction::Inspect(at), actions);
        }
    });
}

/// The reference and the distances.
pub(crate) fn distance_ui(
    ui: &mut Ui,
    model: &Model,
    measured: &Measured,
    actions: &mut Vec<Action>,
) {
    let report = &model.report;
    ui.horizontal_wrapped(|ui| {
        ui.button("Choose a mesh…")
            .on_hover_text("the reference that the surface is compared with (analyze --against)")
            .on_click(ReportAction::AskReference, actions);
        if let Some((path, _)) = &report.loading {
            ui.add(egui::Spinner::new().size(12.0));
            ui.weak(file_name(path));
        } else if let Some(reference) = &report.reference {
            ui.label(file_name(&reference.path))
                .on_hover_text(reference.path.display().to_string());
            ui.small_button("Remove")
                .on_click(ReportAction::DropReference, actions);
        }
    });
    if report.reference.is_none() {
        return;
    }
    let mut style = model.view.style;
    let mut coloured = style.mode == ViewMode::Distance;
    if ui
        .checkbox(&mut coloured, "Colour the view by distance")
        .on_hover_text(
            "distance of the drawn surface (limit surface or triangles), positive on the outer \
             side of the reference; set the range above the view",
        )
        .changed()
    {
        style.mode = if coloured {
            ViewMode::Distance
        } else {
            ViewMode::Shaded
        };
        style.range = None;
        actions.push(ViewAction::Style(style).into());
    }
    let Some(d) = &measured.analysis.distances else {
        ui.weak("measuring…");
        return;
    };
    Grid::new("distances")
        .striped(true)
        .num_columns(4)
        .spacing([8.0, 3.0])
        .show(ui, |ui| {
            for title in ["triangles", "RMS", "mean", "largest"] {
                ui.strong(title);
            }
            ui.end_row();
            for (name, one) in [
                ("to reference", &d.to_reference),
                ("from reference", &d.from_reference),
            ] {
                ui.label(name);
                ui.label(format_number(one.rms));
                ui.label(format_number(one.mean));
                place(ui, one.max, one.max_at, actions);
                ui.end_row();
            }
            ui.label("both");
            ui.label(format_number(d.rms));
            ui.label("");
            ui.label(format_number(d.max));
            ui.end_row();
        });
}
