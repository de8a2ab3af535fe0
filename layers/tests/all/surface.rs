//! Surfaces of fields: manifold whatever the field, where the field says, and as far apart as a slow twin finds.

use curvlay_layers::cells::{Cells, LayerOrder};
use curvlay_layers::curved::surface::{
    ContourError, FieldError, LayerField, SpacingError, Surface, VertexPlacement, contour, contour_with, extend,
    measure_spacing, plain_field,
};
use curvlay_layers::trim::SurfaceSlices;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

pub fn go(_: curvlay_layers::Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The least height of a triangle that is let through, in millimetres.
const LEAST_HEIGHT_MM: f64 = 1e-6;

/// Bits of the cells of a grid at most 64 wide for which `solid` holds.
fn rows_of(dims: [u32; 3], solid: impl Fn([u32; 3]) -> bool) -> Vec<u64> {
    let [nx, ny, nz] = dims;
    let row = |y, z| (0..nx).filter(|&x| solid([x, y, z])).fold(0, |bits, x| bits | 1 << x);
    (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).map(|(y, z)| row(y, z)).collect()
}

/// A field with the value of `of` at the cells, in a grid at most 64 wide.
fn field_of(cells: &Cells, of: impl Fn(Point3<f64>) -> f64) -> LayerField {
    let mut values = vec![f64::NAN; cells.dims().iter().product::<u32>() as usize];
    for cell in cells.iter() {
        values[cell as usize] = of(Point3::from(cells.position(cell).map(|c| f64::from(c) + 0.5)));
    }
    LayerField::new(cells, values, 1.0).unwrap()
}

fn surfaces_of(cells: &Cells, field: &LayerField, levels: &[f64]) -> Vec<Surface> {
    contour(&extend(field, cells), levels, 1.0, Point3::origin(), &go).unwrap()
}

fn slices(surfaces: &[Surface]) -> Vec<SurfaceSlices<'_>> {
    surfaces.iter().map(|surface| (&surface.points[..], &surface.triangles[..])).collect()
}

/// What is wrong with a surface: edges of more than two triangles or run through twice the same way, vertices at
/// which more than one fan of triangles meets, triangles without height.
pub fn faults(surface: &Surface) -> Vec<String> {
    let mut faults = Vec::new();
    let mut edges = BTreeMap::new();
    let mut around: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for &[a, b, c] in &surface.triangles {
        for (from, to, third) in [(a, b, c), (b, c, a), (c, a, b)] {
            if edges.insert((from, to), third).is_some() {
                faults.push(format!("edge {from} {to} twice"));
            }
            around.entry(from).or_default().push((to, third));
        }
        let [p, q, r] = [a, b, c].map(|v| surface.points[v as usize]);
        let longest = [q - p, r - q, p - r].iter().map(Vector3::norm).fold(0.0, f64::max);
        let height = (q - p).cross(&(r - p)).norm() / longest;
        if height.is_nan() || height < LEAST_HEIGHT_MM {
            faults.push(format!("triangle {a} {b} {c} is {height} high"));
        }
    }
    for (vertex, spokes) in around {
        // Follow the fan from its first spoke, or from any if it is closed.
        let next: BTreeMap<u32, u32> = spokes.iter().copied().collect();
        let ends: Vec<u32> = next.values().copied().collect();
        let mut at = next.keys().copied().find(|from| !ends.contains(from)).unwrap_or(spokes[0].0);
        let mut walked = 0;
        while let Some(&to) = next.get(&at).filter(|_| walked < spokes.len()) {
            at = to;
            walked += 1;
        }
        if walked != spokes.len() {
            faults.push(format!("vertex {vertex} has more than one fan"));
        }
    }
    faults
}

pub fn area_of(surface: &Surface) -> f64 {
    let area = |t: &[u32; 3]| {
        let [p, q, r] = t.map(|v| surface.points[v as usize]);
        (q - p).cross(&(r - p)).norm() / 2.0
    };
    surface.triangles.iter().map(area).sum()
}

