//! Where everything of a figure stands. Lengths are points.

use super::FigureOptions;
use super::clip::Bounds;
use super::picture::{Fonts, INCH, Label, Point, Typeset};
use super::sheet::{Plot, Proportions, Sheet};
use super::ticks::Ticks;

/// Width of one column of a journal, and of two, inches.
const COLUMN: f64 = 3.5;
const TWO_COLUMNS: f64 = 7.16;
/// Rows from which on plots are lower.
const MANY_ROWS: usize = 5;
/// Length of the sample of a line in a legend.
pub(super) const SAMPLE: f64 = 21.0;

/// An axis on the page.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    pub(super) range: [f64; 2],
    pub(super) logarithmic: bool,
    /// Where the range begins and ends.
    place: [f64; 2],
    pub(super) ticks: Ticks,
}

impl Scale {
    /// Where a value stands; not finite if it has no place.
    pub(super) fn at(&self, value: f64) -> f64 {
        let of = |value: f64| if self.logarithmic { value.log10() } else { value };
        let [low, high] = self.range.map(of);
        self.place[0] + (of(value) - low) / (high - low) * (self.place[1] - self.place[0])
    }
}

/// The rectangle of a plot, without what stands around it.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) bounds: Bounds,
    pub(super) x: Scale,
    pub(super) y: Scale,
    /// Whether the numbers and the name of the horizontal axis stand below it.
    pub(super) is_named: bool,
    /// Where the middle of the name of the vertical axis stands.
    pub(super) name_at: f64,
}

/// A figure with places.
pub(super) struct Layout {
    pub(super) width: f64,
    pub(super) height: f64,
    /// In the order of the plots of the figure.
    pub(super) frames: Vec<Vec<Frame>>,
    /// The left ends of the entries of the legend, half way up.
    pub(super) entries: Vec<Point>,
    /// Entries beside each other.
    pub(super) columns: usize,
    /// The lines of the note, with the beginnings of their baselines.
    pub(super) note: Vec<(Label, Point)>,
}

/// Lays out a figure.
pub(super) fn layout(sheet: &Sheet, options: &FigureOptions, fonts: &Fonts) -> Layout {
    Builder { sheet, fonts, size: options.font_size, width: INCH * width(sheet, options) }.build()
}

/// Width of a figure, inches.
fn width(sheet: &Sheet, options: &FigureOptions) -> f64 {
    options.width.unwrap_or(if sheet.columns() > 1 { TWO_COLUMNS } else { COLUMN })
}

struct Builder<'a> {
    sheet: &'a Sheet,
    fonts: &'a Fonts,
    /// Of letters.
    size: f64,
    width: f64,
}

