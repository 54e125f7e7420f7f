//! Controls and their changes as rows of a schedule.

use std::collections::BTreeMap;
use std::str::FromStr;

use super::{Fault, Row};
use crate::fill::controls::number;
use crate::fill::{Choice, Continuity, Controls, TauChoice};

/// The rows that turn `from` into `to`.
pub(super) fn difference(attempt: usize, from: &Controls, to: &Controls) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut row = |control: &str, value: String| {
        rows.push(Row {
            attempt,
            control: control.into(),
            value,
        });
    };
    if from.energy != to.energy {
        row("energy", to.energy.clone());
    }
    for (name, value) in changes(&from.params, &to.params) {
        row(
            "param",
            format!("{name}={}", value.map_or_else(String::new, |v| number(*v))),
        );
    }
    if from.scheme != to.scheme {
        row("scheme", to.scheme.name().into());
    }
    if from.mode != to.mode {
        row("mode", to.mode.name().into());
    }
    if from.linear != to.linear {
        row("linear", to.linear.name().into());
    }
    if from.tau != to.tau {
        row(
            "tau",
            match to.tau {
                TauChoice::Auto => "auto".into(),
                TauChoice::Fixed(tau) => number(tau),
            },
        );
    }
    if from.growth != to.growth {
        row("growth", to.growth.map_or_else(|| "auto".into(), number));
    }
    if from.relaxation != to.relaxation {
        row("relaxation", number(to.relaxation));
    }
    if from.tension != to.tension {
        row("tension", number(to.tension));
    }
    if from.bulge != to.bulge {
        row("bulge", number(to.bulge));
    }
    if from.noise != to.noise {
        row("noise", number(to.noise));
    }
    if from.density != to.density {
        row("density", number(to.density));
    }
    if from.continuity != to.continuity {
        row("continuity", to.continuity.name().into());
    }
    for (loop_, value) in changes(&from.loop_continuity, &to.loop_continuity) {
        let name = value.map_or("", |v| v.name());
        row("loop-continuity", format!("{loop_}={name}"));
    }
    if from.max_steps != to.max_steps {
        row("steps", to.max_steps.to_string());
    }
    rows
}

/// Keys with another value in `to`, `None` where it has none.
fn changes<'a, K: Ord, V: PartialEq>(
    from: &'a BTreeMap<K, V>,
    to: &'a BTreeMap<K, V>,
) -> Vec<(&'a K, Option<&'a V>)> {
    let gone = from.keys().filter(|k| !to.contains_key(k));
    let new = to.iter().filter(|(k, v)| from.get(k) != Some(v));
    gone.map(|k| (k, None))
        .chain(new.map(|(k, v)| (k, Some(v))))
        .collect()
}

/// Sets one control from a row.
pub(super) fn set(controls: &mut Controls, control: &str, value: &str) -> Result<(), Fault> {
    match control {
        "energy" => value.clone_into(&mut controls.energy),
        "param" => {
            let (name, value) = pair(value, "NAME=VALUE")?;
            set_entry(&mut controls.params, name.to_owned(), value, parse)?;
        }
        "scheme" => controls.scheme = choice(value)?,
        "mode" => controls.mode = choice(value)?,
        "linear" => controls.linear = choice(value)?,
        "tau" => {
            controls.tau = match value {
                "auto" => TauChoice::Auto,
                _ => TauChoice::Fixed(parse(value)?),
            }
        }
        "growth" => {
            controls.growth = match value {
                "auto" => None,
                _ => Some(parse(value)?),
            }
        }
        "relaxation" => controls.relaxation = parse(value)?,
        "tension" => controls.tension = parse(value)?,
        "bulge" => controls.bulge = parse(value)?,
        "noise" => controls.noise = parse(value)?,
        "density" => controls.density = parse(value)?,
        "continuity" => controls.continuity = choice(value)?,
        "loop-continuity" => {
            let (number, value) = pair(value, "LOOP=g0 or LOOP=g1")?;
            let number = parse(number)?;
            set_entry(
                &mut controls.loop_continuity,
                number,
                value,
                choice::<Continuity>,
            )?;
        }
        "steps" => controls.max_steps = parse(value)?,
        _ => {
            return Err(Fault::new(
                format!("there is no control `{control}`"),
                format!("controls are {}", NAMES.join(", ")),
            ));
        }
    }
    Ok(())
}

const NAMES: [&str; 18] = [
    "energy",
    "param",
    "scheme",
    "mode",
    "linear",
    "tau",
    "growth",
    "relaxation",
    "tension",
    "bulge",
    "noise",
    "density",
    "continuity",
    "loop-continuity",
    "steps",
    "finish",
    "rewind",
    "stop",
];

/// Sets an entry, or removes it where the value is empty.
fn set_entry<K: Ord, V>(
    map: &mut BTreeMap<K, V>,
    key: K,
    value: &str,
    read: impl Fn(&str) -> Result<V, Fault>,
) -> Result<(), Fault> {
    if value.is_empty() {
        map.remove(&key);
    } else {
        map.insert(key, read(value)?);
    }
    Ok(())
}

fn pair<'a>(value: &'a str, form: &str) -> Result<(&'a str, &'a str), Fault> {
    let parts = value.split_once('=').map(|(k, v)| (k.trim(), v.trim()));
    parts.ok_or_else(|| Fault::new(format!("`{value}` has no `=`"), format!("write {form}")))
}

pub(super) fn parse<T: FromStr>(value: &str) -> Result<T, Fault> {
    let value = value.trim();
    let fault = || Fault::new(format!("`{value}` is not a number"), "write a number");
    value.parse().map_err(|_| fault())
}

fn choice<T: Choice>(value: &str) -> Result<T, Fault> {
    T::named(value).ok_or_else(|| {
        let names: Vec<&str> = T::ALL.iter().map(|c| c.name()).collect();
        Fault::new(
            format!("`{value}` is none of the choices"),
            format!("choose {}", names.join(" or ")),
        )
    })
}
