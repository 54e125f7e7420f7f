//! The plots of a run: energy and residual by attempt, with one legend.

use eframe::egui::{self, Color32, RichText, Ui};
use egui_plot::{AxisHints, GridInput, GridMark, Line, LineStyle, Plot, PlotPoints, VLine};

use super::format::{format_number, trimmed};
use super::theme;
use super::widgets::ClickActions;
use crate::app::action::Action;
use crate::app::run::Run;
use crate::mesh::LoopId;

/// Maximum number of curves in the legend.
const LISTED: usize = 9;
/// Width of the line before a name in the legend.
const SWATCH: f32 = 12.0;
/// Maximum number of curves in a readout.
const READ: usize = 12;

/// The curve of a group of holes of a side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlotCurve {
    /// Side and holes; empty if it is the only curve.
    pub(crate) name: String,
    /// Number of its colour: that of the side, or of the group if there is one side.
    pub(crate) color: usize,
    /// Its holes.
    pub(crate) holes: Vec<LoopId>,
    /// Attempt and value, in ascending order.
    pub(crate) points: Vec<[f64; 2]>,
}

impl PlotCurve {
    /// The points in pieces within which values are comparable. An energy does not rise by a step, so it is another one
    /// after a rise: that of new controls, or of a new metric (`g2` and `diffusion`).
    pub(crate) fn pieces(&self, is_energy: bool) -> impl Iterator<Item = &[[f64; 2]]> {
        let falls = move |a: &[f64; 2], b: &[f64; 2]| {
            !is_energy || b[1] <= a[1] + 1e-9 * a[1].abs().max(b[1].abs())
        };
        self.points.chunk_by(falls)
    }

