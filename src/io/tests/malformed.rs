//! Broken files end in an error with the place and the reason.

use proptest::prelude::*;
use std::path::Path;

use super::super::Format::{self, Obj, Ply, Stl};
use super::super::read;
use super::gltf::cube;
use super::syntax::binary_stl;
use super::{assert_sound, bad};

#[track_caller]
fn says(format: Format, bytes: impl AsRef<[u8]>, parts: &[&str]) {
    let message = bad(format, bytes);
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

const POINTS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn obj_coordinates() {
    says(
        Obj,
        "# a\nv 0 0 nan\n",
        &["mesh: line 2:", "vertex 1", "z = 'nan'"],
    );
    says(
        Obj,
        "v 0 0 0\nv 0 -inf 0\n",
        &["line 2", "vertex 2", "y = '-inf'"],
    );
    says(
        Obj,
        "v 1e999 0 0\n",
        &["x = '1e999'", "not a finite number"],
    );
    says(
        Obj,
        "v 0 \\\n abc 0\n",
        &["line 2", "y of vertex 1", "'abc'"],
    );
    says(Obj, "v 0,5 1 2\n", &["'0,5'", "decimal point"]);
    says(Obj, "v 0 0 1.#QNAN\n", &["'1.#QNAN'"]);
    says(Obj, "v 1 2\n", &["line 1", "vertex 1 has 2 numbers"]);
    says(Obj, "v 1 2 3 4 5\n", &["has 5 numbers"]);
    says(Obj, "v 1 2 3 4 5 6 7 8\n", &["has 8 numbers"]);
}

#[test]
fn obj_faces() {
    says(
        Obj,
        format!("{POINTS}f 0 1 2\n"),
        &["line 4", "face 1", "vertex 0", "counts from 1"],
    );
    says(
        Obj,
        format!("{POINTS}f 1 2 3\nf 1 2 4\n"),
        &["line 5", "face 2", "vertex 4", "3 vertices"],
    );
    says(
        Obj,
        format!("{POINTS}f 1 2 99999999999\n"),
        &["vertex 99999999999"],
    );
    says(
        Obj,
        format!("{POINTS}f -1 -2 -4\n"),
        &["line 4", "vertex -4", "3 vertices"],
    );
    says(Obj, format!("{POINTS}f 1 2 x\n"), &["line 4", "corner 'x'"]);
    says(Obj, format!("{POINTS}f 1 2 3.5\n"), &["corner '3.5'"]);
    says(
        Obj,
        format!("{POINTS}f 1/1/1/1 2 3\n"),
        &["corner '1/1/1/1'"],
    );
    says(
        Obj,
        format!("{POINTS}f 1 2\n"),
        &["line 4", "has 2 corners"],
    );
    says(
        Obj,
        format!("{POINTS}f 1 2 3\nf 1 2"),
        &["line 5", "has 2 corners", "cut off"],
    );
    says(
        Obj,
        format!("f 1 2 9\nf 1 2 7\n{POINTS}"),
        &["line 1", "vertex 9"],
    );
}

#[test]
fn obj_without_a_surface() {
    says(Obj, "", &["empty", "0 bytes"]);
    says(Obj, "# nothing\n\n# really\n", &["comments"]);
    says(Obj, POINTS, &["3 vertices but no faces"]);
    says(Obj, "v 0 0 0\nv 1 0 0\nv 0 1", &["line 3", "has 2 numbers"]);
    says(Obj, "v 0 0 0\nv 1 0 0.12", &["no faces", "cut off"]);
    says(Obj, "g group\n", &["no vertices"]);
    says(
        Obj,
        "hello world\n",
        &["not valid OBJ", "line 1", "'hello'"],
    );
    says(Obj, b"\x89PNG\r\n\x1a\n\0\0", &["line 1", "not text"]);
    says(Obj, b"\xff\xfev\0 \0", &["UTF-16"]);
    says(Obj, format!("{POINTS}f 1 2 3\n4 5 6\n"), &["line 5", "'4'"]);
}

#[test]
fn ply_headers() {
    says(Ply, "", &["empty"]);
    says(Ply, "plyx\n", &["line 1", "not valid PLY", "'plyx'"]);
    says(Ply, "\0\0", &["not valid PLY"]);
    says(
        Ply,
        "ply\nformat ascii 1.0\nelement vertex 1\n",
        &["end_header"],
    );
    says(
        Ply,
        "ply\nformat xml 1.0\n",
        &["line 2", "unknown PLY format"],
    );
    says(
        Ply,
        "ply\nformat ascii 1.0\nelement vertex many\n",
        &["line 3", "element vertex many"],
    );
    says(
        Ply,
        "ply\nformat ascii 1.0\nelement vertex -1\n",
        &["line 3"],
    );
    says(
        Ply,
        "ply\nelement vertex 1\nproperty quad x\n",
        &["line 3", "quad"],
    );
    says(
        Ply,
        "ply\nelement vertex 1\nproperty list float int x\n",
        &["line 3"],
    );
    says(
        Ply,
        "ply\nproperty int x\n",
        &["line 2", "before any element"],
    );
    says(Ply, "ply\nend_header\n", &["no format"]);
    says(Ply, "ply\nformat ascii 1.0\nend_header\n", &["no vertices"]);
}

fn ascii_ply(vertices: &str, faces: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n{body}"
    )
}

