//! In which order the curves of layers are travelled, and from which end, so that the ways in between are short.
//!
//! Takes curves layer by layer, as plain points; gives a [`TravelOrder`].
//!
//! Layers keep their order: the growth decides it. Within a layer curves may be printed in any order. An open curve has
//! two *ways* to be travelled, a closed one two for each point at which it may start. Between the end of one and the start of
//! the next the nozzle travels; the sum of these straight distances is made short. It is a travelling salesman's path, in
//! blocks: one a layer, entered where the layer before was left.
//!
//! * `exact`: for layers of few curves the program of Held and Karp ("A dynamic programming approach to sequencing
//!   problems", J. SIAM 10(1), 1962) over sets of curves, begun at all ends of the layer before at once. So over a run of such
//!   layers the sum is the least there is.
//! * `local`: for layers of many curves nearest neighbours, then parts are turned round (2-opt) or moved elsewhere
//!   (or-opt) as long as that shortens the way, from where the layer before ends to where the next begins.
//!
//! At last each layer is done again between its neighbours, and closed curves start where the detour to them is least. What
//! is found is never longer than the order given: if it would be, that one is the answer.

mod exact;
mod local;
mod travelled;
mod way;

pub use way::{OrderError, TravelCurve, Visit};

use crate::{Progress, ProgressFn};
use nalgebra::Point3;
use std::ops::ControlFlow;
use way::{Watch, Way, gap, length, ways};

/// Rounds over all layers at the end. One nearly always does: later ones find nothing.
const ROUNDS: usize = 3;

/// An order of curves.
#[derive(Clone, Debug, PartialEq)]
pub struct TravelOrder {
    /// For each layer its curves.
    pub layers: Vec<Vec<Visit>>,
    /// Length of all straight ways from curve to curve, in millimetres.
    pub travel_mm: f64,
    /// The same for the order given.
    pub given_mm: f64,
}

fn total(layers: &[Vec<Way>]) -> f64 {
    let all: Vec<Way> = layers.iter().flatten().copied().collect();
    length(&all, None, None)
}

/// Finds a short order of the curves of each layer, and which way each is travelled.
///
/// # Arguments
/// * `layers`: the curves of each layer in the order given; layers without curves are passed over.
/// * `progress`: called with the stage `order` and the layers done; may cancel.
///
/// # Returns
/// For each layer every curve once. The sum of the straight ways is the least there is if all curves are open and no
/// layer has more than ten of them; else it is one that is never above that of the order given.
///
/// # Errors
/// [`OrderError`].
///
/// # Cost
/// A layer of ten open curves takes about a millisecond; one of `n` more some passes of `n^2` steps. The result depends
/// on nothing but the curves.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::order::{TravelCurve, Visit, order_curves};
/// // Three parallel lines, 1 mm apart, all from left to right, the middle one last.
/// let line = |y: f64| [Point3::new(0.0, y, 0.0), Point3::new(9.0, y, 0.0)];
/// let lines = [line(0.0), line(2.0), line(1.0)];
/// let curves: Vec<_> = lines.iter().map(|points| TravelCurve { points, closed: false }).collect();
/// let order = order_curves(&[curves], &|_| std::ops::ControlFlow::Continue(()))?;
/// assert!((order.given_mm - (85_f64.sqrt() + 82_f64.sqrt())).abs() < 1e-12);
/// // To and fro.
/// assert_eq!(order.travel_mm, 2.0);
/// assert_eq!(order.layers[0][1], Visit { curve: 2, start: 1, reversed: true });
/// # Ok::<(), curvlay_toolpath::order::OrderError>(())
/// ```
pub fn order_curves(layers: &[Vec<TravelCurve>], progress: ProgressFn) -> Result<TravelOrder, OrderError> {
    let watch = |done: usize| match progress(Progress { stage: "order", done: done as u64, total: layers.len() as u64 })
    {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(OrderError::Cancelled),
    };
    layers.iter().enumerate().try_for_each(|(layer, curves)| check(layer, curves))?;
    let each = |curves: &Vec<TravelCurve>| -> Vec<Vec<Way>> {
        (0..).zip(curves).map(|(number, curve)| ways(curve, number)).collect()
    };
    let choices: Vec<Vec<Vec<Way>>> = layers.iter().map(each).collect();
    let given: Vec<Vec<Way>> = choices.iter().map(|layer| layer.iter().map(|ways| ways[0]).collect()).collect();
    let mut found = forward(&choices, layers, &watch)?;
    polish(&mut found, &choices, layers, &|| watch(layers.len()))?;
    let given_mm = total(&given);
    let best = if total(&found) < given_mm { found } else { given };
    let travel_mm = total(&best);
    let visits = |layer: &Vec<Way>| layer.iter().map(|way| way.visit).collect();
    Ok(TravelOrder { layers: best.iter().map(visits).collect(), travel_mm, given_mm })
}

