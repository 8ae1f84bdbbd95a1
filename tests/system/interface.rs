//! What programs of users can ask for, where their files are looked for, and what is said if they cannot be started.

use serde_json::Value;

use crate::own_programs::{compile, library_folder, python, root};
use crate::program::{Finished, Folder};

/// A scenario that leaves much to defaults.
fn scenario() -> String {
    let text = std::fs::read_to_string(root().join("scenarios/triangle.toml")).expect("the triangle");
    text.replace("[reference]", "[parameters]\nhalf = \"1/2\"\n\n[reference]")
        .replace("duration = 20", "duration = 2")
        .replace("matched = [\"0.1*sin(t)\", \"0.1*cos(t)\", \"0\"]", "matched = [\"t\", \"px + vy\", \"i\"]")
}

#[test]
fn a_program_asks_for_what_is_in_force() {
    let folder = Folder::new();
    folder.write("mine.toml", &scenario());
    let program = compile(&folder, "tests/system/programs/ask.c", "ask");
    let swap = format!("controller.1={program}");
    let run = folder.run(&["run", "mine.toml", "-q", "--set", "assert=[]", "--swap", &swap]);
    assert_eq!(run.code(), 0, "{}", run.stderr());
    for line in [
        "agents.2.position.3 1.5707963267948966",
        "topology.A.1.3 1",
        "topology.A.1.2 0",
        "topology.b.2 1",
        "controller.k_v 2",
        "controller.every 1",
        "timing.dt 0.01",
        "parameters.half 0.5",
        "weight 1 0 b 1",
        "neighbours 1 first 3",
        "disturbance 3: 1.5 5 2",
        "mismatched 0 0 0",
        "error the scenario has no number called `controller.k_q`; did you mean `controller.k_v`?",
        "later there is no agent 9; the scenario has 3, counted from 1",
    ] {
        assert!(run.stderr().lines().any(|found| found.ends_with(line)), "{line}\n{}", run.stderr());
    }
}

#[test]
fn defaults_of_a_component_can_be_read() {
    let folder = Folder::new();
    // `k_v` of `consensus` has a default, which this file leaves.
    folder.write("mine.toml", &scenario().replace("k_v = 2\n", ""));
    let program = compile(&folder, "tests/system/programs/ask.c", "ask");
    let swap = format!("controller.1={program}");
    let run = folder.run(&["run", "mine.toml", "-q", "--set", "assert=[]", "--swap", &swap]);
    assert!(run.stderr().contains("controller.k_v 0"), "{}", run.stderr());
}

#[test]
fn paths_of_a_scenario_start_from_its_folder() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sub")).expect("a folder");
    compile(&folder, "tests/system/programs/ask.c", "sub/ask");
    folder.write("sub/mine.toml", &format!("{}\n[swap]\n\"controller.1\" = \"./ask\"\n", scenario()));
    for placement in [&[][..], &["--placement", "single"]] {
        let run = folder.run(&[&["run", "sub/mine.toml", "-q", "--json", "--set", "assert=[]"], placement].concat());
        assert_eq!(run.code(), 0, "{}", run.stderr());
        // One process for ours, one for the program, one for the orchestrator.
        let processes = if placement.is_empty() { 6 } else { 3 };
        assert_eq!(run.json()["processes"], processes);
    }
    std::fs::rename(folder.path("sub/ask"), folder.path("ask")).expect("another place");
    let run = folder.run(&["run", "sub/mine.toml", "-q"]);
    assert_eq!(run.code(), 2);
    let stderr = run.stderr();
    assert!(
        stderr.contains("controller_1: there is no program") && stderr.contains("folder of the scenario file"),
        "{stderr}"
    );
}

#[test]
fn a_folder_and_a_file_that_is_no_program_are_named() {
    let folder = Folder::new();
    assert_eq!(folder.run(&["new", "controller", "mine", "--lang", "python"]).code(), 0);
    folder.write("text.py", "");
    for (program, words) in [
        ("./mine", "./mine is a folder, not a program; the program in it is `python3 ./mine/main.py`"),
        ("./text.py", "./text.py is not executable: `chmod +x ./text.py`"),
    ] {
        let swap = format!("controller.1={program}");
        for arguments in [&["run", "triangle", "--swap", &swap][..], &["conform", "controller.1", "--", program]] {
            let refused = folder.run(arguments);
            assert!(refused.code() == 2 && refused.stderr().contains(words), "{}", refused.stderr());
        }
    }
}

#[test]
fn the_commands_of_a_new_project_work_in_its_folder() {
    let folder = Folder::new();
    folder.write("my triangle.toml", &scenario());
    let new = folder.run(&["new", "controller", "mine", "--lang", "cpp", "--scenario", "my triangle.toml"]);
    assert_eq!(new.code(), 0, "{}", new.stderr());
    assert!(new.stdout().contains("--scenario '../my triangle.toml'"), "{}", new.stdout());
    let readme = std::fs::read_to_string(folder.path("mine/README.md")).expect("a README");
    assert!(readme.contains("phalanx run '../my triangle.toml' --swap"), "{readme}");
}

