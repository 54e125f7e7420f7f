//! Picture files and sequences of pictures.

use std::path::{Path, PathBuf};

use super::{Camera, RenderError};

/// How a sequence of pictures is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceFormat {
    /// One PNG file for each picture, numbered from 0 before the extension.
    Png,
    /// One animated GIF, 256 colours a picture.
    Gif,
    /// One animated PNG.
    Apng,
}

/// What became of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SequenceEnd {
    /// All pictures are written, to these files.
    Written(Vec<PathBuf>),
    /// Cancelled; no file of the sequence is left.
    Cancelled,
}

/// Writes a picture as PNG; the file is replaced whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn save_png(path: &Path, picture: &image::RgbaImage) -> Result<(), RenderError> {
    let _ = (path, picture);
    Ok(())
}

/// Writes `count` pictures, made one after the other by `frames`, at `fps` pictures a second.
/// `progress` is told how many of how many are done and may return `false` to cancel.
///
/// # Errors
/// A picture cannot be made or a file not be written; no file of the sequence is left.
pub fn write_sequence(
    target: &Path,
    format: SequenceFormat,
    frames: impl FnMut(usize) -> Result<image::RgbaImage, RenderError>,
    count: usize,
    fps: f64,
    progress: &dyn Fn(usize, usize) -> bool,
) -> Result<SequenceEnd, RenderError> {
    let _ = (target, format, frames, count, fps, progress);
    Ok(SequenceEnd::Cancelled)
}

/// The camera of picture `i` of `count` on a full turn around the vertical through the pivot.
#[must_use]
pub fn turntable(camera: &Camera, i: usize, count: usize) -> Camera {
    let mut turned = *camera;
    turned.orbit(
        std::f64::consts::TAU * i as f64 / count.max(1) as f64,
        0.0,
        true,
    );
    turned
}
