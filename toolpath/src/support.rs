//! Which beads lie on something: a check of paths as they are laid.
//!
//! Takes tool paths, in the order in which they are laid; gives a [`BeadSupport`] ([`check_support`]).
//!
//! Dai 2020, section 3.2, asks that material is laid on what is there. Growing proves that for cells; what becomes of cells as
//! beads is another matter. So this check takes the paths that are extruded, and nothing else: it shares no code with what plans
//! them, and knows neither surfaces nor fields.
//!
//! Beads are bodies as `beads` has them. A place of a bead is
//! *supported* if the plate z = 0 is near its middle, or a point of the mould that lies below and faces the nozzle, or the core of a bead that
//!
//! * was laid before, on another layer (neighbours in the same layer hold it aside, not up), and
//! * lies below: nearer to the plate, or whatever the nozzle points at, by a share of a layer height along the direction of the nozzle.
//!
//! A place that is not supported is part of a *span* if what is laid there is a straight line between two places that are: the bead is
//! drawn tight from one to the other, as a slicer's bridges are. Every other piece lies on nothing.
//!
//! Distances are to the place of the centre line that is nearest:
//! exact for beads no wider than high, and for wider ones where their centre line is upright to their nozzle. Places are looked at one by
//! one, a small step apart, each for the piece of bead around it: the end of an unsupported piece is within half a step of where
//! it is found, unless it is shorter than a step.
//!
//! Segments stand in a grid of cells about as wide as the greatest distance, so time is near linear in the length of the paths.

use crate::ProgressFn;
use crate::beads::{BeadGrid, Section, middles, nearest_share};
use crate::layer::{Mould, MouldError, MouldSurface};
use crate::orientation::{ToolPath, Waypoint};
use crate::parallel;
use nalgebra::{Point3, Vector3};

/// Coordinates and sizes beyond this, in millimetres, are refused: numbers of cells stay exact.
const MAX_COORDINATE_MM: f64 = 1e7;

/// A bead lies on a mould that faces its nozzle by 60 degrees: the cosine. A wall beside it does not carry it.
const FACING: f64 = 0.5;

/// What is farther away by this share is too far, however distances are rounded.
const ROUNDING: f64 = 1e-9;

/// More places than this are refused: the step is a slip of the unit.
const MAX_PLACES: f64 = 1e9;

/// What counts as support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportOptions {
    /// How far the middle of a bead may be from what carries it, in layer heights: 1.5.
    pub max_distance: f64,
    /// How far below it that has to be, along the direction of the nozzle, in layer heights: a quarter. Beads of squeezed layers lie
    /// nearer, on what is below those.
    pub min_drop: f64,
    /// How far apart places are that are looked at, in layer heights: a tenth.
    pub step: f64,
    /// Whether there is a plate at z = 0: yes.
    pub plate: bool,
    /// How far the bead has to lie on something before and after a span, in its widths: 1. Infinite for no spans.
    pub span_hold: f64,
    /// How far a span may leave the straight line between its ends, in its widths: a half.
    pub span_bend: f64,
}

impl Default for SupportOptions {
    fn default() -> Self {
        SupportOptions { max_distance: 1.5, min_drop: 0.25, step: 0.1, plate: true, span_hold: 1.0, span_bend: 0.5 }
    }
}

/// A piece of a bead under which there is nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnsupportedPiece {
    /// The path, by its place in the list of paths.
    pub path: usize,
    /// Where it begins and ends, by length along the curve as the waypoints have it, in millimetres. On a closed path it may go on beyond
    /// the end, from the start.
    pub arcs: [f64; 2],
    /// The tip in its middle.
    pub tip: Point3<f64>,
}

impl UnsupportedPiece {
    /// Its length in millimetres.
    pub fn length(&self) -> f64 {
        self.arcs[1] - self.arcs[0]
    }

