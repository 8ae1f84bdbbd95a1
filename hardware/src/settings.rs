//! `robot.toml`: where a robot is, and what the bridge has to watch for.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;

use formation::config::{Node, Problem, Problems, Source, read, read_text};
use lockstep::{LONGEST_WAIT, wait_time};
use plant::Laboratory;
use serde::{Deserialize, Serialize};

use crate::message::Clock;

/// After so long without a command an emulated robot halts by itself, s.
pub const EMULATOR_WATCHDOG: f64 = 0.5;

/// A robot, as the bridge and the emulator are told about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// TCP address of the robot.
    pub robot: SocketAddr,
    /// UDP address at which the host listens to the cameras; port 0: any, which the robot is told.
    pub mocap: SocketAddr,
    /// Number under which robot and cameras know it.
    pub body: u32,
    /// `wall` for real robots; `lockstep` for an emulator that waits for every step.
    #[serde(default = "wall")]
    pub clock: Clock,
    /// Whether other machines may take part; without, both addresses have to be loopback.
    #[serde(default)]
    pub allow_remote: bool,
    /// After so many periods without a command, the bridge halts the robot.
    #[serde(default = "five")]
    pub watchdog_periods: u32,
    /// A link on which no command is acknowledged for so long is closed, which halts the robot, s; 0: robots need not
    /// acknowledge.
    #[serde(default = "one")]
    pub acknowledge_within: f64,
    /// The run ends if there was neither a valid pose nor a connection for so long, s.
    #[serde(default = "one")]
    pub lost_after: f64,
    /// How long connection and first pose may take at the start, s.
    #[serde(default = "ten")]
    pub start_patience: f64,
    /// In lockstep: how long a step waits for the emulator before it goes on with what it has, s.
    #[serde(default = "two")]
    pub deadline: f64,
    /// From a capture to its arrival at least, as known of the cameras, s.
    #[serde(default)]
    pub mocap_latency: f64,
    /// More poses per second than this are dropped.
    #[serde(default = "thousand")]
    pub mocap_max_rate: u32,
    /// Which jumps of the pose are not believed; without, all are.
    #[serde(default)]
    pub gate: Option<Gate>,
    /// What `phalanx robot` plays; the bridge does not read it.
    #[serde(default)]
    pub emulator: Option<Emulator>,
}

/// How far a pose may be from the one before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gate {
    /// Distance, m.
    pub position: f64,
    /// Turn, rad.
    pub angle: f64,
    /// A pose that stays beyond the gate for so long is believed after all, s.
    pub patience: f64,
}

/// What `phalanx robot` plays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Emulator {
    /// Name of a shipped scenario or path of a file, from which the robot takes its vehicle, its start and its disturbance.
    pub scenario: String,
    /// Number of its agent, from 1.
    pub agent: u32,
    /// After so long without a command the robot halts by itself, s.
    #[serde(default = "half")]
    pub watchdog: f64,
    /// Motors, link and cameras; without, those of the scenario if its plant is a laboratory.
    #[serde(default)]
    pub laboratory: Option<Laboratory>,
}

fn wall() -> Clock {
    Clock::Wall
}

fn half() -> f64 {
    EMULATOR_WATCHDOG
}

fn one() -> f64 {
    1.0
}

fn two() -> f64 {
    2.0
}

fn ten() -> f64 {
    10.0
}

fn five() -> u32 {
    5
}

fn thousand() -> u32 {
    1000
}

