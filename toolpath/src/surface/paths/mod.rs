//! Paths that fill a curved layer with beads.
//!
//! Zhao et al., "Connected Fermat spirals for layered fabrication", ACM TOG 35(4), 2016, fill a plane region along its
//! offsets with one continuous curve; Dai 2020, section 3.5.1, does so on a surface with geodesic distance. So does
//! [`Pattern::Spirals`]. The other patterns stand beside it for comparison.
//!
//! * `curve`: rings by arc length, points near the surface. `chains`: the tree of rings.
//! * `spacing`: where rings lie, and how wide their beads are. `spirals`: where rings are cut and bridged. `plan`: from
//!   cuts and bridges to curves. `crossing`: whether these cross. `segments`: what is near. `thin`: fewer points.
//! * `widths`: how wide bridges are. `narrow`: single beads where there is no room for two, or some is left; and for strips too narrow
//!   for any, in case something lies on them.
//! * `join`: curves whose ends nearly meet become one. `short`: those too short to be worth a start are left out. `carry`: whether later
//!   beads lie on them.
//! * `zigzag`: rows to and fro, from where `cut` cuts the surface; `rows` joins them.
//!
//! Departures: the paper joins offsets that lie near each other, and smooths the curve by an optimisation afterwards.
//! Here the tree comes from how level sets nest, holes need no special care, and a bridge counts only if the
//! distance on it proves that it crosses no ring. Curves are not smoothed: away from bridges, every point is on a level.

pub(super) mod carry;
mod chains;
mod crossing;
pub(super) mod curve;
pub(super) mod cut;
mod join;
mod narrow;
mod plan;
mod polyline;
pub(super) mod rows;
pub(super) mod segments;
mod short;
mod spacing;
mod spirals;
mod thin;
mod widths;
mod zigzag;

use super::infill::InfillOptions;
use super::kind::BeadKind;
use super::level_set::{LevelField, LevelSetError, SurfacePoint};
use super::mesh::MeshError;
use super::order::Visit;
use crate::Progress;
use curve::Loop;
use nalgebra::Point3;
use polyline::Curve;
pub use spacing::BEAD_WIDTHS;
use spacing::Spacing;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use thin::thinned;

/// More levels than this are refused: the bead is then no bead but a slip of the unit.
const MOST_LEVELS: usize = 100_000;
/// Points of a path nearer together than this share of a bead are thinned out.
const THIN: f64 = 0.02;

/// Beads whose middle is nearer to the boundary than this, in beads, are walls: the outermost is 0.625 from it at most, the next one
/// 1.125 at least.
const WALL: f64 = 0.875;

/// Steps from level sets to paths, for reports of progress.
const STEPS: u64 = 5;

/// What asks whether to go on.
type Watch<'a> = &'a dyn Fn() -> Result<(), PathError>;

/// How a region is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Pattern {
    /// One continuous curve for each region, from the boundary inward and back out.
    #[default]
    Spirals,
    /// Closed curves along the boundary, one inside the other, not connected.
    Rings,
    /// Rows a bead apart, to and fro: one continuous curve for each part of a region that no hole and no bay divides. Beside
    /// the outermost rows up to a bead stays bare.
    Zigzag,
}

