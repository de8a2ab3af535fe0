//! Regions filled with beads: Brooks, section 4.10, and what section 4.17.2 asks for.
//!
//! The thesis prints over the outline and comes out 3.1 times too wide (section 6.4.2). Here the outermost bead lies within it
//! ([`ContourAt::Inside`]). Beads of a region share a width, near the wanted one, such that a whole number of them reaches its
//! middle: of a ribbon 4.2 mm wide and a bead of 1.5 mm that are two to each side, 1.05 mm wide.
//!
//! * [`Fill::Lines`]: scan lines, joined to zigzags along the boundary (`lines`).
//! * [`Fill::Concentric`]: the outline moved inwards again and again.
//! * [`Fill::Spiral`]: the same loops, joined by bridges into one closed curve a region (`spiral`), so that the nozzle starts and
//!   stops once.

mod inradius;
mod lines;
mod options;
mod spiral;

pub use options::{ContourAt, Fill, FillOptions};

use super::overlap::Region;
use super::polygon::{Ring, Shape, inset, simplified, to_points};
use super::{Contour, MAX_COORDINATE_MM};
use nalgebra::Point2;

/// What a stroke is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrokeKind {
    /// The outline of a region.
    Outline,
    /// Its fill; a spiral is fill, its outermost loop included.
    Fill,
    /// An open contour.
    Open,
}

/// A bead that is laid without a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Its middle line; of a closed one the first point does not come again.
    pub points: Vec<Point2<f64>>,
    /// Whether it returns to its begin.
    pub closed: bool,
    /// Its width, in millimetres.
    pub width: f64,
    /// What it is part of.
    pub kind: StrokeKind,
    /// Which region, or which open contour.
    pub source: usize,
}

impl Stroke {
    /// Its length, in millimetres.
    pub fn length(&self) -> f64 {
        let back = self.points.last().zip(self.points.first()).filter(|_| self.closed);
        let along: f64 = self.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        along + back.map_or(0.0, |(last, first)| (first - last).norm())
    }
}

/// A filled design.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filled {
    /// The strokes: outlines and open contours first, then fill, each in the order of the regions.
    pub strokes: Vec<Stroke>,
    /// Regions that are too narrow for a bead.
    pub too_narrow: usize,
    /// Their area, in square millimetres.
    pub too_narrow_mm2: f64,
}

impl Filled {
    /// How often the nozzle stops: once a stroke.
    pub fn stops(&self) -> usize {
        self.strokes.len()
    }
}

/// Why regions could not be filled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FillError {
    /// An option is out of its range.
    #[error("the option `{what}` is {value}: {need}")]
    Option {
        /// Its name.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        need: &'static str,
    },
    /// A point is not finite, or too far away.
    #[error("region {region} has a point that is not finite, or beyond 1e6 mm")]
    Point {
        /// The region, from 0.
        region: usize,
    },
    /// The bead is so thin that a region would take more beads than make sense.
    #[error("region {region} would take more than {limit} beads side by side; take a wider bead")]
    TooMany {
        /// The region, from 0.
        region: usize,
        /// Greatest number.
        limit: usize,
    },
}

/// Narrowest bead and least tolerance, in millimetres: far below what any nozzle lays. Below them round corners have any number of points.
const MIN_BEAD: f64 = 1e-4;
const MIN_TOLERANCE: f64 = 1e-4;

/// Most beads side by side in a region: a platform of 300 mm with beads of 0.06 mm.
const MAX_LEVELS: usize = 5000;

/// Most scan lines of a region: a kilometre of them.
const MAX_ROWS: usize = 1_000_000;

