//! How much of a design its beads cover, and how much they cover twice: counted in square cells.
//!
//! A cell is covered if its middle lies within half a width of a stroke. It is covered twice if two strokes do so, or two parts of one
//! stroke that lie farther apart along it than two of its widths: neighbouring parts of a bend are one bead.

use super::fill::Stroke;
use super::overlap::Region;

/// Cells across a bead.
const CELLS_PER_BEAD: f64 = 10.0;
/// Most cells; beyond it they become wider.
const MAX_CELLS: f64 = 4e6;
/// Widths along a stroke within which its parts are one bead.
const SAME_BEAD: f64 = 2.0;

/// How a design is covered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Edge of a cell, in millimetres.
    pub cell_mm: f64,
    /// Share of the regions' area that is covered; 0 without regions.
    pub covered: f64,
    /// Share of the regions' area that is covered more than once.
    pub overlap: f64,
    /// Area outside all regions that is covered, as a share of the regions' area.
    pub outside: f64,
}

/// Why a coverage could not be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CoverageError {
    /// A point or a width is not finite.
    #[error("a point of a region or a stroke is not finite, or the width of a stroke is not above 0")]
    NotFinite,
}

/// Counts the cells of regions that strokes cover.
///
/// # Errors
/// [`CoverageError`] for numbers that are not finite.
///
/// # Cost
/// `O(c)` for `c` cells, at most 4 million, and the cells under each stroke.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Region, Stroke, StrokeKind, coverage}, nalgebra::Point2};
/// let outer = [[0.0, 0.0], [40.0, 0.0], [40.0, 2.0], [0.0, 2.0]].map(Point2::from).to_vec();
/// let region = Region { outer, holes: vec![], contour: 0 };
/// // One bead of 1 mm along its middle.
/// let points = vec![Point2::new(0.0, 1.0), Point2::new(40.0, 1.0)];
/// let stroke = Stroke { points, closed: false, width: 1.0, kind: StrokeKind::Fill, source: 0 };
/// let found = coverage(&[region], &[stroke])?;
/// assert!((found.covered - 0.5).abs() < 0.01 && found.overlap == 0.0);
/// # Ok::<(), curvlay_toolpath::drawing::CoverageError>(())
/// ```
pub fn coverage(regions: &[Region], strokes: &[Stroke]) -> Result<Coverage, CoverageError> {
    let finite = |p: &nalgebra::Point2<f64>| p.x.is_finite() && p.y.is_finite();
    let sound = regions.iter().flat_map(Region::rings).flatten().all(finite)
        && strokes
            .iter()
            .all(|stroke| stroke.width > 0.0 && stroke.width < f64::INFINITY && stroke.points.iter().all(finite));
    if !sound {
        return Err(CoverageError::NotFinite);
    }
    let narrowest = strokes.iter().map(|stroke| stroke.width).fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut extend = |x: f64, y: f64, margin: f64| {
        (low[0], low[1]) = (low[0].min(x - margin), low[1].min(y - margin));
        (high[0], high[1]) = (high[0].max(x + margin), high[1].max(y + margin));
    };
    regions.iter().flat_map(Region::rings).flatten().for_each(|p| extend(p.x, p.y, 0.0));
    strokes.iter().for_each(|stroke| stroke.points.iter().for_each(|p| extend(p.x, p.y, 0.5 * stroke.width)));
    let [width, height] = [high[0] - low[0], high[1] - low[1]];
    if !(width > 0.0 && height > 0.0) {
        return Ok(Coverage::default());
    }
    let cell = if narrowest.is_finite() { narrowest / CELLS_PER_BEAD } else { width.max(height) / 1000.0 };
    let cell = cell.max((width * height / MAX_CELLS).sqrt()).max(width.max(height) / MAX_CELLS);
    let [columns, rows] = [width, height].map(|side| (side / cell).ceil() as usize + 1);
    let middle = |k: usize, axis: usize| low[axis] + (k as f64 + 0.5) * cell;

    let mut inside = vec![false; columns * rows];
    for region in regions {
        mark_inside(region, low, cell, columns, rows, &mut inside);
    }
    // The last stroke that covered a cell with its place along it, plus one; 0: none. Then whether it is covered twice.
    let mut last: Vec<(u32, f32)> = vec![(0, 0.0); columns * rows];
    let mut twice = vec![false; columns * rows];
    for (number, stroke) in strokes.iter().enumerate() {
        let number = number as u32 + 1;
        let half = 0.5 * stroke.width;
        let total = stroke.length();
        let back = stroke.points[..usize::from(stroke.closed).min(stroke.points.len())].iter();
        let ends = stroke.points.iter().skip(1).chain(back);
        let mut along = 0.0;
        for (a, b) in stroke.points.iter().zip(ends) {
            let edge = b - a;
            let length = edge.norm();
            let range = |from: f64, to: f64, axis: usize, most: usize| {
                let at = |x: f64| (x - low[axis]) / cell - 0.5;
                (at(from).ceil().max(0.0) as usize)..((at(to).floor() + 1.0).max(0.0) as usize).min(most)
            };
            let across = range(a.x.min(b.x) - half, a.x.max(b.x) + half, 0, columns);
            for y in range(a.y.min(b.y) - half, a.y.max(b.y) + half, 1, rows) {
                for x in across.clone() {
                    let to = nalgebra::Vector2::new(middle(x, 0) - a.x, middle(y, 1) - a.y);
                    let share = if length > 0.0 { (to.dot(&edge) / (length * length)).clamp(0.0, 1.0) } else { 0.0 };
                    if (to - edge * share).norm_squared() > half * half {
                        continue;
                    }
                    let (at, place) = (x + columns * y, along + share * length);
                    let (stroke_before, place_before) = last[at];
                    if stroke_before != 0 {
                        let apart = (place - f64::from(place_before)).abs();
                        let apart = if stroke.closed { apart.min(total - apart) } else { apart };
                        twice[at] |= stroke_before != number || apart > SAME_BEAD * stroke.width;
                    }
                    last[at] = (number, place as f32);
                }
            }
            along += length;
        }
    }
    let mut counts = [0u64; 4];
    for (at, &within) in inside.iter().enumerate() {
        let covered = last[at].0 != 0;
        counts[0] += u64::from(within);
        counts[1] += u64::from(within && covered);
        counts[2] += u64::from(within && twice[at]);
        counts[3] += u64::from(!within && covered);
    }
    let share = |count: u64| if counts[0] > 0 { count as f64 / counts[0] as f64 } else { 0.0 };
    Ok(Coverage { cell_mm: cell, covered: share(counts[1]), overlap: share(counts[2]), outside: share(counts[3]) })
}

/// Marks the cells whose middles lie in a region: by rows, between pairs of crossings. An edge meets a row if one of its ends lies
/// at or below it and the other above.
fn mark_inside(region: &Region, low: [f64; 2], cell: f64, columns: usize, rows: usize, inside: &mut [bool]) {
    let mut met: Vec<(usize, f64)> = Vec::new();
    let row_of = |y: f64| (((y - low[1]) / cell - 0.5).ceil().max(0.0) as usize).min(rows);
    for ring in region.rings() {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            for row in row_of(a.y.min(b.y))..row_of(a.y.max(b.y)) {
                let y = low[1] + (row as f64 + 0.5) * cell;
                met.push((row, a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))));
            }
        }
    }
    met.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let column_of = |x: f64| (((x - low[0]) / cell - 0.5).ceil().max(0.0) as usize).min(columns);
    for pair in met.chunks(2) {
        if let [(row, from), (_, to)] = *pair {
            inside[columns * row + column_of(from)..columns * row + column_of(to)].fill(true);
        }
    }
}
