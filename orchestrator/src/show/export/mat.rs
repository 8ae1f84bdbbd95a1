//! MATLAB files, level 5: what every version since 1996 loads, and Octave and SciPy too.

use std::io::{self, Write};
use std::path::Path;

use super::Table;
use crate::files::OutFile;
use recording::Log;

/// Types of the data that an element holds.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Classes of an array.
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;
/// Longest name that MATLAB accepts.
const NAME_MAX: usize = 63;
/// Where in the header the version and the order of the bytes stand.
const HEADER_TEXT: usize = 124;

/// Writes `t`, `step`, the texts `scenario` and `variant`, and one matrix per field, a row for every `every`-th sample.
///
/// # Errors
/// What the operating system says; [`io::ErrorKind::FileTooLarge`] if a signal does not fit the format, which holds 4 GB each.
pub(crate) fn write_mat(path: &Path, log: &Log, tables: &[Table], every: usize) -> io::Result<()> {
    let samples: Vec<usize> = (0..log.times().len()).step_by(every).collect();
    let mut out = OutFile::create(path)?;
    let mut text = format!("{:HEADER_TEXT$}", "MATLAB 5.0 MAT-file, written by phalanx").into_bytes();
    text.extend_from_slice(&0x0100_u16.to_le_bytes());
    text.extend_from_slice(b"IM");
    out.write_all(&text)?;
    for key in ["scenario", "variant"] {
        let value = log.metadata().and_then(|metadata| metadata.get(key)).map(String::as_str).unwrap_or_default();
        let units: Vec<u8> = value.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let size = [1, units.len() / 2];
        array(&mut out, key, CHAR_CLASS, size, UINT16, units.len(), &mut |out| out.write_all(&units))?;
    }
    let rows = samples.len();
    let mut matrix = |name: &str, columns: usize, value: &dyn Fn(usize, usize) -> f64| {
        // Column by column, as FORTRAN did.
        let mut write = |out: &mut dyn Write| {
            (0..columns).try_for_each(|column| {
                samples.iter().try_for_each(|&sample| out.write_all(&value(sample, column).to_le_bytes()))
            })
        };
        array(&mut out, name, DOUBLE_CLASS, [rows, columns], DOUBLE, rows.saturating_mul(8 * columns), &mut write)
    };
    matrix("t", 1, &|sample, _| log.times()[sample] as f64 / 1e9)?;
    matrix("step", 1, &|sample, _| (log.steps().start + sample as u64) as f64)?;
    for table in tables {
        for column in &table.columns {
            let name = format!("{}_{}", table.name, column.name);
            matrix(&name, column.series.width(), &|sample, j| column.series.row(sample)[j])?;
        }
    }
    out.commit()
}

/// Bytes up to the next multiple of 8.
fn padding(length: usize) -> usize {
    length.next_multiple_of(8) - length
}

fn tag(out: &mut dyn Write, kind: u32, length: usize) -> io::Result<()> {
    let length = u32::try_from(length).map_err(|_| {
        io::Error::new(io::ErrorKind::FileTooLarge, "a signal has more than the 4 GB of this format; use --every")
    })?;
    out.write_all(&kind.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())
}

/// A variable: flags, size, name, and the `length` bytes that `write` writes.
fn array(
    out: &mut dyn Write,
    name: &str,
    class: u32,
    size: [usize; 2],
    kind: u32,
    length: usize,
    write: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let name = &name.as_bytes()[..name.len().min(NAME_MAX)];
    let named = name.len() + padding(name.len());
    tag(out, MATRIX, 16 + 16 + 8 + named + 8 + length.saturating_add(padding(length)))?;
    tag(out, UINT32, 8)?;
    out.write_all(&u64::from(class).to_le_bytes())?;
    tag(out, INT32, 8)?;
    for length in size {
        // The length of the data has been checked to fit 32 bits, so these do.
        out.write_all(&(length as i32).to_le_bytes())?;
    }
    tag(out, INT8, name.len())?;
    out.write_all(name)?;
    out.write_all(&[0; 8][..padding(name.len())])?;
    tag(out, kind, length)?;
    write(out)?;
    out.write_all(&[0; 8][..padding(length)])
}
