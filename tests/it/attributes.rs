//! Attributes of a mesh file (texture coordinates, normals, colours, columns of numbers) are bit-identical
//! after every operation. The files have the structure of exports from programs for scans.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use meniscus::fill::Controls;
use meniscus::io;
use meniscus::mesh::{Column, FaceTag, LoopId, NO_VALUE, Soup, boundary_loops, row_count};
use meniscus::ops::{
    BridgeSpec, CleanSpec, EraseSpec, Faces, FacesSpec, FillSpec, FlipSpec, Operation, RefineSpec,
    StitchSpec,
};
use meniscus::refine::RefineControls;
use meniscus::runner::Schedule;
use serde_json::json;

/// Cells along each side of the sheet.
const N: usize = 8;

/// A wavy sheet with a square hole in the middle, as triangles over (N + 1)² points.
fn sheet() -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let point = |k: usize| {
        let (x, y) = (
            (k % (N + 1)) as f64 / N as f64,
            (k / (N + 1)) as f64 / N as f64,
        );
        [x, y, 0.1 * (3.0 * x).sin() * (2.0 * y).cos()]
    };
    let mut triangles = Vec::new();
    for cell in 0..N * N {
        let (i, j) = (cell % N, cell / N);
        if (3..5).contains(&i) && (3..5).contains(&j) {
            continue;
        }
        let a = j * (N + 1) + i;
        triangles.extend([[a, a + 1, a + N + 2], [a, a + N + 2, a + N + 1]]);
    }
    ((0..(N + 1) * (N + 1)).map(point).collect(), triangles)
}

/// Whether a triangle lies in the right half, whose texture is elsewhere in the image.
fn is_right(triangle: &[usize; 3]) -> bool {
    triangle.iter().map(|v| v % (N + 1)).sum::<usize>() > 3 * N / 2
}

/// An OBJ file with groups and materials, a chart of texture coordinates for each half, and normals.
fn obj(head: &str, decimals: usize, colors: bool, normals: bool, smooth: &str) -> String {
    let (points, triangles) = sheet();
    let mut text = head.to_owned();
    for (k, [x, y, z]) in points.iter().enumerate() {
        if normals && colors {
            // MeshLab writes the normal of a vertex before it
            writeln!(text, "vn {:.6} {:.6} {:.6}", -z, 0.1 * y, 0.99).expect("text");
        }
        write!(text, "v {x:.decimals$} {y:.decimals$} {z:.decimals$}").expect("text");
        if colors {
            let c = |m: usize| (k * m % 256) as f64 / 255.0;
            write!(text, " {:.6} {:.6} {:.6}", c(3), c(5), c(7)).expect("text");
        }
        text.push('\n');
    }
    for (k, [x, y, z]) in points.iter().enumerate() {
        writeln!(text, "vt {:.6} {:.6}", 0.4 * x, 0.9 * y).expect("text");
        writeln!(text, "vt {:.6} {:.6}", 0.5 + 0.4 * x, 0.9 * y).expect("text");
        if normals && !colors {
            writeln!(text, "vn {:.4} {:.4} {:.4}", -z, k as f64 / 999.0, 0.9).expect("text");
        }
    }
    for right in [false, true] {
        let side = if right { "right" } else { "left" };
        writeln!(text, "g {side} side\nusemtl {side}.001\n{smooth}").expect("text");
        for t in triangles.iter().filter(|t| is_right(t) == right) {
            let corner = t.map(|v| {
                let texture = 2 * v + 1 + usize::from(right);
                if normals {
                    format!("{}/{texture}/{}", v + 1, v + 1)
                } else {
                    format!("{}/{texture}", v + 1)
                }
            });
            writeln!(text, "f {} {} {}", corner[0], corner[1], corner[2]).expect("text");
        }
    }
    text
}

