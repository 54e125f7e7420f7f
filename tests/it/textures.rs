//! Texture images of patches, from the command line.

use crate::common::desk::Desk;

/// The names of new files, and messages of a run.
fn new_files(desk: &Desk, words: &[&str]) -> (Vec<String>, String) {
    let before = desk.names();
    let run = desk.run(words).ends(0);
    let after = desk.names().into_iter();
    let new = after.filter(|name| !before.contains(name));
    (new.collect(), run.stderr)
}

#[test]
fn images_of_patches_are_written_with_the_mesh() {
    let desk = Desk::with_sample("egg");
    let given = ["in.obj", "in_egg.png", "in_meniscus.mtl"];
    assert_eq!(desk.names(), given);
    let bytes = given.map(|name| desk.bytes(name));

    let (new, said) = new_files(&desk, &["fill", "in.obj", "-o", "a.obj"]);
    assert_eq!(new, ["a.obj", "a_meniscus.mtl", "a_patches.png"]);
    assert!(said.contains("written beside it: a_meniscus.mtl, a_patches.png"));
    let text = desk.text("a.obj");
    assert!(text.starts_with("mtllib in_meniscus.mtl\nmtllib a_meniscus.mtl\n"));
    assert!(text.contains("\nusemtl patches\n"));
    // the patches are the last faces, and all have texture coordinates
    let faces = text.lines().filter(|line| line.starts_with("f "));
    assert!(faces.clone().count() > 300);
    assert!(faces.into_iter().all(|line| line.contains('/')));

    // glTF contains the image, and a second fill finds the mesh closed
    let (new, _) = new_files(&desk, &["fill", "a.obj", "-o", "b.glb", "--loops", "all"]);
    assert_eq!(new, ["b.glb"]);
    let (new, said) = new_files(&desk, &["fill", "in.obj", "-o", "c.glb"]);
    assert_eq!(new, ["c.glb"]);
    assert!(!said.contains("cannot store"), "{said}");
    let png = desk.bytes("a_patches.png");
    let glb = desk.bytes("c.glb");
    assert!(glb.windows(png.len()).any(|part| part == png));

    // PLY lists the images, and a second fill finds the mesh closed
    let (new, said) = new_files(&desk, &["fill", "in.obj", "-o", "d.ply"]);
    assert_eq!(new, ["d.ply", "d_patches.png"]);
    assert!(said.contains("written beside it: d_patches.png"), "{said}");
    assert!(!said.contains("texture images"), "{said}");
    assert!(desk.bytes("d_patches.png") == png);
    let ply = desk.bytes("d.ply");
    let header = String::from_utf8_lossy(&ply);
    let listed = "comment TextureFile in_egg.png\ncomment TextureFile d_patches.png\n";
    assert!(header.contains(listed) && header.contains("\nproperty int texnumber\n"));
    let (new, _) = new_files(&desk, &["fill", "d.ply", "-o", "e.ply", "--loops", "all"]);
    assert_eq!(new, ["e.ply"]);
    assert!(desk.bytes("e.ply") == ply);

    let (new, said) = new_files(&desk, &["fill", "in.obj", "-o", "f.off"]);
    assert_eq!(new, ["f.off"]);
    assert!(
        said.contains("OFF cannot store texture images of patches"),
        "{said}"
    );

    for (choice, count) in [("extend", 1), ("none", 1), ("own", 3)] {
        let output = format!("{choice}.obj");
        let words = ["fill", "in.obj", "-o", &output, "--patch-texture", choice];
        let (new, _) = new_files(&desk, &words);
        assert_eq!(new.len(), count, "{new:?}");
    }
    assert_eq!(given.map(|name| desk.bytes(name)), bytes);
}

/// A result of the same name in another folder replaces none of the files that are copied there.
#[test]
fn a_second_fill_keeps_the_images_of_the_first() {
    let desk = Desk::with_sample("egg");
    let own = ["--patch-texture", "own"];
    let first = ["fill", "in.obj", "-o", "a.obj", "--loops", "1"];
    let (new, _) = new_files(&desk, &[&first[..], &own].concat());
    assert_eq!(new, ["a.obj", "a_meniscus.mtl", "a_patches.png"]);
    std::fs::create_dir(desk.path("to")).expect("a folder");
    desk.runs(&[&["fill", "a.obj", "-o", "to/a.obj"][..], &own].concat());
    for name in [
        "in_meniscus.mtl",
        "in_egg.png",
        "a_meniscus.mtl",
        "a_patches.png",
    ] {
        assert_eq!(
            desk.bytes(&format!("to/{name}")),
            desk.bytes(name),
            "{name}"
        );
    }
    let library = "# written by Meniscus\nnewmtl patches_2\nKd 1 1 1\nmap_Kd a_patches_2.png\n";
    assert_eq!(desk.text("to/a_meniscus_2.mtl"), library);
    assert!(desk.path("to/a_patches_2.png").is_file());
    let listed = "mtllib in_meniscus.mtl\nmtllib a_meniscus.mtl\nmtllib a_meniscus_2.mtl\n";
    assert!(desk.text("to/a.obj").starts_with(listed));
}

#[test]
fn a_missing_image_is_said() {
    let desk = Desk::with_sample("egg");
    std::fs::remove_file(desk.path("in_egg.png")).expect("there");
    let (new, said) = new_files(&desk, &["fill", "in.obj", "-o", "a.obj"]);
    assert_eq!(new, ["a.obj"]);
    assert_eq!(
        said.matches("has no texture: the image").count(),
        2,
        "{said}"
    );
}
