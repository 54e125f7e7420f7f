//! The glTF writer.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, Write};
use std::ops::Range;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use super::super::{OutputMesh, media_type, stored_media};
use super::{
    BINARY_CHUNK, DATA, FLOAT, JSON_CHUNK, MAGIC, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT,
    materials,
};
use crate::mesh::{
    Attributes, Colors, Column, FaceTag, GltfMaterials, Material, NO_VALUE, OwnMaterial,
    color_steps, colors, columns_named, texture_columns, to_light,
};

/// Values of `target` of buffer views.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The columns of vertices with normals.
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// The columns of vertices that are written besides colours, where corners have no such values.
pub(in super::super) fn vertex_columns(all: &Attributes) -> Vec<usize> {
    let source = Sources::of(all);
    let of_vertices = |list: &Option<Source<'_>>| match list {
        Some(Source::Vertices(columns)) => columns.clone(),
        _ => Vec::new(),
    };
    [of_vertices(&source.texture), of_vertices(&source.normals)].concat()
}

/// What the format cannot store besides columns, as messages for the user.
pub(in super::super) fn losses(mesh: &OutputMesh<'_>, materials: Vec<Material>) -> Vec<String> {
    let mut lost = Vec::new();
    let all = mesh.attributes;
    let mut tags = all.faces.tags.iter().map(|&tag| &all.tags[tag as usize]);
    if tags.any(|tag| !tag.smoothing.is_empty()) {
        lost.push("glTF cannot store smoothing groups".to_owned());
    }
    if !all.material_libraries.is_empty() {
        lost.push(
            "glTF files get the colours and images of materials, not what else libraries say"
                .to_owned(),
        );
    }
    for material in other_materials(all, materials) {
        let media = material.image.as_ref().map(stored_media);
        if let Some(Err(reason)) = media {
            let name = &material.name;
            lost.push(format!("glTF gets no image of material '{name}': {reason}"));
        }
    }
    let numbers = all.texture.iter().chain(all.normals.iter());
    let is_rounded = |column: &Column| {
        let mut numbers = (0..column.numbers.len()).map(|row| column.numbers.get(row));
        numbers.any(|x| f64::from(x as f32) != x)
    };
    if numbers.into_iter().any(is_rounded) {
        lost.push(
            "glTF coordinates of textures and normals are rounded to single precision".to_owned(),
        );
    }
    let mut is_used = vec![false; mesh.positions.len()];
    for &v in mesh.triangles.as_flattened() {
        is_used[v as usize] = true;
    }
    let unused = is_used.iter().filter(|is| !**is).count();
    if unused > 0 {
        lost.push(format!(
            "glTF cannot store the {unused} vertices without faces"
        ));
    }
    lost
}

/// Where the values of corners are.
enum Source<'a> {
    /// In a table to which corners refer.
    Corners(&'a [u32], Vec<&'a Column>),
    /// In these columns of the vertices.
    Vertices(Vec<usize>),
}

struct Sources<'a> {
    texture: Option<Source<'a>>,
    normals: Option<Source<'a>>,
}

impl<'a> Sources<'a> {
    fn of(all: &'a Attributes) -> Self {
        let find = |list: &'a [u32], columns: &'a [Column], count: usize| {
            let is_given = !list.is_empty() && columns.len() >= count;
            is_given.then(|| Source::Corners(list, columns.iter().take(count).collect()))
        };
        let of_vertices = |columns: &[usize]| Source::Vertices(columns.to_vec());
        let texture = find(&all.faces.texture, &all.texture, 2);
        let normals = find(&all.faces.normals, &all.normals, 3);
        Self {
            texture: texture
                .or_else(|| texture_columns(&all.vertices).map(|columns| of_vertices(&columns))),
            normals: normals.or_else(|| {
                columns_named(&all.vertices, NORMAL).map(|columns| of_vertices(&columns))
            }),
        }
    }

    /// The rows of a corner in the tables; 0 without a table, `NO_VALUE` without a value.
    fn rows(&self, corner: usize) -> [u32; 2] {
        [&self.texture, &self.normals].map(|source| match source {
            Some(Source::Corners(list, _)) => list[corner],
            Some(Source::Vertices(_)) => 0,
            None => NO_VALUE,
        })
    }
}