/// An OBJ file whose faces count from the end of the lists.
fn with_negative_indices(text: &str) -> String {
    let count = |keyword: &str| {
        let lines = text.lines().filter(|line| line.starts_with(keyword));
        i64::try_from(lines.count()).expect("few lines")
    };
    let counts = [count("v "), count("vt "), count("vn ")];
    let corner = |corner: &str| -> String {
        let numbers = corner.split('/').zip(counts);
        let numbers = numbers.map(|(number, count)| {
            let number: i64 = number.parse().expect("an index");
            (number - count - 1).to_string()
        });
        numbers.collect::<Vec<_>>().join("/")
    };
    let line = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => {
            let corners: Vec<String> = corners.split(' ').map(corner).collect();
            format!("f {}\n", corners.join(" "))
        }
        None => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// A PLY file with these properties of vertices and faces, whose values count up.
fn ply(head: &str, vertex: &[&str], face: &[&str], double_seam: bool) -> String {
    let (mut points, mut triangles) = sheet();
    if double_seam {
        // each half has its own vertices, as programs write them that have one texture coordinate each
        let count = points.len();
        points.extend_from_within(..);
        for t in triangles.iter_mut().filter(|t| is_right(t)) {
            *t = t.map(|v| v + count);
        }
        let mut used = vec![false; 2 * count];
        triangles.iter().flatten().for_each(|&v| used[v] = true);
        let mut place = 0;
        let places: Vec<usize> = used
            .iter()
            .map(|&is| {
                place += usize::from(is);
                place - usize::from(is)
            })
            .collect();
        let mut flags = used.iter();
        points.retain(|_| *flags.next().expect("a flag for each point"));
        for t in &mut triangles {
            *t = t.map(|v| places[v]);
        }
    }
    let mut text = format!(
        "ply\nformat ascii 1.0\n{head}element vertex {}\n",
        points.len()
    );
    for property in ["float x", "float y", "float z"].iter().chain(vertex) {
        writeln!(text, "property {property}").expect("text");
    }
    writeln!(text, "element face {}", triangles.len()).expect("text");
    for property in ["list uchar int vertex_indices"].iter().chain(face) {
        writeln!(text, "property {property}").expect("text");
    }
    text.push_str("end_header\n");
    let value = |property: &str, k: usize, m: usize| match property.split(' ').next() {
        Some("uchar") => ((k * (m + 3)) % 256).to_string(),
        Some("char") => format!("-{}", k % 100),
        Some("int" | "short" | "uint" | "ushort") => (7 * k + m).to_string(),
        Some("list") => (0..6).fold("6".to_owned(), |text, c| {
            format!("{text} {}", 0.001 * (6 * k + c) as f64)
        }),
        _ => format!("{:.7}", (k as f64 + 0.3).sqrt() / (m + 1) as f64),
    };
    for (k, [x, y, z]) in points.iter().enumerate() {
        write!(text, "{x} {y} {}", *z as f32).expect("text");
        for (m, property) in vertex.iter().enumerate() {
            write!(text, " {}", value(property, k, m)).expect("text");
        }
        text.push('\n');
    }
    for (k, [a, b, c]) in triangles.iter().enumerate() {
        write!(text, "3 {a} {b} {c}").expect("text");
        for (m, property) in face.iter().enumerate() {
            write!(text, " {}", value(property, k, m)).expect("text");
        }
        text.push('\n');
    }
    text
}

/// The same PLY file in binary.
fn binary(text: &str) -> Vec<u8> {
    let (head, body) = text.split_once("end_header\n").expect("a header");
    let mut elements: Vec<(usize, Vec<Vec<&str>>)> = Vec::new();
    for line in head.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[0] {
            "element" => elements.push((words[2].parse().expect("a count"), Vec::new())),
            "property" => elements
                .last_mut()
                .expect("an element")
                .1
                .push(words[1..].to_vec()),
            _ => {}
        }
    }
    let head = head.replace("format ascii", "format binary_little_endian");
    let mut bytes = format!("{head}end_header\n").into_bytes();
    let put = |bytes: &mut Vec<u8>, kind: &str, word: &str| match kind {
        "uchar" => bytes.push(word.parse().expect("a byte")),
        "int" => bytes.extend(word.parse::<i32>().expect("a number").to_le_bytes()),
        "float" => bytes.extend(word.parse::<f32>().expect("a number").to_le_bytes()),
        "double" => bytes.extend(word.parse::<f64>().expect("a number").to_le_bytes()),
        other => panic!("no type {other}"),
    };
    let mut lines = body.lines();
    for (count, properties) in elements {
        for line in lines.by_ref().take(count) {
            let mut words = line.split(' ');
            let mut next = || words.next().expect("a number");
            for property in &properties {
                if let ["list", length, kind, _] = property[..] {
                    let word = next();
                    put(&mut bytes, length, word);
                    for _ in 0..word.parse().expect("a length") {
                        put(&mut bytes, kind, next());
                    }
                } else {
                    put(&mut bytes, property[0], next());
                }
            }
        }
    }
    bytes
}

