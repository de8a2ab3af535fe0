//! Ranges of the surfaces of a part, made without the others: what they are in a whole run, bit for bit.

use crate::common::go;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::LayerField;
use curvlay_layers::curved::{
    CellMesh, Guides, LayerSurfaces, LayersError, PartSupport, PlannedSurfaces, Platform, Rules, SupportCells,
    Workpiece, cell_mesh,
};
use nalgebra::Point3;
use proptest::prelude::*;
use std::ops::{ControlFlow, Range};

/// Edge of a cell in millimetres, and the low corner of the grid: nothing round.
const CELL: f64 = 0.7;
const ORIGIN: [f64; 3] = [3.3, -7.1, 0.0];

/// A block of cells that walls cut into sides, each with a slope of its own: between them the front waited.
#[derive(Clone, Debug)]
struct Sides {
    dims: [u32; 3],
    /// Planes: what lies beyond one along its direction, at this distance from the corner, is another side.
    walls: Vec<[f64; 4]>,
    /// For each side the value at its corner, and how it rises along x, y and z, in layers a cell.
    rise: Vec<[f64; 4]>,
    half_layers: Option<f64>,
    /// Layer height, in cells.
    height: f64,
}

impl Sides {
    /// Level layers of a column.
    fn level(dims: [u32; 3], height: f64) -> Self {
        Sides { dims, walls: Vec::new(), rise: vec![[0.0, 0.0, 0.0, 1.0]], half_layers: None, height }
    }

    /// Two sides with a wall that leans by a cell in two, whose surfaces pass through each other there.
    fn leaning() -> Self {
        let (walls, rise) = (vec![[1.0, 0.0, -0.6, 2.0]], vec![[3.0, -0.3, 0.05, 1.0], [4.0, 0.3, 0.0, 0.7]]);
        Sides { dims: [16, 5, 26], walls, rise, half_layers: None, height: 1.0 }
    }

    fn value(&self, at: [u32; 3]) -> f64 {
        let [x, y, z] = at.map(|c| f64::from(c) + 0.5);
        let is_beyond = |&[a, b, c, d]: &[f64; 4]| usize::from(a * x + b * y + c * z > d);
        let side = self.walls.iter().fold(0, |side, wall| 2 * side + is_beyond(wall));
        let [at, a, b, c] = self.rise[side];
        (at + a * x + b * y + c * z).max(0.0)
    }

    fn with<T>(&self, work: impl FnOnce(&Workpiece, &LayerField) -> T) -> T {
        let [nx, ny, nz] = self.dims;
        let rows = vec![(1 << nx) - 1; (ny * nz) as usize];
        let cells = Cells::new(self.dims, &rows).unwrap();
        let values = cells.iter().map(|cell| self.value(cells.position(cell))).collect();
        let field = LayerField::new(&cells, values, 1.0).unwrap().with_half_layers(self.half_layers);
        let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), CELL, ORIGIN.into());
        let platform = Platform::under(&cells, 60.0).unwrap();
        work(&part(&mesh, cells, &platform), &field)
    }
}

fn part<'a>(mesh: &'a CellMesh, cells: Cells<'a>, platform: &'a Platform) -> Workpiece<'a> {
    Workpiece {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        cells,
        cell_mm: CELL,
        origin: ORIGIN.into(),
        platform,
        rules: Rules::default(),
        volume_mm3: 1.0,
        guides: Guides::default(),
    }
}

/// So many pieces of about the same number of surfaces.
fn pieces(surfaces: usize, count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).map(move |k| k * surfaces / count..(k + 1) * surfaces / count)
}

/// Holds surfaces that were made in pieces against those of one run.
fn assert_same(whole: &LayerSurfaces, pieces: &[LayerSurfaces]) {
    let count = whole.sheets.len();
    assert!(whole.is_whole());
    let [mut found, mut left, mut surfaces] = [0; 3];
    for piece in pieces {
        assert_eq!((&piece.is_half, &piece.heights_mm), (&whole.is_half, &whole.heights_mm));
        assert_eq!(piece.height_mm.to_bits(), whole.height_mm.to_bits());
        for k in 0..count {
            if !piece.made.contains(&k) {
                assert!(piece.sheets[k].triangles.is_empty() && piece.thickness_mm[k].is_empty());
                continue;
            }
            assert_eq!(piece.sheets[k], whole.sheets[k], "sheet {k} of {:?}", piece.made);
            assert_eq!(piece.thickness_mm[k], whole.thickness_mm[k], "thickness {k} of {:?}", piece.made);
            assert_eq!(piece.spacing.values_mm[k], whole.spacing.values_mm[k], "spacing {k} of {:?}", piece.made);
        }
        [found, left] = [found + piece.clipped.found.crossing, left + piece.clipped.left.crossing];
        surfaces += piece.clipped.surfaces;
    }
    // Each crossing is on one surface, which is in one piece.
    let of_whole = &whole.clipped;
    assert_eq!([found, left, surfaces], [of_whole.found.crossing, of_whole.left.crossing, of_whole.surfaces]);
    let edges: usize = pieces.iter().map(|piece| piece.clipped.left.edges).sum();
    assert_eq!(edges, of_whole.left.edges);
    let area: f64 = pieces.iter().map(|piece| piece.spacing.area_mm2).sum();
    assert!((area - whole.spacing.area_mm2).abs() <= 1e-9 * area);
}