impl Settings {
    /// Those of a robot at an address, everything else as it is if a file does not say.
    pub fn new(robot: SocketAddr, mocap: SocketAddr, body: u32) -> Self {
        Self {
            robot,
            mocap,
            body,
            clock: wall(),
            allow_remote: false,
            watchdog_periods: five(),
            acknowledge_within: one(),
            lost_after: one(),
            start_patience: ten(),
            deadline: two(),
            mocap_latency: 0.0,
            mocap_max_rate: thousand(),
            gate: None,
            emulator: None,
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its place.
    pub fn load(path: &Path) -> Result<Self, Vec<Problem>> {
        let name = path.display().to_string();
        let text =
            read_text(path).map_err(|error| vec![Problem::new(None, "", format!("cannot read {name}: {error}"))])?;
        Self::parse(&name, &text)
    }

    /// Reads a text; `name` is what messages call it.
    ///
    /// # Errors
    /// See [`Settings::load`].
    pub fn parse(name: &str, text: &str) -> Result<Self, Vec<Problem>> {
        let source = Arc::new(Source { name: name.into(), text: text.into() });
        let root = Node::parse(source).map_err(|problem| vec![problem])?;
        let mut problems = Problems::default();
        let settings = read::<Self>(&root, "", &mut problems);
        for (field, message) in settings.iter().flat_map(Self::findings) {
            problems.at(&root, &field, message);
        }
        match settings {
            Some(settings) if problems.is_empty() => Ok(settings),
            _ => Err(problems.into_vec()),
        }
    }

    /// The text of a file with these settings.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    fn findings(&self) -> Vec<(String, String)> {
        let mut findings = Vec::new();
        for (field, address) in [("robot", self.robot), ("mocap", self.mocap)] {
            if !self.allow_remote && !address.ip().is_loopback() {
                let message = format!(
                    "{address} is not on this machine; write `allow_remote = true` if the network is yours alone: \
                     the frames are neither secret nor signed"
                );
                findings.push((field.to_string(), message));
            }
        }
        let mut times =
            vec![("lost_after", self.lost_after), ("start_patience", self.start_patience), ("deadline", self.deadline)];
        times.extend(self.gate.iter().map(|gate| ("gate.patience", gate.patience)));
        times.extend(self.emulator.iter().map(|emulator| ("emulator.watchdog", emulator.watchdog)));
        let refused = |(field, time): (&str, f64)| Some((field.to_string(), wait_time(time).err()?));
        findings.extend(times.into_iter().filter_map(refused));
        let mut positive = |field: &str, value: f64| {
            if !(value.is_finite() && value > 0.0) {
                findings.push((field.into(), format!("expected a number > 0, found {value:?}")));
            }
        };
        positive("watchdog_periods", f64::from(self.watchdog_periods));
        positive("mocap_max_rate", f64::from(self.mocap_max_rate));
        if let Some(gate) = &self.gate {
            positive("gate.position", gate.position);
            positive("gate.angle", gate.angle);
        }
        if let Some(emulator) = &self.emulator {
            let laboratory = emulator.laboratory.iter().flat_map(Laboratory::findings);
            findings.extend(laboratory.map(|(field, text)| (format!("emulator.laboratory.{field}"), text)));
        }
        for (field, value) in [("mocap_latency", self.mocap_latency), ("acknowledge_within", self.acknowledge_within)] {
            if !(0.0..=LONGEST_WAIT).contains(&value) {
                findings.push((field.into(), format!("expected a time from 0 to {LONGEST_WAIT} s, found {value:?}")));
            }
        }
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST: &str = "robot = \"127.0.0.1:7402\"\nmocap = \"127.0.0.1:7502\"\nbody = 2\n";

    fn mistakes(text: &str) -> String {
        let problems = Settings::parse("robot.toml", text).unwrap_err();
        problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn three_lines_are_enough_and_all_are_written_again() {
        let settings = Settings::parse("robot.toml", LEAST).unwrap();
        assert_eq!((settings.clock, settings.body, settings.gate), (Clock::Wall, 2, None));
        assert_eq!(settings, Settings::new(settings.robot, settings.mocap, 2));
        let mut full = settings;
        full.gate = Some(Gate { position: 0.1, angle: 0.2, patience: 0.5 });
        full.emulator = Some(Emulator {
            scenario: "compensated".into(),
            agent: 2,
            watchdog: 0.5,
            laboratory: Some(Laboratory::default()),
        });
        assert_eq!(Settings::parse("robot.toml", &full.to_toml()).unwrap(), full);
    }

    #[test]
    fn mistakes_are_named_with_their_places() {
        let text = mistakes(&format!("{LEAST}watchdog = 3"));
        assert!(
            text.contains("robot.toml:4:1: watchdog: unknown field") && text.contains("watchdog_periods"),
            "{text}"
        );
        assert!(mistakes("body = 2").contains("missing field `robot`"));
        let text = mistakes(&LEAST.replace("127.0.0.1:7502", "0.0.0.0:7502"));
        assert!(text.contains("mocap: 0.0.0.0:7502 is not on this machine"), "{text}");
        let open = format!("{}allow_remote = true", LEAST.replace("127.0.0.1:7502", "0.0.0.0:7502"));
        assert!(Settings::parse("robot.toml", &open).is_ok());
        assert!(mistakes(&format!("{LEAST}lost_after = -1")).contains("lost_after: expected a time above 0"));
        for field in ["start_patience", "lost_after", "deadline", "acknowledge_within", "mocap_latency"] {
            let text = mistakes(&format!("{LEAST}{field} = 1e300"));
            assert!(text.contains(&format!("{field}: expected a time")) && text.contains("1e300"), "{text}");
        }
        let text = mistakes(&format!("{LEAST}[emulator]\nscenario = \"cida\"\nagent = 1\nwatchdog = 1e300"));
        assert!(text.contains("emulator.watchdog: expected a time"), "{text}");
    }
}
