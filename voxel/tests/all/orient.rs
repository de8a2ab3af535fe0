//! Which way triangles look: mended where neighbours disagree, kept where a mesh is sound, refused where there is no
//! way.

#![expect(clippy::float_cmp, reason = "sums of small integers are exact")]

use crate::common::{Mesh, bumpy_ball, cuboid, shared};
use curvlay_voxel::inspect::{InspectError, Orientation, inspect};
use curvlay_voxel::nalgebra::{Point3, center};
use curvlay_voxel::{Doubt, OrientError, OrientReport, Resolution, VoxelError, orient};
use proptest::prelude::*;

fn oriented(mesh: &Mesh) -> (Mesh, OrientReport) {
    let found = orient(&mesh.vertices, &mesh.triangles).unwrap();
    (Mesh { triangles: found.triangles, ..mesh.clone() }, found.report)
}

/// The triangle from its least corner on.
fn cycle([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        least if least == a => [a, b, c],
        least if least == b => [b, c, a],
        _ => [c, a, b],
    }
}

fn cycles(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles.iter().map(|&triangle| cycle(triangle)).collect()
}

fn with_turned(mesh: &Mesh, turn: impl Fn(usize) -> bool) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.triangles.iter_mut().enumerate().filter(|(at, _)| turn(*at)).for_each(|(_, triangle)| triangle.swap(1, 2));
    mesh
}

/// Each triangle with vertices of its own, as in an STL file.
fn soup(mesh: &Mesh) -> Mesh {
    let vertices: Vec<_> = mesh.corners().flatten().collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh { vertices, triangles }
}

#[test]
fn any_facets_of_a_cuboid_may_be_turned() {
    let cube = cuboid([1.0, 2.0, 3.0], [5.0, 5.0, 5.0]);
    let cells = cube.with(Resolution::Cell(1.0)).unwrap();
    for turned in 0u32..1 << 12 {
        let broken = with_turned(&cube, |at| turned >> at & 1 == 1);
        let (mended, report) = oriented(&broken);
        assert_eq!(cycles(&mended), cycles(&cube), "{turned:b}");
        assert_eq!(report.turned_triangles, turned.count_ones() as usize);
        assert_eq!(report.disagreeing_edges == 0, turned == 0 || turned == (1 << 12) - 1);
        let solid = broken.with(Resolution::Cell(1.0)).unwrap();
        assert_eq!(solid.grid, cells.grid, "{turned:b}");
        assert_eq!((solid.report.open_edges, solid.report.cells_asked_singly), (0, 0));
        assert_eq!(solid.report.turned_triangles, report.turned_triangles);
        assert_eq!(solid.report.disagreeing_edges, report.disagreeing_edges);
    }
}

#[test]
fn a_third_of_the_facets_costs_nothing_and_changes_no_cell() {
    let ball = bumpy_ball(40, 10.0, 0.1);
    let broken = soup(&with_turned(&ball, |at| at % 3 == 0));
    for resolution in [Resolution::Cell(0.5), Resolution::Count(20_000)] {
        let (solid, sound) = (broken.with(resolution).unwrap(), soup(&ball).with(resolution).unwrap());
        assert_eq!(solid.grid, sound.grid);
        let work = |of: &curvlay_voxel::VoxelReport| (of.open_edges, of.pieces, of.cells_asked_singly, of.trials);
        assert_eq!(work(&solid.report), work(&sound.report));
        assert!(!solid.report.inside_out && solid.report.turned_triangles == ball.triangles.len().div_ceil(3));
    }
}

