//! Scheme A, the mixed finite elements, on caps of a sphere and on the closed sphere.

use std::collections::BTreeMap;

use meniscus::energy::Energy;
use meniscus::mesh::{DVec3, Topology, VertexId};
use meniscus::solver::{
    End, Flow, FlowOptions, FlowProblem, LinearSolver, MixedFlow, Mode, Scheme, Stepper,
};

use crate::common::icosphere::{flowed_radius, icosphere};

const REFERENCE: &str = include_str!("../data/sphere_cap.json");

fn energy(text: &str) -> Energy {
    Energy::parse(text, &BTreeMap::new()).expect("known energy")
}

/// The cap z > cos 40° of the unit sphere.
struct Cap {
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    interior: Vec<u32>,
    radius: f64,
}

impl Cap {
    fn new() -> Self {
        let (points, faces) = icosphere();
        let limit = 40f64.to_radians().cos();
        let interior = (0..points.len() as u32)
            .filter(|&i| points[i as usize].z > limit)
            .collect();
        Self {
            points,
            faces,
            interior,
            radius: 40f64.to_radians().sin(),
        }
    }

    /// Interior in the plane of the rim.
    fn flat() -> Self {
        let mut cap = Self::new();
        for &v in &cap.interior {
            cap.points[v as usize].z = 40f64.to_radians().cos();
        }
        cap
    }

    /// Interior from the uniform graph Laplacian.
    fn harmonic() -> Self {
        let mut cap = Self::new();
        let topology = Topology::from_triangles(cap.points.len(), &cap.faces).expect("sphere");
        for _ in 0..3000 {
            for &v in &cap.interior {
                let ring: Vec<_> = topology.neighbours(VertexId(v)).collect();
                let sum: DVec3 = ring.iter().map(|w| cap.points[w.index()]).sum();
                cap.points[v as usize] = sum / ring.len() as f64;
            }
        }
        cap
    }

    /// Interior from the graph bi-Laplacian, as fills start.
    fn warm() -> Self {
        let mut cap = Self::new();
        let topology = Topology::from_triangles(cap.points.len(), &cap.faces).expect("sphere");
        let interior: Vec<VertexId> = cap.interior.iter().map(|&v| VertexId(v)).collect();
        meniscus::patch::warm_start(&topology, &mut cap.points, &interior).expect("rim around");
        cap
    }

    fn problem(&self) -> FlowProblem {
        FlowProblem::new(&self.points, &self.faces, &self.interior, self.radius).expect("cap")
    }

    fn flow(&self, f: &str, linear: LinearSolver, corrected: bool) -> MixedFlow {
        MixedFlow::new(&self.problem(), &energy(f), linear, corrected).expect("start")
    }
}

fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(p, q)| p.distance(*q))
        .fold(0.0, f64::max)
}

#[test]
fn gmres_and_lu_agree() {
    let cap = Cap::harmonic();
    for f in ["H^2", "H^2+K^2", "k1^4+k2^4"] {
        for corrected in [false, true] {
            for tau in [1e-5, 1e-2] {
                let krylov = LinearSolver::Gmres { tolerance: 1e-12 };
                let mut one = cap.flow(f, krylov, corrected);
                let mut two = cap.flow(f, LinearSolver::Lu, corrected);
                let (a, b) = (one.attempt(tau), two.attempt(tau));
                assert_eq!(a.is_accepted(), b.is_accepted(), "{f} {tau}");
                let difference = farthest(one.positions(), two.positions());
                println!("{f} {corrected} {tau}: {difference:.1e} {:?}", a.linear);
                assert!(difference < 1e-8 * cap.radius, "{f} {tau}: {difference:e}");
            }
        }
    }
}

#[test]
fn iterations_do_not_depend_on_the_time_step() {
    for (cap, energies) in [
        (Cap::flat(), &["H^2", "H^2+K^2"][..]),
        (
            Cap::warm(),
            &["H^2", "H^2+K^2", "k1^4+k2^4", "K^2", "H^2*K^2"],
        ),
    ] {
        for f in energies {
            for tau in [1e-6, 1e-5, 1e-3, 0.1, 10.0] {
                let mut flow = cap.flow(f, LinearSolver::default(), false);
                let report = flow.attempt(tau).linear.expect("GMRES");
                assert!(report.converged && report.relative_residual <= 1e-10);
                assert!(report.iterations < 30, "{f} {tau}: {}", report.iterations);
            }
        }
    }
}

#[test]
fn rotation_and_scale_change_nothing() {
    let turn = glam_rotation();
    for corrected in [false, true] {
        let cap = Cap::warm();
        let mut moved = Cap::warm();
        // f = H² + a K² with a of unit length²; the time step has unit length⁴
        let (s, tau) = (1000.0, 1e-5);
        for p in &mut moved.points {
            *p = turn(*p) * s;
        }
        moved.radius *= s;
        let linear = LinearSolver::Gmres { tolerance: 1e-13 };
        let mut one = cap.flow("H^2+K^2", linear, corrected);
        let mut two = moved.flow("H^2+1e6*K^2", linear, corrected);
        for k in 0..3 {
            let step = tau * 4f64.powi(k);
            assert!(one.attempt(step).is_accepted());
            assert!(two.attempt(step * s.powi(4)).is_accepted());
        }
        let back: Vec<DVec3> = one.positions().iter().map(|&p| turn(p)).collect();
        let there: Vec<DVec3> = two.positions().iter().map(|&p| p / s).collect();
        let difference = farthest(&back, &there) / cap.radius;
        assert!(difference < 1e-9, "{difference:e}");
    }
}

