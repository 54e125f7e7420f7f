//! The bottom panel of a run: playback buttons, timeline, numbers, plots.

use eframe::egui::{self, RichText, Ui};
use egui_extras::{Column, TableBody, TableBuilder, TableRow};

use super::format::{format_number, long_number};
use super::icons::{Icon, icon_button};
use super::plots::plots_ui;
use super::theme;
use super::widgets::{ClickActions, number};
use crate::app::action::{Action, RunAction, Switch, ViewAction};
use crate::app::model::Model;
use crate::app::run::{Figures, Run, RunVariant};
use crate::app::seam::Seam;
use crate::solver::End;

/// The panel of a run: the transport bar, and numbers and plots if they are open.
pub(crate) fn transport_ui(
    ui: &mut Ui,
    model: &Model,
    run: &Run,
    details: bool,
    actions: &mut Vec<Action>,
) {
    bar_ui(ui, model, run, details, actions);
    if !details {
        return;
    }
    ui.separator();
    // the height of the panel does not depend on its content
    ui.take_available_height();
    let width = ui.available_width();
    ui.horizontal_top(|ui| {
        let height = ui.available_height();
        let numbers = egui::vec2((0.62 * width).min(NUMBERS), height);
        let layout = egui::Layout::top_down(egui::Align::Min);
        ui.allocate_ui_with_layout(numbers, layout, |ui| {
            ui.set_min_size(numbers);
            numbers_ui(ui, model, run, actions);
        });
        plots_ui(ui, run, actions);
    });
}

/// Width of the table of numbers where there is room.
const NUMBERS: f32 = 640.0;

/// Buttons, timeline and pace in one row.
fn bar_ui(ui: &mut Ui, model: &Model, run: &Run, details: bool, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let ended = run.ended();
        let playing = run.playing;
        let (icon, play) = if playing {
            (Icon::Pause, "Pause")
        } else {
            (Icon::Play, "Play")
        };
        let tip = match (playing, ended) {
            (true, _) => "pause",
            (false, true) => "replay the stored states",
            (false, false) => "continue the flow",
        };
        ui.spacing_mut().item_spacing.x = 2.0;
        for (icon, name, tip, action, enabled) in [
            (
                Icon::Rewind,
                "Rewind",
                "show the first state",
                RunAction::Scrub(Some(0)),
                true,
            ),
            (icon, play, tip, RunAction::PlayPause, true),
            (
                Icon::Step,
                "Step",
                "take one step, then pause",
                RunAction::Step,
                !ended || run.scrubbed(),
            ),
            (
                Icon::Finish,
                "Finish",
                "continue to the converged shape in fast mode",
                RunAction::Finish,
                !ended,
            ),
            (
                Icon::Stop,
                "Stop",
                "end the flow here",
                RunAction::Stop,
                !ended,
            ),
            (
                Icon::Continue,
                "Continue from here",
                "continue the flow from the shown state with the current controls",
                RunAction::ContinueFromShown,
                run.scrubbed(),
            ),
        ] {
            let key = match action {
                RunAction::Stop => Action::Escape,
                _ => action.into(),
            };
            let button = ui.add_enabled_ui(enabled, |ui| icon_button(ui, icon, name, false));
            button
                .inner
                .key_tip(&format!("{name}: {tip}"), key)
                .on_click(action, actions);
        }
        ui.spacing_mut().item_spacing.x = 6.0;
        ui.separator();
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            icon_button(ui, Icon::BottomPanel, "Numbers and plots", details).on_click_with_key(
                "numbers and plots of the run",
                ViewAction::Toggle(Switch::Details),
                actions,
            );
            let mut pace = model.view.pace;
            let value = number(&mut pace).range(1.0..=240.0);
            let value = value.speed(0.5).suffix(" states/s");
            if ui
                .add_sized([96.0, 20.0], value)
                .on_hover_text("maximum number of states per second")
                .changed()
            {
                actions.push(RunAction::Pace(pace).into());
            }
            ui.separator();
            timeline_ui(ui, run, actions);
        });
    });
}

