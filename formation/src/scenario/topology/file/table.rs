//! CSV: links under the header `from,to,weight`, or the rows of the adjacency matrix.

use std::ops::Range;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::nodes::Nodes;
use super::{FileLink, GraphFile, Wrong, weight};
use crate::config::{brief, did_you_mean};

/// Reads a table whose first line is a header, or a matrix where it consists of numbers.
pub(super) fn parse(text: &str) -> Result<GraphFile, Wrong> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let mut records = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| Wrong::new(0..text.len(), format!("not valid CSV: {error}")))?;
        let start = record.position().map_or(0, |position| position.byte() as usize);
        records.push((line(text, start), record));
    }
    let Some((place, header)) = records.first() else {
        return Err(Wrong::new(0..text.len(), "expected the header `from,to,weight` or a matrix, found an empty file"));
    };
    if header.iter().all(|field| field.parse::<f64>().is_ok()) {
        return matrix(&records);
    }
    let column =
        |names: [&str; 2]| header.iter().position(|field| names.contains(&field.to_ascii_lowercase().as_str()));
    let need = |names: [&'static str; 2]| {
        column(names).ok_or_else(|| {
            let hint = did_you_mean(names[0], header.iter());
            let message = format!("the header has no column `{}`{hint}", names[0]);
            let help = "expected from,to or from,to,weight (source,target,weight too), or a matrix of numbers without a header";
            Wrong::new(place.clone(), message).with_help(help)
        })
    };
    let (from, to) = (need(["from", "source"])?, need(["to", "target"])?);
    links(&records[1..], [from, to], column(["weight", "weight"]))
}

/// The line of the text at or after byte `start`.
fn line(text: &str, start: usize) -> Range<usize> {
    let skipped = text[start..].len() - text[start..].trim_start_matches(['\r', '\n']).len();
    let begin = start + skipped;
    begin..begin + text[begin..].find(['\r', '\n']).unwrap_or(text.len() - begin)
}

fn links(
    records: &[(Range<usize>, StringRecord)],
    ends: [usize; 2],
    weights: Option<usize>,
) -> Result<GraphFile, Wrong> {
    let mut nodes = Nodes::default();
    let mut found = Vec::with_capacity(records.len());
    for (place, record) in records {
        let [from, to] = ends.map(|column| record.get(column).filter(|id| !id.is_empty()));
        let (Some(from), Some(to)) = (from, to) else {
            return Err(Wrong::new(place.clone(), "expected a sender and a receiver in every line"));
        };
        let value = weights.and_then(|column| record.get(column)).filter(|text| !text.is_empty());
        let value = value.map(|text| weight(text, place.clone())).transpose()?;
        found.push((nodes.place(from, place.clone()), nodes.place(to, place.clone()), value, place.clone()));
    }
    let (numbers, nodes) = nodes.linked_numbers()?;
    let link = |(from, to, weight, span): (usize, usize, Option<f64>, Range<usize>)| {
        let [from, to] = [from, to].map(|place| numbers[place]);
        FileLink { from, to, weight, span }
    };
    Ok(GraphFile { links: found.into_iter().map(link).collect(), directed: None, nodes })
}

/// Row i has the weights of the links over which agent i receives.
fn matrix(records: &[(Range<usize>, StringRecord)]) -> Result<GraphFile, Wrong> {
    let size = records.len();
    let mut links = Vec::new();
    for (to, (span, record)) in records.iter().enumerate() {
        if record.len() != size {
            let found = record.len();
            let message = format!("expected {size} numbers, one for each line of the matrix, found {found}");
            return Err(Wrong::new(span.clone(), message));
        }
        for (from, field) in record.iter().enumerate() {
            let value = weight(field, span.clone())?;
            if value > 0.0 && from == to {
                let message = format!(
                    "column {}: an agent is not its own neighbour, expected 0, found {}",
                    from + 1,
                    brief(field)
                );
                return Err(Wrong::new(span.clone(), message));
            }
            if value > 0.0 {
                links.push(FileLink {
                    from: from as u64 + 1,
                    to: to as u64 + 1,
                    weight: Some(value),
                    span: span.clone(),
                });
            }
        }
    }
    Ok(GraphFile { links, directed: Some(true), nodes: Some(size) })
}
