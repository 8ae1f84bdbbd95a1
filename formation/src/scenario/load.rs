//! Reading a scenario file.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use lockstep::Timing;

use super::data::{read_digests, with_digests};
use super::model::resolve;
use super::overrides::{Override, apply, override_problem};
use super::plant_groups::{read_plant_groups, split_plant};
use super::program_parameters::check_with;
use super::ranges::read_ranges;
use super::raw::RawScenario;
use super::realtime::read_overrun;
use super::run_sections::{read_edges, read_groups, read_swaps};
use super::topology::resolve_files;
use super::{Context, Expectation, FailurePolicy, FieldRange, Overrun};
use crate::config::{Entry, Node, Problem, Problems, Source, Table, Value, did_you_mean, read};
use crate::data::{DataCurves, DataFile, DataSource, Library};
use crate::role::Role;

/// What the command line chooses: a variant and overrides `PATH=VALUE`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Name of a variant; `None`: the one that the file names.
    pub variant: Option<String>,
    /// Overrides in order.
    pub overrides: Vec<String>,
    /// Names of plants that something else plays, `plant.2` or `plant.1,3-6`: whatever the scenario says, the plant of these agents
    /// is a participant by itself then.
    pub swapped_plants: Vec<String>,
    /// Where the data files of formulas are.
    pub data: DataSource,
}

/// A scenario: complete, and checked as far as no component is concerned.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Its name, `uav`.
    pub name: String,
    /// One line.
    pub title: String,
    /// Chapter or section of the thesis; empty if none.
    pub thesis: String,
    /// The variant that is selected; empty if the file has none.
    pub variant: String,
    /// Every variant that the file offers, in order.
    pub variants: Vec<String>,
    /// Overrides that were applied.
    pub overrides: Vec<String>,
    /// What every component may know.
    pub context: Context,
    /// Whether every agent's plant is a participant of its own, apart from `plant_groups`.
    pub plant_per_agent: bool,
    /// Agents (from 0) whose plants are one participant where others are participants by themselves.
    pub plant_groups: Vec<Vec<usize>>,
    /// Participants that share a process, by process; empty if the scenario does not say.
    pub groups: Vec<Vec<String>>,
    /// What is to be done when a participant fails.
    pub on_failure: FailurePolicy,
    /// What is to be done about steps that are late, if the scenario says so.
    pub overrun: Option<Overrun>,
    /// Names of participants that something else plays, `plant.2` or `controller.*`, and what that is, as for `--swap`.
    pub swaps: Vec<(String, String)>,
    /// The folder of its file, which paths in `[swap]` start from; `None` if it is no file, or its folder is not known.
    pub folder: Option<PathBuf>,
    /// Edges `reader <- writer` whose timing is not that of their components.
    pub edges: Vec<(String, Timing)>,
    /// The data files that its formulas read, by their paths.
    pub data: Vec<DataFile>,
    /// Ranges of fields, which stop the run if they are left.
    pub ranges: Vec<FieldRange>,
    /// Which set of metrics applies; empty if none.
    pub metrics: String,
    /// What should come out, by metric.
    pub expectations: BTreeMap<String, Expectation>,
    root: Node,
}

impl Scenario {
    /// Reads the scenario in `text`; `file` is what messages call it.
    ///
    /// # Errors
    /// Everything that is wrong, each with its place.
    pub fn load(file: &str, text: &str, selection: &Selection) -> Result<Self, Vec<Problem>> {
        let mut problems = Problems::default();
        match Self::collect(file, text, selection, &mut problems) {
            Some(scenario) if problems.is_empty() => Ok(scenario),
            _ => Err(problems.into_vec()),
        }
    }

    /// Like [`Scenario::load`], but what is wrong goes to `problems`, and dummies take its place as far as possible, so that
    /// the components can be checked too.
    pub(crate) fn collect(file: &str, text: &str, selection: &Selection, problems: &mut Problems) -> Option<Self> {
        match Self::tree(file, text, selection) {
            Ok((root, variant, variants)) => Self::read(root, variant, variants, selection, problems),
            Err(problem) => {
                problems.push(problem);
                None
            }
        }
    }

