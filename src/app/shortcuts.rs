//! Keys: one table for key handling, tooltips and the shortcut sheet.

use eframe::egui::{Context, Event, InputState, Key, KeyboardShortcut, Modifiers, Popup};

use super::action::{
    Action, EditAction, FileAction, PictureAction, RunAction, SelectAction, Switch, TaskAction,
    ViewAction,
};
use super::view_state::Task;
use crate::render::{StandardView, ViewMode};

/// The keys of an action.
pub(crate) struct Shortcut {
    /// The action.
    pub(crate) action: Action,
    /// The keys. The first one is displayed.
    pub(crate) keys: &'static [KeyboardShortcut],
    /// The description on the shortcut sheet.
    pub(crate) about: &'static str,
}

const NONE: Modifiers = Modifiers::NONE;
const CTRL: Modifiers = Modifiers::COMMAND;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

macro_rules! shortcuts {
    ($($kind:ident $(($action:expr))? [$($modifiers:ident $key:ident),+] $about:literal;)+) => {
        &[$(Shortcut {
            action: Action::$kind $(($action))?,
            keys: &[$(KeyboardShortcut::new($modifiers, Key::$key)),+],
            about: $about,
        }),+]
    };
}

/// All shortcuts. Keys with more modifiers come before the same keys with fewer.
pub(crate) static SHORTCUTS: &[Shortcut] = shortcuts! {
    File(FileAction::AskOpen) [CTRL O] "Open a mesh or project";
    File(FileAction::AskSaveAs) [CTRL_SHIFT S] "Save as";
    File(FileAction::Save) [CTRL S] "Save";
    File(FileAction::Close) [CTRL Q] "Quit";
    Edit(EditAction::Redo) [CTRL_SHIFT Z, CTRL Y] "Redo";
    Edit(EditAction::Undo) [CTRL Z] "Undo (also during a run)";
    Select(SelectAction::AllButLargest) [CTRL_SHIFT A] "Select all loops except the largest";
    Select(SelectAction::All) [CTRL A] "Select all holes";
    Escape [NONE Escape] "Close, stop, reject the patch, clear the selection";
    Run(RunAction::Accept(0)) [CTRL Enter] "Accept the patch";
    Run(RunAction::Proceed) [NONE Enter]
        "Fill, blend, refill or refine; accept a finished patch";
    Edit(EditAction::Erase) [NONE Delete] "Erase the selected faces (task Repair)";
    Task(TaskAction::Choose(Task::Fill)) [NONE F2] "Fill holes";
    Task(TaskAction::Choose(Task::Blend)) [NONE F3] "Blend rims";
    Task(TaskAction::Choose(Task::Repair)) [NONE F4] "Repair selected faces";
    Task(TaskAction::Choose(Task::Refine)) [NONE F5] "Refine the mesh";
    Run(RunAction::PlayPause) [NONE Space] "Play or pause";
    Run(RunAction::Finish) [CTRL Period] "Jump to the converged shape";
    Run(RunAction::Step) [NONE Period] "One step forward";
    Run(RunAction::Scrub(Some(0))) [SHIFT Comma] "Back to the first state";
    Run(RunAction::StepBack) [NONE Comma] "One stored state back";
    View(ViewAction::FitAll) [NONE F, NONE Home] "Fit the whole model";
    View(ViewAction::Standard(StandardView::Back)) [CTRL Num1] "View from the back";
    View(ViewAction::Standard(StandardView::Front)) [NONE Num1] "View from the front";
    View(ViewAction::Standard(StandardView::Left)) [CTRL Num3] "View from the left";
    View(ViewAction::Standard(StandardView::Right)) [NONE Num3] "View from the right";
    View(ViewAction::Standard(StandardView::Bottom)) [CTRL Num7] "View from below";
    View(ViewAction::Standard(StandardView::Top)) [NONE Num7] "View from the top";
    View(ViewAction::Standard(StandardView::Isometric)) [NONE Num0] "Isometric view";
    View(ViewAction::Toggle(Switch::Projection)) [NONE Num5] "Perspective or parallel";
    View(ViewAction::PreviousMode) [SHIFT V] "Previous view mode";
    View(ViewAction::NextMode) [NONE V] "Next view mode";
    View(ViewAction::Mode(ViewMode::Shaded)) [NONE S] "Shaded";
    View(ViewAction::Mode(ViewMode::Color)) [NONE C] "Colours of the file";
    View(ViewAction::Mode(ViewMode::Isophotes)) [NONE B] "Isophotes (bands)";
    View(ViewAction::Mode(ViewMode::Zebra)) [NONE Z] "Zebra";
    View(ViewAction::Mode(ViewMode::Mean)) [NONE H] "Mean curvature H";
    View(ViewAction::MoreStripes) [NONE CloseBracket] "More stripes";
    View(ViewAction::FewerStripes) [NONE OpenBracket] "Fewer stripes";
    View(ViewAction::Toggle(Switch::Wireframe)) [NONE W] "Wireframe";
    View(ViewAction::Toggle(Switch::Tint)) [NONE T] "Tint the patch";
    View(ViewAction::Toggle(Switch::Log)) [CTRL L] "Log";
    View(ViewAction::Toggle(Switch::LimitSurface)) [NONE L] "Limit surface or control mesh";
    View(ViewAction::Toggle(Switch::Original)) [NONE O] "Original mesh on or off";
    View(ViewAction::Toggle(Switch::Report)) [CTRL R] "Load report";
    View(ViewAction::Toggle(Switch::Analysis)) [NONE I] "Report: measures of the surface";
    View(ViewAction::Toggle(Switch::Rims)) [NONE R] "Rims on or off";
    View(ViewAction::Toggle(Switch::Grid)) [NONE G] "Grid on the ground";
    Picture(PictureAction::Copy) [CTRL_SHIFT P] "Copy a picture of the view";
    Picture(PictureAction::Ask) [CTRL P] "Write a picture or a sequence";
    File(FileAction::CopyCommand) [CTRL K] "Copy the command line that repeats the work";
    View(ViewAction::Mode(ViewMode::Gauss)) [NONE K] "Gaussian curvature K";
    View(ViewAction::Toggle(Switch::LeftPanel)) [NONE F6] "Left panel: task and loops";
    View(ViewAction::Toggle(Switch::Details)) [NONE F7] "Numbers and plots of the run";
    View(ViewAction::Toggle(Switch::RightPanel)) [NONE F8] "Right panel: controls or report";
    View(ViewAction::Toggle(Switch::Diagnostics)) [CTRL F1] "Frame times and memory";
    View(ViewAction::Toggle(Switch::Help)) [NONE F1] "This sheet";
};

