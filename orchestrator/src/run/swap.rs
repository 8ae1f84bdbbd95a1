//! What plays a participant instead of ours: a program of the user, a log, or a robot.

use std::ffi::OsStr;
use std::fmt::{self, Display, Formatter};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use formation::config::{Problem, did_you_mean};
use formation::scenario::Scenario;
use formation::wiring::{Assembly, EXTERNAL, Role, Swapped};
use hardware::message::Clock;
use hardware::settings::Settings;

use crate::failure::Failure;
use crate::recorded::RecordedSamples;
use crate::terminal::quoted;

/// What stands before the log that a participant is to be played from.
const REPLAY: &str = "replay:";
/// What stands before the file that describes a robot.
const HARDWARE: &str = "hardware:";

/// A participant that something else plays.
#[derive(Clone, Debug, PartialEq)]
pub struct Swap {
    /// Name of the node, `controller_3`.
    pub node: String,
    /// The number of the process that plays it together with others; `None` if it has a process of its own.
    pub(crate) shared: Option<usize>,
    player: Player,
}

/// What plays it.
#[derive(Clone, Debug, PartialEq)]
enum Player {
    /// A program and its arguments, and the folder that it starts in if it is not that of the run.
    Program { words: Vec<String>, folder: Option<PathBuf> },
    /// What was recorded of it.
    Log(PathBuf),
    /// A robot, in the place of the plant of one agent.
    Robot(RobotSwap),
}

/// A robot in the place of a plant.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotSwap {
    /// One that is there already, as its file describes it.
    There {
        /// The file.
        file: PathBuf,
        /// What it says.
        settings: Box<Settings>,
    },
    /// An emulator that is started for the run, with the clock that it keeps.
    Emulated(Clock),
}

impl RobotSwap {
    /// Reads `hardware:FILE` with a file in `folder`, `emulator` or `emulator:free`; `None` for anything else.
    fn parse(player: &str, folder: &Path) -> Option<Result<Self, String>> {
        match player.trim() {
            "emulator" => return Some(Ok(Self::Emulated(Clock::Lockstep))),
            "emulator:free" => return Some(Ok(Self::Emulated(Clock::Wall))),
            _ => {}
        }
        let file = player.trim().strip_prefix(HARDWARE)?;
        let list = |problems: Vec<Problem>| problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n\n");
        let there = |settings| Self::There { file: folder.join(file), settings: Box::new(settings) };
        Some(Settings::load(&folder.join(file)).map(there).map_err(list))
    }

    /// Whether time passes for it by itself.
    pub fn is_free(&self) -> bool {
        match self {
            Self::There { settings, .. } => settings.clock == Clock::Wall,
            Self::Emulated(clock) => *clock == Clock::Wall,
        }
    }
}

impl Swap {
    /// Reads `controller.3=./my_controller --gain 2` or `controller.3=replay:LOG.mcap`; `nodes` are the names that there are.
    ///
    /// # Errors
    /// Says what is wrong: no command, no such participant.
    pub fn parse(text: &str, nodes: &[&str]) -> Result<Self, String> {
        let (name, player) = text.split_once('=').ok_or_else(|| no_command(text))?;
        let node = node_called(name, nodes).map_err(|reason| format!("--swap {name}: {reason}"))?;
        let player = Player::of(&node, player, Path::new("")).map_err(|reason| format!("--swap {text}: {reason}"))?;
        Ok(Self { node, shared: None, player })
    }

    /// All swaps of a run: those of the scenario, and those of the command line, which have the last word.
    ///
    /// # Errors
    /// [`Failure::Usage`] if one of them is not valid, or a log does not fit the run; [`Failure::Log`] if it cannot be read.
    pub fn collect(assembly: &Assembly, texts: &[String]) -> Result<Vec<Self>, Failure> {
        let names: Vec<&str> = assembly.network.nodes.iter().map(|node| node.name.as_str()).collect();
        let mut swaps = Self::of_command_line(assembly, texts)?;
        for swap in Self::of_file(assembly)? {
            if swaps.iter().all(|other| other.node != swap.node) {
                swaps.push(swap);
            }
        }
        if let Some(reason) = swaps.iter().find_map(Self::unusable) {
            return Err(Failure::Usage(format!("{reason}; nothing was started")));
        }
        for log in swaps.iter().filter_map(Self::log) {
            let is_played = |node: &&str| swaps.iter().any(|swap| swap.node == **node && swap.log() == Some(log));
            let nodes = (0..names.len()).filter(|&node| is_played(&names[node])).collect::<Vec<_>>();
            // Opened here only to say what is wrong with it before anything starts.
            RecordedSamples::open(log, &assembly.scenario, &assembly.network, &nodes)?;
        }
        Ok(swaps)
    }

