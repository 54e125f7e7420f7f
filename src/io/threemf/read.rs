//! The 3MF reader: from model parts to a soup.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{DMat3, DMat4};
use rustc_hash::FxHashMap;
use serde_json::{Map, Value, json};

use super::super::error::{ParseError, ParseErrorKind, excerpt, in_file, no_memory};
use super::TILES;
use super::model::{self, Content, Ids, Mesh, Model, Object, Placement, Property, Resource};
use super::package::Package;
use crate::memory;
use crate::mesh::{
    Column, FaceTag, GltfMaterials, NO_VALUE, NumberType, Numbers, ObjectSettings, Soup, to_light,
};

/// Objects that contain each other are nested at most as deep.
const DEEPEST: usize = 64;
/// Memory for a vertex or a triangle while the file is read, bytes.
const BYTES_PER_ELEMENT: f64 = 150.0;

/// Reads 3MF.
///
/// # Errors
/// [`ParseError`]: the file is cut off, contradicts itself, or needs something that is not supported.
pub(in super::super) fn read(bytes: &[u8]) -> Result<Soup, ParseError> {
    let mut package = Package::open(bytes)?;
    let models = Models::read(&mut package)?;
    models.check_size()?;
    let mut notes = Vec::new();
    let materials = Materials::of(&models, &mut package, &mut notes)?;
    let mut reader = Reader {
        models: &models,
        materials: &materials,
        soup: Soup {
            offsets: vec![0],
            ..Soup::default()
        },
        texture: Vec::new(),
        colors: Vec::new(),
        moved: 0,
        unknown: 0,
    };
    reader.build()?;
    let mut soup = reader.finish(&mut notes)?;
    let root = &models.list[0].1;
    soup.attributes.unit.clone_from(&root.unit);
    soup.attributes.metadata.clone_from(&root.metadata);
    soup.attributes.gltf_materials = materials.given.map(Arc::new);
    let mut lost: Vec<String> = Vec::new();
    for (_, model) in &models.list {
        lost.extend(model.lost.iter().cloned());
    }
    lost.extend(package.others());
    if !lost.is_empty() {
        const SHOWN: usize = 8;
        let more = lost.len().saturating_sub(SHOWN);
        lost.truncate(SHOWN);
        let rest = if more > 0 {
            format!(" and {more} others")
        } else {
            String::new()
        };
        notes.push(format!("not kept: {}{rest}", lost.join(", ")));
    }
    soup.notes = notes;
    Ok(soup)
}

fn invalid(what: impl Into<String>) -> ParseError {
    in_file(ParseErrorKind::invalid(what))
}

/// The model parts with their names, that of the archive first.
struct Models {
    list: Vec<(String, Model)>,
    ids: Ids,
}

impl Models {
    /// Reads the model and the parts with objects to which it refers.
    fn read(package: &mut Package<'_>) -> Result<Self, ParseError> {
        let mut wanted = vec![package.model()?];
        let mut list: Vec<(String, Model)> = Vec::new();
        let mut ids = Ids::default();
        while let Some(name) = wanted.pop() {
            let bytes = package.part(&name)?;
            let bytes = bytes.ok_or_else(|| {
                invalid(format!(
                    "the part '{}' does not exist",
                    excerpt(name.as_bytes())
                ))
            })?;
            let model = model::read(&name, &bytes, &mut ids)?;
            list.push((normal(&name), model));
            let model = &list[list.len() - 1].1;
            let components = model.objects.values().filter_map(|o| match &o.content {
                Content::Components(components) => Some(components),
                Content::Mesh(_) => None,
            });
            let placements = model.items.iter().chain(components.flatten());
            let paths = placements.filter_map(|placement| placement.path.clone());
            let mut paths: Vec<String> = paths.collect();
            paths.sort_unstable();
            for path in paths {
                let is_known = list.iter().any(|(name, _)| *name == normal(&path));
                if !is_known && !wanted.iter().any(|w| normal(w) == normal(&path)) {
                    wanted.push(path);
                }
            }
        }
        Ok(Self { list, ids })
    }

