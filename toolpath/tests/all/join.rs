//! Curves whose ends nearly meet, joined: against a slow twin that looks at all ends, all segments and the whole boundary.

use crate::common::{boundary_edges, go_on, plate_with_holes, rng, to_boundary, to_edges, to_segment};
use crate::paths::crossings;
use curvlay_toolpath::level_set::LevelField;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::Point3;
use curvlay_toolpath::path::{LayerPaths, PathError, PathOptions, SurfacePath};
use proptest::prelude::*;
use rand::RngExt;
use std::collections::{BTreeSet, HashMap};

const BEAD: f64 = 0.8;
/// Rounding.
const SLACK: f64 = 1e-6;

fn filled(mesh: &SurfaceMesh, join_distance: f64) -> LayerPaths {
    let options = PathOptions { bead: BEAD, join_distance, min_length: 0.0, min_gap: 0.0, ..PathOptions::default() };
    LevelField::new(&to_boundary(mesh), 0.005, &go_on).unwrap().paths(&options, &go_on).unwrap()
}

/// A plane plate with holes of one or more squares.
fn plate(seed: u64, share: f64) -> SurfaceMesh {
    let mut rng = rng(seed);
    plate_with_holes(12, seed, (0..12 * 12).map(|_| rng.random::<f64>() < share).collect())
}

fn bits(p: Point3<f64>) -> [u64; 3] {
    [p.x, p.y, p.z].map(f64::to_bits)
}

fn places(path: &SurfacePath) -> Vec<Point3<f64>> {
    path.points.iter().map(|point| point.at.position).collect()
}

/// An end of a curve: its number, and whether it is its last point.
type End = (usize, bool);

/// A way between ends, and all its points.
type Way = ([End; 2], Vec<Point3<f64>>);

/// The ways that joined curves have and those before have not. Each curve from before is there, whole, forward or backward.
fn ways(before: &[SurfacePath], after: &[SurfacePath]) -> Vec<Way> {
    let mut first = HashMap::new();
    for (number, path) in before.iter().enumerate() {
        let line = places(path);
        first.insert(bits(line[0]), (number, false));
        first.insert(bits(line[line.len() - 1]), (number, true));
    }
    let (mut ways, mut found) = (Vec::new(), 0);
    for path in after {
        let line = places(path);
        let mut at = 0;
        let mut left: Option<(End, Vec<Point3<f64>>)> = None;
        while at < line.len() {
            let Some(&(number, last)) = first.get(&bits(line[at])) else {
                left.as_mut().unwrap().1.push(line[at]);
                at += 1;
                continue;
            };
            let mut piece = places(&before[number]);
            if last {
                piece.reverse();
            }
            assert_eq!(line[at..at + piece.len()], piece);
            found += 1;
            if let Some((from, mut way)) = left.take() {
                way.push(line[at]);
                ways.push(([from, (number, last)], way));
            }
            at += piece.len();
            left = Some(((number, !last), vec![line[at - 1]]));
        }
    }
    assert_eq!(found, before.len());
    ways
}

/// What a bead on a way has to keep off: the rim of the plate, curves and other ways.
struct Slow<'a> {
    mesh: &'a SurfaceMesh,
    rims: Vec<[u32; 2]>,
    curves: &'a [SurfacePath],
    ways: Vec<Way>,
}

