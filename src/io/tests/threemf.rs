//! 3MF: the variety of the format, what is kept, and what is refused.

use std::io::{Cursor, Write as _};
use std::path::Path;

use zip::write::SimpleFileOptions;

use super::super::Format::{self, Glb, Obj, ThreeMf};
use super::super::{OutputMesh, losses, materials, read, write};
use super::{bad, good};
use crate::mesh::{Attributes, Column, DVec3, ImageSource, NO_VALUE, Soup, build};

const MODEL: &str = "3D/3dmodel.model";
const PNG: &[u8] = b"\x89PNG and so on";

/// An archive with these parts.
fn archive(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        zip.start_file(*name, SimpleFileOptions::default())
            .expect("a new part");
        zip.write_all(bytes).expect("a vector takes everything");
    }
    zip.finish()
        .expect("a vector takes everything")
        .into_inner()
}

/// A model with these resources and items.
fn model(head: &str, resources: &str, items: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<model xml:lang=\"en\" {head} \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
         xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" \
         xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\">\n\
         <resources>\n{resources}\n</resources>\n<build>{items}</build>\n</model>\n"
    )
}

fn file(model: &str) -> Vec<u8> {
    archive(&[(MODEL, model.as_bytes())])
}

const SQUARE: [&str; 4] = ["0 0 0", "1 0 0", "1 1 0", "0 1 0.1"];

/// An object with a square of two triangles, which have these attributes.
fn square(id: u32, attributes: &str, triangles: [&str; 2]) -> String {
    let vertex = |text: &&str| {
        let n: Vec<&str> = text.split(' ').collect();
        format!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", n[0], n[1], n[2])
    };
    let vertices: String = SQUARE.iter().map(vertex).collect();
    format!(
        "<object id=\"{id}\" {attributes}><mesh><vertices>{vertices}</vertices><triangles>\n\
         <triangle v1=\"0\" v2=\"1\" v3=\"2\" {}/>\n<triangle v1=\"0\" v2=\"2\" v3=\"3\" {}/>\n\
         </triangles></mesh></object>",
        triangles[0], triangles[1]
    )
}

/// The file of a soup of triangles.
fn written(format: Format, soup: &Soup) -> Vec<u8> {
    let triangles: Vec<[u32; 3]> = soup.corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
    let mesh = OutputMesh {
        positions: &soup.positions,
        triangles: &triangles,
        attributes: &soup.attributes,
    };
    assert_eq!(super::super::check(format, &mesh), Ok(()));
    if format == ThreeMf {
        assert_eq!(losses(format, &mesh), [""; 0]);
    }
    let mut bytes = Vec::new();
    write(format, &mesh, &mut bytes).expect("a vector takes everything");
    bytes
}

/// The file is written and read again to the same bits.
#[track_caller]
fn comes_back(soup: &Soup) {
    let bytes = written(ThreeMf, soup);
    let again = good(ThreeMf, &bytes);
    assert_eq!(again.positions, soup.positions);
    assert_eq!(again.corners, soup.corners);
    assert_eq!(again.attributes, soup.attributes);
    assert!(again.notes.is_empty(), "{:?}", again.notes);
    assert!(bytes == written(ThreeMf, &again), "other bytes");
}

/// The same after the repair of loading.
#[track_caller]
fn comes_back_repaired(soup: &Soup) {
    comes_back(soup);
    let (mesh, _) = build(soup).expect("a mesh");
    super::super::with_output(&mesh, |output| {
        let mut bytes = Vec::new();
        write(ThreeMf, output, &mut bytes).expect("a vector takes everything");
        let third = good(ThreeMf, bytes);
        assert_eq!(third.positions, soup.positions);
        assert_eq!(third.attributes, soup.attributes);
    });
}

fn column(soup: &[Column], name: &str) -> Vec<f64> {
    let column = soup.iter().find(|c| c.name == name).expect("a column");
    (0..column.numbers.len())
        .map(|row| column.numbers.get(row))
        .collect()
}

