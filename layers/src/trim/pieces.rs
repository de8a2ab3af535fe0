//! The sheet, cut into pieces along the mesh, and the winding number of each piece.
//!
//! An edge of the sheet is cut where it passes through a triangle of the mesh, once for both of its triangles, so
//! that the pieces of neighbours fit. A triangle of the sheet is cut along its segments as a [`Patch`]. Numbers of
//! pieces follow from one of each connected part of the sheet, by the rises of the edges between them.

use super::crossing::{End, meet, pierce};
use super::error::{TrimError, Watch};
use super::patch::{NEAR, NONE, Patch, SIDE};
use super::sheet::Sheet;
use super::solid::Solid;
use crate::boxes::Bounds;
use nalgebra::Point3;

/// A sheet in pieces: a manifold of triangles that covers the sheet.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) corners: Vec<[u32; 3]>,
    /// Half-edge `3 piece + k` across each side, or [`NONE`].
    pub(super) across: Vec<[u32; 3]>,
    /// By how much the winding number of a piece is greater than that of the one across the side. Not zero only where
    /// the mesh passes through the sheet.
    pub(super) rise: Vec<[i32; 3]>,
    /// The triangle of the sheet that each piece is part of.
    pub(super) sources: Vec<u32>,
    /// A vertex of the sheet that surely has the winding number of the piece, or [`NONE`].
    known: Vec<u32>,
    /// The edge of the sheet that each cut lies on; their points come after those of the sheet.
    cut_edges: Vec<u32>,
}

/// The segment that triangle `sheet` shares with triangle `mesh`.
struct Segment {
    sheet: u32,
    mesh: u32,
    ends: [End; 2],
}

/// Where an edge of the sheet passes through a triangle of the mesh.
struct Passage {
    edge: u32,
    mesh: u32,
    /// Distance from the lower vertex, [`SIDE`] for the whole edge.
    along: i64,
    at: Point3<f64>,
    /// Its place on the edge: 0 for the lower vertex, then the cuts in their order, then the higher vertex.
    place: u32,
}

/// The places where edges of the sheet are cut.
struct Cuts {
    passages: Vec<Passage>,
    /// For each edge its first cut; one more at the end.
    first: Vec<u32>,
    along: Vec<i64>,
}

impl Pieces {
    pub(super) fn cut(sheet: &Sheet, solid: &Solid, watch: Watch) -> Result<Pieces, TrimError> {
        let segments = segments(sheet, solid);
        let mut pieces = Pieces { points: sheet.points.to_vec(), ..Pieces::default() };
        let cuts = Cuts::new(sheet, solid, &segments, &mut pieces.points);
        for (edge, cuts) in (0..).zip(cuts.first.windows(2)) {
            pieces.cut_edges.extend((cuts[0]..cuts[1]).map(|_| edge));
        }
        // The two half-edges on each part of each edge of the sheet, to join the pieces of neighbours: an edge with `n` cuts has `n + 1`
        // parts.
        let mut halves = vec![[NONE; 2]; sheet.edges.ends.len() + cuts.along.len()];
        let mut cutter = Cutter::default();
        let mut groups = segments.chunk_by(|a, b| a.sheet == b.sheet).peekable();
        for triangle in 0..sheet.triangles.len() {
            watch(triangle, sheet.triangles.len())?;
            match groups.next_if(|group| group[0].sheet as usize == triangle) {
                Some(group) => cutter.cut(&mut pieces, &mut halves, sheet, solid, &cuts, group)?,
                None => pieces.take_whole(&mut halves, sheet, &cuts, triangle),
            }
        }
        pieces.link(&halves);
        Ok(pieces)
    }

    /// The ends of the edge of the sheet on which a side of a piece lies that has nothing across.
    pub(super) fn border_edge(&self, sheet: &Sheet, piece: usize, side: usize) -> Option<[u32; 2]> {
        let [a, b] = [self.corners[piece][side], self.corners[piece][(side + 1) % 3]];
        let cut = |point: u32| {
            let cut = (point as usize).checked_sub(sheet.points.len())?;
            self.cut_edges.get(cut).map(|&edge| sheet.edges.ends[edge as usize])
        };
        if a.max(b) < sheet.points.len() as u32 { Some([a, b]) } else { cut(a).or_else(|| cut(b)) }
    }

    fn take_whole(&mut self, halves: &mut [[u32; 2]], sheet: &Sheet, cuts: &Cuts, triangle: usize) {
        let first = 3 * self.corners.len() as u32;
        for (half, &edge) in (first..).zip(&sheet.edges.sides[triangle]) {
            put(&mut halves[cuts.part(edge, 0)], half);
        }
        self.push(sheet.triangles[triangle], [NONE; 3], [0; 3], triangle as u32, sheet.triangles[triangle][0]);
    }

