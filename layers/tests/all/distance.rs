//! Orders by distance: the field against closed forms and slow distances, reach by the audit, pits that close.

use crate::common::{BOX, Part, go, parts, tip_1_mm};
use curvlay_layers::Progress;
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::{FieldError, LayerField, UniformMethod};
use curvlay_layers::curved::{
    DirectedOptions, DistanceOrder, GrowthError, Guides, JudgedByNozzle, LayerOptions, LayersBy, LayersError,
    NozzleRule, NozzleRuleError, Platform, Rules, STEPS_PER_LAYER, Workpiece, audit_with_nozzle, cell_mesh,
    distance_field, distance_layers, grow_by_distance, grow_directed,
};
use curvlay_layers::nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::collections::VecDeque;
use std::ops::ControlFlow;

/// A nozzle that is small beside cells of a millimetre, so that small parts decide.
fn small() -> NozzleRule {
    NozzleRule { tip_flat_mm: 0.6, half_angle: 0.5, cone_height_mm: 2.0, block_mm: 3.0, ..NozzleRule::default() }
}

fn part(dims: [u32; 3], is_solid: impl Fn([u32; 3]) -> bool) -> Part {
    let [nx, ny, nz] = dims;
    let row = |y, z| (0..nx).fold(0, |row, x| row | u64::from(is_solid([x, y, z])) << x);
    let rows: Vec<u64> = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect();
    let platform = Platform::under(&Cells::new(dims, &rows).unwrap(), 40.0).unwrap();
    Part { dims, rows, platform }
}

fn field_of(part: &Part) -> LayerField {
    distance_field(&part.cells(), &part.platform, &Rules::default()).unwrap()
}

fn grown(part: &Part, nozzle: &NozzleRule) -> DistanceOrder {
    grow_by_distance(&part.cells(), 1.0, &part.platform, &Rules::default(), None, nozzle, &go).unwrap()
}

fn directed(part: &Part, nozzle: &NozzleRule) -> DistanceOrder {
    grow_directed(
        &part.cells(),
        1.0,
        &part.platform,
        &Rules::default(),
        None,
        nozzle,
        None,
        &DirectedOptions::default(),
        &go,
    )
    .unwrap()
}

/// Faults of an order by distance, in words; nothing if it passes.
fn faults(part: &Part, nozzle: &NozzleRule, made: &DistanceOrder) -> Option<String> {
    let judged = JudgedByNozzle { rule: *nozzle, cell_mm: 1.0, steps: STEPS_PER_LAYER, cells: &made.growth.nozzle };
    let (order, missed) = (&made.growth.order, made.growth.missed_cells());
    let report =
        audit_with_nozzle(&part.cells(), &part.platform, &Rules::default(), &judged, order, &missed, &go).unwrap();
    (!report.is_ok()).then(|| report.to_string())
}

/// A shell of a sphere that closes over an empty room.
fn dome() -> Part {
    part([41, 41, 12], |[x, y, z]| {
        let [dx, dy, dz] = [f64::from(x) - 20.0, f64::from(y) - 20.0, f64::from(z) + 14.5];
        let radius = (dx * dx + dy * dy + dz * dz).sqrt();
        (22.0..25.5).contains(&radius)
    })
}

/// Face steps from the cells that stand on the platform.
fn face_steps(part: &Part) -> Vec<Option<u32>> {
    let cells = part.cells();
    let mut steps = vec![None; part.dims.iter().product::<u32>() as usize];
    let mut queue: VecDeque<u32> = part.standing().into();
    queue.iter().for_each(|&cell| steps[cell as usize] = Some(0));
    while let Some(cell) = queue.pop_front() {
        for beside in face_neighbours(&cells, cell) {
            if steps[beside as usize].is_none() {
                steps[beside as usize] = steps[cell as usize].map(|step| step + 1);
                queue.push_back(beside);
            }
        }
    }
    steps
}

