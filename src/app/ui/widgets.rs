//! Widgets shared by several panels.

use std::ops::RangeInclusive;

use eframe::egui::{
    Align, Atom, Button, Color32, DragValue, Id, Label, Layout, Response, RichText, Slider,
    SliderClamping, TextStyle, Ui, Widget, emath::Numeric, vec2,
};

use super::format::field_number;
use super::theme;

use crate::app::action::{Action, ViewAction};
use crate::app::report::{Pick, ReportAction};
use crate::app::shortcuts::hint;
use crate::mesh::LoopId;

/// Default minimum angle of sharp edges in degrees.
const SHARP: f64 = 40.0;

/// Actions of clicked widgets.
pub(crate) trait ClickActions {
    /// Adds a tooltip with the key of an action.
    fn key_tip(self, tip: &str, action: impl Into<Action>) -> Self;

    /// Requests an action when the widget is clicked.
    fn on_click(&self, action: impl Into<Action>, actions: &mut Vec<Action>);

    /// Highlights loops in the view while the cursor is over the widget.
    fn hovers(&self, loops: &[LoopId], actions: &mut Vec<Action>);

    /// As [`Self::on_click`], with a tooltip that contains the key of the action.
    fn on_click_with_key(self, tip: &str, action: impl Into<Action>, actions: &mut Vec<Action>);
}

impl ClickActions for Response {
    fn key_tip(self, tip: &str, action: impl Into<Action>) -> Self {
        let key = hint(&self.ctx, action);
        self.on_hover_text(format!("{tip}{key}"))
    }

    fn on_click(&self, action: impl Into<Action>, actions: &mut Vec<Action>) {
        if self.clicked() {
            actions.push(action.into());
        }
    }

    fn hovers(&self, loops: &[LoopId], actions: &mut Vec<Action>) {
        if self.contains_pointer() {
            actions.push(ViewAction::Hover(loops.to_vec()).into());
        }
    }

    fn on_click_with_key(self, tip: &str, action: impl Into<Action>, actions: &mut Vec<Action>) {
        let action = action.into();
        self.key_tip(tip, action.clone()).on_click(action, actions);
    }
}

/// A widget with its name before it.
pub(crate) fn named(ui: &mut Ui, name: &str, widget: impl Widget) -> Response {
    let label = ui.label(name);
    ui.add(widget).labelled_by(label.id)
}

/// A field whose number is dragged or typed. A typed number counts when Enter is pressed or the field is
/// left, because its beginning is another number.
pub(crate) fn number<N: Numeric>(value: &mut N) -> DragValue<'_> {
    DragValue::new(value).update_while_editing(false)
}

/// A slider with a field as [`number`].
pub(crate) fn slider<N: Numeric>(value: &mut N, range: RangeInclusive<N>) -> Slider<'_> {
    Slider::new(value, range).update_while_editing(false)
}

/// Width of the column of names.
const NAMES: f32 = 84.0;
/// Width of the number beside a slider, and of the button behind it.
const NUMBER: f32 = 56.0;
const RESET: f32 = 20.0;

/// A row with its name in the left column and widgets in the right one, which get the id of the
/// name.
pub(crate) fn row<R>(
    ui: &mut Ui,
    name: &str,
    tip: &str,
    widgets: impl FnOnce(&mut Ui, Id) -> R,
) -> R {
    ui.horizontal(|ui| {
        let size = vec2(NAMES, ui.spacing().interact_size.y);
        let layout = Layout::left_to_right(Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(NAMES);
            let label = ui.add(Label::new(name).truncate());
            if tip.is_empty() {
                label
            } else {
                label.on_hover_text(tip)
            }
        });
        widgets(ui, label.inner.id)
    })
    .inner
}

/// Smallest positive value of a logarithmic slider that begins at zero.
const SMALLEST: f64 = 1e-3;

/// The values along a slider.
pub(crate) struct Rail {
    ends: RangeInclusive<f64>,
    is_logarithmic: bool,
    is_open: bool,
}

impl Rail {
    /// Equal distances are equal differences.
    pub(crate) fn linear(ends: RangeInclusive<f64>) -> Self {
        Self {
            ends,
            is_logarithmic: false,
            is_open: false,
        }
    }

    /// Equal distances are equal factors.
    pub(crate) fn logarithmic(ends: RangeInclusive<f64>) -> Self {
        Self {
            is_logarithmic: true,
            ..Self::linear(ends)
        }
    }

    /// Typed values may be beyond the ends.
    pub(crate) fn open(self) -> Self {
        Self {
            is_open: true,
            ..self
        }
    }

    /// Change of a value along the whole rail, if it went on as at the value.
    fn reach(&self, value: f64) -> f64 {
        let (start, end) = (*self.ends.start(), *self.ends.end());
        if !self.is_logarithmic {
            return end - start;
        }
        let least = if start > 0.0 { start } else { SMALLEST };
        value.max(least) * (end / least).ln()
    }
}

