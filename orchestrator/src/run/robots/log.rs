//! What the log of a run has only because robots with a clock of their own took part: how well the steps kept their times, and
//! what became of the robots. Nothing of it is in the log of a run whose numbers are the same every time.

use lockstep::{ChannelId, Field, Header, Layout, Network, Status};

use crate::run::observer::{Flow, Observer, StepView};
use recording::{Durability, ENCAPSULATION, ExtraChannel, LogError, Recorder, own_type};

/// Where the times of the steps are.
const TOPIC: &str = "/phalanx/pace";

/// Writes the robot log of one run.
pub(crate) struct RobotLog {
    pace: ExtraChannel,
    misses: u64,
    skipped: u64,
    robots: Vec<Robot>,
}

/// A robot, as its bridge told it last.
struct Robot {
    /// The participant that it plays, `plant_2`.
    node: String,
    channel: ChannelId,
    layout: Layout,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    connected: bool,
    obeys: bool,
    reconnections: f64,
    halts: f64,
}

impl RobotLog {
    /// For a run of `network`, to whose log the topic is added.
    ///
    /// # Errors
    /// [`LogError`] if the log cannot take it.
    pub(crate) fn new(network: &Network, recorder: &mut Recorder) -> Result<Self, LogError> {
        let names = [("late", "s"), ("missed", ""), ("misses", ""), ("skipped", "")];
        let fields = names.map(|(name, unit)| Field::scalar(name, unit));
        let layout = Layout::new(fields);
        let text = layout.ros2msg();
        let pace = recorder.add_channel(TOPIC, &own_type("Pace", &text), &text, Durability::Volatile)?;
        let health = format!("/{}", hardware::health::CHANNEL);
        let channels = network.channels.iter().enumerate().filter(|(_, channel)| channel.topic.ends_with(&health));
        let robots = channels.map(|(index, channel)| Robot {
            node: format!("plant_{}", channel.agent),
            channel: ChannelId(index),
            layout: channel.layout.clone(),
            state: State { connected: true, obeys: true, reconnections: 0.0, halts: 0.0 },
        });
        Ok(Self { pace, misses: 0, skipped: 0, robots: robots.collect() })
    }
}

impl Observer for RobotLog {
    /// Writes how the step was started, and remarks what has become of the robots.
    fn step(&mut self, view: &mut StepView, log: Option<&mut Recorder>) -> Result<Flow, LogError> {
        let (start, step, store) = (view.start, view.step, view.store);
        self.misses += u64::from(start.missed);
        self.skipped += start.skipped;
        let words = [start.late, f64::from(u8::from(start.missed)), self.misses as f64, self.skipped as f64];
        let mut payload = ENCAPSULATION.to_vec();
        payload.extend_from_slice(&Header::new(step, view.period, 0, Status::Fresh).to_bytes());
        words.iter().for_each(|word| payload.extend_from_slice(&word.to_le_bytes()));
        if let Some(log) = log {
            log.write(self.pace, step, &payload)?;
        }
        for robot in &mut self.robots {
            let words = store.read(robot.channel, step);
            let number = |name: &str| robot.layout.find(name).map_or(0.0, |(offset, _)| words[offset]);
            let now = State {
                connected: number("connected") > 0.0,
                obeys: number("obeys") > 0.0,
                reconnections: number("reconnections"),
                halts: number("watchdog"),
            };
            let changes = robot.state.changes(&now);
            view.remarks.extend(changes.map(|text| (robot.node.clone(), text.to_string())));
            robot.state = now;
        }
        Ok(Flow::Continue)
    }
}

impl State {
    /// What is new, in words.
    fn changes(&self, now: &Self) -> impl Iterator<Item = &'static str> {
        [
            (now.reconnections > self.reconnections, "the robot is connected again"),
            (self.connected && !now.connected, "the connection to the robot is lost; its own watchdog stops it"),
            (now.halts > self.halts, "no command for too long; the watchdog of the bridge stopped the robot"),
            (self.obeys && !now.obeys, "the robot says that it is halted"),
            (now.obeys && !self.obeys, "the robot carries out commands again"),
        ]
        .into_iter()
        .filter_map(|(is_new, text)| is_new.then_some(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_is_told_once() {
        let well = State { connected: true, obeys: true, reconnections: 0.0, halts: 0.0 };
        let lost = State { connected: false, ..well };
        let back = State { reconnections: 1.0, ..well };
        let told = |before: &State, now: &State| before.changes(now).collect::<Vec<_>>().join("; ");
        assert_eq!(told(&well, &well), "");
        assert!(told(&well, &lost).starts_with("the connection to the robot is lost"));
        assert_eq!(told(&lost, &lost), "");
        assert_eq!(told(&lost, &back), "the robot is connected again");
        // Lost and found between two steps: the count tells.
        assert_eq!(told(&well, &back), "the robot is connected again");
        assert_eq!(told(&back, &State { obeys: false, ..back }), "the robot says that it is halted");
    }
}
