//! How far the inside of a region is from its outline.

use crate::drawing::polygon::{Shape, inset, ring_area};

/// The radius of the largest circle within a shape, to `precision` and never more than it is.
///
/// The shape moved inwards by a depth is empty exactly if the depth is beyond that radius; the radius is between area over
/// perimeter and the radius of the circle of that area.
pub(super) fn inradius(shape: &Shape, precision: f64, tolerance: f64) -> f64 {
    let area: f64 = shape.iter().map(|ring| ring_area(ring)).sum();
    let length = |ring: &Vec<[f64; 2]>| -> f64 {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        ends.map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
    };
    let perimeter: f64 = shape.iter().map(length).sum();
    if !(area > 0.0 && perimeter > 0.0) {
        return 0.0;
    }
    let shapes = vec![shape.clone()];
    let (mut low, mut high) = (0.0, (area / std::f64::consts::PI).sqrt());
    // Most shapes are near one of the two bounds: a disc, or a ribbon.
    let mut at = (area / perimeter).min(high);
    while high - low > precision {
        if inset(&shapes, at, tolerance).is_empty() {
            high = at
        } else {
            low = at
        }
        at = 0.5 * (low + high);
    }
    low
}
