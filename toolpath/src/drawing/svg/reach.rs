//! Numbers so large that `usvg` would take an arc apart into curves without end: it keeps each within a tenth of a unit.

use super::error::SvgError;
use usvg::roxmltree::{Attribute, Document};

/// Largest sum of the numbers of a path. No coordinate and no radius is above it, and each arc is a few hundred curves at most.
const MAX_PATH: f64 = 1e12;

/// Largest radius, font size and number of a view box.
const MAX_LENGTH: f64 = 1e9;

/// Refuses a document with larger numbers. What cannot be read counts for nothing, as `usvg` draws a path up to there.
pub(super) fn check(document: &Document) -> Result<(), SvgError> {
    for attribute in document.descendants().flat_map(|node| node.attributes()) {
        let limit = if attribute.name() == "d" { MAX_PATH } else { MAX_LENGTH };
        if size(&attribute) > limit {
            let line = document.text_pos_at(attribute.range().start).row;
            return Err(SvgError::TooFar { attribute: attribute.name().to_owned(), line, limit });
        }
    }
    Ok(())
}

/// How large the numbers of an attribute are: of a path, their sum.
fn size(attribute: &Attribute) -> f64 {
    let text = attribute.value();
    match attribute.name() {
        "d" => svgtypes::PathParser::from(text).map_while(Result::ok).map(|segment| sum(&segment)).sum(),
        "viewBox" => svgtypes::NumberListParser::from(text).map_while(Result::ok).map(f64::abs).fold(0.0, f64::max),
        "r" | "rx" | "ry" | "font-size" => text.parse().map_or(0.0, |length: svgtypes::Length| length.number.abs()),
        _ => 0.0,
    }
}

/// The sum of the numbers of a segment.
fn sum(segment: &svgtypes::PathSegment) -> f64 {
    use svgtypes::PathSegment as Segment;
    let of = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).sum();
    match *segment {
        Segment::MoveTo { x, y, .. } | Segment::LineTo { x, y, .. } | Segment::SmoothQuadratic { x, y, .. } => {
            of(&[x, y])
        }
        Segment::HorizontalLineTo { x, .. } => of(&[x]),
        Segment::VerticalLineTo { y, .. } => of(&[y]),
        Segment::CurveTo { x1, y1, x2, y2, x, y, .. } => of(&[x1, y1, x2, y2, x, y]),
        Segment::SmoothCurveTo { x2, y2, x, y, .. } => of(&[x2, y2, x, y]),
        Segment::Quadratic { x1, y1, x, y, .. } => of(&[x1, y1, x, y]),
        Segment::EllipticalArc { rx, ry, x, y, .. } => of(&[rx, ry, x, y]),
        Segment::ClosePath { .. } => 0.0,
    }
}