    /// Attempt and value of the point nearest to an attempt.
    pub(crate) fn nearest(&self, attempt: f64) -> Option<[f64; 2]> {
        let far = |p: &[f64; 2]| (p[0] - attempt).abs();
        let points = self.points.iter().copied();
        points.min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

/// The legend, and the plots side by side.
pub(crate) fn plots_ui(ui: &mut Ui, run: &Run, actions: &mut Vec<Action>) {
    let both = [true, false].map(|energy| curves(run, energy));
    ui.vertical(|ui| {
        if both[0].len() > 1 {
            legend_ui(ui, &entries(run, &both[0]), actions);
        }
        let height = ui.available_height().max(60.0);
        let last = last_attempt(&both);
        ui.columns(2, |columns| {
            for ((column, curves), energy) in columns.iter_mut().zip(both).zip([true, false]) {
                plot_ui(column, run, &curves, energy, last, height);
            }
        });
    });
}

/// The last attempt of all plots, at least 1: their common axis begins at 0.
fn last_attempt(both: &[Vec<PlotCurve>; 2]) -> f64 {
    let points = both.iter().flatten().flat_map(|curve| &curve.points);
    points.map(|point| point[0]).fold(1.0, f64::max)
}

/// The entries of the legend: name, number of the colour, and holes. The curves of one side of a comparison have
/// one colour, and so one entry.
pub(crate) fn entries(run: &Run, curves: &[PlotCurve]) -> Vec<(String, usize, Vec<LoopId>)> {
    if run.sides.len() > 1 {
        let sides = run.sides.iter().enumerate();
        return sides
            .map(|(s, side)| (side.name.to_owned(), s, Vec::new()))
            .collect();
    }
    let entry = |curve: &PlotCurve| (curve.name.clone(), curve.color, curve.holes.clone());
    curves.iter().map(entry).collect()
}

/// Names in the colours of the curves, in one row.
fn legend_ui(ui: &mut Ui, entries: &[(String, usize, Vec<LoopId>)], actions: &mut Vec<Action>) {
    let small = egui::TextStyle::Small.resolve(ui.style());
    let width = |name: &str| {
        let galley = ui
            .painter()
            .layout_no_wrap(name.into(), small.clone(), Color32::WHITE);
        galley.size().x + SWATCH + 2.0 * ui.spacing().item_spacing.x
    };
    // the plots are as wide as the legend
    let mut room = ui.available_width() - width("and 999 more");
    let fits = |entry: &&(String, usize, Vec<LoopId>)| {
        room -= width(&entry.0);
        room >= 0.0
    };
    let listed = entries.iter().take(LISTED).take_while(fits).count();
    ui.horizontal(|ui| {
        for (name, number, holes) in &entries[..listed] {
            let color = theme::series(ui, *number);
            let (line, _) = ui.allocate_exact_size(egui::vec2(SWATCH, 3.0), egui::Sense::hover());
            if theme::is_dashed(*number) {
                for left in [line.left(), line.right() - 5.0] {
                    let dash =
                        egui::Rect::from_min_size([left, line.top()].into(), [5.0, 3.0].into());
                    ui.painter().rect_filled(dash, 1.0, color);
                }
            } else {
                ui.painter().rect_filled(line, 1.0, color);
            }
            let name = RichText::new(name).color(color);
            let label = ui.add(egui::Label::new(name.small()).truncate());
            if !holes.is_empty() {
                label.hovers(holes, actions);
            }
        }
        let more = entries.len() - listed;
        if more > 0 {
            ui.small(format!("and {more} more"));
        }
    });
}

/// One plot, whose axis of attempts reaches at least to `last`.
fn plot_ui(ui: &mut Ui, run: &Run, curves: &[PlotCurve], energy: bool, last: f64, height: f32) {
    let title = match (energy, curves.len()) {
        (true, 0 | 1) => "energy",
        (true, _) => "energy, relative to the start",
        (false, _) => "residual",
    };
    let range = extent(curves);
    let is_empty = range.is_none();
    // as after a change of the energy
    let when = if is_empty && last > 1.0 {
        "known after the next attempt"
    } else {
        "by attempt"
    };
    let words = RichText::new(format!("{title}, {when}")).small();
    // in one line: the height of the plot is what is left
    ui.add(egui::Label::new(words).truncate());
    let mut plot = Plot::new(title)
        .height((height - 22.0).max(40.0))
        .width((ui.available_width() - LABEL).max(40.0))
        .include_x(0.0)
        .include_x(last)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .x_grid_spacer(|input| marks(&input, WIDE, true))
        .y_grid_spacer(move |input| {
            if is_empty {
                Vec::new()
            } else if energy {
                marks(&input, HIGH, false)
            } else {
                logarithmic_marks(&input)
            }
        })
        .custom_x_axes(vec![
            AxisHints::new_x()
                .label_spacing(LABELS)
                .formatter(|mark, _| format!("{:.0}", mark.value)),
        ])
        .custom_y_axes(vec![
            AxisHints::new_y()
                .min_thickness(44.0)
                .label_spacing(LABELS)
                .formatter(move |mark, _| {
                    if energy {
                        mark_words(mark.value, mark.step_size)
                    } else {
                        power_words(mark.value)
                    }
                }),
        ])
        // the readout has the values of all curves
        .label_formatter(|_| None)
        .show_y(false)
        .link_cursor(egui::Id::unique("plots"), [true, false])
        .show_axes([true, true]);
    // a curve that is constant up to rounding needs a minimum height
    if let Some([low, high]) = range
        && high - low <= 1e-6 * high.abs().max(low.abs())
    {
        let pad = (0.01 * high.abs()).max(1e-12);
        plot = plot.include_y(low - pad).include_y(high + pad);
    }
    let ink = ui.visuals().weak_text_color();
    let inks: Vec<Color32> = curves.iter().map(|c| theme::series(ui, c.color)).collect();
    let shown = plot.show(ui, |plot| {
        for (curve, ink) in curves.iter().zip(&inks) {
            let style = if theme::is_dashed(curve.color) {
                LineStyle::dashed_loose()
            } else {
                LineStyle::Solid
            };
            for piece in curve.pieces(energy) {
                let points = PlotPoints::from(piece.to_vec());
                plot.line(Line::new("", points).width(1.8).color(*ink).style(style));
            }
        }
        for change in changes(run) {
            let mark = VLine::new("", change.0).style(LineStyle::dashed_dense());
            plot.vline(mark.color(ink).width(1.2));
        }
        for side in run.sides.iter().filter(|s| s.shown.is_some()) {
            if let Some(state) = side.state() {
                plot.vline(VLine::new("", state.attempt() as f64).color(ink).width(1.0));
            }
        }
    });
    let Some(at) = shown.response.hover_pos() else {
        return;
    };
    let x = shown.transform.value_from_position(at).x;
    let reach = 6.0 * shown.transform.dvalue_dpos()[0].abs();
    shown
        .response
        .on_hover_ui_at_pointer(|ui| readout_ui(ui, run, curves, energy, x, reach));
}

/// Room beside a plot for half of the label at its right end.
const LABEL: f32 = 14.0;

/// Smallest distance of two marks of an axis in points.
pub(crate) const WIDE: f64 = 40.0;
const HIGH: f64 = 18.0;
/// Distance of marks at which labels begin to show and are opaque: all marks are further apart.
const LABELS: egui::Rangef = egui::Rangef {
    min: 8.0,
    max: 16.0,
};

/// A horizontal axis whose marks all have labels.
pub(crate) fn axis() -> AxisHints<'static> {
    AxisHints::new_x()
        .label_spacing(LABELS)
        .formatter(|mark, _| mark_words(mark.value, mark.step_size))
}

/// The marks of an axis at multiples of a round step, at least `least` points apart. Of a `whole` axis
/// they are whole numbers.
pub(crate) fn marks(input: &GridInput, least: f64, whole: bool) -> Vec<GridMark> {
    // the step that is given is eight points
    let least = input.base_step_size / 8.0 * least;
    let step_size = round_step(if whole { least.max(1.0) } else { least });
    let (low, high) = input.bounds;
    let (first, last) = ((low / step_size).ceil(), (high / step_size).floor());
    let count = (last - first + 1.0).clamp(0.0, 100.0) as u32;
    let at = |i: u32| GridMark {
        value: (first + f64::from(i)) * step_size,
        step_size,
    };
    (0..count).map(at).collect()
}

/// The marks of an axis of decadic logarithms: at powers of ten, and at 2 and 5 times these if fewer than two
/// are visible.
fn logarithmic_marks(input: &GridInput) -> Vec<GridMark> {
    let powers = marks(input, HIGH, true);
    if powers.len() > 1 {
        return powers;
    }
    let (low, high) = input.bounds;
    let powers = low.floor() as i32..=high.ceil() as i32;
    let values = powers.flat_map(|k| [1.0f64, 2.0, 5.0].map(|m| f64::from(k) + m.log10()));
    let visible = values.filter(|value| (low..=high).contains(value));
    let mark = |value| GridMark {
        value,
        step_size: 2f64.log10(),
    };
    visible.map(mark).collect()
}

/// The number with a decadic logarithm, as in `2e-3`.
fn power_words(log: f64) -> String {
    let power = (log + 1e-6).floor();
    format!("{:.0}e{power:.0}", 10f64.powf(log - power))
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below a length.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0];
    let step = steps
        .into_iter()
        .find(|s| s * power >= least * (1.0 - 1e-9));
    step.unwrap_or(10.0) * power
}

