//! How a process takes the place of another one in a run that goes on: it goes through the steps that are done at full
//! speed, on the recorded inputs, and then takes its place at the gate where the other one is missed.

use std::env;
use std::fs::File;
use std::io::{BufReader, Read};
use std::os::fd::RawFd;

use super::phase_share::{HostedNode, PhaseShare};
use super::{Worker, adopt};
use crate::board::{Boards, ChannelReader};
use crate::board_parts::BoardParts;
use crate::page::{FaultKind, Report};
use crate::service::ServiceError;
use lockstep::{ChannelId, HEADER_BYTES, Header, Plan, Step, Store};

/// Environment variable that tells a process that it takes the place of another one, as [`ReplacementOrder`] in JSON.
pub(crate) const REPLACEMENT: &str = "PHALANX_REPLACEMENT";

/// What a process does with the steps that are done when it takes the place of another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Replacement {
    /// It computes them anew on the recorded inputs. From the step `since` on, at which its program took over, it must come to
    /// what was published, bit by bit; before that, another program played, and what that has published stays as it was.
    Recompute {
        /// The first step that its program has to answer for; 0 for the program that the run was started with.
        since: u64,
    },
    /// It computes them on the recorded inputs, to have a state; what it comes to may differ: it is another program.
    Adopt,
    /// It computes nothing, neither then nor later: the last samples stand, marked as [`Stale`](lockstep::Status::Stale).
    Hold,
}

/// Where a process comes into a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct ReplacementOrder {
    pub(crate) replacement: Replacement,
    /// Number of this process among those of its worker.
    pub(crate) incarnation: u32,
    /// The steps whose samples come through the pipe: from here ...
    pub(crate) first: u64,
    /// ... to here, this one not included.
    pub(crate) recorded: u64,
    /// The step at which the worker is missed ...
    pub(crate) step: u64,
    /// ... and which of the phases that it takes part in.
    pub(crate) place: usize,
    /// The reading end of the pipe with the recorded steps.
    pub(crate) pipe: RawFd,
}

impl ReplacementOrder {
    /// What the environment tells; `None` for a process that starts with the run.
    pub(super) fn find() -> Result<Option<Self>, String> {
        match env::var(REPLACEMENT) {
            Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| format!("{REPLACEMENT}: {error}")),
            Err(env::VarError::NotPresent) => Ok(None),
            Err(error) => Err(format!("{REPLACEMENT}: {error}")),
        }
    }
}

/// The samples of the steps that are done, as the recorder has them.
struct RecordedSteps {
    input: BufReader<File>,
    channels: Vec<ChannelId>,
    bytes: Vec<u8>,
}

impl RecordedSteps {
    fn open(worker: &Worker, order: &ReplacementOrder) -> Result<Self, String> {
        let file = adopt(order.pipe).map_err(|error| format!("the recorded steps cannot be read: {error}"))?;
        let input = BufReader::with_capacity(1 << 16, file.into());
        Ok(Self { input, channels: worker.plan.traffic(worker.number).into_iter().collect(), bytes: Vec::new() })
    }

    /// Reads all samples of the next step into `store`.
    fn step(&mut self, plan: &Plan, store: &mut Store, step: u64) -> Result<(), Report> {
        for &channel in &self.channels {
            let words = plan.network.channels[channel.0].layout.words();
            self.bytes.resize(HEADER_BYTES + 8 * words, 0);
            let read = self.input.read_exact(&mut self.bytes);
            read.map_err(|error| refusal(format!("the recorded steps end before step {step}: {error}")))?;
            let (values, _) = self.bytes[HEADER_BYTES..].as_chunks();
            for (word, value) in store.write(channel, step).iter_mut().zip(values) {
                *word = f64::from_le_bytes(*value);
            }
            if let Some(header) = Header::from_bytes(&self.bytes) {
                store.stamp(channel, step, header);
            }
        }
        Ok(())
    }
}

/// A sample that was published before.
struct Published {
    channel: ChannelId,
    header: Option<Header>,
    words: Vec<f64>,
}

/// The way of a process through the steps that are done.
pub(super) struct CatchUp {
    order: ReplacementOrder,
    recorded: RecordedSteps,
    /// Of what the process before this one has published and the conductor has not recorded yet.
    former: Vec<ChannelReader>,
    /// What was published at the step in progress.
    published: Vec<Published>,
}

