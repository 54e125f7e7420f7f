//! Option structs as command-line arguments.

use clap::builder::PossibleValuesParser;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use crate::options::{Kind, OptionEntry, Options};

/// The options `T`, each as a flag of the same name.
#[derive(Clone, Debug, Default)]
pub struct OptionArguments<T>(pub T);

impl<T: Options> Args for OptionArguments<T> {
    fn augment_args(command: Command) -> Command {
        command.args(T::entries().into_iter().map(argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: Options> FromArgMatches for OptionArguments<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut options = T::default();
        let is_given = |name: &str| {
            let source = matches
                .try_contains_id(name)
                .is_ok()
                .then(|| matches.value_source(name));
            source.flatten() == Some(ValueSource::CommandLine)
        };
        // a given energy is the one to use
        if is_given("energy") && T::entries().iter().any(|e| e.name == "surface") {
            set(&mut options, "surface", "energy")?;
        }
        for entry in T::entries().into_iter().filter(|e| is_given(&e.name)) {
            if entry.kind == Kind::Flag {
                if matches.get_flag(&entry.name) {
                    set(&mut options, &entry.name, "true")?;
                }
                continue;
            }
            for text in matches
                .get_many::<String>(&entry.name)
                .into_iter()
                .flatten()
            {
                set(&mut options, &entry.name, text)?;
            }
        }
        Ok(Self(options))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The text is valid, because the parser of the argument has accepted it.
fn set<T: Options>(options: &mut T, name: &str, text: &str) -> Result<(), clap::Error> {
    let error = |e| clap::Error::raw(clap::error::ErrorKind::InvalidValue, format!("{e}\n"));
    options.set(name, text).map_err(error)
}

fn argument<T: Options>(entry: OptionEntry<T>) -> Arg {
    let name = entry.name;
    let arg = Arg::new(&name)
        .long(&name)
        .help(entry.help.trim().trim_end_matches('.'));
    if entry.kind == Kind::Flag {
        return arg.action(ArgAction::SetTrue);
    }
    let is_list = entry.kind == Kind::Pairs;
    let arg = arg
        .action(if is_list {
            ArgAction::Append
        } else {
            ArgAction::Set
        })
        .allow_negative_numbers(true)
        .allow_hyphen_values(entry.kind == Kind::Text);
    let arg = match entry.value_name {
        Some(value_name) => arg.value_name(value_name),
        None => arg,
    };
    let arg = match entry.default {
        Some(text) => arg.default_value(text),
        None => arg,
    };
    match entry.kind {
        Kind::Choice(names) => arg.value_parser(PossibleValuesParser::new(names)),
        _ => arg.value_parser(move |text: &str| {
            let valid = T::default().set(&name, text);
            valid.map(|()| text.to_owned())
        }),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Arguments, Command};
    use crate::fill::{Continuity, Controls, Features, Linear, PatchTexture, Surface, Symmetry};
    use crate::refine::{BoundaryRule, Hold, Method, RefineControls};
    use crate::solver::{Mode, Scheme, Tau};

    fn parsed(command: &str, arguments: &[String]) -> Command {
        let words = ["meniscus", command, "a.obj", "-o", "b.obj"].map(String::from);
        let words = words.iter().chain(arguments);
        let parsed = Arguments::try_parse_from(words).expect("arguments");
        parsed.command.expect("a command")
    }

    fn controls(arguments: &[String]) -> Controls {
        match parsed("fill", arguments) {
            Command::Fill(args) => args.flow.controls.0,
            _ => unreachable!("a fill"),
        }
    }

    fn refine_controls(arguments: &[String]) -> RefineControls {
        match parsed("refine", arguments) {
            Command::Refine(args) => args.controls.0,
            _ => unreachable!("a refinement"),
        }
    }

    #[test]
    fn arguments_of_controls_read_back_as_the_controls() {
        assert_eq!(controls(&[]), Controls::default());
        let changed = Controls {
            energy: "-H^2 + a*K^2".into(),
            surface: Surface::Diffusion,
            symmetry: Symmetry::Off,
            features: Features::Off,
            param: [("a".into(), -1.0 / 3.0)].into(),
            scheme: Scheme::MixedCorrected,
            mode: Mode::Flow,
            linear: Linear::Lu,
            tau: Tau::Fixed(1e-7),
            growth: Some(1.3),
            relaxation: 0.5,
            tension: 0.125,
            bulge: -0.5,
            noise: 0.25,
            density: 0.8,
            continuity: Continuity::G0,
            loop_continuity: [(0.into(), Continuity::G1), (11.into(), Continuity::G0)].into(),
            steps: 3,
            label_patches: true,
            patch_texture: PatchTexture::Extend,
        };
        assert_eq!(controls(&changed.to_arguments()), changed);
    }

    #[test]
    fn arguments_of_refinements_read_back_as_their_controls() {
        assert_eq!(refine_controls(&[]), RefineControls::default());
        let changed = RefineControls {
            levels: 5,
            method: Method::Butterfly,
            energy: Some("-a*H^2".into()),
            param: [("a".into(), 1e-12)].into(),
            tension: Some(-0.125),
            hold: Hold::Given,
            boundary: BoundaryRule::Straight,
            corner_angle: 30.5,
            crease_angle: Some(1.0 / 3.0),
            mode: Mode::Flow,
            tau: Tau::Fixed(0.25),
            growth: Some(1.5),
            bulge: -0.5,
            steps: 7,
        };
        assert_eq!(refine_controls(&changed.to_arguments()), changed);
    }
}