impl Shortcut {
    /// The heading under which the shortcut sheet lists it.
    pub(crate) fn group(&self) -> &'static str {
        match &self.action {
            Action::File(_) | Action::Picture(_) => "Files and pictures",
            Action::Edit(_) | Action::Select(_) | Action::Escape => "Edit and select",
            Action::Task(_) | Action::Run(_) => "Tasks and runs",
            Action::View(ViewAction::Standard(_) | ViewAction::FitAll) => "Camera",
            Action::View(ViewAction::Toggle(switch)) => match switch {
                Switch::Projection => "Camera",
                Switch::Wireframe
                | Switch::Tint
                | Switch::LimitSurface
                | Switch::Original
                | Switch::Grid
                | Switch::Rims => "Display",
                _ => "Panels and windows",
            },
            _ => "Display",
        }
    }

    /// Its keys in words, such as `Ctrl+Shift+Z or Ctrl+Y`.
    pub(crate) fn keys_text(&self, ctx: &Context) -> String {
        let names: Vec<String> = self.keys.iter().map(|&k| key_name(ctx, k)).collect();
        names.join(" or ")
    }
}

/// The groups of the shortcut sheet, in order.
pub(crate) const GROUPS: [&str; 6] = [
    "Tasks and runs",
    "Edit and select",
    "Camera",
    "Display",
    "Panels and windows",
    "Files and pictures",
];

