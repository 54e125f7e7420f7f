//! The icosphere of tests/data: 642 vertices near the unit sphere, 7 decimals.

use meniscus::energy::{Energy, Preset};
use meniscus::mesh::DVec3;
use meniscus::solver::{Assembler, Flow, FlowOptions, FlowProblem, Mode, Tau, Unknowns};
use meniscus::subdivision::{Rule, elements};

const DATA: &str = include_str!("../../data/icosphere3.obj");

/// Positions and triangles, as in the file.
pub fn icosphere() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for line in DATA.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let x: Vec<f64> = words.map(|w| w.parse().expect("number")).collect();
                points.push(DVec3::new(x[0], x[1], x[2]));
            }
            Some("f") => {
                let corner = |w: &str| w.split('/').next().and_then(|i| i.parse::<u32>().ok());
                let f: Vec<u32> = words.map(|w| corner(w).expect("index") - 1).collect();
                faces.push([f[0], f[1], f[2]]);
            }
            _ => {}
        }
    }
    (points, faces)
}

/// Radius of the sphere whose area the limit surface of a closed mesh has, 12-point rule.
pub fn area_radius(points: &[DVec3], faces: &[[u32; 3]]) -> f64 {
    let all: Vec<u32> = (0..points.len() as u32).collect();
    let problem = FlowProblem::new(points, faces, &all, 1.0).expect("closed mesh");
    let (topology, active) = (problem.topology(), problem.active_faces());
    let local = elements(topology, active, Rule::Twelve);
    let mut assembler = Assembler::new(&local, Rule::Twelve, Unknowns::none(points.len()));
    let area = Energy::preset(Preset::One);
    let sum = assembler.energy(problem.positions(), &area);
    (sum.value / (4.0 * std::f64::consts::PI)).sqrt()
}

/// Radius of a sphere at time 0.05 of a flow that starts at radius 1, in 40 steps.
pub fn flowed_radius(points: &[DVec3], faces: &[[u32; 3]], mut options: FlowOptions) -> f64 {
    let interior: Vec<u32> = (0..points.len() as u32).collect();
    let start = area_radius(points, faces);
    let unit: Vec<DVec3> = points.iter().map(|&p| p / start).collect();
    let problem = FlowProblem::new(&unit, faces, &interior, 1.0).expect("sphere");
    options.mode = Mode::Flow;
    options.tau = Tau::Fixed(0.05 / 40.0);
    options.max_steps = 40;
    let mut flow = Flow::new(problem, options).expect("start");
    while flow.step().expect("step").is_some() {}
    area_radius(&flow.problem().to_world(flow.positions()), faces)
}
