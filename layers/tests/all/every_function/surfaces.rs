//! Fields, surfaces, trimming, workpieces, saved fields.

use super::numbers::{DIMS, Small, bad, box_of, fit, ids, mesh, nozzles, number, order, point, small, vector};
use crate::common::{BOX, go};
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::Strategy;
use curvlay_layers::curved::surface::*;
use curvlay_layers::curved::*;
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::trim::*;
use proptest::prelude::*;
use proptest::strategy::Strategy as Drawn;

/// A level square, above the origin.
fn square(z: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let corners = [[-1.0, -1.0], [6.0, -1.0], [6.0, 6.0], [-1.0, 6.0]].map(|[x, y]| Point3::new(x, y, z));
    (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

fn feed_field(field: &LayerField, cells: &Cells, numbers: [f64; 3]) {
    let [a, b, c] = numbers;
    let _ = (field.highest(), field.half_layers(), field.steps_per_layer(), field.layer_cells(), field.torn_share(a));
    assert_eq!((field.dims(), field.values().len()), (cells.dims(), 60));
    let orders = [field.rounded(), field.order()].map(|order| order.cells().len());
    assert!(orders.into_iter().all(|len| len <= field.count()));
    for cell in [0, 59, 60, u32::MAX] {
        let _ = field.value(cell);
    }
    for (heights, cell_mm) in [(&[a, b][..], 1.0), (&[0.5, 1.5], c), (&[], 1.0)] {
        let _ = field.cells_by_surface(heights, cell_mm);
    }
    let _ = write_field_vtk(std::io::sink(), field, a, Point3::new(b, c, 0.0));
}

fn feed_surfaces(surfaces: &mut [Surface], numbers: [f64; 3], rounds: u32) {
    let [a, b, c] = numbers;
    for smoothing in [BorderSmoothing::default(), BorderSmoothing { rounds, reach: a }] {
        surfaces.iter_mut().for_each(|surface| surface.smooth_border(b, smoothing));
    }
    let slices: Vec<SurfaceSlices<'_>> =
        surfaces.iter().map(|surface| (&surface.points[..], &surface.triangles[..])).collect();
    let solid = Trimmer::new(&box_of([5.0, 4.0, 3.0]), &BOX).unwrap();
    for height in [1.0, c] {
        let spacings =
            [measure_spacing(&slices, height, &go).ok(), measure_spacing_within(&slices, &solid, height, &go).ok()];
        for spacing in spacings {
            let _ = write_surfaces_vtk(std::io::sink(), &slices, spacing.as_ref());
        }
    }
    let _ = count_crossings(&slices, &go);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn fields_take_anything(
        part in small(), values in prop::collection::vec(number(), 0..70), layer in number(), half in prop::option::of(number()), per_layer in prop::sample::select(vec![0, 1, 2, u32::MAX]), numbers in [number(), number(), number()], rounds in 0..4u32,
        made in order(), missed in ids(), levels in prop::collection::vec(number(), 0..5), origin in point(), value in bad(), solid in mesh(),
    ) {
        let cells = &part.cells();
        let spoilt: Vec<f64> = part.heights().iter().enumerate().map(|(k, height)| if k == 7 { value } else { *height }).collect();
        let fields = [
            LayerField::new(cells, values.clone(), 1.0), LayerField::new(cells, part.heights(), layer), LayerField::new(cells, spoilt, 1.0), LayerField::new(cells, part.heights(), 1.0),
            plain_field(cells, &made), plain_field(cells, &LayerOrder::new()),
        ];
        for field in fields.into_iter().flatten() {
            let field = field.in_steps(per_layer).with_half_layers(half);
            feed_field(&field, cells, numbers);
            let extended = extend(&field, cells);
            let _ = (extended.layer_cells(), extended.highest(), extended.jumps(), extended.ring_cells());
            let _ = (extended.value([0, 1, 2]), extended.value([i32::MIN, 0, i32::MAX]));
            let mut all = vec![levels.clone()];
            for (cell_mm, height) in [(1.0, 1.0), (numbers[0], 1.0), (1.0, numbers[1]), (value, numbers[2])] {
                all.extend(extended.levels(cell_mm, height));
                for (vertices, triangles) in [(&box_of([5.0, 4.0, 3.0]), &BOX[..]), (&solid.0, &solid.1)] {
                    let _ = extended.fitted_levels(vertices, triangles, cell_mm, origin, height);
                }
            }
            for levels in all.iter().filter(|levels| levels.len() < 99) {
                for (cell_mm, origin) in [(1.0, Point3::origin()), (numbers[0], origin)] {
                    let _ = contour(&extended, levels, cell_mm, origin, &go);
                    if let Ok(mut surfaces) = contour_with(&extended, levels, cell_mm, origin, VertexPlacement::Features, &go) {
                        feed_surfaces(&mut surfaces, numbers, rounds);
                    }
                }
            }
        }
        let Small { platform, rules, .. } = &part;
        let grown = grow(cells, platform, rules, &GrowthOptions::default(), None, &go);
        let orders = grown.map(|growth| (growth.missed_cells(), growth.order)).into_iter().chain([(missed, made)]);
        for (missed, order) in orders {
            let _ = uniform_field(cells, platform, rules, &order, &missed, &go);
            for (rule, cell_mm) in nozzles(value).into_iter().map(|rule| (rule, 1.0)).chain([(NozzleRule::default(), value)]) {
                let judged = JudgedByNozzle { rule, cell_mm, steps: per_layer, cells: &[] };
                let _ = uniform_field_with_nozzle(cells, platform, rules, &judged, &order, &missed, &go);
            }
        }
    }

    #[test]
    fn trimming_takes_anything(solid in mesh(), other in mesh(), sheet in mesh(), value in bad(), height in number(), points in prop::collection::vec(point(), 0..9), triangles in prop::collection::vec([0..9u32, 0..9u32, 0..9u32], 0..4)) {
        let cube = (box_of([5.0, 4.0, 3.0]), BOX.to_vec());
        let part = |mesh: &(Vec<Point3<f64>>, Vec<[u32; 3]>)| Trimmer::new(&mesh.0, &mesh.1);
        let outside = Trimmer::new_outside((&cube.0, &cube.1), (&solid.0, &solid.1));
        let trimmers = [part(&solid), part(&cube), outside, Trimmer::new_outside((&solid.0, &solid.1), (&other.0, &other.1)), part(&cube).map(|trimmer| trimmer.thinned(value))];
        for trimmer in trimmers.into_iter().flatten() {
            trimmer.is_holed();
            let sheets = [&square(1.0), &sheet, &(points.clone(), triangles.clone())].map(|(points, triangles)| trimmer.trim(points, triangles, &go));
            let mut trimmed: Vec<TrimmedSheet> = sheets.into_iter().flatten().collect();
            for sheet in &trimmed {
                let _ = (sheet.area(), sheet.border_turning());
            }
            let _ = trimmer.clip(&mut trimmed.clone(), 1.0, &go);
            // The fields are open: a sheet that no trimmer made.
            if let Some(first) = trimmed.first_mut() {
                (first.vertices, first.triangles) = (points.clone(), triangles.clone());
            }
            let _ = trimmer.clip(&mut trimmed, height, &go);
        }
        let mut loose = [Surface { value, points, triangles }];
        feed_surfaces(&mut loose, [height, 1.0, height], 2);
    }

    #[test]
    fn files_take_anything(text in "[a-z0-9_ .,\n-]{0,80}", any in prop::collection::vec(any::<u8>(), 0..60), most in prop::sample::select(vec![0, 60, u64::MAX]), part in small(), cell_mm in number(), origin in point(), aids in [ids(), ids(), ids()], cut in 0..400usize, value in bad(), leaning in vector(), rows in prop::collection::vec(any::<u64>(), 0..13)) {
        let cells = part.cells();
        let mut texts = vec![text.into_bytes(), any];
        if let Ok(field) = LayerField::new(&cells, part.heights(), 1.0) {
            let [support, gap, contact] = aids;
            let nozzle = support.iter().map(|&cell| NozzleCell { cell, direction: curvlay_layers::nalgebra::Unit::new_unchecked(leaning) }).collect();
            let rule = nozzles(value)[cut % 7];
            for rows in [part.rows.clone(), rows] {
                let aids = PrintAids { support: support.clone(), gap: gap.clone(), contact: contact.clone(), rule, nozzle: Vec::clone(&nozzle) };
                let saved = SavedField { field: field.clone(), rows, cell_mm, origin, mesh: mesh_stamp(&[origin], &[[0, 0, u32::MAX]]), aids };
                let _ = (saved.cells().map(|cells| cells.count()), saved.growth(), saved.check_mesh(cut as u64), saved.surfaces_stamp(value), saved.check_cells(&cells, origin));
                let mut written = Vec::new();
                if saved.write(&mut written).is_ok() {
                    texts.push(written[..cut.min(written.len())].to_vec());
                    texts.push(written);
                }
            }
        }
        for text in &texts {
            let _ = SavedField::read(&text[..]);
            let _ = SavedField::read_within(most, &text[..]);
        }
    }
}

/// A workpiece on a box, as the part has it or spoilt in one place.
fn spoilt<'a>(sound: &Workpiece<'a>, kind: usize, value: f64, point: Point3<f64>, lists: &'a Lists) -> Workpiece<'a> {
    let mut work = *sound;
    match kind {
        0 => work.cell_mm = value,
        1 => work.origin = point,
        2 => work.volume_mm3 = value,
        3 => work.guides.support = &lists.support,
        4 => work.guides.heights = Some(&lists.heights),
        5 => work.guides.directions = Some(&lists.directions),
        6 => (work.vertices, work.triangles) = (&lists.mesh.0, &lists.mesh.1),
        _ => {}
    }
    work
}

#[derive(Debug)]
struct Lists {
    support: Vec<u32>,
    heights: Vec<f64>,
    directions: Vec<Vector3<f64>>,
    mesh: (Vec<Point3<f64>>, Vec<[u32; 3]>),
}

fn lists() -> impl Drawn<Value = Lists> {
    let heights = prop::collection::vec(number(), 1..70);
    let directions = prop::collection::vec(vector(), 1..70);
    (ids(), heights, directions, mesh(), any::<bool>()).prop_map(|(support, heights, directions, mesh, fits)| {
        let count = |given: usize| if fits { 60 } else { given };
        let (heights, directions) = (fit(&heights, count(heights.len())), fit(&directions, count(directions.len())));
        Lists { support, heights, directions, mesh }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn workpieces_take_anything(
        part in small(), lists in lists(), kind in 0..9usize, value in bad(), places in prop::collection::vec(point(), 0..4), vector in vector(), missed in ids(), made in order(), number in number(), fields in prop::collection::vec(number(), 60), by in 0..4usize,
    ) {
        let (vertices, cells) = (box_of([5.0, 4.0, 3.0]), part.cells());
        let origin = places.first().copied().unwrap_or_else(Point3::origin);
        let _ = Workpiece::new((&lists.mesh.0, &lists.mesh.1), cells, value, origin, &part.platform, &go);
        let Ok(sound) = Workpiece::new((&vertices, &BOX), cells, 1.0, Point3::origin(), &part.platform, &go) else { return Ok(()) };
        let work = spoilt(&Workpiece { rules: part.rules, ..sound }, kind, value, origin, &lists);
        let _ = work.cells_below(&places);
        let directions: Vec<DirectionAt> = places.iter().map(|&place| DirectionAt { place, direction: vector }).collect();
        let _ = (work.directions_at(&directions), work.upright_directions(number), work.upright_directions(value));
        for (vertices, triangles) in [square(2.0), lists.mesh.clone()] {
            let _ = work.heights_over(&vertices, &triangles);
        }
        let _ = work.volume_of(&missed, &go);
        let layers_by = [LayersBy::Hull, LayersBy::Distance, LayersBy::Directed, LayersBy::Best][by];
        let nozzle = [NozzleUse::Off, NozzleUse::After, NozzleUse::FromStart][by % 3];
        let fine = LayerOptions { layers_by, nozzle, strategy: Some(Strategy::Greedy), ..LayerOptions::hull_rule() };
        let spoilt_options = [fine, LayerOptions { height_mm: Some(value), ..fine }, LayerOptions { rule: nozzles(value)[1 + by], ..fine }, LayerOptions { support: Some(SupportOptions::default()), coherent: true, ..fine }];
        for options in spoilt_options {
            if let Ok(order) = work.order(&options, &go) {
                prop_assert!(order.final_growth().order.len() <= 60 && order.support_cells().cells.len() <= 60);
                let _ = (order.united(&cells), work.field_of(&order, &options, &go));
                let mut wrong = order.clone();
                wrong.growth.order = made.clone();
                let _ = work.field_of(&wrong, &options, &go);
                let _ = work.layers_of(wrong, &options, &go);
            }
            let Ok(layered) = work.layers(&options, &go) else { continue };
            let surfaces = &layered.surfaces;
            let _ = (surfaces.slices().len(), surfaces.is_whole(), surfaces.iter().count(), surfaces.pieces(), surfaces.thickness_share(), surfaces.lost_mm3(value));
            if let Some(support) = &layered.support {
                let _ = support.printed_with(surfaces);
            }
        }
        let values = [part.heights(), fields.iter().zip(part.heights()).map(|(value, height)| if height.is_nan() { height } else { *value }).collect()];
        for field in values.into_iter().filter_map(|values| LayerField::new(&cells, values, 1.0).ok()) {
            for height in [1.0, value] {
                let _ = work.surfaces(&field, &missed, height, &go);
                let support = SupportCells { cells: &lists.support, contact: &missed };
                for rows in [&part.rows, &vec![31; 12], &vec![1; 2]] {
                    let _ = work.surfaces_and_support(&field, rows, support, &missed, height, &go);
                    let Ok(planned) = PlannedSurfaces::new(&work, &field, rows, support, &missed, height, &go) else { continue };
                    let _ = (planned.len(), planned.is_empty());
                    for range in [0..by, by..planned.len(), by..by + 1, usize::MAX - by..usize::MAX, usize::MAX..by] {
                        let wide = planned.with_neighbours(range.clone(), by);
                        let _ = [range, wide].map(|range| planned.make(range, &go).map(|(surfaces, _)| surfaces.is_whole()));
                    }
                }
            }
        }
        prop_assert_eq!(cells.dims(), DIMS);
    }
}