    /// Middles of the bead along it, from end to end: where something has to be put below it.
    ///
    /// # Arguments
    /// * `paths`: those that were checked.
    /// * `step_mm`: how far apart they are at most, by length along the curve; only its ends for what is no length.
    ///
    /// # Example
    /// ```
    /// use curvlay_toolpath::nalgebra::{Point3, Vector3};
    /// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
    /// use curvlay_toolpath::path::BeadKind;
    /// use curvlay_toolpath::support::UnsupportedPiece;
    /// let at = |x| Waypoint {
    ///     position: Point3::new(x, 0.0, 5.0), axis: Vector3::z_axis(), width: 1.0, height: 1.0, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall,
    /// };
    /// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(0.0), at(30.0)] };
    /// let piece = UnsupportedPiece { path: 0, arcs: [10.0, 12.0], tip: Point3::new(11.0, 0.0, 5.0) };
    /// assert_eq!(piece.middles(&[path], 1.0), [10.0, 11.0, 12.0].map(|x| Point3::new(x, 0.0, 4.5)));
    /// ```
    pub fn middles(&self, paths: &[ToolPath], step_mm: f64) -> Vec<Point3<f64>> {
        let Some(path) = paths.get(self.path).filter(|path| path.waypoints.len() > 1) else { return Vec::new() };
        let pieces = (self.length() / step_mm).ceil();
        let pieces = if step_mm > 0.0 && pieces <= MAX_PLACES { pieces.max(1.0) } else { 1.0 };
        let middle = |k: u32| {
            let ([a, b], share) = place_at(path, self.arcs[0] + self.length() * f64::from(k) / pieces);
            Section::of(a).toward(&Section::of(b), share).middle
        };
        (0..=pieces as u32).map(middle).collect()
    }
}

/// What the check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BeadSupport {
    /// Length of all beads, in millimetres.
    pub bead_mm: f64,
    /// The pieces that lie on nothing, in the order in which they are laid.
    pub unsupported: Vec<UnsupportedPiece>,
    /// The spans, held at both ends, in the same order. They are not among the others.
    pub spans: Vec<UnsupportedPiece>,
}

impl BeadSupport {
    /// Length of all pieces that lie on nothing, in millimetres.
    pub fn unsupported_mm(&self) -> f64 {
        total(&self.unsupported)
    }

    /// The same as a share of the length of all beads; 0 if there are none.
    pub fn unsupported_share(&self) -> f64 {
        if self.bead_mm > 0.0 { self.unsupported_mm() / self.bead_mm } else { 0.0 }
    }

    /// Length of the longest piece that lies on nothing, in millimetres.
    pub fn longest_mm(&self) -> f64 {
        longest(&self.unsupported)
    }

    /// Length of all spans, in millimetres.
    pub fn span_mm(&self) -> f64 {
        total(&self.spans)
    }

    /// Length of the longest span, in millimetres.
    pub fn longest_span_mm(&self) -> f64 {
        longest(&self.spans)
    }
}

fn total(pieces: &[UnsupportedPiece]) -> f64 {
    pieces.iter().map(UnsupportedPiece::length).fold(0.0, |sum, length| sum + length) // a sum of nothing is -0.0
}

fn longest(pieces: &[UnsupportedPiece]) -> f64 {
    pieces.iter().map(UnsupportedPiece::length).fold(0.0, f64::max)
}

