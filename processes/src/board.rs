//! The channels of a run as iceoryx2 services: a blackboard for up to 64 channels of a worker, a ring of cells per channel.
//!
//! A blackboard keeps the latest value only. A sample of step k must not replace that of k-1 while a reader still needs it
//! (delayed edges), and the conductor records several steps at a time; so every channel has cells for the last [`RING`] steps.
//!
//! A process that takes the place of another one writes to services of its own: a writer that was killed leaves its cells
//! locked for ever. Readers notice by the page that a worker has another incarnation, and [`follow`] it.

use std::collections::BTreeMap;
use std::path::Path;

use iceoryx2::prelude::{NodeBuilder, SignalHandlingMode, ipc};
use iceoryx2::service::port_factory::blackboard::PortFactory;

use crate::board_parts::{BoardPart, BoardParts};
pub(crate) use crate::cell::RING;
use crate::cell::{Class, ReadRing, WriteRing, class_for};
use crate::directory;
use crate::page::Page;
use crate::seal::SealKey;
use crate::service::{ServiceError, configuration, error};
use lockstep::PlanError;
use lockstep::{ChannelId, Header, Network, Plan, Status, Store};

/// Where iceoryx2 keeps its files within the run directory.
pub(crate) const ROOT: &str = "iox";
/// Readers and nodes that may join a service beyond those of the plan: tools that look on.
const SPARE: usize = 4;

/// What a service takes in shared memory, for the look at whether there is room: copies of every cell ...
const CELL_COPIES: usize = 2;
/// ... bytes for each reader ...
const READER_BYTES: usize = 256;
/// ... and bytes for everything else.
const SERVICE_BYTES: usize = 32 << 10;

/// This process as iceoryx2 sees it.
pub(crate) struct Boards {
    node: iceoryx2::node::Node<ipc::Service>,
}

/// The cells of one channel, to write.
pub(crate) struct ChannelWriter {
    channel: ChannelId,
    key: SealKey,
    cells: WriteRing,
}

/// The cells of one channel, to read.
pub(crate) struct ChannelReader {
    pub(crate) channel: ChannelId,
    /// Number of the node that writes it.
    writer: usize,
    /// The worker that hosts that node, and which of its services.
    host: usize,
    part: usize,
    /// Which process of that worker.
    incarnation: u32,
    /// Whether it writes at every step from the first.
    always: bool,
    key: SealKey,
    cells: ReadRing,
}

/// A sample that is not the one that was due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BadSample {
    channel: ChannelId,
    /// Number of the node that writes it.
    writer: usize,
    expected: u64,
    wrong: Wrong,
}

/// What is wrong with a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    /// It is as it was published at another step.
    Step(u64),
    /// It is not as it was published.
    Altered,
}

impl Boards {
    /// Joins the run whose directory this is.
    ///
    /// # Errors
    /// [`ServiceError`] if iceoryx2 cannot work there.
    pub(crate) fn join(directory: &Path, run: &str, name: &str) -> Result<Self, ServiceError> {
        let config = configuration(&directory.join(ROOT), run)?;
        let node_name = name.try_into().map_err(error(format!("iceoryx2 cannot use the name of {name}")))?;
        let node = NodeBuilder::new()
            .name(&node_name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(error(format!("iceoryx2 does not let {name} in")))?;
        Ok(Self { node })
    }

    /// This process's node.
    pub(crate) fn node(&self) -> &iceoryx2::node::Node<ipc::Service> {
        &self.node
    }

    /// What a program of iceoryx2 needs as its configuration to join the run, TOML.
    pub(crate) fn config_text(&self) -> String {
        let global = &self.node.config().global;
        format!("[global]\nroot-path = \"{}\"\nprefix = \"{}\"\n", global.root_path(), global.prefix)
    }

    /// Creates a service of one process of its worker, for `readers` processes besides this one and the writer's.
    ///
    /// # Errors
    /// [`ServiceError`], also if a sample fits no cell.
    pub(crate) fn create<'a>(
        &self,
        plan: &'a Plan,
        part: &'a BoardPart,
        incarnation: u32,
        readers: usize,
    ) -> Result<Board<'a>, ServiceError> {
        let network = &plan.network;
        let name = service_name(plan, part, incarnation);
        let what = || format!("create service {name}");
        let cells = part.channels.iter().map(|&(channel, _)| Ok(class_of(network, channel)?.bytes()));
        let cells: usize = cells.sum::<Result<usize, ServiceError>>()? * RING as usize;
        directory::require_room(CELL_COPIES * cells + READER_BYTES * readers + SERVICE_BYTES)
            .map_err(|error| ServiceError { what: what(), cause: error.to_string() })?;
        let service_name = name.as_str().try_into().map_err(error(format!("service {name}")))?;
        let mut creator = self
            .node
            .service_builder(&service_name)
            .blackboard_creator::<u64>()
            .max_readers(readers + 1 + SPARE)
            .max_nodes(readers + 2 + SPARE);
        for (number, &(channel, _)) in part.channels.iter().enumerate() {
            creator = class_of(network, channel)?.add(creator, number);
        }
        let service = creator.create().map_err(error(what()))?;
        Ok(Board { network, part, incarnation, name, service })
    }

    /// Opens a service of one process of its worker, which must exist.
    ///
    /// # Errors
    /// [`ServiceError`].
    pub(crate) fn open<'a>(
        &self,
        plan: &'a Plan,
        part: &'a BoardPart,
        incarnation: u32,
    ) -> Result<Board<'a>, ServiceError> {
        let name = service_name(plan, part, incarnation);
        let service_name = name.as_str().try_into().map_err(error(format!("service {name}")))?;
        let opener = self.node.service_builder(&service_name).blackboard_opener::<u64>();
        let service = opener.open().map_err(error(format!("open service {name}")))?;
        Ok(Board { network: &plan.network, part, incarnation, name, service })
    }
}

