//! The communication graph: which agents receive from which, and which know the reference.

mod families;
mod schedule;
mod spectrum;

use nalgebra::SVector;

pub use families::{Family, Orientation};
pub use schedule::{NeighbourhoodSchedule, TopologySchedule};
pub use spectrum::Spectrum;

/// A directed, weighted graph with a reference link per agent.
///
/// `a(i, j) > 0` means that agent i receives from agent j. All agents are numbered from 0 here. Only the links that exist take
/// memory, so that a ring of many agents is as cheap as it looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    rows: Vec<Neighbourhood>,
}

/// A directed link: the agent `to` receives from the agent `from`, both numbered from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The sender.
    pub from: usize,
    /// The receiver.
    pub to: usize,
    /// Its weight; 0 means that there is no link.
    pub weight: f64,
}

/// A link that a graph cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct LinkError {
    /// Its place in the list of links, from 0.
    pub place: usize,
    /// What is wrong with it; agents are numbered from 1 here.
    pub message: String,
}

/// What one agent knows of the graph: the links over which it receives, and the weight of its link to the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbourhood {
    /// In-neighbours, ascending.
    neighbours: Vec<usize>,
    /// The weight of the link from each of them.
    weights: Vec<f64>,
    reference: f64,
}

impl Neighbourhood {
    /// That of an agent without neighbours that knows the reference with weight `reference`.
    pub fn alone(reference: f64) -> Self {
        Self { neighbours: Vec::new(), weights: Vec::new(), reference }
    }

    /// The neighbours with their weights, ascending; links of weight 0 are no links.
    fn new(links: impl Iterator<Item = (usize, f64)>, reference: f64) -> Self {
        let (neighbours, weights) = links.filter(|(_, weight)| *weight > 0.0).unzip();
        Self { neighbours, weights, reference }
    }

    /// The in-neighbours: those that the agent receives from, in ascending order.
    pub fn neighbours(&self) -> &[usize] {
        &self.neighbours
    }

    /// Weight of the link from agent `j`; 0 if there is none.
    pub fn weight(&self, j: usize) -> f64 {
        self.neighbours.binary_search(&j).map_or(0.0, |place| self.weights[place])
    }

    /// Weight of the reference link.
    pub fn b(&self) -> f64 {
        self.reference
    }

    /// The local error of the agent, `sum_j a_ij (own - other_j) + b_i own`: its row of `(L + B)` times the errors.
    ///
    /// `others` yields the error of each in-neighbour in the order of [`Neighbourhood::neighbours`].
    pub fn local_error<const D: usize>(
        &self,
        own: &SVector<f64, D>,
        others: impl IntoIterator<Item = SVector<f64, D>>,
    ) -> SVector<f64, D> {
        let mut sum = SVector::<f64, D>::zeros();
        for (&weight, other) in self.weights.iter().zip(others) {
            sum += weight * (own - other);
        }
        sum + self.reference * own
    }
}

impl Topology {
    /// A graph from the rows of its adjacency matrix and the weights b of the reference links.
    ///
    /// # Errors
    /// Says what is wrong if the matrix is not N x N with N = `reference.len()`, if an entry is negative or not finite, or if
    /// an agent is its own neighbour.
    pub fn new(rows: &[Vec<f64>], reference: Vec<f64>) -> Result<Self, String> {
        let size = reference.len();
        if rows.len() != size {
            return Err(format!("expected {size} rows, one per agent, found {}", rows.len()));
        }
        for (i, row) in rows.iter().enumerate() {
            if row.len() != size {
                return Err(format!("expected {size} x {size} values, found {} in row {}", row.len(), i + 1));
            }
            if let Some(j) = row.iter().position(|a| !(a.is_finite() && *a >= 0.0)) {
                return Err(format!("row {}, column {}: a weight is a number >= 0, found {}", i + 1, j + 1, row[j]));
            }
            if row[i] != 0.0 {
                return Err(format!("row {0}, column {0}: an agent is not its own neighbour, expected 0", i + 1));
            }
        }
        let row = |(row, b): (&Vec<f64>, f64)| Neighbourhood::new(row.iter().copied().enumerate(), b);
        Ok(Self { rows: rows.iter().zip(reference).map(row).collect() })
    }

