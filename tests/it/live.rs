//! Fills in the background, and the same repeated by schedule.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Duration;

use meniscus::fill::{
    Continuity, Controls, FillEvent, FillSnapshot, LiveFill, ScheduledOptions, fill_rim_sets,
};
use meniscus::io::{open, save_mesh};
use meniscus::mesh::{BoundaryLoop, DVec3, LoopId, Mesh, boundary_loops};
use meniscus::ops::{BlendSpec, Faces, FillSpec, Operation};
use meniscus::options::Options;
use meniscus::runner::{Event, Refused, RunSettings, Schedule};
use meniscus::shapes::{self, Hole, HoleShape};
use meniscus::solver::{End, Mode, Scheme, Tau};

/// A sphere with two holes near each other and one apart.
fn mesh() -> (Arc<Mesh>, Vec<BoundaryLoop>) {
    let hole = |centre: DVec3, radius: f64| Hole {
        centre: centre.normalize(),
        shape: HoleShape::Disc { radius },
        turn: 0.0,
        seed: 1,
    };
    let shape = shapes::cut_holes(
        &shapes::sphere(900, 3),
        &[
            hole(DVec3::Z, 0.45),
            hole(DVec3::new(1.0, 0.0, 0.6), 0.25),
            hole(DVec3::new(-0.3, 0.2, -1.0), 0.5),
        ],
    );
    let mesh = Mesh::from_triangles(shape.0, &shape.1).expect("sphere with holes");
    let loops = boundary_loops(&mesh);
    (Arc::new(mesh), loops)
}

fn ids(loops: &[BoundaryLoop]) -> Vec<LoopId> {
    loops.iter().map(|l| l.id).collect()
}

fn holes(loops: &[BoundaryLoop], controls: &Controls) -> Operation {
    Operation::Fill(FillSpec {
        loops: ids(loops),
        islands: true,
        bridges: Faces::default(),
        flow: controls.clone().into(),
    })
}

struct Watched {
    fill: LiveFill,
    woken: Receiver<()>,
    events: Vec<Event<FillEvent>>,
}

impl Watched {
    fn start(controls: &Controls, playing: bool) -> Self {
        let (mesh, loops) = mesh();
        let settings = RunSettings {
            playing,
            pace: None,
            timeline_bytes: 1 << 24,
        };
        Self::of(mesh, &loops, controls, settings)
    }

    fn of(
        mesh: Arc<Mesh>,
        loops: &[BoundaryLoop],
        controls: &Controls,
        settings: RunSettings,
    ) -> Self {
        let (bell, woken) = channel();
        let wake = Arc::new(move || {
            bell.send(()).ok();
        });
        let fill = holes(loops, controls)
            .start(mesh, settings, wake)
            .expect("thread");
        Self {
            fill,
            woken,
            events: Vec::new(),
        }
    }

    /// Waits until an event or the state of the fill is as wanted.
    fn until(&mut self, mut is_there: impl FnMut(&LiveFill, &[Event<FillEvent>]) -> bool) {
        loop {
            let events = self.fill.poll();
            let there = is_there(&self.fill, &events);
            self.events.extend(events);
            if there {
                return;
            }
            let waited = self.woken.recv_timeout(Duration::from_mins(1));
            assert!(waited.is_ok(), "{:?} {:?}", self.fill.groups(), self.events);
        }
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let clock = self.fill.clock();
            self.fill.step();
            self.until(|fill, _| fill.clock() > clock);
        }
    }

    fn latest(&self) -> Arc<FillSnapshot> {
        Arc::clone(self.fill.timeline().latest().expect("planned"))
    }
}

fn flow() -> Controls {
    Controls {
        energy: "(H-H0)^2".into(),
        param: BTreeMap::from([("H0".into(), 0.5)]),
        mode: Mode::Flow,
        growth: Some(1.2),
        ..Controls::default()
    }
}

