//! The glossary of metrics, a page of the documentation.

use std::fmt::Write;

use crate::catalog::Catalog;
use crate::terminal::table::{Left, Table};

/// What the page says before its tables.
const INTRODUCTION: &str = "# Metrics

What the numbers of a run mean. `phalanx check LOG --explain` prints those of one log, the report shows them beside each metric. The page is
made from the definitions beside the code that computes the metrics.

A norm over coordinates with two units (`m, rad`) takes each coordinate in its own unit, as the thesis does; it says how small all of them
are, and is no length. The last quarter of a run is the part from three quarters of its duration on. `t(... ≤ b)` is the first time after
which the value never exceeds `b` again; it does not exist (`-`) if there is no such time. `{i}` stands for the number of an agent.
";

/// All sets of metrics of a catalog: symbol, unit and meaning of each.
pub fn glossary(catalog: &Catalog) -> String {
    let mut text = String::from(INTRODUCTION);
    for set in &catalog.metrics {
        let users: Vec<String> = catalog
            .scenarios
            .iter()
            .filter(|shipped| set.serves(shipped))
            .map(|shipped| format!("`{}`", shipped.name))
            .collect();
        let _ = writeln!(text, "\n## `{}`\n", set.name);
        if !users.is_empty() {
            let _ = writeln!(text, "Scenarios: {}.\n", users.join(", "));
        }
        let mut table = Table::new([("metric", Left), ("symbol", Left), ("unit", Left), ("meaning", Left)]);
        for one in set.definitions {
            table.row([format!("`{}`", one.id), one.symbol.to_string(), one.unit.to_string(), one.text.to_string()]);
        }
        text.push_str(&table.markdown());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::metrics::{Definition, MetricSet};

    #[test]
    fn each_set_has_a_table() {
        static MISS: [Definition; 1] = [Definition::new("miss", "‖δ‖", "m", "How far.")];
        let set = MetricSet { name: "carts", compute: |_| Ok(Vec::new()), definitions: &MISS };
        let page = glossary(&Catalog { metrics: vec![set], ..Catalog::empty() });
        assert!(page.contains("## `carts`") && page.contains("| `miss` | ‖δ‖ | m | How far. |"), "{page}");
    }
}