fn face_neighbours(cells: &Cells, cell: u32) -> Vec<u32> {
    let place = cells.position(cell);
    let at = |axis: usize, step: i32| {
        let mut at = place;
        at[axis] = at[axis].wrapping_add_signed(step);
        cells.contains(at).then(|| cells.id(at))
    };
    (0..3).flat_map(|axis| [at(axis, -1), at(axis, 1)]).flatten().collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Each cell has one beside a face of it half a layer lower, and none more than a layer away; values lie between the straight way and the face steps.
    #[test]
    fn fields_rise_evenly_from_the_base(
        part in parts((2u32..9, 1u32..7, 2u32..9).prop_map(|(x, y, z)| [x, y, z]), 4..8),
    ) {
        let (cells, field, steps) = (part.cells(), field_of(&part), face_steps(&part));
        let base = part.standing();
        for cell in cells.iter() {
            prop_assert_eq!(field.value(cell).is_some(), steps[cell as usize].is_some());
            let Some(value) = field.value(cell) else { continue };
            let around: Vec<f64> = face_neighbours(&cells, cell).iter().filter_map(|&n| field.value(n)).collect();
            prop_assert!(around.iter().all(|other| (other - value).abs() <= 1.0 + 1e-12));
            let lowest = around.iter().copied().fold(f64::INFINITY, f64::min);
            prop_assert!(base.contains(&cell) && value <= 0.5 || value >= lowest + 0.5, "{} {}", value, lowest);
            prop_assert!(value <= f64::from(steps[cell as usize].unwrap()) + 0.5 + 1e-9);
            // Second order may fall short of a straight way by a little where fronts meet.
            let place = |cell: u32| cells.position(cell).map(f64::from);
            let to = |&foot: &u32| (0..3).map(|k| (place(foot)[k] - place(cell)[k]).powi(2)).sum::<f64>().sqrt();
            let straight = base.iter().map(to).fold(f64::INFINITY, f64::min);
            prop_assert!(value - 0.5 >= 0.9 * straight - 1e-9, "{} {}", value, straight);
        }
    }

    /// What is built passes the audit by the nozzle, and the rest is missed.
    #[test]
    fn orders_pass_the_audit(
        part in parts((2u32..9, 1u32..7, 2u32..9).prop_map(|(x, y, z)| [x, y, z]), 3..8),
        tip in 0.1f64..1.5,
    ) {
        let nozzle = NozzleRule { tip_flat_mm: tip, block_mm: 3.0 + tip, ..small() };
        for made in [grown(&part, &nozzle), directed(&part, &nozzle)] {
            prop_assert_eq!(faults(&part, &nozzle, &made), None);
            prop_assert_eq!(made.growth.order.cells().len() + made.growth.missed.len(), part.cells().count());
            let field = distance_layers(&part.cells(), &made.field, &made.growth.order).unwrap();
            prop_assert_eq!(field.order(), made.growth.order);
            prop_assert_eq!(field.half_layers(), made.field.half_layers());
        }
    }
}

#[test]
fn the_distance_in_a_block_is_the_height() {
    let block = part([5, 4, 6], |_| true);
    let field = field_of(&block);
    assert!(
        block.cells().iter().all(|cell| field.value(cell) == Some(f64::from(block.cells().position(cell)[2]) + 0.5))
    );
    assert_eq!((field.layer_cells(), field.steps_per_layer()), (1.0, 2));
}

/// Over the edge of a wall the front turns in circles around it: distances from the edge, to a tenth of a cell and a hundredth of the way.
#[test]
fn the_front_turns_around_an_edge() {
    // A wall with a broad roof that hangs out over nothing.
    let roof = part([40, 3, 40], |[x, _, z]| x < 4 || z >= 8);
    let field = field_of(&roof);
    for (x, z) in [(20, 8), (39, 8), (30, 20), (12, 15), (39, 39)] {
        let [dx, dz] = [f64::from(x) - 3.0, f64::from(z) - 8.0];
        // The edge is between the wall and the roof; level with it or above the way is straight.
        let exact = 8.5 + dx.hypot(dz);
        let value = field.value(roof.cells().id([x, 1, z])).unwrap();
        let seen_from_the_plate = dx.hypot(dz) < dz + 1e-9;
        assert!(!seen_from_the_plate && (value - exact).abs() < 0.35 + 0.01 * exact, "{x} {z}: {value} {exact}");
    }
}