    /// The object of a placement in a part, as the numbers of its part and its id.
    fn target(&self, part: usize, placement: &Placement) -> Result<(usize, u32), ParseError> {
        let other = placement.path.as_deref().map(normal);
        let part = match other {
            Some(path) => self.list.iter().position(|(name, _)| *name == path),
            None => Some(part),
        };
        let id = placement.object;
        let part = part.filter(|&part| self.list[part].1.objects.contains_key(&id));
        Ok((
            part.ok_or_else(|| {
                let id = self.ids.text(id);
                invalid(format!("there is no object with the id {id}"))
            })?,
            id,
        ))
    }

    /// Checks that what the build places fits into the memory: components can multiply a small file.
    fn check_size(&self) -> Result<(), ParseError> {
        let mut sizes = HashMap::new();
        let mut all = 0_u64;
        for item in &self.list[0].1.items {
            let (part, id) = self.target(0, item)?;
            all = all.saturating_add(self.size(part, id, 1, &mut sizes)?);
        }
        if all > u64::from(u32::MAX) {
            return Err(in_file(ParseErrorKind::too_large("vertices and triangles")));
        }
        memory::require(all as f64 * BYTES_PER_ELEMENT)
            .map_err(|error| no_memory(&format!("{all} vertices and triangles"), &error))
    }

    /// The number of vertices, triangles and objects that an object places.
    fn size(
        &self,
        part: usize,
        id: u32,
        depth: usize,
        known: &mut HashMap<(usize, u32), u64>,
    ) -> Result<u64, ParseError> {
        if let Some(&size) = known.get(&(part, id)) {
            return Ok(size);
        }
        if depth > DEEPEST {
            let id = self.ids.text(id);
            return Err(invalid(format!(
                "object {id} is in more than {DEEPEST} others, or contains itself"
            )));
        }
        let mut size = 1_u64;
        match &self.list[part].1.objects[&id].content {
            Content::Mesh(mesh) => {
                size += (mesh.vertices.len() + mesh.triangles.len()) as u64;
            }
            Content::Components(components) => {
                for component in components {
                    let (part, id) = self.target(part, component)?;
                    size = size.saturating_add(self.size(part, id, depth + 1, known)?);
                }
            }
        }
        known.insert((part, id), size);
        Ok(size)
    }
}

/// The name of a part without the leading slash, in lower case.
fn normal(name: &str) -> String {
    name.trim_start_matches('/').to_ascii_lowercase()
}

/// Materials in the form of glTF.
struct Materials {
    given: Option<GltfMaterials>,
    /// The number of the first material of a resource of a part.
    first: HashMap<(usize, usize), usize>,
}

