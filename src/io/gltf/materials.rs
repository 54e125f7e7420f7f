//! Materials of a glTF file, kept as they are.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value};

use super::super::error::ParseError;
use super::DATA;
use super::buffers::{Buffers, decoded, escaped, invalid, unescaped};
use crate::mesh::{Attributes, GltfMaterials, ImageSource, Material, to_signal};

/// The array of the extensions without which a document cannot be read.
pub(super) const REQUIRED: &str = "extensionsRequired";

/// The arrays of a document that are kept with its materials.
pub(super) const ARRAYS: [&str; 5] = ["materials", "textures", "samplers", "images", REQUIRED];

/// Where a material has its colour: the place, and the names of the colour and of the texture. Some
/// programs for scans write the second one only.
const SURFACES: [(&str, &str, &str); 2] = [
    (
        "/pbrMetallicRoughness",
        "baseColorFactor",
        "baseColorTexture",
    ),
    (
        "/extensions/KHR_materials_pbrSpecularGlossiness",
        "diffuseFactor",
        "diffuseTexture",
    ),
];

/// The place of the transform of a texture in a reference to it.
const TRANSFORM: &str = "/extensions/KHR_texture_transform";

/// The materials of these arrays, with the images in the buffers; `None` if there are none. Adds a note
/// about textures that are not kept.
///
/// # Errors
/// An image exceeds its buffer.
pub(super) fn keep(
    mut json: Map<String, Value>,
    buffers: &Buffers<'_>,
    notes: &mut Vec<String>,
) -> Result<Option<GltfMaterials>, ParseError> {
    let mut removed = 0;
    for material in list_mut(&mut json, "materials") {
        removed += remove_other_textures(material);
    }
    if removed > 0 {
        notes.push(format!(
            "{removed} textures with other coordinates than TEXCOORD_0 are not kept"
        ));
    }
    let given = list_mut(&mut json, "materials").iter();
    let given = given.map(|material| material.get("name").and_then(Value::as_str));
    let names = GltfMaterials::different_names(given.map(Option::unwrap_or_default));
    if names.is_empty() {
        return Ok(None);
    }
    let mut images = Vec::new();
    let mut left = buffers.size();
    // images may share a view
    let mut of_view: HashMap<usize, Arc<Vec<u8>>> = HashMap::new();
    for (k, image) in list_mut(&mut json, "images").iter_mut().enumerate() {
        let view = image
            .as_object_mut()
            .and_then(|image| image.remove("bufferView"));
        let Some(view) = view.and_then(|view| usize::try_from(view.as_u64()?).ok()) else {
            images.push(None);
            continue;
        };
        if let Some(bytes) = of_view.get(&view) {
            images.push(Some(Arc::clone(bytes)));
            continue;
        }
        let bytes = buffers.view(view, &format!("image {k}"))?;
        // a small file could repeat a large part of a buffer many times
        let Some(rest) = left.checked_sub(bytes.len()) else {
            return Err(invalid("the images overlap"));
        };
        left = rest;
        let bytes = Arc::new(bytes.to_vec());
        of_view.insert(view, Arc::clone(&bytes));
        images.push(Some(bytes));
    }
    Ok(Some(GltfMaterials {
        names,
        json,
        images,
    }))
}

/// An array of a document; empty if there is none.
fn list_mut<'a>(json: &'a mut Map<String, Value>, name: &str) -> &'a mut [Value] {
    json.get_mut(name)
        .and_then(Value::as_array_mut)
        .map_or(&mut [], Vec::as_mut_slice)
}

/// Removes the references to textures that use a second set of coordinates, which is not kept. Returns
/// their count.
fn remove_other_textures(value: &mut Value) -> usize {
    let Some(object) = value.as_object_mut() else {
        return 0;
    };
    let before = object.len();
    object.retain(|_, entry| {
        let set = entry.get("texCoord").and_then(Value::as_u64);
        entry.get("index").is_none() || set.unwrap_or(0) == 0
    });
    let removed = before - object.len();
    removed
        + object
            .values_mut()
            .map(remove_other_textures)
            .sum::<usize>()
}

/// A material without its references to textures.
pub(super) fn without_textures(mut material: Value) -> Value {
    if let Some(object) = material.as_object_mut() {
        object.retain(|_, entry| entry.get("index").is_none());
        for entry in object.values_mut() {
            *entry = without_textures(entry.take());
        }
    }
    material
}

/// The names of the extensions without which a document cannot be read.
pub(super) fn required(json: &Map<String, Value>) -> impl Iterator<Item = &str> {
    let list = json.get(REQUIRED).and_then(Value::as_array);
    list.into_iter().flatten().filter_map(Value::as_str)
}

/// The names of the extensions in a part of a document.
pub(super) fn extensions(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                if let ("extensions", Value::Object(used)) = (key.as_str(), value) {
                    names.extend(used.keys().cloned());
                }
                extensions(value, names);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| extensions(value, names)),
        _ => {}
    }
}

