//! `bench`: parse, run, and end with the documented exit code.

use mimalloc::MiMalloc;
use std::process::ExitCode;
use vantage_eval::command::end::end;
use vantage_eval::command::interrupt::tell_when_interrupted;
use vantage_eval::command::no_display::start_over;
use vantage_eval::command::run::run;
use vantage_eval::command::source::command_line;
use vantage_eval::progress::say;

/// By which calls of models take less time: see docs/speed.md.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    let cli = command_line();
    start_over(&cli);
    tell_when_interrupted(&cli);
    let (exit, message) = end(|| run(cli, &mut std::io::stdout().lock()));
    if let Some(message) = message {
        say(&message);
    }
    exit.into()
}
