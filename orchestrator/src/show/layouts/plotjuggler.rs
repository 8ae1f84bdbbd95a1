//! PlotJuggler: XML, a tab for every quantity, a plot for every component.

use std::fmt::Write;

use super::{Group, colour};

pub(super) fn layout(groups: &[Group]) -> String {
    let mut xml = String::from("<?xml version='1.0' encoding='UTF-8'?>\n<root>\n");
    xml += " <tabbed_widget name=\"Main Window\" parent=\"main_window\">\n";
    for group in groups {
        xml += &tab(group);
    }
    xml += "  <currentTabIndex index=\"0\"/>\n </tabbed_widget>\n";
    xml += " <use_relative_time_offset enabled=\"1\"/>\n <Plugins/>\n <customMathEquations/>\n <snippets/>\n</root>\n";
    xml
}

fn tab(group: &Group) -> String {
    let suffixes = group.suffixes();
    let sizes: Vec<String> = suffixes.iter().map(|_| (1.0 / suffixes.len() as f64).to_string()).collect();
    let mut xml = format!(
        "  <Tab containers=\"1\" tab_name=\"{}\">\n   <Container>\n    <DockSplitter orientation=\"-\" count=\"{}\" sizes=\"{}\">\n",
        group.title,
        sizes.len(),
        sizes.join(";")
    );
    for suffix in suffixes {
        // Writing into a string does not fail.
        let _ = writeln!(xml, "     <DockArea name=\"{}{suffix}\">", group.title);
        xml += "      <plot flip_x=\"false\" flip_y=\"false\" mode=\"TimeSeries\" style=\"Lines\">\n       <limitY/>\n";
        for (agent, topic) in &group.topics {
            let (field, colour) = (&group.field, colour(*agent));
            let _ = writeln!(xml, "       <curve color=\"{colour}\" name=\"{topic}/{field}{suffix}\"/>");
        }
        xml += "      </plot>\n     </DockArea>\n";
    }
    xml + "    </DockSplitter>\n   </Container>\n  </Tab>\n"
}
