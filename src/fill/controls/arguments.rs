//! Controls as arguments of `meniscus fill`.

use super::{Choice, Controls, TauChoice};

impl Controls {
    /// The arguments of `meniscus fill` that set these controls; only what differs from the
    /// default. Each flag is one argument followed by its value as another, not quoted for a shell.
    pub fn to_arguments(&self) -> Vec<String> {
        let plain = Self::default();
        let mut out = Vec::new();
        let mut flag = |name: &str, value: String| out.extend([format!("--{name}"), value]);
        if self.energy != plain.energy {
            flag("energy", self.energy.clone());
        }
        for (name, &value) in &self.params {
            flag("param", format!("{name}={}", number(value)));
        }
        if self.scheme != plain.scheme {
            flag("scheme", self.scheme.name().into());
        }
        if self.mode != plain.mode {
            flag("mode", self.mode.name().into());
        }
        if self.linear != plain.linear {
            flag("linear", self.linear.name().into());
        }
        if let TauChoice::Fixed(tau) = self.tau {
            flag("tau", number(tau));
        }
        if let Some(growth) = self.growth {
            flag("growth", number(growth));
        }
        if self.relaxation != plain.relaxation {
            flag("relaxation", number(self.relaxation));
        }
        if self.tension != plain.tension {
            flag("tension", number(self.tension));
        }
        if self.bulge != plain.bulge {
            flag("bulge", number(self.bulge));
        }
        if self.noise != plain.noise {
            flag("noise", number(self.noise));
        }
        if self.density != plain.density {
            flag("density", number(self.density));
        }
        if self.continuity != plain.continuity {
            flag("continuity", self.continuity.name().into());
        }
        for (number, continuity) in &self.loop_continuity {
            flag("loop-continuity", format!("{number}={}", continuity.name()));
        }
        if self.max_steps != plain.max_steps {
            flag("steps", self.max_steps.to_string());
        }
        out
    }
}

/// The shortest decimal that reads back as the same number.
pub(in crate::fill) fn number(value: f64) -> String {
    if value == 0.0 || (1e-4..1e9).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}
