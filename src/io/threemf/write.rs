//! The 3MF writer.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::{self, Cursor, Write};
use std::sync::Arc;

use quick_xml::escape::escape;
use rustc_hash::FxHashMap;
use serde_json::Value;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::super::number::{push_f64, push_index, push_number};
use super::super::{OutputMesh, companions, gltf, media_type};
use super::{CORE, MATERIALS, MODEL_RELATION, RELATIONS, TEXTURE_RELATION, TILES};
use crate::mesh::{
    Attributes, Colors, Column, FaceTag, GltfMaterials, Material, NO_VALUE, ObjectSettings, colors,
    columns_named, row_count,
};

/// The part with the model, and that with its relationships.
const MODEL: &str = "3D/3dmodel.model";
const MODEL_RELATIONS: &str = "3D/_rels/3dmodel.model.rels";

/// Bytes of text after which a part is written.
const CHUNK: usize = 1 << 16;

/// The column numbers of colours of faces, with their opacity.
fn face_colors(columns: &[Column]) -> Option<Colors> {
    columns_named(columns, ["red", "green", "blue"])?;
    Colors::of(columns)
}

/// The columns of faces that are written: their colours, unless vertices have some.
pub(in super::super) fn face_columns(all: &Attributes) -> Vec<usize> {
    let colors = face_colors(&all.faces.columns).filter(|_| !all.has_vertex_colors());
    let columns = |c: Colors| c.channels.into_iter().chain(c.alpha).collect();
    colors.map_or_else(Vec::new, columns)
}

/// What the format cannot store besides columns and normals, as messages for the user.
pub(in super::super) fn losses(mesh: &OutputMesh<'_>, sheet: &Sheet<'_>) -> Vec<String> {
    let mut lost = Vec::new();
    let all = mesh.attributes;
    let mut tags = all.faces.tags.iter().map(|&tag| &all.tags[tag as usize]);
    if tags.any(|tag| !tag.smoothing.is_empty()) {
        lost.push("3MF cannot store smoothing groups".to_owned());
    }
    for (name, reason) in &sheet.unread {
        lost.push(format!("3MF gets no image of material '{name}': {reason}"));
    }
    if !all.faces.texture.is_empty() {
        let has_texture = |face: usize| all.faces.texture[3 * face] != NO_VALUE;
        let mut bare = (0..mesh.triangles.len()).filter(|&face| has_texture(face));
        if bare.any(|face| sheet.texture_of(face).is_none()) {
            lost.push("3MF cannot store texture coordinates of faces without an image".to_owned());
        }
    }
    let triangles = mesh.triangles.iter().enumerate();
    let mut colored = triangles.filter(|&(face, triangle)| {
        let colors = sheet.colors_of(face, triangle);
        colors.is_some_and(|colors| !sheet.are_white(colors))
    });
    let has_material = |face: usize| {
        let tag = all.tags.get(sheet.tag_index(face));
        tag.is_some_and(|tag| !tag.material.is_empty())
    };
    let has_other = |face: usize| sheet.texture_of(face).is_some() || has_material(face);
    if colored.any(|(face, _)| has_other(face)) {
        lost.push("3MF stores one of an image, colours and a material for a face".to_owned());
    }
    if sheet.is_rounded {
        lost.push("3MF colours are rounded to 8 bits".to_owned());
    }
    let given = all.gltf_materials.as_deref();
    if !all.material_libraries.is_empty() || !given.is_none_or(gltf::are_plain) {
        lost.push(
            "3MF stores the colours and images of materials, and nothing else of them".into(),
        );
    }
    lost
}

