//! Material libraries: notes for the load report, and the files that they refer to. Their names are
//! kept and their contents are not changed.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::mesh::{Attributes, Soup};

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
                let images = image_names(&bytes);
                names.extend(images.map(|name| beside.join(name).to_string_lossy().into_owned()));
                names.insert(library);
            }
        }
    }
    names
}

/// The names of images in a material library: what follows the options of a `map_` statement.
fn image_names(bytes: &[u8]) -> impl Iterator<Item = String> {
    const KEYWORDS: [&str; 5] = ["bump", "disp", "decal", "norm", "refl"];
    let text = String::from_utf8_lossy(bytes).into_owned();
    let name = |line: &str| {
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
    };
    let names: Vec<String> = text.lines().filter_map(name).collect();
    names.into_iter()
}

/// An entry is one name that contains blanks, or several names.
fn library_names(directory: &Path, entry: &str) -> Vec<String> {
    if directory.join(entry).is_file() {
        return vec![entry.to_owned()];
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
