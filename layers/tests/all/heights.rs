//! Layers parallel to a surface: heights by closed forms, and the layers of a block.

use crate::common::{go, tip_1_mm};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    CellMesh, GrowthError, Guides, HeightsError, LayerOptions, LayersBy, NozzleRule, Platform, Rules, SupportOptions,
    Workpiece, cell_mesh, grow_by_heights,
};
use curvlay_layers::nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

const DIMS: [u32; 3] = [12, 8, 10];

/// A block of cells of a millimetre.
struct Block {
    rows: Vec<u64>,
    mesh: CellMesh,
    platform: Platform,
}

impl Block {
    fn new() -> Block {
        let rows = vec![(1 << DIMS[0]) - 1; (DIMS[1] * DIMS[2]) as usize];
        let cells = Cells::new(DIMS, &rows).unwrap();
        let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), 1.0, Point3::origin());
        let platform = Platform::under(&cells, 40.0).unwrap();
        Block { rows, mesh, platform }
    }

    fn workpiece<'a>(&'a self, heights: Option<&'a [f64]>) -> Workpiece<'a> {
        Workpiece {
            vertices: &self.mesh.vertices,
            triangles: &self.mesh.triangles,
            cells: Cells::new(DIMS, &self.rows).unwrap(),
            cell_mm: 1.0,
            origin: Point3::origin(),
            platform: &self.platform,
            rules: Rules::default(),
            volume_mm3: 960.0,
            guides: Guides { heights, ..Guides::default() },
        }
    }
}

/// A surface over a square of 60 mm around the block.
fn sheet(step: f64, height: impl Fn(f64, f64) -> f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let side = (60.0 / step).round() as u32;
    let at = |i: u32, j: u32| {
        let [x, y] = [i, j].map(|k| f64::from(k) * step);
        Point3::new(x - 24.0, y - 26.0, height(x - 24.0, y - 26.0))
    };
    let vertices = (0..=side).flat_map(|j| (0..=side).map(move |i| [i, j])).map(|[i, j]| at(i, j)).collect();
    let squares = (0..side).flat_map(|j| (0..side).map(move |i| i + j * (side + 1)));
    let triangles = squares.flat_map(|k| [[k, k + 1, k + side + 2], [k, k + side + 2, k + side + 1]]).collect();
    (vertices, triangles)
}

fn centre(cell: u32) -> Point3<f64> {
    let [nx, ny, _] = DIMS;
    Point3::from([cell % nx, cell / nx % ny, cell / nx / ny].map(|k| f64::from(k) + 0.5))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Over a plane the height is the distance along its normal; the way round of the triangles does not matter.
    #[test]
    fn heights_over_a_plane(slope in (-0.8..0.8f64, -0.8..0.8f64), z in 1.0..9.0f64, turned in any::<bool>()) {
        let block = Block::new();
        let (vertices, triangles) = sheet(20.0, |x, y| z + slope.0 * (x - 6.0) + slope.1 * (y - 4.0));
        let triangles: Vec<[u32; 3]> = triangles.into_iter().map(|[a, b, c]| if turned { [a, c, b] } else { [a, b, c] }).collect();
        let heights = block.workpiece(None).heights_over(&vertices, &triangles).unwrap();
        let normal = Vector3::new(-slope.0, -slope.1, 1.0).normalize();
        for (cell, height) in (0..).zip(heights) {
            let expected = (centre(cell) - Point3::new(6.0, 4.0, z)).dot(&normal);
            prop_assert!((height - expected).abs() < 1e-9, "{cell}: {height} {expected}");
        }
    }

    /// The side is right beside edges and corners too: above a rough surface the height is positive, below it negative.
    #[test]
    fn the_side_is_that_of_the_surface(bumps in prop::collection::vec(0.0..6.0f64, 49)) {
        let block = Block::new();
        let height = |x: f64, y: f64| bumps[(((x + 24.0) / 10.0).round() + 7.0 * ((y + 26.0) / 10.0).round()) as usize];
        let (vertices, triangles) = sheet(10.0, height);
        let heights = block.workpiece(None).heights_over(&vertices, &triangles).unwrap();
        for (cell, found) in (0..).zip(heights) {
            let p = centre(cell);
            // The height of the surface above the same place: of the triangle of its square.
            let [u, v] = [(p.x + 24.0) / 10.0, (p.y + 26.0) / 10.0];
            let corner = |i: f64, j: f64| bumps[(u.floor() + i + 7.0 * (v.floor() + j)) as usize];
            let (s, t) = (u.fract(), v.fract());
            let at = if s > t {
                corner(0.0, 0.0) * (1.0 - s) + corner(1.0, 0.0) * (s - t) + corner(1.0, 1.0) * t
            } else {
                corner(0.0, 0.0) * (1.0 - t) + corner(0.0, 1.0) * (t - s) + corner(1.0, 1.0) * s
            };
            prop_assert!((p.z - at) * found > -1e-9, "{cell}: {found}, {}", p.z - at);
        }
    }
}

