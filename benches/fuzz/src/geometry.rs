//! Geometry from bytes: each entry takes numbers off the input until it ends, small grids of numbers more often than any, since these
//! meet in points, lines and planes.

use crate::Entry;
use crate::readers::ranges::LayerFill;
use curvlay_hull::{ConvexHull, ConvexHull2, Depth, Hint};
use curvlay_layers::cells::Cells;
use curvlay_layers::curved::surface::{LayerField, contour, extend};
use curvlay_layers::planar::{Region, SectionPolygon};
use curvlay_layers::trim::Trimmer;
use curvlay_toolpath::fiber::direction::DirectionField;
use curvlay_toolpath::fiber::tapes::{TapeOptions, lay_tapes, lay_tapes_along};
use curvlay_toolpath::fill::fill_layers;
use curvlay_toolpath::layer::LayerSurface;
use curvlay_toolpath::mesh::SurfaceMesh;
use curvlay_toolpath::path::{InfillOptions, PathOptions};
use nalgebra::{Point2, Point3, Vector3};
use std::hint::black_box;
use std::ops::ControlFlow;

pub const ENTRIES: &[Entry] = &[
    ("hull", hull),
    ("hull2", hull2),
    ("contour", contour_field),
    ("trim", trim),
    ("region", region),
    ("infill", infill),
    ("tapes", tapes),
];

/// Numbers taken off an input; zeros behind its end.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    fn below(&mut self, end: u32) -> u32 {
        u32::from(self.byte()) % end.max(1)
    }

    fn wide(&mut self) -> i32 {
        i32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    /// On a coarse grid, on a fine one, or any float.
    fn number(&mut self) -> f64 {
        match self.byte() {
            kind @ 0..=199 => f64::from(kind % 16) - 4.0,
            200..=239 => f64::from(self.wide()) / 65536.0 / 1024.0,
            240..=250 => f64::from(self.byte()) / 64.0,
            _ => f64::from_le_bytes(std::array::from_fn(|_| self.byte())),
        }
    }

    fn integer(&mut self) -> i32 {
        match self.byte() {
            kind @ 0..=231 => i32::from(kind % 32) - 16,
            232..=247 => self.wide() >> 12,
            _ => self.wide(),
        }
    }

    fn is_over(&self) -> bool {
        self.0.is_empty()
    }
}

fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn go_on(_: curvlay_toolpath::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Points in groups, with roll backs between them; all queries on each point.
fn hull(data: &[u8]) {
    let mut bytes = Bytes(data);
    let mut hull = ConvexHull::new(Depth::default());
    let mut hint = Hint::default();
    let mut marks = Vec::new();
    while !bytes.is_over() {
        let points: Vec<[i32; 3]> =
            (0..=bytes.below(6)).map(|_| [bytes.integer(), bytes.integer(), bytes.integer()]).collect();
        match bytes.below(8) {
            0 => marks.push(hull.checkpoint()),
            1 => {
                if let Some(mark) = marks.pop() {
                    hull.rollback(mark);
                }
            }
            _ => {
                let _ = hull.insert(&points);
            }
        }
        for &point in &points {
            let is_outside = hull.is_outside(point, &mut hint);
            assert!(!(is_outside && hull.is_deep(point)), "{point:?}");
            black_box((hull.locate(point), hull.witness(point, &mut hint), hull.support(point)));
        }
    }
    black_box((hull.corners(), hull.planes().count(), hull.triangles().count()));
}

fn hull2(data: &[u8]) {
    let mut bytes = Bytes(data);
    let mut hull = ConvexHull2::new(Depth::default());
    while !bytes.is_over() {
        let points: Vec<[i32; 2]> = (0..=bytes.below(6)).map(|_| [bytes.integer(), bytes.integer()]).collect();
        let mark = hull.checkpoint();
        let _ = hull.insert(&points);
        if bytes.below(4) == 0 {
            hull.rollback(mark);
        }
        for &point in &points {
            black_box((hull.locate(point), hull.is_deep(point), hull.support(point), hull.row_interval(point[1])));
        }
        black_box((hull.area_times_2(), curvlay_hull::convex_polygon(&points)));
    }
}

/// A field of any values on some cells, at any levels.
fn contour_field(data: &[u8]) {
    let mut bytes = Bytes(data);
    let dims = [1 + bytes.below(5), 1 + bytes.below(5), 1 + bytes.below(5)];
    let [nx, ny, nz] = dims.map(|side| side as usize);
    let mut rows = vec![0u64; ny * nz];
    let mut values = vec![f64::NAN; nx * ny * nz];
    for (cell, value) in values.iter_mut().enumerate() {
        if bytes.below(8) > 0 {
            rows[cell / nx] |= 1 << (cell % nx);
            *value = bytes.number();
        }
    }
    let levels: Vec<f64> = (0..bytes.below(5)).map(|_| bytes.number()).collect();
    let (layer, cell_mm) = (bytes.number(), bytes.number());
    let Ok(cells) = Cells::new(dims, &rows) else { return };
    let Ok(field) = LayerField::new(&cells, values, layer) else { return };
    let field = extend(&field, &cells);
    let _ = contour(&field, &levels, cell_mm, Point3::origin(), &go);
    if let Ok(levels) = field.levels(cell_mm, bytes.number()) {
        let _ = contour(&field, &levels[..levels.len().min(50)], cell_mm, Point3::origin(), &go);
    }
}

fn mesh(bytes: &mut Bytes, most: u32) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let vertices: Vec<Point3<f64>> =
        (0..3 + bytes.below(most)).map(|_| Point3::new(bytes.number(), bytes.number(), bytes.number())).collect();
    let count = vertices.len() as u32 + u32::from(bytes.below(64) == 63);
    let triangles = (0..1 + bytes.below(2 * most)).map(|_| std::array::from_fn(|_| bytes.below(count))).collect();
    (vertices, triangles)
}

/// A sheet of a few quads whose corners are moved.
fn sheet(bytes: &mut Bytes) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (nx, ny, step) = (2 + bytes.below(5), 2 + bytes.below(5), 0.5 + f64::from(bytes.below(16)) / 4.0);
    let mut vertices = Vec::new();
    for k in 0..nx * ny {
        let moved = if bytes.below(4) == 0 { bytes.number() } else { 0.0 };
        vertices.push(Point3::new(step * f64::from(k % nx), step * f64::from(k / nx), 0.3 * moved));
    }
    let quad = |k: u32| {
        let a = k % (nx - 1) + nx * (k / (nx - 1));
        [[a, a + 1, a + nx + 1], [a, a + nx + 1, a + nx]]
    };
    let mut triangles: Vec<[u32; 3]> = (0..(nx - 1) * (ny - 1)).flat_map(quad).collect();
    for _ in 0..bytes.below(4).min(triangles.len() as u32 - 1) {
        triangles.swap_remove(bytes.below(triangles.len() as u32) as usize);
    }
    (vertices, triangles)
}