/// A key as it is printed on keyboards.
fn key_name(ctx: &Context, key: KeyboardShortcut) -> String {
    let words = ctx.format_shortcut(&key);
    for (name, printed) in [
        ("Escape", "Esc"),
        ("OpenBracket", "["),
        ("CloseBracket", "]"),
        ("Comma", ","),
        ("Period", "."),
    ] {
        if let Some(before) = words.strip_suffix(name) {
            return format!("{before}{printed}");
        }
    }
    words
}

/// Whether the key of a letter was pressed while Alt was down, which opens a menu. Alt may be up again.
pub(crate) fn pressed_with_alt(input: &InputState, letter: Key) -> bool {
    let is_one = |event: &Event| match event {
        Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } => *key == letter && modifiers.alt && !modifiers.command,
        _ => false,
    };
    (Key::A..=Key::Z).contains(&letter) && input.events.iter().any(is_one)
}

/// The actions whose keys were pressed; none while the user types text or a menu is open. A focused
/// widget gets the keys that press it. `was_typing` is whether a text field had the focus at the last frame.
pub(crate) fn pressed(ctx: &Context, was_typing: bool) -> Vec<Action> {
    if Popup::is_any_open(ctx) {
        return Vec::new();
    }
    // a text field that Esc leaves has no focus any more
    let typing = was_typing || ctx.egui_wants_keyboard_input();
    let focused = ctx.memory(|memory| memory.focused().is_some());
    let opens_menu = |input: &InputState, k: &KeyboardShortcut| {
        k.modifiers == NONE && pressed_with_alt(input, k.logical_key)
    };
    let presses = |k: &KeyboardShortcut| {
        k.modifiers == NONE && matches!(k.logical_key, Key::Space | Key::Enter)
    };
    let help: Action = ViewAction::Toggle(Switch::Help).into();
    ctx.input_mut(|input| {
        SHORTCUTS
            .iter()
            // Esc leaves a text field and must not also stop the run; the help opens from anywhere
            .filter(|shortcut| !typing || shortcut.action == help)
            .filter(|shortcut| !focused || !shortcut.keys.iter().any(presses))
            .filter(|shortcut| {
                let mut keys = shortcut.keys.iter();
                keys.any(|k| !opens_menu(input, k) && input.consume_shortcut(k))
            })
            .map(|shortcut| shortcut.action.clone())
            .collect()
    })
}

/// The key of an action, if it has one.
pub(crate) fn key_text(ctx: &Context, action: &Action) -> Option<String> {
    let found = SHORTCUTS.iter().find(|s| s.action == *action)?;
    Some(key_name(ctx, found.keys[0]))
}

/// The key as a suffix of a tooltip, such as ` (Ctrl+O)`.
pub(crate) fn hint(ctx: &Context, action: impl Into<Action>) -> String {
    key_text(ctx, &action.into()).map_or_else(String::new, |key| format!(" ({key})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shortcut_is_in_a_group_and_keys_have_their_printed_names() {
        let ctx = Context::default();
        for shortcut in SHORTCUTS {
            assert!(GROUPS.contains(&shortcut.group()), "{}", shortcut.about);
        }
        let text = |action: &Action| key_text(&ctx, action).expect("a key");
        assert_eq!(text(&Action::Escape), "Esc");
        assert_eq!(text(&RunAction::StepBack.into()), ",");
        assert_eq!(text(&RunAction::Finish.into()), "Ctrl+.");
        assert_eq!(text(&ViewAction::MoreStripes.into()), "]");
    }

    /// If two rows had the same key, the second could not be reached. A row before the same key
    /// with more modifiers would match those keys too, because egui ignores extra modifiers.
    #[test]
    fn keys_are_unique_and_ordered() {
        let all: Vec<(usize, KeyboardShortcut)> = SHORTCUTS
            .iter()
            .enumerate()
            .flat_map(|(i, shortcut)| shortcut.keys.iter().map(move |&k| (i, k)))
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