    /// The effective tree, the name of its variant and those of all variants.
    fn tree(file: &str, text: &str, selection: &Selection) -> Result<(Node, String, Vec<String>), Problem> {
        let source = Arc::new(Source { name: file.to_string(), text: text.to_string() });
        let mut root = Node::parse(source)?;
        let overrides: Vec<Override> =
            selection.overrides.iter().map(|o| Override::parse(o)).collect::<Result<_, _>>()?;
        let variants = variant_names(&root);
        let chosen = overrides.iter().rev().find_map(|o| o.value_of("variant")).or(selection.variant.as_deref());
        let variant = select_variant(&mut root, chosen, &variants)?;
        resolve(&mut root, file)?;
        let rest: Vec<Override> = overrides.into_iter().filter(|o| o.value_of("variant").is_none()).collect();
        // The command line may choose among the agents of a graph, or give another graph.
        let is_graph = |o: &Override| o.path().starts_with("topology.graph");
        if !rest.iter().any(is_graph) {
            resolve_files(&mut root, file)?;
        }
        apply(&mut root, &rest)?;
        resolve_files(&mut root, file)?;
        // An override may have chosen another vehicle.
        resolve(&mut root, file)?;
        complete(&mut root);
        if let Some(variants) = root.at("variants") {
            let message = "a variant is chosen, with --variant NAME or --set variant=NAME, and changed in the file";
            return Err(Problem::new(Some(variants.origin.clone()), "variants", message));
        }
        split_plant(&mut root, selection);
        Ok((root, variant, variants))
    }

    fn read(
        root: Node,
        variant: String,
        variants: Vec<String>,
        selection: &Selection,
        problems: &mut Problems,
    ) -> Option<Self> {
        // Without it, one of its values is wrong, and the rest is still checked.
        let raw = read::<RawScenario>(&root, "", problems);
        let is_name =
            |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
        if raw.as_ref().is_some_and(|raw| !is_name(raw.name.as_deref().unwrap_or_default())) {
            problems.at(&root, "name", "expected a name of letters, digits, `-` and `_`");
        }
        let RawScenario { name, title, thesis, seed, expect: expectations, .. } = raw.unwrap_or_default();
        // The log is named after the variant, and must stay in its folder.
        let harmless =
            |name: &&String| name.len() <= 64 && !name.contains(['/', '\\']) && !name.contains(char::is_control);
        if let Some(wrong) = variants.iter().find(|name| !harmless(name)) {
            let message =
                format!("expected names of variants of at most 64 characters, without slashes, found {wrong:?}");
            problems.at(&root, "variant", message);
        }
        if let Some(expected) = root.at("expect").and_then(Node::as_table) {
            let wrong =
                expected.entries().iter().filter_map(|entry| Some((entry, expectations.get(&entry.key)?.wrong()?)));
            problems.extend(wrong.map(|(Entry { key, node, .. }, wrong)| {
                Problem::new(Some(node.origin.clone()), format!("expect.{key}"), wrong)
            }));
        }
        let plant_per_agent = match root.at("plant.per_agent") {
            Some(node) => read::<bool>(node, "plant.per_agent", problems).unwrap_or(false),
            None => false,
        };
        check_rates(&root, problems);
        check_with(&root, problems);
        let groups = read_groups(&root, problems);
        let edges = read_edges(&root, problems);
        let swaps = read_swaps(&root, problems);
        let ranges = read_ranges(&root, problems);
        let metrics = read_metric_set(&root, problems);
        let library = RefCell::new(Library::new(selection.data.clone(), read_digests(&root, problems)));
        let mut context = Context::read(&root, seed, &library, problems)?;
        let mut library = library.into_inner();
        library.prepare(Role::ALL.into_iter().filter_map(|role| root.at(role.name())).flat_map(Node::texts));
        let data = library.files();
        context.curves = DataCurves::new(library);
        let (on_failure, overrun) = (FailurePolicy::read(&root, problems), read_overrun(&root, problems));
        Some(Self {
            name: name.unwrap_or_default(),
            title: title.unwrap_or_default(),
            thesis: thesis.unwrap_or_default(),
            variant,
            variants,
            overrides: selection.overrides.clone(),
            context,
            plant_per_agent,
            plant_groups: read_plant_groups(&root, problems),
            groups,
            on_failure,
            overrun,
            edges,
            swaps,
            folder: None,
            root: with_digests(root, &data),
            data,
            ranges,
            metrics,
            expectations,
        })
    }

