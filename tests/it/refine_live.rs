//! Refinements in the background.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use meniscus::energy::{Energy, Preset};
use meniscus::live::LiveSettings;
use meniscus::mesh::{Mesh, Topology};
use meniscus::refine::{LiveRefine, Method, RefineEvent, RefineOptions, Refinement};
use meniscus::shapes;
use meniscus::solver::{FlowOptions, Mode, Tau};

fn mesh() -> Arc<Mesh> {
    let (positions, triangles) = shapes::sphere(30, 3);
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("closed");
    Arc::new(Mesh::new(positions, topology))
}

fn options(method: Method) -> RefineOptions {
    let mut options = RefineOptions::new(Energy::preset(Preset::H2));
    (options.levels, options.method) = (2, method);
    options
}

fn settings(playing: bool) -> LiveSettings {
    LiveSettings {
        playing,
        pace: None,
        timeline_bytes: 1 << 24,
    }
}

struct Watched {
    live: LiveRefine,
    woken: Receiver<()>,
    events: Vec<RefineEvent>,
}

impl Watched {
    fn start(options: RefineOptions, playing: bool) -> Self {
        let (bell, woken) = channel();
        let wake = Arc::new(move || {
            bell.send(()).ok();
        });
        let live = LiveRefine::spawn(mesh(), options, settings(playing), wake).expect("thread");
        Self {
            live,
            woken,
            events: Vec::new(),
        }
    }

    /// Waits until the refinement is as wanted.
    fn until(&mut self, is_there: impl Fn(&LiveRefine) -> bool) {
        loop {
            self.events.extend(self.live.poll());
            if is_there(&self.live) {
                return;
            }
            let waited = self.woken.recv_timeout(Duration::from_mins(1));
            assert!(waited.is_ok(), "{:?} {:?}", self.live.status(), self.events);
        }
    }

    /// What was said, one letter each.
    fn course(&self) -> String {
        let letter = |event: &RefineEvent| match event {
            RefineEvent::Level { .. } => 'L',
            RefineEvent::Step { .. } => 's',
            RefineEvent::LevelDone(_) => 'd',
            RefineEvent::OptionsChanged => 'o',
            RefineEvent::OptionsRefused { .. } => 'r',
            RefineEvent::Finished => 'F',
            RefineEvent::Failed { .. } => 'X',
        };
        let mut letters: Vec<char> = self.events.iter().map(letter).collect();
        letters.dedup();
        letters.into_iter().collect()
    }
}

#[test]
fn every_method_ends_where_it_does_in_the_foreground() {
    for (method, course) in [
        (Method::Pde, "LsdLsdF"),
        (Method::Butterfly, "LdLdF"),
        (Method::Loop, "LdLdF"),
    ] {
        let mut live = Watched::start(options(method), true);
        live.until(LiveRefine::ended);
        assert_eq!(live.course(), course);
        let plain = Refinement::new(mesh(), options(method)).expect("options");
        let plain = plain.run(|_, _| true).expect("refined");
        let timeline = live.live.timeline();
        let latest = timeline.latest().expect("states");
        assert_eq!(live.live.mesh_at(latest), plain.mesh);
        assert_eq!(latest.control[..], plain.control.positions[..]);
        assert_eq!(timeline.states[0].mesh(&mesh()), *mesh());
        let accepted = live.live.records().iter().filter(|(_, r)| !r.rejected);
        // the given mesh, the start of each level, every accepted step
        assert_eq!(timeline.states.len(), 3 + accepted.count());
        let energies = |r: &[meniscus::refine::LevelReport]| -> Vec<f64> {
            r.iter().map(|l| l.energy_end).collect()
        };
        assert_eq!(energies(live.live.levels()), energies(&plain.levels));
    }
}

#[test]
fn it_waits_steps_changes_and_stops() {
    let mut live = Watched::start(options(Method::Pde), false);
    live.until(|live| live.timeline().latest().is_some());
    live.live.step();
    live.until(|live| live.status().level == 1);
    assert!(!live.live.playing() && live.live.status().attempts == 0);
    live.live.step();
    live.until(|live| live.status().attempts == 1);
    let mut flow = FlowOptions::new(Energy::preset(Preset::One));
    (flow.mode, flow.tau) = (Mode::Flow, Tau::Fixed(f64::NAN));
    assert!(live.live.set_flow(flow.clone()).is_err());
    flow.tau = Tau::Auto;
    live.live.set_flow(flow).expect("options");
    live.live.step();
    live.until(|live| live.status().attempts == 2);
    assert_eq!(live.course(), "Lsos");
    live.live.stop();
    live.until(LiveRefine::ended);
    assert_eq!(live.course(), "LsosdF");
    assert_eq!(live.live.levels()[0].end, "cancelled");
}

#[test]
fn a_finished_one_goes_on_to_another_level() {
    let mut live = Watched::start(options(Method::Pde), true);
    live.until(LiveRefine::ended);
    live.live.set_levels(3);
    live.until(|live| live.levels().len() == 3 && live.ended());
    assert_eq!(live.course(), "LsdLsdFoLsdF");
}

#[test]
fn a_panic_is_an_event() {
    let (bell, woken) = channel();
    let first = AtomicBool::new(true);
    let wake = Arc::new(move || {
        bell.send(()).ok();
        assert!(!first.swap(false, Ordering::Relaxed), "a bell that breaks");
    });
    let spawned = LiveRefine::spawn(mesh(), options(Method::Pde), settings(true), wake);
    let mut live = spawned.expect("thread");
    while !live.ended() {
        woken.recv_timeout(Duration::from_mins(1)).expect("woken");
        live.poll();
    }
    assert_eq!(live.status().failed.as_deref(), Some("a bell that breaks"));
}

#[test]
fn dropping_waits_for_nothing_and_ends_the_thread() {
    let (bell, woken) = channel();
    let wake = Arc::new(move || {
        bell.send(()).ok();
    });
    let mut options = options(Method::Pde);
    options.levels = 5;
    drop(LiveRefine::spawn(mesh(), options, settings(true), wake).expect("thread"));
    // the bell goes with the thread
    while woken.recv_timeout(Duration::from_mins(1)).is_ok() {}
    assert!(matches!(
        woken.try_recv(),
        Err(std::sync::mpsc::TryRecvError::Disconnected)
    ));
}
