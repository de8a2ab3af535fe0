//! Meshes of known state, exact oracles for crossings and topology, and the shared models.

#![expect(clippy::float_cmp, reason = "sums of small integers are exact")]

use curvlay_voxel::inspect::{InspectError, MeshReport, Orientation, inspect, thinner_than};
use curvlay_voxel::nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A box; its corners are numbered by bits: x in bit 0, y in bit 1, z in bit 2.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |at: u32| Point3::from([0, 1, 2].map(|k| if at >> k & 1 == 1 { high[k] } else { low[k] }));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

fn cube(low: f64, high: f64) -> Mesh {
    cuboid([low; 3], [high; 3])
}

fn flipped((vertices, triangles): Mesh) -> Mesh {
    (vertices, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect())
}

fn joined(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    meshes.into_iter().fold((Vec::new(), Vec::new()), |(mut vertices, mut triangles), (more, faces)| {
        let first = vertices.len() as u32;
        triangles.extend(faces.iter().map(|t| t.map(|corner| corner + first)));
        vertices.extend(more);
        (vertices, triangles)
    })
}

fn report((vertices, triangles): &Mesh) -> MeshReport {
    inspect(vertices, triangles).unwrap()
}

/// Each triangle with its own three vertices, as in an STL file.
fn soup((vertices, triangles): &Mesh) -> Mesh {
    let corners = triangles.iter().flatten().map(|&at| vertices[at as usize]).collect();
    (corners, (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

#[test]
fn a_cube_is_sound_welded_or_not() {
    let welded = report(&cube(-0.0, 2.0));
    assert!(welded.is_sound(), "{welded}");
    assert_eq!((welded.triangles, welded.vertices, welded.euler, welded.components), (12, 8, 2, 1));
    assert_eq!((welded.signed_volume_mm3, welded.area_mm2, welded.size_mm()), (8.0, 24.0, [2.0; 3]));
    assert_eq!(report(&soup(&cube(0.0, 2.0))), welded);
    assert_eq!(
        welded.to_string(),
        "12 triangles, 1 part, 2.0000 x 2.0000 x 2.0000 mm, volume 8.0000 mm3, area 24.000 mm2\n\
         sound: closed, faces outwards, no crossings"
    );
}

#[test]
fn minus_zero_is_zero() {
    let (mut vertices, triangles) = soup(&cube(0.0, 1.0));
    for point in vertices.iter_mut().step_by(2) {
        *point = point.map(|x| if x == 0.0 { -0.0 } else { x });
    }
    assert_eq!(report(&(vertices, triangles)).vertices, 8);
}

#[test]
fn an_open_cube_has_one_hole() {
    let (vertices, mut triangles) = cube(0.0, 1.0);
    triangles.drain(2..4); // the top
    let open = report(&(vertices, triangles));
    assert!(!open.watertight && !open.is_sound());
    assert_eq!((open.open_edges.count, open.holes, open.open_length_mm, open.euler), (4, 1, 4.0, 1));
    let hole = open.largest_hole.unwrap();
    assert_eq!((hole.edges, hole.length_mm, hole.at.z), (4, 4.0, 1.0));
    assert_eq!(open.open_edges.first[0].at.z, 1.0);
    // The cone over a flat rim is its lid.
    assert_eq!((open.orientation, open.signed_volume_mm3), (Orientation::Outward, 1.0));
    assert!(open.to_string().contains("not closed: 4 open edges round 1 hole, 4.0000 mm in all"), "{open}");
}

#[test]
fn a_flipped_cube_looks_inwards() {
    let inward = report(&flipped(cube(0.0, 1.0)));
    assert_eq!((inward.orientation, inward.signed_volume_mm3, inward.volume_mm3()), (Orientation::Inward, -1.0, 1.0));
    assert!(inward.watertight && !inward.is_sound());
    assert!(inward.to_string().contains("inside out"));
}

#[test]
fn a_flipped_triangle_disagrees_with_its_three_neighbours() {
    let (vertices, mut triangles) = cube(0.0, 1.0);
    triangles[5].swap(0, 1);
    let mixed = report(&(vertices, triangles));
    assert_eq!((mixed.inconsistent_edges.count, mixed.orientation), (3, Orientation::Mixed));
    assert!(mixed.watertight && mixed.inconsistent_edges.first.iter().any(|place| place.triangle == 5));
}

#[test]
fn a_skin_that_looks_inwards_is_a_cavity_only_in_a_solid() {
    let cases = [
        (vec![cube(0.0, 9.0), flipped(cube(3.0, 6.0))], Orientation::Outward, 1),
        (vec![cube(0.0, 9.0), cube(3.0, 6.0)], Orientation::Outward, 0),
        (vec![flipped(cube(0.0, 9.0)), cube(3.0, 6.0)], Orientation::Inward, 0),
        (vec![flipped(cube(0.0, 9.0)), flipped(cube(3.0, 6.0))], Orientation::Inward, 0),
        (vec![cube(0.0, 9.0), flipped(cube(10.0, 12.0))], Orientation::Mixed, 0),
        (vec![cube(0.0, 9.0), flipped(cube(3.0, 6.0)), cube(4.0, 5.0)], Orientation::Outward, 1),
        (vec![cube(0.0, 9.0), flipped(cube(3.0, 6.0)), flipped(cube(4.0, 5.0))], Orientation::Mixed, 1),
        (vec![cube(0.0, 9.0), flipped(cube(1.0, 3.0)), flipped(cube(4.0, 5.0))], Orientation::Outward, 2),
    ];
    for (number, (parts, orientation, cavities)) in cases.into_iter().enumerate() {
        let components = parts.len();
        let found = report(&joined(parts));
        assert_eq!((found.orientation, found.cavities), (orientation, cavities), "case {number}");
        assert_eq!((found.components, found.crossings.count, found.touching.count), (components, 0, 0));
    }
    let hollow = report(&joined([cube(0.0, 9.0), flipped(cube(3.0, 6.0))]));
    assert!(hollow.is_sound() && hollow.signed_volume_mm3 == 729.0 - 27.0, "{hollow}");
}

#[test]
fn a_moebius_strip_has_one_rim_and_no_outside() {
    let count = 12u32;
    let at = |k: u32, side: f64| {
        let turn = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let radius = 3.0 + side * (turn / 2.0).cos();
        Point3::new(radius * turn.cos(), radius * turn.sin(), side * (turn / 2.0).sin())
    };
    let vertices = (0..count).flat_map(|k| [at(k, -1.0), at(k, 1.0)]).collect();
    let triangles = (0..count).flat_map(|k| {
        let [a, b] = [2 * k, 2 * k + 1];
        let [c, d] = if k + 1 == count { [1, 0] } else { [2 * k + 2, 2 * k + 3] };
        [[a, c, b], [b, c, d]]
    });
    let strip = report(&(vertices, triangles.collect()));
    assert_eq!((strip.euler, strip.holes, strip.open_edges.count), (0, 1, 24));
    assert_eq!((strip.inconsistent_edges.count, strip.crossings.count), (1, 0));
    assert_eq!(strip.orientation, Orientation::Mixed);
}

#[test]
fn a_flat_sheet_encloses_nothing() {
    let vertices = vec![Point3::new(0.0, 0.0, 1.0), Point3::new(1.0, 0.0, 1.0), Point3::new(0.0, 1.0, 1.0)];
    let sheet = report(&(vertices, vec![[0, 1, 2]]));
    assert_eq!((sheet.orientation, sheet.open_edges.count, sheet.euler), (Orientation::Undecided, 3, 1));
}

#[test]
fn cubes_may_share_an_edge_or_a_corner() {
    let edge = report(&joined([cube(0.0, 1.0), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])]));
    assert_eq!((edge.non_manifold_edges.count, edge.inconsistent_edges.count, edge.components), (1, 0, 1));
    assert_eq!((edge.vertices, edge.euler, edge.crossings.count, edge.touching.count), (14, 3, 0, 0));
    assert!(edge.is_sound(), "{edge}");
    let corner = report(&joined([cube(0.0, 1.0), cube(1.0, 2.0)]));
    assert_eq!((corner.vertices, corner.components, corner.euler, corner.touching.count), (15, 2, 3, 0));
    assert!(corner.is_sound(), "{corner}");
}

#[test]
fn cubes_that_pass_through_each_other_cross() {
    let pair = joined([cube(0.0, 4.0), cuboid([1.0, 1.0, 1.0], [3.0, 2.0, 7.0])]);
    let crossing = report(&pair);
    let expected = slow_contacts(&pair);
    assert!(crossing.crossings.count > 0);
    assert_eq!([crossing.crossings.count, crossing.touching.count], expected);
    assert_eq!((crossing.orientation, crossing.components), (Orientation::Outward, 2));
    assert!(!crossing.is_sound() && crossing.contacts_complete);
    let first = crossing.crossings.first[0];
    assert!(first.triangle < 12 && first.other.is_some_and(|other| other >= 12));
    assert!(crossing.crossings.first.is_sorted_by_key(|place| (place.triangle, place.other)));
}

#[test]
fn cubes_that_stand_on_each_other_only_touch() {
    let pile = joined([cube(0.0, 4.0), cuboid([1.0, 1.0, 4.0], [2.0, 2.0, 5.0])]);
    let touching = report(&pile);
    assert_eq!([touching.crossings.count, touching.touching.count], slow_contacts(&pile));
    assert_eq!(touching.crossings.count, 0);
    assert!(touching.touching.count > 0 && touching.is_sound());
}

#[test]
fn a_corner_at_a_face_is_distinguished_to_the_last_bit() {
    for (tip, expected) in [(1e-60, [0, 0]), (0.0, [0, 1]), (-1e-60, [1, 0])] {
        let corners =
            [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, tip], [1.0, 2.0, 5.0], [2.0, 1.0, 5.0]];
        let found = report(&(corners.map(Point3::from).to_vec(), vec![[0, 1, 2], [3, 4, 5]]));
        assert_eq!([found.crossings.count, found.touching.count], expected, "{tip}");
    }
}