#[test]
fn sound_meshes_come_back_as_they_are() {
    let cube = |low: f64, high: f64| cuboid([low; 3], [high; 3]);
    let hollow = cube(0.0, 9.0).and(&cube(2.0, 7.0).turned());
    let sound = [
        cube(0.0, 2.0),
        hollow.clone(),
        hollow.and(&cube(3.0, 6.0)),
        cube(0.0, 6.0).and(&cube(3.0, 9.0)),
        cube(0.0, 1.0).and(&cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])),
        cube(0.0, 1.0).and(&cube(1.0, 2.0)),
        // Side by side, with the faces between them twice there.
        cube(0.0, 1.0).and(&cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])),
        cube(0.0, 9.0).and(&cube(1.0, 8.0)),
        bumpy_ball(20, 10.0, 0.2),
    ];
    for mesh in sound {
        let (mended, report) = oriented(&mesh);
        assert_eq!(mended.triangles, mesh.triangles);
        assert_eq!((report.turned_triangles, report.disagreeing_edges), (0, 0));
        assert_eq!(report.to_string(), "");
        let (mended, report) = oriented(&mesh.clone().turned());
        assert_eq!(cycles(&mended), cycles(&mesh), "inside out");
        assert!(report.inside_out && report.turned_triangles == mesh.triangles.len());
    }
}

#[test]
fn bodies_beside_each_other_are_judged_each_for_itself() {
    let beside = cuboid([0.0; 3], [2.0; 3]).and(&cuboid([5.0; 3], [8.0; 3]));
    let (mended, report) = oriented(&with_turned(&beside, |at| at >= 12));
    assert_eq!(cycles(&mended), cycles(&beside));
    assert_eq!(report.to_string(), "12 of 24 triangles looked inwards: they were turned");
    assert_eq!(inspect(&mended.vertices, &mended.triangles).unwrap().signed_volume_mm3, 8.0 + 27.0);
    // One that only reaches into the other is not within it, whichever way it looks.
    let across = cuboid([0.0; 3], [6.0; 3]).and(&cuboid([2.0, 2.0, 4.0], [3.0, 3.0, 8.0]));
    assert_eq!(cycles(&oriented(&with_turned(&across, |at| at >= 12)).0), cycles(&across));
}

#[test]
fn a_cavity_stays_one_whatever_is_turned_around_it() {
    let hollow = cuboid([0.0; 3], [9.0; 3]).and(&cuboid([2.0; 3], [7.0; 3]).turned());
    let cases: [&dyn Fn(usize) -> bool; 4] = [
        &|at| at < 8,      // most of the outer skin
        &|at| at % 12 < 5, // some of both
        &|at| at >= 19,    // less than half of the inner one
        &|at| at < 4 || at == 12,
    ];
    for (number, case) in cases.into_iter().enumerate() {
        let (mended, _) = oriented(&with_turned(&hollow, case));
        assert_eq!(cycles(&mended), cycles(&hollow), "case {number}");
    }
    // An outer skin that agrees with itself takes along what is within it. Both skins look inwards here, so that by
    // winding numbers all that the outer one holds is solid, and it stays so.
    let (mended, report) = oriented(&with_turned(&hollow, |at| at < 12));
    assert_eq!(cycles(&mended), cycles(&cuboid([0.0; 3], [9.0; 3]).and(&cuboid([2.0; 3], [7.0; 3]))));
    assert!(report.inside_out);
}

#[test]
fn holes_do_not_hide_which_side_is_outside() {
    let mut open = cuboid([0.0; 3], [20.0, 20.0, 40.0]);
    open.triangles.truncate(10);
    for turned in 0u32..1 << 10 {
        let (mended, _) = oriented(&with_turned(&open, |at| turned >> at & 1 == 1));
        assert_eq!(cycles(&mended), cycles(&open), "{turned:b}");
    }
}

/// A band of triangles with a half turn.
fn moebius() -> Mesh {
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
    Mesh { vertices, triangles: triangles.collect() }
}

#[test]
fn what_has_one_side_is_refused_with_its_place() {
    let strip = cuboid([10.0; 3], [12.0; 3]).and(&moebius());
    let Err(OrientError::OneSided(refused)) = orient(&strip.vertices, &strip.triangles) else {
        panic!("a Moebius strip was oriented");
    };
    let [a, b] = refused.triangles.map(|at| strip.triangles[at as usize]);
    assert!(refused.triangles.iter().all(|&at| at >= 12));
    let shared: Vec<u32> = a.into_iter().filter(|corner| b.contains(corner)).collect();
    let [from, to] = [0, 1].map(|k| strip.vertices[shared[k] as usize]);
    assert_eq!(Point3::from(refused.at), center(&from, &to));
    assert!(refused.to_string().contains("one side alone"), "{refused}");
    assert_eq!(strip.with(Resolution::Cell(0.5)), Err(VoxelError::OneSided(refused)));
    assert_eq!(inspect(&strip.vertices, &strip.triangles).unwrap().orientation, Orientation::Mixed);
}

