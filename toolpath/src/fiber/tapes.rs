//! Tapes from centre lines: where each begins and ends, what is left out and why, and what they cover.
//!
//! Dai 2020, section 5.3.1: tapes are pressed onto the layer along paths and cut at their ends; there the paths were drawn by hand. Here each
//! line is walked in small steps. At a step a tape may lie if
//!
//! * the line bends no tighter in the tangent plane than the steering radius: a tape that bends tighter buckles at its inner edge;
//! * both edges, half a width to the sides straight over the surface, are on the layer;
//! * at most the permitted share of the width lies on tapes that are there, itself included.
//!
//! A tape is a run of such steps; its ends are found by halving the step to where it may no longer lie. Lines that
//! are least in the way of others come first.

use super::direction::DirectionField;
use super::lines::CentreLine;
use super::measure::{TapeCover, cover};
use super::near::Layer;
use super::offsets::{OffsetError, offset_lines};
use super::station::{Station, stations};
use super::strip::{Strip, StripGrid, strips_of};
use super::stripes::{StripeError, stripes};
pub use super::tape::Tape;
use super::walk::walk;
use crate::mesh::{SurfaceMesh, SurfacePoint};
use crate::{Progress, ProgressFn};
use nalgebra::Point3;

/// What tapes are, and how they may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct TapeOptions {
    /// Width in millimetres: 5, that of the spread tow of the dissertation.
    pub width: f64,
    /// Thickness in millimetres: 0.08, as there.
    pub thickness: f64,
    /// Distance of centre lines in millimetres: 5, so that tapes lie edge to edge.
    pub spacing: f64,
    /// The least steering radius in millimetres: 50. Tighter, the inner edge buckles; what a tape takes depends on its width and its material.
    pub min_radius: f64,
    /// The least length in millimetres: 20. The head feeds and cuts no shorter piece.
    pub min_length: f64,
    /// The share of the width that may lie on other tapes: 0.1.
    pub max_overlap: f64,
    /// What is kept free before the two ends of a tape, in millimetres: 0.
    pub gap: f64,
}

impl Default for TapeOptions {
    fn default() -> Self {
        TapeOptions {
            width: 5.0,
            thickness: 0.08,
            spacing: 5.0,
            min_radius: 50.0,
            min_length: 20.0,
            max_overlap: 0.1,
            gap: 0.0,
        }
    }
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TapeError {
    /// An option makes no sense.
    #[error("option {option} is {value}: it must be {wanted}")]
    BadOption {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// A centre line has a point that is not on the layer.
    #[error(
        "point {point} of centre line {line} does not lie in its triangle of the layer, within the width of a tape"
    )]
    BadLine {
        /// Number of the line.
        line: usize,
        /// Number of the point.
        point: usize,
    },
    /// The steps along all lines would not fit into memory.
    #[error("tapes of {width} mm along {length} mm of lines are too many: are the units right?")]
    TooMany {
        /// Width of the tapes.
        width: f64,
        /// Length of all lines.
        length: f64,
    },
    /// There are no stripes.
    #[error(transparent)]
    Stripes(#[from] StripeError),
    /// There are no offsets.
    #[error(transparent)]
    Offsets(#[from] OffsetError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// What ends a tape, or keeps it from lying somewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum TapeLimit {
    /// The centre line ends: at the border, or where lines spread or close in.
    LineEnd,
    /// An edge of the tape would reach over the border.
    Border,
    /// The centre line bends tighter than the steering radius.
    Radius,
    /// Other tapes lie there.
    Overlap,
    /// What is left between other limits is shorter than the least length.
    Length,
}

/// A piece of a centre line without a tape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LeftOutTape {
    /// Number of the line.
    pub line: usize,
    /// Its middle.
    pub at: Point3<f64>,
    /// Its length in millimetres.
    pub length_mm: f64,
    /// Why.
    pub limit: TapeLimit,
}

/// Why a plan has no tape.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum EmptyPlan {
    /// There was no line.
    #[error("no line crosses the layer: it is narrower than the spacing")]
    NoLines,
    /// The layer is too short.
    #[error(
        "the longest piece of a line with room for a tape is {longest_mm:.3} mm, below the least length of {min_length} mm"
    )]
    Length {
        /// The longest piece.
        longest_mm: f64,
        /// The least length.
        min_length: f64,
    },
    /// The lines bend too tightly.
    #[error("lines bend tighter than the least steering radius of {min_radius} mm almost everywhere")]
    Radius {
        /// The radius.
        min_radius: f64,
    },
    /// The layer is too narrow.
    #[error("the layer has no room for a tape of {width} mm along its lines")]
    Border {
        /// The width.
        width: f64,
    },
}