/// A cube in which a corner of the front lies in the middle of an edge of the top, with or without the sliver that
/// fills the slit.
fn torn_cube(sliver: bool) -> Mesh {
    let (mut vertices, mut triangles) = cube(0.0, 2.0);
    vertices.push(Point3::new(1.0, 0.0, 2.0));
    let split = triangles.iter().position(|&t| t == [0, 5, 4]).unwrap();
    triangles.remove(split);
    triangles.extend([[0, 5, 8], [0, 8, 4]]);
    if sliver {
        // The top runs from 4 to 5.
        triangles.push([5, 4, 8]);
    }
    (vertices, triangles)
}

#[test]
fn a_sliver_may_close_a_slit() {
    let torn = report(&torn_cube(false));
    assert_eq!((torn.open_edges.count, torn.crossings.count, torn.zero_area.count), (3, 0, 0));
    assert!(!torn.watertight && torn.touching.count > 0);
    let closed = report(&torn_cube(true));
    assert_eq!((closed.open_edges.count, closed.zero_area.count, closed.euler, closed.components), (0, 1, 2, 1));
    assert!(closed.watertight && closed.orientation == Orientation::Outward, "{closed}");
    assert_eq!(closed.signed_volume_mm3, 8.0);
}

#[test]
fn slivers_that_close_nothing_are_counted_and_left_out() {
    let (mut vertices, mut triangles) = cube(0.0, 1.0);
    vertices.extend([[0.5, 0.5, 0.5], [0.625, 0.625, 0.625], [0.75, 0.75, 0.75], [0.5, 0.5, 3.0]].map(Point3::from));
    // On a line by the bits (0.1, 0.2, 0.3 need not be); twice the same corner; an edge of the cube.
    triangles.extend([[8, 9, 10], [8, 8, 11], [0, 1, 1]]);
    let found = report(&(vertices, triangles));
    assert_eq!((found.zero_area.count, found.components, found.euler, found.vertices), (3, 1, 2, 8));
    assert!(found.watertight && found.crossings.count == 0);
    assert_eq!(found.zero_area.first.iter().map(|place| place.triangle).collect::<Vec<_>>(), [12, 13, 14]);
    assert!(found.to_string().contains("3 triangles without area (first: triangle 12 near"));
}

