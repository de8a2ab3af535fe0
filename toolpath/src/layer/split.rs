//! How the triangles of a box are shared out between two.
//!
//! At the median of the longest side of the box, or at a border between layers, where the box holds many for its size. So small boxes hold
//! pieces of few layers, which are flat and built at about the same time, where they lie on a nozzle's way: a box with pieces of many layers has some
//! that are still to come, and is around the tip.

use super::triangle::Triangle;
use nalgebra::Point3;

/// Boxes are longer than their layers together are thick by no more than this factor. The hollow bunny at layers of 0.3 mm: boxes that gouging looks at by 2: 0.74, by 4: 0.64,
/// by 16: 0.94 of those without layers.
const LENGTH: f64 = 4.0;

/// Where a triangle is, in space and among the layers.
pub(super) struct Place {
    pub index: u32,
    middle: Point3<f64>,
    height: f64,
    /// Layers from 1; the mould comes first.
    layer: u32,
}

impl Place {
    pub fn new((triangle, index): (&Triangle, u32)) -> Self {
        let [a, b, c] = triangle.corners;
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        Place { index, middle, height: triangle.height, layer: triangle.layer.wrapping_add(1) }
    }
}

/// Sorts two places or more into two parts, neither of them empty: how many are in the first. Numbers decide between equals, so the parts do not depend
/// on how a median is found.
pub(super) fn split(places: &mut [Place]) -> usize {
    let [mut low, mut high] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let ([mut first, mut last], mut height) = ([u32::MAX, 0], 0.0_f64);
    for place in places.iter() {
        for k in 0..3 {
            low[k] = low[k].min(place.middle[k]);
            high[k] = high[k].max(place.middle[k]);
        }
        (first, last, height) = (first.min(place.layer), last.max(place.layer), height.max(place.height));
    }
    let axis = (1..3).fold(0, |best, k| if high[k] - low[k] > high[best] - low[best] { k } else { best });
    if first < last && LENGTH * height * f64::from(last - first) > high[axis] - low[axis] {
        return split_layers(places, first);
    }
    let half = places.len() / 2;
    let order = |a: &Place, b: &Place| a.middle[axis].total_cmp(&b.middle[axis]).then(a.index.cmp(&b.index));
    places.select_nth_unstable_by(half, order);
    half
}

/// At the border between layers that is nearest to the median; `first` is the first of at least two.
fn split_layers(places: &mut [Place], first: u32) -> usize {
    let half = places.len() / 2;
    let layer = places.select_nth_unstable_by_key(half, |place| place.layer).1.layer;
    let earlier = |places: &[Place], layer: u32| places.iter().filter(|place| place.layer < layer).count();
    let [below, above] = [earlier(places, layer), earlier(places, layer + 1)];
    let is_above_nearer = above < places.len() && above - half < half - below;
    let border = if layer == first || is_above_nearer { layer + 1 } else { layer };
    places.sort_unstable_by_key(|place| (place.layer >= border, place.index));
    earlier(places, border)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place(index: u32, middle: [f64; 3], layer: u32) -> Place {
        Place { index, middle: Point3::from(middle), height: 0.3, layer }
    }

    /// `count` places of each layer on a square with this side.
    fn stacked(layers: u32, count: u32, side: f64) -> Vec<Place> {
        let at = |n: u32| {
            let (layer, k) = (n / count, n % count);
            let share = f64::from(k) / f64::from(count);
            place(n, [side * share, 0.8 * side * (7.0 * share).fract(), 0.3 * f64::from(layer)], layer + 1)
        };
        (0..layers * count).map(at).collect()
    }

    #[test]
    fn many_layers_on_a_small_place_are_split_between_layers() {
        let mut places = stacked(10, 6, 2.0);
        let count = split(&mut places);
        assert_eq!(count, 30);
        assert!(places.iter().enumerate().all(|(k, place)| (place.layer <= 5) == (k < count)));
    }

    #[test]
    fn few_layers_on_a_large_place_are_split_in_space() {
        let mut places = stacked(3, 20, 50.0);
        let count = split(&mut places);
        let most = places[..count].iter().map(|place| place.middle.x).fold(0.0, f64::max);
        assert!(count == 30 && places[count..].iter().all(|place| place.middle.x >= most));
    }

    proptest! {
        /// Whatever is split, no part is empty, none is lost, and one part is before the other: in space, or by layers.
        #[test]
        fn parts_are_sorted_and_not_empty(
            places in prop::collection::vec((prop::array::uniform3(0_i32..4), prop::sample::select(vec![0_u32, 1, 2, 7, 8])), 2..40),
            scale in 0.0_f64..2.0,
        ) {
            let mut split_up: Vec<Place> =
                places.iter().zip(0..).map(|(&(at, layer), k)| place(k, at.map(|c| scale * f64::from(c)), layer)).collect();
            let count = split(&mut split_up);
            prop_assert!(count > 0 && count < places.len());
            let (one, other) = split_up.split_at(count);
            let is_before = |key: &dyn Fn(&Place) -> f64| {
                let most = one.iter().map(key).fold(f64::NEG_INFINITY, f64::max);
                other.iter().all(|place| key(place) >= most)
            };
            let in_space = (0..3).any(|k| is_before(&|place| place.middle[k]));
            prop_assert!(in_space || is_before(&|place| f64::from(place.layer)));
            let mut numbers: Vec<u32> = split_up.iter().map(|place| place.index).collect();
            numbers.sort_unstable();
            prop_assert_eq!(numbers, (0..places.len() as u32).collect::<Vec<_>>());
        }
    }
}