/// That of the box around some points.
fn diagonal(points: &[Point2<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// Fills regions with beads, and lays one along each open contour.
///
/// # Errors
/// [`FillError`] for options out of range and points that cannot be used.
///
/// # Cost
/// `O(l n log n)` for `n` points of a region and `l` beads side by side.
///
/// # Example
/// ```
/// use curvlay_toolpath::{drawing::{Fill, FillOptions, Region, fill}, nalgebra::Point2};
/// let outer = [[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [0.0, 10.0]].map(Point2::from).to_vec();
/// let region = Region { outer, holes: vec![], contour: 0 };
/// let options = FillOptions { bead: 1.0, fill: Fill::Concentric, ..FillOptions::default() };
/// // Five loops, half a millimetre from the outline and then a millimetre apart; how far it is to the middle is known to 0.2 % of
/// // a bead.
/// let filled = fill(&[region], &[], &options)?;
/// assert_eq!(filled.stops(), 5);
/// assert!((filled.strokes[1].length() - 2.0 * (37.0 + 7.0)).abs() < 8.0 * 1.5 * 0.002);
/// # Ok::<(), curvlay_toolpath::drawing::FillError>(())
/// ```
pub fn fill(regions: &[Region], open: &[Contour], options: &FillOptions) -> Result<Filled, FillError> {
    check(options)?;
    let mut out = Filled::default();
    let mut fills = Vec::new();
    for (source, region) in regions.iter().enumerate() {
        let far = |p: &Point2<f64>| !(p.x.abs() <= MAX_COORDINATE_MM && p.y.abs() <= MAX_COORDINATE_MM);
        if region.rings().flatten().any(far) {
            return Err(FillError::Point { region: source });
        }
        match beads(region, source, options)? {
            Some((outlines, fill)) => {
                out.strokes.extend(outlines);
                fills.extend(fill);
            }
            None => {
                out.too_narrow += 1;
                out.too_narrow_mm2 += region.area();
            }
        }
    }
    out.strokes.extend(open.iter().enumerate().map(|(source, contour)| Stroke {
        points: contour.points.clone(),
        closed: contour.closed,
        width: options.bead,
        kind: StrokeKind::Open,
        source,
    }));
    out.strokes.append(&mut fills);
    Ok(out)
}

fn check(options: &FillOptions) -> Result<(), FillError> {
    let FillOptions { bead, angle, gap, min_width, tolerance, .. } = *options;
    let checks = [
        ("bead", bead, (MIN_BEAD..=1e3).contains(&bead), "it must be from 0.0001 to 1000 mm"),
        ("angle", angle, angle.is_finite(), "it must be finite"),
        ("gap", gap, (-0.5..=10.0).contains(&gap), "it must be from -0.5 to 10 beads"),
        ("min_width", min_width, (0.05..=1.0).contains(&min_width), "it must be from 0.05 to 1 bead"),
        (
            "tolerance",
            tolerance,
            tolerance >= MIN_TOLERANCE && tolerance <= bead,
            "it must be at least 0.0001 mm and at most a bead",
        ),
    ];
    match checks.into_iter().find(|(_, _, fits, _)| !fits) {
        Some((what, value, _, need)) => Err(FillError::Option { what, value, need }),
        None => Ok(()),
    }
}

/// A shape moved inwards by rising depths, within `tolerance` at each of them.
///
/// Each is moved on from the one before. From the shape itself the round corners of a rough outline would all lie over each other, which
/// is quadratic in its points; after the first step most of them are gone. A corner that was rounded once is a polygon whose chords grow
/// with the depth, and each step takes points from it: both get a share of the tolerance that adds up to it at the last depth.
fn nested(shape: &Shape, depths: &[f64], tolerance: f64) -> Vec<Vec<Shape>> {
    let share = 0.5 * tolerance / depths.len().max(1) as f64;
    let mut now = vec![shape.clone()];
    let mut before = 0.0;
    let mut on = |depth: f64| {
        let moved = inset(&now, depth - before, share);
        let thinned = |shape: &Shape| shape.iter().map(|ring| simplified(ring, share)).collect();
        now = moved.iter().map(thinned).collect();
        before = depth;
        now.clone()
    };
    depths.iter().map(|&depth| on(depth)).collect()
}

/// Outlines and fill.
type Beads = (Vec<Stroke>, Vec<Stroke>);

/// The strokes of a region; `None` if it is too narrow.
fn beads(region: &Region, source: usize, options: &FillOptions) -> Result<Option<Beads>, FillError> {
    let bead = options.bead;
    let whole = region.shape();
    // Half of the tolerance for the shape, half for its round corners.
    let thin: Shape = whole.iter().map(|ring| simplified(ring, 0.5 * options.tolerance)).collect();
    let depth = inradius::inradius(&thin, 0.002 * bead);
    // What lies within the bead on the outline is filled as a region of its own.
    let on_line = options.contour == ContourAt::OnLine;
    let first = if on_line { 0.5 * bead } else { 0.0 };
    let left = depth - first;
    if options.fill == Fill::Lines && diagonal(&region.outer) / bead > MAX_ROWS as f64 {
        return Err(FillError::TooMany { region: source, limit: MAX_ROWS });
    }
    if left / bead > MAX_LEVELS as f64 + 0.5 {
        return Err(FillError::TooMany { region: source, limit: MAX_LEVELS });
    }
    // As many beads to the middle, of one width: no gap is left there, and no bead lies on another.
    let levels = (left / bead).round().max(1.0);
    let inside = Interior { options, source, thin: &thin, depth, first, levels, width: left / levels };
    let is_narrow = left < options.min_width * bead;
    let (mut outlines, fill) = match options.fill {
        _ if is_narrow => (Vec::new(), Vec::new()),
        Fill::None | Fill::Lines => inside.outline_and_lines(),
        Fill::Concentric | Fill::Spiral => inside.loops(),
    };
    if on_line {
        outlines = whole.iter().map(|ring| inside.stroke(ring, StrokeKind::Outline, bead)).collect();
    }
    Ok((on_line || !is_narrow).then_some((outlines, fill)))
}

/// A region to be filled from a depth inwards.
struct Interior<'a> {
    options: &'a FillOptions,
    /// The number of the region.
    source: usize,
    /// Its outline, without points that the tolerance does not need.
    thin: &'a Shape,
    /// How far its middle is from its outline, and how far in the fill begins.
    depth: f64,
    first: f64,
    /// Beads from there to the middle, and their width.
    levels: f64,
    width: f64,
}

impl Interior<'_> {
    fn stroke(&self, ring: &Ring, kind: StrokeKind, width: f64) -> Stroke {
        Stroke { points: to_points(ring), closed: true, width, kind, source: self.source }
    }

    /// The region without what is nearer to its outline than this.
    fn deeper(&self, depth: f64) -> Vec<Shape> {
        inset(&vec![self.thin.clone()], depth, 0.5 * self.options.tolerance)
    }

    /// An outline unless there is one on the line, and scan lines in what it leaves if they are asked for.
    fn outline_and_lines(&self) -> Beads {
        let bead = self.options.bead;
        let (mut outlines, mut fill) = (Vec::new(), Vec::new());
        // Scan lines have a width of their own; the outline keeps the wanted one where there is enough inside.
        let (outline, within) = match self.options.contour {
            ContourAt::OnLine => (bead, self.first),
            ContourAt::Inside if self.levels > 1.0 => (bead, bead),
            ContourAt::Inside => (self.width, 2.0 * self.depth),
        };
        if self.options.contour == ContourAt::Inside {
            let rings = self.deeper(0.5 * outline);
            outlines.extend(rings.iter().flatten().map(|ring| self.stroke(ring, StrokeKind::Outline, outline)));
        }
        let within = within + (0.5 + self.options.gap) * bead;
        if self.options.fill == Fill::Lines && within < self.depth {
            for shape in self.deeper(within) {
                let scanned = lines::scan(&shape, bead, self.options).into_iter();
                let line = |(ring, width): (Ring, f64)| Stroke {
                    closed: false,
                    ..self.stroke(&ring, StrokeKind::Fill, width)
                };
                fill.extend(scanned.map(line));
            }
        }
        (outlines, fill)
    }

    /// Loops one inside the other, or one curve that joins them. The outermost is the outline unless there is one on the line.
    fn loops(&self) -> Beads {
        let (mut outlines, mut fill) = (Vec::new(), Vec::new());
        let depth = |level: usize| self.first + (level as f64 + 0.5) * self.width;
        let depths: Vec<f64> = (0..self.levels as usize).map(depth).collect();
        let nested = nested(self.thin, &depths, 0.5 * self.options.tolerance);
        if self.options.fill == Fill::Spiral {
            let curves = spiral::joined(&nested, self.width);
            fill.extend(curves.iter().map(|ring| self.stroke(ring, StrokeKind::Fill, self.width)));
            return (outlines, fill);
        }
        for (level, shapes) in nested.iter().enumerate() {
            let is_outline = level == 0 && self.options.contour == ContourAt::Inside;
            let (kind, list) =
                if is_outline { (StrokeKind::Outline, &mut outlines) } else { (StrokeKind::Fill, &mut fill) };
            list.extend(shapes.iter().flatten().map(|ring| self.stroke(ring, kind, self.width)));
        }
        (outlines, fill)
    }
}

