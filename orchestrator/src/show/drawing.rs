//! Line plots of text: every character is a grid of two by four dots of the Braille alphabet.

use crate::judge::verdict::short;

/// The dots of a character, from the top row to the bottom row, left and right.
const DOTS: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
/// Codes of the colours of the lines, from the 256 that terminals agree on: Okabe and Ito's, for light and dark backgrounds.
const COLOURS: [u8; 7] = [32, 166, 36, 178, 175, 74, 246];
/// Columns for the numbers at the left.
const MARGIN: usize = 11;

/// A curve and what it is called.
pub(crate) struct Line {
    /// Its name.
    pub(crate) label: String,
    /// Its values.
    pub(crate) values: Vec<f64>,
}

/// How large a drawing is, and how it looks.
pub(crate) struct Drawing {
    /// Characters of a row.
    pub(crate) columns: usize,
    /// Rows of the drawing itself.
    pub(crate) rows: usize,
    /// Whether the values are drawn on a logarithmic scale.
    pub(crate) logarithmic: bool,
    /// Whether the lines have colours.
    pub(crate) coloured: bool,
}

/// A character of the drawing: its dots, and the line that drew last.
#[derive(Clone, Copy, Default)]
struct Cell {
    dots: u8,
    line: usize,
}

impl Drawing {
    /// Draws `lines` over `times` (ascending, at least two).
    pub(crate) fn draw(&self, times: &[f64], lines: &[Line]) -> String {
        let width = self.columns.saturating_sub(MARGIN + 1).max(10);
        let scale = |value: f64| if self.logarithmic { value.log10() } else { value };
        let drawable = lines.iter().flat_map(|line| &line.values).map(|value| scale(*value));
        let (low, high) = drawable
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return "There is no number to draw on this scale.\n".into();
        }
        // A constant is a line in the middle.
        let room = if high > low { 0.0 } else { low.abs().max(1.0) * 0.5 };
        let (low, high) = (low - room, high + room);
        let (start, end) = (times[0], times[times.len() - 1]);
        let mut cells = vec![Cell::default(); width * self.rows];
        for (index, line) in lines.iter().enumerate() {
            let mut before: Option<(usize, usize)> = None;
            for (time, value) in times.iter().zip(&line.values) {
                let value = scale(*value);
                if !value.is_finite() {
                    before = None;
                    continue;
                }
                let place = |share: f64, dots: usize| (share * (dots - 1) as f64).round() as usize;
                let x = place((time - start) / (end - start), 2 * width);
                let y = place((high - value) / (high - low), 4 * self.rows);
                let (x0, y0) = before.unwrap_or((x, y));
                let count = x.abs_diff(x0).max(y.abs_diff(y0)).max(1);
                for k in 0..=count {
                    let between = |a: usize, b: usize| a as f64 + (b as f64 - a as f64) * k as f64 / count as f64;
                    let (x, y) = (between(x0, x).round() as usize, between(y0, y).round() as usize);
                    let cell = &mut cells[(y / 4) * width + x / 2];
                    *cell = Cell { dots: cell.dots | DOTS[y % 4][x % 2], line: index };
                }
                before = Some((x, y));
            }
        }
        let marks = if self.coloured { Vec::new() } else { marks(&cells, width, lines.len()) };
        let mut text = String::new();
        for (row, cells) in cells.chunks(width).enumerate() {
            let share = row as f64 / (self.rows - 1).max(1) as f64;
            let labelled = row == 0 || row + 1 == self.rows || row == self.rows / 2;
            let value = high - share * (high - low);
            let label =
                if labelled { short(if self.logarithmic { 10_f64.powf(value) } else { value }) } else { String::new() };
            text.push_str(&format!("{label:>width$} ", width = MARGIN - 2));
            text.push(if labelled { '┤' } else { '│' });
            self.push_row(&mut text, cells, &marks, row * width);
        }
        text.push_str(&format!("{:>MARGIN$}{}\n", "└", "─".repeat(width)));
        let (start, end) = (format!("{} s", short(start)), format!("{} s", short(end)));
        let gap = width.saturating_sub(start.chars().count() + end.chars().count());
        text.push_str(&format!("{:MARGIN$}{start}{}{end}\n", "", " ".repeat(gap)));
        for (index, line) in lines.iter().enumerate() {
            let sample =
                if marks.is_empty() { self.paint(index, "━━") } else { format!("━{}━", letter(index)) };
            text.push_str(&format!("  {sample} {}{}\n", line.label, range(&line.values)));
        }
        text
    }

    /// Adds a row of cells, the first of which is the `first` of the drawing.
    fn push_row(&self, text: &mut String, cells: &[Cell], marks: &[(usize, char)], first: usize) {
        let mut row = String::new();
        for (place, cell) in cells.iter().enumerate() {
            let mark = marks.iter().find(|(marked, _)| *marked == first + place).map(|(_, letter)| *letter);
            let dots = char::from_u32(0x2800 + u32::from(cell.dots)).filter(|_| cell.dots != 0);
            let letter = mark.or(dots).unwrap_or(' ');
            row.push_str(&if letter == ' ' { " ".to_string() } else { self.paint(cell.line, &letter.to_string()) });
        }
        text.push_str(row.trim_end());
        text.push('\n');
    }

    fn paint(&self, line: usize, text: &str) -> String {
        match self.coloured {
            true => format!("\x1b[38;5;{}m{text}\x1b[0m", COLOURS[line % COLOURS.len()]),
            false => text.into(),
        }
    }
}

