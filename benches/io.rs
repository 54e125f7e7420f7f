//! Reading and writing a mesh of a million triangles, with tobj as the baseline for OBJ.

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};

use criterion::{Criterion, criterion_group, criterion_main};
use meniscus::io::{self, OutputMesh};
use meniscus::mesh::DVec3;

/// A wavy sheet of `2 n^2` triangles.
fn sheet(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let point = |i: u32, j: u32| {
        let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
        DVec3::new(x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos())
    };
    let positions = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| point(i, j)))
        .collect();
    let cell = |i: u32, j: u32| {
        let v = i * (n + 1) + j;
        [[v, v + n + 1, v + 1], [v + 1, v + n + 1, v + n + 2]]
    };
    let triangles = (0..n)
        .flat_map(|i| (0..n).flat_map(move |j| cell(i, j)))
        .collect();
    (positions, triangles)
}

fn tobj_load(path: &Path) -> usize {
    let (models, _) = tobj::load_obj(path, &tobj::LoadOptions::default()).expect("readable");
    models.iter().map(|model| model.mesh.indices.len()).sum()
}

fn files(c: &mut Criterion) {
    let directory = tempfile::tempdir().expect("temporary directory");
    let (positions, triangles) = sheet(707);
    let mesh = OutputMesh {
        positions: &positions,
        triangles: &triangles,
        ..OutputMesh::default()
    };
    let path = |name: &str| -> PathBuf { directory.path().join(name) };
    // nine digits, as in most files
    let mut short = String::new();
    for p in &positions {
        writeln!(short, "v {:.9} {:.9} {:.9}", p.x, p.y, p.z).expect("text");
    }
    for [a, b, c] in &triangles {
        writeln!(short, "f {} {} {}", a + 1, b + 1, c + 1).expect("text");
    }
    let mut textured = String::new();
    for p in &positions {
        writeln!(textured, "v {:.9} {:.9} {:.9}", p.x, p.y, p.z).expect("text");
        writeln!(textured, "vt {:.6} {:.6}", p.x, p.y).expect("text");
        writeln!(textured, "vn {:.4} {:.4} {:.4}", p.z, p.y, p.x).expect("text");
    }
    for t in &triangles {
        let [a, b, c] = t.map(|v| v + 1);
        writeln!(textured, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").expect("text");
    }
    std::fs::write(path("short.obj"), short).expect("written");
    std::fs::write(path("textured.obj"), textured).expect("written");
    for name in ["full.obj", "sheet.ply", "sheet.stl"] {
        io::save(&path(name), &mesh).expect("written");
    }
    let mut group = c.benchmark_group("1M triangles");
    group.sample_size(10);
    for name in [
        "short.obj",
        "textured.obj",
        "full.obj",
        "sheet.ply",
        "sheet.stl",
    ] {
        let file = path(name);
        group.bench_function(format!("load {name}"), |b| {
            b.iter(|| black_box(io::load(&file)).expect("readable"));
        });
        if file.extension().is_some_and(|e| e == "obj") {
            group.bench_function(format!("tobj {name}"), |b| {
                b.iter(|| black_box(tobj_load(&file)));
            });
        }
    }
    for name in ["out.obj", "out.ply", "out.stl"] {
        let file = path(name);
        group.bench_function(format!("save {name}"), |b| {
            b.iter(|| io::save(&file, &mesh).expect("written"));
        });
    }
    group.finish();
}

criterion_group!(benches, files);
criterion_main!(benches);
