//! The samples that a monitor has received of a running simulation, as a [`Log`], so that it is shown by the code that shows logs.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use lockstep::{Header, Network};

use super::Log;
use super::numbers::Numbers;
use super::reader::LogChannel;

impl Log {
    /// An empty log of the run `name` with the channels of `network`; `data` are the data files of its scenario. There is no file
    /// of it; its steps have gaps.
    pub fn live(
        name: &str,
        network: &Network,
        scenario: String,
        data: BTreeMap<String, Arc<[u8]>>,
        metadata: BTreeMap<String, String>,
    ) -> Self {
        let channel = |channel: &lockstep::Channel| LogChannel {
            topic: channel.topic.clone(),
            schema: String::new(),
            messages: 0,
            agent: channel.agent,
            layout: Some(channel.layout.clone()),
            kept: None,
            data: Numbers::default(),
        };
        Self {
            path: PathBuf::from(name),
            complete: true,
            scenario: Some(scenario),
            data,
            metadata: Some(metadata),
            players: Vec::new(),
            channels: network.channels.iter().map(channel).collect(),
            first: None,
            times: Vec::new(),
        }
    }

    /// Adds the samples of a step at `time_ns`, one of each channel in their order.
    pub fn push<'a>(&mut self, time_ns: u64, samples: impl Iterator<Item = (&'a Header, &'a [f64])>) {
        for (channel, (header, words)) in self.channels.iter_mut().zip(samples) {
            let header = [header.step as f64, f64::from(header.status)];
            channel.data.extend(header.iter().chain(words).copied());
            channel.messages += 1;
        }
        self.times.push(time_ns);
    }

    /// Forgets every second step; the newest stays.
    pub fn thin(&mut self) {
        let newest = self.times.len().saturating_sub(1);
        let keep = |row: usize| (newest - row).is_multiple_of(2);
        for channel in &mut self.channels {
            let stride = channel.stride();
            let rows = channel.data.chunks_exact(stride).enumerate().filter(|(row, _)| keep(*row));
            channel.data = rows.flat_map(|(_, sample)| sample).copied().collect::<Vec<_>>().into();
        }
        let times = self.times.iter().enumerate().filter(|(row, _)| keep(*row));
        self.times = times.map(|(_, time)| *time).collect();
    }

    /// Forgets all steps.
    pub fn clear(&mut self) {
        self.channels.iter_mut().for_each(|channel| channel.data.truncate(0));
        self.times.clear();
    }

    /// Numbers of one step over all channels.
    pub fn width(&self) -> usize {
        self.channels.iter().map(LogChannel::stride).sum()
    }
}

#[cfg(test)]
mod tests {
    use lockstep::{Channel, Field, Layout, Status};

    use super::super::reader::HEADER_WORDS;

    use super::*;

    #[test]
    fn a_thinned_log_keeps_its_newest_step() {
        let layout = Layout::new([Field::vector("x", 2, "m")]);
        let channels = vec![Channel { topic: "/agent_1/state".into(), agent: 1, layout, initial: Vec::new() }];
        let network = Network { channels, nodes: Vec::new() };
        let mut log = Log::live("run", &network, String::new(), BTreeMap::new(), BTreeMap::new());
        for step in 0..4 {
            let words = [step as f64, -1.0];
            log.push(step * 10, std::iter::once((&Header::new(step, 10, 1, Status::Fresh), &words[..])));
        }
        assert_eq!((log.width(), log.times().len()), (HEADER_WORDS + 2, 4));
        log.thin();
        assert_eq!(log.times(), [10, 30]);
        let rows: Vec<&[f64]> = log.signal("/agent_1/state", "x").unwrap().rows().collect();
        assert_eq!(rows, [[1.0, -1.0], [3.0, -1.0]]);
        log.clear();
        assert!(log.times().is_empty() && log.signal("/agent_1/state", "x").unwrap().is_empty());
    }
}
