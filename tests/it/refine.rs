//! Refinement of coarse closed meshes: known minima, vertices kept, bad triangles; parts of meshes.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

use meniscus::energy::{Energy, Preset};
use meniscus::mesh::{DVec3, Mesh, check_mesh, folded_edges, self_intersections};
use meniscus::random::SplitMix;
use meniscus::refine::{
    Hold, Method, RefineControls, RefineOptions, Refined, mesh_adapted_flow, refine, surface_energy,
};
use meniscus::runner::Recording;
use meniscus::shapes::{graph, icosphere};
use meniscus::subdivision::limit_position;

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Mesh {
    let positions: Vec<DVec3> = positions.iter().map(|&p| DVec3::from_array(p)).collect();
    Mesh::from_triangles(positions, triangles).expect("closed")
}

fn octahedron() -> Mesh {
    let p = [
        [1., 0., 0.],
        [-1., 0., 0.],
        [0., 1., 0.],
        [0., -1., 0.],
        [0., 0., 1.],
        [0., 0., -1.],
    ];
    let t = [
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    mesh(&p, &t)
}

fn icosahedron() -> Mesh {
    let (positions, triangles) = icosphere(1);
    Mesh::from_triangles(positions, &triangles).expect("closed")
}

/// Options of so many levels by `H²`.
fn bending(levels: usize) -> RefineOptions {
    let controls = RefineControls {
        levels,
        energy: Some("H^2".into()),
        steps: 200,
        ..RefineControls::default()
    };
    controls.into()
}

/// Energy of the limit surface through the input vertices after three levels.
fn refined(mesh: &Mesh) -> f64 {
    let given = mesh.positions.clone();
    let refined = run(mesh, &bending(3));
    check_mesh(&refined.mesh).expect("sound");
    assert_eq!(refined.mesh.positions[..given.len()], given);
    let control = &refined.control.positions;
    for (v, p) in given.iter().enumerate() {
        let at = limit_position(&refined.mesh.topology, control, v.into());
        assert!(
            at.distance(*p) < 1e-12,
            "vertex {v} is off by {}",
            at.distance(*p)
        );
    }
    surface_energy(&refined.mesh.topology, control, &Energy::preset(Preset::H2))
}

#[test]
fn an_octahedron_and_an_icosahedron_become_spheres() {
    // 4 pi is the minimum energy of a sphere; the quadrature error is 1e-5 (measured)
    let least = 4.0 * PI - 1e-5;
    let octahedron = refined(&octahedron());
    assert!((least..=12.570).contains(&octahedron), "{octahedron}");
    let icosahedron = refined(&icosahedron());
    assert!((least..=12.5672).contains(&icosahedron), "{icosahedron}");
}

/// A sphere of 80 faces, and options to refine the chosen ones twice.
fn ball_and_region(chosen: impl Fn(usize) -> bool) -> (Mesh, RefineOptions) {
    let (positions, triangles) = icosphere(2);
    let ball = Mesh::from_triangles(positions, &triangles).expect("closed");
    let mut options = bending(2);
    options.region = Some((0..ball.face_count()).map(chosen).collect());
    (ball, options)
}

fn run(mesh: &Mesh, options: &RefineOptions) -> Refined {
    let (mesh, options) = (Arc::new(mesh.clone()), options.clone());
    let refined = refine(mesh, options, &Recording::default(), &mut |_| true);
    refined.expect("refined").0
}

#[test]
fn a_region_is_refined_and_nothing_else() {
    let cap = |f: usize| (10..30).contains(&f);
    for method in [Method::Pde, Method::Butterfly, Method::Loop] {
        let (ball, mut options) = ball_and_region(cap);
        options.controls.method = method;
        let mesh = run(&ball, &options).mesh;
        // conforming: closed as before, every edge with two faces
        check_mesh(&mesh).expect("sound");
        assert!(mesh.topology.boundary_loops().is_empty());
        assert!(mesh.face_count() > ball.face_count() + 20 * 3);
        if method != Method::Loop {
            assert_eq!(mesh.positions[..ball.vertex_count()], ball.positions);
        }
        // vertices without a face of the region, and the faces among them, do not change
        let touched: BTreeSet<u32> = (0..ball.face_count())
            .filter(|&f| cap(f))
            .flat_map(|f| ball.topology.face_vertices(f.into()).map(|v| v.0))
            .collect();
        let faces: BTreeSet<[u32; 3]> = mesh.topology.triangles().collect();
        let far = |t: &[u32; 3]| t.iter().all(|v| !touched.contains(v));
        for t in ball.topology.triangles().filter(far) {
            assert!(faces.contains(&t));
            for v in t {
                assert_eq!(mesh.positions[v as usize], ball.positions[v as usize]);
            }
        }
        // those beside the region are not worse than a halved one
        for t in mesh.topology.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            for (p, q, r) in [(a, b, c), (b, c, a), (c, a, b)] {
                let angle = (q - p).angle_between(r - p).to_degrees();
                assert!((20.0..130.0).contains(&angle), "{method:?}: {angle}");
            }
        }
        // the distance of new vertices from the sphere depends on the method; H² alone bulges
        let off = |p: &DVec3| (p.length() - 1.0).abs();
        let most = match method {
            Method::Pde => 0.02,
            Method::Butterfly => 0.01,
            Method::Loop => 0.09,
        };
        assert!(mesh.positions.iter().all(|p| off(p) < most), "{method:?}");
    }
}

