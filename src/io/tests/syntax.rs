//! The legal variety of each format.

use super::super::Format::{Obj, Off, Ply, Stl};
use super::{bad, good};
use crate::mesh::{Attributes, Column, DVec3, NO_VALUE};

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";

#[test]
fn obj_variants_read_as_the_plain_file() {
    let plain = good(Obj, TETRAHEDRON);
    assert_eq!(plain.corners, [0, 2, 1, 0, 1, 3, 0, 3, 2]);
    assert_eq!(plain.offsets, [0, 3, 6, 9]);
    assert!(plain.notes.is_empty() && plain.attributes == Attributes::default());
    for text in [
        TETRAHEDRON.replace('\n', "\r\n"),
        TETRAHEDRON.replace('\n', "\r"),
        TETRAHEDRON.replace('\n', " # remark\n"),
        TETRAHEDRON.replace("0 0 ", "0 \\\n 0 "),
        TETRAHEDRON.replace("1 2 4", "1\\\r\n2 4"),
        TETRAHEDRON.replace(' ', " \t "),
        format!("\u{feff}# C:\\dir\\\n{TETRAHEDRON}"),
        TETRAHEDRON.replace("f 1 3 2", "f -4 -2 -3"),
        TETRAHEDRON.replace("v 1 0 0", "v 1 0 0 1.0"),
    ] {
        let soup = good(Obj, &text);
        assert_eq!(soup.positions, plain.positions, "{text}");
        assert_eq!(soup.corners, plain.corners, "{text}");
        assert_eq!(soup.notes, plain.notes, "{text}");
    }
}

