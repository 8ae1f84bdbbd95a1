//! The headline of the project: every regression range and every claim of every scenario, a test for each so that a failure has a
//! name; and that every number that does not meet the thesis says why.

use std::collections::BTreeSet;
use std::path::Path;

use formation::scenario::Published;
use orchestrator::campaign::{Campaign, as_markdown, run_all};
use schemes::SCENARIOS;

/// The page that holds the results of all scenarios.
const PAGE: &str = include_str!("../../docs/thesis-results.md");

/// Runs all variants of the scenario and the runs that its claims need; every regression range, assertion and claim must hold, every
/// statement that is not met must have a reason and no other one, every metric a definition, and every row must stand in the page of
/// results.
fn check(scenario: &str) {
    let folder = std::env::temp_dir().join(format!("phalanx-campaign-{}-{scenario}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the logs");
    let campaign =
        run_all(&thesis::catalog(schemes::ROLES, schemes::SCENARIOS), &[scenario.to_string()], &folder, |_, _, _| {})
            .expect("every run can be carried out");
    std::fs::remove_dir_all(&folder).expect("the logs are removed");
    let missed = missed(&campaign);
    assert!(campaign.ok() && missed.is_empty(), "{}", missed.join("\n"));
    let unclear = unclear(&campaign);
    assert!(unclear.is_empty(), "{}", unclear.join("\n"));
    let text = as_markdown(&campaign, "");
    let known: BTreeSet<&str> = PAGE.lines().collect();
    let missing: Vec<&str> = text.lines().filter(|line| line.starts_with("| ") && !known.contains(line)).collect();
    assert!(
        missing.is_empty(),
        "docs/thesis-results.md is out of date (phalanx thesis --format markdown --out docs/thesis-results.md):\n{}",
        missing.join("\n")
    );
}

/// What does not hold, in words.
fn missed(campaign: &Campaign) -> Vec<String> {
    let mut missed = Vec::new();
    for (job, result) in campaign.own_runs() {
        let Some(verdict) = &result.verdict else {
            missed.push(format!("{}: no metrics ({:?})", job.name(), result.stopped));
            continue;
        };
        let rows = verdict.rows.iter().filter(|row| row.in_range() == Some(false));
        missed.extend(rows.map(|row| format!("{}: {} is {}, not {}", job.name(), row.id, row.value, row.range())));
        missed.extend(result.findings.failure().map(|text| format!("{}: {text}", job.name())));
    }
    let claims = campaign.claims.iter().filter(|claim| !claim.holds);
    missed.extend(claims.map(|claim| format!("{}: {}", claim.scenario, claim.text)));
    missed
}

/// What lacks a reason or a definition, and what has one too many.
fn unclear(campaign: &Campaign) -> Vec<String> {
    let mut unclear = Vec::new();
    let verdicts = campaign.own_runs();
    let verdicts = verdicts.filter_map(|(job, result)| Some((job.name(), result.verdict.as_ref()?)));
    let mut used = BTreeSet::new();
    for (run, row) in verdicts.flat_map(|(run, verdict)| verdict.rows.iter().map(move |row| (run.clone(), row))) {
        let is_not_met = matches!(row.against_thesis(), Published::NotMet(_));
        match (is_not_met, row.expectation.reason.is_empty()) {
            (true, true) => unclear.push(format!("{run}: {} does not meet the thesis, without a reason", row.id)),
            (false, false) => unclear.push(format!("{run}: {} has a reason but needs none", row.id)),
            _ => {}
        }
        match &row.definition {
            Some(definition) => drop(used.insert(definition.id.to_string())),
            None => unclear.push(format!("{run}: {} has no definition", row.id)),
        }
    }
    let scenario = &campaign.selected[0].scenario;
    let set = thesis::SETS.iter().find(|set| set.name == scenario.metrics).expect("its set of metrics");
    // Two scenarios share the set `dsm`, and each has metrics that the other one does not.
    let shared = schemes::SCENARIOS.iter().filter(|one| set.serves(one)).count();
    let idle = set.definitions.iter().filter(|definition| shared == 1 && !used.contains(definition.id.as_ref()));
    unclear.extend(idle.map(|definition| format!("{}: no run has the metric {}", scenario.name, definition.id)));
    unclear
}

macro_rules! campaigns {
    ($($test:ident: $scenario:literal),* $(,)?) => {
        $(
            #[test]
            fn $test() {
                check($scenario);
            }
        )*

        #[test]
        fn every_scenario_has_its_test() {
            let tested = [$($scenario),*];
            // Those of the documentation claim nothing.
            let claims = |shipped: &&formation::scenario::Shipped| shipped.text.contains("\n[expect");
            let shipped: Vec<&str> = SCENARIOS.iter().filter(claims).map(|shipped| shipped.name).collect();
            assert_eq!(shipped, tested);
        }
    };
}

campaigns! {
    dsm_ftdo: "dsm-ftdo",
    dsm_cnn: "dsm-cnn",
    rca: "rca",
    limited_information: "limited-information",
    cida: "cida",
    compensated: "compensated",
    compensated_experiment: "compensated-experiment",
    lp_regulation: "lp-regulation",
    uav: "uav",
    mixed: "mixed",
}

#[test]
fn the_page_of_results_is_of_this_program() {
    assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/thesis-results.md").is_file());
    assert!(PAGE.lines().filter(|line| line.starts_with('|')).count() > 500, "the page lost its tables");
}
