//! Foxglove and Lichtblick, which share a format: JSON, a tree of splits with the names of panels as leaves.

use serde_json::{Map, Value, json};

use super::{Group, colour};

/// Topics of the scene that the 3D panel shows.
const SHOWN: [&str; 5] = ["/tf", "/scene/bodies", "/scene/obstacles", "/scene/links", "/scene/trails"];
/// Topics that it offers, but hides at first: they repeat what the others show.
const HIDDEN: [&str; 2] = ["/scene/poses", "/scene/targets"];
/// Name of the 3D panel.
const FORMATION: &str = "3D!formation";

pub(super) fn layout(groups: &[Group]) -> String {
    let mut panels = Map::new();
    panels.insert(FORMATION.into(), formation());
    panels.insert("RosOut!journal".into(), json!({ "searchTerms": [], "minLogLevel": 1, "topicToRender": "/rosout" }));
    let tabs: Vec<Value> = groups.iter().enumerate().map(|(index, group)| tab(index, group, &mut panels)).collect();
    panels.insert("Tab!plots".into(), json!({ "activeTabIdx": 0, "tabs": tabs }));
    let right =
        json!({ "direction": "column", "first": "Tab!plots", "second": "RosOut!journal", "splitPercentage": 78 });
    let layout = json!({
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": { "speed": 1 },
        "layout": { "direction": "row", "first": FORMATION, "second": right, "splitPercentage": 50 },
    });
    format!("{layout:#}\n")
}

fn formation() -> Value {
    let topics: Map<String, Value> = SHOWN
        .iter()
        .map(|topic| (topic, true))
        .chain(HIDDEN.iter().map(|topic| (topic, false)))
        .map(|(topic, visible)| (topic.to_string(), json!({ "visible": visible })))
        .collect();
    json!({
        "followTf": "world",
        "followMode": "follow-none",
        "scene": { "enableStats": false, "transforms": { "axisScale": 0.25, "showLabel": false } },
        "cameraState": {
            "perspective": true, "distance": 20, "phi": 55, "thetaOffset": 35, "fovy": 45, "near": 0.1, "far": 1000,
            "target": [0, 0, 0], "targetOffset": [0, 0, 1], "targetOrientation": [0, 0, 0, 1],
        },
        "layers": {
            "grid": {
                "layerId": "foxglove.Grid", "instanceId": "grid", "label": "Grid", "visible": true, "frameLocked": true,
                "frameId": "world", "size": 20, "divisions": 20, "lineWidth": 1, "color": "#88888866",
                "position": [0, 0, 0], "rotation": [0, 0, 0], "order": 1,
            },
        },
        "transforms": {},
        "topics": topics,
    })
}

/// A tab with a plot for every component, a line for every agent.
fn tab(index: usize, group: &Group, panels: &mut Map<String, Value>) -> Value {
    let mut names = Vec::new();
    for (component, suffix) in group.suffixes().iter().enumerate() {
        let paths: Vec<Value> = group
            .topics
            .iter()
            .map(|(agent, topic)| {
                json!({
                    "timestampMethod": "receiveTime", "enabled": true, "label": format!("agent {agent}"),
                    "value": format!("{topic}.{}{suffix}", group.field), "color": colour(*agent),
                })
            })
            .collect();
        let name = format!("Plot!{index}-{component}");
        let plot = json!({
            "title": format!("{}{suffix}", group.title), "paths": paths, "xAxisVal": "timestamp", "isSynced": true,
            "showXAxisLabels": true, "showYAxisLabels": true, "showLegend": component == 0,
            "legendDisplay": "floating", "sidebarDimension": 240, "foxglovePanelTitle": format!("{}{suffix}", group.title),
        });
        panels.insert(name.clone(), plot);
        names.push(name);
    }
    json!({ "title": group.title, "layout": stack(&names) })
}

/// Panels below each other, all of the same height.
fn stack(names: &[String]) -> Value {
    match names {
        [] => Value::Null,
        [name] => json!(name),
        [name, rest @ ..] => json!({
            "direction": "column", "first": name, "second": stack(rest), "splitPercentage": 100.0 / names.len() as f64,
        }),
    }
}
