//! Wavefront OBJ.

mod corners;
mod extras;
mod ignored_statements;
mod materials;
mod read;
mod tags;
mod write;

pub(super) use materials::{companions, look_up, materials, renamed_libraries, settings};
pub(super) use read::read;
pub(super) use write::write;