/// A solid of up to 6 x 6 x 6 cells with a value at each; small steps, large jumps, and many equal values.
pub fn wild() -> impl Strategy<Value = ([u32; 3], Vec<Option<f64>>)> {
    let side = 1..=6u32;
    let value = prop_oneof![
        2 => Just(None),
        3 => (0..6u32).prop_map(|v| Some(f64::from(v) / 2.0)),
        3 => (0.0..3.0f64).prop_map(Some),
        1 => (0.0..12.0f64).prop_map(Some),
    ];
    [side.clone(), side.clone(), side].prop_flat_map(move |dims| {
        let len = dims.iter().product::<u32>() as usize;
        (Just(dims), prop::collection::vec(value.clone(), len))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn surfaces_are_manifold_whatever_the_field((dims, values) in wild(), level in 0.0..6.0f64, half in 0..12u32) {
        let at = |[x, y, z]: [u32; 3]| values[(x + dims[0] * (y + dims[1] * z)) as usize];
        // A quarter of what has no value is solid all the same: missed.
        let rows = rows_of(dims, |p| at(p).is_some() || (p[0] + p[1] + p[2]) % 4 == 0);
        let cells = Cells::new(dims, &rows).unwrap();
        let numbers = values.iter().map(|v| v.unwrap_or(f64::NAN)).collect();
        let Ok(field) = LayerField::new(&cells, numbers, 1.0) else { return Ok(()) };
        for surface in surfaces_of(&cells, &field, &[level, f64::from(half) / 2.0]) {
            prop_assert_eq!(faults(&surface), Vec::<String>::new());
        }
        let (extended, levels) = (extend(&field, &cells), [level, f64::from(half) / 2.0]);
        for surface in contour_with(&extended, &levels, 1.0, Point3::origin(), VertexPlacement::Features, &go).unwrap() {
            prop_assert_eq!(faults(&surface), Vec::<String>::new());
        }
    }

    #[test]
    fn spacing_is_that_of_the_slow_twin((dims, values) in wild()) {
        spacing_is_slow(dims, &values)?;
    }
}

fn spacing_is_slow(dims: [u32; 3], values: &[Option<f64>]) -> Result<(), TestCaseError> {
    let rows = rows_of(dims, |[x, y, z]| values[(x + dims[0] * (y + dims[1] * z)) as usize].is_some());
    let cells = Cells::new(dims, &rows).unwrap();
    let numbers = values.iter().map(|v| v.unwrap_or(f64::NAN)).collect();
    let Ok(field) = LayerField::new(&cells, numbers, 1.0) else { return Ok(()) };
    let surfaces = surfaces_of(&cells, &field, &[0.5, 1.25, 2.0]);
    // Not the distance of the levels: two of them would often be as far apart as a wait may be, but for rounding.
    let height = 0.74;
    let spacing = measure_spacing(&slices(&surfaces), height, &go).unwrap();
    let mut volume = 0.0;
    for (i, surface) in surfaces.iter().enumerate() {
        let fast = spacing.values_mm[i].iter().zip(&spacing.thickness_mm[i]);
        for (triangle, (value, thickness)) in surface.triangles.iter().zip(fast) {
            let slow = Slow::at(&surfaces, i, triangle);
            match (*value, slow.spacing(height)) {
                (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-9, "{a} {b}"),
                (a, b) => prop_assert_eq!(a, b),
            }
            prop_assert!((thickness - slow.thickness(height)).abs() < 1e-9, "{thickness} {}", slow.thickness(height));
            let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
            volume += (b - a).cross(&(c - a)).norm() / 2.0 * thickness;
        }
    }
    prop_assert!((volume - spacing.volume_mm3).abs() <= 1e-9 * volume);
    Ok(())
}

/// The line from the middle of a triangle runs along the side of boxes, and through the edge of two triangles.
#[test]
fn a_line_along_the_side_of_a_box_comes_through_it() {
    const N: Option<f64> = None;
    #[rustfmt::skip]
    let values = [
        Some(2.5), Some(1.0), Some(2.5), N, Some(1.0), Some(0.0), N, Some(2.160158223631476), N, N,
        Some(2.5719775451673144), N, Some(2.7602855545894425), Some(2.19053116453393), Some(4.026180727230657),
        Some(1.5), Some(1.0), Some(2.5), N, Some(1.5), Some(4.809524014335714), Some(1.486200454409573), Some(0.0),
        N, Some(0.2755713403711263), Some(2.0), Some(0.0), N, N, Some(0.5), N, N, N, Some(0.0), N, N, Some(2.0), N,
        N, Some(1.5), Some(6.872577798348462), Some(0.5), N, Some(2.0), Some(2.5492850951388193), N, Some(0.0),
        Some(0.09736512496002224), Some(0.0), N, Some(0.6543582816920858), N, Some(0.0), Some(2.0), N,
        Some(2.432001726081554), Some(0.0), Some(2.5), Some(0.0), Some(2.545866679479971), N, N, Some(2.0), N, N,
        Some(0.0), N, N, N, Some(8.907002964108122), Some(0.5), Some(1.5),
    ];
    spacing_is_slow([3, 6, 4], &values).unwrap();
}

/// What a look at every triangle of the others finds: layer and distance, against the normal and along it.
struct Slow {
    layer: usize,
    met: [Vec<(usize, f64)>; 2],
}

impl Slow {
    fn at(surfaces: &[Surface], layer: usize, triangle: &[u32; 3]) -> Self {
        let corners = |surface: &Surface, t: &[u32; 3]| t.map(|v| surface.points[v as usize]);
        let [a, b, c] = corners(&surfaces[layer], triangle);
        let normal = (b - a).cross(&(c - a)).normalize();
        let start = Point3::from((a.coords + b.coords + c.coords) / 3.0);
        let mut met = [Vec::new(), Vec::new()];
        for (other, surface) in surfaces.iter().enumerate().filter(|&(other, _)| other != layer) {
            let side = usize::from(other > layer);
            let direction = if side == 1 { normal } else { -normal };
            for t in &surface.triangles {
                let [p, q, r] = corners(surface, t);
                let across = (q - p).cross(&(r - p));
                let distance = (p - start).dot(&across) / direction.dot(&across);
                let x = start + direction * distance;
                let sides = [(p, q), (q, r), (r, p)];
                let inside = sides.iter().all(|(u, v)| (v - u).cross(&(x - u)).dot(&across) >= -1e-12);
                if inside && distance >= 0.0 && across.dot(&normal) > 0.0 {
                    met[side].push((other, distance));
                }
            }
        }
        Slow { layer, met }
    }

    /// The nearest within `reach` on a side; only of the layer next to it, or of all.
    fn nearest(&self, side: usize, reach: f64, next: bool) -> Option<f64> {
        let counts =
            |&&(other, distance): &&(usize, f64)| distance < reach && (!next || other.abs_diff(self.layer) == 1);
        self.met[side].iter().filter(counts).map(|&(_, distance)| distance).reduce(f64::min)
    }

    fn spacing(&self, height: f64) -> Option<f64> {
        match [0, 1].map(|side| self.nearest(side, 3.0 * height, true)) {
            [Some(down), Some(up)] => Some((up + down) / 2.0),
            [one, other] => one.or(other),
        }
    }

    fn thickness(&self, height: f64) -> f64 {
        let half = |side: usize| {
            let any = self.nearest(side, 2.0 * height, false);
            any.or_else(|| self.nearest(side, 3.0 * height, true)).unwrap_or(height) / 2.0
        };
        half(0) + half(1)
    }
}

#[test]
fn a_leaning_plane_is_met_exactly_and_faces_the_growth() {
    let rows = rows_of([12, 10, 9], |_| true);
    let cells = Cells::new([12, 10, 9], &rows).unwrap();
    let slope = Vector3::new(0.3, -0.2, 0.9).normalize();
    let height = |p: &Point3<f64>| p.coords.dot(&slope) + 3.0;
    let field = field_of(&cells, |p| height(&p));
    let surfaces = surfaces_of(&cells, &field, &[5.0, 6.0, 7.0]);
    for surface in &surfaces {
        assert_eq!(faults(surface), Vec::<String>::new());
        // Beyond the rings there is nothing to go by.
        let within = |p: &&Point3<f64>| p.iter().zip(cells.dims()).all(|(c, side)| (0.0..=f64::from(side)).contains(c));
        for p in surface.points.iter().filter(within) {
            assert!((height(p) - surface.value).abs() < 0.01, "{p}");
        }
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| surface.points[v as usize]);
            assert!(![a, b, c].iter().all(|p| within(&p)) || (b - a).cross(&(c - a)).normalize().dot(&slope) > 0.999);
        }
    }
    let spacing = measure_spacing(&slices(&surfaces), 1.0, &go).unwrap();
    assert!((spacing.mean_mm - 1.0).abs() < 1e-3 && spacing.std_mm < 0.01, "{} {}", spacing.mean_mm, spacing.std_mm);
    assert!(spacing.p05_mm > 0.98 && spacing.p95_mm < 1.02);
    assert!(spacing.squeezed_share <= 0.0);
    assert!((spacing.histogram_mm2.iter().sum::<f64>() - spacing.measured_mm2).abs() < 1e-9);
}

