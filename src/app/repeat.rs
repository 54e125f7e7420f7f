//! The command line that repeats what was done in the window.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::document::{AcceptedFill, Source};
use super::model::Model;
use super::view_state::Task;
use crate::fill::{blend_command_line, command_line};
use crate::io;

/// Commands that repeat all accepted fills and the run that is shown, one after the other, in
/// lines of a shell script. Schedules are written beside the result.
///
/// # Errors
/// There is nothing to repeat, or a schedule cannot be written; the message is for the person.
pub fn command(model: &Model) -> Result<String, String> {
    let mut fills: Vec<AcceptedFill> = model.document.fills.iter().map(|f| (**f).clone()).collect();
    if let Some(run) = &model.run
        && let Some(side) = run.sides.first()
    {
        let schedule = match side.state() {
            Some(state) => side.live.schedule_to(&state),
            None => side.live.schedule(),
        };
        fills.push(AcceptedFill {
            task: run.task,
            loops: run.loops.clone(),
            controls: side.start.clone(),
            schedule,
            faces: 0..0,
        });
    }
    if fills.is_empty() {
        return Err("nothing was filled yet: there is no command to repeat it".into());
    }
    let (mut text, mut input) = match &model.document.origin.source {
        Source::File(path) => (String::new(), path.clone()),
        Source::Sample(name) => {
            let file = PathBuf::from(format!("{name}.obj"));
            (
                format!("meniscus sample {name} -o {}\n", file.display()),
                file,
            )
        }
        Source::Embedded => {
            return Err("the mesh has no file of its own; save it and open that first".into());
        }
    };
    let stem = input
        .file_stem()
        .map_or_else(|| "mesh".into(), |s| s.to_string_lossy().into_owned());
    let folder = match &model.saved_to {
        Some(path) => path.parent().unwrap_or(Path::new(".")).to_owned(),
        None => input.parent().unwrap_or(Path::new(".")).to_owned(),
    };
    let count = fills.len();
    for (i, fill) in fills.iter().enumerate() {
        let last = i + 1 == count;
        let output = match (&model.saved_to, last) {
            (Some(path), true) if io::Format::from_path(path).is_some() => path.clone(),
            (_, true) => folder.join(format!("{stem}_filled.obj")),
            _ => folder.join(format!("{stem}_{}.obj", i + 1)),
        };
        let schedule = if fill.schedule.rows.is_empty() {
            None
        } else {
            let path = output.with_extension("schedule.csv");
            io::save_text(&path, &fill.schedule.to_csv()).map_err(|e| e.to_string())?;
            Some(path)
        };
        let line = match fill.task {
            Task::Fill => command_line,
            Task::Blend => blend_command_line,
        }(
            &input,
            &output,
            &fill.loops,
            &fill.controls,
            schedule.as_deref(),
        );
        let _ = writeln!(text, "{line}");
        input = output;
    }
    Ok(text)
}
