//! The keys of the terminal that a run is started from, pressed on a terminal of the test's own.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use crate::engine::status;
use crate::program::{Folder, wait_until};

/// A terminal with a run at its other end.
struct Terminal {
    master: File,
    shown: Arc<Mutex<String>>,
    run: Child,
}

impl Terminal {
    /// Starts the program on a new terminal.
    fn start(folder: &Folder, arguments: &[&str]) -> Self {
        let master: OwnedFd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&master).expect("a terminal");
        unlockpt(&master).expect("a terminal");
        let name = ptsname(&master, Vec::new()).expect("its name");
        let open = || {
            let name = name.to_str().expect("a path");
            Stdio::from(OpenOptions::new().read(true).write(true).open(name).expect("its other end"))
        };
        let mut command = folder.phalanx(arguments);
        let run = command.stdin(open()).stdout(open()).stderr(open()).spawn().expect("the program starts");
        let (mut master, shown) = (File::from(master), Arc::new(Mutex::new(String::new())));
        let (mut screen, text) = (master.try_clone().expect("a reader"), shown.clone());
        // Ends with an error when the last end of the terminal is closed.
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = screen.read(&mut bytes) {
                text.lock().expect("the screen").push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
        });
        master.flush().expect("a terminal");
        Self { master, shown, run }
    }

    fn press(&mut self, key: &str) {
        self.master.write_all(key.as_bytes()).expect("a key");
    }

    fn shows(&self, text: &str) -> bool {
        self.shown.lock().expect("the screen").contains(text)
    }
}

#[test]
fn keys_pause_step_and_stop_a_run() {
    let folder = Folder::new();
    let mut terminal = Terminal::start(&folder, &["run", "uav", "--realtime", "2", "--out", "a.mcap"]);
    wait_until("the run answers", || status(&folder, &terminal.run).is_some());
    let look = |terminal: &Terminal| {
        let (_, json) = status(&folder, &terminal.run).expect("a status");
        (json["steps"].as_u64().expect("steps"), json["paused"].as_bool().expect("a state"))
    };
    wait_until("it runs", || look(&terminal).0 > 3);
    terminal.press(" ");
    wait_until("it is paused", || look(&terminal).1);
    wait_until("it says so", || terminal.shows("paused; space goes on"));
    // A step that was waiting for its time when the pause came is still done.
    std::thread::sleep(std::time::Duration::from_millis(100));
    let (steps, _) = look(&terminal);
    terminal.press("s");
    wait_until("one step is done", || look(&terminal).0 == steps + 1);
    terminal.press("ss");
    wait_until("two more are done", || look(&terminal).0 == steps + 3);
    assert!(look(&terminal).1, "a step ends the pause");
    terminal.press(" ");
    wait_until("it goes on", || look(&terminal).0 > steps + 10);
    terminal.press("q");
    assert_eq!(terminal.run.wait().expect("an end").code(), Some(130));
    assert_eq!(folder.run(&["info", "a.mcap"]).code(), 0);
}