/// What faces show: images, colours and materials, numbered for the file.
pub(in super::super) struct Sheet<'a> {
    all: &'a Attributes,
    /// The different image files.
    files: Vec<ImageFile>,
    images: Vec<Image>,
    /// Groups of base materials.
    bases: Vec<Bases>,
    /// The images and groups of base materials in the order of the materials.
    order: Vec<Slot>,
    /// For each tag, and last for faces without one: its image, and its group and entry of base materials.
    of_tag: Vec<(Option<usize>, Option<[u32; 2]>)>,
    /// Id of the next resource.
    next_id: u32,
    colors_id: u32,
    /// The colours of the group of colours, and the entry of each row of the columns.
    palette: Vec<[u8; 4]>,
    entries: Vec<u32>,
    /// Whether rows are faces, not vertices.
    is_of_faces: bool,
    has_opacity: bool,
    is_rounded: bool,
    /// Materials whose images cannot be stored, and why.
    unread: BTreeMap<String, String>,
}

/// Base materials that follow each other, with their colours.
struct Bases {
    id: u32,
    list: Vec<(String, [u8; 4])>,
}

/// The number of an image or of a group of base materials.
#[derive(Clone, Copy)]
enum Slot {
    Image(usize),
    Bases(usize),
}

/// A part with an image.
struct ImageFile {
    path: String,
    media: &'static str,
    bytes: Arc<Vec<u8>>,
}

/// The image of a material with the rows of texture coordinates that its faces use, in ascending order.
struct Image {
    /// Id of the texture; that of its group follows.
    id: u32,
    /// The number of its file.
    file: usize,
    tiles: [&'static str; 2],
    rows: Vec<u32>,
}

impl<'a> Sheet<'a> {
    /// That of a mesh. Reads the images of its materials.
    pub fn of(mesh: &OutputMesh<'a>) -> Self {
        let all = mesh.attributes;
        let mut sheet = Self {
            all,
            files: Vec::new(),
            images: Vec::new(),
            bases: Vec::new(),
            order: Vec::new(),
            of_tag: Vec::new(),
            next_id: 1,
            colors_id: 0,
            palette: Vec::new(),
            entries: Vec::new(),
            is_of_faces: false,
            has_opacity: false,
            is_rounded: false,
            unread: BTreeMap::new(),
        };
        sheet.add_materials();
        sheet.add_rows(mesh.triangles.len());
        sheet.add_colors();
        sheet
    }

    /// Gives each image the rows that its faces use. Unused rows are those of the image of the row before.
    fn add_rows(&mut self, faces: usize) {
        let mut images = vec![None; row_count(&self.all.texture)];
        for face in 0..faces {
            if let Some(image) = self.texture_of(face) {
                let corners = &self.all.faces.texture[3 * face..3 * face + 3];
                self.images[image].rows.extend_from_slice(corners);
                for &row in corners {
                    images[row as usize] = Some(image);
                }
            }
        }
        let mut last = images.iter().flatten().next().copied();
        for (row, image) in images.into_iter().enumerate() {
            last = image.or(last);
            if let (None, Some(last)) = (image, last) {
                self.images[last].rows.push(row as u32);
            }
        }
        for image in &mut self.images {
            image.rows.sort_unstable();
            image.rows.dedup();
        }
    }

