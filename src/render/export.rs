//! Picture files and sequences of pictures.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use image::RgbaImage;
use image::codecs::gif::{GifEncoder, Repeat};

use super::{Camera, RenderError};
use crate::io::save_with;
use crate::options::choices;

/// Quality of the colours of a GIF, 1 (best, slow) to 30.
const GIF_SPEED: i32 = 10;

/// The file format of a sequence of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequenceFormat {
    /// One PNG file for each picture: `name-0000.png` and so on for the target `name.png`.
    Png,
    /// One animated GIF: 256 colours per picture, at most 50 pictures per second.
    Gif,
    /// One animated PNG.
    Apng,
}

choices!(SequenceFormat: Png "png", Gif "gif", Apng "apng");

impl SequenceFormat {
    /// The first file of a sequence with this target.
    pub fn first_file(self, target: &Path) -> PathBuf {
        match self {
            Self::Png => numbered_path(target, 0),
            Self::Gif | Self::Apng => target.to_owned(),
        }
    }
}

/// The outcome of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SequenceEnd {
    /// All pictures were written to these files.
    Written(Vec<PathBuf>),
    /// The sequence was cancelled and its files were removed.
    Cancelled,
}

/// Writes a picture as PNG, atomically.
///
/// # Errors
/// The file cannot be written.
pub fn save_png(path: &Path, picture: &RgbaImage) -> Result<(), RenderError> {
    Ok(save_with(path, |out| {
        let mut writer = encoder(out, picture, None)?.write_header()?;
        writer.write_image_data(picture)?;
        Ok(writer.finish()?)
    })?)
}

/// Writes `count` pictures of one size, drawn in sequence by `frames`, to play at `fps` pictures
/// per second. `progress` receives the number of finished pictures and the total, and may return
/// `false` to cancel.
///
/// # Errors
/// A picture cannot be drawn or a file cannot be written. The files of the sequence are then
/// removed.
pub fn write_sequence(
    target: &Path,
    format: SequenceFormat,
    mut frames: impl FnMut(usize) -> Result<RgbaImage, RenderError>,
    count: usize,
    fps: f64,
    progress: &dyn Fn(usize, usize) -> bool,
) -> Result<SequenceEnd, RenderError> {
    if count == 0 {
        return Ok(SequenceEnd::Written(Vec::new()));
    }
    let mut next = |i: usize| -> Result<RgbaImage, Stop> {
        if !progress(i, count) {
            return Err(Stop::Cancelled);
        }
        frames(i).map_err(Stop::Failed)
    };
    let written = match format {
        SequenceFormat::Png => numbered(target, count, &mut next),
        SequenceFormat::Gif => animation(target, |out| gif(out, count, fps, &mut next)),
        SequenceFormat::Apng => animation(target, |out| apng(out, count, fps, &mut next)),
    };
    match written {
        Ok(files) => {
            progress(count, count);
            Ok(SequenceEnd::Written(files))
        }
        Err(Stop::Cancelled) => Ok(SequenceEnd::Cancelled),
        Err(Stop::Failed(error)) => Err(error),
        Err(Stop::Writing(source)) => Err(RenderError::Encode {
            path: target.to_owned(),
            reason: source.to_string(),
        }),
    }
}

/// The camera of picture `i` of `count` on a full turn around the vertical axis through the pivot.
#[must_use]
pub fn turntable(camera: &Camera, i: usize, count: usize) -> Camera {
    let mut turned = *camera;
    let turn = std::f64::consts::TAU * i as f64 / count.max(1) as f64;
    turned.orbit(turn, 0.0, true);
    turned
}

/// Why a sequence ended early.
enum Stop {
    Cancelled,
    Failed(RenderError),
    Writing(io::Error),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Self::Writing(error)
    }
}

impl From<png::EncodingError> for Stop {
    fn from(error: png::EncodingError) -> Self {
        Self::Writing(error.into())
    }
}

type Frames<'a> = &'a mut dyn FnMut(usize) -> Result<RgbaImage, Stop>;

fn numbered(target: &Path, count: usize, next: Frames<'_>) -> Result<Vec<PathBuf>, Stop> {
    let mut files: Vec<PathBuf> = Vec::new();
    for i in 0..count {
        let path = numbered_path(target, i);
        let saved = next(i).and_then(|p| save_png(&path, &p).map_err(Stop::Failed));
        if let Err(stop) = saved {
            for file in &files {
                // the file may be gone already
                std::fs::remove_file(file).ok();
            }
            return Err(stop);
        }
        files.push(path);
    }
    Ok(files)
}

/// `name-0007.png` for `name.png`.
fn numbered_path(target: &Path, i: usize) -> PathBuf {
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    target.with_file_name(format!("{stem}-{i:04}.png"))
}

/// A file that contains all pictures.
fn animation(
    target: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), Stop>,
) -> Result<Vec<PathBuf>, Stop> {
    let mut stopped = None;
    let saved = save_with(target, |out| {
        fill(out).map_err(|stop| match stop {
            Stop::Writing(error) => error,
            other => {
                stopped = Some(other);
                io::Error::other("stopped")
            }
        })
    });
    match (saved, stopped) {
        (_, Some(stop)) => Err(stop),
        (Err(error), None) => Err(Stop::Failed(error.into())),
        (Ok(()), None) => Ok(vec![target.to_owned()]),
    }
}

#[expect(clippy::cast_sign_loss, reason = "clamped to positive numbers")]
fn gif(out: &mut dyn Write, count: usize, fps: f64, next: Frames<'_>) -> Result<(), Stop> {
    let mut encoder = GifEncoder::new_with_speed(out, GIF_SPEED);
    encoder
        .set_repeat(Repeat::Infinite)
        .map_err(io::Error::other)?;
    // the format counts in hundredths of a second, and viewers play delays below two more slowly
    let hundredths = (100.0 / fps).round().clamp(2.0, 6000.0) as u32;
    let delay = image::Delay::from_numer_denom_ms(10 * hundredths, 1);
    for i in 0..count {
        let frame = image::Frame::from_parts(next(i)?, 0, 0, delay);
        encoder.encode_frame(frame).map_err(io::Error::other)?;
    }
    Ok(())
}

#[expect(clippy::cast_sign_loss, reason = "clamped to positive numbers")]
fn apng(out: &mut dyn Write, count: usize, fps: f64, next: Frames<'_>) -> Result<(), Stop> {
    let milliseconds = (1000.0 / fps).round().clamp(1.0, 60_000.0) as u16;
    let first = next(0)?;
    let timing = (count as u32, milliseconds);
    let mut writer = encoder(out, &first, Some(timing))?.write_header()?;
    writer.write_image_data(&first)?;
    for i in 1..count {
        writer.write_image_data(&next(i)?)?;
    }
    Ok(writer.finish()?)
}

/// An encoder for a picture, or for an animation that starts with it, given the number of pictures
/// and the milliseconds per picture.
fn encoder<'a>(
    out: &'a mut dyn Write,
    first: &RgbaImage,
    animated: Option<(u32, u16)>,
) -> io::Result<png::Encoder<'static, &'a mut dyn Write>> {
    let mut encoder = png::Encoder::new(out, first.width(), first.height());
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    if let Some((count, milliseconds)) = animated {
        encoder.set_animated(count, 0)?;
        encoder.set_frame_delay(milliseconds, 1000)?;
    }
    Ok(encoder)
}
