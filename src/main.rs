//! The `meniscus` program.

use std::process::ExitCode;

use clap::Parser;
use meniscus::cli::{Arguments, UsageError, complain, message, run, watch_interrupts};

fn main() -> ExitCode {
    // wrong usage ends here with exit code 2, --help and --version with 0
    let arguments = Arguments::parse();
    let result = match arguments.command {
        Some(command) => {
            watch_interrupts();
            run(command)
        }
        #[cfg(feature = "window")]
        None => meniscus::app::run(meniscus::app::Startup {
            file: arguments.file,
            diagnostics: arguments.diagnostics,
        })
        .map_err(Into::into),
        #[cfg(not(feature = "window"))]
        None => Err(UsageError(
            "this program was built without a window: name a command (`meniscus --help`)".into(),
        )
        .into()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&format!("meniscus: {}\n", message(&error)));
            if error.is::<UsageError>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}
