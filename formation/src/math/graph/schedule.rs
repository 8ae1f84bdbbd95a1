//! Graphs that switch at some steps.

use nalgebra::SVector;

use super::{Neighbourhood, Topology};

/// A graph over time: the same from one switch to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct TopologySchedule {
    /// First step and graph of every interval, in order; the first starts at step 0.
    intervals: Vec<(u64, Topology)>,
}

impl TopologySchedule {
    /// The graph `first` from step 0 on, and every other one from its step on, in ascending order.
    pub fn new(first: Topology, switches: impl IntoIterator<Item = (u64, Topology)>) -> Self {
        Self { intervals: std::iter::once((0, first)).chain(switches).collect() }
    }

    /// Number of agents.
    pub fn size(&self) -> usize {
        self.first().size()
    }

    /// The graph of step 0.
    pub fn first(&self) -> &Topology {
        &self.intervals[0].1
    }

    /// The graph of a step.
    pub fn at(&self, step: u64) -> &Topology {
        &self.intervals[self.interval(step)].1
    }

    /// First step and graph of every interval, in order.
    pub fn intervals(&self) -> &[(u64, Topology)] {
        &self.intervals
    }

    /// Whether there is more than one graph.
    pub fn is_switching(&self) -> bool {
        self.intervals.len() > 1
    }

    /// The graph that has every link that exists at any time.
    pub fn union(&self) -> Topology {
        Topology::union(self.intervals.iter().map(|(_, graph)| graph))
    }

    /// What agent `i` knows of the graph over time.
    pub fn neighbourhood(&self, i: usize) -> NeighbourhoodSchedule {
        let rows = self.intervals.iter().map(|(start, graph)| (*start, graph.neighbourhood(i).clone()));
        NeighbourhoodSchedule::new(rows.collect())
    }

    fn interval(&self, step: u64) -> usize {
        interval(&self.intervals, step)
    }
}

impl From<Topology> for TopologySchedule {
    fn from(graph: Topology) -> Self {
        Self::new(graph, [])
    }
}

/// The last of the intervals that starts at this step or before; the first starts at step 0.
fn interval<T>(intervals: &[(u64, T)], step: u64) -> usize {
    intervals.partition_point(|(start, _)| *start <= step).saturating_sub(1)
}

/// What one agent knows of a graph over time.
#[derive(Clone, Debug, PartialEq)]
pub struct NeighbourhoodSchedule {
    /// The agents that it receives from at any time, ascending.
    heard: Vec<usize>,
    /// First step of every interval, with the neighbours then.
    intervals: Vec<(u64, Row)>,
}

/// The neighbours during an interval.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    neighbourhood: Neighbourhood,
    /// The place of each neighbour in the list of all that are heard.
    places: Vec<usize>,
}

impl NeighbourhoodSchedule {
    fn new(rows: Vec<(u64, Neighbourhood)>) -> Self {
        let mut heard: Vec<usize> = rows.iter().flat_map(|(_, row)| row.neighbours()).copied().collect();
        heard.sort_unstable();
        heard.dedup();
        // Every neighbour is among those that are heard.
        let place = |j: &usize| heard.binary_search(j).unwrap_or(0);
        let row = |neighbourhood: Neighbourhood| Row {
            places: neighbourhood.neighbours().iter().map(place).collect(),
            neighbourhood,
        };
        Self { intervals: rows.into_iter().map(|(start, neighbourhood)| (start, row(neighbourhood))).collect(), heard }
    }

    /// That of an agent without neighbours that knows the reference with weight `reference`.
    pub fn alone(reference: f64) -> Self {
        Self::new(vec![(0, Neighbourhood::alone(reference))])
    }

    /// The agents that it receives from at any time, ascending.
    pub fn heard(&self) -> &[usize] {
        &self.heard
    }

    /// The neighbours at a step.
    pub fn at(&self, step: u64) -> &Neighbourhood {
        &self.row(step).neighbourhood
    }

    /// The local error of the agent at a step; see [`Neighbourhood::local_error`]. `other` gives the error of the agent at this place of
    /// [`NeighbourhoodSchedule::heard`].
    pub fn local_error<const D: usize>(
        &self,
        step: u64,
        own: &SVector<f64, D>,
        other: impl Fn(usize) -> SVector<f64, D>,
    ) -> SVector<f64, D> {
        let row = self.row(step);
        row.neighbourhood.local_error(own, row.places.iter().map(|&place| other(place)))
    }

    fn row(&self, step: u64) -> &Row {
        &self.intervals[interval(&self.intervals, step)].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Link;

    #[test]
    fn a_schedule_switches_at_its_steps() {
        let graph = |from: usize, weight: f64| {
            let link = Link { from, to: 0, weight };
            Topology::from_links(&[link], vec![0.5; 3]).unwrap()
        };
        let schedule = TopologySchedule::new(graph(2, 1.0), [(10, graph(1, 3.0)), (20, graph(2, 2.0))]);
        let weights = |step: u64| [schedule.at(step).a(0, 1), schedule.at(step).a(0, 2)];
        assert_eq!(
            [weights(0), weights(9), weights(10), weights(19), weights(20)].concat(),
            [0.0, 1.0, 0.0, 1.0, 3.0, 0.0, 3.0, 0.0, 0.0, 2.0]
        );
        assert_eq!((schedule.union().a(0, 1), schedule.union().a(0, 2), schedule.is_switching()), (3.0, 2.0, true));
        let own = schedule.neighbourhood(0);
        assert_eq!(own.heard(), [1, 2]);
        let errors = [10.0, 20.0];
        let local = |step| {
            own.local_error(step, &SVector::<f64, 1>::new(1.0), |place| SVector::<f64, 1>::new(errors[place]))[0]
        };
        assert_eq!([local(0), local(10), local(20)], [1.0 - 20.0 + 0.5, 3.0 - 30.0 + 0.5, 2.0 - 40.0 + 0.5]);
        assert!(!TopologySchedule::from(graph(1, 1.0)).is_switching());
    }
}
