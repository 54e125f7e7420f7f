//! What each action does.

mod edits;
mod files;
mod pictures;
mod report;
mod report_files;
mod runs;
mod select;
mod view;

pub use pictures::WRITING;
pub use report::tick as tick_report;
pub use runs::params_for;

use super::action::Action;
use super::model::Model;
use super::report::Pick;
use super::view_state::Modal;

/// Carries out an action.
pub fn update(model: &mut Model, action: Action) {
    match action {
        Action::AskOpen
        | Action::Open(_)
        | Action::Sample(_)
        | Action::Save
        | Action::AskSaveAs
        | Action::SaveAs(_)
        | Action::AskExportPatch
        | Action::ExportPatch(_)
        | Action::Close
        | Action::Discard
        | Action::SaveThenGoOn
        | Action::Recover(_)
        | Action::DropRecovery => files::update(model, action),
        Action::Select(..)
        | Action::SelectAll
        | Action::SelectAllButLargest
        | Action::SelectNone
        | Action::Task(_)
        | Action::Selecting(_)
        | Action::Refining(_)
        | Action::Bridging(_)
        | Action::Faces(_)
        | Action::Hover(_) => select::update(model, action),
        Action::Controls(_)
        | Action::Settle
        | Action::EnergyText(_)
        | Action::ApplyEnergy
        | Action::AddParameter(_)
        | Action::CompareEnergy(_)
        | Action::Fill
        | Action::Fair
        | Action::PlayPause
        | Action::Step
        | Action::Finish
        | Action::Stop
        | Action::Scrub(_)
        | Action::GoOnFromHere
        | Action::Pace(_)
        | Action::Accept(_)
        | Action::Reject
        | Action::CopyCommand => runs::update(model, action),
        Action::Erase | Action::Flip(_) | Action::Bridge(..) => edits::update(model, &action),
        Action::Escape => escape(model),
        Action::Undo => undo(model),
        Action::Redo => redo(model),
        Action::Camera(_)
        | Action::FitAll
        | Action::FlyToLoop(_)
        | Action::FlyTo(_)
        | Action::Style(_)
        | Action::Toggle(_)
        | Action::Navigation(_)
        | Action::Dark(_)
        | Action::UiScale(_) => view::update(model, &action),
        Action::Report(action) => report::update(model, action),
        Action::DismissToast(i) => model.log.dismiss(i),
        Action::Modal(modal) => model.view.modal = modal,
        Action::Picture(_)
        | Action::CopyPicture
        | Action::WindowPicture
        | Action::CancelPicture => pictures::update(model, action),
    }
}

/// Closes what is open, else stops what runs, else clears the selection.
fn escape(model: &mut Model) {
    if model.view.modal != Modal::None {
        model.view.modal = Modal::None;
        model.after_save = None;
    } else if model.view.windows.help {
        model.view.windows.help = false;
    } else if model.view.report.pick != Pick::Holes {
        model.view.report.pick = Pick::Holes;
    } else if let Some(run) = &model.run {
        if run.ended() {
            update(model, Action::Reject);
        } else {
            update(model, Action::Stop);
        }
    } else if model.view.bridging.is_some() {
        model.view.bridging = None;
    } else {
        update(model, Action::SelectNone);
    }
}

/// In the middle of a run what there is of it is taken in first, so that a redo brings it back.
fn undo(model: &mut Model) {
    if model.run.is_some() {
        runs::accept(model, 0);
        model.run = None;
    }
    match model.history.undo(&mut model.document) {
        Some(label) => after_travel(model, &format!("undone: {label}")),
        None => model.log.info("nothing to undo"),
    }
}

fn redo(model: &mut Model) {
    if model.is_busy("doing things again") {
        return;
    }
    match model.history.redo(&mut model.document) {
        Some(label) => after_travel(model, &format!("done again: {label}")),
        None => model.log.info("nothing to do again"),
    }
}

fn after_travel(model: &mut Model, message: &str) {
    model.revision += 1;
    model
        .view
        .energy_text
        .clone_from(&model.document.controls.energy);
    model.view.hover = None;
    model.log.info(message);
}
