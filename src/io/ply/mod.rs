//! Stanford PLY.

mod columns;
mod header;
mod read;
mod source;
mod vertices;
mod write;

pub(super) use read::read;
pub(super) use write::write;