/// The corners of a tetrahedron or a box, or any mesh; a sheet, or any mesh.
fn trim(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (vertices, triangles) = match bytes.below(4) {
        0 => mesh(&mut bytes, 8),
        _ => {
            let corners = (0..4).map(|_| Point3::new(bytes.number(), bytes.number(), bytes.number())).collect();
            (corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        }
    };
    let Ok(trimmer) = Trimmer::new(&vertices, &triangles) else { return };
    let trimmer = if bytes.below(2) == 0 { trimmer } else { trimmer.thinned(bytes.number()) };
    let (vertices, triangles) = if bytes.below(4) == 0 { mesh(&mut bytes, 8) } else { sheet(&mut bytes) };
    let shift = Vector3::new(bytes.number(), bytes.number(), bytes.number());
    let vertices: Vec<_> = vertices.iter().map(|vertex| vertex + shift).collect();
    if let Ok(trimmed) = trimmer.trim(&vertices, &triangles, &go) {
        black_box((trimmed.area(), trimmed.border_turning()));
    }
}

fn polygons(bytes: &mut Bytes) -> Vec<SectionPolygon> {
    let mut ring = |most: u32| -> Vec<Point2<f64>> {
        (0..bytes.below(most)).map(|_| Point2::new(bytes.number(), bytes.number())).collect()
    };
    (0..2).map(|_| SectionPolygon { outer: ring(10), holes: vec![ring(6)] }).collect()
}

fn region(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (Ok(a), Ok(b)) = (Region::new(&polygons(&mut bytes)), Region::new(&polygons(&mut bytes))) else { return };
    let by = bytes.number();
    let normal = bytes.number();
    for region in [a.union(&b), a.intersection(&b), a.difference(&b), a.offset(by.clamp(-3.0, 3.0)).unwrap_or_default()]
    {
        black_box((region.area(), region.centroid(), region.inner_point(), region.bounds(), region.pieces().len()));
        let _ = region.half([normal.cos(), normal.sin()], by);
        black_box(region.simplified(by.abs()).without_specks(by.abs()).contains(&Point2::new(by, normal)));
    }
    let _ = a.offset(by);
}

/// A sheet that is filled: any density, walls and bead.
fn infill(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (density, walls, skin) = (f64::from(bytes.below(21)) / 20.0, bytes.below(4), bytes.below(3));
    let bead = 0.3 + f64::from(bytes.below(16)) / 8.0;
    let sheets: Vec<_> = (0..1 + bytes.below(3)).map(|_| sheet(&mut bytes)).collect();
    let thickness: Vec<Vec<f64>> = sheets.iter().map(|(_, triangles)| vec![0.3; triangles.len()]).collect();
    let surfaces: Vec<LayerSurface> = sheets
        .iter()
        .zip(&thickness)
        .map(|((vertices, triangles), thickness)| LayerSurface { vertices, triangles, thickness, is_half: false })
        .collect();
    let infill = InfillOptions { density, walls, skin, ..InfillOptions::default() };
    let _ = fill_layers(&surfaces, &PathOptions { bead, infill, ..PathOptions::default() }, &go_on);
}

fn tapes(data: &[u8]) {
    let mut bytes = Bytes(data);
    let (vertices, triangles) = if bytes.below(8) == 0 { mesh(&mut bytes, 8) } else { sheet(&mut bytes) };
    let Ok(mesh) = SurfaceMesh::new(vertices, triangles) else { return };
    let width = 0.3 + f64::from(bytes.below(16)) / 8.0;
    let options = TapeOptions {
        width,
        spacing: width * (0.5 + f64::from(bytes.below(4)) / 4.0),
        min_radius: f64::from(bytes.below(20)),
        min_length: f64::from(1 + bytes.below(4)),
        ..TapeOptions::default()
    };
    let turn = bytes.number();
    let bend = bytes.number();
    let direction =
        |point: &Point3<f64>| Vector3::new((turn + bend * point.x).cos(), (turn + bend * point.y).sin(), 0.0);
    if let Ok(field) = DirectionField::from_fn(&mesh, |point| direction(&point)) {
        let _ = lay_tapes(&field, &options, &go_on);
    }
    let guide = (0..bytes.below(5)).map(|_| Point3::new(bytes.number(), bytes.number(), bytes.number())).collect();
    let _ = lay_tapes_along(&mesh, &[guide], &options, &go_on);
}

/// A few layers for files of paths.
pub fn small_layers() -> (Vec<LayerSurface<'static>>, LayerFill) {
    const VERTICES: [Point3<f64>; 4] = [
        Point3::new(0.0, 0.0, 0.2),
        Point3::new(6.0, 0.0, 0.2),
        Point3::new(6.0, 4.0, 0.4),
        Point3::new(0.0, 4.0, 0.2),
    ];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    let layer = LayerSurface { vertices: &VERTICES, triangles: &TRIANGLES, thickness: &[0.3, 0.3], is_half: false };
    (vec![layer; 2], LayerFill { part: PathOptions { bead: 0.8, ..PathOptions::default() }, support: None })
}
