//! What tapes lie on, and what lies on them: judged as one does with a ruler.

use curvlay_toolpath::fiber::bedding::{BeddingError, Roller, TapeBedding, bedded_surface, tape_bedding};
use curvlay_toolpath::fiber::head::LayerTapes;
use curvlay_toolpath::fiber::tapes::Tape;
use curvlay_toolpath::gcode::Tool;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::nalgebra::{Point3, UnitVector3, Vector3};
use curvlay_toolpath::orientation::{ToolPath, Waypoint};
use curvlay_toolpath::path::BeadKind;
use curvlay_toolpath::support::{SupportError, SupportOptions};
use proptest::prelude::*;
use std::ops::ControlFlow;

const H: f64 = 0.5;

fn go(_: curvlay_toolpath::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn bead(layer: u32, y: f64, ends: [f64; 2]) -> ToolPath {
    let at = |x: f64| Waypoint {
        position: Point3::new(x, y, H * f64::from(layer + 1)),
        axis: Vector3::z_axis(),
        width: 1.0,
        height: H,
        arc: x - ends[0],
        added: false,
        lift: Vector3::zeros(),
        kind: BeadKind::Solid,
    };
    let steps = ((ends[1] - ends[0]) / 0.5).ceil() as u32;
    let waypoints = (0..=steps).map(|k| at(ends[0] + (ends[1] - ends[0]) * f64::from(k) / f64::from(steps)));
    ToolPath { layer, curve: 0, closed: false, waypoints: waypoints.collect() }
}

/// Beads side by side: a plate from `low` to `high`.
fn plate(layer: u32, low: [f64; 2], high: [f64; 2]) -> Vec<ToolPath> {
    let count = (high[1] - low[1]).round() as u32;
    (0..count).map(|k| bead(layer, low[1] + 0.5 + f64::from(k), [low[0], high[0]])).collect()
}

fn tape(layer: u32, y: f64, ends: [f64; 2], width: f64) -> LayerTapes {
    let at = |x: f64| Point3::new(x, y, H * f64::from(layer + 1));
    let points: Vec<Point3<f64>> = (0..=8).map(|k| at(ends[0] + (ends[1] - ends[0]) * f64::from(k) / 8.0)).collect();
    let tape = Tape { normals: vec![Vector3::z_axis(); points.len()], points, width, thickness: 0.08 };
    LayerTapes { layer, tool: Tool::Roller, lift: 0.0, tapes: vec![tape] }
}

const ROLLER: Roller = Roller { diameter: 20.0, width: 8.0 };

fn found(paths: &[ToolPath], tapes: &[LayerTapes]) -> TapeBedding {
    tape_bedding(paths, tapes, H, &ROLLER, &SupportOptions { plate: false, ..SupportOptions::default() }, &go).unwrap()
}

#[test]
fn a_tape_between_two_plates_is_bedded() {
    let paths = [plate(0, [0.0, 0.0], [40.0, 10.0]), plate(1, [0.0, 0.0], [40.0, 10.0])].concat();
    let bedding = found(&paths, &[tape(0, 5.0, [2.0, 38.0], 5.0)]);
    assert!((bedding.tape_mm2 - 180.0).abs() < 1e-9);
    assert!(bedding.on_nothing.is_empty() && bedding.uncovered.is_empty() && bedding.roller_depth.is_none());
    // The beads of the first layer have no plate below them here, those of the second have the tape and the first layer.
    assert!((bedding.bead_on_nothing_mm - 400.0).abs() < 1.0, "{}", bedding.bead_on_nothing_mm);
}

/// Found where a layer ends, where the layer above ends, and with nothing above at all: no tape is laid on nothing unseen.
#[test]
fn a_tape_that_sticks_out_is_seen() {
    let paths = [plate(0, [0.0, 0.0], [30.0, 10.0]), plate(1, [0.0, 0.0], [20.0, 10.0])].concat();
    let bedding = found(&paths, &[tape(0, 5.0, [0.0, 40.0], 5.0)]);
    // Reach of the check beyond the end of a bead: its middle is 0.29 mm below that of the tape.
    assert!((bedding.on_nothing_share() - 0.25).abs() < 0.025, "{}", bedding.on_nothing_share());
    assert!((bedding.uncovered_share() - 0.5).abs() < 0.025, "{}", bedding.uncovered_share());
    assert!(bedding.on_nothing.iter().all(|place| place.at.x > 30.0 && place.layer == 0 && place.tape == 0));
    assert!(bedding.uncovered.iter().all(|place| place.at.x > 20.0));
    let last = found(&plate(0, [0.0, 0.0], [30.0, 10.0]), &[tape(0, 5.0, [2.0, 28.0], 5.0)]);
    assert!((last.uncovered_share() - 1.0).abs() < 1e-9 && last.on_nothing.is_empty());
}

/// A tape half beside its layer: its strands are judged one by one, not its centre line.
#[test]
fn a_tape_over_an_edge_is_half_on_nothing() {
    let paths = [plate(0, [0.0, 0.0], [40.0, 10.0]), plate(1, [0.0, 0.0], [40.0, 20.0])].concat();
    let bedding = found(&paths, &[tape(0, 9.5, [2.0, 38.0], 5.0)]);
    // 2 mm of 5 lie beyond the edge; 0.69 mm of them are within reach of the core of the last bead, which ends 0.25 mm inside.
    let known = (2.0 + 0.25 - (0.75f64.powi(2) - 0.29f64.powi(2)).sqrt()) / 5.0;
    assert!((bedding.on_nothing_share() - known).abs() < 0.05, "{} {known}", bedding.on_nothing_share());
    assert!(bedding.on_nothing.iter().all(|place| place.at.y > 10.0));
}

/// A tape that is laid before the layer below it is complete lies on nothing: the order counts, not the place.
#[test]
fn what_comes_later_carries_nothing() {
    let paths = [plate(0, [0.0, 0.0], [40.0, 10.0]), plate(1, [0.0, 0.0], [40.0, 10.0])].concat();
    // At the height of the second layer, but laid behind the first.
    let early = LayerTapes { layer: 0, ..tape(1, 5.0, [2.0, 38.0], 5.0) };
    let bedding = found(&paths, &[early]);
    assert!(bedding.on_nothing_share() > 0.99, "{}", bedding.on_nothing_share());
}

/// The deepest point of a roller in a wall beside its tape: `R - sqrt((R - h)^2 + d^2)` at a distance along and a height above.
#[test]
fn a_roller_in_a_trough_touches_its_end() {
    let floor = plate(0, [0.0, 0.0], [40.0, 10.0]);
    // A step of four layers beyond x = 30, in the way of the roller.
    let steps = (1..5).flat_map(|layer| plate(layer, [30.0, 0.0], [40.0, 10.0]));
    let paths: Vec<ToolPath> = floor.into_iter().chain(steps).collect();
    let mut list = tape(0, 5.0, [2.0, 26.0], 5.0);
    list.layer = 4;
    let deepest = found(&paths, &[list]).roller_depth.unwrap();
    let (radius, ahead, up) = (10.0f64, 4.0f64, 4.0 * H - 0.08);
    let known = radius - ((radius - up).powi(2) + ahead.powi(2)).sqrt();
    assert!((deepest.mm - known).abs() < 1e-9 && deepest.at.x > 25.9, "{deepest:?} {known}");
    // A narrow roller passes beside a wall that a wide one hits.
    let walls = (0..3).flat_map(|layer| [bead(layer, 0.0, [0.0, 40.0]), bead(layer, 10.0, [0.0, 40.0])]);
    let paths: Vec<ToolPath> = plate(0, [0.0, 2.0], [40.0, 8.0]).into_iter().chain(walls.skip(2)).collect();
    let list = LayerTapes { layer: 2, ..tape(0, 5.0, [2.0, 38.0], 5.0) };
    let depth = |width: f64| {
        let roller = Roller { width, ..ROLLER };
        let options = SupportOptions { plate: false, ..SupportOptions::default() };
        tape_bedding(&paths, std::slice::from_ref(&list), H, &roller, &options, &go).unwrap().roller_depth
    };
    assert!(depth(8.0).is_none() && depth(12.0).is_some_and(|deepest| (deepest.mm - (2.0 * H - 0.08)).abs() < 1e-9));
}

#[test]
fn what_cannot_be_judged_is_refused() {
    let paths = [plate(0, [0.0, 0.0], [40.0, 10.0]), plate(1, [0.0, 0.0], [40.0, 10.0])].concat();
    let options = SupportOptions::default();
    let refused = |paths: &[ToolPath], tapes: &[LayerTapes], roller: Roller| {
        tape_bedding(paths, tapes, H, &roller, &options, &go).unwrap_err()
    };
    let good = || tape(0, 5.0, [2.0, 38.0], 5.0);
    let turned: Vec<ToolPath> = paths.iter().rev().cloned().collect();
    assert_eq!(refused(&turned, &[good()], ROLLER), BeddingError::Order { what: "path", number: 10, layer: 0 });
    let lists = [LayerTapes { layer: 1, ..good() }, good()];
    assert_eq!(refused(&paths, &lists, ROLLER), BeddingError::Order { what: "list of tapes", number: 1, layer: 0 });
    for (diameter, width) in [(0.0, 1.0), (1.0, f64::NAN)] {
        assert!(matches!(refused(&paths, &[good()], Roller { diameter, width }), BeddingError::Roller { .. }));
    }
    let with = |change: &dyn Fn(&mut Tape)| {
        let mut list = good();
        change(&mut list.tapes[0]);
        refused(&paths, &[list], ROLLER)
    };
    for error in
        [with(&|tape| tape.width = 0.0), with(&|tape| tape.points.truncate(1)), with(&|tape| _ = tape.normals.pop())]
    {
        assert_eq!(error, BeddingError::Tape { layer: 0, tape: 0 });
    }
    assert!(matches!(with(&|tape| tape.width = 1e6), BeddingError::Strands { .. }));
    assert!(matches!(
        with(&|tape| tape.points[1].x = f64::NAN),
        BeddingError::Support(SupportError::BadWaypoint { .. })
    ));
    let stopped = tape_bedding(&paths, &[good()], H, &ROLLER, &options, &|_| ControlFlow::Break(()));
    assert_eq!(stopped, Err(BeddingError::Support(SupportError::Cancelled)));
    assert!(found(&paths, &[]).on_nothing_share() <= 0.0);
}

/// A fan around a point that two separate triangles share is there twice: a mesh of surfaces takes it.
#[test]
fn a_pinched_surface_has_its_point_twice() {
    let paths = [plate(0, [0.0, 0.0], [10.0, 10.0]), plate(1, [0.0, 0.0], [10.0, 10.0])].concat();
    let top = [[5.0, 5.0], [2.0, 4.0], [2.0, 6.0], [8.0, 4.0], [8.0, 6.0]].map(|[x, y]| Point3::new(x, y, H));
    let (vertices, triangles) = bedded_surface(&top, &[[0, 2, 1], [0, 3, 4]], 0, &paths, H);
    assert_eq!((vertices.len(), triangles.len()), (6, 2));
    assert!(SurfaceMesh::new(vertices, triangles).is_ok());
    assert!(bedded_surface(&top, &[[0, 2, 9]], 0, &paths, H).0.is_empty());
    assert!(bedded_surface(&top, &[[0, 2, 1]], 0, &paths, f64::NAN).0.is_empty());
}

/// A tape lies on beads and has beads on it: one without the other beds nothing.
#[test]
fn what_has_beads_on_one_side_alone_is_not_bedded() {
    let plates = [0, 1].map(|layer| plate(layer, [0.0, 0.0], [10.0, 10.0]));
    let top = [[2.0, 2.0], [8.0, 2.0], [5.0, 8.0]].map(|[x, y]| Point3::new(x, y, H));
    let bedded = |paths: &[ToolPath]| bedded_surface(&top, &[[0, 1, 2]], 0, paths, H).1.len();
    assert_eq!((bedded(&plates[0]), bedded(&plates[1]), bedded(&plates.concat())), (0, 0, 1));
}

/// Corners within 1.25 heights of beads below and above are bedded, others not, however many beads lie near by.
#[test]
fn what_lies_beside_the_beads_is_not_bedded() {
    let paths = [0, 1].map(|layer| plate(layer, [0.0, 0.0], [10.0, 10.0])).concat();
    let bedded = |y: f64| {
        let top = [[2.0, 5.0], [8.0, 5.0], [5.0, y]].map(|[x, y]| Point3::new(x, y, H));
        bedded_surface(&top, &[[0, 1, 2]], 0, &paths, H).1.len()
    };
    // The core of the last bead ends 0.25 mm inside, half a height below.
    let last = 10.0 - 0.25 + ((1.25 * H).powi(2) - (H / 2.0).powi(2)).sqrt();
    assert_eq!([last - 0.05, last + 0.05, last + 0.3].map(bedded), [1, 0, 0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Beads and tapes anywhere: strands that a slow look at points finds bare are those that are reported.
    #[test]
    fn agrees_with_a_slow_look(
        ends in prop::collection::vec((0.0..10.0f64, 15.0..40.0f64), 10),
        above in prop::collection::vec((0.0..10.0f64, 15.0..40.0f64), 10),
        y in 3.0..7.0f64, width in 0.6..5.0f64,
    ) {
        let layer = |layer: u32, ends: &[(f64, f64)]| -> Vec<ToolPath> {
            ends.iter().enumerate().map(|(k, (from, to))| bead(layer, 0.5 + k as f64, [*from, *to])).collect()
        };
        let paths = [layer(0, &ends), layer(1, &above)].concat();
        let list = tape(0, y, [1.0, 39.0], width);
        let bedding = found(&paths, std::slice::from_ref(&list));
        let reach = 1.5 * H;
        let count = (width / H).ceil();
        let bare = |beads: &[(f64, f64)], apart: f64| {
            let mut area = 0.0;
            for k in 0..count as usize {
                let aside = y + ((k as f64 + 0.5) / count - 0.5) * width;
                for step in 0..3800 {
                    let x = 1.0 + 0.01 * (f64::from(step) + 0.5);
                    let near = beads.iter().enumerate().any(|(bead, (from, to))| {
                        let dy = aside - 0.5 - bead as f64;
                        let dx = (from - x).max(x - to).max(0.0);
                        // The core ends in a round.
                        (dx.hypot(dy) - 0.25).max(0.0).hypot(apart) <= reach
                    });
                    area += if near { 0.0 } else { 0.01 * width / count };
                }
            }
            area
        };
        // Middles: of the tape 0.04 mm above its layer, of the beads half a layer below and above.
        let below = bare(&ends, 0.5 * H + 0.04);
        let over = bare(&above, 0.5 * H - 0.04);
        let tolerance = 0.12 * width + 1e-9;
        prop_assert!((bedding.on_nothing_mm2 - below).abs() <= tolerance, "{} {below}", bedding.on_nothing_mm2);
        prop_assert!((bedding.uncovered_mm2 - over).abs() <= tolerance, "{} {over}", bedding.uncovered_mm2);
    }
}

#[test]
fn normals_need_no_upright() {
    // The same world, turned: what is bedded stays bedded.
    let turn = curvlay_toolpath::nalgebra::Rotation3::from_euler_angles(0.4, -0.9, 0.3);
    let paths = [plate(0, [0.0, 0.0], [30.0, 10.0]), plate(1, [0.0, 0.0], [20.0, 10.0])].concat();
    let list = tape(0, 5.0, [0.0, 40.0], 5.0);
    let turned: Vec<ToolPath> = paths
        .iter()
        .map(|path| {
            let waypoint = |at: &Waypoint| Waypoint {
                position: turn * at.position,
                axis: UnitVector3::new_unchecked(turn * at.axis.into_inner()),
                ..*at
            };
            ToolPath { waypoints: path.waypoints.iter().map(waypoint).collect(), ..path.clone() }
        })
        .collect();
    let tapes = LayerTapes {
        tapes: vec![Tape {
            points: list.tapes[0].points.iter().map(|p| turn * p).collect(),
            normals: list.tapes[0].normals.iter().map(|n| UnitVector3::new_unchecked(turn * n.into_inner())).collect(),
            ..list.tapes[0].clone()
        }],
        ..list.clone()
    };
    let (upright, leaning) = (found(&paths, &[list]), found(&turned, &[tapes]));
    assert!((upright.on_nothing_mm2 - leaning.on_nothing_mm2).abs() < 0.5);
    assert!((upright.uncovered_mm2 - leaning.uncovered_mm2).abs() < 0.5);
}
