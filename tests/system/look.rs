//! What is made of a log: reports, exports, values and drawings in the terminal.

use std::process::Command;

use recording::Log;
use serde_json::Value;

use crate::program::{Finished, Folder};

/// A folder with the log `run.mcap` of two seconds.
pub(crate) fn short_run(scenario: &str) -> Folder {
    let folder = Folder::new();
    let run = folder.run(&["run", scenario, "--duration", "2", "--placement", "single", "-q", "--out", "run.mcap"]);
    // The ranges are those of the whole run, so some are missed; that is another test's business.
    assert!(run.code() <= 1, "{}", run.stderr());
    folder
}

pub(crate) fn succeeds(folder: &Folder, arguments: &[&str]) -> Finished {
    let finished = folder.run(arguments);
    assert_eq!(finished.code(), 0, "{arguments:?}: {}", finished.stderr());
    finished
}

/// The data inside a report, and the report.
fn report(folder: &Folder, arguments: &[&str], file: &str) -> (Value, String) {
    succeeds(folder, arguments);
    let html = std::fs::read_to_string(folder.path(file)).expect("the report");
    let start = html.find("id=\"runs\">").expect("the data") + "id=\"runs\">".len();
    let length = html[start..].find("</script>").expect("the end of the data");
    (serde_json::from_str(&html[start..start + length]).expect("JSON"), html)
}

fn panels(run: &Value) -> Vec<&str> {
    let panels = run["panels"].as_array().expect("panels");
    panels.iter().map(|panel| panel["id"].as_str().expect("a name")).collect()
}

#[test]
fn the_report_of_a_whole_run_is_one_small_file() {
    let folder = Folder::new();
    assert_eq!(folder.run(&["run", "uav", "--placement", "single", "-q", "--out", "run.mcap"]).code(), 0);
    let (data, html) = report(&folder, &["report", "run.mcap"], "run.html");
    assert!(html.len() < 5_000_000, "{} bytes", html.len());
    for word in ["http:", "https:", "src="] {
        assert!(!html.contains(word), "{word}: a report must ask nothing of a network");
    }
    let run = &data["runs"][0];
    assert_eq!((run["scenario"].as_str(), run["variant"].as_str()), (Some("uav"), Some("TSC")));
    assert_eq!((run["samples"].as_u64(), run["scene"]["planar"].as_bool()), (Some(8001), Some(false)));
    assert!(run["metrics"].as_array().expect("metrics").iter().all(|metric| metric["in_range"] != false));
    assert_eq!(run["scene"]["links"].as_array().map(Vec::len), Some(8));
    let expected = [
        "tracking-errors",
        "distances",
        "inputs",
        "estimates",
        "sliding-variables",
        "network-weights",
        "other-signals",
    ];
    assert_eq!(panels(run), expected);
    // Base64 of the floats 0 ... 80: 2000 points, the last one whole.
    let time = run["time"].as_str().expect("times");
    assert_eq!(time.len(), (2000 * 4_usize).div_ceil(3) * 4);
    // The same log gives the same report.
    succeeds(&folder, &["report", "run.mcap", "--out", "again.html"]);
    assert_eq!(std::fs::read(folder.path("again.html")).expect("the report"), html.as_bytes());
}

#[test]
fn every_scenario_has_a_report_and_figures() {
    let folder = Folder::new();
    let list = succeeds(&folder, &["list", "--json"]).json();
    let names: Vec<&str> = list["scenarios"]
        .as_array()
        .or(list.as_array())
        .expect("scenarios")
        .iter()
        .filter_map(|s| s["name"].as_str())
        .collect();
    assert!(names.contains(&"uav") && names.contains(&"rca"), "{names:?}");
    for name in names {
        let folder = short_run(name);
        let (data, _) = report(&folder, &["report", "run.mcap"], "run.html");
        let run = &data["runs"][0];
        assert_eq!(run["caveats"].as_array().map(Vec::len), Some(0), "{name}: {}", run["caveats"]);
        let found = panels(run);
        assert_eq!((found[0], found[1]), ("tracking-errors", "distances"), "{name}");
        assert!(found.contains(&"inputs"), "{name}: {found:?}");
        assert_eq!(found.contains(&"obstacles"), name == "rca", "{name}: {found:?}");
        let flagged = ["rca", "compensated-experiment"].contains(&name);
        assert_eq!(found.contains(&"flags"), flagged, "{name}: {found:?}");
        assert_eq!(found.contains(&"links"), name == "limited-information", "{name}: {found:?}");
        let written = succeeds(&folder, &["report", "run.mcap", "--figures", "figures"]).stdout();
        assert!(written.contains("-tracking-errors.svg") && written.contains("-trajectories.svg"), "{written}");
    }
}

#[test]
fn runs_are_compared_by_what_differs() {
    let folder = short_run("uav");
    let toc = ["run", "uav", "--variant", "TOC", "--duration", "2", "--placement", "single", "-q", "--out", "toc.mcap"];
    folder.run(&toc);
    let (data, _) = report(&folder, &["report", "run.mcap", "toc.mcap"], "comparison.html");
    let names: Vec<&str> =
        data["runs"].as_array().expect("runs").iter().filter_map(|run| run["name"].as_str()).collect();
    assert_eq!(names, ["TSC timing.duration=2", "TOC timing.duration=2"]);
}

