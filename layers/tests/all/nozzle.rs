//! Growth with the nozzle that prints: what it reaches, held against geometry by sampling, and what is refused.

use crate::common::{Part, are_neighbours, go, hull_of, parts, rules, tip_1_mm};
use curvlay_layers::Progress;
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::uniform_field_with_nozzle;
use curvlay_layers::curved::{
    AuditError, AuditReport, DIRECTIONS, Fault, Growth, GrowthError, GrowthOptions, JudgedByNozzle, MissedReason,
    NozzleCell, NozzleRule, NozzleRuleError, Platform, Rules, audit_with_nozzle, grow, grow_with_nozzle,
};
use curvlay_layers::nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};
use std::ops::ControlFlow;

/// A nozzle that is small beside cells of a millimetre, so that small parts decide.
fn small() -> NozzleRule {
    NozzleRule { tip_flat_mm: 0.6, half_angle: 0.5, cone_height_mm: 2.0, block_mm: 3.0, ..NozzleRule::default() }
}

fn with_nozzle(part: &Part, rules: &Rules, nozzle: &NozzleRule, growth: Growth) -> Growth {
    grow_with_nozzle(&part.cells(), 1.0, &part.platform, rules, nozzle, growth, &go).unwrap()
}

fn audited(part: &Part, rules: &Rules, nozzle: &NozzleRule, growth: &Growth) -> AuditReport {
    let judged = JudgedByNozzle { rule: *nozzle, cell_mm: 1.0, steps: 1, cells: &growth.nozzle };
    audit_with_nozzle(&part.cells(), &part.platform, rules, &judged, &growth.order, &growth.missed_cells(), &go)
        .unwrap()
}

fn by_hull(part: &Part, rules: &Rules) -> Growth {
    grow(&part.cells(), &part.platform, rules, &GrowthOptions::default(), None, &go).unwrap()
}

fn part(dims: [u32; 3], is_solid: impl Fn([u32; 3]) -> bool) -> Part {
    let [nx, ny, nz] = dims;
    let row = |y, z| (0..nx).fold(0, |row, x| row | u64::from(is_solid([x, y, z])) << x);
    let rows: Vec<u64> = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect();
    let platform = Platform::under(&Cells::new(dims, &rows).unwrap(), 40.0).unwrap();
    Part { dims, rows, platform }
}

/// Points of the nozzle about its tip at the origin: sections every fifth of a millimetre, each in rings. The block up to `length`.
fn points_of(nozzle: &NozzleRule, direction: Vector3<f64>, length: f64) -> Vec<Vector3<f64>> {
    let side = direction.cross(&if direction.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() }).normalize();
    let other = direction.cross(&side);
    let mut points = Vec::new();
    let step = 0.2;
    for k in 0..=(length / step) as usize {
        let z = step * k as f64;
        let radius = if z < nozzle.cone_height_mm {
            nozzle.tip_flat_mm / 2.0 + z * nozzle.half_angle.tan()
        } else {
            nozzle.block_mm / 2.0
        };
        for ring in 0..=5 {
            for turn in 0..24 {
                let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / 24.0).sin_cos();
                points.push(direction * z + (side * cos + other * sin) * (radius * f64::from(ring) / 5.0));
            }
        }
    }
    points
}

fn centre([x, y, z]: [u32; 3]) -> Point3<f64> {
    Point3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(z) + 0.5)
}

