//! Segments of a plan of moves.

use super::frame::frame_at;
use super::parts::MAX_LINES;
use super::{Line, Section, Segment, SegmentKind, WriteBuildError};
use curvlay_toolpath::deposit::{Move, MoveKind};
use curvlay_toolpath::orientation::ToolPath;
use nalgebra::Isometry3;

/// Tips slower than this, in millimetres a second, stand still, as in the plan.
const SLOWEST: f64 = 1e-3;

/// The moves of a plan as segments: one for each run of beads of a kind on a path, and one for each travel. Filament that moves while the tip
/// stands belongs to the segment before (drawn back) or behind (pushed forward). The first travel begins at its first place, since what comes
/// before it is not in the plan. A segment of more than [`MAX_LINES`] lines is cut.
///
/// # Arguments
/// * `moves`: of a [`Deposition`](curvlay_toolpath::deposit::Deposition); `paths`: those that it lays.
///
/// # Errors
/// [`WriteBuildError::Moves`]: a move that goes with no path or waypoint, or a bead before any place. Never panics.
///
/// # Cost
/// `O(n)` for `n` moves; the iterator holds one segment, and can be made again at will.
pub fn segments<'a>(
    moves: &'a [Move],
    paths: &'a [ToolPath],
) -> Result<impl Fn() -> Segments<'a> + use<'a>, WriteBuildError> {
    let mut has_place = false;
    for (index, step) in moves.iter().enumerate() {
        let wrong = |what| Err(WriteBuildError::Moves { index, what });
        let waypoints = match paths.get(step.path) {
            Some(path) => &path.waypoints,
            None => return wrong("there is no such path"),
        };
        match step.kind {
            MoveKind::Travel => has_place = true,
            MoveKind::Print if !has_place => return wrong("a bead needs a place to begin at"),
            MoveKind::Print if step.waypoint == 0 || step.waypoint >= waypoints.len() => {
                return wrong("no waypoints at both ends of the bead");
            }
            MoveKind::Print if step.bead.is_none() => return wrong("a bead needs a kind"),
            _ => {}
        }
    }
    Ok(move || Segments { moves: moves.iter(), paths, at: None, prime_mm: 0.0, open: None })
}

/// See [`segments`].
pub struct Segments<'a> {
    moves: std::slice::Iter<'a, Move>,
    paths: &'a [ToolPath],
    /// Where the nozzle is.
    at: Option<Isometry3<f64>>,
    /// Filament since the last segment ended.
    prime_mm: f64,
    /// The segment that may go on.
    open: Option<Segment>,
}

impl Segments<'_> {
    /// The line of a move from a place.
    fn line(&self, step: &Move, from: &Isometry3<f64>) -> Line {
        let end = frame_at(step.tip, step.direction);
        let length = (end.translation.vector - from.translation.vector).norm();
        let section = |at: usize| {
            let waypoint = &self.paths[step.path].waypoints[at];
            Section { width_mm: waypoint.width, height_mm: waypoint.height }
        };
        let bead = (step.kind == MoveKind::Print).then(|| [section(step.waypoint - 1), section(step.waypoint)]);
        let speed_mm_s = (length > SLOWEST * step.seconds && step.seconds > 0.0).then_some(step.feed);
        Line { end, bead, speed_mm_s, seconds: step.seconds }
    }

    /// Adds a line; returns the segment before it, if the line begins another one.
    fn go(&mut self, step: &Move) -> Option<Segment> {
        let kind = match step.bead {
            Some(kind) if step.kind == MoveKind::Print => SegmentKind::Bead(kind),
            _ => SegmentKind::Travel,
        };
        let Some(start) = self.at else {
            self.at = Some(frame_at(step.tip, step.direction));
            return None;
        };
        let line = self.line(step, &start);
        self.at = Some(line.end);
        let layer = self.paths[step.path].layer;
        let filament_mm = if step.kind == MoveKind::Print { step.filament } else { 0.0 };
        // A travel goes over to the next path, and so to the layer of that.
        let goes_on = |open: &Segment| {
            let same_path = open.path as usize == step.path || kind == SegmentKind::Travel;
            open.kind == kind && same_path && open.retract_mm.abs() <= 0.0 && open.lines.len() < MAX_LINES
        };
        if self.prime_mm.abs() <= 0.0
            && let Some(open) = self.open.as_mut().filter(|open| goes_on(open))
        {
            open.lines.push(line);
            (open.path, open.layer) = (step.path as u32, layer);
            open.filament_mm += filament_mm;
            return None;
        }
        let prime_mm = std::mem::take(&mut self.prime_mm);
        let path = step.path as u32;
        let begun = Segment { layer, path, kind, start, lines: vec![line], filament_mm, prime_mm, retract_mm: 0.0 };
        self.open.replace(begun)
    }
}

impl Iterator for Segments<'_> {
    type Item = Segment;

    fn next(&mut self) -> Option<Segment> {
        while let Some(step) = self.moves.next() {
            match step.kind {
                MoveKind::Retract => match &mut self.open {
                    Some(open) if self.prime_mm.abs() <= 0.0 => open.retract_mm -= step.filament,
                    _ => self.prime_mm += step.filament,
                },
                MoveKind::Prime => self.prime_mm += step.filament,
                _ => {
                    if let Some(done) = self.go(step) {
                        return Some(done);
                    }
                }
            }
        }
        // Filament behind the last segment is drawn back from it.
        let mut last = self.open.take()?;
        last.retract_mm -= std::mem::take(&mut self.prime_mm);
        Some(last)
    }
}
