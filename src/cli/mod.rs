//! The headless commands.

mod args;
mod blend;
mod demo;
mod fill;
mod info;
mod memory;
mod print;
mod progress;
mod refill;
mod report;

pub use args::{Arguments, Command};

use anyhow::Result;

/// An argument that the grammar lets through but nothing can be done with; exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Runs a parsed command line.
///
/// # Errors
/// Anything that keeps the command from doing its job; the message is for the person at the
/// terminal. It is a [`UsageError`] if the command line is to blame.
pub fn run(arguments: Arguments) -> Result<()> {
    match arguments.command {
        Some(Command::Fill(args)) => fill::fill(&args),
        Some(Command::Blend(args)) => blend::blend(&args),
        Some(Command::Refill(args)) => refill::refill(&args),
        Some(Command::Info(args)) => info::info(&args),
        Some(Command::Demo(args)) => demo::demo(&args),
        None => {
            eprintln!(
                "No command given: running `meniscus demo` in the current folder \
                 (see `meniscus --help`)."
            );
            demo::demo(&args::DemoArguments::default())
        }
    }
}
