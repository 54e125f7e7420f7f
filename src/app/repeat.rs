//! The command line that repeats what was done in the window.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::command_line::command_line;
use super::document::{Accepted, CREASE, Source, Work};
use super::model::Model;
use crate::io;
use crate::mesh::{DVec3, ranges_text};

/// Commands that repeat everything that was accepted and the run that is shown, one after the other, in
/// lines of a shell script. Schedules and long lists of faces and sharp edges are written beside the
/// result.
///
/// # Errors
/// There is nothing to repeat, or a schedule cannot be written; the message is for the person.
pub fn command(model: &Model) -> Result<String, String> {
    let accepted = model.document.accepted.iter();
    let mut steps: Vec<Accepted> = accepted.map(|one| (**one).clone()).collect();
    if let Some(run) = &model.run
        && let Some(side) = run.sides.first()
    {
        let schedule = side.state().map(|state| state.schedule());
        steps.push(Accepted {
            work: run.work.clone(),
            controls: side.start.clone(),
            schedule: schedule.unwrap_or_default(),
            faces: 0..0,
        });
    }
    if steps.is_empty() {
        return Err("nothing was done yet: there is no command to repeat it".into());
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
    let count = steps.len();
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == count;
        let output = match (&model.saved_to, last) {
            (Some(path), true) if io::Format::from_path(path).is_some() => path.clone(),
            (_, true) => folder.join(format!("{stem}_filled.obj")),
            _ => folder.join(format!("{stem}_{}.obj", i + 1)),
        };
        let schedule = if step.schedule.entries.is_empty() {
            None
        } else {
            let path = output.with_extension("schedule.csv");
            io::save_text(&path, &step.schedule.to_csv()).map_err(|e| e.to_string())?;
            Some(path)
        };
        let line = command_line(
            step.work.command(),
            &input,
            &output,
            &words(&step.work, &output)?,
            step.work.has_controls().then_some(&step.controls),
            schedule.as_deref(),
        );
        let _ = writeln!(text, "{line}");
        input = output;
    }
    Ok(text)
}

/// Lists of faces and sharp edges longer than this are written to files.
const LONG: usize = 120;

/// What the command is about, as arguments.
fn words(work: &Work, output: &Path) -> Result<Vec<String>, String> {
    let numbers: Vec<String> = work.loops().iter().map(ToString::to_string).collect();
    let mut words = match work {
        Work::Fill(_) | Work::Blend(_) => vec!["--loops".into(), numbers.join(",")],
        Work::Flip(_) => vec!["--component-of".into(), numbers.join(",")],
        Work::Bridge(ends, width) => {
            let text = |p: &DVec3| format!("{},{},{}", p.x, p.y, p.z);
            let [from, to] = ends.each_ref().map(text);
            let width = width.to_string();
            ["--from", &from, "--to", &to, "--width", &width]
                .map(str::to_owned)
                .to_vec()
        }
        Work::Refine(work) => refine_words(&work.words, output)?,
        Work::Refill(_) | Work::Fair(_) | Work::Erase(_) => Vec::new(),
    };
    let list = ranges_text(work.faces());
    if list.len() > LONG {
        let path = output.with_extension("faces.txt");
        let lines = list.replace(',', "\n") + "\n";
        io::save_text(&path, &lines).map_err(|e| e.to_string())?;
        words.extend(["--faces-from".into(), path.to_string_lossy().into_owned()]);
    } else if !list.is_empty() {
        words.extend(["--faces".into(), list]);
    }
    if matches!(work, Work::Fair(_)) {
        words.push("--fair".into());
    }
    Ok(words)
}

/// The arguments of a refinement; long chains of sharp edges go into a file.
fn refine_words(words: &[String], output: &Path) -> Result<Vec<String>, String> {
    let is_chain = |i: usize| i > 0 && words[i - 1] == CREASE;
    let chains: Vec<&str> = (0..words.len())
        .filter(|&i| is_chain(i))
        .map(|i| words[i].as_str())
        .collect();
    if chains.iter().map(|c| c.len()).sum::<usize>() <= LONG {
        return Ok(words.to_vec());
    }
    let path = output.with_extension("creases.txt");
    io::save_text(&path, &(chains.join("\n") + "\n")).map_err(|e| e.to_string())?;
    let others = (0..words.len()).filter(|&i| !is_chain(i) && words[i] != CREASE);
    let mut left: Vec<String> = others.map(|i| words[i].clone()).collect();
    left.extend(["--creases-from".into(), path.to_string_lossy().into_owned()]);
    Ok(left)
}