    /// A graph from a list of its links and the weights b of the reference links, one per agent.
    ///
    /// # Errors
    /// [`LinkError`] for a link to an agent that does not exist or to itself, a weight that is negative or not finite, and a link that
    /// is listed twice with different weights.
    pub fn from_links(links: &[Link], reference: Vec<f64>) -> Result<Self, LinkError> {
        let size = reference.len();
        if let Some((place, message)) =
            links.iter().enumerate().find_map(|(place, link)| link.problem(size).map(|message| (place, message)))
        {
            return Err(LinkError { place, message });
        }
        let mut order: Vec<usize> = (0..links.len()).collect();
        order.sort_by_key(|&place| (links[place].to, links[place].from, place));
        let mut rows: Vec<Neighbourhood> = reference.into_iter().map(Neighbourhood::alone).collect();
        for place in order {
            let Link { from, to, weight } = links[place];
            let row = &mut rows[to];
            if row.neighbours.last() == Some(&from) {
                let earlier = row.weights[row.weights.len() - 1];
                if earlier != weight {
                    let (from, to) = (from + 1, to + 1);
                    let message =
                        format!("the link from {from} to {to} is given twice, with the weights {earlier} and {weight}");
                    return Err(LinkError { place, message });
                }
            } else if weight > 0.0 {
                row.neighbours.push(from);
                row.weights.push(weight);
            }
        }
        Ok(Self { rows })
    }

