//! Which vehicle an agent has: the one of `[vehicle]`, or one of `[vehicles]` by its name.

use super::compile::{Row, Surroundings};
use super::description::Description;
use crate::config::{Node, Problems, Sort, did_you_mean, read};
use crate::scenario::model::LIBRARY;
use crate::scenario::standard_vehicle::{STANDARD_KINDS, VehicleSection};
use crate::vehicle::Model;

/// A vehicle of a scenario.
#[derive(Debug)]
pub(in crate::scenario) enum VehicleOf {
    /// One of the thesis.
    Standard(VehicleSection),
    /// One by equations.
    Equations(Equations),
}

/// A vehicle by equations.
#[derive(Debug)]
pub(in crate::scenario) struct Equations(Description);

/// The vehicles of a scenario.
#[derive(Debug)]
pub(in crate::scenario) struct Vehicles {
    common: Option<VehicleOf>,
    named: Vec<(String, VehicleOf)>,
}

impl Vehicles {
    /// Reads `[vehicle]` and `[vehicles]`; `None` if one of them is wrong, which is reported.
    pub(in crate::scenario) fn read(root: &Node, problems: &mut Problems) -> Option<Self> {
        let before = problems.len();
        let common = root.at("vehicle").and_then(|_| vehicle(root, "vehicle", problems));
        let mut named = Vec::new();
        match root.at("vehicles").map(|node| (node, node.as_table())) {
            Some((_, Some(table))) => {
                for (name, node) in table.iter() {
                    let path = format!("vehicles.{name}");
                    let found = vehicle(root, &path, problems);
                    if let (Some(VehicleOf::Standard(_)), Some(field)) =
                        (&found, ["UM", "actuator"].into_iter().find(|field| node.at(field).is_some()))
                    {
                        let message = "the actuators of all standard vehicles are alike: write it under [vehicle]";
                        problems.at(root, &format!("{path}.{field}"), message);
                    }
                    named.extend(found.map(|vehicle| (name.to_string(), vehicle)));
                }
            }
            Some((node, None)) => {
                _ = problems.at(root, "vehicles", format!("expected vehicles by name, found {}", node.describe()));
            }
            None if common.is_none() && root.at("vehicle").is_none() => {
                _ = problems.at(root, "", "missing section `[vehicle]`");
            }
            None => {}
        }
        (problems.len() == before).then_some(Self { common, named })
    }

    /// The section of all agents, if it is one of the thesis.
    pub(in crate::scenario) fn standard(&self) -> Option<&VehicleSection> {
        match &self.common {
            Some(VehicleOf::Standard(section)) => Some(section),
            _ => None,
        }
    }

    /// Whether all are of the thesis.
    pub(in crate::scenario) fn are_standard(&self) -> bool {
        let mut all = self.common.iter().chain(self.named.iter().map(|(_, vehicle)| vehicle));
        all.all(|vehicle| matches!(vehicle, VehicleOf::Standard(_)))
    }

    /// The vehicle of the agent whose row is at `path`, and its name among `[vehicles]`. What is wrong is reported.
    pub(in crate::scenario) fn of(
        &self,
        root: &Node,
        path: &str,
        problems: &mut Problems,
    ) -> Option<(&VehicleOf, &str)> {
        let path = format!("{path}.vehicle");
        let names = || self.named.iter().map(|(name, _)| name.as_str());
        match root.at(&path) {
            None => {
                if self.common.is_none() {
                    let list = names().collect::<Vec<_>>().join(", ");
                    let message = format!("missing: which vehicle of [vehicles] it is, one of {list}");
                    problems.at(root, &path, message).sort = Sort::Missing;
                }
                self.common.as_ref().map(|vehicle| (vehicle, ""))
            }
            Some(node) => {
                let name = node.as_str().unwrap_or_default();
                let found = self.named.iter().find(|(known, _)| known == name);
                if found.is_none() {
                    let list = names().collect::<Vec<_>>().join(", ");
                    let list = if list.is_empty() { "but the scenario has no [vehicles]".into() } else { list };
                    let hint = did_you_mean(name, names());
                    let message = format!("expected a name of [vehicles], {list}, found {}{hint}", node.describe());
                    problems.at(root, &path, message);
                }
                found.map(|(name, vehicle)| (vehicle, name.as_str()))
            }
        }
    }
}

impl Equations {
    /// The model of the agent at `place` (from 0) out of `count`, whose number in formulas is `id`. What is wrong is reported.
    pub(in crate::scenario) fn model(
        &self,
        around: Surroundings,
        place: usize,
        count: usize,
        id: u32,
        problems: &mut Problems,
    ) -> Option<Model> {
        let path = format!("agents.{}", place + 1);
        let node = around.root.at(&path)?;
        self.0.model(around, &Row { node, path, place, count, id }, problems)
    }
}

/// The vehicle that the section at `path` describes.
fn vehicle(root: &Node, path: &str, problems: &mut Problems) -> Option<VehicleOf> {
    let node = root.at(path)?;
    if node.as_table().is_none() {
        problems.at(root, path, format!("expected a table with the `kind` of the vehicle, found {}", node.describe()));
        return None;
    }
    match node.at("kind").and_then(Node::as_str) {
        Some("equations") => {
            Description::read(root, path, problems).map(|found| VehicleOf::Equations(Equations(found)))
        }
        Some(kind) if !STANDARD_KINDS.contains(&kind) => {
            let library = LIBRARY.iter().map(|vehicle| vehicle.name);
            let known: Vec<&str> = STANDARD_KINDS.iter().copied().chain(["equations"]).chain(library).collect();
            let hint = did_you_mean(kind, known.iter().copied());
            let message = format!("no vehicle is called `{kind}`, expected one of {}{hint}", known.join(", "));
            problems.at(root, &format!("{path}.kind"), message);
            None
        }
        _ => {
            let section = read::<VehicleSection>(node, path, problems)?;
            if let Some(message) = section.wrong_angle() {
                problems.at(root, &format!("{path}.angles"), message);
            }
            Some(VehicleOf::Standard(section))
        }
    }
}
