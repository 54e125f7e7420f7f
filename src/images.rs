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

/// The most bytes of a decoded image: 16384 x 16384 pixels with eight bytes each.
#[cfg(feature = "textures")]
const LARGEST: u64 = 1 << 31;

#[cfg(not(feature = "textures"))]
const MISSING: &str = "this build has no cargo feature `textures`, which reads and writes images";

impl Pixels {
    /// Reads the bytes of a PNG, JPEG, GIF, BMP, TGA, TIFF or WebP file.
    ///
    /// # Errors
    /// A message for the user.
    #[cfg(feature = "textures")]
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        use image::{ImageError, ImageFormat, ImageReader, Limits};
        const REMEDY: &str = "convert it to PNG or JPEG";
        if bytes.is_empty() {
            return Err("the file is empty; export it again".to_owned());
        }
        let format = image::guess_format(bytes)
            .ok()
            .or(is_tga(bytes).then_some(ImageFormat::Tga))
            .ok_or_else(|| {
                format!("it is no PNG, JPEG, GIF, BMP, TGA, TIFF or WebP file; {REMEDY}")
            })?;
        if !format.reading_enabled() {
            let name = format!("{format:?}").to_uppercase();
            return Err(format!("{name} images are not supported; {REMEDY}"));
        }
        let mut reader = ImageReader::with_format(std::io::Cursor::new(bytes), format);
        let mut limits = Limits::default();
        limits.max_alloc = Some(LARGEST);
        reader.limits(limits);
        let image = reader.decode().map_err(|error| match error {
            ImageError::Limits(_) => "it is too large; scale it down".to_owned(),
            error => format!("{}; export it again", error.to_string().trim()),
        })?;
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

/// Whether the header is one of a TGA file, which has no signature.
#[cfg(feature = "textures")]
fn is_tga(bytes: &[u8]) -> bool {
    let Some(header) = bytes.first_chunk::<18>() else {
        return false;
    };
    let (color_map, kind, depth) = (header[1], header[2], header[16]);
    let sides = [12, 14].map(|at| u16::from_le_bytes([header[at], header[at + 1]]));
    color_map <= 1
        && matches!(kind, 1..=3 | 9..=11)
        && matches!(depth, 8 | 15 | 16 | 24 | 32)
        && !sides.contains(&0)
}

#[cfg(all(test, feature = "textures"))]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_from_other_formats() {
        use image::ImageFormat::{Bmp, Tga, Tiff, WebP};
        let picture = image::RgbaImage::from_fn(5, 3, |x, y| {
            image::Rgba([50 * x as u8, 80 * y as u8, 7, 255 - 20 * x as u8])
        });
        for format in [Bmp, Tga, Tiff, WebP] {
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, format).expect("written");
            let bytes = bytes.into_inner();
            let pixels = Pixels::decode(&bytes).expect("read");
            assert_eq!((pixels.width, pixels.height), (5, 3), "{format:?}");
            assert_eq!(&pixels.rgba, picture.as_raw(), "{format:?}");
            let cut = Pixels::decode(&bytes[..bytes.len() / 2]).expect_err("cut off");
            assert!(cut.ends_with("; export it again"), "{format:?}: {cut}");
        }
    }

    /// What a header declares is refused before it is allocated.
    #[test]
    fn large_images_of_other_formats_are_refused() {
        let mut tga = vec![0; 18];
        (tga[2], tga[16]) = (2, 32);
        tga[12..16].fill(0xff);
        let mut bmp = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
        bmp.extend([40_000_u32, 40_000].map(u32::to_le_bytes).concat());
        bmp.extend([1, 0, 32, 0]);
        bmp.resize(54, 0);
        for file in [tga, bmp] {
            let message = Pixels::decode(&file).expect_err("too large");
            assert_eq!(message, "it is too large; scale it down");
        }
    }

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
    }

    #[test]
    fn other_files_are_refused_with_a_remedy() {
        let message = |bytes: &[u8]| Pixels::decode(bytes).expect_err("no image");
        assert_eq!(message(b""), "the file is empty; export it again");
        let other =
            "it is no PNG, JPEG, GIF, BMP, TGA, TIFF or WebP file; convert it to PNG or JPEG";
        assert_eq!(message(b"no image"), other);
        let dds = "DDS images are not supported; convert it to PNG or JPEG";
        assert_eq!(message(b"DDS \x7c\0\0\0"), dds);
        let pixels = Pixels {
            width: 40,
            height: 40,
            rgba: (0..40 * 40 * 4).map(|k| (k % 251) as u8).collect(),
        };
        let png = pixels.to_png().expect("written");
        let cut = message(&png[..png.len() / 2]);
        assert!(cut.ends_with("; export it again"), "{cut}");
        // 40000 x 40000 pixels
        let mut huge = png;
        for at in [16, 20] {
            huge[at..at + 4].copy_from_slice(&40_000_u32.to_be_bytes());
        }
        let mut sum = flate2::Crc::new();
        sum.update(&huge[12..29]);
        huge[29..33].copy_from_slice(&sum.sum().to_be_bytes());
        assert_eq!(message(&huge), "it is too large; scale it down");
    }
}