#[test]
fn obj_faces_may_come_before_their_vertices() {
    let soup = good(Obj, "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    assert_eq!(soup.corners, [0, 1, 2]);
}

#[test]
fn obj_keeps_unused_and_repeated_vertices_in_file_order() {
    let soup = good(
        Obj,
        "v 9 9 9\no a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 4 2 3\no b\nv 0 0 0\nf 5 3 4\n",
    );
    assert_eq!(soup.positions.len(), 5);
    assert_eq!(soup.positions[0], DVec3::splat(9.0));
    assert_eq!(soup.corners, [3, 1, 2, 4, 2, 3]);
}

#[test]
fn obj_attributes_colors_and_groups() {
    let text = "mtllib a b.mtl\nmtllib other.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\n\
        v 0 1 0\nvt 0 0\nvn 0 0 1\ns off\nf 1/1/1 2//1 3/1 4\ng rim left\nusemtl red\nf 1 2 3\nf 2 3 4\n\
        o thing\nf 3 4 1\ng rim left\nl 1 2\n";
    let soup = good(Obj, text);
    assert_eq!(soup.offsets, [0, 4, 7, 10, 13]);
    assert_eq!(soup.attributes.vertex_colors()[1], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(soup.attributes.vertex_colors()[3], [1.0; 4]);
    assert_eq!(soup.attributes.faces.tags, [0, 1, 1, 2]);
    assert_eq!(soup.attributes.tags[0].material, "");
    assert_eq!(
        (
            soup.attributes.tags[1].group.as_str(),
            soup.attributes.tags[1].material.as_str()
        ),
        ("rim left", "red")
    );
    assert_eq!(
        (
            soup.attributes.tags[2].object.as_str(),
            soup.attributes.tags[2].group.as_str()
        ),
        ("thing", "rim left")
    );
    assert_eq!(soup.attributes.material_libraries, ["a b.mtl", "other.mtl"]);
    let faces = &soup.attributes.faces;
    assert_eq!(faces.texture[..5], [0, NO_VALUE, 0, NO_VALUE, NO_VALUE]);
    assert_eq!(faces.normals[..5], [0, 0, NO_VALUE, NO_VALUE, NO_VALUE]);
    assert_eq!(soup.attributes.tags[0].smoothing, "off");
    let notes = soup.notes.join("; ");
    for part in ["lines and points", "1 vertices without a colour"] {
        assert!(notes.contains(part), "{notes}");
    }
}

#[test]
fn obj_seven_numbers_are_weight_and_color_or_color_and_alpha() {
    let file = |four: [&str; 3]| {
        format!(
            "v 0 0 0 {}\nv 1 0 0 {}\nv 0 1 0 {}\nf 1 2 3\n",
            four[0], four[1], four[2]
        )
    };
    let weighted = good(Obj, file(["1.0 .5 .25 0", "1 0 0 0", "1 0 0 0"]));
    assert_eq!(
        weighted.attributes.vertex_colors()[0],
        [0.5, 0.25, 0.0, 1.0]
    );
    let alpha = good(Obj, file(["1.0 .5 .25 0", "0 0 0 1", "1 0 0 0"]));
    assert_eq!(alpha.attributes.vertex_colors()[0], [1.0, 0.5, 0.25, 0.0]);
    let bytes = good(
        Obj,
        "v 0 0 0 255 51 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n",
    );
    assert_eq!(bytes.attributes.vertex_colors()[0], [1.0, 0.2, 0.0, 1.0]);
}

#[test]
fn obj_warns_of_a_last_line_without_end() {
    let soup = good(Obj, TETRAHEDRON.trim_end());
    assert!(
        soup.notes.iter().any(|n| n.contains("line 7")),
        "{:?}",
        soup.notes
    );
}

#[test]
fn ply_ascii_with_everything_that_is_skipped() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment c\r\nobj_info o\r\nelement camera 2\r\n\
        property list uchar float view\r\nproperty int id\r\nelement vertex 4\r\nproperty float nx\r\n\
        property double x\r\nproperty double y\r\nproperty float32 z\r\nproperty uchar red\r\n\
        property uchar green\r\nproperty uchar blue\r\nproperty list uchar int neighbours\r\n\
        element nothing 9999999999999\r\nelement face 2\r\nproperty uchar flags\r\n\
        property list uchar int vertex_index\r\nelement edge 1\r\nproperty int a\r\nend_header\r\n\
        3 .1 .2 .3 7\r\n0 8\r\n1 0 0 0 255 0 0 2 1 2\r\n\r\n1 0.1 0 0 0 0 51 0\r\n1 1 1 0 0 0 0 0\r\n\
        1 0 1e-3 0 0 0 0 0\r\n0 3 0 1 2\r\n1 4 0 1 2 3\r\n5\r\n";
    let soup = good(Ply, text);
    assert_eq!(soup.positions[1].x, 0.1);
    assert_eq!(soup.attributes.vertex_colors()[1], [0.0, 0.0, 0.2, 1.0]);
    assert_eq!(soup.corners, [0, 1, 2, 0, 1, 2, 3]);
    let notes = soup.notes.join("; ");
    assert!(
        notes.contains("vertex lists not kept: neighbours"),
        "{notes}"
    );
    assert!(notes.contains("elements not kept: camera, edge"), "{notes}");
    let all = &soup.attributes;
    assert_eq!(all.comments, ["comment c", "obj_info o"]);
    let numbers = |columns: &[Column], name: &str| -> Vec<f64> {
        let column = columns.iter().find(|c| c.name == name).expect(name);
        (0..column.numbers.len())
            .map(|row| column.numbers.get(row))
            .collect()
    };
    assert_eq!(numbers(&all.vertices, "nx"), [1.0; 4]);
    assert_eq!(numbers(&all.faces.columns, "flags"), [0.0, 1.0]);
}

/// As Rhinoceros writes them: single carriage returns, also before the bytes of a binary file.
#[test]
fn ply_headers_may_have_old_line_ends() {
    let header = |format: &str| {
        format!(
            "ply\rformat {format} 1.0\rcomment c\relement vertex 3\rproperty float x\rproperty float y\r\
             property float z\relement face 1\rproperty list uchar int vertex_indices\rend_header\r"
        )
    };
    let text = good(Ply, header("ascii") + "0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r");
    let mut bytes = header("binary_little_endian").into_bytes();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.push(3);
    for v in [0_i32, 1, 2] {
        bytes.extend(v.to_le_bytes());
    }
    let binary = good(Ply, bytes);
    for soup in [text, binary] {
        assert_eq!(soup.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(soup.corners, [0, 1, 2]);
        assert_eq!(soup.attributes.comments, ["comment c"]);
        assert!(soup.notes.is_empty(), "{:?}", soup.notes);
    }
}

/// As Blender 2.4 wrote them.
#[test]
fn ply_comments_may_lack_the_word() {
    let text = "ply\nformat ascii 1.0\nCreated by a program\nelement vertex 3\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let soup = good(Ply, text);
    let notes = soup.notes.join("; ");
    assert!(
        notes.contains("line 3 of the header, 'Created by a program'"),
        "{notes}"
    );
    // a word that is not of the format after the first element is more likely a mistake in one
    let message = bad(Ply, text.replace("element face", "elment face"));
    assert!(message.contains("line 8"), "{message}");
}

#[test]
fn ply_triangle_strips() {
    let file = |list: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
             property float z\nelement tristrips 1\nproperty list int int vertex_indices\n\
             end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n{list}\n"
        )
    };
    // every other triangle turns, a repeated vertex joins two parts, −1 starts anew
    let soup = good(Ply, file("13 0 1 2 3 4 -1 3 5 4 4 2 2 3"));
    let triangles: Vec<&[u32]> = (0..soup.face_count()).map(|f| soup.face(f)).collect();
    assert_eq!(
        triangles,
        [[0, 1, 2], [2, 1, 3], [2, 3, 4], [3, 5, 4]].map(|t| t.to_vec())
    );
    assert!(soup.notes.is_empty());
}

