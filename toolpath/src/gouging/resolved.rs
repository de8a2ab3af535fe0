//! Paths along which the nozzle gouges nothing.

use super::gouge::{Gouge, LeftOut};
use super::order::Place;
use crate::orientation::{SharpTurn, ToolPath, Turns};
use nalgebra::Point3;

/// Paths along which the nozzle gouges nothing, but for what is listed.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedPaths {
    /// The paths in the order in which they are printed; with points added where neighbours would turn too far. If some were
    /// cut there are more of them than were given: parts know their layer and curve, and arcs go on from where they were cut.
    pub paths: Vec<ToolPath>,
    /// Waypoints that gouged before.
    pub gouging_before: usize,
    /// Waypoints whose direction is another now.
    pub tilted: usize,
    /// The largest tilt, in radians.
    pub max_tilt: f64,
    /// The mean tilt of those that are tilted, in radians.
    pub mean_tilt: f64,
    /// Waypoints whose tip is raised, since no tilt freed them; those on the way up or down from them not counted.
    pub lifted: usize,
    /// The farthest that one is raised, in millimetres.
    pub max_lift: f64,
    /// Waypoints that were added.
    pub added: usize,
    /// Waypoints between samples that no tilt freed and that were taken out again, those added here not counted.
    pub taken_out: usize,
    /// Paths that are printed from their end to their start, in order: fewer waypoints gouge that way.
    pub reversed: Vec<usize>,
    /// Paths that are laid before the rest of their layer, in order: beads of it would close them in. Most are pieces of a
    /// curve, cut out of it.
    pub laid_first: Vec<usize>,
    /// Waypoints that no tilt frees.
    pub left: Vec<Gouge>,
    /// Pieces of curves that are not printed, by layer, curve and place.
    pub left_out: Vec<LeftOut>,
    /// Turns along the paths now.
    pub turns: Turns,
    /// Where paths are cut, since the nozzle would turn too far from one waypoint to the next: the piece that begins there, its first
    /// waypoint, and the turn that it begins with.
    pub cut_turns: Vec<SharpTurn>,
    /// Neighbours between which the nozzle turns more sharply than it should: cut there, more than the width of the bead would be missing, and
    /// the way is free.
    pub sharp: Vec<SharpTurn>,
    /// Length of the paths that is not printed at these cuts, in millimetres: the nozzle is free nowhere between the pieces as it stands in
    /// both. Gaps no longer than the bead is wide do not count: the round ends of the beads fill them.
    pub gaps: f64,
}

impl ResolvedPaths {
    pub(super) fn none(paths: usize) -> Self {
        ResolvedPaths {
            paths: Vec::with_capacity(paths),
            gouging_before: 0,
            tilted: 0,
            max_tilt: 0.0,
            mean_tilt: 0.0,
            lifted: 0,
            max_lift: 0.0,
            added: 0,
            taken_out: 0,
            reversed: Vec::new(),
            laid_first: Vec::new(),
            left: Vec::new(),
            left_out: Vec::new(),
            turns: Turns::default(),
            cut_turns: Vec::new(),
            sharp: Vec::new(),
            gaps: 0.0,
        }
    }

    /// Takes in what came of a path. The mean tilt is their sum as yet.
    pub(super) fn take(&mut self, Place { laid, first, freed, .. }: Place) {
        self.added += freed.added;
        self.taken_out += freed.taken_out;
        for &tilt in freed.tilts.iter().filter(|&&tilt| tilt > 0.0) {
            self.tilted += 1;
            self.max_tilt = self.max_tilt.max(tilt);
            self.mean_tilt += tilt;
        }
        let lifts = freed.waypoints.iter().filter(|waypoint| !waypoint.added).map(|waypoint| waypoint.lift.norm());
        for lift in lifts.filter(|&lift| lift > 0.0) {
            self.lifted += 1;
            self.max_lift = self.max_lift.max(lift);
        }
        let (end, closed) = (freed.waypoints.len(), laid.path.closed && freed.cuts.is_empty());
        let starts = [None].into_iter().chain(freed.cuts.iter().copied().map(Some));
        let ends = freed.cuts.iter().map(|&(cut, _)| cut).chain([end]);
        for (start, end) in starts.zip(ends) {
            let (from, turn) = start.unwrap_or((0, 0.0));
            if from > 0 {
                let gap = (freed.waypoints[from].position - freed.waypoints[from - 1].position).norm();
                self.gaps += if gap > freed.waypoints[from].width { gap } else { 0.0 };
            }
            let path = self.paths.len();
            self.cut_turns.extend(start.map(|_| SharpTurn { path, waypoint: 0, angle: turn }));
            let sharp = freed.sharp.iter().filter(|(second, _)| (from..end).contains(second));
            self.sharp.extend(sharp.map(|&(second, angle)| SharpTurn { path, waypoint: second - 1 - from, angle }));
            self.reversed.extend(freed.reversed.then_some(path));
            self.laid_first.extend(first.then_some(path));
            let within = |(_, gouge): &(usize, Gouge)| (from..end).contains(&gouge.waypoint);
            let left = freed.left.iter().filter(|left| within(left));
            let mut left: Vec<Gouge> =
                left.map(|(_, gouge)| Gouge { path, waypoint: gouge.waypoint - from, ..*gouge }).collect();
            left.sort_by_key(|gouge| gouge.waypoint);
            self.left.append(&mut left);
            self.paths.push(ToolPath { waypoints: freed.waypoints[from..end].to_vec(), closed, ..laid.path });
        }
    }

    /// Where the tip is at each waypoint, path by path.
    pub fn tips(&self) -> impl Iterator<Item = &Point3<f64>> {
        self.paths.iter().flat_map(|path| &path.waypoints).map(|waypoint| &waypoint.position)
    }
}
