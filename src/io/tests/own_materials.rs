//! Materials whose images are written with the mesh.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::io::{self, Format, OutputMesh};
use crate::mesh::{
    Attributes, Column, DVec3, FaceTag, ImageSource, NO_VALUE, Numbers, OwnMaterial, Soup,
};

const POINTS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

/// Two triangles with a material of the file and an own one.
fn attributes(folder: Option<&Path>) -> Attributes {
    let tag = |name: &str| FaceTag {
        material: name.into(),
        ..FaceTag::default()
    };
    let own = |name: &str, png: &Arc<Vec<u8>>| OwnMaterial {
        name: name.into(),
        like: "skin".into(),
        png: Arc::clone(png),
    };
    let (first, second) = (
        Arc::new(b"first image".to_vec()),
        Arc::new(b"second".to_vec()),
    );
    let column = |name| Column::decimals(name, vec![0.25, 0.5, 0.75, 0.125]);
    let mut all = Attributes {
        tags: [tag("skin"), tag("patches")].to_vec(),
        texture: Arc::new(vec![column("u"), column("v")]),
        own_materials: vec![
            own("patches", &first),
            own("again", &first),
            own("other", &second),
        ],
        folder: folder.map(Path::to_owned),
        ..Attributes::default()
    };
    all.faces.tags = vec![0, 1];
    all.faces.texture = TRIANGLES.as_flattened().to_vec();
    all
}

fn output(attributes: &Attributes) -> OutputMesh<'_> {
    OutputMesh {
        positions: &POINTS,
        triangles: &TRIANGLES,
        attributes,
    }
}

/// The bytes of the image of a material of a mesh that was read.
fn image_of(soup: &Soup, name: &str) -> Vec<u8> {
    let all = io::materials(&soup.attributes);
    let material = all.iter().find(|m| m.name == name).expect("a material");
    let image = material.image.as_ref().expect("an image");
    image.bytes().expect("read").to_vec()
}

#[test]
fn obj_files_get_a_library_beside_the_given_one() {
    let desk = tempfile::tempdir().expect("a folder");
    let given = "newmtl skin\nKd 0.5 0.6 0.7\nNs 9\nmap_Kd skin.png\nmap_Bump -bm 2 bump.png\n\
                 newmtl rest\nKd 1 0 0\n";
    let at = |name: &str| desk.path().join(name);
    fs::write(at("a_meniscus.mtl"), given).expect("written");
    fs::write(at("skin.png"), "skin").expect("written");
    let mut all = attributes(Some(desk.path()));
    // a name that the new library would have
    all.material_libraries = vec!["a_meniscus.mtl".into()];
    io::save(&at("a.obj"), &output(&all)).expect("written");
    assert_eq!(
        fs::read_to_string(at("a_meniscus.mtl")).expect("there"),
        given
    );
    let library = fs::read_to_string(at("a_meniscus_2.mtl")).expect("written");
    let settings = "Kd 0.5 0.6 0.7\nNs 9\n";
    let expected = format!(
        "# written by Meniscus\nnewmtl patches\n{settings}map_Kd a_patches.png\n\
         newmtl again\n{settings}map_Kd a_patches.png\nnewmtl other\n{settings}map_Kd a_other.png\n"
    );
    assert_eq!(library, expected);
    let soup = io::load(&at("a.obj")).expect("read");
    assert!(soup.notes.is_empty(), "{:?}", soup.notes);
    assert_eq!(image_of(&soup, "patches"), b"first image");
    assert_eq!(image_of(&soup, "other"), b"second");
    assert_eq!(image_of(&soup, "skin"), b"skin");
    assert_eq!(soup.attributes.tags, all.tags);
    // what is written again has the same names
    io::save(&at("a.obj"), &output(&all)).expect("written");
    assert_eq!(fs::read_dir(desk.path()).expect("a folder").count(), 6);
}