    /// Its name with that of its variant, if it has any: `uav TSC`, `triangle`.
    pub fn label(&self) -> String {
        [self.name.as_str(), &self.variant].join(" ").trim_end().to_string()
    }

    /// A section of the effective scenario.
    pub fn section(&self, name: &str) -> Option<&Node> {
        self.root.at(name)
    }

    /// The names of all values that are no tables, each once.
    pub(super) fn leaf_names(&self) -> Vec<String> {
        self.root.leaf_names()
    }

    /// The dotted paths of all values of this name that are no tables.
    pub(super) fn paths_of(&self, name: &str) -> Vec<String> {
        self.root.find_leaf(name)
    }

    /// The section that describes the component of a role. An observer of the kind `none` is no observer: so a variant drops
    /// the one of its file.
    pub fn component(&self, role: Role) -> Option<&Node> {
        let dropped =
            |section: &&Node| role == Role::Observer && section.at("kind").and_then(Node::as_str) == Some("none");
        self.section(role.name()).filter(|section| !dropped(section))
    }

    /// The effective scenario as TOML: the variant and all overrides applied. Loading it again gives this scenario.
    pub fn to_toml(&self) -> String {
        self.root.to_toml()
    }

    /// The same with these values in the sections of roles, as far as the file does not give them.
    pub(crate) fn with_defaults(&self, defaults: impl IntoIterator<Item = (Role, Vec<(String, Value)>)>) -> String {
        let mut root = self.root.clone();
        for (role, values) in defaults {
            let Some(section) = root.at_mut(role.name()).and_then(Node::as_table_mut) else { continue };
            for (name, value) in values {
                if section.get(&name).is_none() {
                    section.insert(name, Node::from_override(value, "default"));
                }
            }
        }
        root.to_toml()
    }

    /// The same without `[placement]`, `[on_failure]`, `[realtime]` and `[swap]`, which say what computes it and how it is carried
    /// out, and
    /// not what comes out: they do not belong into a log.
    pub fn to_record(&self) -> String {
        let mut root = self.root.clone();
        if let Some(table) = root.as_table_mut() {
            table.remove("placement");
            table.remove("on_failure");
            table.remove("realtime");
            table.remove("swap");
        }
        root.to_toml()
    }

    /// A problem at `path`, or at the closest place above it that exists.
    pub fn problem(&self, path: &str, message: impl Into<String>) -> Problem {
        let mut problems = Problems::default();
        problems.at(&self.root, path, message);
        problems.into_vec().remove(0)
    }

    /// How often a role runs: every so many steps, starting with this one.
    pub fn rate(&self, role: Role) -> (u64, u64) {
        let number = |field: &str, default| {
            let node = self.root.at(&format!("{role}.{field}"));
            node.and_then(Node::as_i64).and_then(|value| u64::try_from(value).ok()).unwrap_or(default)
        };
        (number("every", 1), number("offset", 0))
    }
}

