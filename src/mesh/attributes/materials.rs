//! Materials.

use std::path::PathBuf;

use serde_json::{Map, Value};

/// A material that faces refer to by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Its name; empty for the material of faces that name none.
    pub name: String,
    /// Red, green and blue in 0..=1.
    pub color: Option<[f32; 3]>,
    /// Its image.
    pub image: Option<ImageSource>,
}

/// Where the image of a material is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImageSource {
    /// In a file.
    File(PathBuf),
    /// In the mesh file: the bytes of an image file.
    Bytes(Vec<u8>),
}

/// The materials of a glTF file with everything that they refer to, as the file has them. Faces refer
/// to them by name, with their tags.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfMaterials {
    /// The name of each material. Unnamed materials and those that share a name have names made for
    /// the tags.
    pub names: Vec<String>,
    /// The arrays `materials`, `textures`, `samplers` and `images` of the file.
    pub json: Map<String, Value>,
    /// The bytes of each image; `None` if the file has its `uri`.
    pub images: Vec<Option<Vec<u8>>>,
}
