//! A report as one HTML page that needs nothing else: images are in it, and no address is asked for.

use super::section::Section;
use crate::command::error::BenchError;
use crate::result::gains_text;
use crate::result::table::Table;
use crate::result::table_text::{Sheet, failures, sheets};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SORT: &str = include_str!("sort.js");
/// Nothing is loaded, whatever the texts of a result hold.
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The page.
pub(super) fn page(sections: &[Section]) -> Result<String, BenchError> {
    let title = match sections {
        [only] => only.results.scene.clone(),
        _ => format!("{} results", sections.len()),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (title) " - Vantage" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (title) }
                    @if sections.len() > 1 {
                        nav aria-label="Results" {
                            ul { @for (number, section) in sections.iter().enumerate() {
                                li { a href=(format!("#result-{number}")) { (section.results.scene) } }
                            } }
                        }
                    }
                }
                main { @for (number, section) in sections.iter().enumerate() {
                    (of_result(number, section, sections.len() > 1))
                } }
                script { (PreEscaped(SORT)) }
            }
        }
    };
    Ok(page.into_string())
}

fn of_result(number: usize, section: &Section, titled: bool) -> Markup {
    let (first, others) = section.results.tables.split_at(section.results.tables.len().min(1));
    html! {
        section id=(format!("result-{number}")) {
            @if titled { h2 { (section.results.scene) } }
            @for said in section.said() { p.said { (said) } }
            @for table in first { (folded(table, true)) }
            @for picture in &section.pictures {
                figure {
                    img src=(picture.data) alt=(picture.words) loading="lazy";
                    figcaption { (picture.words) " (" code { (picture.name) } ")" }
                }
            }
            @for table in others { (folded(table, false)) }
            details {
                summary { "Origin" }
                dl { @for (name, value) in section.origin() { dt { (name) } dd { (value) } } }
            }
        }
    }
}

/// A table under its name, unfolded by a click unless it is `open`.
fn folded(table: &Table, open: bool) -> Markup {
    html! {
        details open[open] {
            summary { (table.name()) ": " (table.methods().len()) " rows, " (table.seeds().len()) " seeds" }
            (of_table(table))
        }
    }
}

fn of_table(table: &Table) -> Markup {
    let gains = gains_text::sheets(table);
    html! {
        @for sheet in sheets(table) { (of_sheet(&sheet)) }
        @for line in failures(table) { p.failed { (line) } }
        @if let Some((told, _)) = gains.first() { p { (told) } }
        @for (_, sheet) in &gains { (of_sheet(sheet)) }
    }
}

fn of_sheet(sheet: &Sheet) -> Markup {
    html! {
        div.wide tabindex="0" role="region" aria-label=(sheet.title) {
            table {
                caption { (sheet.title) }
                thead { tr { @for head in &sheet.head { th scope="col" aria-sort="none" { button type="button" { (head) } } } } }
                tbody { @for row in &sheet.rows {
                    tr { @for (column, text) in row.iter().enumerate() {
                        @if column == 0 { th scope="row" { (of_text(text)) } } @else { td { (of_text(text)) } }
                    } }
                } }
            }
        }
    }
}

/// A text, strong where it stands between `**`.
fn of_text(text: &str) -> Markup {
    match text.strip_prefix("**").and_then(|rest| rest.split_once("**")) {
        Some((strong, rest)) => html! { strong { (strong) } (rest) },
        None => html! { (text) },
    }
}
