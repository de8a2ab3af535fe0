//! Surfaces that pass through each other: counted like a twin that computes with whole numbers, and clipped.

use super::helpers::*;
use curvlay_layers::trim::{SurfaceCrossings, SurfaceSlices, TrimError, TrimmedSheet, Trimmer, count_crossings};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Surfaces with whole coordinates.
type Whole = Vec<(Vec<[i64; 3]>, Vec<[u32; 3]>)>;

fn orient(a: [i64; 3], b: [i64; 3], c: [i64; 3], d: [i64; 3]) -> i128 {
    let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k| i128::from(p[k] - a[k])));
    u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0])
}

/// What a unit is; and the step of the later surface, small against it and each of its parts against the next.
const UNIT: i64 = 1_000_000_000;
const STEP: [i64; 3] = [1_000, 1, 1_000_000];

/// All edges against all triangles, in whole numbers: the later surface is lifted by a step that is small enough.
fn slow_crossings(surfaces: &Whole) -> SurfaceCrossings {
    let mut found = SurfaceCrossings::default();
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    for (own, (points, triangles)) in surfaces.iter().enumerate() {
        let edges: BTreeSet<[u32; 2]> = triangles.iter().flat_map(|&t| sides(t)).collect();
        found.edges += edges.len();
        let crosses = |edge: &&[u32; 2]| {
            surfaces.iter().enumerate().filter(|&(other, _)| other != own).any(|(other, (corners, others))| {
                let runs = |side: [u32; 2]| others.iter().filter(|&&t| sides(t).contains(&side)).count();
                let ends = |side: [u32; 2]| runs(side) == 1;
                others.iter().any(|&t| {
                    let at = |lift: bool| {
                        let up = |p: [i64; 3], lift| [0, 1, 2].map(|k| p[k] * UNIT + if lift { STEP[k] } else { 0 });
                        let edge = edge.map(|v| up(points[v as usize], lift && own > other));
                        (edge, t.map(|v| up(corners[v as usize], lift && other > own)))
                    };
                    let signs = |lift: bool| {
                        let ([p, q], [a, b, c]) = at(lift);
                        let round = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)];
                        ([orient(a, b, c, p), orient(a, b, c, q)].map(i128::signum), round.map(i128::signum))
                    };
                    let ((lifted, round), (flat, meets)) = (signs(true), signs(false));
                    let passes = lifted[0] * lifted[1] < 0 && round[0] != 0 && round == [round[0]; 3];
                    // It ends there, or passes along a side or a corner at which the other surface ends.
                    let at_side = (0..3).any(|k| meets[k] == 0 && ends(sides(t)[k]));
                    let at_corner = (0..3).any(|k| {
                        meets[k] == 0
                            && meets[(k + 2) % 3] == 0
                            && others
                                .iter()
                                .any(|&other| sides(other).into_iter().any(|side| side.contains(&t[k]) && ends(side)))
                    });
                    passes && !flat.contains(&0) && !at_side && !at_corner
                })
            })
        };
        found.crossing += edges.iter().filter(crosses).count();
    }
    found
}

fn count(meshes: &[Mesh]) -> SurfaceCrossings {
    let slices: Vec<SurfaceSlices> = meshes.iter().map(|m| (&m.vertices[..], &m.triangles[..])).collect();
    count_crossings(&slices, &go).unwrap()
}

/// Few places, so that much touches, lies in one plane, or is the same.
fn whole_surfaces() -> impl Strategy<Value = Whole> {
    let point = [-2i64..=2, -2..=2, -2..=2];
    let surface = prop::collection::vec(point, 3..7).prop_flat_map(|points| {
        let corner = 0..points.len() as u32;
        let triangle = [corner.clone(), corner.clone(), corner];
        let triangle = triangle.prop_filter("three corners", |[a, b, c]| a != b && b != c && c != a);
        (Just(points), prop::collection::vec(triangle, 0..6))
    });
    prop::collection::vec(surface, 0..5)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn crossings_are_those_of_the_slow_twin(surfaces in whole_surfaces()) {
        let place = |p: &[i64; 3]| P::from(p.map(|c| c as f64));
        let mesh = |(points, triangles): &(Vec<[i64; 3]>, Vec<[u32; 3]>)| {
            Mesh { vertices: points.iter().map(place).collect(), triangles: triangles.clone() }
        };
        let meshes: Vec<Mesh> = surfaces.iter().map(mesh).collect();
        prop_assert_eq!(count(&meshes), slow_crossings(&surfaces));
    }
}