/// Where the shell closes the fronts meet in a pit; delays open it to the nozzle, and the field does not tear.
#[test]
fn a_dome_closes_from_its_inside_out() {
    let (dome, nozzle) = (dome(), NozzleRule { cone_height_mm: 8.0, block_mm: 20.0, ..tip_1_mm() });
    let made = grown(&dome, &nozzle);
    assert_eq!(faults(&dome, &nozzle, &made), None);
    assert!(made.rounds > 0);
    let cells = dome.cells();
    let share = made.growth.missed.len() as f64 / cells.count() as f64;
    assert!(share < 0.01, "{share}");
    for cell in cells.iter() {
        for beside in face_neighbours(&cells, cell) {
            let [a, b] = [cell, beside].map(|cell| made.field.value(cell).unwrap());
            assert!((a - b).abs() <= 1.0 + 1e-9, "{cell} {beside}: {a} {b}");
        }
    }
}

/// An arch of 20 cells: the distance closes a slot that the cone does not get into without delays, a directed field leaves a valley.
#[test]
fn an_arch_closes_as_a_valley() {
    let arch = part([24, 5, 26], |[x, _, z]| !(4..20).contains(&x) || z >= 16);
    let nozzle = NozzleRule { cone_height_mm: 8.0, block_mm: 20.0, ..tip_1_mm() };
    // How far its layers lean is an option.
    let leaning = |tilt: f64| {
        let (cells, rules, options) = (arch.cells(), Rules::default(), DirectedOptions { max_tilt: Some(tilt) });
        grow_directed(&cells, 1.0, &arch.platform, &rules, None, &nozzle, None, &options, &go)
    };
    for tilt in [-0.1, 1.6, f64::NAN] {
        assert!(
            matches!(leaning(tilt), Err(GrowthError::LayerTilt { tilt: reported }) if reported.to_bits() == tilt.to_bits())
        );
    }
    let level = leaning(0.0).unwrap();
    let cells = arch.cells();
    for cell in cells.iter() {
        let [x, y, z] = cells.position(cell);
        let (height, value) = (f64::from(z) + 0.5, level.field.value(cell).unwrap());
        // Only what hangs over nothing comes later than its height.
        let stands = (0..z).all(|z| cells.contains([x, y, z]));
        assert!(if stands { (value - height).abs() < 1e-3 } else { value > height - 1e-3 }, "{cell}: {value} {height}");
    }
    let [by_distance, directed] = [grown(&arch, &nozzle), directed(&arch, &nozzle)];
    assert_eq!([&by_distance, &directed].map(|made| faults(&arch, &nozzle, made)), [None, None]);
    let missed = [&by_distance, &directed].map(|made| made.growth.missed.len());
    assert!(missed[1] == 0 && directed.rounds == 0 && (missed[0] > 0 || by_distance.rounds > 0), "{missed:?}");
}

/// The last cells of an arch have neighbours on both sides that are a layer lower, and in the way: they come a step early, and nothing is delayed.
#[test]
fn the_last_cells_of_an_arch_come_a_step_early() {
    for (span, thickness) in [(9, 3), (11, 3), (13, 4)] {
        let arch = part([span + 4, 3, 6 + thickness], |[x, _, z]| x < 2 || x >= span + 2 || z >= 6);
        let (made, distances) = (grown(&arch, &small()), field_of(&arch));
        assert_eq!(faults(&arch, &small(), &made), None);
        assert!(made.growth.missed.is_empty() && made.rounds == 0, "{span} {thickness}");
        let cells = arch.cells();
        let earlier = |cell: u32| distances.value(cell).unwrap() - made.field.value(cell).unwrap();
        let early: Vec<u32> = cells.iter().filter(|&cell| earlier(cell) > 0.0).collect();
        let middle = 2 + span / 2;
        assert!(
            !early.is_empty() && early.iter().all(|&cell| cells.position(cell)[0] == middle && earlier(cell) <= 0.5)
        );
    }
}