/// How paths are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PathOptions {
    /// Width of a bead, in millimetres: 0.8 by default.
    pub bead: f64,
    /// The pattern.
    pub pattern: Pattern,
    /// Whether widths follow the way across, from 0.75 to 1.25 times the bead, so that beads meet without gap where
    /// opposite sides face each other: so they do by default. Else all beads have the width asked for, as in the paper.
    /// Those of a zigzag always have.
    pub fitted: bool,
    /// A single bead in what other curves leave covers at least this many squares of a bead, or the gap stays: each is a
    /// curve more, with a way to it. One by default. A part of the surface without any other curve always gets one.
    pub min_gap: f64,
    /// Open curves of a layer whose ends are this many beads apart at most become one, if a bead can be laid on the straight way
    /// between them: 2 by default, 0 to leave all as they are.
    pub join_distance: f64,
    /// Curves shorter than this many beads are left out, 5 by default: each costs a start, and little is left of it but the
    /// start. The longest curve of a connected part of the surface always stays, so that tips and pins are printed, and so do those on which
    /// beads of the next layers lie ([`fill_layers`](super::fill_layers)).
    pub min_length: f64,
    /// Strips narrower than three quarters of a bead, but no narrower than this many, get a bead as wide as they are if beads of the next
    /// layers would else lie on nothing there: 0.5 by default, from 0.25 to 0.75, with which they stay bare. Strips on which nothing
    /// lies do in any case. For fitted beads alone: uniform ones lie in strips of half their width.
    pub min_width: f64,
    /// All layers together are refused before any work is done if their curves would have more points than this, by
    /// [`estimate_fill`](super::estimate_fill): 2^25 by default, for which some 5 GB are enough.
    pub max_points: usize,
    /// What is solid and what is not: all is, by default. [`LevelField::paths`] fills a surface solid in any case; the rest is for
    /// [`fill_layers`](super::fill_layers).
    pub infill: InfillOptions,
    /// Whether [`fill_layers`](super::fill_layers) finds what beads cover: yes. Else only lengths, turns and crossings are found, and the
    /// shares of areas are 0 ([`StatisticsOptions::coverage`](super::StatisticsOptions::coverage)); the paths are the same. It takes
    /// nearly as long as the paths.
    pub coverage: bool,
}

impl Default for PathOptions {
    fn default() -> Self {
        PathOptions {
            bead: 0.8,
            pattern: Pattern::default(),
            fitted: true,
            min_gap: 1.0,
            join_distance: 2.0,
            min_length: 5.0,
            min_width: 0.5,
            max_points: 1 << 25,
            infill: InfillOptions::default(),
            coverage: true,
        }
    }
}

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathPoint {
    /// Where it is on the surface.
    pub at: SurfacePoint,
    /// Width of the bead here, in millimetres.
    pub width: f64,
    /// What it is for.
    pub kind: BeadKind,
}

/// A continuous curve on the surface.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfacePath {
    /// Points in order, along which material is laid without a break.
    pub points: Vec<PathPoint>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
    /// The region that it fills.
    pub region: u32,
}

impl SurfacePath {
    /// Length of the curve, in millimetres.
    pub fn length(&self) -> f64 {
        let step = |a: &PathPoint, b: &PathPoint| (b.at.position - a.at.position).norm();
        let steps = self.points.windows(2).map(|pair| step(&pair[0], &pair[1])).sum::<f64>();
        match (self.closed, self.points.first(), self.points.last()) {
            (true, Some(first), Some(last)) => steps + step(last, first),
            _ => steps,
        }
    }

    /// How many segments it has; each begins at the point of its number.
    pub(super) fn segments(&self) -> usize {
        if self.closed { self.points.len() } else { self.points.len().saturating_sub(1) }
    }

    /// Both ends of a segment.
    pub(super) fn segment(&self, k: usize) -> [&PathPoint; 2] {
        [&self.points[k], &self.points[(k + 1) % self.points.len()]]
    }

    /// The places and widths of its points; of a closed curve the first stands at the end once more.
    pub fn line(&self) -> (Vec<Point3<f64>>, Vec<f64>) {
        let closing = self.closed.then(|| self.points.first()).flatten();
        self.points.iter().chain(closing).map(|point| (point.at.position, point.width)).unzip()
    }

    /// The same curve as it is travelled in an order: from another start if it is closed, or backward.
    ///
    /// # Panics
    /// If `visit` starts a closed curve at a point that is not there.
    pub fn travelled(&self, visit: &Visit) -> SurfacePath {
        let mut path = self.clone();
        let start = visit.start as usize;
        match (self.closed, visit.reversed) {
            (true, false) => path.points.rotate_left(start),
            (true, true) => {
                path.points.rotate_left(start + 1);
                path.points.reverse();
            }
            (false, true) => path.points.reverse(),
            (false, false) => {}
        }
        path
    }
}

