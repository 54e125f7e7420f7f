//! Files as programs for scans write them, rebuilt small from what is reported of them.

use std::fs;

use serde_json::json;

use super::super::Format::{Glb, Ply};
use super::super::{
    copy_companions, load, materials, open_joined, save_mesh, save_mesh_keeping_files, with_output,
};
use super::gltf::{one_node, square};
use super::good;
use crate::mesh::{ImageSource, Material, OwnMaterial, Weld};

const SQUARE: &str =
    "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nvt 0 0 0\r\nvt 1 0 0\r\nvt 1 1 0\r\n";

fn image_file(material: &Material) -> Option<&std::path::Path> {
    match &material.image {
        Some(ImageSource::File(path)) => Some(path),
        _ => None,
    }
}

// Names with blanks, separators of Windows, the path of a disk, options and three texture coordinates
// (MeshLab issues 66 and 512, wow.export issue 430, RealityCapture).
#[test]
fn materials_with_paths_of_windows_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("in/my maps")).expect("made");
    fs::create_dir(at("out")).expect("made");
    let library = "newmtl material_0\r\nKd 1 1 1\r\nmap_Kd my maps\\scan 0.png\r\n\r\n\
        newmtl material 1\r\nmap_Kd -blendu on -s 1 1 1 C:\\Users\\me\\scan_1.png\r\n";
    fs::write(at("in/my scan.mtl"), library).expect("written");
    for name in ["in/my maps/scan 0.png", "in/scan_1.png"] {
        fs::write(at(name), name).expect("written");
    }
    let text = format!(
        "# Capturing Reality\r\nmtllib .\\my scan.mtl\r\nusemtl material_0\r\no first\r\n{SQUARE}\
         f 1/1 2/2 3/3\r\nusemtl material 1\r\nf -4/-3 -2/-2 -1/-1\r\n"
    );
    fs::write(at("in/scan.obj"), &text).expect("written");
    let soup = load(&at("in/scan.obj")).expect("read");
    assert!(soup.notes.is_empty(), "{:?}", soup.notes);
    let all = &soup.attributes;
    assert_eq!(all.texture.len(), 3);
    let names: Vec<&str> = all.tags.iter().map(|tag| tag.material.as_str()).collect();
    assert_eq!(names, ["material_0", "material 1"]);
    let found = materials(all);
    let files: Vec<_> = found.iter().filter_map(image_file).collect();
    assert_eq!(files.len(), 2);
    assert!(files.iter().all(|path| path.is_file()), "{files:?}");
    let messages = copy_companions(&at("out/scan.obj"), all).messages;
    assert!(
        messages.len() == 1 && messages[0].contains("'my scan.mtl'"),
        "{messages:?}"
    );
    fs::write(at("out/scan.obj"), &text).expect("written");
    let copied = materials(&load(&at("out/scan.obj")).expect("read").attributes);
    let files: Vec<_> = copied.iter().filter_map(image_file).collect();
    assert!(
        files.len() == 2 && files.iter().all(|path| path.is_file()),
        "{files:?}"
    );
}

// A library with one material that no face names (PyTorch3D issue 1068, objects of the YCB set).
#[test]
fn the_only_material_is_that_of_all_faces() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.mtl"), "newmtl skin\nmap_Kd a.png\n").expect("written");
    fs::write(
        at("a.obj"),
        format!("mtllib a.mtl\n{SQUARE}f 1/1 2/2 3/3\n"),
    )
    .expect("written");
    let soup = load(&at("a.obj")).expect("read");
    let found = materials(&soup.attributes);
    let nameless = found.iter().find(|material| material.name.is_empty());
    assert_eq!(
        image_file(nameless.expect("a material")),
        Some(&*at("a.png"))
    );
    assert_eq!(soup.attributes.material_of(0), "");
}

