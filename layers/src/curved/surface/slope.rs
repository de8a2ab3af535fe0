//! Values evened out within their layers.
//!
//! The front of a re-timed order comes in whole cells, and where it waits it sets out again all at once. So its values
//! are rough: beside a wait layers are thicker or thinner than a cell. Here they are moved so that the slope is as near to 1 as
//! can be, `|grad v| = 1`, wherever the field is not cut: each value goes towards the mean of what its joined neighbours
//! foretell, who are a step of the *way* of the front away, the unit vector along the slope (Poisson's equation with the
//! ways as its right-hand side, solved by damped Jacobi sweeps, the ways taken anew before each). No value leaves its
//! whole layer, so the layers of cells, their audit, and what is cut between them stay as they are.
//!
//! At a cut a surface goes half a cell beyond the centres and no farther. So a cell at a cut that faces it keeps so near
//! to the middle of its layer that the level there, its *own*, comes within that half cell: else nothing would cover it.
//!
//! [`relax`] does the same without any bounds, for a field that is free to move yet (`coherent`).

use super::field::LayerField;
use super::lattice::Lattice;
use crate::parallel::in_parallel;

/// A value stays this far below the next whole number.
const GAP: f64 = 1e-3;

/// How far from the end of its half edge a cell's own level stays, in layers. Half of that or twice as much changes little.
const MARGIN: f64 = 0.05;

/// Where the neighbours on both sides are this much later, or earlier, the front parts or two meet.
const CREST: f64 = 0.5;

/// A front faces a cut if its way has this much across it.
const FACES: f64 = 0.5;

/// Cells that a thread takes at a time.
const AT_A_TIME: usize = 4096;

/// Sweeps, and how far a value goes in each. With twice as many the layers of torn parts are a little evener, those of others
/// less.
const SWEEPS: usize = 10;
const SHARE: f64 = 0.8;

/// Values have settled when they move by less than this in a sweep, in the mean, in layers.
const SETTLED: f64 = 5e-4;

/// The field with a slope of 1 where its layers allow it.
///
/// Values stay in their steps, and the slope is that of a layer in its thickness.
pub(super) fn evened(field: LayerField) -> LayerField {
    let (slope, steps) = (1.0 / field.layer_cells(), f64::from(field.steps_per_layer()));
    let mut lattice = Lattice::of(&field);
    let solid: Vec<usize> = (0..lattice.values.len()).filter(|&node| !lattice.values[node].is_nan()).collect();
    sweep(&mut lattice, &solid, [slope, 0.0], SWEEPS, |lattice, ways, node, foretold| {
        within_step(lattice, ways, node, foretold, steps)
    });
    field.with_values(lattice.values_at_cells())
}

/// The values at some nodes after `sweeps` towards a slope of a layer a cell, or fewer if they have settled; from 0 on. Nothing else holds
/// them; other nodes stay as they are.
pub(super) fn relax(lattice: &mut Lattice, nodes: &[usize], sweeps: usize) {
    sweep(lattice, nodes, [1.0, SETTLED], sweeps, |_, _, _, foretold| foretold.max(0.0));
}

/// `sweeps` in which each of some nodes goes a [`SHARE`] of the way to what its joined neighbours foretell, within what `allowed` permits; until they
/// move by less than `settled` in the mean.
fn sweep(
    lattice: &mut Lattice,
    nodes: &[usize],
    [slope, settled]: [f64; 2],
    sweeps: usize,
    allowed: impl Fn(&Lattice, &[[f64; 3]], usize, f64) -> f64 + Send + Sync,
) {
    let solid: Vec<usize> = (0..lattice.values.len()).filter(|&node| !lattice.values[node].is_nan()).collect();
    let mut ways = vec![[0.0; 3]; lattice.values.len()];
    for _ in 0..sweeps {
        let found = in_parallel(solid.len(), AT_A_TIME, |k| way(lattice, solid[k]).map(|way| way * slope));
        solid.iter().zip(found).for_each(|(&node, way)| ways[node] = way);
        let moved = |node: usize| {
            let value = lattice.values[node];
            let foretold = foretold(lattice, &ways, node);
            foretold.map_or(value, |foretold| allowed(lattice, &ways, node, value + SHARE * (foretold - value)))
        };
        let found = in_parallel(nodes.len(), AT_A_TIME, |k| moved(nodes[k]));
        let mut moves = 0.0;
        for (&node, value) in nodes.iter().zip(found) {
            moves += (value - lattice.values[node]).abs();
            lattice.values[node] = value;
        }
        if moves < settled * nodes.len() as f64 {
            break;
        }
    }
}

