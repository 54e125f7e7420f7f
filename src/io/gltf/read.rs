//! The glTF reader.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DMat4, DQuat};
use serde_json::{Map, Value};

use super::super::error::{ParseError, ParseErrorKind, at_byte, excerpt, in_file};
use super::buffers::{Buffers, compressed, invalid};
use super::schema::{Node, Primitive, Root};
use super::{BINARY_CHUNK, COMPRESSIONS, JSON_CHUNK, MAGIC, materials};
use crate::mesh::{
    Column, DVec3, FaceTag, GltfMaterials, NO_VALUE, Numbers, Soup, to_light, to_signal,
};

/// Attributes of vertices that are read.
const ATTRIBUTES: [&str; 4] = ["POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0"];

/// Modes of primitives: triangles, strips, which are 5, and fans. Those before are points and lines.
const TRIANGLES: u64 = 4;
const FAN: u64 = 6;

/// Reads glTF, binary or JSON. Buffers in other files are in `folder`.
///
/// # Errors
/// [`ParseError`]: the file is cut off, contradicts itself, or needs something that is not supported.
pub(in super::super) fn read(bytes: &[u8], folder: Option<&Path>) -> Result<Soup, ParseError> {
    if bytes.is_empty() {
        return Err(in_file(ParseErrorKind::Empty));
    }
    let (json, chunk) = chunks(bytes)?;
    let wrong = |found: String| {
        let format = "glTF";
        in_file(ParseErrorKind::NotThisFormat { format, found })
    };
    let mut document: Map<String, Value> =
        serde_json::from_slice(json).map_err(|error| wrong(format!("other JSON ({error})")))?;
    check_version(&document)?;
    let mut notes = Vec::new();
    let mut lost = Vec::new();
    for name in ["animations", "skins", "cameras"] {
        if let Some(Value::Array(list)) = document.remove(name)
            && !list.is_empty()
        {
            lost.push(name.to_owned());
        }
    }
    let kept = materials::ARRAYS.into_iter();
    let kept = kept.filter_map(|name| Some((name.to_owned(), document.remove(name)?)));
    let kept: Map<String, Value> = kept.collect();
    let root: Root = serde_json::from_value(Value::Object(document))
        .map_err(|error| wrong(format!("a JSON document in which {error}")))?;
    check_extensions(&kept)?;
    let buffers = Buffers::load(&root, chunk, folder)?;
    let materials = materials::keep(kept, &buffers, &mut notes)?;
    let mut reader = Reader {
        root: &root,
        buffers: &buffers,
        materials: materials.as_ref(),
        soup: Soup {
            offsets: vec![0],
            ..Soup::default()
        },
        texture: Table::new(),
        normals: Table::new(),
        lights: Vec::new(),
        has_opacity: false,
        uncolored: 0,
        not_finite: 0,
        skipped: 0,
        lost: lost.into_iter().collect(),
    };
    reader.scene(&mut notes)?;
    reader.finish(materials.is_some(), &mut notes)?;
    let mut soup = reader.soup;
    soup.attributes.gltf_materials = materials.map(Arc::new);
    soup.notes = notes;
    Ok(soup)
}

