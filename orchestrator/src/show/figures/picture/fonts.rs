//! The fonts of figures. They are part of the program, so a figure looks the same on every machine.

use clap::ValueEnum;
use ttf_parser::{Face, GlyphId, OutlineBuilder, Rect};

use super::outline::{Point, Segment, placed};

/// The font of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Font {
    /// With serifs: Liberation Serif, which has the metrics of Times New Roman
    Times,
    /// Without serifs: Liberation Sans, which has the metrics of Helvetica and Arial
    #[default]
    Helvetica,
}

/// Upright letters, or slanted ones for variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Slant {
    Upright,
    Italic,
}

/// A font with its upright and its slanted letters. Lengths are in units of the size of the font.
pub(crate) struct Fonts {
    upright: Face<'static>,
    italic: Face<'static>,
}

impl Font {
    /// The file of these letters.
    pub(super) fn file(self, slant: Slant) -> &'static [u8] {
        match (self, slant) {
            (Self::Times, Slant::Upright) => include_bytes!("../../../../assets/fonts/LiberationSerif-Regular.ttf"),
            (Self::Times, Slant::Italic) => include_bytes!("../../../../assets/fonts/LiberationSerif-Italic.ttf"),
            (Self::Helvetica, Slant::Upright) => include_bytes!("../../../../assets/fonts/LiberationSans-Regular.ttf"),
            (Self::Helvetica, Slant::Italic) => include_bytes!("../../../../assets/fonts/LiberationSans-Italic.ttf"),
        }
    }

    /// Its name in a file.
    pub(super) fn name(self, slant: Slant) -> &'static str {
        match (self, slant) {
            (Self::Times, Slant::Upright) => "LiberationSerif",
            (Self::Times, Slant::Italic) => "LiberationSerif-Italic",
            (Self::Helvetica, Slant::Upright) => "LiberationSans",
            (Self::Helvetica, Slant::Italic) => "LiberationSans-Italic",
        }
    }
}

impl Fonts {
    pub(crate) fn new(font: Font) -> Self {
        let face = |slant| Face::parse(font.file(slant), 0).expect("a valid font: it is part of the program");
        Self { upright: face(Slant::Upright), italic: face(Slant::Italic) }
    }

    pub(super) fn face(&self, slant: Slant) -> &Face<'static> {
        match slant {
            Slant::Upright => &self.upright,
            Slant::Italic => &self.italic,
        }
    }

    /// The glyph of a letter; the empty box of the font where it has none.
    pub(super) fn glyph(&self, slant: Slant, letter: char) -> GlyphId {
        self.face(slant).glyph_index(letter).unwrap_or_default()
    }

    /// How far the next letter is away.
    pub(super) fn advance(&self, slant: Slant, letter: char) -> f64 {
        let face = self.face(slant);
        let advance = face.glyph_hor_advance(self.glyph(slant, letter)).unwrap_or(0);
        f64::from(advance) / f64::from(face.units_per_em())
    }

    /// Left, lowest, right and highest place of the ink of a letter; y points upwards.
    pub(super) fn ink(&self, slant: Slant, letter: char) -> [f64; 4] {
        let face = self.face(slant);
        let none = Rect { x_min: 0, y_min: 0, x_max: 0, y_max: 0 };
        let ink = face.glyph_bounding_box(self.glyph(slant, letter)).unwrap_or(none);
        [ink.x_min, ink.y_min, ink.x_max, ink.y_max].map(|length| f64::from(length) / f64::from(face.units_per_em()))
    }

    /// The outline of a letter of this size whose baseline begins at `at`; `turned` upwards or not.
    pub(super) fn outline(&self, slant: Slant, letter: char, size: f64, at: Point, turned: bool) -> Vec<Segment> {
        let face = self.face(slant);
        let scale = size / f64::from(face.units_per_em());
        let mut pen = Pen { scale, at, turned, last: at, segments: Vec::new() };
        face.outline_glyph(self.glyph(slant, letter), &mut pen);
        pen.segments
    }
}

/// Takes down an outline in the coordinates of the picture.
struct Pen {
    scale: f64,
    at: Point,
    turned: bool,
    last: Point,
    segments: Vec<Segment>,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> Point {
        // y of a font points upwards.
        placed(self.at, self.turned, f64::from(x) * self.scale, -f64::from(y) * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = self.place(x, y);
        self.segments.push(Segment::Move(self.last));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.last = self.place(x, y);
        self.segments.push(Segment::Line(self.last));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        // The same curve with two control points.
        let (control, end) = (self.place(x1, y1), self.place(x, y));
        let towards =
            |from: Point| (from.0 + (control.0 - from.0) * 2.0 / 3.0, from.1 + (control.1 - from.1) * 2.0 / 3.0);
        self.segments.push(Segment::Cubic(towards(self.last), towards(end), end));
        self.last = end;
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.last = self.place(x, y);
        self.segments.push(Segment::Cubic(self.place(x1, y1), self.place(x2, y2), self.last));
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}
