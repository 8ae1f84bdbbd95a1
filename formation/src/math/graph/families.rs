//! Graphs by name: rings, lines, stars, grids, complete and random graphs.

use super::Link;
use crate::math::SplitMix64;

/// Whether links go one way or both ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// One way.
    Directed,
    /// Both ways, with one weight.
    Undirected,
}

/// A graph that a name and a few numbers describe, for any number of agents. Agents are numbered from 0 here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// 1 -> 2 -> ... -> N -> 1.
    Ring(Orientation),
    /// 1 -> 2 -> ... -> N.
    Line(Orientation),
    /// A centre and a link from it to every other agent.
    Star {
        /// The centre.
        centre: usize,
        /// Whether the others answer.
        orientation: Orientation,
    },
    /// Every agent with every other, both ways.
    Complete,
    /// Rows and columns, numbered row by row, with links between those beside and below each other, both ways.
    Grid {
        /// Rows and columns; `None`: the divisors of N that are closest to each other, not more rows than columns.
        shape: Option<[usize; 2]>,
    },
    /// Every link exists with the same probability, independently of the others: the graph G(N, p) of Gilbert (1959), which is called
    /// after Erdős and Rényi, too.
    Random {
        /// The probability, 0 to 1.
        probability: f64,
        /// Seed of the numbers that decide.
        seed: u64,
        /// Whether graphs are drawn until one is connected (strongly, if it is directed).
        connected: bool,
        /// Directed: each of the two directions is drawn by itself.
        orientation: Orientation,
    },
}

/// A connected graph is given up after so many draws ...
const MOST_DRAWS: usize = 1000;
/// ... or after so many pairs were drawn.
const MOST_PAIRS: usize = 300_000_000;
/// A complete graph may have so many links.
const MOST_LINKS: usize = 20_000_000;

impl Family {
    /// The links among `size` agents, each with this weight.
    ///
    /// # Errors
    /// If there is no such graph of this size.
    pub fn links(&self, size: usize, weight: f64) -> Result<Vec<Link>, String> {
        let pairs: Vec<(usize, usize)> = match *self {
            Self::Ring(_) if size < 2 => Vec::new(),
            // The ring of two is a line whose ends are neighbours already.
            Self::Ring(Orientation::Undirected) if size == 2 => vec![(0, 1)],
            Self::Ring(_) => (0..size).map(|i| (i, (i + 1) % size)).collect(),
            Self::Line(_) => (1..size).map(|i| (i - 1, i)).collect(),
            Self::Star { centre, .. } if centre >= size => {
                return Err(format!("expected a centre from 1 to {size}, found {}", centre.wrapping_add(1)));
            }
            Self::Star { centre, .. } => (0..size).filter(|&i| i != centre).map(|i| (centre, i)).collect(),
            Self::Complete if size.saturating_mul(size) > MOST_LINKS => {
                return Err(format!("a complete graph of {size} agents has {} links", size * (size - 1)));
            }
            Self::Complete => (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j))).collect(),
            Self::Grid { shape } => grid(size, shape)?,
            Self::Random { probability, seed, connected, orientation } => {
                random(size, probability, seed, connected, orientation)?
            }
        };
        let both = self.orientation() == Orientation::Undirected;
        let links = pairs.into_iter().flat_map(|(from, to)| {
            let back = both.then_some(Link { from: to, to: from, weight });
            std::iter::once(Link { from, to, weight }).chain(back)
        });
        Ok(links.collect())
    }

    fn orientation(&self) -> Orientation {
        match *self {
            Self::Ring(orientation)
            | Self::Line(orientation)
            | Self::Star { orientation, .. }
            | Self::Random { orientation, .. } => orientation,
            Self::Complete | Self::Grid { .. } => Orientation::Undirected,
        }
    }
}

/// The pairs of neighbours of a grid.
fn grid(size: usize, shape: Option<[usize; 2]>) -> Result<Vec<(usize, usize)>, String> {
    let [rows, columns] = shape.unwrap_or_else(|| {
        let rows = (1..=size).take_while(|rows| rows * rows <= size).filter(|rows| size.is_multiple_of(*rows)).last();
        rows.map_or([0, 0], |rows| [rows, size / rows])
    });
    if rows.checked_mul(columns) != Some(size) {
        let found = format!("found {rows} rows of {columns}");
        return Err(format!("expected rows and columns whose product is {size}, the number of agents, {found}"));
    }
    let beside = move |i: usize| (!(i + 1).is_multiple_of(columns)).then_some((i, i + 1));
    let below = move |i: usize| (i + columns < size).then_some((i, i + columns));
    Ok((0..size).flat_map(|i| beside(i).into_iter().chain(below(i))).collect())
}