/// The unit vector along the slope at a node; zero if there is none. Not a number along an axis on which the front parts or
/// two meet: what is on both sides of the node knows better.
fn way(lattice: &Lattice, node: usize) -> [f64; 3] {
    let value = lattice.values[node];
    let slopes = lattice.slopes(node);
    let norm = slopes.iter().map(|slope| slope * slope).sum::<f64>().sqrt();
    let strides = lattice.strides();
    let is_crest = |axis: usize| {
        let ahead = [node - strides[axis], node + strides[axis]].map(|next| lattice.values[next] - value);
        let is_inner = [false, true].iter().all(|&forwards| lattice.is_joined(node, axis, forwards));
        is_inner && ahead[0] * ahead[1] > 0.0 && ahead[0].abs().min(ahead[1].abs()) > CREST
    };
    [0, 1, 2].map(|axis| match is_crest(axis) {
        true => f64::NAN,
        false if norm > 0.0 => slopes[axis] / norm,
        false => 0.0,
    })
}

/// How far the front goes along an axis between two nodes whose ways are these there.
fn step(a: f64, b: f64) -> f64 {
    match [a, b].map(f64::is_nan) {
        [false, false] => (a + b) / 2.0,
        [false, true] => a,
        [true, false] => b,
        [true, true] => 0.0,
    }
}

