//! Later surfaces clipped where they pass below earlier ones.
//!
//! Where a front waited, the surfaces of its two sides go on by themselves up to the face between, and may pass through each other
//! there. What lies below an earlier surface is material already, so the later surface ends at the earlier one:
//! 1. Triangles of both that pass through each other are found exactly, and those of the later surface are cut along the segments
//!    that they share (`crossing`, `pieces`), as trimming cuts them along the mesh.
//! 2. A piece beside such a cut on the back of the earlier surface lies below it. So does what hangs together with it
//!    and has an earlier surface ahead, within [`CLIP_REACH`] layer heights along its normal. Both are left out.
//!
//! Surfaces are clipped in their order, each to what is left of those before that it meets; of all others only what lies ahead matters. So a few of many surfaces can be
//! clipped without the rest ([`Trimmer::clip_met`]). The border that a cut makes is the surface's own
//! ([`BoundaryKind::Border`]).

use super::Trimmer;
use super::crossing::meet;
use super::crossings::{AllTriangles, SurfaceCrossings, counted, crosses};
use super::error::TrimError;
use super::patch::NONE;
use super::pieces::Pieces;
use super::predicates::Moves;
use super::sheet::Sheet;
use super::slivers::remove_slivers;
use super::solid::Solid;
use super::surface::Surface;
use super::trimmed::{BoundaryKind, TrimmedSheet, slices};
use crate::boxes::Bounds;
use crate::parallel::in_parallel_watched;
use crate::{Progress, ProgressFn};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;
use std::ops::Range;

/// How far ahead an earlier surface counts, in layer heights. Surfaces were found up to 0.7 layer heights too deep; from 2 on other
/// branches of the part come within reach.
pub(crate) const CLIP_REACH: f64 = 1.5;

/// By the numbers of sheets the triangles of earlier ones that they pass through, by sheet and triangle, rising.
pub(crate) type Met = BTreeMap<usize, Vec<[u32; 2]>>;

/// What some sheets meet of earlier ones.
pub(crate) fn earlier_met(all: &AllTriangles, sheets: &[usize], progress: ProgressFn) -> Result<Met, TrimError> {
    let earlier = |k: usize, _: ProgressFn| {
        let sheet = sheets[k];
        let mut met: Vec<[u32; 2]> = Vec::new();
        for triangle in 0..all.count(sheet) {
            let corners = all.corners([sheet as u32, triangle]);
            all.near(corners, |place| {
                if (place[0] as usize) < sheet && meet(corners, all.corners(place)).is_some() {
                    met.push(place);
                }
            });
        }
        met.sort_unstable();
        met.dedup();
        (sheet, met)
    };
    let met = in_parallel_watched(sheets.len(), "clip", progress, earlier).ok_or(TrimError::Cancelled)?;
    Ok(met.into_iter().collect())
}

/// What came of clipping.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clipped {
    /// Crossings before.
    pub found: SurfaceCrossings,
    /// Crossings that are left: where the earlier surface ends, or the later one cannot be cut.
    pub left: SurfaceCrossings,
    /// Surfaces that were clipped.
    pub surfaces: usize,
    /// Area that was taken off them, in square millimetres.
    pub area_mm2: f64,
}