/// A plate of 12 x 4 mm that rises from the edge it stands on, 3 mm thick, and a block whose underside is half a millimetre above the plate. Only where the first layer
/// touches the plate the order begins: in the column of cells at the edge, and in all of the block.
#[test]
fn the_order_begins_where_the_first_layer_touches_the_plate() {
    let rise = |x: f64| 0.3 * x;
    let mut vertices =
        [(0.0, 0.0), (12.0, 0.0), (0.0, 4.0), (12.0, 4.0)].map(|(x, y)| Point3::new(x, y, rise(x))).to_vec();
    (0..4).for_each(|k| vertices.push(vertices[k] + Vector3::z() * 3.0));
    for z in [0.5, 5.0] {
        for (x, y) in [(14.0, 0.0), (18.0, 0.0), (14.0, 4.0), (18.0, 4.0)] {
            vertices.push(Point3::new(x, y, z));
        }
    }
    let triangles: Vec<[u32; 3]> =
        [0, 8].iter().flat_map(|first| BOX.map(|corners| corners.map(|corner| corner + first))).collect();
    // The cells of a millimetre that they touch.
    let solid = part([18, 4, 7], |[x, _, z]| {
        let [low, high] = [f64::from(x), f64::from(x) + 1.0].map(rise);
        let bar = x < 12 && f64::from(z) < high + 3.0 && f64::from(z) + 1.0 > low;
        bar || x >= 14 && z < 5
    });
    let cells = solid.cells();
    let workpiece = Workpiece {
        vertices: &vertices,
        triangles: &triangles,
        cells,
        cell_mm: 1.0,
        origin: Point3::origin(),
        platform: &solid.platform,
        rules: Rules::default(),
        volume_mm3: 144.0 + 72.0,
        guides: Guides::default(),
    };
    for layers_by in [LayersBy::Distance, LayersBy::Directed] {
        let options = LayerOptions { layers_by, rule: small(), ..LayerOptions::default() };
        let first = |height_mm: f64| {
            let order = workpiece.order(&LayerOptions { height_mm: Some(height_mm), ..options }, &go).unwrap();
            assert!(order.audit.is_ok() && order.growth.missed.is_empty());
            let mut columns: Vec<u32> =
                order.growth.order.layer(0).iter().map(|&cell| cells.position(cell)[0]).collect();
            columns.sort_unstable();
            columns.dedup();
            columns
        };
        assert_eq!(first(0.4), [0, 14, 15, 16, 17]); // 0.2 mm above the plate the plate is 0.67 mm wide
        assert_eq!(first(0.8), [0, 1, 14, 15, 16, 17]); // and 1.33 mm at 0.4 mm
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_order() {
    let (dome, nozzle) = (dome(), tip_1_mm());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let made = pool.install(|| grown(&dome, &nozzle));
        (made.field.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>(), made.growth, made.rounds)
    };
    assert!(with(1) == with(4));
}

/// A ball that hangs below a beam on two posts.
fn hanging_ball() -> Part {
    part([31, 11, 27], |[x, y, z]: [u32; 3]| {
        let [dx, dy, dz] = [f64::from(x) - 15.0, f64::from(y) - 5.0, f64::from(z) - 12.0];
        let post = !(2..=28).contains(&x) && (4..7).contains(&y);
        let beam = z >= 24 && (4..7).contains(&y);
        let stem = (14..17).contains(&x) && (4..7).contains(&y) && z > 12;
        post || beam || stem || dx * dx + dy * dy + dz * dz < 5.2 * 5.2
    })
}

/// In one call, with support where the nozzle does not get to; the best is never worse than what hulls miss.
#[test]
fn a_part_is_complete_by_distance() {
    for part in [dome(), hanging_ball()] {
        let cells = part.cells();
        let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin());
        let workpiece = Workpiece {
            vertices: &mesh.vertices,
            triangles: &mesh.triangles,
            cells,
            cell_mm: 1.0,
            origin: Point3::origin(),
            platform: &part.platform,
            rules: Rules::default(),
            volume_mm3: cells.count() as f64,
            guides: Guides::default(),
        };
        let options = |layers_by| LayerOptions { layers_by, rule: small(), ..LayerOptions::default() };
        let complete = |by| workpiece.layers(&LayerOptions { height_mm: Some(1.0), ..options(by) }, &go).unwrap();
        let [by_hull, by_distance, best] = [LayersBy::Hull, LayersBy::Distance, LayersBy::Best].map(complete);
        let directed = complete(LayersBy::Directed);
        // Bug: of support some of whose cells are missed the field was another than that of the order, and had a layer for each step. It has one for each two
        // steps, and one for each of the few that the nozzle adds afterwards.
        for made in [&by_distance, &directed] {
            let (field, order) = (&made.uniform.field, &made.growth.order);
            let highest = order.cells().iter().filter_map(|&cell| field.value(cell)).fold(0.0, f64::max);
            assert!(highest < 0.75 * order.len() as f64, "{highest}: {} steps", order.len());
        }
        assert_eq!((directed.layers_by, directed.uniform.method), (LayersBy::Directed, UniformMethod::Directed));
        assert!(directed.audit.is_ok() && directed.uniform.audit.is_ok());
        let share = directed.surfaces.spacing.volume_mm3 / workpiece.volume_mm3;
        assert!((share - 1.0).abs() < 0.08, "{share}");
        let missed = [&by_hull, &by_distance, &directed, &best].map(|made| made.growth.missed.len());
        assert!(missed[3] <= missed[0].min(missed[1]).min(missed[2]), "{missed:?}");
        if missed[2] == 0 {
            assert_eq!(best.layers_by, LayersBy::Directed); // it is tried first
        }
        assert_eq!([by_hull.layers_by, by_distance.layers_by], [LayersBy::Hull, LayersBy::Distance]);
        assert_eq!(by_distance.uniform.method, UniformMethod::Distance);
        assert!(by_distance.audit.is_ok() && by_distance.uniform.audit.is_ok());
        let share = by_distance.surfaces.spacing.volume_mm3 / workpiece.volume_mm3;
        assert!((share - 1.0).abs() < 0.08, "{share}");
    }
}

