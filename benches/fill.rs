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

/// A rough sphere with so many holes of about nine vertices, spread evenly, and their loops. The
/// support regions meet, so all holes form one group.
fn sphere_with_many_holes(count: usize) -> Mesh {
    let holes: Vec<Hole> = (0..count)
        .map(|i| {
            let z = 1.0 - (2 * i + 1) as f64 / count as f64;
            // the golden angle
            let (sin, cos) = (2.399_963_229_728_653 * i as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Hole {
                centre: DVec3::new(r * cos, r * sin, z),
                shape: HoleShape::Disc {
                    radius: 0.85 / (count as f64).sqrt(),
                },
                turn: 0.0,
                seed: 1,
            }
        })
        .collect();
    let (mut positions, triangles) = shapes::cut_holes(&shapes::sphere(50 * count, 7), &holes);
    for (i, p) in positions.iter_mut().enumerate() {
        *p *= 1.0 + 1e-2 / (count as f64).sqrt() * (1e3 * i as f64).sin();
    }
    Mesh::from_triangles(positions, &triangles).expect("sphere")
}

/// Many holes: the time per hole should not depend on their number. Prints the share of the
/// prediction and of the check for soundness in the time of all stages.
fn many_holes(c: &mut Criterion) {
    let mut group = c.benchmark_group("many holes");
    group.sample_size(10);
    for count in [100, 1000] {
        let mesh = sphere_with_many_holes(count);
        let loops = boundary_loops(&mesh);
        let targets: Vec<Vec<&BoundaryLoop>> = loops.iter().map(|one| vec![one]).collect();
        let run = || {
            let options = FillOptions::default();
            fill_rim_sets(black_box(&mesh), &targets, &options, &|_, _| true)
        };
        let filled = run().expect("filled");
        let timings = filled.groups.iter().flatten().map(|group| group.timings);
        let patches = filled.holes.iter().map(|hole| hole.patch_ms).sum::<f64>();
        let (mut all, mut prediction, mut soundness) = (patches, 0.0, 0.0);
        for timings in timings {
            all += timings.total();
            prediction += timings.prediction;
            soundness += timings.soundness;
        }
        println!(
            "{} holes in {} groups: prediction {:.0} %, soundness {:.0} %",
            filled.holes.len(),
            filled.groups.len(),
            100.0 * prediction / all,
            100.0 * soundness / all,
        );
        group.throughput(Throughput::Elements(loops.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |b| b.iter(run));
    }
    group.finish();
}

criterion_group!(benches, fills, steps, many_holes);
criterion_main!(benches);
