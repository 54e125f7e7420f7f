//! Picking on a mesh of 100 000 triangles (goal: 2 ms per pick), and the cost of drawing without
//! the graphics card: limit surfaces of a million triangles and of a moving patch.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use meniscus::mesh::{DVec3, FaceId, Mesh, boundary_loops};
use meniscus::render::{Bounds, Camera, DynamicSurface, Picker, SurfaceOptions};
use meniscus::shapes;

fn mesh((positions, triangles): shapes::TriangleMesh) -> Mesh {
    Mesh::from_triangles(positions, &triangles).expect("a manifold")
}

/// A sphere of 100 000 triangles with many holes.
fn holed() -> Mesh {
    let hole = |p: DVec3| {
        let at = |x: f64| (9.0 * x).sin();
        at(p.x) * at(p.y) * at(p.z) > 0.45
    };
    mesh(shapes::cut_where(&shapes::icosphere(71), hole))
}

fn picking(c: &mut Criterion) {
    let mesh = holed();
    let loops = boundary_loops(&mesh);
    let camera = Camera::fit(&Bounds::of(mesh.positions.iter().copied()).expect("points"));
    println!("{} faces, {} loops", mesh.face_count(), loops.len());
    c.bench_function("prepare picking", |b| {
        b.iter(|| Picker::new(black_box(&mesh.positions), &mesh.topology, &loops));
    });
    let picker = Picker::new(&mesh.positions, &mesh.topology, &loops);
    let size = [1280.0, 800.0];
    let mut i = 0u32;
    let mut cursor = move || {
        // points spread over the picture, in a fixed order
        i = (i + 4093) % (128 * 80);
        [
            f64::from(i % 128) * 10.0 + 5.0,
            f64::from(i / 128) * 10.0 + 5.0,
        ]
    };
    c.bench_function("pick a loop", |b| {
        b.iter(|| picker.pick_loop(&camera, size, cursor(), 8.0));
    });
}

fn surfaces(c: &mut Criterion) {
    let mut group = c.benchmark_group("surfaces");
    group.sample_size(10);
    let large = mesh(shapes::icosphere(224));
    let faces: Vec<FaceId> = large.topology.faces().collect();
    println!("{} faces", faces.len());
    group.bench_function("static, a million triangles", |b| {
        b.iter(|| {
            let options = SurfaceOptions {
                samples_per_edge: Some(1),
                ..SurfaceOptions::default()
            };
            let surface = DynamicSurface::new(&large.topology, &faces, &options);
            surface.evaluate(&large.positions, DVec3::ZERO, true, None)
        });
    });
    let patch = &faces[..10_000];
    let surface = DynamicSurface::new(&large.topology, patch, &SurfaceOptions::default());
    group.bench_function("moving, 10 000 triangles", |b| {
        b.iter(|| surface.evaluate(&large.positions, DVec3::ZERO, true, None));
    });
}

criterion_group!(benches, picking, surfaces);
criterion_main!(benches);
