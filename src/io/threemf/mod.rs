//! 3MF: a ZIP archive with XML.
//!
//! The objects of the build are read, at the places of their items and components, with base materials,
//! colour groups and textures of the materials extension, and objects in other parts of the archive
//! (production extension). Materials and textures become those of [`GltfMaterials`](crate::mesh::GltfMaterials).
//! Coordinates are decimals and exact.
//!
//! Specification: <https://github.com/3MFConsortium/spec_core>.

mod model;
mod package;
mod read;
mod write;

pub(super) use read::read;
pub(super) use write::{Sheet, face_columns, losses, write};

/// Namespaces of the core and of the materials and production extensions.
const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const MATERIALS: &str = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
const PRODUCTION: &str = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

/// Types of relationships: to the model, and from it to a texture.
const MODEL_RELATION: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
const TEXTURE_RELATION: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture";

/// The part with the relationships of the archive.
const RELATIONS: &str = "_rels/.rels";

/// Tile styles of textures, with the values of a sampler of glTF. The first is the default.
const TILES: [(&str, u64); 4] = [
    ("wrap", 10497),
    ("mirror", 33648),
    ("clamp", 33071),
    // glTF has no images that end
    ("none", 33071),
];