#[test]
fn repeats_are_left_out_and_pairs_back_to_back_are_not() {
    let (vertices, mut triangles) = cube(0.0, 1.0);
    let [a, b, c] = triangles[7];
    triangles.extend([[b, c, a], [c, a, b]]);
    let found = report(&(vertices.clone(), triangles.clone()));
    assert_eq!((found.repeated.count, found.opposed.count, found.non_manifold_edges.count), (2, 0, 0));
    assert_eq!((found.repeated.first[0].triangle, found.repeated.first[0].other), (12, Some(7)));
    assert!(found.watertight && found.signed_volume_mm3 == 1.0);
    triangles.push([b, a, c]);
    let found = report(&(vertices, triangles));
    assert_eq!((found.repeated.count, found.opposed.count, found.non_manifold_edges.count), (2, 1, 3));
    assert_eq!((found.opposed.first[0].triangle, found.opposed.first[0].other), (7, Some(14)));
}

#[test]
fn unusable_meshes_are_refused() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    assert_eq!(inspect(&corners, &[]), Err(InspectError::NoTriangles));
    assert_eq!(inspect(&[], &[]), Err(InspectError::NoTriangles));
    let missing = InspectError::NoSuchVertex { triangle: 1, vertex: 3, vertices: 3 };
    assert_eq!(inspect(&corners, &[[0, 1, 2], [1, 2, 3]]), Err(missing));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2e60] {
        let mut corners = corners;
        corners[2].y = bad;
        let refused = inspect(&corners, &[[0, 1, 2]]);
        assert!(matches!(refused, Err(InspectError::Coordinate { triangle: 0, vertex: 2, .. })), "{bad}");
    }
    for width_mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(thinner_than(&corners, &[[0, 1, 2]], width_mm), Err(InspectError::Width { .. })));
    }
    assert_eq!(thinner_than(&corners, &[], 1.0), Err(InspectError::NoTriangles));
    // The largest and the smallest coordinates still make a cube.
    for size in [1e60, 1e-80] {
        assert!(report(&cube(-size, size)).is_sound(), "{size}");
    }
}

