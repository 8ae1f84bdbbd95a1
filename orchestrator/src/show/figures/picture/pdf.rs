//! A picture as a page of PDF: vectors, and letters of a font that is embedded, as journals demand.

use std::collections::BTreeMap;

use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};
use subsetter::GlyphRemapper;
use ttf_parser::GlyphId;

use super::canvas::{Colour, Picture, Shape, Stroke};
use super::fonts::{Font, Fonts, Slant};
use super::outline::{Point, Segment, placed};
use super::typeset::Typeset;

const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const INFO: Ref = Ref::new(5);
/// The first object of a font; each has [`FONT_OBJECTS`].
const FONTS: i32 = 6;
const FONT_OBJECTS: i32 = 5;

/// The picture as a file.
///
/// # Errors
/// In words, what is wrong with the font.
pub(crate) fn render(picture: &Picture) -> Result<Vec<u8>, String> {
    let [width, height] = [picture.width, picture.height].map(|length| length as f32);
    let mut page = Page { content: Content::new(), fonts: Fonts::new(picture.font), used: BTreeMap::new() };
    page.content.transform([1.0, 0.0, 0.0, -1.0, 0.0, height]);
    page.content.set_line_join(LineJoinStyle::RoundJoin);
    for shape in &picture.shapes {
        match shape {
            Shape::Path { segments, stroke, fill } => page.path(segments, stroke.as_ref(), *fill),
            Shape::Text { text, at, upwards } => page.text(text, *at, *upwards),
        }
    }
    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut leaf = pdf.page(PAGE);
    leaf.parent(PAGES).media_box(Rect::new(0.0, 0.0, width, height)).contents(CONTENT);
    let mut resources = leaf.resources();
    let mut names = resources.fonts();
    for slant in page.used.keys() {
        names.pair(Name(name(*slant)), first_object(*slant));
    }
    names.finish();
    resources.finish();
    leaf.finish();
    pdf.stream(CONTENT, &compressed(&page.content.finish())).filter(Filter::FlateDecode);
    for (slant, letters) in &page.used {
        letters.embed(&mut pdf, &page.fonts, picture.font, *slant)?;
    }
    // No date: equal pictures are equal files.
    pdf.document_info(INFO).producer(pdf_writer::TextStr(concat!("phalanx ", env!("CARGO_PKG_VERSION"))));
    Ok(pdf.finish())
}

/// What a font is called on the page.
fn name(slant: Slant) -> &'static [u8] {
    match slant {
        Slant::Upright => b"F0",
        Slant::Italic => b"F1",
    }
}

fn first_object(slant: Slant) -> Ref {
    Ref::new(FONTS + if slant == Slant::Upright { 0 } else { FONT_OBJECTS })
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    miniz_oxide::deflate::compress_to_vec_zlib(bytes, 6)
}

fn rgb(colour: Colour) -> [f32; 3] {
    colour.map(|share| f32::from(share) / 255.0)
}

struct Page {
    content: Content,
    fonts: Fonts,
    used: BTreeMap<Slant, Letters>,
}

impl Page {
    fn path(&mut self, segments: &[Segment], stroke: Option<&Stroke>, fill: Option<Colour>) {
        let content = &mut self.content;
        if let Some([r, g, b]) = fill.map(rgb) {
            content.set_fill_rgb(r, g, b);
        }
        if let Some(stroke) = stroke {
            let [r, g, b] = rgb(stroke.colour);
            content.set_stroke_rgb(r, g, b).set_line_width(stroke.width as f32);
            content.set_dash_pattern(stroke.dashes.iter().map(|length| *length as f32), 0.0);
        }
        for segment in segments {
            match segment.single() {
                Segment::Move((x, y)) => content.move_to(x, y),
                Segment::Line((x, y)) => content.line_to(x, y),
                Segment::Cubic((x1, y1), (x2, y2), (x, y)) => content.cubic_to(x1, y1, x2, y2, x, y),
                Segment::Close => content.close_path(),
            };
        }
        match (fill, stroke) {
            (Some(_), Some(_)) => content.fill_nonzero_and_stroke(),
            (Some(_), None) => content.fill_nonzero(),
            (None, Some(_)) => content.stroke(),
            (None, None) => content.end_path(),
        };
    }

