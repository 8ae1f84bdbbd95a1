//! What played the participants of a run that were not played by Phalanx itself: for its log, and from it.
//!
//! A log says so in a metadata record for every such participant, and for every change during the run. The log of a run that
//! Phalanx played alone has none.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use serde_json::{Value, json};

use crate::run::swap::{RobotSwap, Swap};
use crate::terminal::plain;
use recording::file_digest;

/// Larger files beside the program are named without a digest, bytes.
const HASHED_MAX: u64 = 1 << 30;
/// Fields of the record.
const PARTICIPANT: &str = "participant";
const KIND: &str = "kind";
const COMMAND: &str = "command";
const FOLDER: &str = "folder";
const FROM_STEP: &str = "from_step";

/// What played a participant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Player {
    /// The participant, `controller_3`.
    pub participant: String,
    /// The first step that it computed.
    pub from_step: u64,
    /// `program`, `replay`, `robot` or `emulator`.
    pub kind: String,
    /// What stands behind `NODE=` of `--swap` to have it again.
    pub command: String,
    /// The folder in which a program was started; empty if it is that of the run.
    pub folder: String,
    /// Its files: a program and those of its arguments that are files, a log, the description of a robot; with their SHA-256, which
    /// is empty of files that could not be read.
    pub files: Vec<(String, String)>,
}

impl Player {
    /// What a swap puts in the place of a participant from a step on; `None` for an emulator that keeps the time of the run, which
    /// is what Phalanx itself computes in one process.
    pub(crate) fn of(swap: &Swap, from_step: u64) -> Option<Self> {
        let kind = match swap.robot() {
            Some(robot @ RobotSwap::Emulated(_)) if !robot.is_free() => return None,
            Some(RobotSwap::Emulated(_)) => "emulator",
            Some(RobotSwap::There { .. }) => "robot",
            None if swap.log().is_some() => "replay",
            None => "program",
        };
        let folder = swap.folder().map_or(String::new(), |folder| folder.display().to_string());
        let files = swap.files().into_iter().map(|(name, path)| (name, digest(&path))).collect();
        let (participant, kind, command) = (swap.node.clone(), kind.into(), swap.text());
        Some(Self { participant, from_step, kind, command, folder, files })
    }

    /// All that play from the start.
    pub(crate) fn all(swaps: &[Swap]) -> Vec<Self> {
        swaps.iter().filter_map(|swap| Self::of(swap, 0)).collect()
    }

    /// A participant that is played from a log, as that of `replay`.
    pub(crate) fn from_log(participant: &str, log: &Path) -> Self {
        let name = log.display().to_string();
        let files = vec![(name.clone(), digest(log))];
        let (participant, kind, command) = (participant.into(), "replay".into(), format!("replay:{name}"));
        Self { participant, kind, command, files, ..Self::default() }
    }

    /// The record of a log.
    pub(crate) fn to_metadata(&self) -> BTreeMap<String, String> {
        let mut fields = BTreeMap::from([
            (PARTICIPANT.to_string(), self.participant.clone()),
            (KIND.to_string(), self.kind.clone()),
            (COMMAND.to_string(), self.command.clone()),
            (FROM_STEP.to_string(), self.from_step.to_string()),
        ]);
        if !self.folder.is_empty() {
            fields.insert(FOLDER.into(), self.folder.clone());
        }
        for (number, (file, digest)) in (1..).zip(&self.files) {
            fields.insert(format!("file.{number}"), file.clone());
            fields.insert(format!("sha256.{number}"), digest.clone());
        }
        fields
    }

    /// What a record of a log says; what it lacks is empty.
    pub(crate) fn read(fields: &BTreeMap<String, String>) -> Self {
        let text = |name: &str| fields.get(name).cloned().unwrap_or_default();
        let file =
            |number: usize| Some((fields.get(&format!("file.{number}"))?.clone(), text(&format!("sha256.{number}"))));
        Self {
            participant: text(PARTICIPANT),
            from_step: text(FROM_STEP).parse().unwrap_or_default(),
            kind: text(KIND),
            command: text(COMMAND),
            folder: text(FOLDER),
            files: (1..).map_while(file).collect(),
        }
    }

