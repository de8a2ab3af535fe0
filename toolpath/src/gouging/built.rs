//! When each triangle is built, as the number of waypoints done by then.
//!
//! The mould is there from the start. A triangle of an earlier layer is there when its layer is finished. A triangle of the layer itself is there once the last
//! bead that touches it has been laid; one that no bead touches, when the layer is finished.
//!
//! Samples alone lay beads. Waypoints added between them lie on the straight way from one to the next, and are there so that
//! directions turn evenly: however many are put between or taken out, the same is built.
//!
//! Waypoints are numbered from 0 through all paths. A triangle that number `n` completes has the key `n + 1`. A nozzle meets
//! the triangles with a key below some number: [`before`] for the waypoints of a path, [`after`] for what is finished.

use crate::layer::{Keys, LayerStack, MOULD, of_layer};
use crate::orientation::{ToolPath, Waypoint};

/// A path and the triangles that its beads touch, each time with the waypoint. Without any of these its layer is there only
/// when it is finished.
#[derive(Clone, Debug)]
pub(super) struct DepositedPath {
    pub path: ToolPath,
    pub touched: Vec<(u32, u32)>,
}

/// When each triangle is there, as the waypoints done by then.
pub(super) struct Built {
    pub keys: Keys,
    /// The same if each path were printed from its end to its start, with its waypoints numbered that way round.
    pub backward: Keys,
}

/// When each triangle is built, if paths are laid in this order: each with what its beads touch.
pub(super) fn built<'a>(stack: &LayerStack, order: impl Iterator<Item = (&'a ToolPath, &'a [(u32, u32)])>) -> Built {
    let triangles = stack.tree.triangles();
    let mut finished = vec![0; stack.layers.len()];
    let mut laid = vec![[0; 2]; triangles.len()];
    let mut start = 0;
    for (path, touched) in order {
        // The last path that touches a triangle counts: its last waypoint there, and, from its end, its first.
        let end = start + path.waypoints.len() as u32;
        for &(triangle, k) in touched {
            let [last, first] = &mut laid[triangle as usize];
            *last = start + k + 1;
            *first = if *first <= start { end - k } else { *first };
        }
        finished[path.layer as usize] = end;
        start = end;
    }
    // A layer without paths is finished with the one before.
    (1..finished.len()).for_each(|layer| finished[layer] = finished[layer].max(finished[layer - 1]));
    let keys = |way: usize| {
        let key = |(triangle, laid): (usize, &[u32; 2])| match triangles[triangle].layer {
            MOULD => 0,
            _ if laid[way] > 0 => laid[way],
            layer => finished[layer as usize],
        };
        Keys::new(&stack.tree, laid.iter().enumerate().map(key).collect())
    };
    Built { keys: keys(0), backward: keys(1) }
}

/// What a nozzle meets when the first `laid` waypoints are done: the triangles with a key below this.
pub(super) fn after(laid: u32) -> u32 {
    laid + 1
}

/// What a nozzle meets at each waypoint of a path whose first one has the number `start`: the triangles with a key below this.
///
/// It ends with the last sample before. At a waypoint added in between it is the same as at that sample, whose bead then
/// lies under the tip.
pub(super) fn before(waypoints: &[Waypoint], start: u32) -> Vec<u32> {
    let mut before = after(start);
    let mut done = before;
    let at = |(waypoint, number): (&Waypoint, u32)| {
        if !waypoint.added {
            before = done;
            done = after(number + 1);
        }
        before
    };
    waypoints.iter().zip(start..).map(at).collect()
}

/// The triangles that the beads of a path touch, each time with the waypoint: a sample.
pub(super) fn touched(stack: &LayerStack, path: &ToolPath) -> Vec<(u32, u32)> {
    let mut touched = Vec::new();
    for (waypoint, k) in path.waypoints.iter().zip(0..).filter(|(waypoint, _)| !waypoint.added) {
        let layer = of_layer(path.layer);
        let Some(foot) =
            stack.tree.nearest(&stack.keys, waypoint.bead_top(), layer.clone(), f64::INFINITY, |_, _| true)
        else {
            continue;
        };
        // Where beads share a place they are narrow, but lie there all the same.
        let reach = waypoint.width.max(waypoint.height) / 2.0;
        stack.tree.within(&stack.keys, foot.point, layer, reach, |t| touched.push((t as u32, k)));
    }
    touched
}
