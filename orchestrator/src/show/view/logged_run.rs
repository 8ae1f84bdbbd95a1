//! A log, and what is known about it.

use std::path::Path;

use formation::scenario::Scenario;
use formation::vehicle::Vehicle;
use formation::wiring::Assembly;
use lockstep::{Field, Shape};

use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::assertions::{Findings, Watch};
use crate::judge::own;
use crate::judge::verdict::Verdict;
use crate::recorded::scenario_of;
use crate::run::players::Player;
use crate::show::traffic::{Traffic, traffic};
use recording::{Log, Series};

/// A recorded run with its scenario, as far as there is one.
pub struct LoggedRun {
    /// The log.
    pub log: Log,
    /// The scenario that it holds; `None` if it holds none, or one that this program does not read.
    pub scenario: Option<Scenario>,
    /// Its metrics against what is expected; `None` if they cannot be computed.
    pub verdict: Option<Verdict>,
    /// What became of its assertions; none if they cannot be evaluated.
    pub findings: Findings,
    /// What its links did.
    pub traffic: Vec<Traffic>,
    /// Why scenario or metrics are missing, in words.
    pub caveats: Vec<String>,
    /// Numbers of the agents, ascending.
    pub agents: Vec<u32>,
    /// Whether the run is going on, so that what does not vary yet may vary later.
    pub growing: bool,
}

impl LoggedRun {
    /// Reads the log `path`. A log without a readable scenario still has its signals; [`LoggedRun::caveats`] says so.
    ///
    /// # Errors
    /// [`Failure::Log`] if it cannot be read, [`Failure::Usage`] if there is no complete step in it.
    pub fn open(catalog: &Catalog, path: &Path) -> Result<Self, Failure> {
        let log = Log::open(path)?;
        if log.steps().is_empty() {
            let path = path.display();
            return Err(Failure::Usage(format!("{path} holds no complete step; there is nothing to show")));
        }
        let mut caveats = Vec::new();
        let scenario = scenario_of(&log).map_err(|failure| caveats.push(unreadable(&failure))).ok();
        let assembly = scenario.as_ref().map(|scenario| Assembly::new(scenario.clone(), &catalog.roles));
        let own = match &assembly {
            Some(Ok(assembly)) => own::of_log(assembly, &log).unwrap_or_default(),
            _ => Vec::new(),
        };
        let verdict = scenario.as_ref().and_then(|scenario| {
            Verdict::of(&catalog.metrics, scenario, &log, own).map_err(|error| caveats.push(error.to_string())).ok()
        });
        if let Some(why) = log.unfinished() {
            caveats.push(format!("The log is {why}; it ends where its last complete block ended."));
        } else if let Some(scenario) = &scenario {
            let (found, planned) = (log.times().len() as u64, scenario.context.timing.periods() + 1);
            if found < planned {
                caveats.push(format!("The run ended early: {found} of {planned} samples."));
            }
        }
        let asked = assembly.as_ref().and_then(|assembly| assembly.as_ref().ok()).map(Assembly::links);
        let traffic = traffic(&log, &asked.unwrap_or_default());
        let findings = assembly.and_then(|assembly| {
            let found = assembly.and_then(|assembly| Watch::replay(&assembly, &log));
            found.map_err(|problems| caveats.push(unreadable(&Failure::Invalid(problems)))).ok()
        });
        caveats.extend(log.players().iter().map(|player| format!("{}.", Player::read(player).sentence())));
        let (agents, findings) = (agents_of(&log), findings.unwrap_or_default());
        Ok(Self { log, scenario, verdict, findings, traffic, caveats, agents, growing: false })
    }

    /// A run that is going on, with the samples that have been seen of it so far.
    pub fn growing(log: Log, scenario: Scenario) -> Self {
        let agents = agents_of(&log);
        let (scenario, findings) = (Some(scenario), Findings::default());
        Self { log, scenario, verdict: None, findings, traffic: Vec::new(), caveats: Vec::new(), agents, growing: true }
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.log.times().len()
    }

    /// Time of a sample, s.
    pub fn time(&self, sample: usize) -> f64 {
        self.log.times()[sample] as f64 / 1e9
    }

