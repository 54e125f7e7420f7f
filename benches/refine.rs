//! The cost of each level of a refinement: time, its ratio to the previous level, time per
//! attempted step and vertex, peak memory.

use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use meniscus::mesh::Mesh;
use meniscus::refine::{self, LevelReport, RefineControls, RefineEvent};
use meniscus::runner::Recording;
use meniscus::shapes::icosphere;

/// Levels of the table, and those that are repeated.
const LEVELS: usize = 4;
const REPEATED: usize = 3;

/// A sphere of 252 vertices with bumps of a sixth of its radius.
fn bumpy_sphere() -> Arc<Mesh> {
    let (mut positions, triangles) = icosphere(5);
    for p in &mut positions {
        let bump = (4.0 * p.x).sin() * (5.0 * p.y).cos() + (3.0 * p.z + p.x).sin();
        *p *= 1.0 + bump / 12.0;
    }
    Arc::new(Mesh::from_triangles(positions, &triangles).expect("sphere"))
}

/// Refines with the defaults of the command, for [`LEVELS`] levels, but omits those after `last`.
/// The planned number of levels determines how many quadrature points the first level has.
fn refine(mesh: &Arc<Mesh>, last: usize) -> Vec<LevelReport> {
    let controls = RefineControls {
        levels: LEVELS,
        ..RefineControls::default()
    };
    let mut go_on = |event| !matches!(event, RefineEvent::LevelDone(l) if l.level >= last);
    let refined = refine::refine(
        Arc::clone(mesh),
        controls.into(),
        &Recording::default(),
        &mut go_on,
    );
    refined.expect("refined").0.levels
}

fn table(mesh: &Arc<Mesh>) {
    println!("level  vertices  attempts  seconds  ratio  µs per attempt and vertex  MiB");
    let mut before = f64::NAN;
    for l in refine(mesh, LEVELS) {
        let attempts = l.steps + l.rejected;
        println!(
            "{:5} {:9} {attempts:9} {:8.2} {:6.2} {:26.1} {:4}",
            l.level,
            l.vertices,
            l.seconds,
            l.seconds / before,
            1e6 * l.seconds / (attempts.max(1) * l.vertices) as f64,
            l.peak_memory >> 20
        );
        before = l.seconds;
    }
}

fn levels(c: &mut Criterion) {
    let mesh = bumpy_sphere();
    table(&mesh);
    let mut group = c.benchmark_group("refine/level");
    group.sample_size(10);
    for level in 1..=REPEATED {
        group.bench_function(BenchmarkId::from_parameter(level), |b| {
            b.iter_custom(|times| {
                let seconds = |_| refine(&mesh, level).last().map_or(0.0, |l| l.seconds);
                Duration::from_secs_f64((0..times).map(seconds).sum())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, levels);
criterion_main!(benches);
