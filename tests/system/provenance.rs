//! What played a participant is in the log, and everything that reads one says so.

use serde_json::Value;

use crate::program::Folder;

/// A shell script that plays a recording: a program like any other to the orchestrator.
fn script(folder: &Folder, comment: &str) {
    let program = env!("CARGO_BIN_EXE_phalanx");
    folder.write("play.sh", &format!("# {comment}\nexec {program} participant --replay \"$1\"\n"));
}

fn sha256(folder: &Folder, file: &str) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(std::fs::read(folder.path(file)).expect("a file")).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn a_log_says_what_played_and_replay_asks_for_it() {
    let folder = Folder::new();
    let run = ["run", "uav", "--duration", "0.5", "-q", "--json", "--set", "metrics="];
    assert_eq!(folder.run(&[&run[..], &["--out", "plain.mcap"]].concat()).json()["players"], Value::Array(Vec::new()));
    script(&folder, "first");
    let swap = "controller.3=sh play.sh plain.mcap";
    let json = folder.run(&[&run[..], &["--swap", swap]].concat()).json();
    let log = json["log"].as_str().expect("a log");
    let named = log.starts_with("runs/uav-TSC-") && log.ends_with("+controller_3.mcap");
    assert!(named, "the name says that there are overrides, and which participant was swapped: {log}");
    let player = &json["players"][0];
    assert_eq!((&player["participant"], &player["kind"]), (&"controller_3".into(), &"program".into()), "{player}");
    assert_eq!((&player["command"], &player["from_step"]), (&"sh play.sh plain.mcap".into(), &0.into()), "{player}");
    let files = player["files"].as_array().expect("files");
    assert_eq!(files[1]["file"], "play.sh");
    for (file, name) in [(&files[1], "play.sh"), (&files[2], "plain.mcap")] {
        assert_eq!(file["sha256"], sha256(&folder, name).as_str());
    }
    assert_eq!(folder.run(&["info", log, "--json"]).json()["players"], json["players"]);
    assert_eq!(folder.run(&["check", log, "--json"]).json()["players"], json["players"]);
    assert!(folder.run(&["info", log]).stdout().contains("controller_3  by `sh play.sh plain.mcap` (sh sha256 "));
    assert_eq!(folder.run(&["report", log, "--out", "report.html"]).code(), 0);
    let page = std::fs::read_to_string(folder.path("report.html")).expect("a report");
    assert!(page.contains("controller_3 is played by `sh play.sh plain.mcap`"));
    let verify = folder.run(&["verify", "plain.mcap", log]);
    let expected = "only the cast differs: controller_3 is played by Phalanx itself in the first log, by `sh play.sh";
    assert!(verify.code() == 0 && verify.stdout().contains(expected), "{}", verify.stdout());

    let replay = |more: &[&str]| folder.run(&[&["replay", log, "--only", "controller.3"], more].concat());
    let asks = replay(&[]);
    assert_eq!(asks.code(), 2, "{}", asks.stdout());
    assert!(asks.stderr().contains("--swap 'controller_3=sh play.sh plain.mcap'"), "{}", asks.stderr());
    assert!(asks.stderr().contains("--swap controller_3=builtin"), "{}", asks.stderr());
    assert_eq!(folder.run(&["replay", log, "--only", "controller.2"]).code(), 0, "that one is ours");
    assert_eq!(replay(&["--swap", "controller.3=builtin"]).code(), 0);
    let same = replay(&["--swap", swap, "--out", "again.mcap"]);
    assert!(same.code() == 0 && !same.stderr().contains("note:"), "{}", same.stderr());
    let players = folder.run(&["info", "again.mcap", "--json"]).json()["players"].clone();
    assert_eq!(players[0]["participant"], "controller_3", "{players}");
    assert_eq!(players[1]["command"], format!("replay:{log}"), "the others were played from the log: {players}");
    script(&folder, "second");
    let changed = replay(&["--swap", swap]);
    assert!(changed.code() == 0 && changed.stderr().contains("is the play.sh (sha256 "), "{}", changed.stderr());
}