    fn add_materials(&mut self) {
        let all = self.all;
        let materials = companions::materials(all);
        let used: BTreeSet<&str> = all.tags.iter().map(|tag| tag.material.as_str()).collect();
        let mut images: BTreeMap<String, usize> = BTreeMap::new();
        let mut bases: BTreeMap<String, [u32; 2]> = BTreeMap::new();
        let mut paths = BTreeSet::new();
        for material in &materials {
            let is_known =
                images.contains_key(&material.name) || bases.contains_key(&material.name);
            // materials of OBJ libraries stay in these, unless faces have them
            let is_wanted = all.gltf_materials.is_some()
                || used.contains(material.name.as_str())
                || material.name.is_empty() && all.tags.is_empty();
            if is_known || !is_wanted {
                continue;
            }
            let image = material.image.as_ref().map(|image| {
                let bytes = image.bytes().map_err(|error| error.to_string())?;
                let media = media_type(&bytes)
                    .ok_or_else(|| "it is no PNG or JPEG file; convert it".to_owned())?;
                Ok::<_, String>((bytes, media))
            });
            match image {
                Some(Ok((bytes, media))) => {
                    images.insert(material.name.clone(), self.images.len());
                    let known = self.files.iter().position(|file| file.bytes == bytes);
                    let file = known.unwrap_or_else(|| {
                        let path = new_path(&mut paths, &material.name, media);
                        self.files.push(ImageFile { path, media, bytes });
                        self.files.len() - 1
                    });
                    self.order.push(Slot::Image(self.images.len()));
                    self.images.push(Image {
                        id: self.next_id,
                        file,
                        tiles: tiles(all.gltf_materials.as_deref(), &material.name),
                        rows: Vec::new(),
                    });
                    self.next_id += 2;
                    continue;
                }
                Some(Err(reason)) => {
                    self.unread.insert(material.name.clone(), reason);
                }
                None => {}
            }
            if !material.name.is_empty() {
                // several materials of a file may have one name there
                let given = entry(all.gltf_materials.as_deref(), &material.name);
                let name = given.map_or(Some(&*material.name), |m| m.get("name")?.as_str());
                let place = self.add_base(name.unwrap_or_default(), shade(all, material));
                bases.insert(material.name.clone(), place);
            }
        }
        for name in used.into_iter().filter(|name| !name.is_empty()) {
            if !images.contains_key(name) && !bases.contains_key(name) {
                bases.insert(name.to_owned(), self.add_base(name, [255; 4]));
            }
        }
        let names = all.tags.iter().map(|tag| tag.material.as_str());
        self.of_tag = names
            .chain([""])
            .map(|name| (images.get(name).copied(), bases.get(name).copied()))
            .collect();
    }

    /// Adds a base material. Returns its group and its entry there.
    fn add_base(&mut self, name: &str, color: [u8; 4]) -> [u32; 2] {
        if !matches!(self.order.last(), Some(Slot::Bases(_))) {
            self.order.push(Slot::Bases(self.bases.len()));
            let (id, list) = (self.next_id, Vec::new());
            self.bases.push(Bases { id, list });
            self.next_id += 1;
        }
        let group = self.bases.last_mut().expect("the group of the last slot");
        group.list.push((name.to_owned(), color));
        [group.id, group.list.len() as u32 - 1]
    }

    fn add_colors(&mut self) {
        let all = self.all;
        self.is_of_faces = !all.has_vertex_colors();
        let columns = if self.is_of_faces {
            &all.faces.columns
        } else {
            &all.vertices
        };
        let found = if self.is_of_faces {
            face_colors(columns)
        } else {
            Colors::of(columns)
        };
        let Some(found) = found else { return };
        let mut known: FxHashMap<[u8; 4], u32> = FxHashMap::default();
        self.has_opacity = found.alpha.is_some();
        for color in colors(columns) {
            let bytes = color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8);
            self.is_rounded |= bytes.map(|byte| f32::from(byte) / 255.0) != color;
            let entry = *known.entry(bytes).or_insert_with(|| {
                self.palette.push(bytes);
                self.palette.len() as u32 - 1
            });
            self.entries.push(entry);
        }
        if !self.palette.is_empty() {
            self.colors_id = self.next_id;
            self.next_id += 1;
        }
    }

    /// The number of the tag of a face, or that after all tags.
    fn tag_index(&self, face: usize) -> usize {
        let tag = self.all.faces.tags.get(face);
        tag.map_or(self.all.tags.len(), |&tag| tag as usize)
    }

    /// The image of a face with texture coordinates.
    fn texture_of(&self, face: usize) -> Option<usize> {
        let corners = self.all.faces.texture.get(3 * face..3 * face + 3)?;
        let image = self.of_tag[self.tag_index(face)].0?;
        let has_all = !corners.contains(&NO_VALUE) && self.all.texture.len() >= 2;
        has_all.then_some(image)
    }

