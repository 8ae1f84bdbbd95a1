//! What all figures have in common.

use kuva::plot::LineStyle;
use kuva::render::layout::Layout;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use crate::show::view::LoggedRun;

/// Okabe and Ito's colours, ordered so that neighbours differ in lightness too.
const COLOURS: [&str; 8] = ["#0072B2", "#E69F00", "#000000", "#56B4E9", "#D55E00", "#009E73", "#CC79A7", "#8A7F00"];
const DASHES: [&str; 6] = ["", "7 2.5", "2 2", "8 2.5 2 2.5", "12 3", "5 2 1.5 2 1.5 2"];

/// Letters, lines and margins for one column of a journal.
pub(super) fn apply(layout: Layout) -> Layout {
    layout
        .with_title_size(11)
        .with_label_size(11)
        .with_tick_size(10)
        .with_body_size(10)
        .with_axis_line_width(0.8)
        .with_tick_width(0.8)
        .with_tick_length(3.0)
        .with_grid_line_width(0.4)
        .with_ticks(5)
        .with_font_family("Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif")
}

/// The colour of an agent; black for what belongs to all.
pub(super) fn colour(agent: Option<usize>) -> &'static str {
    agent.map_or("#000000", |agent| COLOURS[agent % COLOURS.len()])
}

/// The dashes of an agent: together with its colour they are unique up to 24 agents.
pub(super) fn dashes(agent: Option<usize>) -> LineStyle {
    match DASHES[agent.unwrap_or(0) % DASHES.len()] {
        "" => LineStyle::Solid,
        pattern => LineStyle::Custom(pattern.into()),
    }
}

/// The dashes of a curve beside another one.
pub(super) fn second() -> LineStyle {
    LineStyle::Custom("1 2".into())
}

/// What a legend says of a line.
pub(super) struct Entry {
    /// Whose line it is.
    pub(super) name: String,
    /// Its colour.
    pub(super) colour: &'static str,
    /// Its dashes.
    pub(super) dashes: LineStyle,
}

/// An entry for every agent.
pub(super) fn agents(run: &LoggedRun) -> Vec<Entry> {
    let entry = |place| Entry { name: run.agent_name(place), colour: colour(Some(place)), dashes: dashes(Some(place)) };
    (0..run.agents.len()).map(entry).collect()
}

/// Adds a legend below everything else.
pub(super) fn add_legend(scene: &mut Scene, entries: &[Entry]) {
    const LINE: f64 = 18.0;
    const ROW: f64 = 15.0;
    const GAP: f64 = 8.0;
    // What letters take, a little rounded up.
    let letter = |letter: char| if letter.is_uppercase() { 7.2 } else { 5.4 };
    let longest = entries.iter().map(|entry| entry.name.chars().map(letter).sum::<f64>()).fold(0.0, f64::max);
    let width = LINE + GAP + longest;
    let columns = (scene.width / width).floor().max(1.0) as usize;
    for row in entries.chunks(columns) {
        let left = (scene.width - width * row.len() as f64) / 2.0;
        let y = scene.height + ROW / 2.0 - 3.0;
        for (column, entry) in row.iter().enumerate() {
            let x = left + width * column as f64;
            scene.elements.push(Primitive::PolyLine {
                points: vec![(x, y), (x + LINE, y)],
                stroke: entry.colour.into(),
                stroke_width: 1.3,
                stroke_dasharray: entry.dashes.dasharray(),
            });
            scene.elements.push(Primitive::Text {
                x: x + LINE + 4.0,
                y: y + 3.5,
                content: entry.name.clone(),
                size: 10,
                anchor: TextAnchor::Start,
                rotate: None,
                bold: false,
                color: None,
            });
        }
        scene.height += ROW;
    }
    scene.height += 3.0;
}
