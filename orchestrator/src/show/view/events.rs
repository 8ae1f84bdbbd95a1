//! What is on or off: flags, and the links of the communication graph.

use super::panel::{Curve, Kind, Panel, View};
use super::{Grid, LoggedRun};
use recording::Series;

/// A link of the communication graph: `to` receives what `from` publishes. Agents by their place in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The part of the topic that publishes it.
    pub from: usize,
    /// The part of the topic that receives it.
    pub to: usize,
    /// Spans of time in s during which it exists.
    pub spans: Vec<[f64; 2]>,
}

/// The links of a run: those that were logged as `adjacency` if they were, else the static ones of the scenario.
pub fn links(run: &LoggedRun) -> Vec<Link> {
    let end = run.time(run.samples() - 1);
    let mut links = Vec::new();
    for to in 0..run.agents.len() {
        for from in (0..run.agents.len()).filter(|from| *from != to) {
            let spans = match adjacency(run, to) {
                Some(row) => spans(run, row.component(from)),
                None => fixed_spans(run, to, from, end),
            };
            let spans = without_failures(run, [from, to], spans);
            if !spans.is_empty() {
                links.push(Link { from, to, spans });
            }
        }
    }
    links
}

/// The spans less the times in which nothing arrives over the link of these agents: from when the oldest message that may be expected is two
/// messages late.
fn without_failures(run: &LoggedRun, agents: [usize; 2], spans: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let [from, to] = agents;
    let link = run.traffic.iter().find(|link| {
        let is_state = link.asked.topic.ends_with("/state");
        is_state && link.asked.agents == [from + 1, to + 1]
    });
    // A link on demand has nothing to say at most times.
    let Some((link, rate)) = link.and_then(|link| Some((link, link.asked.rate?))) else { return spans };
    let Some(age) = run.log.signal(&link.asked.topic, "link_age") else { return spans };
    let most = link.asked.delay.unwrap_or(0.0) + 3.0 / rate;
    let mut working: Vec<[f64; 2]> = Vec::new();
    for sample in 0..run.samples() {
        if age.row(sample)[0] > most {
            continue;
        }
        let (time, next) = (run.time(sample), run.time((sample + 1).min(run.samples() - 1)));
        match working.last_mut() {
            Some(last) if last[1] >= time => last[1] = next,
            _ => working.push([time, next]),
        }
    }
    let both = |[start, end]: [f64; 2]| {
        working.iter().map(move |own| [own[0].max(start), own[1].min(end)]).filter(|own| own[0] < own[1])
    };
    spans.into_iter().flat_map(both).collect()
}

/// The logged weights with which an agent receives from all agents.
fn adjacency(run: &LoggedRun, place: usize) -> Option<Series<'_>> {
    let found = run.roles().into_iter().find_map(|role| run.signal(place, &role, "adjacency"))?;
    (found.width() == run.agents.len()).then_some(found)
}

/// Whether the graph of the scenario has the link at any time.
fn is_fixed(run: &LoggedRun, to: usize, from: usize) -> bool {
    !fixed_spans(run, to, from, f64::INFINITY).is_empty()
}

/// When the graph of the scenario has the link, up to `end`.
fn fixed_spans(run: &LoggedRun, to: usize, from: usize, end: f64) -> Vec<[f64; 2]> {
    let Some(context) = run.scenario.as_ref().map(|scenario| &scenario.context) else { return Vec::new() };
    if context.topology.size() <= to.max(from) {
        return Vec::new();
    }
    let start = |step: u64| step as f64 * context.timing.dt;
    let mut spans: Vec<[f64; 2]> = Vec::new();
    let intervals = context.topology.intervals();
    for (place, (first, graph)) in intervals.iter().enumerate() {
        let until = intervals.get(place + 1).map_or(end, |(next, _)| start(*next)).min(end);
        let since = start(*first);
        if graph.a(to, from) == 0.0 || since > end {
            continue;
        }
        match spans.last_mut() {
            Some(last) if last[1] == since => last[1] = until,
            _ => spans.push([since, until]),
        }
    }
    spans
}

/// When the weights are above 0.
fn spans(run: &LoggedRun, weights: impl ExactSizeIterator<Item = f64>) -> Vec<[f64; 2]> {
    let last = weights.len() - 1;
    let mut spans = Vec::new();
    let mut since = None;
    for (sample, weight) in weights.enumerate() {
        match (since, weight > 0.0) {
            (None, true) => since = Some(run.time(sample)),
            (Some(start), false) => {
                spans.push([start, run.time(sample)]);
                since = None;
            }
            _ => {}
        }
        if let (true, Some(start)) = (sample == last, since) {
            spans.push([start, run.time(sample)]);
        }
    }
    spans
}

/// Links that do not exist all the time.
pub(super) fn switching(run: &LoggedRun, grid: &Grid) -> Option<Panel> {
    /// More rows than this say nothing to anybody.
    const ROWS: usize = 60;
    let end = run.time(run.samples() - 1);
    let pairs: Vec<(usize, usize)> = if run.growing {
        // Any of them may come and go before the end.
        let count = run.agents.len();
        let all = (0..count).flat_map(|to| (0..count).map(move |from| (from, to)));
        all.filter(|&(from, to)| from != to && !is_fixed(run, to, from)).collect()
    } else {
        let found = links(run).into_iter().filter(|link| link.spans.as_slice() != [[0.0, end]]);
        found.map(|link| (link.from, link.to)).collect()
    };
    let curves: Vec<Curve> = pairs
        .into_iter()
        .take(ROWS)
        .filter_map(|(from, to)| {
            let row = adjacency(run, to)?;
            Some(Curve {
                label: format!("{} \u{2192} {}", run.agents[from], run.agents[to]),
                agent: Some(to),
                second: false,
                values: grid.curve(|sample| row.row(sample)[from]),
            })
        })
        .collect();
    if curves.is_empty() {
        return None;
    }
    let view = View { name: "links".into(), axis: "link".into(), curves, ..View::default() };
    Some(Panel { id: "links", title: "Links that come and go", kind: Kind::Bands, views: vec![view] })
}

/// Signals that say "on" or "off".
pub(super) fn flags(run: &LoggedRun, grid: &Grid) -> Option<Panel> {
    let mut views = Vec::new();
    for role in run.roles() {
        for field in run.fields(&role).iter().filter(|field| is_flag(&field.name)) {
            let signals = (0..run.agents.len())
                .filter_map(|place| Some((place, run.signal(place, &role, &field.name)?)))
                .flat_map(|(place, series)| (0..series.width()).map(move |component| (place, series, component)));
            let curves = signals.map(|(place, series, component)| Curve {
                label: match series.width() {
                    1 => run.agent_name(place),
                    _ => format!("{} [{component}]", run.agent_name(place)),
                },
                agent: Some(place),
                second: false,
                values: grid.curve(|sample| series.row(sample)[component]),
            });
            let name = format!("{role} {}", field.name.replace('_', " "));
            views.push(View { axis: "agent".into(), curves: curves.collect(), name, ..View::default() });
        }
    }
    (!views.is_empty()).then_some(Panel { id: "flags", title: "Flags", kind: Kind::Bands, views })
}

/// Whether a signal of this name is one that is on or off.
pub(super) fn is_flag(name: &str) -> bool {
    name.split('_')
        .any(|word| matches!(word, "flag" | "flags" | "active" | "saturated" | "triggered" | "feasible" | "connected"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_known_by_a_word_of_their_name() {
        assert!(is_flag("flag") && is_flag("lp_active") && is_flag("input_saturated"));
        assert!(!is_flag("activeness") && !is_flag("position"));
    }
}