/// Why a part of the surface stays without a bead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum UnfilledReason {
    /// There is no room for a bead: it is narrower than three quarters of a bead everywhere, and carries nothing or is narrower than
    /// [`PathOptions::min_width`]; for even ones narrower than half a bead, or shorter than a bead.
    Narrow,
    /// It has no boundary to measure from.
    NoBoundary,
}

/// A connected part of the surface that stays without a bead.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Unfilled {
    /// A point of it: the middle of the triangle that is farthest from the boundary.
    pub at: SurfacePoint,
    /// Its area in mm^2.
    pub area: f64,
    /// Why.
    pub reason: UnfilledReason,
}

/// The paths of a layer.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerPaths {
    /// All curves, region by region.
    pub paths: Vec<SurfacePath>,
    /// Connected regions: parts of the surface wide enough for two beads (necks narrower than a bead, or than one and a
    /// half for fitted ones, do not connect), then what a single bead fills: narrower parts, each branch by itself, and
    /// what fitted beads leave where three sides meet.
    pub regions: usize,
    /// How many times ends of curves were joined.
    pub joints: usize,
    /// Curves that are left out since they are short.
    pub short: Vec<SurfacePath>,
    /// Beads of strips narrower than three quarters of a bead ([`PathOptions::min_width`]) that are left out, since nothing is known to lie
    /// on them.
    pub narrow: Vec<SurfacePath>,
    /// How many of `paths` are beads of such strips, on which beads of the next layers lie ([`fill_layers`](super::fill_layers)).
    pub narrow_laid: usize,
    /// Their length in millimetres.
    pub narrow_laid_mm: f64,
    /// What is left out.
    pub unfilled: Vec<Unfilled>,
}

/// Paths, and what contours leave.
pub(super) struct Contours {
    pub paths: LayerPaths,
    /// For each vertex of the refined mesh how far it is inward of the innermost contour's inner edge, in millimetres; below 0 on the
    /// contours and where fewer of them fit. Empty if the number of contours is not limited.
    pub inside: Vec<f64>,
}