#[test]
fn unusable_meshes_are_refused() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]].map(Point3::from);
    assert_eq!(orient(&corners, &[]), Err(OrientError::Mesh(InspectError::NoTriangles)));
    assert!(matches!(orient(&corners, &[[0, 1, 2]]), Err(OrientError::Mesh(InspectError::Coordinate { .. }))));
    assert!(matches!(orient(&corners, &[[0, 1, 3]]), Err(OrientError::Mesh(InspectError::NoSuchVertex { .. }))));
    // Triangles of one point, or of one place, have nothing to turn.
    let (mended, report) = oriented(&Mesh { vertices: corners[..2].to_vec(), triangles: vec![[0, 0, 0], [1, 1, 0]] });
    assert_eq!((mended.triangles, report.turned_triangles), (vec![[0, 0, 0], [1, 1, 0]], 0));
}

/// The distinct triangles at each edge of two, and whether each runs along it forwards: by looking at all pairs.
fn slow_edges(triangles: &[[u32; 3]]) -> Vec<[(usize, bool); 2]> {
    let mut distinct: Vec<usize> = Vec::new();
    for (at, &triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle;
        let repeats = distinct.iter().any(|&other| cycle(triangles[other]) == cycle(triangle));
        if a != b && b != c && c != a && !repeats {
            distinct.push(at);
        }
    }
    let mut edges = Vec::new();
    for low in 0..7 {
        for high in low + 1..7 {
            let runs = |at: usize, from: u32, to: u32| {
                let [a, b, c] = triangles[at];
                [[a, b], [b, c], [c, a]].contains(&[from, to])
            };
            let uses: Vec<(usize, bool)> = distinct
                .iter()
                .filter(|&&at| runs(at, low, high) || runs(at, high, low))
                .map(|&at| (at, runs(at, low, high)))
                .collect();
            edges.extend(<[(usize, bool); 2]>::try_from(uses));
        }
    }
    edges
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Heaps of triangles against a trial of all ways to turn them.
    #[test]
    fn agrees_with_trying_all_ways(triangles in prop::collection::vec(prop::array::uniform3(0u32..7), 1..11)) {
        // Points on the curve (t, t^2, t^3): no three on a line.
        let vertices: Vec<_> = (0..7).map(|t| Point3::from([1, 2, 3].map(|power| f64::from(t).powi(power)))).collect();
        let edges = slow_edges(&triangles);
        let agrees = |turned: u32| {
            edges.iter().all(|[a, b]| {
                let forward = |&(at, forward): &(usize, bool)| forward != (turned >> at & 1 == 1);
                forward(a) != forward(b)
            })
        };
        let possible = (0u32..1 << triangles.len()).any(agrees);
        match orient(&vertices, &triangles) {
            Ok(found) => {
                prop_assert!(possible);
                let mut turned = 0;
                for (at, (now, before)) in found.triangles.iter().zip(&triangles).enumerate() {
                    let [a, b, c] = *before;
                    prop_assert!(now == before || *now == [a, c, b]);
                    turned |= u32::from(now != before) << at;
                }
                prop_assert!(agrees(turned));
                prop_assert_eq!(found.report.turned_triangles, turned.count_ones() as usize);
                let disagreed = edges.iter().filter(|[a, b]| a.1 == b.1).count();
                prop_assert_eq!(found.report.disagreeing_edges, disagreed);
            }
            Err(OrientError::OneSided(_)) => prop_assert!(!possible),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }

    /// Skins within each other, each turned as a whole or not: the solid, where the winding number is not zero, stays,
    /// and no winding number is below zero.
    #[test]
    fn nested_skins_keep_their_solid(turned in prop::collection::vec(any::<bool>(), 1..7)) {
        let skin = |(k, &turned): (usize, &bool)| {
            let skin = cuboid([k as f64; 3], [20.0 - k as f64; 3]);
            if turned { skin.turned() } else { skin }
        };
        let nest = turned.iter().enumerate().map(skin).fold(Mesh::default(), |all, skin| all.and(&skin));
        let (mended, _) = oriented(&nest);
        let (mut before, mut after) = (0i32, 0i32);
        for (k, &turned) in turned.iter().enumerate() {
            before += if turned { -1 } else { 1 };
            let is_turned = cycles(&mended)[12 * k] != cycles(&nest)[12 * k];
            after += if turned != is_turned { -1 } else { 1 };
            prop_assert_eq!(after, before.abs());
        }
    }

    /// Facets of bodies beside each other turned at random, the order shuffled: all comes back.
    #[test]
    fn turned_facets_come_back(
        turned in prop::collection::vec(any::<bool>(), 12 + 12 + 2 * 6 * 5), from in 0usize..84, own in any::<bool>()
    ) {
        let mut all = cuboid([0.0; 3], [3.0; 3]).and(&cuboid([5.0; 3], [6.0; 3]));
        all = all.and(&bumpy_ball(6, 2.0, 0.1).moved([-9.0, 0.0, 0.0]));
        all.triangles.rotate_left(from);
        let all = if own { soup(&all) } else { all };
        let (mended, report) = oriented(&with_turned(&all, |at| turned[at]));
        prop_assert_eq!(cycles(&mended), cycles(&all));
        prop_assert_eq!(report.turned_triangles, turned.iter().filter(|&&turned| turned).count());
    }
}

/// Sound models come back untouched, and a third of the facets turned changes no cell.
#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where that folder exists"]
fn the_models_are_sound_and_can_be_mended() {
    for name in ["armadillo-hollow", "branches-16", "kitten", "mech-part", "thin-fins", "woman-pully-hollow"] {
        let mesh = shared(&format!("models/{name}.stl"));
        let (mended, report) = oriented(&mesh);
        assert_eq!((mended.triangles, report.turned_triangles), (mesh.triangles.clone(), 0), "{name}");
        let broken = with_turned(&mesh, |at| at * 7 % 3 == 0);
        let (solid, sound) =
            (broken.with(Resolution::Count(20_000)).unwrap(), mesh.with(Resolution::Count(20_000)).unwrap());
        assert_eq!(solid.grid, sound.grid, "{name}");
        assert_eq!(solid.report.cells_asked_singly, 0);
    }
}

/// The volume of a ball of `bumpy_ball`, as its triangles have it.
fn volume(mesh: &Mesh) -> f64 {
    mesh.corners().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0).sum()
}

