//! A Vulkan driver that looks for no display, and so complains of none.
//!
//! Mesa asks libwayland for a display wherever a device is opened, and libwayland prints `error: XDG_RUNTIME_DIR is invalid or
//! not set in the environment.` on standard error where that variable is not set, as on servers and in containers. A process
//! cannot set its own environment safely, but it can start itself over with another one.

use super::cli::{Cli, RendererChoice};

/// Starts this process over with `XDG_RUNTIME_DIR` set, where it is not and the command may open a Vulkan device. Returns where
/// there is no need, or no way.
#[cfg(target_os = "linux")]
pub fn start_over(cli: &Cli) {
    use std::os::unix::process::CommandExt;
    use std::path::Path;
    use std::process::Command;

    /// An absolute path at which nothing is, so that no display is found.
    const NOWHERE: &str = "/nonexistent";
    const VARIABLE: &str = "XDG_RUNTIME_DIR";

    let renders = !matches!(cli.renderer(), None | Some(RendererChoice::Reference));
    let set = std::env::var_os(VARIABLE).is_some_and(|folder| Path::new(&folder).is_absolute());
    if renders
        && !set
        && let Ok(program) = std::env::current_exe()
    {
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        // It only comes back where it failed: then the complaint is printed, and nothing else is lost.
        let _ = Command::new(program).arg0(name).args(arguments).env(VARIABLE, NOWHERE).exec();
    }
}

/// Elsewhere no driver complains.
#[cfg(not(target_os = "linux"))]
pub fn start_over(_: &Cli) {}