/// The specification asks for whole numbers.
#[test]
fn ids_may_be_words() {
    let colors = "<m:colorgroup id=\"m0\"><m:color color=\"#FF0000\"/></m:colorgroup>";
    let object = square(1, "pid=\"m0\" pindex=\"0\"", ["pid=\"m0\" p1=\"0\"", ""]);
    let object = object.replace("id=\"1\"", "id=\"body\"");
    let resources = format!("{colors}{object}");
    let soup = good(
        ThreeMf,
        file(&model("", &resources, "<item objectid=\"body\"/>")),
    );
    assert_eq!(soup.face_count(), 2);
    assert_eq!(soup.attributes.vertex_colors()[0], [1.0, 0.0, 0.0, 1.0]);
    let message = bad(
        ThreeMf,
        file(&model("", &resources, "<item objectid=\"arm\"/>")),
    );
    assert!(message.contains("no object with the id arm"), "{message}");
}

#[test]
fn items_and_components_are_placed() {
    let resources = [
        square(1, "name=\"leaf\"", ["", ""]),
        "<object id=\"7\" name=\"pair\" type=\"model\"><components><component objectid=\"1\"/>\
         <component objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 10 0 0\"/></components></object>"
            .to_owned(),
    ]
    .concat();
    let items = "<item objectid=\"7\" transform=\"2 0 0 0 2 0 0 0 2 0 0 5\"/>\
                 <item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/><item objectid=\"1\"/>";
    let head = "unit=\"inch\"";
    let text = model(head, &resources, items).replace(
        "<resources>",
        "<metadata name=\"Title\">A &amp; B</metadata><resources>",
    );
    let soup = good(ThreeMf, file(&text));
    assert_eq!(soup.face_count(), 8);
    assert_eq!(soup.positions.len(), 16);
    let at = |v: usize| soup.positions[v].to_array();
    assert_eq!(at(1), [2.0, 0.0, 5.0]);
    // a quarter turn, moved by 10, then twice as large
    assert_eq!(at(5), [20.0, 2.0, 5.0]);
    assert_eq!(at(9), [-1.0, 0.0, 0.0]);
    assert_eq!(at(13), [1.0, 0.0, 0.0]);
    // a mirror turns triangles around
    assert_eq!(soup.corners[12..15], [8, 10, 9]);
    assert_eq!(soup.corners[18..21], [12, 13, 14]);
    assert_eq!(
        soup.notes,
        ["the transforms of 3 items and components are applied to their objects"]
    );
    let all = &soup.attributes;
    assert_eq!(all.unit, "inch");
    assert_eq!(all.metadata, [["Title".to_owned(), "A & B".to_owned()]]);
    let names: Vec<[&str; 2]> = all
        .tags
        .iter()
        .map(|tag| [tag.object.as_str(), tag.group.as_str()])
        .collect();
    assert_eq!(
        names,
        [
            ["pair", "leaf"],
            ["pair", "leaf_2"],
            ["leaf", ""],
            ["leaf_2", ""]
        ]
    );
    comes_back(&soup);
    let text = String::from_utf8(written(Obj, &soup)).expect("text");
    assert!(text.contains("o pair\ng leaf\n"), "{text}");
    assert!(text.contains("g leaf_2\nf 5 6 7\n"), "{text}");
}

#[test]
fn types_and_part_numbers_of_objects_come_back() {
    let resources = square(
        1,
        "type=\"support\" partnumber=\"A &amp; 1\" name=\"leg\"",
        ["", ""],
    ) + &square(2, "type=\"model\" name=\"top\"", ["", ""])
        + &square(3, "type=\"other\" name=\"a\"", ["", ""])
        + &square(4, "name=\"b\"", ["", ""])
        + "<object id=\"5\" type=\"solidsupport\" name=\"both\"><components>\
           <component objectid=\"3\"/><component objectid=\"4\"/></components></object>";
    let items = "<item objectid=\"1\"/><item objectid=\"2\"/><item objectid=\"5\"/>";
    let soup = good(ThreeMf, file(&model("", &resources, items)));
    let found: Vec<(&str, &str, Vec<String>)> = (soup.attributes.objects.iter())
        .map(|s| {
            (
                &*s.object,
                &*s.group,
                s.values.iter().map(|v| v.join("=")).collect(),
            )
        })
        .collect();
    let text = |list: &[&str]| list.iter().map(|text| (*text).to_owned()).collect();
    assert_eq!(
        found,
        [
            ("leg", "", text(&["type=support", "partnumber=A & 1"])),
            ("both", "", text(&["type=solidsupport"])),
            ("both", "a", text(&["type=other"])),
        ]
    );
    comes_back(&soup);
    let (mesh, _) = build(&soup).expect("a mesh");
    let lost = super::super::with_output(&mesh, |output| losses(Obj, output));
    assert_eq!(lost, ["OBJ cannot store types and part numbers of objects"]);
    // what belongs to one file only is said
    let resources = square(1, "p:UUID=\"1\" thumbnail=\"t.png\"", ["", ""]);
    let item = "<item objectid=\"1\" p:UUID=\"2\" printable=\"1\"/>";
    let soup = good(ThreeMf, file(&model("", &resources, item)));
    assert_eq!(
        soup.notes,
        ["not kept: UUIDs, item printable, object thumbnail"]
    );
}

