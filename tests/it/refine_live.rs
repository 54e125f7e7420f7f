//! Refinements in the background, and the same repeated by schedule.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use meniscus::io::{open, save_mesh};
use meniscus::mesh::Mesh;
use meniscus::options::Options;
use meniscus::refine::{
    LiveRefine, Method, RefineControls, RefineEvent, RefineSnapshot, Refined, refine,
};
use meniscus::runner::{Event, Recording, RunSettings, Schedule};
use meniscus::shapes;
use meniscus::solver::{End, Mode, Tau};

fn mesh() -> Arc<Mesh> {
    let (positions, triangles) = shapes::sphere(30, 3);
    Arc::new(Mesh::from_triangles(positions, &triangles).expect("closed"))
}

fn controls(method: Method) -> RefineControls {
    RefineControls {
        levels: 2,
        method,
        energy: Some("H^2".into()),
        steps: 200,
        ..RefineControls::default()
    }
}

fn settings(playing: bool) -> RunSettings {
    RunSettings {
        playing,
        pace: None,
        timeline_bytes: 1 << 24,
    }
}

struct Watched {
    live: LiveRefine,
    woken: Receiver<()>,
    events: Vec<Event<RefineEvent>>,
}

impl Watched {
    fn start(controls: RefineControls, playing: bool) -> Self {
        Self::of(mesh(), controls, playing)
    }

    fn of(mesh: Arc<Mesh>, controls: RefineControls, playing: bool) -> Self {
        let (bell, woken) = channel();
        let wake = Arc::new(move || {
            bell.send(()).ok();
        });
        let settings = settings(playing);
        let live = LiveRefine::spawn(mesh, controls, Vec::new(), None, settings, wake);
        Self {
            live: live.expect("thread"),
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

    /// Performs `count` actions one by one.
    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let clock = self.live.clock();
            self.live.step();
            self.until(|live| live.clock() > clock);
        }
    }

    /// Waits for something that is counted in events.
    fn until_event(&mut self, is_wanted: impl Fn(&Event<RefineEvent>) -> bool) {
        while !self.events.iter().any(&is_wanted) {
            let waited = self.woken.recv_timeout(Duration::from_mins(1));
            assert!(waited.is_ok(), "{:?} {:?}", self.live.status(), self.events);
            self.events.extend(self.live.poll());
        }
    }

    fn latest(&self) -> Arc<RefineSnapshot> {
        Arc::clone(self.live.timeline().latest().expect("states"))
    }

    /// The events in order, one letter each.
    fn course(&self) -> String {
        let letter = |event: &Event<RefineEvent>| match event {
            Event::Process(RefineEvent::Level { .. }) => Some('L'),
            Event::Process(RefineEvent::Step { .. }) => Some('s'),
            Event::Process(RefineEvent::LevelDone(_)) => Some('d'),
            Event::ControlsChanged { .. } => Some('o'),
            Event::Refused(_) => Some('r'),
            Event::Rewound { .. } => Some('R'),
            Event::Paused => Some('p'),
            Event::Ended => Some('F'),
            Event::Failed { .. } => Some('X'),
            Event::Started | Event::Process(_) => None,
        };
        let mut letters: Vec<char> = self.events.iter().filter_map(letter).collect();
        letters.dedup();
        letters.into_iter().collect()
    }
}

/// A refinement by schedule, with so many threads.
fn repeated(controls: &RefineControls, schedule: &Schedule, threads: usize) -> Refined {
    let mesh = mesh();
    let recording = schedule.recording(controls).expect("a schedule");
    let options = controls.clone().into();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    let run = || refine(mesh, options, &recording, &mut |_| true);
    let (refined, refused) = pool.install(run).expect("refined");
    assert!(refused.is_empty());
    refined
}