/// Every cell is supported, and free of everything in earlier layers by sampled points of the nozzle, or outside the hull.
fn check_by_samples(part: &Part, rules: &Rules, nozzle: &NozzleRule, growth: &Growth) -> Result<(), TestCaseError> {
    let cells = part.cells();
    let standing = part.standing();
    let mut built: Vec<u32> = Vec::new();
    for layer in growth.order.iter() {
        let hull = hull_of(part, rules, built.iter().copied());
        for &cell in layer {
            let near = |&b: &u32| are_neighbours(&cells, cell, b, rules.neighbours);
            prop_assert!(standing.contains(&cell) || built.iter().any(near), "cell {cell} hangs in the air");
            let place = cells.position(cell);
            let Some(printed) = growth.nozzle.iter().find(|printed| printed.cell == cell) else {
                prop_assert!(!hull.is_deep(place.map(|k| 2 * k as i32 + 1)), "cell {cell} lies inside");
                continue;
            };
            let direction = printed.direction.into_inner();
            prop_assert!(direction.z >= nozzle.max_tilt.cos() - 1e-12);
            let tip = centre(place) + direction * 0.5;
            for point in points_of(nozzle, direction, 14.0) {
                let point = tip + point;
                prop_assert!(point.z >= f64::from(part.platform.top()) / 2.0 - 1e-9, "cell {cell}: below the plate");
                for &other in &built {
                    let distance = (point - centre(cells.position(other))).norm();
                    prop_assert!(distance >= nozzle.margin - 1e-9, "cell {cell} meets {other}");
                }
            }
        }
        built.extend(layer);
    }
    let all: BTreeSet<u32> = built.iter().copied().chain(growth.missed_cells()).collect();
    prop_assert_eq!(all.len(), built.len() + growth.missed.len());
    prop_assert_eq!(all, cells.iter().collect());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// What comes out can be built, by the audit and by sampled points of the nozzle; after the hull rule, and from the start on.
    #[test]
    fn what_is_built_can_be_built(
        part in parts((3u32..8, 1u32..6, 4u32..9).prop_map(|(x, y, z)| [x, y, z]), 3..7),
        rules in rules(),
        margin in prop::sample::select(vec![0.0, 0.25, 0.5]),
        max_tilt in prop::sample::select(vec![0.6, FRAC_PI_2]),
        from_start: bool,
    ) {
        let nozzle = NozzleRule { margin, max_tilt, ..small() };
        let before = if from_start { Growth::default() } else { by_hull(&part, &rules) };
        let after = with_nozzle(&part, &rules, &nozzle, before.clone());
        let report = audited(&part, &rules, &nozzle, &after);
        prop_assert!(report.is_ok(), "{} {:?}", report, report.faults);
        check_by_samples(&part, &rules, &nozzle, &after)?;
        if !from_start {
            prop_assert_eq!(&after.order.cells()[..before.order.cells().len()], before.order.cells());
            prop_assert!(after.missed.len() <= before.missed.len());
        }
    }

    /// No missed cell could follow: each is without support, or met in each direction, by the audit's own measure.
    #[test]
    fn nothing_more_can_follow(
        part in parts((3u32..6, 1u32..5, 4u32..8).prop_map(|(x, y, z)| [x, y, z]), 3..7),
        margin in prop::sample::select(vec![0.25, 0.5]),
    ) {
        let (rules, nozzle) = (Rules::default(), NozzleRule { margin, ..small() });
        let cells = part.cells();
        let growth = with_nozzle(&part, &rules, &nozzle, by_hull(&part, &rules));
        for missed in growth.missed_cells() {
            if !growth.order.cells().iter().any(|&b| are_neighbours(&cells, missed, b, rules.neighbours)) {
                continue;
            }
            let rest: Vec<u32> = growth.missed_cells().into_iter().filter(|&cell| cell != missed).collect();
            let mut order = growth.order.clone();
            order.push([missed]);
            // Beside edges the search keeps a little more free than the margin: up to 62 % of it.
            let tight = NozzleRule { margin: (1.7 * margin).min(1.0), ..nozzle };
            for direction in nozzle.directions() {
                let judged = [NozzleCell { cell: missed, direction }];
                let judged = JudgedByNozzle { rule: tight, cell_mm: 1.0, steps: 1, cells: &judged };
                let report = audit_with_nozzle(&cells, &part.platform, &rules, &judged, &order, &rest, &go).unwrap();
                prop_assert!(report.counts.nozzle > 0, "cell {} could be printed from {:?}", missed, direction);
            }
        }
    }
}

