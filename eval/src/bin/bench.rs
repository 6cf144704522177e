//! `bench`: parse, run, and end with the documented exit code.

use clap::Parser;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use vantage_eval::cli::Cli;
use vantage_eval::exit::{Exit, REPORT_A_BUG};
use vantage_eval::run::run;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let exit = match catch_unwind(AssertUnwindSafe(|| run(&cli, &mut std::io::stdout().lock()))) {
        Ok(Ok(exit)) => exit,
        Ok(Err(error)) => {
            eprintln!("error: {error}");
            error.exit()
        }
        Err(_) => Exit::Bug,
    };
    if exit == Exit::Bug {
        eprintln!("{REPORT_A_BUG}");
    }
    exit.into()
}
