//! The viewport inside an egui window; the only place of the renderer that knows egui.

use std::sync::Arc;

use eframe::egui;

use super::{Camera, Scene, ViewStyle};

/// Draws a scene into a rectangle of the window.
#[derive(Clone)]
pub struct ViewportCallback {
    /// What to draw.
    pub scene: Arc<Scene>,
    /// From where.
    pub camera: Camera,
    /// How.
    pub style: ViewStyle,
    /// Which of several viewports side by side; each keeps its own target.
    pub slot: u32,
    /// Size of the rectangle in physical pixels.
    pub size_px: [u32; 2],
    /// Format of the window's surface, from eframe's `RenderState`.
    pub target_format: wgpu::TextureFormat,
}

impl ViewportCallback {
    /// As a shape for a painter.
    pub fn shape(self, rect: egui::Rect) -> egui::Shape {
        egui_wgpu::Callback::new_paint_callback(rect, self).into()
    }
}

impl egui_wgpu::CallbackTrait for ViewportCallback {
    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        _pass: &mut wgpu::RenderPass<'static>,
        _resources: &egui_wgpu::CallbackResources,
    ) {
    }
}
