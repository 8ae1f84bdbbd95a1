//! What every process of a run must know, and how it is written down.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{ChannelId, LoopError, MAX_WORDS, Network, Period};

/// Name of the plan's file within the run directory.
pub const PLAN_FILE: &str = "plan.json";

/// How a plan is written down; another number is another way.
const FORMAT: u32 = 5;

/// Most processes that can meet in one phase.
pub const MAX_MEMBERS: usize = 4096;

/// What the processes of a run wake each other with. It changes no bit of what comes out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wake {
    /// Futexes on words of the shared page, as Linux has them.
    #[default]
    Futex,
    /// Events of iceoryx2, for systems without futexes that processes can share. They take longer, and since one is lost now
    /// and then, sleeping processes read the page every few milliseconds.
    Events,
}

/// A process of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerPlan {
    /// Its name in reports.
    pub name: String,
    /// The nodes that it hosts, by number.
    pub nodes: Vec<usize>,
}

/// Everything that a process of a run must know; written as `plan.json` into the run directory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    format: u32,
    /// Name of the run; its directory's name.
    pub run: String,
    /// Nodes and channels.
    pub network: Network,
    /// Phase of every node.
    pub phases: Vec<usize>,
    /// Length of a step.
    pub period: Period,
    /// Length of a step in seconds.
    pub dt: f64,
    /// Number of steps: 0 to `steps - 1` are executed.
    pub steps: u64,
    /// The processes.
    pub workers: Vec<WorkerPlan>,
    /// How many of its last runs every worker keeps for a trace; 0 at first, and without influence on any result.
    pub traced: u32,
    /// What the processes wake each other with; said by the conductor, and without influence on any result.
    pub wake: Wake,
    /// SHA-256 of the text that the participants are built from; empty if there is none.
    source: String,
    digest: String,
}

/// A plan that cannot be carried out.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// No node could run first.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// Two nodes or two workers with one name.
    #[error("the name {0} is used twice")]
    Name(String),
    /// A name that a service cannot have.
    #[error("\"{0}\" cannot be a name: use 1 to 64 of a-z, A-Z, 0-9, _, - and the comma")]
    BadName(String),
    /// A node without a process, or with two.
    #[error("node {node} is hosted by {hosts} workers; it takes exactly one")]
    Hosts {
        /// Its name.
        node: String,
        /// How many workers claim it.
        hosts: usize,
    },
    /// An index beyond what there is.
    #[error("{0}")]
    Index(String),
    /// A channel that two nodes write.
    #[error("channel {0} has two writers")]
    Writers(String),
    /// A sample that does not fit into any cell.
    #[error("a sample of channel {topic} has {words} numbers; at most {MAX_WORDS} fit: split the channel")]
    Large {
        /// Name of the channel.
        topic: String,
        /// Its size in words.
        words: usize,
    },
    /// An initial sample that is not one of its channel.
    #[error("the initial sample of channel {topic} has {found} numbers or one that is not finite; it takes {words}")]
    Initial {
        /// Name of the channel.
        topic: String,
        /// How many numbers there are.
        found: usize,
        /// How many there must be.
        words: usize,
    },
    /// A step of no length, no nodes, or too many processes in a phase.
    #[error("{0}")]
    Size(String),
    /// The file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text that participants are built from is not that of the run.
    #[error(
        "its text is not the one that the run was started with (sha256 {found:.16}, not {expected:.16}): somebody has changed \
         it; start the run anew"
    )]
    Source {
        /// The digest that the plan tells.
        expected: String,
        /// That of the text.
        found: String,
    },
    /// The file is not a plan, or that of another version.
    #[error("{path} is no plan of this version: {reason}")]
    Format {
        /// Which.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
}