#[test]
fn every_method_ends_where_it_does_in_the_foreground() {
    for (method, course) in [
        (Method::Pde, "LsdLsdF"),
        (Method::Butterfly, "LdLdF"),
        (Method::Loop, "LdLdF"),
    ] {
        let mut live = Watched::start(controls(method), true);
        live.until(LiveRefine::ended);
        assert_eq!(live.course(), course);
        let options = controls(method).into();
        let plain = refine(mesh(), options, &Recording::default(), &mut |_| true);
        let (plain, _) = plain.expect("refined");
        let timeline = live.live.timeline();
        let latest = timeline.latest().expect("states");
        assert_eq!(latest.mesh(), plain.mesh);
        assert_eq!(latest.control[..], plain.control.positions[..]);
        assert_eq!(timeline.states[0].mesh(), *mesh());
        let is_accepted = |e: &&Event<RefineEvent>| matches!(e, Event::Process(RefineEvent::Step { record, .. }) if !record.is_rejected());
        // the input mesh, the start of each level, every accepted step
        let accepted = live.events.iter().filter(is_accepted).count();
        assert_eq!(timeline.states.len(), 3 + accepted);
        let energies = |r: &[meniscus::refine::LevelReport]| -> Vec<f64> {
            r.iter().map(|l| l.energy_end).collect()
        };
        assert_eq!(
            energies(&live.live.status().reports),
            energies(&plain.levels)
        );
        // a plain run is repeated by the plain command
        assert_eq!(live.live.schedule(), Schedule::default());
    }
}

#[test]
fn it_waits_steps_changes_and_stops() {
    let mut live = Watched::start(controls(Method::Pde), false);
    live.until(|live| live.timeline().latest().is_some());
    live.live.step();
    live.until(|live| live.status().level == 1);
    assert!(!live.live.playing() && live.live.status().attempts == 0);
    live.live.step();
    live.until(|live| live.status().attempts == 1);
    let mut changed = controls(Method::Pde);
    changed.energy = Some("1".into());
    (changed.mode, changed.tau) = (Mode::Flow, Tau::Fixed(f64::NAN));
    assert!(live.live.set_controls(&changed).is_err());
    changed.tau = Tau::Auto;
    live.live.set_controls(&changed).expect("options");
    live.live.step();
    live.until(|live| live.status().attempts == 2);
    assert_eq!(live.course(), "Lsos");
    live.live.stop();
    live.until(LiveRefine::ended);
    assert_eq!(live.course(), "LsosdF");
    assert_eq!(live.live.status().reports[0].end, End::Cancelled);
}

#[test]
fn a_finished_one_goes_on_to_another_level() {
    let mut live = Watched::start(controls(Method::Pde), true);
    live.until(LiveRefine::ended);
    let mut more = controls(Method::Pde);
    more.levels = 3;
    live.live.set_controls(&more).expect("options");
    live.until(|live| live.status().reports.len() == 3 && live.ended());
    assert_eq!(live.course(), "LsdLsdFoLsdF");
    let again = repeated(&controls(Method::Pde), &live.live.schedule(), 2);
    assert_eq!(live.latest().mesh(), again.mesh);
}

/// Controls of all kinds are changed, the refinement goes back twice, also to an earlier level, and
/// is finished: its recording repeats it, and so does the command line.
#[test]
fn changes_and_rewinds_are_repeated_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    save_mesh(&at("in.obj"), &mesh()).expect("written");
    let read = open(&at("in.obj")).expect("read back").mesh;
    assert_eq!(read.positions, mesh().positions);
    let mut start = controls(Method::Pde);
    start.mode = Mode::Flow;
    let mut live = Watched::start(start.clone(), false);
    live.until(|live| live.timeline().latest().is_some());
    live.steps(4);
    let early = live.latest();
    assert!(early.frame.level == 1 && early.step > 0);
    let mut changed = start.clone();
    changed.energy = Some("H^2+a*K^2".into());
    changed.param.insert("a".into(), 0.1);
    (changed.tension, changed.steps) = (Some(0.5), 8);
    live.live.set_controls(&changed).expect("options");
    // to the second level, and into it
    live.live.play();
    live.until(|live| live.ended() || (live.status().level == 2 && live.status().attempts > 9));
    live.live.pause();
    let second = live.latest();
    assert_eq!(second.frame.level, 2);
    assert!(live.live.rewind_to(early.serial) && !live.live.rewind_to(9999));
    live.until_event(|e| matches!(e, Event::Rewound { .. }));
    assert_eq!(live.latest().points, early.points);
    live.until(|live| live.status().level == 1);
    assert!(live.live.status().reports.is_empty());
    live.steps(2);
    changed.mode = Mode::Fast;
    live.live.set_controls(&changed).expect("options");
    live.steps(1);
    // forward again: every stored state can be restored
    assert!(live.live.rewind_to(second.serial));
    live.until(|live| live.status().level == 2);
    changed.levels = 3;
    live.live.set_controls(&changed).expect("options");
    live.steps(2);
    let middle = live.latest();
    live.live.finish();
    live.until(LiveRefine::ended);
    assert_eq!(live.live.status().reports.len(), 3);
    let last = live.latest();
    for state in [&early, &second, &middle, &last] {
        let schedule = state.schedule();
        assert_eq!(Schedule::parse(&schedule.to_csv()), Ok(schedule.clone()));
        for threads in [1, 2] {
            let again = repeated(&start, &schedule, threads);
            assert!(
                state.mesh() == again.mesh,
                "{threads} threads: {schedule:?}"
            );
            assert_eq!(state.control[..], again.control.positions[..]);
        }
    }
    save_mesh(&at("live.obj"), &last.mesh()).expect("written");
    std::fs::write(at("s.csv"), last.schedule().to_csv()).expect("written");
    command(&start, &at("in.obj"), &at("out.obj"), &at("s.csv"))
        .assert()
        .success();
    let bytes = |name: &str| std::fs::read(at(name)).expect("there");
    assert!(bytes("live.obj") == bytes("out.obj"));
}

