//! The report of a run that is going on: the page, and the frames that let it grow.

use serde_json::{Value, json};

use super::data::packed;
use super::{LIVE, POINTS, PROGRAM, data, page};
use crate::show::view::{Grid, LoggedRun, links, panels};

/// The page of a run of `duration` seconds, with what has been seen of it so far; it asks its server for the rest. `no_past` says why
/// nothing is known of the time before, if so.
pub(crate) fn live(run: &LoggedRun, duration: f64, no_past: Option<&str>) -> String {
    let mut data = data::runs_json(std::slice::from_ref(run), POINTS);
    data["live"] = json!({ "duration": duration, "no_past": no_past });
    let title = run.scenario.as_ref().map(|scenario| scenario.name.clone()).unwrap_or_default();
    page(&title, PROGRAM.concat() + LIVE, &data)
}

/// What the newest sample of `run` adds to the page: its curves and paths in the order of the page's data, and the
/// links that exist.
pub(crate) fn frame(run: &LoggedRun) -> Value {
    let sample = run.samples() - 1;
    let grid = Grid::new(1, 2);
    let paths = (0..run.agents.len()).flat_map(|place| {
        let references = ["position", "desired_position"].into_iter();
        let references = references.filter_map(move |field| run.signal(place, "reference", field));
        run.pose(place).into_iter().flatten().chain(references)
    });
    let mut values: Vec<f64> = paths.flat_map(|series| series.row(sample)).copied().collect();
    let curves = panels(run, &grid).into_iter().flat_map(|panel| panel.views).flat_map(|view| view.curves);
    values.extend(curves.flat_map(|curve| curve.values));
    let links: Vec<[usize; 2]> = links(run).into_iter().map(|link| [link.from, link.to]).collect();
    json!({ "time": run.time(sample), "values": packed(values), "links": links })
}
