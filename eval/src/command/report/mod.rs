//! `bench report RESULTS...`: finished results as one page, as Markdown or as LaTeX.

pub mod error;
mod html;
mod latex;
mod pictures;
mod section;

use crate::command::cli::{ReportArgs, ReportFormat};
use crate::command::error::BenchError;
use crate::command::folder::is_there;
use crate::command::index::folders;
use crate::exit::Exit;
use crate::result::kind::ResultKind;
use crate::result::manifest::Manifest;
use crate::result::output_folder::OutputFolder;
use crate::result::results_file::{FILE_NAME, Results};
use error::ReportError;
use section::Section;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Name of the page of a result, beside it.
pub const REPORT: &str = "report.html";

/// Reads every result that is named, or lies below a folder that is, and writes them as one file.
pub fn report(args: &ReportArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let (folder, name) = place(&args.out)?;
    let mut sections = Vec::new();
    for named in &args.results {
        is_there(named)?;
        let folders = results_in(named);
        if folders.is_empty() {
            return Err(ReportError::Nothing { folder: named.clone() }.into());
        }
        for folder in folders {
            sections.push(Section::read(&folder)?);
        }
    }
    let text = match args.format {
        ReportFormat::Html => html::page(&sections)?,
        ReportFormat::Markdown => sections.iter().map(Section::markdown).collect::<Vec<_>>().join("\n"),
        ReportFormat::Latex => latex::document(&sections),
    };
    OutputFolder::probe(&folder)?.write(name, text.as_bytes())?;
    writeln!(stdout, "{} results in {}", sections.len(), args.out.display())?;
    Ok(Exit::Success)
}

/// The page of a result whose pictures are written.
pub fn page_of(
    folder: &Path,
    results: &Results,
    manifest: &Manifest,
    pictures: &[&str],
) -> Result<String, BenchError> {
    let pictures: Vec<String> = pictures.iter().map(|name| (*name).to_owned()).collect();
    html::page(&[Section::new(folder, results.clone(), serde_json::to_value(manifest)?, &pictures)?])
}

pub(super) fn place(out: &Path) -> Result<(PathBuf, &Path), ReportError> {
    let name = out
        .file_name()
        .filter(|_| !out.is_dir())
        .ok_or_else(|| ReportError::NoFile { path: out.to_owned() })?;
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok((folder.to_owned(), Path::new(name)))
}

/// The folder itself, or the results below it: of scenes, then of studies, then of maps.
fn results_in(folder: &Path) -> Vec<PathBuf> {
    if folder.join(FILE_NAME).is_file() {
        return vec![folder.to_owned()];
    }
    let kinds = [ResultKind::Scene, ResultKind::Study, ResultKind::Map];
    kinds.into_iter().flat_map(|kind| folders(folder, kind)).collect()
}
