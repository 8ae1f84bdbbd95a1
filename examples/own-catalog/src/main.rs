//! A program with a catalog of its own: a vehicle, a control law, metrics and a scenario that Phalanx does not know.

mod carts;
mod carts_metrics;
mod tip_consensus;

use formation::shipped;
use formation::wiring::{Kind, Role};
use orchestrator::Catalog;
use orchestrator::judge::metrics::MetricSet;

fn main() -> std::process::ExitCode {
    // The components of Phalanx, so that scenarios can name them too. Without them: `Catalog::empty()`.
    let mut catalog = Catalog { roles: schemes::ROLES, ..Catalog::empty() };
    catalog.roles.add(Role::Plant, [Kind::of::<carts::Carts>("carts", "carts on two driven wheels, with drag")]);
    catalog.roles.add(
        Role::Controller,
        [Kind::of::<tip_consensus::TipConsensus>("tip_consensus", "consensus of the tips of carts")],
    );
    catalog.metrics.push(MetricSet {
        name: "carts",
        compute: carts_metrics::compute,
        definitions: carts_metrics::DEFINITIONS,
    });
    catalog.scenarios.extend_from_slice(shipped!["../scenarios/", "carousel"]);
    orchestrator::main(&catalog)
}
