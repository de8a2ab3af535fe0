//! Every public function takes any input: numbers far out, not finite, none, of another hull. The names are read from the sources, so a new
//! function that is not fed here fails.

use curvlay_hull::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;

/// Public functions, as `file name`: the tests below feed each.
const FED: [&str; 44] = [
    "hull2.rs area_times_2",
    "hull2.rs checkpoint",
    "hull2.rs corners",
    "hull2.rs insert",
    "hull2.rs is_deep",
    "hull2.rs locate",
    "hull2.rs new",
    "hull2.rs rollback",
    "hull2.rs row_interval",
    "hull2.rs support",
    "hull3/body.rs column",
    "hull3/body.rs corners",
    "hull3/body.rs depth",
    "hull3/body.rs insert",
    "hull3/body.rs is_deep",
    "hull3/body.rs is_outside",
    "hull3/body.rs is_solid",
    "hull3/body.rs locate",
    "hull3/body.rs new",
    "hull3/body.rs planes",
    "hull3/body.rs support",
    "hull3/body.rs triangles",
    "hull3/body.rs witness",
    "hull3/what_if.rs added_since",
    "hull3/what_if.rs checkpoint",
    "hull3/what_if.rs commit",
    "hull3/what_if.rs rollback",
    "measure.rs area",
    "measure.rs faces",
    "measure.rs volume_times_6",
    "plane.rs at",
    "plane.rs beyond",
    "plane.rs height",
    "plane.rs length",
    "plane.rs margin",
    "plane.rs new",
    "plane.rs reduced",
    "plane.rs shows",
    "plane.rs units",
    "polygon.rs convex_polygon",
    "rows.rs interval",
    "rows.rs lattice",
    "rows.rs new",
    "rows.rs update",
];

/// Panics that are documented.
const PANICS: [(&str, &str); 1] = [("rows.rs interval", "outside the rows there is no interval, as with a slice")];

/// `file name` of each `pub fn`.
fn public_functions(root: &Path, folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            public_functions(root, &path, found);
            continue;
        }
        let file = path.strip_prefix(root).unwrap().display().to_string().replace('\\', "/");
        for line in std::fs::read_to_string(&path).unwrap().lines().map(str::trim_start) {
            let name = line.strip_prefix("pub fn ").or_else(|| line.strip_prefix("pub const fn "));
            if let Some(name) = name.and_then(|rest| rest.split(['(', '<']).next()) {
                found.insert(format!("{file} {name}"));
            }
        }
    }
}

#[test]
fn every_public_function_is_fed() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = BTreeSet::new();
    public_functions(&root, &root, &mut found);
    let fed: BTreeSet<String> = FED.map(String::from).into();
    assert_eq!(fed, found, "feed new functions in this file and name them in FED");
    let text = include_str!("every_function.rs");
    for name in FED.map(|entry| entry.split_once(' ').unwrap().1) {
        assert!(text.contains(&format!("{name}(")), "{name} is named but not called");
    }
    for (entry, _) in PANICS {
        let (file, name) = entry.split_once(' ').unwrap();
        let source = std::fs::read_to_string(root.join(file)).unwrap();
        let before = source.split(&format!("pub fn {name}(")).next().unwrap();
        let docs: Vec<&str> =
            before.lines().rev().map(str::trim).skip(1).take_while(|line| line.starts_with("///")).collect();
        assert!(docs.contains(&"/// # Panics"), "{entry} does not say when it panics");
    }
}

const M: i32 = MAX_COORDINATE;

/// Coordinates: near, at the limit, beyond it, and as far out as there are.
fn coordinate() -> impl Strategy<Value = i32> {
    prop_oneof![
        6 => -4..=4i32,
        2 => prop::sample::select(vec![-M, M, M - 1]),
        1 => prop::sample::select(vec![-M - 1, M + 1, i32::MIN, i32::MAX, 1 << 20, -1 << 21]),
    ]
}

fn points() -> impl Strategy<Value = Vec<[i32; 3]>> {
    prop::collection::vec([coordinate(), coordinate(), coordinate()], 0..9)
}

fn units() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![
        0.0,
        -0.0,
        1.5,
        64.0,
        64.001,
        -1.0,
        f64::MIN_POSITIVE,
        f64::NAN,
        f64::INFINITY,
        -f64::INFINITY,
        f64::MAX,
    ])
}

fn depth(units: f64, is_beyond: bool) -> Depth {
    let made = if is_beyond { Depth::beyond(units) } else { Depth::new(units) };
    assert_eq!(made.is_ok(), (0.0..=Depth::MAX).contains(&units), "{units}");
    made.unwrap_or(Depth::SURFACE)
}

fn feed_queries(hull: &ConvexHull, points: &[[i32; 3]]) {
    let mut hint = Hint::default();
    for &p in points {
        let (is_deep, is_outside) = (hull.is_deep(p), hull.is_outside(p, &mut hint));
        assert!(!(is_deep && is_outside), "{p:?}");
        assert_eq!(hull.locate(p) == Location::Outside, is_outside, "{p:?}");
        if let Some(plane) = hull.witness(p, &mut hint) {
            assert!(plane.shows(p) && !is_deep, "{p:?}");
        }
        hull.support(p);
        for plane in hull.planes() {
            let reduced = plane.reduced();
            assert_eq!((plane.shows(p), plane.height(p) > 0), (reduced.shows(p), reduced.height(p) > 0), "{p:?}");
            assert!(plane.margin() >= 0 && plane.length() > 0.0);
        }
    }
    assert_eq!(hull.is_solid(), hull.triangles().count() >= 3);
    assert!(hull.volume_times_6().is_none_or(|volume| (volume > 0) == hull.is_solid()));
    assert!(hull.area().is_none_or(|area| area >= 0.0));
    hull.faces();
    assert!(hull.corners().len() <= 64 && hull.depth().units() <= Depth::MAX);
}

