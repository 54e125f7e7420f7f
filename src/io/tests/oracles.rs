//! Independent readers of the same bytes: tobj, ply-rs-bw, `stl_io`.

use std::io::Cursor;

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

use super::super::{Format, OutputMesh, write};
use super::{colored, good};
use crate::mesh::DVec3;

/// A patch of a paraboloid with coordinates of all lengths, coloured.
struct Sample {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    colors: Vec<[f32; 4]>,
}

fn sample() -> Sample {
    let n = 12_u32;
    let at = |i: u32, j: u32| {
        let (x, y) = (f64::from(i) / 7.0, f64::from(j) * 0.1 - 1e-9);
        DVec3::new(x, y, (x * x - y * y) * 1e-7)
    };
    let grid = |n: u32| (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
    let cell = |(i, j): (u32, u32)| {
        let v = i * n + j;
        [[v, v + n, v + 1], [v + 1, v + n, v + n + 1]]
    };
    Sample {
        positions: grid(n).map(|(i, j)| at(i, j)).collect(),
        triangles: grid(n - 1).flat_map(cell).collect(),
        colors: grid(n)
            .map(|(i, j)| [i as f32 / 255.0, j as f32 / 255.0, 0.5, 1.0])
            .collect(),
    }
}

impl Sample {
    fn bytes(&self, format: Format) -> Vec<u8> {
        let mesh = OutputMesh {
            positions: &self.positions,
            triangles: &self.triangles,
            attributes: &colored(&self.colors),
        };
        let mut bytes = Vec::new();
        write(format, &mesh, &mut bytes).expect("a Vec takes everything");
        bytes
    }
}

/// The corners of all faces as points, for readers that renumber the vertices.
fn corner_points(positions: &[f64], indices: &[u32]) -> Vec<[f64; 3]> {
    let point = |&v: &u32| {
        let p = &positions[3 * v as usize..];
        [p[0], p[1], p[2]]
    };
    indices.iter().map(point).collect()
}

#[test]
fn tobj_sees_the_same_mesh() {
    let text = sample().bytes(Format::Obj);
    let ours = good(Format::Obj, &text);
    let none = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let options = tobj::LoadOptions::default();
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(&text), &options, none).expect("tobj reads it");
    let [model] = models.as_slice() else {
        panic!("{} models", models.len())
    };
    let flat: Vec<f64> = ours.positions.iter().flat_map(DVec3::to_array).collect();
    let theirs = corner_points(&model.mesh.positions, &model.mesh.indices);
    assert_eq!(corner_points(&flat, &ours.corners), theirs);
    // tobj renumbers by first use; ours is the list of the file.
    assert_eq!(ours.positions, sample().positions);
    for (v, color) in ours.attributes.vertex_colors().iter().enumerate() {
        let corner = ours
            .corners
            .iter()
            .position(|&c| c as usize == v)
            .expect("used");
        let index = model.mesh.indices[corner] as usize;
        assert_eq!(color[0], model.mesh.vertex_color[3 * index] as f32);
    }
}

#[test]
fn ply_rs_sees_the_same_mesh() {
    let bytes = sample().bytes(Format::Ply);
    let ours = good(Format::Ply, &bytes);
    let theirs = Parser::<DefaultElement>::new()
        .read_ply(&mut Cursor::new(&bytes))
        .expect("ply-rs reads it");
    let vertices = theirs.payload.get("vertex").expect("vertices");
    assert_eq!(vertices.len(), ours.positions.len());
    for (element, p) in vertices.iter().zip(&ours.positions) {
        assert_eq!(element.get("x"), Some(&Property::Double(p.x)));
        assert_eq!(element.get("z"), Some(&Property::Double(p.z)));
    }
    let faces = theirs.payload.get("face").expect("faces");
    for (f, element) in faces.iter().enumerate() {
        let Some(Property::ListInt(corners)) = element.get("vertex_indices") else {
            panic!("no corners in face {f}");
        };
        assert!(
            corners
                .iter()
                .zip(ours.face(f))
                .all(|(a, b)| i64::from(*a) == i64::from(*b))
        );
    }
}

#[test]
fn stl_io_sees_the_same_mesh() {
    let bytes = sample().bytes(Format::Stl);
    let ours = good(Format::Stl, &bytes);
    let reader = &mut Cursor::new(&bytes);
    let theirs: Vec<_> = stl_io::create_stl_reader(reader)
        .expect("stl_io reads it")
        .collect::<Result<_, _>>()
        .expect("stl_io reads it");
    assert_eq!(theirs.len(), ours.face_count());
    for (triangle, corners) in theirs.iter().zip(ours.positions.chunks(3)) {
        for (a, b) in triangle.vertices.iter().zip(corners) {
            assert_eq!(a.0.map(f64::from), b.to_array());
        }
        let normal = triangle.normal.0.map(f64::from);
        let flat = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        assert!((DVec3::from_array(normal) - flat).length() < 1e-5);
    }
}