/// A ball below a beam on two posts: by hulls all of it is out of reach, from the side it is not.
#[test]
fn a_hanging_ball_is_reached_from_the_side() {
    let is_solid = |[x, y, z]: [u32; 3]| {
        let [dx, dy, dz] = [f64::from(x) - 15.0, f64::from(y) - 5.0, f64::from(z) - 12.0];
        let post = !(2..=28).contains(&x) && (4..7).contains(&y);
        let beam = z >= 24 && (4..7).contains(&y);
        let stem = (14..17).contains(&x) && (4..7).contains(&y) && z > 12;
        post || beam || stem || dx * dx + dy * dy + dz * dz < 5.2 * 5.2
    };
    let part = part([31, 11, 27], is_solid);
    let (rules, nozzle) = (
        Rules::default(),
        NozzleRule { tip_flat_mm: 1.0, cone_height_mm: 3.0, block_mm: 8.0, ..NozzleRule::default() },
    );
    let before = by_hull(&part, &rules);
    assert!(before.missed.len() > 400, "{}", before.missed.len());
    let after = with_nozzle(&part, &rules, &nozzle, before.clone());
    let cells = part.cells().count();
    assert!(
        10 * after.missed.len() < before.missed.len(),
        "{} of {} missed, before {}",
        after.missed.len(),
        cells,
        before.missed.len()
    );
    assert_eq!(audited(&part, &rules, &nozzle, &after).to_string(), "passed");
    // Below the beam every one leans: upright the beam is in the way.
    let below_beam = |printed: &&NozzleCell| (4..7).contains(&part.cells().position(printed.cell)[1]);
    assert!(after.nozzle.iter().filter(below_beam).all(|printed| printed.direction.z < 0.9));

    // Layers of a cell, in the order in which they are built, after those of the hull rule.
    let judged = JudgedByNozzle { rule: nozzle, cell_mm: 1.0, steps: 1, cells: &after.nozzle };
    let missed = after.missed_cells();
    let uniform =
        uniform_field_with_nozzle(&part.cells(), &part.platform, &rules, &judged, &after.order, &missed, &go).unwrap();
    assert!(uniform.audit.is_ok());
    assert_eq!(uniform.field.count() + missed.len(), cells);
    let highest = before.order.cells().iter().filter_map(|&cell| uniform.field.value(cell)).fold(0.0, f64::max);
    let lowest =
        after.nozzle.iter().filter_map(|printed| uniform.field.value(printed.cell)).fold(f64::INFINITY, f64::min);
    assert!(lowest.floor() > highest.floor(), "{lowest} {highest}");
}

/// A larger block, a smaller tilt or a wider margin never reaches a single cell that is not reached without.
#[test]
fn less_room_reaches_less() {
    // A shelf 6 cells above the plate, and a cell below its far end.
    let part = part([9, 1, 9], |[x, _, z]| x == 0 || z == 7 || (x == 8 && z == 6) || (x == 8 && z == 5));
    let rules = Rules::default();
    let missed = |nozzle: &NozzleRule| with_nozzle(&part, &rules, nozzle, by_hull(&part, &rules)).missed.len();
    let nozzle = small();
    assert_eq!(by_hull(&part, &rules).missed.len(), 1);
    assert_eq!(missed(&nozzle), 0);
    assert_eq!(missed(&NozzleRule { block_mm: 20.0, ..nozzle }), 1); // it would have to lean by a right angle, 6 mm above the plate
    assert_eq!(missed(&NozzleRule { max_tilt: 0.3, ..nozzle }), 1);
    assert_eq!(missed(&NozzleRule { margin: 1.0, ..nozzle }), 1);
}

#[test]
fn what_hangs_in_the_air_stays_missed() {
    let part = part([5, 1, 5], |[x, _, z]| x == 0 || (x > 2 && z > 2));
    let growth = with_nozzle(&part, &Rules::default(), &small(), by_hull(&part, &Rules::default()));
    assert_eq!(growth.missed.len(), 4);
    assert!(growth.missed.iter().all(|missed| missed.reason == MissedReason::NeverAdjacent));
    assert!(growth.nozzle.is_empty());
}