/// A hollow ball of 30 mm around one of 24 mm, each with its mesh.
fn hollow_ball() -> (Mesh, Mesh) {
    (bumpy_ball(24, 30.0, 0.0), bumpy_ball(24, 24.0, 0.0).turned())
}

/// One triangle that is missing, in either skin: the cavity stays, and its volume is that of the skins.
#[test]
fn a_hole_of_one_triangle_does_not_fill_a_cavity() {
    let (outer, inner) = hollow_ball();
    let whole = volume(&outer) + volume(&inner);
    for missing in [0, 700, outer.triangles.len() + 300] {
        for inside_out in [false, true] {
            let mut hollow = outer.clone().and(&inner);
            hollow.triangles.remove(missing);
            let given = if inside_out { hollow.clone().turned() } else { hollow.clone() };
            let (mended, report) = oriented(&given);
            assert_eq!(cycles(&mended), cycles(&hollow));
            assert!((report.volume_mm3 / whole - 1.0).abs() < 1e-3, "{report:?}, {whole}");
            assert_eq!((report.holes, report.shells, report.sheets), (1, 0, 0));
            assert!(report.holes_mm3 < 1e-3 * whole && report.doubts(1e-3).is_empty(), "{report:?}");
        }
    }
}

/// A cavity behind a wide mouth: closed across its rim it is one, by the surface alone it is not.
#[test]
fn a_wide_hole_leaves_two_volumes() {
    let (outer, _) = hollow_ball();
    let mut bowl = outer.clone();
    bowl.triangles
        .retain(|t| t.iter().map(|&corner| outer.vertices[corner as usize].z).fold(f64::MIN, f64::max) < 12.0);
    let inner = cuboid([-3.0, -3.0, 2.0], [3.0, 3.0, 8.0]).turned();
    let (_, report) = oriented(&bowl.and(&inner));
    let doubts = report.doubts(1e-3);
    assert!(doubts.iter().any(|doubt| matches!(doubt, Doubt::Holes { holes: 1, .. })), "{doubts:?}");
    // Between the two mouths of a short tube the caps fill more than half of all directions.
    let inner = cuboid([-0.5, -0.5, 1.5], [0.5, 0.5, 2.5]).turned();
    let (_, report) = oriented(&tube(4.0).and(&inner));
    assert_eq!((report.volume_mm3 - report.other_volume_mm3).abs().round(), 2.0, "{report:?}");
    assert!(report.doubts(1e-3).iter().any(|doubt| matches!(doubt, Doubt::Nesting { .. })), "{report:?}");
}