/// The mesh of a fill by schedule, at so many threads.
fn repeated(controls: &Controls, schedule: &Schedule, threads: usize) -> Mesh {
    let (mesh, loops) = mesh();
    let rim_sets: Vec<Vec<&BoundaryLoop>> = loops.iter().map(|l| vec![l]).collect();
    let options = ScheduledOptions::new(controls, schedule).expect("a valid schedule");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    pool.install(|| fill_rim_sets(&mesh, &rim_sets, options, &|_, _| true))
        .expect("a fill")
        .mesh
}

#[test]
fn a_plain_run_ends_and_is_the_command_lines() {
    let mut live = Watched::start(&Controls::default(), true);
    live.until(|fill, _| fill.ended());
    assert!(matches!(live.events[0], Event::Started));
    let finished = live.events.iter().filter(
        |e| matches!(e, Event::Process(FillEvent::Finished { outcome, .. }) if outcome.end == End::Converged),
    );
    assert_eq!(finished.count(), live.fill.groups().len());
    assert!(live.fill.schedule().entries.is_empty());
    let filled = live.latest().mesh();
    assert_eq!(
        filled,
        repeated(&Controls::default(), &Schedule::default(), 1)
    );
}

#[test]
fn changes_on_the_way_are_repeated_to_the_bit() {
    let start = flow();
    let mut live = Watched::start(&start, false);
    live.until(|_, events| events.iter().any(|e| matches!(e, Event::Started)));
    let first = live.latest();
    assert_eq!((first.serial, first.clock), (0, 0));
    live.steps(4);
    let mut controls = start.clone();
    controls.energy = "(H-H0)^2 + a*K^2".into();
    controls.param.insert("a".into(), 0.1);
    live.fill.set_controls(&controls).expect("fine");
    live.steps(3);
    let marked = live.latest();
    controls.tau = Tau::Fixed(1e-4);
    live.fill.set_controls(&controls).expect("fine");
    controls.relaxation = 0.5;
    live.fill.set_controls(&controls).expect("fine");
    live.steps(3);
    controls.density = 1.5;
    controls.tau = Tau::Auto;
    live.fill.set_controls(&controls).expect("fine");
    live.steps(3);
    assert!(!Arc::ptr_eq(marked.topology(), live.latest().topology()));
    controls.scheme = Scheme::MixedCorrected;
    live.fill.set_controls(&controls).expect("fine");
    live.steps(2);
    assert!(live.fill.rewind_to(marked.serial));
    live.until(|_, events| events.iter().any(|e| matches!(e, Event::Rewound { .. })));
    assert_eq!(live.latest().positions(), marked.positions());
    assert!(Arc::ptr_eq(marked.topology(), live.latest().topology()));
    controls.scheme = Scheme::Normal;
    controls
        .loop_continuity
        .insert(LoopId::FIRST, Continuity::G0);
    live.fill.set_controls(&controls).expect("fine");
    live.steps(3);
    let middle = live.latest();
    live.fill.finish();
    live.until(|fill, _| fill.ended());
    for state in [&marked, &middle, &live.latest()] {
        let schedule = state.schedule();
        let read = Schedule::parse(&schedule.to_csv()).expect("as written");
        assert_eq!(read, schedule);
        let filled = state.mesh();
        for threads in [1, 2] {
            assert!(
                filled == repeated(&start, &read, threads),
                "{threads} threads"
            );
        }
    }
}

#[test]
fn a_refused_change_leaves_the_flow_and_a_failed_start_can_be_mended() {
    let undefined = Controls {
        energy: "log(H^2-1e5)".into(),
        ..flow()
    };
    let mut live = Watched::start(&undefined, true);
    live.until(|fill, _| !fill.groups().is_empty());
    assert!(live.fill.ended());
    let failed = live.events.iter().filter(|e| matches!(e, Event::Process(FillEvent::Failed { group: Some(_), text, .. }) if text.contains("not finite")));
    assert_eq!(failed.count(), 2);
    let first = live.latest();
    // playing, so that the repaired flow starts by itself
    live.fill.set_controls(&flow()).expect("fine");
    live.until(|fill, _| fill.groups()[0].step >= 2);
    live.fill.pause();
    live.fill
        .set_controls(&undefined)
        .expect("an energy that parses");
    live.fill.step();
    live.until(|_, events| {
        let refused = |e: &Event<_>| matches!(e, Event::Refused(Refused { part: Some(0), .. }));
        events.iter().any(refused)
    });
    assert!(live.fill.groups().iter().all(|g| g.failed.is_none()));
    assert!(
        live.fill
            .set_controls(&Controls {
                energy: "H^".into(),
                ..flow()
            })
            .is_err()
    );
    live.fill.set_controls(&flow()).expect("fine");
    live.fill.finish();
    live.until(|fill, _| fill.ended());
    let repeated = repeated(&undefined, &live.fill.schedule(), 2);
    assert!(live.latest().mesh() == repeated);
    assert!(!Arc::ptr_eq(&first, &live.latest()));
}