fn command(
    controls: &RefineControls,
    input: &Path,
    output: &Path,
    schedule: &Path,
) -> assert_cmd::Command {
    let mut command = assert_cmd::Command::cargo_bin("meniscus").expect("the program");
    command.arg("refine").arg(input).arg("-o").arg(output);
    command.args(controls.to_arguments()).arg("--quiet");
    command.arg("--schedule").arg(schedule);
    command
}

#[test]
fn a_state_returned_to_and_accepted_at_once_is_repeated() {
    let start = controls(Method::Pde);
    let mut live = Watched::start(start.clone(), true);
    live.until(LiveRefine::ended);
    let timeline = live.live.timeline();
    let earlier = &timeline.states[timeline.states.len() / 2];
    live.live.pause();
    assert!(live.live.rewind_to(earlier.serial));
    live.until(|live| !live.ended());
    live.live.stop();
    live.until(LiveRefine::ended);
    let state = live.latest();
    assert_eq!(state.mesh(), repeated(&start, &state.schedule(), 1).mesh);
}

#[test]
fn what_cannot_be_changed_on_the_way_is_refused_with_its_line() {
    let rows = |text: &str| Schedule::parse(&format!("attempt,control,value\n{text}\n"));
    for (text, wanted) in [
        ("1,method,loop", "line 2: `method` cannot be changed"),
        (
            "1,density,2",
            "line 2: unknown control `density`; controls are levels",
        ),
        ("1,tau,soon", "line 2: `soon` is not a valid number"),
        ("1,energy,H^", "line 2: energy: at character"),
        ("1,rewind,2", "line 2: after 1 attempts there is no state 2"),
    ] {
        let recording = rows(text).expect("rows").recording(&controls(Method::Pde));
        let error = recording.expect_err("an error").to_string();
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn a_panic_is_an_event() {
    let (bell, woken) = channel();
    let first = AtomicBool::new(true);
    let wake = Arc::new(move || {
        bell.send(()).ok();
        assert!(!first.swap(false, Ordering::Relaxed), "a bell that breaks");
    });
    let controls = controls(Method::Pde);
    let spawned = LiveRefine::spawn(mesh(), controls, Vec::new(), None, settings(true), wake);
    let mut live = spawned.expect("thread");
    while !live.ended() {
        woken.recv_timeout(Duration::from_mins(1)).expect("woken");
        live.poll();
    }
    assert_eq!(live.failed(), Some("a bell that breaks"));
}

#[test]
fn dropping_waits_for_nothing_and_ends_the_thread() {
    let (bell, woken) = channel();
    let wake = Arc::new(move || {
        bell.send(()).ok();
    });
    let mut controls = controls(Method::Pde);
    controls.levels = 5;
    let spawned = LiveRefine::spawn(mesh(), controls, Vec::new(), None, settings(true), wake);
    drop(spawned.expect("thread"));
    // the bell is dropped with the thread
    while woken.recv_timeout(Duration::from_mins(1)).is_ok() {}
    assert!(matches!(
        woken.try_recv(),
        Err(std::sync::mpsc::TryRecvError::Disconnected)
    ));
}
