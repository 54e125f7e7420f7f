//! The command line that repeats the operations of the window.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::document::Source;
use super::model::Model;
use super::update::kept_extension;
use crate::io;
use crate::ops::Operation;

/// A shell script that repeats all accepted operations and the current run, one command per line.
/// Schedules and long lists of faces and sharp edges are written to files beside the result, whose paths are
/// returned too.
///
/// # Errors
/// There is nothing to repeat, or a file cannot be written. The message is for the user.
pub fn command(model: &Model) -> Result<(String, Vec<String>), String> {
    let accepted = model.document.accepted.iter();
    let mut steps: Vec<Operation> = accepted.map(|one| one.operation.clone()).collect();
    if let Some(run) = &model.run
        && let Some(side) = run.sides.first()
    {
        let mut operation = side.operation.clone();
        if let Some(state) = side.state() {
            operation.set_schedule(state.schedule());
        }
        steps.push(operation);
    }
    if steps.is_empty() {
        return Err("nothing to repeat".into());
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
            return Err("the mesh has no file; save it, then open the saved file".into());
        }
    };
    let stem = input
        .file_stem()
        .map_or_else(|| "mesh".into(), |s| s.to_string_lossy().into_owned());
    let extension = kept_extension(Some(&input));
    let folder = match &model.saved_to {
        Some(path) => path.parent().unwrap_or(Path::new(".")).to_owned(),
        None => input.parent().unwrap_or(Path::new(".")).to_owned(),
    };
    let count = steps.len();
    let mut files = Vec::new();
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == count;
        let output = match (&model.saved_to, last) {
            (Some(path), true) if io::Format::from_path(path).is_some() => path.clone(),
            (_, true) => folder.join(format!("{stem}_filled.{extension}")),
            _ => folder.join(format!("{stem}_{}.{extension}", i + 1)),
        };
        let command = step.command(&input, &output);
        for (path, list) in &command.files {
            io::save_text(path, list).map_err(|e| e.to_string())?;
            files.push(path.display().to_string());
        }
        let _ = writeln!(text, "{}", command.line);
        input = output;
    }
    Ok((text, files))
}
