//! A project in C++.

use super::fill;
use super::order::{File, Order};
use super::rust::method;
use super::signals::{Signal, Signals};

pub(super) fn files(order: &Order, signals: &Signals, title: &str, phalanx: &str) -> Vec<File> {
    let both = || {
        let inputs = signals.inputs.iter().map(|signal| (signal, true));
        inputs.chain(signals.outputs.iter().map(|signal| (signal, false)))
    };
    let field = |(signal, is_input): (&Signal, bool)| {
        let kind = if is_input { "In" } else { "Out" };
        format!("    phalanx::{kind}<{}> {};", signal.length, signal.variable(is_input))
    };
    let bind = |(signal, is_input): (&Signal, bool)| {
        let method = if is_input { method(signal.role) } else { "out" };
        format!("{}(me.{method}<{}>(\"{}\", agent))", signal.variable(is_input), signal.length, signal.name)
    };
    let each = |signal: &Signal, is_input: bool, action: &str| {
        let name = signal.variable(is_input);
        format!(
            "        for (std::size_t j = 0; j < {name}.size(); ++j) {};",
            action.replace("NUMBER", &format!("{name}[j]"))
        )
    };
    let agents = match signals.serves_all {
        true => "for (const int agent : me.served()) agents.emplace_back(me, agent);",
        false => "agents.emplace_back(me, 0);",
    };
    let reads: Vec<String> = signals.inputs.iter().map(|signal| each(signal, true, "seen += NUMBER")).collect();
    let write = |signal: &Signal| match signal.name.as_str() {
        "input" if signals.drives_accelerations => String::new(),
        _ => each(signal, false, "NUMBER = placeholder"),
    };
    let writes: Vec<String> = signals.outputs.iter().map(write).filter(|line| !line.is_empty()).collect();
    let law = if signals.drives_accelerations {
        include_str!("../../../templates/cpp/law.txt").trim_end().to_string()
    } else {
        fill(include_str!("../../../templates/cpp/placeholder.txt").trim_end(), &[("reads", reads.join("\n"))])
    };
    let role = signals.outputs.first().map_or("", |signal| signal.role.name());
    let main = fill(
        include_str!("../../../templates/cpp/main.cpp.txt"),
        &[
            ("title", title.into()),
            ("fields", both().map(field).collect::<Vec<_>>().join("\n")),
            ("binds", both().map(bind).collect::<Vec<_>>().join(",\n          ")),
            ("law", law),
            ("writes", writes.join("\n")),
            ("role", role.into()),
            ("agents", agents.into()),
        ],
    );
    let lists = include_str!("../../../templates/cpp/CMakeLists.txt.txt");
    vec![
        File::new("CMakeLists.txt", fill(lists, &[("name", order.name.clone()), ("phalanx", phalanx.into())])),
        File::new("main.cpp", main),
        File::new(".gitignore", "/build\n".into()),
    ]
}
