//! Warnings and errors with hints that name options of the command line.

use crate::cli::UsageError;
use crate::cli::print::say;
use crate::energy::ExprError;
use crate::fill::FillError;
use crate::warning::{Warning, WhyLeft};

/// Prints warnings, each with its hint on a line of its own.
pub fn print_warnings<'a>(prefix: &str, warnings: impl IntoIterator<Item = &'a Warning>) {
    for warning in warnings {
        say(&format!("{prefix}{warning}"));
        if let Some(hint) = hint(warning) {
            say(&format!("  hint: {hint}"));
        }
    }
}

/// The remedy for a warning, with the options of the command line.
fn hint(warning: &Warning) -> Option<&'static str> {
    Some(match warning {
        Warning::SmoothRim => "use --continuity g0, or a fourth-order energy such as H^2",
        Warning::StepSizeCollapsed => "try another --energy, or a fixed time step with --tau",
        Warning::StepLimit { mixed: false, .. } => "allow more steps with --steps",
        Warning::StepLimit { mixed: true, .. } => {
            "allow more steps with --steps, or use --scheme mixed-corrected, whose vertices \
             do not drift along the surface"
        }
        Warning::Frozen { .. } => "increase --tension, or use a finer mesh there",
        Warning::IslandsLeft { why, .. } => match why {
            WhyLeft::InsideOut => {
                "join the loops with `meniscus blend`, --loops and --flip, or remove the island \
                 with `meniscus clean`"
            }
            _ => "remove the islands with `meniscus clean` if they are no part of the surface",
        },
        Warning::IntersectingResult { .. } => "increase --tension",
        Warning::RoundedEdges { .. } => "keep them sharp with --crease-angle 30",
        _ => return warning.hint(),
    })
}

/// An error with the options that lower the memory that a fill takes, if that is the error.
pub fn with_memory_hint(error: FillError) -> anyhow::Error {
    match error {
        FillError::Memory(_) => anyhow::anyhow!(
            "{error}\n  hint: choose a lower --density, or fewer holes with --loops"
        ),
        _ => error.into(),
    }
}

/// The error of an invalid `--energy`.
pub fn invalid_energy(error: &ExprError) -> UsageError {
    let mut text = format!("--energy\n{}", error.render());
    if let Some(name) = error.syntax().and_then(|e| e.unknown.as_ref()) {
        text += "\n  hint: give a parameter its value with --param ";
        text += name;
        text += "=VALUE";
    }
    UsageError(text)
}
