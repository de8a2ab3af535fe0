//! From level sets to the paths of a layer.

use super::chains::Chain;
use super::curve::Loop;
use super::polyline::Curve;
use super::spacing::{BEAD_WIDTHS, Spacing};
use super::thin::thinned;
use super::watch::Watch;
use super::{chains, join, narrow, rows, short, spirals, widths, zigzag};
use crate::level_set::{LevelField, LevelSets};
use crate::mesh::{SurfaceMesh, SurfacePoint};
use crate::path::{
    BeadKind, LayerPaths, POINTS_A_BEAD, PathError, PathOptions, PathPoint, Pattern, SurfacePath, Unfilled,
    UnfilledReason,
};
use crate::{Progress, ProgressFn};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// More levels than this are refused: the bead is then no bead but a slip of the unit.
const MAX_LEVELS: usize = 100_000;
/// Points of a path nearer together than this share of a bead are thinned out.
const THIN: f64 = 0.02;

/// Beads whose middle is nearer to the boundary than this, in beads, are walls: the outermost is 0.625 from it at most, the next one
/// 1.125 at least.
const WALL: f64 = 0.875;

/// Steps from level sets to paths, for reports of progress.
const STEPS: u64 = 5;

/// Paths, and what contours leave.
pub(crate) struct Contours {
    pub paths: LayerPaths,
    /// For each vertex of the refined mesh how far it is inward of the innermost contour's inner edge, in millimetres; below 0 on the
    /// contours and where fewer of them fit. Empty if the number of contours is not limited.
    pub inside: Vec<f64>,
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
    /// use curvlay_toolpath::geodesic::SurfaceDistance;
    /// use curvlay_toolpath::level_set::LevelField;
    /// use curvlay_toolpath::mesh::SurfaceMesh;
    /// use curvlay_toolpath::path::PathOptions;
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
    pub fn paths(&self, options: &PathOptions, progress: ProgressFn) -> Result<LayerPaths, PathError> {
        Ok(self.contours(options, None, progress)?.paths)
    }

    /// Paths that fill the surface, or so many contours from the boundary inward and what is too narrow for them.
    pub(crate) fn contours(
        &self,
        options: &PathOptions,
        walls: Option<u32>,
        progress: ProgressFn,
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
        check(options)?;
        let PathOptions { bead, min_gap: gap, join_distance, min_length, min_width, .. } = *options;
        // Rows keep one distance from each other whatever is beside them: there is no way across that they could share.
        let fitted = options.fitted && options.pattern != Pattern::Zigzag;
        let reach = self.reach(bead)?;
        self.check_size(options)?;
        let spacing = Spacing::new(self, bead, reach, fitted, walls.map(|walls| walls as usize));
        let inside: Vec<f64> = walls.map(|walls| spacing.inside(walls as usize)).unwrap_or_default();
        if walls == Some(0) {
            return Ok(Contours { paths: LayerPaths::default(), inside });
        }
        let sets = self.sets(&spacing);
        step()?;
        let nested = NestedRings::new(&sets, bead)?;
        let mesh = self.distance().mesh();
        let mut curves = nested.curves(self, &spacing, options.pattern, &watch)?;
        step()?;
        thinned(mesh, &mut curves, bead, &watch)?;
        step()?;
        // Widths follow from what is left beside a curve, so its points must not move any more.
        let widths: Vec<Vec<f64>> = match fitted {
            true => widths::fitted(mesh, &spacing, &curves, bead, &watch)?,
            false => even_widths(&curves, bead),
        };
        step()?;
        let mut lines = Lines { curves, widths };
        let wanted = narrow::Wanted::usual(&spacing, [bead, gap]);
        let singles = nested.singles(self, &wanted, options.pattern, &lines, &inside, &watch)?;
        step()?;
        let regions = lines.add(singles, nested.regions);
        let points = |at, widths| self.path_points(at, widths, bead, walls.is_some());
        let apart = lines.paths(points);
        let (paths, joints) = join::joined(self, &spacing, [bead, join_distance * bead], apart, &watch)?;
        // Strips too narrow for any bead get one in case something lies on them: they are regions after all others. They are found last, beside
        // all that the joined paths cover, and are not joined: whether they are laid is decided later.
        let strips = narrow::strip_beads(self, &spacing, [bead, gap, min_width], &paths, &inside, &watch)?;
        let strip =
            |(k, (at, widths))| SurfacePath { points: points(at, widths), closed: false, region: regions as u32 + k };
        let narrow = (0..).zip(strips).map(strip).collect();
        let (paths, short) = short::without_short(mesh, paths, min_length * bead);
        let unfilled = self.unfilled(&paths);
        Ok(Contours {
            paths: LayerPaths { paths, regions, joints, narrow, short, unfilled, ..LayerPaths::default() },
            inside,
        })
    }