#[test]
fn an_object_alone_has_no_group() {
    let soup = good(
        ThreeMf,
        file(&model(
            "",
            &square(3, "", ["", ""]),
            "<item objectid=\"3\"/>",
        )),
    );
    assert_eq!(soup.attributes, Attributes::default());
    assert_eq!(soup.positions[3], DVec3::new(0.0, 1.0, 0.1));
    comes_back_repaired(&soup);
}

const COLORS: &str = "<m:colorgroup id=\"2\"><m:color color=\"#FF8000\"/>\
                      <m:color color=\"#01020340\"/><m:color color=\"#00ff00\"/></m:colorgroup>";

#[test]
fn colours_of_groups_are_those_of_vertices_or_faces() {
    let with = |triangles| {
        let resources = COLORS.to_owned() + &square(3, "pid=\"2\" pindex=\"0\"", triangles);
        good(
            ThreeMf,
            file(&model("", &resources, "<item objectid=\"3\"/>")),
        )
    };
    let vertices = with(["p1=\"0\" p2=\"1\" p3=\"2\"", "p1=\"0\" p2=\"2\" p3=\"1\""]);
    assert_eq!(
        column(&vertices.attributes.vertices, "red"),
        [255.0, 1.0, 0.0, 1.0]
    );
    assert_eq!(
        column(&vertices.attributes.vertices, "alpha"),
        [255.0, 64.0, 255.0, 64.0]
    );
    comes_back_repaired(&vertices);

    let faces = with(["", "p1=\"2\""]);
    assert!(faces.attributes.vertices.is_empty());
    assert_eq!(
        column(&faces.attributes.faces.columns, "green"),
        [128.0, 255.0]
    );
    comes_back_repaired(&faces);

    // vertex 0 has two colours in triangles with several
    let both = with(["p1=\"0\" p2=\"1\" p3=\"2\"", "p1=\"1\" p2=\"2\" p3=\"0\""]);
    assert_eq!(both.positions.len(), 5);
    assert_eq!(both.positions[4], both.positions[0]);
    assert_eq!(both.corners[3..], [4, 2, 3]);
    assert_eq!(
        column(&both.attributes.vertices, "blue"),
        [0.0, 3.0, 0.0, 0.0, 3.0]
    );
    comes_back_repaired(&both);
}

/// Textures and base materials as 3D Builder writes them.
fn builder() -> Vec<u8> {
    let resources = [
        "<basematerials id=\"1\"><base name=\"red\" displaycolor=\"#C80010\"/>\
         <base name=\"glass\" displaycolor=\"#0102037F\"/><base name=\"red\" displaycolor=\"#FFFFFF\"/>\
         </basematerials>\
         <m:texture2d id=\"4\" path=\"/3D/Textures/wood.png\" contenttype=\"image/png\" \
         tilestyleu=\"clamp\" tilestylev=\"mirror\"/>\
         <m:texture2dgroup id=\"5\" texid=\"4\"><m:tex2coord u=\"0.25\" v=\"0.1\"/>\
         <m:tex2coord u=\"1\" v=\"0\"/><m:tex2coord u=\"0.3\" v=\"-1.5\"/></m:texture2dgroup>",
        &square(6, "name=\"a\" pid=\"5\" pindex=\"0\"", [
            "pid=\"5\" p1=\"0\" p2=\"1\" p3=\"2\"",
            "pid=\"1\" p1=\"1\"",
        ]),
        &square(8, "name=\"b\"", ["pid=\"1\" p1=\"2\"", ""]),
    ]
    .concat();
    let model = model(
        "",
        &resources,
        "<item objectid=\"6\"/><item objectid=\"8\"/>",
    );
    let relations = "<Relationships><Relationship Target=\"/3D/other.model\" Id=\"rel0\" \
        Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    archive(&[
        ("[Content_Types].xml", b"<Types/>"),
        ("_rels/.rels", relations.as_bytes()),
        ("3D/other.model", model.as_bytes()),
        ("3D/Textures/Wood.png", PNG),
    ])
}