impl Materials {
    fn of(
        models: &Models,
        package: &mut Package<'_>,
        notes: &mut Vec<String>,
    ) -> Result<Self, ParseError> {
        let mut first = HashMap::new();
        let (mut list, mut textures, mut samplers, mut images) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut bytes_of = Vec::new();
        // textures may share a part
        let mut parts: HashMap<String, Arc<Vec<u8>>> = HashMap::new();
        for (part, (_, model)) in models.list.iter().enumerate() {
            for (k, resource) in model.resources.iter().enumerate() {
                match resource {
                    Resource::Base(bases) => {
                        first.insert((part, k), list.len());
                        for base in bases {
                            let [r, g, b, opacity] = base.color.map(|c| f64::from(c) / 255.0);
                            let factor = [to_light(r), to_light(g), to_light(b), opacity];
                            let mut material = plain(&base.name);
                            material["pbrMetallicRoughness"]["baseColorFactor"] = json!(factor);
                            if opacity < 1.0 {
                                material["alphaMode"] = "BLEND".into();
                            }
                            list.push(material);
                        }
                    }
                    Resource::Texture { path, media, tiles } => {
                        let name = normal(path);
                        let bytes = if let Some(known) = parts.get(&name) {
                            Arc::clone(known)
                        } else {
                            let Some(bytes) = package.part(path)? else {
                                notes.push(format!(
                                    "the texture '{}' is missing",
                                    excerpt(path.as_bytes())
                                ));
                                continue;
                            };
                            let bytes = Arc::new(bytes);
                            parts.insert(name, Arc::clone(&bytes));
                            bytes
                        };
                        first.insert((part, k), list.len());
                        let file = path.rsplit('/').next().unwrap_or_default();
                        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
                        let mut material = plain(stem);
                        material["pbrMetallicRoughness"]["baseColorTexture"] =
                            json!({ "index": textures.len() });
                        list.push(material);
                        let wrap = |tile: &String| {
                            let known = TILES.iter().find(|(name, _)| name == tile);
                            known.map_or(TILES[0].1, |(_, value)| *value)
                        };
                        let [u, v] = [wrap(&tiles[0]), wrap(&tiles[1])];
                        textures.push(json!({ "source": images.len(), "sampler": samplers.len() }));
                        samplers.push(json!({ "wrapS": u, "wrapT": v }));
                        images.push(json!({ "mimeType": media }));
                        bytes_of.push(Some(bytes));
                    }
                    Resource::Colors { .. } | Resource::TextureGroup { .. } => {}
                }
            }
        }
        let given = list.iter().map(|material: &Value| material.get("name"));
        let given = given.map(|name| name.and_then(Value::as_str).unwrap_or_default());
        let names = GltfMaterials::different_names(given);
        let arrays = [
            ("materials", list),
            ("textures", textures),
            ("samplers", samplers),
            ("images", images),
        ];
        let json: Map<String, Value> = (arrays.into_iter())
            .filter(|(_, list)| !list.is_empty())
            .map(|(name, list)| (name.to_owned(), Value::Array(list)))
            .collect();
        let given = (!names.is_empty()).then_some(GltfMaterials {
            names,
            json,
            images: bytes_of,
        });
        Ok(Self { given, first })
    }

    fn name(&self, number: usize) -> String {
        let names = self.given.as_ref().map(|all| &all.names);
        names.map_or_else(String::new, |names| names[number].clone())
    }
}

fn plain(name: &str) -> Value {
    let mut material = GltfMaterials::plain();
    if !name.is_empty() {
        material["name"] = name.into();
    }
    material
}

struct Reader<'a> {
    models: &'a Models,
    materials: &'a Materials,
    soup: Soup,
    /// Rows of texture coordinates.
    texture: Vec<[f64; 2]>,
    /// The colour of each corner so far; empty before the first one.
    colors: Vec<Option<[u8; 4]>>,
    /// Placements with a transform.
    moved: usize,
    /// Triangles with properties that are not kept.
    unknown: usize,
}

/// The names of objects in the build, which are all different.
#[derive(Default)]
struct Names {
    taken: HashSet<String>,
    /// The next number of each wanted name, so that many copies of a part take no time.
    next: HashMap<String, usize>,
}

impl Names {
    fn made(&mut self, wanted: &str, id: &str) -> String {
        let base = if wanted.is_empty() {
            format!("object_{id}")
        } else {
            wanted.to_owned()
        };
        let mut name = base.clone();
        while !self.taken.insert(name.clone()) {
            let number = self.next.entry(base.clone()).or_insert(2);
            name = format!("{base}_{number}");
            *number += 1;
        }
        name
    }
}