    /// The group and the entries of a triangle; `None` if it shows nothing.
    fn property(&self, face: usize, triangle: &[u32; 3]) -> Option<(u32, [u32; 3])> {
        if let Some(image) = self.texture_of(face) {
            let rows = &self.images[image].rows;
            let corners = &self.all.faces.texture[3 * face..3 * face + 3];
            let entry = |k: usize| rows.partition_point(|&row| row < corners[k]) as u32;
            return Some((self.images[image].id + 1, [entry(0), entry(1), entry(2)]));
        }
        let material = self.of_tag[self.tag_index(face)].1;
        let material = material.map(|[group, base]| (group, [base; 3]));
        let colors = self.colors_of(face, triangle);
        // vertices without a colour are white, which leaves a material as it is
        let seen = colors.filter(|&colors| material.is_none() || !self.are_white(colors));
        seen.map(|colors| (self.colors_id, colors)).or(material)
    }

    /// The entries of the colours at the corners of a triangle.
    fn colors_of(&self, face: usize, triangle: &[u32; 3]) -> Option<[u32; 3]> {
        let row = |v: u32| if self.is_of_faces { face } else { v as usize };
        (!self.palette.is_empty()).then(|| triangle.map(|v| self.entries[row(v)]))
    }

    fn are_white(&self, colors: [u32; 3]) -> bool {
        let mut colors = colors.iter().map(|&entry| self.palette[entry as usize]);
        colors.all(|color| color == [255; 4])
    }
}

/// The path of a new part for the image of a material.
fn new_path(taken: &mut BTreeSet<String>, name: &str, media: &str) -> String {
    let is_safe = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let safe: String = name
        .chars()
        .map(|c| if is_safe(c) { c } else { '_' })
        .collect();
    let stem = if safe.is_empty() { "texture" } else { &safe };
    let extension = if media == "image/png" { "png" } else { "jpg" };
    let mut path = format!("3D/Textures/{stem}.{extension}");
    let mut number = 2;
    while !taken.insert(path.to_ascii_lowercase()) {
        path = format!("3D/Textures/{stem}_{number}.{extension}");
        number += 1;
    }
    path
}

/// The entry of a material of a glTF or 3MF file.
fn entry<'a>(given: Option<&'a GltfMaterials>, name: &str) -> Option<&'a Value> {
    let given = given?;
    let index = given.names.iter().position(|known| known == name)?;
    given.json.get("materials")?.get(index)
}

/// The tile styles of the base colour image of a material.
fn tiles(given: Option<&GltfMaterials>, name: &str) -> [&'static str; 2] {
    let sampler = || {
        let texture =
            entry(given, name)?.pointer("/pbrMetallicRoughness/baseColorTexture/index")?;
        let index = |value: &Value| usize::try_from(value.as_u64()?).ok();
        let json = &given?.json;
        let texture = json.get("textures")?.get(index(texture)?)?;
        json.get("samplers")?.get(index(texture.get("sampler")?)?)
    };
    ["wrapS", "wrapT"].map(|axis| {
        let value = sampler().and_then(|sampler| sampler.get(axis)?.as_u64());
        let tile = TILES.iter().find(|(_, number)| Some(*number) == value);
        tile.map_or(TILES[0].0, |(name, _)| name)
    })
}

/// The colour of a material in bytes.
fn shade(all: &Attributes, material: &Material) -> [u8; 4] {
    let [r, g, b] = material.color.unwrap_or([1.0; 3]);
    let given = entry(all.gltf_materials.as_deref(), &material.name);
    let opacity = given.and_then(|m| {
        m.pointer("/pbrMetallicRoughness/baseColorFactor/3")?
            .as_f64()
    });
    [r, g, b, opacity.unwrap_or(1.0) as f32].map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8)
}

/// A mesh of the file: faces with one object and group.
struct Part {
    faces: Vec<usize>,
    vertices: Vec<u32>,
}

