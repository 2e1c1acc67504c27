//! A table in plain text.

use core::fmt;

use crate::text::printable;

/// One cell, at the left or the right of its column.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    text: String,
    is_left: bool,
}

impl Cell {
    pub(crate) fn left(text: impl AsRef<str>) -> Self {
        Self { text: printable(text.as_ref()).into_owned(), is_left: true }
    }

    pub(crate) fn right(text: impl AsRef<str>) -> Self {
        Self { is_left: false, ..Self::left(text) }
    }
}

/// Rows under a heading. Columns are as wide as they must be and two blanks apart.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    heading: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    pub(crate) fn new(heading: &[&str]) -> Self {
        Self { heading: heading.iter().map(|&name| name.to_owned()).collect(), rows: Vec::new() }
    }

    pub(crate) fn row(&mut self, cells: Vec<Cell>) {
        self.rows.push(cells);
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The heading stands as its column does.
        let heading: Vec<Cell> = (0..)
            .zip(&self.heading)
            .map(|(column, name)| {
                let is_left =
                    self.rows.first().and_then(|row| row.get(column)).is_some_and(|cell| cell.is_left);
                Cell { text: name.clone(), is_left }
            })
            .collect();
        let rows = || core::iter::once(&heading).chain(&self.rows);
        let mut widths = vec![0; rows().map(Vec::len).max().unwrap_or(0)];
        for row in rows() {
            for (width, cell) in widths.iter_mut().zip(row) {
                *width = cell.text.chars().count().max(*width);
            }
        }
        for row in rows() {
            let mut line = String::new();
            for (Cell { text, is_left }, &width) in row.iter().zip(&widths) {
                line += &if *is_left { format!("{text:<width$}  ") } else { format!("{text:>width$}  ") };
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
