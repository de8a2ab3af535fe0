//! Questions to a hull in space that start from a hint, and what its methods say about themselves.

use curvlay_hull::{ConvexHull, Depth, Hint, HullError, Location};
use proptest::prelude::*;

type Point = [i32; 3];

fn hull_of(points: &[Point], depth: Depth) -> ConvexHull {
    let mut hull = ConvexHull::new(depth);
    hull.insert(points).unwrap();
    hull
}

fn cloud(side: i32, most: usize) -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(prop::array::uniform3(-side..=side), 4..most)
}

/// Hints as searches over `hull` leave them.
fn hints(hull: &ConvexHull) -> Vec<Hint> {
    let ends = hull.corners().into_iter().map(|corner| {
        let mut hint = Hint::default();
        hull.witness(corner.map(|c| 2 * c), &mut hint);
        hint
    });
    ends.chain([Hint::default()]).collect()
}

fn assert_hint_will_do(hull: &ConvexHull, p: Point, mut hint: Hint) {
    let witness = hull.witness(p, &mut hint);
    assert_eq!(witness.is_none(), hull.is_deep(p) || !hull.is_solid(), "{p:?} from {hint:?}");
    assert!(witness.is_none_or(|plane| plane.shows(p) && hull.planes().any(|other| other == plane)), "{p:?}");
    assert_eq!(hull.is_outside(p, &mut hint), hull.locate(p) == Location::Outside, "{p:?} from {hint:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Hints of the same body, of a larger one, and of one that has been taken back.
    #[test]
    fn any_hint_will_do(points in cloud(6, 14), more in cloud(12, 60), probes in cloud(9, 12), steps in 0..6u32) {
        let depth = Depth::new(f64::from(steps) / 4.0).unwrap();
        let mut hull = hull_of(&points, depth);
        let mut found = hints(&hull);
        let checkpoint = hull.checkpoint();
        hull.insert(&more).unwrap();
        found.extend(hints(&hull));
        hull.rollback(checkpoint);
        for &p in &probes {
            for &hint in &found {
                assert_hint_will_do(&hull, p, hint);
            }
        }
    }

    #[test]
    fn insert_counts_what_extends_the_body(batches in prop::collection::vec(cloud(4, 8), 1..5), is_flat: bool) {
        let mut hull = ConvexHull::new(Depth::SURFACE);
        for mut batch in batches {
            if is_flat {
                batch.iter_mut().for_each(|p| p[2] = p[0] - p[1]);
            }
            let (before, was_solid) = (hull.clone(), hull.is_solid());
            let extended = hull.insert(&batch).unwrap();
            let new_corners = hull.corners().iter().filter(|corner| !before.corners().contains(corner)).count();
            // Points that were corners of the body for a while count as well.
            let outside: std::collections::BTreeSet<_> = batch.iter().filter(|&&p| before.locate(p) == Location::Outside).collect();
            prop_assert!((new_corners..=outside.len()).contains(&extended), "{} {} {}", new_corners, extended, outside.len());
            if !hull.is_solid() {
                prop_assert_eq!((extended, was_solid), (new_corners, false));
            }
        }
    }

    #[test]
    fn support_is_the_farthest_of_all_points(points in cloud(9, 30), direction in prop::array::uniform3(any::<i16>().prop_map(i32::from)), top in -9..9i32) {
        let along = |p: &Point| (0..3).map(|k| i64::from(direction[k]) * i64::from(p[k])).sum::<i64>();
        let farthest = |points: &[Point]| points.iter().map(along).max();
        prop_assert_eq!(hull_of(&points, Depth::SURFACE).support(direction), farthest(&points));
        let section: Vec<[i32; 2]> = points.iter().map(|p| [p[0], p[1]]).collect();
        let Ok(column) = ConvexHull::column(&section, top, Depth::SURFACE) else { return Ok(()) };
        let lid: Vec<Point> = section.iter().map(|s| [s[0], s[1], top]).collect();
        prop_assert_eq!(column.support(direction), farthest(&lid).filter(|_| direction[2] >= 0));
        let level = [direction[0], direction[1], 0];
        prop_assert_eq!(column.support(level), lid.iter().map(|p| (0..2).map(|k| i64::from(level[k]) * i64::from(p[k])).sum()).max());
    }

    /// What was added: every point that is a corner now and was none, and no point that was in the body already.
    #[test]
    fn added_points_are_those_that_extended_the_body(points in cloud(5, 9), more in cloud(9, 30)) {
        let mut hull = hull_of(&points, Depth::SURFACE);
        let (before, was_solid) = (hull.clone(), hull.is_solid());
        let checkpoint = hull.checkpoint();
        prop_assert!(hull.added_since(&checkpoint).is_empty());
        let extended = hull.insert(&more).unwrap();
        let added = hull.added_since(&checkpoint).to_vec();
        if was_solid {
            prop_assert_eq!(added.len(), extended);
            prop_assert!(added.iter().all(|p| more.contains(p) && before.locate(*p) == Location::Outside));
            prop_assert!(hull.corners().iter().all(|corner| added.contains(corner) || before.corners().contains(corner)));
        } else if hull.is_solid() {
            prop_assert!(hull.corners().iter().all(|corner| added.contains(corner)));
            prop_assert!(added.iter().all(|p| more.contains(p) || points.contains(p)));
        } else {
            prop_assert!(added.is_empty());
        }
    }
}

/// Hulls of 4, 6, 8, ... facets: hints that name the next facet, and ones far beyond.
#[test]
fn hints_of_larger_bodies_will_do_for_every_size() {
    let spiral: Vec<Point> = (0..40).map(|k| [k, k * k, (k * k * k) / 8]).collect();
    let mut largest = hull_of(&spiral, Depth::SURFACE);
    let mut all: Vec<Hint> = hints(&largest);
    largest.insert(&[[-900, 900, 1000]]).unwrap();
    all.extend(hints(&largest));
    // A row of sizes leaves a hint at its newest facet each.
    for size in 4..spiral.len() {
        all.extend(hints(&hull_of(&spiral[..size], Depth::SURFACE)));
    }
    for size in 4..spiral.len() {
        let hull = hull_of(&spiral[..size], Depth::SURFACE);
        for &hint in &all {
            assert_hint_will_do(&hull, [size as i32, 0, 0], hint);
        }
    }
}

#[test]
fn a_column_may_stand_on_a_triangle() {
    let column = ConvexHull::column(&[[0, 0], [4, 0], [0, 4]], 3, Depth::SURFACE).unwrap();
    assert_eq!(column.corners(), [[0, 0, 3], [0, 4, 3], [4, 0, 3]]);
    assert_eq!((column.locate([1, 1, -9]), column.locate([2, 2, 0])), (Location::Inside { depth: 1.0 }, Location::On));
    assert!(matches!(ConvexHull::column(&[[0, 0], [4, 4]], 3, Depth::SURFACE), Err(HullError::NoArea)));
}

#[test]
fn a_hull_keeps_its_depth() {
    for depth in [Depth::new(2.5).unwrap(), Depth::beyond(0.0).unwrap(), Depth::SURFACE] {
        assert_eq!(ConvexHull::new(depth).depth(), depth);
        assert_eq!(ConvexHull::column(&[[0, 0], [4, 0], [0, 4]], 3, depth).unwrap().depth(), depth);
    }
}

/// Checkpoints given to the wrong hull may leave facets that nobody noted; what is taken back after that must still leave a whole body.
#[test]
fn bodies_stay_whole_after_checkpoints_of_others() {
    let corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
    let mut other = ConvexHull::new(Depth::SURFACE);
    let early = other.checkpoint();
    other.insert(&corners).unwrap();
    other.insert(&[[9, 9, 9], [-9, 0, 3], [8, -7, 2], [3, 3, -9]]).unwrap();
    let late = other.checkpoint();

    let mut hull = ConvexHull::new(Depth::SURFACE);
    let own = hull.checkpoint();
    hull.insert(&corners).unwrap();
    hull.rollback(late); // nothing is taken back, and nothing noted from here on
    hull.insert(&[[9, 9, 9], [-9, 0, 0]]).unwrap();
    hull.rollback(early); // takes back what was noted: the body has no volume again
    assert!(!hull.is_solid());
    assert_eq!((hull.planes().count(), hull.triangles().count(), hull.faces().len()), (0, 0, 0));
    assert_eq!(hull.insert(&corners), Ok(4));
    assert_eq!((hull.corners().len(), hull.volume_times_6()), (4, Some(64)));
    hull.commit(own);
}