    /// What `--swap` says, by participant.
    fn of_command_line(assembly: &Assembly, texts: &[String]) -> Result<Vec<Self>, Failure> {
        let split = |text: &'_ String| -> Result<(String, String), Failure> {
            let (name, player) = text.split_once('=').ok_or_else(|| Failure::Usage(no_command(text)))?;
            Ok((name.trim().into(), player.into()))
        };
        let entries = texts.iter().map(split).collect::<Result<Vec<_>, _>>()?;
        let names: Vec<&str> = entries.iter().map(|(name, _)| name.as_str()).collect();
        let places = assembly.swapped(&names);
        let places = places.map_err(|(name, reason)| Failure::Usage(format!("--swap {}: {reason}", names[name])))?;
        let swap = |place: &Swapped| -> Result<Self, Failure> {
            let node = assembly.network.nodes[place.node].name.clone();
            let player = Player::of(&node, &entries[place.name].1, Path::new(""));
            let player = player.map_err(|reason| Failure::Usage(format!("--swap {}: {reason}", texts[place.name])))?;
            Ok(Self { node, shared: place.together.then_some(place.name), player })
        };
        places.iter().map(swap).collect()
    }

    /// What `[swap]` of the scenario file says, by participant.
    fn of_file(assembly: &Assembly) -> Result<Vec<Self>, Failure> {
        let scenario = &assembly.scenario;
        let names: Vec<&str> = scenario.swaps.iter().map(|(name, _)| name.as_str()).collect();
        let places = assembly.swapped(&names);
        let places =
            places.map_err(|(name, reason)| vec![scenario.problem("swap", format!("{}: {reason}", names[name]))])?;
        let swap = |place: &Swapped| -> Result<Self, Failure> {
            let swap =
                Self::of_scenario(scenario, &assembly.network.nodes[place.node].name, &scenario.swaps[place.name].1)?;
            // Numbers that no entry of the command line has.
            let shared = place.together.then_some(usize::MAX - place.name);
            Ok(Self { shared, ..swap })
        };
        places.iter().map(swap).collect()
    }

    /// What `[swap]` of a scenario file says; paths start from the folder of the file.
    fn of_scenario(scenario: &Scenario, node: &str, player: &str) -> Result<Self, Failure> {
        let is_elsewhere = scenario.folder.as_deref().is_some_and(|folder| !folder.as_os_str().is_empty());
        let folder = is_elsewhere.then(|| folder_of(scenario)).transpose()?;
        let player = Player::of(node, player, folder.as_deref().unwrap_or(Path::new("")));
        let player = player.map_err(|reason| vec![scenario.problem("swap", format!("{node}: {reason}"))])?;
        let swap = Self { node: node.into(), shared: None, player };
        Ok(folder.into_iter().fold(swap, |swap, folder| swap.meant_in(&folder)))
    }

    /// Why its program cannot be started, if it is named by a path. What the search path holds is left to the system.
    fn unusable(&self) -> Option<String> {
        let Player::Program { words, folder } = &self.player else { return None };
        let reason = program_problem(words.first()?, folder.as_deref().unwrap_or(Path::new("")))?;
        let place = folder.as_ref().map_or_else(String::new, |folder| {
            format!("; paths in `[swap]` start from the folder of the scenario file, {}", folder.display())
        });
        Some(format!("{}: {reason}{place}", self.node))
    }

    /// The same as it is meant in `folder`, which may be another one than that of the run.
    pub(crate) fn meant_in(mut self, folder: &Path) -> Self {
        match &mut self.player {
            Player::Program { words, folder: place } => {
                // Not the file that a link leads to: a Python in a virtual environment is such a link.
                if words[0].contains('/') {
                    words[0] = folder.join(&words[0]).display().to_string();
                }
                *place = Some(folder.into());
            }
            Player::Log(path) => *path = folder.join(&path),
            Player::Robot(_) => {}
        }
        self
    }

    /// The log that it is played from, if it is.
    pub fn log(&self) -> Option<&Path> {
        match &self.player {
            Player::Log(path) => Some(path),
            Player::Program { .. } | Player::Robot(_) => None,
        }
    }

    /// Files that it reads: the recording, the description of a robot, a program and arguments that are files.
    pub(crate) fn inputs(&self) -> Vec<PathBuf> {
        match &self.player {
            Player::Log(path) => vec![path.clone()],
            Player::Robot(RobotSwap::There { file, .. }) => vec![file.clone()],
            Player::Robot(RobotSwap::Emulated(_)) => Vec::new(),
            Player::Program { words, folder } => {
                let folder = folder.as_deref().unwrap_or(Path::new(""));
                words.iter().map(|word| folder.join(word)).filter(|path| path.is_file()).collect()
            }
        }
    }

    /// The folder that its program starts in, if it is not that of the run.
    pub(crate) fn folder(&self) -> Option<&Path> {
        match &self.player {
            Player::Program { folder, .. } => folder.as_deref(),
            Player::Log(_) | Player::Robot(_) => None,
        }
    }

    /// What stands behind `NODE=` to have the same again.
    pub(crate) fn text(&self) -> String {
        match &self.player {
            Player::Program { words, .. } => words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" "),
            Player::Log(path) => format!("{REPLAY}{}", path.display()),
            Player::Robot(RobotSwap::There { file, .. }) => format!("{HARDWARE}{}", file.display()),
            Player::Robot(RobotSwap::Emulated(Clock::Lockstep)) => "emulator".into(),
            Player::Robot(RobotSwap::Emulated(Clock::Wall)) => "emulator:free".into(),
        }
    }

    /// The files that it consists of, as they are called and where they are: a program and those of its arguments that are files, a
    /// log, the description of a robot.
    pub(crate) fn files(&self) -> Vec<(String, PathBuf)> {
        let at = |path: &Path| (path.display().to_string(), path.to_path_buf());
        match &self.player {
            Player::Program { words, folder } => {
                let place = |word: &str| folder.as_deref().unwrap_or(Path::new("")).join(word);
                let program = match words[0].contains('/') {
                    true => Some(place(&words[0])),
                    false => on_search_path(&words[0]),
                };
                let program = program.map(|path| (words[0].clone(), path));
                let arguments = words[1..].iter().map(|word| (word.clone(), place(word)));
                program.into_iter().chain(arguments.filter(|(_, path)| path.is_file())).collect()
            }
            Player::Log(path) => vec![at(path)],
            Player::Robot(RobotSwap::There { file, .. }) => vec![at(file)],
            Player::Robot(RobotSwap::Emulated(_)) => Vec::new(),
        }
    }

    /// The robot that takes its place, if one does.
    pub fn robot(&self) -> Option<&RobotSwap> {
        match &self.player {
            Player::Robot(robot) => Some(robot),
            Player::Program { .. } | Player::Log(_) => None,
        }
    }

    /// The agent that a robot is swapped for, from 1; `None` for participants that serve all.
    pub fn agent(&self) -> Option<u32> {
        self.node.rsplit_once('_')?.1.parse().ok()
    }

    /// The command that starts the process; `program` is this program. `None` for a robot, which is there already.
    pub fn command(&self, program: &Path) -> Option<Command> {
        Some(match &self.player {
            Player::Program { words, folder } => {
                let mut command = Command::new(&words[0]);
                command.args(&words[1..]);
                folder.iter().for_each(|folder| {
                    command.current_dir(folder);
                });
                command
            }
            Player::Log(path) => recording_command(program, path, 1.0),
            Player::Robot(_) => return None,
        })
    }
}