#[test]
fn a_heap_of_triangles_ends_the_search() {
    // Every pair of boxes overlaps: 12.5 million of them.
    let count = 5_000u32;
    let vertices = (0..count).flat_map(|k| {
        let z = f64::from(k);
        [[0.0, 0.0, z], [1.0, 0.0, -z - 1.0], [0.0, 1.0, z + 0.5]].map(Point3::from)
    });
    let heap = (vertices.collect(), (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect());
    let found = report(&heap);
    assert!(!found.contacts_complete && found.crossings.first.len() == 8);
    assert!(found.to_string().contains("at least"), "{found}");
}

/// Exact points of the oracle: `[x, y, z] / w` with `w > 0`.
type Exact = [i128; 4];

fn integer_point(p: &Point3<f64>) -> [i128; 3] {
    [p.x as i128, p.y as i128, p.z as i128]
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The part of a convex polygon (or segment, or point) with `normal . x >= offset`.
fn clipped(polygon: &[Exact], normal: [i128; 3], offset: i128) -> Vec<Exact> {
    let height = |p: &Exact| dot(normal, [p[0], p[1], p[2]]) - offset * p[3];
    let mut kept = Vec::new();
    for (k, p) in polygon.iter().enumerate() {
        let q = &polygon[(k + 1) % polygon.len()];
        let (hp, hq) = (height(p), height(q));
        if hp >= 0 {
            kept.push(*p);
        }
        if hp.signum() * hq.signum() < 0 {
            let at: Exact = [0, 1, 2, 3].map(|k| (p[k] * hq - q[k] * hp) * (hq - hp).signum());
            let divisor = at.iter().fold(0, |a, &b| gcd(a, b.abs()));
            kept.push(at.map(|x| x / divisor));
        }
    }
    kept
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Pairs of triangles of a mesh on integer points that cross, and that touch: the second triangle is cut to the plane
/// of the first and to the inner side of its edges, in rational numbers, and what is left is compared with what they
/// share.
fn slow_contacts((vertices, triangles): &Mesh) -> [usize; 2] {
    let corners: Vec<[[i128; 3]; 3]> =
        triangles.iter().map(|t| t.map(|corner| integer_point(&vertices[corner as usize]))).collect();
    let mut known = BTreeSet::new();
    let sound: Vec<_> = corners
        .into_iter()
        .filter(|&[a, b, c]| cross(minus(b, a), minus(c, a)) != [0; 3])
        .filter(|&[a, b, c]| known.insert([[a, b, c], [b, c, a], [c, a, b]].into_iter().min()))
        .collect();
    let mut counts = [0, 0];
    for (k, a) in sound.iter().enumerate() {
        for b in &sound[k + 1..] {
            let shared: Vec<[i128; 3]> = a.iter().filter(|corner| b.contains(corner)).copied().collect();
            let normal = cross(minus(a[1], a[0]), minus(a[2], a[0]));
            let mut left: Vec<Exact> = b.iter().map(|&[x, y, z]| [x, y, z, 1]).collect();
            left = clipped(&left, normal, dot(normal, a[0]));
            left = clipped(&left, normal.map(|x| -x), -dot(normal, a[0]));
            for edge in 0..3 {
                let inward = cross(normal, minus(a[(edge + 1) % 3], a[edge]));
                left = clipped(&left, inward, dot(inward, a[edge]));
            }
            // A point p / w lies on the shared corner or edge if p - w u is zero, or along the edge.
            let beyond = |p: &Exact| {
                let from = |u: [i128; 3]| [0, 1, 2].map(|k| p[k] - p[3] * u[k]);
                match shared[..] {
                    [] => true,
                    [u] => from(u) != [0; 3],
                    [u, v] => cross(from(u), minus(v, u)) != [0; 3],
                    _ => false,
                }
            };
            if left.iter().any(beyond) {
                let reaches_through = |plane: &[[i128; 3]; 3], of: &[[i128; 3]; 3]| {
                    let normal = cross(minus(plane[1], plane[0]), minus(plane[2], plane[0]));
                    let heights = of.map(|corner| dot(normal, minus(corner, plane[0])).signum());
                    heights.contains(&1) && heights.contains(&-1)
                };
                counts[usize::from(!(reaches_through(a, b) && reaches_through(b, a)))] += 1;
            }
        }
    }
    counts
}

fn integer_soup(side: i32, most: usize) -> impl Strategy<Value = Mesh> {
    let corner = prop::array::uniform3(0..=side).prop_map(|at| Point3::from(at.map(f64::from)));
    prop::collection::vec(corner, 6..=3 * most).prop_map(|corners| {
        let count = corners.len() as u32 / 3;
        (corners, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
    })
}

/// Counts at the edges, the slow way: `[open, non-manifold, inconsistent]`, and whether all are even.
fn slow_edges(triangles: &[[u32; 3]]) -> ([usize; 3], bool) {
    let mut uses: BTreeMap<[u32; 2], Vec<bool>> = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]];
            uses.entry([a.min(b), a.max(b)]).or_default().push(a < b);
        }
    }
    let count = |what: &dyn Fn(&Vec<bool>) -> bool| uses.values().filter(|ways| what(ways)).count();
    let uneven =
        |ways: &Vec<bool>| ways.len().is_multiple_of(2) && 2 * ways.iter().filter(|&&way| way).count() != ways.len();
    let found = [count(&|ways| ways.len() == 1), count(&|ways| ways.len() > 2), count(&uneven)];
    (found, uses.values().all(|ways| ways.len().is_multiple_of(2)))
}

