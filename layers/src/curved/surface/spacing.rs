//! How far apart surfaces lie.
//!
//! Dai 2020, section 3.6.3 and Figure 3.18 (the histogram of the distance between working surfaces).
//!
//! From the middle of each triangle of surface `i` a ray goes along its normal to surface `i + 1`, and one against it
//! to surface `i - 1`. The *spacing* at the triangle is the mean of the two lengths, or the one that there is. A
//! ray that meets no neighbour within reach has none: the part ends there, or the front waited. Means and percentiles
//! are weighted by area.
//!
//! The *thickness* of the layer at a triangle shares the space between surfaces out among them: on each side half the
//! way to the nearest surface, of whatever layer. Where a front waited a layer is missing between two others, and they
//! lie up to two heights apart there; what is between them is theirs. So thickness by area is volume, which is counted
//! neither twice nor not at all. Where no surface follows before the line leaves the part through a skin that lies along the
//! layer, the layer goes as far as the skin ([`measure_spacing_within`]).
//!
//! Departs from the paper: distances are taken along normals, not to the nearest point, so that the edge of a
//! neighbour that ends nearby does not count as its distance; and triangles are weighted by area, not sampled.

use super::tree::Tree;
use crate::ProgressFn;
use crate::parallel::in_parallel_watched;
use crate::trim::{SurfaceSlices, Trimmer};
use nalgebra::{Point3, Vector3};
use std::ops::Range;

/// How far a neighbour may be, in layer heights. Spacing of hop counts goes up to twice its mean where a front
/// sweeps round a corner; a ray that goes farther has left the part, and finds another branch of it.
pub(crate) const SPACING_REACH: f64 = 3.0;

/// How far apart surfaces are at most, in layer heights, where a layer is missing between them: with a slope of one on
/// both sides of a wait each goes half a layer towards the other, however long the wait. More is a gap of the part.
const WAIT: f64 = 2.0;

/// How far the skin may be from the last surface before it, in layer heights. Layers that fit leave at most one; half of one more
/// where the slope of the field is less.
const SKIN: f64 = 1.5;

/// The skin lies along a layer if the cosine between their normals is at least this: up to 45 degrees. A steeper skin is a side of the
/// layer, where the line would leave through it a little above and a little below its edge.
const ALONG: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// What most rays need, in layer heights.
const SHORT: f64 = 1.3;

/// Surfaces nearer to each other than this, in layer heights, are squeezed: no nozzle lays so thin a layer.
const SQUEEZED: f64 = 0.3;

/// Bars of the histogram, over 0 to [`HISTOGRAM_END`] layer heights.
const BARS: usize = 60;

/// Where the histogram ends, in layer heights.
const HISTOGRAM_END: f64 = 3.0;

/// How far apart surfaces lie.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Spacing {
    /// For each surface, for each triangle: the spacing in millimetres; `None` where no neighbour is in reach.
    pub values_mm: Vec<Vec<Option<f64>>>,
    /// The same for the thickness of the layer: on each side half the way to the nearest surface; where there is none the way
    /// to the skin, if that is known and lies along the layer, else half a layer height.
    pub thickness_mm: Vec<Vec<f64>>,
    /// Mean spacing; 0 if nothing was measured, like the figures that follow.
    pub mean_mm: f64,
    /// Standard deviation of the spacing.
    pub std_mm: f64,
    /// A twentieth of the area has less spacing.
    pub p05_mm: f64,
    /// A twentieth of the area has more spacing.
    pub p95_mm: f64,
    /// Area in square millimetres by spacing: bars of equal width over 0 to 3 layer heights.
    pub histogram_mm2: Vec<f64>,
    /// Width of a bar.
    pub bar_mm: f64,
    /// Area of all surfaces.
    pub area_mm2: f64,
    /// Area where a neighbour is in reach.
    pub measured_mm2: f64,
    /// Share of the area that has another surface, whichever, within 0.3 layer heights along its normal: no nozzle lays so thin a layer.
    pub squeezed_share: f64,
    /// Area by the thickness of the layer there, summed up.
    pub volume_mm3: f64,
}

/// Why spacing could not be measured.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpacingError {
    /// No layer height.
    #[error("a layer height of {height_mm} mm: it must be finite and above 0")]
    Height {
        /// The height that was given.
        height_mm: f64,
    },
    /// A triangle names a point that is not there.
    #[error("triangle {triangle} of surface {surface} names point {point} of {points}")]
    NoPoint {
        /// The surface, from 0.
        surface: usize,
        /// The triangle, from 0.
        triangle: usize,
        /// The point that it names.
        point: u32,
        /// Points that the surface has.
        points: usize,
    },
    /// A coordinate is not finite.
    #[error("point {point} of surface {surface} has a coordinate that is not finite")]
    NotFinite {
        /// The surface, from 0.
        surface: usize,
        /// The point, from 0.
        point: usize,
    },
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

/// What the rays of a triangle found.
#[derive(Clone, Copy, Default)]
struct Found {
    area: f64,
    spacing: Option<f64>,
    thickness: f64,
    squeezed: bool,
}

