//! Materials of a mesh whose images are in no file yet: the files beside an OBJ file that they become.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{SaveError, obj, save_with};
use crate::mesh::{Attributes, OwnMaterial};

/// The files of the own materials of a mesh that is written to an OBJ file.
pub(super) struct Beside {
    folder: PathBuf,
    /// The name of the material library, and its text.
    library: (String, String),
    /// Names and bytes of the images.
    images: Vec<(String, Vec<u8>)>,
}

impl Beside {
    /// Those of the OBJ file at `path`; `None` without own materials. No name is that of a file to which
    /// the mesh refers.
    pub fn of(path: &Path, attributes: &Attributes) -> Option<Self> {
        let own = &attributes.own_materials;
        if own.is_empty() {
            return None;
        }
        let stem = path.file_stem()?.to_string_lossy().into_owned();
        let mut taken = attributes.material_libraries.clone();
        if let Some(folder) = &attributes.folder {
            taken.extend(obj::companions(folder, attributes));
        }
        let mut new_name = |stem: &str, extension: &str| {
            let numbered = (2..).map(|n| format!("{stem}_{n}.{extension}"));
            let mut names = std::iter::once(format!("{stem}.{extension}")).chain(numbered);
            let name = names.find(|name| !taken.contains(name));
            let name = name.expect("endless names");
            taken.push(name.clone());
            name
        };
        let library = new_name(&format!("{stem}_meniscus"), "mtl");
        let mut images: Vec<(String, &OwnMaterial)> = Vec::new();
        let mut text = String::from("# written by Meniscus\n");
        for material in own {
            let known = images.iter().find(|(_, other)| other.png == material.png);
            let image = if let Some((name, _)) = known {
                name.clone()
            } else {
                let name = new_name(&format!("{stem}_{}", material.name), "png");
                images.push((name.clone(), material));
                name
            };
            let settings = obj::settings(attributes, &material.like);
            let settings = settings.unwrap_or_else(|| "Kd 1 1 1\n".to_owned());
            let name = &material.name;
            // writing to a string cannot fail
            let _ = write!(text, "newmtl {name}\n{settings}map_Kd {image}\n");
        }
        let bytes = |(name, material): (String, &OwnMaterial)| (name, (*material.png).clone());
        Some(Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            images: images.into_iter().map(bytes).collect(),
            library: (library, text),
        })
    }

    /// The attributes with a reference to the material library.
    pub fn referred(&self, attributes: &Attributes) -> Attributes {
        let mut all = attributes.clone();
        all.material_libraries.push(self.library.0.clone());
        all
    }

    /// Writes the files.
    ///
    /// # Errors
    /// [`SaveError`] of the first that cannot be written.
    pub fn write(&self) -> Result<(), SaveError> {
        let library = (&self.library.0, self.library.1.as_bytes());
        let images = self.images.iter().map(|(name, bytes)| (name, &bytes[..]));
        for (name, bytes) in images.chain([library]) {
            save_with(&self.folder.join(name), |out| out.write_all(bytes))?;
        }
        Ok(())
    }

    /// The names of the files, for messages.
    pub fn names(&self) -> Vec<&str> {
        let images = self.images.iter().map(|(name, _)| name.as_str());
        std::iter::once(self.library.0.as_str())
            .chain(images)
            .collect()
    }
}