    /// What played, in words, without the participant: `` `python3 mine.py` (mine.py sha256 0123456789abcdef) from step 0 on``.
    pub fn what(&self) -> String {
        let files: Vec<String> = self
            .files
            .iter()
            .map(|(file, digest)| {
                let name = Path::new(file).file_name().map_or(file.as_str().into(), |name| name.to_string_lossy());
                let digest = if digest.is_empty() { "not read" } else { digest.get(..16).unwrap_or(digest) };
                format!("{} sha256 {}", plain(&name), plain(digest))
            })
            .collect();
        let files = if files.is_empty() { String::new() } else { format!(" ({})", files.join(", ")) };
        format!("`{}`{files} from step {} on", plain(&self.command), self.from_step)
    }

    /// The whole, in a sentence without its full stop.
    pub fn sentence(&self) -> String {
        format!("{} is played by {}", plain(&self.participant), self.what())
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let files: Vec<Value> = self
            .files
            .iter()
            .map(|(file, digest)| json!({ "file": file, "sha256": Some(digest).filter(|digest| !digest.is_empty()) }))
            .collect();
        json!({
            "participant": self.participant, "from_step": self.from_step, "kind": self.kind, "command": self.command,
            "folder": Some(&self.folder).filter(|folder| !folder.is_empty()), "files": files,
        })
    }
}

/// What played in one list and in another one, as far as that differs; `None` if it does not.
pub(crate) fn difference(first: &[Player], second: &[Player]) -> Option<String> {
    let names = first.iter().chain(second).map(|player| player.participant.as_str());
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    let of = |players: &[Player], name: &str| {
        let all: Vec<String> = players.iter().filter(|player| player.participant == name).map(Player::what).collect();
        if all.is_empty() { "Phalanx itself".to_string() } else { all.join(", then ") }
    };
    let sides = names.into_iter().map(|name| (name, of(first, name), of(second, name)));
    let differing: Vec<String> = sides
        .filter(|(_, first, second)| first != second)
        .map(|(name, first, second)| {
            format!("{} is played by {first} in the first log, by {second} in the second", plain(name))
        })
        .collect();
    (!differing.is_empty()).then(|| differing.join("; "))
}

/// The SHA-256 of a file; empty if it cannot be read, or is too large to be read on the way.
fn digest(path: &Path) -> String {
    let is_file = |path: &Path| std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() <= HASHED_MAX);
    let read = |path: &Path| -> io::Result<String> { file_digest(path) };
    if is_file(path) { read(path).unwrap_or_default() } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn player(participant: &str, command: &str) -> Player {
        let files = vec![("mine.py".to_string(), "ab".repeat(32)), ("gone".to_string(), String::new())];
        Player {
            participant: participant.into(),
            from_step: 7,
            kind: "program".into(),
            command: command.into(),
            folder: "/home/me".into(),
            files,
        }
    }

    #[test]
    fn a_record_gives_the_player_back() {
        let one = player("controller_3", "python3 mine.py");
        assert_eq!(Player::read(&one.to_metadata()), one);
        assert_eq!(Player::read(&BTreeMap::new()), Player::default());
        let text = one.sentence();
        assert_eq!(
            text,
            "controller_3 is played by `python3 mine.py` (mine.py sha256 abababababababab, gone sha256 not read) from step 7 on"
        );
    }

    #[test]
    fn casts_differ_by_participant() {
        let [a, b] = ["./a", "./b"].map(|command| player("plant", command));
        assert_eq!(difference(std::slice::from_ref(&a), std::slice::from_ref(&a)), None);
        let text = difference(std::slice::from_ref(&a), &[b]).unwrap();
        assert!(text.starts_with("plant is played by `./a`") && text.contains("by `./b`"), "{text}");
        assert!(difference(&[a], &[]).unwrap().ends_with("by Phalanx itself in the second"));
    }
}