/// The layers of a block over a plane that leans by 25 degrees are planes like it, a layer apart, and the audit passes.
#[test]
fn layers_are_parallel_to_a_plane() {
    let block = Block::new();
    let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), 25_f64.to_radians());
    let normal = tilt * Vector3::z();
    let (vertices, triangles) = sheet(30.0, |x, _| 5.0 - normal.x / normal.z * (x - 6.0));
    let heights = block.workpiece(None).heights_over(&vertices, &triangles).unwrap();
    let part = block.workpiece(Some(&heights));
    let options = LayerOptions {
        layers_by: LayersBy::Distance,
        rule: NozzleRule { cone_height_mm: 8.0, block_mm: 20.0, ..tip_1_mm() },
        height_mm: Some(0.5),
        ..LayerOptions::default()
    };
    let made = part.layers(&options, &go).unwrap();
    assert!(made.growth.missed.is_empty() && made.audit.is_ok() && made.uniform.audit.is_ok());
    let field = &made.uniform.field;
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    for cell in 0..960u32 {
        let expected = heights[cell as usize] - lowest + 0.5;
        assert!((field.value(cell).unwrap() - expected).abs() < 1e-9, "{cell}: {:?} {expected}", field.value(cell));
    }
    let surfaces = &made.surfaces;
    let mut last = f64::NEG_INFINITY;
    for sheet in surfaces.sheets.iter().filter(|sheet| !sheet.vertices.is_empty()) {
        let height = |vertex: &Point3<f64>| vertex.coords.dot(&normal);
        // Contours keep their vertices a little within their cells, which may move them off the plane.
        let is_inside = |p: &&Point3<f64>| (0..3).all(|k| p[k] > 1.0 && p[k] < f64::from(DIMS[k]) - 1.0);
        let Some(low) = sheet.vertices.iter().find(is_inside).map(height) else { continue };
        for vertex in &sheet.vertices {
            assert!((height(vertex) - low).abs() < 0.01, "{vertex}: {} {low}", height(vertex));
        }
        assert!(last.is_infinite() || (low - last - surfaces.height_mm).abs() < 0.01, "{last} {low}");
        last = low;
    }
    assert!((surfaces.spacing.volume_mm3 / 960.0 - 1.0).abs() < 0.02, "{}", surfaces.spacing.volume_mm3);

    // Support is grown by the same heights.
    let given = [0, 1, 2];
    let guides = Guides { support: &given, ..part.guides };
    let support = Some(SupportOptions::default());
    let made = Workpiece { guides, ..part }.layers(&LayerOptions { support, ..options }, &go);
    assert_eq!(made.unwrap().support.unwrap().contact, given);
}

/// Bug: a triangle without area at the nearest point had a normal that is no number, and every cell counted as above.
#[test]
fn triangles_without_area_look_nowhere() {
    let block = Block::new();
    let (mut vertices, mut triangles) = sheet(60.0, |_, _| 5.0);
    let middle = vertices.len() as u32;
    vertices.push(Point3::new(6.0, 4.5, 5.0));
    vertices.push(Point3::new(9.0, 4.5, 5.0));
    vertices.push(Point3::new(3.0, 4.5, 5.0));
    triangles.push([middle, middle + 1, middle + 2]);
    let heights = block.workpiece(None).heights_over(&vertices, &triangles).unwrap();
    for (cell, height) in (0..).zip(heights) {
        assert!((height - (centre(cell).z - 5.0)).abs() < 1e-9, "{cell}: {height}");
    }
}

#[test]
fn errors_name_the_cause() {
    let block = Block::new();
    let part = block.workpiece(None);
    let (vertices, triangles) = sheet(30.0, |_, _| 14.0);
    let error = part.heights_over(&vertices, &triangles).unwrap_err();
    assert_eq!(error, HeightsError::Apart { distance_cells: 4.5 });
    assert!(error.to_string().contains("4.5 cells"));
    let CellMesh { vertices, triangles } = &block.mesh;
    assert_eq!(part.heights_over(vertices, triangles).unwrap_err(), HeightsError::NoUpperSide);
    assert!(matches!(part.heights_over(&[], &[]).unwrap_err(), HeightsError::Surface(_)));
    let grow = |heights: &[f64]| {
        let (cells, platform, rules, nozzle) = (part.cells, &block.platform, part.rules, tip_1_mm());
        grow_by_heights(&cells, 1.0, platform, &rules, None, &nozzle, heights, &go)
    };
    for heights in [vec![1.0; 959], vec![f64::NAN; 960]] {
        assert_eq!(grow(&heights).unwrap_err(), GrowthError::Heights { len: 960 });
    }
}
