//! Cuts: parts are closed manifolds, their volumes add up, and their Euler numbers are those of the section.

use super::shapes::{assert_manifold, blocks, cells, cube, euler, plane, sound_blocks, torus, turned};
use curvlay_layers::nalgebra::{Point3, Vector3};
use curvlay_layers::planar::{Cut, CutPlane, Partition, PlaneFrame, Solid, slice};
use proptest::prelude::*;

/// Cuts a solid, and checks what holds for any cut. Returns volumes above and below.
fn cut(solid: &Solid, plane: &CutPlane) -> [Vec<f64>; 2] {
    let mut partition = Partition::new(solid);
    let Cut { above, below } = partition.cut(&[0], plane);
    let check = |cells: &[u32]| -> Vec<f64> {
        cells
            .iter()
            .map(|&cell| {
                let part = partition.part(cell).unwrap();
                assert_manifold(&part);
                let volume = part.volume();
                assert!((volume - partition.volume(cell)).abs() <= 1e-12 * solid.volume());
                volume
            })
            .collect()
    };
    let volumes = [check(&above), check(&below)];
    let sum: f64 = volumes.iter().flatten().sum();
    assert!((sum - solid.volume()).abs() <= 1e-12 * solid.volume(), "{volumes:?}");
    // Nothing above that should be below, but for rounding.
    let size = {
        let [low, high] = solid.bounds();
        (high - low).norm()
    };
    for &cell in &above {
        assert!(partition.part(cell).unwrap().vertices().iter().all(|p| plane.height(p) > -1e-12 * size));
    }
    for &cell in &below {
        assert!(partition.part(cell).unwrap().vertices().iter().all(|p| plane.height(p) < 1e-12 * size));
    }
    volumes
}

#[test]
fn a_cube_is_halved_wherever_the_plane_runs() {
    let cube = cube();
    for normal in [[0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 2.0, -3.0]] {
        let [above, below] = cut(&cube, &plane([0.5; 3], normal));
        assert!(above.len() == 1 && below.len() == 1 && (above[0] - 0.5).abs() < 1e-14, "{normal:?}: {above:?}");
    }
    // In a face: no part without thickness.
    for (point, normal, parts) in
        [([0.0; 3], [0.0, 0.0, 1.0], [1, 0]), ([1.0; 3], [0.0, 0.0, 1.0], [0, 1]), ([1.0; 3], [-1.0, 0.0, 0.0], [1, 0])]
    {
        let volumes = cut(&cube, &plane(point, normal));
        assert_eq!(volumes.map(|side| side.len()), parts, "{point:?} {normal:?}");
    }
    // Through a corner only.
    assert_eq!(cut(&cube, &plane([1.0; 3], [1.0, 1.0, 1.0])).map(|side| side.len()), [0, 1]);
    assert_eq!(cut(&cube, &plane([0.0; 3], [1.0, 1.0, 1.0])).map(|side| side.len()), [1, 0]);
    // Off it.
    assert_eq!(cut(&cube, &plane([0.0, 0.0, -3.0], [0.0, 0.0, 1.0])).map(|side| side.len()), [1, 0]);
}

