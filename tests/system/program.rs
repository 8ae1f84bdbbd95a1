//! The real program, started from outside in an empty folder.

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use recording::Log;
use serde_json::Value;

/// A folder of its own for one test, removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("phalanx-test-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("a folder for the test");
        Self(path)
    }

    /// A path in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file into it.
    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).expect("a file for the test");
        path
    }

    /// The program with these arguments, in this folder.
    pub(crate) fn phalanx(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
        // Cargo's search path would put a library of an earlier build before the one that a program was linked with.
        command.args(arguments).current_dir(&self.0).env_remove("LD_LIBRARY_PATH");
        command
    }

    /// Runs the program to its end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Finished {
        Finished(self.phalanx(arguments).stdin(Stdio::null()).output().expect("the program starts"))
    }

    /// The digest of all samples of a log. Two logs may have the same samples and name different programs.
    pub(crate) fn samples(&self, log: &str) -> String {
        Log::open(&self.path(log)).unwrap_or_else(|error| panic!("{error}")).digest()
    }

    /// Starts the program and leaves it running.
    pub(crate) fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.phalanx(arguments);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("the program starts")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What a finished program left.
pub(crate) struct Finished(pub(crate) Output);

impl Finished {
    /// Its exit code.
    pub(crate) fn code(&self) -> i32 {
        self.0.status.code().expect("an exit code")
    }

    /// What it printed.
    pub(crate) fn stdout(&self) -> String {
        String::from_utf8_lossy(&self.0.stdout).into_owned()
    }

    /// What it complained about.
    pub(crate) fn stderr(&self) -> String {
        String::from_utf8_lossy(&self.0.stderr).into_owned()
    }

    /// The last line of stdout as JSON.
    pub(crate) fn json(&self) -> Value {
        let stdout = self.stdout();
        let last = stdout.lines().last().unwrap_or_else(|| panic!("no output; stderr: {}", self.stderr()));
        serde_json::from_str(last).unwrap_or_else(|error| panic!("{error}: {last}"))
    }
}

/// A name for a run that no other test has, not even the same one started a second time.
pub(crate) fn unique(name: &str) -> String {
    format!("{name}-{}", std::process::id())
}

/// The program that fails on purpose; Cargo builds examples before it runs tests.
pub(crate) fn saboteur() -> PathBuf {
    let path = PathBuf::from(env!("CARGO_BIN_EXE_phalanx")).with_file_name("examples").join("saboteur");
    assert!(path.exists(), "{} is not built: cargo build --release --examples -p phalanx", path.display());
    path
}

/// Processes whose parent is `pid`, but for the guardian of a run.
pub(crate) fn children(pid: u32) -> Vec<u32> {
    let is_child = |process: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        // The name may hold spaces and parentheses; the parent is the second word behind it.
        let parent = stat.rsplit(')').next().and_then(|rest| rest.split_whitespace().nth(1));
        parent == Some(pid.to_string().as_str()) && !stat.contains("(phalanx-guard)")
    };
    let entries = std::fs::read_dir("/proc").expect("/proc");
    entries.flatten().filter_map(|entry| entry.file_name().to_str()?.parse().ok()).filter(is_child).collect()
}

/// Whether a process exists and is not a zombie.
pub(crate) fn is_alive(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')').next().and_then(|rest| rest.split_whitespace().next()).is_some_and(|state| state != "Z")
}

/// Waits until `condition` holds, for a minute at most.
pub(crate) fn wait_until(what: &str, mut condition: impl FnMut() -> bool) {
    for _ in 0..6000 {
        if condition() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("waited a minute until {what}");
}

/// That docs/faults.md has these rows: what happens, what comes of it, and the exit code.
pub(crate) fn assert_rows_of_faults(rows: &[(&str, &str, &str)]) {
    let page = include_str!("../../docs/faults.md");
    for (what, happens, code) in rows {
        let row = format!("| {what} | {happens} | {code} |");
        assert!(page.contains(&row), "docs/faults.md lacks the row\n{row}");
    }
}
