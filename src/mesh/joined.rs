//! Several files as one.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::attributes::{Column, GltfMaterials, NO_VALUE, ObjectSettings, row_count};
use super::{FaceTag, Soup};

/// The contents of files with their names, one after the other: vertices and polygons of the first, then
/// those of the second, and so on.
///
/// Columns with a number for each vertex or face stay if all files have them in the same type, texture
/// coordinates and normals of corners if they have the same numbers in all files that have them; notes
/// say what is left out. If one of the files has groups, objects or materials, the faces of files
/// without an object get the name of the file as object. Material libraries are those of the first
/// file and of others in its folder.
pub fn joined(parts: &[(String, Soup)]) -> Soup {
    let mut all = Soup::default();
    let notes = &mut all.notes;
    for (name, soup) in parts {
        notes.extend(soup.notes.iter().map(|note| format!("{name}: {note}")));
    }
    let soups = || parts.iter().map(|(_, soup)| soup);
    let out = &mut all.attributes;
    let of_vertices: Vec<_> = soups().map(|s| &s.attributes.vertices[..]).collect();
    out.vertices = common("vertices", &of_vertices, notes);
    let of_faces: Vec<_> = soups().map(|s| &s.attributes.faces.columns[..]).collect();
    out.faces.columns = common("faces", &of_faces, notes);
    let mut tables = Vec::new();
    let with_texture = || soups().filter(|s| !s.attributes.faces.texture.is_empty());
    out.texture_is_down = with_texture()
        .next()
        .is_some_and(|s| s.attributes.texture_is_down);
    // all coordinates in the direction of the first
    let is_down = out.texture_is_down;
    let texture: Vec<Arc<Vec<Column>>> = soups()
        .map(|s| match &s.attributes {
            all if all.texture_is_down == is_down => Arc::clone(&all.texture),
            all => all.with_turned_texture().texture,
        })
        .collect();
    for what in ["texture coordinates", "normals"] {
        let of_parts = soups().zip(&texture).map(|(s, texture)| match what {
            "normals" => (&s.attributes.normals[..], &s.attributes.faces.normals[..]),
            _ => (&texture[..], &s.attributes.faces.texture[..]),
        });
        let sizes = soups().map(|s| s.corners.len());
        tables.push(corner_table(
            what,
            &of_parts.collect::<Vec<_>>(),
            sizes,
            notes,
        ));
    }
    for ((columns, corners), is_texture) in tables.into_iter().zip([true, false]) {
        if is_texture {
            (out.texture, out.faces.texture) = (Arc::new(columns), corners);
        } else {
            (out.normals, out.faces.normals) = (Arc::new(columns), corners);
        }
    }
    let has_tags = soups().any(|s| !s.attributes.tags.is_empty());
    out.folder = soups().next().and_then(|s| s.attributes.folder.clone());
    out.stl_header = soups().next().and_then(|s| s.attributes.stl_header);
    let same = |a: &Soup, b: &Soup| a.attributes.unit == b.attributes.unit;
    if let Some(first) = soups().next() {
        if soups().all(|s| same(first, s)) {
            out.unit.clone_from(&first.attributes.unit);
        } else {
            notes.push("the files have different units; their coordinates are not scaled".into());
        }
        out.metadata.clone_from(&first.attributes.metadata);
    }
    let mut materials: Option<GltfMaterials> = None;
    all.offsets.push(0);
    for (name, soup) in parts {
        let (vertex, corner) = (all.positions.len() as u32, all.corners.len() as u32);
        all.positions.extend_from_slice(&soup.positions);
        all.corners.extend(soup.corners.iter().map(|v| v + vertex));
        let ends = soup.offsets.iter().skip(1).map(|end| end + corner);
        all.offsets.extend(ends);
        all.exploded |= soup.exploded;
        let from = &soup.attributes;
        if has_tags {
            let first = out.tags.len() as u32;
            let own = if from.tags.is_empty() {
                vec![FaceTag::default()]
            } else {
                from.tags.clone()
            };
            let mut renamed = BTreeMap::new();
            if let Some(given) = &from.gltf_materials {
                let names = match &mut materials {
                    Some(materials) => materials.append(given),
                    None => materials.insert((**given).clone()).names.clone(),
                };
                renamed.extend(given.names.iter().cloned().zip(names));
            }
            out.tags.extend(own.into_iter().map(|tag| FaceTag {
                object: if tag.object.is_empty() {
                    name.clone()
                } else {
                    tag.object
                },
                material: renamed.get(&tag.material).cloned().unwrap_or(tag.material),
                ..tag
            }));
            out.objects
                .extend(from.objects.iter().cloned().map(|settings| ObjectSettings {
                    object: if settings.object.is_empty() {
                        name.clone()
                    } else {
                        settings.object
                    },
                    ..settings
                }));
            let of_face = |f: usize| first + from.faces.tags.get(f).copied().unwrap_or(0);
            out.faces.tags.extend((0..soup.face_count()).map(of_face));
        }
        out.comments.extend_from_slice(&from.comments);
        if from.folder == out.folder {
            let new = from.material_libraries.iter();
            let new = new.filter(|library| !out.material_libraries.contains(library));
            let new: Vec<String> = new.cloned().collect();
            out.material_libraries.extend(new);
        } else if !from.material_libraries.is_empty() {
            notes.push(format!(
                "{name}: its material libraries are in another folder and are left out"
            ));
        }
    }
    all.attributes.gltf_materials = materials.map(Arc::new);
    all
}