// Faces with the number of their image (MeshLab, PyMeshLab issue 244).
#[test]
fn faces_of_ply_files_have_one_of_several_images() {
    let text = "ply\nformat ascii 1.0\ncomment VCGLIB generated\ncomment TextureFile a.png\n\
        comment TextureFile b c.png\nelement vertex 4\nproperty double x\nproperty double y\n\
        property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
        property uchar alpha\nelement face 2\nproperty list uchar int vertex_indices\n\
        property list uchar float texcoord\nproperty int texnumber\nend_header\n\
        0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n1 1 0 0 0 255 255\n0 1 0 9 9 9 128\n\
        3 0 1 2 6 0 0 1 0 1 1 1\n3 0 2 3 6 0 0 1 1 0 1 0\n";
    let mut soup = good(Ply, text);
    soup.attributes.folder = Some("in".into());
    let all = &soup.attributes;
    assert_eq!([0, 1].map(|face| all.material_of(face)), ["b c.png", ""]);
    let found = materials(all);
    let images: Vec<_> = found
        .iter()
        .map(|m| (m.name.as_str(), image_file(m)))
        .collect();
    let file = |name: &str| std::path::Path::new("in").join(name);
    assert_eq!(
        images,
        [
            ("", Some(&*file("a.png"))),
            ("b c.png", Some(&*file("b c.png")))
        ]
    );
}

// The images of a PLY file with several are materials of glTF and 3MF.
#[test]
fn each_image_of_a_ply_file_is_written_into_gltf_and_3mf() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let text = "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b c.png\n\
        element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
        property list uchar int vertex_indices\nproperty list uchar float texcoord\n\
        property int texnumber\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
        3 0 1 2 6 0 0 1 0 1 1 1\n3 0 2 3 6 0 0 1 1 0 1 0\n";
    fs::write(at("in.ply"), text).expect("written");
    let bytes = |name: &str| [&b"\x89PNG "[..], name.as_bytes()].concat();
    for name in ["a.png", "b c.png"] {
        fs::write(at(name), bytes(name)).expect("written");
    }
    let mesh = super::super::open(&at("in.ply")).expect("opened").mesh;
    for to in ["out.glb", "out.3mf"] {
        let said = save_mesh(&at(to), &mesh).expect("written");
        let name = if to == "out.glb" { "glTF" } else { "3MF" };
        assert_eq!(
            said,
            [format!("{name} cannot store names of texture files")]
        );
        let soup = load(&at(to)).expect("read");
        let all = &soup.attributes;
        let found = materials(all);
        // faces have the image that their number chose
        let image = |face: usize| {
            let name = all.material_of(face);
            let material = found.iter().find(|material| material.name == name);
            let image = material.and_then(|material| material.image.clone());
            let corner = soup.positions[soup.corners[3 * face + 1] as usize];
            (corner.x, corner.y, image.expect("an image"))
        };
        let mut images = [image(0), image(1)];
        images.sort_by(|a, b| a.1.total_cmp(&b.1));
        let wanted = ["b c.png", "a.png"].map(|name| ImageSource::Bytes(bytes(name).into()));
        assert_eq!(
            [&images[0].2, &images[1].2],
            [&wanted[0], &wanted[1]],
            "{to}"
        );
        let again = save_mesh(&at(to), &super::super::open(&at(to)).expect("opened").mesh);
        assert_eq!(again.expect("written"), [""; 0]);
    }
}

// Transforms of textures, and colours of an older extension (Sketchfab).
#[test]
fn images_of_other_materials_of_gltf_are_found() {
    let (mut document, mesh) = square();
    let image = document.view(b"an image");
    let mut json = one_node(&json!([mesh]));
    let transform = json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "scale": [0.5, 2.0],
        "rotation": std::f64::consts::FRAC_PI_2 } });
    json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"] = json!([
        { "name": "old", "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [1.0, 0.0, 0.0, 1.0],
            "diffuseTexture": { "index": 0, "extensions": transform } } } },
        { "name": "plain", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0,
            "extensions": { "KHR_texture_transform": {} } } } },
    ]);
    let soup = good(Glb, document.glb(json));
    let all = materials(&soup.attributes);
    assert!(
        all.iter()
            .all(|m| m.image == Some(ImageSource::Bytes(b"an image".to_vec().into())))
    );
    assert_eq!(all[0].color, Some([1.0, 0.0, 0.0]));
    // scaled to (0.5, 2), turned to (2, -0.5), moved
    let [u, v] = all[0].place([1.0, 1.0]);
    assert!(
        (u - 2.5).abs() < 1e-12 && (v + 0.25).abs() < 1e-12,
        "{u} {v}"
    );
    assert_eq!(all[1].transform, None);
}

