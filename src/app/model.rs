//! Everything behind the window, without the window.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::action::Action;
use super::autosave::Autosave;
use super::display::{DisplayWorker, Request};
use super::document::{Document, Source};
use super::history::History;
use super::jobs::{Job, Wake};
use super::log::Log;
use super::project::Project;
use super::report::Report;
use super::run::Run;
use super::settings::Settings;
use super::view_state::{AfterUnsaved, Modal, PathUse, Task, ViewState};
use crate::energy::Energy;
use crate::fill::Continuity;
use crate::mesh::{LoopId, Mesh, VertexId};
use crate::render::{Bounds, Gpu, Picker, ViewStyle};

/// What only the window itself can do.
#[derive(Clone, Debug)]
pub enum Effect {
    /// Text to the clipboard.
    CopyText(String),
    /// Picture to the clipboard.
    CopyImage(Arc<image::RgbaImage>),
    /// Close, without asking.
    Close,
    /// Picture of the whole window, to this file.
    WindowPicture(PathBuf),
    /// Theme, scale.
    Appearance,
}

/// What a file gave.
pub enum Loaded {
    /// A mesh file or sample.
    Mesh(Box<Document>),
    /// A project or recovery file.
    Project(Box<Document>, Box<Project>),
}

/// Work that was done in the background.
pub enum Done {
    /// A file was read.
    Loaded(PathBuf, Result<Loaded, String>),
    /// A file was written.
    Saved(PathBuf, SavedWhat, Result<(), String>),
    /// Picking is ready for a mesh.
    Picker(Arc<Mesh>, Arc<Picker>),
    /// A lasso was closed around these faces.
    Caught(super::faces::FaceEdit),
    /// A dialog of the system was answered; `None`: cancelled or not there, after so long.
    Chosen(PathUse, Option<PathBuf>, Duration),
    /// A picture for the clipboard.
    Picture(Result<Arc<image::RgbaImage>, String>),
    /// Picture files were written: a message.
    Pictures(Result<String, String>),
}

/// What a written file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SavedWhat {
    /// The whole mesh, at this revision.
    Mesh(u64),
    /// The project, at this revision.
    Project(u64),
    /// The patches alone.
    Patch,
    /// A report.
    Report,
}

/// Views beside each other at most.
pub const MOST_SIDES: usize = 3;

/// All of it.
pub struct Model {
    /// The work.
    pub document: Document,
    /// Its other states.
    pub history: History<Document>,
    /// How it is looked at.
    pub view: ViewState,
    /// What is remembered from one session to the next.
    pub settings: Settings,
    /// A fill in progress, or done and waiting for accept or reject.
    pub run: Option<Run>,
    /// Messages.
    pub log: Log,
    /// Wakes the window.
    pub wake: Wake,
    /// Work in the background.
    pub jobs: Vec<Job<Done>>,
    /// What the window has to do.
    pub effects: Vec<Effect>,
    /// What is drawn: of the document or the first side, and of the others.
    pub displays: [DisplayWorker; MOST_SIDES],
    /// Answers what is under the cursor, once it is ready for the shown mesh.
    pub picker: Option<(Arc<Mesh>, Arc<Picker>)>,
    /// Where the document was saved last.
    pub saved_to: Option<PathBuf>,
    /// Counts changes of the mesh; compared with the saved one.
    pub revision: u64,
    /// Revision of the last save.
    pub saved_revision: u64,
    /// What is held up by unsaved changes while a save is under way.
    pub after_save: Option<AfterUnsaved>,
    /// Keeps a recovery file.
    pub autosave: Autosave,
    /// What was measured of the surface.
    pub report: Report,
    /// Draws pictures; `None` before the window has a device, and in tests without one.
    pub gpu: Option<Arc<Gpu>>,
    picker_wanted: Option<Arc<Mesh>>,
    creases: (Vec<LoopId>, Arc<Vec<[VertexId; 2]>>),
}

impl Model {
    /// Opens on a document.
    pub fn new(document: Document, settings: Settings, autosave: Autosave, wake: Wake) -> Self {
        let style = ViewStyle {
            background: crate::render::Background::of_theme(settings.dark),
            mode: crate::render::ViewMode::Isophotes,
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
            log: Log::default(),
            jobs: Vec::new(),
            effects: Vec::new(),
            displays: std::array::from_fn(|_| DisplayWorker::new(&wake)),
            picker: None,
            saved_to: None,
            revision: 0,
            saved_revision: 0,
            after_save: None,
            autosave,
            report: Report::default(),
            gpu: None,
            picker_wanted: None,
            creases: (Vec::new(), Arc::default()),
            document,
            wake,
        }
    }

