//! Curves whose ends nearly meet become one.
//!
//! Each curve costs a start and a way to it. Where ends of two open curves lie near each other, a straight way over the surface joins
//! them, if a bead can be laid along it: it has room for the narrowest bead between boundaries, crosses no curve, and keeps half a
//! bead from the middle of all others. The nearest ends are joined first, each end once, and no curve becomes a ring.

use super::crossing::cross;
use super::curve::locate;
use super::segments::Segments;
use super::spacing::Spacing;
use super::thin::SAME;
use super::watch::Watch;
use crate::level_set::LevelField;
use crate::mesh::{SurfaceMesh, SurfacePoint, on_segment};
use crate::path::{PathError, PathPoint, SurfacePath};
use crate::union_find::{join, root};
use nalgebra::Point3;

/// Points of a way are at most this far apart, in beads.
const STEP: f64 = 0.25;
/// How far the surface may bend away from the straight way, in beads.
const MAX_BEND: f64 = 0.25;
/// A way keeps this far from the middle of other curves, in beads.
const CLEARANCE: f64 = 0.5;
/// From its ends so far along the two curves that it joins, in beads, it does not.
const BESIDE_END: f64 = 1.5;
/// Side of a cell in which segments are looked up, in beads: what is nearer than the clearance is found in the next cell.
const CELL: f64 = 1.0;

/// An end of a curve: twice its number, and one more for its last point.
type End = u32;

fn curve_of(end: End) -> usize {
    end as usize / 2
}

fn is_last(end: End) -> bool {
    end % 2 == 1
}

struct Joiner<'a, 'd> {
    field: &'a LevelField<'d>,
    spacing: &'a Spacing<'a, 'd>,
    bead: f64,
    paths: &'a [SurfacePath],
    segments: Segments,
    /// Ways found so far, both ends included.
    ways: Vec<Vec<PathPoint>>,
    /// For each end the one that it is joined to, and the way between them.
    joined: Vec<Option<(End, usize)>>,
}

/// Joins open curves whose ends are at most `distance` mm apart. Returns the curves, in the order of the first of each, and the number of
/// joints.
pub(super) fn joined(
    field: &LevelField,
    spacing: &Spacing,
    [bead, distance]: [f64; 2],
    paths: Vec<SurfacePath>,
    watch: Watch,
) -> Result<(Vec<SurfacePath>, usize), PathError> {
    let pairs = pairs(&paths, distance);
    if pairs.is_empty() {
        return Ok((paths, 0));
    }
    let mut segments = Segments::new(CELL * bead);
    segments.add_all(&paths);
    let joined = vec![None; 2 * paths.len()];
    let mut joiner = Joiner { field, spacing, bead, paths: &paths, segments, ways: Vec::new(), joined };
    let mut parents: Vec<u32> = (0..paths.len() as u32).collect();
    for [a, b] in pairs {
        let curves = [a, b].map(|end| root(&mut parents, curve_of(end) as u32));
        // Each end once; and both ends of one curve, whatever it has been joined from, would close a ring.
        if joiner.joined[a as usize].is_some() || joiner.joined[b as usize].is_some() || curves[0] == curves[1] {
            continue;
        }
        watch()?;
        if let Some(way) = joiner.way([a, b]) {
            let number = joiner.ways.len();
            joiner.ways.push(way);
            (joiner.joined[a as usize], joiner.joined[b as usize]) = (Some((b, number)), Some((a, number)));
            join(&mut parents, curves[0], curves[1]);
        }
    }
    Ok((joiner.curves(), joiner.ways.len()))
}

/// Pairs of ends of different open curves that are near each other, the nearest first.
fn pairs(paths: &[SurfacePath], distance: f64) -> Vec<[End; 2]> {
    let ends_of = |(number, path): (u32, &SurfacePath)| {
        let ends = [path.points.first(), path.points.last()]
            .map(|point| point.filter(|_| !path.closed && path.points.len() > 1));
        [0, 1].map(|k| ends[k as usize].map(|point| (point.at.position, 2 * number + k)))
    };
    let mut ends: Vec<(Point3<f64>, End)> = (0..).zip(paths).flat_map(ends_of).flatten().collect();
    // A sweep along x: what is near in space is near along each axis.
    ends.sort_by(|(p, a), (q, b)| p.x.total_cmp(&q.x).then(a.cmp(b)));
    let mut found: Vec<(f64, [End; 2])> = Vec::new();
    for (k, &(p, a)) in ends.iter().enumerate() {
        let beside = ends[k + 1..].iter().take_while(|(q, _)| q.x - p.x <= distance);
        let near = beside.map(|&(q, b)| ((q - p).norm(), [a.min(b), a.max(b)]));
        found.extend(near.filter(|&(apart, [a, b])| apart <= distance && curve_of(a) != curve_of(b)));
    }
    found.sort_by(|(one, a), (other, b)| one.total_cmp(other).then(a.cmp(b)));
    found.into_iter().map(|(_, pair)| pair).collect()
}

