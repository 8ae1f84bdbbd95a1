//! The report: one HTML file without references to other files, which shows runs in any browser.
//!
//! Style sheet, program and data are all in the file; it asks nothing of a network. The data are those of
//! [`crate::show::view`], thinned out so that the file stays small however long the run was.

mod data;
mod live;

pub(crate) use live::{frame, live};

use serde_json::Value;

use crate::show::view::LoggedRun;

/// Points of a curve, for a report of few agents.
const POINTS: usize = 2000;
/// Points of a curve, for a report of many.
const POINTS_LEAST: usize = 200;
/// Agents, of all runs together, up to which a report has [`POINTS`] points a curve.
const AGENTS_IN_FULL: usize = 10;

const PAGE: &str = include_str!("../../../assets/report.html");
const STYLE: &str = include_str!("../../../assets/report.css");
/// In the order in which they need each other.
const PROGRAM: [&str; 11] = [
    include_str!("../../../assets/report-data.js"),
    include_str!("../../../assets/report-chart.js"),
    include_str!("../../../assets/report-save.js"),
    include_str!("../../../assets/report-plot.js"),
    include_str!("../../../assets/report-bodies.js"),
    include_str!("../../../assets/report-scene.js"),
    include_str!("../../../assets/report-verdicts.js"),
    include_str!("../../../assets/report-heading.js"),
    include_str!("../../../assets/report-controls.js"),
    include_str!("../../../assets/report-keys.js"),
    include_str!("../../../assets/report.js"),
];

/// What lets the page of a run that is going on grow.
const LIVE: &str = include_str!("../../../assets/report-live.js");

/// The report on these runs as one HTML document. Runs are told apart by what differs between them.
pub fn html(runs: &[LoggedRun]) -> String {
    let data = data::runs_json(runs, points(runs));
    let title = match runs {
        [one] => one.log.metadata().and_then(|m| m.get("scenario")).cloned().unwrap_or_else(|| one.stem()),
        several => format!("{} runs", several.len()),
    };
    page(&title, PROGRAM.concat(), &data)
}

/// The page with this program and these data in it.
fn page(title: &str, program: String, data: &Value) -> String {
    let parts = [
        ("/*style*/", STYLE.to_string()),
        ("/*program*/", program),
        ("<!--title-->", escape(title)),
        // Last, as it is large and may contain anything. "</" would end the element that holds it.
        ("\"data\"", data.to_string().replace("</", "<\\/")),
    ];
    let mut page = String::with_capacity(parts.iter().map(|(_, text)| text.len()).sum::<usize>() + PAGE.len());
    let mut rest = PAGE;
    while let Some((at, mark, text)) =
        parts.iter().filter_map(|(mark, text)| Some((rest.find(mark)?, mark, text))).min_by_key(|(at, ..)| *at)
    {
        page.push_str(&rest[..at]);
        page.push_str(text);
        rest = &rest[at + mark.len()..];
    }
    page.push_str(rest);
    page
}

/// Points of a curve such that the report stays a file that one can mail.
fn points(runs: &[LoggedRun]) -> usize {
    let agents: usize = runs.iter().map(|run| run.agents.len()).sum();
    (POINTS * AGENTS_IN_FULL / agents.max(AGENTS_IN_FULL)).max(POINTS_LEAST)
}

/// Text for an HTML document.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' | '<' | '>' | '"' | '\'' => escaped.push_str(&format!("&#{};", u32::from(letter))),
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_runs_cannot_become_markup() {
        assert_eq!(escape("<a> & 'b'"), "&#60;a&#62; &#38; &#39;b&#39;");
    }

    #[test]
    fn the_page_asks_nothing_of_a_network() {
        for part in [PAGE, STYLE].into_iter().chain(PROGRAM) {
            for word in ["http:", "https:", "src=", "@import", "url(", "fetch(", "XMLHttpRequest", "import("] {
                assert!(!part.contains(word), "{word}");
            }
        }
        for mark in ["/*style*/", "/*program*/", "<!--title-->", "\"data\""] {
            assert_eq!(PAGE.matches(mark).count(), 1, "{mark}");
        }
    }
}