#[test]
fn a_scenario_with_programs_is_verified_in_processes() {
    let folder = Folder::new();
    let text = folder.run(&["validate", "uav", "--duration", "0.1", "--print"]).stdout();
    folder.run(&["run", "uav", "--duration", "0.1", "-q", "--set", "metrics=", "--out", "plain.mcap"]);
    folder.write("swapped.toml", &format!("{text}\n[swap]\n\"controller.3\" = \"replay:plain.mcap\"\n"));
    let verify = folder.run(&["verify", "--scenario", "swapped.toml"]);
    assert_eq!(verify.code(), 0, "{}{}", verify.stdout(), verify.stderr());
    assert!(verify.stdout().starts_with("processes ") && !verify.stdout().contains("single"), "{}", verify.stdout());
    folder.write("robot.toml", &format!("{text}\n[swap]\n\"plant.2\" = \"emulator:free\"\n"));
    let refused = folder.run(&["verify", "--scenario", "robot.toml", "--set", "plant.per_agent=true"]);
    assert_eq!(refused.code(), 2, "{}", refused.stdout());
}

#[test]
fn nothing_is_equal_to_nothing() {
    let folder = Folder::new();
    let run =
        ["run", "uav", "--duration", "0.1", "-q", "--placement", "single", "--set", "metrics=", "--out", "a.mcap"];
    folder.run(&run);
    let bytes = std::fs::read(folder.path("a.mcap")).expect("a log");
    // The definitions, and no sample: as after a kill before the first chunk.
    let first_chunk = first_record(&bytes, 6);
    std::fs::write(folder.path("cut.mcap"), &bytes[..first_chunk]).expect("written");
    assert_eq!(folder.run(&["recover", "cut.mcap", "--out", "empty.mcap"]).code(), 0);
    for log in ["cut.mcap", "empty.mcap"] {
        let verify = folder.run(&["verify", log, log]);
        assert!(verify.code() == 2 && verify.stderr().contains("holds no complete step"), "{}", verify.stderr());
        let replay = folder.run(&["replay", log, "--only", "controller.3"]);
        assert!(replay.code() == 2 && replay.stderr().contains("holds no complete step"), "{}", replay.stderr());
    }
}

/// Where the first record of this kind begins.
fn first_record(bytes: &[u8], opcode: u8) -> usize {
    let mut at = 8;
    while bytes[at] != opcode {
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes")) as usize;
    }
    at
}

#[test]
fn names_in_a_log_do_not_command_the_terminal() {
    let folder = Folder::new();
    let file = std::fs::File::create(folder.path("hostile.mcap")).expect("a file");
    let mut writer = mcap::Writer::new(file).expect("a log");
    let text = [("scenario", "\u{1b}]0;owned\u{7}"), ("\u{1b}[2J", "x\nfile complete")];
    let metadata = text.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    writer.write_metadata(&mcap::records::Metadata { name: "phalanx".into(), metadata }).expect("written");
    let player = [("participant", "plant\u{9b}31m"), ("command", "\u{202e}sh\r")];
    let metadata = player.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    writer.write_metadata(&mcap::records::Metadata { name: "phalanx-player".into(), metadata }).expect("written");
    writer.add_channel(0, "/\u{1b}[31mred", "json", &Default::default()).expect("a channel");
    let channel = writer.add_channel(0, "/b\u{7f}", "json", &Default::default()).expect("a channel");
    let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    writer.write_to_known_channel(&header, b"{}").expect("written");
    writer.finish().expect("closed");
    for arguments in [
        &["info", "hostile.mcap"][..],
        &["info", "hostile.mcap", "--json"],
        &["verify", "hostile.mcap", "hostile.mcap"],
        &["replay", "hostile.mcap", "--only", "plant"],
        &["echo", "hostile.mcap", "/*"],
        &["check", "hostile.mcap"],
        &["report", "hostile.mcap"],
    ] {
        let run = folder.run(arguments);
        let all = format!("{}{}", run.stdout(), run.stderr());
        let unseen = |letter: char| letter.is_control() && letter != '\n' || letter == '\u{202e}';
        assert!(!all.is_empty() && !all.contains(unseen), "{arguments:?}: {all:?}");
    }
}
