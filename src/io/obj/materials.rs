//! Material libraries: notes for the load report, and the files that they refer to. Their names are
//! kept and their contents are not changed.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::mesh::{Attributes, ImageSource, Material, Soup};

/// Maximum size of a material library in bytes. A library usually has a few kilobytes.
const LONGEST: u64 = 1 << 24;

/// These messages say what is left out of a library, and the remedy.
const NO_COLOR: &str = "the colour is not one or three finite numbers and is left out; write red, \
                        green and blue from 0 to 1, as in 'Kd 0.8 0.8 0.8'";
const NO_IMAGE: &str = "the name of an image is missing; write it after 'map_Kd'";
const NO_NAME: &str = "the material has no name and is left out; write one after 'newmtl'";

/// Adds notes about missing libraries, lines of libraries that are left out, and undefined materials.
pub(in super::super) fn look_up(path: &Path, soup: &mut Soup) {
    let directory = path.parent().unwrap_or(Path::new(""));
    let mut defined = BTreeSet::new();
    for entry in &soup.attributes.material_libraries {
        for name in library_names(directory, entry) {
            let Some(bytes) = read_library(&directory.join(&name)) else {
                soup.notes.push(format!(
                    "the material library '{name}' is not in the directory of the file"
                ));
                continue;
            };
            let (found, faults) = materials_of(&String::from_utf8_lossy(&bytes), directory);
            defined.extend(found.into_iter().map(|material| material.name));
            for (what, lines) in faults {
                let more = match lines.len() - 1 {
                    0 => String::new(),
                    count => format!(" (and {count} more)"),
                };
                soup.notes.push(format!(
                    "the material library '{name}', line {}{more}: {what}",
                    lines[0]
                ));
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

/// The libraries of a file in `folder`, those that are there with new names.
pub(in super::super) fn renamed_libraries(
    folder: &Path,
    attributes: &Attributes,
    mut new_name: impl FnMut(&str) -> String,
) -> Vec<String> {
    let mut all = Vec::new();
    for entry in &attributes.material_libraries {
        let names = library_names(folder, entry);
        if names.iter().any(|name| folder.join(name).is_file()) {
            all.extend(names.iter().map(|name| new_name(name)));
        } else {
            all.push(entry.clone());
        }
    }
    all
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
            all.extend(materials_of(&String::from_utf8_lossy(&bytes), beside).0);
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

/// The materials of a library whose images are relative to `folder`, and the numbers of the lines that are left
/// out, for each reason.
fn materials_of(text: &str, folder: &Path) -> (Vec<Material>, BTreeMap<&'static str, Vec<usize>>) {
    let mut all: Vec<Material> = Vec::new();
    let mut faults: BTreeMap<&'static str, Vec<usize>> = BTreeMap::new();
    for (k, line) in text.lines().enumerate() {
        let mut leave_out = |why: &'static str| faults.entry(why).or_default().push(k + 1);
        let (keyword, rest) = statement(line);
        match (keyword.as_str(), all.last_mut()) {
            ("newmtl", _) => {
                if rest.is_empty() {
                    leave_out(NO_NAME);
                }
                all.push(Material {
                    name: rest.to_owned(),
                    ..Material::default()
                });
            }
            ("kd", Some(material)) => match color(rest) {
                Some(color) => material.color = Some(color),
                None => leave_out(NO_COLOR),
            },
            ("map_kd", Some(material)) => match image_name(line) {
                Some(name) => {
                    let path = folder.join(local_name(folder, &name));
                    material.image = Some(ImageSource::File(path));
                }
                None => leave_out(NO_IMAGE),
            },
            _ => {}
        }
    }
    all.retain(|material| !material.name.is_empty());
    (all, faults)
}

/// The keyword of a line in lower case, and what follows it.
fn statement(line: &str) -> (String, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (keyword.to_ascii_lowercase(), rest.trim_start())
}

/// Red, green and blue in 0..=1. One number is that of all three.
fn color(text: &str) -> Option<[f32; 3]> {
    let words = text.split_whitespace();
    let words: Vec<&str> = words.take_while(|word| !word.starts_with('#')).collect();
    let words = match words[..] {
        [grey] => [grey; 3],
        [r, g, b, ..] => [r, g, b],
        _ => return None,
    };
    let mut color = [0.0; 3];
    for (channel, word) in color.iter_mut().zip(words) {
        let number = word.parse::<f32>().ok().filter(|x| x.is_finite());
        *channel = number?.clamp(0.0, 1.0);
    }
    Some(color)
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
        let (keyword, rest) = statement(line);
        (keyword == "newmtl").then(|| rest.to_owned())
    };
    let mut lines = text.lines();
    lines.find(|line| !name.is_empty() && defined(line).as_deref() == Some(name))?;
    let own = lines.take_while(|line| defined(line).is_none());
    let kept = own.filter(|line| {
        let (keyword, rest) = statement(line);
        let is_readable = keyword != "kd" || color(rest).is_some();
        !keyword.is_empty() && !is_image(&keyword) && is_readable
    });
    Some(kept.fold(String::new(), |all, line| all + line.trim() + "\n"))
}

/// The names of images in a material library.
fn image_names(bytes: &[u8]) -> impl Iterator<Item = String> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let names: Vec<String> = text.lines().filter_map(image_name).collect();
    names.into_iter()
}

/// Whether a statement of a material library names an image.
fn is_image(keyword: &str) -> bool {
    const KEYWORDS: [&str; 5] = ["bump", "disp", "decal", "norm", "refl"];
    keyword.starts_with("map_") || KEYWORDS.contains(&keyword)
}

/// The name of the image in a line of a material library: what follows the options of a `map_`
/// statement.
fn image_name(line: &str) -> Option<String> {
    let (keyword, mut rest) = statement(line);
    if !is_image(&keyword) {
        return None;
    }
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
    let name = unquoted(rest);
    (!name.is_empty()).then(|| name.to_owned())
}

/// A name without the quotes that some programs write around it.
fn unquoted(name: &str) -> &str {
    let inner = name
        .strip_prefix('"')
        .and_then(|name| name.strip_suffix('"'));
    inner.unwrap_or(name)
}

/// An entry is one name that contains blanks, or several names.
fn library_names(directory: &Path, entry: &str) -> Vec<String> {
    let local = local_name(directory, unquoted(entry));
    if directory.join(&local).is_file() {
        return vec![local];
    }
    let names = entry.split_whitespace();
    names.map(|name| unquoted(name).to_owned()).collect()
}

fn read_library(path: &PathBuf) -> Option<Vec<u8>> {
    let metadata = fs::metadata(path).ok()?;
    (metadata.is_file() && metadata.len() <= LONGEST).then(|| fs::read(path).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_images_of_materials_are_found() {
        let text = "# a library\nKd 1 1 1\nnewmtl bark\n  Kd 0.5 0.25 0.125 # brown\nKa 1 0 0\n\
                    map_Kd -s 1 1 1 -o 0 0 -clamp on my bark.png\nmap_Bump bark_n.png\n\nnewmtl leaf\n\
                    Kd spectral file.rfl 1\nKd 0 1 0\nnewmtl none\n";
        let (found, faults) = materials_of(text, Path::new("tree"));
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
        // a colour by its spectrum
        assert_eq!(faults, BTreeMap::from([(NO_COLOR, vec![10])]));
    }

    #[test]
    fn malformed_lines_are_left_out() {
        let text = "newmtl a\nKd a b c\nKd 1 0\nnewmtl b\nKd 0,8 0,8 0,8\nmap_Kd\nKd nan 1 1\nKd 1 1e99 1\n\
                    map_Kd -clamp on\nKd\nnewmtl c\nKd 0.5\nmap_Kd -s 1 1 1 \"my map.png\"\nKd 1 # 0 0\n\
                    newmtl\nKd 0 0 0\n";
        let (found, faults) = materials_of(text, Path::new(""));
        let names: Vec<&str> = found.iter().map(|material| &*material.name).collect();
        assert_eq!(names, ["a", "b", "c"]);
        assert_eq!([found[0].color, found[1].color], [None; 2]);
        assert_eq!(found[1].image, None);
        assert_eq!(found[2].color, Some([1.0; 3]));
        let image = ImageSource::File("my map.png".into());
        assert_eq!(found[2].image, Some(image));
        let expected = [
            (NO_COLOR, vec![2, 3, 5, 7, 8, 10]),
            (NO_IMAGE, vec![6, 9]),
            (NO_NAME, vec![15]),
        ];
        assert_eq!(faults, BTreeMap::from(expected));
        let settings = "newmtl a\nKd a b c\nNs 9\nmap_Kd\n";
        assert_eq!(settings_of(settings, "a").as_deref(), Some("Ns 9\n"));
    }
}
