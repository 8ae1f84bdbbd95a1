//! What goes from a run into its log.

use std::collections::BTreeMap;

use formation::wiring::Assembly;
use lockstep::{ChannelId, Header, Network, Period, Status, Store};

use crate::failure::Failure;
use crate::run::players::Player;
use recording::{DEFAULT_FLUSH_EVERY, LogPlace, PLAYER, Recorder, RunInfo};

/// Starts the log of a run of the scenario on the channels of `network`, with these `players` in the place of Phalanx.
///
/// # Errors
/// [`Failure::Log`].
pub(crate) fn create_log(
    place: &LogPlace,
    assembly: &Assembly,
    network: &Network,
    players: &[Player],
) -> Result<Recorder, Failure> {
    let scenario = &assembly.scenario;
    let text = scenario.to_record();
    // What changes no bit of the result stays out of the log, so that equal results are equal logs.
    let sections = ["placement", "on_failure", "realtime", "swap"];
    let matters = |text: &&String| !sections.iter().any(|section| text.starts_with(section));
    let overrides: Vec<String> = scenario.overrides.iter().filter(matters).cloned().collect();
    let metadata = BTreeMap::from([
        ("scenario".to_string(), scenario.name.clone()),
        ("variant".to_string(), scenario.variant.clone()),
        ("overrides".to_string(), overrides.join("\n")),
        ("phalanx".to_string(), env!("CARGO_PKG_VERSION").to_string()),
        ("format".to_string(), "1".to_string()),
    ]);
    let info = RunInfo {
        network,
        period: scenario.context.timing.period(),
        scenario: &text,
        metadata: &metadata,
        flush_every: DEFAULT_FLUSH_EVERY,
    };
    let mut recorder = Recorder::create_at(place, &info)?;
    scenario.data.iter().try_for_each(|file| recorder.attach_data(&file.path, &file.bytes))?;
    players.iter().try_for_each(|player| recorder.note(PLAYER, &player.to_metadata()))?;
    Ok(recorder)
}

/// The header of a sample; for a channel whose writer has not run yet, that of the zeros that its readers see.
pub(crate) fn header(network: &Network, period: Period, store: &Store, channel: ChannelId, step: u64) -> Header {
    let agent = network.channels[channel.0].agent;
    store.header(channel, step).copied().unwrap_or_else(|| Header::new(step, period, agent, Status::Held))
}