/// The faces and vertices of the meshes of the file. Vertices without faces are in the mesh of the
/// vertex before them.
fn parts(mesh: &OutputMesh<'_>, sheet: &Sheet<'_>) -> Vec<(FaceTag, Part)> {
    let nothing = FaceTag::default();
    let tags: Vec<&FaceTag> = mesh.attributes.tags.iter().chain([&nothing]).collect();
    // tags with the same object and group are one
    let mut first: FxHashMap<[&str; 2], usize> = FxHashMap::default();
    let tag_of: Vec<usize> = (tags.iter().enumerate())
        .map(|(k, tag)| *first.entry([&tag.object, &tag.group]).or_insert(k))
        .collect();
    let mut index: FxHashMap<usize, usize> = FxHashMap::default();
    let mut parts: Vec<(FaceTag, Part)> = Vec::new();
    let mut owners = vec![None; mesh.positions.len()];
    for (face, triangle) in mesh.triangles.iter().enumerate() {
        let tag = tag_of[sheet.tag_index(face)];
        let number = *index.entry(tag).or_insert_with(|| {
            let (faces, vertices) = (Vec::new(), Vec::new());
            parts.push((tags[tag].clone(), Part { faces, vertices }));
            parts.len() - 1
        });
        let part = &mut parts[number].1;
        part.faces.push(face);
        part.vertices.extend_from_slice(triangle);
        for &v in triangle {
            owners[v as usize] = Some(number);
        }
    }
    let mut last = 0;
    for (v, owner) in owners.into_iter().enumerate() {
        match (owner, parts.get_mut(last)) {
            (Some(owner), _) => last = owner,
            (None, Some((_, part))) => part.vertices.push(v as u32),
            (None, None) => {}
        }
    }
    for (_, part) in &mut parts {
        part.vertices.sort_unstable();
        part.vertices.dedup();
    }
    let mut of_object: FxHashMap<String, usize> = FxHashMap::default();
    let order: Vec<usize> = (parts.iter().enumerate())
        .map(|(k, (tag, _))| *of_object.entry(tag.object.clone()).or_insert(k))
        .collect();
    let mut keyed: Vec<_> = order.into_iter().zip(parts).collect();
    keyed.sort_by_key(|(object, _)| *object);
    keyed.into_iter().map(|(_, part)| part).collect()
}

/// Writes 3MF. The mesh has been checked.
///
/// # Errors
/// The error of the writer.
pub(in super::super) fn write(
    mesh: &OutputMesh<'_>,
    sheet: &Sheet<'_>,
    out: &mut dyn Write,
) -> io::Result<()> {
    // the same mesh gives the same bytes at any time
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .large_file(mesh.triangles.len() > 10_000_000);
    let stored = options.compression_method(CompressionMethod::Stored);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("[Content_Types].xml", options)?;
    zip.write_all(CONTENT_TYPES.as_bytes())?;
    zip.start_file(RELATIONS, options)?;
    let model = [(format!("/{MODEL}"), MODEL_RELATION)];
    zip.write_all(relations(&model).as_bytes())?;
    zip.start_file(MODEL, options)?;
    model_part(mesh, sheet, &mut zip)?;
    if !sheet.files.is_empty() {
        zip.start_file(MODEL_RELATIONS, options)?;
        let paths = sheet.files.iter();
        let paths = paths.map(|file| (format!("/{}", file.path), TEXTURE_RELATION));
        zip.write_all(relations(&paths.collect::<Vec<_>>()).as_bytes())?;
    }
    for file in &sheet.files {
        zip.start_file(&file.path, stored)?;
        zip.write_all(&file.bytes)?;
    }
    out.write_all(zip.finish()?.get_ref())
}

const CONTENT_TYPES: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n\
<Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n\
<Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n\
<Default Extension=\"png\" ContentType=\"image/png\"/>\n\
<Default Extension=\"jpg\" ContentType=\"image/jpeg\"/>\n\
</Types>\n";

/// A part with relationships to these targets of these types.
fn relations(targets: &[(String, &str)]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n",
    );
    for (k, (target, kind)) in targets.iter().enumerate() {
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "<Relationship Id=\"rel{k}\" Target=\"{target}\" Type=\"{kind}\"/>"
        );
    }
    text + "</Relationships>\n"
}

/// The text of an attribute or element, without what XML cannot store.
fn plain(text: &str) -> String {
    let is_allowed = |c: &char| !c.is_control() || "\t\n\r".contains(*c);
    escape(text.chars().filter(is_allowed).collect::<String>()).into_owned()
}