impl Joiner<'_, '_> {
    fn mesh(&self) -> &SurfaceMesh {
        self.field.distance().mesh()
    }

    fn point(&self, end: End) -> &PathPoint {
        let points = &self.paths[curve_of(end)].points;
        &points[if is_last(end) { points.len() - 1 } else { 0 }]
    }

    /// A way between two ends along which a bead can be laid, both ends included.
    fn way(&self, ends: [End; 2]) -> Option<Vec<PathPoint>> {
        let [from, to] = ends.map(|end| self.point(end));
        let (p, across) = (from.at.position, to.at.position - from.at.position);
        let steps = (across.norm() / (STEP * self.bead)).ceil().max(1.0);
        let mut way = vec![*from];
        let mut triangle = from.at.triangle;
        for k in 1..steps as usize {
            let share = k as f64 / steps;
            let wanted = p + across * share;
            let at = locate(self.mesh(), triangle, wanted);
            let room = self.field.distance().at(at.triangle, at.barycentric).distance;
            if (at.position - wanted).norm() > MAX_BEND * self.bead || room < self.spacing.least_single() {
                return None;
            }
            triangle = at.triangle;
            let width = from.width + (to.width - from.width) * share;
            way.push(PathPoint { at, width: width.min(self.spacing.single(room)), kind: from.kind });
        }
        // A way over a notch, or on a sheet beside, ends somewhere else.
        let arrived = locate(self.mesh(), triangle, to.at.position);
        if (arrived.position - to.at.position).norm() > SAME * self.bead {
            return None;
        }
        way.push(*to);
        self.is_clear(&way, ends).then_some(way)
    }

    /// Whether a way crosses no curve and no other way, and keeps off all but the ends that it joins.
    fn is_clear(&self, way: &[PathPoint], ends: [End; 2]) -> bool {
        let inner = &way[1..way.len() - 1];
        let keeps_off = |other: [&PathPoint; 2]| {
            let line = other.map(|point| point.at.position);
            inner.iter().all(|point| {
                let p = point.at.position;
                (on_segment(line, p) - p).norm() >= CLEARANCE * self.bead
            })
        };
        let crosses = |other: [&PathPoint; 2]| {
            let at = |point: &'_ PathPoint| -> SurfacePoint { point.at };
            let other = other.map(at);
            way.windows(2).any(|pair| {
                let one = [&pair[0], &pair[1]].map(at);
                cross(self.mesh(), [&one[0], &one[1]], [&other[0], &other[1]])
            })
        };
        let others = way.windows(2).flat_map(|pair| self.segments.along([pair[0].at.position, pair[1].at.position]));
        let clear_of_curves = others.into_iter().all(|[number, k]| {
            let (path, k) = (&self.paths[number as usize], k as usize);
            let other = path.segment(k);
            let own = ends.into_iter().find(|&end| curve_of(end) == number as usize);
            match own.map(|end| self.along(end, k)) {
                // The segment at the end touches the way, of course.
                Some(along) if along <= 0.0 => true,
                Some(along) if along < BESIDE_END * self.bead => !crosses(other),
                _ => !crosses(other) && keeps_off(other),
            }
        });
        clear_of_curves
            && self.ways.iter().flat_map(|way| way.windows(2)).all(|pair| {
                let other = [&pair[0], &pair[1]];
                !crosses(other) && keeps_off(other)
            })
    }

    /// How far along its curve a segment is from an end; beyond [`BESIDE_END`] it is not measured.
    fn along(&self, end: End, k: usize) -> f64 {
        let path = &self.paths[curve_of(end)];
        let (last, most) = (path.segments() - 1, BESIDE_END * self.bead);
        let before = if is_last(end) { last - k } else { k };
        let mut along = 0.0;
        for step in 0..before {
            let [a, b] = path.segment(if is_last(end) { last - step } else { step });
            along += (b.at.position - a.at.position).norm();
            if along >= most {
                break;
            }
        }
        along
    }

    /// All curves, with what is joined to them.
    fn curves(&self) -> Vec<SurfacePath> {
        let mut done = vec![false; self.paths.len()];
        let mut curves = Vec::new();
        for number in 0..self.paths.len() {
            if done[number] {
                continue;
            }
            let path = &self.paths[number];
            let mut whole = SurfacePath { points: Vec::new(), closed: path.closed, region: path.region };
            // From an end that nothing is joined to: there is one, since no curves become a ring.
            let mut at = self.outermost(2 * number as End);
            loop {
                done[curve_of(at)] = true;
                let points = &self.paths[curve_of(at)].points;
                match is_last(at) {
                    true => whole.points.extend(points.iter().rev()),
                    false => whole.points.extend(points),
                }
                let Some((next, way)) = self.joined[(at ^ 1) as usize] else { break };
                let way = &self.ways[way];
                let inner = &way[1..way.len() - 1];
                // Ways run from the lower end to the higher one.
                match at ^ 1 < next {
                    true => whole.points.extend(inner),
                    false => whole.points.extend(inner.iter().rev()),
                }
                at = next;
            }
            curves.push(whole);
        }
        curves
    }

