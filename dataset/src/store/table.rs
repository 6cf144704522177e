//! Tables of text, with columns fixed by name and order.

use super::error::{Fault, StoreError};
use super::hashed_file::{Sink, Source};
use csv::{ErrorKind, ReaderBuilder, StringRecord, WriterBuilder};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::str::FromStr;

/// The columns of one kind of table.
pub(super) struct Table {
    /// Its file, relative to the folder.
    pub file: &'static str,
    /// Its columns, in order.
    pub columns: &'static [&'static str],
    /// What parts two fields, and how the columns are named.
    pub style: Style,
}

/// How a table is laid out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    /// Commas; the first line names the columns.
    Csv,
    /// Single blanks; lines that start with `#` are comments, the first of which names the columns.
    Tum,
}

/// A row to be filled from the left.
pub(super) struct RowWriter<'a> {
    csv: csv::Writer<&'a mut Sink>,
    field: String,
}

/// A row to be taken from the left.
pub(super) struct Row<'a> {
    table: &'a Table,
    record: &'a StringRecord,
    line: u64,
    column: usize,
    /// How many rows came before.
    index: usize,
}

impl Style {
    fn delimiter(self) -> u8 {
        match self {
            Style::Csv => b',',
            Style::Tum => b' ',
        }
    }
}

impl Table {
    /// Writes the names of the columns and a row for each item.
    pub fn write<T>(
        &self,
        sink: &mut Sink,
        rows: impl IntoIterator<Item = T>,
        fill: impl Fn(&mut RowWriter<'_>, T) -> io::Result<()>,
    ) -> io::Result<()> {
        match self.style {
            Style::Csv => writeln!(sink, "{}", self.columns.join(","))?,
            Style::Tum => writeln!(sink, "# {}", self.columns.join(" "))?,
        }
        let csv = WriterBuilder::new().delimiter(self.style.delimiter()).from_writer(sink);
        let mut row = RowWriter { csv, field: String::new() };
        for item in rows {
            fill(&mut row, item)?;
            row.csv.write_record(None::<&[u8]>)?;
        }
        row.csv.flush()
    }

    /// Reads every row with `take`.
    pub fn read<T>(
        &self,
        folder: &Path,
        source: &mut Source,
        take: impl Fn(&mut Row<'_>) -> Result<T, Fault>,
    ) -> Result<Vec<T>, StoreError> {
        let mut csv = ReaderBuilder::new()
            .delimiter(self.style.delimiter())
            .comment((self.style == Style::Tum).then_some(b'#'))
            .has_headers(self.style == Style::Csv)
            .flexible(true)
            .from_reader(source);
        if self.style == Style::Csv {
            let header = csv.headers().map_err(|e| self.unreadable(folder, e))?;
            self.check_columns(1, header.iter().eq(self.columns.iter().copied()), header)
                .map_err(StoreError::invalid(folder))?;
        }
        let mut rows = Vec::new();
        let mut record = StringRecord::new();
        while csv.read_record(&mut record).map_err(|e| self.unreadable(folder, e))? {
            let line = record.position().map_or(0, csv::Position::line);
            let mut row = Row { table: self, record: &record, line, column: 0, index: rows.len() };
            let taken = self
                .check_columns(line, record.len() == self.columns.len(), &record)
                .and_then(|()| take(&mut row));
            rows.push(taken.map_err(StoreError::invalid(folder))?);
        }
        Ok(rows)
    }

    fn check_columns(&self, line: u64, right: bool, found: &StringRecord) -> Result<(), Fault> {
        if right {
            return Ok(());
        }
        let got = format!("{} ({})", found.len(), found.iter().collect::<Vec<_>>().join(","));
        let expected = format!("{} ({})", self.columns.len(), self.columns.join(","));
        Err(Fault::new(self.file, Some(line), "columns", got, expected))
    }

    fn unreadable(&self, folder: &Path, error: csv::Error) -> StoreError {
        let line = error.position().map(csv::Position::line);
        let message = error.to_string();
        match error.into_kind() {
            ErrorKind::Io(source) => StoreError::Read { path: folder.join(self.file), source },
            _ => StoreError::invalid(folder)(Fault::new(self.file, line, "text", message, "UTF-8")),
        }
    }
}

impl RowWriter<'_> {
    /// The next field, a whole number or a word.
    pub fn put(&mut self, value: impl std::fmt::Display) -> io::Result<()> {
        self.field.clear();
        write!(self.field, "{value}").map_err(io::Error::other)?;
        Ok(self.csv.write_field(&self.field)?)
    }

    /// The next fields, with the fewest digits that read back to the same bits.
    pub fn put_floats<'v>(&mut self, values: impl IntoIterator<Item = &'v f64>) -> io::Result<()> {
        values.into_iter().try_for_each(|value| self.put(format_args!("{value:?}")))
    }
}

impl Row<'_> {
    /// The next field.
    pub fn take<T: FromStr>(&mut self, expected: &str) -> Result<T, Fault> {
        self.take_with(expected, |text| text.parse().ok())
    }

    /// The next field, by a parser of its own.
    pub fn take_with<T>(
        &mut self,
        expected: &str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T, Fault> {
        let text = self.record.get(self.column).unwrap_or_default();
        let field = self.table.columns.get(self.column).copied().unwrap_or("columns");
        self.column += 1;
        let fault = || Fault::new(self.table.file, Some(self.line), field, format!("{text:?}"), expected);
        parse(text).ok_or_else(fault)
    }

    /// The next `N` fields: numbers, that may yet be infinite or NaN.
    pub fn take_floats<const N: usize>(&mut self) -> Result<[f64; N], Fault> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.take("a number")?;
        }
        Ok(values)
    }

    /// The next field, which counts the rows from 0.
    pub fn take_index(&mut self) -> Result<(), Fault> {
        let index = self.index;
        self.take_with(&index.to_string(), |text| (text.parse() == Ok(index)).then_some(()))
    }
}
