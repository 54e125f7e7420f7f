#![allow(warnings)]
use meniscus::mesh::*;
use meniscus::refine::proto::*;
use meniscus::solver::*;
use meniscus::solver::energy::Energy;
use std::time::Instant;

#[test]
fn go() {
    let dir = "/work/shared/models/refine/refine_";
    let names = std::env::var("N").unwrap_or("octahedron,icosahedron,tetrahedron,torus".into());
    let levels: usize = std::env::var("L").map_or(3, |s| s.parse().unwrap());
    let steps: usize = std::env::var("S").map_or(60, |s| s.parse().unwrap());
    let hold_all = std::env::var("HOLD").is_ok();
    let verbose = std::env::var("V").is_ok();
    let mode = if std::env::var("FLOW").is_ok() { Mode::Flow } else { Mode::Fast };
    for name in names.split(',') {
        let soup = meniscus::io::load(format!("{dir}{name}.obj").as_ref()).unwrap();
        let (mesh, _) = build(&soup).unwrap();
        let energy: Energy = std::env::var("E").map_or_else(|_| Energy::parse("H^2", &Default::default()).unwrap(), |e| Energy::parse(&e, &Default::default()).unwrap());
        let mut topology = mesh.topology.clone();
        let original = mesh.positions.clone();
        let centre = original.iter().sum::<DVec3>() / original.len() as f64;
        let radius = (original.iter().map(|p| p.distance_squared(centre)).sum::<f64>() / original.len() as f64).sqrt();
        let mut data = original.clone();
        let mut control = original.clone();
        for level in 1..=levels {
            let t0 = Instant::now();
            let split = split_all(&topology);
            let new = Topology::from_triangles(split.vertex_count(&topology), &split.triangles).unwrap();
            let mut x = loop_subdivide(&topology, &control, &split);
            let held: Vec<(u32, DVec3)> = if hold_all || level == 1 { data.iter().enumerate().map(|(i, &p)| (i as u32, p)).collect() } else { original.iter().enumerate().map(|(i, &p)| (i as u32, p)).collect() };
            let triangles: Vec<[u32;3]> = new.triangles().collect();
            if level == 1 || std::env::var("WARM").is_ok() {
                x = meniscus::refine::proto::warm(&new, &x, &held);
            }
            let interior: Vec<u32> = (0..x.len() as u32).collect();
            let problem = FlowProblem::new(&x, &triangles, &interior, radius).unwrap().holding(&held).unwrap();
            let c0 = problem.centre();
            let mut options = FlowOptions::new(energy.clone());
            options.max_steps = steps;
            options.mode = mode;
            let mut flow = Flow::new(problem, options).unwrap();
            let out = flow.run(|_, r| { if verbose { eprintln!("   {:3} tau {:.2e} E {:.8} res {:.2e} {} {:?}", r.step, r.tau, r.energy, r.residual, r.rejected, r.progress); } true }).unwrap();
            control = flow.positions().iter().map(|&p| p + c0).collect();
            topology = new;
            data = meniscus::subdivision::limit_positions(&topology, &control);
            let err = original.iter().zip(&data).map(|(a,b)| a.distance(*b)).fold(0.0, f64::max);
            println!("{name} level {level}: n {} E {:.6} -> {:.6} steps {} rej {} {:?} old err {err:.1e} {:.2}s", x.len(), out.energy_start, out.energy_end, out.steps, out.rejected, out.end, t0.elapsed().as_secs_f64());
        }
    }
}
