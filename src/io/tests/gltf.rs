//! glTF: the variety of the format, what is kept, and what is refused.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::Format::{self, Glb, Gltf, Obj, Ply};
use super::super::{
    OutputMesh, copy_companions, load, losses, open, save_mesh, save_mesh_keeping_files,
    with_output, write,
};
use super::{bad, colored, good};
use crate::mesh::{Attributes, Column, DVec3, Mesh, NO_VALUE, Soup, build};

const U8: u32 = 5121;
const U16: u32 = 5123;
const F32: u32 = 5126;

/// A file in the making.
#[derive(Clone, Default)]
pub(super) struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Document {
    /// Adds bytes. Returns their view.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.views
            .push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }));
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, kind: u32, shape: &str, count: usize) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": kind, "type": shape, "count": count,
        }));
        self.accessors.len() - 1
    }

    pub fn floats(&mut self, shape: &str, rows: &[impl AsRef<[f32]>]) -> usize {
        let numbers = rows.iter().flat_map(|row| row.as_ref().iter());
        let bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(view, F32, shape, rows.len())
    }

    fn indices(&mut self, list: &[u16]) -> usize {
        let bytes: Vec<u8> = list.iter().flat_map(|k| k.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessor(view, U16, "SCALAR", list.len())
    }

    /// The JSON with `more`; the buffer has this URI.
    pub fn json(&self, more: Value, uri: Option<&str>) -> Value {
        let mut buffer = json!({ "byteLength": self.bytes.len() });
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        let mut json = json!({
            "asset": { "version": "2.0" }, "buffers": [buffer], "bufferViews": self.views,
            "accessors": self.accessors,
        });
        let Value::Object(more) = more else {
            panic!("an object")
        };
        json.as_object_mut().expect("an object").extend(more);
        json
    }

    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.clone()
    }

    pub fn glb(&self, more: Value) -> Vec<u8> {
        glb(&self.json(more, None), &self.bytes)
    }
}

pub(super) fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + text.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

const SQUARE: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.1]];

/// A square of two triangles: the document and its mesh.
pub(super) fn square() -> (Document, Value) {
    let mut document = Document::default();
    let positions = document.floats("VEC3", &SQUARE);
    let indices = document.indices(&[0, 1, 2, 0, 2, 3]);
    let mesh =
        json!({ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] });
    (document, mesh)
}

/// A scene of one node with the first mesh.
pub(super) fn one_node(meshes: &Value) -> Value {
    json!({ "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }], "meshes": meshes })
}

/// A cube whose faces have vertices of their own, with normals and a chart each, and an image.
pub(super) fn cube() -> Vec<u8> {
    let (mut positions, mut normals, mut texture, mut corners) = (vec![], vec![], vec![], vec![]);
    for face in 0..6_u16 {
        let (axis, side) = (usize::from(face / 2), f32::from(face % 2));
        let first = positions.len() as u16;
        for (k, [x, y]) in [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].iter().enumerate() {
            let mut p = [0.0; 3];
            p[axis] = side;
            p[(axis + 1) % 3] = *x;
            p[(axis + 2) % 3] = *y;
            positions.push(p.map(|x| x + 0.1));
            let mut n = [0.0; 3];
            n[axis] = 2.0 * side - 1.0;
            normals.push(n);
            texture.push([0.1 * f32::from(face) + 0.05 * x, 1e-10 * k as f32 - 0.3 * y]);
        }
        let turn = |a, b, c| if face % 2 == 1 { [a, b, c] } else { [a, c, b] };
        corners.extend(
            [turn(0, 1, 2), turn(0, 2, 3)]
                .as_flattened()
                .iter()
                .map(|k| first + k),
        );
    }
    let mut document = Document::default();
    let attributes = json!({
        "POSITION": document.floats("VEC3", &positions),
        "NORMAL": document.floats("VEC3", &normals),
        "TEXCOORD_0": document.floats("VEC2", &texture),
    });
    let indices = document.indices(&corners);
    let image = document.view(b"\x89PNG not really");
    let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
    document.glb(json!({
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0, "name": "Cube" }],
        "meshes": [{ "primitives": [primitive], "name": "Box" }],
        "materials": [{
            "name": "Paint",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.25, 0.125, 1.0],
                "baseColorTexture": { "index": 0, "extensions": {
                    "KHR_texture_transform": { "scale": [2.0, 2.0] } } },
            },
        }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 10497 }],
        "images": [{ "bufferView": image, "mimeType": "image/png" }, { "uri": "wood%20grain.png" }],
    }))
}

