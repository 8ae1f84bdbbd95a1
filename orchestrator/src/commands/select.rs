//! From a name on the command line to an assembled scenario.

use std::path::Path;

use formation::config::{TextError, brief, did_you_mean, read_text};
use formation::data::DataSource;
use formation::scenario::Selection;
use formation::wiring::{Assembly, present};

use super::arguments::ScenarioArgs;
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::own::OwnMetric;
use crate::judge::{assertions, own};
use crate::recorded::{scenario_in, scenario_of};
use recording::{Head, Log};

/// Reads and connects the scenario that the command line names.
pub(super) fn assemble(catalog: &Catalog, args: &ScenarioArgs) -> Result<Assembly, Failure> {
    assemble_for(catalog, args, &[])
}

/// The same for a run with these swaps: if one is for the plant of a single agent, every agent's plant is one of its own.
pub(super) fn assemble_for(catalog: &Catalog, args: &ScenarioArgs, swaps: &[String]) -> Result<Assembly, Failure> {
    let (file, text) = find(catalog, &args.scenario)?;
    let mut selection = selection(args);
    selection.data = data_source(catalog, &args.scenario);
    selection.swapped_plants =
        swaps.iter().map(|swap| swap.split('=').next().unwrap_or_default().trim().into()).collect();
    add_present(catalog, &file, &text, &mut selection, &args.set_if_present)?;
    let mut assembly = Assembly::load(&file, &text, &selection, &catalog.roles)?;
    if catalog.scenario(&args.scenario).is_none() {
        assembly.scenario.folder = Path::new(&file).parent().map(Path::to_path_buf);
    }
    // What is wrong with an assertion or the metrics is said before anything starts.
    assertions::read(&assembly)?;
    let own = own::read(&assembly)?;
    check_metrics(catalog, &assembly)?;
    check_expected(&assembly, &own)?;
    Ok(assembly)
}

/// Whether there is a metric for every expectation, where the scenario names no set: those of a set depend on more than the scenario.
fn check_expected(assembly: &Assembly, own: &[OwnMetric]) -> Result<(), Failure> {
    let scenario = &assembly.scenario;
    let names_set = scenario.section("metrics").is_some_and(|section| section.as_table().is_none());
    if names_set || !scenario.metrics.is_empty() || !scenario.overrides.is_empty() {
        return Ok(());
    }
    let ids = || own.iter().map(|metric| metric.id.as_str());
    match scenario.expectations.keys().find(|id| !ids().any(|known| known == *id)) {
        None => Ok(()),
        Some(id) => {
            let (known, hint) = (ids().collect::<Vec<_>>().join(", "), did_you_mean(id, ids()));
            let message = format!("no metric is called `{id}`, expected one of {known}{hint}");
            Err(Failure::Invalid(vec![scenario.problem(&format!("expect.{id}"), message)]))
        }
    }
}

/// Whether there is the set of metrics that the scenario names.
fn check_metrics(catalog: &Catalog, assembly: &Assembly) -> Result<(), Failure> {
    let name = assembly.scenario.metrics.as_str();
    if name.is_empty() || catalog.metric_set(name).is_some() {
        return Ok(());
    }
    let names = catalog.metrics.iter().map(|set| set.name);
    let hint = did_you_mean(name, names.clone());
    let expected = names.collect::<Vec<_>>().join(", ");
    let message = format!("no set of metrics is called `{}`, expected one of {expected}{hint}", brief(name));
    Err(vec![assembly.scenario.problem("metrics", message).with_help("without any: --set metrics=")].into())
}

/// The scenario that a log holds, with its variant and overrides applied, and its components.
pub(super) fn from_log(catalog: &Catalog, log: &Log) -> Result<Assembly, Failure> {
    Ok(Assembly::new(scenario_of(log)?, &catalog.roles)?)
}

/// The scenario that a log holds, with its components; of the samples, none is read. What `selection` chooses comes on top.
pub(super) fn from_head(catalog: &Catalog, log: &Path, selection: &Selection) -> Result<Assembly, Failure> {
    let head = Head::read(log)?;
    let scenario = scenario_in(log, head.scenario.as_deref(), &head.data, Some(&head.metadata), selection)?;
    Ok(Assembly::new(scenario, &catalog.roles)?)
}

fn selection(args: &ScenarioArgs) -> Selection {
    let short = [("timing.dt", &args.dt), ("timing.duration", &args.duration), ("seed", &args.seed)];
    let short = short.into_iter().filter_map(|(path, value)| Some(format!("{path}={}", value.as_ref()?)));
    let overrides = args.set.iter().cloned().chain(short).collect();
    Selection { variant: args.variant.clone(), overrides, ..Selection::default() }
}

/// Adds those of the overrides `conditional` to the selection whose field its variant has. The others are left out.
pub(super) fn add_present(
    catalog: &Catalog,
    file: &str,
    text: &str,
    selection: &mut Selection,
    conditional: &[String],
) -> Result<(), Failure> {
    let found = present(file, text, selection, conditional, &catalog.roles)?;
    for left_out in conditional.iter().filter(|text| !found.contains(text)) {
        tracing::info!("--set-if-present {left_out}: this variant has no such field");
    }
    selection.overrides.extend(found);
    Ok(())
}

/// Where the data files of a scenario are: beside its file. A shipped one has none.
pub(super) fn data_source(catalog: &Catalog, name: &str) -> DataSource {
    let folder = Path::new(name).parent().map(Path::to_path_buf);
    match catalog.scenario(name) {
        Some(_) => DataSource::None,
        None => folder.map_or(DataSource::None, DataSource::Folder),
    }
}

/// Name and text of a shipped scenario, or of a file.
pub(super) fn find(catalog: &Catalog, name: &str) -> Result<(String, String), Failure> {
    if let Some(shipped) = catalog.scenario(name) {
        return Ok((shipped.file.into(), shipped.text.into()));
    }
    let path = Path::new(name);
    if path.is_file() || name.contains('/') || name.ends_with(".toml") {
        let text = read_text(path).map_err(|error| {
            let others = match error {
                TextError::System(_) => "; `phalanx list` shows those that are built in",
                _ => "",
            };
            Failure::Usage(format!("cannot read the scenario {name}: {error}{others}"))
        })?;
        return Ok((name.into(), text));
    }
    let names = catalog.scenarios.iter().map(|shipped| shipped.name);
    let hint = did_you_mean(name, names);
    let name = brief(name);
    Err(Failure::Usage(format!(
        "no scenario is called `{name}`, and there is no such file{hint}; `phalanx list` shows all"
    )))
}
