//! Random blends, refills, refinements and bridges.

use std::sync::Arc;

use meniscus::Fill;
use meniscus::fill::{
    self, Filled, LoopChoice, Refilled, RimSegment, bridge, bridge_warning, segment_at,
};
use meniscus::mesh::{self, DVec3, LoopId, Mesh, boundary_loops, self_intersections};
use meniscus::random::SplitMix;
use meniscus::refine::{self, RefineControls, RefineEvent};
use meniscus::runner::Recording;
use meniscus::shapes::{self, Tube};

use crate::inputs::{Damage, input, noisy_body, soup};
use crate::{MAX_PAIRS, Verdict, check, controls, verdicts};

/// A random input and what is done with it.
pub struct Case {
    /// The row of the table that counts it.
    pub row: String,
    pub mesh: Mesh,
    pub operation: Operation,
}

pub enum Operation {
    /// One patch over these loops.
    Blend(Vec<LoopId>),
    /// A new patch instead of the faces in a ball.
    Refill(DVec3, f64),
    /// One level.
    Refine,
    Bridge([RimSegment; 2]),
}

/// The verdicts of a result, each with whether its surroundings are free of intersections.
type Verdicts = Vec<(Verdict, bool)>;

/// The case of a seed; `None` if it gives none.
pub fn case(kind: &str, seed: u64) -> Option<Case> {
    let mut rng = SplitMix::new(seed);
    match kind {
        "blends" => blend(&mut rng),
        "refills" => {
            let vertices = 300 + rng.below(1500);
            let (body, edge) = noisy_body(vertices, &mut rng);
            let (place, rings) = (body.0[rng.below(body.0.len())], rng.range(2.0, 8.0));
            Some(Case {
                row: "refills".into(),
                mesh: mesh::build(&soup(body)).ok()?.0,
                operation: Operation::Refill(place, rings * edge),
            })
        }
        "refinements" => {
            let vertices = 40 + rng.below(160);
            let (body, _) = noisy_body(vertices, &mut rng);
            Some(Case {
                row: "refinements".into(),
                mesh: mesh::build(&soup(body)).ok()?.0,
                operation: Operation::Refine,
            })
        }
        _ => {
            let input = input(seed).filter(|input| input.damage != Damage::Crumbs)?;
            let loops = boundary_loops(&input.mesh);
            let width = 1 + rng.below(3);
            let mut end = || {
                let hole = &loops[rng.below(loops.len())];
                let v = hole.vertices[rng.below(hole.vertices.len())];
                segment_at(&input.mesh, &loops, input.mesh.position(v), width)
            };
            let ends = [end()?, end()?];
            Some(Case {
                row: "bridges".into(),
                mesh: input.mesh,
                operation: Operation::Bridge(ends),
            })
        }
    }
}

/// Two to four tubes that leave a common place in different directions, of different radii. Their
/// inner rims are blended. `None` if the tubes meet.
fn blend(rng: &mut SplitMix) -> Option<Case> {
    let count = 2 + rng.below(3);
    let radius = rng.range(0.2, 0.6);
    let around = 10 + rng.below(20);
    let tubes: Vec<Tube> = (0..count)
        .map(|_| {
            let direction = rng.direction();
            let tilted = (direction + rng.range(0.0, 0.5) * rng.direction()).normalize();
            let factor = rng.range(0.6, 1.5);
            Tube {
                mouth: rng.range(0.7, 2.0) * direction,
                axis: 1.6 * tilted,
                radius: radius * factor,
                around: (around as f64 * factor).round() as usize,
            }
        })
        .collect();
    let mesh = mesh::build(&soup(shapes::tubes(&tubes))).ok()?.0;
    let faces: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    if !self_intersections(&mesh.positions, &faces, None, 1).is_empty() {
        return None;
    }
    let loops = boundary_loops(&mesh);
    let nearest = |tube: &Tube| {
        let middle = |vertices: &[mesh::VertexId]| {
            let sum: DVec3 = vertices.iter().map(|&v| mesh.position(v)).sum();
            sum / vertices.len() as f64
        };
        let distance = |l: &&mesh::BoundaryLoop| middle(&l.vertices).distance(tube.mouth);
        let nearest = loops
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map(|one| one.id)
    };
    let inner: Option<Vec<LoopId>> = tubes.iter().map(nearest).collect();
    Some(Case {
        row: format!("{count} tubes"),
        operation: Operation::Blend(inner?),
        mesh,
    })
}

