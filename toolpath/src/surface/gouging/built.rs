//! When each triangle is built, as the number of waypoints done by then.
//!
//! A triangle of an earlier layer is there when its layer is finished. A triangle of the layer itself is there once the last
//! bead that touches it has been laid; one that no bead touches, when the layer is finished.

use crate::surface::orientation::ToolPath;
use crate::surface::stack::{Keys, LayerStack};

/// A path and the triangles that its beads touch, each time with the waypoint. Without any of these its layer is there only
/// when it is finished.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub path: ToolPath,
    pub touched: Vec<(u32, u32)>,
}

/// When each triangle is there, as the waypoints done by then.
pub(super) struct Built {
    pub keys: Keys,
    /// The same if each path were printed from its end to its start, with its waypoints numbered that way round.
    pub backward: Keys,
}

/// When each triangle is built, if paths are laid in this order.
pub(super) fn built<'a>(stack: &LayerStack, order: impl Iterator<Item = &'a Laid>) -> Built {
    let triangles = stack.tree.triangles();
    let mut finished = vec![0; stack.layers.len()];
    let mut laid = vec![[0; 2]; triangles.len()];
    let mut start = 0;
    for Laid { path, touched } in order {
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
        let key = |(triangle, laid): (usize, &[u32; 2])| {
            if laid[way] > 0 { laid[way] } else { finished[triangles[triangle].layer as usize] }
        };
        Keys::new(&stack.tree, laid.iter().enumerate().map(key).collect())
    };
    Built { keys: keys(0), backward: keys(1) }
}

/// The triangles that the beads of a path touch, each time with the waypoint.
pub(super) fn touched(stack: &LayerStack, path: &ToolPath) -> Vec<(u32, u32)> {
    let mut touched = Vec::new();
    for (waypoint, k) in path.waypoints.iter().zip(0..) {
        let layer = path.layer..path.layer + 1;
        let Some(foot) = stack.tree.nearest(&stack.keys, waypoint.tip, layer.clone(), f64::INFINITY, |_, _| true)
        else {
            continue;
        };
        // Where beads share a place they are narrow, but lie there all the same.
        let reach = waypoint.width.max(waypoint.height) / 2.0;
        stack.tree.within(&stack.keys, foot.point, layer, reach, |t| touched.push((t as u32, k)));
    }
    touched
}
