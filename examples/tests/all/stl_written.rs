//! STL files as they are written: read back byte by byte, they are closed, and every triangle has an area.

use curvlay_examples::mesh::Mesh;
use curvlay_examples::nalgebra::{Point3, Vector3};
use curvlay_examples::shapes;
use curvlay_layers::planar::{CutPlane, Partition, Solid};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// The corners of each triangle of a binary STL file.
fn corners(bytes: &[u8]) -> Vec<[[f32; 3]; 3]> {
    let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let corner = |k: usize, v: usize| [0, 1, 2].map(|axis| number(84 + 50 * k + 12 + 12 * v + 4 * axis));
    (0..count).map(|k| [0, 1, 2].map(|v| corner(k, v))).collect()
}

fn written(mesh: &Mesh) -> Vec<[[f32; 3]; 3]> {
    let mut bytes = Vec::new();
    mesh.write_stl(&mut bytes).unwrap();
    corners(&bytes)
}

/// Checks what every reader relies on. Returns the volume.
fn check(triangles: &[[[f32; 3]; 3]]) -> f64 {
    let mut sides: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    let mut volume = 0.0;
    for (k, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|p| Vector3::from(p.map(f64::from)));
        assert!((b - a).cross(&(c - a)).norm() > 0.0, "triangle {k} has no area: {triangle:?}");
        volume += a.dot(&b.cross(&c)) / 6.0;
        for i in 0..3 {
            let [from, to] = [triangle[i], triangle[(i + 1) % 3]].map(|p| p.map(f32::to_bits));
            *sides.entry([from, to]).or_default() += 1;
            *sides.entry([to, from]).or_default() -= 1;
        }
    }
    assert!(sides.values().all(|&count| count == 0), "the mesh is open");
    volume
}

/// A tent: three sides over a floor that has a fourth corner at `at`, which splits the floor in three.
fn tent(at: [f64; 3]) -> Mesh {
    let vertices = [[0.0; 3], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [1.0, 1.0, 5.0], at].map(Point3::from).to_vec();
    let triangles = vec![[0, 1, 3], [1, 2, 3], [2, 0, 3], [4, 1, 0], [4, 2, 1], [4, 0, 2]];
    Mesh { vertices, triangles }
}

#[test]
fn what_rounding_takes_the_area_of_goes_and_the_mesh_stays_closed() {
    // Inside the floor; a rounding beside a corner, which swallows it; the same beside an edge, which it then splits.
    for (at, count) in [([2.0, 2.0, 0.0], 6), ([1e-60, 1e-60, 0.0], 4), ([4.0, 1e-60, 0.0], 6), ([4.0, 1e-9, 0.0], 6)] {
        let triangles = written(&tent(at));
        assert_eq!(triangles.len(), count, "{at:?}");
        assert!((check(&triangles) - 8.0 * 8.0 * 5.0 / 6.0).abs() < 1e-5, "{at:?}");
    }
    // A sheet folded onto itself encloses nothing: nothing is written.
    let folded = Mesh { vertices: tent([0.0; 3]).vertices, triangles: vec![[0, 1, 2], [0, 2, 1]] };
    assert!(written(&folded).is_empty());
    // Of an open mesh all that has an area is written.
    let mut open = tent([4.0, 0.0, 0.0]);
    open.triangles.remove(0);
    assert_eq!(written(&open).len(), 4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// Parts of a bent bar far from the origin, cut by planes that pass close to each other and to corners: all that rounding can spoil.
    #[test]
    fn parts_of_a_solid_are_read_back_sound(
        shift in -2000.0..2000.0_f64,
        near in prop::collection::vec((0..400_usize, -1e-4..1e-4_f64, prop::array::uniform3(-1.0..1.0_f64)), 1..6),
    ) {
        let bend = shapes::bend();
        let moved: Vec<Point3<f64>> = bend.vertices.iter().map(|p| p + Vector3::new(shift, 0.5 * shift, 0.0)).collect();
        let solid = Solid::new(&moved, &bend.triangles).unwrap();
        let mut partition = Partition::new(&solid);
        for (vertex, off, normal) in near {
            let at = moved[vertex % moved.len()] + Vector3::repeat(off);
            let Ok(plane) = CutPlane::through(&at, &Vector3::from(normal)) else { continue };
            let cells = partition.cells();
            partition.cut(&cells, &plane);
        }
        for cell in partition.cells() {
            let part = partition.part(cell).unwrap();
            let mesh = Mesh { vertices: part.vertices().to_vec(), triangles: part.triangles().to_vec() };
            let volume = check(&written(&mesh));
            // A rounding in single precision over the whole surface.
            let rounding = part.area() * 4.0 * f64::from(f32::EPSILON) * shift.abs().max(200.0);
            prop_assert!((volume - part.volume()).abs() <= rounding, "{volume} {} {rounding}", part.volume());
        }
    }
}
