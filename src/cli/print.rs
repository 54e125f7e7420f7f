//! Standard output for programs that may stop listening.

use std::io::{ErrorKind, Write};

use anyhow::Result;

/// Writes text to standard output. A reader that has gone away (`meniscus info … | head`) is no
/// error; any other failure, such as a full disk, is.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("cannot write to standard output"))
        }
        _ => Ok(()),
    }
}
