//! A list of what a file holds.

use super::{Attributes, Column, row_count};

/// Start of a comment of a PLY file that names a texture image.
const TEXTURE_FILE: &str = "comment TextureFile ";

impl Attributes {
    /// What the file holds besides positions and faces, one line for each kind; empty for nothing.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut list = |what: &str, columns: &[Column]| {
            if !columns.is_empty() {
                let names: Vec<String> = columns.iter().map(described).collect();
                lines.push(format!("{what}: {}", names.join(", ")));
            }
        };
        list("vertex properties", &self.vertices);
        list("face properties", &self.faces.columns);
        let mut count = |what: &str, count: usize| {
            if count > 0 {
                lines.push(format!("{what}: {count}"));
            }
        };
        count("texture coordinates", row_count(&self.texture));
        count("normals of corners", row_count(&self.normals));
        for (what, name) in [
            (
                "objects",
                (|tag| &tag.object) as fn(&super::FaceTag) -> &String,
            ),
            ("groups", |tag| &tag.group),
            ("materials", |tag| &tag.material),
            ("smoothing groups", |tag| &tag.smoothing),
        ] {
            let mut names: Vec<&str> = self.tags.iter().map(|tag| name(tag).as_str()).collect();
            names.sort_unstable();
            names.dedup();
            count(what, names.iter().filter(|name| !name.is_empty()).count());
        }
        if !self.material_libraries.is_empty() {
            let names = self.material_libraries.join(", ");
            lines.push(format!("material libraries: {names}"));
        }
        if let Some(materials) = &self.gltf_materials {
            let images = materials.images.len();
            let count = materials.names.len();
            lines.push(format!(
                "materials with colours and images in the file: {count}, with {images} images"
            ));
        }
        for material in &self.own_materials {
            lines.push(format!(
                "material with an image of its own: {}",
                material.name
            ));
        }
        if !self.unit.is_empty() {
            lines.push(format!("unit: {}", self.unit));
        }
        for [name, value] in &self.metadata {
            lines.push(format!("{name}: {value}"));
        }
        for settings in &self.objects {
            let names = [&settings.object, &settings.group].map(String::as_str);
            let name = names.join(" ");
            let values = settings.values.iter().map(|value| value.join(" "));
            let values = values.collect::<Vec<_>>().join(", ");
            lines.push(format!("object '{}': {values}", name.trim()));
        }
        for name in self.texture_files() {
            lines.push(format!("texture file: {name}"));
        }
        lines
    }

    /// Names of texture images in the comments of a PLY header.
    pub fn texture_files(&self) -> impl Iterator<Item = &str> {
        self.comments
            .iter()
            .filter_map(|line| line.strip_prefix(TEXTURE_FILE).map(str::trim))
    }

    /// Replaces the names of [`texture_files`](Self::texture_files).
    pub(crate) fn rename_texture_files(&mut self, mut new_name: impl FnMut(&str) -> String) {
        for line in &mut self.comments {
            if let Some(name) = line.strip_prefix(TEXTURE_FILE) {
                *line = format!("{TEXTURE_FILE}{}", new_name(name.trim()));
            }
        }
    }
}

fn described(column: &Column) -> String {
    if column.is_typed {
        format!("{} ({})", column.name, column.numbers.kind().ply_name())
    } else {
        column.name.clone()
    }
}
