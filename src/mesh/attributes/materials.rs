//! Materials of glTF files.

use serde_json::{Map, Value};

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
