//! Image files as pixels. Without the cargo feature `textures`, none can be read or written.

/// An image in sRGB.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue and opacity of each pixel, row by row from the top.
    pub rgba: Vec<u8>,
}

#[cfg(not(feature = "textures"))]
const MISSING: &str = "this build has no cargo feature `textures`, which reads and writes images";

impl Pixels {
    /// Reads the bytes of a PNG, JPEG or GIF file.
    ///
    /// # Errors
    /// A message for the user.
    #[cfg(feature = "textures")]
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let image = image::load_from_memory(bytes).map_err(|e| e.to_string())?;
        Ok(Self {
            width: image.width(),
            height: image.height(),
            rgba: image.into_rgba8().into_raw(),
        })
    }

    /// Reads no image: the feature is missing.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "textures"))]
    pub fn decode(_: &[u8]) -> Result<Self, String> {
        Err(MISSING.to_owned())
    }

    /// The bytes of a PNG file, without opacity if all pixels are opaque.
    ///
    /// # Errors
    /// A message for the user: the image has no pixels.
    #[cfg(feature = "textures")]
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        use image::ImageEncoder as _;
        let mut png = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut png);
        let is_opaque = self.rgba.chunks_exact(4).all(|p| p[3] == u8::MAX);
        let written = if is_opaque {
            let rgb = self.rgba.chunks_exact(4).flat_map(|p| p[..3].to_vec());
            let rgb: Vec<u8> = rgb.collect();
            let kind = image::ExtendedColorType::Rgb8;
            encoder.write_image(&rgb, self.width, self.height, kind)
        } else {
            let kind = image::ExtendedColorType::Rgba8;
            encoder.write_image(&self.rgba, self.width, self.height, kind)
        };
        written.map_err(|e| e.to_string())?;
        Ok(png)
    }

    /// Writes no image: the feature is missing.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "textures"))]
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        Err(MISSING.to_owned())
    }
}

#[cfg(all(test, feature = "textures"))]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_from_png() {
        for last in [u8::MAX, 7] {
            let rgba: Vec<u8> = (0..6).flat_map(|k| [40 * k, 9, 200 - k, u8::MAX]).collect();
            let mut pixels = Pixels {
                width: 3,
                height: 2,
                rgba,
            };
            pixels.rgba[23] = last;
            let png = pixels.to_png().expect("written");
            assert_eq!(Pixels::decode(&png), Ok(pixels));
        }
        assert!(Pixels::decode(b"no image").is_err());
    }
}
