//! Layers on a mould that is a mesh: they begin at the mesh, not at its cells, and are parallel to it.

use crate::common::go;
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::{
    DirectedOptions, GrowthError, Guides, LayerOptions, LayersBy, LayersError, Platform, Rules, Workpiece,
    distance_field,
};
use curvlay_layers::nalgebra::Point3;
use std::f64::consts::FRAC_PI_3;

/// A mesh.
type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

const DIMS: [u32; 3] = [40, 10, 20];

/// The axis of the cylinder runs along y, below the plate; the mould reaches 10 mm up.
const AXIS: [f64; 2] = [20.0, -20.0];
const RADIUS: f64 = 30.0;

/// Half the angle of the mould, and of the part on it.
const HALF: [f64; 2] = [0.6, 0.5];

const STEPS: u32 = 96;

/// A bar of strips that go round it, with its ends.
fn ring(points: Vec<Point3<f64>>, around: u32, along: u32) -> Mesh {
    let mut triangles = Vec::new();
    for k in 0..along {
        for j in 0..around {
            let at = |k: u32, j: u32| k * around + j % around;
            let [a, b, c, d] = [at(k, j), at(k, j + 1), at(k + 1, j + 1), at(k + 1, j)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for j in 1..around - 1 {
        triangles.push([0, j + 1, j]);
        let last = along * around;
        triangles.push([last, last + j, last + j + 1]);
    }
    (points, triangles)
}

/// What lies between two heights, along the arc and between two places along y; `low` and `high` are places at an angle.
fn between(half: f64, ys: [f64; 2], low: impl Fn(f64) -> [f64; 2], high: impl Fn(f64) -> [f64; 2]) -> Mesh {
    let mut points = Vec::new();
    for k in 0..=STEPS {
        let angle = -half + 2.0 * half * f64::from(k) / f64::from(STEPS);
        let [low, high] = [low(angle), high(angle)];
        for ([x, z], y) in [(low, ys[0]), (low, ys[1]), (high, ys[1]), (high, ys[0])] {
            points.push(Point3::new(x, y, z));
        }
    }
    ring(points, 4, STEPS)
}

fn on_arc(radius: f64) -> impl Fn(f64) -> [f64; 2] {
    move |angle| [AXIS[0] + radius * angle.sin(), AXIS[1] + radius * angle.cos()]
}

fn mould() -> Mesh {
    between(HALF[0], [0.0, 10.0], |angle| [on_arc(RADIUS)(angle)[0], 0.0], on_arc(RADIUS))
}

/// A shell of 5 mm over the mould, with a gap between.
fn shell(gap: f64) -> Mesh {
    between(HALF[1], [1.0, 9.0], on_arc(RADIUS + gap), on_arc(RADIUS + gap + 5.0))
}

/// The cells of which some part lies in the shell.
fn cells(gap: f64) -> Vec<u64> {
    let is_in = |[x, y, z]: [f64; 3]| {
        let (aside, up) = (x - AXIS[0], z - AXIS[1]);
        let over = aside.hypot(up) - RADIUS - gap;
        (0.0..5.0).contains(&over) && aside.atan2(up).abs() < HALF[1] && (1.0..9.0).contains(&y)
    };
    let touches = |[x, y, z]: [u32; 3]| {
        let at = |k: u32, step: u32| f64::from(k) + (f64::from(step) + 0.5) / 8.0;
        (0..512).any(|k| is_in([at(x, k % 8), at(y, k / 8 % 8), at(z, k / 64)]))
    };
    let rows = (0..DIMS[1] * DIMS[2]).map(|row| [row % DIMS[1], row / DIMS[1]]);
    rows.map(|[y, z]| (0..DIMS[0]).filter(|&x| touches([x, y, z])).map(|x| 1u64 << x).sum()).collect()
}

fn platform() -> Platform {
    let (points, triangles) = mould();
    let plate = Platform::disc([20.0, 5.0], 60.0).unwrap();
    plate.on_mould_mesh(DIMS, 1.0, Point3::origin(), &points, &triangles).unwrap()
}

/// The cells of the shell that are none of the mould.
fn outside(platform: &Platform, gap: f64) -> Vec<u64> {
    platform.outside_mould(&Cells::new(DIMS, &cells(gap)).unwrap()).unwrap()
}

fn workpiece<'a>((vertices, triangles): &'a Mesh, platform: &'a Platform, rows: &'a [u64], gap: f64) -> Workpiece<'a> {
    let (cells, low) = (Cells::new(DIMS, rows).unwrap(), RADIUS + gap);
    let volume_mm3 = 8.0 * HALF[1] * ((low + 5.0).powi(2) - low.powi(2));
    let (cell_mm, origin, rules) = (1.0, Point3::origin(), Rules::default());
    Workpiece { vertices, triangles, cells, cell_mm, origin, platform, rules, volume_mm3, guides: Guides::default() }
}

/// Away from the edges of the part its values are its heights over the cylinder: to half a hundredth of a cell where it begins, to a tenth five cells up.
#[test]
fn the_field_is_the_height_over_the_mesh() {
    let platform = platform();
    let rows = outside(&platform, 0.0);
    let cells = Cells::new(DIMS, &rows).unwrap();
    let field = distance_field(&cells, &platform, &Rules::default()).unwrap();
    let (mut first, mut all) = (0.0_f64, 0.0_f64);
    for cell in cells.iter() {
        let [x, _, z] = cells.position(cell).map(|k| f64::from(k) + 0.5);
        let (aside, up) = (x - AXIS[0], z - AXIS[1]);
        if aside.atan2(up).abs() < 0.45 {
            let height = aside.hypot(up) - RADIUS;
            let off = (field.value(cell).unwrap() - height).abs();
            (first, all) = (if height < 0.5 { first.max(off) } else { first }, all.max(off));
        }
    }
    assert!(first < 0.005 && all < 0.1, "{first} {all}");
}

/// The layers are parallel to the mould, and nothing is missed, whichever order has them.
#[test]
fn layers_are_parallel_to_the_mould() {
    let (platform, mesh) = (platform(), shell(0.0));
    let rows = outside(&platform, 0.0);
    let part = workpiece(&mesh, &platform, &rows, 0.0);
    for layers_by in [LayersBy::Distance, LayersBy::Directed] {
        let directed = DirectedOptions { max_tilt: Some(FRAC_PI_3) };
        let options =
            LayerOptions { height_mm: Some(0.5), layers_by, directed, support: None, ..LayerOptions::default() };
        let order = part.order(&options, &go).unwrap();
        let missed: Vec<_> = order.growth.missed_cells().iter().map(|&cell| part.cells.position(cell)).collect();
        assert!(order.audit.is_ok() && missed.is_empty(), "{layers_by:?}: {}, {missed:?}", order.audit);
        let made = part.layers_of(order, &options, &go).unwrap();
        let surfaces = &made.surfaces;
        let whole: Vec<_> = surfaces.sheets.iter().zip(&surfaces.is_half).filter(|(_, half)| !**half).collect();
        assert_eq!(whole.len(), 10, "{layers_by:?}");
        let mut off: f64 = 0.0;
        for (k, (sheet, _)) in whole.iter().enumerate() {
            assert!(!sheet.triangles.is_empty(), "{layers_by:?}: layer {k} is empty");
            for p in sheet.vertices.iter().filter(|p| (p.x - AXIS[0]).atan2(p.z - AXIS[1]).abs() < 0.45) {
                let height = (p.x - AXIS[0]).hypot(p.z - AXIS[1]) - RADIUS;
                off = off.max((height - (k as f64 + 0.5) * surfaces.height_mm).abs());
            }
        }
        assert!(off < 0.08 && (surfaces.height_mm - 0.5).abs() < 0.03, "{layers_by:?}: {off} {}", surfaces.height_mm);
        let volume = surfaces.spacing.volume_mm3;
        assert!((volume / part.volume_mm3 - 1.0).abs() < 0.01, "{layers_by:?}: {volume} {}", part.volume_mm3);
    }
}

/// A shell that hangs 0.7 mm over the mould does not begin there.
#[test]
fn a_part_that_passes_the_mould_does_not_touch_it() {
    let (platform, gap) = (platform(), 0.7);
    let (mesh, rows) = (shell(gap), outside(&platform, gap));
    let part = workpiece(&mesh, &platform, &rows, gap);
    let options = LayerOptions { height_mm: Some(0.5), layers_by: LayersBy::Distance, ..LayerOptions::default() };
    let error = part.order(&options, &go).err();
    assert_eq!(error, Some(LayersError::Growth(GrowthError::NothingOnPlatform)));
}