/// Parts that hang together by edges, by painting.
fn slow_parts(triangles: &[[u32; 3]]) -> usize {
    let mut left: BTreeSet<usize> = (0..triangles.len()).collect();
    let mut parts = 0;
    while let Some(first) = left.pop_first() {
        parts += 1;
        let mut front = vec![first];
        while let Some(at) = front.pop() {
            let shares_edge =
                |&&t: &&usize| triangles[t].iter().filter(|corner| triangles[at].contains(corner)).count() >= 2;
            let next: Vec<usize> = left.iter().filter(shares_edge).copied().collect();
            next.iter().for_each(|t| {
                left.remove(t);
            });
            front.extend(next);
        }
    }
    parts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn contacts_agree_with_rational_clipping_where_all_is_degenerate(mesh in integer_soup(3, 9)) {
        let found = report(&mesh);
        prop_assert_eq!([found.crossings.count, found.touching.count], slow_contacts(&mesh));
    }

    #[test]
    fn contacts_agree_with_rational_clipping_in_general(mesh in integer_soup(20, 16)) {
        let found = report(&mesh);
        prop_assert_eq!([found.crossings.count, found.touching.count], slow_contacts(&mesh));
    }

    #[test]
    fn topology_agrees_with_counting(picked in prop::collection::vec(prop::array::uniform3(0u32..7), 1..25)) {
        // Points on the curve (t, t^2, t^3): no three on a line.
        let vertices: Vec<_> = (0..7).map(|t| Point3::from([1, 2, 3].map(|power| f64::from(t).powi(power)))).collect();
        let found = report(&(vertices, picked.clone()));
        let collapsed = picked.iter().filter(|[a, b, c]| a == b || b == c || c == a).count();
        prop_assert_eq!(found.zero_area.count, collapsed);
        let mut known = BTreeSet::new();
        let kept: Vec<[u32; 3]> = picked
            .into_iter()
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .filter(|&[a, b, c]| known.insert([[a, b, c], [b, c, a], [c, a, b]].into_iter().min()))
            .collect();
        prop_assert_eq!(found.repeated.count, found.triangles - collapsed - kept.len());
        let (counts, even) = slow_edges(&kept);
        let edges = [&found.open_edges, &found.non_manifold_edges, &found.inconsistent_edges];
        prop_assert_eq!(edges.map(|finding| finding.count), counts);
        prop_assert_eq!(found.watertight, even && !kept.is_empty());
        prop_assert_eq!(found.components, slow_parts(&kept));
        let corners: BTreeSet<u32> = kept.iter().flatten().copied().collect();
        let ends: BTreeSet<[u32; 2]> = kept
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        prop_assert_eq!(found.euler, corners.len() as i64 - ends.len() as i64 + kept.len() as i64);
    }

    #[test]
    fn nested_skins_are_judged_by_what_is_around_them(turned in prop::collection::vec(any::<bool>(), 1..7)) {
        // Skins from the outermost inwards; winding number from -1 to -1 step by step.
        let skins = turned.iter().enumerate().map(|(k, &turned)| {
            let skin = cube(k as f64, 20.0 - k as f64);
            if turned { flipped(skin) } else { skin }
        });
        let found = report(&joined(skins));
        let (mut outside, mut levels, mut cavities) = (0, Vec::new(), 0);
        for &turned in &turned {
            let inside = outside + if turned { -1 } else { 1 };
            cavities += usize::from(outside == 1 && inside == 0);
            levels.extend([outside, inside]);
            outside = inside;
        }
        let expected = match (levels.iter().any(|&w| w > 0), levels.iter().any(|&w| w < 0)) {
            (true, true) => Orientation::Mixed,
            (true, false) => Orientation::Outward,
            _ => Orientation::Inward,
        };
        prop_assert_eq!((found.orientation, found.cavities), (expected, cavities));
    }

    #[test]
    fn order_turns_and_motions_change_nothing(
        seeds in prop::collection::vec(any::<u32>(), 24),
        angles in prop::array::uniform3(-3.0..3.0),
        shift in prop::array::uniform3(-50.0..50.0),
        scale in 0.01..100.0,
    ) {
        let (vertices, triangles) = joined([cube(0.0, 4.0), flipped(cuboid([1.0; 3], [3.0, 2.0, 3.5]))]);
        let before = report(&(vertices.clone(), triangles.clone()));
        let motion = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let moved: Vec<_> = vertices.iter().map(|p| motion * p * scale + Vector3::from(shift)).collect();
        let mut order: Vec<(u32, [u32; 3])> = seeds.iter().copied().zip(triangles).collect();
        order.sort();
        let shuffled: Vec<[u32; 3]> = order.iter().map(|&(seed, [a, b, c])| match seed % 3 {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        }).collect();
        let after = report(&(moved, shuffled));
        let reported = |report: &MeshReport| {
            (report.is_sound(), report.orientation, report.components, report.cavities, report.euler, report.vertices)
        };
        prop_assert_eq!(reported(&after), reported(&before));
        // What rounding to the grid around the shifted mesh may cost.
        let rounding = 1e-13 * (1.0 + 50.0 / scale);
        prop_assert!((after.signed_volume_mm3 / scale.powi(3) / before.signed_volume_mm3 - 1.0).abs() < rounding);
        prop_assert!((after.area_mm2 / scale.powi(2) / before.area_mm2 - 1.0).abs() < rounding);
    }
}