#[test]
fn what_is_between_surfaces_is_shared_out_where_a_layer_is_missing_too() {
    // Level strips, from x = 0 as far as each goes: heights, and where they end.
    // A triangle for each half of a column, so that none reaches across the end of another strip.
    let strip = |z: f64, end: u32| {
        let points = (0..=end).flat_map(|x| [0.0, 1.0].map(|y| Point3::new(f64::from(x), y, z))).collect();
        let triangles = (0..end).flat_map(|x| [[0, 2, 1], [2, 3, 1]].map(|t| t.map(|v| v + 2 * x))).collect();
        Surface { value: z, points, triangles }
    };
    let surfaces = [strip(0.5, 4), strip(1.3, 2), strip(2.2, 4), strip(3.2, 1), strip(5.0, 4)];
    let spacing = measure_spacing(&slices(&surfaces), 1.0, &go).unwrap();
    let of_layer = |i: usize| spacing.thickness_mm[i].iter().step_by(2).copied().collect::<Vec<_>>();
    let near = |a: Vec<f64>, b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(near(of_layer(0), &[0.9, 0.9, 1.35, 1.35]), "{:?}", of_layer(0));
    assert!(near(of_layer(2), &[0.95, 0.95, 1.35, 1.35]), "{:?}", of_layer(2));
    // Behind the fourth strip there are 2.8 to the last one: more than a wait leaves, so it is a gap of the part.
    assert!(near(of_layer(4), &[1.4, 1.0, 1.0, 1.0]), "{:?}", of_layer(4));
    // From half a layer below the first to half above the last, but for the gap.
    let columns = [5.5, 5.5 - 1.8, 5.5 - 1.8, 5.5 - 1.8];
    assert!((spacing.volume_mm3 - columns.iter().sum::<f64>()).abs() < 1e-12, "{}", spacing.volume_mm3);
    // Spacing is that of neighbours alone.
    assert_eq!(spacing.values_mm[0][4], None);
}