/// The label of a mark, in as many digits as the step needs.
fn mark_words(value: f64, step: f64) -> String {
    let places = -step.log10().floor();
    if value.abs() >= 1e5 || places > 6.0 {
        return trimmed(value);
    }
    let places = places.max(0.0) as usize;
    format!("{value:.places$}")
}

/// The values of all curves at the attempt under the cursor, and the changes of controls within
/// `reach` of it.
fn readout_ui(ui: &mut Ui, run: &Run, curves: &[PlotCurve], energy: bool, x: f64, reach: f64) {
    ui.strong(format!("attempt {:.0}", x.max(0.0)));
    for curve in curves.iter().take(READ) {
        let Some([_, value]) = curve.nearest(x) else {
            continue;
        };
        let value = if energy {
            format_number(value)
        } else {
            format!("{:.1e}", 10f64.powf(value))
        };
        let words = format!("{}  {value}", curve.name);
        ui.colored_label(theme::series(ui, curve.color), words.trim_start());
    }
    if curves.len() > READ {
        ui.weak(format!("and {} more", curves.len() - READ));
    }
    for (_, what) in changes(run)
        .into_iter()
        .filter(|c| (c.0 - x).abs() <= reach)
    {
        ui.label(format!("changed: {what}"));
    }
}

/// The attempts at which controls were changed, with the changes; equal ones of both sides once.
pub(crate) fn changes(run: &Run) -> Vec<(f64, String)> {
    let mut all: Vec<(f64, String)> = Vec::new();
    for change in run.sides.iter().flat_map(|side| &side.changes) {
        let one = (change.attempt as f64, change.what.clone());
        if !all.contains(&one) {
            all.push(one);
        }
    }
    all
}

/// Minimum and maximum.
fn extent(curves: &[PlotCurve]) -> Option<[f64; 2]> {
    let values = curves.iter().flat_map(|curve| &curve.points);
    values.map(|p| p[1]).fold(None, |range, y| match range {
        None => Some([y, y]),
        Some([low, high]) => Some([low.min(y), high.max(y)]),
    })
}