/// A tube of 5 mm round the z axis, open at both ends.
fn tube(height: f64) -> Mesh {
    let side = |k: u32, z: f64| {
        let angle = f64::from(k) / 24.0 * std::f64::consts::TAU;
        Point3::new(5.0 * angle.cos(), 5.0 * angle.sin(), z)
    };
    let wall = |k: u32| {
        let [a, b, c, d] = [2 * k, 2 * k + 1, (2 * k + 2) % 48, (2 * k + 3) % 48];
        [[a, c, d], [a, d, b]]
    };
    let vertices: Vec<_> = (0..24).flat_map(|k| [side(k, 0.0), side(k, height)]).collect();
    Mesh { vertices, triangles: (0..24).flat_map(wall).collect() }
}

/// An inner shell that faces outward is solid, and the report names what it would be as a cavity.
#[test]
fn inner_shells_that_face_outward_are_doubted() {
    let same = cuboid([0.0; 3], [20.0; 3]).and(&cuboid([6.0; 3], [14.0; 3]));
    let (mended, report) = oriented(&same);
    assert_eq!(cycles(&mended), cycles(&same));
    assert_eq!((report.volume_mm3.round(), report.shells, report.shells_mm3.round()), (8000.0, 1, 512.0));
    let doubts = report.doubts(1e-3);
    assert!(matches!(doubts[..], [Doubt::Shells { shells: 1, .. }]));
    assert!(doubts[0].to_string().contains("8000.0 mm3, with cavities 7488.0 mm3"), "{}", doubts[0]);
    let (_, proper) = oriented(&cuboid([0.0; 3], [20.0; 3]).and(&cuboid([6.0; 3], [14.0; 3]).turned()));
    assert_eq!((proper.volume_mm3.round(), proper.shells), (7488.0, 0));
    assert!(proper.doubts(1e-3).is_empty());
    // A body in a cavity, and one that only reaches into another, are no such shells.
    let nested = cuboid([0.0; 3], [20.0; 3]).and(&cuboid([6.0; 3], [14.0; 3]).turned());
    let (_, nested) = oriented(&nested.and(&cuboid([8.0; 3], [12.0; 3])));
    assert_eq!((nested.volume_mm3.round(), nested.shells), (7552.0, 0));
    let (_, across) = oriented(&cuboid([0.0; 3], [6.0; 3]).and(&cuboid([2.0, 2.0, 4.0], [3.0, 3.0, 8.0])));
    assert_eq!(across.shells, 0);
}

