//! `bench index RESULTS_DIR`: the index of a folder of results.

use crate::command::cli::IndexArgs;
use crate::command::error::BenchError;
use crate::command::exit::Exit;
use crate::result::index::{index, scene_table};
use crate::result::output_folder::OutputFolder;
use std::io::Write;

/// Name of the index.
pub const INDEX: &str = "README.md";

/// Writes the index into the folder, and prints its table of scenes with links from here.
pub fn write_index(args: &IndexArgs, stdout: &mut impl Write) -> Result<Exit, BenchError> {
    let folder = &args.results;
    if !folder.is_dir() {
        return Err(BenchError::NoFolder { folder: folder.clone() });
    }
    let text = index(folder)?;
    OutputFolder::probe(folder)?.write(INDEX, text.as_bytes())?;
    write!(
        stdout,
        "{}",
        scene_table(folder, &format!("{}/", folder.to_string_lossy().trim_end_matches('/')))?
    )?;
    Ok(Exit::Success)
}
