//! A figure as a script for matplotlib with its data beside it, for changes that the options do not offer.

use serde_json::{Value, json};

use super::FigureOptions;
use super::layout::{Frame, Layout, layout};
use super::paint::marks;
use super::picture::{Font, Fonts, INCH, hexadecimal};
use super::sheet::{Plot, Sheet};
use super::style::{CURVE, Sample, Style};
use super::ticks::Ticks;

/// The script, with `@NAME@` and `@FIGURE@` for what differs.
const SCRIPT: &str = include_str!("../../../assets/figure.py");

/// All points: a row for each, with the numbers of its plot and of its line from 0.
///
/// # Errors
/// In words, if they cannot be written.
pub(super) fn data(sheet: &Sheet) -> Result<Vec<u8>, String> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut write = || -> Result<(), csv::Error> {
        table.write_record(["plot", "line", "x", "y"])?;
        for (number, plot) in sheet.rows.iter().flatten().enumerate() {
            for (index, line) in plot.lines.iter().enumerate() {
                for (x, y) in &line.points {
                    table.write_record([number.to_string(), index.to_string(), x.to_string(), y.to_string()])?;
                }
            }
        }
        Ok(())
    };
    write().map_err(|error| error.to_string())?;
    table.into_inner().map_err(|error| error.to_string())
}

/// The script that draws the figure `name`.
pub(super) fn script(sheet: &Sheet, options: &FigureOptions, name: &str) -> String {
    let layout = layout(sheet, options, &Fonts::new(options.font));
    let mut figure = String::new();
    push_literal(&mut figure, &description(sheet, &layout, options), 0);
    SCRIPT.replace("@NAME@", name).replace("@FIGURE@", &figure)
}

fn description(sheet: &Sheet, layout: &Layout, options: &FigureOptions) -> Value {
    let plots = sheet.rows.iter().flatten().zip(layout.frames.iter().flatten());
    let entries = sheet.legend.iter().map(|entry| {
        let (sample, style) = match &entry.sample {
            Sample::Curve(style) => ("curve", style),
            Sample::Start => ("start", &Style::BLACK),
            Sample::End => ("end", &Style::BLACK),
        };
        let mut of = style_of(style);
        of["name"] = entry.name.source().into();
        of["sample"] = sample.into();
        of
    });
    let note = layout.note.iter();
    json!({
        "width_inches": rounded(layout.width / INCH),
        "height_inches": rounded(layout.height / INCH),
        "font": if options.font == Font::Times { "times" } else { "helvetica" },
        "font_size": options.font_size,
        "line_width": CURVE,
        "marker_size": rounded(3.4 * options.font_size / 8.0),
        "note": note
            .map(|(line, (x, y))| json!([line.source(), rounded(x / layout.width), rounded(1.0 - y / layout.height)]))
            .collect::<Vec<_>>(),
        "legend_columns": layout.columns,
        "legend": entries.collect::<Vec<_>>(),
        "plots": plots.map(|(plot, frame)| plot_of(plot, frame, layout)).collect::<Vec<_>>(),
    })
}

fn plot_of(plot: &Plot, frame: &Frame, layout: &Layout) -> Value {
    let [x0, y0, x1, y1] = frame.bounds;
    let place = [x0 / layout.width, 1.0 - y1 / layout.height, (x1 - x0) / layout.width, (y1 - y0) / layout.height];
    let named =
        |ticks: &Ticks| ticks.named.iter().map(|(value, name)| json!([value, name.source()])).collect::<Vec<_>>();
    let lines = plot.lines.iter().enumerate().map(|(index, line)| {
        let mut of = style_of(&line.style);
        of["marks"] = marks(plot, index, frame).into();
        of["ends"] = line.ends.into();
        of
    });
    json!({
        "place": place.map(rounded),
        "title": plot.title.source(),
        "x_label": plot.x_label.source(),
        "y_label": plot.y_label.source(),
        "is_named": frame.is_named,
        "logarithmic": frame.y.logarithmic,
        "factor": frame.y.ticks.factor.as_ref().map(|factor| factor.source()),
        "x_range": frame.x.range,
        "y_range": frame.y.range,
        "x_ticks": named(&frame.x.ticks),
        "y_ticks": named(&frame.y.ticks),
        "y_minor_ticks": frame.y.ticks.minor,
        "limits": plot.limits,
        "lines": lines.collect::<Vec<_>>(),
    })
}

fn style_of(style: &Style) -> Value {
    json!({
        "colour": hexadecimal(style.colour),
        "dashes": style.dashes,
        "marker": style.marker.map(|marker| marker.name()),
    })
}

fn rounded(length: f64) -> f64 {
    (length * 1e5).round() / 1e5
}

/// Writes a value as Python does; what is short stays on one line.
fn push_literal(text: &mut String, value: &Value, depth: usize) {
    const SHORT: usize = 100;
    let plain = literal(value);
    if plain.len() + 4 * depth <= SHORT || !(value.is_array() || value.is_object()) {
        return text.push_str(&plain);
    }
    let indent = |text: &mut String, depth: usize| {
        text.push('\n');
        text.push_str(&"    ".repeat(depth));
    };
    let (open, close) = if value.is_array() { ('[', ']') } else { ('{', '}') };
    text.push(open);
    for item in value.as_array().into_iter().flatten() {
        indent(text, depth + 1);
        push_literal(text, item, depth + 1);
        text.push(',');
    }
    for (key, item) in value.as_object().into_iter().flatten() {
        indent(text, depth + 1);
        text.push_str(&format!("{key:?}: "));
        push_literal(text, item, depth + 1);
        text.push(',');
    }
    indent(text, depth);
    text.push(close);
}

fn literal(value: &Value) -> String {
    match value {
        Value::Null => "None".into(),
        Value::Bool(true) => "True".into(),
        Value::Bool(false) => "False".into(),
        // Escapes of JSON are those of Python.
        Value::Number(_) | Value::String(_) => value.to_string(),
        Value::Array(items) => format!("[{}]", items.iter().map(literal).collect::<Vec<_>>().join(", ")),
        Value::Object(items) => {
            let items = items.iter().map(|(key, item)| format!("{key:?}: {}", literal(item)));
            format!("{{{}}}", items.collect::<Vec<_>>().join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_written_as_python_does() {
        let value = json!({ "a": [true, null, 1.5], "b": "true \"x\" \\bar" });
        assert_eq!(literal(&value), r#"{"a": [True, None, 1.5], "b": "true \"x\" \\bar"}"#);
        let mut long = String::new();
        push_literal(&mut long, &json!({ "numbers": vec![1234567; 20] }), 0);
        assert!(long.starts_with("{\n    \"numbers\": [\n        1234567,\n") && long.ends_with("    ],\n}"), "{long}");
    }
}