/// A slider in a row, a field for its value, and a button that restores the default. The field and the
/// button have columns of fixed widths.
pub(crate) fn slider_row(
    ui: &mut Ui,
    name: &str,
    tip: &str,
    value: &mut f64,
    default: f64,
    rail: Rail,
) -> bool {
    row(ui, name, tip, |ui, label| {
        let width = ui.available_width();
        let spacing = ui.spacing_mut();
        spacing.interact_size.x = NUMBER;
        // as much room as the longest number needs
        spacing.button_padding.x = 2.0;
        let beside = NUMBER + RESET + 2.0 * spacing.item_spacing.x;
        let length = (width - beside).max(40.0);
        spacing.slider_width = length;
        let slider = Slider::new(value, rail.ends.clone())
            .logarithmic(rail.is_logarithmic)
            .smallest_positive(SMALLEST)
            .clamping(if rail.is_open {
                SliderClamping::Never
            } else {
                SliderClamping::Always
            })
            .show_value(false);
        let slider = ui.add(slider).labelled_by(label).on_hover_text(tip);
        let shown = *value;
        let field = number(value)
            .clip_text(true)
            .speed(rail.reach(shown) / f64::from(length))
            .custom_formatter(|x, _| field_number(x))
            // the field may show fewer digits than the value has, which keeps them if nothing is typed
            .custom_parser(move |text| {
                if text == field_number(shown) {
                    return Some(shown);
                }
                let typed = text.trim().parse::<f64>().ok();
                typed.filter(|x| x.is_finite())
            });
        let field = if rail.is_open {
            field
        } else {
            field.range(rail.ends)
        };
        let exact = format!("{shown:?}\n{tip}");
        let field = ui.add(field).labelled_by(label).on_hover_text(exact);
        let mut changed = slider.changed() || field.changed();
        #[expect(clippy::float_cmp, reason = "any other value can be reset")]
        let is_other = *value != default;
        if is_other && reset_button(ui, name).clicked() {
            *value = default;
            changed = true;
        }
        changed
    })
}

/// The small button that restores a default.
pub(crate) fn reset_button(ui: &mut Ui, name: &str) -> Response {
    let button = ui.add_sized([RESET, RESET], Button::new("×").frame(false).small());
    button.widget_info(|| {
        let label = format!("Reset {name}");
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Button, true, label)
    });
    button.on_hover_text("back to the default")
}

/// The main button of a panel.
pub(crate) fn primary(ui: &Ui, text: &str) -> Button<'static> {
    let text = RichText::new(text).family(theme::strong());
    let text = text.color(Color32::WHITE);
    Button::new((Atom::grow(), text, Atom::grow())).fill(theme::accent(ui))
}

/// [`primary`] over the whole width.
pub(crate) fn wide_primary(ui: &Ui, text: &str) -> Button<'static> {
    primary(ui, text).min_size(vec2(ui.available_width(), 30.0))
}

/// A button over the whole width beside a primary one.
pub(crate) fn wide_button(ui: &Ui, text: &str) -> Button<'static> {
    let atoms = (Atom::grow(), text.to_owned(), Atom::grow());
    Button::new(atoms).min_size(vec2(ui.available_width(), 26.0))
}

/// Width of the title of a button in points.
pub(crate) fn title_width(ui: &Ui, title: &str) -> f32 {
    let font = TextStyle::Button.resolve(ui.style());
    let galley = (ui.painter()).layout_no_wrap(title.into(), font, Color32::WHITE);
    galley.size().x
}

/// Distance of the values of a choice.
const GAP: f32 = 2.0;

/// A choice between values, with its name before them. Each value has a title and a tooltip.
pub(crate) fn choice<T: PartialEq, const N: usize>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: [(T, &str, &str); N],
) {
    row(ui, name, "", |ui, _| {
        // as much room around the titles as one row has
        let widths = (choices.iter()).map(|(_, title, _)| title_width(ui, title).ceil());
        let titles: f32 = widths.sum();
        let gaps = GAP * N as f32;
        let padding = (ui.available_width() - titles - gaps) / (2 * N) as f32;
        ui.horizontal_wrapped(|ui| {
            let spacing = ui.spacing_mut();
            spacing.item_spacing.x = GAP;
            spacing.button_padding.x = padding.floor().clamp(1.0, 6.0);
            for (one, title, tip) in choices {
                ui.selectable_value(value, one, title).on_hover_text(tip);
            }
        });
    });
}

/// An optional angle in degrees above which edges are sharp.
pub(crate) fn angle_limit(ui: &mut Ui, name: &str, tip: &str, limit: &mut Option<f64>) {
    let (mut is_on, mut angle) = (limit.is_some(), limit.unwrap_or(SHARP));
    ui.checkbox(&mut is_on, name).on_hover_text(tip);
    let value = number(&mut angle).range(1.0..=179.0).speed(0.5);
    ui.add_enabled(is_on, value.suffix("°"));
    *limit = is_on.then_some(angle);
}

/// The button that switches the picking of edges on or off. Returns whether it was clicked.
pub(crate) fn pick_edges(ui: &mut Ui, pick: Pick, tip: &str, actions: &mut Vec<Action>) -> bool {
    let picking = pick == Pick::Edges;
    let other = if picking { Pick::Holes } else { Pick::Edges };
    let button = ui.add(Button::selectable(picking, "Pick edges"));
    let button = button.on_hover_text(tip);
    button.on_click(ReportAction::Pick(other), actions);
    button.clicked()
}