#[test]
fn ply_ascii_bodies() {
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    says(
        Ply,
        ascii_ply("3", "0", points),
        &["3 vertices but no faces"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}3 0 1 3\n")),
        &["line 13", "vertex 3", "3 vertices", "counted from 0"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}3 0 1 -1\n")),
        &["vertex -1"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}3 0 1 1.5\n")),
        &["whole number"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}3 0 1\n")),
        &["line 13", "too few numbers"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}2 0 1\n")),
        &["has 2 corners"],
    );
    says(
        Ply,
        ascii_ply("3", "1", &format!("{points}-3 0 1\n")),
        &["-3 items"],
    );
    says(
        Ply,
        ascii_ply("3", "2", &format!("{points}3 0 1 2\n")),
        &["ends before face 2 of 2"],
    );
    says(
        Ply,
        ascii_ply("3", "1", "0 0 0\n0 nan 0\n0 0 0\n3 0 1 2\n"),
        &["line 11", "vertex 2", "y ="],
    );
    says(
        Ply,
        ascii_ply("3", "1", "0 0 0\n0 a 0\n0 0 0\n3 0 1 2\n"),
        &["line 11", "'a'"],
    );
    says(
        Ply,
        ascii_ply("18446744073709551615", "1", points),
        &["more than"],
    );
    says(
        Ply,
        ascii_ply("4000000000", "1", points),
        &["cut off", "4000000000"],
    );
    says(
        Ply,
        ascii_ply("3", "18446744073709551615", points),
        &["cut off"],
    );
    let strips = ascii_ply("3", "0", "").replace("element face 0", "element tristrips 1");
    let strip = |list: &str| strips.clone() + points + list;
    says(Ply, strip("4 0 1 2 3\n"), &["vertex 3"]);
    says(Ply, strip("4 0 1 2 -2\n"), &["vertex -2"]);
    says(Ply, strip("2 0 1\n"), &["3 vertices but no faces"]);
    says(Ply, strip("5 0 1 2\n"), &["too few numbers"]);
    let no_z = ascii_ply("3", "1", "").replace("float z", "float w");
    says(Ply, no_z + points + "3 0 1 2\n", &["no coordinate", "'z'"]);
}

