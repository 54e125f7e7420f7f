//! First patches and warm starts over generated rims, from 30 to 5,000 edges.
#![allow(missing_docs)]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use meniscus::mesh::{DVec3, Topology, VertexId};
use meniscus::patch::{Patch, PatchOptions, Rim, fill, warm_start};

/// The jittered rim of a cap of half-angle 50° of the unit sphere, with its faces on the sphere.
fn cap(edges: usize) -> Rim {
    let alpha = 50f64.to_radians();
    let on_sphere = |t: f64, a: f64| DVec3::new(a.sin() * t.cos(), a.sin() * t.sin(), a.cos());
    let step = TAU / edges as f64;
    let jitter = |i: usize| 0.2 * step * (7.1 * i as f64).sin();
    Rim {
        points: (0..edges)
            .map(|i| on_sphere(step * i as f64 + jitter(i), alpha + 0.5 * jitter(3 * i)))
            .collect(),
        opposite: (0..edges)
            .map(|i| on_sphere(step * (i as f64 + 0.5), alpha + step))
            .collect(),
        forbidden: Vec::new(),
    }
}

/// A rim with two turns around a torus, which overlaps itself in every projection.
fn coil(edges: usize) -> Rim {
    let at = |i: usize, out: f64| {
        let t = TAU * i as f64 / edges as f64;
        let r = 1.0 + (0.35 + out) * t.cos();
        DVec3::new(
            r * (2.0 * t).cos(),
            r * (2.0 * t).sin(),
            (0.35 + out) * t.sin(),
        )
    };
    Rim {
        points: (0..edges).map(|i| at(i, 0.0)).collect(),
        opposite: (0..edges).map(|i| at(i, 0.02)).collect(),
        forbidden: Vec::new(),
    }
}

/// A strip of two rows of vertices around the patch, so that the rim's rows of L are complete.
fn with_strip(rim: &Rim, patch: &Patch) -> (Topology, Vec<DVec3>, Vec<VertexId>) {
    let n = rim.points.len();
    let mut points = patch.points.clone();
    let interior = (n..points.len()).map(VertexId::from).collect();
    let first = points.len() as u32;
    points.extend(&rim.opposite);
    let mut triangles = patch.triangles.clone();
    for i in 0..n as u32 {
        let next = (i + 1) % n as u32;
        triangles.push([next, i, first + i]);
        triangles.push([next, first + i, first + next]);
    }
    let topology = Topology::from_triangles(points.len(), &triangles).expect("a manifold");
    (topology, points, interior)
}

fn patches(c: &mut Criterion) {
    let options = PatchOptions::default();
    for edges in [30, 61, 108, 218, 669] {
        let rim = cap(edges);
        c.bench_function(&format!("fill cap {edges}"), |b| {
            b.iter(|| fill(black_box(&rim), options));
        });
        let patch = fill(&rim, options).expect("a sound rim");
        let (topology, points, interior) = with_strip(&rim, &patch);
        let mut moved = points.clone();
        c.bench_function(
            &format!("warm start cap {edges} ({} vertices)", interior.len()),
            |b| {
                b.iter(|| {
                    moved.copy_from_slice(&points);
                    warm_start(&topology, &mut moved, &interior)
                });
            },
        );
    }
    let coarse = PatchOptions { density: 0.05 };
    for edges in [120, 5000] {
        let rim = coil(edges);
        let options = if edges > 1000 { coarse } else { options };
        c.bench_function(&format!("fill coil {edges}"), |b| {
            b.iter(|| fill(black_box(&rim), options));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = patches
}
criterion_main!(benches);
