use std::collections::BTreeMap;
use meniscus::mesh::{DVec3,Topology,VertexId};
use meniscus::solver::energy::Energy;
use meniscus::solver::*;
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
fn harmonic(points: &mut [DVec3], topology: &Topology, interior: &[u32]) {
    for _ in 0..3000 {
        for &v in interior {
            let ring: Vec<_> = topology.neighbours(VertexId(v)).collect();
            points[v as usize] = ring.iter().map(|w| points[w.index()]).sum::<DVec3>() / ring.len() as f64;
        }
    }
}
fn energy(t: &str) -> Energy { Energy::parse(t, &BTreeMap::new()).unwrap() }
#[test]
fn flows() {
    let angle: f64 = std::env::var("ANGLE").map_or(40.0, |s| s.parse().unwrap());
    let (points, faces) = icosphere();
    let limit = angle.to_radians().cos();
    let interior: Vec<u32> = (0..points.len() as u32).filter(|&i| points[i as usize].z > limit).collect();
    let topology = Topology::from_triangles(points.len(), &faces).unwrap();
    let names = std::env::var("ENERGY").unwrap_or("H^2".into());
    let verbose = std::env::var("V").is_ok();
    for name in names.split(',') {
        for start in ["flat", "harmonic", "warm"] {
            let mut pts = points.clone();
            if start == "flat" { for &v in &interior { pts[v as usize].z = limit; } } else if start == "warm" { meniscus::patch::warm_start(&topology, &mut pts, &interior.iter().map(|&v| VertexId(v)).collect::<Vec<_>>()).unwrap(); } else { harmonic(&mut pts, &topology, &interior); }
            for scheme in if std::env::var("CORR").is_ok() { vec![Scheme::MixedCorrected] } else { vec![Scheme::Normal, Scheme::Mixed, Scheme::MixedCorrected] } {
                for mode in [Mode::Flow, Mode::Fast] {
                    let problem = FlowProblem::new(&pts, &faces, &interior, angle.to_radians().sin()).unwrap();
                    let mut options = FlowOptions::new(energy(name));
                    options.mode = mode; options.scheme = scheme; options.max_steps = 120;
                    let t = std::time::Instant::now();
                    let mut flow = Flow::new(problem, options).unwrap();
                    let o = flow.run(|_, r| { if verbose { println!("     {} tau {:.1e} E {:.8} res {:.2e} rej {} it {:?}", r.step, r.tau, r.energy, r.residual, r.rejected, r.iterations); } true }).unwrap();
                    let r: Vec<f64> = flow.problem().to_world(flow.positions()).iter().map(|p| p.length()).collect();
                    let least = r.iter().copied().fold(f64::INFINITY, f64::min);
                    let most = r.iter().copied().fold(0.0, f64::max);
                    println!("{name} {start} {scheme:?} {mode:?}: {:?} steps {} rej {} E {:.7} r {least:.5} {most:.5} {:?}", o.end, o.steps, o.rejected, o.energy_end, t.elapsed());
                }
            }
        }
    }
}
