//! The text of a metric: a formula of reducers, `final(tracking) / max(tracking)`.

use formation::config::{brief, did_you_mean};
use formation::formula::{Expression, Formula, Operand};
use formation::wiring::Assembly;

use super::reducer::{Across, Reducer, Reduction, Subject, Threshold};
use crate::judge::assertions::{AgentSignal, Geometry, constant};

/// Compiles the value of a metric over these agents (from 0): its formula, and the reductions that it reads.
///
/// # Errors
/// The first mistake, in words.
pub(super) fn compile(
    text: &str,
    assembly: &Assembly,
    geometry: &Geometry,
    agents: &[usize],
) -> Result<(Formula, Vec<Reduction>), String> {
    let (outer, calls) = split(text)?;
    if calls.is_empty() {
        let names = Reducer::ALL.map(|(name, _)| name);
        let first: String = text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let hint = did_you_mean(&first, names);
        let expected = names.join(", ");
        return Err(format!(
            "expected a signal over time within one of {expected}, as in max(tracking), found {:?}{hint}",
            brief(text)
        ));
    }
    let reductions = calls.iter().map(|call| reduction(call, assembly, geometry, agents));
    let reductions = reductions.collect::<Result<Vec<_>, _>>()?;
    let operand = |name: &str| match name.strip_prefix(PLACEHOLDER).and_then(|place| place.parse().ok()) {
        Some(place) => Some(Operand::Slot(place)),
        None if name == "i" || name == "t" => None,
        None => constant(name, assembly, 0).map(Operand::Constant),
    };
    let formula = Expression::parse(&outer).and_then(|expression| expression.compile(operand));
    Ok((formula.map_err(|error| error.within(&outer))?, reductions))
}

/// The beginning of the name that stands for a reducer in the formula around it.
const PLACEHOLDER: &str = "reducer_";

/// The call of a reducer.
struct Call<'a> {
    name: &'a str,
    reducer: Reducer,
    /// What stands between the parentheses.
    inside: &'a str,
}

/// The formula with names in the place of reducers, and the reducers in their order.
fn split(text: &str) -> Result<(String, Vec<Call<'_>>), String> {
    let (mut outer, mut calls) = (String::new(), Vec::new());
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let mut rest = text;
    while let Some(next) = rest.chars().next() {
        if !is_word(next) {
            outer.push(next);
            rest = &rest[next.len_utf8()..];
            continue;
        }
        let word = &rest[..rest.find(|c| !is_word(c)).unwrap_or(rest.len())];
        rest = &rest[word.len()..];
        let known = Reducer::ALL.into_iter().find(|(name, _)| *name == word);
        let Some(((name, reducer), behind)) = known.zip(rest.trim_start().strip_prefix('(')) else {
            outer.push_str(word);
            continue;
        };
        let end = closing(behind).ok_or_else(|| format!("expected ')' behind {name}( in {:?}", brief(text)))?;
        outer.push_str(&format!("{PLACEHOLDER}{}", calls.len()));
        calls.push(Call { name, reducer, inside: &behind[..end] });
        rest = &behind[end + 1..];
    }
    Ok((outer, calls))
}

/// Where the parenthesis closes that is open before the text.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (place, character) in text.char_indices() {
        match character {
            '(' => depth += 1,
            ')' if depth == 0 => return Some(place),
            ')' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// The parts of the text between commas that stand in no parentheses.
fn arguments(text: &str) -> Vec<&str> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0_usize, 0);
    for (place, character) in text.char_indices() {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&text[start..place]);
                start = place + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

/// The options of a reducer.
const OPTIONS: [&str; 5] = ["from", "until", "across", "below", "within"];

fn reduction(call: &Call, assembly: &Assembly, geometry: &Geometry, agents: &[usize]) -> Result<Reduction, String> {
    let name = call.name;
    let timing = assembly.scenario.context.timing;
    let (mut signals, mut across) = (Vec::new(), Across::Max);
    let (mut from, mut until, mut threshold) = (0.0, None, None);
    for part in arguments(call.inside) {
        let Some((key, value)) = option(part) else {
            signals.push(part.trim());
            continue;
        };
        match key {
            "across" => across = word(value)?,
            "from" => from = number(key, value, assembly)?,
            "until" => until = Some(number(key, value, assembly)?),
            "below" => threshold = Some(Threshold::Below(number(key, value, assembly)?)),
            "within" => threshold = Some(Threshold::Within(number(key, value, assembly)?)),
            _ => {
                let hint = did_you_mean(key, OPTIONS);
                return Err(format!(
                    "{name}(...) has no option `{}`, expected one of {}{hint}",
                    brief(key),
                    OPTIONS.join(", ")
                ));
            }
        }
    }
    let [signal] = signals[..] else {
        return Err(format!(
            "expected one signal in {name}(...), found {}; options are written from = 20",
            signals.len()
        ));
    };
    if (call.reducer == Reducer::Settle) != threshold.is_some() {
        return Err(match threshold {
            None => "settle(...) needs `below = VALUE`, or `within = SHARE` of the first value".into(),
            Some(_) => format!("only settle(...) has `below` and `within`, and this is {name}(...)"),
        });
    }
    let end = until.unwrap_or(timing.duration);
    if from < 0.0 || end < from {
        return Err(format!("{name}(...): expected times 0 <= from <= until, found from = {from}, until = {end}"));
    }
    // A time that is a multiple of the step but for its last digits means that step. Casts saturate.
    let first = (from / timing.dt - 1e-6).ceil().max(0.0) as u64;
    let last = (end / timing.dt + 1e-6).floor() as u64;
    let is_condition = call.reducer == Reducer::Share;
    let subject = |&agent: &usize| {
        AgentSignal::compile(signal, assembly, geometry, agent, is_condition)
            .map(Subject::new)
            .map_err(|error| error.within(signal))
    };
    let subjects = agents.iter().map(subject).collect::<Result<_, _>>()?;
    let threshold = threshold.unwrap_or(Threshold::Below(0.0));
    Ok(Reduction { reducer: call.reducer, across, steps: (first, last), threshold, subjects })
}

/// `key = value`; a comparison is none.
fn option(part: &str) -> Option<(&str, &str)> {
    let (key, value) = part.split_once('=')?;
    let key = key.trim();
    let is_name = !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || c == '_');
    (is_name && !value.starts_with('=')).then(|| (key, value.trim()))
}

fn word(value: &str) -> Result<Across, String> {
    let plain = value.trim_matches(['"', '\'']);
    let found = Across::ALL.into_iter().find(|(name, _)| *name == plain).map(|(_, across)| across);
    found.ok_or_else(|| {
        let names = Across::ALL.map(|(name, _)| name);
        format!("across: expected one of {}, found `{}`{}", names.join(", "), brief(plain), did_you_mean(plain, names))
    })
}

fn number(key: &str, value: &str, assembly: &Assembly) -> Result<f64, String> {
    let operand = |name: &str| constant(name, assembly, 0).filter(|_| name != "i").map(Operand::Constant);
    let formula = Expression::parse(value).and_then(|expression| expression.compile(operand));
    let found = formula.map_err(|error| format!("{key}: {}", error.within(value)))?.evaluate(&[]);
    if found.is_finite() { Ok(found) } else { Err(format!("{key}: expected a finite number, found {found}")) }
}