/// The JSON and the binary chunk of a file, which may be JSON only.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), ParseError> {
    if !bytes.starts_with(MAGIC) {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if !text.trim_ascii_start().starts_with(b"{") {
            let first = &text[..text.len().min(8)];
            let found = format!("'{}' instead of 'glTF' or '{{'", excerpt(first));
            let format = "glTF";
            return Err(in_file(ParseErrorKind::NotThisFormat { format, found }));
        }
        return Ok((text, None));
    }
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes) as usize)
    };
    let cut = |at: usize, what: String| at_byte(at, ParseErrorKind::truncated(what));
    let version = word(4).unwrap_or(0);
    if version != 2 {
        return Err(other_version(&version.to_string()));
    }
    let (declared, size) = (word(8).unwrap_or(0), bytes.len());
    if declared > size || declared < 12 {
        let what = format!("the header declares {declared} bytes, but there are {size}");
        return Err(cut(8, what));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < declared {
        let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(cut(at, "it ends in the header of a chunk".to_owned()));
        };
        let start = at + 8;
        let Some(chunk) = bytes[..declared].get(start..start.saturating_add(length)) else {
            let left = declared.saturating_sub(start);
            let what = format!("a chunk declares {length} bytes, but {left} are left");
            return Err(cut(at, what));
        };
        if kind == JSON_CHUNK {
            json.get_or_insert(chunk);
        } else if kind == BINARY_CHUNK {
            binary.get_or_insert(chunk);
        }
        at = start + length;
    }
    let json = json.ok_or_else(|| invalid("the file has no JSON chunk"))?;
    Ok((json, binary))
}

fn other_version(version: &str) -> ParseError {
    let what = format!("glTF of version {}", excerpt(version.as_bytes()));
    let remedy = "export it as glTF 2.0";
    in_file(ParseErrorKind::Unsupported { what, remedy })
}

fn check_version(document: &Map<String, Value>) -> Result<(), ParseError> {
    let asset = document.get("asset");
    let version = asset.and_then(|asset| asset.get("version")?.as_str());
    match version {
        Some(version) if version.starts_with("2.") => Ok(()),
        Some(version) => Err(other_version(version)),
        None => Err(invalid("the JSON has no asset with a version of glTF")),
    }
}

/// Refuses extensions that the file requires and that change its meshes. Those of materials and images
/// are kept without being understood.
fn check_extensions(kept: &Map<String, Value>) -> Result<(), ParseError> {
    const HARMLESS: [&str; 2] = ["KHR_mesh_quantization", "KHR_lights_punctual"];
    let is_of_material = |name: &str| name.contains("_materials_") || name.contains("_texture_");
    for name in materials::required(kept) {
        if COMPRESSIONS.contains(&name) {
            return Err(compressed(name));
        }
        if !is_of_material(name) && !HARMLESS.contains(&name) {
            let what = format!(
                "a glTF file that requires the extension {}",
                excerpt(name.as_bytes())
            );
            let remedy = "export it without this extension";
            return Err(in_file(ParseErrorKind::Unsupported { what, remedy }));
        }
    }
    Ok(())
}

/// The nodes of the default scene, or of the first one, in the order of the file, with their
/// transforms. Without scenes these are all nodes.
fn placed_nodes(root: &Root) -> Result<Vec<(&Node, DMat4)>, ParseError> {
    let scene = match root.scene {
        Some(index) => {
            let scene = root.scenes.get(index);
            Some(scene.ok_or_else(|| invalid("the default scene does not exist"))?)
        }
        None => root.scenes.first(),
    };
    let roots: Vec<usize> = if let Some(scene) = scene {
        scene.nodes.clone()
    } else {
        let children = root.nodes.iter().flat_map(|node| &node.children);
        let children: BTreeSet<usize> = children.copied().collect();
        let all = 0..root.nodes.len();
        all.filter(|k| !children.contains(k)).collect()
    };
    let mut stack: Vec<(usize, DMat4)> = roots
        .into_iter()
        .rev()
        .map(|k| (k, DMat4::IDENTITY))
        .collect();
    let mut is_placed = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((k, parent)) = stack.pop() {
        let node = root.nodes.get(k);
        let node = node.ok_or_else(|| invalid(format!("node {k} does not exist")))?;
        if std::mem::replace(&mut is_placed[k], true) {
            return Err(invalid(format!("node {k} has two parents")));
        }
        let matrix = parent * own_matrix(node);
        placed.push((node, matrix));
        let children = node.children.iter().rev();
        stack.extend(children.map(|child| (*child, matrix)));
    }
    Ok(placed)
}

