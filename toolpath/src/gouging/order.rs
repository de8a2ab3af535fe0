//! The order in which the paths of a layer are laid: what its beads would close in comes first.
//!
//! In a crease of a layer a waypoint is free as long as the slopes beside it are bare. Curves know nothing of that. So the
//! piece of a path around a waypoint that only beads of its own layer close in, from the sample before to the one after, is
//! cut out and laid before all else of the layer: then only earlier layers are there, and of these a tilt frees it. What is
//! left of the path is laid as before, in two parts or more.
//!
//! Laid early, pieces may be in the way of others. So the layer is looked at once more, and what is left is cut out in turn, a
//! few times; the order that leaves the fewest waypoints is kept.
//!
//! Only what may have changed is looked at again: the pieces, what is left of their paths, and the paths that were laid before these; for all
//! that comes later the same is built. When something is left out, only paths with waypoints that were not free.
//!
//! Where the nozzle would at last be deeper than a layer, a machine would not scratch it but run into it. Such pieces are
//! left out. Everything else is as free without them, or freer.

use super::along::{ResolvedPath, tilted};
use super::built::{DepositedPath, built, touched};
use super::deepest::Scene;
use super::error::GougingError;
use super::gouge::{Gouge, LeftOut};
use super::nozzle::Nozzle;
use super::options::GougingOptions;
use crate::ProgressFn;
use crate::layer::LayerStack;
use crate::orientation::ToolPath;
use crate::parallel;
use std::collections::BTreeMap;

/// How often the orders of layers are changed. Of 5,180 waypoints that gouge on 300 layers with hills 364 are left after three rounds, 24 after six
/// (`common::creases::rows` of the tests, seeds 0 to 299, nothing raised).
const ROUNDS: usize = 6;

/// What paths are freed with.
pub(super) struct Resolving<'a> {
    pub stack: &'a LayerStack<'a>,
    pub nozzle: &'a Nozzle,
    pub options: &'a GougingOptions,
    pub progress: ProgressFn<'a>,
}

/// A path in the order of its layer.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub laid: DepositedPath,
    /// Whether it is laid before what is left of the curves of the layer.
    pub first: bool,
    pub freed: ResolvedPath,
    /// Whether it is still to be set free, or once more.
    open: bool,
}

impl Place {
    fn new(path: ToolPath, first: bool) -> Self {
        Place { laid: DepositedPath { path, touched: Vec::new() }, first, freed: ResolvedPath::default(), open: true }
    }
}

/// What comes of all paths.
pub(super) struct Run {
    pub places: Vec<Place>,
    /// Waypoints that gouge in the order given.
    pub gouging_before: usize,
    pub left_out: Vec<LeftOut>,
}

/// The paths of a layer in the order in which they are laid.
type Order = Vec<Place>;

fn left(order: &Order) -> usize {
    order.iter().map(|place| place.freed.left.len()).sum()
}

/// Pieces that are cut out of the paths of a layer.
struct Cut {
    pieces: Vec<(ToolPath, Gouge)>,
    /// What is left of the paths.
    rest: Order,
    /// So many of these are of the last path that was cut, or come before it.
    changed: usize,
}

/// Cuts out the pieces of paths around the waypoints left that are `bad`: these and the rest. Those of a path that touch are
/// one, with the deepest gouge of all, its waypoint numbered in the piece.
fn cut(order: &Order, bad: impl Fn(&Place, &Gouge) -> bool) -> Cut {
    let mut cut = Cut { pieces: Vec::new(), rest: Vec::new(), changed: 0 };
    for place in order {
        let (path, first) = (&place.laid.path, place.first);
        let (mut from, last) = (0, path.waypoints.len() - 1);
        let part = |from: usize, to: usize| {
            let closed = path.closed && (from, to) == (0, last);
            ToolPath { waypoints: path.waypoints[from..=to].to_vec(), closed, ..*path }
        };
        let left = place.freed.left.iter().filter(|(_, gouge)| bad(place, gouge));
        let pieces = pieces(path, left);
        if pieces.is_empty() {
            cut.rest.push(place.clone());
            continue;
        }
        for (start, end, gouge) in pieces {
            if from < start {
                cut.rest.push(Place::new(part(from, start), first));
            }
            cut.pieces.push((part(start, end), Gouge { waypoint: gouge.waypoint - start, ..gouge }));
            from = end;
        }
        if from < last {
            cut.rest.push(Place::new(part(from, last), first));
        }
        // What follows is laid after all that was cut, in both orders, so it finds the same built.
        cut.changed = cut.rest.len();
    }
    cut
}