#[test]
fn ply_lines_may_be_longer_than_declared() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0\n1 0 0 7 8\n0 1 0\n3 0 1 2 255 255 x\n";
    let soup = good(Ply, text);
    assert_eq!(soup.positions[1], DVec3::X);
    assert_eq!(soup.corners, [0, 1, 2]);
    assert_eq!(soup.notes.len(), 1);
    assert!(soup.notes[0].contains("2 lines") && soup.notes[0].contains("line 11"));
}

/// A binary PLY with float coordinates, alpha, and a list to skip, in either byte order.
fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property double z\nproperty ushort red\nproperty ushort green\nproperty ushort blue\n\
         property float alpha\nelement face 1\nproperty list ushort short skipped\n\
         property list int uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    let mut put = |little: &[u8]| {
        let mut raw = little.to_vec();
        if big {
            raw.reverse();
        }
        bytes.extend(raw);
    };
    for v in 0..3_u8 {
        put(&f32::from(v).to_le_bytes());
        put(&0.1_f32.to_le_bytes());
        put(&(f64::from(v) / 3.0).to_le_bytes());
        for channel in [65535_u16, 0, 13107] {
            put(&channel.to_le_bytes());
        }
        put(&0.5_f32.to_le_bytes());
    }
    put(&2_u16.to_le_bytes());
    put(&(-1_i16).to_le_bytes());
    put(&7_i16.to_le_bytes());
    put(&3_i32.to_le_bytes());
    for index in [2_u32, 0, 1] {
        put(&index.to_le_bytes());
    }
    bytes
}

#[test]
fn ply_binary_in_both_byte_orders() {
    for big in [false, true] {
        let soup = good(Ply, binary_ply(big));
        assert_eq!(
            soup.positions[1],
            DVec3::new(1.0, f64::from(0.1_f32), 1.0 / 3.0)
        );
        assert_eq!(soup.attributes.vertex_colors()[2], [1.0, 0.0, 0.2, 0.5]);
        assert_eq!(soup.corners, [2, 0, 1]);
    }
}

#[test]
fn stl_ascii_with_two_solids() {
    let facet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  VERTEX 1.5e0 0 0\n\tvertex 0 0.1 0\n\
        endloop\nendfacet\n";
    let soup = good(
        Stl,
        format!("solid one\n{facet}{facet}endsolid one\nsolid two\n{facet}endsolid\n"),
    );
    assert!(soup.exploded);
    assert_eq!(soup.positions.len(), 9);
    assert_eq!(soup.positions[8].y, 0.1);
    assert_eq!(soup.attributes.faces.tags, [0, 0, 1]);
    assert_eq!(soup.attributes.tags[1].object, "two");
    let open = good(Stl, format!("solid\r\n{}", facet.replace('\n', "\r\n")));
    assert!(open.attributes.tags.is_empty() && open.notes[0].contains("endsolid"));
}