impl Reader<'_> {
    fn build(&mut self) -> Result<(), ParseError> {
        let models = self.models;
        let root = &models.list[0].1;
        if root.items.is_empty() {
            let count = root.objects.len();
            return Err(invalid(format!(
                "the build places none of the {count} objects; place them before the export"
            )));
        }
        let mut names = Names::default();
        // the rows of the texture groups that were used
        let mut rows = HashMap::new();
        for item in &root.items {
            let (part, id) = models.target(0, item)?;
            let name = &models.list[part].1.objects[&id].name;
            let object = if root.items.len() > 1 {
                names.made(name, models.ids.text(id))
            } else {
                name.clone()
            };
            self.moved += usize::from(item.transform != DMat4::IDENTITY);
            let leaves = self.leaves(part, id, item.transform)?;
            let mut groups = Names::default();
            let is_alone = leaves.len() == 1;
            self.keep_settings(&models.list[part].1.objects[&id], &object, "");
            for (is_inner, part, id, matrix) in leaves {
                let name = &models.list[part].1.objects[&id].name;
                let tag = FaceTag {
                    object: object.clone(),
                    group: match (is_inner, is_alone) {
                        (false, _) => String::new(),
                        (true, true) => name.clone(),
                        (true, false) => groups.made(name, models.ids.text(id)),
                    },
                    ..FaceTag::default()
                };
                let placed = &models.list[part].1.objects[&id];
                if !tag.group.is_empty() {
                    self.keep_settings(placed, &tag.object, &tag.group);
                }
                if let Content::Mesh(mesh) = &placed.content {
                    self.mesh(part, mesh, &matrix, &tag, &mut rows)?;
                }
            }
        }
        Ok(())
    }

    /// Keeps the settings of an object whose faces have these names.
    fn keep_settings(&mut self, placed: &Object, object: &str, group: &str) {
        if !placed.settings.is_empty() {
            self.soup.attributes.objects.push(ObjectSettings {
                object: object.to_owned(),
                group: group.to_owned(),
                values: placed.settings.clone(),
            });
        }
    }

    /// The meshes that an object places, and whether they are components.
    fn leaves(
        &mut self,
        part: usize,
        id: u32,
        matrix: DMat4,
    ) -> Result<Vec<(bool, usize, u32, DMat4)>, ParseError> {
        let mut leaves = Vec::new();
        let mut stack = vec![(false, part, id, matrix)];
        while let Some((is_inner, part, id, matrix)) = stack.pop() {
            match &self.models.list[part].1.objects[&id].content {
                Content::Mesh(_) => leaves.push((is_inner, part, id, matrix)),
                Content::Components(components) => {
                    for component in components.iter().rev() {
                        let (part, id) = self.models.target(part, component)?;
                        self.moved += usize::from(component.transform != DMat4::IDENTITY);
                        stack.push((true, part, id, matrix * component.transform));
                    }
                }
            }
        }
        Ok(leaves)
    }

    /// Adds a mesh at a place.
    fn mesh(
        &mut self,
        part: usize,
        mesh: &Mesh,
        matrix: &DMat4,
        tag: &FaceTag,
        rows: &mut HashMap<(usize, u32), u32>,
    ) -> Result<(), ParseError> {
        let first = self.soup.positions.len() as u32;
        let is_moved = *matrix != DMat4::IDENTITY;
        for (vertex, p) in mesh.vertices.iter().enumerate() {
            let p = if is_moved {
                matrix.transform_point3(*p)
            } else {
                *p
            };
            for (value, axis) in p.to_array().into_iter().zip(['x', 'y', 'z']) {
                if !value.is_finite() {
                    let (vertex, found) = (vertex + 1, value.to_string());
                    return Err(in_file(ParseErrorKind::NotFinite {
                        vertex,
                        axis,
                        found,
                    }));
                }
            }
            self.soup.positions.push(p);
        }
        let is_mirrored = DMat3::from_mat4(*matrix).determinant() < 0.0;
        let mut tags: HashMap<Option<usize>, u32> = HashMap::new();
        for triangle in &mesh.triangles {
            let mut corners = triangle.corners.map(|v| first + v);
            let mut shown = self.shown(part, triangle.property.as_ref(), rows)?;
            if is_mirrored {
                corners.swap(1, 2);
                shown.texture.swap(1, 2);
                if let Some(colors) = &mut shown.colors {
                    colors.swap(1, 2);
                }
            }
            let all = &mut self.soup.attributes;
            let tag = *tags.entry(shown.material).or_insert_with(|| {
                let material = shown
                    .material
                    .map_or_else(String::new, |k| self.materials.name(k));
                all.tags.push(FaceTag {
                    material,
                    ..tag.clone()
                });
                all.tags.len() as u32 - 1
            });
            all.faces.tags.push(tag);
            all.faces.texture.extend(shown.texture);
            if shown.colors.is_some() || !self.colors.is_empty() {
                self.colors.resize(self.soup.corners.len(), None);
                let colors = shown.colors.map_or([None; 3], |colors| colors.map(Some));
                self.colors.extend(colors);
            }
            self.soup.corners.extend(corners);
            self.soup.offsets.push(self.soup.corners.len() as u32);
        }
        Ok(())
    }

    /// What a triangle with a property shows.
    fn shown(
        &mut self,
        part: usize,
        property: Option<&Property>,
        rows: &mut HashMap<(usize, u32), u32>,
    ) -> Result<Shown, ParseError> {
        let mut shown = Shown {
            material: None,
            texture: [NO_VALUE; 3],
            colors: None,
        };
        let Some(property) = property else {
            return Ok(shown);
        };
        let model = &self.models.list[part].1;
        let Property { group, entries } = *property;
        let number = model.of_id.get(&group).copied();
        let Some(number) = number else {
            self.unknown += 1;
            return Ok(shown);
        };
        let check = |count: usize| {
            let wrong = entries.iter().find(|&&entry| entry as usize >= count);
            wrong.map_or(Ok(()), |entry| {
                let group = self.models.ids.text(group);
                Err(invalid(format!(
                    "a triangle uses entry {entry} of the property group {group}, which has {count}, \
                     counted from 0"
                )))
            })
        };
        let first = |number| self.materials.first.get(&(part, number)).copied();
        match &model.resources[number] {
            Resource::Base(bases) => {
                check(bases.len())?;
                shown.material = first(number).map(|first| first + entries[0] as usize);
            }
            Resource::Colors { colors, .. } => {
                check(colors.len())?;
                shown.colors = Some(entries.map(|entry| colors[entry as usize]));
            }
            Resource::TextureGroup {
                texture,
                coordinates,
            } => {
                check(coordinates.len())?;
                let texture = model.of_id.get(texture).copied();
                shown.material = texture.and_then(first);
                let start = *rows.entry((part, group)).or_insert_with(|| {
                    let start = self.texture.len() as u32;
                    self.texture.extend_from_slice(coordinates);
                    start
                });
                shown.texture = entries.map(|entry| start + entry);
            }
            Resource::Texture { .. } => self.unknown += 1,
        }
        Ok(shown)
    }

    /// Moves the attributes into the soup and adds notes.
    fn finish(mut self, notes: &mut Vec<String>) -> Result<Soup, ParseError> {
        let vertices = self.soup.positions.len();
        if self.soup.face_count() == 0 {
            let cut = false;
            return Err(in_file(match vertices {
                0 => ParseErrorKind::NoVertices,
                _ => ParseErrorKind::NoFaces { vertices, cut },
            }));
        }
        if self.moved > 0 {
            notes.push(format!(
                "the transforms of {} items and components are applied to their objects",
                self.moved
            ));
        }
        if self.unknown > 0 {
            notes.push(format!(
                "{} triangles have properties that are not kept",
                self.unknown
            ));
        }
        let all = &mut self.soup.attributes;
        if self.texture.is_empty() {
            all.faces.texture.clear();
        } else {
            let coordinate = |k: usize| self.texture.iter().map(|row| row[k]).collect();
            let columns = ["u", "v"].iter().zip([coordinate(0), coordinate(1)]);
            let columns = columns.map(|(name, numbers)| Column::decimals(name, numbers));
            all.texture = Arc::new(columns.collect());
        }
        if all.tags.len() == 1
            && all.tags[0] == FaceTag::default()
            && self.materials.given.is_none()
        {
            all.tags.clear();
            all.faces.tags.clear();
        }
        let mut colors = std::mem::take(&mut self.colors);
        if !colors.is_empty() {
            colors.resize(self.soup.corners.len(), None);
            let lists = self
                .models
                .list
                .iter()
                .flat_map(|(_, model)| &model.resources);
            let has_opacity = lists.into_iter().any(
                |resource| matches!(resource, Resource::Colors { has_opacity, .. } if *has_opacity),
            );
            settle_colors(&mut self.soup, &colors, has_opacity, notes);
        }
        Ok(self.soup)
    }
}

