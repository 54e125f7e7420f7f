//! The window.
//!
//! A [`Model`] contains the document, the view and the run. Panels are functions of the model that
//! collect [`Action`]s. [`act`] executes actions, and [`tick`] advances background work. Only this
//! file and `ui` need a window.

mod action;
mod autosave;
mod cached;
mod chains;
mod display;
mod document;
mod faces;
mod history;
mod jobs;
mod log;
mod model;
mod project;
mod repeat;
mod report;
mod run;
mod scene_builder;
mod seam;
mod settings;
mod shortcuts;
#[cfg(test)]
mod tests;
mod ui;
mod update;
mod view_state;

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

use eframe::egui;

pub use action::{
    Action, ControlsAction, EditAction, FileAction, PictureAction, RunAction, SelectAction,
    SelectHow, Switch, TaskAction, ViewAction,
};
pub use autosave::Autosave;
pub use document::{AppliedOperation, Document, Source};
pub use faces::{BrushStamp, FaceEdit, Lasso};
pub use model::{Effect, Model};
pub use project::rewrite_project;
pub use run::Run;
pub use settings::Settings;
pub use update::{act, tick};
pub use view_state::{Modal, Navigation, Part, Refining, Selecting, Task, Tool};

use crate::render::{Gpu, ViewportCallback};
use crate::runner::panic_text;
use crate::shapes::SAMPLES;
use jobs::Wake;
use ui::UiState;

/// Why the window cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// Neither X11 nor Wayland is available.
    #[error(
        "no display: {0}. Start the program in a desktop session or on a virtual display \
         (`xvfb-run meniscus`); on Debian or Ubuntu a window needs libx11-6 libxcursor1 libxi6 \
         libxrandr2 libxkbcommon-x11-0; `meniscus fill` and `meniscus render` need no window"
    )]
    NoDisplay(String),
    /// A system library is missing.
    #[error(
        "a system library is missing: {0}. On Debian or Ubuntu: apt install libx11-6 libxcursor1 \
         libxi6 libxrandr2 libxkbcommon-x11-0"
    )]
    NoLibrary(String),
    /// No graphics adapter.
    #[error(
        "no usable graphics adapter: {0}. Install a driver; without a graphics card, a software \
         driver is enough. On Debian or Ubuntu: apt install libvulkan1 mesa-vulkan-drivers libegl1 \
         libgl1-mesa-dri"
    )]
    NoAdapter(String),
    /// A panic.
    #[error("internal error: {0}. The next start offers to recover unsaved work")]
    Defect(String),
}

/// The arguments of the window.
#[derive(Clone, Debug, Default)]
pub struct Startup {
    /// A mesh or project to open; the default is the first sample.
    pub file: Option<PathBuf>,
    /// The JSON file for frame times and memory, written when the window closes.
    pub diagnostics: Option<PathBuf>,
}

/// The application that eframe runs.
pub struct App {
    /// The state of the application.
    pub model: Model,
    ui: UiState,
    format: Option<wgpu::TextureFormat>,
    diagnostics: Option<PathBuf>,
    title: String,
    trouble: Option<String>,
    appearance: Option<Appearance>,
    window_pictures: (Sender<WindowPicture>, Receiver<WindowPicture>),
}

/// The settings that affect the look of the whole window.
#[derive(Clone, Copy, PartialEq)]
struct Appearance {
    scale: f32,
    dark: bool,
}

/// The path for a picture of the window, and the picture.
type WindowPicture = (PathBuf, Arc<egui::ColorImage>);

impl App {
    /// The application of a model. `render_state` is that of the window.
    pub fn new(
        model: Model,
        ctx: &egui::Context,
        render_state: Option<&egui_wgpu::RenderState>,
    ) -> Self {
        let mut app = Self {
            model,
            ui: UiState::default(),
            format: None,
            diagnostics: None,
            title: String::new(),
            trouble: None,
            appearance: None,
            window_pictures: channel(),
        };
        if let Some(state) = render_state {
            let (device, queue) = (state.device.clone(), state.queue.clone());
            app.model.gpu = Some(Arc::new(Gpu::from_device(device, queue)));
            app.format = Some(state.target_format);
            let info = state.adapter.get_info();
            app.ui.adapter = format!("{} ({:?})", info.name, info.backend);
        }
        ui::theme::install(ctx);
        app.apply_theme(ctx);
        app
    }

