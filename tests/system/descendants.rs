//! What participants start themselves ends with the run, however that ends: behind a shell, in a session of its own, as a
//! daemon whose parent is gone, with an empty environment.

use crate::program::{Folder, is_alive, unique, wait_until};

/// Starts something that writes its pid into a file, then is no participant.
const WAYS: [(&str, &str); 4] = [
    ("behind a shell", "sleep 86399 & echo $! > pid; wait"),
    ("in a session", "setsid sh -c 'echo $$ > pid; exec sleep 86399' & wait"),
    ("a daemon", "(setsid sh -c 'sh -c \"trap : TERM HUP; echo \\$\\$ > pid; exec sleep 86399\" &' &) ; sleep 86399"),
    ("without an environment", "(env -i setsid sh -c 'echo $$ > pid; exec sleep 86399' &) ; sleep 86399"),
];

#[test]
fn no_descendant_outlives_an_orchestrator_that_is_killed() {
    for (what, script) in WAYS {
        for signal in [rustix::process::Signal::KILL, rustix::process::Signal::TERM] {
            let folder = Folder::new();
            let name = unique("descendants");
            let text = folder.run(&["validate", "compensated", "--print"]).stdout();
            folder.write("it.toml", &text.replacen("name = \"compensated\"", &format!("name = \"{name}\""), 1));
            let program = folder.write("program.sh", script);
            let swap = format!("controller.1=sh {}", program.display());
            let mut run = folder.start(&["run", "it.toml", "--no-log", "-qq", "--swap", &swap]);
            let mut pid = None;
            wait_until("it has started something", || {
                pid = std::fs::read_to_string(folder.path("pid")).ok().and_then(|text| text.trim().parse::<u32>().ok());
                pid.is_some()
            });
            let pid = pid.expect("a number");
            assert!(is_alive(pid), "{what}");
            let orchestrator = rustix::process::Pid::from_child(&run);
            rustix::process::kill_process(orchestrator, signal).expect("it runs");
            run.wait().expect("an end");
            wait_until(what, || !is_alive(pid));
        }
    }
}
