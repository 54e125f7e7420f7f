//! Material libraries: notes for the load report, and the files that they refer to. Their names are
//! kept and their contents are not changed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::mesh::{Attributes, ImageSource, Material, Soup};

/// Maximum size of a material library in bytes. A library usually has a few kilobytes.
const LONGEST: u64 = 1 << 24;

/// Adds notes about missing libraries and undefined materials.
pub(in super::super) fn look_up(path: &Path, soup: &mut Soup) {
    let directory = path.parent().unwrap_or(Path::new(""));
    let mut defined = BTreeSet::new();
    for entry in &soup.attributes.material_libraries {
        for name in library_names(directory, entry) {
            match read_library(&directory.join(&name)) {
                Some(bytes) => defined.extend(material_names(&bytes)),
                None => soup.notes.push(format!(
                    "the material library '{name}' is not in the directory of the \
                                   file"
                )),
            }
        }
    }
    let tags = &soup.attributes.tags;
    let used: BTreeSet<&str> = tags.iter().map(|tag| tag.material.as_str()).collect();
    let unknown: Vec<String> = used
        .into_iter()
        .filter(|name| !name.is_empty() && !defined.contains(*name))
        .map(|name| format!("'{name}'"))
        .collect();
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        soup.notes.push(format!(
            "materials without a definition, names kept: {names}"
        ));
    }
}

/// Names of the material libraries of a file in `folder`, and of the images that these refer to.
pub(in super::super) fn companions(folder: &Path, attributes: &Attributes) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in &attributes.material_libraries {
        for library in library_names(folder, entry) {
            let path = folder.join(&library);
            if let Some(bytes) = read_library(&path) {
                // images are relative to the library
                let beside = Path::new(&library).parent().unwrap_or(Path::new(""));
                let at = folder.join(beside);
                let images = image_names(&bytes).map(|name| local_name(&at, &name));
                names.extend(images.map(|name| beside.join(name).to_string_lossy().into_owned()));
                names.insert(library);
            }
        }
    }
    names
}

/// The materials of the libraries of a file in `folder`; of several with one name the first.
pub(in super::super) fn materials(folder: &Path, attributes: &Attributes) -> Vec<Material> {
    let mut all: Vec<Material> = Vec::new();
    for entry in &attributes.material_libraries {
        for library in library_names(folder, entry) {
            let path = folder.join(&library);
            let Some(bytes) = read_library(&path) else {
                continue;
            };
            // images are relative to the library
            let beside = path.parent().unwrap_or(Path::new(""));
            all.extend(materials_of(&String::from_utf8_lossy(&bytes), beside));
        }
    }
    let mut seen = BTreeSet::new();
    all.retain(|material| seen.insert(material.name.clone()));
    // faces of a file that names no material have the only one that there is
    let own = attributes.own_materials.iter();
    let own: BTreeSet<&str> = own.map(|material| material.name.as_str()).collect();
    let names_none =
        (attributes.tags.iter()).all(|tag| tag.material.is_empty() || own.contains(&*tag.material));
    if let ([only], true) = (&all[..], names_none) {
        let nameless = Material {
            name: String::new(),
            ..only.clone()
        };
        all.push(nameless);
    }
    all
}

/// The name of a file with separators of this system, if that is where the file is: programs on Windows
/// write `\`. A file of another machine with the path of its disk is looked for beside the mesh.
fn local_name(folder: &Path, name: &str) -> String {
    if !name.contains('\\') || folder.join(name).is_file() {
        return name.to_owned();
    }
    let local = name.replace('\\', "/");
    let local = local.trim_start_matches("./").to_owned();
    let last = local.rsplit('/').next().unwrap_or_default();
    let is_of_disk = local.as_bytes().get(1) == Some(&b':');
    if is_of_disk && folder.join(last).is_file() {
        last.to_owned()
    } else {
        local
    }
}

/// The materials of a library whose images are relative to `folder`.
fn materials_of(text: &str, folder: &Path) -> Vec<Material> {
    let mut all: Vec<Material> = Vec::new();
    for line in text.lines() {
        let line = line.trim();
        let Some((keyword, rest)) = line.split_once(char::is_whitespace) else {
            continue;
        };
        let rest = rest.trim();
        match (keyword.to_ascii_lowercase().as_str(), all.last_mut()) {
            ("newmtl", _) => all.push(Material {
                name: rest.to_owned(),
                ..Material::default()
            }),
            ("kd", Some(material)) => {
                let numbers = rest.split_whitespace().map_while(|word| word.parse().ok());
                let numbers: Vec<f32> = numbers.collect();
                if let [r, g, b, ..] = numbers[..] {
                    material.color = Some([r, g, b]);
                }
            }
            ("map_kd", Some(material)) => {
                material.image = image_name(line)
                    .map(|name| ImageSource::File(folder.join(local_name(folder, &name))));
            }
            _ => {}
        }
    }
    all
}

