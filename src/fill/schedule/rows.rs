//! Controls and their changes as rows of a schedule.

use std::collections::BTreeMap;
use std::str::FromStr;

use super::{Fault, Row};
use crate::fill::controls;
use crate::fill::{Choice, Continuity, Controls, TauChoice};

/// The rows that turn `from` into `to`.
pub(super) fn difference(attempt: usize, from: &Controls, to: &Controls) -> Vec<Row> {
    controls::difference(from, to)
        .into_iter()
        .map(|(control, value)| Row {
            attempt,
            control: control.into(),
            value,
        })
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
