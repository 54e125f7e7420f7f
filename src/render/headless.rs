//! Pictures without a window.

use std::sync::{Mutex, PoisonError};

use super::gpu::{Renderer, Tile};
use super::{Background, Camera, RenderError, Scene, ViewStyle};

/// Maximum side of a picture in pixels.
pub const MAX_SIDE: u32 = 8192;
/// Maximum side of the tiles of a picture in pixels. Four samples of colour and depth for 8192 ×
/// 8192 pixels would need 2 GiB.
const TILE: u32 = 2048;
/// Alignment of rows in a buffer to which a texture is copied, in bytes.
const ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// A graphics device for pictures, with its pipelines.
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    renderer: Mutex<Renderer>,
}

impl Gpu {
    /// Finds an adapter and opens it. A software adapter is the last choice.
    ///
    /// # Errors
    /// There is no adapter, or it cannot be used.
    pub fn new() -> Result<Self, RenderError> {
        pollster::block_on(open())
    }

    /// Uses an open device, such as that of the window.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let renderer = Mutex::new(Renderer::new(
            &device,
            &queue,
            wgpu::TextureFormat::Rgba8Unorm,
        ));
        Self {
            device,
            queue,
            renderer,
        }
    }
}

async fn open() -> Result<Gpu, RenderError> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance
        .request_adapter(&wgpu::RequestAdapterOptions::default())
        .await
        .map_err(|e| RenderError::NoAdapter {
            reason: e.to_string(),
        })?;
    let limits = adapter.limits();
    let device = wgpu::DeviceDescriptor {
        label: Some("meniscus"),
        required_limits: wgpu::Limits {
            max_buffer_size: limits.max_buffer_size,
            ..wgpu::Limits::downlevel_webgl2_defaults().using_resolution(limits)
        },
        ..wgpu::DeviceDescriptor::default()
    };
    let (device, queue) =
        adapter
            .request_device(&device)
            .await
            .map_err(|e| RenderError::NoDevice {
                adapter: adapter.get_info().name,
                reason: e.to_string(),
            })?;
    Ok(Gpu::from_device(device, queue))
}

/// Refuses pictures without pixels and those that no device can draw.
pub(super) fn check_size([width, height]: [u32; 2]) -> Result<(), RenderError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        return Ok(());
    }
    Err(RenderError::Size {
        width,
        height,
        most: MAX_SIDE,
    })
}

/// Draws a scene into a picture of this width and height in pixels. `transparent` replaces the
/// background of the style. Colours are not premultiplied.
///
/// # Errors
/// The size is out of range, the scene is too large, or the device fails.
pub fn picture(
    gpu: &Gpu,
    scene: &Scene,
    camera: &Camera,
    style: &ViewStyle,
    [width, height]: [u32; 2],
    transparent: bool,
) -> Result<image::RgbaImage, RenderError> {
    check_size([width, height])?;
    let mut style = *style;
    if transparent {
        style.background = Background::Transparent;
    }
    // after a panic the picture may be outdated; it is drawn again
    let mut renderer = gpu.renderer.lock().unwrap_or_else(PoisonError::into_inner);
    let step = TILE.min(gpu.device.limits().max_texture_dimension_2d);
    let mut image = image::RgbaImage::new(width, height);
    for y in (0..height).step_by(step as usize) {
        for x in (0..width).step_by(step as usize) {
            let tile = Tile {
                corner: [x, y],
                size: [step.min(width - x), step.min(height - y)],
            };
            let memory = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
            let validity = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
            let (device, queue) = (&gpu.device, &gpu.queue);
            let drawn = renderer.draw(
                device,
                queue,
                0,
                [width, height],
                tile,
                scene,
                camera,
                &style,
            );
            let invalid = pollster::block_on(validity.pop());
            if let Some(error) = pollster::block_on(memory.pop()).or(invalid) {
                return Err(RenderError::Device {
                    reason: error.to_string(),
                });
            }
            drawn?;
            if let Some(texture) = renderer.picture(0) {
                copy_tile(gpu, texture, tile, &mut image)?;
            }
        }
    }
    Ok(image)
}

/// Copies a texture into its tile of a picture.
fn copy_tile(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    tile: Tile,
    image: &mut image::RgbaImage,
) -> Result<(), RenderError> {
    let failed = |reason: String| RenderError::Device { reason };
    let [width, height] = tile.size;
    let row = (4 * width).next_multiple_of(ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("meniscus picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
    );
    gpu.queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // sending fails if the poll below failed, which is reported there
        sender.send(result).ok();
    });
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|e| failed(e.to_string()))?;
    receiver
        .recv()
        .map_err(|e| failed(e.to_string()))?
        .map_err(|e| failed(e.to_string()))?;
    let bytes = buffer
        .get_mapped_range(..)
        .map_err(|e| failed(e.to_string()))?;
    let [x0, y0] = tile.corner;
    for (y, line) in (0..height).zip(bytes.chunks_exact(row as usize)) {
        for (x, pixel) in (0..width).zip(line.chunks_exact(4)) {
            let premultiplied = [pixel[0], pixel[1], pixel[2], pixel[3]];
            image.put_pixel(x0 + x, y0 + y, image::Rgba(straight(premultiplied)));
        }
    }
    Ok(())
}

/// Divides the colours by the opacity.
fn straight([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    if a == 0 {
        return [0; 4];
    }
    let whole = |c: u8| {
        let (c, a) = (u32::from(c), u32::from(a));
        ((255 * c + a / 2) / a).min(255) as u8
    };
    [whole(r), whole(g), whole(b), a]
}
