//! Ctrl-C: says what is kept, and ends with the documented exit code.

use super::cli::Cli;

/// From now on, an interrupt ends the process so.
#[cfg(unix)]
pub fn tell_when_interrupted(cli: &Cli) {
    use crate::exit::Exit;
    use crate::progress::say;
    use signal_hook::consts::SIGINT;
    use signal_hook::iterator::Signals;
    use std::io::IsTerminal;

    let message = message(cli);
    // Where no handler can be had, the system ends the process without a word, as it does by default.
    let Ok(mut signals) = Signals::new([SIGINT]) else { return };
    std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            // After a progress bar, or the terminal's own `^C`, the line is not at its start.
            let start = if std::io::stderr().is_terminal() { "\n" } else { "" };
            say(&format!("{start}{message}"));
            std::process::exit(Exit::Interrupted as i32);
        }
    });
}

/// Elsewhere the system ends the process.
#[cfg(not(unix))]
pub fn tell_when_interrupted(_: &Cli) {}

#[cfg(unix)]
fn message(cli: &Cli) -> String {
    match cli.kept() {
        Some((what, folder)) => format!(
            "interrupted: {what} are kept in {}; the same command goes on from there",
            folder.display()
        ),
        None => "interrupted".to_owned(),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn what_is_kept_is_told_by_command() {
        let told = |line: &str| message(&Cli::try_parse_from(line.split(' ')).unwrap());
        assert!(told("bench tabletop --cache c").contains("finished stages are kept in c;"));
        assert!(told("bench check tabletop").contains("finished stages are kept in cache;"));
        assert!(told("bench dataset tabletop --out d").contains("finished episodes are kept in d;"));
        assert!(told("bench models models/objects") == "interrupted");
    }
}
