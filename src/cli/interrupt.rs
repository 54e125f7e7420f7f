//! Interruption by Ctrl-C (SIGINT) and by SIGTERM.

/// Ends the program on SIGINT with exit code 130 and on SIGTERM with 143, without temporary files
/// left behind. Where this cannot be arranged, the system ends it.
pub fn watch() {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGINT, SIGTERM};
        use signal_hook::iterator::Signals;

        let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
            return;
        };
        std::thread::spawn(move || {
            if let Some(signal) = signals.forever().next() {
                crate::io::abandon_unfinished();
                std::process::exit(128 + signal);
            }
        });
    }
}
