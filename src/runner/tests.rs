use std::convert::Infallible;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use super::*;
use crate::options::options;

options! {
    /// Controls of a counter.
    struct CounterControls {
        /// The increment of a step.
        add("N"): usize = 1,
        /// Number of steps.
        count("N"): usize = 20,
        /// Start.
        start("N"): usize = 0,
    }
}

#[derive(Debug, thiserror::Error)]
#[error("add is 0")]
struct AddsNothing;

impl RunControls for CounterControls {
    const FIXED: &'static [&'static str] = &["start"];
    const FASTEST: &'static [(&'static str, &'static str)] = &[("add", "100")];
    type Error = AddsNothing;

    fn validate(&self) -> Result<(), AddsNothing> {
        if self.add == 0 {
            Err(AddsNothing)
        } else {
            Ok(())
        }
    }
}

/// A number that depends on all controls of all steps, and the number of steps.
#[derive(Clone, Debug, PartialEq)]
struct Count {
    value: usize,
    steps: usize,
}

impl TimelineState for Count {
    fn bytes(&self, _: Option<&Self>) -> usize {
        16
    }
}

struct Counter {
    controls: CounterControls,
    state: Arc<Count>,
    is_new: bool,
    stopped: bool,
    /// Called before a status is returned.
    before_status: Option<Box<dyn FnMut() + Send>>,
}

impl Counter {
    fn new(controls: CounterControls) -> Self {
        let (value, steps) = (controls.start, 0);
        Self {
            controls,
            state: Arc::new(Count { value, steps }),
            is_new: true,
            stopped: false,
            before_status: None,
        }
    }
}

impl Process for Counter {
    type Controls = CounterControls;
    type State = Count;
    type Event = usize;
    type Status = usize;
    type Error = Infallible;

    fn advance(&mut self, clock: usize, emit: &mut dyn FnMut(usize)) -> Result<(), Infallible> {
        if !self.ended() {
            let value = self
                .state
                .value
                .wrapping_mul(31)
                .wrapping_add(self.controls.add);
            let steps = self.state.steps + 1;
            self.state = Arc::new(Count { value, steps });
            self.is_new = true;
            emit(clock);
        }
        Ok(())
    }

    fn set_controls(&mut self, controls: &CounterControls) -> Vec<Refused> {
        if controls.add == 13 {
            let (part, text) = (None, "13 is refused".into());
            return vec![Refused { part, text }];
        }
        self.controls = controls.clone();
        Vec::new()
    }

    fn rewind(&mut self, to: &Arc<Count>, controls: &CounterControls) -> Vec<Refused> {
        (self.state, self.controls) = (Arc::clone(to), controls.clone());
        (self.stopped, self.is_new) = (false, false);
        Vec::new()
    }

    fn stop(&mut self, _: &mut dyn FnMut(usize)) {
        self.stopped = true;
    }

    fn ended(&self) -> bool {
        self.stopped || self.state.steps >= self.controls.count
    }

    fn has_new_state(&self) -> bool {
        self.is_new
    }

    fn state(&mut self) -> Result<Arc<Count>, Infallible> {
        self.is_new = false;
        Ok(Arc::clone(&self.state))
    }

    fn status(&mut self, _: f64, _: &mut dyn FnMut(usize)) -> usize {
        if let Some(before_status) = &mut self.before_status {
            before_status();
        }
        self.state.steps
    }

    fn pauses(&clock: &usize) -> bool {
        clock == 17
    }
}

struct Watched {
    runner: Runner<Counter>,
    woken: Receiver<()>,
    events: Vec<Event<usize>>,
}

impl Watched {
    fn start(playing: bool) -> Self {
        Self::start_with(playing, None)
    }

    fn start_with(playing: bool, before_status: Option<Box<dyn FnMut() + Send>>) -> Self {
        let (bell, woken) = channel();
        let wake = Arc::new(move || {
            bell.send(()).ok();
        });
        let settings = RunSettings {
            playing,
            pace: None,
            timeline_bytes: 1 << 16,
        };
        let controls = CounterControls::default();
        let first = controls.clone();
        let set_up = move || {
            let mut counter = Counter::new(first);
            counter.before_status = before_status;
            Ok::<_, Infallible>(counter)
        };
        let runner = Runner::start("counter", controls, settings, wake, set_up);
        Self {
            runner: runner.expect("a thread"),
            woken,
            events: Vec::new(),
        }
    }

    fn until(&mut self, is_there: impl Fn(&Runner<Counter>, &[Event<usize>]) -> bool) {
        loop {
            self.events.extend(self.runner.poll());
            if is_there(&self.runner, &self.events) {
                return;
            }
            let waited = self.woken.recv_timeout(Duration::from_mins(1));
            assert!(waited.is_ok(), "{:?}", self.events);
        }
    }

