//! A table of named columns, for results that are not elements.

use std::io::{self, Write};

use super::parquet::{Leaf, Physical, write_leaves};

/// Columns of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// In the order in which files have them.
    pub columns: Vec<TableColumn>,
}

/// A named column.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// No other column has it.
    pub name: String,
    /// Its values.
    pub values: TableValues,
}

/// The values of a [`TableColumn`].
#[derive(Clone, Debug, PartialEq)]
pub enum TableValues {
    /// Whole numbers.
    U64(Vec<u64>),
    /// Numbers; NaN where there is none.
    F64(Vec<f64>),
    /// Numbers that are whole by their nature; NaN where there is none. As [`TableValues::F64`], but as CSV
    /// they have no decimals.
    Counts(Vec<f64>),
    /// Words.
    Text(Vec<String>),
}

impl TableValues {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::U64(values) => values.len(),
            Self::F64(values) | Self::Counts(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A value as CSV has it.
    fn field(&self, row: usize) -> String {
        match self {
            Self::U64(values) => values[row].to_string(),
            Self::F64(values) if values[row].is_finite() => format!("{:?}", values[row]),
            Self::Counts(values) if values[row].is_finite() => values[row].to_string(),
            Self::F64(_) | Self::Counts(_) => String::new(),
            Self::Text(values) => quoted(&values[row]),
        }
    }

    fn physical(&self) -> Physical {
        match self {
            Self::U64(_) => Physical::U64,
            Self::F64(_) | Self::Counts(_) => Physical::F64,
            Self::Text(_) => Physical::Text,
        }
    }

    /// Appends a value as Parquet has it.
    fn push(&self, row: usize, page: &mut Vec<u8>) {
        match self {
            Self::U64(values) => page.extend_from_slice(&values[row].to_le_bytes()),
            Self::F64(values) | Self::Counts(values) => {
                page.extend_from_slice(&values[row].to_le_bytes());
            }
            Self::Text(values) => {
                page.extend_from_slice(&(values[row].len() as u32).to_le_bytes());
                page.extend_from_slice(values[row].as_bytes());
            }
        }
    }
}

impl TableColumn {
    fn leaf(&self) -> Leaf<'_> {
        Leaf {
            name: self.name.clone(),
            physical: self.values.physical(),
            push: Box::new(|row, page| self.values.push(row, page)),
        }
    }
}

/// Quoted where it must be (RFC 4180).
fn quoted(text: &str) -> String {
    match text.contains(['"', ',', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

impl Table {
    /// How many rows there are.
    ///
    /// # Panics
    /// When columns differ in length.
    pub fn rows(&self) -> usize {
        let rows = self.columns.first().map_or(0, |c| c.values.len());
        assert!(
            self.columns.iter().all(|c| c.values.len() == rows),
            "columns differ in length"
        );
        rows
    }

    /// Writes the table as CSV (RFC 4180, but for its line ends: LF): a header, and a line a row. Numbers are the
    /// shortest text that reads back to the same bits, and nothing where there is none.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// When columns differ in length.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let names: Vec<_> = self.columns.iter().map(|c| quoted(&c.name)).collect();
        writeln!(out, "{}", names.join(","))?;
        for row in 0..self.rows() {
            let fields: Vec<_> = self.columns.iter().map(|c| c.values.field(row)).collect();
            writeln!(out, "{}", fields.join(","))?;
        }
        Ok(())
    }

    /// Writes the table as Parquet: doubles (NaN where there is none), unsigned 64-bit integers and UTF-8.
    ///
    /// # Errors
    /// Those of `out`.
    ///
    /// # Panics
    /// When columns differ in length.
    pub fn write_parquet(&self, out: &mut dyn Write) -> io::Result<()> {
        let leaves: Vec<Leaf> = self.columns.iter().map(TableColumn::leaf).collect();
        write_leaves("results", self.rows(), &leaves, out)
    }
}
