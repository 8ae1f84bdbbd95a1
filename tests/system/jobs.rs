//! A run as a job of an interactive shell: in the background, stopped with Ctrl-Z, and back in the foreground.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;

use crate::program::{Folder, unique, wait_until};
use crate::stopping::renamed;

/// A shell on a terminal of its own.
struct Shell {
    master: File,
    shown: Arc<Mutex<String>>,
    shell: Child,
}

impl Shell {
    fn start(folder: &Folder) -> Self {
        let master: OwnedFd = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&master).and_then(|()| unlockpt(&master)).expect("a terminal");
        let name = ptsname(&master, Vec::new()).expect("its name").into_string().expect("a path");
        let open = || Stdio::from(OpenOptions::new().read(true).write(true).open(&name).expect("its other end"));
        let mut command = Command::new("setsid");
        command.args(["--ctty", "--wait", "bash", "--norc", "--noprofile", "-i"]).current_dir(folder.path(""));
        command.env("PS1", "$ ").env("TERM", "dumb").env_remove("LD_LIBRARY_PATH");
        let shell = command.stdin(open()).stdout(open()).stderr(open()).spawn().expect("a shell");
        let (master, shown) = (File::from(master), Arc::new(Mutex::new(String::new())));
        let (mut screen, text) = (master.try_clone().expect("a reader"), shown.clone());
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = screen.read(&mut bytes) {
                text.lock().expect("the screen").push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
        });
        Self { master, shown, shell }
    }

    fn type_in(&mut self, text: &str) {
        self.master.write_all(text.as_bytes()).expect("a key");
    }

    fn text(&self) -> String {
        self.shown.lock().expect("the screen").clone()
    }

    fn shows(&self, text: &str) -> bool {
        self.text().contains(text)
    }

    /// What a command prints, which must not be on the screen yet.
    fn answers(&mut self, command: &str, text: &str) {
        self.type_in(&format!("{command}\n"));
        wait_until(&format!("`{command}` prints {text}: {}", self.text()), || self.shows(text));
    }
}

impl Drop for Shell {
    fn drop(&mut self) {
        let _ = self.master.write_all(b"\x03\nkill -KILL %1; exit\n");
        let _ = self.shell.kill();
        let _ = self.shell.wait();
    }
}

fn steps(folder: &Folder, name: &str) -> Option<u64> {
    let answer = folder.run(&["ctl", "status", name, "--json"]);
    serde_json::from_str::<Value>(answer.stdout().trim()).ok()?["steps"].as_u64()
}

fn advances(folder: &Folder, name: &str) {
    let before = steps(folder, name).unwrap_or(0);
    wait_until("it runs on", || steps(folder, name).is_some_and(|steps| steps > before + 5));
}

fn start(folder: &Folder, name: &str, duration: &str, end: &str) -> Shell {
    let mut shell = Shell::start(folder);
    wait_until("there is a prompt", || shell.shows("$ "));
    let (scenario, phalanx) = (renamed(folder, "uav", name), env!("CARGO_BIN_EXE_phalanx"));
    shell.type_in(&format!("{phalanx} run {scenario} --realtime --duration {duration} --out a.mcap{end}\n"));
    wait_until("it runs", || steps(folder, name) > Some(2));
    shell
}

#[test]
fn a_run_in_the_background_runs_to_its_end() {
    let folder = Folder::new();
    let name = unique("background");
    let mut shell = start(&folder, &name, "3", " &");
    advances(&folder, &name);
    shell.answers("jobs", "Running");
    // Keys are for the foreground job.
    shell.type_in("echo q is not for the run | tr a-z A-Z\n");
    wait_until("the shell has the keys", || shell.shows("Q IS NOT FOR THE RUN"));
    wait_until("it ends", || shell.shows("Next:"));
    wait_until("its log is closed", || folder.run(&["info", "a.mcap", "--json"]).code() == 0);
    assert!(!shell.shows("Stopped"), "{}", shell.text());
    assert_eq!(folder.run(&["info", "a.mcap", "--json"]).json()["complete"], true);
}

#[test]
fn a_run_is_stopped_continued_in_the_background_and_brought_back() {
    let folder = Folder::new();
    let name = unique("suspended");
    let mut shell = start(&folder, &name, "3600", "");
    shell.type_in("\x1a");
    wait_until("it is stopped", || shell.shows("Stopped"));
    // The terminal has its mode back: what is typed is shown, and lines are lines.
    shell.answers("stty -a | tr ' ' '\\n' | grep -c -x -e icanon -e echo", "2");
    shell.type_in("bg\n");
    advances(&folder, &name);
    shell.answers("jobs", "Running");
    shell.type_in("fg\n");
    wait_until("the terminal is the run's", || {
        // Paused by a key, once the run takes keys again.
        shell.type_in(" ");
        std::thread::sleep(std::time::Duration::from_millis(300));
        shell.shows("paused; space goes on")
    });
    shell.type_in("q");
    wait_until("it has ended", || shell.shows("error: interrupted"));
    assert_eq!(folder.run(&["info", "a.mcap", "--json"]).json()["complete"], true);
}
