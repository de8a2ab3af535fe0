//! Orders of cells: sets, plates, growth, audits, distances, loads, poses.

use super::numbers::{
    DIMS, Small, bad, box_of, each_spoilt, fit, ids, mesh, nozzles, number, order, point, small, vector,
};
use crate::common::{BOX, go};
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::Strategy;
use curvlay_layers::curved::orient::*;
use curvlay_layers::curved::surface::{LayerField, plain_field};
use curvlay_layers::curved::*;
use curvlay_layers::nalgebra::{Point3, Unit, Vector3};
use proptest::prelude::*;
use proptest::strategy::Strategy as _;

const PREVENTIONS: [Prevention; 5] = [
    Prevention::None,
    Prevention::Incremental,
    Prevention::Adaptive,
    Prevention::FewerThanAll,
    Prevention::FewerThan(0),
];

/// What nozzles make of an order, whatever the order is.
fn feed_order(part: &Small, growth: &Growth, missed: &[u32], value: f64) {
    let Small { platform, rules, .. } = part;
    let cells = &part.cells();
    let order = &growth.order;
    let mut reports = vec![audit(cells, platform, rules, order, missed, &go)];
    for (rule, cell_mm) in nozzles(value).into_iter().map(|rule| (rule, 1.0)).chain([(NozzleRule::default(), value)]) {
        let direction = Unit::new_unchecked(Vector3::new(value, 0.0, 1.0));
        let leaning: Vec<NozzleCell> = missed.iter().map(|&cell| NozzleCell { cell, direction }).collect();
        for (steps, stray) in [(1, &leaning[..]), (2, &growth.nozzle), (0, &[])] {
            let judged = JudgedByNozzle { rule, cell_mm, steps, cells: stray };
            reports.push(audit_with_nozzle(cells, platform, rules, &judged, order, missed, &go));
            reports.push(audit_listing(cells, platform, rules, &judged, (order, missed), usize::MAX, &go));
        }
        let _ = grow_with_nozzle(cells, cell_mm, platform, rules, &rule, growth.clone(), &go);
    }
    for report in reports.into_iter().flatten() {
        assert_eq!(report.is_ok(), report.faults.is_empty());
    }
    layer_quality(cells, order, rules.neighbours);
    assert_eq!(growth.missed_cells().len(), growth.missed.len());
}