/// Why there are no paths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// The bead is not a positive number.
    #[error("a bead of {bead} mm: it must be positive")]
    Bead {
        /// The width that was asked for.
        bead: f64,
    },
    /// The minimum gap is not a number from 0 on.
    #[error("a minimum gap of {gap} squares of a bead: it must be 0 or more")]
    Gap {
        /// What was asked for.
        gap: f64,
    },
    /// The distance between ends to join is not a number from 0 on.
    #[error("a join distance of {beads} beads: it must be 0 or more")]
    JoinDistance {
        /// What was asked for.
        beads: f64,
    },
    /// The minimum length is not a number from 0 on.
    #[error("a minimum length of {beads} beads: it must be 0 or more")]
    MinLength {
        /// What was asked for.
        beads: f64,
    },
    /// The least width of a bead is none between a quarter and three quarters of a bead.
    #[error("a least width of {beads} beads: it must be from 0.25 to 0.75")]
    MinWidth {
        /// What was asked for.
        beads: f64,
    },
    /// An option of walls, skins and infill that is no use.
    #[error("{option} is {value}: it must be {wanted}")]
    Infill {
        /// Its name.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The region is very many beads wide; check the unit.
    #[error("a bead of {bead} mm in a region that reaches {reach} mm inward: more than 100000 beads")]
    BeadTooSmall {
        /// The width that was asked for.
        bead: f64,
        /// The greatest distance from the boundary.
        reach: f64,
    },
    /// The distance is not that to the whole boundary.
    #[error("a level set ends at the boundary: paths need the distance to the whole boundary")]
    NotToBoundary,
    /// The surface cannot be cut where the rows of a zigzag begin.
    #[error("no rows: the surface cannot be cut: {0}")]
    Cut(#[from] MeshError),
    /// The level sets cannot be made.
    #[error(transparent)]
    Levels(#[from] LevelSetError),
    /// The callback stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl LevelField<'_> {
    /// Paths that fill the surface with beads.
    ///
    /// Even beads run along the level sets half a bead from the boundary and at every bead from there. Fitted ones
    /// ([`PathOptions::fitted`]) are as wide as asked for along the boundary; those towards the medial axis share what
    /// is left of the way across. With
    /// [`Pattern::Spirals`] each connected region gets one curve, which starts and ends on its outer rim, next to itself.
    /// Where rings nowhere run side by side (rare: small rings in narrow places) a region gets more than one; compare
    /// the number of paths, joints and short curves with `regions`. Those shorter than about three beads are left out there: a single bead takes their place.
    /// [`Pattern::Zigzag`] has rows instead, a bead apart by geodesic distance, and more than one curve where holes and bays
    /// part them.
    ///
    /// At last curves whose ends nearly meet are joined ([`PathOptions::join_distance`]), and short ones left out
    /// ([`PathOptions::min_length`]), so that there may be fewer curves than regions.
    ///
    /// # Arguments
    /// * `progress`: called with the stage `paths`, for each curve and between five steps; may cancel.
    ///
    /// # Errors
    /// [`PathError`].
    ///
    /// # Cost
    /// That of the level sets, and for each ring some hundreds of passes over its points.
    ///
    /// # Example
    /// ```
    /// # use curvlay_toolpath::nalgebra::Point3;
    /// use curvlay_toolpath::surface::{LevelField, PathOptions, SurfaceDistance, SurfaceMesh};
    /// # use std::ops::ControlFlow;
    /// // A square of 16 mm and beads of 1 mm.
    /// let corners = [[0.0, 0.0], [16.0, 0.0], [16.0, 16.0], [0.0, 16.0]].map(|[x, y]| Point3::new(x, y, 0.0));
    /// let square = SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
    /// let distance = SurfaceDistance::to_boundary(&square, &|_| ControlFlow::Continue(()))?;
    /// let field = LevelField::new(&distance, 0.01, &|_| ControlFlow::Continue(()))?;
    /// let filled = field.paths(&PathOptions { bead: 1.0, ..PathOptions::default() }, &|_| ControlFlow::Continue(()))?;
    /// assert_eq!((filled.paths.len(), filled.regions), (1, 1));
    /// // As long as 256 mm^2 need, but for gaps along the diagonals.
    /// assert!((filled.paths[0].length() - 256.0).abs() < 8.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn paths(
        &self,
        options: &PathOptions,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<LayerPaths, PathError> {
        Ok(self.contours(options, None, progress)?.paths)
    }

    /// Paths that fill the surface, or so many contours from the boundary inward and what is too narrow for them.
    pub(super) fn contours(
        &self,
        options: &PathOptions,
        walls: Option<u32>,
        progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
    ) -> Result<Contours, PathError> {
        let done = AtomicU64::new(0);
        let watch = || match progress(Progress { stage: "paths", done: done.load(Ordering::Relaxed), total: STEPS }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(PathError::Cancelled),
        };
        let step = || {
            done.fetch_add(1, Ordering::Relaxed);
            watch()
        };
        let bead = options.bead;
        if !(bead > 0.0 && bead.is_finite()) {
            return Err(PathError::Bead { bead });
        }
        let PathOptions { min_gap: gap, join_distance, min_length, min_width, .. } = *options;
        let from_zero = |value: f64| value >= 0.0 && value.is_finite();
        if !from_zero(gap) {
            return Err(PathError::Gap { gap });
        }
        if !from_zero(join_distance) {
            return Err(PathError::JoinDistance { beads: join_distance });
        }
        if !from_zero(min_length) {
            return Err(PathError::MinLength { beads: min_length });
        }
        if !(narrow::LEAST_MIN_WIDTH..=BEAD_WIDTHS[0]).contains(&min_width) {
            return Err(PathError::MinWidth { beads: min_width });
        }
        options.infill.check()?;
        let fitted = options.fitted && options.pattern != Pattern::Zigzag;
        let spacing = Spacing::new(self, bead, self.reach(bead)?, fitted, walls.map(|walls| walls as usize));
        let inside: Vec<f64> = walls.map(|walls| spacing.inside(walls as usize)).unwrap_or_default();
        if walls == Some(0) {
            return Ok(Contours { paths: LayerPaths::default(), inside });
        }
        let sets = self.sets(&spacing);
        step()?;
        if sets.rings.iter().any(|ring| !ring.closed) {
            return Err(PathError::NotToBoundary);
        }
        // A shorter ring would be a blot.
        let loop_of = |ring| Loop::new(ring).filter(|on| on.length() >= bead);
        let loops: Vec<Option<Loop>> = sets.rings.iter().map(loop_of).collect();
        let chains = chains::chains(&sets, &loops, bead);
        let mesh = self.distance().mesh();
        let regions = chains.iter().map(|chain| chain.region as usize + 1).max().unwrap_or(0);
        let mut found = LayerPaths { regions, ..LayerPaths::default() };
        let mut curves = match options.pattern {
            Pattern::Spirals => {
                let rings = spirals::Rings { mesh, sets: &sets, spacing: &spacing, loops: &loops, bead };
                let curves = spirals::connect(&rings, &chains, &watch)?.curves(mesh, &loops).into_iter();
                let curve = |(points, region)| Curve { points, closed: false, region, least: THIN * bead };
                curves.map(curve).collect::<Vec<_>>()
            }
            Pattern::Rings => {
                let rings = chains.iter().flat_map(|chain| chain.rings.iter().map(|&r| (r, chain.region)));
                let curve = |(r, region): (u32, u32)| {
                    let points = loops[r as usize].as_ref()?.points().to_vec();
                    Some(Curve { points, closed: true, region, least: THIN * bead })
                };
                rings.filter_map(curve).collect()
            }
            Pattern::Zigzag => {
                let rings = chains.iter().flat_map(|chain| chain.rings.iter().map(|&r| (r as usize, chain.region)));
                let outer = rings.filter(|&(r, _)| sets.rings[r].level == 0);
                let rim = |(r, region): (usize, u32)| Some(rows::Rim { on: loops[r].as_ref()?, region });
                let rims: Vec<rows::Rim> = outer.filter_map(rim).collect();
                let curves = zigzag::curves(self, &rims, bead)?.into_iter();
                curves.map(|(points, closed, region)| Curve { points, closed, region, least: THIN * bead }).collect()
            }
        };
        curves.sort_by_key(|curve| curve.region);
        step()?;
        thinned(mesh, &mut curves, bead, &watch)?;
        step()?;
        let mut widths: Vec<Vec<f64>> = match fitted {
            true => widths::fitted(mesh, &spacing, &curves, bead, &watch)?,
            false => curves.iter().map(|curve| vec![bead; curve.points.len()]).collect(),
        };
        step()?;
        let wanted = narrow::Wanted::usual(&spacing, [bead, gap]);
        let singles = match options.pattern {
            // Rows keep off the boundary: what a ring along it would cover is theirs.
            Pattern::Zigzag => {
                let outer = sets.rings.iter().zip(&loops).filter(|(ring, _)| ring.level == 0);
                let curve = |on: &Loop| Curve { points: on.points().to_vec(), closed: true, region: 0, least: 0.0 };
                let rims: Vec<Curve> = outer.filter_map(|(_, on)| on.as_ref().map(curve)).collect();
                let widths: Vec<Vec<f64>> = rims.iter().map(|rim| vec![bead; rim.points.len()]).collect();
                narrow::single_beads(self, &wanted, &rims, &widths, &inside, &watch)?
            }
            _ => narrow::single_beads(self, &wanted, &curves, &widths, &inside, &watch)?,
        };
        step()?;
        for (points, width) in singles {
            curves.push(Curve { points, closed: false, region: found.regions as u32, least: 0.0 });
            widths.push(width);
            found.regions += 1;
        }
        let kind = |at: &SurfacePoint| if walls.is_some() { BeadKind::Wall } else { self.kind(at, bead) };
        let points = |points: Vec<SurfacePoint>, widths: Vec<f64>| -> Vec<PathPoint> {
            points.into_iter().zip(widths).map(|(at, width)| PathPoint { at, width, kind: kind(&at) }).collect()
        };
        let path = |(curve, widths): (Curve, Vec<f64>)| SurfacePath {
            points: points(curve.points, widths),
            closed: curve.closed,
            region: curve.region,
        };
        let paths;
        let apart = curves.into_iter().zip(widths).map(path).collect();
        (paths, found.joints) = join::joined(self, &spacing, [bead, join_distance * bead], apart, &watch)?;
        let strips = narrow::strip_beads(self, &spacing, [bead, gap, min_width], &paths, &inside, &watch)?;
        let strip = |(k, (at, widths)): (u32, narrow::Single)| SurfacePath {
            points: points(at, widths),
            closed: false,
            region: found.regions as u32 + k,
        };
        found.narrow = (0..).zip(strips).map(strip).collect();
        (found.paths, found.short) = short::without_short(mesh, paths, min_length * bead);
        found.unfilled = self.unfilled(&found.paths);
        Ok(Contours { paths: found, inside })
    }

    /// What a bead of a layer that is filled solid is for.
    fn kind(&self, at: &SurfacePoint, bead: f64) -> BeadKind {
        let distance = self.distance().at(at.triangle, at.barycentric).distance;
        if distance < WALL * bead { BeadKind::Wall } else { BeadKind::Solid }
    }

    /// The greatest distance from the boundary; infinite if there is no boundary anywhere.
    pub(super) fn greatest(&self) -> f64 {
        let finite = self.values.iter().copied().filter(|v| v.is_finite());
        finite.fold(None, |most: Option<f64>, v| Some(most.map_or(v, |most| most.max(v)))).unwrap_or(f64::INFINITY)
    }

    /// The greatest distance from the boundary.
    fn reach(&self, bead: f64) -> Result<f64, PathError> {
        let reach = self.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        if reach / bead > MOST_LEVELS as f64 {
            return Err(PathError::BeadTooSmall { bead, reach });
        }
        Ok(reach)
    }

    /// Connected parts of the mesh without a path.
    pub(super) fn unfilled(&self, paths: &[SurfacePath]) -> Vec<Unfilled> {
        let mesh = self.distance().mesh();
        let parts = mesh.regions();
        let mut filled = vec![false; parts.count];
        let all = paths.iter().flat_map(|path| &path.points);
        all.for_each(|point| filled[parts.of_triangle[point.at.triangle as usize] as usize] = true);
        let mut found: Vec<Option<(Unfilled, f64)>> = vec![None; parts.count];
        for (triangle, corners) in (0..).zip(mesh.triangles()) {
            let part = parts.of_triangle[triangle as usize] as usize;
            if filled[part] {
                continue;
            }
            let [a, b, c] = corners.map(|v| mesh.vertices()[v as usize]);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let third = [1.0 / 3.0; 3];
            let reach = self.distance().at(triangle, third).distance;
            let middle = SurfacePoint { triangle, barycentric: third, position: mesh.point(triangle, third) };
            let reason = if reach.is_finite() { UnfilledReason::Narrow } else { UnfilledReason::NoBoundary };
            let (unfilled, farthest) = found[part].get_or_insert((Unfilled { at: middle, area: 0.0, reason }, reach));
            unfilled.area += area;
            if reach > *farthest {
                (unfilled.at, *farthest) = (middle, reach);
            }
        }
        found.into_iter().flatten().map(|(unfilled, _)| unfilled).collect()
    }
}
