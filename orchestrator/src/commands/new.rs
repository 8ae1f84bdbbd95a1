//! `phalanx new`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use formation::wiring::Role;

use super::arguments::ScenarioArgs;
use super::select::{assemble, find};
use crate::catalog::Catalog;
use crate::failure::Failure;
use crate::terminal::quoted;
use crate::trial::scaffold::{Language, Order, create, create_vehicle};

/// What a new project is to serve as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum NewRole {
    /// Computes the input of one agent
    Controller,
    /// Estimates what the sensors of one agent do not tell
    Observer,
    /// Says what every agent has to track
    Planner,
    /// Moves the vehicles
    Plant,
    /// A scenario file with the equations of a vehicle and a law, which needs no program
    Vehicle,
}

#[derive(Debug, Args)]
pub(crate) struct NewArgs {
    /// What the program is to serve as
    #[arg(value_enum)]
    pub(crate) role: NewRole,
    /// Name of the project, and of the folder that is made for it
    pub(crate) name: String,
    /// What it is written in; all but a vehicle need it
    #[arg(long, value_enum)]
    pub(crate) lang: Option<Language>,
    /// Vehicle of the library to begin with, for a vehicle (see `phalanx list --vehicles`)
    #[arg(long, value_name = "VEHICLE", default_value = "unicycle")]
    pub(crate) from: String,
    /// Scenario whose signals it has: a shipped one (see `phalanx list`) or a file
    /// [default: triangle; for an observer, which triangle does not have, cida]
    #[arg(long)]
    pub(crate) scenario: Option<String>,
    /// Variant of the scenario
    #[arg(long)]
    pub(crate) variant: Option<String>,
    /// Checkout or installation of Phalanx [default: what is installed with this program, else the checkout that it was built from]
    #[arg(long, value_name = "FOLDER")]
    pub(crate) phalanx: Option<PathBuf>,
}

pub(crate) fn new(catalog: &Catalog, args: &NewArgs) -> Result<(), Failure> {
    let role = match args.role {
        NewRole::Controller => Role::Controller,
        NewRole::Observer => Role::Observer,
        NewRole::Planner => Role::Planner,
        NewRole::Plant => Role::Plant,
        NewRole::Vehicle => {
            println!("{}", create_vehicle(&args.name, &args.from)?);
            return Ok(());
        }
    };
    let Some(language) = args.lang else {
        return Err(Failure::Usage(format!("a {role} is a program: add --lang python, --lang cpp or --lang rust")));
    };
    let default = if matches!(args.role, NewRole::Observer) { "cida" } else { "triangle" };
    let (scenario, variant) = (args.scenario.clone().unwrap_or_else(|| default.into()), args.variant.clone());
    // The commands that are printed are given in the folder of the project.
    let there = match find(catalog, &scenario)?.0 {
        file if file == scenario && !Path::new(&file).is_absolute() => quoted(&format!("../{file}")),
        _ => quoted(&scenario),
    };
    let named = match &variant {
        Some(variant) => format!("{there} --variant {}", quoted(variant)),
        None => there,
    };
    let scenario = ScenarioArgs { scenario, variant, ..ScenarioArgs::default() };
    let order = Order {
        name: args.name.clone(),
        role,
        language,
        scenario: named,
        phalanx: args.phalanx.clone(),
        program: std::env::current_exe().map_err(Failure::system("find the path of this program"))?,
        built_from: Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf(),
    };
    println!("{}", create(&order, &assemble(catalog, &scenario)?)?);
    Ok(())
}
