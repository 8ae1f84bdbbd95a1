//! Tables as text.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use csv::WriterBuilder;

use super::Table;
use crate::files::OutFile;
use recording::Log;

/// The names of all columns: t, step, then `position[0]` and so on.
pub(super) fn names(table: &Table) -> Vec<String> {
    let mut names = vec!["t".to_string(), "step".to_string()];
    for column in &table.columns {
        names.extend(column.components.iter().map(|component| match column.vector {
            true => format!("{}[{component}]", column.name),
            false => column.name.clone(),
        }));
    }
    names
}

/// Writes the names of all columns and the samples with these numbers to `out`, and returns it.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write_rows<W: Write>(
    out: W,
    separator: u8,
    log: &Log,
    table: &Table,
    samples: impl IntoIterator<Item = usize>,
) -> io::Result<W> {
    let mut out = WriterBuilder::new().delimiter(separator).from_writer(out);
    out.write_record(names(table))?;
    let mut text = String::new();
    let mut put = |out: &mut csv::Writer<W>, value: f64| {
        text.clear();
        // As many digits as it takes to get the very same bits back, in the shorter of the two notations.
        let _ = match value.abs() {
            size if size != 0.0 && !(1e-5..1e15).contains(&size) => write!(text, "{value:e}"),
            _ => write!(text, "{value}"),
        };
        out.write_field(&text)
    };
    for sample in samples {
        put(&mut out, log.times()[sample] as f64 / 1e9)?;
        out.write_field((log.steps().start + sample as u64).to_string())?;
        for column in &table.columns {
            let row = column.series.row(sample);
            column.components.iter().try_for_each(|&component| put(&mut out, row[component]))?;
        }
        out.write_record(None::<&[u8]>)?;
    }
    out.into_inner().map_err(csv::IntoInnerError::into_error)
}

/// Writes a topic, every `every`-th sample of it, as comma-separated values.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write_csv(path: &Path, log: &Log, table: &Table, every: usize) -> io::Result<()> {
    let samples = (0..log.times().len()).step_by(every);
    write_rows(OutFile::create(path)?, b',', log, table, samples)?.commit()
}
