//! Pictures with labels: views side by side, a legend, a caption.

use std::sync::Arc;

use image::imageops::replace;
use image::{Rgba, RgbaImage};

use super::colormap::{colormap, legend_labels, robust_range};
use super::headless::check_size;
use super::lettering::Pen;
use super::{Background, Camera, Geometry, Gpu, RenderError, Scene, ViewStyle, picture};

/// Size of letters in pixels at a line scale of 1.
const LETTERS: f32 = 14.0;
/// Maximum size of letters, as a fraction of the height and width of the picture.
const LARGEST: [f32; 2] = [1.0 / 14.0, 1.0 / 24.0];
/// Gap between two views in pixels at a line scale of 1.
const GAP: f32 = 2.0;
/// Ink on light and on dark ground.
const INKS: [[u8; 3]; 2] = [[24, 30, 38], [226, 231, 237]];

/// Size and labels of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Width and height in pixels, 1 to [`MAX_SIDE`](super::MAX_SIDE) each.
    pub size: [u32; 2],
    /// Whether the background is transparent.
    pub transparent: bool,
    /// Whether a map has a legend: colours, end values and unit.
    pub legend: bool,
    /// The text below the views; none if it is empty.
    pub caption: String,
}

/// One of the views of a picture.
#[derive(Clone, Copy, Debug)]
pub struct SheetView<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The text in its upper left corner.
    pub title: &'a str,
}

/// The parts of a picture in pixels.
struct Layout {
    /// Size of letters.
    letters: f32,
    /// Size of all views together.
    views: [u32; 2],
    /// Gap between two views.
    gap: u32,
    /// Range of the legend.
    legend: Option<[f32; 2]>,
}

impl Layout {
    /// Width of each view.
    fn width(&self, views: u32) -> u32 {
        let gaps = self.gap * (views - 1);
        (self.views[0].saturating_sub(gaps) / views).max(1)
    }
}

impl Sheet {
    /// Size in pixels of each of `views` views of surfaces. What the camera shows should be fitted to
    /// it.
    pub fn view_size(
        &self,
        surfaces: &[Arc<Geometry>],
        style: &ViewStyle,
        views: usize,
    ) -> [u32; 2] {
        let layout = self.layout(surfaces, style);
        [layout.width(views.max(1) as u32), layout.views[1]]
    }

    fn layout(&self, surfaces: &[Arc<Geometry>], style: &ViewStyle) -> Layout {
        let [width, height] = self.size;
        let largest = (LARGEST[0] * height as f32).min(LARGEST[1] * width as f32);
        let letters = (LETTERS * style.line_scale).min(largest);
        let mode = style.mode;
        let range = || style.range.unwrap_or_else(|| robust_range(surfaces, mode));
        let legend = (self.legend && mode.is_map()).then(range);
        let beside = legend.map_or(0.0, |range| Legend::new(style, range, letters).width());
        let below = if self.caption.is_empty() {
            0.0
        } else {
            2.2 * letters
        };
        let left = |all: u32, taken: f32| all.saturating_sub(taken.round() as u32).max(1);
        Layout {
            letters,
            views: [left(width, beside), left(height, below)],
            gap: (GAP * style.line_scale).round().max(1.0) as u32,
            legend,
        }
    }
}