/// Letters on the lines, for a drawing without colours: cells and what stands there. The letters of several lines take turns; a single
/// line has none.
fn marks(cells: &[Cell], width: usize, lines: usize) -> Vec<(usize, char)> {
    /// Columns from a letter to the next one of any line.
    const APART: usize = 4;
    let mut marks = Vec::new();
    if lines < 2 {
        return marks;
    }
    for column in (APART / 2..width).step_by(APART) {
        // Where the line whose turn it is lies below others, the next one takes its place.
        for turn in 0..lines {
            let line = (column / APART + turn) % lines;
            let of_line = |place: &usize| cells[*place].dots != 0 && cells[*place].line == line;
            if let Some(place) = (column..cells.len()).step_by(width).find(of_line) {
                marks.push((place, letter(line)));
                break;
            }
        }
    }
    marks
}

/// The letter of a line.
fn letter(line: usize) -> char {
    char::from(b'a' + (line % 26) as u8)
}

/// `  0.12 ... 3.4, last 0.2`: what the eye cannot read off the dots.
fn range(values: &[f64]) -> String {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (a.min(value), b.max(value)));
    match values.last() {
        Some(last) if low <= high => format!("   {} ... {}, last {}", short(low), short(high), short(*last)),
        _ => "   no number".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(values: &[f64], logarithmic: bool) -> String {
        let times: Vec<f64> = (0..values.len()).map(|k| k as f64).collect();
        let drawing = Drawing { columns: 42, rows: 3, logarithmic, coloured: false };
        drawing.draw(&times, &[Line { label: "x".into(), values: values.to_vec() }])
    }

    #[test]
    fn a_ramp_goes_from_corner_to_corner() {
        let text = drawn(&[0.0, 1.0], false);
        let rows: Vec<&str> = text.lines().collect();
        assert!(
            rows[0].ends_with('⠉')
                || rows[0].ends_with('⠁')
                || rows[0].ends_with('⠈')
                || rows[0].ends_with('⠋')
                || rows[0].ends_with('⠊'),
            "{text}"
        );
        assert_eq!(rows[0].chars().count(), 41, "{text}");
        assert!(rows[2].trim_start().starts_with("0 ┤"), "{text}");
        assert!(text.contains("x   0 ... 1, last 1"), "{text}");
        assert!(!text.contains('\x1b'));
    }

    #[test]
    fn lines_without_colours_have_letters() {
        let times: Vec<f64> = (0..40).map(f64::from).collect();
        let line = |label: &str, value: f64| Line { label: label.into(), values: vec![value; 40] };
        let lines = [line("low", 0.0), line("high", 1.0)];
        let text = Drawing { columns: 60, rows: 5, logarithmic: false, coloured: false }.draw(&times, &lines);
        let rows: Vec<&str> = text.lines().collect();
        let count = |row: usize, letter: char| rows[row].matches(letter).count();
        assert_eq!(
            (count(0, 'a'), count(0, 'b') >= 3, count(4, 'a') >= 3, count(4, 'b')),
            (0, true, true, 0),
            "{text}"
        );
        assert!(text.contains("━a━ low") && text.contains("━b━ high"), "{text}");
        let coloured = Drawing { columns: 60, rows: 5, logarithmic: false, coloured: true }.draw(&times, &lines);
        assert!(coloured.contains("━━") && !coloured.contains("━a━"));
    }

    #[test]
    fn constants_gaps_and_nothing_are_drawn_too() {
        assert!(drawn(&[2.0, 2.0, 2.0], false).contains("2 ┤"));
        assert!(drawn(&[1.0, f64::NAN, 1.0], false).contains("last 1"));
        assert!(drawn(&[-1.0, -2.0], true).contains("no number"));
        assert!(drawn(&[1.0, 100.0], true).contains("10 ┤"));
    }
}