    /// Applies theme and scale.
    fn apply_theme(&mut self, ctx: &egui::Context) {
        let settings = &self.model.settings;
        let appearance = Appearance {
            scale: settings.ui_scale,
            dark: settings.dark,
        };
        if self.appearance != Some(appearance) {
            self.appearance = Some(appearance);
            ctx.set_theme(if settings.dark {
                egui::Theme::Dark
            } else {
                egui::Theme::Light
            });
            ctx.set_zoom_factor(settings.ui_scale);
        }
    }

    fn carry_out(&mut self, ctx: &egui::Context) {
        for effect in std::mem::take(&mut self.model.effects) {
            match effect {
                Effect::CopyText(text) => ctx.copy_text(text),
                Effect::CopyImage(picture) => {
                    let size = [picture.width() as usize, picture.height() as usize];
                    let image = egui::ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
                    ctx.copy_image(image);
                }
                Effect::Close => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
                Effect::WindowPicture(path) => {
                    let (sender, wake) = (self.window_pictures.0.clone(), ctx.clone());
                    ctx.request_screenshot(move |picture| {
                        sender.send((path, picture)).ok();
                        wake.request_repaint();
                    });
                }
                Effect::Appearance => self.apply_theme(ctx),
            }
        }
    }

    /// Saves a picture of the window, which arrives some frames after the request.
    fn take_window_picture(&mut self) {
        let Ok((path, shot)) = self.window_pictures.1.try_recv() else {
            return;
        };
        let [width, height] = shot.size.map(|n| n as u32);
        let bytes: Vec<u8> = shot
            .pixels
            .iter()
            .flat_map(egui::Color32::to_array)
            .collect();
        let saved = image::RgbaImage::from_raw(width, height, bytes)
            .ok_or_else(|| "the window returned no picture".to_owned())
            .and_then(|p| crate::render::save_png(&path, &p).map_err(|e| e.to_string()));
        match saved {
            Ok(()) => self
                .model
                .log
                .info(format!("picture saved: {}", path.display())),
            Err(text) => self.model.log.error(text),
        }
    }

    /// Stores the size of the window and of its panels.
    fn remember_layout(&mut self) {
        let settings = &mut self.model.settings;
        let sizes = &self.ui.sizes;
        let layout = &mut settings.layout;
        layout.window = self.model.view.window.map(|x| x * settings.ui_scale);
        layout.left_width = sizes.left_width.or(layout.left_width);
        layout.right_width = sizes.right_width.or(layout.right_width);
        layout.bottom_height = sizes.bottom_height.or(layout.bottom_height);
        settings.save();
    }

    fn write_diagnostics(&self) {
        let Some(path) = &self.diagnostics else {
            return;
        };
        let f = &self.ui.frames;
        let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
        let text = serde_json::json!({
            "adapter": self.ui.adapter,
            "first_frame_ms": f.first.map(ms),
            "frames": f.count,
            "longest_frame_ms": ms(f.longest),
            "mean_frame_ms": ms(f.total) / f.count.max(1) as f64,
            "peak_memory_bytes": crate::memory::peak_memory(),
        });
        if let Err(error) = crate::io::save_text(path, &format!("{text:#}\n")) {
            let _ = writeln!(std::io::stderr(), "meniscus: {error}");
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let begun = Instant::now();
        let trouble = frame.wgpu_render_state().and_then(|state| {
            let renderer = state.renderer.read();
            ViewportCallback::trouble(&renderer.callback_resources).map(str::to_owned)
        });
        if trouble != self.trouble {
            if let Some(text) = &trouble {
                self.model.log.error(text.clone());
            }
            self.trouble = trouble;
        }
        let ctx = ui.ctx().clone();
        if ctx.input(|i| i.viewport().close_requested()) && self.model.must_ask_before_closing() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            act(&mut self.model, FileAction::Close);
            ctx.request_repaint();
        }
        self.take_window_picture();
        let wait = tick(&mut self.model, begun);
        // views that an action of this frame splits have their size in the next frame
        let fits = self.model.view.fit;
        let actions = ui::window_ui(ui, &self.model, &mut self.ui, self.format);
        let acted = !actions.is_empty();
        for action in actions {
            act(&mut self.model, action);
        }
        self.model.view.window = ctx.content_rect().size().into();
        let rect = self.ui.viewport;
        let points = ctx.pixels_per_point();
        self.model.view.pixels_per_point = f64::from(points);
        self.model.view.viewport_px = [
            f64::from(rect.width() * points),
            f64::from(rect.height() * points),
        ];
        if fits && rect.is_positive() && self.ui.frames.count > 0 {
            self.model.view.fit = false;
            act(&mut self.model, ViewAction::FitAll);
            ctx.request_repaint();
        }
        self.carry_out(&ctx);
        let title = self.model.title();
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if acted {
            // the next frame shows the effects
            ctx.request_repaint();
        } else if let Some(wait) = wait {
            ctx.request_repaint_after(wait);
        }
        self.ui.frames.record(begun.elapsed());
    }

