//! SVG files, read into a [`Drawing`] (cargo feature `svg`): paths and basic shapes, with their transforms, by `usvg`.
//!
//! A layer is the innermost Inkscape layer, by its label; without one the outermost group that has an id; what is in none is on the
//! layer `0`. The axis y is turned up. Outlines of a filled path are closed, and filled together by its fill rule. Coordinates are of
//! single precision.
//!
//! Not drawn, and counted by name: texts, images, what is hidden, and shapes of which nothing can be drawn. Nothing outside of the file
//! is ever opened.

mod bytes;
mod document;
mod error;
mod outlines;
mod reach;
mod size;

pub use error::SvgError;
pub use size::SvgScale;

use super::curve::Affine;
use super::drawing::Drawing;
use document::Sources;
use error::invalid;
use nalgebra::{Matrix2, Vector2};
use outlines::Walk;
use usvg::roxmltree::{Document, ParsingOptions};
use usvg::{ImageHrefResolver, Options, Tree};

/// How an SVG file is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SvgOptions {
    /// What a unit is. Default: as the file and CSS say.
    pub scale: SvgScale,
}

impl Default for SvgOptions {
    fn default() -> Self {
        SvgOptions { scale: SvgScale::Css }
    }
}

/// Reads an SVG file, compressed (`.svgz`) or not, in millimetres with y up.
///
/// [`Drawing::unit_mm`] is the size of a pixel; it is `None`, with a note on what else it may be, if the size of the drawing is in pixels,
/// or not stated at all.
///
/// # Errors
/// [`SvgError`] for what is no XML, no SVG, or has no size, and for numbers beyond 1e12 in paths, 1e9 in radii.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::{SvgOptions, read_svg};
/// let file = r#"<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10">
///   <g id="rim"><circle cx="5" cy="5" r="4"/></g><path d="M0 0 L10 0"  stroke="black"/></svg>"#;
/// let drawing = read_svg(file.as_bytes(), SvgOptions::default())?;
/// assert_eq!(drawing.layers(), [("0".to_owned(), 1), ("rim".to_owned(), 1)]);
/// # Ok::<(), curvlay_toolpath::drawing::SvgError>(())
/// ```
pub fn read_svg(data: &[u8], options: SvgOptions) -> Result<Drawing, SvgError> {
    check(options.scale)?;
    let text = bytes::text(data)?;
    let original = parse(&text)?;
    reach::check(&original)?;
    let sources = Sources::new(&original);
    let named = sources.with_ids(&text);
    let document = parse(&named)?;
    let dpi = match options.scale {
        SvgScale::Dpi(dpi) => dpi,
        SvgScale::Css | SvgScale::UnitMm(_) => size::CSS_DPI,
    };
    // Never opens what an image refers to.
    let image_href_resolver =
        ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
    let settings = Options { dpi: dpi as f32, image_href_resolver, ..Options::default() };
    let tree = Tree::from_xmltree(&document, &settings).map_err(invalid)?;
    let found = size::find(&original, &tree, options.scale);
    let pixel_mm = found.pixel_mm;
    let height = f64::from(tree.size().height());
    let up =
        Affine { matrix: Matrix2::new(pixel_mm, 0.0, 0.0, -pixel_mm), shift: Vector2::new(0.0, pixel_mm * height) };
    let mut walk = Walk::new(&sources, up);
    walk.group(tree.root(), None);
    let mut drawing = walk.finish();
    drawing.unit_mm = found.is_stated.then_some(pixel_mm);
    drawing.notes.extend(found.note);
    Ok(drawing)
}

fn check(scale: SvgScale) -> Result<(), SvgError> {
    let (what, value, fits, range) = match scale {
        SvgScale::Css => return Ok(()),
        SvgScale::Dpi(dpi) => ("the resolution", dpi, (1.0..=1e5).contains(&dpi), "from 1 to 100000 dpi"),
        SvgScale::UnitMm(mm) => ("the unit", mm, mm > 0.0 && mm <= 1e6, "above 0 and at most 1e6 mm"),
    };
    if fits { Ok(()) } else { Err(SvgError::Scale { what, value, range }) }
}

fn parse(text: &str) -> Result<Document<'_>, SvgError> {
    Document::parse_with_options(text, ParsingOptions { allow_dtd: true, ..ParsingOptions::default() }).map_err(invalid)
}
