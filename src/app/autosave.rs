//! The recovery file: it exists while there is unsaved work and is removed at a regular exit.
//!
//! Each window locks a file beside its recovery file. The system releases the lock whenever the
//! program ends. A recovery file with a free lock belongs to a window that crashed.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::document::Document;
use super::jobs::{Job, Wake};
use super::project;
use super::view_state::ViewState;
use crate::fill::Controls;
use crate::io;
use crate::mesh::LoopId;

/// Time from a change to writing the file.
const DELAY: Duration = Duration::from_secs(2);

/// The state of a document that a recovery file stores. The file is written again when it changes.
#[derive(Clone, PartialEq)]
struct Fingerprint {
    revision: u64,
    selection: BTreeSet<LoopId>,
    controls: Controls,
}

/// The recovery file of this window.
pub struct Autosave {
    file: Option<PathBuf>,
    lock: Option<(PathBuf, File)>,
    written: Option<Fingerprint>,
    seen: Option<(Fingerprint, Instant)>,
    job: Option<Job<Result<(), String>>>,
    errors: Vec<String>,
    told: bool,
    /// Whether there were unsaved changes at the last call.
    was_dirty: bool,
}

impl Autosave {
    /// An autosave that writes nothing.
    pub fn off() -> Self {
        Self {
            file: None,
            lock: None,
            written: None,
            seen: None,
            job: None,
            errors: Vec::new(),
            told: false,
            was_dirty: false,
        }
    }

    /// Reserves a file name in `folder`. If that fails, nothing is written and an error is
    /// reported.
    pub fn in_folder(folder: &Path) -> Self {
        let mut autosave = Self::off();
        match claim(folder) {
            Ok((lock, path)) => {
                autosave.file = Some(path.with_extension(project::EXTENSION));
                autosave.lock = Some((path, lock));
            }
            Err(error) => autosave.errors.push(format!(
                "cannot write recovery files to {}: {error}",
                folder.display()
            )),
        }
        autosave
    }

    /// Errors to report.
    pub fn take_errors(&mut self) -> Vec<String> {
        std::mem::take(&mut self.errors)
    }

    /// Writes the file some time after the last change. Returns the time until the next call.
    pub fn tick(
        &mut self,
        now: Instant,
        revision: u64,
        dirty: bool,
        document: &Document,
        view: &ViewState,
        wake: &Wake,
    ) -> Option<Duration> {
        let file = self.file.clone()?;
        if let Some(job) = &self.job {
            let result = job.poll()?;
            self.job = None;
            if let Err(text) | Ok(Err(text)) = result
                && !std::mem::replace(&mut self.told, true)
            {
                self.errors
                    .push(format!("the recovery file was not written: {text}"));
            }
        }
        let was_dirty = std::mem::replace(&mut self.was_dirty, dirty);
        if !dirty && document.selection.is_empty() && !was_dirty {
            return None;
        }
        let current = Fingerprint {
            revision,
            selection: document.selection.clone(),
            controls: document.controls.clone(),
        };
        if was_dirty && !dirty {
            // everything was undone: what is selected by that is nothing to recover
            self.discard();
            self.written = Some(current);
            return None;
        }
        if self.written.as_ref() == Some(&current) {
            return None;
        }
        match &self.seen {
            Some((seen, since)) if *seen == current => {
                let wait = (*since + DELAY).saturating_duration_since(now);
                if !wait.is_zero() {
                    return Some(wait);
                }
            }
            _ => {
                self.seen = Some((current, now));
                return Some(DELAY);
            }
        }
        let (document, view) = (document.clone(), view.clone());
        self.job = Some(Job::spawn("recovery file", wake, move |_| {
            let folder = file.parent().unwrap_or(Path::new("."));
            io::save_text(&file, &project::write(&document, &view, folder))
                .map_err(|e| e.to_string())
        }));
        self.written = Some(current);
        None
    }

    /// Removes the recovery file: there is no unsaved work.
    pub fn discard(&mut self) {
        // wait for a running write, so that it does not restore the file
        if let Some(job) = self.job.take() {
            while job.poll().is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        if let Some(file) = &self.file {
            fs::remove_file(file).ok();
        }
        self.written = None;
        self.seen = None;
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // the file stays for the next session
            return;
        }
        self.discard();
        if let Some((path, lock)) = self.lock.take() {
            drop(lock);
            fs::remove_file(path).ok();
        }
    }
}

/// Creates and locks a file that no other window uses.
fn claim(folder: &Path) -> std::io::Result<(File, PathBuf)> {
    fs::create_dir_all(folder)?;
    let mut number = std::process::id();
    loop {
        let path = folder.join(format!("window-{number}.lock"));
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)?;
        if file.try_lock().is_ok() && !path.with_extension(project::EXTENSION).exists() {
            return Ok((file, path));
        }
        number = number.wrapping_add(1);
    }
}

/// Recovery files of crashed windows in `folder`, newest first.
pub fn left_behind(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<(std::time::SystemTime, PathBuf)> = entries
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            let lock = path.with_extension("lock");
            let is_ours = path.extension().is_some_and(|e| e == project::EXTENSION);
            // an open window holds its lock
            let free = File::open(&lock).map_or(true, |f| f.try_lock().is_ok());
            let time = fs::metadata(&path).and_then(|m| m.modified()).ok()?;
            (is_ours && free).then_some((time, path))
        })
        .collect();
    found.sort_by(|a, b| b.cmp(a));
    found.into_iter().map(|(_, path)| path).collect()
}

/// Deletes a recovery file with its lock.
pub fn remove(path: &Path) {
    fs::remove_file(path).ok();
    fs::remove_file(path.with_extension("lock")).ok();
}