/// Tapes on a layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TapePlan {
    /// The tapes, in the order of their lines; the first point of a closed one is also its last.
    pub tapes: Vec<Tape>,
    /// The centre line of each tape.
    pub lines: Vec<usize>,
    /// What limits each tape at its start and end.
    pub ends: Vec<[TapeLimit; 2]>,
    /// The steering radius at each point of each tape, in millimetres; infinite where it is straight.
    pub radii: Vec<Vec<f64>>,
    /// What they cover.
    pub cover: TapeCover,
    /// The least steering radius of all tapes, in millimetres; infinite if all are straight, or if there are none.
    pub min_radius_mm: f64,
    /// Pieces of lines without a tape.
    pub left_out: Vec<LeftOutTape>,
    /// Why there is no tape; `None` if there is one.
    pub empty: Option<EmptyPlan>,
}

impl TapePlan {
    /// Length of all tapes in millimetres.
    pub fn tape_mm(&self) -> f64 {
        self.tapes.iter().map(Tape::length).fold(0.0, |sum, length| sum + length)
    }

    /// How often the cutter cuts: once at the end of each tape.
    pub fn cuts(&self) -> usize {
        self.tapes.len()
    }
}

/// An edge of a tape may be over the border by this share of the width: what smoothing and rounding move.
const BORDER_TOLERANCE: f64 = 0.02;

/// Steps of a line over the width of a tape.
const STEPS_A_WIDTH: f64 = 2.0;

/// Places over the width of a tape that are looked at for overlap.
const PLACES_ACROSS: usize = 20;

/// Places of one tape that are closer than this along it do not overlap, in widths.
const OWN_WIDTHS: f64 = 2.0;

/// Halvings of a step to find an end.
const HALVINGS: usize = 6;

/// Steps along all lines that fit into memory.
const MAX_STEPS: f64 = 1e7;

/// Lays tapes along a field of directions: [`stripes`] of the wanted spacing, and [`plan_tapes`] along them.
///
/// # Errors
/// [`TapeError`].
///
/// # Cost
/// That of both.
///
/// # Example
/// ```
/// use curvlay_toolpath::nalgebra::{Point3, Vector3};
/// use curvlay_toolpath::fiber::direction::DirectionField;
/// use curvlay_toolpath::fiber::tapes::{TapeOptions, lay_tapes};
/// use curvlay_toolpath::mesh::SurfaceMesh;
/// use std::ops::ControlFlow;
/// let corners = [[0.0, 0.0], [60.0, 0.0], [60.0, 10.0], [0.0, 10.0]].map(|[x, y]| Point3::new(x, y, 0.0));
/// let bar = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
/// let field = DirectionField::from_fn(&bar, |_| Vector3::x())?;
/// let plan = lay_tapes(&field, &TapeOptions::default(), &|_| ControlFlow::Continue(()))?;
/// assert_eq!(plan.tapes.len(), 2);
/// assert!((plan.tape_mm() - 120.0).abs() < 0.1 && plan.cover.covered_fraction > 0.99);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn lay_tapes(field: &DirectionField, options: &TapeOptions, progress: ProgressFn) -> Result<TapePlan, TapeError> {
    check(options)?;
    let found = stripes(field, options.spacing, progress)?;
    plan_tapes(field.mesh(), &found.lines, options, progress)
}

/// Lays tapes along guide curves and their geodesic offsets: [`offset_lines`] of the wanted spacing, and [`plan_tapes`] along them.
///
/// # Errors
/// [`TapeError`].
///
/// # Cost
/// That of both.
pub fn lay_tapes_along(
    mesh: &SurfaceMesh,
    guides: &[Vec<Point3<f64>>],
    options: &TapeOptions,
    progress: ProgressFn,
) -> Result<TapePlan, TapeError> {
    check(options)?;
    let lines = offset_lines(mesh, guides, options.spacing, options.width, progress)?;
    plan_tapes(mesh, &lines, options, progress)
}