fn made_up(order: LayerOrder, missed: &[u32]) -> Growth {
    let missed = missed.iter().map(|&cell| MissedCell { cell, reason: MissedReason::NeverAdjacent }).collect();
    Growth { order, missed, statistics: GrowthStatistics::default(), nozzle: vec![] }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn sets_and_orders_take_anything(
        dims in [0..70u32, 0..4u32, 0..4u32], huge in prop::sample::select(vec![0, 16_383, 1 << 16, u32::MAX]), rows in prop::collection::vec(any::<u64>(), 0..9), at in (any::<u32>(), 0..5u32, 0..5u32).prop_map(|(x, y, z)| [x, y, z]), id: u32,
        layers in order(), values in prop::collection::vec(any::<u32>(), 0..9),
    ) {
        let words = (dims[0].div_ceil(64) * dims[1] * dims[2]) as usize;
        let few: Vec<u64> = fit(&rows, words).into_iter().map(|row| row & 1).collect();
        for (dims, rows) in [(dims, &few), (dims, &rows), ([huge; 3], &rows), ([1, huge, 0], &vec![]), ([huge, 1, 1], &rows)] {
            let Ok(cells) = Cells::new(dims, rows) else { continue };
            prop_assert_eq!((cells.iter().count(), cells.dims()), (cells.count(), dims));
            prop_assert_eq!(cells.rows().len(), cells.words_per_row() * cells.row_count());
            cells.contains(at);
            if at.iter().zip(dims).all(|(c, side)| *c < side) {
                prop_assert_eq!(cells.position(cells.id(at)), at);
            }
            cells.position(id);
        }
        prop_assert_eq!((layers.iter().len(), layers.is_empty()), (layers.len(), layers.iter().next().is_none()));
        (0..layers.len()).for_each(|layer| assert!(layers.layer(layer).len() <= layers.cells().len()));
        let len = layers.cells().iter().max().map_or(0, |&highest| highest as usize + 1);
        if len < 1 << 21 {
            prop_assert_eq!(layers.field(len).len(), len);
        }
        let sheets = SheetField::new(values.clone());
        prop_assert_eq!((sheets.len(), sheets.is_empty()), (values.len(), values.is_empty()));
        (0..).zip(&values).for_each(|(cell, &value)| assert!(sheets.value(cell) == value && value <= sheets.highest()));
    }

    #[test]
    fn plates_take_anything(
        corners in prop::collection::vec([number(), number()], 0..6), radius in number(), top in prop::sample::select(vec![0, -1, 5, i32::MIN, i32::MAX]), at in (any::<i32>(), -9..9i32).prop_map(|(x, y)| [x, y]), part in small(), solid in mesh(), size in number(), origin in point(), flat: bool,
    ) {
        let cells = part.cells();
        let [x, y] = corners.first().copied().unwrap_or([0.5, 1.0]);
        let made = [
            Platform::polygon(&corners), Platform::disc([x, y], radius), Platform::disc([0.0; 2], 3.0), Platform::under(&cells, radius), Platform::segment(x, y), Ok(part.platform.clone()),
        ];
        for platform in made.into_iter().flatten() {
            let _ = (platform.top(), platform.reaches_down(), platform.corners().len(), platform.carries(at, flat));
            let raised = platform.clone().elevated(top);
            let on_cells = platform.clone().on_mould(&cells);
            let on_mesh = [(size, origin), (1.0, origin), (1.0, Point3::new(3.0, 3.0, 3.0))]
                .map(|(size, origin)| platform.clone().on_mould_mesh(DIMS, size, origin, &solid.0, &solid.1));
            let on_box = platform.clone().on_mould_mesh(DIMS, size, origin, &box_of([2.0, 2.0, 1.0]), &BOX);
            for platform in [raised, on_cells, on_box].into_iter().chain(on_mesh).flatten() {
                let _ = (platform.mould().map(|mould| mould.count()), platform.outside_mould(&cells).map(|rows| rows.len()));
                if let Ok(growth) = grow(&cells, &platform, &part.rules, &GrowthOptions::default(), None, &go) {
                    let _ = audit(&cells, &platform, &part.rules, &growth.order, &growth.missed_cells(), &go);
                }
            }
        }
        let _ = part.rules.inside_depth_in_1024ths();
        prop_assert!(!part.rules.neighbours.offsets().is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn growth_takes_anything(
        part in small(), order in order(), missed in ids(), value in bad(), sheets in prop::collection::vec(any::<u32>(), 0..70), fewer in prop::sample::select(vec![0, 1, u32::MAX]), asked in ids(), forced in ids(),
    ) {
        let Small { platform, rules, .. } = &part;
        let cells = &part.cells();
        feed_order(&part, &made_up(order.clone(), &missed), &missed, value);
        let peeled = peel(cells, platform, rules, &go);
        let governors: Vec<SheetField> = peeled.into_iter().chain([SheetField::new(sheets.clone()), SheetField::new(fit(&sheets, 60))]).collect();
        for prevention in PREVENTIONS.into_iter().chain([Prevention::FewerThan(fewer)]) {
            for governor in &governors {
                let options = GrowthOptions { prevention, candidates: Candidates::OfLastLayer, visit: Visit::HighestFirst };
                let grown = [
                    grow(cells, platform, rules, &options, Some(governor), &go), grow_as_printed(cells, platform, rules, prevention, governor, &go),
                    Strategy::Governed(prevention).grow(cells, platform, rules, &go),
                ];
                for growth in grown.into_iter().flatten() {
                    prop_assert_eq!(growth.order.cells().len() + growth.missed.len(), cells.count());
                }
            }
        }
        for strategy in [Strategy::Greedy, Strategy::Unbuild, Strategy::Printed(Prevention::Adaptive)] {
            prop_assert!(!strategy.name().is_empty());
            let Ok(growth) = strategy.grow(cells, platform, rules, &go) else { continue };
            feed_order(&part, &growth, &missed, value);
        }
        let _ = unbuild(cells, platform, rules, &UnbuildOptions { look_back: fewer }, &go);
        if let Ok(proofs) = prove_impossible(cells, platform, rules, &asked, &go) {
            check_impossible(cells, platform, rules, &proofs).unwrap();
        }
        let proofs = asked.iter().map(|&cell| Impossible { cell, forced: forced.clone(), wall: missed.clone() });
        let _ = check_impossible(cells, platform, rules, &proofs.collect::<Vec<_>>());
    }

    #[test]
    fn distances_and_support_take_anything(
        part in small(), base in ids(), heights in prop::collection::vec(number(), 0..70), directions in prop::collection::vec(vector(), 1..70), value in bad(), size in number(), given in ids(),
        counts in [0..4u32, 0..4u32], huge in prop::sample::select(vec![0, 1, u32::MAX]), made in order(),
    ) {
        let Small { platform, rules, .. } = &part;
        let cells = &part.cells();
        let _ = distance_field(cells, platform, rules);
        let tilts = [None, Some(0.5), Some(value)].map(|max_tilt| DirectedOptions { max_tilt });
        for nozzle in nozzles(value) {
            for directed in &tilts {
                let _ = directed.tilt_for(&nozzle);
            }
            let base = [None, Some(&base[..])];
            for (cell_mm, base) in [(1.0, base[0]), (size, base[0]), (1.0, base[1])] {
                for heights in [heights.clone(), fit(&heights, 60), vec![1.0; 60]] {
                    let _ = grow_by_heights(cells, cell_mm, platform, rules, base, &nozzle, &heights, &go);
                }
                if let Ok(found) = grow_by_distance(cells, cell_mm, platform, rules, base, &nozzle, &go) {
                    for order in [&found.growth.order, &made] {
                        let _ = distance_layers(cells, &found.field, order);
                    }
                }
            }
        }
        let rule = NozzleRule::default();
        prop_assert!(rule.check().is_ok() && !rule.directions().is_empty());
        for given in [None, Some(directions.clone()), Some(fit(&directions, 60)), Some(vec![Vector3::z(); 60])] {
            for options in &tilts {
                let _ = grow_directed(cells, size.abs(), platform, rules, None, &rule, given.as_deref(), options, &go);
                let _ = grow_directed(cells, 1.0, platform, rules, None, &rule, given.as_deref(), options, &go);
            }
        }
        let Ok(growth) = grow(cells, platform, rules, &GrowthOptions::default(), None, &go) else { return Ok(()) };
        let fields: [fn(&mut SupportOptions, u32); 4] = [
            |options, value| options.width = value, |options, value| options.contact = value, |options, value| options.gap = value,
            |options, value| options.rounds = value.min(4),
        ];
        let sound = SupportOptions { rounds: 2, ..SupportOptions::default() };
        let again = |cells: &Cells| grow(cells, platform, rules, &GrowthOptions::default(), None, &go);
        for options in [counts[0], counts[1], huge].into_iter().flat_map(|count| each_spoilt(&sound, &fields, count)) {
            for growth in [&growth, &made_up(made.clone(), &given)] {
                let _ = add_support(cells, platform, rules, growth, &given, &options, &again, &go);
            }
        }
        for (size, origin) in [(1.0, 0.0), (size, value)] {
            let mesh = cell_mesh(cells, &given, size, Point3::new(origin, 0.0, 0.0));
            prop_assert!(mesh.triangles.iter().flatten().all(|&corner| (corner as usize) < mesh.vertices.len()));
        }
    }

    #[test]
    fn loads_take_anything(
        part in small(), stresses in prop::collection::vec(prop::array::uniform6(number()), 1..70), value in bad(), made in order(), share in number(),
    ) {
        let cells = &part.cells();
        let fields: Vec<LayerField> = LayerField::new(cells, part.heights(), 1.0).into_iter().chain(plain_field(cells, &made)).collect();
        let options: [fn(&mut FollowOptions, f64); 2] =
            [|options, value| options.stressed_share = value, |options, value| options.along = value];
        for field in &fields {
            for stresses in [stresses.clone(), fit(&stresses, cells.count()), fit(&[[3.0, 0.0, 0.0, 0.0, 0.0, 0.0]], cells.count())] {
                for options in each_spoilt(&FollowOptions::default(), &options, value) {
                    if let Ok(found) = load_field(cells, &stresses, field, &options, &go) {
                        prop_assert_eq!(found.sheets().len(), found.values.len());
                    }
                }
                for share in [share, value] {
                    let _ = load_angle(cells, &stresses, field, share);
                }
            }
            for cell in [0, 7, 59, 60, u32::MAX] {
                layer_normal(cells, field, cell);
            }
        }
    }

    #[test]
    fn poses_take_anything(solid in mesh(), value in bad(), count in prop::sample::select(vec![0, 1, 9, u32::MAX]), up in vector(), rows in prop::collection::vec(any::<u64>(), 0..4), size in number(), part in small()) {
        let fields: [fn(&mut OrientOptions, f64); 5] = [
            |options, value| options.min_tipping = value, |options, value| options.contact = value, |options, value| options.min_apart = value,
            |options, value| options.platform_diameter_mm = value, |options, value| options.rules.inside_depth_cells = value,
        ];
        let sound = OrientOptions { directions: 4, ..OrientOptions::default() };
        let all = each_spoilt(&sound, &fields, value).into_iter().chain([OrientOptions { directions: count, ..sound }]);
        let sides = box_of([2.0, 3.0, 1.0]);
        let wrong = |_: &[Point3<f64>]| Ok::<_, std::io::Error>(PoseCells { dims: [3, 1, 1], rows: rows.clone(), cell_mm: 1.0 });
        let sized = |_: &[Point3<f64>]| Ok::<_, std::io::Error>(PoseCells { dims: DIMS, rows: part.rows.clone(), cell_mm: size });
        let fair = |_: &[Point3<f64>]| Ok::<_, std::io::Error>(PoseCells { dims: DIMS, rows: part.rows.clone(), cell_mm: 1.0 });
        for options in all {
            for (vertices, triangles) in [(&solid.0, &solid.1[..]), (&sides, &BOX[..])] {
                let mut found = poses(vertices, triangles, &options).unwrap_or_default();
                found.truncate(3);
                found.push(Pose { up: Unit::new_unchecked(up), kind: PoseKind::Given, tipping: value });
                for pose in &found {
                    let _ = (pose.rotation(), pose.lay(vertices));
                }
                let judged = [
                    judge_poses(vertices, &found, &options, &wrong, &go), judge_poses(vertices, &found, &options, &sized, &go), judge_poses(vertices, &found, &options, &fair, &go),
                ];
                for pose in judged.into_iter().flatten().flatten() {
                    prop_assert!(pose.missed_share() >= 0.0);
                }
            }
        }
    }
}

impl Small {
    /// A field of heights over the plate: one a cell of the grid, none where it is empty.
    pub fn heights(&self) -> Vec<f64> {
        let cells = self.cells();
        let height = |cell: u32| {
            let at = cells.position(cell);
            if cells.contains(at) { f64::from(at[2]) + 0.5 } else { f64::NAN }
        };
        (0..60).map(height).collect()
    }
}