/// Why beads cannot be checked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SupportError {
    /// An option is out of its range.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// A path without a second waypoint.
    #[error("path {path} has {waypoints} waypoints: it needs two")]
    FewWaypoints {
        /// The path, from 0.
        path: usize,
        /// Its waypoints.
        waypoints: usize,
    },
    /// A waypoint that is not finite, beyond 1e7 mm, has no bead, or goes back along its curve.
    #[error(
        "waypoint {waypoint} of path {path} is not finite, beyond 1e7 mm, has no bead, or goes back along its curve"
    )]
    BadWaypoint {
        /// The path, from 0.
        path: usize,
        /// The waypoint, from 0.
        waypoint: usize,
    },
    /// The step is too small for the length of the paths.
    #[error("a step of {step_mm} mm takes {places:.1e} places, above the limit of 1e9")]
    TooManyPlaces {
        /// The step in millimetres.
        step_mm: f64,
        /// Places that it takes.
        places: f64,
    },
    /// The mould cannot be used.
    #[error("the mould: {0}")]
    Mould(#[from] MouldError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Checks whether beads lie on something. Sparse infill ([`BeadKind::is_sparse`](crate::path::BeadKind::is_sparse)) and what goes over it
/// ([`BeadKind::is_bridge`](crate::path::BeadKind::is_bridge)) lies on something here and there only, and is not judged.
///
/// # Arguments
/// * `paths`: in the order in which they are laid.
/// * `layer_height`: in millimetres.
/// * `progress`: called with the stage `support` after each path, from any thread; may cancel.
///
/// # Errors
/// [`SupportError`].
///
/// # Cost
/// About a microsecond for each place that is looked at. The result does not depend on the number of threads.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// use curvlay_toolpath::support::{SupportOptions, check_support};
/// use std::ops::ControlFlow;
/// // A bead of 20 mm at the top of the first layer, and one of 30 mm on it that goes on into the air.
/// let at = |x, z| Waypoint {
///     position: Point3::new(x, 0.0, z), axis: Vector3::z_axis(), width: 1.0, height: 1.0, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall,
/// };
/// let path = |layer, [from, to]: [f64; 2], z| ToolPath {
///     layer, curve: 0, closed: false, waypoints: vec![at(from, z), at(to, z)],
/// };
/// let paths = [path(0, [0.0, 20.0], 1.0), path(1, [0.0, 30.0], 2.0)];
/// // The plate is 1.5 mm below the second one.
/// let options = SupportOptions { max_distance: 1.25, ..SupportOptions::default() };
/// let support = check_support(&paths, 1.0, &options, &|_| ControlFlow::Continue(()))?;
/// // It is held a little beyond the end: 0.75 mm aside are 1.25 mm away.
/// assert!((support.unsupported_mm() - (30.0 - 20.75)).abs() < 0.1);
/// assert_eq!(support.unsupported[0].path, 1);
/// # Ok::<(), curvlay_toolpath::support::SupportError>(())
/// ```
pub fn check_support(
    paths: &[ToolPath],
    layer_height: f64,
    options: &SupportOptions,
    progress: ProgressFn,
) -> Result<BeadSupport, SupportError> {
    check_support_on(None, paths, layer_height, options, progress)
}

/// The same on a mould, or on a part that exists already.
///
/// # Arguments
/// * `mould`: its [thickness](Mould::thickness) has no part in it.
/// * all others as for [`check_support`].
///
/// # Errors
/// [`SupportError`].
///
/// # Cost
/// That of [`check_support`], and `O(n log n)` for `n` triangles.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::layer::Mould;
/// use curvlay_toolpath::orientation::{ToolPath, Waypoint};
/// use curvlay_toolpath::path::BeadKind;
/// use curvlay_toolpath::support::{SupportOptions, check_support_on_mould};
/// use std::ops::ControlFlow;
/// // A table of 20 x 20 mm at a height of 5 mm, and a bead of 1 mm that goes on beyond its edge.
/// let vertices = [[0.0, 0.0, 5.0], [20.0, 0.0, 5.0], [20.0, 20.0, 5.0], [0.0, 20.0, 5.0]].map(Point3::from);
/// let mould = Mould { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], thickness: 1.0 };
/// let at = |x| Waypoint {
///     position: Point3::new(x, 10.0, 6.0), axis: Vector3::z_axis(), width: 1.0, height: 1.0, arc: x, added: false, lift: Vector3::zeros(), kind: BeadKind::Wall,
/// };
/// let path = ToolPath { layer: 0, curve: 0, closed: false, waypoints: vec![at(2.0), at(30.0)] };
/// let support = check_support_on_mould(&[path], &mould, 1.0, &SupportOptions::default(), &|_| ControlFlow::Continue(()))?;
/// // Its middle is 0.5 mm up, so it is held until the edge is 1.5 mm away.
/// assert!((support.unsupported_mm() - (10.0 - 2_f64.sqrt())).abs() < 0.1);
/// # Ok::<(), curvlay_toolpath::support::SupportError>(())
/// ```
pub fn check_support_on_mould(
    paths: &[ToolPath],
    mould: &Mould,
    layer_height: f64,
    options: &SupportOptions,
    progress: ProgressFn,
) -> Result<BeadSupport, SupportError> {
    check_support_on(Some(MouldSurface::new(mould)?), paths, layer_height, options, progress)
}

fn check_support_on(
    mould: Option<MouldSurface>,
    paths: &[ToolPath],
    layer_height: f64,
    options: &SupportOptions,
    progress: ProgressFn,
) -> Result<BeadSupport, SupportError> {
    check(paths, layer_height, options)?;
    let laid = DepositedBeads { mould, ..DepositedBeads::new(paths, layer_height, options) };
    let of_path = |number: usize, path: &ToolPath| laid.unsupported(number, path);
    let pieces = parallel::map(paths, "support", progress, of_path).ok_or(SupportError::Cancelled)?;
    let bead_mm = paths.iter().flat_map(|path| path.waypoints.windows(2)).map(|pair| pair[1].arc - pair[0].arc);
    let bead_mm = bead_mm.fold(0.0, |sum, length| sum + length);
    let mut support = BeadSupport { bead_mm, ..BeadSupport::default() };
    for (piece, is_span) in pieces.into_iter().flatten() {
        if is_span { &mut support.spans } else { &mut support.unsupported }.push(piece);
    }
    Ok(support)
}

fn check(paths: &[ToolPath], layer_height: f64, options: &SupportOptions) -> Result<(), SupportError> {
    let &SupportOptions { max_distance, min_drop, step, span_hold, span_bend, .. } = options;
    let above_zero = [("layer_height", layer_height), ("max_distance", max_distance), ("step", step)];
    let wrong = |&(_, value): &(&str, f64)| !(value > 0.0 && value <= MAX_COORDINATE_MM);
    if let Some((option, value)) = above_zero.into_iter().find(wrong) {
        return Err(SupportError::Option { option, value, wanted: "above 0 and at most 1e7" });
    }
    if !(min_drop >= 0.0 && min_drop <= max_distance) {
        let wanted = "from 0 to max_distance";
        return Err(SupportError::Option { option: "min_drop", value: min_drop, wanted });
    }
    let not_below_zero = [("span_hold", span_hold), ("span_bend", span_bend)];
    if let Some((option, value)) = not_below_zero.into_iter().find(|&(_, value)| value.is_nan() || value < 0.0) {
        return Err(SupportError::Option { option, value, wanted: "0 or more" });
    }
    let mut length = 0.0;
    for (number, path) in paths.iter().enumerate() {
        let waypoints = &path.waypoints;
        if waypoints.len() < 2 {
            return Err(SupportError::FewWaypoints { path: number, waypoints: waypoints.len() });
        }
        let is_length = |value: f64| value > 0.0 && value <= MAX_COORDINATE_MM;
        for (k, at) in waypoints.iter().enumerate() {
            let before = waypoints[k.saturating_sub(1)].arc;
            let is_place = at.position.iter().chain(at.axis.iter()).all(|x| x.abs() <= MAX_COORDINATE_MM);
            if !(is_place
                && is_length(at.width)
                && is_length(at.height)
                && at.arc.abs() <= MAX_COORDINATE_MM
                && at.arc >= before)
            {
                return Err(SupportError::BadWaypoint { path: number, waypoint: k });
            }
        }
        let pairs = || waypoints.windows(2).map(|pair| [Section::of(&pair[0]), Section::of(&pair[1])]);
        let places = pairs().map(|[a, b]| (b.middle - a.middle).norm().max(b.arc - a.arc));
        length += places.fold(0.0, |sum, length| sum + length);
    }
    let step_mm = step * layer_height;
    // What is looked up, and what is looked at.
    let places = length / step_mm.min(0.25 * max_distance * layer_height);
    if places > MAX_PLACES {
        return Err(SupportError::TooManyPlaces { step_mm, places });
    }
    Ok(())
}

/// A piece of a bead, by its path and the waypoint that it begins at.
#[derive(Clone, Copy)]
struct Segment {
    path: u32,
    from: u32,
}

/// All beads.
struct DepositedBeads<'a> {
    paths: &'a [ToolPath],
    segments: Vec<Segment>,
    grid: BeadGrid,
    max_mm: f64,
    drop_mm: f64,
    step_mm: f64,
    plate: bool,
    mould: Option<MouldSurface>,
    span_hold: f64,
    span_bend: f64,
}

