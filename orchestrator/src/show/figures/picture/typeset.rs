//! From a label to letters with places.

use super::fonts::{Fonts, Slant};
use super::label::{Accent, Label, Node};
use super::outline::{Point, Segment, placed};

/// Size of scripts, in that of the letters around them.
const SCRIPT: f64 = 0.75;
/// How far scripts stand below and above the baseline, in sizes of the font.
const LOWERED: f64 = 0.17;
const RAISED: f64 = 0.36;

/// Letters of one kind behind each other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Glyphs {
    pub(super) text: String,
    pub(super) slant: Slant,
    /// Size of the font, points.
    pub(super) size: f64,
    /// Where their baseline begins: to the right of that of the text, and below it, points.
    pub(super) x: f64,
    pub(super) y: f64,
}

/// How far slanted letters lean to the right, in their height.
const LEAN: f64 = 0.2;

/// A bar above a letter: its left and upper corner from the beginning of the baseline, its width and height, points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bar {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// A line of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Typeset {
    pub(super) letters: String,
    pub(super) glyphs: Vec<Glyphs>,
    pub(super) bars: Vec<Bar>,
    pub(crate) width: f64,
}

impl Typeset {
    /// Lays out a label in letters of `size` points.
    pub(crate) fn new(fonts: &Fonts, label: &Label, size: f64) -> Self {
        let mut text = Self { letters: label.letters(), ..Self::default() };
        text.width = text.add(fonts, &label.nodes, size, 0.0, 0.0);
        text
    }

    pub(super) fn is_empty(&self) -> bool {
        self.glyphs.is_empty()
    }

    /// Its letters and bars as outlines in the picture; its baseline begins at `at` and goes to the right, or upwards.
    pub(super) fn outlines(&self, fonts: &Fonts, at: Point, upwards: bool) -> Vec<Segment> {
        let place = |x: f64, y: f64| placed(at, upwards, x, y);
        let mut segments = Vec::new();
        for glyphs in &self.glyphs {
            let mut x = glyphs.x;
            for letter in glyphs.text.chars() {
                segments.extend(fonts.outline(glyphs.slant, letter, glyphs.size, place(x, glyphs.y), upwards));
                x += fonts.advance(glyphs.slant, letter) * glyphs.size;
            }
        }
        for bar in &self.bars {
            let (right, low) = (bar.x + bar.width, bar.y + bar.height);
            segments.push(Segment::Move(place(bar.x, bar.y)));
            segments.extend([(right, bar.y), (right, low), (bar.x, low)].map(|(x, y)| Segment::Line(place(x, y))));
            segments.push(Segment::Close);
        }
        segments
    }

    /// Adds nodes from `x` on, `y` below the baseline; where they end.
    fn add(&mut self, fonts: &Fonts, nodes: &[Node], size: f64, mut x: f64, y: f64) -> f64 {
        for node in nodes {
            x = match node {
                Node::Upright(text) => self.add_letters(fonts, text, Slant::Upright, size, x, y),
                Node::Italic(text) => self.add_letters(fonts, text, Slant::Italic, size, x, y),
                Node::Space(width) => x + width * size,
                Node::Accent(accent, body) => self.add_accent(fonts, *accent, body, size, x, y),
                Node::Scripts(below, above) => {
                    let begin = x + 0.03 * size;
                    let lower = self.add(fonts, below, SCRIPT * size, begin, y + LOWERED * size);
                    let upper = self.add(fonts, above, SCRIPT * size, begin, y - RAISED * size);
                    lower.max(upper) + 0.03 * size
                }
            };
        }
        x
    }

    fn add_letters(&mut self, fonts: &Fonts, text: &str, slant: Slant, size: f64, x: f64, y: f64) -> f64 {
        self.glyphs.push(Glyphs { text: text.into(), slant, size, x, y });
        x + text.chars().map(|letter| fonts.advance(slant, letter)).sum::<f64>() * size
    }

    fn add_accent(&mut self, fonts: &Fonts, accent: Accent, body: &[Node], size: f64, x: f64, y: f64) -> f64 {
        let first = self.glyphs.len();
        let end = self.add(fonts, body, size, x, y);
        // Where the ink of the body is: left, right, and its top above the baseline.
        let (mut left, mut right, mut top) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        let is_slanted = self.glyphs[first..].iter().all(|glyphs| glyphs.slant == Slant::Italic);
        for glyphs in &self.glyphs[first..] {
            let mut pen = glyphs.x;
            for letter in glyphs.text.chars() {
                let [x_min, _, x_max, y_max] = fonts.ink(glyphs.slant, letter).map(|length| length * glyphs.size);
                (left, right, top) = (left.min(pen + x_min), right.max(pen + x_max), top.max(y_max));
                pen += fonts.advance(glyphs.slant, letter) * glyphs.size;
            }
        }
        if left > right {
            return end;
        }
        // Above the upper half of slanted letters is to the right of their middle.
        let lean = if is_slanted { LEAN * (top / 2.0 + 0.1 * size) } else { 0.0 };
        let mark = match accent {
            Accent::Bar => {
                let height = 0.055 * size;
                self.bars.push(Bar { x: left + lean, y: y - top - 0.1 * size - height, width: right - left, height });
                return end;
            }
            Accent::Hat => 'ˆ',
            Accent::Tilde => '˜',
        };
        let [x_min, y_min, x_max, _] = fonts.ink(Slant::Upright, mark).map(|length| length * size);
        let middle = (left + right) / 2.0 + lean;
        self.glyphs.push(Glyphs {
            text: mark.into(),
            slant: Slant::Upright,
            size,
            x: middle - (x_min + x_max) / 2.0,
            y: y - (top + 0.07 * size - y_min),
        });
        end
    }
}

#[cfg(test)]
mod tests {
    use super::super::fonts::Font;
    use super::*;

    fn set(text: &str) -> Typeset {
        Typeset::new(&Fonts::new(Font::Helvetica), &Label::tex(text).expect("a label"), 8.0)
    }

    #[test]
    fn scripts_are_smaller_and_off_the_line() {
        let text = set("$x_p^2$");
        let found: Vec<(&str, f64, bool)> =
            text.glyphs.iter().map(|glyphs| (glyphs.text.as_str(), glyphs.size, glyphs.y > 0.0)).collect();
        assert_eq!(found, [("x", 8.0, false), ("p", 6.0, true), ("2", 6.0, false)]);
        assert!(text.glyphs[2].y < 0.0 && text.width > text.glyphs[2].x);
    }

    #[test]
    fn accents_stand_above_their_letter() {
        let text = set(r"$\hat{s}$");
        let [letter, accent] = &text.glyphs[..] else { panic!("{text:?}") };
        let centre = |glyphs: &Glyphs| {
            let fonts = Fonts::new(Font::Helvetica);
            let [left, _, right, _] = fonts.ink(glyphs.slant, glyphs.text.chars().next().unwrap());
            glyphs.x + (left + right) / 2.0 * glyphs.size
        };
        let lean = centre(accent) - centre(letter);
        assert!(lean > 0.0 && lean < 1.0, "as the letter leans: {text:?}");
        let bar = set(r"$\bar{δ}$");
        assert!(bar.bars[0].y < -4.0 && bar.bars[0].width > 2.0, "{bar:?}");
        // An accent takes no room.
        assert_eq!(set(r"$\hat{s}x$").width, set("$sx$").width);
    }
}