/// The sections that a scenario may leave out: the plant that integrates its vehicles, and the planner that publishes its reference.
fn complete(root: &mut Node) {
    let has_reference = root.at("reference").is_some();
    let Some(table) = root.as_table_mut() else { return };
    let mut default = |role: Role, kind: &str| {
        let kind = Node::from_override(Value::String(kind.into()), role.name());
        match table.get_mut(role.name()).map(Node::as_table_mut) {
            Some(Some(section)) if section.get("kind").is_none() => _ = section.insert("kind", kind),
            Some(_) => {}
            None => {
                let mut section = Table::default();
                section.insert("kind", kind);
                table.insert(role.name(), Node::from_override(Value::Table(section), role.name()));
            }
        }
    };
    default(Role::Plant, "vehicles");
    if has_reference {
        default(Role::Planner, "reference");
    }
}

/// The set of metrics that the scenario names, `metrics = "uav"` or `[metrics] set = "uav"`; empty if none.
fn read_metric_set(root: &Node, problems: &mut Problems) -> String {
    let (path, node) = match root.at("metrics") {
        None => return String::new(),
        Some(node) if node.as_table().is_some() => ("metrics.set", node.at("set")),
        Some(node) => ("metrics", Some(node)),
    };
    let Some(node) = node else { return String::new() };
    let Some(name) = node.as_str() else {
        let message = match path {
            "metrics" => {
                format!("expected the name of a set of metrics, or a table of formulas, found {}", node.describe())
            }
            _ => format!("expected the name of a set of metrics, found {}", node.describe()),
        };
        problems.push(Problem::new(Some(node.origin.clone()), path, message));
        return String::new();
    };
    name.into()
}

fn check_rates(root: &Node, problems: &mut Problems) {
    const MOST: i64 = 1_000_000;
    for role in Role::ALL {
        for (field, least) in [("every", 1), ("offset", 0)] {
            let path = format!("{role}.{field}");
            let Some(node) = root.at(&path) else { continue };
            if node.as_i64().is_none_or(|value| value < least || value > MOST) {
                let found = node.describe();
                problems.at(
                    root,
                    &path,
                    format!("expected a whole number of steps from {least} to {MOST}, found {found}"),
                );
            }
        }
    }
}

/// The default variant first: it is the file itself, and needs no table of its own.
fn variant_names(root: &Node) -> Vec<String> {
    let default = root.at("variant").and_then(Node::as_str);
    let mut names: Vec<String> = default.map(str::to_string).into_iter().collect();
    if let Some(table) = root.at("variants").and_then(Node::as_table) {
        names.extend(table.iter().map(|(name, _)| name.to_string()).filter(|name| Some(name.as_str()) != default));
    }
    names
}

/// Overlays the variant `chosen`, or the one that the file names, and drops the table of variants.
fn select_variant(root: &mut Node, chosen: Option<&str>, names: &[String]) -> Result<String, Problem> {
    let default = root.at("variant").and_then(Node::as_str).unwrap_or_default().to_string();
    let name = chosen.unwrap_or(&default).to_string();
    let Some(table) = root.as_table_mut() else { return Ok(name) };
    let variants = table.remove("variants");
    if name.is_empty() {
        return Ok(name);
    }
    if !names.contains(&name) {
        let hint = did_you_mean(&name, names.iter().map(String::as_str));
        let expected = if names.is_empty() { "this scenario has none".into() } else { names.join(", ") };
        let message = format!("no variant is called `{name}`, expected one of: {expected}{hint}");
        return Err(match (chosen, table.get("variant")) {
            (None, Some(node)) => Problem::new(Some(node.origin.clone()), "variant", message),
            _ => override_problem(&format!("variant={name}"), &message),
        });
    }
    if name != default {
        // The expectations of the file are those of its default variant.
        table.remove("expect");
        table.insert("variant", Node::from_override(Value::String(name.clone()), "variant"));
    }
    if let Some(overlay) = variants.and_then(|mut node| node.as_table_mut().and_then(|table| table.remove(&name))) {
        root.overlay(overlay)?;
    }
    Ok(name)
}