/// A tube without caps, a sheet on a box, a bare sheet: none becomes a solid without a word.
#[test]
fn surfaces_without_thickness_are_doubted() {
    let (_, report) = oriented(&tube(100.0));
    assert!(matches!(report.doubts(1e-3)[..], [Doubt::Holes { holes: 2, .. }]), "{report:?}");

    let sheet = Mesh {
        vertices: [[1.0, 1.0, 8.0], [7.0, 1.0, 8.0], [7.0, 1.0, 14.0], [1.0, 1.0, 14.0]].map(Point3::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let (_, report) = oriented(&cuboid([0.0; 3], [8.0; 3]).and(&sheet));
    assert_eq!((report.volume_mm3.round(), report.sheets, report.sheets_mm2.round()), (512.0, 1, 36.0));
    assert!(matches!(report.doubts(1e-3)[..], [Doubt::Sheets { sheets: 1, .. }]), "{report:?}");
    let (_, report) = oriented(&sheet);
    assert_eq!((report.volume_mm3, report.sheets), (0.0, 1));
}

/// A face whose triangles meet those beside them without sharing their corners closes a box all the same.
#[test]
fn seams_are_no_holes() {
    let mut split = cuboid([0.0; 3], [8.0; 3]);
    // The top is the last quadrilateral: four triangles around its middle edge points instead of two.
    split.triangles.truncate(10);
    let first = split.vertices.len() as u32;
    let top = [[0.0, 0.0], [4.0, 0.0], [8.0, 0.0], [8.0, 8.0], [4.0, 8.0], [0.0, 8.0]];
    split.vertices.extend(top.map(|[x, y]| Point3::new(x, y, 8.0)));
    split.triangles.extend([[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]].map(|t: [u32; 3]| t.map(|k| k + first)));
    let (mended, report) = oriented(&split);
    assert_eq!(cycles(&mended), cycles(&split));
    assert_eq!((report.holes, report.sheets, report.volume_mm3.round()), (0, 0, 512.0), "{report:?}");
    assert!(report.doubts(1e-3).is_empty());
}

/// The mouths of a tube are measured in its own unit, and so are sheets and volumes.
#[test]
fn figures_are_those_of_the_mesh_at_any_size() {
    for scale in [0.01, 1.0, 7.0, 3e4] {
        let scaled = |mesh: Mesh| Mesh { vertices: mesh.vertices.iter().map(|at| at * scale).collect(), ..mesh };
        let close = |found: f64, expected: f64| (found - expected).abs() < 1e-9 * expected;
        let (_, report) = oriented(&scaled(tube(40.0)));
        let polygon = 12.0 * (5.0 * scale).powi(2) * (std::f64::consts::TAU / 24.0).sin();
        assert_eq!(report.holes, 2);
        assert!(close(report.holes_mm2, 2.0 * polygon), "{report:?}");
        assert!(close(report.volume_mm3, polygon * 40.0 * scale), "{report:?}");
        // Half a ball over each mouth, which is nearly a circle.
        let balls = 4.0 / 3.0 * std::f64::consts::PI * (5.0 * scale).powi(3);
        assert!((report.holes_mm3 / balls - 1.0).abs() < 0.03, "{report:?} {balls}");

        let sheet = Mesh {
            vertices: [[0.0, 0.0, 3.0], [7.0, 0.0, 3.0], [7.0, 2.0, 3.0], [0.0, 2.0, 3.0]].map(Point3::from).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let (_, report) = oriented(&scaled(sheet));
        assert_eq!((report.sheets, report.holes), (1, 0));
        assert!(close(report.sheets_mm2, 14.0 * scale * scale), "{report:?}");

        let shell = scaled(cuboid([0.0; 3], [20.0; 3]).and(&cuboid([6.0; 3], [14.0; 3])));
        let (_, report) = oriented(&shell);
        assert!(close(report.volume_mm3, 8000.0 * scale.powi(3)) && close(report.shells_mm3, 512.0 * scale.powi(3)));
    }
}

/// All vertices at one place: nothing is turned, and no figure is undefined.
#[test]
fn a_mesh_in_one_point_has_no_figures() {
    let point = Mesh { vertices: vec![Point3::new(3.0, -2.0, 5.0); 6], triangles: vec![[0, 1, 2], [3, 4, 5]] };
    let (found, of) = oriented(&point);
    assert_eq!(found.triangles, point.triangles);
    let figures = [of.volume_mm3, of.other_volume_mm3, of.shells_mm3, of.holes_mm2, of.holes_mm3, of.sheets_mm2];
    assert_eq!(figures, [0.0; 6], "{of:?}");
}