// Blender writes sparse accessors for shape keys, which are not kept (glTF-Blender-IO issue 1346).
#[test]
fn sparse_accessors_of_shape_keys_are_no_obstacle() {
    let (document, mesh) = square();
    let mut json = document.json(one_node(&json!([mesh])), None);
    let accessors = json["accessors"].as_array_mut().expect("an array");
    accessors.push(
        json!({ "componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
        "count": 1, "indices": { "bufferView": 0, "componentType": 5121 },
        "values": { "bufferView": 0 } } }),
    );
    let primitive = &mut json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{ "POSITION": 2 }]);
    let bytes = super::gltf::glb(&json, &document.bytes());
    let soup = good(Glb, bytes);
    assert_eq!(soup.notes, ["not kept: morph targets"]);
}

// Two files with materials of the same name are one mesh with both, also as OBJ.
#[test]
fn materials_of_joined_files_stay_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    for name in ["a", "b"] {
        let (mut document, mut mesh) = square();
        let image = document.view(format!("\u{89}image {name}").as_bytes());
        let texture = document.floats("VEC2", &[[0.0, 0.25_f32]; 4]);
        mesh["primitives"][0]["attributes"]["TEXCOORD_0"] = texture.into();
        mesh["primitives"][0]["material"] = 0.into();
        let mut json = one_node(&json!([mesh]));
        if name == "b" {
            json["nodes"][0]["translation"] = json!([5, 0, 0]);
        }
        json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
        json["samplers"] = json!([{ "wrapS": 33071 }]);
        json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        json["materials"] = json!([{ "name": "skin", "pbrMetallicRoughness": {
            "baseColorFactor": [1.0, 0.0, 0.0, 1.0], "baseColorTexture": { "index": 0 } } }]);
        fs::write(at(name).with_extension("glb"), document.glb(json)).expect("written");
    }
    let paths = [at("a.glb"), at("b.glb")];
    let mesh = open_joined(&paths, Weld::Auto).expect("opened").mesh;
    let names: Vec<&str> = [0, 2]
        .map(|face| mesh.attributes.material_of(face))
        .to_vec();
    assert_eq!(names, ["skin", "skin_2"]);
    assert!(mesh.attributes.texture_is_down);
    let image = |all: &[Material], name: &str| {
        let material = all
            .iter()
            .find(|material| material.name == name)
            .expect("a material");
        assert_eq!(material.color, Some([1.0, 0.0, 0.0]));
        let image = material.image.as_ref().expect("an image");
        String::from_utf8_lossy(&image.bytes().expect("read")).into_owned()
    };
    let both = materials(&mesh.attributes);
    assert_eq!(
        [image(&both, "skin"), image(&both, "skin_2")],
        ["\u{89}image a", "\u{89}image b"]
    );
    let samplers = &mesh
        .attributes
        .gltf_materials
        .as_ref()
        .expect("materials")
        .json["textures"];
    assert_eq!(
        *samplers,
        json!([{ "source": 0, "sampler": 0 }, { "source": 1, "sampler": 1 }])
    );
    // OBJ gets a library with the images beside it
    let said = save_mesh(&at("out.obj"), &mesh).expect("written");
    let beside = "written beside it: out_meniscus.mtl, out_skin.png, out_skin_2.png";
    assert_eq!(said, [beside]);
    let soup = load(&at("out.obj")).expect("read");
    let of_obj = materials(&soup.attributes);
    assert_eq!(
        [image(&of_obj, "skin"), image(&of_obj, "skin_2")],
        ["\u{89}image a", "\u{89}image b"]
    );
    let v = soup.attributes.texture[1].numbers.get(0);
    assert_eq!(v, 0.75);
    with_output(&mesh, |output| assert_eq!(output.triangles.len(), 4));
}

