//! A grid of texts, drawn for the terminal or as Markdown.

use comfy_table::presets::{ASCII_MARKDOWN, UTF8_FULL_CONDENSED};
use comfy_table::{Cell, CellAlignment};

/// What stands for an undefined score.
pub(crate) const UNDEFINED: &str = "-";

/// How a table is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// With box-drawing lines.
    Terminal,
    /// A Markdown table.
    Markdown,
}

/// Draws a table whose first column is text and whose others are numbers.
pub(crate) fn draw(style: Style, head: &[String], rows: Vec<Vec<String>>) -> String {
    let cell = |text: String| match style {
        Style::Terminal => text,
        Style::Markdown => text.replace('|', "\\|"),
    };
    let mut drawn = comfy_table::Table::new();
    drawn.load_style(match style {
        Style::Terminal => UTF8_FULL_CONDENSED,
        Style::Markdown => ASCII_MARKDOWN,
    });
    drawn.set_header(head.iter().cloned().map(cell));
    for row in rows {
        drawn.add_row(row.into_iter().enumerate().map(|(column, text)| {
            let alignment = if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
            Cell::new(cell(text)).set_alignment(alignment)
        }));
    }
    drawn.trim_fmt()
}