#[test]
fn a_stopped_run_is_repeated_up_to_there() {
    let mut live = Watched::start(&flow(), false);
    live.until(|fill, _| !fill.groups().is_empty());
    live.steps(3);
    live.fill.stop();
    live.until(|fill, _| fill.ended());
    assert!(
        live.fill
            .groups()
            .iter()
            .all(|g| g.end == Some(End::Cancelled) && g.step == 3)
    );
    let finished = |e: &&Event<_>| matches!(e, Event::Process(FillEvent::Finished { .. }));
    assert_eq!(live.events.iter().filter(finished).count(), 2);
    let rows = live.fill.schedule().entries;
    assert_eq!(
        (rows.len(), rows[0].attempt, rows[0].control.as_str()),
        (1, 3, "stop")
    );
    let filled = live.latest().mesh();
    assert!(filled == repeated(&flow(), &live.fill.schedule(), 1));
    // go to a state in the middle and continue from it
    let early = Arc::clone(&live.fill.timeline().states[1]);
    let filled = early.mesh();
    assert!(filled == repeated(&flow(), &early.schedule(), 1));
    assert!(live.fill.rewind_to(early.serial) && !live.fill.rewind_to(999));
    live.until(|_, events| {
        let rewound = |e: &Event<_>| matches!(e, Event::Rewound { .. });
        events.iter().any(rewound)
    });
    live.steps(1);
    assert_eq!(live.fill.groups()[0].step, early.groups[0].step + 1);
}

#[test]
fn the_timeline_keeps_its_bounds_and_both_ends() {
    let timeline = |timeline_bytes: usize| {
        let (mesh, loops) = mesh();
        let settings = RunSettings {
            playing: true,
            pace: None,
            timeline_bytes,
        };
        let mut live = Watched::of(mesh, &loops, &flow(), settings);
        live.until(|fill, _| fill.ended());
        live.fill.timeline()
    };
    // what two states need cannot be saved
    let least = timeline(0);
    let indices: Vec<usize> = least.states.iter().map(|s| s.serial).collect();
    assert_eq!((indices.len(), indices[0]), (2, 0));
    assert!(indices[1] > 10);
    let some = timeline(2 * least.bytes);
    assert!(some.bytes <= 2 * least.bytes && some.states.len() > 2);
    assert_eq!(some.states[0].serial, 0);
    assert!(
        some.latest()
            .is_some_and(|s| s.ended() && s.serial == indices[1])
    );
    for state in &some.states {
        assert!(
            some.find(state.serial)
                .is_some_and(|s| Arc::ptr_eq(s, state))
        );
    }
}

#[test]
fn a_dropped_fill_ends() {
    let (mesh, loops) = mesh();
    let settings = RunSettings {
        playing: true,
        pace: Some(0.1),
        timeline_bytes: 1 << 20,
    };
    let (bell, woken) = channel::<()>();
    let wake = Arc::new(move || {
        bell.send(()).ok();
    });
    drop(
        holes(&loops, &flow())
            .start(mesh, settings, wake)
            .expect("thread"),
    );
    // the thread drops its end of the bell, although the next round is ten seconds away
    while woken.recv_timeout(Duration::from_mins(1)).is_ok() {}
    assert!(matches!(woken.try_recv(), Err(TryRecvError::Disconnected)));
}

