//! The files of a project.

use std::path::Path;

use formation::config::read_text;
use formation::wiring::{Assembly, Role};

use super::order::{File, Language, Order};
use super::signals::{Signal, Signals};
use super::source::{self, Source};
use super::{cpp, fill, python, rust};
use crate::failure::Failure;
use crate::terminal::quoted;

/// Writes the project into a new folder of its name, and returns what to do next, in words.
///
/// # Errors
/// [`Failure::Usage`] if the name is invalid, the folder exists, what it is built with is missing, or the scenario has no such participant;
/// [`Failure::System`] if a file cannot be written.
pub fn create(order: &Order, assembly: &Assembly) -> Result<String, Failure> {
    let Order { name, role, .. } = order;
    let letters = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-');
    if !letters || !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        return Err(Failure::Usage(format!("{name}: a name consists of a-z, 0-9, _ and -, and starts with a letter")));
    }
    let folder = Path::new(name);
    if folder.exists() {
        return Err(Failure::Usage(format!("{name} exists already; choose another name")));
    }
    let named = order.phalanx.as_deref().map(std::path::absolute).transpose();
    let named = named.map_err(Failure::system("find the current folder"))?;
    let source = source::find(order.language, named.as_deref(), &order.program, &order.built_from)?;
    let phalanx = source.folder().display().to_string();
    let signals = Signals::of(assembly, *role).map_err(Failure::Usage)?;
    let scenario = &order.scenario;
    let article = if role.name() == "observer" { "An" } else { "A" };
    let title = format!(
        "{article} {role} for the scenario {scenario}, in the place of {}.",
        signals.node.replacen('_', ".", 1)
    );
    let (files, build, command) = match order.language {
        Language::Rust => {
            let files = rust::files(order, &signals, &title, &phalanx);
            (files, "cargo build --release".to_string(), format!("./target/release/{name}"))
        }
        Language::Cpp => {
            let build = "cmake -B build && cmake --build build".to_string();
            (cpp::files(order, &signals, &title, &phalanx), build, format!("./build/{name}"))
        }
        Language::Python => {
            let (build, interpreter) = match &source {
                Source::Checkout(_) => {
                    (format!("pip install {}", quoted(&format!("{phalanx}/python"))), "python3".into())
                }
                Source::Installed(package) => (format!("# the package is there: {phalanx}"), interpreter(package)),
            };
            (python::files(&signals, &title), build, format!("{interpreter} main.py"))
        }
    };
    let lock = read_text(&Path::new(&phalanx).join("Cargo.lock")).ok();
    // The versions of all packages that Phalanx was tried with.
    let lock = lock.filter(|_| order.language == Language::Rust).map(|text| File::new("Cargo.lock", text));
    let readme = readme(order, &signals, &title, &build, &command);
    for file in files.iter().chain(&lock).chain([&File::new("README.md", readme)]) {
        let path = folder.join(file.path);
        let parent = path.parent().unwrap_or(folder);
        let failed = || Failure::system(format!("write {}", path.display()));
        std::fs::create_dir_all(parent).map_err(failed())?;
        std::fs::write(&path, &file.text).map_err(failed())?;
    }
    let node = signals.node.replacen('_', ".", 1);
    Ok(format!(
        "{name} is there. {}Next:\n    cd {name}\n    {build}\n    phalanx conform {node} --scenario {scenario} -- {command}\n    \
         phalanx run {scenario} --swap \"{node}={command}\"",
        what_it_does(&signals, *role)
    ))
}

/// How a shell calls the Python that an installed package belongs to: `python3`, unless that is another one.
fn interpreter(package: &Path) -> String {
    // PREFIX/lib/python3.12/site-packages/phalanx
    let own = package.ancestors().nth(4).map(|prefix| prefix.join("bin/python3")).filter(|path| path.is_file());
    let path = std::env::var_os("PATH").unwrap_or_default();
    let usual = std::env::split_paths(&path).map(|folder| folder.join("python3")).find(|path| path.is_file());
    match own {
        Some(own) if Some(&own) != usual.as_ref() => quoted(&own.to_string_lossy()),
        _ => "python3".into(),
    }
}

/// What the program does as it is written, so that a run of a placeholder surprises no user.
fn what_it_does(signals: &Signals, role: Role) -> &'static str {
    match (signals.drives_accelerations, role) {
        (true, _) => "Its law tracks the reference. ",
        (false, Role::Controller) => {
            "It has no law yet: it keeps the contract, but its inputs do not control the vehicle, so a run with it reaches no goal \
             until you write one. "
        }
        (false, _) => {
            "It computes placeholders: it keeps the contract, but a run with it reaches no goal until you write the rest. "
        }
    }
}

fn readme(order: &Order, signals: &Signals, title: &str, build: &str, command: &str) -> String {
    let row = |signal: &Signal, is_input: bool| {
        let of = if is_input { format!(" of the {}", signal.role) } else { String::new() };
        format!("| `{}`{of} | {} | {} |", signal.name, signal.length, signal.unit)
    };
    let rows = |signals: &[Signal], is_input: bool| {
        signals.iter().map(|signal| row(signal, is_input)).collect::<Vec<_>>().join("\n")
    };
    let others = match signals.others.as_slice() {
        [] => String::new(),
        topics => format!("\nIt may read these, too: {}.\n", topics.join(", ")),
    };
    fill(
        include_str!("../../../templates/README.md.txt"),
        &[
            ("name", order.name.clone()),
            ("title", title.into()),
            ("does", what_it_does(signals, order.role).trim_end().into()),
            ("build", build.into()),
            ("node", signals.node.replacen('_', ".", 1)),
            ("options", format!("--scenario {} ", order.scenario)),
            ("scenario", order.scenario.clone()),
            ("command", command.into()),
            ("inputs", rows(&signals.inputs, true)),
            ("outputs", rows(&signals.outputs, false)),
            ("others", others),
        ],
    )
}