impl Slow<'_> {
    fn place(&self, (number, last): End) -> Point3<f64> {
        let line = places(&self.curves[number]);
        if last { line[line.len() - 1] } else { line[0] }
    }

    fn on_plate(&self, p: Point3<f64>) -> bool {
        self.mesh.triangles().iter().any(|t| {
            let [a, b, c] = t.map(|v| self.mesh.vertices()[v as usize]);
            let side = |a: Point3<f64>, b: Point3<f64>| (b - a).cross(&(p - a)).z >= -1e-9;
            side(a, b) && side(b, c) && side(c, a)
        })
    }

    /// Whether a bead can be laid straight from end to end.
    fn is_clear(&self, ends: [End; 2], way: &[Point3<f64>]) -> bool {
        let crosses = |line: &[Point3<f64>]| {
            way.windows(2).any(|one| line.windows(2).any(|other| cross([one[0], one[1]], [other[0], other[1]])))
        };
        let inner = &way[1..way.len() - 1];
        let off = |pair: &[Point3<f64>]| inner.iter().all(|&p| to_segment(p, pair[0], pair[1]) >= 0.5 * BEAD);
        let clear = |(number, path): (usize, &SurfacePath)| {
            let line = places(path);
            let lengths: Vec<f64> = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
            let along = |k: usize| {
                let end = ends.iter().find(|end| end.0 == number)?;
                Some(if end.1 { lengths[k + 1..].iter().sum::<f64>() } else { lengths[..k].iter().sum() })
            };
            line.windows(2).enumerate().all(|(k, pair)| match along(k) {
                Some(along) if along <= 0.0 => true,
                Some(along) if along < 1.5 * BEAD => !crosses(pair),
                _ => !crosses(pair) && off(pair),
            })
        };
        inner.iter().all(|&p| self.on_plate(p) && to_edges(self.mesh, &self.rims, p) >= 0.375 * BEAD)
            && self.curves.iter().enumerate().all(clear)
            && self.ways.iter().all(|(_, line)| !crosses(line) && line.windows(2).all(off))
    }

    /// Joins the nearest ends that can be, again and again.
    fn join(&mut self) {
        let open = |number: &usize| !self.curves[*number].closed;
        let ends: Vec<End> =
            (0..self.curves.len()).filter(open).flat_map(|number| [(number, false), (number, true)]).collect();
        let mut pairs = Vec::new();
        for (k, &a) in ends.iter().enumerate() {
            for &b in ends[k + 1..].iter().filter(|b| b.0 != a.0) {
                let apart = (self.place(b) - self.place(a)).norm();
                pairs.extend((apart <= 2.0 * BEAD).then_some((apart, [a, b])));
            }
        }
        pairs.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut home: Vec<usize> = (0..self.curves.len()).collect();
        for (apart, pair) in pairs {
            let homes = pair.map(|end| home[end.0]);
            if homes[0] == homes[1] || self.ways.iter().any(|(ends, _)| ends.iter().any(|end| pair.contains(end))) {
                continue;
            }
            let ([p, q], steps) = (pair.map(|end| self.place(end)), (apart / (0.25 * BEAD)).ceil().max(1.0));
            let way: Vec<_> = (0..=steps as usize).map(|k| p + (q - p) * (k as f64 / steps)).collect();
            if self.is_clear(pair, &way) {
                home.iter_mut().filter(|home| **home == homes[1]).for_each(|home| *home = homes[0]);
                self.ways.push((pair, way));
            }
        }
    }
}

/// Whether two segments in the plane cross.
fn cross([a, b]: [Point3<f64>; 2], [c, d]: [Point3<f64>; 2]) -> bool {
    let side = |a: Point3<f64>, b: Point3<f64>, p: Point3<f64>| (b - a).cross(&(p - a)).z;
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn joints_are_those_of_the_slow_twin(seed in 0u64..1000, share in 0.02..0.3) {
        let mesh = plate(seed, share);
        let [before, after] = [0.0, 2.0].map(|distance| filled(&mesh, distance));
        prop_assert_eq!(before.joints, 0);
        prop_assert_eq!(after.paths.len() + after.joints, before.paths.len());
        prop_assert_eq!(crossings(&after.paths), crossings(&before.paths));
        let ways = ways(&before.paths, &after.paths);
        prop_assert_eq!(ways.len(), after.joints);
        for ([a, b], way) in &ways {
            prop_assert!(!before.paths[a.0].closed && !before.paths[b.0].closed);
            prop_assert!(way.windows(2).all(|pair| (pair[1] - pair[0]).norm() <= 0.25 * BEAD + SLACK));
        }
        let mut slow = Slow { mesh: &mesh, rims: boundary_edges(&mesh), curves: &before.paths, ways: Vec::new() };
        slow.join();
        let sorted = |ways: &[Way]| -> BTreeSet<[End; 2]> {
            ways.iter().map(|([a, b], _)| [*a.min(b), *a.max(b)]).collect()
        };
        prop_assert_eq!(sorted(&ways), sorted(&slow.ways));
    }
}

#[test]
fn some_curves_are_joined() {
    let joints: usize = (0..12).map(|seed| filled(&plate(seed, 0.12), 2.0).joints).sum();
    assert!(joints >= 5, "{joints}");
}

#[test]
fn distances_that_are_none_are_refused() {
    let mesh = plate(1, 0.1);
    let distance = to_boundary(&mesh);
    let field = LevelField::new(&distance, 0.005, &go_on).unwrap();
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let options = PathOptions { join_distance: bad, ..PathOptions::default() };
        assert!(matches!(field.paths(&options, &go_on), Err(PathError::JoinDistance { .. })), "{bad}");
        let options = PathOptions { min_length: bad, ..PathOptions::default() };
        assert!(matches!(field.paths(&options, &go_on), Err(PathError::MinLength { .. })), "{bad}");
    }
}
