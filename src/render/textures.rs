//! Texture images and where faces are in them.

use std::collections::BTreeMap;
use std::sync::Arc;

use image::imageops::FilterType;

use super::scene::next_id;
use crate::images::Pixels;
use crate::mesh::{
    Attributes, Column, FaceId, ImageSource, Material, Mesh, NO_VALUE, OwnMaterial, texture_columns,
};

/// Maximum side of an image in pixels, which every device that draws supports. Larger ones are scaled.
const MAX_SIZE: u32 = 8192;

/// A texture image.
#[derive(Debug)]
pub struct Image {
    /// Unique number of the content, by which a renderer finds its copy.
    pub id: u64,
    /// The pixels (sRGB), first row on top.
    pub pixels: image::RgbaImage,
}

impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Image {
    /// An image with a new unique number.
    pub fn new(pixels: image::RgbaImage) -> Self {
        Self {
            id: next_id(),
            pixels,
        }
    }

    /// Whether it has one pixel.
    fn is_plain(&self) -> bool {
        self.pixels.dimensions() == (1, 1)
    }

    /// Reads an image. One with a side above 8192 pixels is scaled down, with a note.
    fn read(source: &ImageSource) -> Result<(Self, Option<String>), String> {
        let name = source.name();
        let read = source.bytes().map_err(|e| e.to_string());
        let read = read.and_then(|bytes| Pixels::decode(&bytes));
        let Pixels {
            width,
            height,
            rgba,
        } = read.map_err(|e| format!("the texture image '{name}' is not drawn: {e}"))?;
        let picture = image::RgbaImage::from_raw(width, height, rgba);
        let picture = picture.expect("a colour for each pixel");
        if width.max(height) <= MAX_SIZE {
            return Ok((Self::new(picture), None));
        }
        let picture = image::DynamicImage::from(picture);
        let scaled = picture.resize(MAX_SIZE, MAX_SIZE, FilterType::Triangle);
        let note = format!(
            "the texture image '{name}' is drawn with {} x {} instead of {width} x {height} pixels",
            scaled.width(),
            scaled.height()
        );
        Ok((Self::new(scaled.into_rgba8()), Some(note)))
    }

    /// The pixels of the image and of its halves, down to one pixel, one after the other, and their
    /// number. A pixel of a half is the mean of two by two.
    pub(super) fn levels(&self) -> (Vec<u8>, u32) {
        let mut all = self.pixels.as_raw().clone();
        let (mut last, mut count) = (self.pixels.clone(), 1);
        while last.width().max(last.height()) > 1 {
            let side = |n: u32| (n / 2).max(1);
            let (width, height) = (side(last.width()), side(last.height()));
            last = image::RgbaImage::from_fn(width, height, |x, y| {
                let at = |i: u32, n: u32| i.min(n - 1);
                let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let four = corners.map(|(i, j)| {
                    let (x, y) = (2 * x + i, 2 * y + j);
                    last.get_pixel(at(x, last.width()), at(y, last.height())).0
                });
                let mean = |k: usize| {
                    four.iter()
                        .map(|p| u32::from(p[k]))
                        .sum::<u32>()
                        .div_ceil(4)
                };
                image::Rgba([0, 1, 2, 3].map(|k| mean(k) as u8))
            });
            all.extend_from_slice(last.as_raw());
            count += 1;
        }
        (all, count)
    }
}

/// The images of the materials of a mesh.
#[derive(Debug, Default)]
pub struct Textures {
    /// By the name of the material.
    images: BTreeMap<String, Arc<Image>>,
    /// The materials with a transform of texture coordinates.
    moved: BTreeMap<String, Material>,
    /// Materials of a mesh whose images are in no file.
    own: Vec<OwnMaterial>,
}

