//! Overrides of fields that only some variants of a scenario have.

use super::Roles;
use super::components::read_components;
use crate::config::{Origin, Problem, Problems, Sort};
use crate::scenario::{Override, Scenario, Selection};

/// Tables in which any name is a field, so that a name which is not there may be a typing mistake as well.
const OPEN: [&str; 8] = [
    "parameters.",
    "expect.",
    "reference.define.",
    "disturbance.define.",
    "plant.with.",
    "planner.with.",
    "observer.with.",
    "controller.with.",
];

/// Those of the overrides `conditional` whose field the selected variant of the scenario in `text` has. A field that the file leaves
/// out, but that the component of the variant knows, counts as one that it has.
///
/// # Errors
/// The problem of the first override whose field no variant of the scenario has. What else is wrong is left to
/// [`Assembly::load`](super::Assembly::load).
pub fn present(
    file: &str,
    text: &str,
    selection: &Selection,
    conditional: &[String],
    roles: &Roles,
) -> Result<Vec<String>, Vec<Problem>> {
    let mut applied = Vec::new();
    for candidate in conditional {
        let trial = Trial { file, text, roles, candidate };
        let Some(absence) = trial.absence(selection) else {
            applied.push(candidate.clone());
            continue;
        };
        let elsewhere = trial.variants(selection).into_iter().map(|variant| {
            let selection = Selection { variant: Some(variant), data: selection.data.clone(), ..Selection::default() };
            trial.absence(&selection)
        });
        if elsewhere.into_iter().all(|absence| absence.is_some()) {
            let help = absence.help.iter().map(|help| format!("{help}; ")).collect::<String>();
            let origin = Some(Origin::argument(&format!("--set-if-present {candidate}")));
            let help = Some(format!("{help}no variant of this scenario has this field"));
            return Err(vec![Problem { origin, help, ..absence }]);
        }
    }
    Ok(applied)
}

/// Adds to every problem of an override whose field the selected variant lacks which other variants have it.
pub(super) fn add_variants_with(
    file: &str,
    text: &str,
    selection: &Selection,
    roles: &Roles,
    problems: &mut [Problem],
) {
    for candidate in &selection.overrides {
        let origin = Override::origin(candidate);
        let of_it = |problem: &&mut Problem| problem.sort == Sort::Unknown && problem.origin.as_ref() == Some(&origin);
        let Some(problem) = problems.iter_mut().find(of_it) else { continue };
        let trial = Trial { file, text, roles, candidate };
        let data = || selection.data.clone();
        let others = Selection { variant: selection.variant.clone(), data: data(), ..Selection::default() };
        let having = trial.variants(&others).into_iter().filter(|variant| {
            trial.absence(&Selection { variant: Some(variant.clone()), data: data(), ..Selection::default() }).is_none()
        });
        let having: Vec<String> = having.collect();
        if !having.is_empty() {
            let verb = if having.len() == 1 { "has" } else { "have" };
            let help = format!(
                "this variant does not have it, but {} {verb}; --set-if-present sets it where it is",
                having.join(", ")
            );
            problem.help = Some(help);
        }
    }
}

/// An override that is tried.
struct Trial<'a> {
    file: &'a str,
    text: &'a str,
    roles: &'a Roles,
    candidate: &'a str,
}

impl Trial<'_> {
    /// Why this selection does not have the field; `None` if it has.
    fn absence(&self, selection: &Selection) -> Option<Problem> {
        let path = Override::parse(self.candidate).ok()?.path().to_string();
        let mut ignored = Problems::default();
        let before = Scenario::collect(self.file, self.text, selection, &mut ignored);
        if let Some(before) = &before {
            if before.section(&path).is_some() {
                return self.of_dropped_component(before, &path);
            }
            if OPEN.iter().any(|table| path.starts_with(table)) {
                return Some(Override::unknown(self.candidate, "unknown field"));
            }
        }
        let mut with = selection.clone();
        with.overrides.push(self.candidate.into());
        let mut problems = Problems::default();
        let after = Scenario::collect(self.file, self.text, &with, &mut problems);
        if let Some(after) = &after {
            read_components(after, self.roles, &mut problems);
        }
        let origin = Override::origin(self.candidate);
        let is_absence = |problem: &Problem| {
            problem.origin.as_ref() == Some(&origin)
                && match problem.sort {
                    Sort::Unknown => true,
                    // The table that lacks something exists only because of this override.
                    Sort::Missing => path.strip_prefix(&problem.path).is_some_and(|rest| rest.starts_with('.')),
                    Sort::Other => false,
                }
        };
        let dropped = || before.as_ref().and_then(|before| self.of_dropped_component(before, &path));
        problems.into_vec().into_iter().find(is_absence).or_else(dropped)
    }

    /// Says so if the field is one of a component that the scenario does not have.
    fn of_dropped_component(&self, scenario: &Scenario, path: &str) -> Option<Problem> {
        let (section, field) = path.split_once('.')?;
        let role = super::Role::ALL.into_iter().find(|role| role.name() == section)?;
        let absent = scenario.component(role).is_none() && field != "kind";
        absent.then(|| Override::unknown(self.candidate, &format!("this variant has no {role}")))
    }

    /// All variants but the selected one, in which the field may be as well.
    fn variants(&self, selection: &Selection) -> Vec<String> {
        let mut ignored = Problems::default();
        let selected = Scenario::collect(self.file, self.text, selection, &mut ignored);
        let Some(Scenario { variant, variants, .. }) = selected else { return Vec::new() };
        variants.into_iter().filter(|other| *other != variant).collect()
    }
}