fn no_command(text: &str) -> String {
    format!("--swap {text}: expected NODE=COMMAND or NODE=replay:LOG.mcap, such as controller.3=./my_controller")
}

impl Player {
    /// What `text` means for `node`; the file of a robot is one in `folder`.
    fn of(node: &str, text: &str, folder: &Path) -> Result<Self, String> {
        if let Some(robot) = RobotSwap::parse(text, folder) {
            let agent = node.strip_prefix("plant_").filter(|agent| agent.parse::<u32>().is_ok());
            if agent.is_none() {
                return Err("a robot takes the place of the plant of one agent, such as plant.2".into());
            }
            return Ok(Self::Robot(robot?));
        }
        if let Some(path) = text.trim().strip_prefix(REPLAY) {
            let path = path.trim();
            return if path.is_empty() {
                Err("name the log, replay:LOG.mcap".into())
            } else {
                Ok(Self::Log(path.into()))
            };
        }
        let words = shlex::split(text).ok_or("a quotation mark is not closed, or nothing follows a backslash")?;
        if words.is_empty() {
            return Err("the command is empty".into());
        }
        Ok(Self::Program { words, folder: None })
    }
}

/// Why a program cannot be started that is named by a path in `folder`; `None` if nothing is wrong, or it is no path.
pub(crate) fn program_problem(program: &str, folder: &Path) -> Option<String> {
    let path = folder.join(program);
    if !program.contains('/') {
        return None;
    }
    let Ok(found) = path.metadata() else { return Some(format!("there is no program {program}")) };
    if found.is_dir() {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let built = [format!("target/release/{name}"), format!("build/{name}"), "main.py".to_string()];
        let hint = match built.iter().find(|file| path.join(file).is_file()) {
            Some(file) if file.ends_with(".py") => format!("the program in it is `python3 {program}/{file}`"),
            Some(file) => format!("the program in it is {program}/{file}"),
            None => format!(
                "build the project in it, and name the program: {program}/{} or {program}/{}",
                built[0], built[1]
            ),
        };
        return Some(format!("{program} is a folder, not a program; {hint}"));
    }
    let executable = found.permissions().mode() & 0o111 != 0;
    (!executable).then(|| {
        format!(
            "{program} is not executable: `chmod +x {program}`, or start it with its interpreter, `python3 {program}`"
        )
    })
}

