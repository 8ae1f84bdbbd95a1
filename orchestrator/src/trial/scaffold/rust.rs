//! A project in Rust.

use formation::wiring::Role;

use super::fill;
use super::order::{File, Order};
use super::signals::{Signal, Signals};

pub(super) fn files(order: &Order, signals: &Signals, title: &str, phalanx: &str) -> Vec<File> {
    let lines = |lines: Vec<String>| lines.join("\n");
    let both = || {
        let inputs = signals.inputs.iter().map(|signal| (signal, true));
        inputs.chain(signals.outputs.iter().map(|signal| (signal, false)))
    };
    let field = |(signal, is_input): (&Signal, bool)| {
        let kind = if is_input { "In" } else { "Out" };
        format!("    {}: {kind}<{}>,", signal.variable(is_input), signal.length)
    };
    let bind = |(signal, is_input): (&Signal, bool)| {
        let method = if is_input { method(signal.role) } else { "out" };
        format!("            {}: me.{method}_of(agent, \"{}\")?,", signal.variable(is_input), signal.name)
    };
    let inputs: Vec<String> = signals.inputs.iter().map(|signal| signal.variable(true)).collect();
    let sum = match inputs.split_first() {
        Some((first, rest)) => {
            let rest: String = rest.iter().map(|name| format!("\n            .chain(&{name})")).collect();
            format!("{first}\n            .iter(){rest}\n            .sum()")
        }
        None => "0.0".into(),
    };
    let write = |signal: &Signal| match signal.name.as_str() {
        "input" if signals.drives_accelerations => "        io.set(self.input, law);".to_string(),
        _ => format!("        io.set(self.{}, [placeholder; {}]);", signal.variable(false), signal.length),
    };
    let law = if signals.drives_accelerations {
        include_str!("../../../templates/rust/law.txt").trim_end().to_string()
    } else {
        fill(include_str!("../../../templates/rust/placeholder.txt").trim_end(), &[("sum", sum)])
    };
    // What the law does not use is read under a name that says so, or the compiler warns.
    let read = |name: &String| {
        let mark = if law.contains(name.as_str()) { "" } else { "_" };
        format!("        let {mark}{name} = io.get(self.{name});\n")
    };
    let agents = if signals.serves_all { "me.served()" } else { "std::iter::once(me.agent()?)" };
    let role = signals.outputs.first().map_or("", |signal| match signal.role {
        Role::Plant => "Plant",
        Role::Planner => "Planner",
        Role::Observer => "Observer",
        Role::Controller => "Controller",
    });
    let main = fill(
        include_str!("../../../templates/rust/main.rs.txt"),
        &[
            ("title", title.into()),
            ("In", if signals.inputs.is_empty() { "" } else { "In, " }.into()),
            ("fields", lines(both().map(field).collect())),
            ("binds", lines(both().map(bind).collect())),
            ("reads", inputs.iter().map(read).collect()),
            ("law", law.clone()),
            ("writes", lines(signals.outputs.iter().map(write).collect())),
            ("Role", role.into()),
            ("agents", agents.into()),
        ],
    );
    let manifest = include_str!("../../../templates/rust/Cargo.toml.txt");
    vec![
        File::new("Cargo.toml", fill(manifest, &[("name", order.name.clone()), ("phalanx", phalanx.into())])),
        File::new("src/main.rs", main),
        File::new(".gitignore", "/target\n".into()),
    ]
}

/// How an input of this role is asked for.
pub(super) fn method(role: Role) -> &'static str {
    match role {
        Role::Plant => "state",
        Role::Planner => "reference",
        Role::Observer => "estimate",
        Role::Controller => "command_before",
    }
}
