//! The state of the application without the window. [`update`](super::update) changes it.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::autosave::Autosave;
use super::cached::{Cached, ParsedEnergy, SharedKey};
use super::display::DisplayWorker;
use super::document::{Document, Origin, Source, elided, file_name};
use super::faces::FaceEdit;
use super::history::History;
use super::jobs::{Job, Reporter, Wake};
use super::log::Log;
use super::project::Project;
use super::report::Report;
use super::run::{Accepting, Run, RunState};
use super::settings::Settings;
use super::view_state::{AfterUnsaved, PathPrompt, PathUse, PictureSettings, ViewState};
use crate::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, VertexId};
use crate::ops::{Condition, Faces, Operation, RepairStep};
use crate::options::Choice;
use crate::render::{Background, Bounds, Gpu, Picker, Textures, ViewMode, ViewStyle};

/// An effect that only the window can carry out.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Copy a text to the clipboard.
    CopyText(String),
    /// Copy a picture to the clipboard.
    CopyImage(Arc<image::RgbaImage>),
    /// Close without asking.
    Close,
    /// Save a picture of the whole window to this file.
    WindowPicture(PathBuf),
    /// Apply theme and scale.
    Appearance,
}

/// A run that was rejected after its end, which Undo brings back.
pub struct Rejected {
    run: Run,
    mesh: Arc<Mesh>,
    selection: BTreeSet<LoopId>,
    faces: Faces,
}

impl Rejected {
    /// That of a document.
    pub fn new(run: Run, document: &Document) -> Self {
        Self {
            run,
            mesh: Arc::clone(&document.mesh),
            selection: document.selection.clone(),
            faces: Arc::clone(&document.faces),
        }
    }

    /// Whether the document is the one of the run: nothing was changed or selected since.
    fn is_of(&self, document: &Document) -> bool {
        Arc::ptr_eq(&self.mesh, &document.mesh)
            && self.selection == document.selection
            && Arc::ptr_eq(&self.faces, &document.faces)
    }
}

/// Content of a file.
pub enum Loaded {
    /// A mesh file or sample.
    Mesh(Box<Document>),
    /// A project or recovery file.
    Project(Box<Document>, Box<Project>),
}

/// A repaired mesh.
pub struct Repaired {
    /// The operations in their order.
    pub steps: Vec<RepairStep>,
    /// Why an operation was left out.
    pub notes: Vec<String>,
    /// The defects that are left.
    pub after: Condition,
}

/// Result of a background job.
pub enum Done {
    /// A file was read.
    Loaded(PathBuf, Result<Loaded, String>),
    /// A file was written.
    Saved(PathBuf, SavedWhat, Result<Vec<String>, String>),
    /// The picker of a mesh is ready.
    Picker(Arc<Mesh>, Arc<Picker>),
    /// The texture images of an opened mesh, for which the view had this mode, were read; with notes for
    /// the user.
    Textures(Arc<Origin>, ViewMode, Textures, Vec<String>),
    /// The mesh of a state that is being accepted was made; with warnings.
    Accepted(RunState, Box<Mesh>, Vec<String>),
    /// A mesh was repaired, or why it was not.
    Repaired(Arc<Mesh>, Result<Box<Repaired>, String>),
    /// Faces to select were found.
    Faces(FaceEdit),
    /// A file dialog was closed after some time; `None` if it was cancelled or is not available.
    PathChosen(PathUse, Option<PathBuf>, Duration),
    /// The same for the file of a picture.
    PicturePath(Option<PathBuf>, Duration),
    /// A picture for the clipboard.
    Picture(Result<Arc<image::RgbaImage>, String>),
    /// Picture files were written or not, with a message, by these settings.
    Pictures(Result<String, String>, Box<PictureSettings>),
}

/// The content of a written file.
#[derive(Clone, Debug)]
pub enum SavedWhat {
    /// The whole mesh.
    Mesh(Arc<Mesh>),
    /// The project with this mesh.
    Project(Arc<Mesh>),
    /// Only the patches.
    Patch,
    /// A report.
    Report,
}