impl Plan {
    /// A plan of `steps` steps of `period` each, which may be a number of nanoseconds, the nodes spread over `workers`.
    ///
    /// # Errors
    /// [`PlanError`] if the network cannot be run like this.
    pub fn new(
        run: &str,
        network: Network,
        period: impl Into<Period>,
        steps: u64,
        workers: Vec<WorkerPlan>,
    ) -> Result<Self, PlanError> {
        check_network(&network)?;
        let phases = network.phases()?;
        check_workers(&network, &workers)?;
        let period = period.into();
        if period.rounded_ns() == 0 {
            return Err(PlanError::Size("a step must take at least 1 ns".into()));
        }
        // The double nearest to the number that people write.
        let dt = period.seconds();
        let (format, traced, wake) = (FORMAT, 0, Wake::default());
        let (run, source, digest) = (run.into(), String::new(), String::new());
        let mut plan = Self { format, run, network, phases, period, dt, steps, workers, traced, wake, source, digest };
        plan.digest = plan.compute_digest();
        match (0..plan.phase_count()).find(|&phase| plan.members(phase).len() > MAX_MEMBERS) {
            Some(phase) => {
                Err(PlanError::Size(format!("more than {MAX_MEMBERS} processes in phase {phase}; group some of them")))
            }
            None => Ok(plan),
        }
    }

    /// SHA-256 of what is computed: network, step and number of steps, but neither the name of the run nor the grouping.
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// Binds the plan to the text that the participants are built from.
    pub fn bind_source(&mut self, text: &str) {
        self.source = sha256(text.as_bytes());
    }

    /// Whether this is the text that the participants are to be built from.
    ///
    /// # Errors
    /// [`PlanError::Source`] if the plan is bound to another one.
    pub fn check_source(&self, text: &str) -> Result<(), PlanError> {
        let found = sha256(text.as_bytes());
        match self.source == found || self.source.is_empty() {
            true => Ok(()),
            false => Err(PlanError::Source { expected: self.source.clone(), found }),
        }
    }

    /// Tells plans apart whose processes must not meet: what is computed, from what, and by whom.
    pub fn fingerprint(&self) -> u64 {
        let content = (&self.run, &self.digest, &self.source, &self.workers);
        // Strings and integers: encoding cannot fail.
        let digest = Sha256::digest(serde_json::to_vec(&content).unwrap_or_default());
        digest.iter().take(8).fold(0, |number, &byte| number << 8 | u64::from(byte))
    }

    /// Number of phases of a step.
    pub fn phase_count(&self) -> usize {
        self.phases.iter().max().map_or(0, |last| last + 1)
    }

    /// The workers that have a node in `phase`, in ascending order.
    pub fn members(&self, phase: usize) -> Vec<usize> {
        let takes_part = |worker: &usize| self.workers[*worker].nodes.iter().any(|&node| self.phases[node] == phase);
        (0..self.workers.len()).filter(takes_part).collect()
    }

    /// The worker that hosts `node`.
    pub fn host(&self, node: usize) -> usize {
        // `check_workers` has seen to it that there is one.
        self.workers.iter().position(|worker| worker.nodes.contains(&node)).unwrap_or(0)
    }

    /// The phases in which a worker takes part, in order, with its position among the workers of each.
    pub fn places(&self, worker: usize) -> Vec<(usize, usize)> {
        let position = |phase| self.members(phase).iter().position(|&member| member == worker);
        (0..self.phase_count()).filter_map(|phase| Some((phase, position(phase)?))).collect()
    }

    /// What a worker reads from other processes, and what it writes, in ascending order: what its successor must be told
    /// about the steps that are done.
    pub fn traffic(&self, worker: usize) -> BTreeSet<ChannelId> {
        let writers = self.network.writers();
        let hosted = &self.workers[worker].nodes;
        let inputs = hosted.iter().flat_map(|&node| self.network.nodes[node].inputs.iter().map(|input| input.channel));
        let outputs = hosted.iter().flat_map(|&node| self.network.nodes[node].outputs.iter().copied());
        inputs.filter(|channel| writers[channel.0].is_some()).chain(outputs).collect()
    }

    /// The text of `plan.json`.
    ///
    /// # Errors
    /// [`PlanError::Format`]; `path` is where the text is meant to go.
    pub fn to_json(&self, path: &Path) -> Result<Vec<u8>, PlanError> {
        let refused = |error: serde_json::Error| PlanError::Format { path: path.into(), reason: error.to_string() };
        serde_json::to_vec_pretty(self).map_err(refused)
    }

