//! Files beside a mesh file for images of its materials that are in no file yet, or inside a glTF or 3MF file.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::companions::{NumberedImages, name_of_file};
use super::{Format, SaveError, gltf, materials, obj, save_with};
use crate::mesh::{Attributes, Column, ImageSource, NumberType, Numbers, TEXTURE_NUMBER};

/// The files beside an OBJ or PLY file.
pub(super) struct Beside {
    folder: PathBuf,
    /// Names and contents. The first one of an OBJ file is the material library, which refers to the others.
    files: Vec<NamedFile>,
    /// The attributes with references to the files.
    attributes: Attributes,
}

impl Beside {
    /// Those of the mesh file at `path`; `None` if the attributes need no further reference. No name is that of a
    /// file to which the mesh refers.
    pub fn of(path: &Path, attributes: &Attributes) -> Option<Self> {
        let (files, attributes) = match Format::from_path(path)? {
            Format::Obj => of_obj(path, attributes)?,
            Format::Ply => of_ply(path, attributes)?,
            Format::Stl | Format::Off | Format::Glb | Format::Gltf | Format::ThreeMf => {
                return None;
            }
        };
        Some(Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            files,
            attributes,
        })
    }

    /// The attributes with references to the files.
    pub fn attributes(&self) -> &Attributes {
        &self.attributes
    }

    /// Writes the files.
    ///
    /// # Errors
    /// [`SaveError`] of the first that cannot be written.
    pub fn write(&self) -> Result<(), SaveError> {
        for (name, bytes) in self.files.iter().rev() {
            save_with(&self.folder.join(name), |out| out.write_all(bytes))?;
        }
        Ok(())
    }

    /// The names of the files, for messages.
    pub fn names(&self) -> Vec<String> {
        self.files.iter().map(|(name, _)| name.clone()).collect()
    }
}

/// Names and contents of files, and the attributes that refer to them.
type Referred = (Vec<NamedFile>, Attributes);

/// The name and the contents of a file.
type NamedFile = (String, Arc<Vec<u8>>);

/// A material library, and the images of own materials and of those of glTF and 3MF; `None` without such
/// materials.
fn of_obj(path: &Path, attributes: &Attributes) -> Option<Referred> {
    let own = &attributes.own_materials;
    if own.is_empty() && attributes.gltf_materials.is_none() {
        return None;
    }
    let mut new = NewFiles::new(path, attributes)?;
    let library = new.name("meniscus", "mtl");
    let mut text = String::from("# written by Meniscus\n");
    let mut add = |name: &str, settings: &str, bytes: Option<Arc<Vec<u8>>>| {
        // writing to a string cannot fail
        let _ = write!(text, "newmtl {name}\n{settings}");
        if let Some(bytes) = bytes {
            let _ = writeln!(text, "map_Kd {}", new.image(name, bytes));
        }
    };
    for material in own {
        let settings = obj::settings(attributes, &material.like);
        let settings = settings.unwrap_or_else(|| "Kd 1 1 1\n".to_owned());
        add(&material.name, &settings, Some(Arc::clone(&material.png)));
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
        add(&material.name, &format!("Kd {r} {g} {b}\n"), bytes);
    }
    let mut all = attributes.clone();
    all.material_libraries.push(library.clone());
    new.files.insert(0, (library, text.into_bytes().into()));
    Some((new.files, all))
}

/// The images that are in no file. Comments name these and the images of material libraries, and the property
/// `texnumber` of a face is the number of its image, -1 without one, as `MeshLab` reads and writes it. It is left
/// out where all faces have the first image. `None` if the mesh lists all its images.
fn of_ply(path: &Path, attributes: &Attributes) -> Option<Referred> {
    let NumberedImages { new, of_face } = NumberedImages::of(attributes);
    if new.is_empty() {
        return None;
    }
    let mut files = NewFiles::new(path, attributes)?;
    let mut all = attributes.clone();
    for (image, material) in new {
        let name = match image {
            ImageSource::File(path) => name_of_file(attributes, &path),
            ImageSource::Bytes(bytes) => files.image(&material, bytes),
        };
        all.comments.push(format!("comment TextureFile {name}"));
    }
    all.own_materials.clear();
    let columns = &mut all.faces.columns;
    if let Some(column) = columns
        .iter_mut()
        .find(|column| column.name == TEXTURE_NUMBER)
    {
        let listed = attributes.texture_files().count();
        let is_new = |&(_, number): &(usize, usize)| number >= listed;
        let numbers = of_face.iter().enumerate();
        let numbers = numbers.filter_map(|(face, number)| Some((face, (*number)?)));
        for (face, number) in numbers.filter(is_new) {
            column.numbers.set(face, number as f64);
        }
    } else if of_face.iter().any(|number| *number != Some(0)) {
        let mut numbers = Numbers::with_capacity(NumberType::I32, of_face.len());
        for number in of_face {
            numbers.push(number.map_or(-1.0, |number| number as f64));
        }
        columns.push(Column {
            name: TEXTURE_NUMBER.to_owned(),
            numbers,
            is_typed: true,
        });
    }
    Some((files.files, all))
}

/// New files beside a mesh file.
struct NewFiles {
    /// The name of the mesh file without its extension.
    stem: String,
    /// Names of other files to which the mesh refers, and of new ones.
    taken: Vec<String>,
    files: Vec<NamedFile>,
}

impl NewFiles {
    fn new(path: &Path, attributes: &Attributes) -> Option<Self> {
        let mut taken = attributes.material_libraries.clone();
        taken.extend(attributes.texture_files().map(str::to_owned));
        if let Some(folder) = &attributes.folder {
            taken.extend(obj::companions(folder, attributes));
            taken.extend(gltf::companions(attributes));
        }
        Some(Self {
            stem: path.file_stem()?.to_string_lossy().into_owned(),
            taken,
            files: Vec::new(),
        })
    }

    /// A new name that begins with that of the mesh file.
    fn name(&mut self, end: &str, extension: &str) -> String {
        let stem = format!("{}_{end}", self.stem);
        let numbered = (2..).map(|n| format!("{stem}_{n}.{extension}"));
        let mut names = std::iter::once(format!("{stem}.{extension}")).chain(numbered);
        let name = names.find(|name| !self.taken.contains(name));
        let name = name.expect("endless names");
        self.taken.push(name.clone());
        name
    }

    /// The name of the file of the image of a material.
    fn image(&mut self, material: &str, bytes: Arc<Vec<u8>>) -> String {
        let known = self.files.iter().find(|(_, other)| *other == bytes);
        if let Some((name, _)) = known {
            return name.clone();
        }
        let is_safe = |c: char| !c.is_control() && !"/\\:".contains(c);
        let safe = material.replace(|c| !is_safe(c), "_");
        let name = self.name(&safe, extension(&bytes));
        self.files.push((name.clone(), bytes));
        name
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