    fn push(&mut self, corners: [u32; 3], across: [u32; 3], rise: [i32; 3], source: u32, known: u32) {
        self.corners.push(corners);
        self.across.push(across);
        self.rise.push(rise);
        self.sources.push(source);
        self.known.push(known);
    }

    /// Joins the pieces along the parts of the sheet's edges. What rises there was found on either side.
    fn link(&mut self, halves: &[[u32; 2]]) {
        for &[a, b] in halves.iter().filter(|halves| halves[1] != NONE) {
            let [(p, i), (q, j)] = [a, b].map(|half| (half as usize / 3, half as usize % 3));
            (self.across[p][i], self.across[q][j]) = (b, a);
            // Each side has what it found to its left; across the edge both add up, with opposite signs.
            let rise = self.rise[p][i] - self.rise[q][j];
            (self.rise[p][i], self.rise[q][j]) = (rise, -rise);
        }
    }

    /// The winding number of each piece, for a closed mesh.
    pub(super) fn numbers(&self, solid: &Solid) -> Vec<i32> {
        let mut numbers = vec![0; self.corners.len()];
        let mut seen = vec![false; self.corners.len()];
        let mut part = Vec::new();
        for start in 0..self.corners.len() {
            if std::mem::replace(&mut seen[start], true) {
                continue;
            }
            part.clear();
            part.push(start);
            let mut at = 0;
            while let Some(&piece) = part.get(at) {
                at += 1;
                for k in 0..3 {
                    let next = self.across[piece][k];
                    if next != NONE && !std::mem::replace(&mut seen[next as usize / 3], true) {
                        numbers[next as usize / 3] = numbers[piece] - self.rise[piece][k];
                        part.push(next as usize / 3);
                    }
                }
            }
            // Numbers so far are relative to the first piece of the part. One exact count shifts them all.
            let known = part.iter().find(|&&piece| self.known[piece] != NONE);
            let shift = match known {
                Some(&piece) => solid.winding(&self.points[self.known[piece] as usize]) - numbers[piece],
                None => self.number_at_largest(solid, &part) - numbers[self.largest(&part)],
            };
            part.iter().for_each(|&piece| numbers[piece] += shift);
        }
        numbers
    }

    /// For a part of the sheet all of whose vertices lie on the mesh, up to rounding.
    fn number_at_largest(&self, solid: &Solid, part: &[usize]) -> i32 {
        let [a, b, c] = self.corners[self.largest(part)].map(|corner| self.points[corner as usize].coords);
        solid.winding(&Point3::from((a + b + c) / 3.0))
    }

    fn largest(&self, part: &[usize]) -> usize {
        let area_sq = |piece: usize| {
            let [a, b, c] = self.corners[piece].map(|corner| self.points[corner as usize]);
            (b - a).cross(&(c - a)).norm_squared()
        };
        part.iter().copied().max_by(|&a, &b| area_sq(a).total_cmp(&area_sq(b))).unwrap_or(part[0])
    }
}

/// All segments, by triangles of the sheet.
fn segments(sheet: &Sheet, solid: &Solid) -> Vec<Segment> {
    let mut segments = Vec::new();
    for triangle in 0..sheet.triangles.len() {
        let corners = sheet.corners(triangle);
        solid.tree.meeting(&Bounds::of(corners), |mesh| {
            if let Some(ends) = meet(corners, solid.corners(mesh)) {
                segments.push(Segment { sheet: triangle as u32, mesh, ends });
            }
        });
    }
    segments
}

fn put(halves: &mut [u32; 2], half: u32) {
    let at = usize::from(halves[0] != NONE);
    halves[at] = half;
}

/// Grid units for a share of an edge.
fn units(share: f64) -> i64 {
    (share * SIDE as f64).round() as i64
}