#[test]
fn bad_input_is_refused() {
    let tower = part([2, 2, 3], |_| true);
    let (cells, rules, nozzle) = (tower.cells(), Rules::default(), tip_1_mm());
    let grow = |cell_mm: f64, rules: &Rules, nozzle: &NozzleRule| {
        grow_by_distance(&cells, cell_mm, &tower.platform, rules, None, nozzle, &go).unwrap_err()
    };
    for cell_mm in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(grow(cell_mm, &rules, &nozzle), NozzleRuleError::Cell { cell_mm }.into());
    }
    assert!(matches!(grow(f64::NAN, &rules, &nozzle), GrowthError::Nozzle(NozzleRuleError::Cell { .. })));
    let narrow = NozzleRule { block_mm: 1.0, ..nozzle };
    assert!(matches!(grow(1.0, &rules, &narrow), GrowthError::Nozzle(NozzleRuleError::Block { .. })));
    assert!(matches!(grow(1.0, &Rules { inside_depth_cells: f64::NAN, ..rules }, &nozzle), GrowthError::Rules(_)));
    let stop = |_: Progress| ControlFlow::Break(());
    let cancelled = grow_by_distance(&cells, 1.0, &tower.platform, &rules, None, &nozzle, &stop);
    assert_eq!(cancelled.unwrap_err(), GrowthError::Cancelled);

    let hanging = part([2, 2, 3], |[_, _, z]| z > 0);
    let nothing = distance_field(&hanging.cells(), &hanging.platform, &rules);
    assert_eq!(nothing.unwrap_err(), GrowthError::NothingOnPlatform);
    let nothing = grow_by_distance(&hanging.cells(), 1.0, &hanging.platform, &rules, None, &nozzle, &go);
    assert_eq!(nothing.unwrap_err(), GrowthError::NothingOnPlatform);

    let mut order = LayerOrder::new();
    assert_eq!(distance_layers(&cells, &field_of(&tower), &order), Err(FieldError::Empty));
    order.push([12]);
    assert_eq!(distance_layers(&cells, &field_of(&tower), &order), Err(FieldError::OutsideGrid { cell: 12, len: 12 }));
    let mut of_empty = LayerOrder::new();
    of_empty.push([0]);
    let not_solid = distance_layers(&hanging.cells(), &field_of(&tower), &of_empty);
    assert_eq!(not_solid, Err(FieldError::NotSolid { cell: 0 }));
    let workpiece_error = LayersError::Growth(GrowthError::NothingOnPlatform);
    assert_eq!(LayersError::from(GrowthError::NothingOnPlatform), workpiece_error);
}
