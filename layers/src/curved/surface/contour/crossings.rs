//! Where levels cross the lattice.

use super::cube::after;
use crate::curved::surface::extend::ExtendedField;

/// A node counts as having reached a level if it lacks no more than this, in layers: rounding alone does not decide
/// on which side of it the nodes of a plane lie.
pub(super) const REACHED: f64 = 1e-6;

/// A place where a surface crosses the lattice: twice [`place_of`] an edge, and 1 more for the half at the upper end
/// of one that is cut.
pub(in crate::curved::surface) type Crossing = usize;

/// `4 * node + axis`.
pub(super) fn place_of(node: usize, axis: usize) -> usize {
    4 * node + axis
}

/// The lower node of the edge of a crossing.
pub(in crate::curved::surface) fn node_of(crossing: Crossing) -> usize {
    crossing / 8
}

/// The cubes around a crossing, by their lowest nodes: all that the surface has there lies in them.
pub(in crate::curved::surface) fn around(crossing: Crossing, strides: [usize; 3]) -> [usize; 4] {
    let (node, axis) = (node_of(crossing), crossing / 2 % 4);
    let [b, c] = after(axis).map(|axis| strides[axis]);
    [node, node - b, node - c, node - b - c]
}

/// For each level its crossings that count, rising.
pub(super) fn crossings(
    field: &ExtendedField,
    levels: &[f64],
    counts: impl Fn(Crossing) -> bool,
) -> Vec<Vec<Crossing>> {
    let mut crossings = vec![Vec::new(); levels.len()];
    each_crossing(field, levels, counts, |crossing, level| crossings[level].push(crossing));
    crossings
}

/// Hands over the crossings of all levels, rising, each with the number of its level; those of an edge only if it `counts`, by its lower half.
pub(in crate::curved::surface) fn each_crossing(
    field: &ExtendedField,
    levels: &[f64],
    counts: impl Fn(Crossing) -> bool,
    mut hand: impl FnMut(Crossing, usize),
) {
    let lattice = &field.lattice;
    // Levels by value: those that an edge crosses follow each other, and one pass over the edges serves all levels.
    let mut rising: Vec<(f64, usize)> = levels.iter().copied().zip(0..).filter(|(level, _)| !level.is_nan()).collect();
    rising.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut add = |from: f64, to: f64, crossing: Crossing| {
        let [a, b] = [from, to].map(|v| v + REACHED);
        let first = rising.partition_point(|&(level, _)| level <= a.min(b));
        for &(_, of) in rising[first..].iter().take_while(|&&(level, _)| level <= a.max(b)) {
            hand(crossing, of);
        }
    };
    let strides = lattice.strides();
    for (node, &joined) in lattice.joined.iter().enumerate() {
        if lattice.values[node].is_nan() {
            continue;
        }
        for (axis, stride) in strides.into_iter().enumerate() {
            let Some(&high) = lattice.values.get(node + stride) else { continue };
            let crossing = 2 * place_of(node, axis);
            if !counts(crossing) {
                continue;
            }
            if joined >> axis & 1 == 1 {
                add(lattice.values[node], high, crossing);
            } else if let Some([from_low, from_high]) = lattice.half_way(node, axis) {
                add(lattice.values[node], from_low, crossing);
                add(from_high, high, crossing + 1);
            }
        }
    }
}