    /// The graph that has every link that one of these graphs has, with the largest of its weights; the same for the links to the
    /// reference.
    pub fn union<'a>(graphs: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut rows: Vec<Neighbourhood> = Vec::new();
        for graph in graphs {
            rows.resize_with(rows.len().max(graph.size()), || Neighbourhood::alone(0.0));
            for (row, other) in rows.iter_mut().zip(&graph.rows) {
                let mut all: Vec<usize> = row.neighbours.iter().chain(&other.neighbours).copied().collect();
                all.sort_unstable();
                all.dedup();
                let weight = |j: usize| row.weight(j).max(other.weight(j));
                *row = Neighbourhood::new(all.into_iter().map(|j| (j, weight(j))), row.reference.max(other.reference));
            }
        }
        Self { rows }
    }

    /// The same links with other weights b of the reference links.
    ///
    /// # Errors
    /// If there are not as many weights as agents.
    pub fn with_reference(mut self, reference: &[f64]) -> Result<Self, String> {
        if reference.len() != self.size() {
            return Err(format!("expected {} weights, one per agent, found {}", self.size(), reference.len()));
        }
        self.rows.iter_mut().zip(reference).for_each(|(row, &b)| row.reference = b);
        Ok(self)
    }

    /// All links, by receiver and then by sender.
    pub fn links(&self) -> impl Iterator<Item = Link> {
        self.rows.iter().enumerate().flat_map(|(to, row)| {
            row.neighbours.iter().zip(&row.weights).map(move |(&from, &weight)| Link { from, to, weight })
        })
    }

    /// Whether every link has one of the same weight in the other direction.
    pub fn is_symmetric(&self) -> bool {
        self.links().all(|Link { from, to, weight }| self.a(from, to) == weight)
    }

    /// The directed ring 1 -> 2 -> ... -> N -> 1 with unit weights; `reference` are the weights of the reference links.
    pub fn ring(reference: Vec<f64>) -> Self {
        let size = reference.len();
        let before = |i: usize| (size > 1).then(|| ((i + size - 1) % size, 1.0)).into_iter();
        Self { rows: reference.into_iter().enumerate().map(|(i, b)| Neighbourhood::new(before(i), b)).collect() }
    }

    /// The ring 1 - 2 - ... - N - 1 with unit weights and links both ways.
    pub fn two_way_ring(reference: Vec<f64>) -> Self {
        let size = reference.len();
        let beside = |i: usize| {
            let mut both = if size > 1 { vec![(i + 1) % size, (i + size - 1) % size] } else { Vec::new() };
            both.sort_unstable();
            both.dedup();
            both.into_iter().map(|j| (j, 1.0))
        };
        Self { rows: reference.into_iter().enumerate().map(|(i, b)| Neighbourhood::new(beside(i), b)).collect() }
    }

    /// Number of agents.
    pub fn size(&self) -> usize {
        self.rows.len()
    }

    /// What agent `i` knows of the graph.
    pub fn neighbourhood(&self, i: usize) -> &Neighbourhood {
        &self.rows[i]
    }

    /// Weight of the link over which `i` receives from `j`; 0 if there is none.
    pub fn a(&self, i: usize, j: usize) -> f64 {
        self.rows[i].weight(j)
    }

    /// Weight of the reference link of agent `i`.
    pub fn b(&self, i: usize) -> f64 {
        self.rows[i].reference
    }

    /// The in-neighbours of `i`: those it receives from, in ascending order.
    pub fn neighbours(&self, i: usize) -> &[usize] {
        self.rows[i].neighbours()
    }

    /// The local error of agent i; see [`Neighbourhood::local_error`].
    pub fn local_error<const D: usize>(
        &self,
        i: usize,
        own: &SVector<f64, D>,
        others: impl IntoIterator<Item = SVector<f64, D>>,
    ) -> SVector<f64, D> {
        self.rows[i].local_error(own, others)
    }

    /// Row i of the matrix A, with a 0 where there is no link.
    pub fn dense_row(&self, i: usize) -> Vec<f64> {
        let mut row = vec![0.0; self.size()];
        self.rows[i].neighbours.iter().zip(&self.rows[i].weights).for_each(|(&j, &weight)| row[j] = weight);
        row
    }

    /// The first agent (from 0) that neither knows the reference nor hears, over any number of links, of one that does.
    ///
    /// `L + B` is invertible if there is none.
    pub fn unled_agent(&self) -> Option<usize> {
        let leaders = (0..self.size()).filter(|&i| self.b(i) > 0.0);
        reached(&self.receivers(), leaders).iter().position(|led| !led)
    }

    /// Whether every agent reaches every other along the links. If not, the first pair (from, to) without a path, from 0.
    pub fn unreachable_pair(&self) -> Option<(usize, usize)> {
        if self.rows.is_empty() {
            return None;
        }
        let receivers = self.receivers();
        let missed_by = |from: usize| reached(&receivers, [from]).iter().position(|reached| !reached);
        if let Some(missed) = missed_by(0) {
            return Some((0, missed));
        }
        // Agent 0 reaches all: exactly those that do not reach it miss some.
        let senders: Vec<&[usize]> = self.rows.iter().map(Neighbourhood::neighbours).collect();
        let from = reached(&senders, [0]).iter().position(|reaches| !reaches)?;
        missed_by(from).map(|missed| (from, missed))
    }

    /// By agent, those that receive from it: the links the other way round.
    fn receivers(&self) -> Vec<Vec<usize>> {
        let mut receivers = vec![Vec::new(); self.size()];
        for (i, row) in self.rows.iter().enumerate() {
            row.neighbours.iter().for_each(|&j| receivers[j].push(i));
        }
        receivers
    }
}

impl Link {
    /// What is wrong with it in a graph of `size` agents, which are numbered from 1 here.
    fn problem(&self, size: usize) -> Option<String> {
        let Self { from, to, weight } = *self;
        if let Some(agent) = [from, to].into_iter().find(|&agent| agent >= size) {
            return Some(format!("expected agents from 1 to {size}, found {}", agent.wrapping_add(1)));
        }
        if from == to {
            return Some(format!("an agent is not its own neighbour, found a link from {0} to {0}", from + 1));
        }
        (!(weight.is_finite() && weight >= 0.0)).then(|| format!("a weight is a number >= 0, found {weight}"))
    }
}

/// Whether each agent is among `start` or can be reached from there over `next`, which lists by agent where a link leads.
fn reached(next: &[impl AsRef<[usize]>], start: impl IntoIterator<Item = usize>) -> Vec<bool> {
    let mut reached = vec![false; next.len()];
    let mut waiting: Vec<usize> = start.into_iter().collect();
    while let Some(at) = waiting.pop() {
        if !std::mem::replace(&mut reached[at], true) {
            waiting.extend(next[at].as_ref().iter().filter(|&&to| !reached[to]));
        }
    }
    reached
}

#[cfg(test)]
mod tests;