impl Textures {
    /// Reads the images of materials. A material without one has its colour. Returns notes for the user:
    /// images that cannot be read, whose faces are drawn without, and images that were scaled.
    pub fn read(materials: &[Material]) -> (Self, Vec<String>) {
        let mut notes = Vec::new();
        let mut read: BTreeMap<&ImageSource, Option<Arc<Image>>> = BTreeMap::new();
        let mut images = BTreeMap::new();
        for material in materials {
            let image = if let Some(source) = &material.image {
                let image = read
                    .entry(source)
                    .or_insert_with(|| match Image::read(source) {
                        Ok((image, note)) => {
                            notes.extend(note);
                            Some(Arc::new(image))
                        }
                        Err(note) => {
                            notes.push(note);
                            None
                        }
                    });
                image.clone()
            } else {
                material.color.map(|color| {
                    let [r, g, b] = color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8);
                    let pixel = image::Rgba([r, g, b, u8::MAX]);
                    Arc::new(Image::new(image::RgbaImage::from_pixel(1, 1, pixel)))
                })
            };
            images.extend(image.map(|image| (material.name.clone(), image)));
        }
        let moved = materials.iter().filter(|m| m.transform.is_some());
        let moved = moved.map(|m| {
            (
                m.name.clone(),
                Material {
                    image: None,
                    ..m.clone()
                },
            )
        });
        let moved = moved.collect();
        let own = Vec::new();
        (Self { images, moved, own }, notes)
    }

    /// The same images and those of the own materials of a mesh, instead of other own materials; `None`
    /// if these are the same.
    #[must_use]
    pub fn with_own(&self, own: &[OwnMaterial]) -> Option<Self> {
        if self.own == own {
            return None;
        }
        let mut images = self.images.clone();
        for material in &self.own {
            images.remove(&material.name);
        }
        let mut read: Vec<(&OwnMaterial, Arc<Image>)> = Vec::new();
        for material in own {
            let known = read.iter().find(|(other, _)| other.png == material.png);
            let image = match known {
                Some((_, image)) => Arc::clone(image),
                None => match Image::read(&ImageSource::Bytes(Arc::clone(&material.png))) {
                    Ok((image, _)) => Arc::new(image),
                    Err(_) => continue,
                },
            };
            images.insert(material.name.clone(), Arc::clone(&image));
            read.push((material, image));
        }
        let (own, moved) = (own.to_vec(), self.moved.clone());
        Some(Self { images, moved, own })
    }

    /// Whether an image is more than one colour.
    pub fn has_pictures(&self) -> bool {
        self.images.values().any(|image| !image.is_plain())
    }

    /// Whether there is no image.
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// The images of the faces of a mesh. Colours of vertices or faces other than white hide that of a material.
    pub fn of_faces(&self, mesh: &Mesh) -> FaceTextures {
        let attributes = &mesh.attributes;
        let coordinates = Coordinates::of(attributes);
        let painted = Painted::of(mesh);
        let faces = mesh.topology.faces().map(|f| {
            let name = attributes.material_of(f.index());
            let image = self.images.get(name)?;
            let corners = mesh.topology.face_vertices(f).map(|v| v.0);
            if image.is_plain() && painted.has_color(f, corners) {
                return None;
            }
            let at = coordinates.as_ref().and_then(|c| c.of_face(f, corners));
            let at = match self.moved.get(name) {
                Some(material) => at.map(|corners| {
                    corners.map(|at| material.place(at.map(f64::from)).map(|x| x as f32))
                }),
                None => at,
            };
            // one colour is the same everywhere
            let at = at.or(image.is_plain().then_some([[0.0; 2]; 3]))?;
            Some((Arc::clone(image), at))
        });
        FaceTextures(faces.collect())
    }
}

/// The colours of the vertices, or of the faces, of a mesh.
struct Painted {
    vertices: Vec<[f32; 4]>,
    faces: Vec<Option<[f32; 3]>>,
}

impl Painted {
    fn of(mesh: &Mesh) -> Self {
        Self {
            vertices: mesh.colors(),
            faces: mesh.attributes.face_colors(),
        }
    }