fn built(soup: &Soup) -> Mesh {
    build(soup).expect("a mesh").0
}

/// A mesh as a file in a format.
fn file(mesh: &Mesh, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    with_output(mesh, |output| write(format, output, &mut bytes)).expect("a Vec takes everything");
    bytes
}

fn bits(columns: &[Column]) -> Vec<(String, Vec<u64>)> {
    let bits = |c: &Column| {
        (0..c.numbers.len())
            .map(|k| c.numbers.get(k).to_bits())
            .collect()
    };
    columns.iter().map(|c| (c.name.clone(), bits(c))).collect()
}

fn triangles(soup: &Soup) -> Vec<Vec<u32>> {
    (0..soup.face_count())
        .map(|f| soup.face(f).to_vec())
        .collect()
}

#[test]
fn a_cube_with_seams_is_closed_and_comes_back_to_the_bit() {
    let soup = good(Glb, cube());
    assert_eq!((soup.positions.len(), soup.face_count()), (24, 12));
    assert_eq!(soup.positions[0], DVec3::splat(f64::from(0.1_f32)));
    let mesh = built(&soup);
    assert_eq!(mesh.vertex_count(), 8);
    assert!(crate::mesh::boundary_loops(&mesh).is_empty());
    for format in [Glb, Gltf] {
        let bytes = file(&mesh, format);
        let again = good(format, &bytes);
        assert_eq!(again, soup);
        assert_eq!(
            bits(&again.attributes.texture),
            bits(&soup.attributes.texture)
        );
        assert_eq!(
            bits(&again.attributes.normals),
            bits(&soup.attributes.normals)
        );
        assert!(with_output(&mesh, |output| losses(format, output)).is_empty());
        assert_eq!(file(&built(&again), format), bytes);
    }
}

#[test]
fn materials_and_images_are_kept_as_they_are() {
    let soup = good(Glb, cube());
    let tags = &soup.attributes.tags;
    assert_eq!(tags.len(), 1);
    let tag = [&tags[0].object, &tags[0].group, &tags[0].material];
    assert_eq!(tag, ["Cube", "Box", "Paint"]);
    let materials = soup
        .attributes
        .gltf_materials
        .as_deref()
        .expect("materials");
    assert_eq!(
        materials.images,
        [Some(b"\x89PNG not really".to_vec().into()), None]
    );
    let bytes = file(&built(&soup), Gltf);
    let json: Value = serde_json::from_slice(&bytes).expect("JSON");
    assert_eq!(json["extensionsUsed"], json!(["KHR_texture_transform"]));
    let colour = &json["materials"][0]["pbrMetallicRoughness"];
    assert_eq!(colour["baseColorFactor"], json!([0.5, 0.25, 0.125, 1.0]));
    assert_eq!(json["images"][1]["uri"], "wood%20grain.png");
    // min and max are the single precision numbers
    let position = &json["accessors"][0];
    assert_eq!(position["min"], json!(vec![0.1_f32; 3]));
    assert_eq!(position["max"], json!(vec![1.1_f32; 3]));
    let lost = with_output(&built(&soup), |output| losses(Obj, output)).join("; ");
    assert!(
        lost.contains("OBJ gets the colours and images of materials"),
        "{lost}"
    );
    let drawn = super::super::materials(&soup.attributes);
    assert_eq!(drawn.len(), 1);
    assert_eq!(drawn[0].name, "Paint");
    let inside = crate::mesh::ImageSource::Bytes(b"\x89PNG not really".to_vec().into());
    assert_eq!(drawn[0].image, Some(inside));
    // a quarter of the light is this signal of sRGB
    assert!((drawn[0].color.expect("a colour")[1] - 0.5371).abs() < 1e-4);
    // the image file goes along to another folder
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("out")).expect("made");
    std::fs::write(at("cube.glb"), cube()).expect("written");
    std::fs::write(at("wood grain.png"), "wood").expect("written");
    let opened = open(&at("cube.glb")).expect("opened");
    assert!(opened.report.notes.is_empty());
    let mesh = opened.mesh;
    let lost = save_mesh(&at("out/cube.gltf"), &mesh).expect("saved");
    assert!(lost.is_empty(), "{lost:?}");
    let messages = copy_companions(&at("out/cube.gltf"), &mesh.attributes).messages;
    assert!(messages[0].contains("'wood grain.png'"), "{messages:?}");
    assert_eq!(
        std::fs::read(at("out/wood grain.png")).expect("copied"),
        b"wood"
    );
    // or it stays, and is named there
    save_mesh_keeping_files(&at("out/kept.gltf"), &mesh).expect("saved");
    let bytes = std::fs::read(at("out/kept.gltf")).expect("written");
    let json: Value = serde_json::from_slice(&bytes).expect("JSON");
    assert_eq!(json["images"][1]["uri"], "../wood%20grain.png");
}

