//! What is written reads back to the same bits.

use proptest::prelude::*;

use super::super::{Format, MeshFault, OutputMesh, check, losses, write};
use super::{colored, good};
use crate::mesh::{Attributes, DVec3, FaceData, FaceTag, NO_VALUE, Soup, color_columns};

fn written(format: Format, mesh: &OutputMesh<'_>) -> Vec<u8> {
    assert_eq!(check(format, mesh), Ok(()));
    let mut bytes = Vec::new();
    write(format, mesh, &mut bytes).expect("a Vec takes everything");
    bytes
}

fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    positions
        .iter()
        .map(|p| p.to_array().map(f64::to_bits))
        .collect()
}

fn triangles(soup: &Soup) -> Vec<[u32; 3]> {
    soup.corners.chunks(3).map(|c| [c[0], c[1], c[2]]).collect()
}

/// Coordinates at every edge of the format.
fn hard_positions() -> Vec<DVec3> {
    let values = [
        0.0,
        -0.0,
        5e-324,
        -2.225_073_858_507_201e-308,
        f64::MIN_POSITIVE,
        1e-300,
        1e300,
        f64::MAX,
        -f64::MAX,
        0.1,
        1.0 / 3.0,
        1e16,
        9_007_199_254_740_993.0,
        1e-5,
        9.999_999_999_999_999e-6,
        1e22,
        1e23,
        123_456.789,
        -1e6 - 0.1,
        f64::EPSILON,
        1.0,
    ];
    values.chunks(3).map(DVec3::from_slice).collect()
}

#[test]
fn hard_coordinates_are_exact() {
    let positions = hard_positions();
    let mesh = OutputMesh {
        positions: &positions,
        triangles: &[[0, 1, 2], [6, 5, 3]],
        ..OutputMesh::default()
    };
    for format in [Format::Obj, Format::Ply, Format::Off, Format::ThreeMf] {
        let soup = good(format, written(format, &mesh));
        assert_eq!(bits(&soup.positions), bits(&positions));
        assert_eq!(triangles(&soup), mesh.triangles);
        let all = &soup.attributes;
        assert!(soup.notes.is_empty() && all.vertices.is_empty() && all.tags.is_empty());
    }
}

#[test]
fn colors_survive() {
    let positions = &hard_positions()[..3];
    let in_bytes = [
        [0.0, 1.0, 51.0 / 255.0, 1.0],
        [1.0; 4],
        [7.0 / 255.0, 0.0, 0.0, 1.0],
    ];
    let in_floats = [
        [0.1, 1e-9, 1.0 / 3.0, 1.0],
        [0.5, 0.25, 1e-20, 1.0],
        [0.0, 0.0, 1e-38, 1.0],
    ];
    let with_alpha = [[0.0, 0.2, 1.0, 0.4], [1.0; 4], [0.0; 4]];
    let in_words = [
        [0.0, 1.0, 513.0 / 65535.0, 1.0],
        [1.0; 4],
        [7.0 / 65535.0, 0.0, 0.0, 1.0],
    ];
    let cases = [
        (in_bytes, "uchar"),
        (in_words, "ushort"),
        (in_floats, "float"),
        (with_alpha, "uchar"),
    ];
    for (colors, kind) in cases {
        let mesh = OutputMesh {
            positions,
            triangles: &[[0, 1, 2]],
            attributes: &colored(&colors),
        };
        let ply = written(Format::Ply, &mesh);
        let header = String::from_utf8_lossy(&ply);
        assert!(header.contains(&format!("property {kind} red")), "{kind}");
        assert_eq!(good(Format::Ply, &ply).attributes.vertex_colors(), colors);
        let obj = good(Format::Obj, written(Format::Obj, &mesh));
        assert_eq!(obj.attributes.vertex_colors(), colors);
        assert_eq!(bits(&obj.positions), bits(positions));
    }
}

#[test]
fn groups_and_materials_survive() {
    let tag = |object: &str, group: &str, material: &str| FaceTag {
        object: object.into(),
        group: group.into(),
        material: material.into(),
        smoothing: String::new(),
    };
    let tags = [
        tag("", "", ""),
        tag("body", "left arm", "skin"),
        tag("body", "hand", "skin"),
    ];
    let positions = &hard_positions()[..3];
    let faces = [[0, 1, 2]; 5];
    let libraries = ["a b.mtl".to_owned()];
    let tagged = |list: &[u32], tags: &[FaceTag]| Attributes {
        faces: FaceData {
            tags: list.to_vec(),
            ..FaceData::default()
        },
        tags: tags.to_vec(),
        material_libraries: libraries.to_vec(),
        ..Attributes::default()
    };
    let given = tagged(&[0, 1, 1, 2, 1], &tags);
    let mesh = OutputMesh {
        positions,
        triangles: &faces,
        attributes: &given,
    };
    let soup = good(Format::Obj, written(Format::Obj, &mesh));
    let folder = soup.attributes.folder.clone();
    assert_eq!(
        soup.attributes,
        Attributes {
            folder,
            ..given.clone()
        }
    );
    // OBJ has no way back to nothing.
    let back = OutputMesh {
        attributes: &tagged(&[1, 1, 1, 1, 0], &tags),
        ..mesh
    };
    let soup = good(Format::Obj, written(Format::Obj, &back));
    assert_eq!(soup.attributes.tags[1], tag("default", "default", "None"));
    // A name cannot smuggle a statement in.
    let evil = [tag("a\nv 1 2 3", "", "")];
    let smuggled = OutputMesh {
        attributes: &tagged(&[0; 5], &evil),
        ..mesh
    };
    assert_eq!(
        good(Format::Obj, written(Format::Obj, &smuggled))
            .positions
            .len(),
        3
    );
}

