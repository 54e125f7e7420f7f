//! The `meniscus` program.

use std::process::ExitCode;

use clap::Parser;
use meniscus::cli::{Arguments, UsageError, run};

fn main() -> ExitCode {
    // wrong usage ends here with exit code 2, --help and --version with 0
    let arguments = Arguments::parse();
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("meniscus: {error:#}");
            if error.is::<UsageError>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}
