//! SVG files, read into a [`Drawing`] (cargo feature `svg`): paths and basic shapes, with their transforms, by `usvg`.
//!
//! A layer is the id of the outermost group that has one; what is in none is on the layer `0`. The axis y is turned up. Lengths follow
//! CSS: a pixel is 25.4 / 96 mm. Coordinates are of single precision.

use super::curve::{Affine, Curve};
use super::drawing::{Drawing, Entity};
use nalgebra::{Matrix2, Point2, Vector2};
use std::collections::BTreeMap;
use usvg::roxmltree::{Document, ParsingOptions};
use usvg::tiny_skia_path::{PathSegment, Point};
use usvg::{Group, Node, Options, Path, Tree};

/// Why an SVG file could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SvgError {
    /// It is no SVG; line and column are named where they are known.
    #[error("not a readable SVG file: {what}")]
    Invalid {
        /// What is wrong.
        what: String,
    },
}

/// Millimetres in a pixel of CSS.
const PIXEL_MM: f64 = 25.4 / 96.0;

/// Reads an SVG file, in millimetres with y up.
///
/// # Errors
/// [`SvgError`] for what is no XML, no SVG, or has no size.
///
/// # Example
/// ```
/// use curvlay_toolpath::drawing::read_svg;
/// let file = r#"<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10">
///   <g id="rim"><circle cx="5" cy="5" r="4"/></g><path d="M0 0 L10 0"  stroke="black"/></svg>"#;
/// let drawing = read_svg(file.as_bytes())?;
/// assert_eq!(drawing.layers(), [("0".to_owned(), 1), ("rim".to_owned(), 1)]);
/// # Ok::<(), curvlay_toolpath::drawing::SvgError>(())
/// ```
pub fn read_svg(data: &[u8]) -> Result<Drawing, SvgError> {
    let text = std::str::from_utf8(data).map_err(|error| SvgError::Invalid { what: error.to_string() })?;
    let invalid = |error: String| SvgError::Invalid { what: error };
    let parsing = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, parsing).map_err(|error| invalid(error.to_string()))?;
    let tree = Tree::from_xmltree(&document, &Options::default()).map_err(|error| invalid(error.to_string()))?;
    let height = f64::from(tree.size().height());
    let up =
        Affine { matrix: Matrix2::new(PIXEL_MM, 0.0, 0.0, -PIXEL_MM), shift: Vector2::new(0.0, PIXEL_MM * height) };
    let mut drawing = Drawing { unit_mm: Some(PIXEL_MM), ..Drawing::default() };
    let mut skipped = BTreeMap::new();
    walk(tree.root(), None, &up, &mut drawing, &mut skipped);
    for kind in ["text", "image", "foreignObject"] {
        let count = document.descendants().filter(|node| node.tag_name().name() == kind).count();
        if count > 0 {
            skipped.insert(kind, count);
        }
    }
    drawing.skipped = skipped.into_iter().map(|(what, count): (&str, usize)| (what.to_owned(), count)).collect();
    Ok(drawing)
}

fn walk(
    group: &Group,
    layer: Option<&str>,
    up: &Affine,
    drawing: &mut Drawing,
    skipped: &mut BTreeMap<&'static str, usize>,
) {
    let layer = layer.or_else(|| Some(group.id()).filter(|id| !id.is_empty()));
    for node in group.children() {
        match node {
            Node::Group(group) => walk(group, layer, up, drawing, skipped),
            Node::Path(path) if path.is_visible() => {
                for (curves, closed) in subpaths(path, up) {
                    let (kind, layer) = ("path".to_owned(), layer.unwrap_or("0").to_owned());
                    drawing.entities.push(Entity { kind, layer, line: 0, curves, closed });
                }
            }
            Node::Path(_) => *skipped.entry("path (invisible)").or_default() += 1,
            // Counted in the document: without fonts there is no text here.
            Node::Image(_) | Node::Text(_) => {}
        }
    }
}

/// The subpaths of a path, and whether each is closed.
fn subpaths(path: &Path, up: &Affine) -> Vec<(Vec<Curve>, bool)> {
    let t = path.abs_transform();
    let [sx, kx, tx, ky, sy, ty] = [t.sx, t.kx, t.tx, t.ky, t.sy, t.ty].map(f64::from);
    let map = up.after(&Affine { matrix: Matrix2::new(sx, kx, ky, sy), shift: Vector2::new(tx, ty) });
    let point = |p: Point| map.point(&Point2::new(f64::from(p.x), f64::from(p.y)));
    let mut all: Vec<(Vec<Curve>, bool)> = Vec::new();
    let (mut begin, mut at) = (Point2::origin(), Point2::origin());
    for segment in path.data().segments() {
        let curve = match segment {
            PathSegment::MoveTo(p) => {
                (begin, at) = (point(p), point(p));
                all.push((Vec::new(), false));
                continue;
            }
            PathSegment::Close => {
                if let Some((_, closed)) = all.last_mut() {
                    *closed = true;
                }
                at = begin;
                continue;
            }
            PathSegment::LineTo(p) => Curve::Line { from: at, to: point(p) },
            PathSegment::QuadTo(a, p) => Curve::bezier(vec![at, point(a), point(p)]),
            PathSegment::CubicTo(a, b, p) => Curve::bezier(vec![at, point(a), point(b), point(p)]),
        };
        at = curve.ends()[1];
        match all.last_mut() {
            Some((curves, false)) => curves.push(curve),
            // Drawn on after it was closed: a subpath of its own.
            _ => all.push((vec![curve], false)),
        }
    }
    all.retain(|(curves, _)| !curves.is_empty());
    all
}
