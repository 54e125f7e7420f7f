//! Actions and background updates of the model.

mod controls;
mod edits;
mod files;
pub(super) mod pictures;
mod repair;
mod report;
mod report_files;
mod runs;
mod select;
mod tick;
mod view;

pub(crate) use controls::params_for;
pub(super) use files::kept_extension;
#[cfg(test)]
pub(super) use files::replace;
pub(crate) use pictures::{WRITING, extension};
pub(crate) use repair::{REPAIRING, is_repairing};
pub use tick::tick;

use std::path::Path;

use super::action::{Action, RunAction, SelectAction};
use super::model::Model;
use super::report::Pick;
use super::view_state::{Modal, Replacing};

/// Executes an action and its consequences. While a patch is being accepted, actions on files and on the mesh
/// wait.
pub fn act(model: &mut Model, action: impl Into<Action>) {
    let action = action.into();
    if let (Action::File(_) | Action::Edit(_), Some(accepting)) = (&action, model.accepting()) {
        accepting.then.push(action);
        return;
    }
    match action {
        Action::File(action) => files::update(model, action),
        Action::Edit(action) => edits::update(model, action),
        Action::Select(action) => select::update(model, action),
        Action::Task(action) => select::update_task(model, action),
        Action::Controls(action) => controls::update(model, action),
        Action::Run(action) => runs::update(model, action),
        Action::View(action) => view::update(model, action),
        Action::Report(action) => report::update(model, action),
        Action::Picture(action) => pictures::update(model, action),
        Action::Escape => escape(model),
        Action::Modal(modal) => model.view.modal = modal,
        Action::DismissToast(i) => model.log.dismiss(i),
    }
}

/// Closes the topmost dialog or tool, else cancels what is made in the background, else stops the run (or
/// rejects it before its first state), else closes the report, else clears the selection.
fn escape(model: &mut Model) {
    match std::mem::take(&mut model.view.modal) {
        Modal::None => {}
        Modal::Replace(asked) => {
            // the dialog of the system is closed
            if asked.named_in == Modal::None {
                model.after_save = None;
            }
            model.view.modal = asked.named_in;
            return;
        }
        _ => {
            model.after_save = None;
            return;
        }
    }
    if model.view.windows.close_one() || repair::cancel(model) || pictures::cancel(model) {
        return;
    }
    if model.view.report.pick != Pick::Holes {
        model.view.report.pick = Pick::Holes;
    } else if let Some(run) = &model.run {
        // without a state there is nothing to accept
        let action = if run.ended() || run.state_count() == 0 {
            RunAction::Reject
        } else {
            RunAction::Stop
        };
        runs::update(model, action);
    } else if model.view.bridging.is_some() {
        model.view.bridging = None;
    } else if model.view.part.is_some() {
        model.view.part = None;
    } else if model.view.windows.analysis {
        model.view.windows.analysis = false;
    } else {
        select::update(model, SelectAction::None);
    }
}

/// Asks whether to replace the file that `writing` writes, if there is one and this is not the answer.
/// Returns whether it asks.
fn asks_to_replace(model: &mut Model, path: &Path, writing: impl Into<Action>) -> bool {
    let is_answer = matches!(&model.view.modal, Modal::Replace(asked) if asked.path == path);
    let asks = path.is_file() && !is_answer;
    if asks {
        let named_in = std::mem::take(&mut model.view.modal);
        model.view.modal = Modal::Replace(Box::new(Replacing {
            path: path.to_owned(),
            writing: writing.into(),
            named_in,
        }));
    }
    asks
}

/// Refuses to do `what`, with a message, until the run is accepted or rejected or the repair is done. Returns
/// whether it was refused.
fn refuse_while_running(model: &mut Model, what: &str) -> bool {
    let before = if model.run.is_some() {
        "accept or reject the patch"
    } else if is_repairing(model) {
        "wait for the repair, or press Esc to cancel it,"
    } else {
        return false;
    };
    model.log.info(format!("{before} before {what}"));
    true
}
