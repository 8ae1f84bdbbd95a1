//! A drawing as a page of PDF: vectors, and letters of a font that is embedded, as journals demand.

use std::collections::BTreeMap;

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};
use subsetter::GlyphRemapper;
use ttf_parser::{Face, GlyphId};

use super::INCHES;
use super::pixels::numbers;

/// Points of a unit.
const POINTS: f32 = 72.0 * INCHES as f32;
/// How the font is called; the letters in front say that only some of its glyphs are there.
const FONT_NAME: &[u8] = b"FIGURE+DejaVuSans";
/// The name of the font on the page.
const FONT: Name<'static> = Name(b"F");
/// Distance of the control points of a quarter of a circle from its ends, in radii.
const CIRCLE: f32 = 0.552_284_8;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const TYPE0: Ref = Ref::new(5);
const CID_FONT: Ref = Ref::new(6);
const DESCRIPTOR: Ref = Ref::new(7);
const FONT_FILE: Ref = Ref::new(8);
const TO_UNICODE: Ref = Ref::new(9);
const INFO: Ref = Ref::new(10);

/// The drawing as a file.
///
/// # Errors
/// What the drawing has that this does not draw, or what is wrong with the font.
pub(super) fn render(scene: &Scene) -> Result<Vec<u8>, String> {
    let font = dejavu::sans::regular();
    let face = Face::parse(font, 0).map_err(|error| format!("the font: {error}"))?;
    let mut page = Page { content: Content::new(), letters: Letters::new(face) };
    page.content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, scene.height as f32 * POINTS]);
    page.content.set_line_join(LineJoinStyle::RoundJoin);
    for element in &scene.elements {
        page.draw(element)?;
    }
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let size = Rect::new(0.0, 0.0, scene.width as f32 * POINTS, scene.height as f32 * POINTS);
    let mut leaf = pdf.page(PAGE);
    leaf.parent(PAGES).media_box(size).contents(CONTENT);
    leaf.resources().fonts().pair(FONT, TYPE0);
    leaf.finish();
    pdf.stream(CONTENT, &compressed(&page.content.finish())).filter(Filter::FlateDecode);
    page.letters.embed(&mut pdf, font)?;
    // No date: equal drawings are equal files.
    pdf.document_info(INFO).producer(pdf_writer::TextStr(concat!("phalanx ", env!("CARGO_PKG_VERSION"))));
    Ok(pdf.finish())
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    miniz_oxide::deflate::compress_to_vec_zlib(bytes, 6)
}

struct Page {
    content: Content,
    letters: Letters,
}

impl Page {
    fn draw(&mut self, element: &Primitive) -> Result<(), String> {
        let content = &mut self.content;
        match element {
            Primitive::Line { x1, y1, x2, y2, stroke, stroke_width, stroke_dasharray } => {
                self.polyline(&[(*x1, *y1), (*x2, *y2)], stroke, *stroke_width, stroke_dasharray.as_deref())
            }
            Primitive::PolyLine { points, stroke, stroke_width, stroke_dasharray } => {
                self.polyline(points, stroke, *stroke_width, stroke_dasharray.as_deref())
            }
            Primitive::Rect { x, y, width, height, fill, stroke, stroke_width, .. } => {
                content.rect(*x as f32, *y as f32, *width as f32, *height as f32);
                self.paint(fill, stroke.as_ref(), *stroke_width)
            }
            Primitive::Circle { cx, cy, r, fill, stroke, stroke_width, .. } => {
                circle(content, *cx as f32, *cy as f32, *r as f32);
                self.paint(fill, stroke.as_ref(), *stroke_width)
            }
            Primitive::CircleBatch { cx, cy, r, fill, stroke, stroke_width, .. } => {
                for (x, y) in cx.iter().zip(cy) {
                    circle(content, *x as f32, *y as f32, *r as f32);
                }
                self.paint(fill, stroke.as_ref(), *stroke_width)
            }
            Primitive::Text { x, y, content, size, anchor, rotate, color, .. } => {
                self.text(*x as f32, *y as f32, content, *size as f32, *anchor, rotate.unwrap_or(0.0), color.as_ref())
            }
            Primitive::GroupStart { transform, .. } => {
                content.save_state();
                if let Some([x, y]) = transform.as_deref().map(translation) {
                    content.transform([1.0, 0.0, 0.0, 1.0, x, y]);
                }
                Ok(())
            }
            Primitive::ClipStart { x, y, width, height, .. } => {
                content.save_state();
                content.rect(*x as f32, *y as f32, *width as f32, *height as f32).clip_nonzero().end_path();
                Ok(())
            }
            Primitive::GroupEnd | Primitive::ClipEnd => {
                content.restore_state();
                Ok(())
            }
            other => Err(format!("a figure has something that PDF files do not: {other:?}")),
        }
    }