#[test]
fn a_ball_is_closed_and_as_large_as_it_should_be() {
    let rows = rows_of([24; 3], |_| true);
    let cells = Cells::new([24; 3], &rows).unwrap();
    let field = field_of(&cells, |p| (p - Point3::new(12.1, 11.8, 12.0)).norm());
    let [ball] = &surfaces_of(&cells, &field, &[8.0])[..] else { panic!("one level, one surface") };
    assert_eq!(faults(ball), Vec::<String>::new());
    assert!((area_of(ball) / (4.0 * std::f64::consts::PI * 64.0) - 1.0).abs() < 0.02);
    let edges = 3 * ball.triangles.len() / 2;
    assert_eq!(ball.points.len() + ball.triangles.len() - edges, 2, "Euler number of a sphere");
    let volume: f64 = ball
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| ball.points[v as usize].coords);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    assert!((volume / (4.0 / 3.0 * std::f64::consts::PI * 512.0) - 1.0).abs() < 0.02, "outwards: {volume}");
}

#[test]
fn every_surface_reaches_outside_the_cells() {
    let inside =
        |[x, y, z]: [u32; 3]| (f64::from(x) - 8.0).powi(2) + (f64::from(y) - 8.0).powi(2) < 36.0 + 3.0 * f64::from(z);
    let rows = rows_of([20, 20, 8], inside);
    let cells = Cells::new([20, 20, 8], &rows).unwrap();
    let field = field_of(&cells, |p| p.z + 0.1 * p.x);
    for surface in surfaces_of(&cells, &field, &[2.0, 3.5, 5.0]) {
        let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for &[a, b, c] in &surface.triangles {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                *edges.entry([p.min(q), p.max(q)]).or_default() += 1;
            }
        }
        let rim = edges.iter().filter(|(_, count)| **count == 1).flat_map(|(edge, _)| edge);
        for &vertex in rim {
            let at = surface.points[vertex as usize].map(f64::floor);
            let outside = at.iter().zip(cells.dims()).any(|(c, side)| *c < 0.0 || *c >= f64::from(side));
            assert!(outside || !cells.contains([at.x, at.y, at.z].map(|c| c as u32)), "{at}");
        }
    }
}

#[test]
fn columns_that_touch_along_an_edge_are_not_bridged() {
    // Two columns, diagonal neighbours, at the same height everywhere.
    let rows = rows_of([6, 6, 6], |[x, y, _]| (x < 3) == (y < 3) && x != 0 && y != 0);
    let cells = Cells::new([6, 6, 6], &rows).unwrap();
    let [surface] = &surfaces_of(&cells, &field_of(&cells, |p| p.z), &[3.2])[..] else { panic!() };
    assert_eq!(faults(surface), Vec::<String>::new());
    assert_eq!(pieces(surface), 2);
}