/// The pairs of a random graph: (i, j) with i < j, and also with i > j if each direction is drawn.
fn random(
    size: usize,
    probability: f64,
    seed: u64,
    connected: bool,
    orientation: Orientation,
) -> Result<Vec<(usize, usize)>, String> {
    if !(0.0..=1.0).contains(&probability) {
        return Err(format!("expected a probability from 0 to 1, found {probability}"));
    }
    let directed = orientation == Orientation::Directed;
    let mut stream = SplitMix64::new(seed);
    let mut draw = || {
        let mut pairs = Vec::new();
        for i in 0..size {
            for j in if directed { 0 } else { i + 1 }..size {
                if i != j && 0.5 * (stream.symmetric() + 1.0) < probability {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    };
    let draws = MOST_DRAWS.min(MOST_PAIRS / (size * size).max(1)).max(1);
    for _ in 0..if connected { draws } else { 1 } {
        let pairs = draw();
        if !connected || is_connected(size, &pairs, directed) {
            return Ok(pairs);
        }
    }
    Err(format!(
        "none of {draws} random graphs of {size} agents with the probability {probability} is connected; most are if it is clearly above \
         ln(N)/N = {:.2}",
        libm::log(size as f64) / size as f64
    ))
}

/// Whether every agent reaches every other.
fn is_connected(size: usize, pairs: &[(usize, usize)], directed: bool) -> bool {
    let lists = |reverse: bool| {
        let mut next = vec![Vec::new(); size];
        for &(from, to) in pairs {
            let (from, to) = if reverse { (to, from) } else { (from, to) };
            next[from].push(to);
            if !directed {
                next[to].push(from);
            }
        }
        next
    };
    let reaches_all = |reverse| size == 0 || super::reached(&lists(reverse), [0]).iter().all(|reached| *reached);
    reaches_all(false) && (!directed || reaches_all(true))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Topology;
    use Orientation::{Directed, Undirected};
    use proptest::prelude::*;

    fn graph(family: Family, size: usize) -> Topology {
        Topology::from_links(&family.links(size, 1.0).unwrap(), vec![1.0; size]).unwrap()
    }

    fn count(family: Family, size: usize) -> usize {
        graph(family, size).links().count()
    }

    fn gnp(probability: f64, seed: u64, connected: bool) -> Family {
        Family::Random { probability, seed, connected, orientation: Undirected }
    }

    #[test]
    fn rings_are_those_of_the_topology() {
        for size in 1..6 {
            assert_eq!(graph(Family::Ring(Directed), size), Topology::ring(vec![1.0; size]));
            assert_eq!(graph(Family::Ring(Undirected), size), Topology::two_way_ring(vec![1.0; size]));
        }
    }

    #[test]
    fn every_family_has_its_number_of_links() {
        assert_eq!([count(Family::Line(Directed), 5), count(Family::Line(Undirected), 5)], [4, 8]);
        let star = |orientation| count(Family::Star { centre: 2, orientation }, 5);
        assert_eq!([star(Directed), star(Undirected), count(Family::Complete, 5)], [4, 8, 20]);
        // 2 x 3: two rows of two links and three columns of one.
        assert_eq!(count(Family::Grid { shape: None }, 6), 14);
        assert_eq!(graph(Family::Grid { shape: None }, 6), graph(Family::Grid { shape: Some([2, 3]) }, 6));
        assert_eq!(graph(Family::Grid { shape: None }, 7), graph(Family::Line(Undirected), 7));
        assert_eq!(graph(Family::Star { centre: 0, orientation: Directed }, 4).neighbours(3), [0]);
    }

    #[test]
    fn what_does_not_fit_the_number_of_agents_is_refused() {
        let refuse = |family: Family| family.links(6, 1.0).unwrap_err();
        let expected = "expected rows and columns whose product is 6, the number of agents, found 2 rows of 4";
        assert_eq!(refuse(Family::Grid { shape: Some([2, 4]) }), expected);
        let star = Family::Star { centre: 6, orientation: Directed };
        assert_eq!(refuse(star), "expected a centre from 1 to 6, found 7");
        assert_eq!(refuse(gnp(1.5, 0, false)), "expected a probability from 0 to 1, found 1.5");
        assert!(refuse(gnp(0.01, 0, true)).ends_with("clearly above ln(N)/N = 0.30"));
        assert!(Family::Complete.links(10_000, 1.0).unwrap_err().contains("has 99990000 links"));
    }

    #[test]
    fn random_graphs_are_the_same_everywhere() {
        let links: Vec<(usize, usize)> =
            gnp(0.5, 1, false).links(4, 1.0).unwrap().iter().map(|l| (l.from, l.to)).collect();
        assert_eq!(links, gnp(0.5, 1, false).links(4, 1.0).unwrap().iter().map(|l| (l.from, l.to)).collect::<Vec<_>>());
        // Of 4950 pairs, 1485 are expected; five standard deviations are 161.
        let edges = count(gnp(0.3, 7, false), 100) / 2;
        assert!((1324..1646).contains(&edges), "{edges}");
        assert_eq!([count(gnp(0.0, 1, false), 9), count(gnp(1.0, 1, false), 9)], [0, 72]);
    }

    proptest! {
        #[test]
        fn connected_means_connected(seed in 0..u64::MAX, directed in proptest::bool::ANY) {
            let orientation = if directed { Directed } else { Undirected };
            let family = Family::Random { probability: 0.3, seed, connected: true, orientation };
            let found = graph(family, 8);
            prop_assert_eq!(found.unreachable_pair(), None);
            prop_assert!(directed || found.is_symmetric());
        }
    }
}
