//! Files that a mesh file refers to: material libraries and texture images.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use super::{Format, gltf, obj};
use crate::mesh::{Attributes, ImageSource, Material, NO_VALUE};

/// What became of the files to which a written mesh refers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Companions {
    /// Messages for the user: what was copied and what could not be copied.
    pub messages: Vec<String>,
    /// The names of files that were not copied because other files have them. The written mesh refers to
    /// these.
    pub others: Vec<String>,
}

/// Copies the material libraries of an OBJ file and the texture images of an OBJ, PLY or glTF file beside
/// `path`, where a mesh with these attributes was written, so that its references stay valid. Files in
/// the folder of `path` are never replaced.
///
/// Nothing is copied if the mesh was read from that folder, or if its folder is unknown.
pub fn copy_companions(path: &Path, attributes: &Attributes) -> Companions {
    let mut companions = Companions::default();
    let Some(from) = &attributes.folder else {
        return companions;
    };
    let to = path.parent().unwrap_or(Path::new(""));
    let resolved = |folder: &Path| {
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        fs::canonicalize(folder).ok()
    };
    if resolved(from) == resolved(to) {
        return companions;
    }
    let names: BTreeSet<String> = match Format::from_path(path) {
        Some(Format::Obj) => obj::companions(from, attributes),
        Some(Format::Ply) => {
            let named = attributes.texture_files().map(str::to_owned);
            named.chain(only_image(attributes)).collect()
        }
        Some(Format::Glb | Format::Gltf) => gltf::companions(attributes),
        _ => BTreeSet::new(),
    };
    let mut copied = Vec::new();
    for name in names {
        let reason = match copy(&from.join(&name), to, Path::new(&name)) {
            Ok(Copied::Now) => {
                copied.push(name);
                continue;
            }
            Ok(Copied::NotNeeded) => continue,
            Ok(Copied::OtherThere) => {
                companions.others.push(name.clone());
                "another file of this name is there and was not changed".to_owned()
            }
            Err(reason) => reason,
        };
        let message = format!("'{name}' was not copied: {reason}");
        companions.messages.push(message);
    }
    if !copied.is_empty() {
        let names = copied.join("', '");
        let from = if from.as_os_str().is_empty() {
            "the current folder".to_owned()
        } else {
            from.display().to_string()
        };
        let message = format!("copied from {from}: '{names}'");
        companions.messages.insert(0, message);
    }
    companions
}

/// The materials of a mesh: its own, those of a glTF or 3MF file and of the libraries of an OBJ file, and for
/// the first texture image of a PLY file one without a name, which is that of faces without a material, and
/// for others ones with the names of their files. Other files are looked for in the folder of the mesh file, and not at all if that is unknown.
pub fn materials(attributes: &Attributes) -> Vec<Material> {
    let own = attributes.own_materials.iter().map(|material| Material {
        name: material.name.clone(),
        image: Some(ImageSource::Bytes(Arc::clone(&material.png))),
        ..Material::default()
    });
    let mut all: Vec<Material> = own.collect();
    let folder = attributes.folder.as_deref();
    if let Some(of_file) = &attributes.gltf_materials {
        all.extend(gltf::materials(folder, of_file));
    } else if let Some(folder) = folder {
        all.extend(obj::materials(folder, attributes));
        all.extend(
            attributes
                .texture_files()
                .enumerate()
                .map(|(k, name)| Material {
                    name: if k == 0 {
                        String::new()
                    } else {
                        name.to_owned()
                    },
                    image: Some(ImageSource::File(folder.join(name))),
                    ..Material::default()
                }),
        );
    }
    all
}

/// The only image file of the faces with texture coordinates, under its name relative to the folder of the
/// mesh file, for a format that names images and not materials. `None` if there is none or several, or if
/// the mesh names image files itself.
pub(super) fn only_image(attributes: &Attributes) -> Option<String> {
    if attributes.texture_files().next().is_some() {
        return None;
    }
    let folder = attributes.folder.as_deref()?;
    let faces = &attributes.faces;
    let corners = faces.texture.chunks_exact(3).enumerate();
    let textured = corners.filter(|(_, rows)| !rows.contains(&NO_VALUE));
    let names: BTreeSet<&str> = textured
        .map(|(face, _)| attributes.material_of(face))
        .collect();
    let own = &attributes.own_materials;
    let is_used = |material: &Material| {
        names.contains(&*material.name) && own.iter().all(|own| own.name != material.name)
    };
    let used = materials(attributes).into_iter().filter(is_used);
    let mut images: Vec<ImageSource> = used.filter_map(|material| material.image).collect();
    images.sort();
    images.dedup();
    let [ImageSource::File(path)] = &images[..] else {
        return None;
    };
    let name = path.strip_prefix(folder).unwrap_or(path);
    Some(name.to_string_lossy().into_owned())
}

/// What became of a file.
enum Copied {
    Now,
    /// It is there, or does not exist.
    NotNeeded,
    /// Another file has its name.
    OtherThere,
}

/// Copies a file into a folder, under a name relative to it.
fn copy(source: &Path, folder: &Path, name: &Path) -> Result<Copied, String> {
    let is_inside = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    if !name.components().all(is_inside) {
        return Err("its path leaves the folder of the mesh; copy it by hand".to_owned());
    }
    let contents = match fs::read(source) {
        Ok(contents) => contents,
        // a missing file was missing before
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Copied::NotNeeded),
        Err(error) => return Err(error.to_string()),
    };
    let target: PathBuf = folder.join(name);
    match fs::read(&target) {
        Ok(there) if there == contents => return Ok(Copied::NotNeeded),
        Ok(_) => return Ok(Copied::OtherThere),
        Err(_) => {}
    }
    if let Some(parent) = target.parent() {
        fs::create_dir_all(parent).map_err(|error| error.to_string())?;
    }
    super::save_with(&target, |out| out.write_all(&contents))
        .map_err(|error| error.kind.to_string())?;
    Ok(Copied::Now)
}