/// The timeline, from right to left.
fn timeline_ui(ui: &mut Ui, run: &Run, actions: &mut Vec<Action>) {
    let count = run.state_count();
    let last = count.saturating_sub(1);
    let mut at = run
        .sides
        .iter()
        .filter_map(|s| s.shown)
        .min()
        .unwrap_or(last);
    let words = format!("state {} of {count}", (at + 1).min(count));
    let size = egui::vec2(112.0, ui.spacing().interact_size.y);
    let label = ui.allocate_ui_with_layout(size, *ui.layout(), |ui| {
        ui.set_min_width(size.x);
        ui.add(egui::Label::new(RichText::new(words).weak()).truncate())
    });
    ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(40.0);
    let slider = egui::Slider::new(&mut at, 0..=last.max(1)).show_value(false);
    let slider = ui
        .add_enabled(last > 0, slider)
        .labelled_by(label.inner.id)
        .on_hover_text("stored states of the flow");
    slider.widget_info(|| egui::WidgetInfo::slider(last > 0, at as f64, "Timeline"));
    if slider.changed() {
        actions.push(RunAction::Scrub((at < last).then_some(at)).into());
    }
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

/// The columns of the table: title, width, tooltip. The second one has the remaining width.
const COLUMNS: [(&str, f32, &str); 8] = [
    (
        "holes",
        64.0,
        "holes are solved together if their surroundings overlap; click a row to show its hole",
    ),
    ("status", 104.0, "how the flow ended"),
    ("step", 36.0, "accepted steps"),
    (
        "τ/τ_ref",
        62.0,
        "time step divided by the natural time of the hole",
    ),
    (
        "energy",
        80.0,
        "what the flow lowers: with the surface model energy the integral of f over the patch and its support region, \
         with others a functional of their own",
    ),
    (
        "residual",
        58.0,
        "predicted remaining motion divided by the hole radius; converged below 1e-6",
    ),
    ("angle", 38.0, "smallest angle of the patch's triangles"),
    ("rejected", 56.0, "rejected steps"),
];

fn numbers_ui(ui: &mut Ui, model: &Model, run: &Run, actions: &mut Vec<Action>) {
    egui::ScrollArea::both().id_salt("numbers").show(ui, |ui| {
        let mut table = TableBuilder::new(ui)
            .striped(true)
            .vscroll(false)
            .sense(egui::Sense::click());
        for (i, (_, width, _)) in COLUMNS.into_iter().enumerate() {
            let column = if i == 1 {
                Column::remainder().at_least(width)
            } else {
                Column::exact(width)
            };
            table = table.column(column.clip(true));
        }
        table
            .header(18.0, |mut header| {
                for (title, _, tip) in COLUMNS {
                    header.col(|ui| {
                        ui.strong(title).on_hover_text(tip);
                    });
                }
            })
            .body(|mut body| {
                for (s, side) in run.sides.iter().enumerate() {
                    groups_ui(&mut body, run, s, side, actions);
                }
            });
        for (s, display) in model.displays.iter().take(run.sides.len()).enumerate() {
            if let Some(seam) = display.latest().and_then(|d| d.seam) {
                seam_ui(ui, run, s, seam);
            }
        }
        for side in &run.sides {
            for warning in side.shown_warnings() {
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
        words.push(format!("curvature jump {} 1/unit", format_number(jump)));
    }
    if !words.is_empty() {
        ui.label(format!("{}{}", run.prefix(s), words.join(", ")))
            .on_hover_text(
                "maxima along the rims: angle between the normals of the two sides (G0; 0 by \
                 construction for G1), difference of mean curvature between the faces of the two \
                 sides (G1)",
            );
    }
}

fn groups_ui(
    body: &mut TableBody<'_>,
    run: &Run,
    s: usize,
    side: &RunVariant,
    actions: &mut Vec<Action>,
) {
    let mut rows: Vec<_> = side.figures().into_iter().enumerate().collect();
    if side.handle.ended() {
        rows.sort_by_key(|(_, figures)| !figures.needs_attention());
    }
    if rows.is_empty() {
        let words = if side.handle.ended() {
            "no flow: the patches have no new vertices"
        } else {
            "first patches…"
        };
        body.row(18.0, |mut row| {
            row.col(|_| {});
            row.col(|ui| {
                cell(ui, RichText::new(words).weak(), words);
            });
            for _ in 2..COLUMNS.len() {
                row.col(|_| {});
            }
        });
    }
    for (g, figures) in rows {
        body.row(18.0, |mut row| {
            group_ui(&mut row, run, s, side, g, &figures);
            let response = row.response();
            response.hovers(&figures.holes, actions);
            if let Some(&hole) = figures.holes.first() {
                response.on_click(ViewAction::FlyToLoop(hole), actions);
            }
        });
    }
}

/// Text that is elided to the width of its column, with the whole text as a tooltip.
fn cell(ui: &mut Ui, text: impl Into<egui::WidgetText>, whole: &str) {
    let label = egui::Label::new(text).truncate();
    let label = ui.add(label.show_tooltip_when_elided(whole.is_empty()));
    if !whole.is_empty() {
        label.on_hover_text(whole);
    }
}

fn group_ui(
    row: &mut TableRow<'_, '_>,
    run: &Run,
    s: usize,
    side: &RunVariant,
    g: usize,
    figures: &Figures,
) {
    let holes = format!("{}{}", run.prefix(s), run.holes_words(figures));
    let numbers = [
        figures.step.map(|n| n.to_string()),
        figures.relative_tau.map(format_number),
        figures.energy.map(long_number),
        figures.residual.map(|r| format!("{r:.1e}")),
    ];
    row.col(|ui| cell(ui, holes.as_str(), &holes));
    row.col(|ui| status_ui(ui, figures));
    for number in numbers {
        row.col(|ui| cell(ui, number.unwrap_or_default(), ""));
    }
    row.col(|ui| {
        let angle = figures.angle.map(|a| format!("{a:.0}°"));
        cell(ui, angle.unwrap_or_default(), "");
    });
    row.col(|ui| {
        let reason = side.curves.get(g).and_then(|c| c.rejection.as_ref());
        let reason = reason.map_or_else(String::new, |r| format!("reason of the last one: {r}"));
        cell(ui, figures.rejected.to_string(), &reason);
    });
}

/// How a flow ended, or what it does.
fn status_ui(ui: &mut Ui, figures: &Figures) {
    match &figures.end {
        Some(Err(text)) => cell(
            ui,
            RichText::new("failed").color(ui.visuals().error_fg_color),
            text,
        ),
        Some(Ok(_)) if !figures.unsound.is_empty() => {
            let color = ui.visuals().warn_fg_color;
            let whole = format!(
                "the flow has ended, but the patch of hole {} intersects itself or the mesh, is folded, or \
                 is far from its rim",
                figures.unsound_list()
            );
            cell(ui, RichText::new("has defects").color(color), &whole);
        }
        Some(Ok(End::Converged)) => {
            cell(ui, RichText::new("converged").color(theme::success(ui)), "");
        }
        Some(Ok(end)) => {
            let words = end_words(*end);
            let color = ui.visuals().warn_fg_color;
            cell(ui, RichText::new(words).color(color), words);
        }
        None => cell(ui, RichText::new(&figures.doing).weak(), &figures.doing),
    }
}
