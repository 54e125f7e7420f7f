//! Each long stage of a fill polls whether its run was cancelled, and ends early if it was.

use std::sync::Arc;

use crate::cancel::tests::{cancelled_at, is_polled};
use crate::fill::context::FillContext;
use crate::fill::hole::HoleRims;
use crate::fill::prepare::prepare;
use crate::fill::repair::repaired;
use crate::fill::self_intersection::Obstacles;
use crate::fill::surface_choice::Prediction;
use crate::fill::{
    Controls, FillOptions, PreparedFill, Symmetry, fill_rim_sets, flow_problem,
    process::FillProcess,
};

use crate::mesh::{BoundaryLoop, DVec3, Mesh, boundary_loops};
use crate::patch::{self, PatchOptions};
use crate::runner::Process as _;
use crate::shapes;
use crate::solver::Flow;

/// A sphere without its cap above a height, a little rough.
fn cup(height: f64) -> Mesh {
    let (mut positions, triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > height);
    for (i, p) in positions.iter_mut().enumerate() {
        *p *= 1.0 + 0.01 * (1e3 * i as f64).sin();
    }
    Mesh::from_triangles(positions, &triangles).expect("a manifold")
}

/// The same with a wall through the place of its cap, which no smooth patch avoids.
fn walled_cup() -> Mesh {
    let (mut positions, mut triangles) = shapes::cut_where(&shapes::sphere(1000, 1), |p| p.z > 0.5);
    let first = positions.len() as u32;
    positions.extend([
        DVec3::new(-2.0, -2.0, 0.8),
        DVec3::new(2.0, -2.0, 0.8),
        DVec3::new(0.0, 2.0, 0.8),
    ]);
    triangles.push([first, first + 1, first + 2]);
    Mesh::from_triangles(positions, &triangles).expect("a manifold")
}

fn hole(mesh: &Mesh) -> BoundaryLoop {
    let loops = boundary_loops(mesh);
    loops.into_iter().find(|l| l.edges() > 4).expect("a hole")
}

#[test]
fn first_patches_are() {
    let mesh = cup(0.5);
    let rims = HoleRims::new(&mesh, &[&hole(&mesh)]);
    let rim = &rims.geometry.rims[0];
    is_polled(5, || patch::fill(rim, PatchOptions::default()));
    // each triangulation that is tried
    is_polled(rim.points.len(), || {
        patch::fill_excluding(rim, PatchOptions::default(), &|t| t[0] % 3 == 0)
    });
}

#[test]
fn predictions_are() {
    let mesh = cup(0.9);
    let one = hole(&mesh);
    let plan = prepare(&mesh, &[vec![&one]], &[], &FillOptions::default()).plan;
    let context = FillContext {
        mesh: &mesh,
        plan: &plan,
    };
    is_polled(6, || {
        Prediction::new(context, 0, &FillOptions::default().flow, Symmetry::Auto)
    });
}

#[test]
fn flows_are() {
    let mesh = cup(0.5);
    let problem = flow_problem(&mesh, &hole(&mesh), &FillOptions::default());
    let problem = problem.expect("valid").expect("inner vertices");
    is_polled(8, || {
        let flow = Flow::new(problem.clone(), FillOptions::default().flow);
        flow.and_then(|mut flow| flow.run(|_, _| true)).ok()
    });
}

#[test]
fn repairs_are() {
    let mesh = cup(0.7);
    let one = hole(&mesh);
    let rims = HoleRims::new(&mesh, &[&one]);
    let patch = patch::fill(&rims.geometry.rims[0], PatchOptions::default());
    let mut patch = patch.expect("a patch");
    patch.points[patch.rim].z -= 2.5;
    let obstacles = Obstacles::new(1);
    is_polled(8, || repaired(&mesh, &obstacles, &rims, &patch, &[], &[]));
}

#[test]
fn searches_for_sound_patches_are() {
    let mesh = walled_cup();
    let one = hole(&mesh);
    let fill = |options: &FillOptions| {
        let sets = [vec![&one]];
        fill_rim_sets(&mesh, &sets, options, &|_, _| true).map(|filled| filled.holes.len())
    };
    is_polled(100, || fill(&FillOptions::default()));
}

/// Wherever a run is cancelled, its process ends without a panic.
#[test]
fn processes_end_wherever_they_are_cancelled() {
    let mesh = Arc::new(walled_cup());
    let one = hole(&mesh);
    let run = || {
        let options = Controls::default().options().expect("valid");
        let prepared = PreparedFill::new(&mesh, &[vec![&one]], &[], &options);
        let process = FillProcess::new(&mesh, prepared);
        let mut process = process.expect("set up");
        let mut failed = Vec::new();
        for clock in 1.. {
            if process.ended() {
                break;
            }
            process.advance(clock, &mut |_| {}).expect("a step");
            process.state().expect("a state");
            let status = process.status(0.0, &mut |_| {});
            failed = status
                .into_iter()
                .filter_map(|group| group.failed)
                .collect();
            if crate::cancel::is_cancelled() {
                break;
            }
        }
        failed
    };
    let (failed, all) = cancelled_at(usize::MAX, run);
    assert_eq!(failed, [""; 0]);
    let mut last = 1;
    while last < all {
        let (failed, polls) = cancelled_at(last, run);
        let panicked = failed.iter().any(|text| text.contains("unexpectedly"));
        assert!(!panicked, "{failed:?} at poll {last} of {all}");
        assert!(polls <= all, "{polls} polls, {last} of {all}");
        last = 2 * last + 1;
    }
}
