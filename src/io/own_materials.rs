//! Materials that are in no material library yet: the files beside an OBJ file that they become.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::{SaveError, gltf, materials, obj, save_with};
use crate::mesh::Attributes;

/// The files of the own materials, and of those of glTF and 3MF, of a mesh that is written to an OBJ file.
pub(super) struct Beside {
    folder: PathBuf,
    /// The name of the material library, and its text.
    library: (String, String),
    /// Names and bytes of the images.
    images: Vec<(String, Vec<u8>)>,
}

impl Beside {
    /// Those of the OBJ file at `path`; `None` without such materials. No name is that of a file to which
    /// the mesh refers.
    pub fn of(path: &Path, attributes: &Attributes) -> Option<Self> {
        let own = &attributes.own_materials;
        if own.is_empty() && attributes.gltf_materials.is_none() {
            return None;
        }
        let stem = path.file_stem()?.to_string_lossy().into_owned();
        let mut taken = attributes.material_libraries.clone();
        if let Some(folder) = &attributes.folder {
            taken.extend(obj::companions(folder, attributes));
            taken.extend(gltf::companions(attributes));
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
        let mut images: Vec<(String, Vec<u8>)> = Vec::new();
        let mut text = String::from("# written by Meniscus\n");
        let mut add = |name: &str, settings: &str, bytes: Option<Vec<u8>>| {
            // writing to a string cannot fail
            let _ = write!(text, "newmtl {name}\n{settings}");
            let Some(bytes) = bytes else { return };
            let known = images.iter().find(|(_, other)| *other == bytes);
            let image = if let Some((image, _)) = known {
                image.clone()
            } else {
                let is_safe = |c: char| !c.is_control() && !"/\\:".contains(c);
                let safe = name.replace(|c| !is_safe(c), "_");
                let image = new_name(&format!("{stem}_{safe}"), extension(&bytes));
                images.push((image.clone(), bytes));
                image
            };
            let _ = writeln!(text, "map_Kd {image}");
        };
        for material in own {
            let settings = obj::settings(attributes, &material.like);
            let settings = settings.unwrap_or_else(|| "Kd 1 1 1\n".to_owned());
            add(&material.name, &settings, Some((*material.png).clone()));
        }
        let is_own = |name: &str| own.iter().any(|other| other.name == name);
        let given = attributes.gltf_materials.iter();
        for material in given.flat_map(|_| materials(attributes)) {
            if is_own(&material.name) {
                continue;
            }
            let [r, g, b] = material.color.unwrap_or([1.0; 3]);
            // an image that cannot be read could not be read before
            let bytes = material.image.as_ref().and_then(|image| image.bytes().ok());
            let bytes = bytes.map(std::borrow::Cow::into_owned);
            add(&material.name, &format!("Kd {r} {g} {b}\n"), bytes);
        }
        Some(Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            images,
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
    pub fn names(&self) -> Vec<String> {
        let images = self.images.iter().map(|(name, _)| name);
        let names = std::iter::once(&self.library.0).chain(images);
        names.cloned().collect()
    }
}

/// The extension of the file of an image.
fn extension(bytes: &[u8]) -> &'static str {
    match bytes {
        [0xff, 0xd8, 0xff, ..] => "jpg",
        [b'R', b'I', b'F', b'F', ..] => "webp",
        _ => "png",
    }
}
