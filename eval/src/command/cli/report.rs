//! Options of `bench report`.

use super::ReportFormat;
use clap::Args;
use std::path::PathBuf;

/// `bench report RESULTS...`: finished results as one file.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct ReportArgs {
    /// Folders of results, or folders that hold `scenes`, `studies` or `maps`.
    #[arg(value_name = "RESULTS", required = true)]
    pub results: Vec<PathBuf>,
    /// What is written.
    #[arg(long, value_enum, default_value_t)]
    pub format: ReportFormat,
    /// The file.
    #[arg(long, value_name = "FILE", default_value = "report.html")]
    pub out: PathBuf,
}