/// An open service.
pub(crate) struct Board<'a> {
    network: &'a Network,
    part: &'a BoardPart,
    incarnation: u32,
    name: String,
    service: PortFactory<ipc::Service, u64>,
}

impl Board<'_> {
    /// Becomes the writer of the service's channels, in order.
    ///
    /// # Errors
    /// [`ServiceError`] if there is a writer already.
    pub(crate) fn writers(&self) -> Result<Vec<ChannelWriter>, ServiceError> {
        let failed = || format!("write to service {}", self.name);
        let port = self.service.writer_builder().create().map_err(error(failed()))?;
        let open = |(number, &(channel, _)): (usize, &(ChannelId, usize))| {
            let cells = class_of(self.network, channel)?.writer(&port, number).map_err(error(failed()))?;
            let key = SealKey::of(channel, self.incarnation);
            Ok(ChannelWriter { channel, key, cells })
        };
        self.part.channels.iter().enumerate().map(open).collect()
    }

    /// Becomes a reader of those of the service's channels that are `wanted`.
    ///
    /// # Errors
    /// [`ServiceError`] if there are too many readers.
    pub(crate) fn readers(&self, wanted: impl Fn(&ChannelId) -> bool) -> Result<Vec<ChannelReader>, ServiceError> {
        let failed = || format!("read from service {}", self.name);
        let port = self.service.reader_builder().create().map_err(error(failed()))?;
        let &BoardPart { worker: host, number: part, .. } = self.part;
        let incarnation = self.incarnation;
        let open = |(number, &(channel, writer)): (usize, &(ChannelId, usize))| {
            let cells = class_of(self.network, channel)?.reader(&port, number).map_err(error(failed()))?;
            let always = self.network.nodes[writer].always_runs();
            let key = SealKey::of(channel, incarnation);
            Ok(ChannelReader { channel, writer, host, part, incarnation, always, key, cells })
        };
        self.part.channels.iter().enumerate().filter(|(_, (channel, _))| wanted(channel)).map(open).collect()
    }
}

impl ChannelWriter {
    /// What it writes.
    pub(crate) fn channel(&self) -> ChannelId {
        self.channel
    }

    /// Publishes the sample of `step`, if there is one.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn publish(&mut self, store: &Store, step: u64) {
        if let Some(header) = store.header(self.channel, step) {
            let words = store.read(self.channel, step);
            self.cells.write(step, (header, self.key.seal(header, words)), words);
        }
    }
}

