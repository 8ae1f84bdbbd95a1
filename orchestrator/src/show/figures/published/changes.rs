//! In what runs differ from those that a published figure shows.

use std::collections::BTreeMap;

use formation::scenario::{Scenario, Selection};

use crate::catalog::Catalog;
use crate::show::view::LoggedRun;

/// Sections that say what is expected of a run, and not what it computes.
const JUDGING: [&str; 6] = ["title", "thesis", "metrics", "expect", "claims", "assert"];

/// What was changed about some runs.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Changes {
    /// Values that differ, each once.
    overridden: Vec<String>,
    /// Other reasons, in words.
    other: Vec<String>,
}

impl Changes {
    /// What was changed about `runs`.
    pub(super) fn of(catalog: &Catalog, runs: &[&LoggedRun]) -> Self {
        let mut changes = Self::default();
        for run in runs {
            let Some(scenario) = &run.scenario else { continue };
            let (overridden, other) = (&mut changes.overridden, &mut changes.other);
            let add = |list: &mut Vec<String>, text: String| {
                if !list.contains(&text) {
                    list.push(text);
                }
            };
            differences(catalog, scenario).into_iter().for_each(|text| add(overridden, text));
            run.caveats.iter().for_each(|caveat| add(other, caveat.trim_end_matches('.').to_string()));
        }
        changes
    }

    /// What stands behind the name of the figure.
    pub(super) fn mark(&self) -> &'static str {
        match (self.overridden.is_empty(), self.other.is_empty()) {
            (true, true) => "",
            (false, _) => "-overridden",
            (true, false) => "-changed",
        }
    }

    /// What stands above the plots.
    pub(super) fn note(&self) -> String {
        let mut parts = Vec::new();
        if !self.overridden.is_empty() {
            parts.push(format!("overridden: {}", self.overridden.join(", ")));
        }
        parts.extend(self.other.iter().cloned());
        parts.join("; ")
    }
}

/// The values in which a scenario differs from the one of its name and variant that comes with the program: `controller.c_p = 3`.
fn differences(catalog: &Catalog, scenario: &Scenario) -> Vec<String> {
    let shipped = catalog.scenario(&scenario.name).and_then(|shipped| {
        let selection = Selection { variant: Some(scenario.variant.clone()), ..Selection::default() };
        Scenario::load(shipped.file, shipped.text, &selection).ok()
    });
    let (Some(shipped), own) = (shipped.map(|shipped| leaves(&shipped)), leaves(scenario)) else {
        return vec!["a scenario that does not come with the program".into()];
    };
    let changed = own.iter().filter(|(path, value)| shipped.get(*path) != Some(*value));
    let mut found: Vec<String> = changed.map(|(path, value)| format!("{path} = {value}")).collect();
    found.extend(shipped.keys().filter(|path| !own.contains_key(*path)).map(|path| format!("no {path}")));
    found
}

/// All values of a scenario that decide what it computes, by their paths.
fn leaves(scenario: &Scenario) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    if let Ok(table) = toml::from_str::<toml::Table>(&scenario.to_record()) {
        let deciding = table.into_iter().filter(|(name, _)| !JUDGING.contains(&name.as_str()));
        deciding.for_each(|(name, value)| add_leaves(&mut leaves, name, value));
    }
    leaves
}

fn add_leaves(leaves: &mut BTreeMap<String, String>, path: String, value: toml::Value) {
    match value {
        toml::Value::Table(table) => {
            table.into_iter().for_each(|(name, value)| add_leaves(leaves, format!("{path}.{name}"), value));
        }
        value => drop(leaves.insert(path, short(&value))),
    }
}

/// A value, shortened where it is a long list.
fn short(value: &toml::Value) -> String {
    const LONG: usize = 40;
    let text = value.to_string();
    if text.chars().count() <= LONG { text } else { format!("{} ...", text.chars().take(LONG).collect::<String>()) }
}
