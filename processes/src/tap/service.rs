//! The services of a tap. iceoryx2 wants them used by the thread that made them.

use std::path::Path;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{PortFactory as _, ZeroCopySend, ipc};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::STEPS;
use crate::board::Boards;
use crate::service::{ServiceError, error};
use lockstep::{Header, Network};

/// Most readers of a channel.
const READERS: usize = 8;

/// The header of a sample as readers of a tap see it, `PhalanxHeader`.
#[derive(Clone, Copy, Debug, Default)]
#[repr(transparent)]
pub struct TapHeader(pub Header);

// SAFETY: a plain repr(C) struct of numbers without pointers or padding.
unsafe impl ZeroCopySend for TapHeader {
    unsafe fn type_name() -> &'static str {
        "PhalanxHeader"
    }
}

/// A publisher for every channel.
pub(super) struct Services {
    topics: Vec<Topic>,
    // Dropped after its publishers.
    boards: Boards,
}

struct Topic {
    words: usize,
    service: PortFactory<ipc::Service, [f64], TapHeader>,
    publisher: Publisher<ipc::Service, [f64], TapHeader>,
}

impl Services {
    /// Creates the services of all channels in the run directory `path` of the run called `name`.
    pub(super) fn create(path: &Path, name: &str, network: &Network) -> Result<Self, ServiceError> {
        let boards = Boards::join(path, name, "tap")?;
        let topics = network.channels.iter().map(|channel| {
            let failed = || format!("create service {}", channel.topic);
            let words = channel.layout.words();
            let name = channel.topic.as_str().try_into().map_err(error(failed()))?;
            let builder = boards.node().service_builder(&name).publish_subscribe::<[f64]>().user_header::<TapHeader>();
            let service = builder
                .max_publishers(1)
                .max_subscribers(READERS)
                .max_nodes(READERS + 1)
                .subscriber_max_buffer_size(STEPS)
                // A reader that comes starts with what comes next, not with what another reader has seen before.
                .history_size(0)
                // The oldest sample of a slow reader gives way, so that the run does not wait for it.
                .enable_safe_overflow(true)
                .create()
                .map_err(error(failed()))?;
            let publisher = service.publisher_builder().max_loaned_samples(1).initial_max_slice_len(words.max(1));
            let publisher = publisher.create().map_err(error(failed()))?;
            Ok(Topic { words, service, publisher })
        });
        Ok(Self { topics: topics.collect::<Result<_, ServiceError>>()?, boards })
    }

    /// What readers need as their configuration, TOML.
    pub(super) fn config(&self) -> String {
        self.boards.config_text()
    }

    /// Whether any process reads.
    pub(super) fn are_read(&self) -> bool {
        self.topics.iter().any(|topic| topic.service.dynamic_config().number_of_subscribers() > 0)
    }

    /// Publishes the samples of a step; channels without a header have none yet.
    pub(super) fn publish(&self, headers: &[Option<Header>], mut words: &[f64]) {
        for (topic, header) in self.topics.iter().zip(headers) {
            let (sample, rest) = words.split_at(topic.words);
            words = rest;
            // The limits rule out that there is no memory; if a reader broke them, samples are lost, no more.
            if let (Some(header), Ok(mut loan)) = (header, topic.publisher.loan_slice_uninit(sample.len())) {
                *loan.user_header_mut() = TapHeader(*header);
                let _ = loan.write_from_slice(sample).send();
            }
        }
    }
}