fn shown(color: [u8; 4], has_opacity: bool) -> String {
    let [r, g, b, a] = color;
    if has_opacity {
        format!("#{r:02X}{g:02X}{b:02X}{a:02X}")
    } else {
        format!("#{r:02X}{g:02X}{b:02X}")
    }
}

fn model_part(mesh: &OutputMesh<'_>, sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    let all = mesh.attributes;
    let unit = if all.unit.is_empty() {
        String::new()
    } else {
        format!(" unit=\"{}\"", plain(&all.unit))
    };
    writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model{unit} xml:lang=\"en-US\" xmlns=\"{CORE}\" xmlns:m=\"{MATERIALS}\">"
    )?;
    for [name, value] in &all.metadata {
        writeln!(
            out,
            "<metadata name=\"{}\">{}</metadata>",
            plain(name),
            plain(value)
        )?;
    }
    writeln!(out, "<resources>")?;
    resources(sheet, out)?;
    let mut id = sheet.next_id;
    let mut items = Vec::new();
    let parts = parts(mesh, sheet);
    for parts in parts.chunk_by(|a, b| a.0.object == b.0.object) {
        let is_single = parts.len() == 1 && parts[0].0.group.is_empty();
        let object = &parts[0].0.object;
        let mut components = Vec::new();
        for (tag, part) in parts {
            let group = if is_single { "" } else { &tag.group };
            let name = if is_single { object } else { &tag.group };
            let head = format!("{}{}", named(name), settings(all, object, group));
            object_part(mesh, sheet, part, id, &head, out)?;
            components.push(id);
            id += 1;
        }
        if !is_single {
            let head = format!("{}{}", named(object), settings(all, object, ""));
            writeln!(out, "<object id=\"{id}\"{head}><components>")?;
            for component in components {
                writeln!(out, "<component objectid=\"{component}\"/>")?;
            }
            writeln!(out, "</components></object>")?;
            id += 1;
        }
        items.push(id - 1);
    }
    writeln!(out, "</resources>\n<build>")?;
    for item in items {
        writeln!(out, "<item objectid=\"{item}\"/>")?;
    }
    writeln!(out, "</build>\n</model>")
}

/// The attributes of an object that the file had.
fn settings(all: &Attributes, object: &str, group: &str) -> String {
    let is_it = |s: &&ObjectSettings| s.object == object && s.group == group;
    let values = all.objects.iter().find(is_it).map(|s| &s.values);
    let mut text = String::new();
    for [name, value] in values.into_iter().flatten() {
        // writing to a string cannot fail
        let _ = write!(text, " {}=\"{}\"", plain(name), plain(value));
    }
    text
}

fn named(name: &str) -> String {
    if name.is_empty() {
        String::new()
    } else {
        format!(" name=\"{}\"", plain(name))
    }
}

fn resources(sheet: &Sheet<'_>, out: &mut dyn Write) -> io::Result<()> {
    for slot in &sheet.order {
        match *slot {
            Slot::Image(k) => image_resources(sheet, &sheet.images[k], out)?,
            Slot::Bases(k) => {
                let Bases { id, list } = &sheet.bases[k];
                writeln!(out, "<basematerials id=\"{id}\">")?;
                for (name, color) in list {
                    let (name, color) = (plain(name), shown(*color, color[3] < 255));
                    writeln!(out, "<base name=\"{name}\" displaycolor=\"{color}\"/>")?;
                }
                writeln!(out, "</basematerials>")?;
            }
        }
    }
    if !sheet.palette.is_empty() {
        writeln!(out, "<m:colorgroup id=\"{}\">", sheet.colors_id)?;
        for color in &sheet.palette {
            writeln!(
                out,
                "<m:color color=\"{}\"/>",
                shown(*color, sheet.has_opacity)
            )?;
        }
        writeln!(out, "</m:colorgroup>")?;
    }
    Ok(())
}

