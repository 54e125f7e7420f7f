//! The bottom panel of a run: playback buttons, timeline, numbers, plots.

use eframe::egui::{self, RichText, Ui};
use egui_plot::{Legend, Line, Plot, PlotPoints, VLine};

use super::format::format_number;
use super::widgets::{Asks, named};
use crate::app::action::{Action, RunAction};
use crate::app::model::Model;
use crate::app::run::{Run, RunVariant};
use crate::app::seam::Seam;
use crate::mesh::LoopId;
use crate::ops::Operation;
use crate::solver::End;

/// The panel of a run.
pub(crate) fn transport_ui(ui: &mut Ui, model: &Model, actions: &mut Vec<Action>) {
    let Some(run) = &model.run else { return };
    // the height of the panel does not depend on its content
    ui.take_available_height();
    ui.add_space(2.0);
    buttons_ui(ui, model, run, actions);
    timeline_ui(ui, run, actions);
    ui.columns(2, |columns| {
        numbers_ui(&mut columns[0], model, run);
        plots_ui(&mut columns[1], run);
    });
}

fn buttons_ui(ui: &mut Ui, model: &Model, run: &Run, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        let ended = run.ended();
        let play = if run.playing { "Pause" } else { "Play" };
        let tip = if ended {
            "replay the stored states"
        } else {
            "continue or pause"
        };
        for (text, tip, action, enabled) in [
            (
                "Rewind",
                "show the first state",
                RunAction::Scrub(Some(0)),
                true,
            ),
            (play, tip, RunAction::PlayPause, true),
            (
                "Step",
                "take one step, then pause",
                RunAction::Step,
                !ended || run.scrubbed(),
            ),
            (
                "Finish",
                "continue to the converged shape in fast mode",
                RunAction::Finish,
                !ended,
            ),
            ("Stop", "end the flow here", RunAction::Stop, !ended),
        ] {
            let key = match action {
                RunAction::Stop => Action::Escape,
                _ => action.into(),
            };
            ui.add_enabled(enabled, egui::Button::new(text))
                .key_tip(tip, key)
                .asks(action, actions);
        }
        if run.scrubbed() {
            ui.button("Continue from here")
                .on_hover_text("continue the flow from the shown state with the current controls")
                .asks(RunAction::ContinueFromShown, actions);
        }
        ui.separator();
        let mut pace = model.view.pace;
        let value = egui::DragValue::new(&mut pace).range(1.0..=240.0);
        let value = named(ui, "Pace", value.speed(0.5).suffix(" states/s"));
        if value
            .on_hover_text("maximum number of states per second")
            .changed()
        {
            actions.push(RunAction::Pace(pace).into());
        }
    });
}

fn timeline_ui(ui: &mut Ui, run: &Run, actions: &mut Vec<Action>) {
    let count = run.state_count();
    let last = count.saturating_sub(1);
    let mut at = run
        .sides
        .iter()
        .filter_map(|s| s.shown)
        .min()
        .unwrap_or(last);
    ui.horizontal(|ui| {
        let label = ui.label("Timeline");
        ui.spacing_mut().slider_width = (ui.available_width() - 170.0).max(80.0);
        let slider = egui::Slider::new(&mut at, 0..=last.max(1)).show_value(false);
        let slider = ui
            .add_enabled(last > 0, slider)
            .labelled_by(label.id)
            .on_hover_text("stored states of the flow");
        if slider.changed() {
            actions.push(RunAction::Scrub((at < last).then_some(at)).into());
        }
        ui.weak(format!("state {} of {count}", (at + 1).min(count)));
    });
}

/// How a flow ended, in words.
fn end_words(end: End) -> &'static str {
    match end {
        End::Converged => "converged",
        End::MaxSteps => "maximum number of steps",
        End::StepSizeCollapsed => "stopped: no step lowers the energy",
        End::Pinched => "pinched off: the last open shape is kept",
        End::SelfIntersected => "self-intersection: the last shape without one is kept",
        End::Cancelled => "stopped",
    }
}