impl ChannelReader {
    /// Fetches the sample of `step` into the store, if there is one yet.
    ///
    /// # Errors
    /// [`BadSample`] if the cell holds another sample than the one that is due, or not what was published.
    #[unsafe(link_section = "lockstep_step")]
    pub(crate) fn fetch(&self, network: &Network, store: &mut Store, step: u64) -> Result<(), BadSample> {
        let expected = if self.always { Some(step) } else { network.nodes[self.writer].last_run(step) };
        let Some(expected) = expected else { return Ok(()) };
        let words = store.write(self.channel, step);
        let (header, seal) = self.cells.read(step, words);
        if seal != self.key.seal(&header, words) {
            return Err(self.bad(expected, if seal == 0 { Wrong::Step(header.step) } else { Wrong::Altered }));
        }
        // What stands in for a failed participant is as old as its last sample.
        if header.step != expected && header.status != Status::Stale as u32 {
            return Err(self.bad(expected, Wrong::Step(header.step)));
        }
        store.stamp(self.channel, step, header);
        Ok(())
    }
}

impl ChannelReader {
    /// Copies whatever sample stands in the cell of `step` and returns its header, for those who only monitor a run; `None` if
    /// it is not as it was published.
    pub(crate) fn peek(&self, step: u64, words: &mut [f64]) -> Option<Header> {
        let (header, seal) = self.cells.read(step, words);
        (seal == 0 || seal == self.key.seal(&header, words)).then_some(header)
    }

    /// The worker that writes it, and which of its services.
    pub(crate) fn service(&self) -> (usize, usize) {
        (self.host, self.part)
    }

    /// Whether any of the cells holds what was never published. `words` has the length of a sample.
    pub(crate) fn is_altered(&self, words: &mut [f64]) -> bool {
        (0..RING).any(|place| {
            let (header, seal) = self.cells.read(place, words);
            // Before the first sample, a cell holds NaN, and no seal.
            let is_empty = seal == 0 && words.iter().all(|word| word.is_nan());
            !is_empty && seal != self.key.seal(&header, words)
        })
    }

    /// Of which step the sample in the cell of `step` is.
    pub(crate) fn step_in(&self, step: u64) -> u64 {
        self.cells.read(step, &mut []).0.step
    }

    #[cold]
    fn bad(&self, expected: u64, wrong: Wrong) -> BadSample {
        BadSample { channel: self.channel, writer: self.writer, expected, wrong }
    }
}

impl BadSample {
    /// The error in words.
    pub(crate) fn describe(&self, network: &Network) -> String {
        let topic = &network.channels[self.channel.0].topic;
        let (writer, expected) = (&network.nodes[self.writer].name, self.expected);
        match self.wrong {
            Wrong::Step(found) => format!("the sample of {topic} is that of step {found}, not of step {expected}"),
            Wrong::Altered => format!(
                "the sample of {topic} of step {expected} is not what {writer} has published: a process has written into \
                 its shared memory, as a stray pointer does"
            ),
        }
    }
}

/// Lets those readers whose writer was replaced read from its successor.
///
/// # Errors
/// [`ServiceError`] if a service cannot be opened.
pub(crate) fn follow<'a>(
    boards: &Boards,
    page: &Page,
    plan: &Plan,
    readers: impl Iterator<Item = &'a mut ChannelReader>,
) -> Result<(), ServiceError> {
    let is_left = |reader: &&'a mut ChannelReader| page.incarnation(reader.host) != reader.incarnation;
    let mut left: BTreeMap<(usize, usize), BTreeMap<ChannelId, &mut ChannelReader>> = BTreeMap::new();
    for reader in readers.filter(is_left) {
        left.entry((reader.host, reader.part)).or_default().insert(reader.channel, reader);
    }
    let parts = BoardParts::of(plan);
    for ((host, part), mut readers) in left {
        // One port for all channels of a service, which has places for few.
        let board = boards.open(plan, &parts.of_worker(host)[part], page.incarnation(host))?;
        for fresh in board.readers(|channel| readers.contains_key(channel))? {
            if let Some(reader) = readers.get_mut(&fresh.channel) {
                **reader = fresh;
            }
        }
    }
    Ok(())
}

/// Names a service of one process of a worker.
fn service_name(plan: &Plan, part: &BoardPart, incarnation: u32) -> String {
    format!("{}/out.{incarnation}.{}", plan.workers[part.worker].name, part.number)
}

fn class_of(network: &Network, channel: ChannelId) -> Result<Class, ServiceError> {
    let Some(channel) = network.channels.get(channel.0) else {
        return Err(ServiceError { what: format!("channel {}", channel.0), cause: "does not exist".into() });
    };
    let words = channel.layout.words();
    class_for(words).ok_or_else(|| ServiceError {
        what: "size of a sample".into(),
        cause: PlanError::Large { topic: channel.topic.clone(), words }.to_string(),
    })
}