#[test]
fn a_wall_in_the_plane_stays_with_its_solid() {
    // A T: stem of a cell, bar of five.
    let mut all = cells([2, 0, 0], [3, 1, 4]);
    all.extend(cells([0, 0, 4], [5, 1, 5]));
    let tee = blocks(&all, 1.0);
    let mut partition = Partition::new(&tee);
    // Along the right side of the stem.
    let Cut { above, below } = partition.cut(&[0], &plane([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    assert_eq!((above.len(), below.len()), (1, 1));
    let arm = partition.part(above[0]).unwrap();
    assert_eq!(arm.bounds(), [Point3::new(3.0, 0.0, 4.0), Point3::new(5.0, 1.0, 5.0)]);
    assert!((arm.area() - 10.0).abs() < 1e-14 && (partition.shared_area(above[0], below[0]) - 1.0).abs() < 1e-14);
    // No triangle without area is left, in either part.
    for cell in [above[0], below[0]] {
        let part = partition.part(cell).unwrap();
        let least = (0..part.triangles().len())
            .map(|t| {
                let [a, b, c] = part.corners(t);
                (b - a).cross(&(c - a)).norm()
            })
            .fold(1.0, f64::min);
        assert!(least > 0.1, "{least}");
    }
}

#[test]
fn a_comb_falls_into_its_teeth() {
    let mut all = cells([0, 0, 0], [9, 2, 1]);
    for x in [0, 2, 4, 6, 8] {
        all.extend(cells([x, 0, 1], [x + 1, 2, 3]));
    }
    let comb = blocks(&all, 1.5);
    for z in [1.0, 1.5, 2.0] {
        let [above, below] = cut(&comb, &plane([0.0, 0.0, 1.5 * z], [0.0, 0.0, 1.0]));
        assert_eq!((above.len(), below.len()), (5, 1), "{z}");
        assert!(above.iter().all(|volume| (volume - (3.0 - z) * 2.0 * 1.5_f64.powi(3)).abs() < 1e-12));
    }
}

#[test]
fn a_void_stays_in_its_part() {
    let mut all = cells([0, 0, 0], [5, 3, 3]);
    all.retain(|&cell| cell != [1, 1, 1]);
    let hollow = blocks(&all, 1.0);
    let [above, below] = cut(&hollow, &plane([3.5, 0.0, 0.0], [1.0, 0.0, 0.0]));
    assert_eq!((above.len(), below.len()), (1, 1));
    assert!((below[0] - (3.5 * 9.0 - 1.0)).abs() < 1e-12);
    // Through the void, and along its wall.
    assert!((cut(&hollow, &plane([1.5, 0.0, 0.0], [1.0, 0.0, 0.0]))[0][0] - (3.5 * 9.0 - 0.5)).abs() < 1e-12);
    assert!((cut(&hollow, &plane([2.0, 0.0, 0.0], [1.0, 0.0, 0.0]))[0][0] - 27.0).abs() < 1e-12);
}

#[test]
fn wedges_merge_back_without_gaps() {
    // A bar; what is right of x = 2 and above a slope is taken off, the rest is one part again.
    let bar = blocks(&cells([0, 0, 0], [6, 2, 4]), 1.0);
    let mut partition = Partition::new(&bar);
    let wall = partition.cut(&[0], &plane([2.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    let slope = partition.cut(&wall.above, &plane([2.0, 0.0, 3.0], [0.5, 0.0, 1.0]));
    let rest = wall.below[0];
    partition.merge(rest, slope.below[0]);
    let (rest, wedge) = (partition.part(rest).unwrap(), partition.part(slope.above[0]).unwrap());
    for part in [&rest, &wedge] {
        assert_manifold(part);
        assert_eq!(euler(part), 2);
    }
    // 4 by 2 above x = 2, from the height 1 to 3 at the wall, 3 at the far end.
    assert!((wedge.volume() - 2.0 * (1.0 + 3.0) / 2.0 * 4.0).abs() < 1e-12);
    assert!((rest.volume() + wedge.volume() - 48.0).abs() < 1e-12);
    assert_eq!(partition.cells().len(), 2);
    // Cutting it once more where it was merged does not find the old wall.
    let again = partition.cut(&[wall.below[0]], &plane([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
    assert_eq!((again.above.len(), again.below.len()), (1, 1));
    for cell in partition.cells() {
        assert_manifold(&partition.part(cell).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn parts_of_a_torus_are_closed(at in prop::array::uniform3(-9.0..9.0_f64), n in prop::array::uniform3(-1.0..1.0_f64)) {
        prop_assume!(Vector3::from(n).norm() > 0.1);
        let solid = torus(8.0, 4.0, [12, 8]);
        let plane = plane(at, n);
        cut(&solid, &plane);
        // Closed surfaces that are cut and closed: two caps are new.
        let mut partition = Partition::new(&solid);
        let pieces = partition.cut(&[0], &plane);
        let sum: i64 = pieces.above.iter().chain(&pieces.below).map(|&cell| euler(&partition.part(cell).unwrap())).sum();
        let caps: i64 = slice(&solid, &plane, &PlaneFrame::of(&plane)).iter().map(|piece| 1 - piece.holes.len() as i64).sum();
        prop_assert_eq!(sum, 2 * caps);
    }

    /// Planes through three vertices, or two, or one.
    #[test]
    fn cuts_through_vertices_are_closed(picked in prop::array::uniform3(0..96_usize), free in prop::array::uniform3(-1.0..1.0_f64), kind in 1..4) {
        let solid = torus(8.0, 4.0, [12, 8]);
        let [a, b, c] = picked.map(|v| solid.vertices()[v]);
        let free = Vector3::from(free);
        let normal = match kind { 3 => (b - a).cross(&(c - a)), 2 => (b - a).cross(&free), _ => free };
        prop_assume!(normal.norm() > 1e-3);
        cut(&solid, &CutPlane::through(&a, &normal).unwrap());
    }

    /// Blocks cut at whole and half numbers: the cells are counted.
    #[test]
    fn blocks_fall_into_blocks(
        picked in prop::collection::vec(prop::array::uniform3(0..3_i32), 1..16), axis in 0..3_usize, at in -1..8_i32, up: bool,
    ) {
        let all = sound_blocks(&picked);
        let solid = blocks(&all, 1.0);
        let (mut normal, mut point) = ([0.0; 3], [0.0; 3]);
        (normal[axis], point[axis]) = (if up { 1.0 } else { -1.0 }, f64::from(at) / 2.0);
        let [above, below] = cut(&solid, &plane(point, normal));
        let over = |cell: &[i32; 3]| (f64::from(cell[axis] + 1) - point[axis]).clamp(0.0, 1.0);
        let counted: f64 = all.iter().map(|cell| if up { over(cell) } else { 1.0 - over(cell) }).sum();
        prop_assert!((above.iter().sum::<f64>() - counted).abs() < 1e-12);
        prop_assert!(above.iter().chain(&below).all(|&volume| volume > 0.4));
    }

    /// Several cuts in a row, of all cells at once: nothing is lost.
    #[test]
    fn many_cuts_lose_nothing(cuts in prop::collection::vec((prop::array::uniform3(-5.0..5.0_f64), prop::array::uniform3(-1.0..1.0_f64)), 1..7)) {
        let solid = turned(&[[0.0, -6.0], [4.0, -6.0], [2.0, 0.0], [7.0, 3.0], [0.0, 6.0]], 9);
        let mut partition = Partition::new(&solid);
        for (at, n) in cuts {
            prop_assume!(Vector3::from(n).norm() > 0.1);
            let all = partition.cells();
            partition.cut(&all, &plane(at, n));
        }
        let mut sum = 0.0;
        for cell in partition.cells() {
            let part = partition.part(cell).unwrap();
            assert_manifold(&part);
            sum += part.volume();
        }
        prop_assert!((sum - solid.volume()).abs() < 1e-12 * solid.volume());
    }
}