/// The mean of what the joined neighbours of a node foretell; `None` if there are none.
fn foretold(lattice: &Lattice, ways: &[[f64; 3]], node: usize) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    for (axis, stride) in lattice.strides().into_iter().enumerate() {
        for forwards in [false, true] {
            let next = if forwards { node + stride } else { node - stride };
            if lattice.is_joined(node, axis, forwards) {
                let step = step(ways[node][axis], ways[next][axis]);
                sum += if forwards { lattice.values[next] - step } else { lattice.values[next] + step };
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// What is nearest to a value of all that a node may have: it stays in its step, and at a cut its own level stays within its half.
fn within_step(lattice: &Lattice, ways: &[[f64; 3]], node: usize, wanted: f64, steps: f64) -> f64 {
    let value = lattice.values[node];
    let layer = value.floor();
    let own = layer + 0.5;
    // Whether the own level lies between the node and a joined neighbour that comes later, or earlier; if not, how far
    // across the cuts on that side the front goes.
    let mut carried = [false; 2];
    let mut across = [0.0f64; 2];
    for (axis, stride) in lattice.strides().into_iter().enumerate() {
        for forwards in [false, true] {
            let there = lattice.values[if forwards { node + stride } else { node - stride }];
            if lattice.is_joined(node, axis, forwards) {
                carried[usize::from(there < own)] = true;
            } else if !there.is_nan() {
                let out = if forwards { ways[node][axis] } else { -ways[node][axis] };
                let side = usize::from(out < 0.0);
                across[side] = across[side].max(out.abs());
            }
        }
    }
    let reach = |side: usize| {
        let is_bound = !carried[side] && across[side] >= FACES;
        if is_bound { (0.5 - MARGIN) * across[side] } else { 0.5 }
    };
    let (low, high) = (own - reach(0), (own + reach(1)).min(layer + 1.0 - GAP));
    let (first, end) = ((value * steps).floor() / steps, ((value * steps).floor() + 1.0) / steps - GAP);
    wanted.clamp(low.min(end), high.max(first)).clamp(first, end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Cells;

    fn column(values: &[f64]) -> Vec<f64> {
        let rows = vec![1; values.len()];
        let cells = Cells::new([1, 1, values.len() as u32], &rows).unwrap();
        evened(LayerField::new(&cells, values.to_vec(), 1.0).unwrap()).values().to_vec()
    }

    #[test]
    fn a_steady_front_stays_as_it_is() {
        let steady: Vec<f64> = (0..8).map(|k| f64::from(k) + 0.5).collect();
        assert_eq!(column(&steady), steady);
    }

    #[test]
    fn where_a_front_parts_and_where_two_meet_values_stay_as_they_are() {
        for values in [[6.5, 5.5, 4.5, 5.5, 6.5], [4.5, 5.5, 6.5, 5.5, 4.5]] {
            let cells = Cells::new([5, 1, 1], &[0b11111]).unwrap();
            let field = LayerField::new(&cells, values.to_vec(), 1.0).unwrap();
            assert_eq!(evened(field).values(), values);
        }
    }

    #[test]
    fn between_two_waits_layers_become_a_cell_thick_and_no_value_leaves_its_layer() {
        // From layer 2 to 4 there is a whole layer between, and from 7 to 9: the sides know nothing of each other.
        let waits = [0.5, 1.5, 2.5, 4.0, 5.3, 6.1, 7.6, 9.4, 10.4];
        let after = column(&waits);
        assert!(waits.iter().zip(&after).all(|(a, b)| a.floor() - b.floor() == 0.0), "{after:?}");
        assert_eq!(after[..3], waits[..3]);
        assert!(after[3..7].windows(2).all(|w| (w[1] - w[0] - 1.0).abs() < 0.05), "{after:?}");
        assert_eq!(after[7..], waits[7..]);
    }

    #[test]
    fn a_cell_at_a_wait_keeps_its_own_level_within_its_half() {
        // The slopes would like to have the first at 4.0, half a cell below its level, or the last at 7.0.
        for waits in [[1.5, 4.0, 5.0, 6.0], [4.0, 5.0, 6.0, 9.5], [1.5, 4.99, 5.99, 6.99], [4.99, 5.99, 6.99, 9.5]] {
            let after = column(&waits);
            for cell in (0..4).filter(|&cell| cell > 0 && after[cell] - after[cell - 1] > 1.5) {
                assert!(after[cell] - after[cell].floor() <= 0.5 + 0.45 + 1e-9, "{after:?}");
                assert!(after[cell - 1] - after[cell - 1].floor() >= 0.5 - 0.45 - 1e-9, "{after:?}");
            }
        }
    }

    #[test]
    fn a_front_that_leans_gets_a_slope_of_one() {
        // It gets faster and slower, by two fifths.
        let cells = Cells::new([12, 1, 12], &[0xfff; 12]).unwrap();
        let pulsing = |cell: u32| {
            let along = 0.8 * f64::from(cell / 12) + 0.6 * f64::from(cell % 12);
            along + 0.3 * (1.3 * along).sin() + 1.0
        };
        let field = evened(LayerField::new(&cells, (0..144).map(pulsing).collect(), 1.0).unwrap());
        let rough = |of: &dyn Fn(u32) -> f64| {
            let slope = |cell: u32| ((of(cell + 1) - of(cell - 1)) / 2.0).hypot((of(cell + 12) - of(cell - 12)) / 2.0);
            let inner = (1..11).flat_map(|z| (1..11).map(move |x| x + 12 * z));
            inner.map(|cell| (slope(cell) - 1.0).powi(2)).sum::<f64>()
        };
        let after = |cell: u32| field.value(cell).unwrap();
        assert!(rough(&after) < rough(&pulsing) / 4.0, "{} {}", rough(&after), rough(&pulsing));
    }
}