/// An OFF file with colours of vertices, as programs for scans write it.
fn off() -> String {
    let (points, triangles) = sheet();
    let mut text = format!("COFF\n{} {} 0\n", points.len(), triangles.len());
    for (k, [x, y, z]) in points.iter().enumerate() {
        let c = |m: usize| k * m % 256;
        writeln!(text, "{x:.6} {y:.6} {z:.6} {} {} {} 255 ", c(3), c(5), c(7)).expect("text");
    }
    for [a, b, c] in &triangles {
        writeln!(text, "3 {a} {b} {c} ").expect("text");
    }
    text
}

/// A glTF file as Blender writes it: vertices are repeated along the seam of the texture. Its JSON without
/// an address of its buffer, and the buffer.
fn gltf() -> (serde_json::Value, Vec<u8>) {
    let (points, triangles) = sheet();
    let mut number = std::collections::BTreeMap::new();
    for t in &triangles {
        for &v in t {
            let next = number.len();
            number.entry((is_right(t), v)).or_insert(next);
        }
    }
    let mut corners: Vec<(usize, (bool, usize))> = number.iter().map(|(&k, &n)| (n, k)).collect();
    corners.sort_unstable();
    let mut binary = Vec::new();
    let mut views = Vec::new();
    let mut put = |bytes: Vec<u8>| {
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        binary.extend(bytes);
        binary.resize(binary.len().next_multiple_of(4), 0);
    };
    let floats = |row: &dyn Fn(usize, bool) -> Vec<f64>| -> Vec<u8> {
        let rows = corners.iter().flat_map(|&(_, (right, v))| row(v, right));
        rows.flat_map(|x| (x as f32).to_le_bytes()).collect()
    };
    put(floats(&|v, _| points[v].to_vec()));
    put(floats(&|v, _| vec![-points[v][2], v as f64 / 999.0, 0.9]));
    put(floats(&|v, right| {
        let [x, y, _] = points[v];
        vec![0.4 * x + if right { 0.5 } else { 0.0 }, 0.9 * y]
    }));
    let shades = |m: usize| move |k: usize| (k * m % 256) as u8;
    let color = |&(_, (_, v)): &(usize, (bool, usize))| [shades(3)(v), shades(5)(v), 7, 255];
    put(corners.iter().flat_map(color).collect());
    let index = |t: &[usize; 3]| t.map(|v| number[&(is_right(t), v)] as u16);
    let indices = triangles.iter().flat_map(index);
    put(indices.flat_map(u16::to_le_bytes).collect());
    put(b"\x89PNG and so on".to_vec());
    let accessor = |view: usize, kind: u32, shape: &str| {
        let count = if view == 4 {
            3 * triangles.len()
        } else {
            corners.len()
        };
        json!({ "bufferView": view, "componentType": kind, "type": shape, "count": count,
            "normalized": kind == 5121 })
    };
    let text = json!({
        "asset": { "version": "2.0", "generator": "Khronos glTF Blender I/O v4.1.63" },
        "scene": 0,
        "scenes": [{ "name": "Scene", "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "Sheet.001" }],
        "materials": [{ "doubleSided": true, "name": "scan", "pbrMetallicRoughness": {
            "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }],
        "meshes": [{ "name": "Sheet", "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 },
            "indices": 4, "material": 0 }] }],
        "textures": [{ "source": 0 }],
        "images": [{ "bufferView": 5, "mimeType": "image/png", "name": "scan" }],
        "accessors": [
            accessor(0, 5126, "VEC3"), accessor(1, 5126, "VEC3"), accessor(2, 5126, "VEC2"),
            accessor(3, 5121, "VEC4"), accessor(4, 5123, "SCALAR"),
        ],
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
    });
    (text, binary)
}

/// A binary glTF file.
fn glb((text, binary): (serde_json::Value, Vec<u8>)) -> Vec<u8> {
    let mut text = text.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + text.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

/// The same file as Polycam writes it: the light is in the texture.
fn unlit() -> (serde_json::Value, Vec<u8>) {
    let (mut text, binary) = gltf();
    text["asset"]["generator"] = "Polycam".into();
    text["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    text["materials"][0]["extensions"] = json!({ "KHR_materials_unlit": {} });
    (text, binary)
}

/// The same file with its buffer in the JSON.
fn gltf_text() -> Vec<u8> {
    use base64::Engine as _;
    let (mut text, binary) = gltf();
    let encoded = base64::engine::general_purpose::STANDARD.encode(binary);
    let uri = format!("data:application/octet-stream;base64,{encoded}");
    text["buffers"][0]["uri"] = uri.into();
    text.to_string().into_bytes()
}

/// A 3MF file with a chart of an image for each half, as 3D Builder writes it.
fn threemf() -> Vec<u8> {
    let (points, triangles) = sheet();
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"centimeter\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n\
         <metadata name=\"Application\">Microsoft.3D Builder</metadata>\n<resources>\
         <basematerials id=\"1\"><base name=\"paint\" displaycolor=\"#804020FF\"/></basematerials>\
         <m:texture2d id=\"2\" path=\"/3D/Textures/scan.png\" contenttype=\"image/png\"/>",
    );
    for (group, left) in [(3, 0.0), (5, 0.5)] {
        write!(text, "<m:texture2dgroup id=\"{group}\" texid=\"2\">").expect("text");
        for [x, y, _] in &points {
            let u = left + 0.4 * x;
            write!(text, "<m:tex2coord u=\"{u}\" v=\"{}\"/>", 0.9 * y).expect("text");
        }
        text.push_str("</m:texture2dgroup>\n");
    }
    text.push_str("<object id=\"4\" name=\"sheet\" pid=\"1\" pindex=\"0\"><mesh><vertices>");
    for [x, y, z] in &points {
        writeln!(text, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>").expect("text");
    }
    text.push_str("</vertices><triangles>");
    for t in &triangles {
        let [a, b, c] = t;
        let group = if is_right(t) { 5 } else { 3 };
        writeln!(
            text,
            "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" pid=\"{group}\" p1=\"{a}\" p2=\"{b}\" p3=\"{c}\"/>"
        )
        .expect("text");
    }
    text.push_str(
        "</triangles></mesh></object></resources><build><item objectid=\"4\"/></build></model>",
    );
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let parts = [
        ("3D/3dmodel.model", text.as_bytes()),
        ("3D/Textures/scan.png", b"\x89PNG and so on"),
    ];
    for (name, bytes) in parts {
        zip.start_file(name, zip::write::SimpleFileOptions::default())
            .expect("a new part");
        std::io::Write::write_all(&mut zip, bytes).expect("a vector takes everything");
    }
    zip.finish()
        .expect("a vector takes everything")
        .into_inner()
}

/// A binary STL file with a header and attributes as Materialise writes them.
fn stl() -> Vec<u8> {
    let (points, triangles) = sheet();
    let mut bytes = b"COLOR=\xff\x80\x00\xff,MATERIAL=".to_vec();
    bytes.resize(80, 7);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for (k, t) in triangles.iter().enumerate() {
        bytes.extend([0; 12]);
        let corners = t.iter().flat_map(|&v| points[v]);
        bytes.extend(corners.flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend((0x8000 + 31 * k as u16).to_le_bytes());
    }
    bytes
}

/// Small files as programs export them.
fn exports() -> Vec<(&'static str, Vec<u8>)> {
    let colors = ["uchar red", "uchar green", "uchar blue"];
    let with = |more: &[&'static str]| [&colors[..], more].concat();
    let files = [
        (
            "blender.obj",
            obj(
                "# Blender 4.1.1\n# www.blender.org\nmtllib scan.mtl\no Sheet.001\n",
                6,
                false,
                true,
                "s 1",
            ),
        ),
        (
            "meshlab.obj",
            obj(
                "####\n#\n# OBJ File Generated by Meshlab\n#\n####\nmtllib ./scan.obj.mtl\n\n",
                6,
                true,
                true,
                "",
            ),
        ),
        (
            "metashape.obj",
            obj(
                "# Alias OBJ Model File\n# Exported from Agisoft Metashape\n\nmtllib scan.mtl\n\n",
                8,
                false,
                true,
                "s off",
            ),
        ),
        (
            "realitycapture.obj",
            obj(
                "# Capturing Reality\nmtllib scan.mtl\n",
                7,
                false,
                false,
                "",
            ),
        ),
        (
            "polycam.obj",
            obj("mtllib material.mtl\no mesh\n", 15, false, true, "s 0"),
        ),
        (
            // metashape-scripts issue 62: a texture of two pages
            "metashape-pages.obj",
            with_negative_indices(&obj("mtllib model.mtl\n", 8, false, true, "")),
        ),
        (
            // tiles of a texture, whose names have blanks
            "realitycapture-tiles.obj",
            (5..10).fold(
                obj(
                    "# Capturing Reality\nmtllib my scan.mtl\n",
                    7,
                    false,
                    false,
                    "",
                )
                .replace("left.001", "my scan_u1_v1")
                .replace("right.001", "my scan_u2_v1"),
                |text, digit| text.replace(&format!("vt 0.{digit}"), &format!("vt 1.{digit}")),
            ),
        ),
        (
            // loaders.gl issue 2568: colours since Blender 3.2; and loose edges
            "blender-colors.obj",
            obj(
                "# Blender 4.1.1\no Sheet # from a scan\n",
                6,
                true,
                false,
                "s 0",
            ) + "l 1 2\nl 2 3\n",
        ),
        (
            "cloudcompare.ply",
            ply(
                "comment Created by CloudCompare v2.13.1\nobj_info Generated by CloudCompare!\n",
                &with(&[
                    "float nx",
                    "float ny",
                    "float nz",
                    "float scalar_Distance",
                    "int label",
                ]),
                &[],
                false,
            ),
        ),
        (
            "meshlab.ply",
            ply(
                "comment VCGLIB generated\ncomment TextureFile scan.png\n",
                &[
                    "float nx",
                    "float ny",
                    "float nz",
                    "int flags",
                    "uchar red",
                    "uchar green",
                    "uchar blue",
                    "uchar alpha",
                    "double quality",
                ],
                &[
                    "list uchar float texcoord",
                    "int texnumber",
                    "uchar red",
                    "uchar green",
                    "uchar blue",
                    "uchar alpha",
                    "float quality",
                    "int flags",
                ],
                false,
            ),
        ),
        (
            "blender.ply",
            ply(
                "comment Created in Blender version 4.1.1\n",
                &["float nx", "float ny", "float nz", "float s", "float t"],
                &[],
                true,
            ),
        ),
        (
            "metashape.ply",
            ply(
                "",
                &with(&["uchar confidence", "ushort class"]),
                &["char side"],
                false,
            ),
        ),
        (
            "polycam.ply",
            ply(
                "comment Polycam\n",
                &[
                    "double u",
                    "double v",
                    "float red",
                    "float green",
                    "float blue",
                    "short id",
                ],
                &["uint part"],
                true,
            ),
        ),
    ];
    // CloudCompare issues 1476 and 1731: all scalar fields are floats with this prefix
    let scalars = ply(
        "comment Created by CloudCompare v2.11.1 (Anoia)\nobj_info Generated by CloudCompare!\n",
        &with(&[
            "float scalar_Intensity",
            "float scalar_label",
            "double scalar_Coord._Z",
        ]),
        &[],
        false,
    );
    let text = files
        .into_iter()
        .map(|(name, text)| (name, text.into_bytes()));
    text.chain([
        ("meshlab.off", off().into_bytes()),
        ("materialise.stl", stl()),
        ("blender.glb", glb(gltf())),
        ("blender.gltf", gltf_text()),
        ("polycam.glb", glb(unlit())),
        ("cloudcompare-binary.ply", binary(&scalars)),
        ("builder.3mf", threemf()),
    ])
    .collect()
}

fn bits(column: &Column, rows: usize) -> Vec<u64> {
    (0..rows)
        .map(|row| column.numbers.get(row).to_bits())
        .collect()
}

/// The columns of `new` begin with the rows of `old`, in the same types.
fn assert_begins(old: &[Column], new: &[Column], what: &str) {
    let heads = |columns: &[Column]| -> Vec<_> {
        columns
            .iter()
            .map(|c| (c.name.clone(), c.numbers.kind(), c.is_typed))
            .collect()
    };
    assert_eq!(heads(old), heads(new), "{what}");
    for (a, b) in old.iter().zip(new) {
        let rows = a.numbers.len();
        assert!(b.numbers.len() >= rows, "{what}");
        assert!(bits(a, rows) == bits(b, rows), "{what}: {}", a.name);
    }
}

/// The lists of a file come first in that of the result.
fn assert_lists_kept(old: &Soup, new: &Soup, what: &str) {
    let (a, b) = (&old.attributes, &new.attributes);
    assert_begins(&a.vertices, &b.vertices, what);
    // PLY has no list of texture coordinates: each face has its own
    if a.texture.iter().all(|column| !column.is_typed) {
        assert_begins(&a.texture, &b.texture, what);
    }
    assert_begins(&a.normals, &b.normals, what);
    assert_eq!(a.material_libraries, b.material_libraries, "{what}");
    assert!(
        a.comments.iter().all(|line| b.comments.contains(line)),
        "{what}"
    );
    assert_eq!(a.stl_header, b.stl_header, "{what}");
    assert_eq!(a.gltf_materials, b.gltf_materials, "{what}");
    assert_eq!((&a.unit, &a.metadata), (&b.unit, &b.metadata), "{what}");
    if !old.exploded {
        let count = old.positions.len();
        assert_eq!(new.positions[..count], old.positions, "{what}");
    }
}

/// The faces of a file come first in the result, with all their data.
fn assert_faces_kept(old: &Soup, new: &Soup, what: &str) {
    assert_lists_kept(old, new, what);
    let corners = old.corners.len();
    let at = |soup: &Soup, c: usize| soup.positions[soup.corners[c] as usize];
    for c in 0..corners {
        assert_eq!(at(old, c), at(new, c), "{what}");
    }
    assert_begins(&old.attributes.texture, &new.attributes.texture, what);
    let (a, b) = (&old.attributes.faces, &new.attributes.faces);
    assert_begins(&a.columns, &b.columns, what);
    for (a, b) in [(&a.texture, &b.texture), (&a.normals, &b.normals)] {
        assert_eq!(a[..], b[..a.len()], "{what}");
        assert!(a.is_empty() || a.len() == corners);
    }
    let tag = |soup: &Soup, f: usize| -> Option<FaceTag> {
        let index = soup.attributes.faces.tags.get(f)?;
        Some(soup.attributes.tags[*index as usize].clone())
    };
    for f in 0..old.face_count() {
        assert_eq!(tag(old, f), tag(new, f), "{what}");
    }
}

fn loops(path: &Path) -> Vec<(LoopId, usize)> {
    let mesh = io::open(path).expect("opened").mesh;
    boundary_loops(&mesh)
        .iter()
        .map(|l| (l.id, l.edges()))
        .collect()
}

/// The result of an operation on a file, written and read again.
fn after(operation: &Operation, from: &Path) -> Soup {
    let mesh = io::open(from).expect("opened").mesh;
    let new = operation
        .run(&mesh, &|_, _| true)
        .expect("an operation that fits")
        .into_mesh();
    let name = format!(
        "{}-{}",
        operation.command_name(),
        from.file_name().expect("a name").display()
    );
    let to = from.with_file_name(name);
    let lost = io::save_mesh(&to, &new).expect("written");
    assert!(
        lost.iter()
            .all(|loss| loss.contains("coordinates are rounded")),
        "{lost:?}"
    );
    io::load(&to).expect("read")
}

fn folder_with_exports() -> (tempfile::TempDir, Vec<std::path::PathBuf>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths = exports().into_iter().map(|(name, bytes)| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    });
    let paths = paths.collect();
    (folder, paths)
}

#[test]
fn files_come_back_as_they_were() {
    let (_folder, paths) = folder_with_exports();
    for path in paths {
        let what = path.display().to_string();
        let given = io::load(&path).expect("read");
        let nothing = Operation::Clean(CleanSpec::default());
        let new = after(&nothing, &path);
        assert_faces_kept(&given, &new, &what);
        assert_eq!(new.positions.len(), given.positions.len(), "{what}");
        assert_eq!(new.corners.len(), given.corners.len(), "{what}");
        // a joint of nothing changes nothing either
        let stitched = after(
            &Operation::Stitch(StitchSpec {
                tolerance: Some(0.0),
            }),
            &path,
        );
        assert_faces_kept(&given, &stitched, &what);
    }
}

#[test]
fn fills_and_bridges_keep_what_was_there() {
    let (_folder, paths) = folder_with_exports();
    for path in paths {
        let what = path.display().to_string();
        let given = io::load(&path).expect("read");
        let hole = loops(&path)
            .into_iter()
            .find(|l| l.1 == 8)
            .expect("the hole");
        let fill = Operation::Fill(FillSpec {
            loops: vec![hole.0],
            islands: true,
            bridges: Faces::default(),
            flow: Controls::default().into(),
        });
        let new = after(&fill, &path);
        assert_faces_kept(&given, &new, &what);
        assert!(new.face_count() > given.face_count());
        // the hole crosses the seam of the texture
        let patch = new.attributes.faces.texture.get(given.corners.len()..);
        assert!(patch.is_none_or(|rows| rows.iter().all(|&row| row == NO_VALUE)));
        let bridge = Operation::Bridge(BridgeSpec {
            ends: [[0.375, 0.5, 0.0], [0.625, 0.5, 0.0]].map(Into::into),
            width: 2,
        });
        let new = after(&bridge, &path);
        assert_faces_kept(&given, &new, &what);
        assert!(new.face_count() > given.face_count());
    }
}

#[test]
fn flips_take_the_corners_along() {
    let (_folder, paths) = folder_with_exports();
    for path in paths {
        let what = path.display().to_string();
        let given = io::load(&path).expect("read");
        let flip = Operation::Flip(FlipSpec {
            loops: vec![loops(&path)[0].0],
        });
        let new = after(&flip, &path);
        assert_lists_kept(&given, &new, &what);
        for f in 0..given.face_count() {
            for (k, l) in [(0, 0), (1, 2), (2, 1)] {
                let (a, b) = (corner_data(&given, 3 * f + k), corner_data(&new, 3 * f + l));
                assert_eq!(a, b, "{what}");
            }
        }
    }
}

/// The numbers of a corner and of its vertex, instead of references.
fn corner_data(soup: &Soup, corner: usize) -> Vec<u64> {
    let all = &soup.attributes;
    let v = soup.corners[corner] as usize;
    let mut data = soup.positions[v].to_array().map(f64::to_bits).to_vec();
    data.extend(
        all.vertices
            .iter()
            .map(|column| column.numbers.get(v).to_bits()),
    );
    for (list, columns) in [
        (&all.faces.texture, &all.texture),
        (&all.faces.normals, &all.normals),
    ] {
        let row = list.get(corner).copied().unwrap_or(NO_VALUE) as usize;
        if row != NO_VALUE as usize {
            data.extend(
                columns
                    .iter()
                    .map(|column| column.numbers.get(row).to_bits()),
            );
        }
    }
    data
}

/// The numbers of a face and its corners.
fn data_of(soup: &Soup, face: usize) -> Vec<u64> {
    let columns = soup.attributes.faces.columns.iter();
    let mut data: Vec<u64> = columns.map(|c| c.numbers.get(face).to_bits()).collect();
    for corner in 3 * face..3 * face + 3 {
        data.extend(corner_data(soup, corner));
    }
    data
}

#[test]
fn erased_and_refilled_meshes_keep_the_other_faces() {
    let (_folder, paths) = folder_with_exports();
    for path in paths {
        let what = path.display().to_string();
        let given = io::load(&path).expect("read");
        // the two faces of a cell
        let is_erased = |&f: &usize| {
            let corners = given.face(f).iter().map(|&v| given.positions[v as usize]);
            let centre = corners.sum::<meniscus::mesh::DVec3>() / 3.0;
            [centre.x, centre.y]
                .iter()
                .all(|x| (0.125..0.25).contains(x))
        };
        let (faces, others): (Vec<usize>, Vec<usize>) =
            (0..given.face_count()).partition(is_erased);
        assert_eq!(faces.len(), 2, "{what}");
        let faces = Arc::new(faces.iter().map(|&f| f as u32).collect::<Vec<u32>>());
        let left: Vec<Vec<u64>> = others.iter().map(|&f| data_of(&given, f)).collect();
        let erase = Operation::Erase(EraseSpec {
            faces: Arc::clone(&faces),
        });
        let refill = Operation::Refill(FacesSpec {
            faces,
            flow: Controls::default().into(),
        });
        for operation in [erase, refill] {
            let new = after(&operation, &path);
            for (f, data) in left.iter().enumerate() {
                assert_eq!(*data, data_of(&new, f), "{what}: {operation:?}");
            }
            // the cell is inside one chart of the OBJ, glTF and 3MF files; faces of meshlab.ply have no chart
            let patch = new.attributes.faces.texture.get(3 * left.len()..);
            let has_chart = path
                .extension()
                .is_some_and(|e| e == "obj" || e == "glb" || e == "gltf" || e == "3mf");
            let mut rows = patch.unwrap_or_default().iter();
            assert!(rows.all(|&row| (row != NO_VALUE) == has_chart), "{what}");
        }
    }
}

#[test]
fn refined_meshes_interpolate_linearly() {
    let (_folder, paths) = folder_with_exports();
    for path in paths {
        let what = path.display().to_string();
        let given = io::load(&path).expect("read");
        for crease_angle in [None, Some(1.0)] {
            let refine = Operation::Refine(RefineSpec {
                controls: RefineControls {
                    levels: 1,
                    steps: 2,
                    crease_angle,
                    ..RefineControls::default()
                },
                creases: Vec::new(),
                faces: Arc::default(),
                schedule: Schedule::default(),
            });
            let new = after(&refine, &path);
            assert_lists_kept(&given, &new, &what);
            assert_eq!(new.face_count(), 4 * given.face_count());
            // the middle triangle of a face has the means of its corners
            let (a, b) = (&given.attributes, &new.attributes);
            for f in 0..given.face_count() {
                let middle = 3 * (4 * f + 3);
                for k in 0..3 {
                    let ends = [3 * f + k, 3 * f + (k + 1) % 3];
                    let mean = |columns: &[Column], list: &[u32], column: usize| {
                        let number = |c: usize| columns[column].numbers.get(list[c] as usize);
                        0.5 * (number(ends[0]) + number(ends[1]))
                    };
                    let has_texture = !a.faces.texture.is_empty();
                    for column in 0..if has_texture { a.texture.len() } else { 0 } {
                        let row = b.faces.texture[middle + k] as usize;
                        let found = b.texture[column].numbers.get(row);
                        let wanted = mean(&a.texture, &a.faces.texture, column);
                        assert!((found - wanted).abs() < 1e-6, "{what}");
                    }
                    for (column, numbers) in a.vertices.iter().enumerate() {
                        if ["s", "t", "u", "v", "quality"].contains(&numbers.name.as_str()) {
                            let row = new.corners[middle + k] as usize;
                            let found = b.vertices[column].numbers.get(row);
                            let wanted = mean(&a.vertices, &given.corners, column);
                            assert!((found - wanted).abs() < 1e-6, "{what}: {}", numbers.name);
                        }
                    }
                }
            }
            assert!(row_count(&b.vertices) == 0 || row_count(&b.vertices) == new.positions.len());
        }
    }
}

/// A library and its images go with a mesh to another folder, and replace nothing there.
#[test]
fn libraries_and_images_go_along() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("in/maps")).expect("made");
    std::fs::create_dir_all(at("out")).expect("made");
    let library = "newmtl a\nmap_Kd -s 1 1 1 -blendu on maps/my image.png\nbump -bm 0.5 maps/b.png\n\
        map_Ks missing.png\nmap_d ../outside.png\n";
    let library = format!("{library}map_Ke {}\n", at("outside.png").display());
    std::fs::write(at("in/scan.mtl"), &library).expect("written");
    for name in ["in/maps/my image.png", "in/maps/b.png", "outside.png"] {
        std::fs::write(at(name), name).expect("written");
    }
    std::fs::write(
        at("in/mesh.obj"),
        obj("mtllib scan.mtl\n", 6, false, false, ""),
    )
    .expect("written");
    let mesh = io::open(&at("in/mesh.obj")).expect("opened").mesh;
    let nothing = io::Companions::default();
    assert_eq!(
        io::copy_companions(&at("in/other.obj"), &mesh.attributes),
        nothing
    );
    std::fs::create_dir_all(at("out/maps")).expect("made");
    std::fs::write(at("out/maps/b.png"), "another").expect("written");
    let companions = io::copy_companions(&at("out/mesh.obj"), &mesh.attributes);
    assert_eq!(companions.others, ["maps/b.png"]);
    let messages = &companions.messages;
    let read = |name: &str| std::fs::read_to_string(at(name)).expect("there");
    assert_eq!(read("out/scan.mtl"), library);
    assert_eq!(read("out/maps/my image.png"), "in/maps/my image.png");
    assert_eq!(read("out/maps/b.png"), "another");
    let text = messages.join("\n");
    for part in [
        "copied from",
        "'maps/my image.png', 'scan.mtl'",
        "'maps/b.png' was not copied",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // these paths lead to the same file from here
    assert!(!text.contains("outside.png"), "{text}");
    assert!(companions.outside.is_empty());
    // and one of them leads nowhere from another depth
    std::fs::create_dir_all(at("deep/out")).expect("made");
    let deep = io::copy_companions(&at("deep/out/mesh.obj"), &mesh.attributes);
    assert_eq!(deep.outside, ["../outside.png"]);
    let messages = deep.messages.iter();
    let about: Vec<&String> = messages.filter(|m| m.contains("outside.png")).collect();
    assert!(
        about.len() == 1 && about[0].contains("'../outside.png' was not copied: its path leaves"),
        "{about:?}"
    );
    // nothing is left to copy
    assert!(
        !io::copy_companions(&at("out/mesh.obj"), &mesh.attributes)
            .messages
            .join("")
            .contains("copied from")
    );
}