/// Connected pieces of a surface.
fn pieces(surface: &Surface) -> usize {
    let mut of: Vec<usize> = (0..surface.points.len()).collect();
    loop {
        let before = of.clone();
        for t in &surface.triangles {
            let least = t.iter().map(|&v| of[v as usize]).min().unwrap();
            t.iter().for_each(|&v| of[v as usize] = least);
        }
        if of == before {
            break;
        }
    }
    let mut used: Vec<usize> = surface.triangles.iter().flatten().map(|&v| of[v as usize]).collect();
    used.sort_unstable();
    used.dedup();
    used.len()
}

#[test]
fn a_gap_of_one_or_two_cells_is_not_bridged() {
    for gap in 1..=2 {
        let rows = rows_of([9, 3, 5], |[x, _, _]| x < 4 || x >= 4 + gap);
        let cells = Cells::new([9, 3, 5], &rows).unwrap();
        let [surface] = &surfaces_of(&cells, &field_of(&cells, |p| p.z), &[2.2])[..] else { panic!() };
        assert_eq!((gap, pieces(surface)), (gap, 2));
    }
}

#[test]
fn a_front_that_is_a_little_slow_goes_on_across_a_layer() {
    let cells = Cells::new([1, 1, 2], &[1, 1]).unwrap();
    let jumps = |values: [f64; 2]| extend(&LayerField::new(&cells, values.to_vec(), 1.0).unwrap(), &cells).jumps();
    // From the first layer to the third both times.
    assert_eq!([jumps([0.9, 2.1]), jumps([0.5, 2.5])], [0, 1]);
    // From one layer to the next, however far apart.
    assert_eq!(jumps([0.01, 1.99]), 0);
}

#[test]
fn at_a_wait_surfaces_go_on_to_the_face_and_none_is_squeezed() {
    // Level fronts; above half of the height everything came five layers later.
    let rows = rows_of([4, 4, 8], |_| true);
    let cells = Cells::new([4, 4, 8], &rows).unwrap();
    let field = field_of(&cells, |p| if p.z < 4.0 { p.z } else { p.z + 5.0 });
    let extended = extend(&field, &cells);
    assert_eq!(extended.jumps(), 16);
    let levels = extended.levels(1.0, 0.8).unwrap();
    let surfaces = contour(&extended, &levels, 1.0, Point3::origin(), &go).unwrap();
    let inside = |p: &Point3<f64>| p.x > 0.5 && p.x < 3.5 && p.y > 0.5 && p.y < 3.5;
    let mut heights: Vec<f64> = surfaces
        .iter()
        .filter(|surface| !surface.triangles.is_empty())
        .filter_map(|surface| surface.points.iter().find(|p| inside(p)).map(|p| p.z))
        .collect();
    heights.sort_by(f64::total_cmp);
    // 0.4, 1.2 .. 3.6 below the wait; 9.2 - 5 = 4.2, 5.0 .. above: the first surface after it is a layer away at least.
    let expected = [0.4, 1.2, 2.0, 2.8, 3.6, 4.2, 5.0, 5.8, 6.6, 7.4];
    assert_eq!(heights.len(), expected.len(), "{heights:?}");
    assert!(heights.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01), "{heights:?}");
}

#[test]
fn beside_a_wait_each_side_ends_at_the_face_between() {
    let rows = rows_of([8, 4, 6], |_| true);
    let cells = Cells::new([8, 4, 6], &rows).unwrap();
    let field = field_of(&cells, |p| if p.x < 4.0 { p.z } else { p.z + 9.0 });
    let surfaces = surfaces_of(&cells, &field, &[3.0, 12.0]);
    let range = |surface: &Surface| {
        let xs = || surface.points.iter().map(|p| p.x);
        (xs().fold(f64::INFINITY, f64::min), xs().fold(f64::NEG_INFINITY, f64::max))
    };
    assert!((range(&surfaces[0]).1 - 4.0).abs() < 0.01 && (range(&surfaces[1]).0 - 4.0).abs() < 0.01);
    assert!(surfaces.iter().all(|surface| faults(surface).is_empty()));
}

#[test]
fn nothing_reaches_into_missed_cells() {
    let rows = rows_of([6, 3, 4], |_| true);
    let cells = Cells::new([6, 3, 4], &rows).unwrap();
    let mut values = vec![f64::NAN; 72];
    for cell in cells.iter().filter(|&cell| cells.position(cell)[0] < 3) {
        values[cell as usize] = f64::from(cells.position(cell)[2]) + 0.5;
    }
    let field = LayerField::new(&cells, values, 1.0).unwrap();
    let extended = extend(&field, &cells);
    assert_eq!((extended.value([3, 1, 1]), extended.value([4, 1, 1])), (None, None));
    let [surface] = &surfaces_of(&cells, &field, &[2.0])[..] else { panic!() };
    let within = surface.points.iter().filter(|p| (0.1..2.9).contains(&p.y));
    assert!(within.clone().count() > 0 && within.clone().all(|p| p.x <= 3.01));
}

