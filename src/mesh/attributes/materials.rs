//! Materials.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

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
    /// Whether the file moves, turns or scales the image by a transform, which is not applied.
    pub is_transformed: bool,
}

/// Where the image of a material is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImageSource {
    /// In a file.
    File(PathBuf),
    /// In the mesh file: the bytes of an image file.
    Bytes(Vec<u8>),
}

impl ImageSource {
    /// Its name in messages.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Bytes(_) => "in the mesh file".to_owned(),
        }
    }

    /// The bytes of the image file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn bytes(&self) -> std::io::Result<Cow<'_, [u8]>> {
        match self {
            Self::File(path) => std::fs::read(path).map(Cow::Owned),
            Self::Bytes(bytes) => Ok(Cow::Borrowed(bytes)),
        }
    }
}

/// A material with an image that is in no file yet, such as that of patches. Faces refer to it by its
/// name, with their tags. It is written with the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnMaterial {
    /// Its name, which no other material has.
    pub name: String,
    /// The material whose other settings it has; empty for none.
    pub like: String,
    /// Its image: the bytes of a PNG file.
    pub png: Arc<Vec<u8>>,
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