impl Builder<'_> {
    fn build(self) -> Layout {
        let (rows, columns) = (&self.sheet.rows, self.sheet.columns());
        let margins: Vec<f64> = (0..columns).map(|column| self.margin(column)).collect();
        let right = 0.9 * self.size;
        let inner = (self.width - margins.iter().sum::<f64>() - right * columns as f64) / columns as f64;
        let inner = inner.max(20.0);
        let note = self.note();
        let mut y = 2.0 + 1.25 * self.size * note.len() as f64;
        let mut frames = Vec::new();
        for (index, plots) in rows.iter().enumerate() {
            let is_named = index + 1 == rows.len() || !self.sheet.shares_axis();
            y += self.above(plots);
            let height = plots.iter().map(|plot| self.height(plot, inner)).fold(0.0, f64::max);
            let mut x = 0.0;
            let mut row = Vec::new();
            for (plot, margin) in plots.iter().zip(&margins) {
                x += margin;
                row.push(self.frame(plot, [x, y, x + inner, y + height], x - margin, is_named));
                x += inner + right;
            }
            frames.push(row);
            y += height + if is_named { 2.9 * self.size } else { 0.8 * self.size };
        }
        let (entries, columns, height) = self.legend(y + 0.3 * self.size);
        Layout { width: self.width, height, frames, entries, columns, note }
    }

    fn text_width(&self, label: &Label) -> f64 {
        Typeset::new(self.fonts, label, self.size).width
    }

    /// Room for a title, or for a power of ten, above a row.
    fn above(&self, plots: &[Plot]) -> f64 {
        let has_factor = |plot: &Plot| self.y_ticks(plot, self.free_height(20.0)).factor.is_some();
        match plots.iter().any(|plot| !plot.title.is_empty() || has_factor(plot)) {
            true => 1.55 * self.size,
            // Half of a number, with its exponent.
            false => 0.7 * self.size,
        }
    }

    /// Height of a plot whose proportions are free.
    fn free_height(&self, inner: f64) -> f64 {
        let scale = self.size / 8.0;
        match self.sheet.rows.len() {
            1 => (0.55 * inner).clamp(100.0 * scale, 170.0 * scale),
            count if count >= MANY_ROWS => 52.0 * scale,
            _ => 76.0 * scale,
        }
    }

    fn height(&self, plot: &Plot, inner: f64) -> f64 {
        if !plot.rows.is_empty() {
            return 1.9 * self.size * plot.rows.len() as f64;
        }
        match plot.proportions {
            Proportions::Free => self.free_height(inner),
            Proportions::Equal => {
                let [[left, right], [low, high]] = [plot.x_range(), plot.y_range()];
                // Two views fit on a page with text.
                let highest = if self.sheet.rows.len() > 1 { 0.85 } else { 1.05 };
                ((high - low) / (right - left) * inner).clamp(0.3 * inner, highest * inner)
            }
        }
    }

    fn y_ticks(&self, plot: &Plot, height: f64) -> Ticks {
        let most = |lines: f64| ((height / (lines * self.size)) as usize).clamp(2, 7);
        match plot.is_logarithmic() {
            _ if !plot.rows.is_empty() => Ticks::rows(&plot.rows),
            true => Ticks::decades(plot.y_range(), most(2.1)),
            false => Ticks::linear(plot.y_range(), most(1.6)),
        }
    }

    /// Room for numbers and name at the left of a column.
    fn margin(&self, column: usize) -> f64 {
        let plots = self.sheet.rows.iter().filter_map(|row| row.get(column));
        let numbers = |plot: &Plot| {
            // The height does not depend on the margin but for equal proportions, where it is about this.
            let ticks = self.y_ticks(plot, self.height(plot, 0.8 * self.width / self.sheet.columns() as f64));
            ticks.named.iter().map(|(_, name)| self.text_width(name)).fold(0.0, f64::max)
        };
        plots.map(numbers).fold(0.0, f64::max) + 2.6 * self.size
    }

    fn frame(&self, plot: &Plot, bounds: Bounds, left: f64, is_named: bool) -> Frame {
        let [x0, y0, x1, y1] = bounds;
        let (mut x_range, mut y_range) = (plot.x_range(), plot.y_range());
        if plot.proportions == Proportions::Equal {
            // Whichever axis has room to spare shows more.
            let (per_x, per_y) = ((x_range[1] - x_range[0]) / (x1 - x0), (y_range[1] - y_range[0]) / (y1 - y0));
            if per_x < per_y {
                x_range = widened(x_range, per_y / per_x);
            } else {
                y_range = widened(y_range, per_x / per_y);
            }
        }
        let most = (((x1 - x0) / (4.2 * self.size)) as usize).clamp(2, 8);
        let x = Scale { range: x_range, logarithmic: false, place: [x0, x1], ticks: Ticks::linear(x_range, most) };
        let ticks = match plot.proportions {
            Proportions::Equal => Ticks::linear(y_range, (((y1 - y0) / (3.0 * self.size)) as usize).clamp(2, 8)),
            Proportions::Free => self.y_ticks(plot, y1 - y0),
        };
        let y = Scale { range: y_range, logarithmic: plot.is_logarithmic(), place: [y1, y0], ticks };
        Frame { bounds, x, y, is_named, name_at: left + 1.4 * self.size }
    }

    /// Entries of the legend below `top`: where they begin, how many stand beside each other, and where the legend ends.
    fn legend(&self, top: f64) -> (Vec<Point>, usize, f64) {
        let entries = &self.sheet.legend;
        if entries.is_empty() {
            return (Vec::new(), 0, top);
        }
        let gap = 1.2 * self.size;
        let longest = entries.iter().map(|entry| self.text_width(&entry.name)).fold(0.0, f64::max);
        let width = SAMPLE + 0.5 * self.size + longest;
        let fitting = (((self.width - 6.0 + gap) / (width + gap)) as usize).clamp(1, entries.len());
        let columns = entries.len().div_ceil(entries.len().div_ceil(fitting));
        let left = (self.width - width * columns as f64 - gap * (columns - 1) as f64) / 2.0;
        let line = 1.4 * self.size;
        let place = |index: usize| {
            let (row, column) = (index / columns, index % columns);
            (left + (width + gap) * column as f64, top + line * (row as f64 + 0.5))
        };
        let rows = entries.len().div_ceil(columns);
        ((0..entries.len()).map(place).collect(), columns, top + line * rows as f64 + 2.0)
    }

    /// The note, broken into lines at its spaces.
    fn note(&self) -> Vec<(Label, Point)> {
        let mut lines: Vec<String> = Vec::new();
        for word in self.sheet.note.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.text_width(&Label::plain(&format!("{line} {word}"))) < self.width - 8.0 => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.into()),
            }
        }
        let place = |(index, line): (usize, String)| {
            (Label::plain(&line), (4.0, 1.0 + 1.25 * self.size * (index as f64 + 0.85)))
        };
        lines.into_iter().enumerate().map(place).collect()
    }
}

fn widened([low, high]: [f64; 2], factor: f64) -> [f64; 2] {
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * factor);
    [middle - half, middle + half]
}
