//! `phalanx list`.

use clap::Args;
use formation::scenario::{Scenario, Selection};
use formation::wiring::Role;
use serde_json::json;

use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::terminal;

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// List the components that scenarios can name instead
    #[arg(long)]
    pub(crate) components: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn list(catalog: &Catalog, args: &ListArgs) -> Result<(), Failure> {
    if args.components {
        list_components(catalog, args.json);
        return Ok(());
    }
    let mut entries = Vec::new();
    for shipped in &catalog.scenarios {
        let scenario = Scenario::load(shipped.file, shipped.text, &Selection::default())?;
        let agents = scenario.context.agents.len();
        if args.json {
            entries.push(json!({
                "name": scenario.name, "title": scenario.title, "thesis": scenario.thesis, "file": shipped.file,
                "agents": agents, "variants": scenario.variants, "default": scenario.variant,
            }));
            continue;
        }
        println!("{:<20} {} ({}{agents} agents)", scenario.name, scenario.title, section(&scenario.thesis));
        if !scenario.variants.is_empty() {
            println!("{:<20}   variants: {}", "", scenario.variants.join(", "));
        }
    }
    if args.json {
        println!("{}", json!(entries));
    } else {
        let program = terminal::program();
        println!("\nRun one with `{program} run NAME`, another variant with `{program} run NAME --variant VARIANT`.");
    }
    Ok(())
}

fn section(thesis: &str) -> String {
    if thesis.is_empty() { String::new() } else { format!("thesis {thesis}, ") }
}

fn list_components(catalog: &Catalog, as_json: bool) {
    let mut entries = Vec::new();
    for role in Role::ALL {
        if !as_json {
            println!("{role}");
        }
        for kind in catalog.roles.of(role) {
            if as_json {
                entries.push(json!({"role": role.name(), "kind": kind.name, "summary": kind.summary}));
            } else {
                println!("  {:<26} {}", kind.name, kind.summary);
            }
        }
    }
    if as_json {
        println!("{}", json!(entries));
    }
}
