//! Figures for a paper, as a reader and a journal see them.

use std::path::PathBuf;
use std::process::Command;

use crate::look::{short_run, succeeds};
use crate::program::Folder;

/// A Python with `tests/python/requirements.txt`, if there is one.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("PHALANX_PYTHON").map(PathBuf::from);
    if python.is_none() {
        eprintln!("skipped in part: PHALANX_PYTHON does not name a Python with tests/python/requirements.txt");
    }
    python
}

/// What `tests/python/read_figure.py` finds in a PDF.
fn read(python: &PathBuf, file: &PathBuf) -> String {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/python/read_figure.py");
    let output = Command::new(python).arg(script).arg(file).output().expect("Python runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
fn figures_are_vectors_or_pixels() {
    let folder = short_run("rca");
    let written = succeeds(&folder, &["report", "run.mcap", "--figures", "figures"]).stdout();
    for line in written.lines() {
        let svg = std::fs::read_to_string(folder.path(line)).expect("a figure");
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{line}");
        // Letters are outlines: no machine has to have a font.
        assert!(!svg.contains("<text") && !svg.contains("font"), "{line}");
        assert!(
            svg.contains("width=\"3.500in\"") && svg.contains("aria-label=\"time [s]\"") != line.contains("traj"),
            "{line}"
        );
        // Flags are one black line for each agent.
        assert!(svg.contains("stroke-dasharray") || line.contains("flags"), "{line}");
    }
    assert!(written.contains("figures/ch3-tracking-errors.svg"), "{written}");
    let written = succeeds(&folder, &["report", "run.mcap", "--figures", "figures", "--format", "png"]).stdout();
    for line in written.lines() {
        let png = std::fs::read(folder.path(line)).expect("a figure");
        assert!(png.starts_with(b"\x89PNG"), "{line}");
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().expect("four bytes"));
        assert_eq!(number(16), 2100, "{line}: 3.5 inches of 600 pixels");
        let place = png.windows(4).position(|word| word == b"pHYs").expect("how large a pixel is");
        assert_eq!(number(place + 4), 23_622, "{line}: pixels of a metre");
    }
}

#[test]
fn letters_have_the_size_and_the_font_that_are_asked_for() {
    let folder = short_run("uav");
    let figure = |look: &[&str]| {
        let arguments = [&["report", "run.mcap", "--figures", "figures", "--format", "pdf"], look].concat();
        let written = succeeds(&folder, &arguments).stdout();
        let name = written.lines().find(|line| line.contains("tracking-error")).expect("a figure");
        let path = folder.path(name);
        let bytes = std::fs::read(&path).expect("the figure");
        assert!(bytes.starts_with(b"%PDF-1.") && bytes.trim_ascii_end().ends_with(b"%%EOF"));
        path
    };
    let first = std::fs::read(figure(&[])).expect("the figure");
    assert_eq!(std::fs::read(figure(&[])).expect("the figure"), first, "the same log gives the same figure");
    let Some(python) = python() else { return };
    let text = read(&python, &figure(&[]));
    assert!(text.starts_with("3.50 x ") && text.contains("agent 6") && text.contains("time [s]"), "{text}");
    // Scripts have three quarters of the size; nothing else is smaller than 8 points.
    assert!(text.contains("\npoints: 6.00 8.00\n"), "{text}");
    assert!(text.contains("\nfonts: /FIGURE+LiberationSans /FIGURE+LiberationSans-Italic\n"), "{text}");
    let text = read(&python, &figure(&["--font", "times", "--font-size", "10", "--width", "7.16"]));
    assert!(text.starts_with("7.16 x ") && text.contains("\npoints: 7.50 10.00\n"), "{text}");
    assert!(text.contains("\nfonts: /FIGURE+LiberationSerif /FIGURE+LiberationSerif-Italic\n"), "{text}");
}

#[test]
fn looks_that_cannot_be_are_refused() {
    let folder = short_run("uav");
    for (arguments, words) in [
        (&["--font", "times"][..], "--figures"),
        (&["--figures", "figures", "--font", "comic"], "helvetica"),
        (&["--figures", "figures", "--font-size", "2"], "from 4 to 24"),
        (&["--figures", "figures", "--width", "wide"], "expected a number"),
    ] {
        let finished = folder.run(&[&["report", "run.mcap"], arguments].concat());
        assert_eq!(finished.code(), 2, "{arguments:?}");
        assert!(finished.stderr().contains(words), "{arguments:?}: {}", finished.stderr());
    }
}

#[test]
fn figures_of_the_thesis_go_by_their_numbers_and_tell_what_was_changed() {
    let folder = Folder::new();
    let run = |arguments: &[&str]| {
        let all = [&["run", "mixed", "--placement", "single", "-q", "--out", "run.mcap"], arguments].concat();
        assert!(folder.run(&all).code() <= 1);
        succeeds(&folder, &["report", "run.mcap", "--figures", "figures"]).stdout()
    };
    let written = run(&[]);
    assert!(written.contains("figures/fig-7-14-high-level-controller.svg\n"), "{written}");
    assert!(written.contains("figures/fig-7-18-trajectories.svg\n"), "{written}");
    assert!(!written.contains("fig-7-03"), "that one is about the drones: {written}");
    let written = run(&["--duration", "3"]);
    assert!(!written.contains("fig-7-14-high-level-controller.svg"), "{written}");
    let name = "figures/fig-7-14-high-level-controller-overridden.svg";
    assert!(written.contains(name), "{written}");
    let svg = std::fs::read_to_string(folder.path(name)).expect("the figure");
    assert!(svg.contains("overridden: ") && svg.contains("timing.duration = 3"), "{svg}");
}

#[test]
fn a_changed_copy_of_a_scenario_has_no_figures_of_the_thesis_without_a_mark() {
    let folder = Folder::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/mixed.toml");
    let text = std::fs::read_to_string(shipped).expect("the scenario");
    let changed = text.replacen("duration = ", "duration = 2 # ", 1);
    assert_ne!(text, changed);
    folder.write("mixed.toml", &changed);
    folder.run(&["run", "mixed.toml", "--placement", "single", "-q", "--out", "run.mcap"]);
    let written = succeeds(&folder, &["report", "run.mcap", "--figures", "figures"]).stdout();
    let marked = |name: &str| !name.contains("/fig-") || name.ends_with("-overridden.svg");
    assert!(written.lines().all(marked), "{written}");
}

#[test]
fn figures_that_compare_want_all_their_runs() {
    let folder = Folder::new();
    let run = |variant: &str| {
        let out = format!("{variant}.mcap");
        let arguments = ["run", "rca", "--variant", variant, "--duration", "1", "--no-check", "--placement", "single"];
        succeeds(&folder, &[&arguments[..], &["-q", "--out", &out]].concat());
    };
    run("SMC");
    let alone = succeeds(&folder, &["report", "SMC.mcap", "--figures", "figures"]);
    assert!(alone.stderr().contains("figure 3.7 needs also `phalanx run rca --variant RCABSMC`"), "{}", alone.stderr());
    run("RCABSMC");
    let both = succeeds(&folder, &["report", "SMC.mcap", "RCABSMC.mcap", "--figures", "figures"]);
    let name = "figures/fig-3-07-absolute-tracking-errors-overridden.svg";
    assert!(both.stdout().contains(name), "{}", both.stdout());
    let svg = std::fs::read_to_string(folder.path(name)).expect("the figure");
    assert!(svg.contains("width=\"3.500in\"") && svg.contains("aria-label=\"RCABSMC\""));
    // A row for every agent.
    assert!(svg.contains("aria-label=\"Δ1 [m s, rad s]\"") && svg.contains("aria-label=\"Δ5 [m s, rad s]\""));
}

#[test]
fn matplotlib_draws_the_same_figure_from_script_and_data() {
    let folder = short_run("uav");
    let arguments = ["report", "run.mcap", "--figures", "figures", "--format", "matplotlib", "--font", "times"];
    let written = succeeds(&folder, &arguments).stdout();
    let scripts: Vec<&str> = written.lines().filter(|line| line.contains("/fig-7-")).collect();
    assert!(scripts.iter().all(|line| line.ends_with(".py")), "{written}");
    let data = std::fs::read_to_string(folder.path(&scripts[0].replace(".py", ".csv"))).expect("the data");
    assert!(data.starts_with("plot,line,x,y\n0,0,0,"), "{}", &data[..80]);
    let Some(python) = python() else { return };
    // Curves with scripts and accents, and both views of trajectories.
    for name in ["observer", "trajectories", "inputs-TSC"] {
        let script = scripts.iter().find(|line| line.contains(name)).expect("a script");
        let output = Command::new(&python).arg(folder.path(script)).output().expect("Python runs");
        let complaints = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !complaints.contains("font family"), "{complaints}");
        let text = read(&python, &folder.path(&script.replace(".py", ".pdf")));
        assert!(text.starts_with("3.50 x ") && text.contains("overridden"), "{text}");
    }
}