/// Measures the spacing of `surfaces`, which follow each other; trimmed or not.
///
/// # Arguments
/// * `surfaces`: points in millimetres and triangles of each, counter-clockwise seen from where the growth goes.
///   Triangles without area count for nothing.
/// * `height_mm`: the layer height, for what is in reach and what is squeezed.
/// * `progress`: called with the stage `spacing` after each surface; may cancel.
///
/// # Errors
/// [`SpacingError`].
///
/// # Cost
/// `O(n log n)` for `n` triangles, two or three microseconds each. With the feature `rayon` surfaces are shared out
/// among threads; the result is the same.
///
/// # Example
/// ```
/// use curvlay_layers::{curved::surface::measure_spacing, nalgebra::Point3};
/// let level = |z| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]].map(Point3::from);
/// let points = [level(0.5), level(1.5), level(2.4)];
/// let surfaces: Vec<_> = points.iter().map(|points| (&points[..], &[[0, 1, 2]][..])).collect();
/// let spacing = measure_spacing(&surfaces, 1.0, &|_| std::ops::ControlFlow::Continue(()))?;
/// let values: Vec<f64> = spacing.values_mm.iter().flatten().flatten().copied().collect();
/// assert!(values.iter().zip([1.0, 0.95, 0.9]).all(|(a, b)| (a - b).abs() < 1e-12));
/// assert!((spacing.mean_mm - 0.95).abs() < 1e-12);
/// # Ok::<(), curvlay_layers::curved::surface::SpacingError>(())
/// ```
pub fn measure_spacing(
    surfaces: &[SurfaceSlices],
    height_mm: f64,
    progress: ProgressFn,
) -> Result<Spacing, SpacingError> {
    measure(surfaces, 0..surfaces.len(), None, height_mm, progress)
}

/// The same for surfaces within a solid, to which they are trimmed: the first and the last layer go as far as its skin.
///
/// # Arguments
/// * `solid`: what the surfaces are trimmed to.
///
/// # Errors
/// [`SpacingError`].
///
/// # Cost
/// That of [`measure_spacing`], and `O(log m)` for a mesh of `m` triangles wherever no surface follows.
///
/// # Example
/// ```
/// use curvlay_layers::curved::surface::measure_spacing_within;
/// use curvlay_layers::trim::Trimmer;
/// use curvlay_layers::nalgebra::Point3;
/// # let corner = |k: u32| Point3::from([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 10.0 } else { 0.0 }));
/// # let cube: Vec<_> = (0..8).map(corner).collect();
/// # let faces = [
/// #     [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
/// #     [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
/// # ];
/// // A cube of 10 mm; the last of its surfaces lies 1.2 mm below the top.
/// let solid = Trimmer::new(&cube, &faces)?;
/// let level = |z| [[0.0, 0.0, z], [10.0, 0.0, z], [0.0, 10.0, z]].map(Point3::from);
/// let points = [level(7.2), level(8.8)];
/// let surfaces: Vec<_> = points.iter().map(|points| (&points[..], &[[0, 1, 2]][..])).collect();
/// let spacing = measure_spacing_within(&surfaces, &solid, 1.6, &|_| std::ops::ControlFlow::Continue(()))?;
/// assert!((spacing.thickness_mm[1][0] - (0.8 + 1.2)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure_spacing_within(
    surfaces: &[SurfaceSlices],
    solid: &Trimmer,
    height_mm: f64,
    progress: ProgressFn,
) -> Result<Spacing, SpacingError> {
    measure(surfaces, 0..surfaces.len(), Some(solid), height_mm, progress)
}

/// The same for a range of the surfaces; others need to be there only as far as they are near these.
pub(crate) fn measure_spacing_in(
    surfaces: &[SurfaceSlices],
    range: Range<usize>,
    solid: &Trimmer,
    height_mm: f64,
    progress: ProgressFn,
) -> Result<Spacing, SpacingError> {
    measure(surfaces, range, Some(solid), height_mm, progress)
}

fn measure(
    surfaces: &[SurfaceSlices],
    range: Range<usize>,
    solid: Option<&Trimmer>,
    height_mm: f64,
    progress: ProgressFn,
) -> Result<Spacing, SpacingError> {
    if !(height_mm > 0.0 && height_mm.is_finite()) {
        return Err(SpacingError::Height { height_mm });
    }
    for (surface, (points, triangles)) in surfaces.iter().enumerate() {
        if let Some(point) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(SpacingError::NotFinite { surface, point });
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&point) = corners.iter().find(|&&point| point as usize >= points.len()) {
                return Err(SpacingError::NoPoint { surface, triangle, point, points: points.len() });
            }
        }
    }
    let tree = Tree::new(surfaces);
    let of_surface = |surface: usize, _: ProgressFn| -> Vec<Found> {
        if !range.contains(&surface) {
            return Vec::new();
        }
        let (points, triangles) = surfaces[surface];
        let has = [surface > 0, surface + 1 < surfaces.len()];
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let around = Around { tree: &tree, solid, surface: surface as u32, has, height_mm };
        triangles.iter().map(|t| around.found(corners(t))).collect()
    };
    let found = in_parallel_watched(surfaces.len(), "spacing", progress, of_surface).ok_or(SpacingError::Cancelled)?;
    drop(tree); // the most that is held here, with the figures of all triangles
    Ok(summed_up(found, height_mm))
}