/// Pieces around waypoints, from the sample before to the one after: first and last waypoint, and the deepest gouge.
fn pieces<'a>(path: &ToolPath, around: impl Iterator<Item = &'a (usize, Gouge)>) -> Vec<(usize, usize, Gouge)> {
    let mut pieces: Vec<(usize, usize, Gouge)> = Vec::new();
    let (last, is_sample) = (path.waypoints.len() - 1, |k: &usize| !path.waypoints[*k].added);
    for &(k, gouge) in around {
        let gouge = Gouge { waypoint: k, ..gouge };
        let from = (0..k).rev().find(is_sample).unwrap_or(0);
        let to = (k + 1..last).find(is_sample).unwrap_or(last);
        match pieces.last_mut() {
            // The waypoints come by rising number, so a piece can touch the last one alone.
            Some((_, end, worst)) if *end >= from => {
                *end = to;
                *worst = if gouge.depth > worst.depth { gouge } else { *worst };
            }
            _ => pieces.push((from, to, gouge)),
        }
    }
    pieces
}

impl Resolving<'_> {
    /// Sets all paths free.
    pub fn run(&self, paths: Vec<ToolPath>) -> Result<Run, GougingError> {
        let mut orders: Vec<Order> = Vec::new();
        for path in paths {
            let place = Place::new(path, false);
            match orders.last_mut() {
                Some(order) if order[0].laid.path.layer == place.laid.path.layer => order.push(place),
                _ => orders.push(vec![place]),
            }
        }
        let all: Vec<usize> = (0..orders.len()).collect();
        // All paths once in the order given; from here on only those that a change may concern.
        self.free(&mut orders, &all)?;
        let gouging_before = orders.iter().flatten().map(|place| place.freed.gouging_before).sum();
        if self.options.own_layer && self.options.cut {
            self.lay_first(&mut orders, all)?;
        }
        let left_out = self.leave_out(&mut orders)?;
        Ok(Run { places: orders.into_iter().flatten().collect(), gouging_before, left_out })
    }

    /// Changes the orders of layers in a few rounds, and keeps of each layer that with which the fewest waypoints are left.
    fn lay_first(&self, orders: &mut [Order], mut open: Vec<usize>) -> Result<(), GougingError> {
        let mut best: BTreeMap<usize, Order> = BTreeMap::new();
        for _ in 0..ROUNDS {
            open.retain(|&k| {
                let Cut { pieces, mut rest, changed } = cut(&orders[k], |_, gouge| gouge.own_layer);
                if pieces.is_empty() {
                    return false;
                }
                rest[..changed].iter_mut().for_each(|place| place.open = true);
                let mut order: Order = pieces.into_iter().map(|(path, _)| Place::new(path, true)).collect();
                order.append(&mut rest);
                let before = std::mem::replace(&mut orders[k], order);
                if best.get(&k).is_none_or(|best| left(&before) < left(best)) {
                    best.insert(k, before);
                }
                true
            });
            if open.is_empty() {
                break;
            }
            self.free(orders, &open)?;
        }
        for (k, order) in best {
            // What it came to is put back with it, so nothing has to be freed again.
            if left(&orders[k]) >= left(&order) {
                orders[k] = order;
            }
        }
        Ok(())
    }

    /// Takes out what is too deep. Each round takes at least one piece, so there is an end.
    fn leave_out(&self, orders: &mut [Order]) -> Result<Vec<LeftOut>, GougingError> {
        let mut left_out = Vec::new();
        loop {
            let mut open = Vec::new();
            for (k, order) in orders.iter_mut().enumerate() {
                let too_deep = |place: &Place, gouge: &Gouge| {
                    gouge.depth > self.options.max_depth * place.freed.waypoints[gouge.waypoint].height
                };
                let Cut { pieces, mut rest, .. } = cut(order, too_deep);
                if !pieces.is_empty() {
                    // Less is built now. What was free stays free, what was not may be free.
                    rest.iter_mut().for_each(|place| place.open |= !place.freed.left.is_empty());
                    left_out.extend(pieces.iter().filter_map(|(piece, gouge)| LeftOut::new(piece, gouge)));
                    *order = rest;
                    open.push(k);
                }
            }
            if open.is_empty() {
                left_out.sort_by(|a: &LeftOut, b: &LeftOut| {
                    (a.layer, a.curve).cmp(&(b.layer, b.curve)).then(a.arcs[0].total_cmp(&b.arcs[0]))
                });
                return Ok(left_out);
            }
            self.free(orders, &open)?;
        }
    }

    /// Sets the open paths of some layers free. The others count for what is built by then: what comes of them does not
    /// depend on the orders of other layers.
    fn free(&self, orders: &mut [Order], which: &[usize]) -> Result<(), GougingError> {
        let is_open = |&(k, place): &(usize, usize)| orders[k][place].open;
        let places = |k: usize| (0..orders[k].len()).map(move |place| (k, place)).filter(is_open);
        let wanted: Vec<(usize, usize)> = which.iter().flat_map(|&k| places(k)).collect();
        if self.options.own_layer {
            let work = |_: usize, &(k, place): &(usize, usize)| touched(self.stack, &orders[k][place].laid.path);
            let found = parallel::map(&wanted, "built", self.progress, work).ok_or(GougingError::Cancelled)?;
            wanted.iter().zip(found).for_each(|(&(k, place), found)| orders[k][place].laid.touched = found);
        }
        let built =
            built(self.stack, orders.iter().flatten().map(|Place { laid, .. }| (&laid.path, &laid.touched[..])));
        let starts = starts(orders);
        let scene = |keys| Scene::new(self.stack, keys, self.nozzle, self.options.over_plate());
        // A path that is laid from its end meets other beads of its own than one from its start.
        let [forward, backward] = [scene(&built.keys), scene(&built.backward)];
        let work = |_: usize, &(k, place): &(usize, usize)| {
            let path = &orders[k][place].laid.path;
            let (start, layer) = (starts[k][place], starts[k][0]);
            let there = tilted(&forward, path, start, self.options, &self.stack.hints);
            let may_turn = there.left() > 0 && self.options.own_layer && self.options.reverse;
            let back = may_turn.then(|| there.reversed(&backward, path, start)).flatten();
            let Some(back) = back else { return there.freed(layer) };
            let back = back.freed(layer);
            let last = path.waypoints.len() - 1;
            // Numbers count in the path as it was given.
            let left = back.left.iter().rev().map(|&(k, gouge)| (last - k, gouge)).collect();
            ResolvedPath { reversed: true, left, ..back }
        };
        let found = parallel::map(&wanted, "gouging", self.progress, work).ok_or(GougingError::Cancelled)?;
        for (&(k, place), found) in wanted.iter().zip(found) {
            (orders[k][place].freed, orders[k][place].open) = (found, false);
        }
        Ok(())
    }
}

