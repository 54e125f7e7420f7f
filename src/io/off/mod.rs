//! OFF, the object file format of Geomview, as text: vertices with normals (N), colours (C) and texture
//! coordinates (ST), and faces with colours.

mod read;
mod write;

pub(super) use read::read;
pub(super) use write::{face_columns, write};

/// Names of the columns of normals, colours and texture coordinates.
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const COLOR: [&str; 4] = ["red", "green", "blue", "alpha"];
const TEXTURE: [&str; 2] = ["s", "t"];

/// Names of the columns of vertices that OFF stores besides colours.
pub(super) const VERTEX_NUMBERS: [&str; 5] = ["nx", "ny", "nz", "s", "t"];
