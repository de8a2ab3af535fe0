//! From curves to figures, stage by stage.

use super::error::StatisticsError;
use super::figures::{BeadCurve, CurveStatistics, PathStatistics, StatisticsOptions};
use super::locate::Locator;
use super::raster::Raster;
use super::sheet::Sheet;
use super::trace::Tracer;
use super::walk::Walker;
use super::{crossing, curve, fillable, gap, spill, straight};
use crate::{Progress, ProgressFn};
use nalgebra::Point3;
use std::ops::ControlFlow;

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
    progress: ProgressFn,
) -> Result<PathStatistics, StatisticsError> {
    check_options(options)?;
    curves.iter().enumerate().try_for_each(|(number, curve)| check_curve(number, curve))?;
    let sheet = Sheet::new(vertices, triangles)?;
    let step = mean_width(curves).map_or(sheet.area.sqrt() / STEPS_WITHOUT_BEADS, |w| w / options.samples_per_width);
    let raster = options.coverage.then(|| Raster::new(&sheet, step, options.max_samples)).transpose()?;
    let report =
        |stage, done: usize, total: usize| progress(Progress { stage, done: done as u64, total: total as u64 });

    let mut laid = laid(&sheet, step, curves, options, &report)?;
    let closed: Vec<bool> = laid.iter().map(|l| l.closed).collect();
    let pieces: Vec<curve::Piece> = laid.iter_mut().flat_map(|l| std::mem::take(&mut l.pieces)).collect();
    let statistics = PathStatistics { step_mm: step, ..of_curves(&sheet, curves, &laid, &pieces, &closed) };
    let Some(mut raster) = raster else { return Ok(statistics) };

    let pieces = straight::straightened(&pieces, step);
    let mut walker = Walker::new(&sheet);
    let spilled = deposited(&mut raster, &mut walker, (&laid, &pieces), step, &report)?;
    let mut tick = |done: usize, total: usize| match done % PIECES_A_TICK {
        0 => report("gap", done, total),
        _ => ControlFlow::Continue(()),
    };
    let largest_gap = gap::largest(&raster, &mut walker, &pieces, &mut tick)?;
    let out_of_reach = match 0.5 * options.min_width_mm {
        radius if radius > 0.0 => fillable::out_of_reach(&raster, &mut walker, [radius, step], &mut tick)?,
        _ => vec![false; raster.samples()],
    };
    Ok(PathStatistics {
        spill_fraction: spilled.max(0.0) / sheet.area,
        largest_gap,
        ..of_areas(&raster, &out_of_reach, statistics)
    })
}

/// Called with a stage, how much of it is done, and how much there is.
type Report<'a> = &'a dyn Fn(&'static str, usize, usize) -> ControlFlow<()>;

/// Curves as pieces that lie in a triangle each. A curve without points is kept: curves are known by their numbers.
fn laid(
    sheet: &Sheet,
    step: f64,
    curves: &[BeadCurve],
    options: &StatisticsOptions,
    report: Report,
) -> Result<Vec<curve::DepositedCurve>, StatisticsError> {
    let tracer = Tracer { locator: Locator::new(sheet), sheet, step };
    let mut laid = Vec::with_capacity(curves.len());
    for (number, curve) in curves.iter().enumerate() {
        if report("curves", number, curves.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        laid.push(match curve.points.is_empty() {
            true => curve::DepositedCurve::default(),
            false => curve::lay(&tracer, number as u32, curve, options)?,
        });
    }
    Ok(laid)
}

/// Lays all beads on the raster. Gives the area that they have beside the surface: along their sides where these cross the boundary, in the
/// fans of their ends and turns, and where they are off it altogether.
fn deposited(
    raster: &mut Raster,
    walker: &mut Walker,
    (laid, pieces): (&[curve::DepositedCurve], &[curve::Piece]),
    step: f64,
    report: Report,
) -> Result<f64, StatisticsError> {
    let sheet = raster.sheet;
    // Along a closed curve the way back to the start may be the shorter one.
    let rounds: Vec<f32> = laid.iter().map(|l| if l.closed { l.widths as f32 } else { f32::INFINITY }).collect();
    let mut spilled = 0.0;
    for (done, piece) in pieces.iter().enumerate() {
        if done % PIECES_A_TICK == 0 && report("beads", done, pieces.len()).is_break() {
            return Err(StatisticsError::Cancelled);
        }
        if raster.deposit(walker, piece, rounds[piece.curve as usize]) {
            spilled += spill::beside(sheet, piece, step);
        }
    }
    spilled += laid.iter().flat_map(|l| &l.fans).map(|fan| spill::around(sheet, fan)).sum::<f64>();
    spilled += laid.iter().map(|l| l.off_area).sum::<f64>();
    Ok(spilled)
}

/// Adds what samples say of areas: shares of the whole surface, and of what a bead can reach.
fn of_areas(raster: &Raster, out_of_reach: &[bool], of_curves: PathStatistics) -> PathStatistics {
    let sheet = raster.sheet;
    let once = raster.area(|sample| !raster.is_bare(sample));
    let twice = raster.area(|sample| raster.is_twice(sample));
    let unfillable = raster.area(|sample| out_of_reach[sample]);
    let filled = raster.area(|sample| !raster.is_bare(sample) && !out_of_reach[sample]);
    PathStatistics {
        covered_fraction: once / sheet.area,
        unfillable_fraction: (unfillable / sheet.area).min(1.0),
        filled_fraction: if unfillable < sheet.area { filled / (sheet.area - unfillable) } else { 1.0 },
        overlap_fraction: twice / sheet.area,
        samples: raster.samples(),
        ..of_curves
    }
}

/// What is known of curves without looking at areas.
fn of_curves(
    sheet: &Sheet,
    curves: &[BeadCurve],
    laid: &[curve::DepositedCurve],
    pieces: &[curve::Piece],
    closed: &[bool],
) -> PathStatistics {
    let (jumps, jump_mm) = jumps(curves);
    let each: Vec<CurveStatistics> = laid.iter().map(|l| l.statistics).collect();
    let sum = |of: fn(&curve::DepositedCurve) -> f64| laid.iter().map(of).fold(0.0, |a, b| a + b);
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
