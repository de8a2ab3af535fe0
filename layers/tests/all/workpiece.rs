//! Parts layered in one call: against the steps done one by one, and volumes that are known.

use crate::common::{go, random_rows};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{
    BorderSmoothing, ContourError, LayerField, SavedField, UniformMethod, contour, extend, measure_spacing_within,
    uniform_field,
};
use curvlay_layers::curved::{
    Growth, GrowthError, GrowthOptions, Guides, LayerOptions, LayerSurfaces, LayersError, Platform, Prevention, Rules,
    Strategy, UnbuildOptions, WORTH, WORTH_MISSED, Workpiece, grow, grow_as_printed, peel, unbuild,
};
use curvlay_layers::trim::Trimmer;
use nalgebra::Point3;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

const CELL: f64 = 0.5;

/// Layers by the hull rule alone.
fn by_hulls(strategy: Option<Strategy>, height_mm: f64) -> LayerOptions {
    LayerOptions { strategy, height_mm: Some(height_mm), ..LayerOptions::hull_rule() }
}

/// Cells, and the skin between them and what is empty as a mesh.
struct Solid {
    dims: [u32; 3],
    rows: Vec<u64>,
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    platform: Platform,
}

impl Solid {
    fn new(dims: [u32; 3], rows: Vec<u64>) -> Solid {
        let cells = Cells::new(dims, &rows).unwrap();
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for place in cells.iter().map(|cell| cells.position(cell)) {
            for axis in 0..3 {
                for up in [false, true] {
                    let mut beside = place;
                    beside[axis] = if up { beside[axis] + 1 } else { beside[axis].wrapping_sub(1) };
                    if beside.iter().zip(dims).all(|(&c, side)| c < side) && cells.contains(beside) {
                        continue;
                    }
                    let first = vertices.len() as u32;
                    for [u, v] in [[0, 0], [1, 0], [1, 1], [0, 1]] {
                        let mut corner = place;
                        corner[axis] += u32::from(up);
                        corner[(axis + 1) % 3] += u;
                        corner[(axis + 2) % 3] += v;
                        vertices.push(Point3::from(corner.map(|c| f64::from(c) * CELL)));
                    }
                    let square = if up { [0, 1, 2, 3] } else { [0, 3, 2, 1] }.map(|k| first + k);
                    triangles.extend([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
                }
            }
        }
        let platform = Platform::under(&cells, 20.0).unwrap();
        Solid { dims, rows, vertices, triangles, platform }
    }

    fn block(dims: [u32; 3]) -> Solid {
        Solid::new(dims, vec![(1 << dims[0]) - 1; (dims[1] * dims[2]) as usize])
    }

    fn cells(&self) -> Cells<'_> {
        Cells::new(self.dims, &self.rows).unwrap()
    }

    fn workpiece(&self) -> Workpiece<'_> {
        Workpiece {
            vertices: &self.vertices,
            triangles: &self.triangles,
            cells: self.cells(),
            cell_mm: CELL,
            origin: Point3::origin(),
            platform: &self.platform,
            rules: Rules::default(),
            volume_mm3: self.cells().count() as f64 * CELL.powi(3),
            guides: Guides::default(),
        }
    }
}

