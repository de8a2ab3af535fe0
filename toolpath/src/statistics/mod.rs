//! How well beads cover a surface: figures that judge tool paths without knowing how they were made.
//!
//! Takes a mesh and curves with widths, as plain points; gives [`PathStatistics`].
//!
//! Dai 2020, section 3.6.3, reports the covered share of curved layers; here it comes with what else makes a path good
//! or bad. Nothing is shared with the generators of paths or the geodesic distance but the types of `nalgebra`: not the
//! mesh, not the distance, not the unfolding. A bead is the union of all discs on the surface around points of its
//! curve, half the width in radius. It is laid down on a raster of samples, finer than a tenth of a bead.
//!
//! * `sheet`: triangles laid flat, and how one continues in the next. `locate`: nearest points.
//! * `trace`: curves laid on the surface, in pieces of one triangle each. `curve`: lengths and turns. `straight`: fewer pieces.
//! * `walk`: a piece seen from the triangles around it. `raster`: samples, and what covers them.
//! * `gap`: the largest bare disc. `fillable`: what no bead could cover. `spill`: what lies past the boundary. `crossing`: curves that meet.
//!
//! Beads cover only what is connected with them over the surface, so sheets that fold over each other in space stay
//! apart. Distances are straight lines over unfolded triangles: exact on planes and whatever unrolls into them. Where a
//! surface bends both ways they err with the curvature that a bead spans, which is little; a bare region much wider than
//! the triangles may span much, and the radius of its disc is then only an estimate.
//! Covered and overlapping shares converge with the step of the raster; a share of a region with a smooth outline of
//! length `l` is off by less than `l * step` and by far less on average.

mod and;
mod crossing;
mod curve;
mod fillable;
mod gap;
mod locate;
mod raster;
mod sheet;
mod spill;
mod straight;
mod trace;
mod walk;

use crate::Progress;
use locate::Locator;
use nalgebra::Point3;
use raster::Raster;
use sheet::Sheet;
use std::ops::ControlFlow;
use trace::Tracer;
use walk::Walker;

/// A bead along a curve: a polyline on the surface and how wide the bead is.
///
/// Equal first and last points (of three or more) make a closed curve. One point is a round dot; a curve without points
/// is not there.
#[derive(Clone, Copy, Debug)]
pub struct BeadCurve<'a> {
    /// Points in order, in millimetres, within half a width of the surface.
    pub points: &'a [Point3<f64>],
    /// Width at each point, in millimetres; between points it goes evenly from one to the next.
    pub widths: &'a [f64],
}

/// How finely to look, and for what.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct StatisticsOptions {
    /// Samples across a bead of mean width (by length): 14. So beads of three quarters of it still have ten.
    pub samples_per_width: f64,
    /// The samples that may be used; one takes some 16 bytes. 2^26.
    pub max_samples: usize,
    /// Direction changes by more than this within a quarter of the width are sharp turns: 60 degrees, in radians.
    pub sharp_turn: f64,
    /// The least width of a bead that is admissible, in millimetres: what none of this width can cover counts as
    /// unfillable. Zero, so that nothing does.
    pub min_width_mm: f64,
    /// Whether to look at areas: yes. Else only lengths, turns and crossings are found: the shares of what is
    /// covered, covered twice, spilled, unfillable and filled are 0, there is no largest gap, and there are no samples.
    pub coverage: bool,
    /// `in_width_range` counts widths from the first to the second; in millimetres, all of them.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite::pair"))]
    pub width_range_mm: [f64; 2],
}

impl Default for StatisticsOptions {
    fn default() -> Self {
        StatisticsOptions {
            samples_per_width: 14.0,
            max_samples: 1 << 26,
            sharp_turn: std::f64::consts::FRAC_PI_3,
            min_width_mm: 0.0,
            coverage: true,
            width_range_mm: [0.0, f64::INFINITY],
        }
    }
}

/// The largest disc on the surface that touches neither a bead nor crosses the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gap {
    /// Its radius: half the width of the gap; two steps of the raster too small at most. Infinite on a closed surface without beads.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub radius_mm: f64,
    /// Its centre.
    pub at: Point3<f64>,
}

/// Figures of one curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveStatistics {
    /// Length of the polyline.
    pub length_mm: f64,
    /// Distance in space from its first point to its last.
    pub entry_exit_mm: f64,
    /// Whether it is closed.
    pub closed: bool,
    /// Places where its direction on the surface changes by more than the limit within a quarter of the width.
    pub sharp_turns: usize,
    /// Length of what lies off the surface: chords over notches of the boundary.
    pub off_surface_mm: f64,
}

