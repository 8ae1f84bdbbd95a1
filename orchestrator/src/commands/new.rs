//! `phalanx new`.

use std::path::{Path, PathBuf};

use formation::wiring::Role;

use super::select::{assemble, find};
use crate::catalog::Catalog;
use crate::cli::{NewArgs, NewRole, ScenarioArgs};
use crate::failure::Failure;
use crate::trial::scaffold::{Order, create};

pub(crate) fn new(catalog: &Catalog, args: &NewArgs) -> Result<(), Failure> {
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
        role: match args.role {
            NewRole::Controller => Role::Controller,
            NewRole::Observer => Role::Observer,
            NewRole::Planner => Role::Planner,
            NewRole::Plant => Role::Plant,
        },
        language: args.lang,
        scenario: named,
        phalanx: args.phalanx.clone().unwrap_or_else(own_source),
    };
    println!("{}", create(&order, &assemble(catalog, &scenario)?)?);
    Ok(())
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./+=:,@%".contains(c);
    if word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Where the source was when this program was built.
fn own_source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf()
}