/// The surfaces of a field, and those of so many pieces, held against each other.
fn checked(sides: &Sides, count: usize) -> LayerSurfaces {
    sides.with(|part, field| {
        let (rows, height_mm) = (part.cells.rows(), sides.height * CELL);
        let whole = part.surfaces(field, &[], height_mm, &go).unwrap();
        let planned = PlannedSurfaces::new(part, field, rows, SupportCells::default(), &[], height_mm, &go).unwrap();
        assert_eq!((planned.len(), planned.is_empty()), (whole.sheets.len(), whole.sheets.is_empty()));
        let made = pieces(planned.len(), count).map(|range| planned.make(range, &go).unwrap().0);
        assert_same(&whole, &made.collect::<Vec<_>>());
        whole
    })
}

/// Fronts that waited for each other: their surfaces pass through each other at the wall, far apart in number.
#[test]
fn surfaces_across_a_wait_are_those_of_one_run() {
    let whole = checked(&Sides::leaning(), 7);
    assert!(whole.clipped.surfaces > 0 && whole.boundary.at_waits_mm > 1.0, "{:?}", whole.clipped);
    checked(&Sides::leaning(), whole.sheets.len());
    let whole = checked(&Sides { half_layers: Some(1.2), ..Sides::leaning() }, 5);
    let halves = whole.is_half.iter().filter(|is_half| **is_half).count();
    assert!(halves > 3 && halves < whole.sheets.len() / 2, "{halves} of {}", whole.sheets.len());
    // Layers that are several cells thick are far apart, and within reach of each other all the same.
    for height in [2.5, 4.0, 5.5] {
        checked(&Sides { height, ..Sides::leaning() }, 3);
    }
}

/// Many sides: surfaces are clipped by some that others have clipped.
#[test]
fn surfaces_of_many_sides_are_those_of_one_run() {
    let mut seed = 7_u64;
    // Numbers from -1 to 1 (Knuth's constants).
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (mut clipped, mut thick) = (0, 0);
    for k in 0..24 {
        let walls = (0..3).map(|_| [random(), random(), random(), 6.0 * random()]).collect();
        let rise =
            (0..8).map(|_| [9.0 + 6.0 * random(), 0.4 * random(), 0.4 * random(), 0.8 + 0.4 * random()]).collect();
        let height = [0.6, 1.0, 2.2, 4.5][k % 4];
        let half_layers = (k % 3 == 0).then_some(1.2);
        let whole = checked(&Sides { dims: [14, 10, 16], walls, rise, half_layers, height }, 2 + k % 5);
        clipped += whole.clipped.surfaces;
        thick += if height > 2.0 { whole.clipped.surfaces } else { 0 };
    }
    assert!(clipped > 100 && thick > 4, "{clipped} {thick}");
}

/// A level stack, in layers so thick that neighbours are known by the reach of the spacing alone.
#[test]
fn the_reach_of_the_spacing_goes_with_the_layer_height() {
    let whole = checked(&Sides::level([6, 6, 30], 5.0), 6);
    assert!(whole.spacing.values_mm.iter().flatten().all(Option::is_some));
}

