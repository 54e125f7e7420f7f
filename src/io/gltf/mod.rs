//! glTF 2.0, binary (`.glb`) and as JSON (`.gltf`).
//!
//! The meshes of the default scene are read, at the places of their nodes. Vertices of the file stay
//! separate in the soup where exporters repeat them for another normal, colour or texture coordinate;
//! `mesh::build` joins them. Texture coordinates and normals are tables with a row for each vertex of
//! the file, so the writer finds the order of the file again.
//!
//! Colours of the format are light, and those of the mesh are signals with the transfer function of
//! sRGB. Single precision numbers are the same after both conversions, up to ten where the pieces of this
//! function meet.
//!
//! Specification: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html>.

mod buffers;
mod materials;
mod read;
mod schema;
mod write;

pub(super) use materials::{are_plain, companions, materials, renamed};
pub(super) use read::read;
pub(super) use write::{losses, vertex_columns, write};

/// Magic number of a binary file, and the types of its chunks.
const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";

/// Values of `componentType`.
const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// Start of the URI of data in the file, for any type of media.
const DATA: &str = "data:";

/// Extensions that replace the data of accessors or buffers.
const COMPRESSIONS: [&str; 3] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];
