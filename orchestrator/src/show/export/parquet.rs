//! Parquet files: columns of doubles, compressed with Zstandard, one file for each topic.
//!
//! All columns are required and encoded plainly, so that a page is its values and nothing else. What stands around them is of
//! the format's version 1, which every reader knows.

use std::io::{self, Write};
use std::path::Path;

use super::thrift::{Struct, Value};
use super::{Table, names};
use crate::files::OutFile;
use recording::Log;

const MAGIC: &[u8] = b"PAR1";
/// Rows of a group; readers take in one group at a time.
const GROUP_ROWS: usize = 1 << 18;
/// A compression that costs little time.
const LEVEL: i32 = 3;

// Numbers of the format.
const INT64: i32 = 2;
const DOUBLE: i32 = 5;
const REQUIRED: i32 = 0;
const ZSTD: i32 = 6;
const PLAIN: i32 = 0;
const RLE: i32 = 3;
const DATA_PAGE: i32 = 0;

/// A page that has been written.
struct Chunk {
    name: String,
    kind: i32,
    rows: usize,
    offset: u64,
    /// Lengths with the head of the page: raw, and as it stands in the file.
    raw: usize,
    stored: usize,
}

/// Writes a topic, every `every`-th sample of it: `t`, `step`, then a column per number.
pub(crate) fn write_parquet(path: &Path, log: &Log, table: &Table, every: usize) -> io::Result<()> {
    let samples: Vec<usize> = (0..log.times().len()).step_by(every).collect();
    let names = names(table);
    let mut out = Output { file: OutFile::create(path)?, at: 0 };
    out.write(MAGIC)?;
    let mut groups = Vec::new();
    for samples in samples.chunks(GROUP_ROWS) {
        let mut chunks = Vec::with_capacity(names.len());
        let mut columns = names.iter();
        let mut put = |kind, bytes: Vec<u8>| {
            let name = columns.next().cloned().unwrap_or_default();
            chunks.push(out.page(name, kind, samples.len(), &bytes)?);
            Ok::<(), io::Error>(())
        };
        let times = samples.iter().map(|&sample| log.times()[sample] as f64 / 1e9);
        put(DOUBLE, times.flat_map(f64::to_le_bytes).collect())?;
        let steps = samples.iter().map(|&sample| (log.steps().start + sample as u64) as i64);
        put(INT64, steps.flat_map(i64::to_le_bytes).collect())?;
        for column in &table.columns {
            for &component in &column.components {
                let values = samples.iter().map(|&sample| column.series.row(sample)[component]);
                put(DOUBLE, values.flat_map(f64::to_le_bytes).collect())?;
            }
        }
        groups.push((samples.len(), chunks));
    }
    let foot = foot(log, &names, samples.len(), &groups).bytes();
    out.write(&foot)?;
    out.write(&(foot.len() as u32).to_le_bytes())?;
    out.write(MAGIC)?;
    out.file.commit()
}

struct Output {
    file: OutFile,
    at: u64,
}

impl Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn page(&mut self, name: String, kind: i32, rows: usize, bytes: &[u8]) -> io::Result<Chunk> {
        let stored = zstd::bulk::compress(bytes, LEVEL)?;
        let page = Struct(vec![
            (1, Value::I32(rows as i32)),
            (2, Value::I32(PLAIN)),
            // Levels of columns that are required take no bytes.
            (3, Value::I32(RLE)),
            (4, Value::I32(RLE)),
        ]);
        let head = Struct(vec![
            (1, Value::I32(DATA_PAGE)),
            (2, Value::I32(bytes.len() as i32)),
            (3, Value::I32(stored.len() as i32)),
            (5, Value::Struct(page)),
        ])
        .bytes();
        let offset = self.at;
        self.write(&head)?;
        self.write(&stored)?;
        Ok(Chunk { name, kind, rows, offset, raw: head.len() + bytes.len(), stored: head.len() + stored.len() })
    }
}

/// What stands at the end of a file: its columns, where their pages are, and what the run was.
fn foot(log: &Log, names: &[String], rows: usize, groups: &[(usize, Vec<Chunk>)]) -> Struct {
    let text = |text: &str| Value::Text(text.into());
    let kind = |name: &str| if name == "step" { INT64 } else { DOUBLE };
    let root = Struct(vec![(4, text("schema")), (5, Value::I32(names.len() as i32))]);
    let column =
        |name: &String| Struct(vec![(1, Value::I32(kind(name))), (3, Value::I32(REQUIRED)), (4, text(name.as_str()))]);
    let schema = std::iter::once(root).chain(names.iter().map(column)).map(Value::Struct).collect();
    let groups = groups.iter().map(|(rows, chunks)| {
        let raw = chunks.iter().map(|chunk| chunk.raw as i64).sum();
        let chunks = chunks.iter().map(|chunk| Value::Struct(described(chunk))).collect();
        Value::Struct(Struct(vec![(1, Value::List(chunks)), (2, Value::I64(raw)), (3, Value::I64(*rows as i64))]))
    });
    let about = log.metadata().into_iter().flatten().filter(|(_, value)| !value.is_empty());
    let about = about.map(|(key, value)| Value::Struct(Struct(vec![(1, text(key)), (2, text(value))])));
    Struct(vec![
        (1, Value::I32(1)),
        (2, Value::List(schema)),
        (3, Value::I64(rows as i64)),
        (4, Value::List(groups.collect())),
        (5, Value::List(about.collect())),
        (6, text(concat!("phalanx version ", env!("CARGO_PKG_VERSION")))),
    ])
}

fn described(chunk: &Chunk) -> Struct {
    let offset = chunk.offset as i64;
    let data = Struct(vec![
        (1, Value::I32(chunk.kind)),
        (2, Value::List(vec![Value::I32(PLAIN), Value::I32(RLE)])),
        (3, Value::List(vec![Value::Text(chunk.name.clone())])),
        (4, Value::I32(ZSTD)),
        (5, Value::I64(chunk.rows as i64)),
        (6, Value::I64(chunk.raw as i64)),
        (7, Value::I64(chunk.stored as i64)),
        (9, Value::I64(offset)),
    ]);
    Struct(vec![(2, Value::I64(offset)), (3, Value::Struct(data))])
}