    /// A signal of the agent at this place in the list; `role` is the last part of the topic, `state`.
    pub fn signal(&self, place: usize, role: &str, field: &str) -> Option<Series<'_>> {
        self.log.signal(&self.topic(place, role), field)
    }

    /// Name of a topic of the agent at this place in the list.
    pub fn topic(&self, place: usize, role: &str) -> String {
        format!("/agent_{}/{role}", self.agents[place])
    }

    /// The last parts of all topics of agents, in the order of the log.
    pub fn roles(&self) -> Vec<String> {
        let mut roles: Vec<String> = Vec::new();
        for channel in self.log.channels().iter().filter(|channel| channel.layout.is_some() && channel.agent > 0) {
            let role = channel.topic.rsplit('/').next().unwrap_or_default();
            if !roles.iter().any(|known| known == role) {
                roles.push(role.into());
            }
        }
        roles
    }

    /// Fields of a role, in the order of the log; a field that only some agents have is among them.
    pub fn fields(&self, role: &str) -> Vec<Field> {
        let mut fields: Vec<Field> = Vec::new();
        for place in 0..self.agents.len() {
            let topic = self.topic(place, role);
            let channel = self.log.channels().iter().find(|channel| channel.topic == topic);
            for field in channel.and_then(|channel| channel.layout.as_ref()).into_iter().flat_map(|l| l.fields()) {
                if !fields.iter().any(|known| known.name == field.name) {
                    fields.push(field.clone());
                }
            }
        }
        fields
    }

    /// A field of a role, if any agent has it.
    pub fn field(&self, role: &str, name: &str) -> Option<Field> {
        self.fields(role).into_iter().find(|field| field.name == name)
    }

    /// Name of an agent for people.
    pub fn agent_name(&self, place: usize) -> String {
        format!("agent {}", self.agents[place])
    }

    /// The vehicle of an agent, if the log has the scenario.
    pub fn vehicle(&self, place: usize) -> Option<&Vehicle> {
        Some(&self.scenario.as_ref()?.context.agents.get(place)?.vehicle)
    }

    /// Radius of an agent's body in m; see [`Vehicle::radius`].
    pub fn radius(&self, place: usize) -> Option<f64> {
        self.vehicle(place)?.radius()
    }

    /// Whether the agents move in a plane, with a heading as their third coordinate, and not in space.
    pub fn is_planar(&self) -> bool {
        if let Some(scenario) = &self.scenario {
            return scenario.context.agents.iter().all(|agent| agent.vehicle.dimensions() <= 2);
        }
        self.field("state", "position").is_some_and(|field| match field.shape {
            Shape::Vector(3) => field.unit.ends_with("rad"),
            Shape::Vector(length) => length < 3,
            Shape::Scalar => true,
        })
    }

    /// Number of coordinates of a place: 2 in the plane, 3 in space.
    pub fn space(&self) -> usize {
        if self.is_planar() { 2 } else { 3 }
    }

    /// What the file is called, without its ending.
    pub fn stem(&self) -> String {
        self.log.path().file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

fn agents_of(log: &Log) -> Vec<u32> {
    let mut agents: Vec<u32> =
        log.channels().iter().filter(|channel| channel.layout.is_some()).map(|channel| channel.agent).collect();
    agents.retain(|agent| *agent > 0);
    agents.sort_unstable();
    agents.dedup();
    agents
}

/// What it means that the scenario of a log cannot be read.
fn unreadable(failure: &Failure) -> String {
    let reason = match failure {
        Failure::Invalid(problems) => problems
            .iter()
            .map(|problem| format!("{}: {}", problem.path, problem.message))
            .collect::<Vec<_>>()
            .join("; "),
        other => other.to_string(),
    };
    format!("Bands, radii, obstacles and links of the scenario are missing, as this version cannot read it: {reason}.")
}

/// The unit of component `component` of `field`: units are written for the whole vector (`m, m, rad`) or for equal parts of it
/// (`m, rad` for three lengths and three angles).
pub(super) fn unit_of(field: &Field, component: usize) -> String {
    let units: Vec<&str> = field.unit.split(',').map(str::trim).collect();
    units[(component * units.len() / field.shape.words().max(1)).min(units.len() - 1)].into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_units_is_spread_over_the_components() {
        let units = |unit: &str, length: usize| -> Vec<String> {
            let field = Field::vector("x", length, unit);
            (0..length).map(|component| unit_of(&field, component)).collect()
        };
        assert_eq!(units("m, m, rad", 3), ["m", "m", "rad"]);
        assert_eq!(units("m, rad", 6), ["m", "m", "m", "rad", "rad", "rad"]);
        assert_eq!(units("N", 2), ["N", "N"]);
        assert_eq!(units("", 2), ["", ""]);
    }
}
