//! Opening, saving, closing.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{asks_to_replace, report, report_files, view};
use crate::app::action::FileAction;
use crate::app::autosave;
use crate::app::display::DisplayWorker;
use crate::app::document::{Document, Origin, Source};
use crate::app::history::History;
use crate::app::model::{Done, Effect, Loaded, Model, SavedWhat};
use crate::app::project;
use crate::app::repeat;
use crate::app::report::Report;
use crate::app::view_state::{AfterUnsaved, Modal, PathPrompt, PathUse};
use crate::io;
use crate::render::{Textures, ViewMode, grouped};
use crate::shapes::SAMPLES;
use crate::warning::counted;

/// The job that reads the texture images of an opened mesh.
pub(super) const TEXTURES: &str = "texture images";

/// A dialog that returns within this time was not shown.
pub(super) const NO_DIALOG: Duration = Duration::from_millis(400);

pub(crate) fn update(model: &mut Model, action: FileAction) {
    match action {
        FileAction::AskOpen => guarded(model, AfterUnsaved::AskOpen),
        FileAction::Open(path) => guarded(model, AfterUnsaved::Open(path)),
        FileAction::Sample(name) => guarded(model, AfterUnsaved::Sample(name)),
        FileAction::Close => guarded(model, AfterUnsaved::Close),
        FileAction::Save => match model.saved_to.clone() {
            Some(path) => save(model, &path),
            None => ask(model, PathUse::SaveAs),
        },
        FileAction::AskSaveAs => ask(model, PathUse::SaveAs),
        FileAction::SaveAs(path) => save(model, &path),
        FileAction::UsePath(purpose, path) => use_path(model, purpose, path, true),
        FileAction::AskExportPatch => {
            if model.document.is_changed() {
                ask(model, PathUse::ExportPatch);
            } else {
                model.log.info("there is no patch: fill a hole first");
            }
        }
        FileAction::ExportPatch(path) => export_patch(model, path),
        FileAction::DiscardAndContinue => {
            if let Modal::Unsaved(next) = std::mem::take(&mut model.view.modal) {
                resume(model, next);
            }
        }
        FileAction::SaveAndContinue => {
            if let Modal::Unsaved(next) = std::mem::take(&mut model.view.modal) {
                model.after_save = Some(next);
                update(model, FileAction::Save);
            }
        }
        FileAction::Recover(path) => {
            model.view.modal = Modal::None;
            load(model, path);
        }
        FileAction::DropRecovery => {
            if let Modal::Recover(paths) = std::mem::take(&mut model.view.modal) {
                for path in &paths {
                    autosave::remove(path);
                }
            }
        }
        FileAction::CopyCommand => match repeat::command(model) {
            Ok((text, files)) => {
                model.effects.push(Effect::CopyText(text));
                let written = match &files[..] {
                    [] => String::new(),
                    files => format!("; it reads {}, which was written", files.join(", ")),
                };
                model
                    .log
                    .info(format!("command copied to the clipboard{written}"));
            }
            Err(text) => model.log.warning(text),
        },
    }
}

/// Continues with `next`, or asks first if work would be lost.
fn guarded(model: &mut Model, next: AfterUnsaved) {
    if model.must_ask_before_closing() {
        model.view.modal = Modal::Unsaved(next);
    } else {
        resume(model, next);
    }
}

fn resume(model: &mut Model, next: AfterUnsaved) {
    match next {
        AfterUnsaved::Close => {
            // the user has decided; do not ask again
            model.run = None;
            model.saved_mesh = Some(Arc::clone(&model.document.mesh));
            model.autosave.discard();
            model.effects.push(Effect::Close);
        }
        AfterUnsaved::Open(path) => load(model, path),
        AfterUnsaved::AskOpen => ask(model, PathUse::Open),
        AfterUnsaved::Sample(name) => sample(model, name),
    }
}