/// What a triangle shows: its material, rows of texture coordinates, and colours of its corners.
struct Shown {
    material: Option<usize>,
    texture: [u32; 3],
    colors: Option<[[u8; 4]; 3]>,
}

/// Stores the colours of corners: with the vertices if each has one colour, with the faces if each of
/// these has one, else with the vertices, of which further ones follow for further colours.
fn settle_colors(
    soup: &mut Soup,
    colors: &[Option<[u8; 4]>],
    has_opacity: bool,
    notes: &mut Vec<String>,
) {
    const WHITE: [u8; 4] = [255; 4];
    let mut of_vertices: Vec<Option<[u8; 4]>> = vec![None; soup.positions.len()];
    let mut is_unique = true;
    for (&v, &color) in soup.corners.iter().zip(colors) {
        let known = &mut of_vertices[v as usize];
        is_unique &= known.is_none() || color.is_none() || *known == color;
        *known = known.or(color);
    }
    let is_flat = |corners: &[Option<[u8; 4]>]| corners.iter().all(|&c| c == corners[0]);
    if !is_unique && colors.chunks_exact(3).all(is_flat) {
        let of_faces: Vec<_> = colors.chunks_exact(3).map(|corners| corners[0]).collect();
        soup.attributes.faces.columns = columns(&of_faces, has_opacity);
        let bare = of_faces.iter().filter(|color| color.is_none()).count();
        if bare > 0 {
            notes.push(format!("{bare} triangles without a colour are white"));
        }
        return;
    }
    if !is_unique {
        let mut more: FxHashMap<(u32, [u8; 4]), u32> = FxHashMap::default();
        for (v, color) in soup.corners.iter_mut().zip(colors) {
            let (Some(color), known) = (*color, of_vertices[*v as usize]) else {
                continue;
            };
            if known != Some(color) {
                let new = of_vertices.len() as u32;
                let copy = *more.entry((*v, color)).or_insert(new);
                if copy == new {
                    soup.positions.push(soup.positions[*v as usize]);
                    of_vertices.push(Some(color));
                }
                *v = copy;
            }
        }
    }
    let bare = of_vertices.iter().filter(|color| color.is_none()).count();
    if bare > 0 {
        notes.push(format!("{bare} vertices without a colour are white"));
    }
    let of_vertices: Vec<_> = of_vertices
        .iter()
        .map(|c| Some(c.unwrap_or(WHITE)))
        .collect();
    soup.attributes.vertices = columns(&of_vertices, has_opacity);
}

/// Columns of colours in bytes.
fn columns(colors: &[Option<[u8; 4]>], has_opacity: bool) -> Vec<Column> {
    let names = ["red", "green", "blue", "alpha"].into_iter();
    names
        .take(if has_opacity { 4 } else { 3 })
        .enumerate()
        .map(|(k, name)| {
            let mut numbers = Numbers::with_capacity(NumberType::U8, colors.len());
            for color in colors {
                numbers.push(f64::from(color.map_or(255, |color| color[k])));
            }
            Column {
                name: name.to_owned(),
                numbers,
                is_typed: true,
            }
        })
        .collect()
}