    /// Whether there are changes that no file holds.
    pub fn is_dirty(&self) -> bool {
        self.revision != self.saved_revision
    }

    /// Whether a run waits to be accepted or rejected; the person is told to do that before `what`.
    pub fn is_busy(&mut self, what: &str) -> bool {
        let busy = self.run.is_some();
        if busy {
            let text = format!("accept or reject the patch before {what}");
            self.log.info(text);
        }
        busy
    }

    /// Puts another document in place of this one.
    pub fn replace(&mut self, document: Document) {
        self.run = None;
        // the camera must not be fitted to what was there before
        self.displays.iter_mut().for_each(DisplayWorker::forget);
        self.history = History::default();
        self.view.camera.home();
        self.view.camera.fit_to(&document.origin.bounds);
        self.view.fit = true;
        self.view.hover = None;
        self.view.report.forget();
        self.view.energy_text.clone_from(&document.controls.energy);
        self.view.compare_energy = None;
        self.document = document;
        self.saved_to = None;
        self.revision += 1;
        self.saved_revision = self.revision;
        self.autosave.discard();
        self.announce();
    }

    /// Says what was opened.
    fn announce(&mut self) {
        let document = &self.document;
        let report = &document.origin.report;
        let holes = document.holes().len();
        let noun = if holes == 1 { "hole" } else { "holes" };
        let mut text = format!(
            "{}: {} vertices, {} faces, {holes} {noun}",
            document.origin.name(),
            report.vertices,
            report.faces
        );
        if report.welded_vertices > 0 {
            let _ = write!(text, "; {} vertices merged", report.welded_vertices);
        }
        self.log.info(text);
        if !report.defects.is_empty() {
            self.log.warning(format!(
                "{} places were repaired or are unsound: see the load report (Ctrl+R)",
                report.defects.len()
            ));
        }
        for note in &report.notes {
            self.log.warning(note.clone());
        }
    }

    /// Looks after everything that goes on by itself. Returns when it wants to be called again
    /// although nothing wakes it.
    pub fn tick(&mut self, now: Instant) -> Option<Duration> {
        let mut soonest = self.log.next_change(now);
        let mut at = |wait: Option<Duration>| {
            if let Some(wait) = wait {
                soonest = Some(soonest.map_or(wait, |s| s.min(wait)));
            }
        };
        let mut i = 0;
        while i < self.jobs.len() {
            let Some(result) = self.jobs[i].poll() else {
                i += 1;
                continue;
            };
            self.jobs.remove(i);
            match result {
                Ok(done) => self.finish_job(done),
                Err(text) => self.log.error(text),
            }
        }
        if let Some(run) = &mut self.run {
            for (level, text) in run.poll() {
                self.log.note(level, text);
            }
            at(run.replay(self.view.pace, now));
        }
        self.refresh();
        super::update::tick_report(self);
        at(self.autosave.tick(
            now,
            self.revision,
            self.is_dirty(),
            &self.document,
            &self.view,
            &self.wake,
        ));
        for text in self.autosave.take_errors() {
            self.log.warning(text);
        }
        soonest
    }

    /// Asks for what has to be drawn and picked from now on.
    fn refresh(&mut self) {
        for display in &mut self.displays {
            display.poll();
        }
        let sides = self.run.as_ref().map_or(0, |r| r.sides.len());
        for i in 0..sides.max(1) {
            let request = self.request(i);
            self.displays[i].ask(request);
        }
        let mesh = Arc::clone(&self.document.mesh);
        let ready = self.picker.as_ref().map(|(m, _)| m);
        let has = |m: Option<&Arc<Mesh>>| m.is_some_and(|m| Arc::ptr_eq(m, &mesh));
        if !has(ready) && !has(self.picker_wanted.as_ref()) {
            self.picker_wanted = Some(Arc::clone(&mesh));
            let loops = Arc::clone(&self.document.loops);
            self.jobs.push(Job::spawn("picking", &self.wake, move |_| {
                let picker = Picker::new(&mesh.positions, &mesh.topology, &loops);
                Done::Picker(mesh, Arc::new(picker))
            }));
        }
    }

