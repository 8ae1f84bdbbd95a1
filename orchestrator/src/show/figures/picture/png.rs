//! A picture as pixels, so many that a printer shows no steps.

use tiny_skia::{Color, FillRule, LineJoin, Paint, PathBuilder, Pixmap, StrokeDash, Transform};

use super::canvas::{Colour, Picture, Shape, Stroke};
use super::fonts::Fonts;
use super::outline::{INCH, Segment};

/// Pixels of an inch, as journals ask for of drawings.
const RESOLUTION: f64 = 600.0;
/// Pixels of an inch in those of a metre, the unit of the file.
const PER_METRE: u32 = 23_622;

/// The picture as a file.
///
/// # Errors
/// In words, if it is too large for the memory.
pub(crate) fn render(picture: &Picture) -> Result<Vec<u8>, String> {
    let scale = RESOLUTION / INCH;
    let [width, height] = [picture.width, picture.height].map(|length| (length * scale).round() as u32);
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| format!("{width} x {height} pixels are too many"))?;
    pixels.fill(Color::WHITE);
    let transform = Transform::from_scale(scale as f32, scale as f32);
    let fonts = Fonts::new(picture.font);
    for shape in &picture.shapes {
        match shape {
            Shape::Path { segments, stroke, fill } => {
                let Some(path) = path(segments) else { continue };
                if let Some(colour) = fill {
                    pixels.fill_path(&path, &paint(*colour), FillRule::Winding, transform, None);
                }
                if let Some(stroke) = stroke {
                    pixels.stroke_path(&path, &paint(stroke.colour), &stroked(stroke), transform, None);
                }
            }
            Shape::Text { text, at, upwards } => {
                let Some(path) = path(&text.outlines(&fonts, *at, *upwards)) else { continue };
                pixels.fill_path(&path, &paint([0; 3]), FillRule::Winding, transform, None);
            }
        }
    }
    encode(&pixels).map_err(|error| error.to_string())
}

/// Without transparency: everything is drawn on white.
fn encode(pixels: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let dimensions = png::PixelDimensions { xppu: PER_METRE, yppu: PER_METRE, unit: png::Unit::Meter };
    encoder.set_pixel_dims(Some(dimensions));
    let rgb: Vec<u8> = pixels.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(file)
}

fn path(segments: &[Segment]) -> Option<tiny_skia::Path> {
    let mut path = PathBuilder::new();
    for segment in segments {
        match segment.single() {
            Segment::Move((x, y)) => path.move_to(x, y),
            Segment::Line((x, y)) => path.line_to(x, y),
            Segment::Cubic((x1, y1), (x2, y2), (x, y)) => path.cubic_to(x1, y1, x2, y2, x, y),
            Segment::Close => path.close(),
        }
    }
    path.finish()
}

fn paint([red, green, blue]: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn stroked(stroke: &Stroke) -> tiny_skia::Stroke {
    let dashes = stroke.dashes.iter().map(|length| *length as f32).collect();
    tiny_skia::Stroke {
        width: stroke.width as f32,
        line_join: LineJoin::Round,
        dash: StrokeDash::new(dashes, 0.0),
        ..tiny_skia::Stroke::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::fonts::Font;
    use super::*;

    #[test]
    fn an_inch_has_600_pixels() {
        let mut picture = Picture::new(72.0, 36.0, Font::Helvetica);
        let black = Stroke { colour: [0; 3], width: 1.0, dashes: vec![3.0, 3.0] };
        picture.line(&[(0.0, 18.0), (72.0, 18.0)], black);
        let file = render(&picture).expect("a file");
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().expect("a PNG");
        let info = reader.info();
        assert_eq!((info.width, info.height, info.pixel_dims.map(|dims| dims.xppu)), (600, 300, Some(PER_METRE)));
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut bytes).expect("pixels");
        let row: Vec<u8> = bytes[3 * 600 * 150..].iter().step_by(3).take(600).copied().collect();
        // A dash of 3 points, a gap of 3 points.
        assert_eq!((row[10], row[35], row[60]), (0, 255, 0));
    }
}
