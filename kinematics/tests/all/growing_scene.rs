//! The scene of a print against scenes made by hand for each state and layer, and the depth of the nozzle in the plate against
//! points of its edges.
#![cfg(feature = "serde")] // the cells are read from the files of the examples

use crate::common::cells::{over_table, ur3};
use curvlay_kinematics::Waypoint;
use curvlay_kinematics::nalgebra::{Isometry3, Point3, Translation3, UnitVector3, Vector3};
use curvlay_kinematics::scene::{Body, Scene, SceneError, SceneModel, Shape, Sweep};
use curvlay_kinematics::workcell::{
    ClearanceLevel, GrowingError, GrowingOptions, GrowingScene, HOT_END, NOZZLE, PART, PLATE, PartCells,
    SixAxisWorkcell, Workcell,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

/// 70 cells in x: rows of two words. Every second cell of the upper half is missing.
const DIMS: [u32; 3] = [70, 6, 4];
const PLATE_MM: f64 = 150.0;
const MARGIN_MM: f64 = 2.0;

/// The cells of the part by layer, and all of them as rows.
fn part_cells() -> (Vec<Vec<u32>>, Vec<u64>) {
    let [nx, ny, nz] = DIMS;
    let (mut layers, mut rows) = (vec![vec![]; 3], vec![0; (2 * ny * nz) as usize]);
    for z in 0..nz {
        for y in 0..ny {
            for x in (0..nx).filter(|x| z < 2 || x % 2 == 0) {
                rows[((y + ny * z) * 2 + x / 64) as usize] |= 1u64 << (x % 64);
                // The last layer holds the two upper sheets.
                layers[z.min(2) as usize].push(x + nx * (y + ny * z));
            }
        }
    }
    (layers, rows)
}

fn part<'a>(layers: &'a [Vec<u32>], rows: &'a [u64]) -> PartCells<'a> {
    let frame_part = Isometry3::new(Vector3::new(3.0, -2.0, 0.0), Vector3::z() * 0.7);
    PartCells { dims: DIMS, rows, cell_mm: 1.0, origin: Point3::new(-35.0, -3.0, 0.0), frame_part, layers }
}

/// What a scene with the first layers in it is made from, by hand.
fn model_by_hand(cell: &SixAxisWorkcell, part: &PartCells, layers: usize) -> SceneModel {
    let mut rows = vec![0; part.rows.len()];
    for &cell in part.layers[..layers].iter().flatten() {
        let (x, row) = (cell % DIMS[0], cell / DIMS[0]);
        rows[(row * 2 + x / 64) as usize] |= 1u64 << (x % 64);
    }
    let (mount, frame) = cell.equipment().part_frame();
    let mut model = cell.equipment().scene(PLATE_MM);
    model.bodies.push(Body {
        name: PART.into(),
        mount,
        mount_body: frame * part.frame_part * Translation3::from(part.origin.coords),
        shape: Shape::Cells { dims: part.dims, rows, cell: part.cell_mm },
    });
    SceneModel { margin: MARGIN_MM, ..model }
}

/// The scene.
fn by_hand(cell: &SixAxisWorkcell, part: &PartCells, layers: usize, clearance: f64, nozzle_touches: bool) -> Scene {
    let pairs = [[NOZZLE, PART], [NOZZLE, PLATE], [HOT_END, PART], [HOT_END, PLATE]];
    let allowed = if nozzle_touches { pairs.map(|pair| pair.map(str::to_owned)).to_vec() } else { vec![] };
    Scene::new(SceneModel { clearance, allowed, ..model_by_hand(cell, part, layers) }).unwrap()
}

/// The scene in which only these two bodies may not touch.
fn of_two(cell: &SixAxisWorkcell, part: &PartCells, layers: usize, [a, b]: [&str; 2]) -> Scene {
    let model = model_by_hand(cell, part, layers);
    let names: Vec<String> = model.links.iter().chain(&model.bodies).map(|body| body.name.clone()).collect();
    let others = |first: &String| {
        let pairs = names.iter().map(|second| [first.clone(), second.clone()]);
        pairs.filter(|pair| *pair != [a, b] && *pair != [b, a]).collect::<Vec<_>>()
    };
    let allowed = names.iter().flat_map(others).filter(|[first, second]| first < second).collect();
    Scene::new(SceneModel { allowed, ..model }).unwrap()
}

/// Postures with the nozzle near the part: some touch, some do not.
fn postures(cell: &SixAxisWorkcell, rng: &mut Pcg64, count: usize) -> Vec<[f64; 6]> {
    let mut found = vec![];
    while found.len() < count {
        let mut number = |least: f64, most: f64| least + (most - least) * rng.random::<f64>();
        let position = Point3::new(number(-40.0, 40.0), number(-10.0, 10.0), number(0.0, 8.0));
        let axis = UnitVector3::new_normalize(Vector3::new(number(-1.0, 1.0), number(-1.0, 1.0), 1.0));
        let (turn, wanted) = (number(0.0, TAU), number(0.0, 8.0) as usize);
        let mut k = 0;
        cell.solutions(&Waypoint { position, axis }, &[turn], &mut |_, joints| {
            found.extend((k == wanted).then_some(joints));
            k += 1;
        });
    }
    found
}

#[test]
fn every_state_is_the_scene_made_by_hand() {
    let (cell, (layers, rows)) = (ur3(), part_cells());
    let (part, options) = (part(&layers, &rows), GrowingOptions::default());
    let mut scene = GrowingScene::new(&cell, &part, PLATE_MM, &options).unwrap();
    let mut rng = Pcg64::seed_from_u64(24);
    let (mut touching, mut apart, mut swept, mut fine) = (0, 0, [0, 0], 0);
    for [begun, built] in [[0, 0], [1, 0], [2, 1], [3, 3]] {
        // A layer that is there already, and one beyond the last, do no harm.
        if begun > 0 {
            scene.begin(begun as u32 - 1).unwrap();
            scene.begin(0).unwrap();
        }
        if built > 0 {
            scene.build(if built == 3 { 1000 } else { built as u32 - 1 }).unwrap();
        }
        assert_eq!(scene.layers(), [begun, built]);
        let moving = by_hand(&cell, &part, built, 0.0, false);
        let printing = by_hand(&cell, &part, begun, 0.0, true);
        let clear = [9.5, 2.5, 0.5].map(|clearance| by_hand(&cell, &part, begun, clearance, true));
        let postures = postures(&cell, &mut rng, 50);
        for joints in &postures {
            let posture = (*joints).into();
            assert_eq!(scene.touching_moving(joints), moving.touching(&posture));
            for (level, by_hand) in ClearanceLevel::ALL.into_iter().zip(&clear) {
                let found = scene.touching_printing(joints, level).unwrap();
                assert_eq!(found, by_hand.touching(&posture).unwrap());
                if found.is_some() { touching += 1 } else { apart += 1 }
            }
            let (value, slope) = scene.indicator(joints);
            match printing.clearance(&posture, 30.0).unwrap() {
                Some(near) => {
                    assert_eq!((value, slope), (MARGIN_MM - near.nearest.distance, near.joints.map(|rate| -rate)));
                }
                None => assert_eq!((value, slope), (MARGIN_MM - 30.0, [0.0; 6])),
            }
        }
        for pair in postures.windows(2) {
            // A short motion about the first.
            let along = |share: f64| std::array::from_fn(|j| pair[0][j] + 0.02 * share * (pair[1][j] - pair[0][j]));
            let control = [along(0.0), along(2.0), along(1.0), along(3.0)];
            let scenes = [&printing, &moving];
            for (k, found) in [scene.sweep_printing(&control), scene.sweep_moving(&control)].into_iter().enumerate() {
                let look = |resolution| scenes[k].sweep_cubic(&control.map(Into::into), resolution).unwrap();
                let found = found.unwrap();
                match look(0.25) {
                    Sweep::Free => assert_eq!(found, None),
                    Sweep::Near { bodies, .. } => {
                        // What a coarse sweep proves is proven. Of several that are near at once, another may be named: near it is.
                        let is_near = |pair: [&str; 2]| {
                            let two = of_two(&cell, &part, [begun, built][k], pair);
                            two.sweep_cubic(&control.map(Into::into), 0.25).unwrap() != Sweep::Free
                        };
                        let found = found.map(|found| found == bodies || is_near(found));
                        assert!(found.unwrap_or_else(|| look(2.0) == Sweep::Free));
                    }
                }
                fine += usize::from(found.is_none() && look(2.0) != Sweep::Free);
                swept[usize::from(found.is_none())] += 1;
            }
            let free = scene.is_moving_free(&control[0], &control[3]).unwrap();
            assert_eq!(free, moving.is_free(&control[0].into(), &control[3].into(), 2.0).unwrap());
        }
    }
    println!("{touching} {apart} {swept:?} {fine}");
    assert!(touching > 50 && apart > 50 && swept.iter().all(|&count| count > 20) && fine > 0);
}

/// A mould is there from the start, in every state: as the first layers are once they are begun and built.
#[test]
fn a_mould_is_there_from_the_start() {
    let (cell, (layers, rows)) = (ur3(), part_cells());
    let (whole, upper) = (part(&layers, &rows), part(&layers[2..], &rows));
    let mut mould = vec![0; rows.len()];
    for &cell in layers[..2].iter().flatten() {
        let (x, row) = (cell % DIMS[0], cell / DIMS[0]);
        mould[(row * 2 + x / 64) as usize] |= 1u64 << (x % 64);
    }
    let scene = |part: &PartCells| GrowingScene::new(&cell, part, PLATE_MM, &GrowingOptions::default()).unwrap();
    let on_mould = scene(&upper).on_mould(&mould).unwrap();
    let mut built = scene(&whole);
    let bare = built.clone();
    built.begin(1).unwrap();
    built.build(1).unwrap();
    let mut differ = 0;
    for joints in postures(&cell, &mut Pcg64::seed_from_u64(7), 200) {
        assert_eq!(on_mould.touching_moving(&joints), built.touching_moving(&joints));
        assert_eq!(on_mould.indicator(&joints), built.indicator(&joints));
        for level in ClearanceLevel::ALL {
            assert_eq!(on_mould.touching_printing(&joints, level), built.touching_printing(&joints, level));
        }
        differ += usize::from(on_mould.touching_moving(&joints) != bare.touching_moving(&joints));
    }
    assert!(differ > 0);
    assert!(scene(&upper).on_mould(&mould[1..]).is_err());
}

#[test]
fn a_table_moves_the_indicator() {
    let cell = over_table();
    let (layers, rows) = part_cells();
    // Links above a part that lies on the table.
    let options = GrowingOptions { near_mm: 1e3, ..GrowingOptions::default() };
    let mut scene = GrowingScene::new(&cell, &part(&layers, &rows), PLATE_MM, &options).unwrap();
    scene.begin(2).unwrap();
    let waypoint = Waypoint { position: Point3::new(10.0, 4.0, 6.0), axis: Vector3::z_axis() };
    let mut looked = [0; 8];
    cell.solutions(&waypoint, &[0.4, 0.6], &mut |_, joints| {
        let (value, slope) = scene.indicator(&joints);
        if value >= options.margin_mm {
            return; // something overlaps: no slope
        }
        for j in 0..8 {
            let moved =
                |by: f64| scene.indicator(&std::array::from_fn(|k| joints[k] + if k == j { by } else { 0.0 })).0;
            let (ahead, behind) = (moved(1e-5) - value, value - moved(-1e-5));
            // Where the nearest pair changes the slope jumps.
            if (ahead - behind).abs() < 1e-6 {
                assert!((0.5 * (ahead + behind) / 1e-5 - slope[j]).abs() < 0.05, "{j} {slope:?}");
                looked[j] += usize::from(slope[j] != 0.0);
            }
        }
    });
    assert!(looked.iter().sum::<usize>() > 0, "{looked:?}");
}

#[test]
fn a_part_without_layers_is_an_empty_cell() {
    let (cell, (_, rows)) = (ur3(), part_cells());
    let mut scene = GrowingScene::new(&cell, &part(&[], &rows), PLATE_MM, &GrowingOptions::default()).unwrap();
    scene.begin(5).unwrap();
    scene.build(u32::MAX).unwrap();
    assert_eq!(scene.layers(), [0, 0]);
    let joints = postures(&cell, &mut Pcg64::seed_from_u64(1), 1)[0];
    let by_hand = by_hand(&cell, &part(&[], &rows), 0, 0.0, false);
    assert_eq!(scene.touching_moving(&joints), by_hand.touching(&joints.into()));
}

#[test]
fn numbers_that_cannot_be_are_named() {
    let (cell, (layers, rows)) = (ur3(), part_cells());
    let good = GrowingOptions::default();
    let error = |part: &PartCells, plate_mm: f64, options: GrowingOptions| {
        GrowingScene::new(&cell, part, plate_mm, &options).map(|_| ()).unwrap_err()
    };
    let part = part(&layers, &rows);
    let named = |options: GrowingOptions| match error(&part, PLATE_MM, options) {
        GrowingError::Option { option, .. } => option,
        other => panic!("{other}"),
    };
    for clearances_mm in [[1.0, 2.0, 0.5], [2.0, 1.0, -0.5], [f64::INFINITY, 1.0, 0.5], [2.0, f64::NAN, 0.5]] {
        assert_eq!(named(GrowingOptions { clearances_mm, ..good }), "clearances_mm");
    }
    for wrong in [0.0, 1e-4, f64::NAN, f64::INFINITY] {
        assert_eq!(named(GrowingOptions { resolution_mm: wrong, ..good }), "resolution_mm");
        assert_eq!(named(GrowingOptions { fine_resolution_mm: wrong, ..good }), "fine_resolution_mm");
    }
    // The least clearances that may be, and nothing that is near.
    let least =
        GrowingOptions { clearances_mm: [0.0; 3], resolution_mm: 5.0, fine_resolution_mm: 2.0, near_mm: 0.0, ..good };
    assert!(GrowingScene::new(&cell, &part, PLATE_MM, &least).is_ok());
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(named(GrowingOptions { near_mm: wrong, ..good }), "near_mm");
        let margin = error(&part, PLATE_MM, GrowingOptions { margin_mm: wrong, ..good });
        assert!(matches!(margin, GrowingError::Scene(SceneError::Margin { .. })), "{margin}");
    }
    // A cell beyond the grid, and one that the part does not have.
    for cell in [u32::MAX, 70 * 6 * 4, 70 * 6 * 2 + 1] {
        let layers = [vec![0], vec![1, cell]];
        let found = error(&PartCells { layers: &layers, ..part }, PLATE_MM, good);
        assert_eq!(found, GrowingError::Cell { layer: 1, cell });
        assert_eq!(found.to_string(), format!("layer 1 has cell {cell}, which is no cell of the part"));
    }
    let short = error(&PartCells { rows: &rows[1..], ..part }, PLATE_MM, good);
    assert!(matches!(short, GrowingError::Scene(SceneError::Words { .. })), "{short}");
    let flat = error(&PartCells { dims: [0, 6, 4], rows: &[], ..part }, PLATE_MM, good);
    assert!(matches!(flat, GrowingError::Scene(SceneError::Empty { .. })), "{flat}");
    let plate = error(&part, f64::NAN, good);
    assert!(matches!(plate, GrowingError::Scene(SceneError::Point { .. })), "{plate}");

    let scene = GrowingScene::new(&cell, &part, PLATE_MM, &good).unwrap();
    let nowhere = [f64::NAN; 6];
    assert!(scene.touching_moving(&nowhere).is_err());
    assert!(scene.touching_printing(&nowhere, ClearanceLevel::Wide).is_err());
    assert!(scene.sweep_printing(&[[0.0; 6], nowhere, [0.0; 6], [0.0; 6]]).is_err());
    assert!(scene.is_moving_free(&[0.0; 6], &nowhere).is_err());
    assert_eq!(scene.indicator(&nowhere), (MARGIN_MM - 30.0, [0.0; 6]));
}