    fn request(&mut self, side: usize) -> Request {
        let creases = self.creases();
        let run = self.run.as_ref().and_then(|r| r.sides.get(side));
        let controls = run.map_or(&self.document.controls, |s| &s.controls);
        let rims = self.document.selected();
        let rims = rims.iter().map(|l| l.radius).fold(0.0, f64::max);
        let radius = run.map_or(rims, |side| side.live.radius());
        let state = run.and_then(super::run::Side::state);
        let energy = Energy::parse(&controls.energy, &controls.param).ok();
        let document = &self.document;
        let (mut mesh, mut first_patch_face) = (&document.mesh, document.first_patch_face);
        let mut faired = Arc::default();
        if let Some(run) = &self.run {
            (mesh, first_patch_face) = (&run.base, run.first_patch_face);
            faired = run.faired();
        }
        // what was accepted as a surface is drawn as that until there is another
        let is_there = Arc::ptr_eq(mesh, &document.mesh);
        let accepted = document.surface.clone().filter(|_| is_there);
        let state = state.or(accepted);
        let repairs = self.view.task == Task::Repair && self.run.is_none();
        Request {
            mesh: Arc::clone(mesh),
            faired,
            highlight: if repairs {
                Arc::clone(&self.document.faces)
            } else {
                Arc::default()
            },
            start: run
                .zip(state.as_ref())
                .and_then(|(side, at)| side.live.start_of(at)),
            state,
            first_patch_face,
            creases,
            limit: self.view.limit_surface,
            original: self.view.show_original,
            centre: self.centre(),
            bounds: self.document.origin.bounds,
            energy: energy.filter(|_| radius > 0.0).map(|e| (e, radius)),
            reference: self.report.shown_reference(self.view.style.mode),
        }
    }

    /// Whether vertices of the document's mesh are drawn where its limit surface passes them, rather
    /// than where they are.
    pub fn draws_limit_of_mesh(&self) -> bool {
        self.view.limit_surface && self.document.surface.is_none()
    }

    /// What drawn positions are relative to.
    pub fn centre(&self) -> crate::mesh::DVec3 {
        self.document.origin.bounds.centre()
    }

    /// Edges of the rims that are joined with a crease.
    fn creases(&mut self) -> Arc<Vec<[VertexId; 2]>> {
        let Some(run) = &self.run else {
            if !self.creases.0.is_empty() {
                self.creases = (Vec::new(), Arc::default());
            }
            return Arc::clone(&self.creases.1);
        };
        let Some(side) = run.sides.first() else {
            return Arc::clone(&self.creases.1);
        };
        let sharp: Vec<LoopId> = run
            .loops
            .iter()
            .map(|l| l.id)
            .filter(|&id| side.controls.continuity_at(id) == Continuity::G0)
            .collect();
        if sharp != self.creases.0 {
            let mut edges = Vec::new();
            for l in run.loops.iter().filter(|l| sharp.contains(&l.id)) {
                edges.extend(l.edge_ends());
            }
            self.creases = (sharp, Arc::new(edges));
        }
        Arc::clone(&self.creases.1)
    }

    /// The box of what is shown.
    pub fn bounds(&self) -> Bounds {
        self.displays[0]
            .latest()
            .map_or(self.document.origin.bounds, |d| d.bounds)
    }

    fn finish_job(&mut self, done: Done) {
        match done {
            Done::Loaded(path, result) => self.loaded(&path, result),
            Done::Saved(path, what, result) => self.saved(path, what, result),
            Done::Picker(mesh, picker) => {
                if Arc::ptr_eq(&mesh, &self.document.mesh) {
                    self.picker = Some((mesh, picker));
                }
            }
            Done::Caught(edit) => self.act(Action::Faces(edit)),
            Done::Chosen(purpose, path, waited) => self.chosen(purpose, path, waited),
            Done::Picture(Ok(picture)) => {
                self.effects.push(Effect::CopyImage(picture));
                self.log.info("picture copied to the clipboard");
            }
            Done::Pictures(Ok(text)) => self.log.info(text),
            Done::Picture(Err(text)) | Done::Pictures(Err(text)) => self.log.error(text),
        }
    }

    /// Changes the selection, as an undo entry.
    pub fn select(&mut self, selection: std::collections::BTreeSet<LoopId>, label: &str) {
        if selection != self.document.selection {
            self.history.record(&self.document, label, None);
            self.document.selection = selection;
        }
    }

    /// Opens a dialog.
    pub fn ask_path(&mut self, purpose: PathUse, text: String) {
        self.view.modal = Modal::Path(super::view_state::PathPrompt { purpose, text });
    }

    /// Carries out an action and all that follows from it.
    pub fn act(&mut self, action: Action) {
        super::update::update(self, action);
    }

    /// Whether closing would lose something.
    pub fn must_ask_before_closing(&self) -> bool {
        self.is_dirty() || self.run.is_some()
    }

    /// Title of the window.
    pub fn title(&self) -> String {
        let star = if self.is_dirty() { "*" } else { "" };
        format!("{}{star} - Meniscus", self.document.origin.name())
    }

    /// The source's path, for the first guess of where to save.
    pub fn source_path(&self) -> Option<PathBuf> {
        match &self.document.origin.source {
            Source::File(path) => Some(path.clone()),
            Source::Sample(_) | Source::Embedded => None,
        }
    }
}
