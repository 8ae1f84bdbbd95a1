//! A program in Python.

use super::fill;
use super::order::File;
use super::rust::method;
use super::signals::{Signal, Signals};

pub(super) fn files(signals: &Signals, title: &str) -> Vec<File> {
    let both = || {
        let inputs = signals.inputs.iter().map(|signal| (signal, true));
        inputs.chain(signals.outputs.iter().map(|signal| (signal, false)))
    };
    let bind = |(signal, is_input): (&Signal, bool)| {
        let method = if is_input { method(signal.role) } else { "output" };
        let Signal { name, length, .. } = signal;
        format!("        self.{} = me.{method}(\"{name}\", {length}, agent)", signal.variable(is_input))
    };
    let read = |signal: &Signal| format!("        seen += float(self.{}.value.sum())", signal.variable(true));
    let write = |signal: &Signal| match signal.name.as_str() {
        "input" if signals.drives_accelerations => "        self.input.value = law".to_string(),
        _ => format!("        self.{}.value[:] = placeholder", signal.variable(false)),
    };
    let law = if signals.drives_accelerations {
        include_str!("../../../templates/python/law.txt").trim_end().to_string()
    } else {
        let reads: Vec<String> = signals.inputs.iter().map(read).collect();
        fill(include_str!("../../../templates/python/placeholder.txt").trim_end(), &[("reads", reads.join("\n"))])
    };
    let role = signals.outputs.first().map_or("", |signal| signal.role.name());
    let agents = match signals.serves_all {
        true => "[Signals(me, agent) for agent in me.served]",
        false => "[Signals(me, 0)]",
    };
    let main = fill(
        include_str!("../../../templates/python/main.py.txt"),
        &[
            ("title", title.into()),
            ("binds", both().map(bind).collect::<Vec<_>>().join("\n")),
            ("law", law),
            ("writes", signals.outputs.iter().map(write).collect::<Vec<_>>().join("\n")),
            ("role", role.into()),
            ("agents", agents.into()),
        ],
    );
    vec![File::new("main.py", main), File::new(".gitignore", "__pycache__/\n".into())]
}
