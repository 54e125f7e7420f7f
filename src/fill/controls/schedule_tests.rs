//! Schedules of fills.

use super::*;
use crate::options::Options;
use crate::runner::{Change, Schedule, ScheduleEntry};

/// Controls that differ from the default in everything.
fn changed() -> Controls {
    Controls {
        energy: "max(H,-H)^2 + a*K^2".into(),
        param: [("a".into(), 1.0 / 3.0), ("b".into(), -1e-300)].into(),
        surface: Surface::G2,
        symmetry: Symmetry::Off,
        features: Features::Off,
        scheme: Scheme::Mixed,
        mode: Mode::Flow,
        linear: Linear::Lu,
        tau: Tau::Fixed(0.1 + 0.2),
        growth: Some(1.7),
        relaxation: 0.25,
        tension: 0.125,
        bulge: -0.5,
        noise: 0.25,
        density: 1.5,
        continuity: Continuity::G0,
        loop_continuity: [(2.into(), Continuity::G1)].into(),
        label_patches: true,
        patch_texture: PatchTexture::Own,
        steps: 17,
    }
}

fn schedule(rows: &[(usize, &str, &str)]) -> Schedule {
    let row = |&(attempt, control, value): &(usize, &str, &str)| ScheduleEntry {
        attempt,
        control: control.into(),
        value: value.into(),
    };
    Schedule {
        entries: rows.iter().map(row).collect(),
    }
}

/// The rows of a difference, written and read back, make the change exactly.
#[test]
fn every_control_goes_to_rows_and_back() {
    for (from, to) in [
        (Controls::default(), changed()),
        (changed(), Controls::default()),
    ] {
        let row = |(control, value)| ScheduleEntry {
            attempt: 2,
            control,
            value,
        };
        let written = Schedule {
            entries: from.difference(&to).into_iter().map(row).collect(),
        };
        let read = Schedule::parse(&written.to_csv()).expect("as written");
        assert_eq!(read, written);
        let mut controls = from.clone();
        for row in &read.entries {
            controls.set(&row.control, &row.value).expect("as written");
        }
        assert_eq!(controls, to);
        assert!(to.difference(&controls).is_empty());
    }
}

#[test]
fn values_with_commas_and_quotes_come_back() {
    for value in ["max(H,K)", "a \"b\" c", "", " x ", "1,2"] {
        let written = schedule(&[(1, "energy", value)]);
        assert_eq!(Schedule::parse(&written.to_csv()), Ok(written));
    }
    // a value without quotes may hold commas all the same
    let read = Schedule::parse("attempt,control,value\n3, energy , max(H,K)\n").expect("a row");
    assert_eq!(read, schedule(&[(3, "energy", "max(H,K)")]));
}

#[test]
fn errors_name_line_and_remedy() {
    for (text, wanted) in [
        (
            "",
            "line 1: the header is missing; the first line is `attempt,control,value`",
        ),
        (
            "attempt,control,value\n1,energy",
            "line 2: `1,energy` has no three columns",
        ),
        (
            "attempt,control,value\nx,stop,",
            "line 2: `x` is not a number of attempts",
        ),
        (
            "attempt,control,value\n5,finish,\n4,stop,",
            "line 3: attempt 4 comes after 5; sort the rows by attempt",
        ),
    ] {
        let error = Schedule::parse(text).expect_err("a fault").to_string();
        assert!(error.contains(wanted), "{error}");
    }
    for (rows, wanted) in [
        (
            &[(1, "enrgy", "1")][..],
            "line 2: unknown control `enrgy`; controls are energy",
        ),
        (
            &[(1, "scheme", "fast")],
            "line 2: `fast` is not one of the choices; choose normal or",
        ),
        (
            &[(1, "tau", "soon")],
            "line 2: `soon` is not a valid number; write `auto` or a positive number",
        ),
        (
            &[(1, "tau", "auto"), (2, "tau", "-1")],
            "line 3: tau is -1; a time step is a positive",
        ),
        (
            &[(1, "param", "a")],
            "line 2: `a` has no `=`; write NAME=VALUE",
        ),
        (
            &[(4, "rewind", "5")],
            "line 2: after 4 attempts there is no state 5",
        ),
        (&[(4, "energy", "H^2+")], "line 2: energy: at character 5"),
        (
            &[(4, "density", "0")],
            "line 2: density must be a positive number, not 0",
        ),
        (
            &[(4, "relaxation", "2")],
            "line 2: relaxation is 2; a weight is a number from 0 to 1",
        ),
        (&[(4, "growth", "0.5")], "line 2: growth is 0.5; the factor"),
        (
            &[(4, "loop-continuity", "x=g0")],
            "line 2: `x` is not a valid number",
        ),
    ] {
        let error = schedule(rows)
            .recording(&Controls::default())
            .expect_err("a fault");
        assert!(error.to_string().contains(wanted), "{error}");
    }
    let invalid = Controls {
        energy: "H^".into(),
        ..Controls::default()
    };
    assert!(Schedule::default().recording(&invalid).is_err());
}

/// An energy and its parameter may come in any order: only the combination is checked.
#[test]
fn rows_of_one_attempt_are_one_change() {
    let schedule = schedule(&[
        (1, "energy", "H^2+a*K^2"),
        (1, "param", "a=2"),
        (1, "finish", ""),
        (1, "scheme", "mixed"),
        (3, "scheme", "normal"),
    ]);
    let recording = schedule.recording(&Controls::default()).expect("fine");
    let attempts: Vec<usize> = recording.changes.iter().map(|c| c.0).collect();
    assert_eq!(attempts, [1, 1, 1, 3]);
}

#[test]
fn finishing_lasts_until_the_pace_is_changed() {
    let start = Controls {
        mode: Mode::Flow,
        tau: Tau::Fixed(0.5),
        ..Controls::default()
    };
    let schedule = schedule(&[
        (1, "finish", ""),
        (2, "energy", "K^2"),
        (3, "tau", "0.25"),
        (4, "finish", ""),
        (5, "rewind", "2"),
    ]);
    let recording = schedule.recording(&start).expect("fine");
    let paces = recording.changes.iter().map(|(_, change)| match change {
        Change::Controls(controls) | Change::Rewind { controls, .. } => {
            let flow = controls.options().expect("valid").flow;
            (flow.mode, flow.tau)
        }
        Change::Stop => unreachable!("no such row"),
    });
    assert_eq!(
        paces.collect::<Vec<_>>(),
        [
            (Mode::Fast, Tau::Auto),
            (Mode::Fast, Tau::Auto),
            (Mode::Flow, Tau::Fixed(0.25)),
            (Mode::Fast, Tau::Auto),
            (Mode::Flow, Tau::Fixed(0.25)),
        ]
    );
}