/// All numbers of an extended field around the cells, of surfaces and of their spacing, bit by bit.
fn bits_of(cells: &Cells, field: &LayerField, levels: &[f64]) -> Vec<u64> {
    let extended = extend(field, cells);
    let [nx, ny, nz] = cells.dims().map(|side| -2..side as i32 + 2);
    let places = nz.flat_map(|z| ny.clone().map(move |y| (y, z))).flat_map(|(y, z)| nx.clone().map(move |x| [x, y, z]));
    let mut bits: Vec<u64> = places.map(|place| extended.value(place).map_or(u64::MAX, f64::to_bits)).collect();
    let surfaces = contour(&extended, levels, 0.7, Point3::new(0.1, -0.2, 0.3), &go).unwrap();
    for surface in &surfaces {
        bits.extend(surface.points.iter().flat_map(|p| p.iter()).map(|c| c.to_bits()));
        bits.extend(surface.triangles.iter().flatten().map(|&v| u64::from(v)));
    }
    let spacing = measure_spacing(&slices(&surfaces), 0.7, &go).unwrap();
    bits.extend(spacing.values_mm.iter().flatten().map(|value| value.map_or(u64::MAX, f64::to_bits)));
    bits.extend(spacing.thickness_mm.iter().flatten().chain(&spacing.histogram_mm2).map(|value| value.to_bits()));
    let sums = [spacing.mean_mm, spacing.std_mm, spacing.area_mm2, spacing.squeezed_share, spacing.volume_mm3];
    bits.extend(sums.map(f64::to_bits));
    bits
}

#[test]
fn threads_change_no_bit() {
    let rows = rows_of([40, 30, 20], |[x, y, z]| (x * 7 + y * 5 + z * 3) % 11 != 0);
    let cells = Cells::new([40, 30, 20], &rows).unwrap();
    let smooth = |p: Point3<f64>| (p - Point3::new(3.0, 4.0, -20.0)).norm() - 19.0;
    // Waits across slopes and of single cells.
    let waits =
        |p: Point3<f64>| smooth(p) + if p.x > p.z + 9.0 || (p.x * 5.0 + p.y).floor() % 7.0 < 1.0 { 5.3 } else { 0.0 };
    let levels: Vec<f64> = (0..30).map(|k| f64::from(k) + 0.5).collect();
    for field in [field_of(&cells, smooth), field_of(&cells, waits)] {
        let run = || bits_of(&cells, &field, &levels);
        let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
        let [one, four] = [1, 4].map(with);
        assert!(one.len() > 100_000, "{}", one.len());
        assert!(one == four);
    }
}

#[test]
fn levels_stand_for_slabs_from_the_plate_to_the_skin() {
    let rows = rows_of([2, 2, 10], |_| true);
    let cells = Cells::new([2, 2, 10], &rows).unwrap();
    let mut order = LayerOrder::new();
    (0..10).for_each(|z| order.push(4 * z..4 * z + 4));
    let plain = plain_field(&cells, &order).unwrap();
    assert!((plain.layer_cells() - 1.0).abs() < 1e-12);
    let field = extend(&plain, &cells);
    let levels = field.levels(0.5, 1.0).unwrap(); // cells of half a millimetre: the part is 5 mm high
    assert_eq!(levels, [1.0, 3.0, 5.0, 7.0, 9.0]);
    assert_eq!(field.levels(0.5, 5.0).unwrap(), [5.0]);
    assert_eq!(field.levels(0.5, 0.1).unwrap().len(), 50);
    assert!(matches!(field.levels(0.5, 0.099), Err(ContourError::TooThin { .. })));
    assert!(matches!(field.levels(0.5, f64::NAN), Err(ContourError::TooThin { .. })));
    assert!(matches!(field.levels(0.5, 5.1), Err(ContourError::TooThick { .. })));
    // Bug: a far value made a list of levels that filled the memory.
    let far = LayerField::new(&cells, (0..40).map(|k| if k == 7 { 1e15 } else { 0.5 }).collect(), 1.0).unwrap();
    assert!(matches!(extend(&far, &cells).levels(0.5, 0.3), Err(ContourError::TooMany { .. })));
    assert!(matches!(field.levels(0.0, 1.0), Err(ContourError::Placement { .. })));
    let nowhere = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(matches!(contour(&field, &levels, 1.0, nowhere, &go), Err(ContourError::Placement { .. })));
}

