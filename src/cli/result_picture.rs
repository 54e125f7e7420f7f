//! The picture of a result: `--picture` and its options.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;

use crate::cli::UsageError;
use crate::cli::picture::Shot;
use crate::cli::picture_args::PictureArguments;
use crate::mesh::{Mesh, VertexId};
use crate::render::{Gpu, save_png};

/// The options of `fill`, `blend` and `refill` for a picture.
#[derive(Clone, Debug, Default, Args)]
pub struct ResultPicture {
    /// Write a picture of the result as PNG, with tinted patches.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    look: PictureArguments,
}

impl ResultPicture {
    /// The file to write.
    pub fn path(&self) -> Option<&Path> {
        self.picture.as_deref()
    }

    /// Refuses picture options without `--picture`, and options that contradict each other.
    pub fn check(&self) -> Result<()> {
        if self.picture.is_none() && self.look.given() {
            let message = "picture options need --picture FILE.png";
            return Err(UsageError(message.into()).into());
        }
        self.look.check()
    }

    /// Writes the picture, if requested. The arguments are those of [`Shot::new`].
    pub fn save(
        &self,
        mesh: &Mesh,
        first_patch_face: usize,
        creases: Vec<[VertexId; 2]>,
    ) -> Result<()> {
        let Some(path) = &self.picture else {
            return Ok(());
        };
        let shot = Shot::new(mesh, first_patch_face, creases, &self.look)?;
        Ok(save_png(path, &shot.take(&Gpu::new()?, &shot.camera)?)?)
    }
}
