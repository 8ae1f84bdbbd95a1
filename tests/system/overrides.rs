//! Every field at the top of a scenario can be set from the command line, whether its file has the field or not.

use crate::program::Folder;

/// Fields at the top that most files leave out, with admissible values.
const FIELDS: &[&str] = &[
    "seed=3",
    "title=another",
    "metrics=",
    "assert=[]",
    "assert=[{name='a', metric='gap', min=-100}]",
    "on_failure=restart",
    "on_failure=hold",
    "ranges={'command.input'={max=1e9}}",
    "any_graph=true",
    "topology.any_graph=true",
];

#[test]
fn a_field_that_the_file_does_not_have_can_be_set() {
    let folder = Folder::new();
    let list = folder.run(&["list", "--json"]).json();
    for scenario in list.as_array().expect("a list") {
        let name = scenario["name"].as_str().expect("a name");
        for field in FIELDS {
            let end = folder.run(&["validate", name, "--set", field]);
            assert_eq!(end.code(), 0, "{name}, {field}: {}", end.stderr());
        }
        let end = folder.run(&["validate", name, "--seed", "5"]);
        assert_eq!(end.code(), 0, "{name}: {}", end.stderr());
    }
}

#[test]
fn a_field_that_no_scenario_has_is_refused() {
    let folder = Folder::new();
    for (field, hint) in [("sed=3", "`seed`"), ("timing.dtt=1", "timing.dtt: unknown field"), ("asert=[]", "`assert`")]
    {
        let end = folder.run(&["validate", "triangle", "--set", field]);
        assert!(end.code() == 2 && end.stderr().contains(hint), "{field}: {}", end.stderr());
    }
}