    fn steps(&mut self, count: usize) {
        for _ in 0..count {
            let clock = self.runner.clock();
            self.runner.step();
            self.until(|runner, _| runner.clock() > clock);
        }
    }

    fn set(&mut self, add: usize, count: usize) {
        let start = 0;
        let controls = CounterControls { add, count, start };
        self.runner.set_controls(&controls).expect("valid");
    }
}

fn repeated(schedule: &Schedule) -> Count {
    let start = CounterControls::default();
    let mut counter = Counter::new(start.clone());
    let recording = schedule.recording(&start).expect("a schedule");
    let Ok(_) = replay(&mut counter, &recording, &mut |_| true);
    (*counter.state).clone()
}

#[test]
fn every_state_of_a_changed_run_is_repeated() {
    let mut run = Watched::start(false);
    run.until(|_, events| !events.is_empty());
    run.steps(2);
    // two changes before a step count as one
    run.set(5, 20);
    run.set(3, 20);
    run.steps(3);
    run.runner.rewind_to(1);
    run.steps(2);
    run.set(13, 20);
    run.steps(1);
    run.set(4, 12);
    run.runner.finish();
    run.until(|runner, _| runner.ended());
    // an ended run continues with other controls, and from an earlier state
    run.set(4, 14);
    run.until(|runner, _| runner.ended() && *runner.status() == 14);
    run.runner.pause();
    run.runner.rewind_to(7);
    run.until(|runner, _| !runner.ended());
    run.runner.stop();
    run.until(|runner, _| runner.ended());
    let timeline = run.runner.timeline();
    assert!(timeline.states.len() > 20);
    for state in &timeline.states {
        let schedule = state.schedule();
        assert_eq!(Schedule::parse(&schedule.to_csv()), Ok(schedule.clone()));
        assert_eq!(repeated(&schedule), *state.state, "{schedule:?}");
    }
    let is_refused = |e: &&Event<usize>| matches!(e, Event::Refused(_));
    assert_eq!(run.events.iter().filter(is_refused).count(), 1);
    let is_end = |e: &&Event<usize>| matches!(e, Event::Ended);
    assert_eq!(run.events.iter().filter(is_end).count(), 3);
}

#[test]
fn a_run_pauses_by_itself_unless_it_is_to_finish() {
    let mut run = Watched::start(true);
    run.until(|_, events| events.iter().any(|e| matches!(e, Event::Paused)));
    assert!(!run.runner.playing() && run.runner.clock() == 17 && !run.runner.ended());
    let mut run = Watched::start(false);
    run.runner.finish();
    run.until(|runner, _| runner.ended());
    assert!(!run.events.iter().any(|e| matches!(e, Event::Paused)));
}

#[test]
fn events_are_returned_with_the_status_after_them() {
    let (enter, entered) = channel();
    let (open, opened) = channel::<()>();
    let before_status = move || {
        enter.send(()).ok();
        opened.recv().ok();
    };
    let mut run = Watched::start_with(false, Some(Box::new(before_status)));
    run.runner.step();
    let minute = Duration::from_mins(1);
    for clock in 0..2 {
        // the events of the action are sent, its status is not
        entered.recv_timeout(minute).expect("a status");
        assert!(run.runner.poll().is_empty());
        open.send(()).expect("a thread");
        run.until(|_, events| events.len() > clock);
        assert_eq!(run.runner.clock(), clock);
    }
}

#[test]
fn an_observer_ends_a_replay() {
    let mut counter = Counter::new(CounterControls::default());
    let Ok(refused) = replay(&mut counter, &Recording::default(), &mut |clock| clock < 4);
    assert!(refused.is_empty() && counter.stopped && counter.state.steps == 4);
}

#[test]
fn invalid_controls_are_refused_at_once_and_in_a_schedule() {
    let mut run = Watched::start(false);
    let none = CounterControls {
        add: 0,
        ..CounterControls::default()
    };
    assert!(run.runner.set_controls(&none).is_err());
    assert_eq!(*run.runner.controls(), CounterControls::default());
    for (row, wanted) in [
        ("3,add,0", "line 2: add is 0"),
        (
            "3,start,1",
            "line 2: `start` cannot be changed while a run is in progress",
        ),
        (
            "3,sub,1",
            "line 2: unknown control `sub`; controls are add, count, finish",
        ),
        ("3,rewind,4", "line 2: after 3 attempts there is no state 4"),
    ] {
        let schedule = Schedule::parse(&format!("attempt,control,value\n{row}\n"));
        let recording = schedule
            .expect("a row")
            .recording(&CounterControls::default());
        let error = recording.expect_err("an error").to_string();
        assert!(error.contains(wanted), "{error}");
    }
}
