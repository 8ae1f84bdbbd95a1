//! `phalanx list`.

use clap::Args;
use formation::scenario::{LIBRARY, LibraryVehicle, Scenario, Selection};
use formation::wiring::Role;
use serde_json::json;

use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::terminal;
use crate::terminal::table::{Left, Table};

#[derive(Debug, Args)]
pub(crate) struct ListArgs {
    /// List the components that scenarios can name instead
    #[arg(long)]
    pub(crate) components: bool,
    /// List the library of vehicles instead
    #[arg(long, conflicts_with = "components")]
    pub(crate) vehicles: bool,
    /// Print the equations of a vehicle of the library, to copy them into a scenario
    #[arg(long, value_name = "NAME", conflicts_with_all = ["components", "vehicles", "json"])]
    pub(crate) vehicle: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn list(catalog: &Catalog, args: &ListArgs) -> Result<(), Failure> {
    if args.components {
        list_components(catalog, args.json);
        return Ok(());
    }
    if args.vehicles {
        list_vehicles(args.json);
        return Ok(());
    }
    if let Some(name) = &args.vehicle {
        return print_vehicle(name);
    }
    let mut entries = Vec::new();
    let mut table = Table::new([("", Left), ("", Left)]);
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
        let title = format!("{} ({}{agents} agents)", scenario.title, section(&scenario.thesis));
        table.row([scenario.name, title]);
        if !scenario.variants.is_empty() {
            table.row([String::new(), format!("variants: {}", scenario.variants.join(", "))]);
        }
    }
    if args.json {
        println!("{}", json!(entries));
    } else {
        let program = terminal::program();
        print!("{}", table.text(terminal::columns()));
        println!("\nRun one with `{program} run NAME`, another variant with `{program} run NAME --variant VARIANT`.");
    }
    Ok(())
}

fn list_vehicles(as_json: bool) {
    let rows = LIBRARY.iter().map(|vehicle| (vehicle.name, vehicle.words()));
    if as_json {
        let entries = rows.map(|(name, [title, source])| json!({ "kind": name, "title": title, "source": source }));
        println!("{}", json!(entries.collect::<Vec<_>>()));
        return;
    }
    let mut table = Table::new([("", Left), ("", Left)]);
    rows.for_each(|(name, [title, _])| table.row([name.to_string(), title]));
    let program = terminal::program();
    print!("{}", table.text(terminal::columns()));
    println!(
        "\nA scenario names one, `vehicle.kind = \"unicycle\"`; `{program} list --vehicle unicycle` prints its equations."
    );
}

fn print_vehicle(name: &str) -> Result<(), Failure> {
    let vehicle = LibraryVehicle::named(name).map_err(|reason| Failure::Usage(format!("--vehicle: {reason}")))?;
    print!("{}", vehicle.text);
    Ok(())
}

fn section(thesis: &str) -> String {
    if thesis.is_empty() { String::new() } else { format!("thesis {thesis}, ") }
}

fn list_components(catalog: &Catalog, as_json: bool) {
    let mut entries = Vec::new();
    for role in Role::ALL {
        let mut table = Table::new([("", Left), ("", Left)]).indented(2);
        for kind in catalog.roles.of(role) {
            if as_json {
                entries.push(json!({"role": role.name(), "kind": kind.name, "summary": kind.summary}));
            } else {
                table.row([kind.name, kind.summary].map(String::from));
            }
        }
        if !as_json {
            print!("{role}\n{}", table.text(terminal::columns()));
        }
    }
    if as_json {
        println!("{}", json!(entries));
    }
}