impl Cuts {
    /// Finds them and appends a point for each.
    fn new(sheet: &Sheet, solid: &Solid, segments: &[Segment], points: &mut Vec<Point3<f64>>) -> Cuts {
        let mut keys = Vec::new();
        for segment in segments {
            for end in segment.ends {
                if let End::Sheet(k) = end {
                    keys.push((sheet.edges.sides[segment.sheet as usize][k as usize], segment.mesh));
                }
            }
        }
        // Both triangles at an edge, and both that share an edge of the mesh, name the same passage: it is computed once, so that its
        // point is one.
        keys.sort_unstable();
        keys.dedup();
        let passage = |(edge, mesh): (u32, u32)| {
            let [low, high] = sheet.edges.ends[edge as usize].map(|vertex| &sheet.points[vertex as usize]);
            let (share, at) = pierce(low, high, solid.corners(mesh));
            Passage { edge, mesh, along: units(share), at, place: 0 }
        };
        let mut passages: Vec<_> = keys.into_iter().map(passage).collect();
        passages.sort_unstable_by_key(|passage| (passage.edge, passage.along, passage.mesh));
        let mut cuts = Cuts { passages: Vec::new(), first: vec![0; sheet.edges.ends.len() + 1], along: Vec::new() };
        for same in passages.chunk_by_mut(|a, b| a.edge == b.edge) {
            let before = cuts.along.len();
            let (mut last, mut count) = (0, 0);
            for passage in same.iter_mut() {
                // Passages nearer to each other, or to an end, than `NEAR` are one place: an edge of less length would be rounding alone.
                if passage.along - last > NEAR && SIDE - passage.along > NEAR {
                    (last, count) = (passage.along, count + 1);
                    cuts.along.push(passage.along);
                    points.push(passage.at);
                }
                passage.place = count;
            }
            for passage in same.iter_mut().filter(|passage| SIDE - passage.along <= NEAR) {
                passage.place = count + 1;
            }
            cuts.first[same[0].edge as usize + 1] = (cuts.along.len() - before) as u32;
        }
        // Counts become starts.
        let mut sum = 0;
        for first in &mut cuts.first {
            sum += *first;
            *first = sum;
        }
        passages.sort_unstable_by_key(|passage| (passage.edge, passage.mesh));
        cuts.passages = passages;
        cuts
    }

    /// The cuts of an edge, in their order.
    fn of(&self, edge: u32) -> std::ops::Range<u32> {
        self.first[edge as usize]..self.first[edge as usize + 1]
    }

    /// The number of a part of an edge: part 0 begins at the lower vertex.
    fn part(&self, edge: u32, part: u32) -> usize {
        (edge + self.first[edge as usize] + part) as usize
    }

    /// Where on an edge a mesh triangle passes.
    fn place(&self, edge: u32, mesh: u32) -> u32 {
        let found = self.passages.binary_search_by_key(&(edge, mesh), |passage| (passage.edge, passage.mesh));
        found.map_or_else(|_| unreachable!("every end on an edge was listed"), |at| self.passages[at].place)
    }
}

/// Cuts one triangle after the other, with the same lists.
#[derive(Default)]
struct Cutter {
    patch: Patch,
    /// The number of each point of the patch among all points.
    numbers: Vec<u32>,
    /// For each side the points of the patch on it, from the lower vertex to the higher one.
    sides: [Vec<u32>; 3],
    /// For each point of the patch its place on the side on which it was put.
    places: Vec<u32>,
    /// Edges of the mesh that pass, and their points.
    pierced: Vec<(u32, u32)>,
    /// At which corners of the sheet's triangle a segment ends, exactly or for being near. The others are off the mesh,
    /// so that their winding number is that of the pieces around them.
    touched: [bool; 3],
}

impl Cutter {
    fn cut(
        &mut self,
        pieces: &mut Pieces,
        halves: &mut [[u32; 2]],
        sheet: &Sheet,
        solid: &Solid,
        cuts: &Cuts,
        segments: &[Segment],
    ) -> Result<(), TrimError> {
        let triangle = segments[0].sheet as usize;
        self.place_border(sheet, cuts, triangle);
        let frame = Frame { corners: sheet.corners(triangle) };
        self.touched = [false; 3];
        self.pierced.clear();
        for segment in segments {
            for end in segment.ends {
                if let End::Mesh(k) = end {
                    self.pierce(pieces, &frame, solid, solid.sides[segment.mesh as usize][k as usize]);
                }
            }
        }
        for segment in segments {
            let ends = segment.ends.map(|end| match end {
                End::Sheet(k) => {
                    let place = cuts.place(sheet.edges.sides[triangle][k as usize], segment.mesh);
                    self.sides[k as usize][place as usize]
                }
                End::Mesh(k) => {
                    let edge = solid.sides[segment.mesh as usize][k as usize];
                    let found = self.pierced.iter().find(|(pierced, _)| *pierced == edge);
                    found.map_or_else(|| unreachable!("every edge was pierced before"), |&(_, point)| point)
                }
            });
            for end in ends.into_iter().filter(|&end| end < 3) {
                self.touched[end as usize] = true;
            }
            let numbers = &mut self.numbers;
            let cross = |ends: [u32; 2], share: f64| {
                let [a, b] = ends.map(|point| pieces.points[numbers[point as usize] as usize]);
                numbers.push(pieces.points.len() as u32);
                pieces.points.push(a + (b - a) * share);
            };
            self.patch.connect(ends, 1, cross).map_err(|_| TrimError::Tangled { triangle })?;
        }
        self.patch.relax(frame.metric());
        self.hand_over(pieces, halves, sheet, cuts, triangle);
        Ok(())
    }