/// The law of a new controller works on the scenario that it is made for.
#[test]
fn new_controllers_fly() {
    let folder = Folder::new();
    let flies = |swap: &str| {
        let mut run = folder.phalanx(&["run", "triangle", "-q", "--swap", swap]);
        run.env("PYTHONPATH", root().join("python/src"));
        run.env("PHALANX_LIBRARY", library_folder().join("libphalanx.so"));
        let run = Finished(run.output().expect("the program starts"));
        assert_eq!(run.code(), 0, "{swap}: {}{}", run.stdout(), run.stderr());
    };
    assert_eq!(folder.run(&["new", "controller", "cpp", "--lang", "cpp"]).code(), 0);
    let source = folder.path("cpp/main.cpp");
    let program = compile(&folder, source.to_str().expect("a path"), "flier");
    flies(&format!("controller.2={program}"));
    if let Some(python) = python() {
        assert_eq!(folder.run(&["new", "controller", "py", "--lang", "python"]).code(), 0);
        flies(&format!("controller.3={python} {}", folder.path("py/main.py").display()));
    }
}

/// The program in C++ that the documentation prints.
#[test]
fn printed_programs_in_cpp_fly() {
    let folder = Folder::new();
    for page in ["docs/adding-a-controller.md", "capi/include/phalanx.hpp"] {
        let text = std::fs::read_to_string(root().join(page)).expect("a page");
        let program = if page.ends_with(".md") {
            let shown = text.split("```cpp\n").nth(1).and_then(|rest| rest.split("```").next());
            shown.expect("a program").to_string()
        } else {
            let lines = text.lines().skip_while(|line| !line.contains("int main()"));
            let lines = lines.take_while(|line| line.starts_with("//     "));
            format!("#include <phalanx.hpp>\n{}", lines.map(|line| format!("{}\n", &line[2..])).collect::<String>())
        };
        let source = folder.write("printed.cpp", &program);
        let program = compile(&folder, source.to_str().expect("a path"), "printed");
        let run = folder.run(&["run", "triangle", "-q", "--swap", &format!("controller.3={program}")]);
        assert_eq!(run.code(), 0, "{page}: {}{}", run.stdout(), run.stderr());
    }
}

fn points(report: &Value, verdict: &str) -> Vec<String> {
    let points = report["points"].as_array().expect("points").iter().filter(|point| point["verdict"] == verdict);
    points.map(|point| point["name"].as_str().expect("a name").to_string()).collect()
}

/// Conforms a program that a shell runs.
fn conform(folder: &Folder, script: &str, more: &[&str]) -> (i32, Value) {
    let arguments = ["conform", "controller.1", "--steps", "20", "--json"];
    let tried = folder.run(&[&arguments[..], more, &["--", "sh", "-c", script]].concat());
    (tried.code(), tried.json())
}

#[test]
fn nothing_passes_for_a_program_that_dies_at_import() {
    let folder = Folder::new();
    let (code, report) = conform(&folder, "echo ImportError: no module named nosuch >&2; exit 1", &[]);
    assert_eq!((code, points(&report, "fail"), points(&report, "pass")), (1, vec!["start".into()], Vec::new()));
    assert!(report["points"][0]["finding"].as_str().expect("text").contains("no module named nosuch"), "{report:#}");
    let (code, report) = conform(&folder, "exec sleep 60", &["--patience", "1"]);
    assert_eq!((code, points(&report, "fail"), points(&report, "pass")), (1, Vec::new(), Vec::new()));
    assert!(report["points"][0]["finding"].as_str().expect("text").contains("still starting"), "{report:#}");
    assert!(report["points"][0]["advice"].as_str().expect("text").contains("--patience"), "{report:#}");
}

#[test]
fn outputs_that_are_not_bound_conform() {
    let folder = Folder::new();
    let program = compile(&folder, "tests/system/programs/ask.c", "ask");
    folder.write("mine.toml", &scenario());
    let tried = folder.run(&["conform", "controller.1", "--scenario", "mine.toml", "--steps", "30", "--", &program]);
    assert_eq!(tried.code(), 0, "{}{}", tried.stdout(), tried.stderr());
    assert!(tried.stdout().contains("always 0, as what is not bound: error"), "{}", tried.stdout());
}

#[test]
fn an_output_that_a_program_binds_and_does_not_write_is_named_at_step_0() {
    let folder = Folder::new();
    let source = folder.write(
        "half.c",
        "#include <phalanx.h>\nint main(void) {\nphalanx_participant *me = phalanx_open(\"controller\");\n\
         const int input = phalanx_output(me, 0, \"input\", 3);\nphalanx_output(me, 0, \"error\", 3);\n\
         while (phalanx_next(me)) {\ndouble *u = phalanx_write(me, input);\nfor (int j = 0; j < 3; ++j) u[j] = 0.0;\n\
         phalanx_done(me);\n}\nreturn phalanx_close(me);\n}\n",
    );
    let program = compile(&folder, source.to_str().expect("a path"), "half");
    let run = folder.run(&["run", "triangle", "-q", "--swap", &format!("controller.3={program}")]);
    assert_eq!(run.code(), 3);
    let told = "controller_3 at step 0: output /agent_3/command: error[0] is NaN: it was not written";
    assert!(run.stderr().contains(told), "{}", run.stderr());
}

#[test]
fn a_wrong_output_is_answered_with_those_that_there_are() {
    let folder = Folder::new();
    let source = folder.write(
        "wrong.cpp",
        "#include <phalanx.hpp>\nint main() { return phalanx::serve(\"controller\", [](phalanx::Participant &me) { me.out<3>(\"inptu\"); }); }\n",
    );
    let program = compile(&folder, source.to_str().expect("a path"), "wrong");
    let run = folder.run(&["run", "triangle", "-q", "--swap", &format!("controller.3={program}")]);
    assert_eq!(run.code(), 3);
    assert!(run.stderr().contains("of agent 3; it declares input (3), error (3)"), "{}", run.stderr());
}