/// Maximum number of characters of the name in the title of the window.
const TITLE: usize = 60;

/// Maximum number of views side by side.
pub const MAX_SIDES: usize = 3;

/// The state of the application.
pub struct Model {
    /// The document.
    pub document: Document,
    /// Undo and redo states of the document.
    pub history: History<Document>,
    /// The view.
    pub view: ViewState,
    /// Settings that persist from session to session.
    pub settings: Settings,
    /// A run that is in progress, or finished but neither accepted nor rejected.
    pub run: Option<Run>,
    /// The last run, if it was rejected.
    pub rejected: Option<Rejected>,
    /// Messages.
    pub log: Log,
    /// Wakes the window.
    pub wake: Wake,
    /// Background jobs.
    pub jobs: Vec<Job<Done>>,
    /// Pending effects for the window.
    pub effects: Vec<Effect>,
    /// Displays: the first of the document or of side A of the run, then those of the other sides.
    pub displays: [DisplayWorker; MAX_SIDES],
    /// Finds the object under the cursor, once it is ready for the mesh of the document.
    pub picker: Option<(Arc<Mesh>, Arc<Picker>)>,
    /// The path of the last save.
    pub saved_to: Option<PathBuf>,
    /// Number of changes of the mesh.
    pub revision: u64,
    /// The mesh of the last save or of the opened file; `None` if it is stored nowhere, as after a
    /// recovery.
    pub saved_mesh: Option<Arc<Mesh>>,
    /// The action that continues after the running save.
    pub after_save: Option<AfterUnsaved>,
    /// The path that was typed last, until its file is read or written.
    pub typed_path: Option<PathPrompt>,
    /// Writes the recovery file.
    pub autosave: Autosave,
    /// The texture images of the document.
    pub textures: Arc<Textures>,
    /// Measures of the surface.
    pub report: Report,
    /// The picture renderer; `None` before the window has a device, and in tests without one.
    pub gpu: Option<Arc<Gpu>>,
    /// The mesh of the last request for a picker.
    pub(crate) picker_asked: Option<Arc<Mesh>>,
    /// Edges of the rims that the run joins with a crease.
    pub(crate) creases: Cached<CreaseKey, Arc<Vec<[VertexId; 2]>>>,
    /// Energies of the displayed surfaces.
    pub(crate) energies: [ParsedEnergy; MAX_SIDES],
}

/// The key of the creases of a run.
#[derive(PartialEq)]
pub(crate) struct CreaseKey {
    /// The mesh of the run; `None` without creases.
    pub(crate) base: Option<SharedKey<Mesh>>,
    /// The loops joined with a crease.
    pub(crate) loops: Vec<LoopId>,
}

impl Model {
    /// The model of a document.
    pub fn new(document: Document, settings: Settings, autosave: Autosave, wake: Wake) -> Self {
        let style = ViewStyle {
            background: Background::of_theme(settings.dark),
            material: settings.material,
            ..ViewStyle::default()
        };
        let mut view = ViewState::new(&document.origin.bounds, style);
        view.camera.z_up = settings.z_up;
        view.camera.home();
        Self {
            view,
            history: History::default(),
            settings,
            run: None,
            rejected: None,
            log: Log::default(),
            jobs: Vec::new(),
            effects: Vec::new(),
            displays: std::array::from_fn(|_| DisplayWorker::new(&wake)),
            picker: None,
            saved_to: None,
            revision: 0,
            saved_mesh: Some(Arc::clone(&document.mesh)),
            after_save: None,
            typed_path: None,
            autosave,
            textures: Arc::default(),
            report: Report::default(),
            gpu: None,
            picker_asked: None,
            creases: Cached::default(),
            energies: Default::default(),
            document,
            wake,
        }
    }

    /// Starts a background job.
    pub fn spawn(
        &mut self,
        what: impl Into<String>,
        work: impl FnOnce(&Reporter) -> Done + Send + 'static,
    ) {
        self.jobs.push(Job::spawn(what, &self.wake, work));
    }

