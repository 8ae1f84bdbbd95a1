//! A list of links: `from to [weight]` in every line, with `#` before comments.

use std::ops::Range;

use super::nodes::Nodes;
use super::{FileLink, GraphFile, Wrong, weight};
use crate::config::brief;

/// Reads the list. A dictionary of Python in the place of the weight, as networkx writes it, may have the key `weight`.
pub(super) fn parse(text: &str) -> Result<GraphFile, Wrong> {
    let mut nodes = Nodes::default();
    let mut links = Vec::new();
    let mut start = 0;
    for whole in text.split_inclusive('\n') {
        let line = whole.split('#').next().unwrap_or_default();
        let words = words(line, start);
        let span = start..start + whole.trim_end().len();
        start += whole.len();
        let (ends, rest) = match &words[..] {
            [] => continue,
            [from, to, rest @ ..] => ([from, to], rest),
            _ => return Err(Wrong::new(span, format!("expected `from to [weight]`, found `{}`", brief(line.trim())))),
        };
        let found = match rest {
            [] => None,
            [(first, _), ..] if first.starts_with('{') => {
                let begin = rest[0].1.start - span.start;
                dictionary(line[begin..].trim(), span.clone())?
            }
            [(word, place)] => Some(weight(word, place.clone())?),
            [_, (word, place), ..] => {
                let message = format!("expected the end of the line after `from to weight`, found `{}`", brief(word));
                return Err(Wrong::new(place.clone(), message));
            }
        };
        let [from, to] = ends.map(|(id, place)| nodes.place(id, place.clone()));
        links.push((from, to, found, span));
    }
    let (numbers, nodes) = nodes.linked_numbers()?;
    let link = |(from, to, weight, span): (usize, usize, Option<f64>, Range<usize>)| {
        let [from, to] = [from, to].map(|place| numbers[place]);
        FileLink { from, to, weight, span }
    };
    Ok(GraphFile { links: links.into_iter().map(link).collect(), directed: None, nodes })
}

/// The words of a line that starts at byte `start` of the text, with their places.
fn words(line: &str, start: usize) -> Vec<(&str, Range<usize>)> {
    let offset = |word: &str| word.as_ptr() as usize - line.as_ptr() as usize + start;
    line.split_whitespace().map(|word| (word, offset(word)..offset(word) + word.len())).collect()
}

/// The weight in `{'weight': 0.5}`, if there is one.
fn dictionary(text: &str, span: Range<usize>) -> Result<Option<f64>, Wrong> {
    let inner = text.strip_prefix('{').and_then(|text| text.strip_suffix('}'));
    let inner = inner.ok_or_else(|| Wrong::new(span.clone(), "expected `}` at the end of the line"))?;
    let is_weight = |pair: &&str| pair.trim().trim_start_matches(['\'', '"']).starts_with("weight");
    let Some(pair) = inner.split(',').find(is_weight) else { return Ok(None) };
    let value = pair.split_once(':').map_or("", |(_, value)| value.trim());
    weight(value, span).map(Some)
}