    /// The end of what is joined to a curve that lies beyond one of its ends.
    fn outermost(&self, end: End) -> End {
        let mut end = end;
        while let Some((next, _)) = self.joined[end as usize] {
            end = next ^ 1;
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesic::SurfaceDistance;
    use crate::path::BeadKind;
    use std::ops::ControlFlow;

    /// Joints, up to two beads of 1 mm long, of open lines and closed ones on a large plate.
    fn joints(open: &[&[[f64; 2]]], closed: &[&[[f64; 2]]]) -> usize {
        let vertices = [[-20.0, -20.0], [20.0, -20.0], [20.0, 20.0], [-20.0, 20.0]];
        let vertices = vertices.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
        let mesh = SurfaceMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let distance = SurfaceDistance::to_boundary(&mesh, &|_| ControlFlow::Continue(())).unwrap();
        let field = LevelField::new(&distance, 0.01, &|_| ControlFlow::Continue(())).unwrap();
        let spacing = Spacing::new(&field, 1.0, 20.0, true, None);
        let point = |[x, y]: &[f64; 2]| PathPoint {
            at: locate(&mesh, 0, Point3::new(*x, *y, 0.0)),
            width: 1.0,
            kind: BeadKind::Solid,
        };
        let path = |closed: bool| {
            move |line: &&[[f64; 2]]| SurfacePath { points: line.iter().map(point).collect(), closed, region: 0 }
        };
        let paths: Vec<SurfacePath> = open.iter().map(path(false)).chain(closed.iter().map(path(true))).collect();
        let (curves, joints) = joined(&field, &spacing, [1.0, 2.0], paths.clone(), &|| Ok(())).unwrap();
        assert_eq!(curves.len() + joints, paths.len());
        joints
    }

    #[test]
    fn a_joint_crosses_no_other_curve() {
        // So short that no place of it is looked at but its ends: a crossing is all that could be found.
        let gap: [&[[f64; 2]]; 2] = [&[[-8.0, 0.0], [-0.1, 0.0]], &[[0.1, 0.0], [8.0, 0.0]]];
        assert_eq!(joints(&gap, &[]), 1);
        assert_eq!(joints(&gap, &[&[[0.0, -5.0], [0.0, 5.0], [-12.0, 5.0], [-12.0, -5.0]]]), 0);
        // Nor the curve itself, which turns round just before its end.
        let straight: &[[f64; 2]] = &[[0.5, 0.0], [8.0, 0.0]];
        let hook: &[[f64; 2]] = &[[-8.0, -2.0], [0.0, -2.0], [0.0, 0.5], [-0.5, 0.0]];
        assert_eq!(joints(&[&[[-8.0, 0.0], [-0.5, 0.0]], straight], &[]), 1);
        assert_eq!(joints(&[hook, straight], &[]), 0);
    }

    #[test]
    fn a_joint_keeps_half_a_bead_off_other_curves() {
        let gap: [&[[f64; 2]]; 2] = [&[[-8.0, 0.0], [-0.5, 0.0]], &[[0.5, 0.0], [8.0, 0.0]]];
        for (off, wanted) in [(0.49, 0), (0.51, 1)] {
            assert_eq!(joints(&gap, &[&[[0.0, off], [1.0, 4.0], [-1.0, 4.0]]]), wanted, "{off}");
        }
    }

    #[test]
    fn a_joint_keeps_off_other_joints() {
        // Of a hairpin with its ends side by side the second would pass the way of the first by 0.483 beads. The curves themselves are
        // farther off.
        let hairpin: &[[f64; 2]] = &[[0.0, 0.0], [0.0, -8.0], [0.45, -8.0], [0.45, 0.0]];
        let [near, far]: [&[[f64; 2]]; 2] = [&[[-0.1, 0.6], [-8.0, 0.6]], &[[0.45, 1.9], [0.45, 8.0]]];
        assert_eq!(joints(&[hairpin, near, far], &[]), 1);
        assert_eq!([joints(&[hairpin, near], &[]), joints(&[hairpin, far], &[])], [1, 1]);
        let wide: &[[f64; 2]] = &[[0.0, 0.0], [0.0, -8.0], [0.5, -8.0], [0.5, 0.0]];
        assert_eq!(joints(&[wide, near, &[[0.5, 1.9], [0.5, 8.0]]], &[]), 2);
    }

    #[test]
    fn joints_do_not_cross() {
        // Both so short that no place of them is looked at but their ends.
        let corner: &[[f64; 2]] = &[[0.0, -0.04], [0.0, -8.0], [-8.0, -8.0], [-8.0, 0.0], [-0.1, 0.0]];
        let [up, aside]: [&[[f64; 2]]; 2] = [&[[0.0, 0.04], [0.0, 8.0]], &[[0.1, 0.0], [8.0, 0.0]]];
        assert_eq!(joints(&[corner, up, aside], &[]), 1);
    }
}