    /// What Undo undoes, in words.
    pub fn next_undo(&self) -> Option<&str> {
        let rejected = self.rejected.as_ref().filter(|_| self.run.is_none());
        if rejected.is_some_and(|rejected| rejected.is_of(&self.document)) {
            return Some(match rejected.map(|rejected| &rejected.run.operation) {
                Some(Operation::Refine(_)) => "reject the refinement",
                Some(Operation::Fair(_)) => "reject the fairing",
                _ => "reject the patch",
            });
        }
        self.history.next_undo()
    }

    /// Takes the rejected run if nothing has happened since.
    pub fn take_rejected(&mut self) -> Option<Run> {
        let rejected = self.rejected.take_if(|r| r.is_of(&self.document))?;
        Some(rejected.run)
    }

    /// Whether there are unsaved changes of the mesh. After an undo of all changes there are none.
    pub fn is_dirty(&self) -> bool {
        let saved = self.saved_mesh.as_ref();
        !saved.is_some_and(|saved| Arc::ptr_eq(saved, &self.document.mesh))
    }

    /// The name of the saved file, or else of the opened one.
    pub fn name(&self) -> String {
        let saved = self.saved_to.as_deref().map(file_name);
        saved.unwrap_or_else(|| self.document.origin.name())
    }

    /// Number of views side by side.
    pub fn sides(&self) -> usize {
        self.run.as_ref().map_or(1, |run| run.sides.len().max(1))
    }

    /// Whether vertices of the document's mesh are drawn at their limit positions instead of their
    /// own.
    pub fn draws_limit_of_mesh(&self) -> bool {
        self.view.limit_surface && self.document.surface.is_none()
    }

    /// The origin of drawn positions.
    pub fn centre(&self) -> DVec3 {
        self.document.origin.bounds.centre()
    }

    /// The state of the run that is being accepted.
    pub fn accepting(&mut self) -> Option<&mut Accepting> {
        self.run.as_mut()?.accepting.as_mut()
    }

    /// A loop of the run's mesh, or of the document.
    pub fn shown_loop(&self, id: LoopId) -> Option<&BoundaryLoop> {
        match self.erased_run() {
            Some(run) => run.loops.iter().find(|l| l.id == id),
            None => self.document.loop_of(id),
        }
    }

    /// The mesh that [`Self::shown_loop`] refers to.
    pub fn looped_mesh(&self) -> &Arc<Mesh> {
        let erased = self.erased_run();
        erased.map_or(&self.document.mesh, |run| &run.base)
    }

    /// The run, if its mesh is that of the document without some faces.
    fn erased_run(&self) -> Option<&Run> {
        self.run.as_ref().filter(|run| run.kept.is_some())
    }

    /// Whether the document has colours or texture images.
    pub fn has_colors(&self) -> bool {
        self.document.mesh.attributes.has_colors() || !self.textures.is_empty()
    }

    /// The available view modes.
    pub fn view_modes(&self) -> impl Iterator<Item = ViewMode> + use<> {
        let compared = self.report.reference.is_some();
        let colored = self.has_colors();
        let shown = move |mode: &ViewMode| match mode {
            ViewMode::Color => colored,
            ViewMode::Distance => compared,
            _ => true,
        };
        ViewMode::ALL.iter().copied().filter(shown)
    }

    /// The bounding box of the displayed surfaces.
    pub fn bounds(&self) -> Bounds {
        self.displays[0]
            .latest()
            .map_or(self.document.origin.bounds, |d| d.bounds)
    }

    /// Whether closing would lose work.
    pub fn must_ask_before_closing(&self) -> bool {
        self.is_dirty() || self.run.is_some()
    }

    /// The title of the window.
    pub fn title(&self) -> String {
        let star = if self.is_dirty() { "*" } else { "" };
        format!("{}{star} - Meniscus", elided(&self.name(), TITLE))
    }

    /// The path of the source, as the default for saving.
    pub fn source_path(&self) -> Option<PathBuf> {
        match &self.document.origin.source {
            Source::File(path) => Some(path.clone()),
            Source::Sample(_) | Source::Embedded => None,
        }
    }
}
