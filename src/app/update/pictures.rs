//! Pictures and sequences of pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::asks_to_replace;
use super::files::NO_DIALOG;
use crate::app::action::PictureAction;
use crate::app::display::{Continued, DisplayWorker, Request};
use crate::app::jobs::Reporter;
use crate::app::model::{Done, Effect, Model};
use crate::app::run::RunState;
use crate::app::scene_builder;
use crate::app::view_state::{Modal, PictureKind, PictureSettings};
use crate::options::Choice as _;
use crate::render::{
    Camera, Gpu, MAX_SIDE, RenderError, Scene, SequenceEnd, SequenceFormat, Sheet, SheetView,
    ViewStyle, robust_range, save_png, sheet_picture, turntable, write_sequence,
};

/// The name of jobs that write pictures.
pub(crate) const WRITING: &str = "pictures";

pub(crate) fn update(model: &mut Model, action: PictureAction) {
    match action {
        PictureAction::Ask => model.view.modal = Modal::Picture(first_settings(model)),
        PictureAction::Browse => browse(model),
        PictureAction::Make(settings) => make(model, *settings),
        PictureAction::Copy => {
            let settings = PictureSettings {
                overlays: true,
                ..first_settings(model)
            };
            copy(model, settings);
        }
        PictureAction::CopyAs(settings) => {
            model.view.modal = Modal::None;
            copy(model, *settings);
        }
        PictureAction::Window => {
            // a question would be in the picture
            let mut path = path_beside_source(model, "window.png");
            let mut count = 1;
            while path.exists() {
                count += 1;
                path = path_beside_source(model, &format!("window-{count}.png"));
            }
            model.effects.push(Effect::WindowPicture(path));
        }
        PictureAction::Cancel => {
            cancel(model);
        }
    }
}

/// Cancels the writing of pictures. Returns whether there was one.
pub(super) fn cancel(model: &mut Model) -> bool {
    let before = model.jobs.len();
    model.jobs.retain(|job| !job.what.starts_with(WRITING));
    let is_cancelled = model.jobs.len() < before;
    if is_cancelled {
        model
            .log
            .info("the writing of pictures was cancelled; no new files are left");
    }
    is_cancelled
}

/// The initial settings of the picture dialog: the views as they are shown.
fn first_settings(model: &Model) -> PictureSettings {
    let [width, height] = model.view.viewport_px;
    let width = width * model.sides() as f64;
    PictureSettings {
        width: (width as u32).clamp(1, MAX_SIDE),
        height: (height as u32).clamp(1, MAX_SIDE),
        path: path_beside_source(model, "png").display().to_string(),
        ..PictureSettings::default()
    }
}