#[test]
fn unsound_fields_are_refused() {
    let cells = Cells::new([2, 1, 1], &[0b01]).unwrap();
    let new = |values: &[f64], layer_cells| LayerField::new(&cells, values.to_vec(), layer_cells).unwrap_err();
    assert_eq!(new(&[0.5], 1.0), FieldError::Length { values: 1, cells: 2 });
    assert_eq!(new(&[-0.5, f64::NAN], 1.0), FieldError::Value { cell: 0, value: -0.5 });
    assert!(matches!(new(&[f64::INFINITY, f64::NAN], 1.0), FieldError::Value { cell: 0, .. }));
    assert_eq!(new(&[0.5, 0.5], 1.0), FieldError::NotSolid { cell: 1 });
    assert_eq!(new(&[0.5, f64::NAN], 0.0), FieldError::Thickness { layer_cells: 0.0 });
    assert_eq!(new(&[f64::NAN, f64::NAN], 1.0), FieldError::Empty);
    let mut order = LayerOrder::new();
    order.push([5]);
    assert_eq!(plain_field(&cells, &order), Err(FieldError::OutsideGrid { cell: 5, len: 2 }));
    assert_eq!(plain_field(&cells, &LayerOrder::new()), Err(FieldError::Empty));
}

#[test]
fn unsound_surfaces_are_refused_and_none_have_no_spacing() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let triangles = [[0, 1, 2]];
    assert_eq!(measure_spacing(&[], 0.0, &go).unwrap_err(), SpacingError::Height { height_mm: 0.0 });
    let error = measure_spacing(&[(&points, &[[0, 1, 3]])], 1.0, &go).unwrap_err();
    assert_eq!(error, SpacingError::NoPoint { surface: 0, triangle: 0, point: 3, points: 3 });
    let mut broken = points;
    broken[1].y = f64::NAN;
    let error = measure_spacing(&[(&points, &triangles), (&broken, &triangles)], 1.0, &go).unwrap_err();
    assert_eq!(error, SpacingError::NotFinite { surface: 1, point: 1 });
    let none = measure_spacing(&[], 1.0, &go).unwrap();
    assert_eq!((none.mean_mm, none.area_mm2, none.squeezed_share), (0.0, 0.0, 0.0));
    // One alone has no neighbour, but it has a volume; one without area counts for nothing.
    let alone = measure_spacing(&[(&points, &[[0, 1, 2], [0, 1, 1]])], 2.0, &go).unwrap();
    assert_eq!(alone.values_mm, [[None, None]]);
    assert_eq!((alone.area_mm2, alone.measured_mm2, alone.volume_mm3), (0.5, 0.0, 1.0));
}

#[test]
fn squeezed_area_is_reported_whichever_surface_comes_near() {
    let level = |z: f64| [[0.0, 0.0, z], [4.0, 0.0, z], [0.0, 4.0, z]].map(Point3::from);
    let points = [level(0.0), level(1.0), level(0.2)]; // the third comes near the first
    let surfaces: Vec<SurfaceSlices> = points.iter().map(|points| (&points[..], &[[0, 1, 2]][..])).collect();
    let spacing = measure_spacing(&surfaces, 1.0, &go).unwrap();
    assert!((spacing.squeezed_share - 2.0 / 3.0).abs() < 1e-12);
}

/// Area of the surfaces at all whole and a half levels over the middle of a block of 20 cells, per cell.
fn area_a_cell(of: impl Fn(Point3<f64>) -> f64) -> f64 {
    let rows = rows_of([20; 3], |_| true);
    let cells = Cells::new([20; 3], &rows).unwrap();
    let field = field_of(&cells, of);
    let levels: Vec<f64> = (0..=field.highest() as u32 + 1).map(|k| f64::from(k) + 0.5).collect();
    let mut area = 0.0;
    for surface in surfaces_of(&cells, &field, &levels) {
        assert_eq!(faults(&surface), Vec::<String>::new());
        for t in &surface.triangles {
            let [a, b, c] = t.map(|v| surface.points[v as usize]);
            let middle = (a.coords + b.coords + c.coords) / 3.0;
            if middle.iter().all(|&c| (4.0..16.0).contains(&c)) {
                area += (b - a).cross(&(c - a)).norm() / 2.0;
            }
        }
    }
    area / 12f64.powi(3)
}

