//! The scenario that a log holds.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use formation::data::DataSource;
use formation::scenario::{Scenario, Selection};

use crate::failure::Failure;
use recording::Log;

/// The scenario that a log holds, with its variant and overrides applied.
///
/// # Errors
/// [`Failure`] if it holds none, or one that is not valid.
pub(crate) fn scenario_of(log: &Log) -> Result<Scenario, Failure> {
    scenario_in(log.path(), log.scenario_text(), log.data(), log.metadata(), &Selection::default())
}

/// The scenario whose text, data files and metadata stand in `log`; what `selection` chooses comes on top.
///
/// # Errors
/// [`Failure`] if there is none, or it is not valid.
pub(crate) fn scenario_in(
    log: &Path,
    text: Option<&str>,
    data: &BTreeMap<String, Arc<[u8]>>,
    metadata: Option<&BTreeMap<String, String>>,
    selection: &Selection,
) -> Result<Scenario, Failure> {
    let file = log.display();
    let Some(text) = text else {
        return Err(Failure::Usage(format!("{file} holds no scenario; was it recorded by `phalanx run`?")));
    };
    let selection = Selection { data: DataSource::Bytes(data.clone()), ..selection.clone() };
    let mut scenario = Scenario::load(&format!("{file} (scenario.toml)"), text, &selection)?;
    let overrides = metadata.and_then(|metadata| metadata.get("overrides"));
    scenario.overrides = overrides.map(|text| text.lines().map(str::to_string).collect()).unwrap_or_default();
    Ok(scenario)
}
