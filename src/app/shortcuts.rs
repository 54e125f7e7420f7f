//! Keys: one table for the handling, the tooltips and the sheet.

use eframe::egui::{Context, Key, KeyboardShortcut, Modifiers};

use super::action::{Action, Switch};
use super::view_state::Task;
use crate::render::StandardView;

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// See [`Action::AskOpen`].
    Open,
    /// See [`Action::Save`].
    Save,
    /// See [`Action::AskSaveAs`].
    SaveAs,
    /// Close the window.
    Quit,
    /// Undo.
    Undo,
    /// Redo.
    Redo,
    /// All holes.
    SelectAll,
    /// All but the largest.
    SelectAllButLargest,
    /// Esc.
    Escape,
    /// Start, or accept and start the next.
    Fill,
    /// Erase the selected faces.
    Erase,
    /// Fill, blend, repair, refine.
    Task(Task),
    /// Accept the patch.
    Accept,
    /// Play or pause.
    PlayPause,
    /// One step.
    Step,
    /// One kept state back.
    StepBack,
    /// To the first kept state.
    Rewind,
    /// Jump to the converged shape.
    Finish,
    /// Fit everything.
    Fit,
    /// A standard view.
    View(StandardView),
    /// A switch.
    Toggle(Switch),
    /// The next view mode, or the one before.
    NextMode(bool),
    /// More or fewer stripes.
    Stripes(bool),
    /// The picture dialog.
    Picture,
    /// Picture to the clipboard.
    CopyPicture,
    /// Command line to the clipboard.
    CopyLine,
}

/// Command, keys (the first one is shown), what it does.
pub type Row = (Command, &'static [KeyboardShortcut], &'static str);

const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

/// All of them. Keys with more modifiers come before the same keys with fewer.
pub const ROWS: &[Row] = &[
    (
        Command::Open,
        &[key(CTRL, Key::O)],
        "Open a mesh or project",
    ),
    (Command::SaveAs, &[key(CTRL_SHIFT, Key::S)], "Save as"),
    (Command::Save, &[key(CTRL, Key::S)], "Save"),
    (Command::Quit, &[key(CTRL, Key::Q)], "Quit"),
    (
        Command::Redo,
        &[key(CTRL_SHIFT, Key::Z), key(CTRL, Key::Y)],
        "Redo",
    ),
    (
        Command::Undo,
        &[key(CTRL, Key::Z)],
        "Undo (also in the middle of a run)",
    ),
    (
        Command::SelectAllButLargest,
        &[key(CTRL_SHIFT, Key::A)],
        "Select all loops but the largest",
    ),
    (Command::SelectAll, &[key(CTRL, Key::A)], "Select all holes"),
    (
        Command::Escape,
        &[key(NONE, Key::Escape)],
        "Close, stop, drop the patch, clear the selection",
    ),
    (
        Command::Accept,
        &[key(CTRL, Key::Enter)],
        "Accept the patch",
    ),
    (
        Command::Fill,
        &[key(NONE, Key::Enter)],
        "Fill, blend or refill what is selected; accept a finished patch",
    ),
    (
        Command::Erase,
        &[key(NONE, Key::Delete)],
        "Erase the selected faces (task Repair)",
    ),
    (
        Command::Task(Task::Fill),
        &[key(NONE, Key::F2)],
        "Fill holes",
    ),
    (
        Command::Task(Task::Blend),
        &[key(NONE, Key::F3)],
        "Blend rims",
    ),
    (
        Command::Task(Task::Repair),
        &[key(NONE, Key::F4)],
        "Repair selected faces",
    ),
    (
        Command::Task(Task::Refine),
        &[key(NONE, Key::F5)],
        "Refine the mesh",
    ),
    (
        Command::PlayPause,
        &[key(NONE, Key::Space)],
        "Play or pause",
    ),
    (
        Command::Finish,
        &[key(CTRL, Key::Period)],
        "Jump to the converged shape",
    ),
    (Command::Step, &[key(NONE, Key::Period)], "One step on"),
    (
        Command::Rewind,
        &[key(SHIFT, Key::Comma)],
        "Back to the first state",
    ),
    (
        Command::StepBack,
        &[key(NONE, Key::Comma)],
        "One kept state back",
    ),
    (
        Command::Fit,
        &[key(NONE, Key::F), key(NONE, Key::Home)],
        "Fit everything",
    ),
    (
        Command::View(StandardView::Back),
        &[key(CTRL, Key::Num1)],
        "View from the back",
    ),
    (
        Command::View(StandardView::Front),
        &[key(NONE, Key::Num1)],
        "View from the front",
    ),
    (
        Command::View(StandardView::Left),
        &[key(CTRL, Key::Num3)],
        "View from the left",
    ),
    (
        Command::View(StandardView::Right),
        &[key(NONE, Key::Num3)],
        "View from the right",
    ),
    (
        Command::View(StandardView::Bottom),
        &[key(CTRL, Key::Num7)],
        "View from below",
    ),
    (
        Command::View(StandardView::Top),
        &[key(NONE, Key::Num7)],
        "View from the top",
    ),
    (
        Command::View(StandardView::Isometric),
        &[key(NONE, Key::Num0)],
        "Isometric view",
    ),
    (
        Command::Toggle(Switch::Projection),
        &[key(NONE, Key::Num5)],
        "Perspective or parallel",
    ),
    (
        Command::NextMode(false),
        &[key(SHIFT, Key::V)],
        "View mode before",
    ),
    (
        Command::NextMode(true),
        &[key(NONE, Key::V)],
        "Next view mode",
    ),
    (
        Command::Stripes(true),
        &[key(NONE, Key::CloseBracket)],
        "More stripes",
    ),
    (
        Command::Stripes(false),
        &[key(NONE, Key::OpenBracket)],
        "Fewer stripes",
    ),
    (
        Command::Toggle(Switch::Wireframe),
        &[key(NONE, Key::W)],
        "Wireframe",
    ),
    (
        Command::Toggle(Switch::Tint),
        &[key(NONE, Key::T)],
        "Tint the patch",
    ),
    (Command::Toggle(Switch::Log), &[key(CTRL, Key::L)], "Log"),
    (
        Command::Toggle(Switch::LimitSurface),
        &[key(NONE, Key::L)],
        "Limit surface or control mesh",
    ),
    (
        Command::Toggle(Switch::Original),
        &[key(NONE, Key::O)],
        "Opened mesh on or off",
    ),
    (
        Command::Toggle(Switch::Report),
        &[key(CTRL, Key::R)],
        "Load report",
    ),
    (
        Command::Toggle(Switch::Analysis),
        &[key(NONE, Key::I)],
        "Report: measures of the surface",
    ),
    (
        Command::Toggle(Switch::Rims),
        &[key(NONE, Key::R)],
        "Rims on or off",
    ),
    (
        Command::CopyPicture,
        &[key(CTRL_SHIFT, Key::P)],
        "Picture of the view to the clipboard",
    ),
    (
        Command::Picture,
        &[key(CTRL, Key::P)],
        "Make a picture or a sequence",
    ),
    (
        Command::CopyLine,
        &[key(CTRL, Key::K)],
        "Copy the command line that repeats this",
    ),
    (
        Command::Toggle(Switch::Diagnostics),
        &[key(CTRL, Key::F1)],
        "Frame times and memory",
    ),
    (
        Command::Toggle(Switch::Help),
        &[key(NONE, Key::F1)],
        "This sheet",
    ),
];

