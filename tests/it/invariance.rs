//! Fills do not depend on units, place or orientation, nor on the density beyond their accuracy.

use glam::{DMat3, DQuat};
use meniscus::energy::Energy;
use meniscus::fill::{FillOptions, fill_rim_sets, flow_problem};
use meniscus::mesh::{DVec3, Mesh, boundary_loops};
use meniscus::shapes::{self, Hole, HoleShape, TriangleMesh};
use meniscus::solver::{End, Flow, FlowOptions, FlowProblem, Scheme};
use std::collections::BTreeMap;

fn holed(radius: f64, seed: u64) -> Mesh {
    let (positions, triangles) = shapes::cut_holes(
        &shapes::sphere(1500, seed),
        &[Hole {
            centre: DVec3::new(0.3, -0.2, 1.0),
            shape: HoleShape::Ragged { radius },
            turn: 0.4,
            seed,
        }],
    );
    Mesh::from_triangles(positions, &triangles).expect("sphere")
}

/// The region of the first hole: local positions, triangles, interior vertices, hole radius.
struct Region {
    shape: TriangleMesh,
    interior: Vec<u32>,
    radius: f64,
}

fn region() -> Region {
    let mesh = holed(0.55, 5);
    let loops = boundary_loops(&mesh);
    let problem = flow_problem(&mesh, &loops[0], &FillOptions::default());
    let problem = problem.expect("a start").expect("new vertices");
    let centre = problem.centre();
    Region {
        shape: (
            problem.positions().iter().map(|&p| p + centre).collect(),
            problem.topology().triangles().collect(),
        ),
        interior: problem.interior().to_vec(),
        radius: problem.radius(),
    }
}

/// Interior positions after the flow, over `map` of the region scaled by `scale`.
fn flowed(
    region: &Region,
    scale: f64,
    map: impl Fn(DVec3) -> DVec3,
    energy: &str,
    scheme: Scheme,
) -> Vec<DVec3> {
    let positions: Vec<DVec3> = region.shape.0.iter().map(|&p| map(p)).collect();
    let problem = FlowProblem::new(
        &positions,
        &region.shape.1,
        &region.interior,
        region.radius * scale,
    )
    .expect("region");
    let energy = Energy::parse(energy, &BTreeMap::new()).expect("energy");
    let mut options = FlowOptions::new(energy);
    options.scheme = scheme;
    let mut flow = Flow::new(problem, options).expect("start");
    let outcome = flow.run(|_, _| true).expect("flow");
    assert_eq!(outcome.end, End::Converged);
    flow.problem().to_world(flow.positions())
}

fn worst(a: &[DVec3], b: &[DVec3], map: impl Fn(DVec3) -> DVec3) -> f64 {
    a.iter()
        .zip(b)
        .map(|(&p, &q)| map(p).distance(q))
        .fold(0.0, f64::max)
}

#[test]
fn scale_rotation_and_offset() {
    let region = region();
    // f in the units of the file: lengths times s, so coefficients of H² stay and of K² grow as s²
    for (plain, scaled) in [("H^2", "H^2"), ("H^2+0.01*K^2", "H^2+10000*K^2")] {
        let base = flowed(&region, 1.0, |p| p, plain, Scheme::Normal);
        let s = 1000.0;
        let big = flowed(&region, s, |p| p * s, scaled, Scheme::Normal);
        let error = worst(&base, &big, |p| p * s) / (region.radius * s);
        assert!(error < 1e-9, "{plain} scaled: {error:e}");

        let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -1.1, 2.3));
        let turned = flowed(&region, 1.0, |p| turn * p, plain, Scheme::Normal);
        let error = worst(&base, &turned, |p| turn * p) / region.radius;
        assert!(error < 1e-9, "{plain} rotated: {error:e}");

        // coordinates of 1e6 carry a rounding of 1e-10, and curvatures amplify it
        let offset = DVec3::new(1e6, -1e6, 1e6);
        let moved = flowed(&region, 1.0, |p| p + offset, plain, Scheme::Normal);
        let error = worst(&base, &moved, |p| p + offset) / region.radius;
        assert!(error < 1e-7, "{plain} moved: {error:e}");
    }
}

#[test]
fn turning_the_surface_over_changes_nothing_for_even_energies() {
    let region = region();
    let base = flowed(&region, 1.0, |p| p, "H^2", Scheme::Normal);
    let mut over = Region {
        shape: region.shape.clone(),
        interior: region.interior.clone(),
        radius: region.radius,
    };
    for t in &mut over.shape.1 {
        t.swap(1, 2);
    }
    let same = flowed(&over, 1.0, |p| p, "H^2", Scheme::Normal);
    let error = worst(&base, &same, |p| p) / region.radius;
    assert!(error < 1e-9, "{error:e}");
}

#[test]
fn two_densities_give_one_surface() {
    // a sphere: the true surface is known, so is the error of each density
    let mesh = holed(0.6, 9);
    let loops = boundary_loops(&mesh);
    let error = |density: f64| {
        let mut options = FillOptions::default();
        options.patch.density = density;
        let filled =
            fill_rim_sets(&mesh, &[vec![&loops[0]]], &options, &|_, _| true).expect("fill");
        assert!(filled.complete());
        let new = &filled.mesh.positions[mesh.vertex_count()..];
        let sum: f64 = new.iter().map(|p| (p.length() - 1.0).powi(2)).sum();
        ((sum / new.len() as f64).sqrt() / loops[0].radius, new.len())
    };
    let (coarse, few) = error(1.0);
    let (fine, many) = error(1.7);
    assert!(
        many as f64 > 2.2 * few as f64 && (many as f64) < 3.8 * few as f64,
        "{few} {many}"
    );
    // both are within the discretisation error of the input mesh, about (edge/radius of curvature)²
    assert!(coarse < 4e-3 && fine < 4e-3, "{coarse:e} {fine:e}");
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let mesh = holed(0.7, 11);
    let loops = boundary_loops(&mesh);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let filled = fill_rim_sets(
                &mesh,
                &[vec![&loops[0]]],
                &FillOptions::default(),
                &|_, _| true,
            );
            filled.expect("fill").mesh.positions
        })
    };
    let one = run(1);
    for threads in [2, 3, 7] {
        let other = run(threads);
        assert!(
            one.iter()
                .zip(&other)
                .all(|(a, b)| a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits)),
            "{threads} threads"
        );
    }
}