    /// Puts the corners and the cuts of the sides into the patch.
    fn place_border(&mut self, sheet: &Sheet, cuts: &Cuts, triangle: usize) {
        self.patch.reset();
        self.numbers.clear();
        self.numbers.extend(sheet.triangles[triangle]);
        self.places.clear();
        self.places.extend([0; 3]);
        for k in 0..3 {
            let edge = sheet.edges.sides[triangle][k];
            let down = sheet.runs_down(triangle, k);
            let ends = if down { [(k + 1) % 3, k] } else { [k, (k + 1) % 3] }.map(|corner| corner as u32);
            self.sides[k].clear();
            self.sides[k].push(ends[0]);
            for (place, cut) in (1..).zip(cuts.of(edge)) {
                let along = cuts.along[cut as usize];
                self.sides[k].push(self.patch.insert_on_side(k, if down { SIDE - along } else { along }));
                self.numbers.push(sheet.points.len() as u32 + cut);
                self.places.push(place);
            }
            self.sides[k].push(ends[1]);
        }
    }

    /// Puts the point into the patch where an edge of the mesh passes, unless it is there.
    fn pierce(&mut self, pieces: &mut Pieces, frame: &Frame, solid: &Solid, edge: u32) {
        if self.pierced.iter().any(|(pierced, _)| *pierced == edge) {
            return;
        }
        let [low, high] = solid.ends[edge as usize].map(|vertex| &solid.points[vertex as usize]);
        let (_, at) = pierce(low, high, frame.corners);
        let before = self.patch.points.len();
        let point = self.patch.insert_inside(frame.shares(&at).map(units));
        if self.patch.points.len() > before {
            self.numbers.push(pieces.points.len() as u32);
            pieces.points.push(at);
        }
        self.pierced.push((edge, point));
    }

    /// Appends the triangles of the patch to the pieces.
    fn hand_over(&self, pieces: &mut Pieces, halves: &mut [[u32; 2]], sheet: &Sheet, cuts: &Cuts, triangle: usize) {
        let patch = &self.patch;
        let base = 3 * pieces.corners.len() as u32;
        for first in (0..patch.from.len() as u32).step_by(3) {
            let halves_here = [first, first + 1, first + 2];
            let corners = halves_here.map(|half| patch.from[half as usize]);
            for half in halves_here.into_iter().filter(|&half| patch.twin[half as usize] == NONE) {
                let k = patch.side(half);
                let edge = sheet.edges.sides[triangle][k];
                let down = sheet.runs_down(triangle, k);
                let last = cuts.of(edge).len() as u32;
                // The part of the edge that begins at the lower one of its two ends.
                let lower = if down { patch.to(half) } else { patch.from[half as usize] };
                let place = if lower < 3 { 0 } else { self.places[lower as usize] };
                debug_assert!(place <= last);
                put(&mut halves[cuts.part(edge, place)], base + half);
            }
            let known = corners.into_iter().find(|&corner| corner < 3 && !self.touched[corner as usize]);
            let known = known.map_or(NONE, |corner| sheet.triangles[triangle][corner as usize]);
            let across = halves_here.map(|half| match patch.twin[half as usize] {
                NONE => NONE,
                twin => base + twin,
            });
            let rise = halves_here.map(|half| patch.rise[half as usize]);
            pieces.push(corners.map(|c| self.numbers[c as usize]), across, rise, triangle as u32, known);
        }
    }
}

/// A triangle of the sheet and the measures in which points of its plane are given.
struct Frame<'a> {
    corners: [&'a Point3<f64>; 3],
}

impl Frame<'_> {
    /// Squared lengths of the sides from corner 0, and their product between.
    fn metric(&self) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let (u, v) = (b - a, c - a);
        [u.norm_squared(), u.dot(&v), v.norm_squared()]
    }

    /// The shares of the two sides from corner 0 that lead to a point.
    fn shares(&self, p: &Point3<f64>) -> [f64; 2] {
        let [a, b, c] = self.corners;
        let (u, v, w) = (b - a, c - a, p - a);
        let normal = u.cross(&v);
        let area = normal.norm_squared();
        [w.cross(&v), u.cross(&w)].map(|part| {
            let share = part.dot(&normal) / area;
            // A triangle without area has no shares; anywhere inside will do.
            if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.25 }
        })
    }
}