impl CatchUp {
    pub(super) fn open(
        worker: &Worker,
        order: ReplacementOrder,
        boards: &Boards,
        shares: &[PhaseShare],
    ) -> Result<Self, String> {
        let recorded = RecordedSteps::open(worker, &order)?;
        let former = former_readers(worker, boards).map_err(|error| error.to_string())?;
        let channels = shares.iter().flat_map(outputs);
        let published = channels.map(|channel| Published { channel, header: None, words: Vec::new() }).collect();
        Ok(Self { order, recorded, former, published })
    }

    /// The first step to go through.
    pub(super) fn first(&self) -> u64 {
        self.order.first
    }

    /// Whether this share of a step is done already.
    pub(super) fn covers(&self, step: &Step, share: usize) -> bool {
        (step.index, share) < (self.order.step, self.order.place)
    }

    /// Brings the samples that a share reads, and what it has published, into the store.
    pub(super) fn enter(
        &mut self,
        plan: &Plan,
        shares: &[PhaseShare],
        share: usize,
        store: &mut Store,
        step: &Step,
    ) -> Result<(), Report> {
        if step.index < self.order.recorded {
            if share == 0 {
                self.recorded.step(plan, store, step.index)?;
                self.published.iter_mut().for_each(|published| published.note(store, step.index));
            }
            return Ok(());
        }
        shares[share].fetch(plan, store, step)?;
        for channel in outputs(&shares[share]) {
            for reader in self.former.iter().filter(|reader| reader.channel == channel) {
                let fetched = reader.fetch(&plan.network, store, step.index);
                fetched.map_err(|wrong| refusal(wrong.describe(&plan.network)))?;
            }
            let own = self.published.iter_mut().filter(|published| published.channel == channel);
            own.for_each(|published| published.note(store, step.index));
        }
        Ok(())
    }

    /// Compares what was computed with what was published, and publishes that again.
    pub(super) fn leave(
        &self,
        plan: &Plan,
        share: &mut PhaseShare,
        store: &mut Store,
        step: &Step,
    ) -> Result<(), Report> {
        for channel in outputs(share) {
            for published in self.published.iter().filter(|published| published.channel == channel) {
                if let Replacement::Recompute { since } = self.order.replacement
                    && step.index >= since
                {
                    published.check(plan, store, step.index)?;
                }
                // What others have read stays as it was, whatever another program computes.
                published.restore(store, step.index);
            }
        }
        share.members.iter_mut().for_each(|hosted| hosted.publish(store, step));
        Ok(())
    }

    /// From now on this process is the one that serves as its worker.
    pub(super) fn take_over(&self, worker: &Worker) {
        worker.page.take_over(worker.number, self.order.incarnation);
        worker.page.mark_ready(worker.number);
    }
}

fn outputs(share: &PhaseShare) -> impl Iterator<Item = ChannelId> {
    share.members.iter().flat_map(HostedNode::outputs)
}

fn refusal(message: String) -> Report {
    Report { kind: FaultKind::Refusal, node: 0, step: 0, message }
}

/// Readers of what the process before this one has published.
fn former_readers(worker: &Worker, boards: &Boards) -> Result<Vec<ChannelReader>, ServiceError> {
    let incarnation = worker.page.incarnation(worker.number);
    let mut readers = Vec::new();
    for part in BoardParts::of(&worker.plan).of_worker(worker.number) {
        readers.extend(boards.open(&worker.plan, part, incarnation)?.readers(|_| true)?);
    }
    Ok(readers)
}

impl Published {
    fn note(&mut self, store: &Store, step: u64) {
        self.header = store.header(self.channel, step).copied();
        self.words.clear();
        self.words.extend_from_slice(store.read(self.channel, step));
    }

    /// Puts it back into the store.
    fn restore(&self, store: &mut Store, step: u64) {
        if let Some(header) = self.header {
            store.write(self.channel, step).copy_from_slice(&self.words);
            store.stamp(self.channel, step, header);
        }
    }

    /// Whether what is in the store now is the same, bit by bit.
    fn check(&self, plan: &Plan, store: &Store, step: u64) -> Result<(), Report> {
        let now = store.read(self.channel, step);
        let differs = |(now, before): (&f64, &f64)| now.to_bits() != before.to_bits();
        let Some(at) = now.iter().zip(&self.words).position(differs) else { return Ok(()) };
        let channel = &plan.network.channels[self.channel.0];
        Err(refusal(format!(
            "it recomputes {} {} of step {step} as {}, but {} was published: the participant does not follow from its \
             inputs alone, so it cannot be restarted",
            channel.topic,
            channel.layout.label(at),
            now[at],
            self.words[at]
        )))
    }
}
