//! Plates and parts that end between two layers of cells: their layers fit, and hold their volume.

use crate::common::{BOX, go};
use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::{extend, plain_field};
use curvlay_layers::curved::{Guides, LayerOptions, LayerSurfaces, Platform, Rules, Strategy, Workpiece};
use nalgebra::Point3;
use proptest::prelude::*;

/// Boxes from the plate up: low and high corner of each in x and y, and its height, in millimetres. They may touch.
#[derive(Clone, Debug)]
struct Boxes(Vec<([f64; 2], [f64; 2], f64)>);

impl Boxes {
    fn mesh(&self) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for (low, high, top) in &self.0 {
            let first = points.len() as u32;
            let at = |k: u32, axis: usize| if k >> axis & 1 == 1 { high[axis] } else { low[axis] };
            points.extend((0..8).map(|k| Point3::new(at(k, 0), at(k, 1), if k >> 2 == 1 { *top } else { 0.0 })));
            triangles.extend(BOX.map(|face| face.map(|corner| corner + first)));
        }
        (points, triangles)
    }

    fn volume(&self) -> f64 {
        self.0.iter().map(|(low, high, top)| (high[0] - low[0]) * (high[1] - low[1]) * top).sum()
    }

    /// All cells of the given size that the boxes share space with.
    fn cells(&self, cell: f64) -> ([u32; 3], Vec<u64>) {
        let last = |length: f64| (length / cell - 1e-9).ceil() as u32;
        let most = |axis: usize| self.0.iter().map(|(_, high, _)| last(high[axis])).max().unwrap();
        let dims = [most(0), most(1), self.0.iter().map(|(_, _, top)| last(*top)).max().unwrap()];
        let row = |y: u32, z: u32| {
            (0..dims[0])
                .filter(|&x| {
                    self.0.iter().any(|(low, high, top)| {
                        let inside = |at: u32, low: f64, high: f64| {
                            f64::from(at + 1) * cell > low + 1e-9 && f64::from(at) * cell < high - 1e-9
                        };
                        inside(x, low[0], high[0]) && inside(y, low[1], high[1]) && inside(z, 0.0, *top)
                    })
                })
                .fold(0, |bits, x| bits | 1 << x)
        };
        let rows = (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect();
        (dims, rows)
    }

    fn layers(&self, cell_mm: f64, height_mm: f64) -> LayerSurfaces {
        let (dims, rows) = self.cells(cell_mm);
        let cells = Cells::new(dims, &rows).unwrap();
        let platform = Platform::under(&cells, 20.0).unwrap();
        let (vertices, triangles) = self.mesh();
        let part = Workpiece {
            vertices: &vertices,
            triangles: &triangles,
            cells,
            cell_mm,
            origin: Point3::origin(),
            platform: &platform,
            rules: Rules::default(),
            volume_mm3: self.volume(),
            guides: Guides::default(),
        };
        let strategy = Some(Strategy::Incremental);
        let options = LayerOptions { strategy, height_mm: Some(height_mm), ..LayerOptions::hull_rule() };
        part.layers(&options, &go).unwrap().surfaces
    }
}

fn plate(side: f64, thickness: f64) -> Boxes {
    Boxes(vec![([0.0; 2], [side; 2], thickness)])
}

/// Found: 60 x 60 x 0.8 mm was laid at 0.75 of its volume, 1.0 mm at 1.21.
#[test]
fn a_flat_plate_is_laid_at_its_volume_whatever_its_thickness() {
    for cell in [0.3, 0.44, 0.9] {
        for tenths in 2..=14 {
            let boxes = plate(12.0, f64::from(tenths) / 10.0);
            let layers = boxes.layers(cell, cell);
            let laid = layers.spacing.volume_mm3 / boxes.volume();
            assert!((laid - 1.0).abs() < 1e-6, "{tenths} tenths of a millimetre, cells of {cell}: {laid}");
            let layers_wanted = (f64::from(tenths) / 10.0 / cell).round().max(1.0) as usize;
            assert_eq!(layers.sheets.len(), layers_wanted);
            assert!(layers.sheets.iter().all(|sheet| (sheet.area() - 144.0).abs() < 1e-6));
        }
    }
}

