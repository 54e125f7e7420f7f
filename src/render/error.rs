//! Errors of drawing.

use std::path::PathBuf;

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No graphics adapter, not even a software one.
    #[error(
        "no graphics adapter found ({reason}). Install a driver; without a graphics card, a \
         software driver is enough: on Debian or Ubuntu `apt install libvulkan1 \
         mesa-vulkan-drivers` (Vulkan) or `apt install libegl1 libgl1-mesa-dri` (OpenGL)"
    )]
    NoAdapter {
        /// The error of the graphics library.
        reason: String,
    },
    /// The adapter provides no device.
    #[error("the graphics adapter {adapter} cannot be used: {reason}. Update its driver")]
    NoDevice {
        /// The name of the adapter.
        adapter: String,
        /// The error of the graphics library.
        reason: String,
    },
    /// The device stopped working.
    #[error("the graphics device failed: {reason}. Try a smaller picture or update the driver")]
    Device {
        /// The error of the graphics library.
        reason: String,
    },
    /// A picture without pixels, or with too many.
    #[error("a picture cannot have {width} × {height} pixels: each side must be from 1 to {most}")]
    Size {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Maximum side.
        most: u32,
    },
    /// A surface with more vertices or triangles than the device can hold in one buffer.
    #[error(
        "a surface needs a buffer of {needed} bytes of graphics memory, but the adapter allows \
         {allowed}. Reduce the mesh"
    )]
    TooLarge {
        /// Size of the buffer in bytes.
        needed: u64,
        /// The limit.
        allowed: u64,
    },
    /// A picture file could not be encoded.
    #[error("{path} could not be encoded: {reason}", path = path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// The error of the encoder.
        reason: String,
    },
    /// A file could not be written.
    #[error(transparent)]
    Save(#[from] crate::io::SaveError),
}