/// Sheets over a square of 12 mm around the origin, trimmed to a block of 8 x 8 x 10 mm, in their order.
fn trimmed(heights: &[&dyn Fn(f64, f64) -> f64], cells: u32) -> (Trimmer, Vec<TrimmedSheet>) {
    let block = cuboid([-4.0, -4.0, 0.0], [4.0, 4.0, 10.0]);
    let sheets = heights.iter().map(|height| trim(&block, &field(6.0, cells, height))).collect();
    (block.trimmer(), sheets)
}

fn mesh_of(sheet: &TrimmedSheet) -> Mesh {
    Mesh { vertices: sheet.vertices.clone(), triangles: sheet.triangles.clone() }
}

#[test]
fn a_leaning_sheet_ends_where_it_meets_the_one_before() {
    // The plane z = 5, and one that meets it at x = 1, within its triangles.
    let (trimmer, mut sheets) = trimmed(&[&|_, _| 5.0, &|x, _| 4.9 + 0.1 * x], 9);
    let before = sheets.clone();
    let clipped = trimmer.clip(&mut sheets, 2.0, &go).unwrap();
    assert_eq!(clipped.found, count(&before.iter().map(mesh_of).collect::<Vec<_>>()));
    assert!(clipped.found.crossing > 0);
    assert_eq!(count(&sheets.iter().map(mesh_of).collect::<Vec<_>>()), clipped.left);
    assert_eq!((clipped.left.crossing, clipped.surfaces), (0, 1));
    assert_eq!(sheets[0], before[0], "the earlier one stays");
    let slope = 1.01_f64.sqrt();
    assert!((sheets[1].area() - 24.0 * slope).abs() < 1e-9, "{}", sheets[1].area());
    assert!((clipped.area_mm2 - 40.0 * slope).abs() < 1e-9);
    assert!(sheets[1].vertices.iter().all(|p| p.x > 1.0 - 1e-9));
    // Its end at the other is its own border, the rest still on the block.
    assert!((sheets[1].border_mm - 8.0).abs() < 1e-9 && (sheets[1].mesh_mm - 8.0 - 6.0 * slope).abs() < 1e-9);
    assert!(sheets[1].error_mm < 1e-9);
}

#[test]
fn only_what_lies_below_is_taken_where_the_cut_ends_within_the_sheet() {
    // A narrow strip at z = 5 within the block; a sheet dips below it, and beside it where there is nothing.
    let block = cuboid([-4.0, -4.0, 0.0], [4.0, 4.0, 10.0]);
    let strip = grid([8, 2], [false; 2], |u, v| P::new(12.0 * u - 6.0, 2.0 * v - 1.0, 5.0));
    let dip = |x: f64, _: f64| 5.0 + (x.abs() - 2.0) * 0.4;
    let mut sheets = vec![trim(&block, &strip), trim(&block, &field(6.0, 24, dip))];
    let before = sheets[1].area();
    let clipped = block.trimmer().clip(&mut sheets, 1.0, &go).unwrap();
    // 4 mm along x, of a slope of 0.4, by the 2 mm of the strip.
    let below = 8.0 * 1.16_f64.sqrt();
    assert!((before - sheets[1].area() - clipped.area_mm2).abs() < 1e-9);
    assert!((clipped.area_mm2 - below).abs() < 0.25 * below, "{} of {below} mm2", clipped.area_mm2);
    assert!(clipped.left.crossing * 4 < clipped.found.crossing, "{clipped:?}");
}