#[test]
fn images_of_libraries_and_of_ply_files_are_written_into_gltf_and_3mf() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let png = b"\x89PNG and so on";
    fs::write(at("a.png"), png).expect("written");
    fs::write(
        at("a.mtl"),
        "newmtl skin\nKd 1 0.5 0\nmap_Kd a.png\nnewmtl unused\n",
    )
    .expect("written");
    let faces = "usemtl skin\nf 1/1 2/2 3/3\n";
    fs::write(at("a.obj"), format!("mtllib a.mtl\n{SQUARE}{faces}")).expect("written");
    let ply = "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
        property list uchar float texcoord\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2 6 0 0 1 0 1 1\n";
    fs::write(at("a.ply"), ply).expect("written");
    for (from, name) in [("a.obj", "skin"), ("a.ply", "")] {
        let mesh = super::super::open(&at(from)).expect("opened").mesh;
        for to in ["out.glb", "out.3mf"] {
            save_mesh(&at(to), &mesh).expect("written");
            let soup = load(&at(to)).expect("read");
            let found = materials(&soup.attributes);
            assert_eq!(found.len(), 1, "{from} {to}");
            assert_eq!(
                found[0].image,
                Some(ImageSource::Bytes(png.to_vec().into()))
            );
            assert_eq!(soup.attributes.material_of(0), found[0].name);
            if to == "out.glb" && name == "skin" {
                let color = found[0].color.expect("a colour");
                assert!((color[1] - 0.5).abs() < 1e-6 && found[0].name == name);
            }
            let rows = &soup.attributes.faces.texture;
            assert!(rows.iter().all(|row| *row < 3), "{from} {to}");
        }
    }
}

// Blender writes several materials with one image.
#[test]
fn equal_images_are_written_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let png = [&b"\x89PNG"[..], &[7; 4000]].concat();
    for name in ["a.png", "b.png"] {
        fs::write(at(name), &png).expect("written");
    }
    let library = "newmtl first\nmap_Kd a.png\nnewmtl second\nKd 1 0 0\nmap_Kd b.png\n";
    fs::write(at("a.mtl"), library).expect("written");
    let faces = "usemtl first\nf 1/1 2/2 3/3\nusemtl second\nf 1/1 3/3 4/2\n";
    fs::write(at("a.obj"), format!("mtllib a.mtl\n{SQUARE}{faces}")).expect("written");
    let mut mesh = super::super::open(&at("a.obj")).expect("opened").mesh;
    mesh.attributes.own_materials.push(OwnMaterial {
        name: "patches".into(),
        like: "second".into(),
        png: png.clone().into(),
    });
    for to in ["out.glb", "out.3mf", "again.glb"] {
        save_mesh(&at(to), &mesh).expect("written");
        let bytes = fs::read(at(to)).expect("there");
        let parts = bytes.windows(png.len());
        let count = parts.filter(|part| **part == png[..]).count();
        assert_eq!(count, 1, "{to}");
        mesh = super::super::open(&at(to)).expect("opened").mesh;
        let all = &mesh.attributes;
        assert_ne!(all.material_of(0), all.material_of(1), "{to}");
        let found = materials(all);
        for face in [0, 1] {
            let name = all.material_of(face);
            let material = found.iter().find(|material| material.name == name);
            let image = material.and_then(|material| material.image.clone());
            assert_eq!(image, Some(ImageSource::Bytes(png.clone().into())), "{to}");
        }
    }
}