    /// Whether a face, or a vertex of it, has a colour other than white.
    fn has_color(&self, f: FaceId, corners: [u32; 3]) -> bool {
        let of_vertex = |&v: &u32| self.vertices.get(v as usize).map(|c| [c[0], c[1], c[2]]);
        let of_face = self.faces.get(f.index()).copied().flatten();
        let mut colors = corners.iter().filter_map(of_vertex).chain(of_face);
        colors.any(|color| color != [1.0; 3])
    }
}

/// Where the texture coordinates of corners are.
struct Coordinates<'a> {
    columns: [&'a Column; 2],
    attributes: &'a Attributes,
    /// Whether they are columns of vertices.
    of_vertices: bool,
}

impl<'a> Coordinates<'a> {
    /// The texture coordinates of corners, or those among the columns of vertices.
    fn of(attributes: &'a Attributes) -> Option<Self> {
        let of_corners = (!attributes.faces.texture.is_empty()).then_some(&attributes.texture[..]);
        let of_vertices = of_corners.is_none();
        let columns = of_corners.unwrap_or(&attributes.vertices);
        Some(Self {
            columns: texture_columns(columns)?.map(|k| &columns[k]),
            attributes,
            of_vertices,
        })
    }

    /// Those of the corners of a face, with the second one downwards. `None` if a corner has none.
    fn of_face(&self, f: FaceId, corners: [u32; 3]) -> Option<[[f32; 2]; 3]> {
        let faces = &self.attributes.faces;
        let list = if self.of_vertices {
            &faces.rows
        } else {
            &faces.texture
        };
        let mut out = [[0.0; 2]; 3];
        for k in 0..3 {
            let row = if list.is_empty() {
                corners[k]
            } else {
                *list.get(3 * f.index() + k)?
            };
            if row == NO_VALUE {
                return None;
            }
            let [u, v] = self
                .columns
                .map(|column| column.numbers.get(row as usize) as f32);
            let is_down = self.attributes.texture_is_down && !self.of_vertices;
            out[k] = [u, if is_down { v } else { 1.0 - v }];
        }
        Some(out)
    }
}

/// For each face of a mesh its image and the places of its corners there, from 0 to 1 rightwards and
/// downwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceTextures(Vec<Option<FaceTexture>>);

/// The image of a face, and the places of its corners.
pub(super) type FaceTexture = (Arc<Image>, [[f32; 2]; 3]);

impl FaceTextures {
    /// Those of a face; `None` if it has none.
    pub(super) fn of(&self, f: FaceId) -> Option<&FaceTexture> {
        self.0.get(f.index())?.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{DVec3, FaceTag};

    fn column(name: &str, numbers: &[f64]) -> Column {
        Column::decimals(name, numbers.to_vec())
    }

    /// Two triangles, of which the first is red and the second has an image.
    fn square() -> Mesh {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let mut mesh = Mesh::from_triangles(points, &[[0, 1, 2], [0, 2, 3]]).expect("a square");
        let tag = |material: &str| FaceTag {
            material: material.into(),
            ..FaceTag::default()
        };
        mesh.attributes.tags = vec![tag("red"), tag("picture"), tag("other")];
        mesh.attributes.faces.tags = vec![0, 1];
        mesh.attributes.texture = Arc::new(vec![
            column("u", &[0.0, 1.0, 0.25]),
            column("v", &[0.0, 0.5, 0.75]),
        ]);
        mesh.attributes.faces.texture = vec![NO_VALUE, NO_VALUE, NO_VALUE, 0, 1, 2];
        mesh
    }

    #[test]
    fn faces_have_the_image_or_colour_of_their_material() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let pixels =
            image::RgbaImage::from_fn(4, 2, |x, y| image::Rgba([x as u8, y as u8, 0, 255]));
        pixels.save(&path).expect("saved");
        let material = |name: &str, color, image| Material {
            transform: None,
            name: name.into(),
            color,
            image,
        };
        let missing = ImageSource::File(folder.path().join("missing.png"));
        let materials = [
            material("red", Some([1.0, 0.0, 0.0]), None),
            material(
                "picture",
                Some([0.0; 3]),
                Some(ImageSource::File(path.clone())),
            ),
            material("again", None, Some(ImageSource::File(path.clone()))),
            material(
                "inside",
                None,
                Some(ImageSource::Bytes(
                    std::fs::read(path).expect("bytes").into(),
                )),
            ),
            material("missing", None, Some(missing.clone())),
            material("missing too", None, Some(missing)),
        ];
        let (textures, notes) = Textures::read(&materials);
        assert!(
            notes.len() == 1 && notes[0].contains("missing.png"),
            "{notes:?}"
        );
        assert!(Arc::ptr_eq(
            &textures.images["picture"],
            &textures.images["again"]
        ));
        assert_eq!(textures.images["inside"].pixels, pixels);
        let mut mesh = square();
        let faces = textures.of_faces(&mesh);
        let (red, _) = faces.of(FaceId(0)).expect("a colour");
        assert_eq!(red.pixels.as_raw(), &[255, 0, 0, 255]);
        let (picture, at) = faces.of(FaceId(1)).expect("an image");
        assert_eq!(picture.pixels, pixels);
        assert_eq!(*at, [[0.0, 1.0], [1.0, 0.5], [0.25, 0.25]]);
        // as in glTF
        mesh.attributes.texture_is_down = true;
        let faces = textures.of_faces(&mesh);
        let (_, at) = faces.of(FaceId(1)).expect("an image");
        assert_eq!(*at, [[0.0, 0.0], [1.0, 0.5], [0.25, 0.75]]);
    }