/// Opens the file dialog of the system, or asks for a typed path if there is none.
pub(super) fn ask(model: &mut Model, purpose: PathUse) {
    let start = model.source_path();
    let name = suggestion(model, purpose);
    model.spawn("file dialog", move |_| {
        let asked = Instant::now();
        let mut dialog = rfd::FileDialog::new();
        if let Some(folder) = start.as_ref().and_then(|p| p.parent()) {
            dialog = dialog.set_directory(folder);
        }
        let meshes = io::Format::ALL.map(io::Format::extension);
        let path = match purpose {
            PathUse::Open => dialog
                .add_filter(
                    "Meshes and projects",
                    &[&meshes[..], &[project::EXTENSION]].concat(),
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
        Done::PathChosen(purpose, path, asked.elapsed())
    });
}

/// The extension of files beside a mesh file: that of the file, or `obj`.
pub(in crate::app) fn kept_extension(source: Option<&Path>) -> String {
    let source = source.filter(|path| io::Format::from_path(path).is_some());
    let extension = source.and_then(Path::extension);
    extension.map_or_else(|| "obj".into(), |s| s.to_string_lossy().into_owned())
}

fn suggestion(model: &Model, purpose: PathUse) -> String {
    let source = model.source_path();
    let source = source.as_deref();
    let stem = source.and_then(Path::file_stem);
    let stem = stem.map_or_else(|| "mesh".into(), |s| s.to_string_lossy().into_owned());
    let extension = kept_extension(source);
    match purpose {
        PathUse::Open | PathUse::Reference => String::new(),
        PathUse::Report(file) => format!("{stem}_{}", file.suffix()),
        PathUse::SaveAs => format!("{stem}_filled.{extension}"),
        PathUse::ExportPatch => format!("{stem}_patch.{extension}"),
    }
}

/// Handles the result of a dialog; `None` if it was cancelled or is not available.
pub(super) fn path_chosen(
    model: &mut Model,
    purpose: PathUse,
    path: Option<PathBuf>,
    waited: Duration,
) {
    match path {
        Some(path) => use_path(model, purpose, path, false),
        None if waited < NO_DIALOG => {
            let text = suggestion(model, purpose);
            let folder = model.source_path();
            let folder = folder.as_deref().and_then(Path::parent);
            let text = folder.map_or(text.clone(), |f| f.join(text).display().to_string());
            model.view.modal = Modal::Path(PathPrompt { purpose, text });
        }
        None => model.after_save = None,
    }
}

/// Uses a path for its purpose. It was typed, or chosen in the dialog of the system, which asks whether to
/// replace a file. A file to write gets an extension if it has none.
fn use_path(model: &mut Model, purpose: PathUse, mut path: PathBuf, is_typed: bool) {
    let text = path.display().to_string();
    let extension = match purpose {
        PathUse::Open | PathUse::Reference => None,
        PathUse::SaveAs | PathUse::ExportPatch => Some("obj"),
        PathUse::Report(file) => Some(file.extension()),
    };
    if let Some(extension) = extension {
        let target = with_extension(path.clone(), extension);
        let is_answered = !is_typed && target == path;
        let writing = FileAction::UsePath(purpose, path);
        if !is_answered && !is_source(model, &target) && asks_to_replace(model, &target, writing) {
            return;
        }
        path = target;
    }
    if is_typed {
        model.view.modal = Modal::None;
        // the report names a reference that cannot be read
        let prompt = (purpose != PathUse::Reference).then_some(PathPrompt { purpose, text });
        model.typed_path = prompt;
    }
    match purpose {
        PathUse::Open => load(model, path),
        PathUse::SaveAs => save(model, &path),
        PathUse::ExportPatch => export_patch(model, path),
        PathUse::Reference => report::set_reference(model, path),
        PathUse::Report(file) => report_files::save(model, file, path),
    }
}

/// The path with an extension if it has none. What follows the last dot is part of the name if it has
/// digits, as in `scan.v2`, and is not that of a format.
pub(super) fn with_extension(mut path: PathBuf, extension: &str) -> PathBuf {
    let own = path
        .extension()
        .map(|own| own.to_string_lossy().into_owned());
    let is_format = own.is_some_and(|own| {
        let is_known =
            io::Format::from_path(&path).is_some() || own.eq_ignore_ascii_case(extension);
        is_known || own.chars().all(char::is_alphabetic)
    });
    if !is_format {
        path.as_mut_os_string().push(format!(".{extension}"));
    }
    path
}

/// Asks again for a typed path whose file cannot be read or written.
fn ask_again(model: &mut Model) {
    if let Some(prompt) = model.typed_path.take() {
        model.view.modal = Modal::Path(prompt);
    }
}

/// Opens the content that was read.
pub(super) fn loaded(model: &mut Model, path: &Path, result: Result<Loaded, String>) {
    if result.is_ok() {
        model.typed_path = None;
    } else {
        ask_again(model);
    }
    match result {
        Ok(Loaded::Mesh(document)) => {
            if matches!(document.origin.source, Source::File(_)) {
                model.settings.remember(path);
            }
            replace(model, *document);
        }
        Ok(Loaded::Project(document, project)) => {
            let recovered =
                crate::app::settings::state_folder().is_some_and(|folder| path.starts_with(folder));
            replace(model, *document);
            let bounds = model.document.origin.bounds;
            project.view.restore(&mut model.view, &bounds);
            if recovered {
                // the recovery file is removed once the work is saved
                model.revision += 1;
                model.saved_mesh = None;
                autosave::remove(path);
                model.log.info("recovered: save it to keep it");
            } else {
                model.saved_to = Some(path.to_owned());
                model.settings.remember(path);
            }
        }
        Err(text) if model.document.is_blank() => {
            model.log.error(text);
            let first = SAMPLES[0].name;
            if path != Path::new(first) {
                sample(model, first.into());
            }
        }
        Err(text) => model
            .log
            .error(format!("{text}\nThe open document is unchanged.")),
    }
}

/// Records that a file was written.
pub(super) fn saved(
    model: &mut Model,
    path: PathBuf,
    what: SavedWhat,
    result: Result<Vec<String>, String>,
) {
    let losses = match result {
        Ok(losses) => losses,
        Err(text) => {
            model.after_save = None;
            model.log.error(text);
            ask_again(model);
            return;
        }
    };
    model.typed_path = None;
    model.log.info(format!("saved {}", path.display()));
    for loss in losses {
        model.log.warning(loss);
    }
    let (SavedWhat::Mesh(mesh) | SavedWhat::Project(mesh)) = what else {
        return;
    };
    model.saved_mesh = Some(mesh);
    model.settings.remember(&path);
    model.saved_to = Some(path);
    if !model.is_dirty() {
        model.autosave.discard();
    }
    if let Some(next) = model.after_save.take() {
        resume(model, next);
    }
}

/// Replaces the open document.
pub(in crate::app) fn replace(model: &mut Model, document: Document) {
    model.run = None;
    model.rejected = None;
    // do not fit the camera to the old surfaces
    model.displays.iter_mut().for_each(DisplayWorker::clear);
    model.history = History::default();
    let view = &mut model.view;
    view.camera.home();
    view.camera.fit_to(&document.origin.bounds);
    view.fit = true;
    view.hover.clear();
    view.report.forget();
    model.report = Report::default();
    view.energy_text.clone_from(&document.controls.energy);
    view.compared = None;
    model.document = document;
    model.textures = Arc::default();
    view::first_mode(model);
    read_textures(model);
    model.saved_to = None;
    model.revision += 1;
    model.saved_mesh = Some(Arc::clone(&model.document.mesh));
    model.autosave.discard();
    announce(model);
}

/// Reads the texture images of the document in the background.
fn read_textures(model: &mut Model) {
    let materials = io::materials(&model.document.mesh.attributes);
    if materials.is_empty() {
        return;
    }
    let origin = Arc::clone(&model.document.origin);
    let mode = model.view.style.mode;
    model.spawn(TEXTURES, move |_| {
        let (textures, notes) = Textures::read(&materials);
        Done::Textures(origin, mode, textures, notes)
    });
}

/// Shows the texture images of the document with this origin, in its colours if the view mode was not
/// changed from `mode` in the meantime.
pub(super) fn textures_read(
    model: &mut Model,
    origin: &Arc<Origin>,
    mode: ViewMode,
    textures: Textures,
    notes: Vec<String>,
) {
    if !Arc::ptr_eq(origin, &model.document.origin) {
        return;
    }
    for note in notes {
        model.log.warning(note);
    }
    model.textures = Arc::new(textures);
    if model.view.style.mode == mode {
        view::first_mode(model);
    }
}

/// Reports the opened mesh.
fn announce(model: &mut Model) {
    let document = &model.document;
    let report = &document.origin.report;
    let holes = document.holes().len();
    let noun = if holes == 1 { "hole" } else { "holes" };
    let mut text = format!(
        "{}: {} vertices, {} faces, {holes} {noun}",
        document.origin.name(),
        grouped(report.vertices),
        grouped(report.faces)
    );
    if report.welded_vertices > 0 {
        let _ = write!(text, "; {} vertices merged", report.welded_vertices);
    }
    model.log.info(text);
    let defects = report.defect_count();
    if defects > 0 {
        let defects = counted(defects, "defect was", "defects were");
        model.log.warning(format!(
            "{defects} found or repaired: see the load report (Ctrl+R)"
        ));
    }
    for note in &report.notes {
        model.log.warning(note.clone());
    }
}

/// Builds a sample in the background; some take a third of a second.
fn sample(model: &mut Model, name: String) {
    model.spawn(format!("sample {name}"), move |_| {
        let path = PathBuf::from(&name);
        let made = project::sample_of(&name)
            .map(|opened| Loaded::Mesh(Box::new(Document::new(opened, Source::Sample(name)))));
        Done::Loaded(path, made)
    });
}

fn is_project(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case(project::EXTENSION))
}

fn load(model: &mut Model, path: PathBuf) {
    model.spawn(format!("opening {}", path.display()), move |_| {
        let result = if is_project(&path) {
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
    });
}

/// Whether writing to this path would overwrite the opened file.
pub(super) fn is_source(model: &Model, path: &Path) -> bool {
    model
        .source_path()
        .is_some_and(|source| io::same_file(&source, path))
}

/// The same; if so, it is reported and nothing follows the save.
fn refuses_source(model: &mut Model, path: &Path) -> bool {
    let refused = is_source(model, path);
    if refused {
        model.after_save = None;
        model.log.error(format!(
            "{} is the opened file, which is never overwritten: choose another name",
            path.display()
        ));
        ask_again(model);
    }
    refused
}

/// Writes a file in the background. `write` returns what the format cannot keep.
pub(super) fn save_as(
    model: &mut Model,
    path: PathBuf,
    what: SavedWhat,
    write: impl FnOnce(&Path) -> Result<Vec<String>, String> + Send + 'static,
) {
    model.spawn(format!("saving {}", path.display()), move |_| {
        let result = write(&path);
        Done::Saved(path, what, result)
    });
}

fn save(model: &mut Model, path: &Path) {
    if refuses_source(model, path) {
        return;
    }
    if model.run.is_some() {
        model
            .log
            .warning("the patch is not accepted and not in the saved file");
    }
    let (document, view) = (model.document.clone(), model.view.clone());
    let is_project = is_project(path);
    let mesh = Arc::clone(&document.mesh);
    let what = if is_project {
        SavedWhat::Project(mesh)
    } else {
        SavedWhat::Mesh(mesh)
    };
    save_as(model, path.to_owned(), what, move |path| {
        let result = if is_project {
            let folder = path.parent().unwrap_or(Path::new("."));
            io::save_text(path, &project::write(&document, &view, folder)).map(|()| Vec::new())
        } else {
            io::save_mesh(path, &document.mesh).map(|mut messages| {
                messages.extend(io::copy_companions(path, &document.mesh.attributes).messages);
                messages
            })
        };
        result.map_err(|e| e.to_string())
    });
}

fn export_patch(model: &mut Model, path: PathBuf) {
    if refuses_source(model, &path) {
        return;
    }
    let Some(patches) = model.document.patches() else {
        model.log.info("there is no patch: fill a hole first");
        return;
    };
    save_as(model, path, SavedWhat::Patch, move |path| {
        io::save_mesh(path, &patches).map_err(|e| e.to_string())
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::tests::{model, opened};

    #[test]
    fn saved_files_are_suggested_in_the_format_of_the_opened_one() {
        let mut m = model();
        assert_eq!(suggestion(&m, PathUse::SaveAs), "mesh_filled.obj");
        for (name, wanted) in [
            ("scan.ply", "scan_filled.ply"),
            ("a.b.glb", "a.b_filled.glb"),
            ("scan.xyz", "scan_filled.obj"),
        ] {
            m.document = Document::new(opened(), Source::File(name.into()));
            assert_eq!(suggestion(&m, PathUse::SaveAs), wanted);
        }
    }
}
