//! Tables for people: columns that are aligned, numbers of a few digits.

use std::io::{self, Write};

use super::Table;
use super::csv::names;
use recording::Log;

/// Significant digits, as many as there is room for.
const DIGITS: [usize; 2] = [6, 4];

/// Writes the names of all columns and the samples with these numbers to `out`, for a terminal of so many columns.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write_aligned(
    mut out: impl Write,
    columns: Option<usize>,
    log: &Log,
    table: &Table,
    samples: impl IntoIterator<Item = usize>,
) -> io::Result<()> {
    let names = names(table);
    // A lone vector is named by its numbers: `[0]`.
    let short: Vec<&str> = match table.columns.as_slice() {
        [one] if one.vector => names.iter().map(|name| name.strip_prefix(&one.name).unwrap_or(name)).collect(),
        _ => names.iter().map(String::as_str).collect(),
    };
    let last = log.times().len().saturating_sub(1);
    let numbers = |sample: usize| [seconds(log, sample), (log.steps().start + sample as u64).to_string()];
    let ends = numbers(last).map(|text| text.len());
    let widths = |digits: usize| -> Vec<usize> {
        let least = ends.iter().copied().chain(std::iter::repeat(widest(digits)));
        short.iter().zip(least).map(|(name, width)| name.chars().count().max(width)).collect()
    };
    let fits = |digits: &usize| {
        let widths = widths(*digits);
        columns.is_none_or(|columns| widths.iter().sum::<usize>() + 2 * (widths.len() - 1) <= columns)
    };
    let digits = DIGITS.into_iter().find(fits).unwrap_or(DIGITS[1]);
    let widths = widths(digits);
    let mut line = |cells: &mut dyn Iterator<Item = String>| {
        let cells: Vec<String> = cells.zip(&widths).map(|(cell, &width)| format!("{cell:>width$}")).collect();
        writeln!(out, "{}", cells.join("  "))
    };
    line(&mut short.iter().map(|name| (*name).to_string()))?;
    for sample in samples {
        let values = table.columns.iter().flat_map(|column| {
            let row = column.series.row(sample);
            column.components.iter().map(move |&component| significant(row[component], digits))
        });
        line(&mut numbers(sample).into_iter().chain(values))?;
    }
    Ok(())
}

/// A time as short as its step allows, s.
fn seconds(log: &Log, sample: usize) -> String {
    let text = format!("{:.6}", log.times()[sample] as f64 / 1e9);
    let tail = log.times().get(1).map_or(0, |ns| decimals(*ns as f64 / 1e9));
    text[..text.len() - 6 + tail].trim_end_matches('.').into()
}

/// Decimals of a time, up to six.
fn decimals(time: f64) -> usize {
    format!("{time:.6}").trim_end_matches('0').split('.').nth(1).map_or(0, str::len)
}

/// Characters of the longest number of so many significant digits: `-1.2346e-308`.
fn widest(digits: usize) -> usize {
    // Sign, point, `e-7`.
    digits + 5
}

/// A number with so many significant digits, in the notation that is shorter to read.
fn significant(value: f64, digits: usize) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let rounded = format!("{value:.*e}", digits - 1);
    if !(1e-3..10f64.powi(digits as i32)).contains(&size) {
        return rounded;
    }
    let power: i32 = rounded.split('e').nth(1).and_then(|power| power.parse().ok()).unwrap_or(0);
    format!("{value:.*}", (digits as i32 - 1 - power).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_they_should() {
        let values = [0.0, -0.081_204_245, 12.500_000_66, 123_456.7, -3.418e-7, 1.2e7, f64::NAN, 9.999_999_9];
        let shown = values.map(|value| significant(value, 6));
        let expected = ["0", "-0.0812042", "12.5000", "123457", "-3.41800e-7", "1.20000e7", "NaN", "10.0000"];
        assert_eq!(shown, expected);
        assert!(values.into_iter().all(|value| significant(value, 4).len() <= widest(4)));
    }
}
