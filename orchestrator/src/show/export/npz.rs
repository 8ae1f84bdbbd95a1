//! NumPy archives: a zip file with an array in each member, not compressed, as NumPy itself writes it.

use std::io::{self, Write};
use std::path::Path;

use rawzip::{ErrorKind, ZipArchiveWriter};

use super::{Column, Table};
use crate::files::OutFile;
use recording::Log;

/// Writes `t`, `step` and one array per field, a row for every `every`-th sample.
///
/// # Errors
/// What the operating system reports.
pub(crate) fn write_npz(path: &Path, log: &Log, tables: &[Table], every: usize) -> io::Result<()> {
    let samples: Vec<usize> = (0..log.times().len()).step_by(every).collect();
    let rows = samples.len();
    let mut archive = ZipArchiveWriter::new(OutFile::create(path)?);
    // `put(sample, row)` appends the bytes of a row.
    let mut member = |name: &str, kind: &str, shape: &[usize], put: &dyn Fn(usize, &mut Vec<u8>)| {
        add_member(&mut archive, &format!("{name}.npy"), |out| {
            out.write_all(&preamble(kind, shape))?;
            let mut row = Vec::new();
            samples.iter().try_for_each(|&sample| {
                row.clear();
                put(sample, &mut row);
                out.write_all(&row)
            })
        })
    };
    member("t", "<f8", &[rows], &|sample, row| row.extend((log.times()[sample] as f64 / 1e9).to_le_bytes()))?;
    member("step", "<u8", &[rows], &|sample, row| row.extend((log.steps().start + sample as u64).to_le_bytes()))?;
    for table in tables {
        for Column { name, vector, series, .. } in &table.columns {
            let shape = if *vector { vec![rows, series.width()] } else { vec![rows] };
            member(&format!("{}_{name}", table.name), "<f8", &shape, &|sample, row| {
                row.extend(series.row(sample).iter().flat_map(|value| value.to_le_bytes()));
            })?;
        }
    }
    archive.finish().map_err(io_error)?.commit()
}

/// Appends a member. It has no date, so that equal content is equal bytes.
fn add_member<W: Write>(
    archive: &mut ZipArchiveWriter<W>,
    name: &str,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let (mut entry, config) = archive.new_file(name).start().map_err(io_error)?;
    let mut content = config.wrap(&mut entry);
    write(&mut content)?;
    // Length and checksum follow the content, so that it need not be known before.
    let (_, descriptor) = content.finish().map_err(io_error)?;
    entry.finish(descriptor).map_err(io_error)?;
    Ok(())
}

fn io_error(error: rawzip::Error) -> io::Error {
    match error.into_kind() {
        ErrorKind::IO(error) => error,
        kind => io::Error::other(rawzip::Error::from(kind)),
    }
}

/// The header of an array, in version 1.0 of the format.
fn preamble(kind: &str, shape: &[usize]) -> Vec<u8> {
    const ALIGNMENT: usize = 64;
    let mut lengths: String = shape.iter().map(|length| format!("{length},")).collect();
    if shape.len() > 1 {
        lengths.pop();
    }
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({lengths}), }}");
    let fixed = b"\x93NUMPY\x01\x00".len() + 2;
    while !(fixed + text.len() + 1).is_multiple_of(ALIGNMENT) {
        text.push(' ');
    }
    text.push('\n');
    let length = (text.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_start_at_a_multiple_of_64() {
        for shape in [&[7][..], &[8001, 6]] {
            let bytes = preamble("<f8", shape);
            assert!(bytes.len().is_multiple_of(64) && bytes.ends_with(b"\n"));
            assert_eq!(usize::from(u16::from_le_bytes([bytes[8], bytes[9]])) + 10, bytes.len());
        }
        let text = String::from_utf8_lossy(&preamble("<f8", &[3])).into_owned();
        assert!(text.contains("'shape': (3,)"), "{text}");
    }

    #[test]
    fn errors_of_the_file_stay_what_they_are() {
        /// A disk without space.
        struct Full;

        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }

        let error = add_member(&mut ZipArchiveWriter::new(Full), "t.npy", |out| out.write_all(b"1")).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