#[test]
fn ply_binary_counts_that_lie() {
    let file = |vertices: u64, faces: u64, body: &[u8]| {
        let header = ascii_ply(&vertices.to_string(), &faces.to_string(), "");
        let mut bytes = header.replace("ascii", "binary_little_endian").into_bytes();
        bytes.extend(body);
        bytes
    };
    says(
        Ply,
        file(3, 1, &[0; 30]),
        &["3 'vertex' elements", "36 bytes", "30 are left"],
    );
    says(
        Ply,
        file(4_000_000_000, 1, &[0; 99]),
        &["48000000000 bytes"],
    );
    let mut body = vec![0; 36];
    body.extend([255, 0, 0, 0, 0]);
    says(Ply, file(3, 1, &body), &["list of 255 items"]);
    body[36] = 3;
    says(Ply, file(3, 1, &body), &["byte", "ends in face 1"]);
    says(Ply, file(3, u64::MAX, &body), &["cut off"]);
    body[0..4].copy_from_slice(&f32::NAN.to_le_bytes());
    says(Ply, file(3, 1, &body), &["byte", "vertex 1", "x = 'NaN'"]);
}

#[test]
fn stl_files() {
    let face = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    says(Stl, "", &["empty"]);
    says(Stl, [7; 50], &["50 bytes"]);
    says(
        Stl,
        binary_stl(b"x", 3, &[face; 2]),
        &["3 faces has 234 bytes", "this file has 184"],
    );
    says(Stl, binary_stl(b"solid x", u32::MAX, &[face]), &["cut off"]);
    says(Stl, binary_stl(b"x", 0, &[]), &["no vertices"]);
    let mut broken = face;
    broken[4] = f32::INFINITY;
    says(
        Stl,
        binary_stl(b"x", 1, &[broken]),
        &["byte 112", "vertex 2", "y = 'inf'"],
    );
    says(Stl, "solid a\nendsolid a\n", &["no vertices"]);
    says(
        Stl,
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0",
        &["line 5", "2 numbers"],
    );
    says(
        Stl,
        "solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n",
        &["cut off", "2 corners"],
    );
    says(
        Stl,
        "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
        &["line 5", "2 corners"],
    );
    says(
        Stl,
        "solid\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\n",
        &["line 5", "fourth"],
    );
    says(Stl, "solid\nvertex 0 nan 0\n", &["line 2", "y = 'nan'"]);
    says(Stl, "solid\nvertex 0 x 0\n", &["line 2", "'x'"]);
    says(Stl, "solid\nvertex 0 0 0 0\n", &["line 2", "4 numbers"]);
    says(Stl, "solid\nthe rest\n", &["line 2", "'the'"]);
}

fn never_panics(bytes: &[u8]) {
    for format in Format::ALL {
        if let Ok(soup) = read(format, bytes, Path::new("noise")) {
            assert_sound(&soup);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn noise_is_refused_or_sound(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        never_panics(&bytes);
    }

    #[test]
    fn statements_in_any_order_are_refused_or_sound(
        words in prop::collection::vec(
            prop::sample::select(vec![
                "v", "f", "o", "g", "usemtl", "\n", "\n", "1", "-1", "2", "1/2/3", "0", "1e9", "\\\n",
                "nan", "#", "solid", "vertex", "endloop", "endfacet", "endsolid", "ply\n",
                "format ascii 1.0\n", "element vertex 1\n", "property int x\n", "end_header\n",
            ]),
            0..60,
        ),
    ) {
        never_panics(words.join(" ").as_bytes());
    }

    #[test]
    fn cut_and_changed_files_are_refused_or_sound(
        which in 0_usize..5, cut in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), byte in any::<u8>(),
    ) {
        let face = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let ply = ascii_ply("3", "1", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").into_bytes();
        let mut binary = ascii_ply("3", "1", "").replace("ascii", "binary_big_endian").into_bytes();
        binary.extend([0; 36]);
        binary.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2]);
        let obj = format!("{POINTS}g a\nf 1/1 2/2 3/3\n").into_bytes();
        let mut bytes = [ply, binary, obj, binary_stl(b"x", 2, &[face; 2]), cube()][which].clone();
        let end = bytes.len();
        bytes[at.index(end)] = byte;
        never_panics(&bytes);
        bytes.truncate(cut.index(end));
        never_panics(&bytes);
    }
}