/// The materials with their base colours, as signals, and the images of these. Image files are in `folder`,
/// and are left out if that is unknown.
pub(in super::super) fn materials(folder: Option<&Path>, all: &GltfMaterials) -> Vec<Material> {
    let entry = |list: &str, k: &Value| all.json.get(list)?.get(usize::try_from(k.as_u64()?).ok()?);
    let image = |texture: &Value| {
        let texture = entry("textures", texture.get("index")?)?;
        // the formats of extensions, such as WebP, have their own source
        let others = || texture.get("extensions")?.as_object();
        let mut others = others().into_iter().flat_map(|list| list.values());
        let source = texture.get("source");
        let source = source.or_else(|| others.find_map(|other| other.get("source")))?;
        let bytes = all.images.get(usize::try_from(source.as_u64()?).ok()?);
        if let Some(Some(bytes)) = bytes {
            return Some(ImageSource::Bytes(Arc::clone(bytes)));
        }
        let uri = entry("images", source)?.get("uri")?.as_str()?;
        if uri.starts_with(DATA) {
            return decoded(uri).map(|bytes| ImageSource::Bytes(bytes.into()));
        }
        folder.map(|folder| ImageSource::File(folder.join(unescaped(uri))))
    };
    let color = |factor: &Value| {
        let channel = |k: usize| {
            let signal = to_signal(factor.get(k)?.as_f64()?) as f32;
            signal.is_finite().then_some(signal)
        };
        Some([channel(0)?, channel(1)?, channel(2)?])
    };
    let list = all.json.get("materials").and_then(Value::as_array);
    let pairs = all.names.iter().zip(list.into_iter().flatten());
    let material = |(name, material): (&String, &Value)| {
        let surfaces = SURFACES
            .iter()
            .filter_map(|(path, color_name, texture_name)| {
                let surface = material.pointer(path)?;
                Some((surface.get(color_name), surface.get(texture_name)))
            });
        let surfaces: Vec<(Option<&Value>, Option<&Value>)> = surfaces.collect();
        let texture = surfaces.iter().find_map(|(_, texture)| *texture);
        let transform = texture.and_then(|texture| texture.pointer(TRANSFORM));
        Material {
            name: name.clone(),
            color: surfaces.iter().find_map(|(factor, _)| color((*factor)?)),
            image: texture.and_then(image),
            transform: transform.and_then(affine_map),
        }
    };
    pairs.map(material).collect()
}

/// The rows of the affine map of a transform of a texture: scaled, then turned, then moved; `None` for
/// the identity.
fn affine_map(transform: &Value) -> Option<[[f64; 3]; 2]> {
    let pair = |name: &str, missing: f64| {
        let list = transform.get(name);
        [0, 1].map(|k| {
            list.and_then(|list| list.get(k)?.as_f64())
                .unwrap_or(missing)
        })
    };
    let ([x, y], [s, t]) = (pair("offset", 0.0), pair("scale", 1.0));
    let angle = transform.get("rotation").and_then(Value::as_f64);
    // counter-clockwise, while the second coordinate is downwards
    let (sin, cos) = angle.unwrap_or(0.0).sin_cos();
    let rows = [[cos * s, sin * t, x], [-sin * s, cos * t, y]];
    (rows != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).then_some(rows)
}

/// Whether materials have only a colour and an image of it.
pub(in super::super) fn are_plain(all: &GltfMaterials) -> bool {
    let has_only = |value: Option<&Value>, known: &[&str]| {
        let object = value.and_then(Value::as_object);
        object.is_none_or(|object| object.keys().all(|key| known.contains(&key.as_str())))
    };
    let of_surface = [
        "baseColorFactor",
        "baseColorTexture",
        "metallicFactor",
        "roughnessFactor",
    ];
    let is_plain = |material: &Value| {
        let surface = material.get("pbrMetallicRoughness");
        let texture = surface.and_then(|surface| surface.get("baseColorTexture"));
        has_only(
            Some(material),
            &["name", "pbrMetallicRoughness", "alphaMode"],
        ) && has_only(surface, &of_surface)
            && has_only(texture, &["index", "texCoord"])
    };
    let list = all.json.get("materials").and_then(Value::as_array);
    list.into_iter().flatten().all(is_plain)
}

/// The image files that materials refer to.
pub(in super::super) fn companions(attributes: &Attributes) -> BTreeSet<String> {
    let json = attributes.gltf_materials.iter().map(|all| &all.json);
    let images = json.filter_map(|json| json.get("images")?.as_array());
    let uris = images
        .flatten()
        .filter_map(|image| image.get("uri")?.as_str());
    uris.filter(|uri| is_file(uri)).map(unescaped).collect()
}

/// The same materials with new names of their image files.
pub(in super::super) fn renamed(
    given: &GltfMaterials,
    mut new_name: impl FnMut(&str) -> String,
) -> GltfMaterials {
    let mut all = given.clone();
    for image in list_mut(&mut all.json, "images") {
        let uri = image.get("uri").and_then(Value::as_str);
        let Some(name) = uri.filter(|uri| is_file(uri)).map(unescaped) else {
            continue;
        };
        let new = new_name(&name);
        if new != name {
            image["uri"] = escaped(&new).into();
        }
    }
    all
}

/// Whether a URI is the relative path of a file.
fn is_file(uri: &str) -> bool {
    !uri.starts_with(DATA) && !uri.contains("://")
}