/// The number of the first waypoint of each path.
fn starts(orders: &[Order]) -> Vec<Vec<u32>> {
    let mut sum = 0;
    let mut start = |place: &Place| {
        let start = sum;
        sum += place.laid.path.waypoints.len() as u32;
        start
    };
    orders.iter().map(|order| order.iter().map(&mut start).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gouging::{NozzlePart, Obstacle};
    use crate::orientation::Waypoint;
    use crate::path::BeadKind;
    use nalgebra::{Point3, Vector3};

    /// Pieces that touch become one with the deepest gouge of both; others stay apart. They go from sample to sample.
    #[test]
    fn pieces_that_touch_become_one() {
        let waypoint = |k: u32| Waypoint {
            position: Point3::new(f64::from(k), 0.0, 0.4),
            axis: Vector3::z_axis(),
            width: 0.5,
            height: 0.4,
            arc: f64::from(k),
            added: k == 11,
            lift: Vector3::zeros(),
            kind: BeadKind::Solid,
        };
        let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: (0..20).map(waypoint).collect() };
        let gouge = |k: usize, depth: f64| {
            let part = NozzlePart::Cone;
            (k, Gouge { path: 0, waypoint: 0, obstacle: Obstacle::Plate, depth, part, own_layer: false })
        };
        let around = [gouge(2, 0.3), gouge(4, 0.5), gouge(12, 0.1), gouge(16, 0.2), gouge(17, 0.1)];
        let found: Vec<_> =
            pieces(&path, around.iter()).iter().map(|(from, to, worst)| (*from, *to, worst.waypoint)).collect();
        assert_eq!(found, [(1, 5, 4), (10, 13, 12), (15, 18, 16)]);
    }
}
