//! A picture as SVG. Letters are outlines, so that no machine replaces their font by another one; what they say is in `aria-label`.

use std::fmt::Write;

use super::canvas::{Colour, Picture, Shape, Stroke};
use super::fonts::Fonts;
use super::outline::{INCH, Segment};

/// The picture as a file, with its size in inches.
pub(crate) fn render(picture: &Picture) -> String {
    let fonts = Fonts::new(picture.font);
    let (width, height) = (picture.width, picture.height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.3}in\" height=\"{:.3}in\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\">\n",
        width / INCH,
        height / INCH,
        number(width),
        number(height)
    );
    for shape in &picture.shapes {
        match shape {
            Shape::Path { segments, stroke, fill } => {
                let fill = fill.map_or_else(|| "none".into(), colour);
                let stroke = stroke.as_ref().map(stroked).unwrap_or_default();
                push(&mut svg, format_args!("<path d=\"{}\" fill=\"{fill}\"{stroke}/>\n", outline(segments)));
            }
            Shape::Text { text, at, upwards } => {
                let letters = escaped(&text.letters);
                let outlines = outline(&text.outlines(&fonts, *at, *upwards));
                push(&mut svg, format_args!("<path aria-label=\"{letters}\" d=\"{outlines}\"/>\n"));
            }
        }
    }
    svg.push_str("</svg>\n");
    svg
}

fn push(svg: &mut String, text: std::fmt::Arguments) {
    svg.write_fmt(text).expect("a text takes all that is written");
}

fn outline(segments: &[Segment]) -> String {
    let mut path = String::new();
    for segment in segments {
        let (command, points) = match segment {
            Segment::Move(end) => ("M", vec![end]),
            Segment::Line(end) => ("L", vec![end]),
            Segment::Cubic(first, second, end) => ("C", vec![first, second, end]),
            Segment::Close => ("Z", Vec::new()),
        };
        path.push_str(command);
        for (index, (x, y)) in points.into_iter().enumerate() {
            let gap = if index > 0 { " " } else { "" };
            push(&mut path, format_args!("{gap}{} {}", number(*x), number(*y)));
        }
    }
    path
}

fn stroked(stroke: &Stroke) -> String {
    let mut text = format!(" stroke=\"{}\" stroke-width=\"{}\"", colour(stroke.colour), number(stroke.width));
    if !stroke.dashes.is_empty() {
        let dashes: Vec<String> = stroke.dashes.iter().map(|length| number(*length)).collect();
        push(&mut text, format_args!(" stroke-dasharray=\"{}\"", dashes.join(" ")));
    }
    text
}

/// `#rrggbb`
pub(crate) fn colour([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A length, to a hundredth of a point.
fn number(length: f64) -> String {
    let text = format!("{length:.2}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::fonts::Font;
    use super::super::label::Label;
    use super::super::typeset::Typeset;
    use super::*;

    #[test]
    fn letters_are_outlines_that_say_what_they_are() {
        let mut picture = Picture::new(252.0, 100.0, Font::Times);
        let label = Label::tex("a < b $x_p$").expect("a label");
        picture.text(Typeset::new(&Fonts::new(Font::Times), &label, 8.0), (10.0, 20.0));
        let svg = render(&picture);
        assert!(svg.contains("width=\"3.500in\"") && svg.contains("aria-label=\"a &lt; b xp\""), "{svg}");
        assert!(!svg.contains("<text") && !svg.contains("font"), "{svg}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([1.0, 0.5, 0.126, -3.10].map(number), ["1", "0.5", "0.13", "-3.1"]);
    }
}
