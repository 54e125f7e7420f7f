//! Wavefront OBJ.

mod colors;
mod materials;
mod read;
mod remarks;
mod tags;
mod write;

pub(super) use materials::look_up;
pub(super) use read::read;
pub(super) use write::write;