#[test]
fn the_thin_end_of_a_wedge_is_as_long_as_its_angle_says() {
    // Section: a right triangle with legs of 10 (along x) and 5 (along z, at x = 10), the sharp end at the origin.
    let section = [[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]];
    let depth = 40.0;
    let vertices: Vec<_> = [0.0, depth].iter().flat_map(|&y| section.map(|[x, z]| Point3::new(x, y, z))).collect();
    let triangles = [[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [2, 5, 3], [2, 3, 0]];
    let wedge = report(&(vertices.clone(), triangles.to_vec()));
    assert!(wedge.is_sound(), "{wedge}");
    let width = 1.0;
    let found = thinner_than(&vertices, &triangles, width).unwrap();
    // Bottom: straight up x / 2 is left. Slope: at s along it, s / 2, but near its upper end the back is nearer. Back:
    // 10 - 2 z.
    let slope = 125.0f64.sqrt();
    let thin = 2.0 * width + (2.0 * width + 0.5 * width) + 0.5 * width;
    let expected = depth * thin / (2.0 * 25.0 + depth * (10.0 + 5.0 + slope));
    assert!((found.share - expected).abs() < 0.01, "{} is not {expected}", found.share);
    let inside_out: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(thinner_than(&vertices, &inside_out, width).unwrap().share, found.share);
}

#[test]
fn a_ball_is_as_thick_as_its_diameter() {
    // Octahedron, its triangles cut in four five times, on the sphere of radius 5.
    let mut faces: Vec<[Vector3<f64>; 3]> = Vec::new();
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    for (a, b) in [(x, y), (y, -x), (-x, -y), (-y, x)] {
        faces.extend([[a, b, z], [b, a, -z]]);
    }
    for _ in 0..5 {
        let middle = |a: &Vector3<f64>, b: &Vector3<f64>| (a + b).normalize();
        let cut = |[a, b, c]: &[Vector3<f64>; 3]| {
            let [u, v, w] = [middle(a, b), middle(b, c), middle(c, a)];
            [[*a, u, w], [u, *b, v], [w, v, *c], [u, v, w]]
        };
        faces = faces.iter().flat_map(cut).collect();
    }
    let vertices: Vec<_> = faces.iter().flatten().map(|&corner| Point3::from(corner * 5.0)).collect();
    let triangles: Vec<_> = (0..faces.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let ball = report(&(vertices.clone(), triangles.clone()));
    assert!(ball.is_sound() && ball.euler == 2 && ball.vertices == 4098, "{ball}");
    assert_eq!(thinner_than(&vertices, &triangles, 9.8).unwrap().share, 0.0);
    let found = thinner_than(&vertices, &triangles, 10.0).unwrap();
    assert!(found.share > 0.999, "{found:?}");
    assert!(found.thinnest.is_some_and(|(thickness, _)| thickness > 9.9));
}

/// A folder of models beside the workspace.
fn shared(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name)
}

fn read_stl(path: &std::path::Path) -> Mesh {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap());
    let corner = |t: usize, k: usize| 84 + 50 * t + 12 + 12 * k;
    let vertices = (0..count as usize)
        .flat_map(|t| [0, 1, 2].map(|k| corner(t, k)))
        .map(|at| Point3::new(number(at), number(at + 4), number(at + 8)))
        .collect();
    (vertices, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where that folder exists"]
fn the_models_are_as_their_manifest_says() {
    let folder = shared("models");
    let text = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
    for model in manifest["models"].as_array().unwrap() {
        let name = model["file"].as_str().unwrap();
        let found = report(&read_stl(&folder.join(name)));
        let number = |key: &str| model[key].as_i64().unwrap();
        let reported = [found.triangles, found.vertices, found.components, found.cavities].map(|n| n as i64);
        assert_eq!(reported, ["triangles", "vertices", "components", "cavities"].map(number), "{name}\n{found}");
        assert_eq!(found.euler, number("euler"), "{name}");
        assert_eq!(found.crossings.count as i64, number("self_intersecting_faces"), "{name}\n{found}");
        assert!(found.is_sound(), "{name}\n{found}");
        let [volume, area] = ["volume_mm3", "area_mm2"].map(|key| model[key].as_f64().unwrap());
        assert!((found.signed_volume_mm3 / volume - 1.0).abs() < 1e-5, "{name}: {}", found.signed_volume_mm3);
        assert!((found.area_mm2 / area - 1.0).abs() < 1e-5, "{name}: {}", found.area_mm2);
    }
}

#[test]
#[ignore = "needs ../shared/bad-models; .ci/run runs it where that folder exists"]
fn each_bad_model_is_reported_by_its_fault() {
    let folder = shared("bad-models");
    let found = |name: &str| report(&read_stl(&folder.join(name)));
    let hole = found("hole.stl");
    assert!(!hole.watertight && hole.open_edges.count > 0 && hole.holes == 1, "{hole}");
    assert_eq!((hole.orientation, hole.crossings.count), (Orientation::Outward, 0));
    let crossing = found("self-intersecting.stl");
    assert!(crossing.watertight && crossing.crossings.count > 0, "{crossing}");
    assert_eq!((crossing.components, crossing.orientation), (3, Orientation::Outward));
    let slivers = found("zero-area.stl");
    assert_eq!((slivers.zero_area.count, slivers.watertight, slivers.euler), (120, true, 2), "{slivers}");
    let inward = found("inside-out.stl");
    assert_eq!((inward.orientation, inward.watertight), (Orientation::Inward, true), "{inward}");
    let (vertices, triangles) = read_stl(&folder.join("nan-coords.stl"));
    assert!(matches!(inspect(&vertices, &triangles), Err(InspectError::Coordinate { .. })));
    for name in ["solid-header.stl", "metres.stl"] {
        assert!(found(name).is_sound(), "{name}");
    }
}

#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where that folder exists"]
fn walls_of_the_models_are_found_at_their_thickness() {
    let folder = shared("models");
    let share = |name: &str, width: f64| {
        let (vertices, triangles) = read_stl(&folder.join(name));
        thinner_than(&vertices, &triangles, width).unwrap().share
    };
    // The shell is 2.8 mm thick on most of its surface.
    let shell = [2.0, 2.5, 3.2].map(|width| share("bunny-hollow.stl", width));
    assert!(shell[0] < shell[1] && shell[1] < 0.1 && shell[2] > 0.7, "{shell:?}");
    // Fins of 0.8 to 3.2 mm, pins of 1.6 to 4.8 mm.
    let fins = [0.7, 0.9, 2.0, 3.3].map(|width| share("thin-fins.stl", width));
    assert!(fins[0] < 0.01 && fins[1] > 0.05 && fins.is_sorted() && fins[3] > 0.5, "{fins:?}");
}