#[test]
fn materials_and_textures_come_back() {
    let soup = good(ThreeMf, builder());
    assert!(soup.notes.is_empty(), "{:?}", soup.notes);
    let all = &soup.attributes;
    let names: Vec<&str> = all.tags.iter().map(|tag| tag.material.as_str()).collect();
    assert_eq!(names, ["wood", "glass", "red_2", ""]);
    assert_eq!(column(&all.texture, "v"), [0.1, 0.0, -1.5]);
    assert_eq!(all.faces.texture[..3], [0, 1, 2]);
    assert_eq!(all.faces.texture[3..], [NO_VALUE; 9]);
    let drawn = materials(all);
    let named = |name: &str| drawn.iter().find(|m| m.name == name).expect("a material");
    assert_eq!(
        named("wood").image,
        Some(ImageSource::Bytes(PNG.to_vec().into()))
    );
    let red = named("red").color.expect("a colour");
    assert!((red[0] - 200.0 / 255.0).abs() < 1e-6 && red[1] == 0.0);
    comes_back(&soup);

    // the same in glTF, and back
    let gltf = good(Glb, written(Glb, &soup));
    let all = &gltf.attributes;
    assert_eq!(all.gltf_materials, soup.attributes.gltf_materials);
    let back = good(ThreeMf, {
        let triangles: Vec<[u32; 3]> = gltf.corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        let mesh = OutputMesh {
            positions: &gltf.positions,
            triangles: &triangles,
            attributes: all,
        };
        let mut bytes = Vec::new();
        write(ThreeMf, &mesh, &mut bytes).expect("a vector takes everything");
        bytes
    });
    assert_eq!(back.attributes.gltf_materials, all.gltf_materials);
    let v = column(&back.attributes.texture, "v");
    assert!((v[0] - 0.1).abs() < 1e-6 && v[2] == -1.5, "{v:?}");
}

/// Slicers write each object into a part of its own.
#[test]
fn objects_of_other_parts_are_read() {
    let root = model(
        "requiredextensions=\"p\" xmlns:paint=\"x\"",
        "<object id=\"8\" p:UUID=\"1\" type=\"model\"><components><component \
         p:path=\"/3D/Objects/object_1.model\" objectid=\"1\" p:UUID=\"2\" \
         transform=\"1 0 0 0 1 0 0 0 1 0 0 3\"/></components></object>",
        "<item objectid=\"8\" p:UUID=\"3\" printable=\"1\"/>",
    );
    let inner = model(
        "",
        &square(1, "type=\"model\"", ["paint_color=\"4\"", ""]),
        "",
    );
    let bytes = archive(&[
        (MODEL, root.as_bytes()),
        ("3D/Objects/object_1.model", inner.as_bytes()),
        ("Metadata/project_settings.config", b"{}"),
    ]);
    let soup = good(ThreeMf, bytes);
    assert_eq!(soup.positions[1].to_array(), [1.0, 0.0, 3.0]);
    assert_eq!(
        soup.notes,
        [
            "the transforms of 1 items and components are applied to their objects",
            "not kept: UUIDs, item printable, triangle paint_color, Metadata/project_settings.config"
        ]
    );
}