fn own_matrix(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix);
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| {
        DQuat::from_array(rotation).normalize()
    });
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, DVec3::from),
        rotation,
        node.translation.map_or(DVec3::ZERO, DVec3::from),
    )
}

/// Texture coordinates or normals, and the row of each vertex.
struct Table<const N: usize> {
    numbers: [Vec<f32>; N],
    row_of_vertex: Vec<u32>,
}

impl<const N: usize> Table<N> {
    fn new() -> Self {
        Self {
            numbers: std::array::from_fn(|_| Vec::new()),
            row_of_vertex: Vec::new(),
        }
    }

    /// Adds the numbers of the vertices that follow; `None` if they have none.
    fn vertices(&mut self, count: usize, rows: Option<impl Iterator<Item = [f32; N]>>) {
        let first = self.numbers[0].len() as u32;
        let after = self.row_of_vertex.len() + count;
        let Some(rows) = rows else {
            self.row_of_vertex.resize(after, NO_VALUE);
            return;
        };
        self.row_of_vertex.extend((first..).take(count));
        for row in rows {
            for (list, number) in self.numbers.iter_mut().zip(row) {
                list.push(number);
            }
        }
    }

    /// The columns and the rows of these corners.
    fn settle(self, names: [&str; N], corners: &[u32]) -> (Arc<Vec<Column>>, Vec<u32>) {
        if self.numbers[0].is_empty() {
            return Default::default();
        }
        let rows = corners.iter().map(|&v| self.row_of_vertex[v as usize]);
        let rows = rows.collect();
        let columns = names.into_iter().zip(self.numbers);
        let columns = columns.map(|(name, list)| typed(name, Numbers::F32(list)));
        (Arc::new(columns.collect()), rows)
    }
}

fn typed(name: &str, numbers: Numbers) -> Column {
    Column {
        name: name.to_owned(),
        numbers,
        is_typed: true,
    }
}

struct Reader<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    materials: Option<&'a GltfMaterials>,
    soup: Soup,
    texture: Table<2>,
    normals: Table<3>,
    /// Colour and opacity of each vertex, as light; empty before the first one.
    lights: Vec<[f32; 4]>,
    has_opacity: bool,
    uncolored: usize,
    /// Numbers of attributes that are not finite.
    not_finite: usize,
    /// Primitives of points and lines.
    skipped: usize,
    /// Names of what is not kept.
    lost: BTreeSet<String>,
}

/// The accessors of positions, normals, texture coordinates and colours.
type Vertices = [Option<usize>; 4];