/// Faces that become one primitive: those of one tag that have the same attributes.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    tag: Option<u32>,
    /// Whether they have no texture coordinates and no normals.
    lacks: [bool; 2],
}

/// Writes glTF, binary or as JSON with the buffer in a data URI. The mesh has been checked. `others` are all its
/// materials, among them those that no glTF file had.
///
/// # Errors
/// The error of the writer, and binary files above 4 GiB.
pub(in super::super) fn write(
    mesh: &OutputMesh<'_>,
    others: Vec<Material>,
    is_binary: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let all = mesh.attributes;
    let sources = Sources::of(all);
    let mut faces_of: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    for face in 0..mesh.triangles.len() {
        let mut lacks = [false; 2];
        for corner in 3 * face..3 * face + 3 {
            for (lacks, row) in lacks.iter_mut().zip(sources.rows(corner)) {
                *lacks |= row == NO_VALUE;
            }
        }
        let tag = all.faces.tags.get(face).copied();
        faces_of.entry(Key { tag, lacks }).or_default().push(face);
    }
    let mut file = File::default();
    let mut materials = Materials::new(all.gltf_materials.as_deref(), &mut file);
    materials.add(&all.own_materials, &mut file);
    materials.add_others(all, others, &mut file);
    let light = Light::of(&all.vertices);
    let mut meshes: Vec<(FaceTag, Vec<Value>)> = Vec::new();
    for (key, faces) in &faces_of {
        let tag = key.tag.map(|tag| all.tags[tag as usize].clone());
        let tag = tag.unwrap_or_default();
        let mut primitive = primitive(mesh, &sources, light.as_ref(), key, faces, &mut file);
        if !tag.material.is_empty() || materials.of_name.contains_key("") {
            primitive["material"] = materials.index(&tag.material).into();
        }
        match meshes.last_mut() {
            Some((last, list)) if [&last.object, &last.group] == [&tag.object, &tag.group] => {
                list.push(primitive);
            }
            _ => meshes.push((tag, vec![primitive])),
        }
    }
    let named = |mut value: Value, name: &str| {
        if !name.is_empty() {
            value["name"] = name.into();
        }
        value
    };
    let (mut nodes, mut list) = (Vec::new(), Vec::new());
    for (k, (tag, primitives)) in meshes.into_iter().enumerate() {
        nodes.push(named(json!({ "mesh": k }), &tag.object));
        list.push(named(json!({ "primitives": primitives }), &tag.group));
    }
    let mut document = materials.json;
    let mut used = BTreeSet::new();
    for value in document.values() {
        materials::extensions(value, &mut used);
    }
    let required = materials::required(&document).filter(|name| used.contains(*name));
    let required: BTreeSet<String> = required.map(str::to_owned).collect();
    for (name, list) in [(materials::REQUIRED, required), ("extensionsUsed", used)] {
        document.insert(name.into(), list.into_iter().collect::<Value>());
    }
    let scene: Vec<usize> = (0..nodes.len()).collect();
    document.insert("nodes".into(), nodes.into());
    document.insert("meshes".into(), list.into());
    file.finish(document, &scene, is_binary, out)
}

/// Those of the materials of a mesh, in `found`, that faces have and that are in a library of an OBJ file or are
/// images of a PLY file.
fn other_materials(all: &Attributes, mut found: Vec<Material>) -> Vec<Material> {
    let used: BTreeSet<&str> = all.tags.iter().map(|tag| tag.material.as_str()).collect();
    let given = all.gltf_materials.iter().flat_map(|given| &given.names);
    let own = all.own_materials.iter().map(|own| &own.name);
    let others: BTreeSet<&String> = given.chain(own).collect();
    // faces without a material have that without a name
    let is_used = |name: &str| used.contains(name) || name.is_empty() && all.tags.is_empty();
    found.retain(|material| is_used(&material.name) && !others.contains(&material.name));
    found
}

/// The materials of a file that is being written.
#[derive(Default)]
struct Materials {
    json: Map<String, Value>,
    of_name: HashMap<String, usize>,
    /// The new texture of each view of an image.
    textures: HashMap<usize, usize>,
}