#[test]
fn a_plate_within_one_cell_gets_one_surface_in_its_middle() {
    let layers = plate(9.0, 0.3).layers(1.0, 1.0);
    assert!((layers.height_mm - 0.3).abs() < 1e-9);
    let [sheet] = &layers.sheets[..] else { panic!("{} surfaces", layers.sheets.len()) };
    assert!(sheet.vertices.iter().all(|p| (p.z - 0.15).abs() < 1e-9));
    assert!(layers.thickness_mm[0].iter().all(|thickness| (thickness - 0.3).abs() < 1e-9));
}

/// A step down ends wherever its skin is; layers that fit the highest place do not fit it.
#[test]
fn the_last_layer_of_a_lower_step_goes_as_far_as_its_skin() {
    for low in [1.0, 1.3, 1.6, 1.9, 2.2] {
        let boxes = Boxes(vec![([0.0; 2], [6.0, 8.0], 4.0), ([6.0, 0.0], [14.0, 8.0], low)]);
        let laid = boxes.layers(0.5, 0.5).spacing.volume_mm3 / boxes.volume();
        assert!((laid - 1.0).abs() < 0.01, "a step of {low} mm: {laid}");
    }
}

/// A foot of one cell beside a tower: nothing above or below it says which way it grows, but it stands on the plate.
#[test]
fn a_foot_of_one_cell_has_a_surface() {
    let boxes = Boxes(vec![([0.0; 2], [4.0; 2], 6.0), ([4.0, 0.0], [16.0, 4.0], 0.8)]);
    let layers = boxes.layers(0.8, 0.8);
    let first = &layers.sheets[0];
    assert!((first.area() - 64.0).abs() < 1.0, "{} of 64 mm2", first.area());
}

/// Found: one corner of each layer was cut off, by 0.0025 mm.
#[test]
fn a_plate_keeps_corners_beside_short_edges() {
    let (boxes, cell) = (plate(8.0, 1.8384567377618746), 0.5331696744540604);
    let laid = boxes.layers(cell, 1.365748929649307 * cell).spacing.volume_mm3 / boxes.volume();
    assert!((laid - 1.0).abs() < 1e-6, "{laid}");
}

#[test]
fn where_fronts_meet_in_the_middle_of_a_face_the_layers_reach_that_far() {
    // The field is highest at the middle of the roof of one triangle pair, far from all of its vertices.
    let rows = vec![(1 << 9) - 1; 3];
    let cells = Cells::new([9, 1, 3], &rows).unwrap();
    let mut order = LayerOrder::new();
    for layer in 0..5u32 {
        let columns = if layer == 4 { vec![4] } else { vec![layer, 8 - layer] };
        order.push(columns.into_iter().flat_map(|x| (0..3).map(move |z| x + 9 * z)).collect::<Vec<_>>());
    }
    let extended = extend(&plain_field(&cells, &order).unwrap(), &cells);
    let (vertices, triangles) = Boxes(vec![([0.0; 2], [9.0, 1.0], 3.0)]).mesh();
    let fitted = extended.fitted_levels(&vertices, &triangles, 1.0, Point3::origin(), 1.0).unwrap();
    let highest = fitted.levels.last().unwrap() * extended.layer_cells();
    assert!(highest > 3.5, "{highest}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn plates_of_any_size_and_height_hold_their_volume(
        thickness in 0.05..3.0f64, cell in 0.25..1.2f64, of_cell in 0.3..1.6f64,
    ) {
        let boxes = plate(8.0, thickness);
        let (dims, _) = boxes.cells(cell);
        prop_assume!(of_cell <= f64::from(dims[2]) && dims[0] <= 64);
        let layers = boxes.layers(cell, of_cell * cell);
        let laid = layers.spacing.volume_mm3 / boxes.volume();
        prop_assert!((laid - 1.0).abs() < 1e-6, "{}", laid);
        // As near to the height that was asked for as whole layers allow.
        let count = layers.sheets.len() as f64;
        prop_assert!((thickness / (of_cell * cell) - count).abs() <= 0.5 + 1e-9 || layers.sheets.len() == 1);
    }
}
