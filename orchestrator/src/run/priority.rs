//! Processes that go before others: SCHED_FIFO and locked memory, where the system permits it.

use std::process::{Command, Stdio};

use rustix::mm::{MlockAllFlags, mlockall};

/// Environment variable that tells a process of a run to keep its memory from being swapped.
const LOCK_MEMORY: &str = "PHALANX_LOCK_MEMORY";
/// The program that sets the scheduling of another one (util-linux).
const CHRT: &str = "chrt";

/// How urgent the processes of a run are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Priority {
    /// SCHED_FIFO priority, 1 to 99; `None`: normal scheduling.
    pub priority: Option<u8>,
}

impl Priority {
    /// Makes this thread urgent, and with it all processes and threads that it starts from now on. Where that is not
    /// permitted, a line on stderr says so, and everything goes on as usual.
    pub(crate) fn claim(self) {
        let Some(priority) = self.priority else { return };
        let (priority, pid) = (priority.to_string(), std::process::id().to_string());
        let mut command = Command::new(CHRT);
        command.args(["--fifo", "--pid", &priority, &pid]).stdout(Stdio::null()).stderr(Stdio::null());
        if !command.status().is_ok_and(|status| status.success()) {
            eprintln!(
                "--rt-priority {priority}: not permitted here, going on without; it takes the program {CHRT} (util-linux) and \
                 CAP_SYS_NICE, or an rtprio line in /etc/security/limits.conf"
            );
        }
    }

    /// Tells a process that is to be started to lock its memory.
    pub(crate) fn apply(self, command: &mut Command) {
        if self.priority.is_some() {
            command.env(LOCK_MEMORY, "1");
        }
    }
}

/// Locks the memory of this process if the run wants it.
pub(crate) fn lock_memory_if_wanted() {
    if std::env::var_os(LOCK_MEMORY).is_some()
        && let Err(error) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
    {
        eprintln!("memory cannot be locked: {error}; `ulimit -l` says how much may be");
    }
}
