//! Numbers so large that `usvg` would take an arc apart into curves without end: it keeps each within a tenth of a unit.

use super::error::SvgError;
use usvg::roxmltree::{Attribute, Document, Node};

/// Largest sum of the numbers of a path. No coordinate and no radius is above it, and each arc is a few hundred curves at most.
const MAX_PATH: f64 = 1e12;

/// Largest radius, font size and number of a view box.
const MAX_LENGTH: f64 = 1e9;

/// Refuses a document with larger numbers.
pub(super) fn check(document: &Document) -> Result<(), SvgError> {
    for node in document.descendants().filter(Node::is_element) {
        for attribute in node.attributes() {
            let (size, limit) = measured(&attribute);
            if size > limit {
                let line = document.text_pos_at(attribute.range().start).row;
                return Err(SvgError::TooFar { attribute: attribute.name().to_owned(), line, limit });
            }
        }
    }
    Ok(())
}

/// How large the numbers of an attribute are, as far as they can be read, and how large they may be.
fn measured(attribute: &Attribute) -> (f64, f64) {
    let text = attribute.value();
    match attribute.name() {
        "d" => {
            let segments = svgtypes::PathParser::from(text).map_while(Result::ok);
            (segments.map(|segment| size(&segment)).sum(), MAX_PATH)
        }
        "viewBox" => {
            let numbers = svgtypes::NumberListParser::from(text).map_while(Result::ok);
            (numbers.map(f64::abs).fold(0.0, f64::max), MAX_LENGTH)
        }
        "r" | "rx" | "ry" | "font-size" => {
            (text.parse().map_or(0.0, |length: svgtypes::Length| length.number.abs()), MAX_LENGTH)
        }
        _ => (0.0, MAX_LENGTH),
    }
}

/// The sum of the numbers of a segment.
fn size(segment: &svgtypes::PathSegment) -> f64 {
    use svgtypes::PathSegment as Segment;
    let sum = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).sum();
    match *segment {
        Segment::MoveTo { x, y, .. } | Segment::LineTo { x, y, .. } | Segment::SmoothQuadratic { x, y, .. } => {
            sum(&[x, y])
        }
        Segment::HorizontalLineTo { x, .. } => sum(&[x]),
        Segment::VerticalLineTo { y, .. } => sum(&[y]),
        Segment::CurveTo { x1, y1, x2, y2, x, y, .. } => sum(&[x1, y1, x2, y2, x, y]),
        Segment::SmoothCurveTo { x2, y2, x, y, .. } => sum(&[x2, y2, x, y]),
        Segment::Quadratic { x1, y1, x, y, .. } => sum(&[x1, y1, x, y]),
        Segment::EllipticalArc { rx, ry, x, y, .. } => sum(&[rx, ry, x, y]),
        Segment::ClosePath { .. } => 0.0,
    }
}