fn numbers_ui(ui: &mut Ui, model: &Model, run: &Run) {
    egui::ScrollArea::both().id_salt("numbers").show(ui, |ui| {
        egui::Grid::new("groups")
            .striped(true)
            .num_columns(8)
            .show(ui, |ui| {
                for (title, tip) in [
                    (
                        "holes",
                        "holes are solved together if their surroundings overlap",
                    ),
                    ("step", "accepted steps"),
                    (
                        "τ/τ_ref",
                        "time step divided by the natural time of the hole",
                    ),
                    (
                        "energy",
                        "integral of f over the patch and its support region",
                    ),
                    (
                        "residual",
                        "predicted remaining motion divided by the hole radius; converged below \
                         1e-6",
                    ),
                    ("rejected", "rejected steps"),
                    ("angle", "smallest angle of the patch's triangles"),
                    ("", ""),
                ] {
                    ui.strong(title).on_hover_text(tip);
                }
                ui.end_row();
                for (s, side) in run.sides.iter().enumerate() {
                    groups_ui(ui, run, s, side);
                }
            });
        for (s, display) in model.displays.iter().take(run.sides.len()).enumerate() {
            if let Some(seam) = display.latest().and_then(|d| d.seam) {
                seam_ui(ui, run, s, seam);
            }
        }
        for side in &run.sides {
            for warning in &side.warnings {
                ui.label(
                    RichText::new(warning)
                        .small()
                        .color(ui.visuals().warn_fg_color),
                );
            }
        }
    });
}

/// Continuity of the patch and the mesh: the maxima along the rims.
fn seam_ui(ui: &mut Ui, run: &Run, s: usize, seam: Seam) {
    let mut words = Vec::new();
    if let Some(angle) = seam.angle {
        words.push(format!("seam angle {angle:.1}°"));
    }
    if let Some(jump) = seam.jump {
        words.push(format!("curvature jump {}", format_number(jump)));
    }
    if !words.is_empty() {
        ui.label(format!("{}{}", side_name(run, s), words.join(", ")))
            .on_hover_text(
                "maxima along the rims: angle between the normals of the two sides (G0; 0 by \
                 construction for G1), difference of mean curvature between the faces of the two \
                 sides (G1)",
            );
    }
}

/// The prefix of texts about one side of a comparison.
fn side_name(run: &Run, s: usize) -> String {
    let names = run.names();
    let name = names.get(s).copied().unwrap_or("");
    if name.is_empty() {
        String::new()
    } else {
        format!("{name} ")
    }
}

fn groups_ui(ui: &mut Ui, run: &Run, s: usize, side: &RunVariant) {
    let rows = side.figures();
    if rows.is_empty() {
        ui.label(if side.handle.ended() {
            "no flow: the patches have no new vertices"
        } else {
            "first patches…"
        });
        ui.end_row();
    }
    for (g, row) in rows.into_iter().enumerate() {
        let numbers = |holes: &[LoopId], between| {
            let words: Vec<String> = holes.iter().map(LoopId::to_string).collect();
            words.join(between)
        };
        let what = match &run.operation {
            Operation::Blend(spec) => numbers(&spec.loops, "+"),
            Operation::Fair(spec) => format!("{} faces", spec.faces.len()),
            Operation::Refine(_) => row.level.map_or_else(String::new, |n| format!("level {n}")),
            _ => numbers(&row.holes, ", "),
        };
        let text = |value: Option<String>| value.unwrap_or_default();
        ui.label(format!("{}{what}", side_name(run, s)));
        ui.label(text(row.step.map(|n| n.to_string())));
        ui.label(text(row.relative_tau.map(format_number)));
        ui.label(text(row.energy.map(|e| format!("{:.6}", Sig(e)))));
        ui.label(text(row.residual.map(|r| format!("{r:.1e}"))));
        let rejected = ui.label(row.rejected.to_string());
        if let Some(reason) = side.curves.get(g).and_then(|c| c.rejection.as_ref()) {
            rejected.on_hover_text(format!("reason of the last one: {reason}"));
        }
        ui.label(text(row.angle.map(|a| format!("{a:.0}°"))));
        match row.end {
            Some(Err(text)) => {
                ui.label(RichText::new("failed").color(super::error_color(ui)))
                    .on_hover_text(text);
            }
            Some(Ok(End::Converged)) => {
                ui.label(RichText::new("converged").color(super::success_color(ui)));
            }
            Some(Ok(end)) => {
                ui.label(RichText::new(end_words(end)).color(ui.visuals().warn_fg_color));
            }
            None => {
                ui.weak(row.doing);
            }
        }
        ui.end_row();
    }
}

