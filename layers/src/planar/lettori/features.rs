//! Holes and small features that are machined after the print: sections without them.
//!
//! Lettori et al. 2022: "holes and small features are removed after being created with standard subtractive processes". Here
//! they are removed from the sections by which the part is divided, not from its mesh; each is listed.

use crate::planar::{Region, SectionPolygon};
use nalgebra::Point2;

/// Whether material is added or left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeatureKind {
    /// A hole, slot or gap that the print fills.
    Hole,
    /// A piece of the section that stands alone and is too small to print.
    Island,
}

/// A small feature, from its lowest to its highest layer along the direction of its part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// What it is.
    pub kind: FeatureKind,
    /// Where it begins and ends along the direction, to a layer.
    pub from_mm: f64,
    /// See `from_mm`.
    pub to_mm: f64,
    /// Its middle in the plane of the first layer that has it, in the frame of the part's base plane.
    pub middle: Point2<f64>,
    /// Its longest side across the direction, over all its layers.
    pub size_mm: f64,
    /// Its volume.
    pub volume_mm3: f64,
}

/// A section closed over what is narrower than `size`, without islands that are. Adds what changed to the list; the layers come
/// from the bottom up.
pub(super) fn close_small(section: &Region, size: f64, [low, high]: [f64; 2], features: &mut Vec<Feature>) -> Region {
    let note = |pieces: &Region, kind: FeatureKind, features: &mut Vec<Feature>| {
        for piece in pieces.pieces() {
            let Some([from, to]) = piece.bounds() else { continue };
            let (middle, longest) = (from + (to - from) / 2.0, (to - from).amax());
            let volume_mm3 = piece.area() * (high - low);
            // The same as in the layer below if it is of the same kind and no further off than it is wide.
            let same = |known: &&mut Feature| {
                known.kind == kind
                    && (known.to_mm - low).abs() < 1e-9 * (1.0 + low.abs())
                    && (known.middle - middle).norm() <= longest.max(known.size_mm)
            };
            match features.iter_mut().find(same) {
                Some(known) => {
                    known.to_mm = high;
                    known.size_mm = known.size_mm.max(longest);
                    known.volume_mm3 += volume_mm3;
                }
                None => {
                    features.push(Feature { kind, from_mm: low, to_mm: high, middle, size_mm: longest, volume_mm3 })
                }
            }
        }
    };
    let mut closed = section.clone();
    for hole in section.polygons().into_iter().flat_map(|polygon| polygon.holes) {
        let outer = hole.into_iter().rev().collect();
        let hole = Region::of(&[SectionPolygon { outer, holes: Vec::new() }]).difference(&closed);
        if !hole.is_empty() && hole.grown(-size / 2.0).is_empty() {
            note(&hole, FeatureKind::Hole, features);
            closed = closed.union(&hole);
        }
    }
    // Slots and gaps. What closing does to a corner that points inwards is a fillet of 0.054 squares of the size, and stays out.
    let gaps = closed.grown(size / 2.0).grown(-size / 2.0).difference(&closed).without_specks(0.1 * size * size);
    note(&gaps, FeatureKind::Hole, features);
    closed = closed.union(&gaps);
    let mut kept = Region::default();
    for piece in closed.pieces() {
        if piece.grown(-size / 2.0).is_empty() {
            note(&piece, FeatureKind::Island, features);
        } else {
            kept = kept.union(&piece);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of so many millimetres beside a square.
    fn with_a_bar(wide: f64) -> Region {
        let rectangle = |x: f64, wide: f64| {
            let outer = [[x, 0.0], [x + wide, 0.0], [x + wide, 30.0], [x, 30.0]].map(Point2::from).to_vec();
            SectionPolygon { outer, holes: Vec::new() }
        };
        Region::of(&[rectangle(0.0, 30.0), rectangle(60.0, wide)])
    }

    #[test]
    fn islands_narrower_than_a_feature_are_left_out_and_no_others() {
        for (wide, left_out) in [(5.0, true), (7.0, false), (20.0, false)] {
            let mut features = Vec::new();
            let kept = close_small(&with_a_bar(wide), 6.0, [0.0, 3.0], &mut features);
            let area = 900.0 + if left_out { 0.0 } else { 30.0 * wide };
            assert!((kept.area() - area).abs() < 1e-6 * area, "{wide}: {}", kept.area());
            let found: Vec<_> = features.iter().map(|feature| (feature.kind, feature.volume_mm3.round())).collect();
            let island = (FeatureKind::Island, 90.0 * wide);
            assert_eq!(found, if left_out { vec![island] } else { Vec::new() }, "{wide}");
        }
    }
}
