//! A grid of texts, drawn for the terminal or as Markdown.

use comfy_table::presets::{ASCII_MARKDOWN, UTF8_FULL_CONDENSED};
use comfy_table::{Cell, CellAlignment, ContentArrangement};

/// What stands for an undefined score.
pub(crate) const UNDEFINED: &str = "-";
/// Columns where nothing says how wide the terminal is.
const USUAL_WIDTH: u16 = 120;
/// What a column takes beside its text: a space on each side, and a line.
const BESIDE: usize = 3;

/// How a table is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// With box-drawing lines, within so many columns of a terminal.
    Terminal(u16),
    /// A Markdown table.
    Markdown,
}

impl Style {
    /// As wide as the terminal that standard output is.
    pub fn terminal() -> Self {
        Self::Terminal(console::Term::stdout().size_checked().map_or(USUAL_WIDTH, |(_, columns)| columns))
    }

    /// The same, within no more than so many columns of a terminal.
    pub fn within(self, most: u16) -> Self {
        match self {
            Self::Terminal(columns) => Self::Terminal(columns.min(most)),
            Self::Markdown => self,
        }
    }
}

/// Draws a table whose first column is text and whose others are numbers. On a terminal that it is too wide for, cells break.
pub(crate) fn draw(style: Style, head: &[String], rows: Vec<Vec<String>>) -> String {
    let cell = |text: String| match style {
        Style::Terminal(_) => text,
        Style::Markdown => text.replace('|', "\\|"),
    };
    let mut drawn = comfy_table::Table::new();
    match style {
        Style::Terminal(width) => {
            drawn.load_style(UTF8_FULL_CONDENSED);
            drawn.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
        }
        Style::Markdown => {
            drawn.load_style(ASCII_MARKDOWN);
        }
    }
    drawn.set_header(head.iter().cloned().map(cell));
    for row in rows {
        drawn.add_row(row.into_iter().enumerate().map(|(column, text)| {
            let alignment = if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
            Cell::new(cell(text)).set_alignment(alignment)
        }));
    }
    drawn.trim_fmt()
}

/// Likewise; on a terminal that it is too wide for, several tables below each other, each with the first `kept` columns.
pub(crate) fn draw_in_parts(style: Style, kept: usize, head: &[String], rows: &[Vec<String>]) -> String {
    let Style::Terminal(width) = style else { return draw(style, head, rows.to_vec()) };
    let widest = |column: usize| {
        let texts = rows.iter().map(|row| &row[column]).chain([&head[column]]);
        texts.flat_map(|text| text.lines()).map(|line| line.chars().count()).max().unwrap_or(0) + BESIDE
    };
    let beside = (0..kept).map(widest).sum::<usize>() + 1;
    let mut parts: Vec<Vec<usize>> = Vec::new();
    let mut filled = usize::MAX;
    for column in kept..head.len() {
        filled = filled.saturating_add(widest(column));
        if filled > usize::from(width) {
            parts.push((0..kept).collect());
            filled = beside + widest(column);
        }
        parts.iter_mut().rev().take(1).for_each(|part| part.push(column));
    }
    let pick =
        |part: &[usize], row: &[String]| part.iter().map(|&column| row[column].clone()).collect::<Vec<_>>();
    let drawn = parts
        .iter()
        .map(|part| draw(style, &pick(part, head), rows.iter().map(|row| pick(part, row)).collect()));
    drawn.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_wide_for_the_terminal_becomes_several_tables_with_the_first_columns() {
        let head: Vec<String> = ["Method", "A", "B", "C"].map(str::to_owned).to_vec();
        let rows = vec![vec!["mine".to_owned(), "1".repeat(12), "2".repeat(12), "3".repeat(12)]];
        let widths = |text: &str| text.lines().map(|line| line.chars().count()).max();
        let whole = draw_in_parts(Style::Terminal(60), 1, &head, &rows);
        assert_eq!((whole.matches("mine").count(), widths(&whole)), (1, Some(55)));
        let parts = draw_in_parts(Style::Terminal(54), 1, &head, &rows);
        assert_eq!((parts.matches("mine").count(), widths(&parts)), (2, Some(40)));
        let broken = draw_in_parts(Style::Terminal(20), 1, &head, &rows);
        assert_eq!((broken.matches("mine").count(), widths(&broken)), (3, Some(20)));
        assert_eq!(draw_in_parts(Style::Markdown, 1, &head, &rows).matches("mine").count(), 1);
    }
}