/// One curve for each group of each side: energies or decadic logarithms of residuals. Several energies
/// are relative to their starts, because those of other holes or functionals have other sizes.
pub(crate) fn curves(run: &Run, energy: bool) -> Vec<PlotCurve> {
    let count: usize = run.sides.iter().map(|side| side.curves.len()).sum();
    let mut all = Vec::new();
    for (s, side) in run.sides.iter().enumerate() {
        let rows = side.handle.figures(None);
        for (g, curve) in side.curves.iter().enumerate() {
            let points = if energy {
                &curve.energy
            } else {
                &curve.residual
            };
            // as in the table
            let row = rows.get(g);
            let holes = row.map_or_else(String::new, |row| run.holes_words(row));
            let (name, color) = match (run.sides.len(), side.curves.len()) {
                (1, 1) => (String::new(), 0),
                (1, _) => (holes, g),
                (_, 1) => (side.name.to_owned(), s),
                _ => (format!("{}{holes}", run.prefix(s)), s),
            };
            let scale = match (energy, count, points.first()) {
                (true, 2.., Some(first)) if first[1] != 0.0 => first[1].recip(),
                _ => 1.0,
            };
            all.push(PlotCurve {
                name,
                color,
                holes: row.map_or_else(Vec::new, |row| row.holes.clone()),
                points: points.iter().map(|p| [p[0], p[1] * scale]).collect(),
            });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_that_rises_is_another_one() {
        let curve = PlotCurve {
            name: String::new(),
            color: 0,
            holes: Vec::new(),
            points: vec![[0.0, 3.0], [1.0, 1.0], [2.0, 2.0], [3.0, 2.0], [4.0, 1.5]],
        };
        let lengths = |is_energy| curve.pieces(is_energy).map(<[_]>::len).collect::<Vec<_>>();
        assert_eq!((lengths(true), lengths(false)), (vec![2, 3], vec![5]));
    }

    #[test]
    fn both_plots_have_the_attempts_of_the_longer_one() {
        let curve = |attempts: &[f64]| PlotCurve {
            name: String::new(),
            color: 0,
            holes: Vec::new(),
            points: attempts.iter().map(|&attempt| [attempt, 2.0]).collect(),
        };
        assert_eq!(last_attempt(&[Vec::new(), Vec::new()]), 1.0);
        assert_eq!(last_attempt(&[vec![curve(&[1.0])], vec![curve(&[])]]), 1.0);
        let changed = [
            vec![curve(&[])],
            vec![curve(&[1.0, 2.0]), curve(&[1.0, 8.0])],
        ];
        assert_eq!(last_attempt(&changed), 8.0);
    }

    #[test]
    fn marks_are_round_and_have_labels_of_their_own() {
        let axis = |low: f64, high: f64, points: f64, least: f64, whole: bool| {
            let base_step_size = 8.0 * (high - low) / points;
            let bounds = (low, high);
            let input = GridInput {
                bounds,
                base_step_size,
            };
            marks(&input, least, whole)
        };
        for (low, high) in [(0.017, 0.0184), (0.9999, 1.0), (0.3, 90.0), (-3.0, 1.0)] {
            let all = axis(low, high, 100.0, HIGH, false);
            assert!((2..=6).contains(&all.len()), "{low} to {high}: {all:?}");
            let words: Vec<String> = all
                .iter()
                .map(|m| mark_words(m.value, m.step_size))
                .collect();
            assert!(words.windows(2).all(|w| w[0] != w[1]), "{words:?}");
        }
        // attempts and powers of ten are whole, also where there are few
        let whole = axis(0.9, 1.1, 140.0, WIDE, true);
        assert_eq!(whole.iter().map(|m| m.value).collect::<Vec<_>>(), [1.0]);
        let powers = axis(-7.0, 0.2, 100.0, HIGH, true);
        assert!(powers.len() > 2 && powers.iter().all(|m| m.value.fract() == 0.0));
    }

    #[test]
    fn logarithmic_axes_have_marks_in_any_range() {
        let words = |low: f64, high: f64| -> Vec<String> {
            let input = GridInput {
                bounds: (low, high),
                base_step_size: 8.0 * (high - low) / 120.0,
            };
            let marks = logarithmic_marks(&input);
            marks.iter().map(|mark| power_words(mark.value)).collect()
        };
        assert_eq!(words(-2.5, 0.5), ["1e-2", "1e-1", "1e0"]);
        assert_eq!(words(-0.8, 0.1), ["2e-1", "5e-1", "1e0"]);
        assert_eq!(words(-2.8, -2.2), ["2e-3", "5e-3"]);
    }
}