#[test]
fn a_sheet_is_clipped_to_what_is_left_of_those_before() {
    // The second loses its left half. The third lies between the first and what the second was there: it stays whole.
    let (trimmer, mut sheets) =
        trimmed(&[&|_, _| 5.0, &|x, _| 5.0 + 0.5 * x, &|x, _| if x < -2.0 { 5.2 } else { 5.2 + 0.6 * (x + 2.0) }], 12);
    let third = sheets[2].clone();
    let clipped = trimmer.clip(&mut sheets, 1.0, &go).unwrap();
    assert_eq!(clipped.left.crossing, 0);
    assert_eq!(sheets[2], third);
}

#[test]
fn sheets_that_do_not_cross_stay_as_they_are() {
    let (trimmer, mut sheets) = trimmed(&[&|_, _| 3.0, &|_, _| 3.0, &|x, y| 4.0 + 0.05 * x * y, &|_, _| 7.0], 6);
    let before = sheets.clone();
    let clipped = trimmer.clip(&mut sheets, 1.0, &go).unwrap();
    assert_eq!((clipped.found.crossing, clipped.surfaces, clipped.area_mm2), (0, 0, 0.0));
    assert_eq!(sheets, before);
    assert_eq!(trimmer.clip(&mut [], 1.0, &go).unwrap().found, SurfaceCrossings::default());
}

#[test]
fn bad_surfaces_and_cancelling_are_reported() {
    let cube = cuboid([0.0; 3], [4.0; 3]);
    let slices: [SurfaceSlices; 1] = [(&cube.vertices, &cube.triangles)];
    assert_eq!(count_crossings(&slices, &|_| ControlFlow::Break(())), Err(TrimError::Cancelled));
    let mut bad = cube.clone();
    bad.vertices[2].z = f64::NAN;
    assert!(matches!(count_crossings(&[(&bad.vertices, &bad.triangles)], &go), Err(TrimError::BadCoordinate { .. })));
    bad.triangles[1][2] = 99;
    bad.vertices[2].z = 0.0;
    assert!(matches!(count_crossings(&[(&bad.vertices, &bad.triangles)], &go), Err(TrimError::BadCorner { .. })));
    let (trimmer, mut sheets) = trimmed(&[&|_, _| 5.0, &|x, _| 5.0 + 0.5 * x], 8);
    assert_eq!(trimmer.clip(&mut sheets, 1.0, &|_| ControlFlow::Break(())), Err(TrimError::Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Rough sheets at the same places over a square: what is left of each lies above those before, and none crosses another.
    #[test]
    fn what_is_left_lies_in_order(
        bumps in prop::collection::vec([-0.6..0.6f64, -0.6..0.6, 0.5..2.0, 0.5..2.0, -3.0..3.0, -3.0..3.0], 2..5),
        cells in 3u32..14,
    ) {
        let heights: Vec<_> = bumps.iter().zip(0..).map(|(&[a, b, p, q, s, t], k)| move |x: f64, y: f64| {
            5.0 + 0.5 * f64::from(k) + a * (p * x + s).sin() + b * (q * y + t).sin()
        }).collect();
        let dynamic: Vec<&dyn Fn(f64, f64) -> f64> = heights.iter().map(|h| h as &dyn Fn(f64, f64) -> f64).collect();
        let (trimmer, mut sheets) = trimmed(&dynamic, cells);
        let before = sheets.clone();
        let clipped = trimmer.clip(&mut sheets, 1.0, &go).unwrap();
        prop_assert!(clipped.left.crossing <= clipped.found.crossing / 8, "{:?}", clipped);
        let mut taken = 0.0;
        for (sheet, was) in sheets.iter().zip(&before) {
            prop_assert!(sheet.sources.iter().all(|&source| (source as usize) < 2 * (cells * cells) as usize));
            taken += was.area() - sheet.area();
            let mut sides = BTreeSet::new();
            for &[a, b, c] in &sheet.triangles {
                prop_assert!(sides.insert([a, b]) && sides.insert([b, c]) && sides.insert([c, a]));
            }
        }
        prop_assert!((taken - clipped.area_mm2).abs() < 1e-6);
    }
}
