//! Values smoothed within their layers.
//!
//! The front of a re-timed order comes in whole cells, and where it waits it sets out again all at once. So its values
//! are rough: two fronts that meet differ by a part of a layer, and a level that runs through the centres of many cells
//! at once is torn by rounding. Here each value goes a share of the way to what its joined neighbours foretell: along
//! each axis their mean unless the front parts or meets there; at an end of the part or at a cut the straight continuation
//! of what is on the other side. It never leaves its whole layer, so the layers of cells, their audit, and what is cut
//! between them stay as they are.

use super::extend::JUMP;
use super::field::LayerField;
use super::in_parallel;
use super::lattice::Lattice;

/// A value stays this far below the next whole number.
const GAP: f64 = 1e-3;

/// Where the neighbours on both sides are this much later, or earlier, the front parts or two meet: their mean would cut the
/// crest off.
const CREST: f64 = 0.5;

/// Cells that a thread takes at least.
const LEAST_SHARE: usize = 4096;

/// The field after so many `sweeps`, in each of which a value goes `share` of the way.
pub(super) fn smoothed(field: LayerField, sweeps: usize, share: f64) -> LayerField {
    let mut lattice = Lattice::of(&field, JUMP);
    for _ in 0..sweeps {
        lattice.values = in_parallel(lattice.values.len(), LEAST_SHARE, |node| {
            let value = lattice.values[node];
            match foretold(&lattice, node) {
                Some(foretold) if !value.is_nan() => {
                    let layer = value.floor();
                    (value + share * (foretold - value)).clamp(layer, layer + 1.0 - GAP)
                }
                _ => value,
            }
        });
    }
    field.with_values(&lattice)
}

/// What the neighbours foretell for a node: along an axis with two of them their mean, which counts twice; with one, what
/// lies behind it continued.
fn foretold(lattice: &Lattice, node: usize) -> Option<f64> {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (axis, stride) in lattice.strides().into_iter().enumerate() {
        let next = |node: usize, forwards: bool| {
            let to = if forwards { node + stride } else { node.wrapping_sub(stride) };
            lattice.is_joined(node, axis, forwards).then_some(to)
        };
        match [false, true].map(|forwards| next(node, forwards)) {
            [Some(before), Some(after)] => {
                let ahead = [before, after].map(|next| lattice.values[next] - lattice.values[node]);
                if ahead[0].signum() == ahead[1].signum() && ahead[0].abs().min(ahead[1].abs()) > CREST {
                    continue;
                }
                sum += lattice.values[before] + lattice.values[after];
                weights += 2.0;
            }
            [None, None] => {}
            [before, after] => {
                let forwards = after.is_some();
                if let Some(near) = before.or(after)
                    && let Some(far) = next(near, forwards)
                {
                    sum += 2.0 * lattice.values[near] - lattice.values[far];
                    weights += 1.0;
                }
            }
        }
    }
    (weights > 0.0).then(|| sum / weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curved::Cells;

    fn column(values: &[f64]) -> Vec<f64> {
        let rows = vec![1; values.len()];
        let cells = Cells::new([1, 1, values.len() as u32], &rows).unwrap();
        let field = LayerField::new(&cells, values.to_vec(), 1.0).unwrap();
        smoothed(field, 3, 0.5).values().to_vec()
    }

    #[test]
    fn a_steady_front_stays_as_it_is() {
        let steady: Vec<f64> = (0..8).map(|k| f64::from(k) + 0.5).collect();
        assert_eq!(column(&steady), steady);
    }

    #[test]
    fn a_wait_stays_a_wait_and_no_value_leaves_its_layer() {
        let waits = [0.5, 1.5, 2.5, 4.0, 5.0, 5.9, 7.0];
        let after = column(&waits);
        assert!(waits.iter().zip(&after).all(|(a, b)| a.floor() - b.floor() == 0.0), "{after:?}");
        // From layer 2 to 4 there is a whole layer between: the two sides know nothing of each other.
        assert_eq!(after[..3], waits[..3]);
        // From layer 5 the front goes on evenly: 4, 5, 5.95, 7 become steps nearer to each other.
        let rough = |v: &[f64]| v[3..].windows(3).map(|w| (w[0] + w[2] - 2.0 * w[1]).powi(2)).sum::<f64>();
        assert!(rough(&after) < rough(&waits) / 2.0, "{after:?}");
    }
}
