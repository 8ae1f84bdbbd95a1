//! A participant that writes where it must not: into the samples of others, into the memory that all share. The run ends with
//! an error that names it, and never by a signal or a panic of the orchestrator.

use std::process::Command;

use crate::own_programs::{library_folder, root};
use crate::program::Folder;

/// What `programs/hostile.c` does at step 20, and what must be told; nothing: the run is complete.
const WAYS: [(&str, &str); 12] = [
    ("board_data", "is not what"),
    ("board_ff", "at step"),
    ("board_00", "at step"),
    ("board_rand", "at step"),
    ("board_trunc", "bytes instead of"),
    ("page_ff", "was overwritten"),
    ("page_00", "was overwritten"),
    ("page_rand", "was overwritten"),
    ("mgmt_ff", ""),
    ("mgmt_rand", ""),
    ("dyn_trunc", ""),
    ("all_rand", "at step"),
];

/// The program that does it. It is wrong C on purpose, so no warning is asked for.
fn compile(folder: &Folder) -> String {
    let (library, program) = (library_folder(), folder.path("hostile"));
    let compiled = Command::new("cc")
        .args(["-w", "-O1", "-ffp-contract=off"])
        .arg(format!("-I{}", root().join("capi/include").display()))
        .arg(root().join("tests/system/programs/hostile.c"))
        .arg("-o")
        .arg(&program)
        .arg(format!("-L{}", library.display()))
        .args(["-lphalanx", "-lm", &format!("-Wl,-rpath,{}", library.display())])
        .output()
        .expect("a C compiler: apt-get install gcc");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    program.display().to_string()
}

#[test]
fn memory_that_a_participant_overwrites_is_a_named_error() {
    let folder = Folder::new();
    let hostile = compile(&folder);
    for (way, told) in WAYS {
        let swap = format!("controller.3={hostile} {way} 20");
        // A participant that finds the samples altered is not at fault, and to replace it is no help.
        let policy = if way.starts_with("board_") { "restart" } else { "abort" };
        let run = folder.run(&[
            "run",
            "uav",
            "--duration",
            "0.5",
            "-q",
            "--deadline",
            "5",
            "--on-failure",
            policy,
            "--swap",
            &swap,
            "--out",
            "a.mcap",
        ]);
        let (code, stderr) = (run.code(), run.stderr());
        if told.is_empty() {
            assert!([0, 1, 3].contains(&code), "{way}: {code}\n{stderr}");
        } else {
            assert!(code == 3 && stderr.contains(told), "{way}: {code}\n{stderr}");
            if way.starts_with("board_") && way != "board_trunc" {
                // It has overwritten all the samples that it can reach, and no other process can reach all of them.
                assert!(stderr.contains("only controller_3 (pid "), "{way}:\n{stderr}");
            }
        }
        assert!(!stderr.contains("stack backtrace") && !stderr.contains("phalanx` panicked"), "{way}:\n{stderr}");
        let info = folder.run(&["info", "a.mcap", "--json"]);
        assert_eq!(info.code(), 0, "{way}: the log is readable\n{}", info.stderr());
    }
}
