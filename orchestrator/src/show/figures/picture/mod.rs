//! A picture of vectors and letters, and the files that it is stored in: all show the same.

mod canvas;
mod fonts;
mod label;
mod outline;
mod pdf;
mod png;
mod svg;
mod typeset;

pub(super) use canvas::{Colour, Picture, Stroke};
pub(crate) use fonts::Font;
pub(super) use fonts::Fonts;
pub(super) use label::Label;
pub(super) use outline::{INCH, Point};
pub(super) use pdf::render as pdf;
pub(super) use png::render as png;
pub(super) use svg::{colour as hexadecimal, render as svg};
pub(super) use typeset::Typeset;
