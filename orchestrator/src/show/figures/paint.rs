//! From a figure with places to a picture.

use super::FigureOptions;
use super::clip::cut;
use super::layout::{Frame, Layout, SAMPLE, layout};
use super::picture::{Colour, Fonts, Label, Picture, Point, Stroke, Typeset};
use super::sheet::{Line, Plot, Proportions, Sheet};
use super::style::{CURVE, Sample, Style};

const GRID: Colour = [0xdd; 3];
const BLACK: Colour = [0; 3];
/// Height of a letter's middle above the baseline, in sizes of the font.
const MIDDLE: f64 = 0.35;
/// Distance of two markers on a curve, points.
const MARKS_APART: f64 = 30.0;

/// Draws a figure.
pub(super) fn paint(sheet: &Sheet, options: &FigureOptions) -> Picture {
    let fonts = Fonts::new(options.font);
    let layout = layout(sheet, options, &fonts);
    let picture = Picture::new(layout.width, layout.height, options.font);
    let mut painter = Painter { picture, fonts, size: options.font_size };
    for (plots, frames) in sheet.rows.iter().zip(&layout.frames) {
        for (plot, frame) in plots.iter().zip(frames) {
            painter.plot(plot, frame);
        }
    }
    painter.legend(sheet, &layout);
    for (line, at) in &layout.note {
        let text = painter.set(line);
        painter.picture.text(text, *at);
    }
    painter.picture
}

struct Painter {
    picture: Picture,
    fonts: Fonts,
    size: f64,
}

impl Painter {
    fn set(&self, label: &Label) -> Typeset {
        Typeset::new(&self.fonts, label, self.size)
    }

    fn marker_radius(&self) -> f64 {
        1.7 * self.size / 8.0
    }

    fn plot(&mut self, plot: &Plot, frame: &Frame) {
        let [x0, y0, x1, y1] = frame.bounds;
        let thin = |colour: Colour, width: f64| Stroke { colour, width, dashes: Vec::new() };
        for (value, _) in &frame.x.ticks.named {
            let x = frame.x.at(*value);
            self.picture.line(&[(x, y0), (x, y1)], thin(GRID, 0.4));
        }
        for (value, _) in &frame.y.ticks.named {
            let y = frame.y.at(*value);
            self.picture.line(&[(x0, y), (x1, y)], thin(GRID, 0.4));
        }
        for limit in &plot.limits {
            let y = frame.y.at(*limit);
            if (y0..=y1).contains(&y) {
                self.picture.line(&[(x0, y), (x1, y)], Style::LIMIT.stroke(0.7));
            }
        }
        for line in &plot.lines {
            self.curve(line, frame);
        }
        for (index, line) in plot.lines.iter().enumerate() {
            let (places, radius) = (places(line, frame), self.marker_radius());
            for mark in marks(plot, index, frame) {
                if let Some(marker) = line.style.marker {
                    marker.draw(&mut self.picture, places[mark], radius, line.style.colour);
                }
            }
            if line.ends
                && let (Some(first), Some(last)) = (places.first(), places.last())
            {
                self.end(*first, line.style.colour, Some([255; 3]));
                self.end(*last, line.style.colour, None);
            }
        }
        self.picture.polygon(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], Some(thin(BLACK, 0.6)), None);
        self.ticks(frame);
        self.names(plot, frame);
    }

    /// The sign at the beginning of a trajectory (white inside) or at its end.
    fn end(&mut self, at: Point, colour: Colour, fill: Option<Colour>) {
        let stroke = Stroke { colour, width: 0.8, dashes: Vec::new() };
        self.picture.circle(at, 1.35 * self.marker_radius(), Some(stroke), Some(fill.unwrap_or(colour)));
    }

    fn curve(&mut self, line: &Line, frame: &Frame) {
        let places = places(line, frame);
        for piece in places.split(|(x, y)| !x.is_finite() || !y.is_finite()) {
            for visible in cut(piece, &frame.bounds) {
                self.picture.line(&visible, line.style.stroke(CURVE));
            }
        }
    }

    fn ticks(&mut self, frame: &Frame) {
        let [x0, _, _, y1] = frame.bounds;
        let (x, y) = (&frame.x, &frame.y);
        let mut tick = |from: Point, to: Point| {
            self.picture.line(&[from, to], Stroke { colour: BLACK, width: 0.6, dashes: Vec::new() });
        };
        x.ticks.named.iter().for_each(|(value, _)| tick((x.at(*value), y1), (x.at(*value), y1 - 2.5)));
        y.ticks.named.iter().for_each(|(value, _)| tick((x0, y.at(*value)), (x0 + 2.5, y.at(*value))));
        y.ticks.minor.iter().for_each(|value| tick((x0, y.at(*value)), (x0 + 1.4, y.at(*value))));
    }

    /// Numbers, names and title.
    fn names(&mut self, plot: &Plot, frame: &Frame) {
        let [x0, y0, x1, y1] = frame.bounds;
        let size = self.size;
        for (value, name) in &frame.y.ticks.named {
            let text = self.set(name);
            let at = (x0 - 0.35 * size - text.width, frame.y.at(*value) + MIDDLE * size);
            self.picture.text(text, at);
        }
        if let Some(factor) = &frame.y.ticks.factor {
            let text = self.set(factor);
            self.picture.text(text, (x0, y0 - 0.4 * size));
        }
        if frame.is_named {
            for (value, name) in &frame.x.ticks.named {
                let text = self.set(name);
                // The last number must not leave the page.
                let left = (frame.x.at(*value) - text.width / 2.0).min(x1 + 0.85 * size - text.width);
                self.picture.text(text, (left, y1 + 1.05 * size));
            }
            let name = self.set(&plot.x_label);
            let left = (x0 + x1 - name.width) / 2.0;
            self.picture.text(name, (left, y1 + 2.25 * size));
        }
        let name = self.set(&plot.y_label);
        let middle = ((y0 + y1 + name.width) / 2.0).max(name.width + 1.0);
        self.picture.upright(name, (frame.name_at - MIDDLE * size, middle));
        let title = self.set(&plot.title);
        let left = ((x0 + x1 - title.width) / 2.0).max(x0.min(self.picture.width - title.width - 2.0)).max(2.0);
        self.picture.text(title, (left, y0 - 0.45 * size));
    }

    fn legend(&mut self, sheet: &Sheet, layout: &Layout) {
        for (entry, &(x, y)) in sheet.legend.iter().zip(&layout.entries) {
            let (middle, radius) = ((x + SAMPLE / 2.0, y), self.marker_radius());
            match &entry.sample {
                Sample::Curve(style) => {
                    self.picture.line(&[(x, y), (x + SAMPLE, y)], style.stroke(CURVE));
                    if let Some(marker) = style.marker {
                        marker.draw(&mut self.picture, middle, radius, style.colour);
                    }
                }
                Sample::Start => self.end(middle, BLACK, Some([255; 3])),
                Sample::End => self.end(middle, BLACK, None),
            }
            let text = self.set(&entry.name);
            self.picture.text(text, (x + SAMPLE + 0.5 * self.size, y + MIDDLE * self.size));
        }
    }
}

