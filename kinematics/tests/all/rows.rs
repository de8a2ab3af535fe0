//! Published robots against reference rows made with 50 digits: forward, inverse, completeness, continuing. Rows in
//! metres.
//!
//! `data/rows.csv` is a small set that every clone has; `data/rows.py` makes it. The large set lies outside the
//! repository.

use crate::common::{ROBOTS, Row, apart, arm, assert_meets, differ, in_one_turn, miss, reference, rows};
use curvlay_kinematics::nalgebra::{Isometry3, Quaternion, UnitQuaternion};
use curvlay_kinematics::{Branch, Positioner, robots};

/// Below this distance from a singularity the joints of a row are not unique to the digits asked for.
const UNIQUE: f64 = 1e-6;

fn eps(row: &Row) -> Option<f64> {
    let text = row.text("eps");
    (!text.is_empty()).then(|| text.parse().unwrap())
}

/// Rows of all robots.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    /// Our own few.
    Own,
    /// Those in the folder `shared` beside the workspace.
    Shared,
}

/// Calls `check` for all rows with what to call the row in front, and says how many there were.
fn for_each_row(source: Source, mut check: impl FnMut(&str, &curvlay_kinematics::Arm, &Row)) {
    let mut count = 0;
    for (name, model) in ROBOTS {
        let text = match source {
            Source::Own => include_str!("../data/rows.csv").to_owned(),
            Source::Shared => reference(&format!("{name}.csv")),
        };
        let arm = arm(model);
        for row in rows(&text).filter(|row| source == Source::Shared || row.text("robot") == name) {
            check(&format!("{name}, row {} ({})", row.text("id"), row.text("class")), &arm, &row);
            count += 1;
        }
    }
    assert!(count >= 90, "{count} rows");
}