/// Lays tapes along centre lines.
///
/// # Arguments
/// * `lines`: on the layer. `options.spacing` plays no part here.
/// * `progress`: called now and then; may cancel.
///
/// # Returns
/// The plan. A plan without tapes says why in [`TapePlan::empty`].
///
/// # Errors
/// [`TapeError`], for the first fault found.
///
/// # Cost
/// `O(m log n)` for lines of `m` half widths on a layer of `n` triangles, and 64 samples a square of the width. The result does not depend on the
/// number of threads.
pub fn plan_tapes(
    mesh: &SurfaceMesh,
    lines: &[CentreLine],
    options: &TapeOptions,
    progress: ProgressFn,
) -> Result<TapePlan, TapeError> {
    check(options)?;
    let layer = Layer::new(mesh);
    let step = options.width / STEPS_A_WIDTH;
    let length: f64 = lines.iter().map(CentreLine::length).sum();
    check_lines(mesh, lines, options.width)?;
    if length / step > MAX_STEPS {
        return Err(TapeError::TooMany { width: options.width, length });
    }
    let along = crate::parallel::map(lines, "lines", progress, |_, line| {
        let stations = stations(&layer, line, step, options.width, options.min_radius);
        let limits = stations.iter().map(|station| by_itself(mesh, station, options)).collect();
        Walked { stations, limits, closed: line.closed }
    });
    let along = along.ok_or(TapeError::Cancelled)?;
    let order = order(&along, options, progress)?;
    let mut planner = Planner {
        layer: &layer,
        options,
        grid: StripGrid::new(options.width, step),
        tapes: Vec::new(),
        left_out: Vec::new(),
    };
    for (done, &line) in order.iter().enumerate() {
        let tick = Progress { stage: "tapes", done: done as u64, total: order.len() as u64 };
        if progress(tick).is_break() {
            return Err(TapeError::Cancelled);
        }
        planner.lay(line, &along[line]);
    }
    let Planner { mut tapes, mut left_out, .. } = planner;
    tapes.sort_by_key(|tape| tape.line); // keeps the order along a line
    left_out.sort_by_key(|piece| piece.line);
    let mut plan = TapePlan { min_radius_mm: f64::INFINITY, ..TapePlan::default() };
    for laid in tapes {
        plan.radii.push(laid.stations.iter().map(|s| s.radius).collect());
        plan.tapes.push(Tape {
            points: laid.stations.iter().map(|s| s.at.position).collect(),
            normals: laid.stations.iter().map(|s| s.normal).collect(),
            width: options.width,
            thickness: options.thickness,
        });
        plan.lines.push(laid.line);
        plan.ends.push(laid.ends);
    }
    plan.min_radius_mm = plan.radii.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    plan.cover = cover(mesh, &plan.tapes, progress).ok_or(TapeError::Cancelled)?;
    plan.empty = plan.tapes.is_empty().then(|| why_empty(&left_out, options));
    plan.left_out = left_out;
    Ok(plan)
}

/// A line as stations, and what keeps a tape from each of them, whatever else is laid.
struct Walked {
    stations: Vec<Station>,
    limits: Vec<Option<TapeLimit>>,
    closed: bool,
}

/// A tape as stations.
struct PlacedTape {
    line: usize,
    stations: Vec<Station>,
    ends: [TapeLimit; 2],
}