#[test]
fn no_area_is_lost_at_a_wait() {
    let waits = |late: bool, layers: f64| if late { layers } else { 0.0 };
    let near = |area: f64, what: &str| assert!((area - 1.0).abs() < 0.02, "{what}: {area}");
    near(area_a_cell(|p| p.z + waits(p.x > 10.0, 5.3)), "an upright step");
    near(area_a_cell(|p| 0.8 * p.z + 0.6 * p.x + waits(p.y > 10.0, 7.3)), "a step across a slope");
    near(area_a_cell(|p| 3.0 * p.z), "each layer of cells waits");
    near(area_a_cell(|p| 3.0 * p.z + 0.3 * p.x), "each waits, and leans");
    near(area_a_cell(|p| p.z + waits((p - Point3::new(8.5, 8.5, 8.5)).norm() < 0.1, 5.2)), "a single cell");
    // Steps that run across the lattice, a twelfth of these cells on either side: half a cell of each pair is left out.
    let leaning = |area: f64, what: &str| assert!(area > 1.0 - 0.5 / 12.0 && area <= 1.0, "{what}: {area}");
    leaning(area_a_cell(|p| p.z + waits(p.x > p.z, 5.3)), "an overhanging step");
    leaning(area_a_cell(|p| p.z + waits(p.x + p.z > 20.0, 5.3)), "a step that leans back");
    near(area_a_cell(|p| p.z + 2.2 * ((p.x * 7.0 + p.y * 3.0).floor() % 3.0)), "columns");
}

#[test]
fn contouring_and_measuring_can_be_cancelled() {
    let rows = [1; 4];
    let cells = Cells::new([1, 1, 4], &rows).unwrap();
    let field = extend(&field_of(&cells, |p| p.z), &cells);
    for asked in 0..3 {
        let calls = AtomicUsize::new(0);
        let stop = |p: curvlay_layers::Progress| {
            assert!(p.total == 3 && p.done <= 3 && ["contour", "spacing"].contains(&p.stage));
            let is_last = calls.fetch_add(1, Ordering::Relaxed) == asked;
            if is_last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let levels = [0.5, 1.5, 2.5];
        let cancelled = contour(&field, &levels, 1.0, Point3::origin(), &stop).unwrap_err();
        assert_eq!(cancelled, ContourError::Cancelled);
        let surfaces = contour(&field, &levels, 1.0, Point3::origin(), &go).unwrap();
        calls.store(0, Ordering::Relaxed);
        assert_eq!(measure_spacing(&slices(&surfaces), 1.0, &stop).unwrap_err(), SpacingError::Cancelled);
    }
}

/// How far the points and the middles of the triangles of a surface within 8 mm of the centre lie from a shape, root of the mean square.
fn rms(surface: &Surface, distance: impl Fn(&Point3<f64>) -> f64) -> f64 {
    let middle =
        |t: &[u32; 3]| Point3::from(t.iter().map(|&v| surface.points[v as usize].coords).sum::<Vector3<f64>>() / 3.0);
    let places: Vec<Point3<f64>> = surface.triangles.iter().map(middle).chain(surface.points.iter().copied()).collect();
    (places.iter().map(|p| distance(p).powi(2)).sum::<f64>() / places.len() as f64).sqrt()
}

/// What `VertexPlacement` says of the two, measured: a box has edges and corners, a ball has none.
#[test]
fn features_are_nearer_to_the_level_at_edges_and_elsewhere() {
    let rows = rows_of([24; 3], |_| true);
    let cells = Cells::new([24; 3], &rows).unwrap();
    let centre = Point3::new(12.13, 11.81, 12.07);
    let box_like = |p: &Point3<f64>| (p - centre).amax();
    let ball_like = |p: &Point3<f64>| (p - centre).norm();
    let error = |of: &dyn Fn(&Point3<f64>) -> f64, placement| {
        let field = extend(&field_of(&cells, |p| of(&p)), &cells);
        let surfaces = contour_with(&field, &[5.3, 7.7], 1.0, Point3::origin(), placement, &go).unwrap();
        surfaces
            .iter()
            .map(|s| {
                assert!(faults(s).is_empty());
                rms(s, |p| of(p) - s.value)
            })
            .sum::<f64>()
            / 2.0
    };
    let [boxes, balls] = [&box_like as &dyn Fn(&Point3<f64>) -> f64, &ball_like]
        .map(|of| [VertexPlacement::Mean, VertexPlacement::Features].map(|placement| error(of, placement)));
    // As the docs of contouring say: 2.7 and 3.2 times.
    assert!((2.5..3.0).contains(&(boxes[0] / boxes[1])), "{boxes:?}");
    assert!((3.0..3.5).contains(&(balls[0] / balls[1])), "{balls:?}");
}