impl Reader<'_> {
    fn scene(&mut self, notes: &mut Vec<String>) -> Result<(), ParseError> {
        let root = self.root;
        let mut moved = 0;
        let mut is_used = vec![false; root.meshes.len()];
        for (node, matrix) in placed_nodes(root)? {
            let Some(k) = node.mesh else { continue };
            let mesh = root.meshes.get(k);
            let mesh = mesh.ok_or_else(|| invalid(format!("mesh {k} does not exist")))?;
            is_used[k] = true;
            let transform = (matrix != DMat4::IDENTITY).then_some(matrix);
            moved += usize::from(transform.is_some());
            let tag = FaceTag {
                object: node.name.clone(),
                group: mesh.name.clone(),
                ..FaceTag::default()
            };
            let mut known = HashMap::new();
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                let what = format!("primitive {number} of mesh {k}");
                self.primitive(primitive, &tag, transform.as_ref(), &mut known, &what)?;
            }
        }
        if moved > 0 {
            notes.push(format!(
                "the transforms of {moved} nodes are applied to their meshes"
            ));
        }
        let unused = is_used.iter().filter(|is| !**is).count();
        if unused > 0 {
            notes.push(format!(
                "not kept: {unused} meshes outside the default scene"
            ));
        }
        Ok(())
    }

    /// Reads a primitive. `known` has the first vertex for the accessors that its mesh has used before.
    fn primitive(
        &mut self,
        primitive: &Primitive,
        tag: &FaceTag,
        transform: Option<&DMat4>,
        known: &mut HashMap<Vertices, (u32, u32)>,
        what: &str,
    ) -> Result<(), ParseError> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if mode < TRIANGLES {
            self.skipped += 1;
            return Ok(());
        }
        if mode > FAN {
            return Err(invalid(format!("{what} has the unknown mode {mode}")));
        }
        if !primitive.targets.is_empty() {
            self.lost.insert("morph targets".to_owned());
        }
        for name in primitive.attributes.keys() {
            if !ATTRIBUTES.contains(&name.as_str()) {
                self.lost.insert(excerpt(name.as_bytes()));
            }
        }
        let accessors = ATTRIBUTES.map(|name| primitive.attributes.get(name).copied());
        let (first, vertices) = match known.get(&accessors) {
            Some(&range) => range,
            None => self.vertices(accessors, transform, what)?,
        };
        known.insert(accessors, (first, vertices));
        let material = match primitive.material {
            Some(index) => {
                let names = self.materials.map_or(&[][..], |all| &all.names);
                let name = names.get(index);
                name.cloned()
                    .ok_or_else(|| invalid(format!("{what} has no material")))?
            }
            None => String::new(),
        };
        let mirrored = transform.is_some_and(|matrix| matrix.determinant() < 0.0);
        let before = self.soup.face_count();
        self.triangles(primitive, mode, first, vertices, mirrored, what)?;
        let all = &mut self.soup.attributes;
        let count = self.soup.offsets.len() - 1 - before;
        if count > 0 {
            let index = all.tags.len() as u32;
            all.faces.tags.resize(before + count, index);
            all.tags.push(FaceTag {
                material,
                ..tag.clone()
            });
        }
        Ok(())
    }

    /// Reads the vertices of a primitive. Returns the first one and their number.
    fn vertices(
        &mut self,
        [positions, normals, texture, colors]: Vertices,
        transform: Option<&DMat4>,
        what: &str,
    ) -> Result<(u32, u32), ParseError> {
        let positions =
            positions.ok_or_else(|| invalid(format!("{what} has no attribute POSITION")))?;
        let named = |name: &str| format!("{name} of {what}");
        let buffers = self.buffers;
        let positions = buffers.elements(positions, &["VEC3"], &named("POSITION"))?;
        let count = positions.count;
        let other = |index: Option<usize>, shapes: &[&str], name: &str| {
            let Some(index) = index else { return Ok(None) };
            let elements = buffers.elements(index, shapes, &named(name))?;
            if elements.count == count {
                return Ok(Some(elements));
            }
            let found = elements.count;
            let name = named(name);
            Err(invalid(format!(
                "{name} has {found} elements instead of {count}"
            )))
        };
        let normals = other(normals, &["VEC3"], "NORMAL")?;
        let texture = other(texture, &["VEC2"], "TEXCOORD_0")?;
        let colors = other(colors, &["VEC3", "VEC4"], "COLOR_0")?;
        let first = self.soup.positions.len();
        if u32::try_from(first + count).is_err() {
            return Err(in_file(ParseErrorKind::too_large("vertices")));
        }
        self.soup.positions.reserve(count);
        for i in 0..count {
            let mut p = DVec3::from(positions.numbers(i).map(f64::from));
            if let Some(matrix) = transform {
                p = matrix.transform_point3(p);
            }
            for (value, axis) in p.to_array().into_iter().zip(['x', 'y', 'z']) {
                if !value.is_finite() {
                    let (vertex, found) = (first + i + 1, value.to_string());
                    return Err(in_file(ParseErrorKind::NotFinite {
                        vertex,
                        axis,
                        found,
                    }));
                }
            }
            self.soup.positions.push(p);
        }
        let mut not_finite = 0;
        let mut finite = |number: f32| {
            not_finite += usize::from(!number.is_finite());
            if number.is_finite() { number } else { 0.0 }
        };
        let turn = transform.map(|matrix| DMat3::from_mat4(*matrix).inverse().transpose());
        let normals = normals.map(|normals| {
            let normals: Vec<[f32; 3]> = (0..count)
                .map(|i| {
                    let normal = normals.numbers(i);
                    let turned = |turn: DMat3| {
                        let n = turn * DVec3::from(normal.map(f64::from));
                        n.normalize_or_zero().as_vec3().to_array()
                    };
                    turn.map_or(normal, turned).map(&mut finite)
                })
                .collect();
            normals.into_iter()
        });
        self.normals.vertices(count, normals);
        let texture = texture.map(|texture| {
            let rows = (0..count).map(|i| texture.numbers(i).map(&mut finite));
            rows.collect::<Vec<[f32; 2]>>().into_iter()
        });
        self.texture.vertices(count, texture);
        match colors {
            Some(colors) => {
                self.uncolored += first - self.lights.len();
                self.lights.resize(first, [1.0; 4]);
                self.has_opacity |= colors.width == 4;
                for i in 0..count {
                    let opacity = if colors.width == 4 {
                        colors.number(i, 3)
                    } else {
                        1.0
                    };
                    let [r, g, b] = colors.numbers(i);
                    self.lights.push([r, g, b, opacity].map(&mut finite));
                }
            }
            None if self.lights.is_empty() => {}
            None => {
                self.uncolored += count;
                self.lights.resize(first + count, [1.0; 4]);
            }
        }
        self.not_finite += not_finite;
        Ok((first as u32, count as u32))
    }

    /// Reads the triangles of a primitive, whose vertices begin at `first`.
    fn triangles(
        &mut self,
        primitive: &Primitive,
        mode: u64,
        first: u32,
        vertices: u32,
        mirrored: bool,
        what: &str,
    ) -> Result<(), ParseError> {
        let indices = match primitive.indices {
            Some(index) => {
                let name = format!("the list of indices of {what}");
                let elements = self.buffers.elements(index, &["SCALAR"], &name)?;
                let mut indices = Vec::with_capacity(elements.count);
                for k in 0..elements.count {
                    let index = elements.index(k);
                    let index =
                        index.ok_or_else(|| invalid(format!("{name} has no unsigned integers")))?;
                    if index >= vertices {
                        return Err(invalid(format!(
                            "index {index} at place {k} of {what} exceeds its {vertices} vertices, \
                             counted from 0"
                        )));
                    }
                    indices.push(first + index);
                }
                indices
            }
            None => (first..first + vertices).collect(),
        };
        let count = indices.len();
        if mode == TRIANGLES && count % 3 != 0 {
            return Err(invalid(format!(
                "{what} has {count} corners, which is no multiple of 3"
            )));
        }
        let triangles = match mode {
            TRIANGLES => count / 3,
            _ => count.saturating_sub(2),
        };
        if u32::try_from(self.soup.corners.len() + 3 * triangles).is_err() {
            return Err(in_file(ParseErrorKind::too_large("face corners")));
        }
        self.soup.corners.reserve(3 * triangles);
        for k in 0..triangles {
            let at = match mode {
                TRIANGLES => [3 * k, 3 * k + 1, 3 * k + 2],
                FAN => [k + 1, k + 2, 0],
                // every other triangle of a strip turns
                _ => [k, k + 1 + k % 2, k + 2 - k % 2],
            };
            let [a, mut b, mut c] = at.map(|k| indices[k]);
            // strips are joined by triangles without area
            if mode != TRIANGLES && (a == b || b == c || c == a) {
                continue;
            }
            if mirrored {
                std::mem::swap(&mut b, &mut c);
            }
            self.soup.corners.extend([a, b, c]);
            self.soup.offsets.push(self.soup.corners.len() as u32);
        }
        Ok(())
    }

    /// Moves the attributes into the soup and adds notes.
    fn finish(&mut self, has_materials: bool, notes: &mut Vec<String>) -> Result<(), ParseError> {
        let soup = &mut self.soup;
        let vertices = soup.positions.len();
        if self.skipped > 0 {
            let count = self.skipped;
            notes.push(format!("not kept: {count} primitives of points or lines"));
        }
        if soup.face_count() == 0 {
            let cut = false;
            return Err(in_file(match vertices {
                0 => ParseErrorKind::NoVertices,
                _ => ParseErrorKind::NoFaces { vertices, cut },
            }));
        }
        let all = &mut soup.attributes;
        if all.tags.len() == 1 && all.tags[0] == FaceTag::default() && !has_materials {
            all.tags.clear();
            all.faces.tags.clear();
        }
        let texture = std::mem::replace(&mut self.texture, Table::new());
        (all.texture, all.faces.texture) = texture.settle(["u", "v"], &soup.corners);
        all.texture_is_down = !all.faces.texture.is_empty();
        let normals = std::mem::replace(&mut self.normals, Table::new());
        (all.normals, all.faces.normals) = normals.settle(["nx", "ny", "nz"], &soup.corners);
        if !self.lights.is_empty() {
            let is_outside = |light: &&mut f32| !(0.0..=1.0).contains(*light);
            let mut outside = 0;
            for light in self.lights.iter_mut().flatten().filter(is_outside) {
                *light = light.clamp(0.0, 1.0);
                outside += 1;
            }
            if outside > 0 {
                notes.push(format!(
                    "{outside} numbers of colours are limited to 0 to 1"
                ));
            }
            all.vertices = color_columns(&self.lights, self.has_opacity);
        }
        if self.uncolored > 0 {
            let count = self.uncolored;
            notes.push(format!("{count} vertices without a colour are white"));
        }
        if self.not_finite > 0 {
            let count = self.not_finite;
            notes.push(format!(
                "{count} numbers of normals, texture coordinates or colours are not finite and read as 0"
            ));
        }
        if !self.lost.is_empty() {
            let names: Vec<&str> = self.lost.iter().map(String::as_str).collect();
            notes.push(format!("not kept: {}", names.join(", ")));
        }
        Ok(())
    }
}

