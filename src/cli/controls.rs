//! The flags of everything a person may choose about a fill.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::fill::{Choice, Continuity, Controls, Linear, TauChoice};
use crate::mesh::LoopId;
use crate::solver::{Mode, Scheme};

/// Flags that make up [`Controls`].
#[derive(Clone, Debug, Args)]
pub struct ControlArguments {
    /// Energy f(H,K): a preset or an expression.
    #[arg(
        long,
        value_name = "F",
        default_value = "H^2",
        allow_hyphen_values = true
    )]
    pub energy: String,
    /// Value of a parameter of the energy (repeatable).
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameter)]
    pub param: Vec<(String, f64)>,
    /// Method: `normal` is the fast linearly implicit normal flow, `mixed` the paper's mixed finite
    /// elements, `mixed-corrected` the same matrix with the exact gradient.
    #[arg(long, default_value = "normal", value_parser = choice::<Scheme>())]
    pub scheme: Scheme,
    /// `fast` goes for the stationary shape, `flow` follows the flow in true time.
    #[arg(long, default_value = "fast", value_parser = choice::<Mode>())]
    pub mode: Mode,
    /// Linear solver of the mixed schemes.
    #[arg(long, default_value = "gmres", value_parser = choice::<Linear>())]
    pub linear: Linear,
    /// Time step: auto, or a fixed one.
    #[arg(long, value_name = "T", default_value = "auto", value_parser = tau, allow_negative_numbers = true)]
    pub tau: TauChoice,
    /// Factor of an adaptive time step after an accepted step: 10 in fast mode, 1.3 in flow mode.
    #[arg(long, value_name = "F", value_parser = growth, allow_negative_numbers = true)]
    pub growth: Option<f64>,
    /// Tangential relaxation after each accepted step: vertices slide towards the mean of their
    /// neighbours, by this weight from 0 to 1.
    #[arg(long, value_name = "W", default_value_t = 0.0, value_parser = weight, allow_negative_numbers = true)]
    pub relaxation: f64,
    /// Most steps to take.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub steps: usize,
    /// Weight of the area beside the energy, in units of 1/r^2, r the hole radius: more draws the
    /// surface together.
    #[arg(long, value_name = "W", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    pub tension: f64,
    /// Spontaneous curvature in units of 1/r: 1 favours spheres of the hole's radius that bulge along
    /// the normals, -1 such that sink in.
    #[arg(long, value_name = "C", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    pub bulge: f64,
    /// Noise on the surface the flow starts from, in mean edge lengths along the normals.
    #[arg(long, value_name = "A", default_value_t = 0.0, value_parser = amplitude, allow_negative_numbers = true)]
    pub noise: f64,
    /// Density of the patch relative to the rim: 2 halves the edge length.
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = density, allow_negative_numbers = true)]
    pub density: f64,
    /// How patches meet the mesh: `g1` smoothly, `g0` in a crease.
    #[arg(long, default_value = "g1", value_parser = choice::<Continuity>())]
    pub continuity: Continuity,
    /// The same for one loop, by its number (repeatable).
    #[arg(long, value_name = "LOOP=g0|g1", value_parser = loop_continuity)]
    pub loop_continuity: Vec<(LoopId, Continuity)>,
}

impl ControlArguments {
    /// The controls these flags stand for.
    pub fn controls(&self) -> Controls {
        Controls {
            energy: self.energy.clone(),
            params: self.param.iter().cloned().collect(),
            scheme: self.scheme,
            mode: self.mode,
            linear: self.linear,
            tau: self.tau,
            growth: self.growth,
            relaxation: self.relaxation,
            tension: self.tension,
            bulge: self.bulge,
            noise: self.noise,
            density: self.density,
            continuity: self.continuity,
            loop_continuity: self.loop_continuity.iter().copied().collect(),
            max_steps: self.steps,
        }
    }
}

pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::ALL.iter().map(|c| c.name()))
        .map(|name| T::named(&name).expect("one of the possible values"))
}

pub(crate) fn tau(text: &str) -> Result<TauChoice, String> {
    if text == "auto" {
        return Ok(TauChoice::Auto);
    }
    match text.parse::<f64>() {
        Ok(t) if t.is_finite() && t > 0.0 => Ok(TauChoice::Fixed(t)),
        _ => Err("give `auto` or a positive number".into()),
    }
}

fn growth(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(g) if g.is_finite() && g >= 1.0 => Ok(g),
        _ => Err("give a number of at least 1".into()),
    }
}

fn weight(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(w) if (0.0..=1.0).contains(&w) => Ok(w),
        _ => Err("give a number from 0 to 1".into()),
    }
}

pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("give a number".into()),
    }
}

fn amplitude(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(a) if a.is_finite() && a >= 0.0 => Ok(a),
        _ => Err("give a number of edge lengths, 0 for none".into()),
    }
}

fn density(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(d) if d.is_finite() && d > 0.0 => Ok(d),
        _ => Err("give a positive number".into()),
    }
}

pub(crate) fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("give NAME=VALUE, as in a=0.3")?;
    let value = value
        .trim()
        .parse::<f64>()
        .map_err(|_| format!("`{value}` is not a number"))?;
    Ok((name.trim().to_owned(), value))
}

fn loop_continuity(text: &str) -> Result<(LoopId, Continuity), String> {
    let parts = text.split_once('=');
    let read = parts.and_then(|(number, name)| {
        Some((number.trim().parse().ok()?, Continuity::named(name.trim())?))
    });
    read.ok_or_else(|| "give LOOP=g0 or LOOP=g1, as in 2=g0".into())
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Arguments, Command};

    fn parsed(arguments: &[String]) -> Controls {
        let words = ["meniscus", "fill", "a.obj", "-o", "b.obj"].map(String::from);
        let words = words.iter().chain(arguments);
        let parsed = Arguments::try_parse_from(words).expect("arguments");
        match parsed.command {
            Some(Command::Fill(args)) => args.controls.controls(),
            _ => unreachable!("a fill command"),
        }
    }

    #[test]
    fn arguments_of_controls_read_back_as_the_controls() {
        assert_eq!(parsed(&[]), Controls::default());
        let controls = Controls {
            energy: "-H^2 + a*K^2".into(),
            params: [("a".into(), -1.0 / 3.0)].into(),
            scheme: Scheme::MixedCorrected,
            mode: Mode::Flow,
            linear: Linear::Lu,
            tau: TauChoice::Fixed(1e-7),
            growth: Some(1.3),
            relaxation: 0.5,
            tension: 0.125,
            bulge: -0.5,
            noise: 0.25,
            density: 0.8,
            continuity: Continuity::G0,
            loop_continuity: [(0.into(), Continuity::G1), (11.into(), Continuity::G0)].into(),
            max_steps: 3,
        };
        assert_eq!(parsed(&controls.to_arguments()), controls);
    }
}