    /// Reads `plan.json` from a run directory.
    ///
    /// # Errors
    /// [`PlanError::File`] and [`PlanError::Format`].
    pub fn read(directory: &Path) -> Result<Self, PlanError> {
        let path = directory.join(PLAN_FILE);
        let text = std::fs::read(&path).map_err(|source| PlanError::File { path: path.clone(), source })?;
        let no_plan = |reason: String| PlanError::Format { path: path.clone(), reason };
        let Written { format } = serde_json::from_slice(&text).map_err(|error| no_plan(error.to_string()))?;
        if format != FORMAT {
            let advice = "build all programs of the run from the same version of Phalanx";
            return Err(no_plan(format!("it has format {format}, this program knows {FORMAT}; {advice}")));
        }
        let plan: Self = serde_json::from_slice(&text).map_err(|error| no_plan(error.to_string()))?;
        if plan.compute_digest() != plan.digest {
            return Err(PlanError::Format { path, reason: "its digest does not fit its content".into() });
        }
        Ok(plan)
    }

    fn compute_digest(&self) -> String {
        let content = (&self.network, &self.phases, self.period, self.dt.to_bits(), self.steps);
        // Strings, integers and vectors of them: encoding cannot fail.
        sha256(&serde_json::to_vec(&content).unwrap_or_default())
    }
}

/// The part of a plan that tells how the rest is written.
#[derive(Deserialize)]
struct Written {
    format: u32,
}

/// SHA-256 as 64 lower-case hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

fn check_network(network: &Network) -> Result<(), PlanError> {
    if network.nodes.is_empty() {
        return Err(PlanError::Size("there is no node to run".into()));
    }
    for channel in &network.channels {
        let words = channel.layout.words();
        if words > MAX_WORDS {
            return Err(PlanError::Large { topic: channel.topic.clone(), words });
        }
        let (found, finite) = (channel.initial.len(), channel.initial.iter().all(|word| word.is_finite()));
        if !finite || ![0, words].contains(&found) {
            return Err(PlanError::Initial { topic: channel.topic.clone(), found, words });
        }
    }
    check_names(network.nodes.iter().map(|node| &node.name))?;
    let mut written = BTreeSet::new();
    for node in &network.nodes {
        let channels = node.inputs.iter().map(|input| input.channel).chain(node.outputs.iter().copied());
        if let Some(channel) = channels.into_iter().find(|channel| channel.0 >= network.channels.len()) {
            return Err(PlanError::Index(format!(
                "node {} uses channel {}, which does not exist",
                node.name, channel.0
            )));
        }
        if let Some(twice) = node.outputs.iter().find(|output| !written.insert(output.0)) {
            return Err(PlanError::Writers(network.channels[twice.0].topic.clone()));
        }
    }
    Ok(())
}

fn check_workers(network: &Network, workers: &[WorkerPlan]) -> Result<(), PlanError> {
    check_names(workers.iter().map(|worker| &worker.name))?;
    let mut hosts = vec![0; network.nodes.len()];
    for worker in workers {
        for &node in &worker.nodes {
            match hosts.get_mut(node) {
                Some(count) => *count += 1,
                None => {
                    let text = format!("worker {} hosts node {node}, which does not exist", worker.name);
                    return Err(PlanError::Index(text));
                }
            }
        }
    }
    match hosts.iter().position(|&count| count != 1) {
        Some(node) => Err(PlanError::Hosts { node: network.nodes[node].name.clone(), hosts: hosts[node] }),
        None => Ok(()),
    }
}

fn check_names<'a>(names: impl Iterator<Item = &'a String>) -> Result<(), PlanError> {
    let mut seen = BTreeSet::new();
    for name in names {
        let allowed = |character: char| character.is_ascii_alphanumeric() || "_-,".contains(character);
        if name.is_empty() || name.len() > 64 || !name.chars().all(allowed) {
            return Err(PlanError::BadName(name.clone()));
        }
        if !seen.insert(name) {
            return Err(PlanError::Name(name.clone()));
        }
    }
    Ok(())
}