/// What rays from a surface are looked up in.
struct Around<'a> {
    tree: &'a Tree<'a>,
    solid: Option<&'a Trimmer>,
    surface: u32,
    /// Whether there is a surface before, and one after.
    has: [bool; 2],
    height_mm: f64,
}

impl Around<'_> {
    fn found(&self, [a, b, c]: [Point3<f64>; 3]) -> Found {
        let &Around { tree, surface, has, height_mm, .. } = self;
        let normal = (b - a).cross(&(c - a));
        let area = normal.norm() / 2.0;
        let Some(normal) = normal.try_normalize(0.0) else { return Found::default() };
        let middle: Point3<f64> = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let near = SQUEEZED * height_mm;
        // Most neighbours are about a layer away: a short line first passes by far fewer triangles.
        let short = tree.cast(middle, &normal, surface, has.map(|has| if has { SHORT * height_mm } else { 0.0 }), near);
        let missing = [0, 1].map(|side| short.neighbours[side].is_none());
        let mut sides = [0, 1].map(|side| (short.neighbours[side], short.nearest[side]));
        let searched = [0, 1].map(|side| missing[side] && has[side]);
        if searched != [false; 2] {
            let reach = searched.map(|searched| if searched { SPACING_REACH * height_mm } else { 0.0 });
            let long = tree.cast(middle, &normal, surface, reach, 0.0);
            for side in (0..2).filter(|&side| searched[side]) {
                sides[side] = (long.neighbours[side], long.nearest[side]);
            }
        }
        let spacing = match sides.map(|(neighbour, _)| neighbour) {
            [Some(before), Some(after)] => Some((before + after) / 2.0),
            [one, other] => one.or(other),
        };
        let thickness = |side: usize| {
            let (neighbour, nearest) = sides[side];
            let to_next = nearest.filter(|&nearest| nearest < WAIT * height_mm).or(neighbour);
            let way = if side == 0 { -normal } else { normal };
            let skin = if missing[side] { self.skin(middle, way) } else { None };
            skin.filter(|&skin| to_next.is_none_or(|next| skin < next)).unwrap_or(to_next.unwrap_or(height_mm) / 2.0)
        };
        Found { area, spacing, thickness: thickness(0) + thickness(1), squeezed: short.near }
    }

    /// How far it is to the skin, if that is near and lies along the layer.
    fn skin(&self, from: Point3<f64>, way: Vector3<f64>) -> Option<f64> {
        let (distance, along) = self.solid?.skin(&from, &way, SKIN * self.height_mm)?;
        (along >= ALONG).then_some(distance)
    }
}

fn summed_up(found: Vec<Vec<Found>>, height_mm: f64) -> Spacing {
    let bar_mm = HISTOGRAM_END * height_mm / BARS as f64;
    let mut spacing = Spacing { bar_mm, histogram_mm2: vec![0.0; BARS], ..Spacing::default() };
    let mut weighted = Vec::with_capacity(found.iter().flatten().filter(|found| found.spacing.is_some()).count());
    let mut squeezed = 0.0;
    for surface in found {
        for found in &surface {
            spacing.area_mm2 += found.area;
            squeezed += if found.squeezed { found.area } else { 0.0 };
            spacing.volume_mm3 += found.area * found.thickness;
            if let Some(value) = found.spacing {
                weighted.push((value, found.area));
                spacing.measured_mm2 += found.area;
                spacing.histogram_mm2[((value / bar_mm) as usize).min(BARS - 1)] += found.area;
            }
        }
        spacing.values_mm.push(surface.iter().map(|found| found.spacing).collect());
        spacing.thickness_mm.push(surface.iter().map(|found| found.thickness).collect());
    }
    if spacing.area_mm2 > 0.0 {
        spacing.squeezed_share = squeezed / spacing.area_mm2;
    }
    if spacing.measured_mm2 > 0.0 {
        let mean_of = |of: &dyn Fn(f64) -> f64| {
            weighted.iter().map(|&(value, area)| of(value) * area).sum::<f64>() / spacing.measured_mm2
        };
        spacing.mean_mm = mean_of(&|value| value);
        spacing.std_mm = mean_of(&|value| (value - spacing.mean_mm).powi(2)).sqrt();
        weighted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        [spacing.p05_mm, spacing.p95_mm] = [0.05, 0.95].map(|share| percentile(&weighted, share));
    }
    spacing
}

/// The value below which `share` of the weight lies; `weighted` rises.
fn percentile(weighted: &[(f64, f64)], share: f64) -> f64 {
    let total: f64 = weighted.iter().map(|w| w.1).sum();
    let mut so_far = 0.0;
    let reached = |&&(_, weight): &&(f64, f64)| {
        so_far += weight;
        so_far >= share * total
    };
    weighted.iter().find(reached).or(weighted.last()).map_or(0.0, |w| w.0)
}