#[test]
fn stl_is_exact_to_single_precision() {
    let positions: Vec<DVec3> = [[0.1, -0.0, 1e-40], [1.0, 2.0, 3.0], [1e30, 0.3, 5.0]]
        .map(DVec3::from_array)
        .to_vec();
    let mesh = OutputMesh {
        positions: &positions,
        triangles: &[[2, 0, 1]],
        ..OutputMesh::default()
    };
    let bytes = written(Format::Stl, &mesh);
    assert_eq!(bytes.len(), 134);
    let soup = good(Format::Stl, &bytes);
    let single = |v: usize| {
        positions[v]
            .to_array()
            .map(|x| f64::from(x as f32).to_bits())
    };
    assert_eq!(bits(&soup.positions), [single(2), single(0), single(1)]);
}

#[test]
fn what_a_format_leaves_out_is_said() {
    let near = [
        DVec3::splat(1e6),
        DVec3::splat(1e6) + DVec3::X * 1e-3,
        DVec3::ZERO,
    ];
    let mesh = OutputMesh {
        positions: &near,
        triangles: &[[0, 1, 2]],
        ..OutputMesh::default()
    };
    assert!(losses(Format::Obj, &mesh).is_empty() && losses(Format::Ply, &mesh).is_empty());
    let lost = losses(Format::Stl, &mesh);
    assert!(lost[0].contains("rounded") && lost[1].contains("collapse in single precision: 1"));
    let exact = OutputMesh {
        positions: &[DVec3::ZERO, DVec3::X, DVec3::Y],
        ..mesh
    };
    assert!(losses(Format::Stl, &exact).is_empty());
    let tagged = |tag: FaceTag| Attributes {
        faces: FaceData {
            tags: vec![0],
            ..FaceData::default()
        },
        tags: vec![tag],
        ..Attributes::default()
    };
    let patch = OutputMesh {
        attributes: &tagged(FaceTag::default().in_patch(7)),
        ..mesh
    };
    assert!(losses(Format::Ply, &patch).is_empty());
    assert_eq!(losses(Format::Stl, &patch).len(), 3);
    let mut all = tagged(FaceTag {
        object: "door".into(),
        ..FaceTag::default()
    });
    all.vertices = color_columns(&[[0.5; 4]; 3]);
    for column in &mut all.vertices {
        column.is_typed = true;
    }
    let full = OutputMesh {
        attributes: &all,
        ..mesh
    };
    assert_eq!(
        Format::ALL.map(|f| losses(f, &full).len()),
        [1, 1, 4, 1, 2, 2, 1]
    );
}

#[test]
fn unsound_meshes_are_not_written() {
    let positions = [DVec3::ZERO, DVec3::X, DVec3::splat(1e200)];
    let mesh = OutputMesh {
        positions: &positions,
        triangles: &[[0, 1, 2]],
        ..OutputMesh::default()
    };
    assert_eq!(check(Format::Ply, &mesh), Ok(()));
    assert!(matches!(
        check(Format::Stl, &mesh),
        Err(MeshFault::BeyondSingle { vertex: 2, .. })
    ));
    let nan = [DVec3::NAN];
    let with_tags = |list: &[u32]| Attributes {
        faces: FaceData {
            tags: list.to_vec(),
            ..FaceData::default()
        },
        ..Attributes::default()
    };
    let with_texture = |list: &[u32]| Attributes {
        faces: FaceData {
            texture: list.to_vec(),
            ..FaceData::default()
        },
        ..Attributes::default()
    };
    let faults = [
        OutputMesh {
            positions: &nan,
            triangles: &[],
            ..mesh
        },
        OutputMesh {
            triangles: &[[0, 1, 3]],
            ..mesh
        },
        OutputMesh {
            attributes: &colored(&[[0.0; 4]]),
            ..mesh
        },
        OutputMesh {
            attributes: &with_tags(&[0]),
            ..mesh
        },
        OutputMesh {
            attributes: &with_tags(&[0, 0]),
            ..mesh
        },
        OutputMesh {
            attributes: &with_texture(&[0; 3]),
            ..mesh
        },
        OutputMesh {
            attributes: &with_texture(&[NO_VALUE; 2]),
            ..mesh
        },
    ];
    for fault in faults {
        assert!(check(Format::Obj, &fault).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn random_bits_are_exact(raw in prop::collection::vec(any::<[u64; 3]>(), 3..40)) {
        let finite = |b: u64| Some(f64::from_bits(b)).filter(|x| x.is_finite()).unwrap_or(0.5);
        let positions: Vec<DVec3> = raw.iter().map(|p| DVec3::from_array(p.map(finite))).collect();
        let mesh = OutputMesh { positions: &positions, triangles: &[[2, 1, 0]], ..OutputMesh::default() };
        for format in [Format::Obj, Format::Ply, Format::Off, Format::ThreeMf] {
            prop_assert_eq!(bits(&good(format, written(format, &mesh)).positions), bits(&positions));
        }
    }
}