#[test]
fn forward_gives_the_pose_of_every_row_of_our_own() {
    forward_gives_the_poses(Source::Own);
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn forward_gives_the_pose_of_every_row() {
    forward_gives_the_poses(Source::Shared);
}

fn forward_gives_the_poses(source: Source) {
    let mut worst = (0.0f64, 0.0f64);
    for_each_row(source, |what, arm, row| {
        let (mm, rad) = miss(&arm.forward(&row.joints()), &row.pose());
        assert!(mm < 1e-9 && rad < 1e-12, "{what}: {mm:e} {rad:e}");
        if source == Source::Shared {
            let q = Quaternion::new(row.number("qw"), row.number("qx"), row.number("qy"), row.number("qz"));
            let by_quaternion = Isometry3::from_parts(row.pose().translation, UnitQuaternion::new_normalize(q));
            assert!(miss(&by_quaternion, &row.pose()).1 < 1e-14);
        }
        worst = (worst.0.max(mm), worst.1.max(rad));
    });
    println!("forward: {:e} mm, {:e} rad", worst.0, worst.1);
}

#[test]
fn inverse_recovers_every_row_of_our_own() {
    inverse_recovers_the_joints(Source::Own);
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn inverse_recovers_every_row() {
    inverse_recovers_the_joints(Source::Shared);
}

fn inverse_recovers_the_joints(source: Source) {
    let (mut recovered, mut asked, mut worst) = (0, 0, (0.0f64, 0.0f64));
    for_each_row(source, |what, arm, row| {
        let (pose, joints) = (row.pose(), row.joints());
        let found = arm.inverse(&pose).unwrap();
        assert!(!found.is_empty(), "{what}: nothing");
        for (branch, solution) in found.iter() {
            assert_meets(arm, solution, &pose, what);
            let (mm, rad) = miss(&arm.forward(solution), &pose);
            worst = (worst.0.max(mm), worst.1.max(rad));
            assert!(in_one_turn(solution), "{what}: {solution:?}");
            let others = found.iter().filter(|(other, _)| *other != branch);
            assert!(others.into_iter().all(|(_, other)| apart(other, solution) > 1e-6), "{what}: twins");
        }
        if eps(row).is_none_or(|eps| eps >= UNIQUE) {
            asked += 1;
            let nearest = found.iter().map(|(_, solution)| apart(solution, &joints)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-6, "{what}: {nearest:e} from the nearest of {}", found.len());
            recovered += 1;
        }
    });
    println!("inverse: {recovered} of {asked} recovered, at most {:e} mm and {:e} rad off", worst.0, worst.1);
}

fn distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn continuing_from_a_row_of_our_own_stays_on_it() {
    continuing_stays(Source::Own);
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn continuing_from_a_row_stays_on_it() {
    continuing_stays(Source::Shared);
}

fn continuing_stays(source: Source) {
    for_each_row(source, |what, arm, row| {
        let (pose, joints) = (row.pose(), row.joints());
        let next = arm.continuing(&pose, &joints).unwrap_or_else(|| panic!("{what}: nothing"));
        assert!(differ(&next, &joints) < 1e-6, "{what}: {:e}", differ(&next, &joints));
        assert_meets(arm, &next, &pose, what);
    });
}

#[test]
fn continuing_from_beside_a_row_of_our_own_stays_beside_it() {
    continuing_stays_beside(Source::Own);
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn continuing_from_beside_a_row_stays_beside_it() {
    continuing_stays_beside(Source::Shared);
}

/// Moved by 1e-3 rad in each joint, in all 64 directions.
fn continuing_stays_beside(source: Source) {
    const STEP: f64 = 1e-3;
    let mut farthest = 0.0f64;
    for_each_row(source, |what, arm, row| {
        let (pose, joints) = (row.pose(), row.joints());
        for signs in 0..64 {
            let mut beside = joints;
            (0..6).for_each(|k| beside[k] += if signs >> k & 1 == 0 { STEP } else { -STEP });
            let next = arm.continuing(&pose, &beside).unwrap_or_else(|| panic!("{what}: nothing"));
            assert_meets(arm, &next, &pose, what);
            assert!(arm.limits().contains(&next), "{what}: {next:?}");
            // The row is a solution. So the nearest is no farther; with a free joint kept, at most four times as far.
            let (far, known) = (distance(&next, &beside), distance(&joints, &beside));
            let unique = eps(row).is_none_or(|eps| eps >= UNIQUE);
            assert!(far <= if unique { known } else { 4.0 * known } + 1e-6, "{what}: {far:e}, {known:e}");
            farthest = farthest.max(differ(&next, &beside));
        }
    });
    println!("continuing: at most {farthest:e} rad from the previous joints");
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn random_rows_have_exactly_the_branches_that_two_other_solvers_found() {
    for (name, model) in ROBOTS {
        let [poses, branches] = ["", "_branches"].map(|kind| reference(&format!("{name}{kind}.csv")));
        let arm = arm(model);
        let theirs: Vec<Row> = rows(&branches).collect();
        let mut count = 0;
        let is_in = |row: &Row| theirs.iter().any(|branch| branch.text("id") == row.text("id"));
        let poses: Vec<Row> = rows(&poses).filter(is_in).collect();
        assert_eq!(poses.len(), 100);
        for row in &poses {
            let ours = arm.inverse(&row.pose()).unwrap();
            let wanted: Vec<_> = theirs.iter().filter(|b| b.text("id") == row.text("id")).map(Row::joints).collect();
            assert_eq!(ours.len(), wanted.len(), "{name}, row {}", row.text("id"));
            for solution in &wanted {
                let nearest = ours.iter().map(|(_, q)| apart(q, solution)).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-6, "{name}, row {}: {nearest:e}", row.text("id"));
            }
            for (branch, solution) in ours.iter() {
                assert_eq!(arm.branch(solution), branch, "{name}, row {}", row.text("id"));
            }
            count += wanted.len();
        }
        println!("{name}: {count} branches, none missing, none false");
    }
}

#[test]
fn the_slot_is_the_cfx_of_an_abb_arm_in_rows_of_our_own() {
    slot_is_cfx(Source::Own);
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn the_slot_is_the_cfx_of_an_abb_arm() {
    slot_is_cfx(Source::Shared);
}

fn slot_is_cfx(source: Source) {
    for_each_row(source, |what, arm, row| {
        if !arm.is_ur() && eps(row).is_none_or(|eps| eps >= UNIQUE) {
            let cfx: usize = row.text("cfx").parse().unwrap();
            assert_eq!(arm.branch(&row.joints()), Branch::ALL[cfx], "{what}");
        }
    });
}

#[test]
#[ignore = "needs ../shared/kinematics; .ci/run runs it where that folder exists"]
fn the_positioner_gives_the_pose_of_every_row() {
    let text = reference("IRBP_A-250.csv");
    let positioner = Positioner::new(&robots::IRBP_A250, &Isometry3::identity()).unwrap();
    for row in rows(&text) {
        let (mm, rad) = miss(&positioner.forward(&[row.number("q1"), row.number("q2")]), &row.pose());
        assert!(mm < 1e-9 && rad < 1e-12, "row {}: {mm:e} {rad:e}", row.text("id"));
    }
}