    fn polyline(
        &mut self,
        points: &[(f64, f64)],
        stroke: &Color,
        width: f64,
        dashes: Option<&str>,
    ) -> Result<(), String> {
        let Some([r, g, b]) = rgb(stroke)? else { return Ok(()) };
        let content = &mut self.content;
        content.set_stroke_rgb(r, g, b).set_line_width(width as f32);
        let pattern = dashes.into_iter().flat_map(numbers).map(|length| length as f32);
        content.set_dash_pattern(pattern, 0.0);
        for (index, (x, y)) in points.iter().enumerate() {
            match index {
                0 => content.move_to(*x as f32, *y as f32),
                _ => content.line_to(*x as f32, *y as f32),
            };
        }
        content.stroke();
        Ok(())
    }

    /// Fills and strokes the path that was made.
    fn paint(&mut self, fill: &Color, stroke: Option<&Color>, width: Option<f64>) -> Result<(), String> {
        let (fill, stroke) = (rgb(fill)?, stroke.map(rgb).transpose()?.flatten());
        let content = &mut self.content;
        if let Some([r, g, b]) = fill {
            content.set_fill_rgb(r, g, b);
        }
        if let Some([r, g, b]) = stroke {
            content.set_stroke_rgb(r, g, b).set_line_width(width.unwrap_or(1.0) as f32).set_dash_pattern([], 0.0);
        }
        match (fill, stroke) {
            (Some(_), Some(_)) => content.fill_nonzero_and_stroke(),
            (Some(_), None) => content.fill_nonzero(),
            (None, Some(_)) => content.stroke(),
            (None, None) => content.end_path(),
        };
        Ok(())
    }

    #[expect(clippy::too_many_arguments, reason = "the fields of a text of the drawing")]
    fn text(
        &mut self,
        x: f32,
        y: f32,
        text: &str,
        size: f32,
        anchor: TextAnchor,
        degrees: f64,
        colour: Option<&Color>,
    ) -> Result<(), String> {
        let Some([r, g, b]) = colour.map_or(Ok(Some([0.0; 3])), rgb)? else { return Ok(()) };
        let (codes, width) = self.letters.encode(text);
        let back = match anchor {
            TextAnchor::Start => 0.0,
            TextAnchor::Middle => width * size / 2.0,
            TextAnchor::End => width * size,
        };
        let (sin, cos) = (degrees.to_radians().sin() as f32, degrees.to_radians().cos() as f32);
        let content = &mut self.content;
        content.begin_text().set_fill_rgb(r, g, b).set_font(FONT, size);
        // The page is upside down, as drawings are; letters are not.
        content.set_text_matrix([cos, sin, sin, -cos, x - back * cos, y - back * sin]);
        content.show(Str(&codes)).end_text();
        Ok(())
    }
}

fn circle(content: &mut Content, x: f32, y: f32, r: f32) {
    let c = CIRCLE * r;
    content.move_to(x + r, y);
    content.cubic_to(x + r, y + c, x + c, y + r, x, y + r);
    content.cubic_to(x - c, y + r, x - r, y + c, x - r, y);
    content.cubic_to(x - r, y - c, x - c, y - r, x, y - r);
    content.cubic_to(x + c, y - r, x + r, y - c, x + r, y);
    content.close_path();
}

