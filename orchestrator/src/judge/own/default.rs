//! The metrics of a scenario that names none.

use formation::wiring::{Assembly, Role};

use super::OwnMetric;
use super::formula::compile;
use crate::judge::assertions::Geometry;
use crate::judge::metrics::Definition;

/// Up to so many agents, each has its own rows.
const MOST_LISTED: usize = 12;
/// Distances between all pairs of more agents than these take too long.
const MOST_PAIRED: usize = 100;

/// The default set, as far as the scenario has the signals that a metric reads.
pub(super) fn default_set(assembly: &Assembly, geometry: &Geometry) -> Vec<OwnMetric> {
    let count = assembly.scenario.context.agents.len();
    let all: Vec<usize> = (0..count).collect();
    let mut set = Set { assembly, geometry, metrics: Vec::new() };
    set.add("tracking_end", "final(tracking)", "m", "Tracking error at the end; worst agent.", &all);
    set.add("tracking_rms", "rms(tracking)", "m", "Root of the mean square of the tracking error; worst agent.", &all);
    if (2..=MOST_LISTED).contains(&count) {
        for agent in 0..count {
            let id = |name: &str| format!("{name}_{}", agent + 1);
            set.add(&id("tracking_end"), "final(tracking)", "m", "Tracking error of one agent at the end.", &[agent]);
            set.add(&id("tracking_rms"), "rms(tracking)", "m", "As `tracking_rms`, of one agent.", &[agent]);
        }
    }
    let settled = "Time from which on the tracking error stays within 5 % of its initial value; last agent.";
    set.add("settling", "settle(tracking, within = 0.05)", "s", settled, &all);
    if (2..=MOST_PAIRED).contains(&count) {
        let shape = "Position relative to another agent against what the references say; worst pair at the end.";
        set.add("formation_end", "final(formation)", "m", shape, &all);
        let shape = "The same, root of the mean square over the run; worst agent.";
        set.add("formation_rms", "rms(formation)", "m", shape, &all);
        let gap = "Smallest distance between two agents less their radii; below 0 they collided.";
        set.add("gap_min", "min(gap, across = min)", "m", gap, &all);
    }
    let effort = "Integral of the squared norm of the input; sum of the agents.";
    set.add("effort", "integral(norm(command.input)^2, across = sum)", "", effort, &all);
    set.variation(&all);
    set.saturation(&all);
    set.connectivity();
    set.metrics
}

struct Set<'a> {
    assembly: &'a Assembly,
    geometry: &'a Geometry,
    metrics: Vec<OwnMetric>,
}

impl Set<'_> {
    /// Adds a metric, unless the scenario lacks one of its signals.
    fn add(&mut self, id: &str, text: &str, unit: &str, meaning: &str, agents: &[usize]) {
        if let Ok((value, reductions)) = compile(text, self.assembly, self.geometry, agents) {
            let definition = Definition::own(id, text, unit, meaning.into());
            self.metrics.push(OwnMetric { id: id.into(), definition, value, reductions });
        }
    }

    /// The share of the time at which an input is at a limit, where all agents have the same limits.
    fn saturation(&mut self, all: &[usize]) {
        let agents = &self.assembly.scenario.context.agents;
        let limits = agents.first().and_then(|agent| agent.vehicle.model()).map(|model| &model.limits);
        let have_these = |limits: &Vec<(f64, f64)>| {
            agents.iter().all(|agent| agent.vehicle.model().is_some_and(|model| model.limits == *limits))
        };
        let text = match limits {
            None => "share(peak(command.input) >= UM*(1 - 1e-9))".to_string(),
            Some(limits) if have_these(limits) => {
                let name = |place: usize| match limits.len() {
                    1 => "command.input".to_string(),
                    _ => format!("command.input[{place}]"),
                };
                let at = |(place, (low, high)): (usize, &(f64, f64))| {
                    let low = low.is_finite().then(|| format!("{} <= {:?}", name(place), low + 1e-9 * low.abs()));
                    let high = high.is_finite().then(|| format!("{} >= {:?}", name(place), high - 1e-9 * high.abs()));
                    low.into_iter().chain(high)
                };
                let conditions = limits.iter().enumerate().flat_map(at).collect::<Vec<_>>().join(" or ");
                format!("share({conditions})")
            }
            Some(_) => return,
        };
        let meaning = "Share of the time at which an input is at its limit; worst agent.";
        self.add("saturation", &text, "", meaning, all);
    }

    /// The total variation of the inputs, where all agents have as many.
    fn variation(&mut self, agents: &[usize]) {
        let channels = &self.assembly.network.channels;
        let role = Role::Controller.channel();
        let width = |&agent: &usize| {
            let topic = format!("/agent_{}/{role}", agent + 1);
            let channel = channels.iter().find(|channel| channel.topic == topic)?;
            channel.layout.find("input").map(|(_, length)| length)
        };
        let widths: Option<Vec<usize>> = agents.iter().map(width).collect();
        let Some(widths) = widths.filter(|widths| widths.windows(2).all(|pair| pair[0] == pair[1])) else { return };
        let length = widths.first().copied().unwrap_or(0);
        let component = |index: usize| match length {
            1 => "variation(command.input, across = sum)".to_string(),
            _ => format!("variation(command.input[{index}], across = sum)"),
        };
        let text = (0..length).map(component).collect::<Vec<_>>().join(" + ");
        let meaning = "Total variation of the inputs: sum of the absolute changes from step to step, over all components and agents.";
        self.add("variation", &text, "", meaning, agents);
    }

    /// The least algebraic connectivity of the graphs of the run, if there are links.
    fn connectivity(&mut self) {
        let schedule = &self.assembly.scenario.context.topology;
        let has_links = schedule.intervals().iter().any(|(_, graph)| graph.links().next().is_some());
        if schedule.size() < 2 || schedule.size() > MOST_PAIRED || !has_links {
            return;
        }
        let values: Option<Vec<f64>> =
            schedule.intervals().iter().map(|(_, graph)| Some(graph.spectrum()?.algebraic_connectivity)).collect();
        let Some(values) = values else { return };
        let least = values.into_iter().fold(f64::INFINITY, f64::min);
        let Ok(value) = formation::formula::Expression::parse(&format!("{least:?}")).and_then(|e| e.compile(|_| None))
        else {
            return;
        };
        let meaning = "Algebraic connectivity of the static graph; the least if it switches.";
        let definition = Definition::own("lambda_2", "λ2(L)", "", meaning.into());
        self.metrics.push(OwnMetric { id: "lambda_2".into(), definition, value, reductions: Vec::new() });
    }
}