/// A binary STL of one face, with any header.
pub(super) fn binary_stl(header: &[u8], declared: u32, faces: &[[f32; 9]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(declared.to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        bytes.extend(face.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_is_binary_for_any_header_text() {
    let face = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.0];
    for header in [&b"exported"[..], b"solid exported"] {
        let soup = good(Stl, binary_stl(header, 2, &[face; 2]));
        assert_eq!((soup.face_count(), soup.exploded), (2, true));
        assert_eq!(soup.positions[5].y, f64::from(0.1_f32));
    }
    let longer = good(Stl, binary_stl(b"x", 1, &[face; 2]));
    assert!(longer.notes[0].contains("50 bytes"));
}

#[test]
fn off_with_everything() {
    let text = "\u{feff}# made by hand\nSTCNOFF 4 2 0\n\n0 0 0  0 0 1  255 0 51 255  0 0\n\
        1 0 0  0 0 1  0 255 0 255  .5 0 # corner\n1 1 0  0 0 1  0 0 255 128  .5 .5\n\
        0 .1 0  0 0 1  9 9 9 255  0 .5\n3 0 1 2 255 0 0\n4 0 1 2 3 0 0 255\nmore\n";
    let soup = good(Off, text);
    assert_eq!(soup.positions[3], DVec3::new(0.0, 0.1, 0.0));
    assert_eq!(soup.offsets, [0, 3, 7]);
    assert_eq!(soup.corners, [0, 1, 2, 0, 1, 2, 3]);
    let all = &soup.attributes;
    let names =
        |columns: &[Column]| -> Vec<String> { columns.iter().map(|c| c.name.clone()).collect() };
    let vertex = ["nx", "ny", "nz", "red", "green", "blue", "alpha", "s", "t"];
    assert_eq!(names(&all.vertices), vertex);
    assert_eq!(all.vertex_colors()[0], [1.0, 0.0, 0.2, 1.0]);
    assert_eq!(all.vertices[7].numbers.get(1), 0.5);
    assert_eq!(names(&all.faces.columns), ["red", "green", "blue"]);
    assert_eq!(all.faces.columns[2].numbers.get(1), 255.0);
    assert!(soup.notes[0].contains("line 10"), "{:?}", soup.notes);
    let plain = good(
        Off,
        "OFF\n3 1\n0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2 7",
    );
    assert_eq!(plain.attributes.vertex_colors()[1], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(names(&plain.attributes.faces.columns), ["color"]);
    let mixed = good(
        Off,
        "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 1 0 0\n3 2 1 0\n",
    );
    assert!(mixed.attributes.faces.columns.is_empty() && mixed.notes[0].contains("face colours"));
}

#[test]
fn off_is_refused_with_place_and_remedy() {
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, words) in [
        ("", "empty"),
        ("solid x\n", "'solid' instead of 'OFF'"),
        ("4OFF\n3 1 0\n", "four or more dimensions"),
        ("OFF BINARY\n", "binary OFF"),
        ("OFF\nx 1 0\n", "line 2: the number of vertices"),
        ("OFF\n3000000000 1 0\n", "at least 18000000008 bytes"),
        ("OFF\n0 1 0\n00000000", "no vertices"),
        (&format!("OFF\n3 0 0\n{points}"), "no faces"),
        (
            &format!("OFF\n3 1 0\n{points}2 0 1 9\n"),
            "line 6: face 1 has 2",
        ),
        (&format!("OFF\n3 1 0\n{points}3 0 1 3\n"), "line 6: face 1"),
        (
            &format!("OFF\n3 1 0\n{points}3 0 1 x\n"),
            "a vertex of face 1",
        ),
        (
            &format!("OFF\n3 1 0\n{points}3 0 1 2 1 1 1 1 1\n"),
            "more than 4 numbers",
        ),
        (
            "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n",
            "vertex 2 of 3 needs 3 numbers",
        ),
        ("OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "vertex 2"),
        (
            "OFF\n3 1 0\n0 0 0\n1 0 0\n# 0 0 0 0 0\n",
            "it ends before vertex 3",
        ),
    ] {
        let message = bad(Off, text);
        assert!(message.contains(words), "{text:?}: {message}");
    }
}
