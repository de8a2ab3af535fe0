//! Moves of a plan with marks among them: where layers begin, and what the beads are that follow.

use super::tags::Mark;
use crate::deposit::{Move, MoveKind};
use crate::gcode;
use crate::orientation::ToolPath;

/// Beads whose width and height change by less than this go by the mark before, in millimetres: fitted beads change all the time, and
/// no viewer shows less.
const NOTABLE_MM: f64 = 0.02;

/// The moves of a plan as a machine file takes them, with [marks](Mark) among them: each layer where the nozzle first goes to one of its
/// paths, and beads where their kind changes, or their width or height by 0.02 mm.
///
/// # Arguments
/// * `moves`: of a [`Deposition`](crate::deposit::Deposition); `paths`: those that it lays.
///
/// # Cost
/// Constant memory, `O(1)` a move.
///
/// # Example
/// ```
/// use curvlay_toolpath::gcode::{WriteOptions, marked_moves, write_gcode};
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::deposit::{DepositionOptions, deposit};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// let (axis, kind) = (Vector3::z_axis(), BeadKind::Wall);
/// let at = |x| Waypoint { position: Point3::new(x, 0.0, 0.3), axis, width: 0.5, height: 0.3, arc: x, added: false, lift: Vector3::zeros(), kind };
/// let paths = [ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(10.0)] }];
/// let plan = deposit(&paths, &DepositionOptions::default())?;
/// let mut file = Vec::new();
/// write_gcode(marked_moves(&plan.moves, &paths), &WriteOptions::default(), &mut file)?;
/// let file = String::from_utf8(file)?;
/// assert!(file.contains(";LAYER_CHANGE\n;Z:0.3\n;HEIGHT:0.3\n") && file.contains(";TYPE:External perimeter\n;WIDTH:0.5\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn marked_moves<'a>(moves: &'a [Move], paths: &'a [ToolPath]) -> impl Iterator<Item = gcode::Move> + 'a {
    let (mut layer, mut bead) = (None, None);
    moves.iter().flat_map(move |step| {
        let path = paths.get(step.path);
        // A retraction belongs to the path before.
        let first = path.filter(|path| step.kind != MoveKind::Retract && layer != Some(path.layer));
        let begins = first.and_then(|path| {
            layer = Some(path.layer);
            let start = path.waypoints.first()?;
            Some(Mark::Layer { number: path.layer, z_mm: start.position.z, height_mm: start.height })
        });
        let at = path.and_then(|path| path.waypoints.get(step.waypoint));
        let size = at.zip(step.bead).map(|(at, kind)| (kind, at.width, at.height));
        let is_near = |(kind, width, height): (_, f64, f64)| {
            let near = |a: f64, b: f64| (a - b).abs() < NOTABLE_MM;
            bead.is_some_and(|(last, w, h)| last == kind && near(w, width) && near(h, height))
        };
        let changed = size.filter(|size| !is_near(*size));
        bead = changed.or(bead);
        let changed = changed.map(|(kind, width_mm, height_mm)| Mark::Bead { kind, width_mm, height_mm });
        let marks = [begins, changed].map(|mark| mark.map(gcode::Move::Mark));
        marks.into_iter().flatten().chain([step.into()])
    })
}

impl From<&Move> for gcode::Move {
    /// The move of the machine file.
    fn from(step: &Move) -> Self {
        let &Move { tip, direction, filament, feed: feed_mm_s, .. } = step;
        match step.kind {
            MoveKind::Retract => gcode::Move::Retract { filament_mm: -filament, feed_mm_s },
            MoveKind::Prime => gcode::Move::Prime { filament_mm: filament, feed_mm_s },
            MoveKind::Print => gcode::Move::Print { tip, direction, filament_mm: filament, feed_mm_s },
            MoveKind::Travel => gcode::Move::Travel { tip, direction, feed_mm_s },
        }
    }
}