#[test]
fn directions_are_unit_vectors_within_the_tilt_upright_first() {
    for max_tilt in [0.3, FRAC_PI_3, FRAC_PI_2] {
        let directions = NozzleRule { max_tilt, ..NozzleRule::default() }.directions();
        assert_eq!(directions.len(), DIRECTIONS);
        assert!((directions[0].into_inner() - Vector3::z()).norm() < 1e-12);
        assert!(directions.windows(2).all(|pair| pair[0].z > pair[1].z));
        assert!(directions.iter().all(|d| (d.norm() - 1.0).abs() < 1e-12 && d.z >= max_tilt.cos() - 1e-12));
        // No direction of the cap is farther from one of them than twice the radius of its share.
        let share = (2.0 * (1.0 - max_tilt.cos()) / DIRECTIONS as f64).sqrt();
        for (a, b) in (0..400).map(|k| (f64::from(k) * 0.37, max_tilt * f64::from(k % 20) / 20.0)) {
            let direction = Vector3::new(b.sin() * a.cos(), b.sin() * a.sin(), b.cos());
            let nearest = directions.iter().map(|d| d.angle(&direction)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 2.0 * share, "{nearest} {share}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let nozzle = tip_1_mm();
    let bad = [
        (NozzleRule { tip_flat_mm: 0.0, ..nozzle }, NozzleRuleError::Measure { measure: "tip flat", value: 0.0 }),
        (NozzleRule { cone_height_mm: 1e9, ..nozzle }, NozzleRuleError::Measure { measure: "cone", value: 1e9 }),
        (NozzleRule { half_angle: FRAC_PI_2, ..nozzle }, NozzleRuleError::HalfAngle { half_angle: FRAC_PI_2 }),
        (
            NozzleRule { half_angle: 1.0, ..nozzle },
            NozzleRuleError::Block { block_mm: 20.0, cone_mm: 1.0 + 16.0 * 1f64.tan() },
        ),
        (NozzleRule { max_tilt: 0.0, ..nozzle }, NozzleRuleError::Tilt { max_tilt: 0.0 }),
        (NozzleRule { max_tilt: 2.0, ..nozzle }, NozzleRuleError::Tilt { max_tilt: 2.0 }),
        (NozzleRule { margin: 1.5, ..nozzle }, NozzleRuleError::Margin { margin: 1.5 }),
    ];
    let part = part([3, 1, 3], |_| true);
    let cells = part.cells();
    let rules = Rules::default();
    let grown = |mm, rules: &Rules, nozzle: &NozzleRule| {
        grow_with_nozzle(&cells, mm, &part.platform, rules, nozzle, Growth::default(), &go).unwrap_err()
    };
    for (nozzle, error) in bad {
        assert_eq!(nozzle.check(), Err(error));
        assert_eq!(grown(1.0, &rules, &nozzle), GrowthError::Nozzle(error));
        let judged = JudgedByNozzle { rule: nozzle, cell_mm: 1.0, steps: 1, cells: &[] };
        let audited = audit_with_nozzle(&cells, &part.platform, &rules, &judged, &LayerOrder::new(), &[], &go);
        assert_eq!(audited, Err(AuditError::Nozzle(error)));
    }
    assert!(NozzleRule { block_mm: f64::NAN, ..nozzle }.check().is_err());
    assert_eq!(grown(0.0, &rules, &nozzle), GrowthError::Nozzle(NozzleRuleError::Cell { cell_mm: 0.0 }));
    assert_eq!(grown(1.0, &Rules { flat: true, ..rules }, &nozzle), GrowthError::Nozzle(NozzleRuleError::Flat));
    let away = Platform::polygon(&[[50.0, 50.0], [60.0, 50.0], [60.0, 60.0]]).unwrap();
    let error = grow_with_nozzle(&cells, 1.0, &away, &rules, &nozzle, Growth::default(), &go).unwrap_err();
    assert_eq!(error, GrowthError::NothingOnPlatform);
    // Orders of other grids: cells that the part does not have, and numbers beyond its grid. Until 0.1.0 they panicked.
    for cell in [4, 9, u32::MAX] {
        let hollow = self::part([3, 1, 3], |[x, _, z]| [x, z] != [1, 1]);
        let mut order = LayerOrder::new();
        order.push([0, 1, cell]);
        let growth = Growth { order, ..Growth::default() };
        let error = grow_with_nozzle(&hollow.cells(), 1.0, &part.platform, &rules, &nozzle, growth, &go).unwrap_err();
        assert_eq!(error, GrowthError::OtherCells { cell });
    }
    let stop = |_: Progress| ControlFlow::Break(());
    let stopped = grow_with_nozzle(&cells, 1.0, &part.platform, &rules, &nozzle, Growth::default(), &stop).unwrap_err();
    assert_eq!(stopped, GrowthError::Cancelled);
}

/// Each kind of fault that the audit reports about nozzles.
#[test]
fn the_audit_finds_what_a_nozzle_meets() {
    let part = part([3, 1, 4], |_| true);
    let cells = part.cells();
    let order = {
        let mut order = LayerOrder::new();
        (0..4).for_each(|z| order.push(3 * z..3 * z + 3));
        order
    };
    let faults = |nozzle: NozzleRule, directions: &[NozzleCell]| {
        let judged = JudgedByNozzle { rule: nozzle, cell_mm: 1.0, steps: 1, cells: directions };
        audit_with_nozzle(&cells, &part.platform, &Rules::default(), &judged, &order, &[], &go).unwrap().faults
    };
    let leaning =
        |cell: u32, x: f64, z: f64| NozzleCell { cell, direction: Unit::new_normalize(Vector3::new(x, 0.0, z)) };
    assert_eq!(faults(small(), &[leaning(4, 0.0, 1.0)]), []);
    // Level with the plate, and with the layer below.
    assert_eq!(faults(small(), &[leaning(1, 1.0, 0.1)]), [Fault::NozzleMeetsPlate { cell: 1, layer: 1 }]);
    assert_eq!(faults(small(), &[leaning(9, 1.0, 0.05)]), [Fault::NozzleMeets { cell: 9, layer: 4, other: 7 }]);
    let steep = NozzleRule { max_tilt: 0.2, ..small() };
    assert_eq!(faults(steep, &[leaning(11, 1.0, 1.0)]), [Fault::NozzleLeans { cell: 11, layer: 4 }]);
    let twice = [leaning(4, 0.0, 1.0), leaning(4, 0.0, 1.0)];
    assert_eq!(faults(small(), &twice), [Fault::StrayDirection { cell: 4 }]);
    let judged = JudgedByNozzle { rule: small(), cell_mm: 1.0, steps: 1, cells: &[leaning(11, 0.0, 1.0)] };
    let mut short = LayerOrder::new();
    (0..3).for_each(|z| short.push(3 * z..3 * z + 3));
    let report =
        audit_with_nozzle(&cells, &part.platform, &Rules::default(), &judged, &short, &[9, 10, 11], &go).unwrap();
    assert_eq!(report.faults, [Fault::StrayDirection { cell: 11 }]);
    assert_eq!(report.to_string(), "1 directions of the nozzle that belong to no cell");
}

/// The same on one thread and on four.
#[test]
fn threads_change_nothing() {
    let part = part([13, 9, 12], |[x, y, z]| {
        (x == 0 && y == 4) || z == 11 || (z > 4 && (5..9).contains(&x) && (2..7).contains(&y))
    });
    let grown = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| with_nozzle(&part, &Rules::default(), &small(), by_hull(&part, &Rules::default())))
    };
    let one = grown(1);
    assert!(!one.nozzle.is_empty());
    assert_eq!(one, grown(4));
}
