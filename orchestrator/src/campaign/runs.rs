//! Many runs, as many at a time as the machine has cores.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use formation::scenario::{Scenario, Selection, Shipped};

use super::{ClaimRow, Job, JobResult};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::claims::{Claim, Claims};

/// The scenarios of a campaign with what they claim.
pub struct Selected {
    /// The scenario, its default variant.
    pub scenario: Scenario,
    /// Its claims.
    pub claims: Vec<Claim>,
}

/// What came of all runs.
pub struct Campaign {
    /// The scenarios in order.
    pub selected: Vec<Selected>,
    /// The runs in order, each variant first, then those that claims demand.
    pub results: Vec<(Job, JobResult)>,
    /// The claims of all scenarios.
    pub claims: Vec<ClaimRow>,
}

impl Selected {
    /// The names of all variants, the default first; its name is empty if the scenario gives it none.
    pub(super) fn variants(&self) -> impl Iterator<Item = &str> {
        let unnamed = self.scenario.variant.is_empty().then_some("");
        unnamed.into_iter().chain(self.scenario.variants.iter().map(String::as_str))
    }
}

impl Campaign {
    /// Whether every metric is in its regression range, every assertion of a variant and every claim holds.
    pub fn ok(&self) -> bool {
        self.own_runs().all(|(_, result)| result.findings.ok())
            && self.own_runs().filter_map(|(_, result)| result.verdict.as_ref()).all(|verdict| verdict.ok())
            && self.claims.iter().all(|claim| claim.holds)
    }

    /// The runs of variants as they are, without those that claims demand.
    pub fn own_runs(&self) -> impl Iterator<Item = &(Job, JobResult)> {
        self.results.iter().filter(|(job, _)| job.with.is_empty())
    }

    /// The result of a variant without overrides.
    pub fn of(&self, scenario: &str, variant: &str) -> Option<&JobResult> {
        let found = self.own_runs().find(|(job, _)| job.shipped.name == scenario && job.variant == variant);
        found.map(|(_, result)| result)
    }
}

/// Runs all variants of the scenarios called `names` (without names, of all) and the runs that their claims need.
///
/// `report` is called after every run: how many are done, of how many, and which.
///
/// # Errors
/// [`Failure`] of the first run that cannot be carried out; an unknown name.
pub fn run_all(
    catalog: &Catalog,
    names: &[String],
    folder: &Path,
    report: impl Fn(usize, usize, &str) + Sync,
) -> Result<Campaign, Failure> {
    let selected = select(catalog, names)?;
    let jobs = jobs(catalog, &selected)?;
    let results = carry_out(catalog, &jobs, folder, &report)?;
    let results: Vec<(Job, JobResult)> = jobs.into_iter().zip(results).collect();
    let claims = selected.iter().flat_map(|selected| ClaimRow::all(selected, &results)).collect();
    Ok(Campaign { selected, results, claims })
}

fn select(catalog: &Catalog, names: &[String]) -> Result<Vec<Selected>, Failure> {
    if let Some(unknown) = names.iter().find(|name| catalog.scenario(name).is_none()) {
        return Err(Failure::Usage(format!("no scenario is called `{unknown}`; `phalanx list` shows all")));
    }
    let wanted = |shipped: &&Shipped| names.is_empty() || names.iter().any(|name| name == shipped.name);
    let load = |shipped: &Shipped| -> Result<Selected, Failure> {
        let scenario = Scenario::load(shipped.file, shipped.text, &Selection::default())?;
        let claims = Claims::read(&scenario).map_err(|problem| vec![problem])?;
        Ok(Selected { scenario, claims })
    };
    let mut selected = Vec::new();
    for shipped in catalog.scenarios.iter().filter(wanted) {
        let one = load(shipped)?;
        if !names.is_empty() || !one.claims.is_empty() || has_bands(&one, shipped)? {
            selected.push(one);
        }
    }
    match selected.is_empty() {
        true => {
            Err(Failure::Usage("no scenario of this program has regression ranges or claims; name those to run".into()))
        }
        false => Ok(selected),
    }
}

