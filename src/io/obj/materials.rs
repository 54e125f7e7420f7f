//! Notes about material libraries for the load report. Their names are kept; their contents are not
//! read.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::mesh::Soup;

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