/// Where the points of a line stand on the page.
fn places(line: &Line, frame: &Frame) -> Vec<Point> {
    line.points.iter().map(|&(x, y)| (frame.x.at(x), frame.y.at(y))).collect()
}

/// The points of a line that carry its marker: at equal intervals of the horizontal axis, or of its way where it goes to and fro. The
/// markers of several lines take turns.
pub(super) fn marks(plot: &Plot, index: usize, frame: &Frame) -> Vec<usize> {
    let line = &plot.lines[index];
    // A single curve needs none.
    let count = plot.lines.iter().filter(|line| line.style.marker.is_some()).count();
    if line.style.marker.is_none() || count < 2 {
        return Vec::new();
    }
    let places = places(line, frame);
    let mut way = 0.0;
    let ways: Vec<f64> = places
        .iter()
        .enumerate()
        .map(|(k, &(x, y))| {
            let (before_x, before_y) = places[k.saturating_sub(1)];
            let step = match plot.proportions {
                Proportions::Equal => (x - before_x).hypot(y - before_y),
                Proportions::Free => x - before_x,
            };
            way += if step.is_finite() { step } else { 0.0 };
            way
        })
        .collect();
    let [x0, y0, x1, y1] = frame.bounds;
    let length = if plot.proportions == Proportions::Equal { way } else { x1 - x0 };
    let intervals = (length / MARKS_APART).round().clamp(2.0, 9.0);
    let share = (index as f64 + 0.5) / plot.lines.len() as f64;
    (0..intervals as usize)
        .map(|interval| (interval as f64 + share) / intervals * length)
        .map(|wanted| ways.partition_point(|way| *way < wanted))
        .filter(|&k| places.get(k).is_some_and(|(x, y)| (x0..=x1).contains(x) && (y0..=y1).contains(y)))
        .collect()
}
