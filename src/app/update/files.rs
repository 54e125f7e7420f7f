//! Opening, saving, closing.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::app::action::Action;
use crate::app::autosave;
use crate::app::document::{Document, Source};
use crate::app::jobs::Job;
use crate::app::model::{Done, Effect, Loaded, Model, SavedWhat};
use crate::app::project;
use crate::app::report::ReportAction;
use crate::app::view_state::{AfterUnsaved, Modal, PathUse};
use crate::io;
use crate::shapes::SAMPLES;

/// A dialog that is answered sooner was never shown.
const NO_DIALOG: Duration = Duration::from_millis(400);

/// Carries out the actions of this kind.
pub fn update(model: &mut Model, action: Action) {
    match action {
        Action::AskOpen => guarded(model, AfterUnsaved::AskOpen),
        Action::Open(path) => guarded(model, AfterUnsaved::Open(path)),
        Action::Sample(name) => guarded(model, AfterUnsaved::Sample(name)),
        Action::Close => guarded(model, AfterUnsaved::Close),
        Action::Save => match model.saved_to.clone() {
            Some(path) => save(model, &path),
            None => ask(model, PathUse::SaveAs),
        },
        Action::AskSaveAs => ask(model, PathUse::SaveAs),
        Action::SaveAs(path) => save(model, &path),
        Action::AskExportPatch => {
            if model.document.is_changed() {
                ask(model, PathUse::ExportPatch);
            } else {
                model.log.info("there is no patch yet: fill a hole first");
            }
        }
        Action::ExportPatch(path) => export_patch(model, path),
        Action::Discard => {
            if let Modal::Unsaved(next) = std::mem::take(&mut model.view.modal) {
                go_on(model, next);
            }
        }
        Action::SaveThenGoOn => {
            if let Modal::Unsaved(next) = std::mem::take(&mut model.view.modal) {
                model.after_save = Some(next);
                update(model, Action::Save);
            }
        }
        Action::Recover(path) => {
            model.view.modal = Modal::None;
            load(model, path);
        }
        Action::DropRecovery => {
            if let Modal::Recover(paths) = std::mem::take(&mut model.view.modal) {
                for path in &paths {
                    autosave::remove(path);
                }
            }
        }
        _ => {}
    }
}

/// Does it, unless work would be lost.
fn guarded(model: &mut Model, next: AfterUnsaved) {
    if model.must_ask_before_closing() {
        model.view.modal = Modal::Unsaved(next);
    } else {
        go_on(model, next);
    }
}

fn go_on(model: &mut Model, next: AfterUnsaved) {
    match next {
        AfterUnsaved::Close => {
            // nothing is to be asked about any more
            model.run = None;
            model.saved_revision = model.revision;
            model.autosave.discard();
            model.effects.push(Effect::Close);
        }
        AfterUnsaved::Open(path) => load(model, path),
        AfterUnsaved::AskOpen => ask(model, PathUse::Open),
        AfterUnsaved::Sample(name) => sample(model, name),
    }
}

/// Asks the system's dialog; where it has none a path is typed instead.
pub(super) fn ask(model: &mut Model, purpose: PathUse) {
    let start = model.source_path();
    let name = suggestion(model, purpose);
    model
        .jobs
        .push(Job::spawn("file dialog", &model.wake, move |_| {
            let asked = Instant::now();
            let mut dialog = rfd::FileDialog::new();
            if let Some(folder) = start.as_ref().and_then(|p| p.parent()) {
                dialog = dialog.set_directory(folder);
            }
            let meshes = ["obj", "ply", "stl"];
            let path = match purpose {
                PathUse::Open => dialog
                    .add_filter(
                        "Meshes and projects",
                        &["obj", "ply", "stl", project::EXTENSION],
                    )
                    .pick_file(),
                PathUse::SaveAs => dialog
                    .add_filter("Meshes", &meshes)
                    .add_filter("Project", &[project::EXTENSION])
                    .set_file_name(name)
                    .save_file(),
                PathUse::ExportPatch => dialog
                    .add_filter("Meshes", &meshes)
                    .set_file_name(name)
                    .save_file(),
                PathUse::Reference => dialog.add_filter("Meshes", &meshes).pick_file(),
                PathUse::Report(file) => dialog
                    .add_filter("Report", &[file.extension()])
                    .set_file_name(name)
                    .save_file(),
            };
            Done::Chosen(purpose, path, asked.elapsed())
        }));
}

fn suggestion(model: &Model, purpose: PathUse) -> String {
    let stem = model
        .source_path()
        .as_deref()
        .and_then(Path::file_stem)
        .map_or_else(|| "mesh".into(), |s| s.to_string_lossy().into_owned());
    match purpose {
        PathUse::Open | PathUse::Reference => String::new(),
        PathUse::Report(file) => format!("{stem}_{}", file.suffix()),
        PathUse::SaveAs => format!("{stem}_filled.obj"),
        PathUse::ExportPatch => format!("{stem}_patch.obj"),
    }
}

impl Model {
    /// Takes a dialog's answer.
    pub(in crate::app) fn chosen(
        &mut self,
        purpose: PathUse,
        path: Option<PathBuf>,
        waited: Duration,
    ) {
        let Some(path) = path else {
            if waited < NO_DIALOG {
                let text = suggestion(self, purpose);
                let folder = self.source_path();
                let folder = folder.as_deref().and_then(Path::parent);
                let text = folder.map_or(text.clone(), |f| f.join(text).display().to_string());
                self.ask_path(purpose, text);
            } else {
                self.after_save = None;
            }
            return;
        };
        match purpose {
            PathUse::Open => load(self, path),
            PathUse::SaveAs => save(self, &path),
            PathUse::ExportPatch => export_patch(self, path),
            PathUse::Reference | PathUse::Report(_) => {
                self.act(Action::Report(ReportAction::Path(purpose, path)));
            }
        }
    }