#[test]
fn the_direction_of_texture_coordinates_is_that_of_the_format() {
    let soup = good(Glb, cube());
    let mesh = built(&soup);
    let v = |soup: &Soup, corner: usize| {
        let row = soup.attributes.faces.texture[corner];
        soup.attributes.texture[1].numbers.get(row as usize)
    };
    for format in [Obj, Ply] {
        let other = good(format, file(&mesh, format));
        for corner in 0..36 {
            let (a, b) = (v(&soup, corner), v(&other, corner));
            assert!((a + b - 1.0).abs() < 1e-7, "{a} {b}");
        }
        let again = good(Glb, file(&built(&other), Glb));
        for corner in 0..36 {
            assert!((v(&again, corner) - v(&soup, corner)).abs() < 1e-7);
        }
    }
    // numbers of vertices, as OFF and some PLY files have them
    let names = ["s", "t", "nx", "ny", "nz"];
    let attributes = Attributes {
        vertices: names
            .map(|name| Column::decimals(name, vec![0.25; 3]))
            .to_vec(),
        ..Attributes::default()
    };
    let mesh = OutputMesh {
        positions: &[DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: &[[0, 1, 2]],
        attributes: &attributes,
    };
    assert!(losses(Glb, &mesh).is_empty());
    let mut bytes = Vec::new();
    write(Glb, &mesh, &mut bytes).expect("a Vec takes everything");
    let all = good(Glb, bytes).attributes;
    assert_eq!(
        (all.faces.texture.len(), all.texture[1].numbers.get(0)),
        (3, 0.75)
    );
    assert_eq!(all.normals[0].numbers.get(2), 0.25);
}

#[test]
fn nodes_place_their_meshes_and_primitives_are_groups() {
    let (mut document, mesh) = square();
    let normals = document.floats("VEC3", &[[0.0_f32, 0.6, 0.8]; 4]);
    let first = mesh["primitives"][0].clone();
    let mut second = first.clone();
    second["material"] = 1.into();
    second["attributes"]["NORMAL"] = normals.into();
    let mut points = first.clone();
    points["mode"] = 0.into();
    points["attributes"]["TANGENT"] = normals.into();
    let half = 0.5_f32.sqrt();
    let bytes = document.glb(json!({
        "scene": 1,
        "scenes": [{ "nodes": [3] }, { "nodes": [0] }],
        "nodes": [
            { "name": "root", "translation": [10.0, 0.0, 0.0], "children": [1, 2] },
            // a quarter of a turn about z
            { "name": "turned", "mesh": 0, "rotation": [0.0, 0.0, half, half] },
            { "name": "mirrored", "mesh": 1, "matrix": [
                -2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 5.0, 1.0] },
            { "mesh": 2 },
        ],
        "meshes": [
            { "primitives": [first] }, { "name": "two", "primitives": [first, second, points] },
            { "primitives": [first] },
        ],
        "materials": [{ "name": "a" }, { "name": "a" }],
        "animations": [{ "channels": [], "samplers": [] }],
    }));
    let soup = good(Glb, bytes);
    assert_eq!(soup.face_count(), 6);
    let far = |v: usize, x: [f64; 3]| soup.positions[v].distance(DVec3::from(x));
    assert!(far(1, [10.0, 1.0, 0.0]) < 1e-7 && far(2, [9.0, 1.0, 0.0]) < 1e-7);
    assert!(far(5, [8.0, 0.0, 5.0]) < 1e-7);
    // a mirror turns triangles round, and normals have the inverse transform
    assert_eq!(triangles(&soup)[2..4], [[4, 6, 5], [4, 7, 6]]);
    let all = &soup.attributes;
    assert_eq!(all.faces.normals[..12], [NO_VALUE; 12]);
    let normal = [0, 1, 2].map(|k| all.normals[k].numbers.get(0) as f32);
    assert_eq!(normal, [0.0, 0.6, 0.8]);
    assert_eq!(all.faces.tags, [0, 0, 1, 1, 2, 2]);
    assert_eq!(all.tags[1].object, "mirrored");
    assert_eq!(
        (all.tags[2].group.as_str(), all.tags[2].material.as_str()),
        ("two", "a_1")
    );
    let notes = soup.notes.join("; ");
    for part in [
        "transforms of 2 nodes",
        "1 meshes outside the default scene",
        "1 primitives of points or lines",
        "animations",
    ] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    // they go back as primitives of two meshes
    let mut bytes = Vec::new();
    let triangles: Vec<[u32; 3]> = triangles(&soup)
        .iter()
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    let mesh = OutputMesh {
        positions: &soup.positions,
        triangles: &triangles,
        attributes: &soup.attributes,
    };
    write(Gltf, &mesh, &mut bytes).expect("a Vec takes everything");
    let json: Value = serde_json::from_slice(&bytes).expect("JSON");
    let names = [
        &json["nodes"][0]["name"],
        &json["nodes"][1]["name"],
        &json["meshes"][1]["name"],
    ];
    assert_eq!(names, ["turned", "mirrored", "two"]);
    assert_eq!(json["meshes"][1]["primitives"][1]["material"], 1);
    let again = good(Gltf, &bytes);
    assert_eq!(again.attributes.tags, soup.attributes.tags);
    assert_eq!(again.attributes.faces.tags, soup.attributes.faces.tags);
    assert_eq!(again.attributes.faces.normals[..12], [NO_VALUE; 12]);
    // a turned position has more digits than the format
    assert!(losses(Glb, &mesh)[0].contains("glTF coordinates are rounded to single precision"));
}

#[test]
fn strips_fans_and_lists_without_indices() {
    for (mode, with_indices, wanted) in [
        (5, true, vec![[0, 1, 2], [1, 3, 2]]),
        (5, false, vec![[0, 1, 2], [1, 3, 2]]),
        (6, true, vec![[1, 2, 0], [2, 3, 0]]),
        (4, false, vec![[0, 1, 2]]),
    ] {
        let mut document = Document::default();
        let count = if mode == 4 { 3 } else { 4 };
        let positions = document.floats("VEC3", &SQUARE[..count]);
        let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
        if with_indices {
            // a repeated corner has no area
            let list: &[u16] = if mode == 5 {
                &[0, 1, 2, 3, 3]
            } else {
                &[0, 1, 2, 3]
            };
            primitive["indices"] = document.indices(list).into();
        }
        let soup = good(
            Glb,
            document.glb(one_node(&json!([{ "primitives": [primitive] }]))),
        );
        assert_eq!(
            triangles(&soup),
            wanted.iter().map(|t| t.to_vec()).collect::<Vec<_>>()
        );
        assert!(soup.attributes == Attributes::default() && soup.notes.is_empty());
    }
}

/// Positions and colours of 8 bits side by side, and indices of 8 bits.
fn interleaved(alpha: bool) -> (Document, Value) {
    let mut document = Document::default();
    let mut bytes = Vec::new();
    for (k, p) in SQUARE.iter().enumerate() {
        bytes.extend(p.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([128, 255, k as u8, 51]);
    }
    let view = document.view(&bytes);
    document.views[view]["byteStride"] = 16.into();
    let positions = document.accessor(view, F32, "VEC3", 4);
    let colors = document.accessor(view, U8, if alpha { "VEC4" } else { "VEC3" }, 4);
    document.accessors[colors]["byteOffset"] = 12.into();
    document.accessors[colors]["normalized"] = true.into();
    let indices = document.view(&[0, 1, 2, 0, 2, 3]);
    let indices = document.accessor(indices, U8, "SCALAR", 6);
    let attributes = json!({ "POSITION": positions, "COLOR_0": colors });
    (
        document,
        json!([{ "primitives": [{ "attributes": attributes, "indices": indices }] }]),
    )
}

#[test]
fn colours_are_light_in_the_file() {
    for alpha in [false, true] {
        let (document, meshes) = interleaved(alpha);
        let soup = good(Glb, document.glb(one_node(&meshes)));
        assert_eq!(soup.positions[3].z, f64::from(0.1_f32));
        let colors = soup.attributes.vertex_colors();
        // half of the light is the signal 188
        assert!((colors[0][0] - 188.0 / 255.0).abs() < 2e-3);
        assert_eq!((colors[0][1], colors[0][2]), (1.0, 0.0));
        assert_eq!(colors[0][3], if alpha { 0.2 } else { 1.0 });
        let bytes = file(&built(&soup), Gltf);
        let json: Value = serde_json::from_slice(&bytes).expect("JSON");
        let accessor = &json["accessors"][1];
        assert_eq!(accessor["componentType"], U8);
        assert_eq!(accessor["type"], if alpha { "VEC4" } else { "VEC3" });
        assert_eq!(json["bufferViews"][1]["byteStride"], 4);
        assert_eq!(good(Gltf, bytes), soup);
    }
    // signals of 8 bits survive as light in single precision
    let shades = |k: f32| [k / 255.0, 1.0 - k / 255.0, 0.2, 1.0];
    let attributes = colored(&[shades(3.0), shades(100.0), shades(200.0)]);
    let mesh = OutputMesh {
        positions: &[DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: &[[0, 1, 2]],
        attributes: &attributes,
    };
    let mut bytes = Vec::new();
    write(Glb, &mesh, &mut bytes).expect("a Vec takes everything");
    let again = good(Glb, &bytes);
    assert_eq!(again.attributes.vertex_colors(), attributes.vertex_colors());
    assert_eq!(file(&built(&again), Glb), bytes);
}

#[test]
fn buffers_are_in_the_file_or_beside_it() {
    let (document, mesh) = square();
    let plain = good(Glb, document.glb(one_node(&json!([mesh]))));
    let data = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&document.bytes)
    );
    let text = document
        .json(one_node(&json!([mesh])), Some(&data))
        .to_string();
    assert_eq!(good(Gltf, format!("\u{feff}{text}")), plain);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mesh.gltf");
    let text = document
        .json(one_node(&json!([mesh])), Some("my%20mesh.bin"))
        .to_string();
    std::fs::write(&path, &text).expect("written");
    let message = load(&path).expect_err("no buffer").to_string();
    assert!(
        message.contains("'my mesh.bin'") && message.contains("beside"),
        "{message}"
    );
    let binary = folder.path().join("my mesh.bin");
    std::fs::write(&binary, &document.bytes[1..]).expect("written");
    let message = load(&path).expect_err("too short").to_string();
    assert!(message.contains("59 bytes instead of 60"), "{message}");
    std::fs::write(&binary, &document.bytes).expect("written");
    assert_eq!(load(&path).expect("loaded").positions, plain.positions);
    let message = bad(Gltf, &text);
    assert!(
        message.contains("in another file") && message.contains(".glb"),
        "{message}"
    );
}

#[test]
fn broken_files_are_refused_with_place_and_remedy() {
    let (document, mesh) = square();
    let meshes = json!([mesh]);
    let sound = document.glb(one_node(&meshes));
    let mut cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "empty"),
        (b"solid x".to_vec(), "instead of 'glTF'"),
        (b"{}".to_vec(), "no asset"),
        (b"{ \"asset\": }".to_vec(), "line 1 column 12"),
        (br#"{"asset":{"version":"1.0"}}"#.to_vec(), "glTF 2.0"),
        (br#"{"asset":{"version":"2.0"}}"#.to_vec(), "no vertices"),
        (
            br#"{"asset":{"version":"2.0"},"meshes":7}"#.to_vec(),
            "not valid glTF",
        ),
        (
            sound[..sound.len() - 4].to_vec(),
            "byte 8: the file is cut off",
        ),
        (sound[..10].to_vec(), "cut off"),
        (b"glTF\x01\0\0\0\0\0\0\0".to_vec(), "version 1"),
    ];
    let mut long = sound.clone();
    long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    cases.push((
        long,
        "byte 12: the file is cut off: a chunk declares 4294967295",
    ));
    let edited = |edit: &dyn Fn(&mut Value)| {
        let mut json = document.json(one_node(&meshes), None);
        edit(&mut json);
        glb(&json, &document.bytes)
    };
    let mut with = |edit: &dyn Fn(&mut Value), words| cases.push((edited(edit), words));
    with(
        &|j| j["accessors"][0]["count"] = 3.into(),
        "index 3 at place 5",
    );
    with(
        &|j| j["accessors"][0]["count"] = 5.into(),
        "POSITION of primitive 0 of mesh 0 has 5",
    );
    with(&|j| j["accessors"][0]["count"] = 0.into(), "no elements");
    with(
        &|j| j["accessors"][1]["count"] = u64::MAX.into(),
        "18446744073709551615 elements",
    );
    with(
        &|j| j["accessors"][1]["count"] = 5.into(),
        "no multiple of 3",
    );
    with(
        &|j| j["accessors"][0]["byteOffset"] = u64::MAX.into(),
        "from byte 18446744073709551615 on",
    );
    with(
        &|j| j["accessors"][1]["componentType"] = 5126.into(),
        "its buffer view has 12 bytes; export the mesh again",
    );
    with(
        &|j| j["accessors"][1]["componentType"] = 7.into(),
        "unknown type",
    );
    with(
        &|j| j["accessors"][1]["componentType"] = 5122.into(),
        "no unsigned integers",
    );
    with(
        &|j| j["accessors"][0]["type"] = "VEC2".into(),
        "'VEC2' instead of VEC3",
    );
    with(
        &|j| {
            j["accessors"][0]["sparse"] = json!({ "count": 1,
            "indices": { "bufferView": 0, "componentType": 5 },
            "values": { "bufferView": 0 } });
        },
        "sparse indices of an unknown type",
    );
    with(
        &|j| j["accessors"][0]["bufferView"] = 9.into(),
        "no buffer view",
    );
    with(
        &|j| j["accessors"][0]["bufferView"] = Value::Null,
        "has no data",
    );
    with(
        &|j| j["bufferViews"][0]["byteStride"] = 4.into(),
        "4 bytes apart, but its buffer view has 48 bytes; export the mesh again",
    );
    with(
        &|j| j["bufferViews"][0]["byteLength"] = 4_000_000_000_u32.into(),
        "the buffer has 60; export the mesh again",
    );
    with(&|j| j["bufferViews"][0]["buffer"] = 1.into(), "no buffer");
    with(
        &|j| j["buffers"][0]["byteLength"] = u64::MAX.into(),
        "60 bytes instead of",
    );
    with(&|j| j["buffers"][0]["uri"] = "data:,x".into(), "not base64");
    with(
        &|j| j["nodes"][0]["mesh"] = 5.into(),
        "mesh 5 does not exist",
    );
    with(&|j| j["nodes"][0]["children"] = json!([0]), "two parents");
    with(
        &|j| j["nodes"][0]["children"] = json!([7]),
        "node 7 does not exist",
    );
    with(
        &|j| j["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
        "not a finite number",
    );
    with(&|j| j["scene"] = 3.into(), "default scene");
    let primitive = |j: &mut Value| j["meshes"][0]["primitives"][0].take();
    with(
        &|j| j["meshes"][0]["primitives"][0]["material"] = 0.into(),
        "no material",
    );
    with(
        &|j| j["meshes"][0]["primitives"][0]["mode"] = 9.into(),
        "unknown mode 9",
    );
    with(
        &|j| j["meshes"][0]["primitives"][0]["mode"] = 1.into(),
        "no vertices",
    );
    with(
        &|j| j["meshes"][0]["primitives"][0]["indices"] = 8.into(),
        "no accessor",
    );
    with(
        &|j| j["meshes"][0]["primitives"][0]["attributes"] = json!({}),
        "no attribute POSITION",
    );
    with(
        &|j| {
            let mut taken = primitive(j);
            taken["attributes"]["NORMAL"] = 1.into();
            j["meshes"][0]["primitives"][0] = taken;
        },
        "NORMAL of primitive 0 of mesh 0 is 'SCALAR'",
    );
    with(
        &|j| j["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        "without compression",
    );
    with(
        &|j| {
            j["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
            j["accessors"][0]["bufferView"] = Value::Null;
        },
        "without compression",
    );
    with(
        &|j| j["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]),
        "this extension",
    );
    with(
        &|j| {
            j["materials"] = json!([{}]);
            let whole = json!({ "buffer": 0, "byteLength": j["buffers"][0]["byteLength"] });
            j["bufferViews"] = json!([j["bufferViews"][0], j["bufferViews"][1], whole, whole]);
            j["images"] = json!([{ "bufferView": 2 }, { "bufferView": 3 }]);
        },
        "images overlap",
    );
    for (bytes, words) in &cases {
        let message = bad(Glb, bytes);
        assert!(message.contains(words), "'{words}' is not in: {message}");
    }
    let mut nan = document.clone();
    nan.bytes[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = bad(Glb, nan.glb(one_node(&meshes)));
    assert!(
        message.contains("vertex 2 has the coordinate y = 'NaN'"),
        "{message}"
    );
}

/// Sparse accessors replace elements of a buffer view, or of zeros.
#[test]
fn sparse_accessors_are_read() {
    let (mut document, mesh) = square();
    let places = document.view(&[1, 3]);
    let bytes: Vec<u8> = [2.0_f32, 0.0, 0.0, 0.0, 2.0, 0.5]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let values = document.view(&bytes);
    let sparse = json!({
        "count": 2, "indices": { "bufferView": places, "componentType": U8 },
        "values": { "bufferView": values },
    });
    let read = |change: &dyn Fn(&mut Value)| {
        let mut json = document.json(one_node(&json!([mesh])), None);
        json["accessors"][0]["sparse"] = sparse.clone();
        change(&mut json);
        glb(&json, &document.bytes())
    };
    let replaced = good(Glb, read(&|_| {}));
    let (x, y) = (DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.5));
    let expected = [DVec3::ZERO, x, DVec3::new(1.0, 1.0, 0.0), y];
    assert_eq!(replaced.positions, expected);
    let no_view = |json: &mut Value| {
        let accessor = json["accessors"][0].as_object_mut().expect("an object");
        accessor.remove("bufferView");
    };
    let zeros = good(Glb, read(&no_view));
    assert_eq!(zeros.positions, [DVec3::ZERO, x, DVec3::ZERO, y]);
    let message = bad(Glb, read(&|json| json["accessors"][0]["count"] = 3.into()));
    assert!(message.contains("a sparse index of POSITION"), "{message}");
    let message = bad(
        Glb,
        read(&|json| {
            no_view(json);
            json["accessors"][0]["count"] = (1_u64 << 60).into();
        }),
    );
    assert!(message.contains("split the mesh"), "{message}");
}

/// Images that share a buffer view are read and written once.
#[test]
fn images_may_share_a_view() {
    let (mut document, mut mesh) = square();
    let view = document.view(&[b'\x89'; 4000]);
    mesh["primitives"][0]["material"] = 1.into();
    let image = json!({ "bufferView": view, "mimeType": "image/png" });
    let mut json = one_node(&json!([mesh]));
    json["images"] = json!([image, image]);
    json["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    let colour = |k: u32| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": k } } });
    json["materials"] = json!([colour(0), colour(1)]);
    let soup = good(Glb, document.glb(json));
    let materials = soup
        .attributes
        .gltf_materials
        .as_deref()
        .expect("materials");
    assert!(
        materials
            .images
            .iter()
            .all(|image| image.as_ref().is_some_and(|i| i.len() == 4000))
    );
    let bytes = file(&built(&soup), Glb);
    assert!(bytes.len() < 8000, "{}", bytes.len());
    let again = good(Glb, bytes);
    assert_eq!(
        again.attributes.gltf_materials,
        soup.attributes.gltf_materials
    );
}

/// Readers need the extensions of materials as before, and those of the meshes no longer.
#[test]
fn required_extensions_of_materials_stay() {
    let (mut document, mut mesh) = square();
    let view = document.view(b"RIFF and so on");
    mesh["primitives"][0]["material"] = 0.into();
    let mut json = one_node(&json!([mesh]));
    json["extensionsRequired"] = json!(["KHR_mesh_quantization", "EXT_texture_webp"]);
    json["images"] = json!([{ "bufferView": view, "mimeType": "image/webp" }]);
    json["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    let soup = good(Glb, document.glb(json));
    let written: Value = serde_json::from_slice(&file(&built(&soup), Gltf)).expect("JSON");
    for list in ["extensionsUsed", "extensionsRequired"] {
        assert_eq!(written[list], json!(["EXT_texture_webp"]), "{list}");
    }
}

/// Extensions of materials, other attributes and other sets of coordinates are no errors.
#[test]
fn unknown_parts_are_noted() {
    let (mut document, mesh) = square();
    let more = document.floats("VEC2", &[[0.5_f32, f32::NAN]; 4]);
    let mut primitive = mesh["primitives"][0].clone();
    for name in ["TEXCOORD_0", "TEXCOORD_1", "_BATCHID"] {
        primitive["attributes"][name] = more.into();
    }
    let texture = json!({ "index": 0, "texCoord": 1 });
    let mut json = one_node(&json!([{ "primitives": [primitive] }]));
    json["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_materials_unlit"]);
    json["materials"] = json!([{ "occlusionTexture": texture, "emissiveTexture": { "index": 0 } }]);
    let soup = good(Glb, document.glb(json));
    let notes = soup.notes.join("; ");
    for part in [
        "1 textures with other coordinates",
        "_BATCHID",
        "TEXCOORD_1",
        "4 numbers of normals, texture coordinates or colours are not finite",
    ] {
        assert!(notes.contains(part), "{part}: {notes}");
    }
    let materials = soup
        .attributes
        .gltf_materials
        .as_ref()
        .map(Arc::as_ref)
        .expect("materials");
    assert_eq!(materials.names, ["material_0"]);
    assert_eq!(
        materials.json["materials"],
        json!([{ "emissiveTexture": { "index": 0 } }])
    );
}
