use formation::config::Problem;
use formation::formula::Condition;
use formation::scenario::{Scenario, Selection};
use proptest::prelude::*;

use super::metric::Metrics;
use super::{Claim, Claims};
use schemes::SCENARIOS;

/// A scenario with the variants A, B-2 and `C (old)`.
fn scenario(claims: &str) -> Scenario {
    let text = format!(
        "name = \"sample\"\nvariant = \"A\"\nagents = [{{ position = [0, 0, 0] }}]\nclaims = {claims}\n\
         [timing]\ndt = 0.1\nduration = 1\n[vehicle]\nkind = \"integrator\"\n[topology]\nb = 1\n\
         [reference]\nposition = [0, 0, 0]\n[variants.B-2]\n[variants.\"C (old)\"]\n"
    );
    Scenario::load("sample.toml", &text, &Selection::default()).unwrap_or_else(|problems| panic!("{}", problems[0]))
}

fn one(holds: &str) -> Result<Claim, Problem> {
    let claims = Claims::read(&scenario(&format!("[{{ text = \"c\", holds = '{holds}' }}]")))?;
    Ok(claims.into_iter().next().expect("a claim"))
}

fn lookup(variant: &str, metric: &str) -> Option<f64> {
    match (variant, metric) {
        ("A", "dx") => Some(2.0),
        ("A", "t_δ") => Some(5.0),
        ("A", "wt_t(1.12e-2)") => Some(0.25),
        ("B-2", "dx") => Some(6.0),
        ("C (old)", "dx") => Some(f64::NAN),
        _ => None,
    }
}

#[track_caller]
fn check(holds: &str, expected: bool) {
    let claim = one(holds).unwrap_or_else(|problem| panic!("{problem}"));
    let result = claim.evaluate(&lookup);
    assert_eq!(result.verdict, Ok(expected), "{holds}: {:?}", result.comparisons);
}

#[track_caller]
fn refuse(holds: &str, part: &str) {
    let problem = one(holds).expect_err(holds);
    let shown = problem.to_string();
    assert!(shown.contains(part), "{holds}: {shown}");
    assert!(shown.starts_with("sample.toml:4:") && shown.contains("claims.1.holds: "), "{shown}");
}

#[test]
fn comparisons_and_arithmetic() {
    check("dx(B-2) >= 3*dx(A)", true);
    check("dx(B-2) > 3*dx(A)", false);
    check("dx(B-2)/dx(A) - 1 <= 2e0", true);
    check("-dx(A) < 0", true);
    check("2 - 3 - 4 < -4.5", true);
    check("2 + 3 * 4 > 13.9", true);
    check("(2 + 3) * 4 > 19.9", true);
    check("8 / 4 / 2 < 1.5", true);
    check("abs(dx(A) - dx(B-2)) <= 4", true);
    check("min(dx(A), dx(B-2), 7) >= 2", true);
    check("max(dx(A), dx(B-2)) <= 5", false);
    check("1 <= dx(A) <= 3 < dx(B-2)", true);
    check("1 <= dx(A) <= 1.5 < dx(B-2)", false);
}

#[test]
fn unusual_names_are_quoted() {
    check("`wt_t(1.12e-2)`(A) < 0.3", true);
    check("t_δ(A) < 6 and `t_δ`( `A` ) < 6 and dx ( B-2 ) > 5", true);
    check("not_finite(dx(`C (old)`))", true);
}

/// What did not come out is neither below nor above anything.
#[test]
fn not_a_number_fails_every_comparison() {
    check("dx(`C (old)`) < 1 or dx(`C (old)`) >= 1", false);
    check("min(dx(`C (old)`), 1) < 2 or max(1, dx(`C (old)`)) > 0", false);
    check("not_finite(1/0) and not_finite(dx(`C (old)`) + 1)", true);
    check("not_finite(dx(A))", false);
}

#[test]
fn both_sides_are_reported_as_written() {
    let claim = one("1 < dx(A)  and (dx(B-2) >= 100 * dx(A) or not_finite(dx(A)))").expect("a claim");
    let result = claim.evaluate(&lookup);
    assert!(!result.holds());
    let [first, second, third] = result.comparisons.as_slice() else { panic!("{:?}", result.comparisons) };
    assert_eq!((first.left.value, first.relation, first.holds), (1.0, "<", true));
    let right = second.right.as_ref().expect("a right side");
    assert_eq!((second.left.text.as_str(), second.left.value), ("dx(B-2)", 6.0));
    assert_eq!((right.text.as_str(), right.value, second.holds), ("100 * dx(A)", 200.0, false));
    assert_eq!((third.relation, &third.right, third.holds), ("is not finite", &None, false));
}