    /// Points of a path with their widths. Where a layer is not filled solid all contours are walls.
    fn path_points(&self, points: Vec<SurfacePoint>, widths: Vec<f64>, bead: f64, is_wall: bool) -> Vec<PathPoint> {
        let kind = |at: &SurfacePoint| if is_wall { BeadKind::Wall } else { self.kind(at, bead) };
        points.into_iter().zip(widths).map(|(at, width)| PathPoint { at, width, kind: kind(&at) }).collect()
    }

    /// What a bead of a layer that is filled solid is for.
    fn kind(&self, at: &SurfacePoint, bead: f64) -> BeadKind {
        let distance = self.distance().at(at.triangle, at.barycentric).distance;
        if distance < WALL * bead { BeadKind::Wall } else { BeadKind::Solid }
    }

    /// The greatest distance from the boundary; infinite if there is no boundary anywhere.
    pub(crate) fn greatest(&self) -> f64 {
        let finite = self.values.iter().copied().filter(|v| v.is_finite());
        finite.fold(None, |most: Option<f64>, v| Some(most.map_or(v, |most| most.max(v)))).unwrap_or(f64::INFINITY)
    }

    /// Refuses beads that would take too many points, as [`PathOptions::max_points`] says.
    fn check_size(&self, options: &PathOptions) -> Result<(), PathError> {
        let PathOptions { bead, max_points: most, .. } = *options;
        let mesh = self.distance().mesh();
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| mesh.vertices()[v as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        let area_mm2: f64 = mesh.triangles().iter().map(area).sum();
        let points = POINTS_A_BEAD * area_mm2 / bead / bead;
        if points > most as f64 {
            return Err(PathError::TooManyPoints { bead, area_mm2, points, most });
        }
        Ok(())
    }

    /// The greatest distance from the boundary.
    pub(super) fn reach(&self, bead: f64) -> Result<f64, PathError> {
        let reach = self.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        if reach / bead > MAX_LEVELS as f64 {
            return Err(PathError::BeadTooSmall { bead, reach });
        }
        Ok(reach)
    }

    /// Connected parts of the mesh without a path.
    pub(crate) fn unfilled(&self, paths: &[SurfacePath]) -> Vec<Unfilled> {
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

/// Refuses options out of their ranges.
pub(crate) fn check(options: &PathOptions) -> Result<(), PathError> {
    let PathOptions { bead, min_gap: gap, join_distance, min_length, min_width, .. } = *options;
    if !(bead > 0.0 && bead.is_finite()) {
        return Err(PathError::Bead { bead });
    }
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
    if !(narrow::LOWEST_MIN_WIDTH..=BEAD_WIDTHS[0]).contains(&min_width) {
        return Err(PathError::MinWidth { beads: min_width });
    }
    options.infill.check()
}

/// The same width at all points of curves.
fn even_widths(curves: &[Curve], bead: f64) -> Vec<Vec<f64>> {
    curves.iter().map(|curve| vec![bead; curve.points.len()]).collect()
}

/// The curves of a layer on their way to paths, each with its widths.
struct Lines {
    curves: Vec<Curve>,
    widths: Vec<Vec<f64>>,
}

impl Lines {
    /// Adds single beads: each is a region of its own, after those that are there. Gives the number of regions.
    fn add(&mut self, singles: Vec<narrow::Single>, mut regions: usize) -> usize {
        for (points, width) in singles {
            self.curves.push(Curve { points, closed: false, region: regions as u32, least: 0.0 });
            self.widths.push(width);
            regions += 1;
        }
        regions
    }

    /// A path for each curve, in their order.
    fn paths(self, points: impl Fn(Vec<SurfacePoint>, Vec<f64>) -> Vec<PathPoint>) -> Vec<SurfacePath> {
        let path = |(curve, widths): (Curve, Vec<f64>)| SurfacePath {
            points: points(curve.points, widths),
            closed: curve.closed,
            region: curve.region,
        };
        self.curves.into_iter().zip(self.widths).map(path).collect()
    }
}

/// The rings of all levels, as loops by arc length and as chains of one inside the other.
struct NestedRings<'a> {
    sets: &'a LevelSets,
    /// `None` for rings that are too short.
    loops: Vec<Option<Loop>>,
    chains: Vec<Chain>,
    /// Connected regions: those of the chains.
    regions: usize,
    bead: f64,
}

impl<'a> NestedRings<'a> {
    /// A ring that ends at the boundary means that the distance is not that to the whole boundary.
    fn new(sets: &'a LevelSets, bead: f64) -> Result<Self, PathError> {
        if sets.rings.iter().any(|ring| !ring.closed) {
            return Err(PathError::NotToBoundary);
        }
        // A shorter ring would be a blot.
        let loop_of = |ring| Loop::new(ring).filter(|on| on.length() >= bead);
        let loops: Vec<Option<Loop>> = sets.rings.iter().map(loop_of).collect();
        let chains = chains::chains(sets, &loops, bead);
        let regions = chains.iter().map(|chain| chain.region as usize + 1).max().unwrap_or(0);
        Ok(NestedRings { sets, loops, chains, regions, bead })
    }

    /// The curves of a pattern, region by region.
    fn curves(
        &self,
        field: &LevelField,
        spacing: &Spacing,
        pattern: Pattern,
        watch: Watch,
    ) -> Result<Vec<Curve>, PathError> {
        let mut curves = match pattern {
            Pattern::Spirals => self.spirals(field.distance().mesh(), spacing, watch)?,
            Pattern::Rings => self.rings(),
            Pattern::Zigzag => self.rows(field)?,
        };
        // Stable: within a region curves keep the order in which they are laid.
        curves.sort_by_key(|curve| curve.region);
        Ok(curves)
    }

    /// Single beads where curves leave room for one. They keep off the curves that are there; with rows they keep off the outermost rings
    /// instead: what a ring along the boundary would cover belongs to the rows.
    fn singles(
        &self,
        field: &LevelField,
        wanted: &narrow::Wanted,
        pattern: Pattern,
        lines: &Lines,
        inside: &[f64],
        watch: Watch,
    ) -> Result<Vec<narrow::Single>, PathError> {
        if pattern == Pattern::Zigzag {
            let rims = self.rims();
            return narrow::single_beads(field, wanted, &rims, &even_widths(&rims, self.bead), inside, watch);
        }
        narrow::single_beads(field, wanted, &lines.curves, &lines.widths, inside, watch)
    }

    /// Rings of chains, each with its region.
    fn of_chains(&self) -> impl Iterator<Item = (usize, u32)> {
        self.chains.iter().flat_map(|chain| chain.rings.iter().map(|&ring| (ring as usize, chain.region)))
    }

    /// [`Pattern::Spirals`]: the rings of each region as one curve, cut open and bridged.
    fn spirals(&self, mesh: &SurfaceMesh, spacing: &Spacing, watch: Watch) -> Result<Vec<Curve>, PathError> {
        let rings = spirals::Rings { mesh, sets: self.sets, spacing, loops: &self.loops, bead: self.bead };
        let curves = spirals::connect(&rings, &self.chains, watch)?.curves(mesh, &self.loops).into_iter();
        let curve = |(points, region)| Curve { points, closed: false, region, least: THIN * self.bead };
        Ok(curves.map(curve).collect())
    }

    /// [`Pattern::Rings`]: each ring as a closed curve.
    fn rings(&self) -> Vec<Curve> {
        let curve = |(ring, region): (usize, u32)| {
            let points = self.loops[ring].as_ref()?.points().to_vec();
            Some(Curve { points, closed: true, region, least: THIN * self.bead })
        };
        self.of_chains().filter_map(curve).collect()
    }

    /// [`Pattern::Zigzag`]: rows between the outermost rings.
    fn rows(&self, field: &LevelField) -> Result<Vec<Curve>, PathError> {
        let outer = self.of_chains().filter(|&(ring, _)| self.sets.rings[ring].level == 0);
        let rim = |(ring, region): (usize, u32)| Some(rows::Rim { on: self.loops[ring].as_ref()?, region });
        let rims: Vec<rows::Rim> = outer.filter_map(rim).collect();
        let curves = zigzag::curves(field, &rims, self.bead)?.into_iter();
        let curve = |(points, closed, region)| Curve { points, closed, region, least: THIN * self.bead };
        Ok(curves.map(curve).collect())
    }

    /// The outermost rings, which rows leave bare.
    fn rims(&self) -> Vec<Curve> {
        let outer = self.sets.rings.iter().zip(&self.loops).filter(|(ring, _)| ring.level == 0);
        let curve = |on: &Loop| Curve { points: on.points().to_vec(), closed: true, region: 0, least: 0.0 };
        outer.filter_map(|(_, on)| on.as_ref().map(curve)).collect()
    }
}
