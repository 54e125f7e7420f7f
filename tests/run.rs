//! Flows on their own thread.

use meniscus::fill::{FillOptions, prepare, warm_start};
use meniscus::mesh::shapes::{self, Hole, HoleShape};
use meniscus::mesh::{DVec3, Mesh, Topology, boundary_loops};
use meniscus::solver::energy::{Energy, Preset};
use meniscus::solver::{
    Command, End, Event, Flow, FlowOptions, FlowProblem, Mode, SolverError, Tau, spawn,
};
use meniscus::subdivision::Rule;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

fn problem() -> FlowProblem {
    let shape = shapes::cut_holes(
        &shapes::sphere(700, 3),
        &[Hole {
            centre: DVec3::Z,
            shape: HoleShape::Disc { radius: 0.6 },
            turn: 0.0,
            seed: 1,
        }],
    );
    let topology = Topology::from_triangles(shape.0.len(), &shape.1).expect("sphere with a hole");
    let mesh = Mesh::new(shape.0, topology);
    let loops = boundary_loops(&mesh);
    let plan = prepare(&mesh, &[&loops[0]], &FillOptions::default());
    warm_start(plan.groups[0].problem(&mesh, &plan).expect("region")).expect("start")
}

fn options(mode: Mode) -> FlowOptions {
    let mut options = FlowOptions::new(Energy::preset(Preset::H2));
    options.mode = mode;
    options
}

#[test]
fn runs_to_the_end_and_says_so() {
    let wakes = Arc::new(AtomicUsize::new(0));
    let counter = Arc::clone(&wakes);
    let handle = spawn(problem(), options(Mode::Fast), true, move || {
        counter.fetch_add(1, Ordering::Relaxed);
    })
    .expect("thread");
    let (mut steps, mut events) = (0, 0);
    let outcome = loop {
        events += 1;
        match handle.wait().expect("an end") {
            Event::Step(record) => steps += usize::from(!record.rejected),
            Event::Finished(outcome) => break outcome,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(outcome.end, End::Converged);
    assert_eq!(outcome.steps, steps);
    assert_eq!(handle.snapshot().step, steps);
    // an event is sent before its wake-up: only once the thread has ended have all been counted
    drop(handle);
    assert_eq!(wakes.load(Ordering::Relaxed), events);
    assert!(events > steps);
    assert!(outcome.energy_end < outcome.energy_start);
}

#[test]
fn pauses_steps_and_changes_options_on_the_way() {
    let handle = spawn(problem(), options(Mode::Flow), false, || {}).expect("thread");
    let start = handle.snapshot();
    assert_eq!(start.step, 0);
    handle.send(Command::Step);
    let Some(Event::Step(first)) = handle.wait() else {
        panic!("a step")
    };
    assert_eq!(first.step, 1);
    let shape = handle.snapshot();
    assert_ne!(start.interior, shape.interior);
    // refused options leave the flow as it was
    let mut bad = options(Mode::Flow);
    bad.tau = Tau::Fixed(-1.0);
    handle.send(Command::Options(Box::new(bad)));
    assert!(matches!(
        handle.wait(),
        Some(Event::OptionsRefused(SolverError::BadOption {
            option: "tau",
            ..
        }))
    ));
    let mut other = options(Mode::Flow);
    other.energy =
        Energy::parse("H^2 + a*K^2", &BTreeMap::from([("a".into(), 0.1)])).expect("energy");
    handle.send(Command::Options(Box::new(other)));
    assert!(matches!(
        handle.wait(),
        Some(Event::OptionsChanged { step: 1 })
    ));
    // the shape did not jump
    assert_eq!(handle.snapshot().interior, shape.interior);
    handle.send(Command::Step);
    assert!(matches!(handle.wait(), Some(Event::Step(r)) if r.step == 2));
    handle.send(Command::Cancel);
    assert!(matches!(handle.wait(), Some(Event::Finished(o)) if o.end == End::Cancelled));
    assert!(handle.wait().is_none());
}

#[test]
fn an_energy_that_is_not_finite_is_an_event_and_dropping_cancels() {
    let mut undefined = options(Mode::Fast);
    undefined.energy = Energy::parse("log(H^2-1e5)", &BTreeMap::new()).expect("parses");
    let handle = spawn(problem(), undefined, true, || {}).expect("thread");
    assert!(matches!(
        handle.wait(),
        Some(Event::Failed(SolverError::EnergyNotFinite { .. }))
    ));
    drop(spawn(problem(), options(Mode::Flow), true, || {}).expect("thread"));
}

/// Refused options used to leave the stencils of the new quadrature behind with the old rule.
#[test]
fn refused_options_change_nothing() {
    let mut flow = Flow::new(problem(), options(Mode::Flow)).expect("start");
    let energy = flow.energy();
    let mut bad = options(Mode::Flow);
    bad.quadrature = Rule::Twelve;
    bad.energy = Energy::parse("log(H^2-1e5)", &BTreeMap::new()).expect("parses");
    assert!(matches!(
        flow.set_options(bad),
        Err(SolverError::EnergyNotFinite { .. })
    ));
    flow.set_options(options(Mode::Flow)).expect("as before");
    assert_eq!(flow.energy(), energy);
}
