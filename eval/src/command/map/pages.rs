//! What is made of a map's raw scores: its tables and its figures.

use super::text::map_markdown;
use crate::figure::FigureError;
use crate::figure::map::{map_png, map_summary_png, map_summary_svg, map_svg};
use crate::result::report::TABLES;
use crate::result::results_file::Results;
use crate::scene_file::map::MapFile;

/// The map as it was run, beside its scores: what its tables and figures are made by.
pub const MAP_FILE: &str = "map.json";

/// The name and the bytes of each page: the tables, the figure of all panels, and that of the summary where the map has one.
pub fn map_pages(map: &MapFile, results: &Results) -> Result<Vec<(&'static str, Vec<u8>)>, FigureError> {
    let mut pages = vec![
        (TABLES, map_markdown(map, results).into_bytes()),
        ("map.svg", map_svg(map, results)?.into_bytes()),
        ("map.png", map_png(map, results)?),
    ];
    if let Some(svg) = map_summary_svg(map, results)? {
        pages.push(("summary.svg", svg.into_bytes()));
    }
    if let Some(png) = map_summary_png(map, results)? {
        pages.push(("summary.png", png));
    }
    Ok(pages)
}