fn sides() -> impl Strategy<Value = Sides> {
    let rise = prop::array::uniform4(-0.5..0.5_f64).prop_map(|[at, a, b, c]| [6.0 + 9.0 * at, a, b, 0.8 + c]);
    let wall = prop::array::uniform4(-1.0..1.0_f64).prop_map(|[a, b, c, d]| [a, b, c, 6.0 * d]);
    let height = prop::sample::select(vec![0.6, 1.0, 1.7, 3.0, 4.5]);
    let half_layers = prop::sample::select(vec![None, Some(1.1), Some(1.4)]);
    let (walls, rise) = (prop::collection::vec(wall, 2), prop::collection::vec(rise, 4));
    (walls, rise, height, half_layers).prop_map(|(walls, rise, height, half_layers)| Sides {
        dims: [12, 6, 14],
        walls,
        rise,
        half_layers,
        height,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn pieces_of_any_field_are_those_of_one_run(sides in sides(), count in 2_usize..9) {
        checked(&sides, count);
    }
}

/// An overhang on support, which is part of it where the two touch, and a cell between them that stays empty: both in pieces.
#[test]
fn support_in_pieces_is_that_of_one_run() {
    // A column, 4 cells wide, with an arm to the right in its upper half; support below the end of the arm.
    let dims = [14_u32, 4, 16];
    let is_part = |[x, _, z]: [u32; 3]| x < 4 || z >= 9;
    let row =
        |z: u32, is: &dyn Fn([u32; 3]) -> bool| (0..14).filter(|&x| is([x, 0, z])).fold(0_u64, |row, x| row | 1 << x);
    let rows = |is: &dyn Fn([u32; 3]) -> bool| (0..4 * 16).map(|k| row(k / 4, is)).collect::<Vec<u64>>();
    let (own, all) = (rows(&is_part), rows(&|at| is_part(at) || at[0] >= 9));
    let (cells, united) = (Cells::new(dims, &own).unwrap(), Cells::new(dims, &all).unwrap());
    let support: Vec<u32> = united.iter().filter(|&cell| !is_part(united.position(cell))).collect();
    let contact: Vec<u32> =
        cells.iter().filter(|&cell| cells.position(cell)[2] == 9 && cells.position(cell)[0] >= 9).collect();
    let value = |cell: u32| {
        let [x, _, z] = united.position(cell);
        if united.contains([x, 0, z]) { f64::from(z) + 0.5 + 0.2 * f64::from(x) } else { f64::NAN }
    };
    let field = LayerField::new(&united, (0..14 * 4 * 16).map(value).collect(), 1.0).unwrap();
    let mesh = cell_mesh(&cells, &cells.iter().collect::<Vec<u32>>(), CELL, ORIGIN.into());
    let platform = Platform::under(&cells, 60.0).unwrap();
    let part = part(&mesh, cells, &platform);
    for contact in [&contact[..], &[]] {
        let of_support = SupportCells { cells: &support, contact };
        let (whole, on) = part.surfaces_and_support(&field, &all, of_support, &[], CELL, &go).unwrap();
        let planned = PlannedSurfaces::new(&part, &field, &all, of_support, &[], CELL, &go).unwrap();
        let made: Vec<(LayerSurfaces, Option<PartSupport>)> =
            pieces(planned.len(), 4).map(|range| planned.make(range, &go).unwrap()).collect();
        let (of_part, supports): (Vec<LayerSurfaces>, Vec<Option<PartSupport>>) = made.into_iter().unzip();
        assert_same(&whole, &of_part);
        let supports: Vec<LayerSurfaces> = supports.into_iter().map(|support| support.unwrap().surfaces).collect();
        assert_same(&on.unwrap().surfaces, &supports);
        assert!(supports.iter().any(|piece| piece.spacing.area_mm2 > 1.0));
    }
}

#[test]
fn neighbours_are_whole_layers_with_the_half_layers_between() {
    Sides { half_layers: Some(1.2), ..Sides::leaning() }.with(|part, field| {
        let planned =
            PlannedSurfaces::new(part, field, part.cells.rows(), SupportCells::default(), &[], CELL, &go).unwrap();
        let count = planned.len();
        let is_half = planned.make(0..0, &go).unwrap().0.is_half;
        let whole = |range: Range<usize>| range.filter(|&k| !is_half[k]).count();
        let middle = count / 2..count / 2 + 3;
        for layers in 0..4 {
            let wide = planned.with_neighbours(middle.clone(), layers);
            assert_eq!([whole(wide.start..middle.start), whole(middle.end..wide.end)], [layers; 2]);
        }
        assert_eq!(planned.with_neighbours(middle.clone(), 0), middle);
        assert_eq!(planned.with_neighbours(middle.clone(), 9999), 0..count);
        assert_eq!(planned.with_neighbours(0..count, 2), 0..count);
    });
}

#[test]
fn ranges_that_are_none_and_cancelled_runs_are_errors() {
    Sides::level([4, 4, 6], 1.0).with(|part, field| {
        let plan = |progress| {
            PlannedSurfaces::new(part, field, part.cells.rows(), SupportCells::default(), &[], CELL, progress)
        };
        let planned = plan(&go).unwrap();
        #[allow(clippy::reversed_empty_ranges)]
        for range in [0..7, 5..4, 7..7, usize::MAX..usize::MAX] {
            let expected = LayersError::Range { range: [range.start, range.end], surfaces: 6 };
            assert_eq!(planned.make(range, &go).err(), Some(expected));
        }
        assert!(planned.make(6..6, &go).unwrap().0.sheets.iter().all(|sheet| sheet.triangles.is_empty()));
        assert_eq!(planned.make(0..2, &|_| ControlFlow::Break(())).err(), Some(LayersError::Cancelled));
        assert_eq!(plan(&|_| ControlFlow::Break(())).err(), Some(LayersError::Cancelled));
    });
}

/// Layers of which each goes through very many cells: what is in reach is the whole lattice, not more.
#[test]
fn a_reach_beyond_all_numbers_is_all_there_is() {
    let rows = vec![1; 4];
    let cells = Cells::new([1, 1, 4], &rows).unwrap();
    let mesh = cell_mesh(&cells, &[0, 1, 2, 3], 1e-3, Point3::origin());
    let platform = Platform::under(&cells, 9.0).unwrap();
    let field = LayerField::new(&cells, vec![0.5, 1.5, 2.5, 3.5], 1e15).unwrap();
    let part = Workpiece { cell_mm: 1e-3, origin: Point3::origin(), ..part(&mesh, cells, &platform) };
    let planned = PlannedSurfaces::new(&part, &field, &rows, SupportCells::default(), &[], 1e12, &go).unwrap();
    assert!(planned.len() > 1);
    planned.make(0..1, &go).unwrap();
}
