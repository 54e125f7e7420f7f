//! One step of each scheme on the same cap of a sphere, and the GMRES iterations of the mixed
//! scheme at small and large time steps.

use std::collections::BTreeMap;
use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use meniscus::energy::Energy;
use meniscus::mesh::{DVec3, Topology, VertexId};
use meniscus::solver::{
    Flow, FlowOptions, FlowProblem, LinearSolver, MixedFlow, Mode, Scheme, Tau,
};

/// Number of splits of the octahedron, and polar angle of the rim in degrees: 1,100 and 4,600
/// interior vertices.
const CAPS: [(usize, f64); 2] = [(5, 62.0), (6, 64.0)];
const TAUS: [f64; 4] = [1e-6, 1e-5, 1e-3, 0.1];

/// The split octahedron, projected to the unit sphere.
fn sphere(levels: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points: Vec<DVec3> = [DVec3::X, DVec3::Y, DVec3::Z]
        .iter()
        .flat_map(|&p| [p, -p])
        .collect();
    let upper = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]];
    let lower = upper.map(|[a, b, _]| [b, a, 5]);
    let mut faces: Vec<[u32; 3]> = upper.into_iter().chain(lower).collect();
    for _ in 0..levels {
        let mut middle = BTreeMap::new();
        let mut finer = Vec::with_capacity(4 * faces.len());
        for f in &faces {
            let m: [u32; 3] = std::array::from_fn(|i| {
                let (a, b) = (f[i], f[(i + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            finer.extend([
                [f[0], m[0], m[2]],
                [m[0], f[1], m[1]],
                [m[2], m[1], f[2]],
                m,
            ]);
        }
        faces = finer;
    }
    (points, faces)
}

/// A cap after the warm start.
fn cap((levels, degrees): (usize, f64)) -> FlowProblem {
    let (mut points, faces) = sphere(levels);
    let limit = degrees.to_radians().cos();
    let interior: Vec<u32> = (0..points.len() as u32)
        .filter(|&v| points[v as usize].z > limit)
        .collect();
    let topology = Topology::from_triangles(points.len(), &faces).expect("sphere");
    let ids: Vec<VertexId> = interior.iter().map(|&v| VertexId(v)).collect();
    meniscus::patch::warm_start(&topology, &mut points, &ids).expect("rim around");
    FlowProblem::new(&points, &faces, &interior, degrees.to_radians().sin()).expect("cap")
}

fn energy(text: &str) -> Energy {
    Energy::parse(text, &BTreeMap::new()).expect("known energy")
}

fn iterations() {
    println!("GMRES iterations to 1e-10 at tau = {TAUS:?}");
    for size in CAPS {
        let problem = cap(size);
        for f in ["H^2", "H^2+K^2", "k1^4+k2^4"] {
            let counts = TAUS.map(|tau| {
                let linear = LinearSolver::default();
                let mut flow = MixedFlow::new(&problem, &energy(f), linear, false).expect("start");
                let report = flow.attempt(tau).linear.expect("GMRES");
                (report.iterations, report.converged)
            });
            println!("{} vertices, {f}: {counts:?}", problem.interior().len());
        }
    }
}

fn one_step(c: &mut Criterion) {
    iterations();
    for size in CAPS {
        let problem = cap(size);
        let mut group = c.benchmark_group(format!("step/{}", problem.interior().len()));
        group.sample_size(10);
        for (name, scheme) in [
            ("normal", Scheme::Normal),
            ("mixed", Scheme::Mixed),
            ("mixed corrected", Scheme::MixedCorrected),
        ] {
            group.bench_function(name, |b| {
                b.iter_batched(
                    || {
                        let mut options = FlowOptions::new(energy("H^2"));
                        options.scheme = scheme;
                        options.mode = Mode::Flow;
                        options.tau = Tau::Fixed(1e-3);
                        Flow::new(problem.clone(), options).expect("start")
                    },
                    |mut flow| black_box(flow.step().expect("step")),
                    BatchSize::PerIteration,
                );
            });
        }
        group.finish();
    }
}

criterion_group!(benches, one_step);
criterion_main!(benches);