/// A number with six significant digits.
struct Sig(f64);

impl std::fmt::Display for Sig {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let x = self.0;
        let size = x.abs();
        if x == 0.0 || (1e-3..1e6).contains(&size) {
            let digits = if x == 0.0 {
                5
            } else {
                (5 - size.log10().floor() as i32).clamp(0, 9) as usize
            };
            write!(f, "{x:.digits$}")
        } else {
            write!(f, "{x:.5e}")
        }
    }
}

fn plots_ui(ui: &mut Ui, run: &Run) {
    let height = ui.available_height().max(60.0);
    ui.columns(2, |columns| {
        for (column, (name, title)) in columns.iter_mut().zip([
            ("energy", "energy by attempt"),
            ("residual", "log10 of the residual by attempt"),
        ]) {
            column.small(title);
            let energy = name == "energy";
            let curves = curves(run, energy);
            let mut plot = Plot::new(name)
                .height((height - 22.0).max(40.0))
                .allow_scroll(false)
                .allow_drag(false)
                .allow_zoom(false)
                .show_axes([true, true]);
            if (2..5).contains(&curves.len()) {
                plot = plot.legend(Legend::default());
            }
            // a curve that is constant up to rounding needs a minimum height
            if let Some([low, high]) = extent(&curves)
                && high - low <= 1e-6 * high.abs().max(low.abs())
            {
                let pad = (0.01 * high.abs()).max(1e-12);
                plot = plot.include_y(low - pad).include_y(high + pad);
            }
            plot.show(column, |plot| {
                for (name, points) in curves {
                    plot.line(Line::new(name, PlotPoints::from(points)).width(1.8));
                }
                for side in run.sides.iter().filter(|s| s.shown.is_some()) {
                    if let Some(state) = side.state() {
                        plot.vline(VLine::new("", state.attempt() as f64).width(1.0));
                    }
                }
            });
        }
    });
}

/// Minimum and maximum.
fn extent(curves: &[(String, Vec<[f64; 2]>)]) -> Option<[f64; 2]> {
    let values = curves.iter().flat_map(|(_, points)| points);
    values.map(|p| p[1]).fold(None, |range, y| match range {
        None => Some([y, y]),
        Some([low, high]) => Some([low.min(y), high.max(y)]),
    })
}

/// One curve with its name for each group of each side.
fn curves(run: &Run, energy: bool) -> Vec<(String, Vec<[f64; 2]>)> {
    let mut all = Vec::new();
    for side in &run.sides {
        for (g, curve) in side.curves.iter().enumerate() {
            let points = if energy {
                &curve.energy
            } else {
                &curve.residual
            };
            let name = match (run.sides.len(), side.curves.len()) {
                (1, 1) => String::new(),
                (1, _) => format!("{}", g + 1),
                (_, 1) => side.name.into(),
                _ => format!("{}{}", side.name, g + 1),
            };
            // energies of different holes share a plot, so each is relative to its start
            let scale = match (energy, side.curves.len(), points.first()) {
                (true, 2.., Some(first)) if first[1] != 0.0 => first[1].recip(),
                _ => 1.0,
            };
            all.push((name, points.iter().map(|p| [p[0], p[1] * scale]).collect()));
        }
    }
    all
}
