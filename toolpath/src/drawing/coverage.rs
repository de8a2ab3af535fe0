//! How much of a design its beads cover, and how much they cover twice: counted in square cells.
//!
//! A cell is covered if its middle lies within half a width of a stroke. It is covered twice if two strokes do so, or two parts of one
//! stroke that lie farther apart along it than two of its widths: neighbouring parts of a bend are one bead.

use super::fill::Stroke;
use super::overlap::Region;
use nalgebra::{Point2, Vector2};
use std::ops::Range;

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
    let finite = |p: &Point2<f64>| p.x.is_finite() && p.y.is_finite();
    let sound = regions.iter().flat_map(Region::rings).flatten().all(finite)
        && strokes
            .iter()
            .all(|stroke| stroke.width > 0.0 && stroke.width < f64::INFINITY && stroke.points.iter().all(finite));
    if !sound {
        return Err(CoverageError::NotFinite);
    }
    let Some(mut raster) = Raster::over(regions, strokes) else { return Ok(Coverage::default()) };
    let mut inside = vec![false; raster.last.len()];
    for region in regions {
        mark_inside(region, raster.low, raster.cell, raster.size[0], raster.size[1], &mut inside);
    }
    strokes.iter().zip(1..).for_each(|(stroke, number)| raster.lay(stroke, number));
    let count = |counts: &dyn Fn(bool, (u32, f32), bool) -> bool| {
        let cells = inside.iter().zip(&raster.last).zip(&raster.twice);
        cells.filter(|&((&within, &last), &twice)| counts(within, last, twice)).count() as f64
    };
    let all = count(&|within, _, _| within);
    let share = |count: f64| if all > 0.0 { count / all } else { 0.0 };
    Ok(Coverage {
        cell_mm: raster.cell,
        covered: share(count(&|within, last, _| within && last.0 != 0)),
        overlap: share(count(&|within, _, twice| within && twice)),
        outside: share(count(&|within, last, _| !within && last.0 != 0)),
    })
}

/// Cells over regions and strokes, and what covers each.
struct Raster {
    low: [f64; 2],
    cell: f64,
    /// Columns and rows.
    size: [usize; 2],
    /// The last stroke that covered a cell, counted from 1, and the place along it; 0: no stroke.
    last: Vec<(u32, f32)>,
    /// Whether it is covered twice.
    twice: Vec<bool>,
}

impl Raster {
    /// Nothing is covered yet. `None` if regions and strokes have no extent.
    fn over(regions: &[Region], strokes: &[Stroke]) -> Option<Raster> {
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
            return None;
        }
        let cell = if narrowest.is_finite() { narrowest / CELLS_PER_BEAD } else { width.max(height) / 1000.0 };
        let cell = cell.max((width * height / MAX_CELLS).sqrt()).max(width.max(height) / MAX_CELLS);
        let size = [width, height].map(|side| (side / cell).ceil() as usize + 1);
        let cells = size[0] * size[1];
        Some(Raster { low, cell, size, last: vec![(0, 0.0); cells], twice: vec![false; cells] })
    }

    /// Covers the cells under a stroke, segment by segment.
    fn lay(&mut self, stroke: &Stroke, number: u32) {
        let total = stroke.length();
        let back = stroke.points[..usize::from(stroke.closed).min(stroke.points.len())].iter();
        let ends = stroke.points.iter().skip(1).chain(back);
        let mut along = 0.0;
        for (a, b) in stroke.points.iter().zip(ends) {
            self.lay_segment(stroke, number, [*a, *b], [along, total]);
            along += (b - a).norm();
        }
    }

    /// Cells along an axis whose middles are between two coordinates.
    fn range(&self, from: f64, to: f64, axis: usize) -> Range<usize> {
        let at = |x: f64| (x - self.low[axis]) / self.cell - 0.5;
        (at(from).ceil().max(0.0) as usize)..((at(to).floor() + 1.0).max(0.0) as usize).min(self.size[axis])
    }

    /// Covers the cells under a segment that begins at a length along a stroke of some length. A cell is covered twice by two strokes, or by
    /// one at places that are far apart along it.
    fn lay_segment(&mut self, stroke: &Stroke, number: u32, [a, b]: [Point2<f64>; 2], [along, total]: [f64; 2]) {
        let half = 0.5 * stroke.width;
        let edge = b - a;
        let length = edge.norm();
        let middle = |k: usize, axis: usize| self.low[axis] + (k as f64 + 0.5) * self.cell;
        let across = self.range(a.x.min(b.x) - half, a.x.max(b.x) + half, 0);
        for y in self.range(a.y.min(b.y) - half, a.y.max(b.y) + half, 1) {
            for x in across.clone() {
                let to = Vector2::new(middle(x, 0) - a.x, middle(y, 1) - a.y);
                let share = if length > 0.0 { (to.dot(&edge) / (length * length)).clamp(0.0, 1.0) } else { 0.0 };
                if (to - edge * share).norm_squared() > half * half {
                    continue;
                }
                let (at, place) = (x + self.size[0] * y, along + share * length);
                let (stroke_before, place_before) = self.last[at];
                if stroke_before != 0 {
                    let apart = (place - f64::from(place_before)).abs();
                    let apart = if stroke.closed { apart.min(total - apart) } else { apart };
                    self.twice[at] |= stroke_before != number || apart > SAME_BEAD * stroke.width;
                }
                self.last[at] = (number, place as f32);
            }
        }
    }
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
