//! Files that a mesh file refers to: material libraries and texture images.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
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
    /// Paths out of the folder of the mesh, which lead to no file from the folder of the written mesh.
    pub outside: Vec<String>,
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
    if real(from) == real(to) {
        return companions;
    }
    let names: BTreeSet<String> = match Format::from_path(path) {
        Some(Format::Obj) => obj::companions(from, attributes),
        Some(Format::Ply) => {
            let named = attributes.texture_files().map(str::to_owned);
            let new = NumberedImages::of(attributes).new.into_iter();
            let new = new.filter_map(|(image, _)| match image {
                ImageSource::File(path) => Some(name_of_file(attributes, &path)),
                ImageSource::Bytes(_) => None,
            });
            named.chain(new).collect()
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
            Ok(Copied::Outside) => {
                companions.outside.push(name.clone());
                "its path leaves the folder of the input; write the output to the folder of the input".to_owned()
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

/// The attributes of a mesh that is written to `path` while its material libraries and images stay where they are:
/// with the paths of these from the folder of `path`. Absolute paths, and those that lead to no file, are the
/// same. Also returns a message for the user if a file has no such path.
pub(super) fn kept<'a>(
    path: &Path,
    attributes: &'a Attributes,
) -> (Cow<'a, Attributes>, Option<String>) {
    let to = path.parent().unwrap_or(Path::new(""));
    let from = attributes.folder.as_deref();
    let (Some(from), Some(real_from), Some(real_to)) = (from, from.and_then(real), real(to)) else {
        return (Cow::Borrowed(attributes), None);
    };
    if real_from == real_to {
        return (Cow::Borrowed(attributes), None);
    }
    let mut unresolved: Vec<String> = Vec::new();
    let mut moved = |name: &str| {
        if Path::new(name).is_absolute() || !from.join(name).is_file() {
            return name.to_owned();
        }
        relative(&real_from, name, &real_to).unwrap_or_else(|| {
            unresolved.push(name.to_owned());
            name.to_owned()
        })
    };
    let mut all = attributes.clone();
    all.material_libraries = obj::renamed_libraries(from, attributes, &mut moved);
    all.rename_texture_files(&mut moved);
    if let Some(given) = &attributes.gltf_materials {
        all.gltf_materials = Some(Arc::new(gltf::renamed(given, &mut moved)));
    }
    if unresolved.is_empty() {
        all.folder = Some(to.to_owned());
        return (Cow::Owned(all), None);
    }
    let names = unresolved.join("', '");
    let message = format!("no relative path leads to '{names}'; write to the drive of the input");
    (Cow::Borrowed(attributes), Some(message))
}

/// The path, from the folder `to`, of a file that has the path `name` from the folder `from`. Both folders are
/// [`real`]. `None` if they are on two drives, or have names that are no text.
fn relative(from: &Path, name: &str, to: &Path) -> Option<String> {
    let (mut from, mut name) = (from, Path::new(name));
    while let Ok(rest) = name.strip_prefix("..") {
        from = from.parent().unwrap_or(from);
        name = rest;
    }
    let file = from.join(name);
    let pairs = file.components().zip(to.components());
    let common = pairs.take_while(|(a, b)| a == b).count();
    let up = to.iter().skip(common).map(|_| OsStr::new(".."));
    let parts = up.chain(file.iter().skip(common)).map(OsStr::to_str);
    let parts: Vec<&str> = parts.collect::<Option<_>>()?;
    (common > 0).then(|| parts.join("/"))
}

/// The absolute path of a folder, without links.
fn real(folder: &Path) -> Option<PathBuf> {
    let is_current = folder.as_os_str().is_empty();
    fs::canonicalize(if is_current { Path::new(".") } else { folder }).ok()
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
        all.extend(listed_images(attributes).map(|(material, image)| Material {
            name: material.to_owned(),
            image: Some(ImageSource::File(folder.join(image))),
            ..Material::default()
        }));
    }
    all
}

/// The names of the materials of the texture images that a PLY file lists, and those of the images. The first
/// material has no name, because it is that of faces without a material.
fn listed_images(attributes: &Attributes) -> impl Iterator<Item = (&str, &str)> {
    let names = attributes.texture_files().enumerate();
    names.map(|(k, name)| (if k == 0 { "" } else { name }, name))
}

/// The images of the faces of a mesh in the list of a PLY file.
pub(super) struct NumberedImages {
    /// The images behind those that the mesh lists already, each with the name of a material that has it.
    pub new: Vec<(ImageSource, String)>,
    /// For each face with texture coordinates the number of its image, if it has one.
    pub of_face: Vec<Option<usize>>,
}

impl NumberedImages {
    /// Those of a mesh. Images of own materials are the last.
    pub fn of(attributes: &Attributes) -> Self {
        let rows = &attributes.faces.texture;
        // if vertices have texture coordinates, all faces have
        let of_vertices = rows.is_empty() && attributes.has_texture();
        let count = if of_vertices {
            attributes.faces.tags.len()
        } else {
            rows.len() / 3
        };
        let is_placed =
            |face: usize| of_vertices || !rows[3 * face..3 * face + 3].contains(&NO_VALUE);
        let name = |face: usize| is_placed(face).then(|| attributes.material_of(face));
        let names: Vec<Option<&str>> = (0..count).map(name).collect();
        let used: BTreeSet<&str> = names.iter().copied().flatten().collect();
        let listed = listed_images(attributes).zip(0..);
        let mut number_of: BTreeMap<String, usize> = listed
            .map(|((material, _), number)| (material.to_owned(), number))
            .collect();
        let count = attributes.texture_files().count();
        let mut all = materials(attributes);
        all.rotate_left(attributes.own_materials.len());
        let mut new: Vec<(ImageSource, String)> = Vec::new();
        for Material { name, image, .. } in all {
            let is_new = used.contains(&*name) && !number_of.contains_key(&name);
            let Some(image) = image.filter(|_| is_new) else {
                continue;
            };
            let known = new.iter().position(|(other, _)| *other == image);
            let place = known.unwrap_or_else(|| {
                new.push((image, name.clone()));
                new.len() - 1
            });
            number_of.insert(name, count + place);
        }
        let number = |name: Option<&str>| number_of.get(name?).copied();
        Self {
            of_face: names.into_iter().map(number).collect(),
            new,
        }
    }
}

/// The name of an image file relative to the folder of the mesh file.
pub(super) fn name_of_file(attributes: &Attributes, path: &Path) -> String {
    let folder = attributes.folder.as_deref();
    let name = folder.and_then(|folder| path.strip_prefix(folder).ok());
    name.unwrap_or(path).to_string_lossy().into_owned()
}

/// What became of a file.
enum Copied {
    Now,
    /// It is there, or does not exist.
    NotNeeded,
    /// Another file has its name.
    OtherThere,
    /// Its path leaves the folder.
    Outside,
}

/// Copies a file into a folder, under a name relative to it.
fn copy(source: &Path, folder: &Path, name: &Path) -> Result<Copied, String> {
    let contents = match fs::read(source) {
        Ok(contents) => contents,
        // a missing file was missing before
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Copied::NotNeeded),
        Err(error) => return Err(error.to_string()),
    };
    let target: PathBuf = folder.join(name);
    let is_inside = is_inside(name);
    // before the target is read, because a path through a missing folder leads nowhere
    if let (true, Some(parent)) = (is_inside, target.parent()) {
        fs::create_dir_all(parent).map_err(|error| error.to_string())?;
    }
    match fs::read(&target) {
        // an absolute path leads to the source itself
        Ok(there) if there == contents => return Ok(Copied::NotNeeded),
        Ok(_) => return Ok(Copied::OtherThere),
        Err(_) if is_inside => {}
        Err(_) => return Ok(Copied::Outside),
    }
    super::save_with(&target, |out| out.write_all(&contents))
        .map_err(|error| error.kind.to_string())?;
    Ok(Copied::Now)
}

/// Whether a path never leaves the folder to which it is relative.
fn is_inside(name: &Path) -> bool {
    let mut depth = 0;
    name.components().all(|component| {
        depth += match component {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            Component::RootDir | Component::Prefix(_) => return false,
        };
        depth >= 0
    })
}
