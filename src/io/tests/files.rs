//! Paths, permissions, full disks and old files.

use std::fs;
use std::path::Path;

use super::super::{
    Format, LoadError, LoadErrorKind, OutputMesh, SaveError, SaveErrorKind, atomic, check_target,
    load, open, same_file, save, save_mesh,
};
use crate::mesh::DVec3;

const POSITIONS: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

fn triangle() -> OutputMesh<'static> {
    OutputMesh {
        positions: &POSITIONS,
        triangles: &[[0, 1, 2]],
        ..OutputMesh::default()
    }
}

fn names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory)
        .expect("readable")
        .map(|e| e.expect("entry").file_name());
    let mut names: Vec<String> = entries.map(|n| n.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn formats_go_by_extension() {
    assert_eq!(Format::from_path("a/b.OBJ".as_ref()), Some(Format::Obj));
    assert_eq!(Format::from_path("x.y.Ply".as_ref()), Some(Format::Ply));
    assert_eq!(Format::from_path("obj".as_ref()), None);
    let directory = tempfile::tempdir().expect("temporary directory");
    for (name, words) in [("mesh.step", "'.step'"), ("mesh", "no file extension")] {
        let path = directory.path().join(name);
        fs::write(&path, "x").expect("written");
        for message in [
            load(&path).expect_err("unknown").to_string(),
            save(&path, &triangle()).expect_err("unknown").to_string(),
        ] {
            assert!(
                message.contains(words) && message.contains(".obj, .ply, .stl"),
                "{message}"
            );
        }
        assert_eq!(fs::read(&path).expect("there"), b"x");
    }
}

#[test]
fn saved_files_load_again() {
    let directory = tempfile::tempdir().expect("temporary directory");
    for format in Format::ALL {
        let path = directory
            .path()
            .join("mesh")
            .with_extension(format.extension());
        assert_eq!(check_target(&path).expect("free"), format);
        assert!(!path.exists());
        for _ in 0..2 {
            save(&path, &triangle()).expect("saved");
            assert_eq!(load(&path).expect("loaded").positions, POSITIONS);
        }
    }
    assert_eq!(
        names(directory.path()),
        [
            "mesh.3mf",
            "mesh.glb",
            "mesh.gltf",
            "mesh.obj",
            "mesh.off",
            "mesh.ply",
            "mesh.stl"
        ]
    );
}

#[test]
fn paths_that_are_no_files() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let inside = directory.path().join("dir.obj");
    fs::create_dir(&inside).expect("made");
    assert!(matches!(
        load(&inside),
        Err(LoadError {
            kind: LoadErrorKind::IsDirectory,
            ..
        })
    ));
    assert!(matches!(
        save(&inside, &triangle()),
        Err(SaveError {
            kind: SaveErrorKind::IsDirectory,
            ..
        })
    ));
    let missing = directory.path().join("none").join("mesh.obj");
    assert!(matches!(
        load(&missing),
        Err(LoadError {
            kind: LoadErrorKind::NotFound,
            ..
        })
    ));
    let error = save(&missing, &triangle()).expect_err("no directory");
    assert!(
        matches!(&error.kind, SaveErrorKind::DirectoryMissing(_)),
        "{error}"
    );
    let file = directory.path().join("file.obj");
    fs::write(&file, "").expect("written");
    let below = file.join("mesh.obj");
    assert!(matches!(
        load(&below),
        Err(LoadError {
            kind: LoadErrorKind::NotFound,
            ..
        })
    ));
    assert!(matches!(
        save(&below, &triangle()),
        Err(SaveError {
            kind: SaveErrorKind::DirectoryMissing(_),
            ..
        })
    ));
}

#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("old.obj");
    fs::write(&path, "old").expect("written");
    let full = |out: &mut dyn std::io::Write| {
        out.write_all(&vec![b'v'; 1 << 20])?;
        Err(std::io::ErrorKind::StorageFull.into())
    };
    let error = atomic::replace(&path, full).expect_err("full");
    assert!(matches!(error.kind, SaveErrorKind::DiskFull), "{error}");
    let nan = [DVec3::NAN];
    let unsound = OutputMesh {
        positions: &nan,
        ..OutputMesh::default()
    };
    assert!(matches!(
        save(&path, &unsound),
        Err(SaveError {
            kind: SaveErrorKind::Mesh(_),
            ..
        })
    ));
    assert_eq!(fs::read(&path).expect("there"), b"old");
    assert_eq!(names(directory.path()), ["old.obj"]);
}

