//! Programs of a user in the place of a participant: the examples give the log of the built-in controller, and mistakes are
//! told in words.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{Finished, Folder};

const SHORT: [&str; 6] = ["run", "uav", "--duration", "1", "-q", "--json"];

/// The top-level folder of the project.
pub(crate) fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The folder where Cargo puts the library: the one of this test, which depends on it.
pub(crate) fn library_folder() -> PathBuf {
    let test = std::env::current_exe().expect("the path of this test");
    let folder = test.parent().expect("a folder").to_path_buf();
    assert!(folder.join("libphalanx.so").exists(), "no libphalanx.so in {}", folder.display());
    folder
}

/// Compiles a C or C++ program against the header and the library.
pub(crate) fn compile(folder: &Folder, source: &str, name: &str) -> String {
    let (compiler, standard) = if source.ends_with(".c") { ("cc", "-std=c11") } else { ("c++", "-std=c++17") };
    let library = library_folder();
    let program = folder.path(name);
    let compiled = Command::new(compiler)
        .args([standard, "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off"])
        .arg(format!("-I{}", root().join("capi/include").display()))
        .arg(root().join(source))
        .arg("-o")
        .arg(&program)
        .arg(format!("-L{}", library.display()))
        .args(["-lphalanx", "-lm", &format!("-Wl,-rpath,{}", library.display())])
        .output()
        .expect("a C and a C++ compiler: apt-get install g++");
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    program.to_str().expect("a path").to_string()
}

/// The digest of the samples of a short run with these programs in it.
fn digest(folder: &Folder, swaps: &[String]) -> String {
    digest_of(folder, &[], swaps)
}

/// The same with more options.
fn digest_of(folder: &Folder, options: &[&str], swaps: &[String]) -> String {
    let swaps = swaps.iter().flat_map(|swap| ["--swap", swap]);
    let options = ["--out", "log.mcap"].into_iter().chain(options.iter().copied());
    let arguments: Vec<&str> = SHORT.into_iter().chain(options).chain(swaps).collect();
    let run = folder.run(&arguments);
    // 1: a run as short as this misses ranges that are about its end.
    assert!(run.code() <= 1, "{}", run.stderr());
    folder.samples("log.mcap")
}

#[test]
fn the_example_in_cpp_gives_the_same_log() {
    let folder = Folder::new();
    let program = compile(&folder, "examples/controller-cpp/controller.cpp", "controller");
    let plain = digest(&folder, &[]);
    assert_eq!(digest(&folder, &[format!("controller.3={program}")]), plain);
    let all: Vec<String> = (1..=6).map(|agent| format!("controller_{agent}={program}")).collect();
    assert_eq!(digest(&folder, &all), plain);
    // At a lower rate it is asked for its own steps only, and its outputs are held.
    let slow = ["--set", "controller.every=3", "--set", "controller.offset=1"];
    assert_eq!(digest_of(&folder, &slow, &all), digest_of(&folder, &slow, &[]));
    assert_ne!(digest_of(&folder, &slow, &[]), plain);
}

/// Writes a project with `phalanx new` and returns the path of its program text.
fn project(folder: &Folder, role: &str, scenario: &str, language: &str, text: &str) -> PathBuf {
    let new = folder.run(&["new", role, "mine", "--lang", language, "--scenario", scenario]);
    assert_eq!(new.code(), 0, "{}", new.stderr());
    folder.path("mine").join(text)
}

/// Participants of a scenario that a project is written for, one of each role.
const ROLES: [(&str, &str, &str); 4] = [
    ("controller", "uav", "controller.3"),
    ("observer", "cida", "observer.2"),
    ("planner", "rca", "planner"),
    ("plant", "lp-regulation", "plant"),
];

#[test]
fn new_projects_in_cpp_build_and_conform() {
    for (role, scenario, node) in ROLES {
        let folder = Folder::new();
        let text = project(&folder, role, scenario, "cpp", "main.cpp");
        let program = compile(&folder, text.to_str().expect("a path"), role);
        let tried = folder.run(&["conform", node, "--scenario", scenario, "--steps", "30", "--", &program]);
        assert_eq!(tried.code(), 0, "{role}: {}{}", tried.stdout(), tried.stderr());
    }
}

/// A Python with NumPy, if there is one: `.ci/run` makes an environment and says here which it is.
pub(crate) fn python() -> Option<String> {
    let python = std::env::var("PHALANX_PYTHON").ok();
    if python.is_none() {
        eprintln!("skipped: PHALANX_PYTHON does not name a Python with NumPy");
    }
    python
}

#[test]
fn new_projects_in_python_conform() {
    let Some(python) = python() else { return };
    for (role, scenario, node) in ROLES {
        let folder = Folder::new();
        let text = project(&folder, role, scenario, "python", "main.py");
        let arguments = ["conform", node, "--scenario", scenario, "--steps", "30", "--", &python];
        let mut conform = folder.phalanx(&arguments);
        conform.arg(text).env("PYTHONPATH", root().join("python/src"));
        conform.env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
        let tried = Finished(conform.output().expect("the program starts"));
        assert_eq!(tried.code(), 0, "{role}: {}{}", tried.stdout(), tried.stderr());
    }
}

#[test]
fn the_example_in_rust_gives_the_same_log() {
    let folder = Folder::new();
    let program = library_folder().join("../examples/controller-rust");
    assert!(program.exists(), "build it: cargo build --release -p phalanx --example controller-rust");
    let swap = format!("controller.3={}", program.display());
    assert_eq!(digest(&folder, &[swap]), digest(&folder, &[]));
}

