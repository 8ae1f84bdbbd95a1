//! Looking at a run while it goes on, in the terminal and in a browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout, Stdio};

use serde_json::Value;

use crate::program::{Folder, wait_until};

/// The drones under a name of their own, by which their run is known.
fn scenario(folder: &Folder, name: &str) -> String {
    let text = folder.run(&["validate", "uav", "--set", "metrics=", "--print"]).stdout();
    assert!(text.contains("name = \"uav\""), "{text}");
    let path = folder.write(&format!("{name}.toml"), &text.replace("name = \"uav\"", &format!("name = \"{name}\"")));
    path.to_str().expect("a path").to_string()
}

/// What a run that goes to its end prints as JSON.
fn outcome(run: Child) -> Value {
    let output = run.wait_with_output().expect("the end of the run");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    serde_json::from_str(text.lines().last().expect("a line")).expect("JSON")
}

/// Starts a run of three seconds in about as much time, recorded into `log`.
fn start_run(folder: &Folder, file: &str, log: &str) -> Child {
    folder.start(&["run", file, "--duration", "3", "--realtime", "--json", "-q", "--out", log])
}

#[test]
fn a_watcher_waits_follows_to_the_end_and_changes_no_bit() {
    let folder = Folder::new();
    let file = scenario(&folder, "watched");
    let alone = outcome(start_run(&folder, &file, "alone.mcap"));
    let watchers: Vec<Child> = (0..2).map(|_| folder.start(&["watch", "watched"])).collect();
    let run = outcome(start_run(&folder, &file, "watched.mcap"));
    assert_eq!(run["sha256"], alone["sha256"]);
    for watcher in watchers {
        let output = watcher.wait_with_output().expect("the end of the watcher");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(text.ends_with("The run watched is over: all 301 steps are done.\n"), "{text}");
        assert!(!text.contains('\x1b'), "a pipe is no screen: {text:?}");
    }
    // Nothing of it is left in shared memory.
    for entry in std::fs::read_dir("/dev/shm").expect("shared memory").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(!name.contains("-watched_"), "{name}");
    }
}

#[test]
fn a_run_that_ends_early_is_reported_so_and_a_watcher_may_leave() {
    let folder = Folder::new();
    let file = scenario(&folder, "left");
    let mut run = folder.start(&["run", &file, "--realtime", "-q", "--no-log"]);
    let leaving = folder.start(&["watch", "left"]);
    let staying = folder.start(&["watch", "left"]);
    wait_until("the run goes on", || folder.run(&["ctl", "status", "left"]).code() == 0);
    // Signal numbers of processes that this test has started.
    let signal = |child: &Child| {
        let ended = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(ended.expect("kill").success());
    };
    std::thread::sleep(std::time::Duration::from_millis(300));
    signal(&leaving);
    let output = leaving.wait_with_output().expect("the end of the watcher");
    assert!(output.status.success());
    assert_eq!(folder.run(&["ctl", "stop", "left"]).code(), 0);
    assert_eq!(run.wait().expect("the end of the run").code(), Some(130));
    let output = staying.wait_with_output().expect("the end of the watcher");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("The run left is over. It ended early, at step "), "{text}");
}

/// Asks the server for something and returns the whole answer.
fn get(address: &str, path: &str, host: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("a connection");
    // The older version: no answer in chunks.
    write!(stream, "GET {path} HTTP/1.0\r\nHost: {host}\r\n\r\n").expect("a request");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer
}

/// Starts to watch a run in a browser.
fn start_page(folder: &Folder, run: &str) -> Child {
    let mut watcher = folder.phalanx(&["watch", run, "--web"]);
    watcher.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("the program starts")
}

/// Where its page is, once it says so. Its stdout has to stay open: a watcher whose output is no longer read ends.
fn address_of(watcher: &mut Child) -> (String, BufReader<ChildStdout>) {
    let mut line = String::new();
    let mut stdout = BufReader::new(watcher.stdout.take().expect("stdout"));
    stdout.read_line(&mut line).expect("the address");
    let address = line.trim().rsplit("http://").next().expect("an address").trim_end_matches('/').to_string();
    assert!(address.starts_with("127.0.0.1:"), "{line}");
    (address, stdout)
}