/// The order in which lines are laid: those first of which others would keep the smallest share from lying, then those with the most room. So what
/// ends in between is cut and not what goes through.
fn order(along: &[Walked], options: &TapeOptions, progress: ProgressFn) -> Result<Vec<usize>, TapeError> {
    let mut all = StripGrid::new(options.width, options.width / STEPS_A_WIDTH);
    for (line, walked) in along.iter().enumerate() {
        for [first, last] in runs(&walked.limits) {
            strips(&walked.stations[first..=last], options.width, line as u32)
                .into_iter()
                .for_each(|strip| all.add(strip));
        }
    }
    let lines: Vec<u32> = (0..along.len() as u32).collect();
    let keys = crate::parallel::map(&lines, "order", progress, |_, &line| {
        let walked = &along[line as usize];
        let free = walked.stations.iter().zip(&walked.limits).filter(|(_, limit)| limit.is_none());
        let (mut room, mut taken) = (0usize, 0.0);
        for (station, _) in free {
            room += 1;
            let over = |place: Point3<f64>| all.over(place, &station.normal).any(|(strip, _)| strip.tape != line);
            let share = covered(station, options.width, over);
            taken += if share > options.max_overlap { share } else { 0.0 };
        }
        (if room > 0 { taken / room as f64 } else { 0.0 }, room)
    });
    let keys = keys.ok_or(TapeError::Cancelled)?;
    let mut order: Vec<usize> = (0..along.len()).collect();
    order.sort_by(|&a, &b| keys[a].0.total_cmp(&keys[b].0).then(keys[b].1.cmp(&keys[a].1)));
    Ok(order)
}

/// The strips of a run of stations.
fn strips(stations: &[Station], width: f64, tape: u32) -> Vec<Strip> {
    let (points, normals): (Vec<_>, Vec<_>) = stations.iter().map(|s| (s.at.position, s.normal)).unzip();
    strips_of(&points, &normals, width, tape)
}

struct Planner<'a> {
    layer: &'a Layer<'a>,
    options: &'a TapeOptions,
    /// The tapes laid so far.
    grid: StripGrid,
    tapes: Vec<PlacedTape>,
    left_out: Vec<LeftOutTape>,
}

/// Why a tape may not lie at a station, whatever else is laid.
fn by_itself(mesh: &SurfaceMesh, station: &Station, options: &TapeOptions) -> Option<TapeLimit> {
    if station.radius < options.min_radius {
        return Some(TapeLimit::Radius);
    }
    let half = options.width / 2.0;
    let side = station.normal.cross(&station.along);
    let wanted = half - BORDER_TOLERANCE * options.width;
    let on_layer = |side| walk(mesh, &station.at, side, half, |_, _| {}).is_some_and(|to| to.length >= wanted);
    if on_layer(side) && on_layer(-side) { None } else { Some(TapeLimit::Border) }
}