/// Layer by layer, keeping the best for each end of a layer as long as layers are small.
fn forward(
    choices: &[Vec<Vec<Way>>],
    layers: &[Vec<TravelCurve>],
    watch: &dyn Fn(usize) -> Result<(), OrderError>,
) -> Result<Vec<Vec<Way>>, OrderError> {
    // For each layer its orders, each with the one of the layer before that it goes on from.
    let mut orders: Vec<Vec<(Vec<Way>, Option<usize>)>> = Vec::new();
    // Where the layers so far may end, and how long the way there is.
    let mut ends: Vec<(f64, Option<Point3<f64>>)> = vec![(0.0, None)];
    for (done, (choice, curves)) in choices.iter().zip(layers).enumerate() {
        watch(done)?;
        let found: Vec<(f64, Vec<Way>, usize)> = if exact::fits(choice) {
            exact::orders(choice, &ends)
        } else {
            // Too many curves to go on from each end: from the best one alone.
            let from = (0..ends.len()).fold(0, |best, k| if ends[k].0 < ends[best].0 { k } else { best });
            let order = local::order(choice, curves, ends[from].1, None, &|| watch(done))?;
            vec![(ends[from].0 + length(&order, ends[from].1, None), order, from)]
        };
        // A layer without curves changes no end, and hands each of them on.
        if choice.is_empty() {
            orders.push((0..ends.len()).map(|k| (Vec::new(), Some(k))).collect());
            continue;
        }
        ends = found.iter().map(|(cost, order, _)| (*cost, order.last().map(|way| way.end))).collect();
        orders.push(found.into_iter().map(|(_, order, from)| (order, Some(from))).collect());
    }
    let mut at = (0..ends.len()).fold(0, |best, k| if ends[k].0 < ends[best].0 { k } else { best });
    let mut best = Vec::with_capacity(orders.len());
    for layer in orders.into_iter().rev() {
        let Some((order, from)) = layer.into_iter().nth(at) else {
            break;
        };
        at = from.unwrap_or(0);
        best.push(order);
    }
    best.reverse();
    Ok(best)
}

/// Each layer again, between its neighbours as they are.
fn polish(
    layers: &mut [Vec<Way>],
    choices: &[Vec<Vec<Way>>],
    curves: &[Vec<TravelCurve>],
    watch: Watch,
) -> Result<(), OrderError> {
    for _ in 0..ROUNDS {
        let before = total(layers);
        for k in (0..layers.len()).filter(|&k| !choices[k].is_empty()) {
            watch()?;
            // Past layers without curves.
            let from = layers[..k].iter().rev().find_map(|layer| layer.last()).map(|way| way.end);
            let to = layers[k + 1..].iter().find_map(|layer| layer.first()).map(|way| way.start);
            if !exact::fits(&choices[k]) {
                local::improve(&mut layers[k], &curves[k], from, to, watch)?;
            }
            turn_rings(&mut layers[k], &curves[k], from, to);
        }
        // Nothing but rounding left to gain.
        if total(layers) >= before * (1.0 - 1e-9) {
            break;
        }
    }
    Ok(())
}

/// Starts each closed curve where the detour between its neighbours is least.
fn turn_rings(order: &mut [Way], curves: &[TravelCurve], from: Option<Point3<f64>>, to: Option<Point3<f64>>) {
    for k in 0..order.len() {
        let visit = order[k].visit;
        let curve = &curves[visit.curve as usize];
        if !curve.closed {
            continue;
        }
        let before = k.checked_sub(1).map_or(from, |k| Some(order[k].end));
        let behind = order.get(k + 1).map_or(to, |way| Some(way.start));
        let detour = |p: Point3<f64>| gap(before, Some(p)) + gap(Some(p), behind);
        let mut best = (detour(order[k].start), visit.start as usize);
        for (start, &p) in curve.points.iter().enumerate() {
            let found = detour(p);
            if found < best.0 {
                best = (found, start);
            }
        }
        order[k] = Way::new(curve, visit.curve, best.1, visit.reversed);
    }
}

fn check(layer: usize, curves: &[TravelCurve]) -> Result<(), OrderError> {
    if curves.len() > 1 << 24 || curves.iter().any(|curve| curve.points.len() > 1 << 31) {
        return Err(OrderError::TooLarge { layer });
    }
    for (curve, given) in curves.iter().enumerate() {
        if given.points.is_empty() {
            return Err(OrderError::NoPoints { layer, curve });
        }
        let sound = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= 1e9);
        if let Some(point) = given.points.iter().position(|p| !sound(p)) {
            return Err(OrderError::BadPoint { layer, curve, point });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Layers of many curves are made shorter between their neighbours; those of few have the shortest order already and stay.
    #[test]
    fn layers_of_many_curves_are_polished() {
        let mut draw = Pcg64Mcg::seed_from_u64(1);
        let mut place = || Point3::from([(); 3].map(|()| 10.0 * draw.random::<f64>()));
        let points: Vec<Vec<[Point3<f64>; 2]>> =
            [30, 3, 40].map(|count| (0..count).map(|_| [place(), place()]).collect()).to_vec();
        let curves: Vec<Vec<TravelCurve>> = points
            .iter()
            .map(|layer| layer.iter().map(|points| TravelCurve { points, closed: false }).collect())
            .collect();
        let choices: Vec<Vec<Vec<Way>>> = curves
            .iter()
            .map(|layer| layer.iter().zip(0..).map(|(curve, number)| ways(curve, number)).collect())
            .collect();
        assert_eq!([0, 1, 2].map(|k| exact::fits(&choices[k])), [false, true, false]);
        let given: Vec<Vec<Way>> = choices.iter().map(|layer| layer.iter().map(|ways| ways[0]).collect()).collect();
        let mut polished = given.clone();
        polish(&mut polished, &choices, &curves, &|| Ok(())).unwrap();
        assert_eq!(polished[1], given[1]);
        // Most curves of both lie in another place, or turned.
        let moved = |k: usize| polished[k].iter().zip(&given[k]).filter(|(now, then)| now != then).count();
        assert!(moved(0) > 20 && moved(2) > 28, "{} {}", moved(0), moved(2));
        assert!(total(&polished) < 0.6 * total(&given), "{} {}", total(&polished), total(&given));
    }
}