/// `translate(x,y)`, the only transformation of our drawings.
fn translation(text: &str) -> [f32; 2] {
    let inside = text.trim_start_matches("translate(").trim_end_matches(')');
    let mut parts = numbers(inside).map(|number| number as f32);
    [parts.next().unwrap_or(0.0), parts.next().unwrap_or(0.0)]
}

/// Shares of red, green and blue; `None` for no colour.
fn rgb(colour: &Color) -> Result<Option<[f32; 3]>, String> {
    match colour {
        Color::Rgb(r, g, b) => Ok(Some([*r, *g, *b].map(|share| f32::from(share) / 255.0))),
        Color::None => Ok(None),
        Color::Css(name) => Err(format!("a figure has the colour {name:?}, which PDF files do not know")),
    }
}

/// The letters that a page uses.
struct Letters {
    face: Face<'static>,
    remapper: GlyphRemapper,
    /// New number of a glyph, its old one and the letter.
    used: BTreeMap<u16, (GlyphId, char)>,
}

impl Letters {
    fn new(face: Face<'static>) -> Self {
        Self { face, remapper: GlyphRemapper::new(), used: BTreeMap::new() }
    }

    /// The codes of a text and its width, in sizes of the font.
    fn encode(&mut self, text: &str) -> (Vec<u8>, f32) {
        let mut width = 0.0;
        let mut codes = Vec::with_capacity(2 * text.len());
        for letter in text.chars() {
            let glyph = self.face.glyph_index(letter).unwrap_or_default();
            let code = self.remapper.remap(glyph.0);
            self.used.insert(code, (glyph, letter));
            codes.extend(code.to_be_bytes());
            width += self.advance(glyph);
        }
        (codes, width)
    }

    fn advance(&self, glyph: GlyphId) -> f32 {
        f32::from(self.face.glyph_hor_advance(glyph).unwrap_or(0)) / f32::from(self.face.units_per_em())
    }

    /// Writes the font with these letters alone.
    fn embed(&self, pdf: &mut Pdf, font: &[u8]) -> Result<(), String> {
        let subset = subsetter::subset(font, 0, &self.remapper).map_err(|error| format!("the font: {error}"))?;
        let system = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
        pdf.type0_font(TYPE0)
            .base_font(Name(FONT_NAME))
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(CID_FONT)
            .to_unicode(TO_UNICODE);
        let mut cid = pdf.cid_font(CID_FONT);
        cid.subtype(CidFontType::Type2).base_font(Name(FONT_NAME)).system_info(system);
        cid.font_descriptor(DESCRIPTOR).cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = cid.widths();
        for (code, (glyph, _)) in &self.used {
            widths.consecutive(*code, [1000.0 * self.advance(*glyph)]);
        }
        widths.finish();
        cid.finish();
        let per_mille = |units: i16| 1000.0 * f32::from(units) / f32::from(self.face.units_per_em());
        let bounds = self.face.global_bounding_box();
        pdf.font_descriptor(DESCRIPTOR)
            .name(Name(FONT_NAME))
            .flags(FontFlags::SYMBOLIC)
            .bbox(Rect::new(
                per_mille(bounds.x_min),
                per_mille(bounds.y_min),
                per_mille(bounds.x_max),
                per_mille(bounds.y_max),
            ))
            .italic_angle(0.0)
            .ascent(per_mille(self.face.ascender()))
            .descent(per_mille(self.face.descender()))
            .cap_height(per_mille(self.face.capital_height().unwrap_or(self.face.ascender())))
            .stem_v(80.0)
            .font_file2(FONT_FILE);
        let length = subset.len() as i32;
        pdf.stream(FONT_FILE, &compressed(&subset)).filter(Filter::FlateDecode).pair(Name(b"Length1"), length);
        let mut letters = UnicodeCmap::new(Name(b"Letters"), system);
        for (code, (_, letter)) in &self.used {
            letters.pair(*code, *letter);
        }
        pdf.stream(TO_UNICODE, &letters.finish());
        Ok(())
    }
}