/// The columns that all parts have in the same type, one part after the other.
fn common(of_what: &str, parts: &[&[Column]], notes: &mut Vec<String>) -> Vec<Column> {
    let same = |a: &Column, b: &Column| a.name == b.name && a.numbers.kind() == b.numbers.kind();
    let is_common = |column: &Column| {
        let mut parts = parts.iter();
        parts.all(|part| part.iter().any(|other| same(column, other)))
    };
    let mut dropped: Vec<&str> = Vec::new();
    for column in parts.iter().copied().flatten().filter(|c| !is_common(c)) {
        if !dropped.contains(&&*column.name) {
            dropped.push(&column.name);
        }
    }
    if !dropped.is_empty() {
        let names = dropped.join(", ");
        notes.push(format!(
            "data of {of_what} that not all files have in one type are left out: {names}"
        ));
    }
    let first = parts.first().copied().unwrap_or_default();
    let mut columns: Vec<Column> = first.iter().filter(|c| is_common(c)).cloned().collect();
    for part in &parts[1..] {
        for column in &mut columns {
            if let Some(other) = part.iter().find(|other| same(column, other)) {
                append(column, other);
            }
        }
    }
    columns
}

/// Rows to which corners refer, and the rows of all corners. Corners of parts without such rows have
/// none.
fn corner_table(
    what: &str,
    parts: &[(&[Column], &[u32])],
    sizes: impl Iterator<Item = usize>,
    notes: &mut Vec<String>,
) -> (Vec<Column>, Vec<u32>) {
    let kinds = |columns: &[Column]| -> Vec<_> {
        let kind = |c: &Column| (c.name.clone(), c.numbers.kind());
        columns.iter().map(kind).collect()
    };
    let mut with = parts.iter().filter(|(_, corners)| !corners.is_empty());
    let Some(&(first, _)) = with.next() else {
        return (Vec::new(), Vec::new());
    };
    if with.any(|(columns, _)| kinds(columns) != kinds(first)) {
        notes.push(format!(
            "the {what} of corners differ in type between the files and are left out"
        ));
        return (Vec::new(), Vec::new());
    }
    let mut columns: Vec<Column> = Vec::new();
    let mut all = Vec::new();
    for ((own, corners), size) in parts.iter().zip(sizes) {
        if corners.is_empty() {
            all.resize(all.len() + size, NO_VALUE);
            continue;
        }
        let before = row_count(&columns) as u32;
        let shifted = |&row: &u32| if row == NO_VALUE { row } else { row + before };
        all.extend(corners.iter().map(shifted));
        if columns.is_empty() {
            columns = own.to_vec();
        } else {
            for (column, other) in columns.iter_mut().zip(*own) {
                append(column, other);
            }
        }
    }
    (columns, all)
}

/// Appends the numbers of a column of the same type.
fn append(column: &mut Column, other: &Column) {
    for i in 0..other.numbers.len() {
        column.numbers.push(other.numbers.get(i));
    }
}