/// Where the search path has a program; `None` if it has none.
fn on_search_path(program: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(program)).find(|path| path.is_file())
}

/// Whether something plays every participant whose kind is `external`.
///
/// # Errors
/// [`Failure::Invalid`] that says what to add.
pub(crate) fn check_played(assembly: &Assembly, swaps: &[Swap]) -> Result<(), Failure> {
    let is_played = |node: &str| swaps.iter().any(|swap| swap.node == node);
    let mut problems = Vec::new();
    for role in Role::ALL.into_iter().filter(|role| assembly.is_external(*role)) {
        let nodes = assembly.network.nodes.iter().zip(&assembly.nodes).filter(|(_, place)| place.role == role);
        let (played, idle): (Vec<&str>, Vec<&str>) =
            nodes.map(|(node, _)| node.name.as_str()).partition(|&node| is_played(node));
        let names = match idle.as_slice() {
            [] => continue,
            [first, .., last] if played.is_empty() => format!("{first} to {last}"),
            several => several.join(", "),
        };
        let key = match idle.as_slice() {
            [only] => only.replace('_', "."),
            _ => format!("{role}.*"),
        };
        let message = format!("the kind `{EXTERNAL}` has no law, and nothing plays {names}");
        let help = format!(
            "add --swap \"{key}=python3 my_{role}.py\", or this line to the section [swap] of the file: \
             \"{key}\" = \"python3 my_{role}.py\""
        );
        problems.push(assembly.scenario.problem(&format!("{role}.kind"), message).with_help(help));
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.into()) }
}

/// The folder that paths of a scenario start from; absolute.
///
/// # Errors
/// [`Failure::System`] if the current folder, which stands in for that of a scenario without a file, is not known.
pub(crate) fn folder_of(scenario: &Scenario) -> Result<PathBuf, Failure> {
    let folder = scenario.folder.as_deref().filter(|folder| !folder.as_os_str().is_empty());
    std::path::absolute(folder.unwrap_or(Path::new("."))).map_err(Failure::system("find the current folder"))
}

