//! One run of a campaign.

use std::path::{Path, PathBuf};

use formation::config::Problem;
use formation::scenario::{Selection, Shipped};
use formation::wiring::Assembly;

use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::judge::assertions::Findings;
use crate::judge::own;
use crate::judge::verdict::Verdict;
use crate::run::placement::Placement;
use crate::run::{Options, run};
use recording::Log;

/// A variant of a scenario, with overrides.
#[derive(Clone, Debug)]
pub struct Job {
    /// The scenario.
    pub shipped: Shipped,
    /// The variant; empty for that of a scenario that gives it no name.
    pub variant: String,
    /// Overrides `PATH=VALUE`, as a claim demands them.
    pub with: Vec<String>,
}

/// What came of it.
#[derive(Debug)]
pub struct JobResult {
    /// The metrics against what is expected; `None` if not one step was completed.
    pub verdict: Option<Verdict>,
    /// Why the run ended before its time, if it did.
    pub stopped: Option<String>,
    /// What became of the assertions.
    pub findings: Findings,
    /// Number of steps.
    pub steps: u64,
    /// Time it took, s.
    pub wall: f64,
}

impl Job {
    /// Scenario, variant and overrides, for messages.
    pub fn name(&self) -> String {
        let with = if self.with.is_empty() { String::new() } else { format!(" with {}", self.with.join(", ")) };
        let variant = if self.variant.is_empty() { String::new() } else { format!(" {}", self.variant) };
        format!("{}{variant}{with}", self.shipped.name)
    }

    /// Whether this is the same run as `other`.
    pub fn is_same(&self, other: &Job) -> bool {
        self.shipped.name == other.shipped.name && self.variant == other.variant && self.with == other.with
    }

    /// Runs it in this process. The log goes to a file in `folder` and is removed once the metrics are known.
    ///
    /// # Errors
    /// [`Failure`] if it cannot start or its log cannot be read; a run that stops early is no error.
    pub fn carry_out(&self, catalog: &Catalog, folder: &Path) -> Result<JobResult, Failure> {
        let selection =
            Selection { variant: Some(self.variant.clone()), overrides: self.with.clone(), ..Selection::default() };
        let assembly: Assembly = Assembly::load(self.shipped.file, self.shipped.text, &selection, &catalog.roles)
            .map_err(|problems: Vec<Problem>| Failure::Invalid(problems))?;
        let log = TemporaryLog(folder.join(format!("{}.mcap", self.name().replace(['/', ' '], "-"))));
        let options = Options { scene: false, ..Options::new(Placement::Single, Some(log.0.clone())) };
        let outcome = run(&assembly, &options, |_| {})?;
        let recorded = Log::open(&log.0)?;
        let verdict = match recorded.steps().is_empty() {
            true => None,
            false => {
                Some(Verdict::of(&catalog.metrics, &assembly.scenario, &recorded, own::of_log(&assembly, &recorded)?)?)
            }
        };
        let stopped = outcome.ending.reason();
        let findings = outcome.findings;
        Ok(JobResult { verdict, stopped, findings, steps: outcome.steps, wall: outcome.wall })
    }
}

/// A log that is removed with the value.
struct TemporaryLog(PathBuf);

impl Drop for TemporaryLog {
    fn drop(&mut self) {
        // If it was never written, there is nothing to remove.
        let _ = std::fs::remove_file(&self.0);
    }
}