impl Operation {
    /// Runs the operation with the options of a seed.
    pub fn run(&self, mesh: &Mesh, seed: u64) -> Verdicts {
        let result = match self {
            Self::Blend(loops) => Fill::new(mesh)
                .controls(controls(seed))
                .loops(LoopChoice::Listed(loops.clone()))
                .joined()
                .run()
                .map_err(|error| error.to_string())
                .map(|filled| of_fill(mesh, &filled, seed)),
            Self::Refill(centre, radius) => refill(mesh, *centre, *radius, seed),
            Self::Refine => refined(mesh),
            Self::Bridge(ends) => bridged(mesh, *ends),
        };
        result.unwrap_or_else(|error| {
            println!("seed {seed}: {error}");
            vec![(Verdict::Failed, true)]
        })
    }
}

fn of_fill(mesh: &Mesh, filled: &Filled, seed: u64) -> Verdicts {
    if let Err(fault) = check(mesh, &filled.mesh) {
        println!("seed {seed}: {fault}");
        return vec![(Verdict::Broken, true)];
    }
    let failed = filled.failed.iter().map(|error| {
        println!("seed {seed}: {error}");
        (Verdict::Failed, true)
    });
    verdicts(mesh, filled).into_iter().chain(failed).collect()
}

fn refill(mesh: &Mesh, centre: DVec3, radius: f64, seed: u64) -> Result<Verdicts, String> {
    let selected = mesh::faces_in_ball(mesh, centre, radius);
    let options = controls(seed)
        .options()
        .map_err(|error| error.to_string())?;
    let refilled = fill::refill(mesh, &selected, &options, &|_, _| true);
    let Refilled { region, filled, .. } = refilled.map_err(|error| error.to_string())?;
    let left = &region.erased.mesh;
    let old = region.erased.old_vertex.iter();
    let is_kept = |(p, &old): (&DVec3, &u32)| bits(*p) == bits(mesh.positions[old as usize]);
    if !left.positions.iter().zip(old).all(is_kept) {
        return Ok(vec![(Verdict::Broken, true)]);
    }
    Ok(of_fill(left, &filled, seed))
}

fn refined(mesh: &Mesh) -> Result<Verdicts, String> {
    let controls = RefineControls {
        levels: 1,
        ..RefineControls::default()
    };
    let given = Arc::new(mesh.clone());
    let run = refine::refine(
        given,
        controls.into(),
        &Recording::default(),
        &mut |_: RefineEvent| true,
    );
    let (refined, _) = run.map_err(|error| error.to_string())?;
    let after = &refined.mesh;
    let mut pairs = mesh.positions.iter().zip(&after.positions);
    let is_valid = mesh::check_mesh(after).is_ok()
        && after.face_count() == 4 * mesh.face_count()
        && pairs.all(|(a, b)| bits(*a) == bits(*b));
    if !is_valid {
        return Ok(vec![(Verdict::Broken, true)]);
    }
    // `meniscus refine` itself compares these numbers and warns
    Ok(vec![compared(mesh, after, true)])
}

fn bridged(mesh: &Mesh, [from, to]: [RimSegment; 2]) -> Result<Verdicts, String> {
    let bridged =
        bridge(mesh, &boundary_loops(mesh), from, to).map_err(|error| error.to_string())?;
    if check(mesh, &bridged).is_err() {
        return Ok(vec![(Verdict::Broken, true)]);
    }
    let is_said = bridge_warning(mesh, &bridged).is_some();
    Ok(vec![compared(mesh, &bridged, is_said)])
}

/// The verdict by the numbers of intersections before and after an operation.
fn compared(before: &Mesh, after: &Mesh, is_said: bool) -> (Verdict, bool) {
    let [given, now] = [before, after].map(crossings);
    let verdict = match (now > given, is_said) {
        (false, _) => Verdict::Sound,
        (true, true) => Verdict::Said,
        (true, false) => Verdict::Silent,
    };
    (verdict, given == 0)
}

fn crossings(mesh: &Mesh) -> usize {
    let faces: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    self_intersections(&mesh.positions, &faces, None, MAX_PAIRS).len()
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}
