//! Rerun, whose layouts are made by a Python program: one that opens the log and lays out its views.

use super::Group;

/// The program, but for the log and what is plotted.
const SCRIPT: &str = include_str!("../../../assets/rerun-layout.py");

pub(super) fn script(groups: &[Group], log: &str) -> String {
    let mut list = String::from("[\n");
    for group in groups {
        let topics: Vec<String> =
            group.topics.iter().map(|(_, topic)| format!("{:?}", topic.trim_start_matches('/'))).collect();
        list += &format!("    ({:?}, {:?}, [{}]),\n", group.title, group.field, topics.join(", "));
    }
    list.push(']');
    SCRIPT.replace("\"@LOG@\"", &format!("{log:?}")).replace("\"@PLOTS@\"", &list)
}
