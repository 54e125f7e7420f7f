//! Vector flows: exact solutions on the regular lattice, invariance, and the sphere.

use super::*;
use crate::energy::{Energy, Preset};
use crate::shapes;
use crate::solver::{End, Flow, FlowOptions, Mode};

const MODELS: [SurfaceModel; 2] = [SurfaceModel::Diffusion, SurfaceModel::G2];

fn options(surface: SurfaceModel) -> FlowOptions {
    let mut options = FlowOptions::new(Energy::preset(Preset::H2));
    options.surface = surface;
    options
}

/// The lattice of equilateral triangles with edges of 0.1 over [-1, 1]², lifted to `height`.
fn lattice(height: impl Fn(f64, f64) -> f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const SIDE: usize = 21;
    let at = |i: usize, j: usize| (i * SIDE + j) as u32;
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..SIDE {
        for j in 0..SIDE {
            let (i_, j_) = (i as f64 - 10.0, j as f64 - 10.0);
            let (x, y) = (0.1 * (j_ + 0.5 * i_), 0.1 * 0.75f64.sqrt() * i_);
            points.push(DVec3::new(x, y, height(x, y)));
            if i + 1 < SIDE && j + 1 < SIDE {
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }
    (points, triangles)
}

/// The vertices within 0.4 of the middle of the lattice.
fn middle(points: &[DVec3]) -> Vec<u32> {
    let is_inside = |v: &u32| points[*v as usize].truncate().length() < 0.4;
    (0..points.len() as u32).filter(is_inside).collect()
}

fn run(
    points: &[DVec3],
    triangles: &[[u32; 3]],
    interior: &[u32],
    options: FlowOptions,
) -> (Vec<DVec3>, Option<End>) {
    let problem = FlowProblem::new(points, triangles, interior, 0.4).expect("a problem");
    let mut flow = Flow::new(problem, options).expect("a flow");
    flow.run(|_, _| true).expect("steps");
    let centre = flow.problem().centre();
    let positions = flow.positions().iter().map(|&p| p + centre).collect();
    (positions, flow.end())
}

fn distance(a: &[DVec3], b: &[DVec3]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn polynomials_are_stationary_on_the_flat_lattice() {
    // Δ² annihilates cubic polynomials, Δ³ those of degree five; the discrete operators are exact on
    // them. Heights of 1e-5 change the metric by about 1e-10, and the surface by 1e-10 as well.
    let cubic = |x: f64, y: f64| 1e-5 * (x * x * x - 2.0 * x * y + y * y + x);
    let quintic = |x: f64, y: f64| 1e-5 * (x.powi(5) - 3.0 * x.powi(3) * y * y + y.powi(4) - x);
    let surfaces: [(_, &dyn Fn(f64, f64) -> f64); 3] = [
        (SurfaceModel::Diffusion, &cubic),
        (SurfaceModel::G2, &cubic),
        (SurfaceModel::G2, &quintic),
    ];
    for (model, height) in surfaces {
        let (points, triangles) = lattice(height);
        let interior = middle(&points);
        let mut start = points.clone();
        for &v in &interior {
            start[v as usize].z = 0.0;
        }
        assert!(distance(&start, &points) > 1e-6);
        let (found, end) = run(&start, &triangles, &interior, options(model));
        assert_eq!(end, Some(End::Converged));
        let error = distance(&found, &points);
        assert!(error < 1e-9, "{model:?}: {error:e}");
    }
    // order 4 does not keep a polynomial of degree four
    let (points, triangles) = lattice(|x, _| 1e-3 * x.powi(4));
    let interior = middle(&points);
    let (found, _) = run(
        &points,
        &triangles,
        &interior,
        options(SurfaceModel::Diffusion),
    );
    assert!(distance(&found, &points) > 1e-6);
}

#[test]
fn flows_commute_with_motions_and_scaling() {
    let (points, triangles) = lattice(|x, y| 0.3 * (2.0 * x).sin() * y);
    let interior = middle(&points);
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
    let map = |p: DVec3| 8.0 * (turn * p) + DVec3::new(3.0, -5.0, 1.0);
    let moved: Vec<DVec3> = points.iter().map(|&p| map(p)).collect();
    for model in MODELS {
        for tension in [0.0, 10.0] {
            let mut options = options(model);
            options.tension = tension;
            let (expected, _) = run(&points, &triangles, &interior, options.clone());
            let problem = FlowProblem::new(&moved, &triangles, &interior, 3.2).expect("a problem");
            let mut flow = Flow::new(problem, options).expect("a flow");
            flow.run(|_, _| true).expect("steps");
            let centre = flow.problem().centre();
            let found: Vec<DVec3> = flow.positions().iter().map(|&p| p + centre).collect();
            let expected: Vec<DVec3> = expected.into_iter().map(map).collect();
            // convergence ends at 1e-6 of the radius
            let error = distance(&found, &expected);
            assert!(error < 1e-5, "{model:?} {tension}: {error:e}");
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_energy() {
    let (points, triangles) = lattice(|x, y| 0.3 * (3.0 * x).sin() * y);
    let interior = middle(&points);
    for (model, tension) in [
        (SurfaceModel::Diffusion, 0.0),
        (SurfaceModel::Diffusion, 5.0),
        (SurfaceModel::G2, 5.0),
    ] {
        let problem = FlowProblem::new(&points, &triangles, &interior, 0.4).expect("a problem");
        let mut flow = DiffusionFlow::new(&problem, model, tension).expect("a flow");
        let n = flow.unknowns.len();
        let before = flow.state.energy.value;
        let gradient = flow.state.gradient.clone();
        let shift: Vec<DVec3> = (0..n)
            .map(|i| {
                1e-3 * DVec3::new(
                    (i as f64).sin(),
                    (2.0 * i as f64).cos(),
                    (0.7 * i as f64).sin(),
                )
            })
            .collect();
        // quadratic: the difference is the mean of the gradients at both ends
        flow.follow(&shift);
        let mean = |i: usize| 0.5 * (gradient[i] + flow.state.gradient[i]);
        let expected: f64 = (0..n).map(|i| mean(i).dot(shift[i])).sum();
        let change = flow.state.energy.value - before;
        assert!(
            (change - expected).abs() < 1e-10 * change.abs(),
            "{change} {expected}"
        );
        // and the energy in the same metric agrees with a direct sum
        let metric = Metric::new(problem.topology(), problem.positions());
        let mut x = problem.positions().to_vec();
        for (&v, d) in flow.unknowns.vertex.iter().zip(&shift) {
            x[v as usize] += *d;
        }
        let mut direct = 0.0;
        flow.squares
            .for_each(&problem, &metric, |e, weight, c, constant| {
                let vertices = flow.squares.vertices.of(e);
                let moving = c.iter().zip(vertices).map(|(c, &v)| *c * x[v as usize]);
                let value = constant + moving.sum::<DVec3>();
                direct += 0.5 * weight * value.length_squared();
            });
        let energy = flow.state.energy.value;
        assert!(
            (direct - energy).abs() < 1e-10 * direct,
            "{direct} {energy}"
        );
    }
}

#[test]
fn a_step_in_a_fixed_metric_never_raises_the_energy() {
    let (points, triangles) = lattice(|x, y| 0.3 * (3.0 * x).sin() * y);
    let interior = middle(&points);
    for model in MODELS {
        let problem = FlowProblem::new(&points, &triangles, &interior, 0.4).expect("a problem");
        let mut flow = DiffusionFlow::new(&problem, model, 1.0).expect("a flow");
        flow.updates_left = 0;
        let mut last = flow.state.energy.value;
        for k in -6..3 {
            let tau = 10f64.powi(k) * model.natural_time(0.4);
            let request = StepRequest {
                tau,
                next_tau: tau,
                may_freeze: false,
            };
            assert!(flow.attempt(&request).is_accepted());
            let now = flow.state.energy.value;
            assert!(now <= last, "{model:?} {k}: {now} {last}");
            last = now;
        }
    }
}

#[test]
fn g2_restores_a_cap_of_the_sphere_better_than_diffusion() {
    let (positions, triangles) = shapes::sphere(2000, 1);
    let interior: Vec<u32> = (0..positions.len() as u32)
        .filter(|&v| positions[v as usize].z > 0.8)
        .collect();
    let error = |model: SurfaceModel| {
        let problem = FlowProblem::new(&positions, &triangles, &interior, 0.6).expect("a problem");
        let mut flow = Flow::new(problem, options(model)).expect("a flow");
        flow.run(|_, _| true).expect("steps");
        let world = flow.problem().to_world(flow.positions());
        let squares = world.iter().map(|p| (p.length() - 1.0).powi(2));
        (squares.sum::<f64>() / interior.len() as f64).sqrt()
    };
    let (diffusion, g2) = MODELS.map(error).into();
    assert!(diffusion < 0.01, "{diffusion}");
    assert!(g2 < 0.2 * diffusion, "{g2} {diffusion}");
}

#[test]
fn flow_mode_takes_many_small_steps_to_the_same_surface() {
    let (points, triangles) = lattice(|x, y| 1e-4 * (3.0 * x).sin() * y);
    let interior = middle(&points);
    let mut start = points.clone();
    for &v in &interior {
        start[v as usize].z = 0.0;
    }
    for model in MODELS {
        let fast = run(&start, &triangles, &interior, options(model)).0;
        let mut watched = options(model);
        watched.mode = Mode::Flow;
        let (slow, end) = run(&start, &triangles, &interior, watched);
        assert_eq!(end, Some(End::Converged));
        let error = distance(&fast, &slow);
        assert!(
            error < 1e-6 * distance(&start, &slow).max(1.0),
            "{model:?}: {error:e}"
        );
    }
}

/// A bumpy height field, its triangles, the same field shifted, and with a flat middle at a height.
fn bumpy(height: f64) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<DVec3>, Vec<DVec3>) {
    let (points, triangles) = lattice(|x, y| 0.1 * (9.0 * x).sin() * (7.0 * y + 1.0).cos());
    let shifted = points.iter().map(|&p| p + DVec3::new(5.0, -3.0, 2.0));
    let shifted = shifted.collect();
    let mut flat = points.clone();
    for v in middle(&points) {
        flat[v as usize].z = height;
    }
    (points, triangles, shifted, flat)
}

/// The result with the reference `shape` of all vertices for which `is_known`.
fn with_reference(
    start: &[DVec3],
    triangles: &[[u32; 3]],
    shape: &[DVec3],
    share: f64,
    is_known: impl Fn(usize) -> bool,
) -> Vec<DVec3> {
    let interior = middle(start);
    let problem = FlowProblem::new(start, triangles, &interior, 0.4).expect("a problem");
    let at = |(v, &p): (usize, &DVec3)| (v as u32, is_known(v).then_some(p));
    let positions = shape.iter().enumerate().map(at).collect();
    let problem = problem.with_references(vec![Reference { positions, share }]);
    let mut flow = Flow::new(problem, options(SurfaceModel::G2)).expect("a flow");
    flow.run(|_, _| true).expect("steps");
    let centre = flow.problem().centre();
    flow.positions().iter().map(|&p| p + centre).collect()
}

#[test]
fn a_shifted_copy_as_reference_restores_the_surface() {
    let (points, triangles, shifted, start) = bumpy(0.3);
    let interior = middle(&points);
    let (plain, _) = run(&start, &triangles, &interior, options(SurfaceModel::G2));
    assert!(distance(&plain, &points) > 0.05);
    let whole = with_reference(&start, &triangles, &shifted, 1.0, |_| true);
    // the metric of the result is that of a nearby surface, which does not matter
    assert!(
        distance(&whole, &points) < 1e-6,
        "{}",
        distance(&whole, &points)
    );
    // no share, no effect
    let none = with_reference(&start, &triangles, &shifted, 0.0, |_| true);
    assert!(distance(&none, &plain) < 1e-9);
    // a reference without positions says nothing
    let nothing = with_reference(&start, &triangles, &shifted, 1.0, |_| false);
    assert!(distance(&nothing, &plain) < 1e-6);
}

#[test]
fn a_part_of_a_reference_restores_that_part() {
    let (points, triangles, shifted, start) = bumpy(0.0);
    let interior = middle(&points);
    let is_known = |v: usize| points[v].x < 0.15;
    let part = with_reference(&start, &triangles, &shifted, 1.0, is_known);
    let (plain, _) = run(&start, &triangles, &interior, options(SurfaceModel::G2));
    let known = || {
        interior
            .iter()
            .map(|&v| v as usize)
            .filter(|&v| points[v].x < -0.05)
    };
    let farthest = |from: &[DVec3]| {
        let distances = known().map(|v| from[v].distance(points[v]));
        distances.fold(0.0, f64::max)
    };
    let [part, plain] = [&part, &plain].map(|positions| farthest(positions));
    // measured: 0.14
    assert!(part < 0.2 * plain, "{part} {plain}");
}

#[test]
fn a_kept_metric_is_that_of_the_start() {
    let (_, triangles, _, start) = bumpy(0.3);
    let interior = middle(&start);
    let problem = FlowProblem::new(&start, &triangles, &interior, 0.4).expect("a problem");
    let energies = |problem: FlowProblem| {
        let mut flow = Flow::new(problem, options(SurfaceModel::G2)).expect("a flow");
        let mut energies = vec![flow.energy().value];
        flow.run(|_, record| {
            energies.push(record.energy);
            true
        })
        .expect("steps");
        assert_eq!(flow.end(), Some(End::Converged));
        energies
    };
    let rises = |energies: &[f64]| {
        let pairs = energies.windows(2);
        pairs
            .filter(|pair| pair[1] > pair[0] * (1.0 + 1e-9))
            .count()
    };
    // only an update of the metric can raise the energy
    assert_eq!(rises(&energies(problem.clone())), 1);
    assert_eq!(rises(&energies(problem.keeping_metric())), 0);
}

/// With a free curvature at the rim, that of the surroundings has no influence.
#[test]
fn a_rim_with_free_curvature_continues_normals_only() {
    use crate::solver::test_surfaces::distance_from_paraboloid;
    let mut options = options(SurfaceModel::G2);
    options.tau = crate::solver::Tau::Fixed(1e9);
    options.max_steps = 20;
    let [free, given] = [true, false].map(|is| distance_from_paraboloid(options.clone(), is));
    assert!(free < 1e-6, "{free:e}");
    assert!(given > 0.01, "{given:e}");
}