/// Draws views side by side from one camera, with the labels of the sheet. The text is dark on a light
/// background of `style` and light on a dark one. Colours are not premultiplied.
///
/// # Errors
/// The size is out of range, a scene is too large, or the device fails.
pub fn sheet_picture(
    gpu: &Gpu,
    sheet: &Sheet,
    views: &[SheetView<'_>],
    camera: &Camera,
    style: &ViewStyle,
) -> Result<RgbaImage, RenderError> {
    check_size(sheet.size)?;
    let [width, height] = sheet.size;
    let surfaces: Vec<_> = views
        .iter()
        .flat_map(|v| v.scene.surfaces.clone())
        .collect();
    let layout = sheet.layout(&surfaces, style);
    let style = ViewStyle {
        // one range for all views
        range: layout.legend.or(style.range),
        ..*style
    };
    let ground = Ground::of(&style, sheet.transparent);
    let mut image = RgbaImage::from_fn(width, height, |_, y| ground.at(y, layout.views[1]));
    let pen = Pen::new(layout.letters, ground.ink);
    let each = layout.width(views.len().max(1) as u32);
    for (i, view) in views.iter().enumerate() {
        let size = [each, layout.views[1]];
        let drawn = picture(gpu, view.scene, camera, &style, size, sheet.transparent)?;
        let left = i as u32 * (each + layout.gap);
        replace(&mut image, &drawn, i64::from(left), 0);
        let margin = 0.8 * layout.letters;
        let title = pen.elided(view.title, each as f32 - 2.0 * margin);
        pen.write(&mut image, [left as f32 + margin, 1.6 * margin], &title);
    }
    if let Some(range) = layout.legend {
        Legend::new(&style, range, layout.letters).draw(&mut image, &pen, layout.views);
    }
    let margin = 0.8 * layout.letters;
    let caption = pen.elided(&sheet.caption, width as f32 - 2.0 * margin);
    let middle = 0.5 * (layout.views[1] + height) as f32;
    pen.write(&mut image, [margin, middle], &caption);
    Ok(image)
}

/// The colours around the views, which continue their background.
struct Ground {
    /// Colours of the upper and lower edge; `None` if it is transparent.
    ends: Option<[[f32; 3]; 2]>,
    ink: [u8; 3],
}

impl Ground {
    fn of(style: &ViewStyle, transparent: bool) -> Self {
        let (ends, is_dark) = match style.background {
            Background::Gradient { top, bottom } => {
                (Some([top, bottom]), bottom.iter().sum::<f32>() < 1.5)
            }
            Background::Transparent => (None, false),
        };
        Self {
            ends: ends.filter(|_| !transparent),
            ink: INKS[usize::from(is_dark)],
        }
    }

    /// The colour in row `y`, where the views are `height` pixels high.
    fn at(&self, y: u32, height: u32) -> Rgba<u8> {
        let Some([top, bottom]) = self.ends else {
            return Rgba([0; 4]);
        };
        let t = ((y as f32 + 0.5) / height as f32).min(1.0);
        let [r, g, b] = [0, 1, 2].map(|k| top[k] + t * (bottom[k] - top[k]));
        let byte = |c: f32| (255.0 * c).round() as u8;
        Rgba([byte(r), byte(g), byte(b), 255])
    }
}

/// The legend of a map, beside the views.
struct Legend {
    title: String,
    labels: Vec<(f32, String)>,
    letters: f32,
    /// Length of the longest text in pixels.
    longest: [f32; 2],
}

impl Legend {
    fn new(style: &ViewStyle, range: [f32; 2], letters: f32) -> Self {
        let pen = Pen::new(letters, INKS[0]);
        let title = style.mode.legend_title();
        let labels = legend_labels(range, 0.07);
        let longest = labels.iter().map(|(_, words)| pen.length(words));
        Self {
            longest: [pen.length(&title), longest.fold(0.0, f32::max)],
            title,
            labels,
            letters,
        }
    }

    /// Distance of the numbers from the left edge of the colours.
    fn indent(&self) -> f32 {
        1.9 * self.letters
    }

    fn width(&self) -> f32 {
        let [title, label] = self.longest;
        1.6 * self.letters + title.max(self.indent() + label)
    }

    /// Draws the legend at the right of views of this size.
    fn draw(&self, image: &mut RgbaImage, pen: &Pen, [left, height]: [u32; 2]) {
        let s = self.letters;
        let left = left as f32 + 0.8 * s;
        let (top, bottom) = (0.22 * height as f32, 0.82 * height as f32);
        pen.write(image, [left, top - 1.4 * s], &self.title);
        let mut fill = |from: [f32; 2], to: [f32; 2], color: &dyn Fn(f32) -> [u8; 3]| {
            let rows = from[1].round() as u32..to[1].round() as u32;
            for y in rows {
                let [r, g, b] = color(y as f32 + 0.5);
                for x in from[0].round() as u32..to[0].round() as u32 {
                    if let Some(pixel) = image.get_pixel_mut_checked(x, y) {
                        *pixel = Rgba([r, g, b, 255]);
                    }
                }
            }
        };
        fill([left, top], [left + 1.2 * s, bottom], &|y| {
            let t = (bottom - y) / (bottom - top);
            colormap(t).map(|c| (255.0 * c).round() as u8)
        });
        let tick = (0.08 * s).max(1.0);
        let place = |t: f32| bottom - t * (bottom - top);
        for (t, _) in &self.labels {
            let y = place(*t) - 0.5 * tick;
            fill([left + 1.2 * s, y], [left + 1.55 * s, y + tick], &|_| {
                pen.ink()
            });
        }
        for (t, words) in &self.labels {
            pen.write(image, [left + self.indent(), place(*t)], words);
        }
    }
}