/// Whether a variant of the scenario says what must come out of it.
fn has_bands(selected: &Selected, shipped: &Shipped) -> Result<bool, Failure> {
    for variant in selected.variants() {
        let selection = Selection { variant: Some(variant.into()), ..Selection::default() };
        if !Scenario::load(shipped.file, shipped.text, &selection)?.expectations.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn jobs(catalog: &Catalog, selected: &[Selected]) -> Result<Vec<Job>, Failure> {
    let mut jobs: Vec<Job> = Vec::new();
    for one in selected {
        let Selected { scenario, claims } = one;
        let shipped = *catalog
            .scenario(&scenario.name)
            .ok_or_else(|| Failure::Usage(format!("the scenario {} has another name in its file", scenario.name)))?;
        let variants = one.variants().map(|variant| (variant.to_string(), Vec::new()));
        let demanded = claims
            .iter()
            .flat_map(|claim| claim.needs().into_iter().map(|variant| (variant.to_string(), claim.with.clone())));
        for (variant, with) in variants.chain(demanded) {
            let job = Job { shipped, variant, with };
            if !jobs.iter().any(|known| known.is_same(&job)) {
                jobs.push(job);
            }
        }
    }
    Ok(jobs)
}

fn carry_out(
    catalog: &Catalog,
    jobs: &[Job],
    folder: &Path,
    report: &(impl Fn(usize, usize, &str) + Sync),
) -> Result<Vec<JobResult>, Failure> {
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let slots: Vec<Mutex<Option<Result<JobResult, Failure>>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads.min(jobs.len()) {
            scope.spawn(|| {
                while let Some((job, slot)) = take(&next, jobs, &slots) {
                    let result = job.carry_out(catalog, folder);
                    report(done.fetch_add(1, Ordering::Relaxed) + 1, jobs.len(), &job.name());
                    *slot.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(result);
                }
            });
        }
    });
    let missing = || Err(Failure::Internal("a run of the campaign was not carried out".into()));
    let results = slots
        .into_iter()
        .map(|slot| slot.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()).unwrap_or_else(missing));
    results.collect()
}

fn take<'a, T>(next: &AtomicUsize, jobs: &'a [Job], slots: &'a [T]) -> Option<(&'a Job, &'a T)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    Some((jobs.get(index)?, slots.get(index)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scenario with a head and further sections.
    macro_rules! scenario {
        ($name:literal, $head:literal, $sections:literal) => {
            Shipped {
                name: $name,
                file: $name,
                text: concat!(
                    "name = \"",
                    $name,
                    "\"\n",
                    $head,
                    "\nagents = [{ position = [0, 0, 0] }]\ntiming = { dt = 0.1, duration = 1 }\n",
                    "vehicle = { kind = \"integrator\" }\ntopology = { b = 1 }\n",
                    "reference = { position = [\"0\", \"0\", \"0\"] }\n",
                    $sections
                ),
            }
        };
    }

    fn names(scenarios: Vec<Shipped>, names: &[&str]) -> Result<Vec<String>, Failure> {
        let catalog = Catalog { scenarios, ..Catalog::empty() };
        let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
        Ok(jobs(&catalog, &select(&catalog, &names)?)?.iter().map(Job::name).collect())
    }

    const BARE: Shipped = scenario!("bare", "", "");

    #[test]
    fn whatever_has_bands_or_claims_is_run_in_all_its_variants() {
        let scenarios = vec![
            BARE,
            scenario!("single", "", "expect.x.high = 1"),
            scenario!("late", "", "variants.b.expect.x.high = 1"),
            scenario!("named", "variant = \"a\"", "expect.x.high = 1\nvariants.b.seed = 1"),
            scenario!("claiming", "claims = [{ text = \"t\", holds = \"x(b) > 0\" }]", "variants.b.seed = 1"),
        ];
        let expected = ["single", "late", "late b", "named a", "named b", "claiming", "claiming b"];
        assert_eq!(names(scenarios.clone(), &[]).unwrap(), expected);
        assert_eq!(names(scenarios, &["bare"]).unwrap(), ["bare"]);
    }

    #[test]
    fn a_campaign_of_nothing_is_refused() {
        let refused = names(vec![BARE], &[]).unwrap_err().to_string();
        assert!(refused.contains("no scenario of this program has regression ranges or claims"), "{refused}");
    }
}