/// Opens the file dialog of the system for the file of the picture.
fn browse(model: &mut Model) {
    let Modal::Picture(settings) = &model.view.modal else {
        return;
    };
    let (path, extension) = (PathBuf::from(&settings.path), extension(settings));
    model.spawn("file dialog", move |_| {
        let asked = Instant::now();
        let mut dialog = rfd::FileDialog::new().add_filter("Pictures", &[extension]);
        if let Some(folder) = path.parent() {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = path.file_name() {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
        Done::PicturePath(dialog.save_file(), asked.elapsed())
    });
}

/// Takes the path that was chosen for the picture; `None` if the dialog was cancelled or is not
/// available.
pub(in crate::app) fn path_chosen(model: &mut Model, path: Option<PathBuf>, waited: Duration) {
    let Modal::Picture(settings) = &mut model.view.modal else {
        return;
    };
    match path {
        Some(path) => settings.path = path.display().to_string(),
        None if waited < NO_DIALOG => {
            let text = "the system has no file dialog: type the path of the picture";
            model.log.warning(text);
        }
        None => {}
    }
}

/// The extension of the file.
pub(crate) fn extension(settings: &PictureSettings) -> &'static str {
    match (settings.kind, settings.format) {
        (PictureKind::Still, _) | (_, SequenceFormat::Apng) => SequenceFormat::Png.name(),
        (_, format) => format.name(),
    }
}

/// The path of the opened file with another extension.
fn path_beside_source(model: &Model, extension: &str) -> PathBuf {
    let source = model.source_path();
    source
        .unwrap_or_else(|| "meniscus.obj".into())
        .with_extension(extension)
}

fn gpu(model: &mut Model) -> Option<Arc<Gpu>> {
    if model.gpu.is_none() {
        match Gpu::new() {
            Ok(gpu) => model.gpu = Some(Arc::new(gpu)),
            Err(error) => model.log.error(error.to_string()),
        }
    }
    model.gpu.clone()
}

/// What is drawn of the views, and how. `None` if there is no graphics device; the reason was reported.
fn job(model: &mut Model, settings: PictureSettings) -> Option<(PictureJob, Vec<Scene>)> {
    let gpu = gpu(model)?;
    let sides = if settings.all_sides { model.sides() } else { 1 };
    let scenes: Vec<Scene> = (0..sides)
        .map(|side| {
            let mut scene = scene_builder::scene(model, side);
            if let (false, Some(display)) = (settings.overlays, model.displays[side].latest()) {
                // remove the selected faces, which come last
                scene.surfaces.truncate(display.surfaces.len());
            }
            scene
        })
        .collect();
    let run = model.run.as_ref().filter(|_| sides > 1);
    let titles = (0..sides).map(|side| run.map_or_else(String::new, |run| run.title(side)));
    let scale = settings.height as f32 / model.view.viewport_px[1].max(1.0) as f32;
    let mut style = ViewStyle {
        show_overlays: settings.overlays,
        line_scale: model.view.style.line_scale * scale.max(0.25),
        ..model.view.style
    };
    let surfaces: Vec<_> = scenes.iter().flat_map(|s| s.surfaces.clone()).collect();
    if style.mode.is_map() && style.range.is_none() {
        // one range for all sides and all pictures of a sequence
        style.range = Some(robust_range(&surfaces, style.mode));
    }
    let sheet = Sheet {
        size: [settings.width, settings.height],
        transparent: settings.transparent,
        legend: settings.legend,
        caption: settings.caption.trim().to_owned(),
    };
    // what the view shows is in the picture, also beside a legend
    let mut camera = model.view.camera;
    let aspect = |[width, height]: [f64; 2]| width / height.max(1.0);
    let size = sheet.view_size(&surfaces, &style, sides);
    camera.keep_width(aspect(model.view.viewport_px), aspect(size.map(f64::from)));
    let job = PictureJob {
        gpu,
        camera,
        style,
        sheet,
        titles: titles.collect(),
        settings,
    };
    Some((job, scenes))
}

fn copy(model: &mut Model, settings: PictureSettings) {
    let Some((job, scenes)) = job(model, settings) else {
        return;
    };
    model.spawn("picture", move |_| {
        let result = job.one(&scenes, &job.camera);
        Done::Picture(result.map(Arc::new).map_err(|e| e.to_string()))
    });
}

fn make(model: &mut Model, mut settings: PictureSettings) {
    if settings.path.trim().is_empty() {
        model.log.error("enter a file name for the picture");
        return;
    }
    let wanted = extension(&settings);
    let mut path = PathBuf::from(settings.path.trim());
    // the content is in this format whatever the name
    if !path
        .extension()
        .is_some_and(|own| own.eq_ignore_ascii_case(wanted))
    {
        path.as_mut_os_string().push(format!(".{wanted}"));
    }
    settings.path = path.display().to_string();
    let flow = settings.kind == PictureKind::Flow;
    if flow && model.run.is_none() {
        model.log.warning(
            "there is no flow: fill a hole and write the pictures before you accept the patch",
        );
        return;
    }
    let file = match settings.kind {
        PictureKind::Still => path,
        PictureKind::Turntable | PictureKind::Flow => settings.format.first_file(&path),
    };
    let writing = PictureAction::Make(Box::new(settings.clone()));
    if asks_to_replace(model, &file, writing) {
        return;
    }
    let Some((job, scenes)) = job(model, settings) else {
        // the dialog, instead of the question
        if let Modal::Replace(asked) = std::mem::take(&mut model.view.modal) {
            model.view.modal = asked.named_in;
        }
        return;
    };
    let sides = model.run.iter().flat_map(|run| &run.sides);
    let states: Vec<_> = sides
        .take(scenes.len())
        .map(|s| s.handle.states())
        .collect();
    let displays = model.displays.iter().take(scenes.len());
    let requests: Vec<Request> = displays.filter_map(|d| d.requested().cloned()).collect();
    model.view.modal = Modal::None;
    let what = format!("{WRITING}: {}", job.settings.path);
    model.spawn(what, move |reporter| {
        let result = match job.settings.kind {
            PictureKind::Still => job.still(&scenes, reporter),
            PictureKind::Turntable => job.turntable(&scenes, reporter),
            PictureKind::Flow => job.flow(&scenes, &requests, &states, reporter),
        };
        Done::Pictures(result.map_err(|e| e.to_string()), Box::new(job.settings))
    });
}

/// Receives the message about written pictures, or why they could not be written. The dialog then opens
/// again with its settings.
pub(super) fn written(
    model: &mut Model,
    result: Result<String, String>,
    settings: PictureSettings,
) {
    match result {
        Ok(text) => model.log.info(text),
        Err(text) => {
            model.log.error(text);
            if matches!(model.view.modal, Modal::None) {
                model.view.modal = Modal::Picture(settings);
            }
        }
    }
}

/// The state that picture `i` of `count` shows of `all`: the first and the last, and evenly spaced ones
/// between.
fn state_at(i: usize, count: usize, all: usize) -> usize {
    i * all.saturating_sub(1) / count.saturating_sub(1).max(1)
}

/// The data for drawing a picture in the background.
struct PictureJob {
    gpu: Arc<Gpu>,
    camera: Camera,
    style: ViewStyle,
    sheet: Sheet,
    titles: Vec<String>,
    settings: PictureSettings,
}

impl PictureJob {
    fn one(&self, scenes: &[Scene], camera: &Camera) -> Result<image::RgbaImage, RenderError> {
        let views: Vec<SheetView<'_>> = scenes
            .iter()
            .zip(&self.titles)
            .map(|(scene, title)| SheetView { scene, title })
            .collect();
        sheet_picture(&self.gpu, &self.sheet, &views, camera, &self.style)
    }

    fn still(&self, scenes: &[Scene], reporter: &Reporter) -> Result<String, RenderError> {
        let path = Path::new(&self.settings.path);
        let picture = self.one(scenes, &self.camera)?;
        if !reporter.is_wanted() {
            return Ok("the picture was cancelled".into());
        }
        save_png(path, &picture)?;
        Ok(format!("picture saved: {}", path.display()))
    }

    fn turntable(&self, scenes: &[Scene], reporter: &Reporter) -> Result<String, RenderError> {
        let count = self.settings.frames.max(1);
        self.sequence(count, reporter, |i| {
            self.one(scenes, &turntable(&self.camera, i, count))
        })
    }

    /// Pictures of stored states. `states` are those of each side; a shorter list stays at its last.
    fn flow(
        &self,
        scenes: &[Scene],
        requests: &[Request],
        states: &[Vec<RunState>],
        reporter: &Reporter,
    ) -> Result<String, RenderError> {
        let all = states.iter().map(Vec::len).max().unwrap_or(0);
        let count = match self.settings.states {
            0 => all,
            some => some.min(all),
        };
        let mut builders: Vec<_> = scenes.iter().map(|_| DisplayWorker::builder()).collect();
        self.sequence(count, reporter, |i| {
            let at = state_at(i, count, all);
            let sides = scenes.iter().zip(requests).zip(states).zip(&mut builders);
            let frames: Vec<Scene> = sides
                .map(|(((scene, request), states), build)| {
                    let continued = match request.continued {
                        Continued::No => Continued::No,
                        _ => Continued::WithTriangulation,
                    };
                    let display = build(&Request {
                        state: states.get(at).or(states.last()).cloned(),
                        continued,
                        ..request.clone()
                    });
                    Scene {
                        surfaces: display.surfaces,
                        ..scene.clone()
                    }
                })
                .collect();
            self.one(&frames, &self.camera)
        })
    }

    fn sequence(
        &self,
        count: usize,
        reporter: &Reporter,
        frames: impl FnMut(usize) -> Result<image::RgbaImage, RenderError>,
    ) -> Result<String, RenderError> {
        let s = &self.settings;
        let path = PathBuf::from(&s.path);
        let progress = |done, total| reporter.progress(done, total);
        Ok(
            match write_sequence(&path, s.format, frames, count, s.fps, &progress)? {
                SequenceEnd::Written(files) if files.len() == 1 => {
                    format!("{count} pictures saved: {}", files[0].display())
                }
                SequenceEnd::Written(files) => format!(
                    "{count} pictures saved: {} and following",
                    files
                        .first()
                        .map_or_else(String::new, |f| f.display().to_string())
                ),
                SequenceEnd::Cancelled => "the sequence was cancelled".into(),
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::state_at;

    #[test]
    fn sequences_begin_and_end_with_the_flow() {
        let shown =
            |count, all| -> Vec<usize> { (0..count).map(|i| state_at(i, count, all)).collect() };
        assert_eq!(shown(4, 4), [0, 1, 2, 3]);
        assert_eq!(shown(3, 9), [0, 4, 8]);
        assert_eq!(shown(1, 5), [0]);
    }
}