/// Figures of beads on a surface. Shares are of the area of the surface unless they say otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathStatistics {
    /// Area of the surface.
    pub area_mm2: f64,
    /// Share covered by a bead.
    pub covered_fraction: f64,
    /// Share covered by two curves, or by two arcs of one that are more than two widths apart along it.
    pub overlap_fraction: f64,
    /// Area of beads past the boundary, each bead counted by itself, as a share of the area of the surface.
    pub spill_fraction: f64,
    /// Share that no disc of the least width ([`StatisticsOptions::min_width_mm`]) covers without reaching over the
    /// boundary: what is narrower, and the tips of corners. No bead could cover it and spill nothing. The beads given have
    /// no part in it.
    pub unfillable_fraction: f64,
    /// Covered share of the rest, of what beads can fill; one if there is no rest.
    pub filled_fraction: f64,
    /// The largest gap; none if every sample is covered.
    pub largest_gap: Option<Gap>,
    /// Curves with at least one point.
    pub curves: usize,
    /// Steps from the end of a curve to the start of the next that is elsewhere.
    pub jumps: usize,
    /// Their length, straight through space.
    pub jump_mm: f64,
    /// Length of all curves.
    pub path_mm: f64,
    /// Length times width of all curves.
    pub bead_area_mm2: f64,
    /// Share of this whose width lies in the range asked for; zero without beads.
    pub in_width_range: f64,
    /// Sharp turns of all curves.
    pub sharp_turns: usize,
    /// Places where curves cross or touch themselves or each other. Ends may touch ends.
    pub self_crossings: usize,
    /// The largest distance from entry to exit of a curve.
    pub entry_exit_mm: f64,
    /// Length of path off the surface. Its bead counts as spilled.
    pub off_surface_mm: f64,
    /// Step of the raster.
    pub step_mm: f64,
    /// Samples of the raster.
    pub samples: usize,
    /// Figures of each curve given, zeros for one without points.
    pub each: Vec<CurveStatistics>,
}

/// Why there are no figures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StatisticsError {
    /// There is no triangle, or none has an area.
    #[error("the surface has no area")]
    NoArea,
    /// Triangles are counted in 32 bits.
    #[error("{triangles} triangles over {vertices} vertices are too many: at most 2^29 each")]
    TooLarge {
        /// Triangles given.
        triangles: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A coordinate is NaN, infinite or absurd.
    #[error("vertex {vertex} has a coordinate that is not finite or beyond 1e100")]
    BadVertex {
        /// Number of the vertex.
        vertex: usize,
    },
    /// A corner names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    NoSuchVertex {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Vertices given.
        vertices: usize,
    },
    /// A triangle has a vertex twice.
    #[error("triangle {triangle} repeats a corner")]
    RepeatedCorner {
        /// Number of the triangle.
        triangle: usize,
    },
    /// More than two triangles meet in an edge, so it is not clear where a bead goes on.
    #[error("triangle {triangle} is one of more than two at the edge between vertices {from} and {to}")]
    NonManifoldEdge {
        /// One of the triangles.
        triangle: usize,
        /// One end of the edge.
        from: u32,
        /// The other end.
        to: u32,
    },
    /// A curve has more or fewer widths than points.
    #[error("curve {curve} has {points} points and {widths} widths; give one for each point")]
    WidthCount {
        /// Number of the curve.
        curve: usize,
        /// Its points.
        points: usize,
        /// Its widths.
        widths: usize,
    },
    /// A coordinate of a curve is NaN, infinite or absurd.
    #[error("point {point} of curve {curve} has a coordinate that is not finite or beyond 1e100")]
    BadPoint {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
    },
    /// A width is not a length.
    #[error("curve {curve} is {width} mm wide at point {point}; it must be above zero, at most 1e100")]
    BadWidth {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
        /// The width.
        width: f64,
    },
    /// A point of a curve does not lie on the surface.
    #[error("point {point} of curve {curve} is farther than half its width, {reach} mm, from the surface")]
    OffSurface {
        /// Number of the curve.
        curve: usize,
        /// Number of the point.
        point: usize,
        /// Half the width there, in millimetres.
        reach: f64,
    },
    /// The raster would need too many samples.
    #[error("a step of {step} mm takes about {samples} samples, above the limit of {most}: are the units right?")]
    TooFine {
        /// Step of the raster, in millimetres.
        step: f64,
        /// Samples it would take, about.
        samples: f64,
        /// The limit.
        most: usize,
    },
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
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// Without beads the raster has its step from the surface: this part of the square root of the area.
const STEPS_WITHOUT_BEADS: f64 = 256.0;

/// Pieces between two reports of progress.
const PIECES_A_TICK: usize = 1024;