impl Planner<'_> {
    /// Lays the tapes of a line.
    fn lay(&mut self, line: usize, walked: &Walked) {
        let mut limits = self.limits(walked);
        for [first, last] in runs(&limits) {
            let end_of =
                |k: Option<usize>| k.and_then(|k| limits.get(k).copied().flatten()).unwrap_or(TapeLimit::LineEnd);
            let ends = [end_of(first.checked_sub(1)), end_of(Some(last + 1))];
            let stations = self.cut(&walked.stations, [first, last]);
            let length = |s: &[Station]| s.last().zip(s.first()).map_or(0.0, |(last, first)| last.arc - first.arc);
            if stations.len() < 2 || length(&stations) < self.options.min_length {
                limits[first..=last].fill(Some(TapeLimit::Length));
                continue;
            }
            let strips = strips(&stations, self.options.width, self.tapes.len() as u32);
            strips.into_iter().for_each(|strip| self.grid.add(strip));
            self.tapes.push(PlacedTape { line, stations, ends });
        }
        self.leave_out(line, walked, &limits);
    }

    /// What keeps a tape from each station.
    fn limits(&self, walked: &Walked) -> Vec<Option<TapeLimit>> {
        let mut limits = walked.limits.clone();
        let mut own = StripGrid::new(self.options.width, self.options.width / STEPS_A_WIDTH);
        let length = walked.stations.last().map_or(0.0, |last| last.arc);
        let apart = |one: f64, other: f64| {
            let apart = (one - other).abs();
            let apart = if walked.closed { apart.min(length - apart) } else { apart };
            apart > OWN_WIDTHS * self.options.width
        };
        for k in 0..limits.len() {
            let station = &walked.stations[k];
            if limits[k].is_none() {
                let over = |place: Point3<f64>| {
                    let normal = station.normal.into_inner();
                    self.grid.over(place, &normal).next().is_some()
                        || own.over(place, &normal).any(|(strip, _)| apart(strip.arc, station.arc))
                };
                if covered(station, self.options.width, over) > self.options.max_overlap {
                    limits[k] = Some(TapeLimit::Overlap);
                }
            }
            if k > 0 && limits[k].is_none() && limits[k - 1].is_none() {
                let before = &walked.stations[k - 1];
                let normal = before.normal.into_inner() + station.normal.into_inner();
                let ends = [before.at.position, station.at.position];
                Strip::new(ends, normal, self.options.width, 0, before.arc)
                    .into_iter()
                    .for_each(|strip| own.add(strip));
            }
        }
        limits
    }

    /// Whether a tape may lie at a station beside those that are laid.
    fn allows(&self, station: &Station) -> bool {
        let over = |place| self.grid.over(place, &station.normal).next().is_some();
        by_itself(self.layer.mesh, station, self.options).is_none()
            && covered(station, self.options.width, over) <= self.options.max_overlap
    }

    /// The stations of a run, with its ends where it may lie no longer, less the gap.
    fn cut(&self, stations: &[Station], [first, last]: [usize; 2]) -> Vec<Station> {
        let mut run = Vec::with_capacity(last - first + 3);
        run.extend(first.checked_sub(1).and_then(|before| self.halve(&stations[first], &stations[before])));
        run.extend_from_slice(&stations[first..=last]);
        run.extend(stations.get(last + 1).and_then(|after| self.halve(&stations[last], after)));
        if self.options.gap > 0.0 {
            let [from, to] = [run[0].arc + self.options.gap, run[run.len() - 1].arc - self.options.gap];
            let ends = [from, to].map(|arc| self.at_arc(&run, arc));
            run.retain(|station| station.arc > from && station.arc < to);
            if from < to {
                run.insert(0, ends[0]);
                run.push(ends[1]);
            }
        }
        run
    }

    /// The station at a length along a run.
    fn at_arc(&self, run: &[Station], arc: f64) -> Station {
        let k = run.partition_point(|station| station.arc < arc).clamp(1, run.len() - 1);
        let size = run[k].arc - run[k - 1].arc;
        let share = if size > 0.0 { ((arc - run[k - 1].arc) / size).clamp(0.0, 1.0) } else { 0.0 };
        self.between(&run[k - 1], &run[k], share)
    }

    /// A station between two neighbours.
    fn between(&self, from: &Station, to: &Station, share: f64) -> Station {
        let place = from.at.position + (to.at.position - from.at.position) * share;
        let at = self.layer.nearest(place, f64::INFINITY).unwrap_or(from.at);
        let mix = |a: f64, b: f64| a + (b - a) * share;
        Station {
            at,
            normal: self.layer.normal(&at),
            along: (from.along * (1.0 - share) + to.along * share).try_normalize(0.0).unwrap_or(from.along),
            arc: mix(from.arc, to.arc),
            radius: from.radius.min(to.radius),
        }
    }

    /// The last station between one that is allowed and one that is not; `None` if none is.
    fn halve(&self, good: &Station, bad: &Station) -> Option<Station> {
        let (mut low, mut high, mut found) = (0.0, 1.0, None);
        if bad.radius < self.options.min_radius {
            return None; // in between, too, it is as tight as that
        }
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            let station = self.between(good, bad, share);
            if self.allows(&station) {
                (low, found) = (share, Some(station));
            } else {
                high = share;
            }
        }
        found
    }

    /// Notes the pieces of a line without a tape.
    fn leave_out(&mut self, line: usize, walked: &Walked, limits: &[Option<TapeLimit>]) {
        let stations = &walked.stations;
        let mut first = 0;
        while first < limits.len() {
            let last = (first..limits.len()).take_while(|&k| limits[k] == limits[first]).last().unwrap_or(first);
            if let Some(limit) = limits[first] {
                // Between stations a piece reaches half a step.
                let middle = |one: usize, other: usize| 0.5 * (stations[one].arc + stations[other].arc);
                let from = middle(first.saturating_sub(1), first);
                let to = middle(last, (last + 1).min(stations.len() - 1));
                let at = stations[(first + last) / 2].at.position;
                self.left_out.push(LeftOutTape { line, at, length_mm: to - from, limit });
            }
            first = last + 1;
        }
    }
}

