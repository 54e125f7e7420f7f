//! Output to standard output and standard error, and to mesh files.

use std::cell::RefCell;
use std::io::{ErrorKind, Write};
use std::path::Path;

use anyhow::{Result, anyhow};

use crate::io::{Companions, copy_companions, save_mesh, save_mesh_keeping_files};
use crate::mesh::{LoadReport, Mesh};

/// Writes text to standard output. A closed pipe (`meniscus info … | head`) is not an error; any
/// other failure, such as a full disk, is one.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("cannot write to standard output"))
        }
        _ => Ok(()),
    }
}

/// The `most` elements of the greatest size, and the others, both in the given order.
pub fn largest<T>(
    all: &[T],
    most: usize,
    size: impl Fn(&T) -> usize,
) -> (Vec<(usize, &T)>, Vec<&T>) {
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(size(&all[i])));
    let (shown, others) = order.split_at_mut(most.min(all.len()));
    shown.sort_unstable();
    others.sort_unstable();
    let shown = shown.iter().map(|&i| (i, &all[i])).collect();
    (shown, others.iter().map(|&i| &all[i]).collect())
}

thread_local! {
    /// The lines that [`kept`] keeps.
    static KEPT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Prints a line to standard error, or keeps it inside [`kept`].
pub fn say(line: &str) {
    KEPT.with_borrow_mut(|kept| match kept {
        Some(text) => {
            text.push_str(line);
            text.push('\n');
        }
        None => complain(&format!("{line}\n")),
    });
}

/// Prints the notes of loading the file of this name.
pub fn say_notes(name: &str, report: &LoadReport) {
    for note in &report.notes {
        say(&format!("{name}: {note}"));
    }
}

/// Writes text to standard error. Errors of this write are ignored.
pub fn complain(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// Collects the lines that `work` prints on this thread. Returns them with its result.
pub fn kept<T>(work: impl FnOnce() -> T) -> (T, String) {
    KEPT.set(Some(String::new()));
    let result = work();
    (result, KEPT.take().unwrap_or_default())
}

/// Whether lines are kept.
pub fn are_lines_kept() -> bool {
    KEPT.with_borrow(Option::is_some)
}

/// What happens to the material libraries and images of a mesh that is written to another folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Textures {
    /// They are copied.
    #[default]
    Copy,
    /// They stay where they are, and the mesh refers to them there.
    Keep,
}

/// Writes a mesh, and copies the files that it refers to. Unless `quiet`, prints to standard error
/// what was copied and what the format cannot store.
///
/// # Errors
/// The mesh is not written, or it is written and refers to another file than the input.
pub fn save(path: &Path, mesh: &Mesh, textures: Textures, quiet: bool) -> Result<()> {
    save_with_companions(path, mesh, textures, quiet)?
}

/// [`save`] with the error about a written mesh inside.
///
/// # Errors
/// The mesh is not written.
pub fn save_with_companions(
    path: &Path,
    mesh: &Mesh,
    textures: Textures,
    quiet: bool,
) -> Result<Result<()>> {
    let (messages, companions) = match textures {
        Textures::Copy => (
            save_mesh(path, mesh)?,
            copy_companions(path, &mesh.attributes),
        ),
        Textures::Keep => (save_mesh_keeping_files(path, mesh)?, Companions::default()),
    };
    if !quiet {
        for message in messages.iter().chain(&companions.messages) {
            say(&format!("{}: {message}", path.display()));
        }
        if !companions.outside.is_empty() {
            say("  hint: with --textures keep, the output refers to such files where they are");
        }
    }
    let others = companions.others;
    if others.is_empty() {
        return Ok(Ok(()));
    }
    Ok(Err(anyhow!(
        "{} is written, but another file than that of the input is beside it: '{}'; write to another folder, \
         or use --textures keep",
        path.display(),
        others.join("', '")
    )))
}
