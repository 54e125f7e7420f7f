//! Controls as arguments of `meniscus fill`, and the differences of two sets of them.

use std::collections::BTreeMap;

use super::{Choice, Controls, TauChoice};

impl Controls {
    /// The arguments of `meniscus fill` that set these controls; only what differs from the
    /// default. Each flag is one argument followed by its value as another, not quoted for a shell.
    pub fn to_arguments(&self) -> Vec<String> {
        difference(&Self::default(), self)
            .into_iter()
            .flat_map(|(name, value)| [format!("--{name}"), value])
            .collect()
    }
}

/// What turns `from` into `to`: names of controls, which are those of the flags, and their values
/// as on the command line; a value that is taken back is empty, one left to the program `auto`.
pub(in crate::fill) fn difference(from: &Controls, to: &Controls) -> Vec<(&'static str, String)> {
    let mut out = Vec::new();
    let mut row = |name, value: String| out.push((name, value));
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
    out
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

/// The shortest decimal that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e9).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}