    fn on_exit(&mut self) {
        self.remember_layout();
        self.model.run = None;
        self.model.autosave.discard();
        self.write_diagnostics();
    }
}

/// Why there is no display, in words. The message of winit contains source locations, which are
/// removed.
fn no_display(error: &eframe::Error) -> String {
    let named = |name: &str| std::env::var(name).ok().filter(|v| !v.is_empty());
    match (named("WAYLAND_DISPLAY"), named("DISPLAY")) {
        (None, None) => "neither DISPLAY nor WAYLAND_DISPLAY is set".into(),
        (Some(name), _) | (None, Some(name)) => match error {
            eframe::Error::WinitEventLoop(inner) => {
                let text = inner.to_string();
                // the part after the source location
                let reason = text.split(".rs:").last().unwrap_or(&text);
                let reason = reason.split_once(": ").map_or(reason, |(_, rest)| rest);
                format!("the display {name} is not available ({reason})")
            }
            other => other.to_string(),
        },
    }
}

/// The icon of the program; an empty one if it cannot be decoded.
fn icon() -> egui::IconData {
    image::load_from_memory(ui::theme::ICON).map_or_else(
        |_| egui::IconData::default(),
        |icon| egui::IconData {
            width: icon.width(),
            height: icon.height(),
            rgba: icon.into_rgba8().into_raw(),
        },
    )
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// There is no display or no graphics adapter, or a library is missing.
pub fn run(startup: Startup) -> Result<(), WindowError> {
    let started = Instant::now();
    let (settings, message) = Settings::load();
    let folder = settings::state_folder().map(|f| f.join("recovery"));
    let left = folder
        .as_deref()
        .map_or_else(Vec::new, autosave::left_behind);
    let autosave = folder
        .as_deref()
        .map_or_else(Autosave::off, Autosave::in_folder);
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Meniscus")
            .with_app_id("meniscus")
            .with_inner_size(settings.layout.window)
            .with_icon(icon())
            .with_min_inner_size([760.0, 480.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        ..Default::default()
    };
    let diagnostics = startup.diagnostics.clone();
    let began = Arc::new(AtomicBool::new(false));
    let begins = Arc::clone(&began);
    let opened = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        eframe::run_native(
            "Meniscus",
            options,
            Box::new(move |cc| {
                begins.store(true, Ordering::Relaxed);
                let ctx = cc.egui_ctx.clone();
                let wake: Wake = Arc::new(move || ctx.request_repaint());
                let mut model = Model::new(Document::blank(), settings, autosave, wake);
                if let Some(text) = message {
                    model.log.warning(text);
                }
                if !left.is_empty() {
                    model.view.modal = Modal::Recover(left);
                }
                // the mesh is loaded while the window opens
                let first = match startup.file {
                    Some(file) => FileAction::Open(file),
                    None => FileAction::Sample(SAMPLES[0].name.into()),
                };
                act(&mut model, first);
                let mut app = App::new(model, &cc.egui_ctx, cc.wgpu_render_state.as_ref());
                app.diagnostics = diagnostics;
                app.ui.frames.started = started;
                Ok(Box::new(app))
            }),
        )
    }));
    match opened {
        Ok(Ok(())) => Ok(()),
        Ok(Err(eframe::Error::Wgpu(error))) => Err(WindowError::NoAdapter(error.to_string())),
        Ok(Err(error)) => Err(WindowError::NoDisplay(no_display(&error))),
        Err(panic) => {
            let text = panic_text(panic.as_ref());
            // winit panics if a library of X11 cannot be loaded
            Err(if began.load(Ordering::Relaxed) {
                WindowError::Defect(text)
            } else {
                WindowError::NoLibrary(text)
            })
        }
    }
}
