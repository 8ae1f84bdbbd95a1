//! Tables as text.

use std::io::{self, Write};
use std::path::Path;

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

/// The names of all columns in a line.
pub(crate) fn header(table: &Table, separator: &str) -> String {
    names(table).join(separator)
}

/// One sample. Numbers have as many digits as it takes to get the very same bits back.
pub(crate) fn write_row(
    out: &mut impl Write,
    log: &Log,
    table: &Table,
    sample: usize,
    separator: &str,
) -> io::Result<()> {
    write!(out, "{}{separator}{}", log.times()[sample] as f64 / 1e9, log.steps().start + sample as u64)?;
    for column in &table.columns {
        let row = column.series.row(sample);
        for &component in &column.components {
            let value = row[component];
            // The shorter of the two notations.
            match value.abs() {
                size if size != 0.0 && !(1e-5..1e15).contains(&size) => write!(out, "{separator}{value:e}")?,
                _ => write!(out, "{separator}{value}")?,
            }
        }
    }
    writeln!(out)
}

/// Writes a topic, every `every`-th sample of it, as comma-separated values.
pub(crate) fn write_csv(path: &Path, log: &Log, table: &Table, every: usize) -> io::Result<()> {
    let mut out = OutFile::create(path)?;
    writeln!(out, "{}", header(table, ","))?;
    (0..log.times().len()).step_by(every).try_for_each(|sample| write_row(&mut out, log, table, sample, ","))?;
    out.commit()
}
