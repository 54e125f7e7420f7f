//! The viewport inside an egui window. Only this file of the renderer uses egui.

use std::sync::Arc;

use eframe::egui;
use egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor};

use super::gpu::Renderer;
use super::{Camera, Scene, ViewStyle};

/// Draws a scene into a rectangle of the window.
///
/// The renderer is created when the first callback is painted, so the graphics card is not used
/// before.
#[derive(Clone)]
pub struct ViewportCallback {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The camera.
    pub camera: Camera,
    /// The style.
    pub style: ViewStyle,
    /// Index of the viewport. Each viewport has its own target.
    pub slot: u32,
    /// Size of the rectangle in physical pixels.
    pub size_px: [u32; 2],
    /// Format of the window's surface, from eframe's `RenderState`.
    pub target_format: wgpu::TextureFormat,
}

/// Data kept between frames.
struct Kept {
    renderer: Renderer,
    format: wgpu::TextureFormat,
    trouble: Option<String>,
}

impl ViewportCallback {
    /// The shape for a painter. The rectangle is in points.
    pub fn shape(self, rect: egui::Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect, self).into()
    }

    /// Why the last frame could not be drawn, such as a surface too large for the graphics card.
    /// Taken from the resources of egui's renderer.
    pub fn trouble(resources: &CallbackResources) -> Option<&str> {
        resources.get::<Kept>()?.trouble.as_deref()
    }
}

impl CallbackTrait for ViewportCallback {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let fits = |kept: &Kept| kept.format == self.target_format;
        if !resources.get::<Kept>().is_some_and(fits) {
            resources.insert(Kept {
                renderer: Renderer::new(device, queue, self.target_format),
                format: self.target_format,
                trouble: None,
            });
        }
        if let Some(kept) = resources.get_mut::<Kept>() {
            let drawn = kept.renderer.prepare(
                device,
                queue,
                self.slot,
                self.size_px,
                &self.scene,
                &self.camera,
                &self.style,
            );
            kept.trouble = drawn.err().map(|e| e.to_string());
        }
        Vec::new()
    }

    fn paint(
        &self,
        info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(kept) = resources.get::<Kept>() else {
            return;
        };
        // egui clips the viewport to the window; the picture must not move
        let scale = info.pixels_per_point;
        let (corner, size) = (info.viewport.min, info.viewport.size());
        pass.set_viewport(
            (corner.x * scale).round(),
            (corner.y * scale).round(),
            (size.x * scale).round().max(1.0),
            (size.y * scale).round().max(1.0),
            0.0,
            1.0,
        );
        kept.renderer.paint(pass, self.slot);
    }
}