/// Columns of colours that are light in 0..=1: signals of 8 bits where these give the same light in
/// single precision, else decimals.
fn color_columns(lights: &[[f32; 4]], has_opacity: bool) -> Vec<Column> {
    let step = |signal: f64| (signal * 255.0).round();
    let signal = |light: f32| to_signal(f64::from(light));
    let is_step = |&light: &f32| to_light(step(signal(light)) / 255.0) as f32 == light;
    let in_bytes = lights.iter().all(|light| light[..3].iter().all(is_step));
    let channel = |k: usize| lights.iter().map(move |light| light[k]);
    let mut columns: Vec<Column> = (["red", "green", "blue"].into_iter().enumerate())
        .map(|(k, name)| {
            if in_bytes {
                let steps = channel(k).map(|light| step(signal(light)) as u8);
                typed(name, Numbers::U8(steps.collect()))
            } else {
                Column::decimals(name, channel(k).map(signal).collect())
            }
        })
        .collect();
    if has_opacity {
        let opacity = channel(3).map(f64::from).collect();
        columns.push(Column::decimals("alpha", opacity));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_in_single_precision_survives_as_signal() {
        let mut random = crate::random::SplitMix::new(5);
        let bits = (0..200_000).map(|_| random.below(0x3f80_0001) as u32);
        let steps = (0..=65535_u16).map(|k| (f32::from(k) / 65535.0).to_bits());
        for light in bits.chain(steps).map(f32::from_bits) {
            let again = to_light(to_signal(f64::from(light))) as f32;
            assert_eq!(again.to_bits(), light.to_bits(), "{light}");
        }
    }
}
