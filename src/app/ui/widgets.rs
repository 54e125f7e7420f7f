//! Widgets shared by several panels.

use eframe::egui::{Button, DragValue, Response, Ui, Widget};

use crate::app::action::Action;
use crate::app::report::{Pick, ReportAction};
use crate::app::shortcuts::hint;

/// Default minimum angle of sharp edges in degrees.
const SHARP: f64 = 40.0;

/// Actions of clicked widgets.
pub(crate) trait Asks {
    /// Adds a tooltip with the key of an action.
    fn key_tip(self, tip: &str, action: impl Into<Action>) -> Self;

    /// Requests an action when the widget is clicked.
    fn asks(&self, action: impl Into<Action>, actions: &mut Vec<Action>);

    /// As [`Self::asks`], with a tooltip that contains the key of the action.
    fn asks_with_key(self, tip: &str, action: impl Into<Action>, actions: &mut Vec<Action>);
}

impl Asks for Response {
    fn key_tip(self, tip: &str, action: impl Into<Action>) -> Self {
        let key = hint(&self.ctx, action);
        self.on_hover_text(format!("{tip}{key}"))
    }

    fn asks(&self, action: impl Into<Action>, actions: &mut Vec<Action>) {
        if self.clicked() {
            actions.push(action.into());
        }
    }

    fn asks_with_key(self, tip: &str, action: impl Into<Action>, actions: &mut Vec<Action>) {
        let action = action.into();
        self.key_tip(tip, action.clone()).asks(action, actions);
    }
}

/// A widget with its name before it.
pub(crate) fn named(ui: &mut Ui, name: &str, widget: impl Widget) -> Response {
    let label = ui.label(name);
    ui.add(widget).labelled_by(label.id)
}

/// A choice between values, with its name before them. Each value has a title and a tooltip.
pub(crate) fn choice<T: PartialEq, const N: usize>(
    ui: &mut Ui,
    name: &str,
    value: &mut T,
    choices: [(T, &str, &str); N],
) {
    ui.horizontal_wrapped(|ui| {
        ui.label(name);
        for (one, title, tip) in choices {
            ui.selectable_value(value, one, title).on_hover_text(tip);
        }
    });
}

/// An optional angle in degrees above which edges are sharp.
pub(crate) fn angle_limit(ui: &mut Ui, name: &str, tip: &str, limit: &mut Option<f64>) {
    let (mut is_on, mut angle) = (limit.is_some(), limit.unwrap_or(SHARP));
    ui.checkbox(&mut is_on, name).on_hover_text(tip);
    let value = DragValue::new(&mut angle).range(1.0..=179.0).speed(0.5);
    ui.add_enabled(is_on, value.suffix("°"));
    *limit = is_on.then_some(angle);
}

/// The button that switches the picking of edges on or off. Returns whether it was clicked.
pub(crate) fn pick_edges(ui: &mut Ui, pick: Pick, tip: &str, actions: &mut Vec<Action>) -> bool {
    let picking = pick == Pick::Edges;
    let other = if picking { Pick::Holes } else { Pick::Edges };
    let button = ui.add(Button::selectable(picking, "Pick edges"));
    let button = button.on_hover_text(tip);
    button.asks(ReportAction::Pick(other), actions);
    button.clicked()
}