impl Materials {
    /// The given materials; writes their images to the buffer of `file`.
    fn new(given: Option<&GltfMaterials>, file: &mut File) -> Self {
        let Some(given) = given else {
            return Self::default();
        };
        let mut json = given.json.clone();
        let images = json.get_mut("images").and_then(Value::as_array_mut);
        for (image, bytes) in images.into_iter().flatten().zip(&given.images) {
            if let (Some(bytes), Value::Object(image)) = (bytes, image) {
                image.insert("bufferView".into(), file.image(bytes).into());
            }
        }
        let names = given.names.iter().cloned().enumerate();
        Self {
            json,
            of_name: names.map(|(k, name)| (name, k)).collect(),
            textures: HashMap::new(),
        }
    }

    /// Adds own materials; writes their images to the buffer of `file`.
    fn add(&mut self, own: &[OwnMaterial], file: &mut File) {
        for material in own {
            let texture = self.texture(&material.png, "image/png", file);
            let like = self.of_name.get(&material.like).copied();
            let like = like.and_then(|k| self.json.get("materials")?.get(k).cloned());
            let like = like.unwrap_or_else(GltfMaterials::plain);
            let mut entry = materials::without_textures(like);
            entry["name"] = material.name.clone().into();
            entry["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
            let index = self.push("materials", entry);
            self.of_name.insert(material.name.clone(), index);
        }
    }

    /// Adds the materials of faces that are in a library of an OBJ file, and the image of a PLY file, with
    /// their colours and images.
    fn add_others(&mut self, all: &Attributes, others: Vec<Material>, file: &mut File) {
        for material in other_materials(all, others) {
            let name = material.name.as_str();
            if self.of_name.contains_key(name) {
                continue;
            }
            let mut entry = GltfMaterials::plain();
            if !name.is_empty() {
                entry["name"] = name.into();
            }
            if let Some([r, g, b]) = material.color {
                let light = [r, g, b].map(|x| to_light(f64::from(x.clamp(0.0, 1.0))));
                let factor = [light[0], light[1], light[2], 1.0];
                entry["pbrMetallicRoughness"]["baseColorFactor"] = json!(factor);
            }
            let image = material.image.as_ref().and_then(|image| image.bytes().ok());
            if let Some(bytes) = image
                && let Some(media) = media_type(&bytes)
            {
                let texture = self.texture(&bytes, media, file);
                entry["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
            }
            let index = self.push("materials", entry);
            self.of_name.insert(name.to_owned(), index);
        }
    }

    /// The new texture of an image, which is written to the buffer of `file`.
    fn texture(&mut self, bytes: &[u8], media: &str, file: &mut File) -> usize {
        let view = file.image(bytes);
        if let Some(&texture) = self.textures.get(&view) {
            return texture;
        }
        let image = self.push("images", json!({ "bufferView": view, "mimeType": media }));
        let texture = self.push("textures", json!({ "source": image }));
        self.textures.insert(view, texture);
        texture
    }

    /// Appends an entry to an array of the document. Returns its index.
    fn push(&mut self, list: &str, entry: Value) -> usize {
        let list = self.json.entry(list).or_insert_with(|| json!([]));
        if !list.is_array() {
            *list = json!([]);
        }
        let list = list.as_array_mut().expect("an array");
        list.push(entry);
        list.len() - 1
    }

    /// The index of the material of this name, which is added if there is none.
    fn index(&mut self, name: &str) -> usize {
        if let Some(&index) = self.of_name.get(name) {
            return index;
        }
        let index = self.push("materials", json!({ "name": name }));
        self.of_name.insert(name.to_owned(), index);
        index
    }
}

/// The colours of vertices as light.
struct Light {
    colors: Vec<[f32; 4]>,
    has_opacity: bool,
    /// The largest value of the integer type in whose steps all numbers are exact.
    steps: Option<u16>,
}

impl Light {
    fn of(columns: &[Column]) -> Option<Self> {
        let Colors {
            channels,
            alpha,
            full,
        } = Colors::of(columns)?;
        let mut lights = colors(columns);
        if lights.is_empty() {
            return None;
        }
        for (row, light) in lights.iter_mut().enumerate() {
            for (number, k) in light.iter_mut().zip(channels) {
                // from the column, because `colors` rounds to single precision
                let signal = columns[k].numbers.get(row) / full;
                *number = to_light(signal.clamp(0.0, 1.0)) as f32;
            }
            light[3] = light[3].min(1.0);
        }
        Some(Self {
            steps: color_steps(&lights),
            colors: lights,
            has_opacity: alpha.is_some(),
        })
    }
}

/// A vertex of a primitive: rows of texture coordinates and normals, and the vertex of the mesh. In this
/// order, the vertices of a glTF file come back in the order of the file.
type Corner = ([u32; 2], u32);

/// Writes the vertices and indices of a primitive to the buffer.
fn primitive(
    mesh: &OutputMesh<'_>,
    sources: &Sources<'_>,
    light: Option<&Light>,
    key: &Key,
    faces: &[usize],
    file: &mut File,
) -> Value {
    let all = mesh.attributes;
    let corner_of = |face: usize, k: usize| -> Corner {
        let mut rows = sources.rows(3 * face + k);
        for (row, lacks) in rows.iter_mut().zip(key.lacks) {
            if lacks {
                *row = NO_VALUE;
            }
        }
        (rows, mesh.triangles[face][k])
    };
    let corners = || {
        faces
            .iter()
            .flat_map(|&face| (0..3).map(move |k| corner_of(face, k)))
    };
    let mut vertices: Vec<Corner> = corners().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut attributes = Map::new();
    let position = |&(_, v): &Corner| mesh.positions[v as usize].as_vec3().to_array();
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in vertices.iter().map(position) {
        low = std::array::from_fn(|k| low[k].min(p[k]));
        high = std::array::from_fn(|k| high[k].max(p[k]));
    }
    let positions = vertices.iter().flat_map(position);
    let mut accessor = file.floats(positions, vertices.len(), 3);
    accessor["min"] = json!(low);
    accessor["max"] = json!(high);
    attributes.insert("POSITION".into(), file.accessor(accessor).into());
    let tables = [
        (&sources.texture, "TEXCOORD_0", 2),
        (&sources.normals, "NORMAL", 3),
    ];
    for (which, (source, name, width)) in tables.into_iter().enumerate() {
        let Some(source) = source.as_ref().filter(|_| !key.lacks[which]) else {
            continue;
        };
        let number = |(rows, v): &Corner, k: usize| match source {
            Source::Corners(_, columns) => columns[k].numbers.get(rows[which] as usize) as f32,
            Source::Vertices(columns) => {
                let number = all.vertices[columns[k]].numbers.get(*v as usize);
                // `v` of other formats increases upwards
                let is_v = which == 0 && k == 1;
                (if is_v { 1.0 - number } else { number }) as f32
            }
        };
        let numbers = vertices
            .iter()
            .flat_map(|at| (0..width).map(move |k| number(at, k)));
        let accessor = file.floats(numbers, vertices.len(), width);
        attributes.insert(name.into(), file.accessor(accessor).into());
    }
    if let Some(light) = light {
        let lights = vertices.iter().map(|&(_, v)| light.colors[v as usize]);
        let accessor = file.colors(lights, vertices.len(), light);
        attributes.insert("COLOR_0".into(), file.accessor(accessor).into());
    }
    file.align();
    let start = file.bytes.len();
    for corner in corners() {
        let index = vertices.partition_point(|vertex| *vertex < corner) as u32;
        file.bytes.extend_from_slice(&index.to_le_bytes());
    }
    let view = file.view(start, None, Some(INDICES));
    let indices = json!({
        "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * faces.len(), "type": "SCALAR",
    });
    json!({ "attributes": attributes, "indices": file.accessor(indices) })
}

/// The buffer of a file with its views and accessors.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    /// The places of images in the buffer, and their views.
    images: Vec<(Range<usize>, usize)>,
}

impl File {
    /// Pads the buffer to a multiple of four bytes.
    fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// Adds a view of the bytes from `start` on. Returns its index.
    fn view(&mut self, start: usize, stride: Option<usize>, target: Option<u32>) -> usize {
        let length = self.bytes.len() - start;
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": length });
        if let Some(stride) = stride {
            view["byteStride"] = stride.into();
        }
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    /// Writes an image, equal ones once. Returns its view.
    fn image(&mut self, bytes: &[u8]) -> usize {
        let mut images = self.images.iter();
        if let Some((_, view)) = images.find(|(place, _)| self.bytes[place.clone()] == *bytes) {
            return *view;
        }
        self.align();
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        let view = self.view(start, None, None);
        self.images.push((start..self.bytes.len(), view));
        view
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Writes vectors of `width` numbers. Returns their accessor.
    fn floats(&mut self, numbers: impl Iterator<Item = f32>, count: usize, width: usize) -> Value {
        self.align();
        let start = self.bytes.len();
        for number in numbers {
            self.bytes.extend_from_slice(&number.to_le_bytes());
        }
        let view = self.view(start, None, Some(VERTICES));
        let kind = format!("VEC{width}");
        json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind })
    }

