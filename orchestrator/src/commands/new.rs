//! `phalanx new`.

use std::path::{Path, PathBuf};

use formation::wiring::Role;

use super::select::assemble;
use crate::cli::{NewArgs, NewRole, ScenarioArgs};
use crate::failure::Failure;
use crate::trial::scaffold::{Order, create};

pub(crate) fn new(args: &NewArgs) -> Result<(), Failure> {
    let (scenario, variant) = (args.scenario.clone(), args.variant.clone());
    let named = match &variant {
        Some(variant) => format!("{scenario} --variant {variant}"),
        None => scenario.clone(),
    };
    let scenario = ScenarioArgs { scenario, variant, set: Vec::new(), dt: None, duration: None, seed: None };
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
    println!("{}", create(&order, &assemble(&scenario)?)?);
    Ok(())
}

/// Where the source was when this program was built.
fn own_source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new(".")).to_path_buf()
}
