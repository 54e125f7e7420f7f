//! Whole fills without files, for holes of increasing size in a sphere.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use meniscus::fill::{FillOptions, fill_rim_sets, flow_problem};
use meniscus::mesh::{BoundaryLoop, DVec3, Mesh, boundary_loops};
use meniscus::shapes::{self, Hole, HoleShape};
use meniscus::solver::{Flow, FlowOptions, Mode};

/// A unit sphere without a cap of half-angle 50°, which had about `missing` vertices.
fn sphere_with_hole(missing: usize) -> Mesh {
    // the cap is 18 % of the sphere
    let hole = Hole {
        centre: DVec3::Z,
        shape: HoleShape::Disc {
            radius: 50f64.to_radians(),
        },
        turn: 0.0,
        seed: 1,
    };
    let (positions, triangles) = shapes::cut_holes(&shapes::sphere(missing * 100 / 18, 7), &[hole]);
    Mesh::from_triangles(positions, &triangles).expect("sphere")
}

fn fills(c: &mut Criterion) {
    let mut group = c.benchmark_group("fill");
    group.sample_size(10);
    for missing in [200, 1000, 5000, 20_000] {
        let mesh = sphere_with_hole(missing);
        let loops = boundary_loops(&mesh);
        let targets: Vec<Vec<&BoundaryLoop>> = loops.iter().map(|one| vec![one]).collect();
        group.throughput(Throughput::Elements(missing as u64));
        group.bench_function(BenchmarkId::from_parameter(missing), |b| {
            b.iter(|| {
                fill_rim_sets(
                    black_box(&mesh),
                    &targets,
                    &FillOptions::default(),
                    &|_, _| true,
                )
            });
        });
    }
    group.finish();
}

/// Set-up of a flow, and single steps in true time (one assembly and factorization each).
fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("flow");
    group.sample_size(10);
    for missing in [1000, 5000] {
        let mesh = sphere_with_hole(missing);
        let loops = boundary_loops(&mesh);
        let options = FillOptions::default();
        let problem = flow_problem(&mesh, &loops[0], &options);
        let problem = problem.expect("a start").expect("new vertices");
        let mut timed = FlowOptions::new(options.flow.energy.clone());
        timed.mode = Mode::Flow;
        group.bench_function(BenchmarkId::new("set-up", missing), |b| {
            b.iter(|| Flow::new(problem.clone(), timed.clone()));
        });
        group.bench_function(BenchmarkId::new("set-up and step", missing), |b| {
            b.iter(|| {
                let mut flow = Flow::new(problem.clone(), timed.clone()).expect("start");
                flow.step().expect("step")
            });
        });
    }
    group.finish();
}

criterion_group!(benches, fills, steps);
criterion_main!(benches);