    #[test]
    fn colours_hide_those_of_materials_unless_they_are_white() {
        let material = Material {
            name: "red".into(),
            color: Some([1.0, 0.0, 0.0]),
            ..Material::default()
        };
        let (textures, _) = Textures::read(&[material]);
        let mut mesh = square();
        mesh.attributes.faces.tags = vec![0, 0];
        let is_red = |mesh: &Mesh| {
            let faces = textures.of_faces(mesh);
            [0, 1].map(|f| faces.of(FaceId(f)).is_some())
        };
        assert_eq!(is_red(&mesh), [true, true]);
        let [white, gray] = [[1.0; 4], [0.5, 0.5, 0.5, 1.0]];
        // the second vertex is in the first face only
        mesh.attributes.vertices = crate::mesh::color_columns(&[white, gray, white, white]);
        assert_eq!(is_red(&mesh), [false, true]);
        mesh.attributes.vertices.clear();
        mesh.attributes.faces.columns = crate::mesh::color_columns(&[white, gray]);
        assert_eq!(is_red(&mesh), [true, false]);
    }

    #[test]
    fn coordinates_of_vertices_serve_as_well() {
        let mut mesh = square();
        mesh.attributes.faces.texture.clear();
        mesh.attributes.tags.clear();
        mesh.attributes.faces.tags.clear();
        mesh.attributes.vertices = vec![
            column("s", &[0.0, 1.0, 1.0, 0.0]),
            column("t", &[0.0, 0.0, 1.0, 1.0]),
        ];
        let image = Arc::new(Image::new(image::RgbaImage::new(2, 2)));
        let images = [(String::new(), image)].into();
        let textures = Textures {
            images,
            ..Textures::default()
        };
        let faces = textures.of_faces(&mesh);
        let (_, at) = faces.of(FaceId(1)).expect("an image");
        assert_eq!(*at, [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    }

    #[test]
    fn levels_are_means_down_to_one_pixel() {
        let pixels = image::RgbaImage::from_fn(4, 2, |x, _| image::Rgba([10 * x as u8, 8, 0, 255]));
        let (all, count) = Image::new(pixels).levels();
        assert_eq!(count, 3);
        assert_eq!(all.len(), 4 * (8 + 2 + 1));
        assert_eq!(all[32..], [5, 8, 0, 255, 25, 8, 0, 255, 15, 8, 0, 255]);
    }
}