    /// Writes colours: as 8 or 16 bits where these are exact, else in single precision.
    fn colors(
        &mut self,
        colors: impl Iterator<Item = [f32; 4]>,
        count: usize,
        light: &Light,
    ) -> Value {
        let width = if light.has_opacity { 4 } else { 3 };
        let Some(steps) = light.steps else {
            return self.floats(colors.flat_map(|c| c.into_iter().take(width)), count, width);
        };
        self.align();
        let start = self.bytes.len();
        for color in colors {
            for number in &color[..width] {
                let step = (number * f32::from(steps)).round() as u16;
                let bytes = step.to_le_bytes();
                self.bytes
                    .extend_from_slice(if steps == 255 { &bytes[..1] } else { &bytes });
            }
            // each vertex begins at a multiple of four bytes
            self.align();
        }
        let size = if steps == 255 { 1 } else { 2 };
        let stride = (width * size).next_multiple_of(4);
        let view = self.view(start, Some(stride), Some(VERTICES));
        let kind = if steps == 255 {
            UNSIGNED_BYTE
        } else {
            UNSIGNED_SHORT
        };
        json!({
            "bufferView": view, "componentType": kind, "normalized": true, "count": count,
            "type": format!("VEC{width}"),
        })
    }

    /// Writes the file, whose scene has these nodes.
    fn finish(
        mut self,
        mut document: Map<String, Value>,
        scene: &[usize],
        is_binary: bool,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.align();
        let mut buffer = json!({ "byteLength": self.bytes.len() });
        if !is_binary {
            let data = STANDARD.encode(&self.bytes);
            buffer["uri"] = format!("{DATA}application/octet-stream;base64,{data}").into();
        }
        document.insert(
            "asset".into(),
            json!({ "version": "2.0", "generator": "meniscus" }),
        );
        document.insert("scene".into(), 0.into());
        document.insert("scenes".into(), json!([{ "nodes": scene }]));
        document.insert("accessors".into(), self.accessors.into());
        document.insert("bufferViews".into(), self.views.into());
        document.insert("buffers".into(), json!([buffer]));
        // the format has no empty arrays
        document.retain(|_, value| value.as_array().is_none_or(|list| !list.is_empty()));
        if !is_binary {
            serde_json::to_writer(&mut *out, &document)?;
            return out.write_all(b"\n");
        }
        let mut json = serde_json::to_vec(&document)?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let size = 12 + 8 + json.len() + 8 + self.bytes.len();
        let size = u32::try_from(size).map_err(|_| {
            io::Error::other("a .glb file cannot exceed 4 GiB; write .gltf, .ply or .obj")
        })?;
        out.write_all(MAGIC)?;
        out.write_all(&2_u32.to_le_bytes())?;
        out.write_all(&size.to_le_bytes())?;
        for (kind, chunk) in [(JSON_CHUNK, &json), (BINARY_CHUNK, &self.bytes)] {
            out.write_all(&(chunk.len() as u32).to_le_bytes())?;
            out.write_all(kind)?;
            out.write_all(chunk)?;
        }
        Ok(())
    }
}