#[test]
fn the_example_in_c_gives_the_same_log_twice() {
    let folder = Folder::new();
    let program = compile(&folder, "examples/controller-c/controller.c", "hover");
    let swap = format!("controller.3={program}");
    let first = digest(&folder, std::slice::from_ref(&swap));
    assert_eq!(digest(&folder, &[swap]), first);
    assert_ne!(digest(&folder, &[]), first);
}

/// Runs with the program that makes this mistake.
fn mistake(folder: &Folder, program: &str, name: &str) -> Finished {
    let swap = format!("controller.3={program} \"{name}\"");
    folder.run(&[&SHORT[..], &["--out", "log.mcap", "--swap", &swap]].concat())
}

#[test]
fn every_mistake_is_told_in_words() {
    let folder = Folder::new();
    let program = compile(&folder, "tests/system/programs/misuse.c", "misuse");
    assert!(mistake(&folder, &program, "none").code() <= 1);
    let told = [
        ("role", "there is no role called `pilot`, expected one of plant, planner, observer, controller"),
        ("other role", "`controller_3` is no observer"),
        ("channel", "there is no channel called `states`, expected one of state, reference, estimate, command"),
        ("agent", "there is no agent 17; the scenario has 6"),
        ("signal", "needs the signal `positon` (6 values) from the plant of agent 3, which offers only position (6)"),
        ("length", "needs the signal `position` (3 values) from the plant of agent 3, which offers only position (6)"),
        ("no length", "asked for with a length that is not positive"),
        ("not read", "which the participant that it replaces does not read"),
        ("output", "does not declare the output `inputs` (4)"),
        ("foreign output", "does not declare the output `input` (4)"),
        ("number", "the scenario has no number called `controller.c_q`"),
        ("no number", "`controller.intro` of the scenario is not a number, but the string \"logistic\""),
        ("no text", "`controller.c_p` of the scenario is not a text, but the integer 2"),
        ("no list", "`controller.c_p` of the scenario is not a list, but the integer 2"),
        ("model", "the model of agent 3 has no number called `mass`"),
        ("early read", "0 is no handle of a signal"),
        ("early done", "done: no step is in progress"),
        ("text bytes", "the name of a text is no UTF-8 text"),
        ("no role", "the role is NULL"),
        ("second open", "this process is a participant already"),
        ("forget", "controller_3 at step 7: output /agent_3/command: input[0] is NaN"),
        ("infinite", "controller_3 at step 7: output /agent_3/command: input[2] is inf"),
        ("handle", "controller_3 at step 7: 99 is no handle of a signal"),
        ("read output", "is an output, not an input"),
        ("write input", "is an input, not an output"),
        ("late", "controller_3 at step 7: signals can be bound before the first step only"),
        ("fail", "controller_3 at step 7: the battery is empty"),
        ("leave", "controller_3"),
        ("crash", "signal 11"),
        ("not done", "controller_3 at step 7: the next step was asked for before this one was done"),
        ("twice done", "controller_3 at step 7: a step was called done, but none is in progress"),
        ("late read", "controller_3 at step 7: read: no step is in progress"),
    ];
    for (name, words) in told {
        let run = mistake(&folder, &program, name);
        assert_eq!(run.code(), 3, "{name}: {}{}", run.stdout(), run.stderr());
        assert!(run.stderr().contains(words), "{name}: {}", run.stderr());
    }
}

#[test]
fn outside_a_run_a_program_says_how_it_is_started() {
    let folder = Folder::new();
    let program = compile(&folder, "examples/controller-cpp/controller.cpp", "controller");
    let alone = Finished(Command::new(&program).output().expect("it starts"));
    assert_eq!(alone.code(), 2);
    assert!(alone.stderr().contains("phalanx run SCENARIO --swap controller.3=PROGRAM"), "{}", alone.stderr());
    let program = compile(&folder, "tests/system/programs/misuse.c", "misuse");
    let null = Finished(Command::new(&program).arg("null").output().expect("it starts"));
    assert_eq!((null.code(), null.stdout().trim()), (0, "0 the participant is NULL 2"));
}

/// `.ci/run` has CMake beside its Python.
#[test]
fn cmake_finds_the_package() {
    let beside = std::env::var_os("PHALANX_PYTHON").map(|python| Path::new(&python).with_file_name("cmake"));
    let cmake = beside.filter(|cmake| cmake.exists()).unwrap_or("cmake".into());
    if Command::new(&cmake).arg("--version").output().is_err() {
        eprintln!("skipped: there is no CMake");
        return;
    }
    let folder = Folder::new();
    let build = folder.path("build");
    let run = |command: &mut Command| {
        let done = command.output().expect("CMake runs");
        let text = [done.stdout, done.stderr].concat();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&text));
    };
    run(Command::new(&cmake)
        .arg("-S")
        .arg(root().join("examples/controller-cpp"))
        .arg("-B")
        .arg(&build)
        .arg(format!("-DPhalanx_DIR={}", root().join("capi/cmake").display()))
        .arg(format!("-DPHALANX_LIBRARY={}", library_folder().join("libphalanx.so").display())));
    run(Command::new(&cmake).arg("--build").arg(&build));
    let swap = format!("controller.3={}", build.join("controller").display());
    assert_eq!(digest(&folder, &[swap]), digest(&folder, &[]));
}