#[test]
fn a_scenario_cannot_break_out_of_its_report() {
    let folder = Folder::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/uav.toml");
    let text = std::fs::read_to_string(shipped).expect("the scenario");
    let title = "title = \"</script><script>alert(1)</script>\"";
    let text: String =
        text.lines().map(|line| if line.starts_with("title = ") { title } else { line }).collect::<Vec<_>>().join("\n");
    folder.write("mine.toml", &text);
    folder.run(&["run", "mine.toml", "--duration", "1", "--placement", "single", "-q", "--out", "run.mcap"]);
    let (data, html) = report(&folder, &["report", "run.mcap"], "run.html");
    assert_eq!(data["runs"][0]["title"], "</script><script>alert(1)</script>");
    // The data and the program.
    assert_eq!(html.matches("</script>").count(), 2);
}

#[test]
fn the_log_of_a_killed_run_has_a_report_that_says_so() {
    let folder = short_run("uav");
    let bytes = std::fs::read(folder.path("run.mcap")).expect("the log");
    std::fs::write(folder.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).expect("a cut log");
    let (data, _) = report(&folder, &["report", "cut.mcap"], "cut.html");
    let caveats = data["runs"][0]["caveats"].to_string();
    assert!(caveats.contains("killed"), "{caveats}");
}

#[test]
fn tables_hold_the_very_same_bits() {
    let folder = short_run("uav");
    succeeds(&folder, &["export", "run.mcap", "--topics", "agent_1/*,agent_2/command", "--out", "tables"]);
    let names = std::fs::read_dir(folder.path("tables")).expect("the tables").count();
    assert_eq!(names, 5);
    let log = Log::open(&folder.path("run.mcap")).expect("the log");
    let input = log.signal("/agent_2/command", "input").expect("the signal");
    let table = std::fs::read_to_string(folder.path("tables/agent_2_command.csv")).expect("the table");
    let mut lines = table.lines();
    assert!(lines.next().expect("a header").starts_with("t,step,input[0],input[1],input[2],input[3],"));
    for (step, (line, row)) in lines.zip(input.rows()).enumerate() {
        let values: Vec<f64> = line.split(',').map(|text| text.parse().expect("a number")).collect();
        assert_eq!(values[1], step as f64);
        assert_eq!(
            values[2..6].iter().map(|v| v.to_bits()).collect::<Vec<_>>(),
            row.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        );
    }
    // The same values on the terminal.
    let echoed = succeeds(&folder, &["echo", "run.mcap", "agent_2/command", "input", "--at", "1.5"]).stdout();
    let last = echoed.lines().last().expect("a row").replace('\t', ",");
    assert!(table.contains(&format!("\n{last},")), "{last}");
}

#[test]
fn numpy_and_matlab_files_are_read_by_their_readers() {
    let Some(python) = std::env::var_os("PHALANX_PYTHON") else {
        eprintln!("skipped: PHALANX_PYTHON does not name a Python with tests/python/requirements.txt");
        return;
    };
    let folder = short_run("mixed");
    for format in ["npz", "mat", "csv", "parquet"] {
        succeeds(&folder, &["export", "run.mcap", "--format", format, "--every", "10"]);
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/python/read_export.py");
    let output = Command::new(&python).arg(script).arg(folder.path("run")).output().expect("Python runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.starts_with("mixed HFC 21 samples"), "{text}");
}

#[test]
fn drawings_fit_the_terminal_and_have_no_colours_in_a_pipe() {
    let folder = short_run("uav");
    let arguments = ["plot", "run.mcap", "agent_*/state/position[2]", "--width", "60", "--height", "8"];
    let text = succeeds(&folder, &arguments).stdout();
    assert!(!text.contains('\x1b'), "{text}");
    assert!(text.lines().take(10).all(|line| line.chars().count() <= 60), "{text}");
    assert_eq!(text.lines().filter(|line| line.contains("━ agent_")).count(), 6);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let folder = short_run("uav");
    let refused = |arguments: &[&str], words: &[&str]| {
        let finished = folder.run(arguments);
        assert_eq!(finished.code(), 2, "{arguments:?}");
        for word in words {
            assert!(finished.stderr().contains(word), "{arguments:?}: {}", finished.stderr());
        }
    };
    refused(&["echo", "run.mcap", "agent_1/stat"], &["agent_1/stat", "did you mean `agent_1/state`?"]);
    refused(&["echo", "run.mcap", "agent_*/state"], &["/agent_1/state, /agent_2/state"]);
    refused(&["echo", "run.mcap", "agent_1/state", "posision"], &["did you mean `position`?", "velocity"]);
    refused(&["echo", "run.mcap", "agent_1/state", "--at", "-1"], &["first sample"]);
    refused(&["plot", "run.mcap", "agent_1/state/position[6]"], &["6 components are counted from 0"]);
    refused(&["plot", "run.mcap", "agent_1"], &["TOPIC/FIELD"]);
    refused(&["plot", "run.mcap", "agent_*/state/*"], &["108 lines", "--norm"]);
    refused(&["plot", "run.mcap", "agent_1/state/position", "--from", "3"], &["ends at 2 s"]);
    refused(&["export", "run.mcap", "--topics", "agent_7/*"], &["agent_7/*"]);
    refused(&["report", "run.mcap", "--format", "png"], &["--figures"]);
    assert_eq!(folder.run(&["report", "missing.mcap"]).code(), 4);
}
