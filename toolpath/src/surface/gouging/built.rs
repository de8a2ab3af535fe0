//! When each triangle is built, as the number of waypoints done by then.
//!
//! A triangle of an earlier layer is there when its layer is finished. A triangle of the layer itself is there once the last
//! bead that touches it has been laid; one that no bead touches, when the layer is finished.

use crate::Progress;
use crate::surface::orientation::ToolPath;
use crate::surface::parallel;
use crate::surface::stack::{Keys, LayerStack};
use std::ops::ControlFlow;

/// The number of the first waypoint of each path.
pub(super) fn starts(paths: &[ToolPath]) -> Vec<u32> {
    let count = |sum: &mut u32, path: &ToolPath| {
        let start = *sum;
        *sum += path.waypoints.len() as u32;
        Some(start)
    };
    paths.iter().scan(0, count).collect()
}

/// For each triangle the waypoints that are done when it is there; `None` if cancelled.
pub(super) fn keys(
    stack: &LayerStack,
    paths: &[ToolPath],
    starts: &[u32],
    own_layer: bool,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Option<Keys> {
    let mut finished = vec![0; stack.layers.len()];
    for (path, start) in paths.iter().zip(starts) {
        finished[path.layer as usize] = start + path.waypoints.len() as u32;
    }
    // A layer without paths is finished with the one before.
    (1..finished.len()).for_each(|layer| finished[layer] = finished[layer].max(finished[layer - 1]));
    let triangles = stack.tree.triangles();
    let mut keys: Vec<u32> = triangles.iter().map(|triangle| finished[triangle.layer as usize]).collect();
    if own_layer {
        let touched = parallel::map(paths, "built", progress, |k, path| touched(stack, path, starts[k]))?;
        let mut laid = vec![0; keys.len()];
        touched.into_iter().flatten().for_each(|(triangle, key)| laid[triangle as usize] = key);
        keys.iter_mut().zip(laid).filter(|(_, laid)| *laid > 0).for_each(|(key, laid)| *key = laid);
    }
    Some(Keys::new(&stack.tree, keys))
}

/// The triangles that the beads of a path touch, each time with the waypoints done after that: the last word holds.
fn touched(stack: &LayerStack, path: &ToolPath, start: u32) -> Vec<(u32, u32)> {
    let mut touched = Vec::new();
    for (waypoint, done) in path.waypoints.iter().zip(start + 1..) {
        let layer = path.layer..path.layer + 1;
        let Some(foot) = stack.tree.nearest(&stack.keys, waypoint.tip, layer.clone(), f64::INFINITY, |_, _| true)
        else {
            continue;
        };
        // Where beads share a place they are narrow, but lie there all the same.
        let reach = waypoint.width.max(waypoint.height) / 2.0;
        stack.tree.within(&stack.keys, foot.point, layer, reach, |t| touched.push((t as u32, done)));
    }
    touched
}