/// A few random balls and bars above a foot, with overhangs and gaps.
fn random(seed: u64) -> Solid {
    let dims = [13, 9, 13];
    // Six numbers for each part, out of random bits.
    let bits = random_rows(seed, 40, 8, 4);
    let number = |part: usize, k: usize, below: u64| (bits[5 * part + k] % below) as u32;
    let foot = number(7, 0, 11) + 1;
    let is_solid = |p: [u32; 3]| {
        let stands = p[2] < 2 && p[0].abs_diff(foot) < 3;
        stands
            || (0..6).any(|part| {
                let centre = [number(part, 0, 13), number(part, 1, 9), number(part, 2, 13)];
                let away = [0, 1, 2].map(|k| p[k].abs_diff(centre[k]));
                let size = 2 + number(part, 3, 3);
                match number(part, 4, 3) {
                    0 => away.iter().map(|d| d * d).sum::<u32>() <= size * size,
                    1 => away[0] <= 1 && away[1] <= 1 && p[2] <= centre[2],
                    _ => away[2] <= 1 && away[1] <= 1 && away[0] <= 2 * size,
                }
            })
    };
    let row = |y, z| (0..dims[0]).filter(|&x| is_solid([x, y, z])).fold(0, |bits, x| bits | 1 << x);
    let rows = (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect();
    Solid::new(dims, rows)
}

#[test]
fn strategies_are_the_functions_behind_them() {
    let solid = random(5);
    let (cells, platform, rules) = (solid.cells(), &solid.platform, Rules::default());
    let with = |prevention| {
        let options = GrowthOptions { prevention, ..GrowthOptions::default() };
        grow(&cells, platform, &rules, &options, None, &go).unwrap()
    };
    let governed = |prevention| {
        let options = GrowthOptions { prevention, ..GrowthOptions::default() };
        let field = peel(&cells, platform, &Rules { boundary_is_inside: false, ..rules }, &go).unwrap();
        grow(&cells, platform, &rules, &options, Some(&field), &go).unwrap()
    };
    let printed = |prevention| {
        let field = peel(&cells, platform, &rules, &go).unwrap();
        grow_as_printed(&cells, platform, &rules, prevention, &field, &go).unwrap()
    };
    let unbuilt = unbuild(&cells, platform, &rules, &UnbuildOptions::default(), &go).unwrap();
    let expected = [
        (Strategy::Greedy, "greedy", with(Prevention::None)),
        (Strategy::Incremental, "incremental", with(Prevention::Incremental)),
        (Strategy::Adaptive, "adaptive", with(Prevention::Adaptive)),
        (Strategy::Governed(Prevention::Adaptive), "governed", governed(Prevention::Adaptive)),
        (Strategy::Governed(Prevention::Incremental), "governed", governed(Prevention::Incremental)),
        (Strategy::Printed(Prevention::Adaptive), "printed", printed(Prevention::Adaptive)),
        (Strategy::Printed(Prevention::Incremental), "printed", printed(Prevention::Incremental)),
        (Strategy::Unbuild, "unbuild", unbuilt),
    ];
    for (strategy, name, growth) in expected {
        assert_eq!((strategy.name(), strategy.to_string()), (name, name.to_owned()));
        assert_eq!(strategy.grow(&cells, platform, &rules, &go).unwrap(), growth, "{name}");
        let missed: Vec<u32> = growth.missed.iter().map(|missed| missed.cell).collect();
        assert_eq!(growth.missed_cells(), missed);
    }
    let stop = |_| ControlFlow::Break(());
    for strategy in [
        Strategy::Greedy,
        Strategy::Governed(Prevention::Adaptive),
        Strategy::Printed(Prevention::Adaptive),
        Strategy::Unbuild,
    ] {
        assert_eq!(strategy.grow(&cells, platform, &rules, &stop).unwrap_err(), GrowthError::Cancelled, "{strategy}");
    }
}

/// A layered part, its steps done one by one.
struct Steps {
    growth: Growth,
    field: LayerField,
    lost: f64,
    pieces: usize,
}

fn by_steps(solid: &Solid, strategy: Strategy, height: f64) -> Steps {
    let (cells, rules) = (solid.cells(), Rules::default());
    let growth = strategy.grow(&cells, &solid.platform, &rules, &go).unwrap();
    let missed = growth.missed_cells();
    let field = uniform_field(&cells, &solid.platform, &rules, &growth.order, &missed, &go).unwrap().field;
    let extended = extend(&field, &cells);
    let fitted = extended.fitted_levels(&solid.vertices, &solid.triangles, CELL, Point3::origin(), height).unwrap();
    let mut surfaces = contour(&extended, &fitted.levels, CELL, Point3::origin(), &go).unwrap();
    surfaces.iter_mut().for_each(|surface| surface.smooth_border(CELL, BorderSmoothing::default()));
    let trimmer = Trimmer::new(&solid.vertices, &solid.triangles).unwrap().thinned(0.1 * height);
    let trimmed = surfaces.iter().map(|s| trimmer.trim(&s.points, &s.triangles, &go).unwrap());
    let mut sheets: Vec<_> = trimmed.collect();
    trimmer.clip(&mut sheets, fitted.height_mm, &go).unwrap();
    let slices: Vec<_> = sheets.iter().map(|sheet| (&sheet.vertices[..], &sheet.triangles[..])).collect();
    let laid = measure_spacing_within(&slices, &trimmer, fitted.height_mm, &go).unwrap().volume_mm3;
    // The mesh is the skin of the cells: what is missed is whole cells.
    let [all, missed] = [cells.count(), missed.len()].map(|count| count as f64 * CELL.powi(3));
    let pieces = sheets.iter().map(|sheet| pieces(&sheet.triangles)).sum();
    Steps { growth, field, lost: missed + (all - missed - laid).abs(), pieces }
}

/// Pieces that hang together by corners, by walking from triangle to triangle.
fn pieces(triangles: &[[u32; 3]]) -> usize {
    let mut left: Vec<[u32; 3]> = triangles.to_vec();
    let mut pieces = 0;
    while let Some(first) = left.pop() {
        pieces += 1;
        let mut piece = vec![first];
        while let Some(triangle) = piece.pop() {
            let (near, far) = left.into_iter().partition(|other| other.iter().any(|corner| triangle.contains(corner)));
            left = far;
            piece.extend::<Vec<_>>(near);
        }
    }
    pieces
}

/// Solids with each of the outcomes of [`the_best_of_two_loses_less`].
const SEEDS: [u64; 9] = [0, 1, 3, 6, 78, 113, 379, 725, 1791];

#[test]
fn the_best_of_two_loses_less() {
    // Nothing missed; the incremental or the un-built order loses less; about as much.
    let mut taken = [0; 4];
    for seed in SEEDS {
        let solid = random(seed);
        let part = solid.workpiece();
        let layered = part.layers(&by_hulls(None, 0.6), &go).unwrap();
        let incremental = by_steps(&solid, Strategy::Incremental, 0.6);
        let unbuilt = by_steps(&solid, Strategy::Unbuild, 0.6);
        let volume = part.volume_mm3;
        let gain = (incremental.lost - unbuilt.lost) / volume;
        let missed = |steps: &Steps| steps.growth.missed.len() as f64 * CELL.powi(3) / volume;
        let gain_missed = missed(&incremental) - missed(&unbuilt);
        let (outcome, unbuild_wins) = match (gain, gain_missed) {
            _ if incremental.growth.missed.is_empty() => (0, false),
            (gain, _) if gain.abs() > WORTH => (1 + usize::from(gain > 0.0), gain > 0.0),
            (_, gain) if gain.abs() > WORTH_MISSED => (3, gain > 0.0),
            _ => (3, unbuilt.pieces < incremental.pieces),
        };
        taken[outcome] += 1;
        let Steps { growth, field, lost, pieces } = if unbuild_wins { unbuilt } else { incremental };
        let bits = |field: &LayerField| field.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(layered.growth == growth && bits(&layered.uniform.field) == bits(&field), "{seed}");
        assert_eq!(layered.strategy, if unbuild_wins { Strategy::Unbuild } else { Strategy::Incremental });
        assert!(layered.audit.is_ok());
        assert!((layered.surfaces.lost_mm3(volume) - lost).abs() < 1e-9 * volume, "{seed}");
        assert_eq!(layered.surfaces.pieces(), pieces, "{seed}");
        let missed_mm3 = growth.missed.len() as f64 * CELL.powi(3);
        assert!((layered.surfaces.missed_mm3 - missed_mm3).abs() < 1e-9 * volume, "{seed}");

        // Who asks for the order alone gets the same one.
        let order = part.order(&by_hulls(None, 0.6), &go).unwrap();
        assert_eq!((order.strategy, &order.growth, &order.audit), (layered.strategy, &growth, &layered.audit));
    }
    assert!(taken.iter().all(|&count| count > 0), "{taken:?}");
}

/// An order alone needs no surfaces but to choose between two.
#[test]
fn coherent_layers_are_taken_where_they_end_less_inside() {
    let mut taken = 0;
    for seed in 0..12 {
        let solid = random(seed);
        let part = solid.workpiece();
        let (Ok(before), Ok(after)) = (
            part.layers(&by_hulls(None, 0.8), &go),
            part.layers(&LayerOptions { coherent: true, ..by_hulls(None, 0.8) }, &go),
        ) else {
            continue;
        };
        assert_eq!((&before.growth.order, &before.growth.missed), (&after.growth.order, &after.growth.missed));
        assert!(after.uniform.audit.is_ok());
        if after.uniform.method == UniformMethod::Coherent {
            assert!(after.surfaces.boundary.at_waits_mm < before.surfaces.boundary.at_waits_mm, "{seed}");
            assert!(after.surfaces.pieces() <= before.surfaces.pieces(), "{seed}");
            taken += 1;
        } else {
            assert_eq!(before.uniform.method, after.uniform.method);
            assert_eq!(before.surfaces, after.surfaces);
        }
    }
    assert!(taken > 0);
}

#[test]
fn an_order_is_grown_without_surfaces_where_there_is_no_choice() {
    let stages = |part: &Workpiece, strategy| {
        let seen = std::sync::Mutex::new(BTreeSet::new());
        let watch = |p: curvlay_layers::Progress| {
            seen.lock().unwrap().insert(p.stage);
            ControlFlow::Continue(())
        };
        let order = part.order(&by_hulls(strategy, 0.6), &watch).unwrap();
        let grown = strategy.unwrap_or(order.strategy).grow(&part.cells, part.platform, &part.rules, &go).unwrap();
        assert_eq!(order.growth, grown);
        seen.into_inner().unwrap()
    };
    let block = Solid::block([6, 5, 4]);
    assert_eq!(stages(&block.workpiece(), None), BTreeSet::from(["grow", "audit"]));
    let with_misses = random(SEEDS.into_iter().find(|&seed| misses(&random(seed))).unwrap());
    assert_eq!(stages(&with_misses.workpiece(), Some(Strategy::Incremental)), BTreeSet::from(["grow", "audit"]));
    assert!(stages(&with_misses.workpiece(), None).contains("trim"));
    let error = Workpiece { volume_mm3: 0.0, ..block.workpiece() }.order(&by_hulls(None, 0.6), &go).unwrap_err();
    assert!(matches!(error, LayersError::Volume { .. }));
}

fn misses(solid: &Solid) -> bool {
    let grown = Strategy::Incremental.grow(&solid.cells(), &solid.platform, &Rules::default(), &go).unwrap();
    !grown.missed.is_empty()
}

/// The mean over the triangles around the corners of each, by area, the slow way.
fn slow_thickness(surfaces: &LayerSurfaces, at: usize) -> Vec<f64> {
    let (sheet, raw) = (&surfaces.sheets[at], &surfaces.spacing.thickness_mm[at]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| sheet.vertices[v as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    let at_corner = |v: u32| {
        let around: Vec<usize> = (0..raw.len()).filter(|&k| sheet.triangles[k].contains(&v)).collect();
        let areas: f64 = around.iter().map(|&k| area(&sheet.triangles[k])).sum();
        around.iter().map(|&k| area(&sheet.triangles[k]) * raw[k]).sum::<f64>() / areas
    };
    let mean = |t: &[u32; 3]| t.iter().map(|&v| at_corner(v)).sum::<f64>() / 3.0;
    sheet.triangles.iter().map(|t| mean(t).max(0.02 * surfaces.height_mm)).collect()
}

#[test]
fn thickness_is_evened_out_over_corners() {
    let solid = random(3);
    let surfaces = solid.workpiece().layers(&by_hulls(None, 0.6), &go).unwrap().surfaces;
    let mut triangles = 0;
    for (at, (vertices, corners, thickness, _)) in surfaces.iter().enumerate() {
        let sheet = &surfaces.sheets[at];
        assert_eq!((vertices, corners), (&sheet.vertices[..], &sheet.triangles[..]));
        assert!(thickness.iter().zip(slow_thickness(&surfaces, at)).all(|(a, b)| (a - b).abs() < 1e-12));
        triangles += thickness.len();
    }
    assert!(triangles > 100 && surfaces.slices().len() == surfaces.sheets.len());
}

#[test]
fn a_block_is_filled_and_ends_on_its_mesh() {
    let solid = Solid::block([6, 5, 4]);
    let part = solid.workpiece();
    let layered = part.layers(&by_hulls(None, 0.4), &go).unwrap();
    let LayerSurfaces { sheets, spacing, boundary, missed_mm3, .. } = &layered.surfaces;
    assert_eq!((layered.strategy, sheets.len()), (Strategy::Incremental, 5));
    assert!((spacing.volume_mm3 - part.volume_mm3).abs() < 1e-9 && *missed_mm3 < 1e-300);
    assert!(layered.surfaces.lost_mm3(part.volume_mm3) < 1e-9);
    assert!(boundary.error_mm < 1e-12);
    let inside = boundary.at_missed_mm + boundary.at_waits_mm + boundary.at_holes_mm;
    assert!(inside < 1e-300, "{boundary:?}");
}

/// A block with a hole in its field: missed cells have their volume, and surfaces end beside them.
#[test]
fn missed_cells_have_a_volume_and_a_border() {
    let solid = Solid::block([7, 7, 4]);
    let (part, cells) = (solid.workpiece(), solid.cells());
    // A shaft of one cell through the middle.
    let missed: Vec<u32> = cells.iter().filter(|&cell| cells.position(cell)[..2] == [3, 3]).collect();
    let value = |cell: u32| match missed.contains(&cell) {
        true => f64::NAN,
        false => f64::from(cells.position(cell)[2]) + 0.5,
    };
    let field = LayerField::new(&cells, (0..7 * 7 * 4).map(value).collect(), 1.0).unwrap();
    let surfaces = part.surfaces(&field, &missed, CELL, &go).unwrap();
    assert!((surfaces.missed_mm3 - 4.0 * CELL.powi(3)).abs() < 1e-12);
    let LayerSurfaces { boundary, sheets, .. } = &surfaces;
    let border: f64 = sheets.iter().map(|sheet| sheet.border_mm).sum();
    assert!((boundary.at_missed_mm - border).abs() < 1e-12 && border > 4.0 * CELL, "{boundary:?}");
    // Without the missed cells nobody knows why surfaces end there.
    let unknown = part.surfaces(&field, &[], CELL, &go).unwrap();
    assert!((unknown.boundary.at_waits_mm - border).abs() < 1e-12 && unknown.boundary.at_missed_mm < 1e-300);

    // Cells at a slanted skin count with what of the part is in them: half of each along the slope.
    let wedge = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [2.0, 0.0, 2.0], [2.0, 2.0, 2.0]];
    let vertices = wedge.map(Point3::from);
    let triangles = [[0, 3, 2], [0, 2, 1], [1, 2, 5], [1, 5, 4], [0, 1, 4], [3, 5, 2], [0, 4, 5], [0, 5, 3]];
    let rows: Vec<u64> = (0..16).map(|row| 0b1111 << (row / 4) & 0b1111).collect();
    let cells = Cells::new([4, 4, 4], &rows).unwrap();
    let part = Workpiece { vertices: &vertices, triangles: &triangles, cells, ..part };
    let slope: Vec<u32> = (0..16).map(|k| (k / 4) + 4 * (k % 4) + 16 * (k / 4)).collect();
    let value = |cell: u32| if cells.contains(cells.position(cell)) { f64::from(cell / 16) + 0.5 } else { f64::NAN };
    let field = LayerField::new(&cells, (0..64).map(value).collect(), 1.0).unwrap();
    let surfaces = part.surfaces(&field, &slope, CELL, &go).unwrap();
    assert!((surfaces.missed_mm3 - 8.0 * CELL.powi(3)).abs() < 1e-12, "{}", surfaces.missed_mm3);
}

/// Two blocks of one mesh that overlap are one solid; the volume that their faces enclose counts the overlap twice.
#[test]
fn overlaps_of_the_mesh_count_once() {
    let [first, second] = [Solid::block([4, 4, 4]), Solid::block([4, 4, 4])];
    let moved = second.vertices.iter().map(|vertex| vertex + nalgebra::Vector3::x() * CELL);
    let vertices: Vec<Point3<f64>> = first.vertices.iter().copied().chain(moved).collect();
    let count = first.vertices.len() as u32;
    let second = second.triangles.iter().map(|corners| corners.map(|corner| corner + count));
    let triangles: Vec<[u32; 3]> = first.triangles.iter().copied().chain(second).collect();
    let union = Solid::block([5, 4, 4]);
    let part = Workpiece { vertices: &vertices, triangles: &triangles, ..union.workpiece() };
    let all: Vec<u32> = union.cells().iter().collect();
    assert!((part.volume_of(&all, &go).unwrap() - 80.0 * CELL.powi(3)).abs() < 1e-9);
    let half: Vec<u32> = all.iter().copied().filter(|&cell| union.cells().position(cell)[2] < 2).collect();
    assert!((part.volume_of(&half, &go).unwrap() - 40.0 * CELL.powi(3)).abs() < 1e-9);
    assert!(part.volume_of(&[], &go).unwrap() < 1e-300);
    assert_eq!(part.volume_of(&all, &|_| ControlFlow::Break(())), Err(LayersError::Cancelled));
}

/// A mesh that closes and overlaps nowhere has the volume that it goes round, to its last triangle; others that of their cells.
#[test]
fn a_new_part_knows_its_volume() {
    let solid = Solid::block([4, 4, 4]);
    let new = |vertices: &[Point3<f64>], triangles: &[[u32; 3]], of: &Solid| {
        let cells = of.cells();
        Workpiece::new((vertices, triangles), cells, CELL, Point3::origin(), &of.platform, &go)
            .map(|part| part.volume_mm3)
    };
    // Larger than its cells by what no cell shows.
    let grown: Vec<Point3<f64>> = solid.vertices.iter().map(|vertex| Point3::from(vertex.coords * 1.01)).collect();
    let volume = 64.0 * (CELL * 1.01).powi(3);
    assert!((new(&grown, &solid.triangles, &solid).unwrap() - volume).abs() < 1e-9);
    let turned: Vec<[u32; 3]> = solid.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert!((new(&grown, &turned, &solid).unwrap() - volume).abs() < 1e-9);
    // Twice the same block, or one in the other: a winding number of 2.
    let twice: Vec<[u32; 3]> = [&solid.triangles[..], &solid.triangles[..]].concat();
    assert!((new(&solid.vertices, &twice, &solid).unwrap() - 64.0 * CELL.powi(3)).abs() < 1e-9);
    // A triangle is missing.
    let holed = &solid.triangles[1..];
    assert!((new(&solid.vertices, holed, &solid).unwrap() - 64.0 * CELL.powi(3)).abs() < 0.1 * 64.0 * CELL.powi(3));
    let error = new(&solid.vertices, &[[0, 1, 999]], &solid).unwrap_err();
    assert!(matches!(error, LayersError::Trim(_)), "{error}");
    let flat: Vec<Point3<f64>> = solid.vertices.iter().map(|vertex| Point3::new(vertex.x, vertex.y, 0.0)).collect();
    assert!(matches!(new(&flat, &solid.triangles, &solid), Err(LayersError::Volume { .. } | LayersError::Trim(_))));
    let stop = |_| ControlFlow::Break(());
    let mesh = (&solid.vertices[..], &solid.triangles[..]);
    let stopped = Workpiece::new(mesh, solid.cells(), CELL, Point3::origin(), &solid.platform, &stop);
    assert_eq!(stopped.err(), Some(LayersError::Cancelled));
}

#[test]
fn a_saved_field_stands_for_its_order() {
    let solid = random(7);
    let layered = solid.workpiece().layers(&by_hulls(Some(Strategy::Greedy), 0.6), &go).unwrap();
    let field = layered.uniform.field.clone();
    let rounded = field.rounded();
    let saved = SavedField {
        field,
        rows: solid.rows.clone(),
        cell_mm: CELL,
        origin: Point3::origin(),
        mesh: 0,
        aids: Default::default(),
    };
    let growth = saved.growth().unwrap();
    assert_eq!((growth.order.iter().collect::<Vec<_>>()), rounded.iter().collect::<Vec<_>>());
    assert_eq!(growth.missed_cells(), layered.growth.missed_cells());
    assert!(!growth.missed.is_empty());
    assert!(SavedField { rows: vec![0; 3], ..saved }.growth().is_err());
}

#[test]
fn errors_name_the_cause() {
    let solid = Solid::block([4, 4, 3]);
    let part = solid.workpiece();
    for volume_mm3 in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Workpiece { volume_mm3, ..part }.layers(&by_hulls(None, 0.5), &go).unwrap_err();
        assert!(matches!(error, LayersError::Volume { .. }), "{error}");
    }
    let error = part.layers(&by_hulls(None, 0.01), &go).unwrap_err();
    assert!(matches!(error, LayersError::Contour(ContourError::TooThin { .. })), "{error}");
    let vertices = vec![Point3::new(f64::NAN, 0.0, 0.0); solid.vertices.len()];
    let error = Workpiece { vertices: &vertices, ..part }.layers(&by_hulls(None, 0.5), &go).unwrap_err();
    assert!(matches!(error, LayersError::Trim(_)), "{error}");
    let nothing = vec![0; 12];
    let none = Workpiece { cells: Cells::new([4, 4, 3], &nothing).unwrap(), ..part };
    assert!(matches!(none.layers(&by_hulls(None, 0.5), &go).unwrap_err(), LayersError::Growth(GrowthError::NoCell)));

    for stage in ["grow", "audit", "uniform", "contour", "trim", "spacing"] {
        let stop = |p: curvlay_layers::Progress| match p.stage == stage {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        assert_eq!(part.layers(&by_hulls(None, 0.5), &stop).unwrap_err(), LayersError::Cancelled, "{stage}");
    }
}