#[cfg(test)]
mod tests {
    use super::{Shape, inset, nested};
    use std::f64::consts::TAU;

    /// Of an outline as rough as a scanned one.
    pub fn rough(points: u32, radius: f64, depth: f64) -> Shape {
        let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) >> 16) / 65536.0;
        let at = |k: u32| {
            let (r, a) = (radius - depth * noise(k), TAU * f64::from(k) / f64::from(points));
            [r * a.cos(), r * a.sin()]
        };
        vec![(0..points).map(at).collect()]
    }

    fn far(ring: &[[f64; 2]], at: [f64; 2]) -> f64 {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        let distance = |(a, b): (&[f64; 2], &[f64; 2])| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let share = ((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
            let share = share.clamp(0.0, 1.0);
            (a[0] + dx * share - at[0]).hypot(a[1] + dy * share - at[1])
        };
        ends.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Points of loops that are moved on from each other lie at their depth below the outline, from which the slow twin moves each loop, and
    /// the twin's lie on them.
    #[test]
    fn loops_moved_on_from_each_other_are_those_moved_from_the_outline() {
        let tolerance = 0.005;
        let star = vec![
            (0..10)
                .map(|k| (TAU * f64::from(k) / 10.0, if k % 2 == 0 { 40.0 } else { 22.0 }))
                .map(|(a, r)| [r * a.cos(), r * a.sin()])
                .collect::<Vec<_>>(),
        ];
        for shape in [star, rough(120, 30.0, 1.5)] {
            let depths: Vec<f64> = (0..7).map(|level| 1.5 + 3.0 * f64::from(level)).collect();
            let found = nested(&shape, &depths, tolerance);
            assert!(!found[6].is_empty());
            for (depth, loops) in depths.iter().zip(&found) {
                for at in loops.iter().flatten().flatten() {
                    let off = far(&shape[0], *at) - depth;
                    assert!((-tolerance..=tolerance).contains(&off), "{depth}: {off}");
                }
                let slow = inset(&vec![shape.clone()], *depth, 1e-4);
                assert_eq!(slow.len(), loops.len(), "{depth}");
                let ours: Vec<_> = loops.iter().flatten().collect();
                for at in slow.iter().flatten().flatten() {
                    let off = ours.iter().map(|ring| far(ring, *at)).fold(f64::INFINITY, f64::min);
                    // At the sharp end of a loop a small error of depth is a larger one along it.
                    assert!(off <= 4.0 * tolerance, "{depth}: {off}");
                }
            }
        }
        assert!(nested(&rough(9, 5.0, 0.1), &[], tolerance).is_empty());
    }

    /// Moved from the outline, 15 loops of 2,000 points took 14 s, and 10,000 points minutes: each step moved all of them. Now each leaves fewer than it took, all
    /// together three times as many as the outline has.
    #[test]
    fn loops_of_a_rough_outline_lose_points_from_step_to_step() {
        let depths: Vec<f64> = (0..15).map(|level| 1.6 + 3.2 * f64::from(level)).collect();
        let found = nested(&rough(10_000, 50.0, 0.5), &depths, 0.005);
        assert!(found.iter().all(|level| level.len() == 1));
        let points: Vec<usize> = found.iter().map(|level| level[0].iter().map(Vec::len).sum()).collect();
        assert!(points.is_sorted_by(|a, b| a > b) && points.iter().sum::<usize>() < 30_000, "{points:?}");
    }
}