#[test]
fn a_region_of_everything_is_no_region() {
    for hold in [Hold::Previous, Hold::Given] {
        let (ball, mut everything) = ball_and_region(|_| true);
        everything.controls.hold = hold;
        let mut none = everything.clone();
        none.region = None;
        let [with, without] = [&everything, &none].map(|o| run(&ball, o));
        assert_eq!(with.mesh, without.mesh);
        assert_eq!(with.control, without.control);
    }
}

#[test]
fn a_region_may_reach_the_boundary() {
    let (positions, triangles) = graph(2.0, 6, |x, y| 0.3 * (x * x - y * y), 2);
    let sheet = Mesh::from_triangles(positions, &triangles).expect("open");
    let mut options = bending(2);
    for first in [0, sheet.face_count() / 2] {
        let chosen = (0..sheet.face_count()).map(|f| f >= first && f < first + 3);
        options.region = Some(chosen.collect());
        let mesh = run(&sheet, &options).mesh;
        check_mesh(&mesh).expect("sound");
        assert_eq!(mesh.topology.boundary_loops().len(), 1);
        assert_eq!(mesh.positions[..sheet.vertex_count()], sheet.positions);
    }
}

/// A ball with spikes, dents and slivers. Every vertex is displaced by up to a third of the radius,
/// some of them along the surface by most of an edge.
fn crumpled(seed: u64) -> Mesh {
    let (mut positions, triangles) = icosphere(2);
    let mut random = SplitMix::new(seed);
    for p in &mut positions {
        *p *= random.range(0.7, 1.3);
        *p += 0.1 * random.direction();
    }
    Mesh::from_triangles(positions, &triangles).expect("closed")
}

/// Coarse meshes with bad triangles: the surface has no folds and no more self-intersections than
/// the input. The energy decreases and is continuous between levels, which are all integrated at
/// the same surface points.
#[test]
fn energies_fall_over_all_levels_and_nothing_folds() {
    for seed in 1..3 {
        let given = crumpled(seed);
        for energy in [None, Some("H^2".into())] {
            let mut options = bending(2);
            options.controls.energy = energy;
            let refined = run(&given, &options);
            let mut last = f64::INFINITY;
            for level in &refined.levels {
                assert!(level.energy_start <= last * (1.0 + 1e-12), "{level:?}");
                assert!(level.energy_end <= level.energy_start, "{level:?}");
                assert!(
                    !last.is_finite() || level.energy_start > last * (1.0 - 1e-12),
                    "{level:?} after {last}"
                );
                assert!(
                    ["converged", "stuck"].contains(&level.end_name()),
                    "{level:?}"
                );
                last = level.energy_end;
            }
            let mesh = &refined.mesh;
            let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
            let of_input: Vec<[u32; 3]> = given.topology.triangles().collect();
            let before = self_intersections(&given.positions, &of_input, None, 100).len();
            let after = self_intersections(&mesh.positions, &triangles, None, 100).len();
            assert!(
                after <= before,
                "seed {seed}: {after} crossings, {before} given"
            );
            let folds = folded_edges(&mesh.positions, &mesh.topology, 150_f64.to_radians());
            assert!(folds.is_empty(), "seed {seed}: {folds:?}");
        }
    }
}

/// The natural energy has the units of the mesh: another scale, the same shape.
#[test]
fn the_natural_energy_goes_with_the_scale() {
    let given = crumpled(7);
    let (energy, tension) = mesh_adapted_flow(&given);
    let mut large = given.clone();
    for p in &mut large.positions {
        *p *= 8.0; // exact in binary
    }
    let (scaled, scaled_tension) = mesh_adapted_flow(&large);
    assert_eq!(scaled.params()["c"], energy.params()["c"] / 8.0);
    // f is a curvature, and the tension counts in f over the squared radius
    assert!((scaled_tension / (8.0 * tension) - 1.0).abs() < 1e-12);
    let refined = |mesh: &Mesh| {
        let mut options = bending(1);
        (options.controls.energy, options.controls.steps) = (None, 5);
        run(mesh, &options).mesh.positions
    };
    let (small, big) = (refined(&given), refined(&large));
    for (p, q) in small.iter().zip(&big) {
        assert!((*p - *q / 8.0).length() < 1e-9, "{p} {q}");
    }
}

/// Each level reports the peak memory of the process.
#[test]
fn the_peak_of_memory_only_rises() {
    let (ball, options) = ball_and_region(|_| true);
    let levels = run(&ball, &options).levels;
    let peaks: Vec<u64> = levels.iter().map(|l| l.peak_memory).collect();
    assert!(peaks.is_sorted(), "{peaks:?}");
    if cfg!(target_os = "linux") {
        assert!(peaks[0] > 1 << 20, "{peaks:?}");
    }
}
