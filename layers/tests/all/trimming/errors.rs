//! Every error, and what is none.

use super::helpers::*;
use curvlay_layers::nalgebra::Point3;
use curvlay_layers::trim::{Input, TrimError, TrimmedSheet, Trimmer};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn bad_input_is_reported() {
    let cube = cuboid([0.0; 3], [4.0; 3]);
    let new = |mesh: &Mesh| Trimmer::new(&mesh.vertices, &mesh.triangles).map(|_| ());
    assert_eq!(new(&Mesh::default()), Err(TrimError::EmptyMesh));
    let flat = Mesh { vertices: vec![P::origin(); 3], triangles: vec![[0, 1, 2]] };
    assert_eq!(new(&flat), Err(TrimError::EmptyMesh));
    let mut bad = cube.clone();
    bad.triangles[5][1] = 8;
    assert_eq!(new(&bad), Err(TrimError::BadCorner { input: Input::Mesh, triangle: 5, vertex: 8, vertices: 8 }));
    for value in [f64::NAN, f64::INFINITY, -2e9] {
        let mut bad = cube.clone();
        bad.vertices[3].y = value;
        assert_eq!(new(&bad), Err(TrimError::BadCoordinate { input: Input::Mesh, vertex: 3 }));
    }

    let trimmer = cube.trimmer();
    let sheet = field(6.0, 2, |_, _| 1.0);
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut sheet = sheet.clone();
        change(&mut sheet);
        trimmer.trim(&sheet.vertices, &sheet.triangles, &go)
    };
    assert_eq!(
        with(&|sheet| sheet.triangles[2][0] = 9),
        Err(TrimError::BadCorner { input: Input::Sheet, triangle: 2, vertex: 9, vertices: 9 })
    );
    assert_eq!(
        with(&|sheet| sheet.vertices[7].z = f64::NAN),
        Err(TrimError::BadCoordinate { input: Input::Sheet, vertex: 7 })
    );
    let twice = with(&|sheet| sheet.triangles[4][0] = sheet.triangles[4][2]);
    assert_eq!(twice, Err(TrimError::RepeatedCorner { triangle: 4 }));
    let double = with(&|sheet| sheet.triangles.push(sheet.triangles[0]));
    assert!(matches!(double, Err(TrimError::NotManifold { triangle: 8, .. })), "{double:?}");
    let turned = with(&|sheet| sheet.triangles[3].swap(0, 1));
    assert!(matches!(turned, Err(TrimError::NotManifold { .. })), "{turned:?}");
    let message = double.unwrap_err().to_string();
    assert!(message.starts_with("triangle 8 of the sheet runs along edge"), "{message}");
}

#[test]
fn a_sheet_of_nothing_is_trimmed_to_nothing() {
    assert_eq!(cuboid([0.0; 3], [4.0; 3]).trimmer().trim(&[], &[], &go), Ok(TrimmedSheet::default()));
}

#[test]
fn a_trimmer_is_shared_by_threads() {
    let mesh = torus(20.0, 6.0, [60, 30]);
    let trimmer = mesh.trimmer();
    let sheets: Vec<_> = (0..4).map(|k| field(30.0, 40, |x, _| f64::from(k) + 0.1 * x)).collect();
    let one = |sheet: &Mesh| trimmer.trim(&sheet.vertices, &sheet.triangles, &go).unwrap();
    let alone: Vec<_> = sheets.iter().map(one).collect();
    let together: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = sheets.iter().map(|sheet| scope.spawn(move || one(sheet))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(alone, together);
}

#[test]
fn flat_triangles_of_the_sheet_are_no_error() {
    let mesh = ball([0.0; 3], 5.0, 2);
    // Vertex 3 lies on edge 0-1, and triangle 0, 3, 1 fills the seam; the last triangle is a point.
    let at = [[-9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [1.0, 0.0, 0.0], [0.0, -9.0, 0.0]];
    let mut vertices: Vec<_> = at.map(P::from).into();
    vertices.extend([P::new(0.5, 0.5, 0.1); 3]);
    let triangles = [[0, 1, 2], [0, 3, 1], [0, 4, 3], [3, 4, 1], [5, 6, 7]];
    let trimmed = mesh.trimmer().trim(&vertices, &triangles, &go).unwrap();
    let whole = mesh.trimmer().trim(&vertices, &[[0, 1, 2], [0, 4, 1]], &go).unwrap();
    assert!((trimmed.area() - whole.area()).abs() < 1e-9);
    assert!((trimmed.mesh_mm - whole.mesh_mm).abs() < 1e-5, "{} {}", trimmed.mesh_mm, whole.mesh_mm);
}

#[test]
fn trimming_can_be_cancelled() {
    let mesh = cuboid([0.0; 3], [4.0; 3]);
    // Holed as well, where each vertex takes its time.
    let holed = Mesh { triangles: mesh.triangles[1..].to_vec(), ..mesh.clone() };
    let n = 30;
    let at = |i: u32, j: u32| Point3::new(f64::from(i) * 0.2 - 1.0, f64::from(j) * 0.2 - 1.0, 2.1);
    let vertices: Vec<P> = (0..n * n).map(|k| at(k % n, k / n)).collect();
    let squares = (0..n * n).filter(|k| k % n + 1 < n && k / n + 1 < n);
    let triangles: Vec<[u32; 3]> = squares.flat_map(|k| [[k, k + 1, k + n], [k + 1, k + n + 1, k + n]]).collect();
    for (mesh, holed) in [(&mesh, false), (&holed, true)] {
        let trimmer = mesh.trimmer();
        assert_eq!(trimmer.is_holed(), holed);
        let calls = AtomicUsize::new(0);
        let count = |_| {
            calls.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        trimmer.trim(&vertices, &triangles, &count).unwrap();
        let all = calls.into_inner();
        assert!(all >= if holed { 5 } else { 3 }, "{all}");
        for asked in 0..all {
            let calls = AtomicUsize::new(0);
            let stop = |_| match calls.fetch_add(1, Ordering::Relaxed) == asked {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            assert_eq!(trimmer.trim(&vertices, &triangles, &stop).unwrap_err(), TrimError::Cancelled);
        }
    }
}