/// The node that a user calls `controller.3` or `controller_3`.
///
/// # Errors
/// The error for an unknown name, with the known ones.
pub fn node_called(name: &str, nodes: &[&str]) -> Result<String, String> {
    let node = name.trim().replace('.', "_");
    if nodes.contains(&node.as_str()) {
        return Ok(node);
    }
    let hint = did_you_mean(&node, nodes.iter().copied());
    let list = nodes.join(", ");
    Err(format!("there is no such participant, expected one of {list}{hint}"))
}

/// The command of a process of `program`, which is this one, that plays its participants from `log`, their numbers multiplied
/// by `factor`.
pub fn recording_command(program: &Path, log: &Path, factor: f64) -> Command {
    let mut command = Command::new(program);
    command.args([OsStr::new("participant"), OsStr::new("--replay"), log.as_os_str()]);
    command.arg("--factor").arg(factor.to_string());
    command
}

/// This program.
///
/// # Errors
/// [`Failure::System`] if the operating system does not tell.
pub fn own_program() -> Result<PathBuf, Failure> {
    std::env::current_exe().map_err(Failure::system("find this program"))
}

impl Display for Swap {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.player {
            Player::Program { words, .. } => write!(f, "{}", words.join(" ")),
            Player::Log(path) => write!(f, "{REPLAY}{}", path.display()),
            Player::Robot(RobotSwap::There { settings, .. }) => write!(f, "the robot at {}", settings.robot),
            Player::Robot(RobotSwap::Emulated(_)) => write!(f, "an emulator"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [&str; 3] = ["plant", "controller_1", "controller_2"];

    #[test]
    fn a_node_and_a_command() {
        let swap = Swap::parse("controller.2=python3 'my controller.py' --gain 2", &NODES).unwrap();
        assert_eq!(swap.node, "controller_2");
        let words = ["python3", "my controller.py", "--gain", "2"].map(String::from);
        assert_eq!(swap.player, Player::Program { words: words.to_vec(), folder: None });
        assert_eq!(swap.log(), None);
    }

    #[test]
    fn the_text_of_a_command_gives_it_back() {
        let words = ["python3", "my controller.py", "--gain=2", "it's", "", "\"x\""].map(String::from);
        let player = Player::Program { words: words.to_vec(), folder: None };
        let swap = Swap { node: "plant".into(), shared: None, player };
        let again = Swap::parse(&format!("plant={}", swap.text()), &NODES).unwrap();
        assert_eq!(again, swap);
    }

    #[test]
    fn a_node_and_a_log() {
        for text in ["controller.2=replay:runs/a b.mcap", "controller_2= replay: runs/a b.mcap"] {
            let swap = Swap::parse(text, &NODES).unwrap();
            assert_eq!((swap.node.as_str(), swap.log()), ("controller_2", Some(Path::new("runs/a b.mcap"))));
        }
        assert!(Swap::parse("plant=replay:", &NODES).unwrap_err().contains("replay:LOG.mcap"));
    }

    #[test]
    fn names_of_files_are_meant_in_a_folder() {
        let meant = |text: &str| Swap::parse(text, &NODES).unwrap().meant_in(Path::new("/home/me")).to_string();
        assert_eq!(meant("plant=./mine --log a/b"), "/home/me/./mine --log a/b");
        assert_eq!(meant("plant=python3 mine.py"), "python3 mine.py");
        assert_eq!(meant("plant=/opt/mine"), "/opt/mine");
        assert_eq!(meant("plant=replay:runs/a.mcap"), "replay:/home/me/runs/a.mcap");
        let swap = Swap::parse("plant=python3 mine.py", &NODES).unwrap().meant_in(Path::new("/home/me"));
        let command = swap.command(Path::new("phalanx")).unwrap();
        assert_eq!(command.get_current_dir(), Some(Path::new("/home/me")));
    }

    #[test]
    fn mistakes_are_named() {
        assert!(Swap::parse("controller.2", &NODES).unwrap_err().contains("NODE=COMMAND"));
        assert!(Swap::parse("controler.2=x", &NODES).unwrap_err().contains("did you mean `controller_2`"));
        assert!(Swap::parse("plant= ", &NODES).unwrap_err().contains("empty"));
        assert!(Swap::parse("plant='x", &NODES).unwrap_err().contains("not closed"));
    }
}
