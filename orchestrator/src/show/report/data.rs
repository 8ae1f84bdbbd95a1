//! What the report knows, as JSON; long lists of numbers as base64 of little-endian 32-bit floats.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use recording::Series;
use serde_json::{Value, json};

use crate::judge::assertions::Finding;
use crate::judge::verdict::Row;
use crate::show::traffic::Traffic;
use crate::show::view::{Curve, Grid, Kind, LoggedRun, Panel, View, links, panels};

/// All runs, each curve with at most `points` points.
pub(super) fn runs_json(runs: &[LoggedRun], points: usize) -> Value {
    let names = names(runs);
    let runs: Vec<Value> = runs.iter().zip(names).map(|(run, name)| run_json(run, &name, points)).collect();
    json!({ "version": env!("CARGO_PKG_VERSION"), "runs": runs })
}

pub(super) fn packed(values: impl IntoIterator<Item = f64>) -> Value {
    let bytes: Vec<u8> = values.into_iter().flat_map(|value| (value as f32).to_le_bytes()).collect();
    STANDARD.encode(bytes).into()
}

/// Names that tell the runs apart: by variant and overrides if these differ, else by file.
fn names(runs: &[LoggedRun]) -> Vec<String> {
    let meta = |run: &LoggedRun, key: &str| {
        run.log.metadata().and_then(|metadata| metadata.get(key)).cloned().unwrap_or_default()
    };
    let scenarios: Vec<String> = runs.iter().map(|run| meta(run, "scenario")).collect();
    let same_scenario = scenarios.iter().all(|name| *name == scenarios[0]);
    let describe = |run: &LoggedRun| {
        let mut parts = vec![meta(run, "variant")];
        if !same_scenario {
            parts.insert(0, meta(run, "scenario"));
        }
        parts.extend(meta(run, "overrides").lines().map(String::from));
        parts.retain(|part| !part.is_empty());
        parts.join(" ")
    };
    let names: Vec<String> = runs.iter().map(describe).collect();
    let unique = names.iter().enumerate().all(|(k, name)| !name.is_empty() && !names[..k].contains(name));
    if unique { names } else { runs.iter().map(LoggedRun::stem).collect() }
}

fn run_json(run: &LoggedRun, name: &str, points: usize) -> Value {
    let grid = Grid::new(run.samples(), points);
    let metadata = run.log.metadata();
    let text = |key: &str| metadata.and_then(|metadata| metadata.get(key)).map(String::as_str).unwrap_or_default();
    let scenario = run.scenario.as_ref();
    let overrides: Vec<&str> = text("overrides").lines().filter(|line| !line.is_empty()).collect();
    let channels: Vec<Value> = run
        .log
        .channels()
        .iter()
        .filter_map(|channel| {
            let fields = channel.layout.as_ref()?.fields();
            let fields: Vec<Value> = fields.iter().map(|f| json!([f.name, f.shape.words(), f.unit])).collect();
            Some(json!({ "topic": channel.topic, "fields": fields }))
        })
        .collect();
    json!({
        "name": name,
        "file": run.log.path().file_name().unwrap_or_default().to_string_lossy(),
        "scenario": text("scenario"),
        "title": scenario.map(|scenario| scenario.title.as_str()).unwrap_or_default(),
        "thesis": scenario.map(|scenario| scenario.thesis.as_str()).unwrap_or_default(),
        "variant": text("variant"),
        "overrides": overrides,
        "caveats": run.caveats,
        "samples": run.samples(),
        "dt": scenario.map(|scenario| scenario.context.timing.dt),
        "interval": grid.interval(),
        "not_held": run.verdict.as_ref().and_then(|verdict| verdict.not_held.clone()),
        "metrics": run.verdict.as_ref().map(|verdict| verdict.rows.iter().map(metric).collect::<Vec<_>>()),
        "assertions": run.findings.0.iter().map(assertion).collect::<Vec<_>>(),
        "traffic": run.traffic.iter().map(Traffic::to_json).collect::<Vec<_>>(),
        "text": run.log.scenario_text(),
        "channels": channels,
        "time": packed(grid.points().iter().map(|&sample| run.time(sample))),
        "scene": scene(run, &grid),
        "panels": panels(run, &grid).iter().map(panel).collect::<Vec<_>>(),
    })
}

fn metric(row: &Row) -> Value {
    let mut json = row.to_json();
    json["id"] = row.id.clone().into();
    json
}

fn assertion(finding: &Finding) -> Value {
    let first = finding.first.map(|first| json!({ "time": first.time, "text": first.text(&finding.signal) }));
    json!({
        "name": finding.name,
        "signal": finding.signal,
        "bound": finding.bound(),
        "worst": finding.worst(),
        "worst_at": finding.worst_time(),
        "first": first,
        "word": finding.word(),
        "ok": finding.ok(),
        "fails": finding.fails(),
    })
}

/// What moves, and where.
fn scene(run: &LoggedRun, grid: &Grid) -> Value {
    let agents: Vec<Value> = (0..run.agents.len())
        .map(|place| {
            let path = |all: Vec<Series>| {
                let row = |&sample: &usize| all.iter().flat_map(move |series| series.row(sample)).copied();
                let width: usize = all.iter().map(Series::width).sum();
                json!({ "width": width, "values": packed(grid.points().iter().flat_map(row)) })
            };
            let of_reference = |field: &str| run.signal(place, "reference", field).map(|series| path(vec![series]));
            json!({
                "number": run.agents[place],
                "radius": run.radius(place),
                "planar": run.vehicle(place).is_none_or(|vehicle| vehicle.dimensions() <= 2),
                "position": run.pose(place).map(path),
                "tracked": of_reference("position"),
                "desired": of_reference("desired_position"),
            })
        })
        .collect();
    let obstacles: Vec<Value> = run
        .obstacles()
        .iter()
        .map(|obstacle| json!({ "centre": obstacle.centre, "radius": obstacle.radius, "rings": obstacle.rings }))
        .collect();
    let links: Vec<Value> = links(run)
        .into_iter()
        .map(|link| {
            let spans = packed(link.spans.into_iter().flatten());
            json!({ "from": link.from, "to": link.to, "spans": spans })
        })
        .collect();
    json!({ "planar": run.is_planar(), "agents": agents, "obstacles": obstacles, "links": links })
}

fn panel(panel: &Panel) -> Value {
    let kind = match panel.kind {
        Kind::Lines => "lines",
        Kind::Bands => "bands",
    };
    let views: Vec<Value> = panel.views.iter().map(view).collect();
    json!({ "id": panel.id, "title": panel.title, "kind": kind, "views": views })
}

fn view(view: &View) -> Value {
    let curve = |curve: &Curve| {
        let values = packed(curve.values.iter().copied());
        json!({ "label": curve.label, "agent": curve.agent, "second": curve.second, "values": values })
    };
    let limits: Vec<Value> = view.limits.iter().map(|limit| json!([limit.label, limit.value])).collect();
    json!({
        "name": view.name,
        "axis": view.axis,
        "unit": view.unit,
        "logarithmic": view.logarithmic,
        "curves": view.curves.iter().map(curve).collect::<Vec<_>>(),
        "limits": limits,
    })
}
