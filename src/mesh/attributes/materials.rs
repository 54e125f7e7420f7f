//! Materials.

use std::collections::HashSet;
use std::io::Read as _;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::serial;

/// A material that faces refer to by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Its name; empty for the material of faces that name none.
    pub name: String,
    /// Red, green and blue in 0..=1.
    pub color: Option<[f32; 3]>,
    /// Its image.
    pub image: Option<ImageSource>,
    /// What is applied to texture coordinates whose second one is downwards, before the image is looked
    /// up: the rows of an affine map, if it is not the identity.
    pub transform: Option<[[f64; 3]; 2]>,
}

impl Material {
    /// The place in the image of texture coordinates whose second one is downwards.
    pub fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        match self.transform {
            Some(rows) => rows.map(|[a, b, c]| a * u + b * v + c),
            None => [u, v],
        }
    }
}

/// Where the image of a material is.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImageSource {
    /// In a file.
    File(PathBuf),
    /// In the mesh file: the bytes of an image file.
    Bytes(Arc<Vec<u8>>),
}

impl ImageSource {
    /// Its name in messages.
    pub fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Bytes(_) => "in the mesh file".to_owned(),
        }
    }

    /// The first bytes of the image file, at most eight.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn start(&self) -> std::io::Result<Vec<u8>> {
        match self {
            Self::File(path) => {
                let mut start = Vec::new();
                std::fs::File::open(path)?.take(8).read_to_end(&mut start)?;
                Ok(start)
            }
            Self::Bytes(bytes) => Ok(bytes.iter().take(8).copied().collect()),
        }
    }

    /// The bytes of the image file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn bytes(&self) -> std::io::Result<Arc<Vec<u8>>> {
        match self {
            Self::File(path) => std::fs::read(path).map(Arc::new),
            Self::Bytes(bytes) => Ok(Arc::clone(bytes)),
        }
    }
}

/// A material with an image that is in no file yet, such as that of patches. Faces refer to it by its
/// name, with their tags. It is written with the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OwnMaterial {
    /// Its name, which no other material has.
    pub name: String,
    /// The material whose other settings it has; empty for none.
    pub like: String,
    /// Its image: the bytes of a PNG file.
    #[serde(with = "serial::image")]
    pub png: Arc<Vec<u8>>,
}

/// The materials of a glTF file with everything that they refer to, as the file has them, or those of a
/// 3MF file in this form. Faces refer to them by name, with their tags.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GltfMaterials {
    /// The name of each material. Unnamed materials and those that share a name have names made for
    /// the tags.
    pub names: Vec<String>,
    /// The arrays `materials`, `textures`, `samplers`, `images` and `extensionsRequired` of the file.
    pub json: Map<String, Value>,
    /// The bytes of each image; `None` if the file has its `uri`.
    #[serde(with = "serial::images")]
    pub images: Vec<Option<Arc<Vec<u8>>>>,
}

impl GltfMaterials {
    /// A material without colour and image.
    pub fn plain() -> Value {
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } })
    }

    /// Different names for materials with these names, which may be empty or equal.
    pub fn different_names<'a>(given: impl IntoIterator<Item = &'a str>) -> Vec<String> {
        let mut taken = HashSet::new();
        let different = |(k, given): (usize, &str)| {
            let mut name = if given.is_empty() {
                format!("material_{k}")
            } else {
                given.to_owned()
            };
            while !taken.insert(name.clone()) {
                name = format!("{name}_{k}");
            }
            name
        };
        given.into_iter().enumerate().map(different).collect()
    }

    /// Appends the materials of another file. Returns their names here, where no other material has them.
    pub fn append(&mut self, other: &Self) -> Vec<String> {
        let count = |name: &str| {
            let list = self.json.get(name).and_then(Value::as_array);
            list.map_or(0, Vec::len) as u64
        };
        let shifts = [
            ("index", count("textures")),
            ("source", count("images")),
            ("sampler", count("samplers")),
        ];
        for (name, value) in &other.json {
            let mut value = value.clone();
            shift(&mut value, &shifts);
            let list = self.json.entry(name.as_str()).or_insert_with(|| json!([]));
            if let (Value::Array(list), Value::Array(more)) = (list, value) {
                list.extend(more);
            }
        }
        // each image has an entry, also where the array lacks it
        self.images.extend(other.images.iter().cloned());
        let first = self.names.len();
        for wanted in &other.names {
            let mut name = wanted.clone();
            let mut number = 2;
            while self.names.contains(&name) {
                name = format!("{wanted}_{number}");
                number += 1;
            }
            self.names.push(name);
        }
        self.names[first..].to_vec()
    }
}

/// Adds to all numbers with these keys.
fn shift(value: &mut Value, by: &[(&str, u64); 3]) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let by_this = by.iter().find(|(name, _)| name == key);
                match (by_this, value.as_u64()) {
                    (Some((_, by)), Some(number)) => *value = (number + by).into(),
                    _ => shift(value, by),
                }
            }
        }
        Value::Array(list) => list.iter_mut().for_each(|value| shift(value, by)),
        _ => {}
    }
}