/// The command line with the copied arguments and schedule writes the same bytes.
#[test]
fn the_command_line_repeats_a_run_to_the_byte() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let (given, loops) = mesh();
    save_mesh(&at("in.obj"), &given).expect("written");
    let opened = open(&at("in.obj")).expect("read back");
    assert_eq!(boundary_loops(&opened.mesh), loops);
    let (mesh, controls) = (Arc::new(opened.mesh), flow());
    let settings = RunSettings {
        playing: false,
        pace: None,
        timeline_bytes: 1 << 24,
    };
    let mut live = Watched::of(Arc::clone(&mesh), &loops, &controls, settings);
    live.until(|_, events| events.iter().any(|e| matches!(e, Event::Started)));
    live.steps(3);
    let mut changed = controls.clone();
    changed.density = 1.4;
    changed.energy = "max(H,-H)^2".into();
    live.fill.set_controls(&changed).expect("fine");
    live.steps(4);
    let state = live.latest();
    let filled = state.mesh();
    save_mesh(&at("live.obj"), &filled).expect("written");
    std::fs::write(at("s.csv"), state.schedule().to_csv()).expect("written");
    let wanted = std::fs::read(at("live.obj")).expect("there");
    for threads in ["1", "2"] {
        let mut command = assert_cmd::Command::cargo_bin("meniscus").expect("the program");
        command.env("RAYON_NUM_THREADS", threads);
        command
            .arg("fill")
            .arg(at("in.obj"))
            .arg("-o")
            .arg(at("out.obj"));
        command
            .args(controls.to_arguments())
            .args(["--loops", "1,2,3", "--quiet"]);
        command.arg("--schedule").arg(at("s.csv"));
        command.assert().success();
        assert!(std::fs::read(at("out.obj")).expect("there") == wanted);
    }
    std::fs::write(at("s.csv"), "attempt,control,value\n3,enrgy,1\n").expect("written");
    let mut command = assert_cmd::Command::cargo_bin("meniscus").expect("the program");
    command
        .arg("fill")
        .arg(at("in.obj"))
        .arg("-o")
        .arg(at("no.obj"));
    command.arg("--schedule").arg(at("s.csv"));
    let output = command
        .assert()
        .failure()
        .code(2)
        .get_output()
        .stderr
        .clone();
    let text = String::from_utf8_lossy(&output).into_owned();
    assert!(
        text.contains("s.csv") && text.contains("line 2: unknown control `enrgy`"),
        "{text}"
    );
    assert!(!at("no.obj").exists());
}

#[test]
fn a_surface_that_runs_into_the_mesh_pauses_there() {
    let (mesh, loops) = crate::common::layouts::with_obstacle();
    let settings = RunSettings {
        playing: true,
        pace: None,
        timeline_bytes: 1 << 24,
    };
    let (bell, woken) = channel();
    let wake = Arc::new(move || {
        bell.send(()).ok();
    });
    let blend = Operation::Blend(BlendSpec {
        loops: ids(&loops),
        flow: Controls::default().into(),
    });
    let spawned = blend.start(Arc::new(mesh), settings, wake);
    let fill = spawned.expect("thread");
    let mut live = Watched {
        fill,
        woken,
        events: Vec::new(),
    };
    live.until(|_, events| events.iter().any(|e| matches!(e, Event::Paused)));
    let found = live.events.iter().find_map(|e| match e {
        Event::Process(FillEvent::SelfIntersection {
            place, last_good, ..
        }) => Some((*place, *last_good)),
        _ => None,
    });
    let (place, last_good) = found.expect("an event");
    // the bar is round the line x = 0.9, z = 0
    assert!(
        place.z.abs() < 0.5 && (place.x - 0.9).abs() < 0.5,
        "{place}"
    );
    assert!(!live.fill.playing() && !live.fill.ended());
    let good = last_good.expect("the start was clean");
    let timeline = live.fill.timeline();
    assert!(timeline.states.iter().any(|s| s.groups[0].step == good));
    // continuing leads to the last surface without a self-intersection
    live.fill.finish();
    live.until(|fill, _| fill.ended());
    assert_eq!(live.fill.groups()[0].end, Some(End::SelfIntersected));
}