// MeshLab and others take the images of a PLY file from comments, and the number of an image from each face.
#[test]
fn images_of_obj_files_are_named_in_ply() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("in/maps")).expect("made");
    fs::create_dir(at("out")).expect("made");
    let library = "newmtl skin\nmap_Kd maps/my skin.png\nnewmtl same\nmap_Kd maps/my skin.png\n\
        newmtl plain\nKd 1 0 0\nnewmtl other\nmap_Kd b.png\n";
    fs::write(at("in/a.mtl"), library).expect("written");
    for name in ["in/maps/my skin.png", "in/b.png"] {
        fs::write(at(name), name).expect("written");
    }
    let line = "comment TextureFile maps/my skin.png\n";
    for (second, images, numbers) in [
        ("usemtl same\nf 1/1 3/3 4/1\n", 1, None),
        ("usemtl plain\nf 1 3 4\n", 1, Some([0.0, -1.0])),
        ("usemtl other\nf 1 3 4\n", 1, Some([0.0, -1.0])),
        ("usemtl other\nf 1/1 3/3 4/1\n", 2, Some([0.0, 1.0])),
    ] {
        fs::remove_dir_all(at("out")).expect("there");
        fs::create_dir(at("out")).expect("made");
        let faces = format!("usemtl skin\nf 1/1 2/2 3/3\n{second}");
        fs::write(at("in/a.obj"), format!("mtllib a.mtl\n{SQUARE}{faces}")).expect("written");
        let mesh = super::super::open(&at("in/a.obj")).expect("opened").mesh;
        save_mesh(&at("out/a.ply"), &mesh).expect("written");
        let bytes = fs::read(at("out/a.ply")).expect("there");
        let header = String::from_utf8_lossy(&bytes).into_owned();
        assert_eq!(header.matches("TextureFile").count(), images, "{second}");
        assert!(header.contains(line), "{header}");
        copy_companions(&at("out/a.ply"), &mesh.attributes);
        assert!(at("out/maps/my skin.png").is_file());
        assert_eq!(at("out/b.png").exists(), images == 2);
        // what was written is read and written as the same bytes
        let again = super::super::open(&at("out/a.ply")).expect("opened").mesh;
        let found = materials(&again.attributes);
        assert_eq!(image_file(&found[0]), Some(&*at("out/maps/my skin.png")));
        let mut columns = again.attributes.faces.columns.iter();
        let column = columns.find(|column| column.name == "texnumber");
        let found = column.map(|column| [0, 1].map(|face| column.numbers.get(face)));
        assert_eq!(found, numbers, "{second}");
        save_mesh(&at("out/b.ply"), &again).expect("written");
        assert!(
            fs::read(at("out/b.ply")).expect("there") == bytes,
            "{second}"
        );
    }
}

// Material libraries and images in folders of their own.
#[test]
fn files_that_stay_are_named_from_another_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    for name in ["in/materials", "in/my maps", "in/my out", "other"] {
        fs::create_dir_all(at(name)).expect("made");
    }
    let library = "newmtl skin\nmap_Kd ../my maps/skin.png\n";
    fs::write(at("in/materials/a.mtl"), library).expect("written");
    fs::write(at("in/my maps/skin.png"), "an image").expect("written");
    let text = format!("mtllib materials/a.mtl missing.mtl\n{SQUARE}usemtl skin\nf 1/1 2/2 3/3\n");
    fs::write(at("in/a.obj"), text).expect("written");
    let mesh = super::super::open(&at("in/a.obj")).expect("opened").mesh;
    for (to, line) in [
        ("in/my out/a.obj", "mtllib ../materials/a.mtl\n"),
        ("other/a.obj", "mtllib ../in/materials/a.mtl\n"),
        ("in/b.obj", "mtllib materials/a.mtl missing.mtl\n"),
        (
            "in/my out/a.ply",
            "TextureFile ../materials/../my maps/skin.png\n",
        ),
    ] {
        save_mesh_keeping_files(&at(to), &mesh).expect("written");
        let bytes = fs::read(at(to)).expect("there");
        let written = String::from_utf8_lossy(&bytes);
        assert!(written.contains(line), "{to}: {written}");
        let again = super::super::open(&at(to)).expect("opened").mesh;
        let found = materials(&again.attributes);
        let image = found.iter().find_map(image_file).expect("an image");
        assert_eq!(fs::read(image).expect("there"), b"an image", "{to}");
        // and back
        save_mesh_keeping_files(&at("in/back.ply"), &again).expect("written");
        let back = load(&at("in/back.ply")).expect("read");
        let found = materials(&back.attributes);
        let image = image_file(&found[0]).expect("an image");
        assert_eq!(fs::read(image).expect("there"), b"an image", "{to}");
    }
    // a copy has the same folders
    fs::create_dir(at("copy")).expect("made");
    let companions = copy_companions(&at("copy/a.obj"), &mesh.attributes);
    assert!(companions.outside.is_empty(), "{companions:?}");
    assert!(at("copy/my maps/skin.png").is_file());
}

// A mesh without a folder in its path.
#[test]
fn the_current_folder_is_named_in_messages() {
    let folder = tempfile::tempdir().expect("a folder");
    // a file that is in the current folder of the tests
    let text = "ply\nformat ascii 1.0\ncomment TextureFile Cargo.toml\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
    let mut soup = good(Ply, text);
    soup.attributes.folder = Some("".into());
    let messages = copy_companions(&folder.path().join("a.ply"), &soup.attributes).messages;
    assert_eq!(messages, ["copied from the current folder: 'Cargo.toml'"]);
}