#[test]
fn what_is_not_kept_is_said() {
    let resources = "<m:multiproperties id=\"9\" pids=\"1\"><m:multi pindices=\"0\"/>\
        </m:multiproperties>"
        .to_owned()
        + &square(1, "", ["pid=\"9\" p1=\"0\"", ""]).replace(
            "<triangles>",
            "<b:beamlattice><b:beams/></b:beamlattice><triangles>",
        );
    let soup = good(
        ThreeMf,
        file(&model("", &resources, "<item objectid=\"1\"/>")),
    );
    assert_eq!(
        soup.notes,
        [
            "1 triangles have properties that are not kept",
            "not kept: b:beamlattice, m:multiproperties"
        ]
    );
}

#[track_caller]
fn says(bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let message = bad(ThreeMf, bytes);
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

#[test]
fn broken_files_are_refused() {
    says("", &["the file is empty"]);
    says(
        "solid a",
        &["not valid 3MF", "'solid a' instead of a ZIP archive"],
    );
    let whole = builder();
    says(
        &whole[..whole.len() / 2],
        &["cut off", "no valid directory"],
    );
    says(
        archive(&[("a.txt", b"")]),
        &["no model, no part '3D/3dmodel.model'"],
    );
    let item = "<item objectid=\"1\"/>";
    let with = |from: &str, to: &str| {
        let text = model("", &square(1, "", ["", ""]), item);
        assert!(text.contains(from), "{from}");
        file(&text.replacen(from, to, 1))
    };
    let place = "3D/3dmodel.model, line 5: ";
    says(
        with("x=\"1\"", "x=\"1,5\""),
        &[place, "x is not a number: '1,5'", "decimal point"],
    );
    says(
        with("x=\"1\"", "x=\"1e999\""),
        &[place, "vertex 2", "not a finite number"],
    );
    says(with("x=\"1\"", ""), &[place, "vertex 2 has 2 numbers"]);
    says(
        with("v3=\"2\"", "v3=\"4\""),
        &["line 9: face 1 uses vertex 4", "4 vertices, counted from 0"],
    );
    says(with("v3=\"2\"", ""), &["face 1 has 2 corners"]);
    says(
        with("v3=\"2\"", "v3=\"-1\""),
        &["the index v3 is not a number: '-1'"],
    );
    says(
        with("id=\"1\"", "name=\"1\""),
        &["'object' has no attribute 'id'"],
    );
    says(
        with(item, "<item objectid=\"5\"/>"),
        &["no object with the id 5"],
    );
    says(with("</mesh>", ""), &["line 11", "the XML is malformed"]);
    says(with("</model>", ""), &["cut off", "elements do not end"]);
    says(file("<a></a>"), &["without an element 'model'"]);
    says(
        with(item, "<item objectid=\"1\" transform=\"1 0 0\"/>"),
        &["twelve numbers: '1 0 0'"],
    );
    says(
        with("<model", "<model requiredextensions=\"b\""),
        &["requires the extension beamlattice/2017/02 is not supported"],
    );
    says(with("0.1", "0.1\u{e9}"), &["is not a number"]);
    let wide = |unit: fn(u16) -> [u8; 2], mark: &[u8]| {
        let text = model("", &square(1, "", ["", ""]), item);
        let units = text.encode_utf16().flat_map(unit);
        archive(&[(
            MODEL,
            &mark.iter().copied().chain(units).collect::<Vec<u8>>(),
        )])
    };
    let same = good(ThreeMf, file(&model("", &square(1, "", ["", ""]), item)));
    assert_eq!(good(ThreeMf, wide(u16::to_le_bytes, b"\xff\xfe")), same);
    assert_eq!(good(ThreeMf, wide(u16::to_be_bytes, b"\xfe\xff")), same);
    let text = model("", &square(1, "", ["", ""]), item);
    let latin = [&b"<!-- caf\xe9 -->"[..], text.as_bytes()].concat();
    says(
        archive(&[(MODEL, &latin)]),
        &["line 1", "neither UTF-8 nor UTF-16", "export it with UTF-8"],
    );
    let mut changed = archive(&[(MODEL, model("", "", "").as_bytes())]);
    changed[60] ^= 1;
    says(
        changed,
        &[
            "the file is damaged",
            "the part '3D/3dmodel.model' cannot be read",
        ],
    );
    let mut changed = builder();
    while let Some(at) = changed.windows(4).position(|four| four == b"PK\x01\x02") {
        changed[at] = b'Q';
    }
    says(changed, &["the file is damaged", "no valid directory"]);
    says(
        file(&model("", &square(1, "", ["", ""]), "")),
        &["the build places none of the 1 objects; place them"],
    );
    let resources = COLORS.to_owned() + &square(1, "pid=\"2\" pindex=\"0\"", ["p1=\"3\"", ""]);
    says(
        file(&model("", &resources, item)),
        &["entry 3 of the property group 2, which has 3"],
    );
    says(
        file(&model("", &COLORS.replace("#00ff00", "#00ff+0"), "")),
        &["six or eight digits, as in #FF8000: '#00ff+0'"],
    );
}

#[test]
fn archives_that_would_fill_the_memory_are_refused() {
    // 64 MiB of spaces
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file(MODEL, SimpleFileOptions::default())
        .expect("a new part");
    let spaces = vec![b' '; 1 << 20];
    for _ in 0..64 {
        zip.write_all(&spaces).expect("a vector takes everything");
    }
    let bytes = zip
        .finish()
        .expect("a vector takes everything")
        .into_inner();
    assert!(bytes.len() < 1 << 18);
    says(&bytes, &["'3D/3dmodel.model' has more than the"]);
    // components of components
    let mut resources = square(1, "", ["", ""]);
    for id in 2..40 {
        let one = format!("<component objectid=\"{}\"/>", id - 1);
        let object = format!("<object id=\"{id}\"><components>{one}{one}</components></object>");
        resources.push_str(&object);
    }
    let nested = |id: u32| {
        file(&model(
            "",
            &resources,
            &format!("<item objectid=\"{id}\"/>"),
        ))
    };
    assert_eq!(good(ThreeMf, nested(5)).face_count(), 32);
    says(
        nested(39),
        &[
            "vertices and triangles: more than 4294967295",
            "split the mesh",
        ],
    );
    let own = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    says(
        file(&model("", own, "<item objectid=\"1\"/>")),
        &["object 1 is in more than 64 others, or contains itself"],
    );
}

#[test]
fn half_of_a_file_never_panics() {
    let whole = builder();
    for length in 0..whole.len() {
        assert!(read(ThreeMf, &whole[..length], Path::new("mesh")).is_err());
    }
}

#[test]
fn base_materials_stay_beside_objects_with_colours() {
    let resources = [
        "<basematerials id=\"1\"><base name=\"red\" displaycolor=\"#FF0000\"/></basematerials>\
         <m:colorgroup id=\"2\"><m:color color=\"#00FF00\"/></m:colorgroup>",
        &square(3, "name=\"a\" pid=\"1\" pindex=\"0\"", ["", ""]),
        &square(4, "name=\"b\" pid=\"2\" pindex=\"0\"", ["", ""]),
    ];
    let items = "<item objectid=\"3\"/><item objectid=\"4\"/>";
    let soup = good(ThreeMf, file(&model("", &resources.concat(), items)));
    let back = good(ThreeMf, written(ThreeMf, &soup));
    for all in [&soup.attributes, &back.attributes] {
        let material = |face: usize| &all.tags[all.faces.tags[face] as usize].material;
        assert_eq!([0, 1, 2, 3].map(material), ["red", "red", "", ""]);
        assert_eq!(column(&all.vertices, "red")[4..], [0.0; 4]);
        assert_eq!(column(&all.vertices, "green")[4..], [255.0; 4]);
    }
}

#[test]
fn copies_of_a_part_have_names_of_their_own() {
    let resources = [
        square(1, "name=\"part\"", ["", ""]),
        square(2, "name=\"part_2\"", ["", ""]),
    ];
    let items = "<item objectid=\"2\"/>".to_owned() + &"<item objectid=\"1\"/>".repeat(2000);
    let soup = good(ThreeMf, file(&model("", &resources.concat(), &items)));
    let tags = soup.attributes.tags.iter();
    let mut names: Vec<&str> = tags.map(|tag| tag.object.as_str()).collect();
    assert_eq!(names[..4], ["part_2", "part", "part_3", "part_4"]);
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 2001);
}