/// Writes a texture and the group of its coordinates.
fn image_resources(sheet: &Sheet<'_>, image: &Image, out: &mut dyn Write) -> io::Result<()> {
    let (texture, group) = (image.id, image.id + 1);
    let file = &sheet.files[image.file];
    writeln!(
        out,
        "<m:texture2d id=\"{texture}\" path=\"/{}\" contenttype=\"{}\" tilestyleu=\"{}\" \
         tilestylev=\"{}\"/>",
        file.path, file.media, image.tiles[0], image.tiles[1]
    )?;
    // a group has at least one entry
    if image.rows.is_empty() {
        return Ok(());
    }
    writeln!(out, "<m:texture2dgroup id=\"{group}\" texid=\"{texture}\">")?;
    let mut text = Vec::new();
    for &row in &image.rows {
        text.extend_from_slice(b"<m:tex2coord");
        for (name, column) in [" u=\"", " v=\""].iter().zip(&**sheet.all.texture) {
            text.extend_from_slice(name.as_bytes());
            push_number(&mut text, &column.numbers, row as usize);
            text.push(b'"');
        }
        text.extend_from_slice(b"/>\n");
        flush(&mut text, CHUNK, out)?;
    }
    flush(&mut text, 0, out)?;
    writeln!(out, "</m:texture2dgroup>")
}

/// Writes text of more than `limit` bytes.
fn flush(text: &mut Vec<u8>, limit: usize, out: &mut dyn Write) -> io::Result<()> {
    if text.len() > limit {
        out.write_all(text)?;
        text.clear();
    }
    Ok(())
}

/// Writes an object with a mesh and the attributes `head`.
fn object_part(
    mesh: &OutputMesh<'_>,
    sheet: &Sheet<'_>,
    part: &Part,
    id: u32,
    head: &str,
    out: &mut dyn Write,
) -> io::Result<()> {
    let property = |face: usize| sheet.property(face, &mesh.triangles[face]);
    // the first one is the default of the object, unless some triangles have none
    let has_all = part.faces.iter().all(|&face| property(face).is_some());
    let default = match part.faces.first().and_then(|&face| property(face)) {
        Some((group, [entry, ..])) if has_all => format!(" pid=\"{group}\" pindex=\"{entry}\""),
        _ => String::new(),
    };
    writeln!(out, "<object id=\"{id}\"{head}{default}><mesh><vertices>")?;
    let mut text = Vec::new();
    for &v in &part.vertices {
        let p = mesh.positions[v as usize].to_array();
        text.extend_from_slice(b"<vertex");
        for (name, x) in [" x=\"", " y=\"", " z=\""].iter().zip(p) {
            text.extend_from_slice(name.as_bytes());
            push_f64(&mut text, x);
            text.push(b'"');
        }
        text.extend_from_slice(b"/>\n");
        flush(&mut text, CHUNK, out)?;
    }
    text.extend_from_slice(b"</vertices><triangles>\n");
    let is_whole = part.vertices.len() == mesh.positions.len();
    let index = |v: u32| {
        if is_whole {
            v as usize
        } else {
            part.vertices.partition_point(|&other| other < v)
        }
    };
    for &face in &part.faces {
        let triangle = &mesh.triangles[face];
        text.extend_from_slice(b"<triangle");
        for (name, &v) in [" v1=\"", " v2=\"", " v3=\""].iter().zip(triangle) {
            text.extend_from_slice(name.as_bytes());
            push_index(&mut text, index(v) as u64);
            text.push(b'"');
        }
        if let Some((group, entries)) = property(face) {
            let is_flat = entries.iter().all(|&entry| entry == entries[0]);
            let names = [" p1=\"", " p2=\"", " p3=\""];
            let names = names.iter().take(if is_flat { 1 } else { 3 });
            let values = [(&" pid=\"", group)].into_iter().chain(names.zip(entries));
            for (name, value) in values {
                text.extend_from_slice(name.as_bytes());
                push_index(&mut text, u64::from(value));
                text.push(b'"');
            }
        }
        text.extend_from_slice(b"/>\n");
        flush(&mut text, CHUNK, out)?;
    }
    flush(&mut text, 0, out)?;
    writeln!(out, "</triangles></mesh></object>")
}
