//! Participants whose outputs are those of a log.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use formation::scenario::Scenario;
use lockstep::{ChannelId, Fault, Io, Network, Participant, Slice, Step};

use super::{RecordedSamples, ReplayError};

/// A participant that publishes what was recorded of it.
struct Played {
    /// Shared by all that are played from one log in one process; they run one after the other, step by step.
    samples: Arc<Mutex<RecordedSamples>>,
    outputs: Vec<(ChannelId, Slice)>,
    /// What the recorded numbers are multiplied by.
    factor: f64,
}

impl Participant for Played {
    fn step(&mut self, step: &Step, io: &mut Io) -> Result<(), Fault> {
        let mut samples = self.samples.lock().unwrap_or_else(PoisonError::into_inner);
        let fault = |error: ReplayError| Fault(error.to_string());
        if !samples.advance_to(step.index).map_err(fault)? {
            return Err(fault(samples.over(step.index)));
        }
        for &(channel, place) in &self.outputs {
            let words = samples.words(channel);
            if self.factor == 1.0 {
                io.slice_mut(place).copy_from_slice(words);
            } else {
                // A value that is not finite would end the run here, and not reach the participant under test.
                let scaled = words.iter().map(|word| (word * self.factor).clamp(-f64::MAX, f64::MAX));
                io.slice_mut(place).iter_mut().zip(scaled).for_each(|(place, word)| *place = word);
            }
        }
        Ok(())
    }
}

/// The participants of these `nodes`, played from the log `path` in a run of `scenario`. Every number is multiplied by
/// `factor`, up to the largest that there is: 1 to play what was recorded.
///
/// # Errors
/// [`ReplayError`] if the log does not fit.
pub fn played(
    path: &Path,
    scenario: &Scenario,
    network: &Network,
    nodes: &[usize],
    factor: f64,
) -> Result<Vec<Box<dyn Participant>>, ReplayError> {
    let samples = Arc::new(Mutex::new(RecordedSamples::open(path, scenario, network, nodes)?));
    let participant = |&node: &usize| {
        let outputs = network.nodes[node].outputs.iter().enumerate();
        let place = |(port, &channel): (usize, &ChannelId)| {
            (channel, Slice::new(port, 0, network.channels[channel.0].layout.words()))
        };
        let played = Played { samples: Arc::clone(&samples), outputs: outputs.map(place).collect(), factor };
        Box::new(played) as Box<dyn Participant>
    };
    Ok(nodes.iter().map(participant).collect())
}