/// The share of the width at a station for which `over` holds.
fn covered(station: &Station, width: f64, over: impl Fn(Point3<f64>) -> bool) -> f64 {
    let side = station.normal.cross(&station.along) * width;
    let place = |k: usize| station.at.position + side * ((k as f64 + 0.5) / PLACES_ACROSS as f64 - 0.5);
    (0..PLACES_ACROSS).filter(|&k| over(place(k))).count() as f64 / PLACES_ACROSS as f64
}

/// The first and last of each run of stations without a limit.
fn runs(limits: &[Option<TapeLimit>]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for k in (0..limits.len()).filter(|&k| limits[k].is_none()) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == k => run[1] = k,
            _ => runs.push([k, k]),
        }
    }
    runs
}

/// What leaves out most, by length.
fn why_empty(left_out: &[LeftOutTape], options: &TapeOptions) -> EmptyPlan {
    let of = |limit| left_out.iter().filter(move |piece| piece.limit == limit);
    let length = |limit| of(limit).map(|piece| piece.length_mm).fold(0.0, |sum, length| sum + length);
    let [border, radius] = [length(TapeLimit::Border), length(TapeLimit::Radius)];
    if left_out.is_empty() {
        EmptyPlan::NoLines
    } else if of(TapeLimit::Length).next().is_some() && length(TapeLimit::Length) >= border.max(radius) {
        let longest_mm = of(TapeLimit::Length).map(|piece| piece.length_mm).fold(0.0, f64::max);
        EmptyPlan::Length { longest_mm, min_length: options.min_length }
    } else if radius >= border {
        EmptyPlan::Radius { min_radius: options.min_radius }
    } else {
        EmptyPlan::Border { width: options.width }
    }
}

fn check(options: &TapeOptions) -> Result<(), TapeError> {
    let lengths = [
        ("width", options.width, false),
        ("thickness", options.thickness, false),
        ("spacing", options.spacing, false),
        ("min_radius", options.min_radius, true),
        ("min_length", options.min_length, true),
        ("gap", options.gap, true),
    ];
    for (option, value, or_zero) in lengths {
        let wanted = if or_zero { "a length, not below zero" } else { "a length above zero" };
        if !(0.0..=1e100).contains(&value) || (value <= 0.0 && !or_zero) {
            return Err(TapeError::BadOption { option, value, wanted });
        }
    }
    match (0.0..=1.0).contains(&options.max_overlap) {
        true => Ok(()),
        false => Err(TapeError::BadOption {
            option: "max_overlap",
            value: options.max_overlap,
            wanted: "a share from 0 to 1",
        }),
    }
}

fn check_lines(mesh: &SurfaceMesh, lines: &[CentreLine], reach: f64) -> Result<(), TapeError> {
    for (line, CentreLine { points, .. }) in lines.iter().enumerate() {
        let on_layer = |p: &SurfacePoint| {
            let there = (p.triangle as usize) < mesh.triangles().len();
            there && (mesh.point(p.triangle, p.barycentric) - p.position).norm() <= reach
        };
        if let Some(point) = points.iter().position(|p| !on_layer(p)) {
            return Err(TapeError::BadLine { line, point });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// A quarter of the way from a station that looks along x to one that looks along y.
    #[test]
    fn between_two_stations_all_goes_by_share() {
        let corners = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]].map(|[x, y]| Point3::new(x, y, 0.0));
        let mesh = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let (layer, options) = (Layer::new(&mesh), TapeOptions::default());
        let grid = StripGrid::new(options.width, options.width);
        let planner = Planner { layer: &layer, options: &options, grid, tapes: Vec::new(), left_out: Vec::new() };
        let station = |x: f64, along: Vector3<f64>, radius: f64| {
            let at = layer.nearest(Point3::new(x, 1.0, 0.0), f64::INFINITY).unwrap();
            Station { at, normal: layer.normal(&at), along, arc: 10.0 * x, radius }
        };
        let (from, to) = (station(1.0, Vector3::x(), 40.0), station(2.0, Vector3::y(), 30.0));
        let found = planner.between(&from, &to, 0.25);
        assert!((found.at.position - Point3::new(1.25, 1.0, 0.0)).norm() < 1e-12, "{:?}", found.at);
        assert!((found.along - Vector3::new(0.75, 0.25, 0.0).normalize()).norm() < 1e-12, "{}", found.along);
        assert!((found.arc - 12.5).abs() < 1e-12 && found.radius <= 30.0);
    }
}