#[test]
fn gltf_files_contain_the_images() {
    let all = attributes(None);
    for format in [Format::Glb, Format::Gltf] {
        let mut bytes = Vec::new();
        io::write(format, &output(&all), &mut bytes).expect("written");
        let soup = io::read(format, &bytes, Path::new("mesh")).expect("read");
        let materials = io::materials(&soup.attributes);
        for (name, image) in [
            ("patches", "first image"),
            ("again", "first image"),
            ("other", "second"),
        ] {
            let material = materials
                .iter()
                .find(|m| m.name == name)
                .expect("a material");
            let expected = ImageSource::Bytes(Vec::from(image).into());
            assert_eq!(material.image.as_ref(), Some(&expected));
        }
        // a material of the file keeps its settings for an own one
        let mut again = soup.attributes.clone();
        again.own_materials = vec![OwnMaterial {
            name: "new".into(),
            like: "other".into(),
            png: Arc::new(b"new image".to_vec()),
        }];
        bytes.clear();
        let mesh = OutputMesh {
            positions: &soup.positions,
            ..output(&again)
        };
        io::write(format, &mesh, &mut bytes).expect("written");
        let third = io::read(format, &bytes, Path::new("mesh")).expect("read");
        assert_eq!(image_of(&third, "new"), b"new image");
        assert_eq!(image_of(&third, "patches"), b"first image");
        let json = &third
            .attributes
            .gltf_materials
            .as_ref()
            .expect("materials")
            .json;
        let surface = json["materials"].as_array().and_then(|all| all.last());
        let surface = &surface.expect("the new one")["pbrMetallicRoughness"];
        assert_eq!(surface["metallicFactor"], 0);
    }
}

/// The numbers of the images of faces in a PLY file, and the materials of the faces of the mesh in it.
fn numbers_of(soup: &Soup) -> (Vec<f64>, Vec<&str>) {
    let all = &soup.attributes;
    let column = all.faces.columns.iter().find(|c| c.name == "texnumber");
    let numbers = &column.expect("numbers").numbers;
    let faces = 0..soup.face_count();
    let numbers = faces.clone().map(|face| numbers.get(face));
    (
        numbers.collect(),
        faces.map(|face| all.material_of(face)).collect(),
    )
}

#[test]
fn ply_files_name_the_images_beside_them() {
    let desk = tempfile::tempdir().expect("a folder");
    let at = |name: &str| desk.path().join(name);
    let mut all = attributes(Some(desk.path()));
    all.tags[0] = FaceTag::default();
    // a name that the new image would have
    let given = "comment TextureFile a_patches.png";
    all.comments = vec![given.into()];
    fs::write(at("a_patches.png"), "given").expect("written");
    assert_eq!(io::losses(Format::Ply, &output(&all)), [""; 0]);
    io::save(&at("a.ply"), &output(&all)).expect("written");
    let soup = io::load(&at("a.ply")).expect("read");
    let new = "a_patches_2.png";
    let comments = &soup.attributes.comments;
    assert_eq!(
        comments[1..],
        [given, "comment TextureFile a_patches_2.png"]
    );
    assert_eq!(numbers_of(&soup), (vec![0.0, 1.0], vec!["", new]));
    assert_eq!(image_of(&soup, ""), b"given");
    assert_eq!(image_of(&soup, new), b"first image");
    assert!(!soup.attributes.faces.texture.contains(&NO_VALUE));
    // what was read is written as the same bytes, and without another image
    let mesh = io::from_soup(&soup, Path::new("a")).expect("a mesh").mesh;
    io::save_mesh(&at("b.ply"), &mesh).expect("written");
    let bytes = |name: &str| fs::read(at(name)).expect("there");
    assert!(bytes("a.ply") == bytes("b.ply"));
    assert_eq!(fs::read_dir(desk.path()).expect("a folder").count(), 4);
    // a declared number stays where an image is given, and a face without coordinates has no image
    all.faces.columns = vec![Column {
        name: "texnumber".into(),
        numbers: Numbers::U8(vec![7, 0]),
        is_typed: true,
    }];
    io::save(&at("c.ply"), &output(&all)).expect("written");
    let soup = io::load(&at("c.ply")).expect("read");
    assert_eq!(numbers_of(&soup).0, [7.0, 1.0]);
    all.faces.columns.clear();
    all.comments.clear();
    all.faces.texture[..3].fill(NO_VALUE);
    io::save(&at("d.ply"), &output(&all)).expect("written");
    let soup = io::load(&at("d.ply")).expect("read");
    assert_eq!(numbers_of(&soup), (vec![-1.0, 0.0], vec!["no image", ""]));
    assert_eq!(image_of(&soup, ""), b"first image");
}

