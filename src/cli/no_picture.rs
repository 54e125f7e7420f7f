//! Replaces `result_picture.rs` if the feature `render` is off.

use std::path::Path;

use anyhow::Result;
use clap::Args;

use crate::mesh::{Mesh, VertexId};

/// No options: this program draws no pictures.
#[derive(Clone, Debug, Default, Args)]
pub struct ResultPicture {}

#[expect(
    clippy::unused_self,
    clippy::unnecessary_wraps,
    reason = "as with pictures"
)]
impl ResultPicture {
    /// No file.
    pub fn path(&self) -> Option<&Path> {
        None
    }

    /// Nothing to refuse.
    pub fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Nothing to write.
    pub fn save(&self, _: &Mesh, _: usize, _: Vec<[VertexId; 2]>) -> Result<()> {
        Ok(())
    }
}
