//! Tables of numbers as text.

use crate::text::{brief, did_you_mean};

/// Most rows of a data file.
const MOST_ROWS: usize = 1_000_000;

/// A text with a line of names and lines of numbers between `,`, `;` or tabs.
pub(super) struct Csv<'a> {
    /// The names of the columns.
    pub(super) names: Vec<&'a str>,
    separator: char,
    /// The lines behind the names, with their numbers (from 1); none is empty.
    lines: Vec<(usize, &'a str)>,
}

impl<'a> Csv<'a> {
    /// # Errors
    /// Says which line is wrong.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let text =
            std::str::from_utf8(bytes).map_err(|error| format!("byte {} is not valid UTF-8", error.valid_up_to()))?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let (number, header) =
            lines.next().ok_or("expected a line with the names of the columns, found an empty file")?;
        // NumPy marks the line of names.
        let header = header.trim_start().trim_start_matches('#');
        let separator = [',', ';', '\t'].into_iter().find(|separator| header.contains(*separator)).unwrap_or(',');
        let mut names: Vec<&str> = cells(header, separator).collect();
        while names.last().is_some_and(|name| name.is_empty()) {
            names.pop();
        }
        if names.is_empty() || names.iter().any(|name| name.parse::<f64>().is_ok()) {
            return Err(format!("line {number}: expected the names of the columns, found \"{}\"", brief(header)));
        }
        let lines: Vec<(usize, &str)> = lines.collect();
        if lines.len() > MOST_ROWS {
            return Err(format!("expected at most {MOST_ROWS} rows, found {}", lines.len()));
        }
        Ok(Self { names, separator, lines })
    }

    /// The place of the column of this name.
    pub(super) fn place(&self, name: &str) -> Result<usize, String> {
        self.names.iter().position(|known| *known == name).ok_or_else(|| {
            let hint = did_you_mean(name, self.names.iter().copied());
            format!("no column is called `{}`, expected one of {}{hint}", brief(name), brief(&self.names.join(", ")))
        })
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The number of the line in which a row stands.
    pub(super) fn line(&self, row: usize) -> usize {
        self.lines[row].0
    }

    /// The columns at these places, which are increasing.
    ///
    /// # Errors
    /// Names line and column of what is no finite number.
    pub(super) fn columns<const COUNT: usize>(&self, places: [usize; COUNT]) -> Result<[Vec<f64>; COUNT], String> {
        let mut columns = places.map(|_| Vec::with_capacity(self.lines.len()));
        for &(line, text) in &self.lines {
            let mut cells = (0..).zip(cells(text, self.separator));
            for (column, place) in columns.iter_mut().zip(places) {
                let cell = cells.find(|(at, _)| *at == place).map_or("", |(_, cell)| cell);
                let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
                column.push(number.ok_or_else(|| {
                    let found = if cell.is_empty() { "nothing".into() } else { format!("\"{}\"", brief(cell)) };
                    format!("line {line}, column `{}`: expected a finite number, found {found}", self.names[place])
                })?);
            }
        }
        Ok(columns)
    }
}

fn cells(line: &str, separator: char) -> impl Iterator<Item = &str> {
    line.split(separator).map(|cell| {
        let cell = cell.trim();
        cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell).trim()
    })
}
