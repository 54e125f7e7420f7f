//! Pictures and sequences of pictures.

use std::path::PathBuf;
use std::sync::Arc;

use crate::app::action::PictureAction;
use crate::app::display::{DisplayWorker, Request};
use crate::app::jobs::Reporter;
use crate::app::model::{Done, Effect, Model};
use crate::app::run::RunState;
use crate::app::scene_builder;
use crate::app::view_state::{Modal, PictureKind, PictureSettings};
use crate::render::{
    Camera, Gpu, MAX_SIDE, RenderError, Scene, SequenceEnd, ViewStyle, picture, save_png,
    turntable, write_sequence,
};

/// The name of jobs that write pictures.
pub(crate) const WRITING: &str = "pictures";

pub(crate) fn update(model: &mut Model, action: PictureAction) {
    match action {
        PictureAction::Ask => model.view.modal = Modal::Picture(first_settings(model)),
        PictureAction::Make(settings) => make(model, &settings),
        PictureAction::Copy => copy(model),
        PictureAction::Window => {
            let path = path_beside_source(model, "window.png");
            model.effects.push(Effect::WindowPicture(path));
        }
        PictureAction::Cancel => {
            model.jobs.retain(|job| !job.what.starts_with(WRITING));
            model
                .log
                .info("the sequence was cancelled; its files were removed");
        }
    }
}

/// The initial settings of the picture dialog.
fn first_settings(model: &Model) -> PictureSettings {
    let [width, height] = model.view.viewport_px;
    PictureSettings {
        width: (width as u32).clamp(1, MAX_SIDE),
        height: (height as u32).clamp(1, MAX_SIDE),
        path: path_beside_source(model, "png").display().to_string(),
        ..PictureSettings::default()
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

fn style_for(model: &Model, settings: &PictureSettings) -> ViewStyle {
    let scale = settings.height as f32 / model.view.viewport_px[1].max(1.0) as f32;
    ViewStyle {
        show_overlays: settings.overlays,
        line_scale: model.view.style.line_scale * scale.max(0.25),
        ..model.view.style
    }
}

fn copy(model: &mut Model) {
    let Some(gpu) = gpu(model) else { return };
    let [width, height] = model.view.viewport_px.map(|x| (x.max(1.0) as u32).max(1));
    let scene = scene_builder::scene(model, 0);
    let (camera, style) = (model.view.camera, model.view.style);
    model.spawn("picture", move |_| {
        let result = picture(&gpu, &scene, &camera, &style, width, height, false);
        Done::Picture(result.map(Arc::new).map_err(|e| e.to_string()))
    });
}

fn make(model: &mut Model, settings: &PictureSettings) {
    if settings.path.trim().is_empty() {
        model.log.error("enter a file name for the picture");
        return;
    }
    let Some(gpu) = gpu(model) else { return };
    let job = PictureJob {
        gpu,
        camera: model.view.camera,
        style: style_for(model, settings),
        settings: settings.clone(),
    };
    let mut scene = scene_builder::scene(model, 0);
    if let (false, Some(display)) = (settings.overlays, model.displays[0].latest()) {
        // remove the selected faces, which come last
        scene.surfaces.truncate(display.surfaces.len());
    }
    let states = match (settings.kind, &model.run) {
        (PictureKind::Flow, Some(run)) => run.sides[0].handle.states(),
        (PictureKind::Flow, None) => {
            model.log.warning(
                "there is no flow: fill a hole and write the pictures before you accept \
                          the patch",
            );
            return;
        }
        _ => Vec::new(),
    };
    let request = model.displays[0].asked().cloned();
    model.view.modal = Modal::None;
    let what = format!("{WRITING}: {}", settings.path);
    model.spawn(what, move |reporter| {
        let result = match job.settings.kind {
            PictureKind::Still => job.still(&scene),
            PictureKind::Turntable => job.turntable(&scene, reporter),
            PictureKind::Flow => job.flow(&scene, request, &states, reporter),
        };
        Done::Pictures(result.map_err(|e| e.to_string()))
    });
}

/// The data for drawing a picture in the background.
struct PictureJob {
    gpu: Arc<Gpu>,
    camera: Camera,
    style: ViewStyle,
    settings: PictureSettings,
}

impl PictureJob {
    fn one(&self, scene: &Scene, camera: &Camera) -> Result<image::RgbaImage, RenderError> {
        let s = &self.settings;
        picture(
            &self.gpu,
            scene,
            camera,
            &self.style,
            s.width,
            s.height,
            s.transparent,
        )
    }

    fn still(&self, scene: &Scene) -> Result<String, RenderError> {
        let path = PathBuf::from(&self.settings.path);
        save_png(&path, &self.one(scene, &self.camera)?)?;
        Ok(format!("picture saved: {}", path.display()))
    }

    fn turntable(&self, scene: &Scene, reporter: &Reporter) -> Result<String, RenderError> {
        let count = self.settings.frames.max(1);
        self.sequence(count, reporter, |i| {
            self.one(scene, &turntable(&self.camera, i, count))
        })
    }

    fn flow(
        &self,
        scene: &Scene,
        request: Option<Request>,
        states: &[RunState],
        reporter: &Reporter,
    ) -> Result<String, RenderError> {
        let Some(request) = request else {
            return self.still(scene);
        };
        let mut build = DisplayWorker::builder();
        self.sequence(states.len(), reporter, |i| {
            let display = build(&Request {
                state: Some(states[i].clone()),
                ..request.clone()
            });
            let frame = Scene {
                surfaces: display.surfaces,
                ..scene.clone()
            };
            self.one(&frame, &self.camera)
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
