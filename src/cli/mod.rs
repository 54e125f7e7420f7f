//! The commands that run without a window.

mod analyze;
mod args;
mod batch;
mod blend;
mod creases;
mod demo;
mod edit;
mod fill;
mod flow;
mod hints;
mod info;
mod interrupt;
mod options;
mod parse;
#[cfg(feature = "render")]
mod picture;
#[cfg(feature = "render")]
mod picture_args;
mod print;
mod progress;
mod refill;
mod refine;
#[cfg(feature = "render")]
mod render;
mod repair;
mod report;
#[cfg(feature = "render")]
mod result_picture;
#[cfg(not(feature = "render"))]
#[path = "no_picture.rs"]
mod result_picture;
mod sample;
mod selection;
mod side_by_side;
mod targets;
mod trace;

pub use args::{Arguments, Command};
pub use interrupt::watch as watch_interrupts;
pub use print::complain;

use anyhow::Result;

/// An invalid argument that the parser accepted; exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// The message of an error with its causes, but for those it names itself.
pub fn message(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Runs a command.
///
/// # Errors
/// The command failed. The error is a [`UsageError`] if the command line is invalid.
pub fn run(command: Command) -> Result<()> {
    match command {
        Command::Fill(args) => match &args.files.out_dir {
            Some(folder) => batch::batch(&args, folder),
            None => fill::fill(&args),
        },
        Command::Blend(args) => blend::blend(&args),
        Command::Bridge(args) => edit::bridge(&args),
        Command::Erase(args) => edit::erase(&args),
        Command::Flip(args) => edit::flip(&args),
        Command::Clean(args) => edit::clean(&args),
        Command::Stitch(args) => edit::stitch(&args),
        Command::Refill(args) => refill::refill(&args),
        Command::Repair(args) => repair::repair(&args),
        Command::Refine(args) => refine::refine(&args),
        Command::Analyze(args) => analyze::analyze(&args),
        Command::Info(args) => info::info(&args),
        Command::Demo(args) => demo::demo(&args),
        #[cfg(feature = "render")]
        Command::Render(args) => render::render(&args),
        Command::Sample(args) => sample::sample(&args),
    }
}