/// The lines of a material in the libraries of a mesh, its images left out; `None` if none has it.
pub(in super::super) fn settings(attributes: &Attributes, name: &str) -> Option<String> {
    let folder = attributes.folder.as_deref()?;
    let entries = attributes.material_libraries.iter();
    let mut names = entries.flat_map(|entry| library_names(folder, entry));
    names.find_map(|library| {
        let bytes = read_library(&folder.join(library))?;
        settings_of(&String::from_utf8_lossy(&bytes), name)
    })
}

fn settings_of(text: &str, name: &str) -> Option<String> {
    let defined = |line: &str| {
        let (keyword, rest) = line.trim().split_once(char::is_whitespace)?;
        let is_new = keyword.eq_ignore_ascii_case("newmtl");
        is_new.then(|| rest.trim().to_owned())
    };
    let mut lines = text.lines();
    lines.find(|line| defined(line).as_deref() == Some(name))?;
    let own = lines.take_while(|line| defined(line).is_none());
    let kept = own.filter(|line| !line.trim().is_empty() && image_name(line).is_none());
    Some(kept.fold(String::new(), |all, line| all + line.trim() + "\n"))
}

/// The names of images in a material library.
fn image_names(bytes: &[u8]) -> impl Iterator<Item = String> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let names: Vec<String> = text.lines().filter_map(image_name).collect();
    names.into_iter()
}

/// The name of the image in a line of a material library: what follows the options of a `map_`
/// statement.
fn image_name(line: &str) -> Option<String> {
    const KEYWORDS: [&str; 5] = ["bump", "disp", "decal", "norm", "refl"];
    let (keyword, mut rest) = line.trim().split_once(char::is_whitespace)?;
    let keyword = keyword.to_ascii_lowercase();
    if !keyword.starts_with("map_") && !KEYWORDS.contains(&keyword.as_str()) {
        return None;
    }
    rest = rest.trim_start();
    while rest.starts_with('-') {
        // an option, and its values: numbers, `on` or `off`, or one word
        let (_, after) = rest.split_once(char::is_whitespace)?;
        let (first, mut after) = after.trim_start().split_once(char::is_whitespace)?;
        while first.parse::<f64>().is_ok()
            && let Some((word, others)) = after.trim_start().split_once(char::is_whitespace)
            && word.parse::<f64>().is_ok()
        {
            after = others;
        }
        rest = after.trim_start();
    }
    Some(rest.to_owned())
}

/// An entry is one name that contains blanks, or several names.
fn library_names(directory: &Path, entry: &str) -> Vec<String> {
    let local = local_name(directory, entry);
    if directory.join(&local).is_file() {
        return vec![local];
    }
    entry.split_whitespace().map(str::to_owned).collect()
}

fn read_library(path: &PathBuf) -> Option<Vec<u8>> {
    let metadata = fs::metadata(path).ok()?;
    (metadata.is_file() && metadata.len() <= LONGEST).then(|| fs::read(path).ok())?
}

fn material_names(bytes: &[u8]) -> Vec<String> {
    let name = |line: &[u8]| {
        let rest = line.trim_ascii().strip_prefix(b"newmtl")?;
        Some(String::from_utf8_lossy(rest.trim_ascii()).into_owned())
    };
    bytes.split(|&b| b == b'\n').filter_map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_images_of_materials_are_found() {
        let text = "# a library\nKd 1 1 1\nnewmtl bark\n  Kd 0.5 0.25 0.125 # brown\nKa 1 0 0\n\
                    map_Kd -s 1 1 1 -o 0 0 -clamp on my bark.png\nmap_Bump bark_n.png\n\nnewmtl leaf\n\
                    Kd spectral file.rfl 1\nKd 0 1 0\nnewmtl none\n";
        let found = materials_of(text, Path::new("tree"));
        let material = |name: &str, color, image: Option<&str>| Material {
            name: name.into(),
            color,
            image: image.map(|name| ImageSource::File(name.into())),
            transform: None,
        };
        let bark = Some([0.5, 0.25, 0.125]);
        let expected = [
            material("bark", bark, Some("tree/my bark.png")),
            material("leaf", Some([0.0, 1.0, 0.0]), None),
            material("none", None, None),
        ];
        assert_eq!(found, expected);
    }
}
