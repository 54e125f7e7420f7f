//! The `meniscus` program.

use std::process::ExitCode;

use clap::Parser;
use meniscus::app::{Startup, run as open_window};
use meniscus::cli::{Arguments, UsageError, run};

fn main() -> ExitCode {
    // wrong usage ends here with exit code 2, --help and --version with 0
    let arguments = Arguments::parse();
    let result = match arguments.command {
        Some(command) => run(command),
        None => open_window(Startup {
            file: arguments.file,
            diagnostics: arguments.diagnostics,
        })
        .map_err(Into::into),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("meniscus: {}", words(&error));
            if error.is::<UsageError>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

/// The message with its causes, but for those it names itself.
fn words(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}
