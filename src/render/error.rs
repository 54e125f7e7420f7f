//! What can go wrong when drawing.

use std::path::PathBuf;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No graphics adapter, not even one in software.
    #[error(
        "no graphics adapter found ({reason}). Install a driver; without a graphics card a \
         software one does: on Debian or Ubuntu `apt install libvulkan1 mesa-vulkan-drivers` \
         (Vulkan) or `apt install libegl1 libgl1-mesa-dri` (OpenGL)"
    )]
    NoAdapter {
        /// The error of the graphics library.
        reason: String,
    },
    /// The adapter does not give a device.
    #[error("the graphics adapter {adapter} cannot be used: {reason}. Update its driver")]
    NoDevice {
        /// Its name.
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
    #[error(
        "a picture of {width} × {height} pixels is not possible: each side can have 1 to {most}"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Largest side.
        most: u32,
    },
    /// A surface with more vertices or triangles than the device can hold in one buffer.
    #[error(
        "a surface needs {needed} bytes of graphics memory in one piece, the adapter allows \
         {allowed}. Reduce the mesh"
    )]
    TooLarge {
        /// Bytes of the buffer.
        needed: u64,
        /// The limit.
        allowed: u64,
    },
    /// A picture file could not be encoded.
    #[error("{path} could not be made: {reason}", path = path.display())]
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