/// Texture coordinates of vertices, as many PLY files have them.
#[test]
fn images_are_written_for_texture_coordinates_of_vertices() {
    let desk = tempfile::tempdir().expect("a folder");
    let at = |name: &str| desk.path().join(name);
    let mut all = attributes(Some(desk.path()));
    all.tags[0] = FaceTag::default();
    all.comments = vec!["comment TextureFile skin.png".into()];
    all.faces.texture.clear();
    all.texture = Arc::default();
    let numbers = [0.25, 0.5, 0.75, 0.125, 0.375, 0.625];
    all.vertices = ["s", "t"]
        .map(|name| Column::decimals(name, numbers.to_vec()))
        .to_vec();
    let points = [0, 1, 2, 0, 2, 3].map(|v: usize| POINTS[v]);
    let mesh = OutputMesh {
        positions: &points,
        triangles: &[[0, 1, 2], [3, 4, 5]],
        attributes: &all,
    };
    let column = |soup: &Soup| -> Vec<f64> {
        let column = soup.attributes.vertices.iter().find(|c| c.name == "s");
        let numbers = &column.expect("a column").numbers;
        (0..numbers.len()).map(|row| numbers.get(row)).collect()
    };
    io::save(&at("a.ply"), &mesh).expect("written");
    let soup = io::load(&at("a.ply")).expect("read");
    let named = (vec![0.0, 1.0], vec!["", "a_patches.png"]);
    assert_eq!(numbers_of(&soup), named);
    assert_eq!(image_of(&soup, "a_patches.png"), b"first image");
    assert_eq!(column(&soup), numbers);
    // corners have them in OBJ
    let lost = io::losses(Format::Obj, &mesh);
    assert_eq!(lost, ["OBJ cannot store names of texture files"]);
    io::save(&at("a.obj"), &mesh).expect("written");
    let soup = io::load(&at("a.obj")).expect("read");
    assert_eq!(soup.attributes.faces.texture, [0, 1, 2, 3, 4, 5]);
    assert_eq!(soup.attributes.texture[1].numbers.get(4), 0.375);
    // OFF has no image for those of the second face
    io::save(&at("a.off"), &mesh).expect("written");
    let soup = io::load(&at("a.off")).expect("read");
    assert_eq!(column(&soup), [0.25, 0.5, 0.75, 0.0, 0.0, 0.0]);
}

#[test]
fn other_formats_say_that_they_leave_the_images_out() {
    let all = attributes(None);
    for format in [Format::Stl, Format::Off] {
        let losses = io::losses(format, &output(&all));
        assert!(
            losses
                .iter()
                .any(|l| l.contains("texture images of patches")),
            "{losses:?}"
        );
    }
    // without a folder for the images
    let mut bytes = Vec::new();
    io::write(Format::Ply, &output(&all), &mut bytes).expect("written");
    let soup = io::read(Format::Ply, &bytes, Path::new("mesh")).expect("read");
    let rows = &soup.attributes.faces.texture;
    assert!(rows[..3].iter().all(|&row| row != NO_VALUE));
    assert_eq!(rows[3..], [NO_VALUE; 3]);
}