    fn text(&mut self, text: &Typeset, at: Point, upwards: bool) {
        let place = |x: f64, y: f64| placed(at, upwards, x, y);
        self.content.set_fill_rgb(0.0, 0.0, 0.0);
        for glyphs in &text.glyphs {
            let codes = self.used.entry(glyphs.slant).or_default().encode(&self.fonts, glyphs.slant, &glyphs.text);
            let (x, y) = place(glyphs.x, glyphs.y);
            let content = &mut self.content;
            content.begin_text().set_font(Name(name(glyphs.slant)), glyphs.size as f32);
            // The page is upside down, as pictures are; letters are not.
            let [a, b, c, d] = if upwards { [0.0, -1.0, -1.0, 0.0] } else { [1.0, 0.0, 0.0, -1.0] };
            content.set_text_matrix([a, b, c, d, x as f32, y as f32]);
            content.show(Str(&codes)).end_text();
        }
        for bar in &text.bars {
            let ((x0, y0), (x1, y1)) = (place(bar.x, bar.y), place(bar.x + bar.width, bar.y + bar.height));
            let [x, y, width, height] = [x0.min(x1), y0.min(y1), (x1 - x0).abs(), (y1 - y0).abs()];
            self.content.rect(x as f32, y as f32, width as f32, height as f32).fill_nonzero();
        }
    }
}

/// The letters of one font that the page shows.
#[derive(Default)]
struct Letters {
    remapper: GlyphRemapper,
    /// By their codes in the file.
    used: BTreeMap<u16, (GlyphId, char)>,
}

impl Letters {
    /// The codes of a text.
    fn encode(&mut self, fonts: &Fonts, slant: Slant, text: &str) -> Vec<u8> {
        let mut codes = Vec::with_capacity(2 * text.len());
        for letter in text.chars() {
            let glyph = fonts.glyph(slant, letter);
            let code = self.remapper.remap(glyph.0);
            self.used.insert(code, (glyph, letter));
            codes.extend(code.to_be_bytes());
        }
        codes
    }

    /// Writes the font with these letters alone.
    fn embed(&self, pdf: &mut Pdf, fonts: &Fonts, font: Font, slant: Slant) -> Result<(), String> {
        let first = first_object(slant).get();
        let [type0, cid_font, descriptor, file, to_unicode] = [0, 1, 2, 3, 4].map(|index| Ref::new(first + index));
        let subset =
            subsetter::subset(font.file(slant), 0, &self.remapper).map_err(|error| format!("the font: {error}"))?;
        // The letters in front say that only some of its glyphs are there.
        let full_name = format!("FIGURE+{}", font.name(slant));
        let name = Name(full_name.as_bytes());
        let system = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
        pdf.type0_font(type0)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(cid_font)
            .to_unicode(to_unicode);
        let mut cid = pdf.cid_font(cid_font);
        cid.subtype(CidFontType::Type2).base_font(name).system_info(system);
        cid.font_descriptor(descriptor).cid_to_gid_map_predefined(Name(b"Identity"));
        let face = fonts.face(slant);
        let per_mille = |units: i16| 1000.0 * f32::from(units) / f32::from(face.units_per_em());
        let mut widths = cid.widths();
        for (code, (glyph, _)) in &self.used {
            let advance = face.glyph_hor_advance(*glyph).unwrap_or(0);
            widths.consecutive(*code, [1000.0 * f32::from(advance) / f32::from(face.units_per_em())]);
        }
        widths.finish();
        cid.finish();
        let bounds = face.global_bounding_box();
        pdf.font_descriptor(descriptor)
            .name(name)
            .flags(FontFlags::SYMBOLIC)
            .bbox(Rect::new(
                per_mille(bounds.x_min),
                per_mille(bounds.y_min),
                per_mille(bounds.x_max),
                per_mille(bounds.y_max),
            ))
            .italic_angle(face.italic_angle())
            .ascent(per_mille(face.ascender()))
            .descent(per_mille(face.descender()))
            .cap_height(per_mille(face.capital_height().unwrap_or(face.ascender())))
            .stem_v(80.0)
            .font_file2(file);
        let length = subset.len() as i32;
        pdf.stream(file, &compressed(&subset)).filter(Filter::FlateDecode).pair(Name(b"Length1"), length);
        let mut letters = UnicodeCmap::new(Name(b"Letters"), system);
        for (code, (_, letter)) in &self.used {
            letters.pair(*code, *letter);
        }
        pdf.stream(to_unicode, &letters.finish());
        Ok(())
    }
}
