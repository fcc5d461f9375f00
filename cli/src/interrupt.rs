//! A signal to stop: one line that says how to go on, and the exit code that shells expect.

/// From now on SIGINT, SIGTERM and SIGHUP end the program with this line and the exit code 128 + signal.
///
/// Files appear whole or not at all, so the program may end at any time.
#[cfg(unix)]
pub(super) fn watch(how_to_go_on: &'static str) {
    use std::io::{IsTerminal, stderr};

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // without the watch a signal ends the program all the same
    let Ok(mut signals) = Signals::new([SIGHUP, SIGINT, SIGTERM]) else {
        return;
    };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let name = signal_hook::low_level::signal_name(signal).unwrap_or("a signal");
            // a bar may stand in the line
            let end = if stderr().is_terminal() { "\n" } else { "" };
            super::complain(&format!("{end}stopped by {name}"), how_to_go_on);
            std::process::exit(128 + signal);
        }
    });
}

/// Elsewhere the system ends the program.
#[cfg(not(unix))]
pub(super) fn watch(_: &'static str) {}