/// What was found for the place before on a path.
#[derive(Default)]
struct Looked {
    /// The segment that carries it.
    last: Option<u32>,
    /// Its cell of the grid, and the segments in and around it that may carry the path.
    cell: Option<[i64; 3]>,
    around: Vec<u32>,
}

/// What is known of a piece of a bead.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    Held,
    OnNothing,
    /// Of a kind that is not judged.
    Unknown,
}

impl<'a> DepositedBeads<'a> {
    fn new(paths: &'a [ToolPath], layer_height: f64, options: &SupportOptions) -> DepositedBeads<'a> {
        let &SupportOptions { max_distance, min_drop, step, plate, span_hold, span_bend } = options;
        let max_mm = max_distance * layer_height;
        let mut segments = Vec::new();
        for (number, path) in (0..).zip(paths) {
            segments.extend((1..path.waypoints.len() as u32).map(|to| Segment { path: number, from: to - 1 }));
        }
        let core = paths.iter().flat_map(|path| &path.waypoints).map(|at| Section::of(at).core);
        // Beads are looked up by their middle lines: from there to the edge is the core of the widest.
        let reach = max_mm + core.fold(0.0, f64::max);
        let grid = BeadGrid::new(segments.iter().map(|&segment| middles(&sections(paths, segment))), reach);
        DepositedBeads {
            paths,
            segments,
            grid,
            max_mm,
            drop_mm: min_drop * layer_height,
            step_mm: step * layer_height,
            plate,
            mould: None,
            span_hold,
            span_bend,
        }
    }

    /// Whether a segment may carry one of a path: beads of its own layer do not, they lie beside it, and later paths are not there yet.
    fn may_carry(&self, other: u32, path: u32) -> bool {
        let other = self.segments[other as usize].path;
        other < path && self.paths[other as usize].layer != self.paths[path as usize].layer
    }

    /// The unsupported pieces of a path, and whether they are spans.
    fn unsupported(&self, number: usize, path: &ToolPath) -> Vec<(UnsupportedPiece, bool)> {
        let runs = self.runs(number, path);
        let is_held = |run: Option<&(Hold, [f64; 2])>, width: f64| {
            run.is_some_and(|(hold, [from, to])| *hold == Hold::Held && to - from >= self.span_hold * width)
        };
        let mut pieces = Vec::new();
        for (k, &(hold, arcs)) in runs.iter().enumerate() {
            if hold != Hold::OnNothing || arcs[1] <= arcs[0] {
                continue;
            }
            // Runs alternate, so that before and after one on nothing there is another kind, of a closed path across its start as well.
            let (before, after) = match path.closed {
                true => (runs.get((k + runs.len() - 1) % runs.len()), runs.get((k + 1) % runs.len())),
                false => (k.checked_sub(1).and_then(|k| runs.get(k)), runs.get(k + 1)),
            };
            let width = path.waypoints[waypoint_after(path, arcs[0])].width;
            let is_span = is_held(before, width) && is_held(after, width) && bend(path, arcs) <= self.span_bend * width;
            pieces
                .push((UnsupportedPiece { path: number, arcs, tip: tip_at(path, 0.5 * (arcs[0] + arcs[1])) }, is_span));
        }
        pieces
    }

    /// The runs of a path in which all is alike, with their lengths along it. On a closed path the last one goes on into the first.
    fn runs(&self, number: usize, path: &ToolPath) -> Vec<(Hold, [f64; 2])> {
        let mut runs: Vec<(Hold, [f64; 2])> = Vec::new();
        let mut looked = Looked::default();
        for pair in path.waypoints.windows(2) {
            let [a, b] = &[Section::of(&pair[0]), Section::of(&pair[1])];
            let is_judged = !(pair[1].kind.is_sparse() || pair[1].kind.is_bridge());
            let length = (b.middle - a.middle).norm().max(b.arc - a.arc);
            // A bead that is not judged is one piece: it is neither held nor on nothing.
            let steps = if is_judged { (length / self.step_mm).ceil().max(1.0) } else { 1.0 };
            for k in 0..steps as usize {
                let hold = match is_judged {
                    false => Hold::Unknown,
                    true if self.is_supported(number as u32, &a.toward(b, (k as f64 + 0.5) / steps), &mut looked) => {
                        Hold::Held
                    }
                    true => Hold::OnNothing,
                };
                let [from, to] = [k, k + 1].map(|k| a.arc + (b.arc - a.arc) * (k as f64 / steps));
                match runs.last_mut().filter(|run| run.0 == hold) {
                    Some(run) => run.1[1] = to,
                    None => runs.push((hold, [from, to])),
                }
            }
        }
        // A run over the start of a closed path is one: its arc goes on past the end.
        if path.closed && runs.len() > 1 && runs[0].0 == runs[runs.len() - 1].0 {
            let (_, [from, to]) = runs.remove(0);
            runs.iter_mut().last().into_iter().for_each(|last| last.1[1] += to - from);
        }
        runs
    }

    fn is_supported(&self, path: u32, at: &Section, looked: &mut Looked) -> bool {
        if self.plate && at.middle.z <= self.max_mm {
            return true;
        }
        let is_below = |p: Point3<f64>, normal: Vector3<f64>| {
            normal.dot(&at.direction) >= FACING && (at.middle - p).dot(&at.direction) >= self.drop_mm
        };
        if self.mould.as_ref().is_some_and(|mould| mould.has(at.middle, self.max_mm, is_below)) {
            return true;
        }
        // What carried the place before most likely carries this one, or what lies before or behind that on its path.
        let beside = |last: u32| [Some(last), last.checked_add(1), last.checked_sub(1)].into_iter().flatten();
        let carries = |number: &u32| {
            let other = self.segments.get(*number as usize);
            other.is_some_and(|&other| self.may_carry(*number, path) && self.is_below(&sections(self.paths, other), at))
        };
        if let Some(found) = looked.last.and_then(|last| beside(last).find(carries)) {
            looked.last = Some(found);
            return true;
        }
        let cell = self.grid.cell(at.middle);
        if looked.cell != Some(cell) {
            looked.cell = Some(cell);
            looked.around.clear();
            let around = self.grid.in_and_around(cell);
            looked.around.extend(around.filter(|&other| self.may_carry(other, path)));
            // Just below come those that were laid last.
            looked.around.sort_unstable_by(|a, b| b.cmp(a));
            looked.around.dedup();
        }
        let found = looked.around.iter().copied().find(carries);
        looked.last = found.or(looked.last);
        found.is_some()
    }

    /// Whether a segment is below a place of a bead and near it.
    fn is_below(&self, ends: &[Section; 2], at: &Section) -> bool {
        let [a, b] = ends;
        // How far below the place it is, at its start and along it.
        let drops = [a, b].map(|end| (at.middle - end.middle).dot(&at.direction) - self.drop_mm);
        // A segment that leans may be far enough below along a part of it only: there its nearest point is looked for.
        let crossing = drops[0] / (drops[0] - drops[1]);
        let [low, high] = match drops.map(|drop| drop >= 0.0) {
            [true, true] => [0.0, 1.0],
            [true, false] => [0.0, crossing],
            [false, true] => [crossing, 1.0],
            [false, false] => return false,
        };
        let share = nearest_share(ends, at.middle).max(low).min(high);
        // Most are too far from the middle line to be near the core.
        let to_line = at.middle - (a.middle + (b.middle - a.middle) * share);
        let reach = (self.max_mm + a.core.max(b.core)) * (1.0 + ROUNDING);
        if to_line.norm_squared() > reach * reach {
            return false;
        }
        let [up, aside] = a.toward(b, share).off(at.middle);
        up.hypot(aside) <= self.max_mm
    }
}

/// Both ends of a segment.
fn sections(paths: &[ToolPath], segment: Segment) -> [Section; 2] {
    let waypoints = &paths[segment.path as usize].waypoints;
    [0, 1].map(|k| Section::of(&waypoints[segment.from as usize + k]))
}

/// The waypoint at the end of the segment at a length along a path.
fn waypoint_after(path: &ToolPath, arc: f64) -> usize {
    path.waypoints.partition_point(|waypoint| waypoint.arc < arc).clamp(1, path.waypoints.len() - 1)
}

/// The waypoints around a place at a length along a path, and the share of the way between them; beyond the end of a closed one from its start.
fn place_at(path: &ToolPath, arc: f64) -> ([&Waypoint; 2], f64) {
    let waypoints = &path.waypoints;
    let [first, last] = [&waypoints[0], &waypoints[waypoints.len() - 1]].map(|end| end.arc);
    let arc = if arc > last { arc - (last - first) } else { arc };
    let after = waypoint_after(path, arc);
    let [a, b] = [after - 1, after].map(|k| &waypoints[k]);
    let length = b.arc - a.arc;
    ([a, b], if length > 0.0 { ((arc - a.arc) / length).clamp(0.0, 1.0) } else { 0.0 })
}

/// The tip there.
fn tip_at(path: &ToolPath, arc: f64) -> Point3<f64> {
    let ([a, b], share) = place_at(path, arc);
    a.position + (b.position - a.position) * share
}

/// How far the tips of a piece are from the straight line between its ends, at most.
fn bend(path: &ToolPath, [from, to]: [f64; 2]) -> f64 {
    let [start, end] = [from, to].map(|arc| tip_at(path, arc));
    let (way, whole) = (end - start, path.waypoints[path.waypoints.len() - 1].arc - path.waypoints[0].arc);
    let is_within = |arc: f64| (from..=to).contains(&arc) || (from..=to).contains(&(arc + whole));
    let off_line = |tip: &Point3<f64>| {
        let share = (tip - start).dot(&way) / way.norm_squared().max(f64::MIN_POSITIVE);
        (tip - (start + way * share.clamp(0.0, 1.0))).norm()
    };
    path.waypoints.iter().filter(|at| is_within(at.arc)).map(|at| off_line(&at.position)).fold(0.0, f64::max)
}
