//! The catalogue of figures against the scenarios.

use formation::scenario::Selection;
use formation::wiring::Assembly;

use super::super::picture::Label;
use super::catalog::{Figure, Kind, figures};
use super::curves::integrated;
use crate::catalog::Catalog;
use crate::judge::assertions::check;

/// The figures of the thesis.
fn own_figures() -> Vec<Figure> {
    let text = include_str!("../../../../../thesis/src/figures.toml");
    figures(&Catalog { figures: vec![text], ..Catalog::empty() }).expect("a valid catalogue")
}

fn assembly(scenario: &str, variant: &str) -> Assembly {
    let shipped =
        schemes::SCENARIOS.iter().find(|shipped| shipped.name == scenario).expect("a scenario that is shipped");
    let selection = Selection { variant: Some(variant.into()), ..Selection::default() };
    Assembly::load(shipped.file, shipped.text, &selection, &schemes::ROLES).expect("a valid variant")
}

#[test]
fn every_figure_shows_what_its_variants_have() {
    for figure in own_figures() {
        let number = &figure.number;
        assert!(figure.plots.is_empty() == (figure.kind == Kind::Trajectories), "{number}");
        for variant in &figure.variants {
            let assembly = assembly(&figure.scenario, variant);
            for plot in &figure.plots {
                let shown = [plot.signal.is_some(), plot.derived.is_some(), plot.pair.is_some()];
                assert_eq!(shown.iter().filter(|shows| **shows).count(), 1, "{number}: one thing to show");
                let Some(signal) = plot.instead.get(variant).or(plot.signal.as_ref()) else { continue };
                let found = check(signal, &assembly, 0);
                assert_eq!(found.is_ok(), !plot.without.contains(variant), "{number}, {variant}: {found:?}");
            }
        }
    }
}

#[test]
fn labels_can_be_read_and_have_a_unit() {
    for figure in own_figures().iter().filter(|figure| figure.kind == Kind::Lines) {
        for plot in &figure.plots {
            let label = Label::tex(&plot.label.replace('#', "i")).expect("a label");
            assert!(label.letters().contains(" [") && label.letters().ends_with(']'), "{}: {label:?}", figure.number);
        }
    }
}

#[test]
fn numbers_and_names_of_figures_are_their_own() {
    let mut names: Vec<String> = own_figures().iter().map(|figure| figure.file_name()).collect();
    assert!(names.contains(&"fig-7-03-high-level-tracking-errors".into()), "{names:?}");
    assert!(names.is_sorted(), "the figures are in the order of the thesis: {names:?}");
    let all = names.len();
    names.dedup_by_key(|name| name[..8].to_string());
    assert_eq!(names.len(), all);
}

#[test]
fn a_catalogue_that_is_not_valid_is_refused() {
    let wrong = figures(&Catalog { figures: vec!["[[figure]]\nnumber = 1"], ..Catalog::empty() });
    assert!(wrong.is_err_and(|error| error.starts_with("the catalogue of figures is not valid: ")));
}

#[test]
fn integrals_grow_by_trapezia() {
    let mut values = [1.0, 3.0, 3.0];
    integrated(&mut values, 0.5);
    assert_eq!(values, [0.0, 1.0, 2.5]);
}