impl Trimmer {
    /// Clips trimmed sheets where they pass below earlier ones.
    ///
    /// # Arguments
    /// * `sheets`: in build order, trimmed to this solid, counter-clockwise seen from where the growth goes. Those that cross an
    ///   earlier one are replaced.
    /// * `height_mm`: layer height, for what is ahead.
    /// * `progress`: called with the stages `crossings` and `clip`; may cancel, and then the sheets may be clipped in part.
    ///
    /// # Returns
    /// What was found, what was taken off, and what is left.
    ///
    /// # Errors
    /// [`TrimError::Cancelled`]; others as for [`Trimmer::trim`] if the sheets are not as trimming leaves them. A sheet that cannot
    /// be cut stays as it is: its crossings are among those left.
    ///
    /// # Cost
    /// About that of [`count_crossings`](super::count_crossings), and some microseconds for each triangle of a sheet that passes through an
    /// earlier one. The same on any number of threads.
    pub fn clip(
        &self,
        sheets: &mut [TrimmedSheet],
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<Clipped, TrimError> {
        let numbers: Vec<usize> = (0..sheets.len()).collect();
        let surfaces = slices(sheets);
        let all = AllTriangles::checked(&surfaces)?;
        let met = earlier_met(&all, &numbers, progress)?;
        let (changed, clipped) = self.clip_met(sheets, &all, &met, 0..sheets.len(), height_mm, progress)?;
        changed.into_iter().for_each(|(sheet, left)| sheets[sheet] = left);
        Ok(clipped)
    }

    /// What is left of the sheets that lose something, of those that `met` tells of, and what came of clipping in a range of the sheets. In `met` are also all that these meet,
    /// and those that they meet, and so on, and all that meet one of the range.
    pub(crate) fn clip_met(
        &self,
        sheets: &[TrimmedSheet],
        all: &AllTriangles,
        met: &Met,
        range: Range<usize>,
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<(BTreeMap<usize, TrimmedSheet>, Clipped), TrimError> {
        // Where an edge passes through a triangle, two triangles pass through each other.
        let mut is_met = vec![false; sheets.len()];
        for (&sheet, met) in met.iter().filter(|(_, met)| !met.is_empty()) {
            is_met[sheet] = true;
            met.iter().for_each(|place| is_met[place[0] as usize] = true);
        }
        let is_counted = |sheet: usize| range.contains(&sheet);
        let before = all.crossings(is_counted, |sheet| is_met[sheet], progress)?;
        let found = counted(&before);
        if !is_met.contains(&true) {
            return Ok((BTreeMap::new(), Clipped { found, left: found, ..Clipped::default() }));
        }
        let changed = self.clipped(sheets, all, met, height_mm, progress)?;
        let left = counted(&all.crossings_with(&changed, &before, is_counted, progress)?);
        let mut clipped = Clipped { found, left, ..Clipped::default() };
        for (&sheet, of_sheet) in changed.range(range) {
            clipped.surfaces += 1;
            clipped.area_mm2 += sheets[sheet].area() - of_sheet.area();
        }
        Ok((changed, clipped))
    }

    /// The sheets that lose something.
    fn clipped(
        &self,
        sheets: &[TrimmedSheet],
        all: &AllTriangles,
        met: &Met,
        height_mm: f64,
        progress: ProgressFn,
    ) -> Result<BTreeMap<usize, TrimmedSheet>, TrimError> {
        let mut clipped: BTreeMap<usize, TrimmedSheet> = BTreeMap::new();
        for (&sheet, met) in met.iter().filter(|(_, met)| !met.is_empty()) {
            let report = Progress { stage: "clip", done: sheet as u64, total: sheets.len() as u64 };
            if progress(report).is_break() {
                return Err(TrimError::Cancelled);
            }
            // In order of the sheets: what an earlier one has lost is no wall for later ones.
            let wall = Wall::new(met, all, &clipped);
            let below = Below { all, own: sheet as u32, reach: CLIP_REACH * height_mm };
            if let Some(left) = self.clip_one(&sheets[sheet], &wall, &below)? {
                clipped.insert(sheet, left);
            }
        }
        Ok(clipped)
    }

    /// What is left of a sheet; `None` if all of it is.
    fn clip_one(&self, sheet: &TrimmedSheet, wall: &Wall, below: &Below) -> Result<Option<TrimmedSheet>, TrimError> {
        if wall.triangles.is_empty() {
            return Ok(None);
        }
        let cut = Sheet::new(&sheet.vertices, &sheet.triangles)?;
        let solid = match Solid::new(&wall.points, &wall.triangles) {
            // What is left of earlier sheets there has no area.
            Err(TrimError::EmptyMesh) => return Ok(None),
            solid => solid?,
        };
        // A sheet that cannot be cut stays: what it crosses is counted as left.
        let pieces = match Pieces::cut(&cut, &solid, &|_, _| Ok(())) {
            Err(TrimError::Tangled { .. }) => return Ok(None),
            pieces => pieces?,
        };
        let gone = below.pieces(&pieces);
        if !gone.contains(&true) {
            return Ok(None);
        }
        let keep: Vec<bool> = gone.iter().map(|gone| !gone).collect();
        let kinds: BTreeMap<[u32; 2], BoundaryKind> =
            sheet.boundary.iter().map(|edge| (sorted(edge.ends), edge.kind)).collect();
        let border = |piece: usize, side: usize| {
            let edge = pieces.border_edge(&cut, piece, side);
            edge.and_then(|edge| kinds.get(&sorted(edge)).copied()).unwrap_or(BoundaryKind::Border)
        };
        let mut surface = Surface::of(&pieces, &keep, border, |_, _| BoundaryKind::Border);
        remove_slivers(&mut surface, &self.solid);
        let mut left = surface.finish(&self.solid);
        left.sources.iter_mut().for_each(|source| *source = sheet.sources[*source as usize]);
        Ok(Some(left))
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// What is left of the triangles that a sheet is clipped to.
struct Wall {
    points: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

impl Wall {
    fn new(met: &[[u32; 2]], all: &AllTriangles, clipped: &BTreeMap<usize, TrimmedSheet>) -> Wall {
        let mut wall = Wall { points: Vec::new(), triangles: Vec::new() };
        for of_sheet in met.chunk_by(|a, b| a[0] == b[0]) {
            match clipped.get(&(of_sheet[0][0] as usize)) {
                None => of_sheet.iter().for_each(|&place| wall.push(all.corners(place).map(|p| *p))),
                Some(left) => {
                    // Pieces of these triangles and what was put together with them: all that lies in their boxes.
                    for corners in &left.triangles {
                        let corners = corners.map(|corner| left.vertices[corner as usize]);
                        let bounds = Bounds::of(&corners);
                        let meets = |&place: &[u32; 2]| bounds.meets(&Bounds::of(all.corners(place)));
                        if of_sheet.iter().copied().any(|place| meets(&place)) {
                            wall.push(corners);
                        }
                    }
                }
            }
        }
        wall
    }

    fn push(&mut self, corners: [Point3<f64>; 3]) {
        let first = self.points.len() as u32;
        self.points.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }
}

/// Tells what of a sheet lies below earlier ones.
struct Below<'a> {
    all: &'a AllTriangles<'a>,
    own: u32,
    reach: f64,
}

impl Below<'_> {
    /// For each piece whether it does.
    fn pieces(&self, pieces: &Pieces) -> Vec<bool> {
        let count = pieces.corners.len();
        let mut gone: Vec<bool> = (0..count).map(|piece| pieces.rise[piece].iter().any(|&rise| rise > 0)).collect();
        let mut waiting: Vec<usize> = (0..count).filter(|&piece| gone[piece]).collect();
        // What is asked once is not asked again: whether a piece lies below does not depend on the way to it.
        let mut asked = gone.clone();
        while let Some(piece) = waiting.pop() {
            for side in 0..3 {
                let across = pieces.across[piece][side];
                // A cut parts what lies below from what does not: the walk ends there.
                if across == NONE || pieces.rise[piece][side] != 0 {
                    continue;
                }
                let next = across as usize / 3;
                if !std::mem::replace(&mut asked[next], true) && self.is_below(pieces, next) {
                    gone[next] = true;
                    waiting.push(next);
                }
            }
        }
        gone
    }

    /// Whether an earlier surface that faces the same way lies ahead.
    fn is_below(&self, pieces: &Pieces, piece: usize) -> bool {
        let [a, b, c] = pieces.corners[piece].map(|corner| pieces.points[corner as usize]);
        let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let Some(way) = (b - a).cross(&(c - a)).try_normalize(0.0) else { return false };
        let end = middle + way * self.reach;
        let mut found = false;
        self.all.ahead(&middle, &way, self.reach, |place| {
            if place[0] < self.own && !found {
                let corners = self.all.corners(place);
                found = normal(corners).dot(&way) > 0.0 && crosses([&middle, &end], corners, Moves::Point);
            }
        });
        found
    }
}

fn normal([a, b, c]: [&Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