/// The data of the page, once there are any.
fn data_at(address: &str) -> Value {
    let mut page = String::new();
    wait_until("the page has data", || {
        page = get(address, "/", address);
        page.contains("id=\"runs\">")
    });
    let data = page.split("id=\"runs\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("the data");
    serde_json::from_str(data).expect("JSON")
}

#[test]
fn a_page_that_is_opened_late_begins_with_the_run_or_says_why_not() {
    for (name, log, no_past) in [
        ("late", &["--out", "late.mcap"][..], Value::Null),
        ("unrecorded", &["--no-log"][..], "the run is not recorded".into()),
    ] {
        let folder = Folder::new();
        let file = scenario(&folder, name);
        let arguments = ["run", &file, "--duration", "600", "--realtime", "-q"];
        let mut run = folder.start(&[&arguments[..], log].concat());
        let is_under_way = || {
            let status = folder.run(&["ctl", "status", name]).stdout();
            let steps = status.split(" of ").next().and_then(|text| text.rsplit(' ').next()?.parse::<u64>().ok());
            steps.is_some_and(|steps| steps > 150)
        };
        wait_until("the run is under way", is_under_way);
        let mut watcher = start_page(&folder, name);
        let (address, _stdout) = address_of(&mut watcher);
        let data = data_at(&address);
        assert_eq!(data["live"]["no_past"], no_past, "{name}");
        // Base64 of a time of 0 as 32 bits.
        let begins_with_zero = data["runs"][0]["time"].as_str().expect("times").starts_with("AAAAA");
        assert_eq!(begins_with_zero, no_past.is_null(), "{name}");
        assert_eq!(folder.run(&["ctl", "stop", name]).code(), 0);
        run.wait().expect("the end of the run");
        // The page would stay until a browser has shown its end.
        get(&address, "/events", &address);
        watcher.wait().expect("the end of the watcher");
    }
}

#[test]
fn the_page_grows_frame_by_frame_to_the_last_step() {
    let folder = Folder::new();
    let file = scenario(&folder, "paged");
    let mut watcher = start_page(&folder, "paged");
    let run = start_run(&folder, &file, "paged.mcap");
    let (address, _stdout) = address_of(&mut watcher);

    let events = std::thread::spawn({
        let address = address.clone();
        move || get(&address, "/events", &address)
    });
    assert!(get(&address, "/", "elsewhere.example").starts_with("HTTP/1.1 403"));
    assert!(get(&address, "/other", &address).starts_with("HTTP/1.1 404"));
    let data = data_at(&address);
    assert_eq!(data["live"]["duration"], 3.0);
    // A frame has a number for every path and curve of the page.
    let agents = data["runs"][0]["scene"]["agents"].as_array().expect("agents");
    let paths =
        agents.iter().flat_map(|agent| ["position", "tracked", "desired"].map(|name| agent[name]["width"].as_u64()));
    let curves = data["runs"][0]["panels"].as_array().expect("panels").iter().flat_map(|panel| {
        panel["views"]
            .as_array()
            .expect("views")
            .iter()
            .map(|view| view["curves"].as_array().expect("curves").len() as u64)
    });
    let numbers = paths.flatten().sum::<u64>() + curves.sum::<u64>();

    let events = events.join().expect("all events");
    let frames: Vec<Value> = events
        .split("\n\n")
        .filter_map(|event| event.strip_prefix("event: frame\ndata: "))
        .map(|data| serde_json::from_str(data).expect("JSON"))
        .collect();
    assert!(frames.len() > 10, "{} frames", frames.len());
    let times: Vec<f64> = frames.iter().map(|frame| frame["time"].as_f64().expect("a time")).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
    let over = events.split("event: over\ndata: ").nth(1).expect("the end");
    let over: Value = serde_json::from_str(over.trim_end()).expect("JSON");
    assert_eq!(over["frame"]["time"], 3.0);
    assert_eq!(over["text"], "The run paged is over: all 301 steps are done.");
    for frame in frames.iter().chain([&over["frame"]]) {
        let letters = frame["values"].as_str().expect("values").len() as u64;
        assert_eq!(letters, (4 * numbers).div_ceil(3) * 4);
    }
    outcome(run);
    assert!(watcher.wait().expect("the end of the watcher").success());
}

#[test]
fn a_run_in_one_process_shows_its_progress_and_has_no_page() {
    let folder = Folder::new();
    let file = scenario(&folder, "alone");
    let arguments = ["run", &file, "--placement", "single", "--realtime", "-q", "--no-log"];
    let mut run = folder.start(&arguments);
    let refused = folder.run(&["watch", "alone", "--web"]);
    assert_eq!(refused.code(), 2);
    assert!(refused.stderr().contains("--placement single"), "{}", refused.stderr());
    let mut watcher = folder.start(&["watch", "alone"]);
    let mut seen = BufReader::new(watcher.stdout.take().expect("a pipe"));
    let mut text = String::new();
    // It has found the run before that ends.
    seen.read_line(&mut text).expect("a line");
    wait_until("the run goes on", || folder.run(&["ctl", "stop", "alone"]).code() == 0);
    run.wait().expect("the end of the run");
    seen.read_to_string(&mut text).expect("the rest");
    watcher.wait().expect("the end of the watcher");
    assert!(text.contains("The run alone is over."), "{text}");
}