#[test]
fn needs_name_each_variant_and_metric_once() {
    let claim = one("dx(B-2) > dx(A) and dx(A) < 3 and t_δ(A) > dx(B-2)").expect("a claim");
    assert_eq!(claim.needs(), ["B-2", "A"]);
    let metrics: Vec<(&str, &str)> = claim.metrics().iter().map(|n| (n.variant.as_str(), n.metric.as_str())).collect();
    assert_eq!(metrics, [("B-2", "dx"), ("A", "dx"), ("A", "t_δ")]);
}

#[test]
fn unknown_metrics_have_no_verdict() {
    let result = one("dx(A) < 3 and speed(A) < 3").expect("a claim").evaluate(&lookup);
    let problem = result.verdict.clone().expect_err("an unknown metric").to_string();
    assert!(problem.contains("sample.toml:4:") && problem.contains("the variant `A` has no metric called `speed`"));
    assert!(!result.holds() && result.comparisons.is_empty());
}

#[test]
fn unknown_variants_are_refused_at_their_place() {
    refuse("1 < dx(B-3)", "no variant is called `B-3`, expected one of: A, B-2, C (old); did you mean `B-2`?");
    refuse("1 < dx(B-3)", "(column 8 of ");
    refuse("t_δ(A) < dx(D)", "(column 13 of ");
}

#[test]
fn malformed_claims_are_refused_at_their_place() {
    refuse("   ", "found an empty text");
    refuse("dx(A)", "found just a number");
    refuse("dx < 3", "expected the variant behind the metric 'dx', as in dx(VARIANT), found '<' (column 4 of ");
    refuse("dx", "as in dx(VARIANT), found the end of the formula");
    refuse("dx() < 3", "expected the name of a variant");
    refuse("dx(A < 3", "expected ')' behind the variant, found '<'");
    refuse("dx(A) < 3 4", "(column 11 of ");
    refuse("t_δ(A) < 3 4", "(column 12 of ");
    refuse("`dx(A) < 3", "second backtick");
    refuse("dx(``) < 3", "found none");
    refuse(&"(".repeat(2000), "at most 64 parentheses");
}

#[test]
fn rows_are_checked() {
    let read = |claims: &str| Claims::read(&scenario(claims)).map(|claims| claims.len());
    assert_eq!(read("[]"), Ok(0));
    assert_eq!(read("[{ text = 'a', holds = '1 < 2', with = ['dt=0.05'] }]"), Ok(1));
    let message = |claims: &str| read(claims).expect_err(claims).to_string();
    assert!(message("[{ text = ' ', holds = '1 < 2' }]").contains("claims.1.text: expected the claim in words"));
    assert!(message("[{ text = 'a', holds = '1 < 2', with = ['dt'] }]").contains("claims.1.with: expected overrides"));
    assert!(message("[{ text = 'a', holds = '1 < 2', note = '' }]").contains("unknown field"));
    assert!(message("[{ text = 'a', holds = 1 }]").contains("claims.1.holds"));
    assert!(message("3").contains("claims: "));
}

/// Also when a variant is selected: the claims are about all of them.
#[test]
fn claims_of_shipped_scenarios_are_well_formed() {
    for shipped in SCENARIOS {
        let load = |variant: Option<String>| {
            let selection = Selection { variant, ..Selection::default() };
            Scenario::load(shipped.file, shipped.text, &selection).unwrap_or_else(|problems| panic!("{}", problems[0]))
        };
        let count = |scenario: &Scenario| Claims::read(scenario).unwrap_or_else(|problem| panic!("{problem}")).len();
        let default = load(None);
        for variant in &default.variants {
            assert_eq!(count(&load(Some(variant.clone()))), count(&default), "{}", shipped.name);
        }
    }
}

proptest! {
    #[test]
    fn nothing_makes_it_panic(text in "\\PC{0,80}") {
        let variants = ["A".to_string()];
        let mut metrics = Metrics { variants: &variants, needs: Vec::new() };
        let _ = Condition::parse(&text, &mut metrics, |_| None);
    }
}