#[test]
fn read_only_files_stay() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("kept.ply");
    fs::write(&path, "old").expect("written");
    let mut permissions = fs::metadata(&path).expect("there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("set");
    assert!(matches!(
        save(&path, &triangle()),
        Err(SaveError {
            kind: SaveErrorKind::ReadOnly,
            ..
        })
    ));
    assert_eq!(fs::read(&path).expect("there"), b"old");
}

#[cfg(unix)]
#[test]
fn modes_links_and_devices() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let directory = tempfile::tempdir().expect("temporary directory");
    let real = directory.path().join("real.obj");
    let link = directory.path().join("link.obj");
    fs::write(&real, "old").expect("written");
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("set");
    symlink(&real, &link).expect("linked");
    save(&link, &triangle()).expect("saved");
    assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
    assert_eq!(load(&real).expect("loaded").positions, POSITIONS);
    assert_eq!(
        fs::metadata(&real).expect("there").permissions().mode() & 0o777,
        0o640
    );
    let device = directory.path().join("device.obj");
    symlink("/dev/full", &device).expect("linked");
    assert!(matches!(
        load(&device),
        Err(LoadError {
            kind: LoadErrorKind::NotAFile,
            ..
        })
    ));
    let error = save(&device, &triangle()).expect_err("full");
    assert!(error.to_string().contains("disk is full"), "{error}");
    assert_eq!(
        names(directory.path()),
        ["device.obj", "link.obj", "real.obj"]
    );
    assert!(same_file(&link, &real) && !same_file(&device, &real));
}

#[test]
fn the_same_file_by_other_names() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("a.obj");
    let other = directory.path().join("b.obj");
    let around = directory.path().join(".").join("a.obj");
    assert!(same_file(&path, &around) && !same_file(&path, &other));
    fs::write(&path, "x").expect("written");
    assert!(same_file(&path, &around) && !same_file(&path, &other));
    fs::hard_link(&path, &other).expect("linked");
    assert!(cfg!(not(unix)) || same_file(&path, &other));
}

#[test]
fn material_libraries_are_looked_up() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let path = directory.path().join("mesh.obj");
    let text = "mtllib one.mtl two.mtl\nmtllib my own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\n\
        f 1 2 3\nusemtl deep blue\nf 1 2 3\nusemtl green\nf 1 2 3\n";
    fs::write(&path, text).expect("written");
    fs::write(directory.path().join("one.mtl"), "newmtl red\nKd 1 0\n").expect("written");
    fs::write(
        directory.path().join("my own.mtl"),
        "# x\r\n\tnewmtl deep blue\r\n",
    )
    .expect("written");
    let soup = load(&path).expect("loaded");
    let notes = soup.notes.join("; ");
    assert!(
        notes.contains("the material library 'two.mtl' is not in the directory of the file"),
        "{notes}"
    );
    assert!(
        notes.contains("materials without a definition, names kept: 'green'"),
        "{notes}"
    );
    let line = "the material library 'one.mtl', line 2: the colour is not one or three finite";
    assert!(notes.contains(line), "{notes}");
    let libraries = &soup.attributes.material_libraries;
    assert_eq!(*libraries, ["one.mtl two.mtl", "my own.mtl"]);
}

#[test]
fn numbers_of_libraries_are_finite() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let at = |name: &str| directory.path().join(name);
    let text = "mtllib \"my own.mtl\"\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    fs::write(at("mesh.obj"), text).expect("written");
    let library = "newmtl a\nKd nan 1 1\nmap_Kd\nKd 0,8 0,8 0,8\n";
    fs::write(at("my own.mtl"), library).expect("written");
    let opened = open(&at("mesh.obj")).expect("opened");
    let place = "the material library 'my own.mtl', line";
    let notes = &opened.report.notes;
    assert!(
        notes.len() == 2
            && notes[0].starts_with(&format!("{place} 2 (and 1 more): the colour"))
            && notes[1].starts_with(&format!("{place} 3: the name of an image")),
        "{notes:?}"
    );
    save_mesh(&at("mesh.gltf"), &opened.mesh).expect("written");
    let json = fs::read_to_string(at("mesh.gltf")).expect("there");
    assert!(
        json.contains("\"name\":\"a\"") && !json.contains("null"),
        "{json}"
    );
}
