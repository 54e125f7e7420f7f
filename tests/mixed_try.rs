use std::collections::BTreeMap;
use meniscus::mesh::DVec3;
use meniscus::solver::energy::Energy;
use meniscus::solver::{FlowProblem, LinearSolver, MixedFlow};
const DATA: &str = include_str!("data/icosphere3.obj");
fn icosphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for line in DATA.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => { let x: Vec<f64> = words.map(|w| w.parse().unwrap()).collect(); points.push(DVec3::new(x[0], x[1], x[2])); }
            Some("f") => { let f: Vec<u32> = words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect(); faces.push([f[0], f[1], f[2]]); }
            _ => {}
        }
    }
    (points, faces)
}
fn split(points: &[DVec3], faces: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut p = points.to_vec();
    let mut mid = BTreeMap::new();
    let mut out = Vec::new();
    for f in faces {
        let mut m = |a: u32, b: u32| *mid.entry((a.min(b), a.max(b))).or_insert_with(|| { p.push((p[a as usize] + p[b as usize]).normalize()); p.len() as u32 - 1 });
        let (a, b, c) = (m(f[0], f[1]), m(f[1], f[2]), m(f[2], f[0]));
        out.extend([[f[0], a, c], [a, f[1], b], [c, b, f[2]], [a, b, c]]);
    }
    (p, out)
}
fn energy(t: &str) -> Energy { Energy::parse(t, &BTreeMap::new()).unwrap() }
#[test]
fn try_flat() {
    let levels: usize = std::env::var("LEVELS").map_or(0, |s| s.parse().unwrap());
    let corrected = std::env::var("PLAIN").is_err();
    let angle: f64 = std::env::var("ANGLE").map_or(40.0, |s| s.parse().unwrap());
    let (mut points, mut faces) = icosphere();
    for _ in 0..levels { (points, faces) = split(&points, &faces); }
    let limit = angle.to_radians().cos();
    let interior: Vec<u32> = (0..points.len() as u32).filter(|&i| points[i as usize].z > limit).collect();
    let flat = std::env::var("SPHERE").is_err();
    if flat { for &v in &interior { points[v as usize].z = limit; } }
    let names = std::env::var("ENERGY").unwrap_or("H^2".into());
    for name in names.split(',') {
        let problem = FlowProblem::new(&points, &faces, &interior, angle.to_radians().sin()).unwrap();
        let linear = if std::env::var("LU").is_ok() { LinearSolver::Lu } else { LinearSolver::default() };
        let t = std::time::Instant::now();
        let mut flow = MixedFlow::new(&problem, &energy(name), linear, corrected).unwrap();
        println!("{name}: n = {} dim {} E0 {} setup {:?}", interior.len(), flow.dimension(), flow.energy().value, t.elapsed());
        if let Ok(taus) = std::env::var("TAUS") {
            for tau in taus.split(',') {
                let t = std::time::Instant::now();
                let a = flow.attempt(tau.parse().unwrap()).unwrap();
                println!("  tau {tau} {:?} acc {} longest {:.3e} E {:.8} its {:?} {:?}", t.elapsed(), a.accepted, a.longest, flow.energy().value, a.linear.map(|l| (l.iterations, l.relative_residual)), a.note);
            }
            continue;
        }
        let mut tau = 1e-6;
        while tau < 2e3 {
            let t = std::time::Instant::now();
            let a = flow.attempt(tau).unwrap();
            println!("  tau {tau:.1e} {:?} acc {} longest {:.3e} E {:.8} its {:?} {:?}", t.elapsed(), a.accepted, a.longest, flow.energy().value, a.linear.map(|l| (l.iterations, l.relative_residual)), a.note);
            tau *= 4.0;
        }
    }
}