    /// Takes in what was read.
    pub(in crate::app) fn loaded(&mut self, path: &Path, result: Result<Loaded, String>) {
        match result {
            Ok(Loaded::Mesh(document)) => {
                if matches!(document.origin.source, Source::File(_)) {
                    self.settings.remember(path);
                }
                self.replace(*document);
            }
            Ok(Loaded::Project(document, project)) => {
                let recovered = crate::app::settings::state_folder()
                    .is_some_and(|folder| path.starts_with(folder));
                self.replace(*document);
                let bounds = self.document.origin.bounds;
                project.view.restore(&mut self.view, &bounds);
                if recovered {
                    // its file goes once the work is saved
                    self.revision += 1;
                    autosave::remove(path);
                    self.log.info("recovered; save it to keep it");
                } else {
                    self.saved_to = Some(path.to_owned());
                    self.settings.remember(path);
                }
            }
            Err(text) if self.document.is_blank() => {
                self.log.error(text);
                let first = SAMPLES[0].name;
                if path != Path::new(first) {
                    sample(self, first.into());
                }
            }
            Err(text) => self
                .log
                .error(format!("{text}\nThe open document was left alone.")),
        }
    }

    /// Takes in that something was written.
    pub(in crate::app) fn saved(
        &mut self,
        path: PathBuf,
        what: SavedWhat,
        result: Result<(), String>,
    ) {
        if let Err(text) = result {
            self.after_save = None;
            self.log.error(text);
            return;
        }
        self.log.info(format!("saved {}", path.display()));
        let (SavedWhat::Mesh(revision) | SavedWhat::Project(revision)) = what else {
            return;
        };
        self.saved_revision = revision;
        if matches!(what, SavedWhat::Project(_)) {
            self.settings.remember(&path);
        }
        self.saved_to = Some(path);
        if !self.is_dirty() {
            self.autosave.discard();
        }
        if let Some(next) = self.after_save.take() {
            go_on(self, next);
        }
    }
}

/// Makes a sample in the background; some take a third of a second.
fn sample(model: &mut Model, name: String) {
    model.jobs.push(Job::spawn(
        format!("sample {name}"),
        &model.wake,
        move |_| {
            let path = PathBuf::from(&name);
            let made = project::sample_of(&name)
                .map(|opened| Loaded::Mesh(Box::new(Document::new(opened, Source::Sample(name)))));
            Done::Loaded(path, made)
        },
    ));
}

fn load(model: &mut Model, path: PathBuf) {
    model.jobs.push(Job::spawn(
        format!("opening {}", path.display()),
        &model.wake,
        move |_| {
            let is_project = path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(project::EXTENSION));
            let result = if is_project {
                project::read(&path)
                    .map(|(document, head)| Loaded::Project(Box::new(document), Box::new(head)))
            } else {
                io::open(&path)
                    .map(|opened| {
                        let source = Source::File(path.clone());
                        Loaded::Mesh(Box::new(Document::new(opened, source)))
                    })
                    .map_err(|e| e.to_string())
            };
            Done::Loaded(path, result)
        },
    ));
}

/// Whether writing there would destroy the opened file.
pub(super) fn is_source(model: &Model, path: &Path) -> bool {
    model
        .source_path()
        .is_some_and(|source| io::same_file(&source, path))
}

fn save(model: &mut Model, path: &Path) {
    let path = path.to_owned();
    if is_source(model, &path) {
        model.after_save = None;
        model.log.error(format!(
            "{} is the file that was opened; it is never overwritten: choose another name",
            path.display()
        ));
        return;
    }
    if model.run.is_some() {
        model
            .log
            .warning("the patch was not accepted yet and is not in the saved file");
    }
    let revision = model.revision;
    let document = model.document.clone();
    let is_project = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(project::EXTENSION));
    let what = if is_project {
        SavedWhat::Project(revision)
    } else {
        SavedWhat::Mesh(revision)
    };
    let view = model.view.clone();
    model.jobs.push(Job::spawn(
        format!("saving {}", path.display()),
        &model.wake,
        move |_| {
            let result = if is_project {
                let folder = path.parent().unwrap_or(Path::new("."));
                io::save_text(&path, &project::write(&document, &view, folder))
            } else {
                io::save_mesh(&path, &document.mesh, &document.origin.material_libraries)
            };
            Done::Saved(path, what, result.map_err(|e| e.to_string()))
        },
    ));
}

fn export_patch(model: &mut Model, path: PathBuf) {
    if is_source(model, &path) {
        model.log.error(format!(
            "{} is the file that was opened; it is never overwritten: choose another name",
            path.display()
        ));
        return;
    }
    let Some(patches) = model.document.patches() else {
        model.log.info("there is no patch yet: fill a hole first");
        return;
    };
    let patches = Arc::new(patches);
    model.jobs.push(Job::spawn(
        format!("saving {}", path.display()),
        &model.wake,
        move |_| {
            let result = io::save_mesh(&path, &patches, &[]).map_err(|e| e.to_string());
            Done::Saved(path, SavedWhat::Patch, result)
        },
    ));
}
