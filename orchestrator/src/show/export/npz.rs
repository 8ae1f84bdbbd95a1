//! NumPy archives: a zip file with an array in each member.

use std::io;
use std::path::Path;

use super::zip::Archive;
use super::{Column, Table};
use crate::files::OutFile;
use recording::Log;

/// Writes `t`, `step` and one array per field, a row for every `every`-th sample.
pub(crate) fn write_npz(path: &Path, log: &Log, tables: &[Table], every: usize) -> io::Result<()> {
    let samples: Vec<usize> = (0..log.times().len()).step_by(every).collect();
    let mut archive = Archive::new(OutFile::create(path)?);
    // `put(sample)` gives the bytes of a row.
    let mut member = |name: &str, kind: &str, shape: &[usize], put: &dyn Fn(usize, &mut Vec<u8>)| {
        archive.add(&format!("{name}.npy"), &|out| {
            out.write_all(&preamble(kind, shape))?;
            let mut row = Vec::new();
            samples.iter().try_for_each(|&sample| {
                row.clear();
                put(sample, &mut row);
                out.write_all(&row)
            })
        })
    };
    let rows = samples.len();
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
    archive.finish()?.commit()
}

/// What stands before the values of an array, in version 1.0 of the format.
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
}