/// The commands whose keys were pressed, none while something is typed.
pub fn pressed(ctx: &Context) -> Vec<Command> {
    let typing = ctx.egui_wants_keyboard_input();
    ctx.input_mut(|input| {
        ROWS.iter()
            .filter(|(command, keys, _)| {
                // Esc leaves a field and must not stop the run as well; sheets open from anywhere
                if typing && *command != Command::Toggle(Switch::Help) {
                    return false;
                }
                keys.iter().any(|k| input.consume_shortcut(k))
            })
            .map(|(command, ..)| *command)
            .collect()
    })
}

/// ` (Ctrl+O)`, to be put after a tooltip.
pub fn hint(ctx: &Context, command: Command) -> String {
    ROWS.iter()
        .find(|(c, ..)| *c == command)
        .map_or_else(String::new, |(_, keys, _)| {
            format!(" ({})", ctx.format_shortcut(&keys[0]))
        })
}

impl Command {
    /// The action, where it does not depend on anything.
    pub fn action(self) -> Option<Action> {
        Some(match self {
            Self::Open => Action::AskOpen,
            Self::Save => Action::Save,
            Self::SaveAs => Action::AskSaveAs,
            Self::Quit => Action::Close,
            Self::Undo => Action::Undo,
            Self::Redo => Action::Redo,
            Self::SelectAll => Action::SelectAll,
            Self::SelectAllButLargest => Action::SelectAllButLargest,
            Self::Escape => Action::Escape,
            Self::Fill => Action::Fill,
            Self::Erase => Action::Erase,
            Self::Task(task) => Action::Task(task),
            Self::Accept => Action::Accept(0),
            Self::PlayPause => Action::PlayPause,
            Self::Step => Action::Step,
            Self::Rewind => Action::Scrub(Some(0)),
            Self::Finish => Action::Finish,
            Self::Fit => Action::FitAll,
            Self::Toggle(switch) => Action::Toggle(switch),
            Self::CopyPicture => Action::CopyPicture,
            Self::CopyLine => Action::CopyCommand,
            Self::StepBack
            | Self::View(_)
            | Self::NextMode(_)
            | Self::Stripes(_)
            | Self::Picture => {
                return None;
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows with the same key would make the second unreachable, and a row before the same
    /// key with more modifiers would take it (egui matches the fewer).
    #[test]
    fn keys_are_unique_and_ordered() {
        let all: Vec<(usize, KeyboardShortcut)> = ROWS
            .iter()
            .enumerate()
            .flat_map(|(i, (_, keys, _))| keys.iter().map(move |&k| (i, k)))
            .collect();
        for (n, (i, a)) in all.iter().enumerate() {
            for (j, b) in &all[n + 1..] {
                assert_ne!(a, b, "rows {i} and {j}");
                if a.logical_key == b.logical_key && a.modifiers == Modifiers::NONE {
                    assert!(
                        b.modifiers == Modifiers::NONE,
                        "row {j} comes after row {i}"
                    );
                }
            }
        }
    }
}