/// Lays beads on a surface and measures what they cover, and how.
///
/// # Arguments
/// * `vertices`, `triangles`: the whole surface that should be covered, in millimetres: the trimmed layer, untouched.
///   Triangles without area are allowed, and so are faces turned over; three triangles at an edge are not.
/// * `curves`: in the order in which they are laid down.
/// * `progress`: called now and then with the stage; may cancel.
///
/// # Errors
/// [`StatisticsError`], for the first fault found. Without curves all figures of paths are zero.
///
/// # Cost
/// Time in proportion to the samples that beads cover, `length * width / step^2`, and to the triangles they touch;
/// searches of nearest points take `O(log n)` each for `n` triangles. Memory of 16 bytes a sample. The result is the same
/// on every run.
///
/// # Example
/// A plate of 10 mm by 1.5 mm with one bead of 1 mm along its middle, from one end to the other.
/// ```
/// use curvlay_toolpath::nalgebra::Point3;
/// use curvlay_toolpath::statistics::{BeadCurve, StatisticsOptions, path_statistics};
/// use std::ops::ControlFlow;
/// let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 1.5], [0.0, 1.5]].map(|[x, y]| Point3::new(x, y, 0.0));
/// let line = [Point3::new(0.0, 0.75, 0.0), Point3::new(10.0, 0.75, 0.0)];
/// let bead = BeadCurve { points: &line, widths: &[1.0, 1.0] };
/// let go_on = |_| ControlFlow::Continue(());
/// let found =
///     path_statistics(&corners, &[[0, 1, 2], [0, 2, 3]], &[bead], &StatisticsOptions::default(), &go_on)?;
/// assert!((found.covered_fraction - 2.0 / 3.0).abs() < 0.02);
/// // Half a disc is spilled at each end; a strip of a quarter is left on each side.
/// assert!((found.spill_fraction * 15.0 - std::f64::consts::PI / 4.0).abs() < 0.01);
/// assert!((found.largest_gap.unwrap().radius_mm - 0.125).abs() < found.step_mm);
/// assert_eq!((found.path_mm, found.overlap_fraction, found.self_crossings), (10.0, 0.0, 0));
/// # Ok::<(), curvlay_toolpath::statistics::StatisticsError>(())
/// ```
pub fn path_statistics(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    curves: &[BeadCurve<'_>],
    options: &StatisticsOptions,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<PathStatistics, StatisticsError> {
    check_options(options)?;
    curves.iter().enumerate().try_for_each(|(number, curve)| check_curve(number, curve))?;
    let sheet = Sheet::new(vertices, triangles)?;
    let step = mean_width(curves).map_or(sheet.area.sqrt() / STEPS_WITHOUT_BEADS, |w| w / options.samples_per_width);
    let raster = options.coverage.then(|| Raster::new(&sheet, step, options.max_samples)).transpose()?;
    let report =
        |stage, done: usize, total: usize| progress(Progress { stage, done: done as u64, total: total as u64 });

    let tracer = Tracer { locator: Locator::new(&sheet), sheet: &sheet, step };
    let mut laid = Vec::with_capacity(curves.len());
    for (number, curve) in curves.iter().enumerate() {
        if report("curves", number, curves.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        laid.push(match curve.points.is_empty() {
            true => curve::Laid::default(),
            false => curve::lay(&tracer, number as u32, curve, options)?,
        });
    }
    let closed: Vec<bool> = laid.iter().map(|l| l.closed).collect();
    let rounds: Vec<f32> = laid.iter().map(|l| if l.closed { l.widths as f32 } else { f32::INFINITY }).collect();
    let pieces: Vec<curve::Piece> = laid.iter_mut().flat_map(|l| std::mem::take(&mut l.pieces)).collect();

    let mut statistics = of_curves(&sheet, curves, &laid, &pieces, &closed);
    statistics.step_mm = step;
    let Some(mut raster) = raster else { return Ok(statistics) };
    let pieces = straight::straightened(&pieces, step);
    let mut walker = Walker::new(&sheet);
    let mut spilled = 0.0;
    for (done, piece) in pieces.iter().enumerate() {
        if done % PIECES_A_TICK == 0 && report("beads", done, pieces.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        if raster.deposit(&mut walker, piece, rounds[piece.curve as usize]) {
            spilled += spill::beside(&sheet, piece, step);
        }
    }
    spilled += laid.iter().flat_map(|l| &l.fans).map(|fan| spill::around(&sheet, fan)).sum::<f64>();
    spilled += laid.iter().map(|l| l.off_area).sum::<f64>();
    let mut tick = |done: usize, total: usize| match done % PIECES_A_TICK {
        0 => report("gap", done, total),
        _ => ControlFlow::Continue(()),
    };
    let largest_gap = gap::largest(&raster, &mut walker, &pieces, &mut tick)?;
    let out_of_reach = match 0.5 * options.min_width_mm {
        radius if radius > 0.0 => fillable::out_of_reach(&raster, &mut walker, [radius, step], &mut tick)?,
        _ => vec![false; raster.samples()],
    };

    let once = raster.area(|sample| !raster.is_bare(sample));
    let twice = raster.area(|sample| raster.is_twice(sample));
    let unfillable = raster.area(|sample| out_of_reach[sample]);
    let filled = raster.area(|sample| !raster.is_bare(sample) && !out_of_reach[sample]);
    Ok(PathStatistics {
        covered_fraction: once / sheet.area,
        unfillable_fraction: (unfillable / sheet.area).min(1.0),
        filled_fraction: if unfillable < sheet.area { filled / (sheet.area - unfillable) } else { 1.0 },
        overlap_fraction: twice / sheet.area,
        spill_fraction: spilled.max(0.0) / sheet.area,
        largest_gap,
        samples: raster.samples(),
        ..statistics
    })
}

/// What is known of curves without looking at areas.
fn of_curves(
    sheet: &Sheet,
    curves: &[BeadCurve],
    laid: &[curve::Laid],
    pieces: &[curve::Piece],
    closed: &[bool],
) -> PathStatistics {
    let (jumps, jump_mm) = jumps(curves);
    let each: Vec<CurveStatistics> = laid.iter().map(|l| l.statistics).collect();
    let sum = |of: fn(&curve::Laid) -> f64| laid.iter().map(of).fold(0.0, |a, b| a + b);
    let bead_area_mm2 = sum(|l| l.bead);
    PathStatistics {
        area_mm2: sheet.area,
        curves: curves.iter().filter(|c| !c.points.is_empty()).count(),
        jumps,
        jump_mm,
        path_mm: sum(|l| l.statistics.length_mm),
        bead_area_mm2,
        in_width_range: if bead_area_mm2 > 0.0 { sum(|l| l.in_range) / bead_area_mm2 } else { 0.0 },
        sharp_turns: each.iter().map(|e| e.sharp_turns).sum(),
        self_crossings: crossing::count(sheet, pieces, closed),
        entry_exit_mm: each.iter().map(|e| e.entry_exit_mm).fold(0.0, f64::max),
        off_surface_mm: sum(|l| l.statistics.off_surface_mm),
        each,
        ..PathStatistics::default()
    }
}

fn check_options(options: &StatisticsOptions) -> Result<(), StatisticsError> {
    let bad = |option, value, wanted| Err(StatisticsError::BadOption { option, value, wanted });
    if !(1.0..=1e6).contains(&options.samples_per_width) {
        return bad("samples_per_width", options.samples_per_width, "from 1 to a million");
    }
    if !(0.0..=std::f64::consts::PI).contains(&options.sharp_turn) {
        return bad("sharp_turn", options.sharp_turn, "an angle from 0 to pi");
    }
    if !(0.0..=1e100).contains(&options.min_width_mm) {
        return bad("min_width_mm", options.min_width_mm, "a length");
    }
    if let Some(&value) = options.width_range_mm.iter().find(|w| w.is_nan()) {
        return bad("width_range_mm", value, "two lengths");
    }
    Ok(())
}

fn check_curve(number: usize, curve: &BeadCurve) -> Result<(), StatisticsError> {
    let (points, widths) = (curve.points.len(), curve.widths.len());
    if points != widths {
        return Err(StatisticsError::WidthCount { curve: number, points, widths });
    }
    if let Some(point) = curve.points.iter().position(|p| !p.iter().all(|c| c.abs() <= 1e100)) {
        return Err(StatisticsError::BadPoint { curve: number, point });
    }
    if let Some(point) = curve.widths.iter().position(|&w| !(w > 0.0 && w <= 1e100)) {
        return Err(StatisticsError::BadWidth { curve: number, point, width: curve.widths[point] });
    }
    Ok(())
}

/// The mean width of all curves by their length; of their points if they have no length.
fn mean_width(curves: &[BeadCurve]) -> Option<f64> {
    let (mut area, mut length) = (0.0, 0.0);
    for curve in curves {
        for (p, w) in curve.points.windows(2).zip(curve.widths.windows(2)) {
            let run = (p[1] - p[0]).norm();
            area += run * (w[0] + w[1]) / 2.0;
            length += run;
        }
    }
    if length > 0.0 {
        return Some(area / length);
    }
    let points: usize = curves.iter().map(|c| c.widths.len()).sum();
    (points > 0).then(|| curves.iter().flat_map(|c| c.widths).sum::<f64>() / points as f64)
}

fn jumps(curves: &[BeadCurve]) -> (usize, f64) {
    let ends: Vec<_> = curves.iter().filter_map(|c| c.points.first().zip(c.points.last())).collect();
    let lengths = ends.windows(2).map(|pair| (pair[1].0 - pair[0].1).norm()).filter(|&length| length > 0.0);
    lengths.fold((0, 0.0), |(count, sum), length| (count + 1, sum + length))
}