/// The lowest points of the circles around the tip flat, and around both ends of the block.
#[test]
fn the_depth_in_the_plate_is_that_of_the_lowest_edge() {
    let cell = ur3();
    let nozzle = cell.equipment().model().nozzle;
    let edges = [
        (NOZZLE, 0.0, nozzle.tip_flat_mm),
        (HOT_END, nozzle.cone_height_mm, nozzle.block_diameter_mm),
        (HOT_END, nozzle.block_top_mm, nozzle.block_diameter_mm),
    ];
    let mut rng = Pcg64::seed_from_u64(7);
    let mut found = [0; 3];
    for _ in 0..1000 {
        let mut number = || 2.0 * rng.random::<f64>() - 1.0;
        let axis = UnitVector3::new_normalize(Vector3::new(number(), number(), number()));
        let tip = Point3::new(number(), number(), 12.0 * number() + 6.0);
        let across = axis.cross(&Vector3::new(0.3, 0.5, 0.7)).normalize();
        let lowest = edges.map(|(body, height, diameter)| {
            let around = |k: u32| {
                let (sin, cos) = (TAU * f64::from(k) / 3600.0).sin_cos();
                (tip + axis.scale(height) + (across * cos + axis.cross(&across) * sin) * diameter / 2.0).z
            };
            (body, (0..3600).map(around).fold(f64::INFINITY, f64::min))
        });
        let (body, z) = lowest.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        match cell.equipment().depth_in_plate(&tip, &axis) {
            Some(contact) => {
                assert!((contact.depth_mm + z).abs() < 1e-4 && contact.body == body, "{contact:?} {body} {z}");
                found[usize::from(body == HOT_END)] += 1;
            }
            None => {
                assert!(z > -1e-4);
                found[2] += 1;
            }
        }
    }
    assert!(found.iter().all(|&count| count > 10), "{found:?}");
    // Upright on the plate it is nowhere in it; what is no number is not above.
    let up = Vector3::z_axis();
    assert_eq!(cell.equipment().depth_in_plate(&Point3::origin(), &up), None);
    assert!(cell.equipment().depth_in_plate(&Point3::new(0.0, 0.0, f64::NAN), &up).is_some());
}
