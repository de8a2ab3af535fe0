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

/// When each triangle is there, as the waypoints done by then.
pub(super) struct Built {
    pub keys: Keys,
    /// The same if each path were printed from its end to its start, with its waypoints numbered that way round.
    pub backward: Keys,
}

/// When each triangle is built; `None` if cancelled.
pub(super) fn built(
    stack: &LayerStack,
    paths: &[ToolPath],
    starts: &[u32],
    own_layer: bool,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Option<Built> {
    let mut finished = vec![0; stack.layers.len()];
    for (path, start) in paths.iter().zip(starts) {
        finished[path.layer as usize] = start + path.waypoints.len() as u32;
    }
    // A layer without paths is finished with the one before.
    (1..finished.len()).for_each(|layer| finished[layer] = finished[layer].max(finished[layer - 1]));
    let triangles = stack.tree.triangles();
    let mut keys: Vec<u32> = triangles.iter().map(|triangle| finished[triangle.layer as usize]).collect();
    let mut backward = keys.clone();
    if own_layer {
        let touched = parallel::map(paths, "built", progress, |_, path| touched(stack, path))?;
        let mut laid = vec![[0; 2]; keys.len()];
        for ((of_path, path), start) in touched.iter().zip(paths).zip(starts) {
            // The last path that touches a triangle counts: its last waypoint there, and, from its end, its first.
            let end = start + path.waypoints.len() as u32;
            for &(triangle, k) in of_path {
                let [last, first] = &mut laid[triangle as usize];
                *last = start + k + 1;
                *first = if *first <= *start { end - k } else { *first };
            }
        }
        for (triangle, [last, first]) in laid.into_iter().enumerate().filter(|(_, laid)| laid[0] > 0) {
            (keys[triangle], backward[triangle]) = (last, first);
        }
    }
    Some(Built { keys: Keys::new(&stack.tree, keys), backward: Keys::new(&stack.tree, backward) })
}

/// The triangles that the beads of a path touch, each time with the waypoint.
fn touched(stack: &LayerStack, path: &ToolPath) -> Vec<(u32, u32)> {
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
