//! Text in pictures.

use ab_glyph::{Font as _, FontRef, Glyph, GlyphId, PxScaleFont, ScaleFont as _, point};
use image::{Rgba, RgbaImage};

/// The font of the window, and one for characters that it lacks: Latin, Greek and Cyrillic letters.
const FONTS: [&[u8]; 2] = [
    include_bytes!("../../assets/fonts/Inter-Regular.otf"),
    epaint_default_fonts::UBUNTU_LIGHT,
];
/// What is written for characters that both fonts lack.
const UNKNOWN: char = '?';

type Font = PxScaleFont<FontRef<'static>>;

/// Writes text of one size and colour.
pub struct Pen {
    fonts: [Font; 2],
    ink: [u8; 3],
}

impl Pen {
    /// A pen for letters of `size` pixels in an sRGB colour.
    pub fn new(size: f32, ink: [u8; 3]) -> Self {
        let fonts = FONTS.map(|bytes| {
            let font = FontRef::try_from_slice(bytes).expect("a font of the program");
            // from the size of the em square to the height of a line
            let line = font.height_unscaled() / font.units_per_em().unwrap_or(1000.0);
            font.into_scaled(size * line)
        });
        Self { fonts, ink }
    }

    /// The colour of the letters.
    pub fn ink(&self) -> [u8; 3] {
        self.ink
    }

    /// Length of a text in pixels.
    pub fn length(&self, text: &str) -> f32 {
        self.glyphs(text).1
    }

    /// The text, elided at its end so that it is at most `length` pixels long.
    pub fn elided(&self, text: &str, length: f32) -> String {
        if self.length(text) <= length {
            return text.to_owned();
        }
        let mut kept = text.to_owned();
        while kept.pop().is_some() {
            let shorter = format!("{}…", kept.trim_end());
            if self.length(&shorter) <= length {
                return shorter;
            }
        }
        String::new()
    }

    /// Writes a text. It begins at `at[0]`, and the middle of its line is at `at[1]`.
    pub fn write(&self, picture: &mut RgbaImage, at: [f32; 2], text: &str) {
        let baseline = at[1] + 0.5 * (self.fonts[0].ascent() + self.fonts[0].descent());
        for (font, mut glyph) in self.glyphs(text).0 {
            glyph.position.x += at[0];
            glyph.position.y = baseline;
            let Some(outline) = font.outline_glyph(glyph) else {
                continue; // a space
            };
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, coverage| {
                let [x, y] = [corner.x + x as f32, corner.y + y as f32];
                if x >= 0.0 && y >= 0.0 {
                    blend(picture, [x as u32, y as u32], self.ink, coverage);
                }
            });
        }
    }

    /// The font that has a character, and its glyph.
    fn glyph(&self, c: char) -> Option<(&Font, GlyphId)> {
        let all = self.fonts.iter().map(|font| (font, font.glyph_id(c)));
        all.into_iter().find(|(_, id)| id.0 != 0)
    }

    /// The glyphs of a text that begins at 0, and its length.
    fn glyphs(&self, text: &str) -> (Vec<(&Font, Glyph)>, f32) {
        let mut x = 0.0;
        let mut glyphs = Vec::new();
        let mut last = None;
        for c in text.chars() {
            let Some((font, id)) = self.glyph(c).or_else(|| self.glyph(UNKNOWN)) else {
                continue;
            };
            if let Some((before, last)) = last
                && std::ptr::eq::<Font>(before, font)
            {
                x += font.kern(last, id);
            }
            glyphs.push((
                font,
                id.with_scale_and_position(font.scale(), point(x, 0.0)),
            ));
            x += font.h_advance(id);
            last = Some((font, id));
        }
        (glyphs, x)
    }
}

/// Draws a colour over a pixel of a picture with straight alpha; nothing outside of it.
fn blend(picture: &mut RgbaImage, [x, y]: [u32; 2], color: [u8; 3], opacity: f32) {
    let Some(pixel) = picture.get_pixel_mut_checked(x, y) else {
        return;
    };
    let Rgba([r, g, b, a]) = *pixel;
    let over = opacity.clamp(0.0, 1.0);
    let under = (1.0 - over) * f32::from(a) / 255.0;
    let both = over + under;
    if both <= 0.0 {
        return;
    }
    let mix = |new: u8, old: u8| {
        let mixed = (over * f32::from(new) + under * f32::from(old)) / both;
        mixed.round() as u8
    };
    let alpha = (255.0 * both).round() as u8;
    *pixel = Rgba([mix(color[0], r), mix(color[1], g), mix(color[2], b), alpha]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_drawn_where_it_should_be_also_on_transparent_ground() {
        let pen = Pen::new(20.0, [10, 20, 30]);
        let mut picture = RgbaImage::new(200, 60);
        pen.write(&mut picture, [50.0, 30.0], "H, 1/unit²");
        let inked = |(_, _, p): &(u32, u32, &Rgba<u8>)| p[3] > 0;
        let places: Vec<_> = picture.enumerate_pixels().filter(inked).collect();
        let length = pen.length("H, 1/unit²");
        assert!((80.0..120.0).contains(&length), "{length}");
        for (x, y, pixel) in &places {
            assert!((50.0..51.0 + length).contains(&(*x as f32)) && (18..42).contains(y));
            assert_eq!(pixel.0[..3], [10, 20, 30]);
        }
        // solid strokes, and nothing beyond the edges of a picture
        assert!(places.iter().filter(|(.., p)| p[3] == 255).count() > 100);
        pen.write(
            &mut picture,
            [-20.0, 0.0],
            "beyond the edge of the picture, on all sides",
        );
    }

    /// No character is left out: what both fonts lack is a question mark.
    #[test]
    fn every_character_is_drawn() {
        let pen = Pen::new(20.0, [0; 3]);
        let drawn = |text: &str| {
            let mut picture = RgbaImage::new(40, 40);
            pen.write(&mut picture, [10.0, 20.0], text);
            picture
        };
        let inked = |picture: &RgbaImage| picture.pixels().filter(|p| p[3] > 0).count();
        for text in ["č", "Ω", "Ж", "²", "…", "−"] {
            let picture = drawn(text);
            assert!(inked(&picture) > 10 && picture != drawn("?"), "{text}");
        }
        assert_eq!(drawn("漢"), drawn("?"));
        assert_eq!(inked(&drawn(" ")), 0);
    }

    #[test]
    fn long_texts_are_elided() {
        let pen = Pen::new(12.0, [0; 3]);
        assert_eq!(pen.elided("short", 100.0), "short");
        let elided = pen.elided("a caption that is much too long for its picture", 100.0);
        assert!(elided.starts_with("a caption") && elided.ends_with('…'));
        assert!(pen.length(&elided) <= 100.0);
        assert_eq!(pen.elided("anything", 1.0), "");
    }
}