fn feed_rows(hull: &ConvexHull, lattice: RowLattice) {
    let Ok(mut rows) = RowIntervals::new(lattice) else { return };
    rows.update(hull);
    let [ny, nz] = rows.lattice().count;
    for (y, z) in (0..ny.min(3)).flat_map(|y| (0..nz.min(3)).map(move |z| (y, z))) {
        let [py, pz] = [0, 1].map(|k| lattice.origin[k] + lattice.step * [y, z][k] as i32);
        if let Some(interval) = rows.interval(y, z).filter(|_| py.abs() <= M && pz.abs() <= M) {
            for x in [*interval.start(), *interval.end()].into_iter().filter(|x| x.abs() <= M) {
                assert!(hull.is_deep([x, py, pz]), "{x} {py} {pz}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn hulls_take_anything(batches in prop::collection::vec(points(), 1..4), far in points(), units in units(), is_beyond: bool, keep: bool) {
        let depth = depth(units, is_beyond);
        let mut hull = ConvexHull::new(depth);
        for batch in &batches {
            let corners = hull.corners();
            let checkpoint = hull.checkpoint();
            let inserted = hull.insert(batch);
            prop_assert_eq!(inserted.is_ok(), batch.iter().flatten().all(|c| c.unsigned_abs() <= M.unsigned_abs()));
            hull.added_since(&checkpoint);
            feed_queries(&hull, &far);
            if keep {
                hull.commit(checkpoint);
            } else {
                hull.rollback(checkpoint);
                prop_assert_eq!(hull.corners(), corners);
            }
        }
        let section: Vec<[i32; 2]> = far.iter().map(|&[x, y, _]| [x, y]).collect();
        if let Ok(column) = ConvexHull::column(&section, batches[0].first().map_or(0, |p| p[2]), depth) {
            feed_queries(&column, &far);
        }
    }

    /// A checkpoint of another hull is a mistake, and none that ends the program.
    #[test]
    fn checkpoints_of_others_end_nothing(a in points(), b in points(), twice: bool) {
        let (mut first, mut second) = (ConvexHull::new(Depth::SURFACE), ConvexHull::new(Depth::SURFACE));
        let _ = first.insert(&a);
        let checkpoint = first.checkpoint();
        let _ = first.insert(&b);
        let _ = second.insert(&b);
        second.added_since(&checkpoint);
        if twice {
            second.commit(checkpoint);
        } else {
            second.rollback(checkpoint);
        }
        let _ = second.insert(&a);
        feed_queries(&second, &b);
    }

    #[test]
    fn rows_take_anything(
        points in points(), origin in [coordinate(), coordinate()], step in coordinate(), count in [0..4u32, 0..4u32], units in units(), is_beyond: bool,
    ) {
        let near: Vec<[i32; 3]> = points.into_iter().map(|p| p.map(|c| c % 1000)).collect();
        let mut hull = ConvexHull::new(depth(units, is_beyond));
        hull.insert(&near).unwrap();
        for step in [step, 1, i32::MAX] {
            for count in [count, [1, 1], [u32::MAX, 1], [1 << 14, 1 << 14]] {
                feed_rows(&hull, RowLattice { origin, step, count });
            }
        }
    }

    #[test]
    fn polygons_take_anything(points in prop::collection::vec([coordinate(), coordinate()], 0..9), far in [coordinate(), coordinate()], units in units()) {
        let corners = convex_polygon(&points);
        prop_assert!(corners.len() <= points.len());
        let mut hull = ConvexHull2::new(depth(units, false));
        let checkpoint = hull.checkpoint();
        let inserted = hull.insert(&points);
        prop_assert_eq!(hull.corners(), if inserted.is_ok() { &corners[..] } else { &[] });
        prop_assert!(!(hull.is_deep(far) && hull.locate(far) == Location2::Outside));
        hull.support(far);
        prop_assert!(hull.area_times_2() >= 0);
        if let Some(row) = hull.row_interval(far[1]) {
            prop_assert!(hull.is_deep([*row.start(), far[1]]) && hull.is_deep([*row.end(), far[1]]));
        }
        hull.rollback(checkpoint);
        prop_assert!(hull.corners().is_empty());
    }

    /// Planes are plain numbers: any of them.
    #[test]
    fn planes_take_anything(
        normal in [coordinate(), coordinate(), coordinate()], p in [coordinate(), coordinate(), coordinate()], units in units(),
        numbers in [any::<i64>(), any::<i64>(), any::<i64>(), any::<i64>(), any::<i64>()],
    ) {
        let given = Plane { normal: [numbers[0], numbers[1], numbers[2]], offset: numbers[3], inner: numbers[4] };
        let edge = Plane { normal: [i64::MIN; 3], offset: i64::MIN, inner: i64::MAX };
        for plane in [Plane::at(normal, p, depth(units, false)), given, edge] {
            let reduced = plane.reduced();
            let _ = (plane.height(p), plane.shows(p), plane.margin(), plane.length(), reduced.height(p), reduced.margin());
        }
    }
}