/// A rotation in general position.
fn glam_rotation() -> impl Fn(DVec3) -> DVec3 {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    let (s, c) = 1.1f64.sin_cos();
    move |p| p * c + axis.cross(p) * s + axis * (axis.dot(p) * (1.0 - c))
}

#[test]
fn rejected_steps_leave_no_trace() {
    let cap = Cap::harmonic();
    let mut one = cap.flow("K^2", LinearSolver::default(), false);
    let mut two = cap.flow("K^2", LinearSolver::default(), false);
    let start = one.positions().to_vec();
    for tau in [f64::NAN, -1.0, 1e6] {
        let attempt = one.attempt(tau);
        assert!(!attempt.is_accepted(), "{tau}");
        assert_eq!(one.positions(), start);
    }
    for flow in [&mut one, &mut two] {
        assert!(flow.attempt(1e-7).is_accepted());
    }
    assert_eq!(one.positions(), two.positions());
}

/// Growing time steps from a flat disc: the paper's first figure.
#[test]
fn flat_disc_becomes_a_cap_without_a_rejected_step() {
    let cap = Cap::flat();
    for f in ["H^2", "H^2+K^2", "k1^4+k2^4"] {
        let mut options = FlowOptions::new(energy(f));
        options.mode = Mode::Flow;
        let mut normal = Flow::new(cap.problem(), options).expect("start");
        let minimum = normal.run(|_, _| true).expect("flow").energy_end;
        for corrected in [false, true] {
            let mut flow = cap.flow(f, LinearSolver::default(), corrected);
            // measured 3e-5 to 3e-3 and 2e-4 to 8e-3: the path matters, and the plain scheme is
            // still creeping then
            let bound = if corrected { 1.005 } else { 1.01 };
            let (mut tau, mut rejected, mut last) = (1e-6, 0, flow.state().energy);
            while tau < 1e3 {
                let attempt = flow.attempt(tau);
                rejected += u32::from(!attempt.is_accepted());
                assert!(last.admits(&flow.state().energy));
                last = flow.state().energy;
                tau *= 4.0;
            }
            println!(
                "{f} {corrected}: E {} B {minimum} rejected {rejected}",
                last.value
            );
            assert_eq!(rejected, 0, "{f} {corrected}");
            assert!(
                last.value < minimum * bound,
                "{f} {corrected}: {}",
                last.value
            );
        }
    }
}

/// Not above it, that is: which stationary point is reached depends a little on the path, as it
/// does for scheme B (the vertices do not move along the surface), and some are lower.
#[test]
fn corrected_scheme_reaches_the_reference_minimum() {
    let reference: serde_json::Value = serde_json::from_str(REFERENCE).expect("json");
    let cap = Cap::harmonic();
    for f in ["1", "H^2", "H^2+K^2", "k1^4+k2^4"] {
        let minimum = reference["values"][f]["energy_minimum"]
            .as_f64()
            .expect("number");
        let mut flow = cap.flow(f, LinearSolver::default(), true);
        let (mut tau, mut longest, mut rejected) = (1e-6, 1.0, 0);
        while longest > 1e-6 * cap.radius || tau < 0.1 {
            let attempt = flow.attempt(tau);
            if attempt.is_accepted() {
                longest = attempt.max_displacement;
                tau = (2.0 * tau).min(1e3);
            } else {
                rejected += 1;
                tau /= 8.0;
            }
            assert!(rejected < 20, "{f}");
        }
        let e = flow.state().energy.value;
        println!("{f}: {e} instead of {minimum}, rejected {rejected}");
        let excess = e / minimum - 1.0;
        assert!(excess < 1e-4, "{f}: {e} instead of {minimum}");
        if ["1", "H^2"].contains(&f) {
            assert!(excess > -1e-4, "{f}: {e} instead of {minimum}");
        }
    }
}

#[test]
fn corrected_scheme_converges_as_fast_as_scheme_b() {
    let cap = Cap::warm();
    for f in ["1", "H^2", "H^2+K^2", "k1^4+k2^4", "K^2", "H^2*K^2"] {
        let mut energies = Vec::new();
        for scheme in [Scheme::Normal, Scheme::MixedCorrected] {
            let mut options = FlowOptions::new(energy(f));
            options.scheme = scheme;
            let outcome = Flow::new(cap.problem(), options)
                .expect("start")
                .run(|_, _| true)
                .expect("flow");
            println!(
                "{f} {scheme:?}: {} steps, {}",
                outcome.steps, outcome.rejected
            );
            assert_eq!(outcome.end, End::Converged, "{f} {scheme:?}");
            assert!(
                outcome.steps <= 25 && outcome.rejected == 0,
                "{f} {scheme:?}"
            );
            energies.push(outcome.energy_end);
        }
        assert!(
            (energies[1] / energies[0] - 1.0).abs() < 1e-3,
            "{f}: {energies:?}"
        );
    }
}

/// R(0.05) of a unit sphere, exactly (formulation, section 9).
#[test]
fn spheres_flow_nearly_as_exact_ones() {
    let (points, faces) = icosphere();
    for (f, wanted) in [
        ("1", 0.89443),
        ("H^2", 1.0),
        ("K", 1.0),
        ("K^2", 1.08148),
        ("H^4", 1.08148),
        ("(H-0.3)^2", 0.95957),
        ("k1^4+k2^4", 1.14043),
        ("H^2*K^2", 1.12686),
    ] {
        let mut options = FlowOptions::new(energy(f));
        options.scheme = Scheme::MixedCorrected;
        let r = flowed_radius(&points, &faces, options);
        println!("{f}: R = {r:.5}, exactly {wanted}");
        assert!((r - wanted).abs() < 5e-3, "{f}: R = {r}");
    }
}
