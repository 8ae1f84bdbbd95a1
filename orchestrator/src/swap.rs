//! Programs of the user in the place of participants.

use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::process::Command;

use formation::config::{Problem, nearest};
use hardware::message::Clock;
use hardware::settings::Settings;

/// A participant that another program plays.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// Name of the node, `controller_3`.
    pub node: String,
    /// The program and its arguments.
    words: Vec<String>,
    /// The robot, if none of the user's programs but a robot takes the place.
    pub robot: Option<RobotSwap>,
}

/// A robot in the place of a plant.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotSwap {
    /// One that is there already, as its file describes it.
    There(Box<Settings>),
    /// An emulator that is started for the run, with the clock that it keeps.
    Emulated(Clock),
}

impl RobotSwap {
    /// Reads `hardware:FILE`, `emulator` or `emulator:free`; `None` for anything else.
    fn parse(player: &str) -> Option<Result<Self, String>> {
        match player.trim() {
            "emulator" => return Some(Ok(Self::Emulated(Clock::Lockstep))),
            "emulator:free" => return Some(Ok(Self::Emulated(Clock::Wall))),
            _ => {}
        }
        let file = player.trim().strip_prefix("hardware:")?;
        let list = |problems: Vec<Problem>| problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n\n");
        Some(Settings::load(Path::new(file)).map(|settings| Self::There(Box::new(settings))).map_err(list))
    }

    /// Whether time passes for it by itself.
    pub fn is_free(&self) -> bool {
        match self {
            Self::There(settings) => settings.clock == Clock::Wall,
            Self::Emulated(clock) => *clock == Clock::Wall,
        }
    }
}

impl Swap {
    /// Reads `controller.3=./my_controller --gain 2`; `nodes` are the names that there are.
    ///
    /// # Errors
    /// Says what is wrong: no command, no such participant.
    pub fn parse(text: &str, nodes: &[&str]) -> Result<Self, String> {
        let Some((name, command)) = text.split_once('=') else {
            return Err(format!("--swap {text}: expected NODE=COMMAND, such as controller.3=./my_controller"));
        };
        let node = name.trim().replace('.', "_");
        if !nodes.contains(&node.as_str()) {
            let hint = nearest(&node, nodes.iter().copied()).map(|near| format!("; did you mean `{near}`?"));
            let list = nodes.join(", ");
            return Err(format!(
                "--swap {name}: there is no such participant, expected one of {list}{}",
                hint.unwrap_or_default()
            ));
        }
        if let Some(robot) = RobotSwap::parse(command) {
            if node.strip_prefix("plant_").is_none() {
                return Err(format!(
                    "--swap {text}: a robot takes the place of the plant of one agent, such as plant.2"
                ));
            }
            let robot = robot.map_err(|reason| format!("--swap {text}: {reason}"))?;
            return Ok(Self { node, words: Vec::new(), robot: Some(robot) });
        }
        let words = split_words(command).map_err(|reason| format!("--swap {text}: {reason}"))?;
        if words.is_empty() {
            return Err(format!("--swap {text}: the command is empty"));
        }
        Ok(Self { node, words, robot: None })
    }

    /// The agent that a robot is swapped for, from 1; `None` for participants that serve all.
    pub fn agent(&self) -> Option<u32> {
        self.node.rsplit_once('_')?.1.parse().ok()
    }

    /// The command that starts the program.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.words[0]);
        command.args(&self.words[1..]);
        command
    }
}

impl Display for Swap {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.words.join(" "))
    }
}

/// Splits a command into words as a shell does: at spaces, except within quotes.
fn split_words(text: &str) -> Result<Vec<String>, String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote: Option<char> = None;
    for character in text.chars() {
        match (quote, character) {
            (Some(open), _) if open == character => quote = None,
            (None, '"' | '\'') => {
                quote = Some(character);
                word.get_or_insert_default();
            }
            (None, space) if space.is_whitespace() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(character),
        }
    }
    if quote.is_some() {
        return Err("a quotation mark is not closed".into());
    }
    words.extend(word);
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [&str; 3] = ["plant", "controller_1", "controller_2"];

    #[test]
    fn a_node_and_a_command() {
        let swap = Swap::parse("controller.2=python3 'my controller.py' --gain 2", &NODES).unwrap();
        assert_eq!(swap.node, "controller_2");
        assert_eq!(swap.words, ["python3", "my controller.py", "--gain", "2"]);
    }

    #[test]
    fn mistakes_are_named() {
        assert!(Swap::parse("controller.2", &NODES).unwrap_err().contains("NODE=COMMAND"));
        assert!(Swap::parse("controler.2=x", &NODES).unwrap_err().contains("did you mean `controller_2`"));
        assert!(Swap::parse("plant= ", &NODES).unwrap_err().contains("empty"));
        assert!(Swap::parse("plant=emulator", &NODES).unwrap_err().contains("such as plant.2"));
        assert!(Swap::parse("controller.1=emulator", &NODES).unwrap_err().contains("such as plant.2"));
        let error = Swap::parse("plant.2=hardware:nowhere.toml", &["plant_2"]).unwrap_err();
        assert!(error.contains("cannot read nowhere.toml"), "{error}");
        assert!(Swap::parse("plant='x", &NODES).unwrap_err().contains("not closed"));
    }
}
