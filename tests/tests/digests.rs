//! Golden digests: the samples of short runs, to be held against on any machine and after any change.

use std::collections::BTreeMap;
use std::path::Path;

use formation::scenario::Selection;
use formation::wiring::Assembly;
use orchestrator::run::placement::Placement;
use orchestrator::run::{Options, run};
use recording::Log;
use schemes::{ROLES, SCENARIOS};

/// Steps of every run.
const STEPS: f64 = 100.0;
/// Environment variable that has the file written anew.
const BLESS: &str = "PHALANX_BLESS";

/// The digest of the samples of the first steps of a scenario's default variant.
fn digest(name: &str) -> String {
    let shipped = SCENARIOS.iter().find(|shipped| shipped.name == name).expect("a shipped scenario");
    let load = |overrides| {
        let selection = Selection { overrides, ..Selection::default() };
        Assembly::load(shipped.file, shipped.text, &selection, &ROLES)
            .unwrap_or_else(|problems| panic!("{}", problems[0]))
    };
    let dt = load(Vec::new()).scenario.context.timing.dt;
    // Whole nanoseconds, as a scenario demands.
    let duration = (STEPS * dt * 1e9).round() / 1e9;
    let assembly = load(vec![format!("timing.duration={duration}")]);
    let path = std::env::temp_dir().join(format!("phalanx-digest-{}-{name}.mcap", std::process::id()));
    let outcome = run(&assembly, &Options::new(Placement::Single, Some(path.clone())), |_| {}).expect("it starts");
    assert!(outcome.ending.is_whole(), "{name}: {:?}", outcome.ending);
    let digest = Log::open(&path).expect("its log").digest();
    std::fs::remove_file(path).expect("its log is removed");
    digest
}

/// To accept what comes out now: `PHALANX_BLESS=1 cargo test --release -p tests --test digests`.
#[test]
fn short_runs_give_the_known_samples() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("digests.toml");
    let found: BTreeMap<&str, String> = SCENARIOS.iter().map(|shipped| (shipped.name, digest(shipped.name))).collect();
    let lines: String = found.iter().map(|(name, digest)| format!("{name} = \"{digest}\"\n")).collect();
    let text = format!(
        "# SHA-256 of the samples of the first 101 steps of every scenario's default variant; see tests/tests/digests.rs.\n\n{lines}"
    );
    if std::env::var_os(BLESS).is_some() {
        std::fs::write(&path, text).expect("the file can be written");
        return;
    }
    let known = std::fs::read_to_string(&path).expect("the golden digests");
    let differ = differences(&lines, &known);
    assert!(differ.is_empty(), "{}", differ.join("\n"));
}

/// What does not agree between the lines `name = "digest"` of today and those of a file, whose comments do not count.
fn differences(found: &str, known: &str) -> Vec<String> {
    fn entry(line: &str) -> Option<(&str, &str)> {
        line.split_once(" = ").filter(|_| !line.starts_with('#'))
    }
    let [found, known] = [found, known].map(|text| text.lines().filter_map(entry).collect::<BTreeMap<_, _>>());
    let of_scenario = |(name, digest): (&&str, &&str)| match known.get(name) {
        Some(expected) if expected == digest => None,
        Some(expected) => Some(format!("the samples of {name} have changed: {digest}, expected {expected}")),
        None => Some(format!("{name} has no golden digest; if its samples are right, add the line {name} = {digest}")),
    };
    let gone = known.keys().filter(|name| !found.contains_key(*name));
    let gone = gone.map(|name| format!("the digest of {name} belongs to no scenario; remove the line"));
    found.iter().filter_map(of_scenario).chain(gone).collect()
}

#[test]
fn a_digest_that_is_missing_changed_or_left_over_is_named() {
    assert_eq!(differences("a = \"1\"\n", "# comment\n\na = \"1\"\n"), Vec::<String>::new());
    for (known, word) in
        [("", "a has no golden digest"), ("a = \"2\"", "a have changed"), ("a = \"1\"\nb = \"1\"", "digest of b")]
    {
        let found = differences("a = \"1\"\n", known);
        assert!(found.len() == 1 && found[0].contains(word), "{found:?}");
    }
}
